//! A user-defined friction law in place of Eq. (5).
//!
//! The law rises as `x / sqrt(1 + x^2)` and falls as a hyperbola. Its two free parameters are fitted to
//! the value and the slope of Eq. (5) at the speed of steady sliding, so the linear stability of the two
//! laws is nearly identical. The settled vibration depends on the full curve.
//!
//! ```text
//! cargo run --release --example custom_friction_law
//! ```

use std::error::Error;
use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, Integrator, MethodName, System};
use squeakscope::joint::{BallJoint, Friction, FrictionLaw, Joint, Ratio, Stribeck};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// `mu(V) = x / sqrt(1 + x^2) (mu_d + rise / (1 + V / v_fall))` with `x = creep V`.
#[derive(Debug)]
struct Algebraic {
    creep: f64,
    mu_d: f64,
    rise: f64,
    v_fall: f64,
}

impl Algebraic {
    /// With the creep slope factor and the kinetic coefficient of `law`, fitted to its value and slope
    /// at `speed` (m/s).
    fn fitted(law: &Stribeck, speed: f64) -> Self {
        let x = law.creep * speed;
        let (share, share_slope) = (x / x.hypot(1.0), law.creep / x.hypot(1.0).powi(3));
        let sliding = law.coefficient(speed) / share;
        let slope = (law.slope(speed) - share_slope * sliding) / share;
        let above = sliding - law.mu_d;
        let v_fall = -above / slope - speed;
        Self {
            creep: law.creep,
            mu_d: law.mu_d,
            rise: above * (1.0 + speed / v_fall),
            v_fall,
        }
    }
}

impl FrictionLaw for Algebraic {
    fn ratio(&self, speed: f64) -> Ratio {
        let x = self.creep * speed;
        let share = self.creep / x.hypot(1.0);
        let share_slope = -self.creep * x * share / (1.0 + x * x);
        let fall = 1.0 / (1.0 + speed / self.v_fall);
        let sliding = self.mu_d + self.rise * fall;
        let sliding_slope = -self.rise * fall * fall / self.v_fall;
        Ratio {
            value: share * sliding,
            slope: share_slope * sliding + share * sliding_slope,
        }
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::load("periodic-2deg")?;
    let ball = BallJoint::new(&scene.joint()?.spec)?;
    let tilt = scene.joint()?.tilt.at(0.0);
    let model = ball.model(tilt)?;
    let Friction::Stribeck { law, radial } = model.friction else {
        return Err("the scene has no friction".into());
    };
    let speed = ball
        .sliding_velocity(tilt)
        .iter()
        .map(|v| v * v)
        .sum::<f64>()
        .sqrt();
    let custom = Algebraic::fitted(&law, speed);
    println!(
        "steady sliding at {:.2} mm/s, mu = {:.4}",
        1e3 * speed,
        law.coefficient(speed)
    );

    for (name, joint) in [
        ("Eq. (5)", Joint::new(&model)),
        (
            "custom law",
            Joint::with_friction(&model, Arc::new(custom), radial),
        ),
    ] {
        println!("{name}:");
        for mode in joint.linear_modes()?.iter().filter(|mode| mode.unstable()) {
            println!(
                "  unstable at {:8.1} Hz, growth {:6.1} 1/s",
                mode.frequency_hz, mode.growth
            );
        }
        println!(
            "  settles at an amplitude of {:.4} um",
            1e6 * settled(&joint, &scene)?
        );
    }
    Ok(())
}

/// Half the peak-to-peak displacement (m), Eq. (24), over 20 ms, starting 80 ms after a small kick.
fn settled(joint: &Joint, scene: &Scene) -> Result<f64, Box<dyn Error>> {
    let accuracy = Accuracy::relative(scene.integrator.tolerance);
    let method = MethodName::Lawson54.with(accuracy, scene.integrator.max_step);
    let mut integrator = Integrator::new(method, joint)?;
    let mut z = initial_state(scene, joint.modes());
    integrator.start(0.0, &z)?;
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for k in 16_000..20_000 {
        integrator.sample(f64::from(k) / 200e3, &mut z)?;
        let u = joint.probe_value(&z[..z.len() / 2]);
        (low, high) = (low.min(u), high.max(u));
    }
    Ok(0.5 * (high - low))
}
