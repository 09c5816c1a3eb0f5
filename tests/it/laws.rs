//! Friction laws of the joint on a system with an exact solution: a mass on a moving belt.

use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, Integrator, MethodName};
use squeakscope::joint::{ContactDamping, Friction, FrictionLaw, Joint, Model, Ratio, Stribeck};

/// The exact limit cycle for unit mass, stiffness and normal load on a belt at 0.2. The coefficient of
/// friction drops from 1 to 0.5 when the mass breaks loose: slip for 2 (pi - atan(0.5/0.2)), stick for 5.
const PERIOD: f64 = 8.902_605_4;
const AMPLITUDE: f64 = 0.538_516_5;
const STUCK: f64 = 5.0;

fn belt(friction: Friction) -> Model {
    Model {
        positions: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1.0],
        stiffness: vec![1.0],
        shapes: vec![[1.0, 0.0, 0.0]],
        omega: vec![1.0],
        damping: vec![],
        sliding_velocity: vec![[-0.2, 0.0, 0.0]],
        friction,
        unilateral: true,
        contact_damping: ContactDamping::None,
        convection: None,
        probe: vec![1.0],
    }
}

struct Cycle {
    period: f64,
    amplitude: f64,
    stuck: f64,
}

/// The settled stick-slip cycle, started with the mass sticking.
fn cycle(joint: &Joint) -> Cycle {
    // The errors must be small compared with the creep speed, not only with the motion.
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-9), 0.01);
    let mut integrator = Integrator::new(method, joint).unwrap();
    integrator.start(0.0, &[0.0, 0.2]).unwrap();
    let dt = 1e-3;
    let mut z = [0.0; 2];
    let (mut low, mut high, mut stuck) = (f64::MAX, f64::MIN, 0.0);
    let mut crossings = Vec::new();
    let mut before = 0.0;
    for k in 1..=30_000 {
        let t = f64::from(k) * dt;
        integrator.sample(t, &mut z).unwrap();
        // A stick phase removes the dependence on the initial state: the cycle after the first crossing
        // is periodic.
        if before < 0.0 && z[0] >= 0.0 {
            crossings.push(t - dt * z[0] / (z[0] - before));
        }
        if crossings.len() == 1 {
            low = low.min(z[0]);
            high = high.max(z[0]);
            stuck += if (z[1] - 0.2).abs() < joint.stick_speed(0) {
                dt
            } else {
                0.0
            };
        }
        before = z[0];
    }
    assert!(crossings.len() >= 2, "{} cycles", crossings.len());
    Cycle {
        period: crossings[1] - crossings[0],
        amplitude: 0.5 * (high - low),
        stuck,
    }
}

/// Friction rises to 1 at the creep speed and has decreased to 0.5 at twice that speed: nearly
/// discontinuous.
#[derive(Debug)]
struct NearlySharp {
    creep_speed: f64,
}

impl FrictionLaw for NearlySharp {
    fn ratio(&self, speed: f64) -> Ratio {
        let x = speed / self.creep_speed;
        let (mu, slope) = match x {
            x if x <= 1.0 => {
                return Ratio {
                    value: 1.0 / self.creep_speed,
                    slope: 0.0,
                };
            }
            x if x < 2.0 => (1.5 - 0.5 * x, -0.5 / self.creep_speed),
            _ => (0.5, 0.0),
        };
        Ratio {
            value: mu / speed,
            slope: (slope - mu / speed) / speed,
        }
    }

    fn stick_speed(&self) -> f64 {
        2.0 * self.creep_speed
    }
}

#[test]
fn stick_slip_of_a_mass_on_a_belt() {
    let law = Arc::new(NearlySharp { creep_speed: 1e-5 });
    let cycle = cycle(&Joint::with_friction(&belt(Friction::None), law, true));
    assert!(
        (cycle.period / PERIOD - 1.0).abs() < 1e-3,
        "{}",
        cycle.period
    );
    assert!(
        (cycle.amplitude / AMPLITUDE - 1.0).abs() < 1e-3,
        "{}",
        cycle.amplitude
    );
    assert!((cycle.stuck - STUCK).abs() < 0.01, "{}", cycle.stuck);
}

/// Eq. (5) falls with its Stribeck slope, and its peak is below mu_s by the ratio of its slopes. As both
/// slopes increase, the cycle approaches the exact one.
#[test]
fn eq_5_approaches_discontinuous_friction() {
    let off = |stribeck: f64| {
        let creep = 4.0 * stribeck * stribeck;
        let law = Friction::Stribeck {
            law: Stribeck {
                mu_s: 1.0,
                mu_d: 0.5,
                creep,
                stribeck,
            },
            radial: true,
        };
        let cycle = cycle(&Joint::new(&belt(law)));
        [
            cycle.period / PERIOD - 1.0,
            cycle.amplitude / AMPLITUDE - 1.0,
        ]
        .map(f64::abs)
    };
    let (blunt, sharp) = (off(50.0), off(200.0));
    for (blunt, sharp) in blunt.into_iter().zip(sharp) {
        assert!(sharp < 0.02 && sharp < 0.4 * blunt, "{blunt} {sharp}");
    }
}
