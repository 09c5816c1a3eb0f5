//! Short cost studies.

use super::*;

fn run_study(scene: &str, setting: CostSetting) -> CostStudy {
    let plan = CostPlan {
        settings: vec![setting],
        repeats: 1,
        horizon: 1e-3,
        ..CostPlan::new(Scene::load(scene).unwrap())
    };
    cost(&plan, &mut |_| true).unwrap().unwrap()
}

/// Errors of a family's points.
fn errors(study: &CostStudy, family: &str) -> Vec<f64> {
    let set = study.sets.iter().find(|set| set.family == family).unwrap();
    set.points
        .iter()
        .map(|point| *point.error.as_ref().unwrap())
        .collect()
}

#[test]
fn tighter_tolerances_need_more_evaluations_and_are_more_accurate() {
    let study = run_study("torus-3deg", CostSetting::Integrator);
    assert_eq!(study.sets.len(), crate::dynamics::MethodName::ALL.len());
    for set in &study.sets {
        let floor = set.floor.unwrap();
        assert!(floor < 1e-7, "{}: {floor}", set.family);
        let found = errors(&study, &set.family);
        let (first, last) = (found[0], found[found.len() - 1]);
        // The largest fixed steps are close to the stability limit.
        assert!(last < 1e-4 * first.max(1e-3), "{}: {found:?}", set.family);
        // One point per decade; the loosest tolerances are not monotonic.
        let decades = set.points.iter().step_by(2);
        let rhs_evals: Vec<u64> = decades.map(|point| point.rhs_evals).collect();
        assert!(rhs_evals.is_sorted(), "{}: {rhs_evals:?}", set.family);
        assert!(set.points.iter().all(|point| point.seconds > 0.0));
    }
    let advised = &study.advice;
    assert_eq!(advised.len(), TARGETS.len());
    for (advice, target) in advised.iter().zip(TARGETS) {
        assert!(advice.target == target && advice.error <= target);
    }
}

#[test]
fn more_nodes_reduce_the_error() {
    let study = run_study("torus-3deg", CostSetting::Nodes);
    let [rings, gauss] = ["rings", "gauss"].map(|family| errors(&study, family));
    for found in [&rings, &gauss] {
        assert!(found[7] < 0.1 * found[0], "{found:?}");
    }
    // With a few rings the Gauss rule is exact for the load and for a uniform stiffness.
    assert!(gauss[1] < 0.2 * rings[1], "{gauss:?} {rings:?}");
}

#[test]
fn smaller_elements_and_higher_orders_reduce_the_error() {
    let study = run_study("torus-3deg", CostSetting::Elements);
    let finest = ["linear", "quadratic", "cubic", "quartic"].map(|order| {
        let found = errors(&study, &format!("{order} elements"));
        assert!(found.is_sorted_by(|a, b| a >= b), "{order}: {found:?}");
        found[found.len() - 1]
    });
    assert!(finest.is_sorted_by(|a, b| *a > 3.0 * b), "{finest:?}");
    assert!(finest[0] < 1e-2 && finest[3] < 1e-6, "{finest:?}");
    // No error is below that of the reference.
    for set in &study.sets {
        assert!(set.floor.unwrap() < finest[3], "{}", set.family);
    }
}

#[test]
fn mode_sets_are_nested_and_the_reference_has_all_modes() {
    let study = run_study("torus-3deg", CostSetting::Modes);
    let [frequency, rms] = &study.sets[..] else {
        panic!("two invariants");
    };
    let count = |set: &WorkPrecisionSet| {
        set.points
            .iter()
            .map(|p| p.value as usize)
            .collect::<Vec<_>>()
    };
    // In order of the published frequencies: B1, B2, T1, B3, A1, T2; with B4 the set is complete.
    assert_eq!(count(frequency), [2, 4, 5, 7, 8, 9]);
    let details: Vec<&str> = rms.points.iter().map(|p| &*p.detail).collect();
    assert_eq!(details[0], "1 bending pair");
    assert_eq!(details[5], "3 bending pairs, 2 torsion, 1 axial");
    for set in [frequency, rms] {
        let floor = set.floor.unwrap();
        assert!(floor < 1e-2, "{}: {floor}", set.family);
        assert!(set.points.iter().all(|point| point.rhs_evals > 0));
        // With one bending pair the squeak is different.
        assert!(*set.points[0].error.as_ref().unwrap() > 10.0 * floor);
    }
}

#[test]
fn averages_have_a_reference_error() {
    let study = run_study("impact-oscillator", CostSetting::Recurrence);
    for set in &study.sets {
        let floor = set.floor.unwrap();
        let longest = errors(&study, &set.family);
        assert!(floor < 0.1 && longest.len() == 6, "{}: {floor}", set.family);
    }
    let study = run_study("impact-oscillator", CostSetting::Exponents);
    for set in &study.sets {
        let found = errors(&study, &set.family);
        assert!(set.floor.unwrap() < found[found.len() - 1], "{found:?}");
        assert!(
            set.points
                .iter()
                .all(|point| point.detail.starts_with("λ1 "))
        );
    }
}

#[test]
fn chaos_shortens_the_horizon() {
    let exponent = |value: f64| {
        Some(Exponent {
            value,
            half_width: 1.0,
        })
    };
    assert_eq!(horizon(4e-3, exponent(1000.0)), 1e-3);
    assert_eq!(horizon(4e-3, exponent(50.0)), 4e-3);
    assert_eq!(horizon(4e-3, exponent(-5.0)), 4e-3);
    assert_eq!(horizon(4e-3, None), 4e-3);
}

#[test]
fn the_callback_stops_a_study() {
    let plan = CostPlan::new(Scene::load("torus-3deg").unwrap());
    assert_eq!(cost(&plan, &mut |_| false).unwrap(), None);
    let small = CostPlan::new(Scene::load("impact-oscillator").unwrap());
    assert!(
        !small.settings.contains(&CostSetting::Nodes)
            && small.settings.contains(&CostSetting::Events)
    );
}
