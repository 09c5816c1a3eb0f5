//! A recording of made-up work-precision sets, read back from the file.

use super::*;
use crate::{record::tests::read, scene::Scene};

fn point(value: f64, calls: u64, error: Result<f64, &str>) -> CostPoint {
    CostPoint {
        value,
        seconds: 1e-3 * value.log10().abs(),
        calls,
        error: error.map_err(str::to_owned),
        detail: String::new(),
    }
}

fn plan() -> CostPlan {
    CostPlan::new(Scene::load("torus-3deg").unwrap())
}

/// A knob with calls, advice and a failure, and one without any of these.
fn study() -> CostStudy {
    let set = |knob, family: &str, turned, floor, points| CostSet {
        knob,
        family: family.to_owned(),
        turned,
        floor,
        points,
    };
    let lawson = vec![
        point(1e-2, 2000, Ok(1e-2)),
        point(1e-4, 4000, Ok(2e-5)),
        point(1e-6, 8000, Ok(3e-7)),
    ];
    let rk4 = vec![
        point(1.6e-6, 9000, Ok(1e-3)),
        point(6.4e-6, 2500, Err("it blew up")),
    ];
    let elements = vec![point(40.0, 0, Ok(1e-4)), point(8.0, 0, Ok(0.0))];
    let integrator = Knob::Integrator;
    let sets = vec![
        set(
            Knob::Elements,
            "quadratic elements",
            "size, mm",
            None,
            elements,
        ),
        set(integrator, "lawson54", "tolerance", Some(1e-10), lawson),
        set(integrator, "rk4", "step, s", Some(1e-10), rk4),
    ];
    CostStudy {
        scene: "test".to_owned(),
        held: Default::default(),
        horizon: 4e-3,
        exponent: None,
        stopped: false,
        advice: crate::study::cost::advice(&sets),
        sets,
    }
}

#[test]
fn knobs_come_in_their_order() {
    let names: Vec<Knob> = knobs(&study()).iter().map(|(knob, _)| *knob).collect();
    assert_eq!(names, [Knob::Integrator, Knob::Elements]);
}

#[test]
fn a_recording_holds_every_knob() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cost.rrd");
    save_cost(&path, &plan(), &study(), "squeakscope cost").unwrap();
    let (entities, blueprint) = read(&path, paths::TIMELINE);
    assert!(blueprint > 10, "a blueprint is there: {blueprint} chunks");
    let integrator = Root::of_knob("integrator");
    for picture in [paths::COST_TIME, paths::COST_CALLS] {
        for path in [
            "axes/lines",
            "axes/labels",
            "key",
            "floor",
            "advised",
            "curves/lawson54",
            "points/lawson54",
            "points/rk4",
            "failed/rk4",
            "failed/rk4/words",
        ] {
            let path = format!("{picture}/{path}");
            let entity = &entities[&integrator.at(&path)];
            assert_eq!(entity.rows, 0, "{path} is static");
        }
        let failed = integrator.at(&format!("{picture}/failed/lawson54"));
        assert!(!entities.contains_key(&failed), "only what failed");
    }
    // The tooltip names no more than three components: the words must be among them.
    for (path, shape) in [
        ("time/points/rk4", "positions"),
        ("time/failed/rk4", "strips"),
    ] {
        let components = &entities[&integrator.at(path)].components;
        assert_eq!(components.len(), 3, "{components:?}");
        for name in [shape, "colors", "labels"] {
            let found = components.iter().any(|component| component.contains(name));
            assert!(found, "{name}: {components:?}");
        }
    }
    let numbers = &entities[&integrator.at(&paths::cost_numbers("rk4"))];
    for name in ["setting", "cpu_ms", "calls", "error"] {
        let found = numbers.components.iter().any(|c| c.ends_with(name));
        assert!(found, "{name}: {:?}", numbers.components);
    }
    let elements = Root::of_knob("elements");
    let of_elements = |path: &str| entities.contains_key(&elements.at(path));
    assert!(of_elements("time/points/quadratic_elements"));
    assert!(!of_elements("calls/points/quadratic_elements"));
    assert!(!of_elements("time/floor"));
    for root in [&integrator, &elements] {
        assert!(entities.contains_key(&root.at(paths::KNOB_WORDS)));
    }
    assert!(entities.contains_key(paths::ABOUT));
    let run = entities
        .keys()
        .find(|path| path.ends_with(paths::RUN_PROPERTY));
    assert!(run.is_some(), "versions, scene and command");
    // Only the recording is left.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn pictures_of_a_knob_share_their_axis_of_errors() {
    let study = study();
    let integrator = pictures(&study, Knob::Integrator);
    let [time, calls] = &integrator[..] else {
        panic!("two pictures");
    };
    assert_eq!(time.panel.y, calls.panel.y, "so that they can be compared");
    assert_eq!(calls.panel.x.range, [2000.0, 1e4]);
    // A decade above the errors is for what failed.
    assert_eq!(time.panel.y.range, [1e-10, 1e-1]);
    // An error of nothing does not stretch the axis: it is drawn at its lower end.
    let elements = pictures(&study, Knob::Elements);
    let [time] = &elements[..] else {
        panic!("one picture");
    };
    assert_eq!(time.panel.y.range, [1e-4, 1e-3]);
    let plot = time.view.plot(&time.panel);
    assert_eq!(plot.at(1.0, 0.0)[1], plot.height);
}

#[test]
fn settings_and_advice_are_told() {
    let study = study();
    let told = words::knob(&study, Knob::Integrator);
    for part in [
        "| 1e-4 | lawson54, tolerance 1e-4 | 4 | 4000 | 2.0e-5 |",
        "squeakscope cost test --write",
        "| 6.4e-6 | 5.19 | 2500 | failed: it blew up |",
        "Method and tolerance",
    ] {
        assert!(told.contains(part), "{part} in {told}");
    }
    let told = words::knob(&study, Knob::Elements);
    assert!(
        told.contains("| 40 | 1.6 | – | 1.0e-4 |") && !told.contains("cheapest"),
        "{told}"
    );
    let knobs = [Knob::Integrator, Knob::Elements];
    let about = words::about(&study, &knobs);
    assert!(
        about.contains("over 4 ms") && about.contains("**elements**"),
        "{about}"
    );
}

#[test]
fn a_recording_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let error = save_cost(folder.path(), &plan(), &study(), "").unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}
