//! A contact pushes and never pulls: clamped contact damping, its events, tangent vectors and work.

use super::*;
use squeakscope_dynamics::{Accuracy, Integrator, MethodName, Switching};

/// Damping laws so strong that the force of closed nodes ends.
const STRONG: [ContactDamping; 2] = [
    ContactDamping::KelvinVoigt { time: 5e-6 },
    ContactDamping::HuntCrossley { dissipation: 60.0 },
];

const DAMPINGS: [ContactDamping; 4] = [
    ContactDamping::None,
    ContactDamping::KelvinVoigt { time: 2e-7 },
    STRONG[0],
    STRONG[1],
];

/// Normal forces are not negative, and friction dissipates, at each node of a state. Returns the number of
/// closed nodes without force.
fn assert_pushes(joint: &Joint, z: &[f64]) -> usize {
    let (q, v) = z[..2 * joint.modes()].split_at(joint.modes());
    let forces = joint.node_forces(z);
    let mut status = vec![0; joint.status_len()];
    joint.status_of(0.0, z, &mut status);
    let mut pulled = 0;
    for (k, normal) in forces.normal.iter().enumerate() {
        let action = joint.node_action(k, q, v, &[]);
        assert!(
            action.normal >= 0.0 && *normal >= 0.0,
            "node {k}: {action:?}"
        );
        assert!(
            dot(action.friction, action.slip) <= 0.0,
            "node {k}: {action:?}"
        );
        let is_pulled = action.gap > 0.0 && action.normal == 0.0;
        let bits = status.get(joint.nodes.blocks.len() + k / LANES);
        let marked = bits.is_some_and(|bits| bits >> (k % LANES) & 1 == 1);
        assert_eq!(marked, is_pulled, "node {k}: {action:?}");
        pulled += usize::from(is_pulled);
    }
    pulled
}

/// At random states and along simulations, for each law of friction and damping.
#[test]
fn contacts_never_pull() {
    for friction in frictions() {
        for contact_damping in DAMPINGS {
            let joint = Joint::new(&Model {
                contact_damping,
                ..scattered(19, 4, friction.clone())
            });
            let mut pulled = 0;
            for seed in 0..40 {
                let mut z = state(&joint, seed);
                z[4..].iter_mut().for_each(|v| *v *= 10.0);
                pulled += assert_pushes(&joint, &z);
            }
            assert_eq!(pulled > 20, STRONG.contains(&contact_damping), "{pulled}");
            let mut run = started(&joint, 1e-8, &state(&joint, 3));
            let mut z = vec![0.0; joint.dim()];
            for k in 1..200 {
                run.sample(1e-6 * f64::from(k), &mut z).unwrap();
                // A sample may be beyond a guard by the rounding of its time.
                let (q, v) = z.split_at(4);
                let pushes = |k| joint.node_action(k, q, v, &[]).normal >= 0.0;
                assert!((0..19).all(pushes));
            }
        }
    }
}

/// The force of a node as it is pulled off: it ends before separation, continuously, and returns at closing.
#[test]
fn force_ends_before_separation() {
    let model = |contact_damping| Model {
        contact_damping,
        shapes: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1e-7],
        pre_stress: vec![1e7],
        stiffness: vec![1e13],
        ..scattered(1, 1, Friction::None)
    };
    let normal = |damping, q: f64, v: f64| {
        let action = Joint::new(&model(damping)).node_action(0, &[q], &[v], &[]);
        (action.normal, action.dashpot)
    };
    let [dashpot, hunt_crossley] = STRONG;
    // The spring carries 0.4 N. The stress of the dashpot is 5e7 Pa s/m.
    let close = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() + (b - d).abs() < 1e-12;
    assert!(close(normal(dashpot, -6e-7, -0.04), (0.2, -0.2)));
    assert!(close(normal(dashpot, -6e-7, -0.08), (0.0, -0.4)));
    assert!(close(normal(dashpot, -6e-7, -0.3), (0.0, -0.4)));
    assert!(close(normal(dashpot, -1.1e-6, 0.3), (0.0, 0.0)));
    assert!(close(normal(dashpot, -1e-6 + 1e-20, 0.1), (0.5, 0.5)));
    assert!(close(normal(hunt_crossley, -6e-7, -0.01), (0.16, -0.24)));
    assert!(close(normal(hunt_crossley, -6e-7, -0.02), (0.0, -0.4)));
}

/// A joint of few nodes whose vibration pulls its nodes off.
fn rattling(friction: Friction, contact_damping: ContactDamping) -> Joint {
    Joint::new(&Model {
        contact_damping,
        damping: vec![],
        ..scattered(3, 2, friction)
    })
}

const RATTLE: [f64; 4] = [8e-7, -6e-7, 0.03, 0.06];

fn started<'a>(joint: &'a Joint, relative: f64, z: &[f64]) -> Integrator<'a> {
    let method = MethodName::Lawson853.with(Accuracy::relative(relative), 1e-5);
    let new = Integrator::new(method, joint).unwrap();
    let mut run = new.with_events().unwrap();
    run.start(0.0, z).unwrap();
    run
}

