//! Knobs turned for real, shortly.

use super::*;

fn turned(scene: &str, knob: Knob) -> CostStudy {
    let plan = CostPlan {
        knobs: vec![knob],
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
fn tighter_tolerances_cost_calls_and_bring_accuracy() {
    let study = turned("torus-3deg", Knob::Integrator);
    assert_eq!(study.sets.len(), crate::dynamics::MethodName::ALL.len());
    for set in &study.sets {
        let floor = set.floor.unwrap();
        assert!(floor < 1e-7, "{}: {floor}", set.family);
        let found = errors(&study, &set.family);
        let (first, last) = (found[0], found[found.len() - 1]);
        // The steps of a fixed method go up to where it is hardly stable.
        assert!(last < 1e-4 * first.max(1e-3), "{}: {found:?}", set.family);
        // From one decade to the next; the loosest are coarse.
        let decades = set.points.iter().step_by(2);
        let calls: Vec<u64> = decades.map(|point| point.calls).collect();
        assert!(calls.is_sorted(), "{}: {calls:?}", set.family);
        assert!(set.points.iter().all(|point| point.seconds > 0.0));
    }
    let advised = &study.advice;
    assert_eq!(advised.len(), TARGETS.len());
    for (advice, target) in advised.iter().zip(TARGETS) {
        assert!(advice.target == target && advice.error <= target);
    }
}

#[test]
fn more_nodes_come_nearer() {
    let study = turned("torus-3deg", Knob::Nodes);
    for family in ["rings", "gauss"] {
        let found = errors(&study, family);
        let set = study.sets.iter().find(|set| set.family == family).unwrap();
        assert!(found[7] < 0.1 * found[0], "{family}: {found:?}");
        // Rings down to what the two references differ by, which are of rings.
        let floor = set.floor.unwrap();
        assert!(family != "rings" || found[7] < 20.0 * floor, "{found:?}");
    }
}

#[test]
fn smaller_elements_and_higher_orders_come_nearer() {
    let study = turned("torus-3deg", Knob::Elements);
    let finest = ["linear", "quadratic", "cubic", "quartic"].map(|order| {
        let found = errors(&study, &format!("{order} elements"));
        assert!(found.is_sorted_by(|a, b| a >= b), "{order}: {found:?}");
        found[found.len() - 1]
    });
    assert!(finest.is_sorted_by(|a, b| *a > 3.0 * b), "{finest:?}");
    assert!(finest[0] < 1e-2 && finest[3] < 1e-6, "{finest:?}");
    // Nothing is told below the reference's own error.
    for set in &study.sets {
        assert!(set.floor.unwrap() < finest[3], "{}", set.family);
    }
}

#[test]
fn sets_of_modes_are_nested_and_all_modes_are_the_reference() {
    let study = turned("torus-3deg", Knob::Modes);
    let [frequency, rms] = &study.sets[..] else {
        panic!("two invariants");
    };
    let count = |set: &CostSet| {
        set.points
            .iter()
            .map(|p| p.value as usize)
            .collect::<Vec<_>>()
    };
    // The published frequencies in their order: B1, B2, T1, B3, A1, T2; with B4 they are all eleven.
    assert_eq!(count(frequency), [2, 4, 5, 7, 8, 9]);
    let details: Vec<&str> = rms.points.iter().map(|p| &*p.detail).collect();
    assert_eq!(details[0], "1 bending pair");
    assert_eq!(details[5], "3 bending pairs, 2 torsion, 1 axial");
    for set in [frequency, rms] {
        let floor = set.floor.unwrap();
        assert!(floor < 1e-2, "{}: {floor}", set.family);
        assert!(set.points.iter().all(|point| point.calls > 0));
        // One pair is another squeak.
        assert!(*set.points[0].error.as_ref().unwrap() > 10.0 * floor);
    }
}

#[test]
fn averages_have_the_error_of_their_own_references() {
    let study = turned("impact-oscillator", Knob::Recurrence);
    for set in &study.sets {
        let floor = set.floor.unwrap();
        let longest = errors(&study, &set.family);
        assert!(floor < 0.1 && longest.len() == 6, "{}: {floor}", set.family);
    }
    let study = turned("impact-oscillator", Knob::Exponents);
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
fn what_is_told_to_stop_stops() {
    let plan = CostPlan::new(Scene::load("torus-3deg").unwrap());
    assert_eq!(cost(&plan, &mut |_| false).unwrap(), None);
    let small = CostPlan::new(Scene::load("impact-oscillator").unwrap());
    assert!(!small.knobs.contains(&Knob::Nodes) && small.knobs.contains(&Knob::Events));
}
