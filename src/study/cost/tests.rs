//! Knobs turned for real, shortly.

use super::*;

fn turned(scene: &str, knob: Knob) -> CostStudy {
    let plan = CostPlan {
        knobs: vec![knob],
        repeats: 1,
        horizon: 1e-3,
        ..CostPlan::new(Scene::load(scene).unwrap())
    };
    cost(&plan, &mut |_, _| true).unwrap().unwrap()
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
    assert_eq!(study.sets.len(), crate::scene::Method::ALL.len());
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
    let advised = advice(&study.sets);
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
    assert_eq!(cost(&plan, &mut |_, _| false).unwrap(), None);
    let small = CostPlan::new(Scene::load("impact-oscillator").unwrap());
    assert!(!small.knobs.contains(&Knob::Nodes) && small.knobs.contains(&Knob::Events));
}
