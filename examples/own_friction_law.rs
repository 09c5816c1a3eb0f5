//! A friction law of one's own, beside Eq. (5).
//!
//! The law here rises as a hyperbolic tangent and falls as a hyperbola. Its two free parameters
//! give it the value and the slope of Eq. (5) at the speed of steady sliding, so that linear
//! stability can hardly tell the two apart. The vibration that settles sees the whole curve.
//!
//! ```text
//! cargo run --release --example own_friction_law
//! ```

use std::error::Error;
use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, Integrator, Method, System};
use squeakscope::joint::{BallJoint, Friction, FrictionLaw, Joint, Ratio, Stribeck};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// `mu(V) = tanh(creep V) (mu_d + rise / (1 + V / v_fall))`.
#[derive(Debug)]
struct Hyperbolic {
    creep: f64,
    mu_d: f64,
    rise: f64,
    v_fall: f64,
}

impl Hyperbolic {
    /// With the limits, value and slope of `law` at `speed`, where that must slide, not creep.
    fn touching(law: &Stribeck, speed: f64) -> Self {
        let above = law.coefficient(speed) - law.mu_d;
        let v_fall = -above / law.slope(speed) - speed;
        let rise = above * (1.0 + speed / v_fall);
        Self {
            creep: law.creep,
            mu_d: law.mu_d,
            rise,
            v_fall,
        }
    }
}

impl FrictionLaw for Hyperbolic {
    fn ratio(&self, speed: f64) -> Ratio {
        let x = self.creep * speed;
        // tanh(x)/x and its derivative, by their series where the closed form cancels.
        let (share, share_slope) = if x < 0.03 {
            let y = x * x;
            let slope = -2.0 / 3.0 + y * (8.0 / 15.0 - y * (34.0 / 105.0 - y * 496.0 / 2835.0));
            (
                1.0 - y * (1.0 / 3.0 - y * (2.0 / 15.0 - y * 17.0 / 315.0)),
                x * slope,
            )
        } else {
            let share = x.tanh() / x;
            (share, (x.cosh().powi(-2) - share) / x)
        };
        let fall = 1.0 / (1.0 + speed / self.v_fall);
        let (sliding, slope) = (
            self.mu_d + self.rise * fall,
            -self.rise * fall * fall / self.v_fall,
        );
        Ratio {
            value: self.creep * share * sliding,
            slope: self.creep * (self.creep * share_slope * sliding + share * slope),
        }
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::load("periodic-2deg")?;
    let ball = BallJoint::new(&scene.joint)?;
    let tilt = scene.tilt.at(0.0);
    let model = ball.model(tilt)?;
    let Friction::Stribeck {
        mu_s,
        mu_d,
        creep,
        stribeck,
        radial,
    } = model.friction
    else {
        return Err("the scene has no friction".into());
    };
    let paper = Stribeck {
        mu_s,
        mu_d,
        creep,
        stribeck,
    };
    let speed = ball
        .sliding_velocity(tilt)
        .iter()
        .map(|v| v * v)
        .sum::<f64>()
        .sqrt();
    let own = Hyperbolic::touching(&paper, speed);
    println!(
        "steady sliding at {:.2} mm/s, mu = {:.4}",
        1e3 * speed,
        paper.coefficient(speed)
    );

    for (name, joint) in [
        ("Eq. (5)", Joint::new(&model)),
        (
            "hyperbolic",
            Joint::with_friction(&model, Arc::new(own), radial),
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

/// Half the range (m) of Eq. (24) over 20 ms, 80 ms after a small kick.
fn settled(joint: &Joint, scene: &Scene) -> Result<f64, Box<dyn Error>> {
    let accuracy = Accuracy::relative(scene.integrator.tolerance);
    let method = Method::Lawson54 {
        accuracy,
        max_step: scene.integrator.max_step,
    };
    let mut integrator = Integrator::new(method, joint)?;
    let mut z = initial_state(scene, joint.modes());
    integrator.start(joint, 0.0, &z)?;
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for k in 16_000..20_000 {
        integrator.sample(joint, f64::from(k) / 200e3, &mut z)?;
        let u = joint.probe_value(&z[..z.len() / 2]);
        (low, high) = (low.min(u), high.max(u));
    }
    Ok(0.5 * (high - low))
}
