//! The integrators on the paper's joint: agreement with each other and with an independent high-order
//! method, and convergence orders.

use squeakscope::dynamics::{Accuracy, Integrator, Method, MethodName, System};
use squeakscope::joint::{BallJoint, Joint, Quadrature};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

const SPAN: f64 = 4e-3;

/// The joint of `doubled-torus-3deg` with a strong kick.
fn strongly_kicked() -> (Joint, Vec<f64>) {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene.start.kick = 5e-3;
    // Few of these nodes separate at the rim of the patch, so that the reference converges fast.
    let contact = &mut scene.joint_mut().unwrap().spec.contact;
    (contact.nodes, contact.quadrature) = (100, Quadrature::Rings);
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let joint = ball.joint(scene.joint().unwrap().tilt.at(0.0)).unwrap();
    let z = initial_state(&scene, joint.modes());
    (joint, z)
}

/// Gragg–Bulirsch–Stoer method: the modified midpoint rule with 2, 4, ... 16 substeps, extrapolated to
/// order 16 in each of `steps` steps. It shares no code with the integrators under test.
fn reference(joint: &Joint, start: &[f64], steps: usize) -> Vec<f64> {
    const LEVELS: usize = 8;
    let step = SPAN / steps as f64;
    let mut z = start.to_vec();
    let mut rate = vec![0.0; z.len()];
    for _ in 0..steps {
        let mut table: Vec<Vec<f64>> = Vec::new();
        for level in 0..LEVELS {
            let n = 2 * (level + 1);
            let h = step / n as f64;
            joint.rhs(0.0, &z, &mut rate);
            let mut before = z.clone();
            let mut now: Vec<f64> = z.iter().zip(&rate).map(|(z, r)| z + h * r).collect();
            for _ in 1..n {
                joint.rhs(0.0, &now, &mut rate);
                let next = before
                    .iter()
                    .zip(&rate)
                    .map(|(z, r)| z + 2.0 * h * r)
                    .collect();
                before = std::mem::replace(&mut now, next);
            }
            // Gragg's smoothing, then Aitken–Neville extrapolation in h^2.
            joint.rhs(0.0, &now, &mut rate);
            let mut column: Vec<f64> = (0..z.len())
                .map(|i| 0.5 * (now[i] + before[i] + h * rate[i]))
                .collect();
            for (back, lower) in (0..level).rev().zip(table.iter_mut().rev()) {
                let ratio = ((level + 1) as f64 / (back + 1) as f64).powi(2);
                let better: Vec<f64> = column
                    .iter()
                    .zip(lower.iter())
                    .map(|(fine, coarse)| fine + (fine - coarse) / (ratio - 1.0))
                    .collect();
                *lower = std::mem::replace(&mut column, better);
            }
            table.insert(0, column);
        }
        z = table.swap_remove(0);
    }
    z
}

/// Distance between two states in the energy norm, relative to the second.
fn distance(joint: &Joint, a: &[f64], b: &[f64]) -> f64 {
    let m = joint.modes();
    let norm = |z: &dyn Fn(usize) -> f64| -> f64 {
        (0..m)
            .map(|i| (joint.omega()[i] * z(i)).powi(2) + z(m + i).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    norm(&|i| a[i] - b[i]) / norm(&|i| b[i])
}

fn integrate(joint: &Joint, start: &[f64], method: Method) -> Vec<f64> {
    let mut integrator = Integrator::new(method, joint).unwrap();
    integrator.start(0.0, start).unwrap();
    integrator.integrate_to(SPAN).unwrap();
    integrator.state().to_vec()
}

#[test]
fn the_integrators_agree_with_an_independent_method() {
    let (joint, start) = strongly_kicked();
    // The steps are short because contact changes are kinks, which reduce the order.
    let exact = reference(&joint, &start, 16_000);
    let check = distance(&joint, &reference(&joint, &start, 11_000), &exact);
    assert!(check < 2e-9, "the error of the reference is {check:e}");
    let adaptive = |relative| (Accuracy::relative(relative), 1e-4);
    let lawson = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(
                &joint,
                &start,
                MethodName::Lawson54.with(accuracy, max_step),
            ),
            &exact,
        )
    };
    let tsit = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(&joint, &start, MethodName::Tsit5.with(accuracy, max_step)),
            &exact,
        )
    };
    let rk4 = |step| {
        distance(
            &joint,
            &integrate(
                &joint,
                &start,
                MethodName::Rk4.with(Accuracy::relative(1e-6), step),
            ),
            &exact,
        )
    };
    let rodas = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(&joint, &start, MethodName::Rodas5P.with(accuracy, max_step)),
            &exact,
        )
    };
    // Adaptive methods: the error is proportional to the tolerance, down to 1e-8 and below.
    for error in [&lawson as &dyn Fn(f64) -> f64, &tsit, &rodas] {
        let (loose, tight, tightest) = (error(1e-6), error(1e-8), error(1e-10));
        assert!(
            tight < 0.05 * loose && tightest < 0.05 * tight,
            "{loose:e} {tight:e} {tightest:e}"
        );
        assert!(tightest < 1e-8, "{tightest:e}");
    }
    // Fixed steps: order 4.
    let (coarse, fine) = (rk4(0.4e-6), rk4(0.2e-6));
    let order = (coarse / fine).log2();
    assert!(
        (3.7..4.4).contains(&order),
        "order {order}: {coarse:e} {fine:e}"
    );
    assert!(rk4(0.05e-6) < 1e-8);
}

