//! A recording of made-up work-precision sets, read back from the file.

use super::*;
use crate::record::tests::read;

fn setting(value: f64, calls: u64, error: Result<f64, &str>) -> SettingView {
    SettingView {
        value,
        seconds: 1e-3 * value.log10().abs(),
        calls,
        error: error.map_err(str::to_owned),
        detail: String::new(),
    }
}

/// A knob with calls, advice and a failure, and one without any of these.
fn cost() -> CostView {
    let family = |name: &str, turned, floor, settings| FamilyView {
        name: name.to_owned(),
        turned,
        floor,
        settings,
    };
    let lawson = vec![
        setting(1e-2, 2000, Ok(1e-2)),
        setting(1e-4, 4000, Ok(2e-5)),
        setting(1e-6, 8000, Ok(3e-7)),
    ];
    let rk4 = vec![
        setting(1.6e-6, 9000, Ok(1e-3)),
        setting(6.4e-6, 2500, Err("it blew up")),
    ];
    let elements = vec![setting(40.0, 0, Ok(1e-4)), setting(8.0, 0, Ok(0.0))];
    CostView {
        scene: "test".to_owned(),
        title: "A test".to_owned(),
        scene_text: "duration_ms = 1".to_owned(),
        command: "squeakscope cost test".to_owned(),
        held: Default::default(),
        horizon: 4e-3,
        knobs: vec![
            KnobView {
                name: "integrator",
                about: "Method and tolerance.",
                error: "largest error of the state",
                families: vec![
                    family("lawson54", "tolerance", Some(1e-10), lawson),
                    family("rk4", "step, s", Some(1e-10), rk4),
                ],
                advice: vec![AdviceView {
                    target: 1e-4,
                    family: "lawson54".to_owned(),
                    value: 1e-4,
                }],
            },
            KnobView {
                name: "elements",
                about: "Size of the finite elements.",
                error: "largest error of a natural frequency",
                families: vec![family("quadratic elements", "size, mm", None, elements)],
                advice: Vec::new(),
            },
        ],
    }
}

#[test]
fn a_recording_holds_every_knob() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cost.rrd");
    save_cost(&path, &cost()).unwrap();
    let (entities, blueprint) = read(&path, paths::TIMELINE);
    assert!(blueprint > 10, "a blueprint is there: {blueprint} chunks");
    let integrator = Root::of_knob("integrator");
    for picture in [paths::COST_TIME, paths::COST_CALLS] {
        for path in [
            paths::axis_lines(&paths::cost_axes(picture)),
            paths::axis_labels(&paths::cost_axes(picture)),
            paths::cost_key(picture),
            paths::cost_floor(picture),
            paths::cost_advised(picture),
            paths::cost_curve(picture, "lawson54"),
            paths::cost_points(picture, "lawson54"),
            paths::cost_points(picture, "rk4"),
            paths::cost_failed(picture, "rk4"),
            paths::cost_failed_words(picture, "rk4"),
        ] {
            let entity = &entities[&integrator.at(&path)];
            assert_eq!(entity.rows, 0, "{path} is static");
        }
        let failed = integrator.at(&paths::cost_failed(picture, "lawson54"));
        assert!(!entities.contains_key(&failed), "only what failed");
    }
    // The tooltip names no more than three components: the words must be among them.
    for (path, shape) in [
        (paths::cost_points(paths::COST_TIME, "rk4"), "positions"),
        (paths::cost_failed(paths::COST_TIME, "rk4"), "strips"),
    ] {
        let components = &entities[&integrator.at(&path)].components;
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
    let family = "quadratic elements";
    let of_elements = |path: String| entities.contains_key(&elements.at(&path));
    assert!(of_elements(paths::cost_points(paths::COST_TIME, family)));
    assert!(!of_elements(paths::cost_points(paths::COST_CALLS, family)));
    assert!(!of_elements(paths::cost_floor(paths::COST_TIME)));
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
fn axes_hold_all_points_and_leave_room_for_words() {
    let cost = cost();
    let [integrator, elements] = [0, 1].map(|k| Scope::new(&cost.knobs[k]));
    let [time, calls] = &integrator.pictures[..] else {
        panic!("two pictures");
    };
    assert_eq!(time.plot.y, calls.plot.y, "so that they can be compared");
    assert_eq!((calls.plot.x.low, calls.plot.x.high), (2.0, 10.0));
    // A decade below the floor for its words, one above the errors for what failed.
    assert_eq!((time.plot.y.low, time.plot.y.high), (1e-11, 1e-1));
    // An error of nothing does not stretch the axis.
    let [time] = &elements.pictures[..] else {
        panic!("one picture");
    };
    assert_eq!((time.plot.y.low, time.plot.y.high), (1e-4, 1e-3));
    assert_eq!(time.plot.at(1.0, 0.0)[1], time.plot.height);
}

#[test]
fn settings_and_advice_are_told() {
    let cost = cost();
    let [integrator, elements] = &cost.knobs[..] else {
        panic!("two knobs");
    };
    let of = |family: usize, k: usize| {
        let family = &integrator.families[family];
        words::point(family, &family.settings[k])
    };
    assert_eq!(
        of(0, 1),
        "tolerance 1e-4: error 2.0e-5, 4 ms of CPU, 4000 calls"
    );
    assert_eq!(
        of(1, 1),
        "step 6.4e-6 s: failed, 5.19 ms of CPU, 2500 calls; it blew up"
    );
    let told = words::knob(&cost, integrator);
    for part in [
        "| 1e-4 | lawson54, tolerance 1e-4 | 4 | 4000 | 2.0e-5 |",
        "squeakscope cost test --write",
        "| 6.4e-6 | 5.19 | 2500 | failed |",
        "Method and tolerance.",
    ] {
        assert!(told.contains(part), "{part} in {told}");
    }
    let told = words::knob(&cost, elements);
    assert!(
        told.contains("| 40 | 1.6 | – | 1.0e-4 |") && !told.contains("cheapest"),
        "{told}"
    );
    let about = words::about(&cost);
    assert!(
        about.contains("over 4 ms") && about.contains("**elements**"),
        "{about}"
    );
}

#[test]
fn a_recording_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let error = save_cost(folder.path(), &cost()).unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}
