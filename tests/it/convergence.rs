//! The integrators on the paper's joint: they agree with one another, at their orders, and with an
//! independent method of high order.

use squeakscope::dynamics::{Accuracy, Integrator, Method, System};
use squeakscope::joint::{BallJoint, Joint};
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

const SPAN: f64 = 4e-3;

/// The joint of `torus-3deg`, kicked hard.
fn kicked() -> (Joint, Vec<f64>) {
    let mut scene = Scene::load("torus-3deg").unwrap();
    scene.start.kick = 5e-3;
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let joint = ball.joint(scene.joint().unwrap().tilt.at(0.0)).unwrap();
    let z = initial_state(&scene, joint.modes());
    (joint, z)
}

/// Gragg, Bulirsch and Stoer: the modified midpoint rule with 2, 4, ... 16 substeps, extrapolated
/// to order 16 in each of `steps` steps. Shares nothing with the integrators under test.
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
            // Gragg's smoothing, then Aitken and Neville in h^2.
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

/// Distance of two states over the size of the second, in the energy norm.
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
    integrator.start(joint, 0.0, start).unwrap();
    integrator.land(joint, SPAN).unwrap();
    integrator.state().to_vec()
}

#[test]
fn the_integrators_and_an_independent_one_agree() {
    let (joint, start) = kicked();
    // The steps are short because nodes open and close: each kink costs the order, not the step.
    let exact = reference(&joint, &start, 16_000);
    let check = distance(&joint, &reference(&joint, &start, 11_000), &exact);
    assert!(check < 2e-9, "the reference itself is off by {check:e}");
    let adaptive = |relative| (Accuracy::relative(relative), 1e-4);
    let lawson = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(&joint, &start, Method::Lawson54 { accuracy, max_step }),
            &exact,
        )
    };
    let tsit = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(&joint, &start, Method::Tsit54 { accuracy, max_step }),
            &exact,
        )
    };
    let rk4 = |step| {
        distance(
            &joint,
            &integrate(&joint, &start, Method::Rk4 { step }),
            &exact,
        )
    };
    let rodas = |relative| {
        let (accuracy, max_step) = adaptive(relative);
        distance(
            &joint,
            &integrate(&joint, &start, Method::Rodas5p { accuracy, max_step }),
            &exact,
        )
    };
    // Adaptive methods: the error follows the tolerance, down to 1e-8 and below.
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

/// Samples between the steps are as good as the steps: dense output against landing there.
#[test]
fn samples_do_not_depend_on_the_steps() {
    let (joint, start) = kicked();
    let method = Method::Lawson54 {
        accuracy: Accuracy::relative(1e-9),
        max_step: 1e-4,
    };
    let mut sampled = Integrator::new(method, &joint).unwrap();
    let mut landed = Integrator::new(method, &joint).unwrap();
    sampled.start(&joint, 0.0, &start).unwrap();
    landed.start(&joint, 0.0, &start).unwrap();
    let mut z = vec![0.0; joint.dim()];
    for k in 1..=100 {
        let t = 5e-6 * f64::from(k);
        sampled.sample(&joint, t, &mut z).unwrap();
        landed.land(&joint, t).unwrap();
        let off = distance(&joint, &z, landed.state());
        assert!(off < 1e-7, "{off:e} at {t}");
    }
}

/// With hardly any sliding the whole patch creeps at rest, and the joint is stiff.
#[test]
fn auto_turns_implicit_where_the_joint_sticks() {
    let scene = Scene::load("torus-3deg").unwrap();
    let tilted = scene.joint().unwrap();
    let accuracy = Accuracy::relative(1e-5);
    let max_step = 20e-6;
    let run = |slowness: f64, method: Method| {
        let mut spec = tilted.spec.clone();
        spec.rotation
            .iter_mut()
            .for_each(|omega| *omega /= slowness);
        let ball = BallJoint::new(&spec).unwrap();
        let joint = ball.joint(tilted.tilt.at(0.0)).unwrap().with_audit();
        let mut start = initial_state(&scene, joint.modes());
        start.resize(joint.dim(), 0.0);
        let mut integrator = Integrator::new(method, &joint).unwrap();
        integrator.start(&joint, 0.0, &start).unwrap();
        integrator.land(&joint, 10e-3).unwrap();
        let state = integrator.state()[..2 * joint.modes()].to_vec();
        (integrator.tally(), state, joint)
    };
    let lawson = Method::Lawson54 { accuracy, max_step };
    let auto = Method::Auto { accuracy, max_step };
    let (explicit, there, joint) = run(100.0, lawson);
    let (switched, here, _) = run(100.0, auto);
    assert!(
        switched.switches > 0 && switched.jacobians > 100,
        "{switched:?}"
    );
    assert!(
        4 * switched.steps < explicit.steps,
        "{switched:?} {explicit:?}"
    );
    // Each Jacobian with its factors weighs as much as ten calls, at most.
    let cost = switched.calls + 10 * switched.jacobians;
    assert!(4 * cost < 3 * explicit.calls, "{switched:?} {explicit:?}");
    let off = distance(&joint, &here, &there);
    assert!(off < 1e-2, "{off:e}");
    // At the preset's speed nothing sticks for long.
    let (explicit, there, _) = run(1.0, lawson);
    let (switched, here, _) = run(1.0, auto);
    assert_eq!((explicit, there), (switched, here));
}
