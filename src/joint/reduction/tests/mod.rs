//! Rules, their training, and joints with kept nodes only.

use std::sync::Arc;

use super::*;
use crate::dynamics::{Accuracy, Integrator, Method, System};
use crate::joint::{BallJoint, BodySpec, ImportedModes, Joint};

mod joints;
mod shipped;

use joints::named;

/// The ball joint of a name with its tilt.
fn ball(name: &str, nodes: usize) -> (BallJoint, f64) {
    let (spec, tilt) = named(name, nodes);
    (BallJoint::new(&spec).unwrap(), tilt)
}

/// A joint with all nodes and with the shipped rule of a size.
fn full_and_reduced(name: &str, nodes: usize, size: usize) -> [Joint; 2] {
    let (ball, tilt) = ball(name, nodes);
    let full = ball.joint(tilt).unwrap();
    let rules = shipped_rules(&ball.spec().contact).into_iter();
    let rule = rules
        .map(|shipped| shipped.rule)
        .find(|rule| rule.kept().len() == size);
    let ball = ball.with_reduction(rule.map(Arc::new)).unwrap();
    let reduced = ball.joint(tilt).unwrap();
    assert_eq!(reduced.contact_nodes(), size);
    [full, reduced]
}

/// The state after some time (s), with a small integration error.
fn after(joint: &Joint, start: &[f64], time: f64, relative: f64) -> Vec<f64> {
    let method = Method::Auto {
        accuracy: Accuracy {
            floor: 1e-12,
            ..Accuracy::relative(relative)
        },
        max_step: time,
    };
    let mut integrator = Integrator::new(method, joint).unwrap();
    integrator.start(joint, 0.0, start).unwrap();
    integrator.integrate_to(joint, time).unwrap();
    integrator.state().to_vec()
}

/// A state of the settled motion.
fn settled(joint: &Joint) -> Vec<f64> {
    let mut start = vec![0.0; joint.dim()];
    start[joint.modes()..2 * joint.modes()].fill(1e-4);
    after(joint, &start, 0.06, 1e-5)
}

/// `|a - b| / |b|` in the norm of the velocities `[omega q | dq/dt]`.
fn difference(joint: &Joint, a: &[f64], b: &[f64]) -> f64 {
    let m = joint.modes();
    let norm = |z: &dyn Fn(usize) -> f64| {
        let scaled = (0..2 * m).map(|i| z(i) * if i < m { joint.omega()[i] } else { 1.0 });
        scaled.map(|x| x * x).sum::<f64>().sqrt()
    };
    norm(&|i| a[i] - b[i]) / norm(&|i| b[i])
}

#[test]
fn rules_are_checked() {
    let kept = |node, weight| KeptNode { node, weight };
    let rule = CubatureRule::new(4, vec![kept(1, 1.5), kept(3, 2.5)]).unwrap();
    assert_eq!(CubatureRule::new(4, vec![]), Err(RuleError::Empty));
    for (node, weight) in [(0, 1.0), (1, 1.0), (4, 1.0), (2, 0.0), (2, f64::NAN)] {
        assert!(CubatureRule::new(4, vec![kept(1, 1.0), kept(node, weight)]).is_err());
    }
    let text = serde_json::to_string(&rule).unwrap();
    assert_eq!(serde_json::from_str::<CubatureRule>(&text).unwrap(), rule);
    assert!(serde_json::from_str::<CubatureRule>(&text.replace("1.5", "-1.5")).is_err());
    let other = ball("torus-3deg", 100)
        .0
        .with_reduction(Some(Arc::new(rule)));
    let (rule, patch) = (4, 100);
    assert_eq!(other.err(), Some(RuleError::OtherPatch { rule, patch }));
}

/// A rule with all nodes and weights of one changes nothing.
#[test]
fn the_full_rule_is_the_full_patch() {
    let (ball, tilt) = ball("torus-3deg", 20);
    let kept = (0..20).map(|node| KeptNode { node, weight: 1.0 });
    let rule = CubatureRule::new(20, kept.collect()).unwrap();
    let model = ball.model(tilt).unwrap();
    assert_eq!(model.reduced(&rule).unwrap(), model);
    let reduced = ball.with_reduction(Some(Arc::new(rule))).unwrap();
    assert_eq!(reduced.model(tilt).unwrap(), model);
}

