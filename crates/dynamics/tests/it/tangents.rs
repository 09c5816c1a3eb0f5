//! Tangent vectors compared with finite differences of the flow.

use super::*;
use crate::known::Lorenz;
use squeakscope_dynamics::{Differentiable, Switching};
use squeakscope_joint::systems::{DampedContact, ImpactOscillator, MassOnBelt};

const IMPACTS: ImpactOscillator = ImpactOscillator {
    omega: 1.0,
    damping: 0.03,
    drive: 1.0,
    drive_omega: 2.8,
    drive_phase: 0.0,
    wall: 0.0,
    restitution: 0.8,
};

const BELT: MassOnBelt = MassOnBelt {
    omega: 1.0,
    damping: 0.05,
    load: 1.0,
    mu_s: 1.0,
    mu_d: 0.5,
    belt: 0.2,
    stribeck: None,
};

const CONTACT: DampedContact = DampedContact {
    omega: 1.0,
    damping: 0.02,
    drive: 0.7,
    drive_omega: 1.7,
    drive_phase: 0.0,
    contact_stiffness: 20.0,
    contact_damping: 1.5,
};

fn integrator_with_events<Y: System>(method: Method, sys: &Y) -> Integrator<'_> {
    let integrator = Integrator::new(method, sys).unwrap();
    match sys.switching() {
        Some(_) => integrator.with_events().unwrap(),
        None => integrator,
    }
}

/// The state at time `t`, with event location if the system has guards.
fn flow<Y: System>(method: Method, sys: &Y, z0: &[f64], t: f64) -> Vec<f64> {
    let mut integrator = integrator_with_events(method, sys);
    integrator.start(0.0, z0).unwrap();
    integrator.integrate_to(t).unwrap();
    integrator.state().to_vec()
}

/// Largest difference between the tangent vectors and finite differences of the flow, relative to the
/// largest component; and the number of crossings.
fn difference<Y: System>(method: Method, sys: &Y, z0: &[f64], t: f64) -> (f64, u64) {
    let n = sys.tangent_dim();
    let mut integrator = integrator_with_events(method, sys)
        .with_tangents(n, 0)
        .unwrap();
    integrator.start(0.0, z0).unwrap();
    let mut unit = vec![0.0; n * n];
    (0..n).for_each(|c| unit[c * n + c] = 1.0);
    integrator.set_tangent_vectors(&unit).unwrap();
    integrator.integrate_to(t).unwrap();
    let vectors = integrator.tangent_vectors().unwrap();
    let largest = vectors.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    let mut worst = 0.0_f64;
    for l in 0..n {
        let shifted = |shift: f64| {
            let mut z = z0.to_vec();
            z[l] += shift;
            flow(method, sys, &z, t)
        };
        let step = 1e-4;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| shifted(k * step));
        for k in 0..n {
            let slope = (8.0 * (c[k] - b[k]) - (d[k] - a[k])) / (12.0 * step);
            worst = worst.max((slope - vectors[k * n + l]).abs() / largest);
        }
    }
    (worst, integrator.stats().crossings)
}

#[test]
fn tangent_vectors_are_the_derivative_of_the_flow_across_jumps() {
    for method in all_methods(1e-12, 0.1, 1e-3) {
        for (name, (error, crossings)) in [
            (
                "Lorenz",
                difference(method, &Lorenz::CLASSICAL, &[1.0, -2.0, 17.0], 0.7),
            ),
            ("impacts", difference(method, &IMPACTS, &[0.5, 0.1], 9.0)),
            (
                "belt, slipping",
                difference(method, &BELT, &[1.8, -0.3], 3.0),
            ),
            (
                "belt, sticking",
                difference(method, &BELT, &[1.8, -0.3], 20.0),
            ),
            // The spring force exceeds the friction limit: the mass does not stick.
            ("belt, turning", difference(method, &BELT, &[2.3, 0.6], 1.0)),
            (
                "damped contact",
                difference(method, &CONTACT, &[0.4, 0.1], 9.0),
            ),
        ] {
            assert!(error < 1e-6, "{name}, {method:?}: {error:e}");
            assert_eq!(
                crossings == 0,
                name == "Lorenz" || name == "belt, slipping",
                "{name}"
            );
        }
    }
}

/// Three laws. The second one has zero duration: its guard is negative from the start.
struct Relay;

impl System for Relay {
    fn omega(&self) -> &[f64] {
        &[]
    }
    fn first_order(&self) -> usize {
        2
    }
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        self.force_in(&[0], t, z, out);
    }
    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Switching for Relay {
    fn status_of(&self, _t: f64, _z: &[f64], status: &mut [u8]) {
        status[0] = 0;
    }
    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&match status[0] {
            0 => [1.0, z[0]],
            1 => [3.0, -5.0],
            _ => [2.0, 4.0],
        });
    }
    fn guards(&self) -> usize {
        2
    }
    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&match status[0] {
            0 => [1.0 - z[0] - 0.3 * z[1], 1.0],
            1 => [1.0, -1.0 - z[0]],
            _ => [1.0, 1.0],
        });
    }
    fn cross(&self, _guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        status[0] += 1;
    }
    fn guard_gradient(
        &self,
        status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let slopes = if status[0] == 0 {
            [-1.0, -0.3]
        } else {
            [-1.0, 0.0]
        };
        gradient.copy_from_slice(&slopes);
        0.0
    }
}

