//! Short growth studies.

use super::*;
use crate::pipeline::message::Record;
use crate::pipeline::{Monitor, run};

fn here(
    scene: &Scene,
    duration: f64,
    _: &mut dyn FnMut() -> bool,
) -> Result<Option<RunCost>, Cause> {
    let scene = scene.clone().with_duration(1e3 * duration)?;
    let mut records = Vec::<Record>::new();
    let summary = run(&scene, "", &mut records, Monitor::default())?;
    Ok(Some(RunCost {
        seconds: summary.wall,
        memory: peak_memory(),
    }))
}

fn small(scene: &str) -> GrowthPlan {
    GrowthPlan {
        repeats: 1,
        nodes: vec![64, 1024],
        modes: vec![[1, 0, 0], [34, 16, 16]],
        exponents: vec![1, 4, 1000],
        states: vec![500, 2000],
        threads: vec![1, 2],
        durations: vec![2e-3, 4e-3],
        ..GrowthPlan::new(Scene::load(scene).unwrap(), 1)
    }
}

#[test]
fn every_size_of_a_joint_is_measured() {
    let found = growth(&small("periodic-2deg"), &mut here, &mut |_| true);
    let found = found.unwrap().0;
    let of = |size, work| {
        let growth = found.iter().find(|g| g.size == size && g.work == work);
        growth.unwrap_or_else(|| panic!("{size:?} {work:?}"))
    };
    let sizes = |growth: &Growth| growth.points.iter().map(|p| p.value).collect::<Vec<_>>();
    assert_eq!(sizes(of(Size::Nodes, Work::RhsEvaluation)), [64.0, 1024.0]);
    assert_eq!(sizes(of(Size::Nodes, Work::Vibration)), [64.0, 1024.0]);
    assert_eq!(sizes(of(Size::Modes, Work::RhsEvaluation)), [2.0, 100.0]);
    // A joint with eleven modes does not have 1000 exponents.
    assert_eq!(sizes(of(Size::Exponents, Work::Vibration)), [1.0, 4.0]);
    let quantified = of(Size::Recurrence, Work::Quantification);
    assert_eq!(sizes(quantified), [500.0, 2000.0]);
    assert_eq!(sizes(of(Size::Threads, Work::Sweep)), [1.0, 2.0]);
    assert_eq!(sizes(of(Size::Duration, Work::Run)), [2e-3, 4e-3]);
    let run = of(Size::Duration, Work::Run);
    assert!(cfg!(not(target_os = "linux")) || run.points[0].memory.is_some());
    for point in found.iter().flat_map(|growth| &growth.points) {
        assert!(point.seconds > 0.0);
        assert!(point.memory.is_none_or(|bytes| bytes > 1 << 20));
    }
}

#[test]
fn a_scene_without_a_joint_has_no_node_or_mode_sizes() {
    let found = growth(&small("impact-oscillator"), &mut here, &mut |_| true);
    let sizes: Vec<Size> = found.unwrap().0.iter().map(|g| g.size).collect();
    assert_eq!(sizes, [Size::Recurrence, Size::Exponents, Size::Duration]);
}

#[test]
fn the_callback_stops_the_study() {
    let mut asked = 0;
    let stopped = growth(&small("periodic-2deg"), &mut here, &mut |_| {
        asked += 1;
        asked < 3
    });
    let (found, whole) = stopped.unwrap();
    assert_eq!((found.len(), whole, asked), (0, false, 3));
}

#[test]
fn the_exponent_is_fitted_to_the_larger_sizes() {
    let point = |value: f64, seconds| GrowthPoint {
        value,
        seconds,
        memory: None,
    };
    let mut growth = Growth {
        size: Size::Nodes,
        work: Work::RhsEvaluation,
        points: vec![point(1.0, 5.0)],
    };
    assert_eq!(growth.exponent(), None);
    growth
        .points
        .extend([point(10.0, 1.0), point(100.0, 1000.0)]);
    assert!((growth.exponent().unwrap() - 3.0).abs() < 1e-12);
}