/// Each event changes one bit, and the sequence is end of the force, separation, closing. The force is
/// continuous at the first two.
#[test]
fn events_follow_each_other() {
    for damping in STRONG {
        let joint = rattling(STRIBECK, damping);
        let mut run = started(&joint, 1e-11, &RATTLE);
        let rate = |status: &[u8], z: &[f64]| {
            let mut rate = vec![0.0; joint.modes()];
            joint.force_in(status, 0.0, z, &mut rate);
            rate
        };
        let mut counts = [0; 4];
        loop {
            let before = run.status().to_vec();
            let crossed = run.next_event(3e-4).unwrap().to_vec();
            let Some(&guard) = crossed.first() else { break };
            let (node, is_gap) = (guard % 3, guard < 3);
            let after = run.status();
            let bits = |status: &[u8]| [0, 1].map(|half| status[half] >> node & 1 == 1);
            let (kind, continuous) = match (is_gap, bits(&before), bits(after)) {
                (true, [false, _], [true, false]) => (0, damping != STRONG[0]),
                (true, [true, false], [false, false]) => (1, damping != STRONG[0]),
                (false, [false, false], [false, true]) => (2, true),
                (false, [false, true], [false, false]) => (3, true),
                other => panic!("{other:?}"),
            };
            let continuous = continuous || (kind == 0 && bits(&before)[1]);
            counts[kind] += 1;
            let [one, two] = [rate(&before, run.state()), rate(after, run.state())];
            let jump = one
                .iter()
                .zip(&two)
                .map(|(a, b)| (a - b).abs())
                .sum::<f64>();
            let size = joint
                .equilibrium()
                .force
                .iter()
                .fold(0.0, |a: f64, f| a + f.abs());
            assert_eq!(
                jump < 1e-6 * size,
                continuous,
                "{kind}: {jump:e} of {size:e}"
            );
        }
        assert!(
            counts[0] > 1 && counts[1] > 1 && counts[2] > 1,
            "{counts:?}"
        );
    }
}

/// Tangent vectors through these events are the derivative of the flow.
#[test]
fn tangent_vectors_are_the_derivative_of_the_flow() {
    let end = 2e-4;
    for damping in STRONG {
        for friction in [Friction::None, STRIBECK] {
            let joint = rattling(friction, damping);
            let mut run = started(&joint, 1e-12, &RATTLE);
            run = run.with_tangents(4, 0).unwrap();
            run.start(0.0, &RATTLE).unwrap();
            let mut unit = vec![0.0; 16];
            (0..4).for_each(|c| unit[c * 4 + c] = 1.0);
            run.set_tangent_vectors(&unit).unwrap();
            run.integrate_to(end).unwrap();
            let vectors = run.tangent_vectors().unwrap();
            assert!(run.stats().crossings > 4, "{:?}", run.stats());
            // Displacements and velocities in comparable units.
            let unit = |c: usize| if c < 2 { 1.0 } else { 4e4 };
            let mut worst = 0.0_f64;
            let mut largest = 0.0_f64;
            for l in 0..4 {
                let step = 1e-11 * unit(l);
                let ends = [-2.0, -1.0, 1.0, 2.0].map(|k| {
                    let mut z = RATTLE;
                    z[l] += k * step;
                    let mut run = started(&joint, 1e-12, &z);
                    run.integrate_to(end).unwrap();
                    run.state().to_vec()
                });
                for c in 0..4 {
                    let [a, b, d, e] = [0, 1, 2, 3].map(|k: usize| ends[k][c]);
                    let slope = (8.0 * (d - b) - (e - a)) / (12.0 * step);
                    let scale = unit(l) / unit(c);
                    worst = worst.max((slope - vectors[c * 4 + l]).abs() * scale);
                    largest = largest.max(slope.abs() * scale);
                }
            }
            assert!(
                worst < 1e-5 * largest,
                "{damping:?}: {worst:e} of {largest:e}"
            );
        }
    }
}

/// The change of energy is the work over many events, and the dashpot only dissipates.
#[test]
fn the_audit_closes_across_events() {
    for damping in STRONG {
        for friction in [Friction::None, STRIBECK] {
            let joint = rattling(friction, damping).with_audit();
            let start = [RATTLE.as_slice(), &[0.0]].concat();
            let mut run = started(&joint, 1e-11, &start);
            let energy = joint.energy(&start).total();
            let mut z = start;
            for k in 1..=100 {
                run.sample(3e-6 * f64::from(k), &mut z).unwrap();
                let change = joint.energy(&z).total() - energy;
                assert!(
                    (change - z[4]).abs() < 1e-8 * energy,
                    "{change:e} {:e}",
                    z[4]
                );
                assert!(joint.power(&z).contact_damping <= 0.0);
            }
            assert!(run.stats().crossings > 4 && z[4].abs() > 1e-3 * energy);
        }
    }
}