/// Steady sliding is exactly stationary; load and area are those of the full patch; the static deflection
/// agrees within the stated error.
#[test]
fn equilibrium_is_preserved() {
    for size in [16, 24, 32] {
        let [full, reduced] = full_and_reduced("torus-3deg", 100, size);
        let mut rate = vec![1.0; reduced.dim()];
        reduced.rhs(0.0, &vec![0.0; reduced.dim()], &mut rate);
        assert!(rate.iter().all(|rate| *rate == 0.0));
        let (q, exact) = (&reduced.equilibrium().q, &full.equilibrium().q);
        let largest = exact.iter().fold(0.0_f64, |a, q| a.max(q.abs()));
        for (q, exact) in q.iter().zip(exact) {
            assert!((q - exact).abs() < 1e-5 * largest, "{size}: {q} {exact}");
        }
        let totals = |joint: &Joint| {
            let blocks = joint.nodes.blocks.iter();
            blocks.fold([0.0, 0.0], |[area, load], block| {
                let loads = (0..8).map(|k| block.area.0[k] * block.pre_stress.0[k]);
                [
                    area + block.area.0.iter().sum::<f64>(),
                    load + loads.sum::<f64>(),
                ]
            })
        };
        for (a, b) in totals(&full).iter().zip(totals(&reduced)) {
            assert!((a / b - 1.0).abs() < 1e-12, "{size}: {a} {b}");
        }
    }
}

/// Frequencies and growth rates of steady sliding at tilts of 0 to 8 degrees.
#[test]
fn growth_rates_agree() {
    for (size, tolerance) in [(16, 2e-5), (24, 3e-6), (32, 5e-7)] {
        let mut largest = 0.0_f64;
        for tilt in ["tilt-0", "tilt-1", "tilt-4", "tilt-8"] {
            let [full, reduced] = full_and_reduced(tilt, 100, size);
            let (full, reduced) = (
                full.linear_modes().unwrap(),
                reduced.linear_modes().unwrap(),
            );
            let scale = full
                .iter()
                .fold(0.0_f64, |a, mode| a.max(mode.growth.abs()));
            for (a, b) in full.iter().zip(&reduced) {
                // An overdamped mode has no frequency.
                let change = (a.frequency_hz - b.frequency_hz).abs();
                assert!(change <= tolerance * b.frequency_hz, "{a:?} {b:?}");
                largest = largest.max((a.growth - b.growth).abs() / scale);
                assert_eq!(a.unstable(), b.unstable());
            }
        }
        println!("{size} nodes: growth rates within {largest:.1e} of the largest");
        assert!(largest < tolerance, "{size}: {largest:e}");
    }
}

/// The state of `torus-3deg` after 4 ms of the settled motion.
#[test]
fn a_trajectory_agrees() {
    for (nodes, size, tolerance) in [
        (100, 16, 2.1e-5),
        (100, 24, 2e-6),
        (100, 32, 1e-6),
        // Of the Gauss nodes some are near the rim, where they separate.
        (1000, 24, 1e-4),
        (1000, 32, 3e-5),
        (1000, 48, 2e-5),
    ] {
        let [full, reduced] = full_and_reduced("torus-3deg", nodes, size);
        let start = settled(&full_and_reduced("torus-3deg", 100, size)[0]);
        let exact = after(&full, &start, 4e-3, 1e-9);
        let error = difference(&full, &after(&reduced, &start, 4e-3, 1e-9), &exact);
        println!("{size} of {nodes} nodes: state after 4 ms {error:.1e}");
        assert!(error < tolerance, "{size} of {nodes}: {error:e}");
    }
}