/// Samples between step ends are as accurate as step ends.
#[test]
fn samples_agree_with_step_ends() {
    let (joint, start) = strongly_kicked();
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-9), 1e-4);
    let mut sampled = Integrator::new(method, &joint).unwrap();
    let mut at_step_ends = Integrator::new(method, &joint).unwrap();
    sampled.start(0.0, &start).unwrap();
    at_step_ends.start(0.0, &start).unwrap();
    let mut z = vec![0.0; joint.dim()];
    for k in 1..=100 {
        let t = 5e-6 * f64::from(k);
        sampled.sample(t, &mut z).unwrap();
        at_step_ends.integrate_to(t).unwrap();
        let error = distance(&joint, &z, at_step_ends.state());
        assert!(error < 1e-7, "{error:e} at {t}");
    }
}

/// At very low sliding speed the whole patch creeps, and the joint is stiff.
#[test]
fn auto_switches_to_implicit_steps_while_the_joint_sticks() {
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let tilted = scene.joint().unwrap();
    let accuracy = Accuracy::relative(1e-5);
    let max_step = 20e-6;
    let run = |slowdown: f64, method: Method| {
        let mut spec = tilted.spec.clone();
        spec.rotation
            .iter_mut()
            .for_each(|omega| *omega /= slowdown);
        let ball = BallJoint::new(&spec).unwrap();
        let joint = ball.joint(tilted.tilt.at(0.0)).unwrap().with_audit();
        let mut start = initial_state(&scene, joint.modes());
        start.resize(joint.dim(), 0.0);
        let mut integrator = Integrator::new(method, &joint).unwrap();
        integrator.start(0.0, &start).unwrap();
        integrator.integrate_to(10e-3).unwrap();
        let state = integrator.state()[..2 * joint.modes()].to_vec();
        let stats = integrator.stats();
        drop(integrator);
        (stats, state, joint)
    };
    let lawson = MethodName::Lawson54.with(accuracy, max_step);
    let auto = MethodName::Auto.with(accuracy, max_step);
    let (explicit, explicit_state, joint) = run(100.0, lawson);
    let (switched, auto_state, _) = run(100.0, auto);
    assert!(
        switched.switches > 0 && switched.jacobians > 100,
        "{switched:?}"
    );
    assert!(
        4 * switched.steps < explicit.steps,
        "{switched:?} {explicit:?}"
    );
    // A Jacobian with its factorisation costs at most ten evaluations.
    let cost = switched.rhs_evals + 10 * switched.jacobians;
    assert!(
        4 * cost < 3 * explicit.rhs_evals,
        "{switched:?} {explicit:?}"
    );
    let error = distance(&joint, &auto_state, &explicit_state);
    assert!(error < 1e-2, "{error:e}");
    // At the speed of the preset no node sticks for long.
    let (explicit, explicit_state, _) = run(1.0, lawson);
    let (switched, auto_state, _) = run(1.0, auto);
    assert_eq!((explicit, explicit_state), (switched, auto_state));
}
