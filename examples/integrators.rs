//! The integrators on one scene: what a digit costs.
//!
//! Each starts from the same kick, hard enough for contact nodes to lift off, and is compared with
//! a fine reference after 4 ms. One call is one pass over all contact nodes, which is nearly all
//! the work there is. Each opening and closing is a kink in the force: below about 1e-6 errors still
//! fall, but unevenly.
//!
//! ```text
//! cargo run --release --example integrators
//! ```

use std::error::Error;

use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, System};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// Time of the comparison, s.
const END: f64 = 4e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::load("torus-3deg")?;
    scene.start.kick = 10e-3;
    let tilted = scene.joint()?;
    let joint = BallJoint::new(&tilted.spec)?.joint(tilted.tilt.at(0.0))?;
    let start = initial_state(&scene, joint.modes());
    let reference = integrate(&joint, &start, Method::Rk4 { step: 0.05e-6 })?;
    let most = most_open(&joint, &start)?;
    println!("up to {most} of {} nodes open", joint.contact_nodes());

    let max_step = scene.integrator.max_step;
    let accuracies = [1e-4, 1e-6, 1e-8];
    let adaptive = |method: fn(Accuracy, f64) -> Method| {
        accuracies.map(|x| (x, method(Accuracy::relative(x), max_step)))
    };
    let classical = [1.6e-6, 0.8e-6, 0.4e-6].map(|step| (step, Method::Rk4 { step }));
    println!("method    tolerance or step  steps  rejected   calls  error at 4 ms");
    for (name, methods) in [
        (
            "lawson54",
            adaptive(|accuracy, max_step| Method::Lawson54 { accuracy, max_step }),
        ),
        (
            "lawson853",
            adaptive(|accuracy, max_step| Method::Lawson853 { accuracy, max_step }),
        ),
        (
            "tsit54",
            adaptive(|accuracy, max_step| Method::Tsit54 { accuracy, max_step }),
        ),
        (
            "dop853",
            adaptive(|accuracy, max_step| Method::Dop853 { accuracy, max_step }),
        ),
        (
            "rodas5p",
            adaptive(|accuracy, max_step| Method::Rodas5p { accuracy, max_step }),
        ),
        (
            "auto",
            adaptive(|accuracy, max_step| Method::Auto { accuracy, max_step }),
        ),
        ("rk4", classical),
    ] {
        for (parameter, method) in methods {
            let end = integrate(&joint, &start, method)?;
            let (tally, error) = (
                end.tally(),
                distance(&joint, end.state(), reference.state()),
            );
            println!(
                "{name:<9} {parameter:>17e} {:>6} {:>9} {:>7} {error:>14.1e}",
                tally.steps, tally.rejections, tally.calls,
            );
        }
    }
    Ok(())
}

/// The integrator after it has landed on the end.
fn integrate(joint: &Joint, start: &[f64], method: Method) -> Result<Integrator, DynamicsError> {
    let mut integrator = Integrator::new(method, joint)?;
    integrator.start(joint, 0.0, start)?;
    integrator.land(joint, END)?;
    Ok(integrator)
}

/// How far apart two states are, in the square root of energy, relative to the second.
fn distance(joint: &Joint, a: &[f64], b: &[f64]) -> f64 {
    let m = joint.modes();
    let size = |x: &dyn Fn(usize) -> f64| {
        let modes = (0..m).map(|i| (joint.omega()[i] * x(i)).powi(2) + x(m + i).powi(2));
        modes.sum::<f64>().sqrt()
    };
    size(&|i| a[i] - b[i]) / size(&|i| b[i])
}

/// The most contact nodes found open at once, looking every 5 us.
fn most_open(joint: &Joint, start: &[f64]) -> Result<u32, DynamicsError> {
    let mut integrator = Integrator::new(Method::Rk4 { step: 0.5e-6 }, joint)?;
    integrator.start(joint, 0.0, start)?;
    let mut z = start.to_vec();
    let mut open = vec![0; joint.contact_nodes().div_ceil(8)];
    let mut most = 0;
    for k in 0..800 {
        integrator.sample(joint, f64::from(k) * END / 800.0, &mut z)?;
        joint.open_nodes(&z[..joint.modes()], &mut open);
        most = most.max(open.iter().map(|byte| byte.count_ones()).sum());
    }
    Ok(most)
}