/// A rule trained for one joint and one tilt is more accurate there than a shipped one.
#[test]
fn a_rule_for_one_joint_is_repeatable_and_accurate() {
    let (ball, tilt) = ball("torus-3deg", 100);
    let plan = TrainingPlan::new(2e-5, tilt, tilt);
    let trained = train(&ball, &plan).unwrap();
    assert_eq!(train(&ball, &plan).unwrap(), trained);
    assert!(trained.held_out.rms <= 2e-5 && trained.rule.kept().len() <= 24);
    assert!(trained.rule.kept().len().is_multiple_of(8));
    let full = ball.joint(tilt).unwrap();
    let reduced = ball
        .with_reduction(Some(Arc::new(trained.rule.clone())))
        .unwrap();
    let reduced = reduced.joint(tilt).unwrap();
    let start = settled(&full);
    let exact = after(&full, &start, 4e-3, 1e-9);
    let error = difference(&full, &after(&reduced, &start, 4e-3, 1e-9), &exact);
    println!(
        "{} of 100 nodes, trained at 3 deg: held-out {:.1e}, state after 4 ms {error:.1e}",
        trained.rule.kept().len(),
        trained.held_out.rms
    );
    assert!(error < 1e-6, "{error:e}");
}

/// The change of energy of the reduced joint is the work of friction, with and without separation.
#[test]
fn energy_balance_closes() {
    for name in ["torus-3deg", "lift-off"] {
        let reduced = full_and_reduced(name, 100, 32)[1].clone().with_audit();
        let m = reduced.modes();
        let mut start = vec![0.0; reduced.dim()];
        start[m..2 * m].fill(5e-3);
        let end = after(&reduced, &start, 4e-3, 1e-10);
        let [before, later] = [&start, &end].map(|z| reduced.energy(z).total());
        let (change, work) = (later - before, end[2 * m]);
        assert!(
            (change - work).abs() < 1e-7 * (before + later),
            "{name}: {change} {work}"
        );
    }
}

/// The certificate of a separating scene: the separated area is represented, and the error is seen.
#[test]
fn separation_is_represented() {
    let [full, reduced] = full_and_reduced("lift-off", 100, 40);
    let mut checker = ForceChecker::new(full.clone());
    let mut errors = ReductionErrors::default();
    let mut start = settled(&full);
    let mut separated = 0;
    for _ in 0..400 {
        start = after(&full, &start, 5e-5, 1e-5);
        let check = checker.check(&reduced, &start);
        separated += u32::from(check.separated > 0.0);
        errors.add(&check);
    }
    println!("lift-off with 40 nodes: {errors:?}, separated {separated} times");
    assert!(separated > 40);
    assert!(errors.rms < 1e-3 && errors.max_separated_difference < 0.1);
    assert!(!errors.within(1e-5));
}

#[test]
fn errors_are_accumulated() {
    let mut errors = ReductionErrors::default();
    assert!(!errors.within(1.0));
    for (relative_error, separated) in [(3e-5, 0.0), (4e-5, 0.1)] {
        errors.add(&ForceCheck {
            relative_error,
            separated,
            separated_kept: 0.0,
        });
    }
    assert_eq!((errors.checks, errors.missed_separations), (2, 1));
    assert!((errors.rms - 12.5e-10_f64.sqrt()).abs() < 1e-18 && errors.max == 4e-5);
    let text = serde_json::to_string(&errors).unwrap();
    assert_eq!(
        serde_json::from_str::<ReductionErrors>(&text).unwrap(),
        errors
    );
    assert!(errors.within(3.6e-5) && !errors.within(3.5e-5));
    errors.add(&ForceCheck {
        relative_error: f64::NAN,
        ..ForceCheck::default()
    });
    assert!(!errors.within(1.0));
}

