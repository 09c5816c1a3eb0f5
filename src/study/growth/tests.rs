//! Growth measured for real, shortly.

use super::*;
use crate::pipeline::message::Record;

fn sinks(_: &Scene) -> Result<Box<dyn Sink>, SinkError> {
    Ok(Box::new(Vec::<Record>::new()))
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
fn each_size_of_a_joint_is_measured() {
    let found = growth(&small("periodic-2deg"), &mut sinks, &mut |_, _| true);
    let found = found.unwrap().unwrap();
    let of = |size, work| {
        let growth = found.iter().find(|g| g.size == size && g.work == work);
        growth.unwrap_or_else(|| panic!("{size:?} {work:?}"))
    };
    let sizes = |growth: &Growth| growth.points.iter().map(|p| p.value).collect::<Vec<_>>();
    let nodes = of(Size::Nodes, Work::Call);
    assert_eq!(sizes(nodes), [64.0, 1024.0]);
    // Sixteen times the nodes: between four and forty times the work, on a machine however noisy.
    let exponent = nodes.exponent().unwrap();
    assert!((0.5..1.33).contains(&exponent), "{exponent}");
    assert_eq!(sizes(of(Size::Modes, Work::Call)), [2.0, 100.0]);
    assert!(of(Size::Modes, Work::Vibration).exponent().unwrap() > 0.2);
    // A joint of eleven modes has no thousand exponents.
    assert_eq!(sizes(of(Size::Exponents, Work::Vibration)), [1.0, 4.0]);
    let quantified = of(Size::Recurrence, Work::Quantification);
    assert!(quantified.exponent().unwrap() > 1.0);
    assert_eq!(sizes(of(Size::Threads, Work::Sweep)), [1.0, 2.0]);
    assert_eq!(sizes(of(Size::Duration, Work::Run)), [2e-3, 4e-3]);
    for point in found.iter().flat_map(|growth| &growth.points) {
        assert!(point.seconds > 0.0);
        assert!(cfg!(not(target_os = "linux")) || point.memory.unwrap() > 1 << 20);
    }
}

#[test]
fn a_scene_without_joint_has_neither_nodes_nor_modes() {
    let found = growth(&small("impact-oscillator"), &mut sinks, &mut |_, _| true);
    let sizes: Vec<Size> = found.unwrap().unwrap().iter().map(|g| g.size).collect();
    assert_eq!(sizes, [Size::Exponents, Size::Recurrence, Size::Duration]);
}

#[test]
fn it_stops_when_told() {
    let mut asked = 0;
    let stopped = growth(&small("periodic-2deg"), &mut sinks, &mut |_, _| {
        asked += 1;
        asked < 3
    });
    assert_eq!((stopped.unwrap(), asked), (None, 3));
}
