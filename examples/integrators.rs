//! Accuracy and cost of the integration methods on one scene.
//!
//! Each run starts from the same kick, strong enough to separate contact nodes, and is compared with a
//! fine reference after 4 ms. One evaluation of the right-hand side is one loop over all contact nodes,
//! which is nearly the whole cost. Each contact change is a kink in the force: below about 1e-6 the
//! errors still decrease, but irregularly.
//!
//! ```text
//! cargo run --release --example integrators
//! ```

use std::error::Error;

use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, MethodName, System};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

/// Time of the comparison, s.
const END: f64 = 4e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::load("torus-1.75deg")?;
    scene.start.kick = 10e-3;
    let tilted = scene.joint()?;
    let joint = BallJoint::new(&tilted.spec)?.joint(tilted.tilt.at(0.0))?;
    let start = initial_state(&scene, joint.modes());
    let reference = integrate(
        &joint,
        &start,
        MethodName::Rk4.with(Accuracy::relative(1e-6), 0.05e-6),
    )?;
    let max_separated_nodes = max_separated(&joint, &start)?;
    println!(
        "up to {max_separated_nodes} of {} nodes separated",
        joint.contact_nodes()
    );

    let max_step = scene.integrator.max_step;
    let accuracies = [1e-4, 1e-6, 1e-8];
    let adaptive =
        |method: MethodName| accuracies.map(|x| (x, method.with(Accuracy::relative(x), max_step)));
    let classical = [1.6e-6, 0.8e-6, 0.4e-6]
        .map(|step| (step, MethodName::Rk4.with(Accuracy::relative(1e-6), step)));
    println!("method    tolerance or step  steps  rejected   evals  error at 4 ms");
    for (name, methods) in [
        ("lawson54", adaptive(MethodName::Lawson54)),
        ("lawson853", adaptive(MethodName::Lawson853)),
        ("tsit5", adaptive(MethodName::Tsit5)),
        ("dop853", adaptive(MethodName::Dop853)),
        ("rodas5p", adaptive(MethodName::Rodas5P)),
        ("auto", adaptive(MethodName::Auto)),
        ("rk4", classical),
    ] {
        for (parameter, method) in methods {
            let end = integrate(&joint, &start, method)?;
            let (stats, error) = (
                end.stats(),
                distance(&joint, end.state(), reference.state()),
            );
            println!(
                "{name:<9} {parameter:>17e} {:>6} {:>9} {:>7} {error:>14.1e}",
                stats.steps, stats.rejections, stats.rhs_evals,
            );
        }
    }
    Ok(())
}

/// Integrates to [`END`].
fn integrate<'a>(
    joint: &'a Joint,
    start: &[f64],
    method: Method,
) -> Result<Integrator<'a>, DynamicsError> {
    let mut integrator = Integrator::new(method, joint)?;
    integrator.start(0.0, start)?;
    integrator.integrate_to(END)?;
    Ok(integrator)
}

/// Distance between two states in the energy norm, relative to the second.
fn distance(joint: &Joint, a: &[f64], b: &[f64]) -> f64 {
    let m = joint.modes();
    let size = |x: &dyn Fn(usize) -> f64| {
        let modes = (0..m).map(|i| (joint.omega()[i] * x(i)).powi(2) + x(m + i).powi(2));
        modes.sum::<f64>().sqrt()
    };
    size(&|i| a[i] - b[i]) / size(&|i| b[i])
}

/// Maximum number of separated contact nodes, sampled every 5 us.
fn max_separated(joint: &Joint, start: &[f64]) -> Result<u32, DynamicsError> {
    let mut integrator = Integrator::new(
        MethodName::Rk4.with(Accuracy::relative(1e-6), 0.5e-6),
        joint,
    )?;
    integrator.start(0.0, start)?;
    let mut z = start.to_vec();
    let mut open = vec![0; joint.contact_nodes().div_ceil(8)];
    let mut max_separated_nodes = 0;
    for k in 0..800 {
        integrator.sample(f64::from(k) * END / 800.0, &mut z)?;
        joint.separated_nodes(&z[..joint.modes()], &mut open);
        max_separated_nodes =
            max_separated_nodes.max(open.iter().map(|byte| byte.count_ones()).sum());
    }
    Ok(max_separated_nodes)
}