/// A stiff contact, which the shipped rules do not fit: the certificate shows it, and a rule is trained.
#[test]
fn a_joint_that_the_rules_do_not_fit_is_trained() {
    let [full, reduced] = full_and_reduced("stiffness-20", 100, 32);
    let check = ForceChecker::new(full.clone()).check(&reduced, &settled(&full));
    println!("stiffness factor 20 with the shipped rule: {check:?}");
    assert!(check.relative_error > 1e-3);
    let (stiff, tilt) = ball("stiffness-20", 100);
    let plan = TrainingPlan::new(5e-3, tilt, tilt);
    let (trained, source) = reduce(&stiff, &plan).unwrap();
    println!(
        "trained: {} nodes, {:?}",
        trained.rule.kept().len(),
        trained.held_out
    );
    assert_eq!(source, RuleSource::Trained);
    let strict = TrainingPlan::new(1e-9, tilt, tilt);
    assert!(matches!(
        reduce(&stiff, &strict),
        Err(TrainingError::Tolerance { .. })
    ));
    let (fits, tilt) = ball("periodic-2deg", 100);
    let (_, source) = reduce(&fits, &TrainingPlan::new(1e-4, tilt, tilt)).unwrap();
    assert_eq!(source, RuleSource::Shipped);
}

/// States at which a rule is inaccurate are added to the training.
#[test]
fn additional_states_improve_a_rule() {
    let (ball, tilt) = ball("torus-3deg", 100);
    let joint = ball.joint(tilt).unwrap();
    let large = Excitation {
        kicks: vec![1.5],
        duration: 2e-4,
        states: 2,
        seed: 11,
    };
    let state = large.states_of(&joint).unwrap().swap_remove(1);
    let case = [TrainingCase {
        joint,
        states: vec![state.clone()],
        weight: 1.0,
    }];
    let mut plan = TrainingPlan::new(1e-4, tilt, tilt);
    let before = errors_of(&train(&ball, &plan).unwrap().rule, &case);
    plan.additional = vec![(tilt, state); 20];
    let after = errors_of(&train(&ball, &plan).unwrap().rule, &case);
    assert!(after.rms < 0.5 * before.rms, "{before:?} {after:?}");
}

/// A joint with imported modes.
#[test]
fn imported_modes_are_reduced() {
    let (source, tilt) = ball("torus-3deg", 200);
    let model = source.full_model(tilt).unwrap();
    let imported = imported(&model);
    let mut spec = source.spec().clone();
    spec.body = BodySpec::Imported(Arc::new(imported));
    spec.contact.stiffness_factor = 1.0;
    spec.contact.quadrature = crate::joint::Quadrature::Gauss;
    let ball = BallJoint::new(&spec).unwrap();
    let full = ball.joint(tilt).unwrap();
    let (trained, source) = reduce(&ball, &TrainingPlan::new(1e-4, tilt, tilt)).unwrap();
    assert_eq!(source, RuleSource::Trained);
    let reduced = ball.with_reduction(Some(Arc::new(trained.rule))).unwrap();
    assert_eq!(reduced.full_model(tilt).unwrap().nodes(), 200);
    let reduced = reduced.joint(tilt).unwrap();
    assert!(reduced.contact_nodes() <= 24);
    let check = ForceChecker::new(full.clone()).check(&reduced, &settled(&full));
    assert!(check.relative_error < 1e-3, "{check:?}");
}

/// Imported modes with the arrays of a model.
fn imported(model: &crate::joint::Model) -> ImportedModes {
    use crate::numpy::{Array, encode_npz};
    let (n, m) = (model.nodes(), model.modes());
    let vectors = |all: &[[f64; 3]]| Array::matrix(n, all.as_flattened().to_vec());
    let shapes = (0..n).flat_map(|k| {
        let at = model.shapes_at(k);
        (0..3).flat_map(move |axis| at.iter().map(move |shape| shape[axis]))
    });
    let arrays = [
        ("positions", vectors(&model.positions)),
        ("normals", vectors(&model.normals)),
        ("areas", Array::vector(model.areas.clone())),
        ("pre_stress", Array::vector(model.pre_stress.clone())),
        ("stiffness", Array::vector(model.stiffness.clone())),
        (
            "shapes",
            Array {
                shape: vec![n, 3, m],
                values: shapes.collect(),
            },
        ),
        ("omega", Array::vector(model.omega.clone())),
    ];
    let file = tempfile::NamedTempFile::new().unwrap();
    encode_npz(std::fs::File::create(file.path()).unwrap(), &arrays).unwrap();
    ImportedModes::read(file.path(), "model.npz").unwrap()
}