impl Differentiable for Relay {
    fn product(
        &self,
        status: Option<&[u8]>,
        _record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        if status == Some(&[0]) {
            out[width..].copy_from_slice(&vectors[..width]);
        }
    }
}

#[test]
fn guards_crossed_at_one_instant_share_their_delay() {
    for method in all_methods(1e-12, 0.1, 1e-3) {
        let (error, crossings) = difference(method, &Relay, &[0.2, 0.1], 2.0);
        assert_eq!(crossings, 2);
        assert!(error < 1e-8, "{method:?}: {error:e}");
    }
}

/// Separation rate of two trajectories with periodic renormalisation of their distance (G. Benettin, L.
/// Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9-20). This uses no tangent vectors,
/// derivatives or saltation matrices.
fn separation_rate<Y: System>(method: Method, sys: &Y, z0: &[f64], every: f64, times: u32) -> f64 {
    const INITIAL_DISTANCE: f64 = 1e-7;
    let (mut first, mut second) = (
        integrator_with_events(method, sys),
        integrator_with_events(method, sys),
    );
    let mut perturbed = z0.to_vec();
    perturbed[0] += INITIAL_DISTANCE;
    first.start(0.0, z0).unwrap();
    let (mut sum, skip) = (0.0, times / 10);
    for k in 1..=times {
        let from = every * f64::from(k - 1);
        second.start(from, &perturbed).unwrap();
        first.integrate_to(from + every).unwrap();
        second.integrate_to(from + every).unwrap();
        let difference_vector: Vec<f64> = second
            .state()
            .iter()
            .zip(first.state())
            .map(|(b, a)| b - a)
            .collect();
        let length = difference_vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if k > skip {
            sum += (length / INITIAL_DISTANCE).ln();
        }
        for ((perturbed, a), x) in perturbed
            .iter_mut()
            .zip(first.state())
            .zip(&difference_vector)
        {
            *perturbed = a + x * (INITIAL_DISTANCE / length);
        }
    }
    sum / (every * f64::from(times - skip))
}

#[test]
fn two_trajectories_separate_at_the_largest_exponent() {
    let method = all_methods(1e-10, 0.1, 1e-3)[1];
    let lorenz = separation_rate(method, &Lorenz::CLASSICAL, &[1.0, -2.0, 17.0], 0.5, 2000);
    assert!((lorenz - 0.9056).abs() < 0.02, "{lorenz}");
    let sys = ImpactOscillator {
        damping: 0.0,
        ..IMPACTS
    };
    let impacts = separation_rate(method, &sys, &[0.5, 0.0], 2.0, 4000);
    assert!((impacts - 0.14245).abs() < 0.01, "{impacts}");
}

#[test]
fn reverting_a_step_reverts_the_vectors() {
    let lorenz = Lorenz::CLASSICAL;
    for method in all_methods(1e-9, 0.1, 0.01) {
        let exponents = |detour: bool| {
            let mut integrator = Integrator::new(method, lorenz)
                .and_then(|new| new.with_tangents(3, 4))
                .unwrap();
            integrator.start(0.0, &[1.0, -2.0, 17.0]).unwrap();
            integrator.sample(3.0, &mut [0.0; 3]).unwrap();
            if detour {
                integrator.reset_growth();
            }
            integrator.integrate_to(3.0).unwrap();
            integrator.reset_growth();
            integrator.integrate_to(5.0).unwrap();
            integrator.exponents().unwrap()
        };
        let (straight, detour) = (exponents(false), exponents(true));
        for (a, b) in straight.exponents.iter().zip(&detour.exponents) {
            assert!((a.value - b.value).abs() < 1e-8, "{method:?}: {a:?} {b:?}");
        }
    }
}

/// User-supplied vectors remain the derivative of the flow.
#[test]
fn user_supplied_vectors_are_unaffected_by_a_growth_reset() {
    let sys = Lorenz::CLASSICAL;
    let vectors = |forget: bool| {
        let method = all_methods(1e-8, 0.1, 0.01)[1];
        let mut motion = Integrator::new(method, sys)
            .and_then(|new| new.with_tangents(2, 1))
            .unwrap();
        motion.start(0.0, &[1.0, -2.0, 17.0]).unwrap();
        motion
            .set_tangent_vectors(&[1.0, 1.0, 0.0, 1.0, 2.0, -1.0])
            .unwrap();
        motion.integrate_to(0.5).unwrap();
        if forget {
            motion.reset_growth();
        }
        motion.integrate_to(1.0).unwrap();
        motion.tangent_vectors().unwrap().to_vec()
    };
    assert_eq!(vectors(true), vectors(false));
}
