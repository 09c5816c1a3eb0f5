//! A recording of synthetic work-precision diagrams, read back from the file.

use super::*;
use crate::{record::tests::read, scene::Scene};

fn point(value: f64, rhs_evals: u64, error: Result<f64, &str>) -> WorkPrecisionPoint {
    WorkPrecisionPoint {
        value,
        seconds: 1e-3 * value.log10().abs(),
        rhs_evals,
        error: error.map_err(str::to_owned),
        detail: String::new(),
    }
}

fn plan() -> CostPlan {
    CostPlan::new(Scene::load("torus-3deg").unwrap())
}

/// A setting with evaluations, recommendations and a failed run, and one without any of these.
fn study() -> CostStudy {
    let set = |setting, family: &str, parameter: &'static str, floor, points| WorkPrecisionSet {
        setting,
        family: family.to_owned(),
        parameter: parameter.into(),
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
        point(6.4e-6, 2500, Err("the solution diverged")),
    ];
    let elements = vec![point(40.0, 0, Ok(1e-4)), point(8.0, 0, Ok(0.0))];
    let integrator = CostSetting::Integrator;
    let sets = vec![
        set(
            CostSetting::Elements,
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
        fixed_at: Default::default(),
        horizon: 4e-3,
        exponent: None,
        stopped: false,
        budget: None,
        advice: crate::study::cost::advice(&sets),
        sets,
    }
}

#[test]
fn settings_have_a_fixed_order() {
    let names: Vec<CostSetting> = settings(&study())
        .iter()
        .map(|(setting, _)| *setting)
        .collect();
    assert_eq!(names, [CostSetting::Integrator, CostSetting::Elements]);
}

#[test]
fn a_recording_contains_every_setting() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cost.rrd");
    save_cost(&path, &plan(), &study(), "squeakscope cost").unwrap();
    let (entities, blueprint) = read(&path, paths::TIMELINE);
    assert!(blueprint > 10, "the blueprint has {blueprint} chunks");
    let integrator = Root::of_setting("integrator");
    for picture in [paths::COST_CPU_TIME, paths::COST_RHS_EVALS] {
        for path in [
            "axes/lines",
            "axes/labels",
            "legend",
            "reference_error",
            "recommended",
            "curves/lawson54",
            "points/lawson54",
            "points/rk4",
            "failed/rk4",
            "failed/rk4/label",
        ] {
            let path = format!("{picture}/{path}");
            let entity = &entities[&integrator.at(&path)];
            assert_eq!(entity.rows, 0, "{path} is static");
        }
        let failed = integrator.at(&format!("{picture}/failed/lawson54"));
        assert!(
            !entities.contains_key(&failed),
            "lawson54 has no failed run"
        );
    }
    // The viewer's tooltip lists at most three components; the labels must be among them.
    for (path, shape) in [
        ("cpu_time/points/rk4", "positions"),
        ("cpu_time/failed/rk4", "strips"),
    ] {
        let components = &entities[&integrator.at(path)].components;
        assert_eq!(components.len(), 3, "{components:?}");
        for name in [shape, "colors", "labels"] {
            let found = components.iter().any(|component| component.contains(name));
            assert!(found, "{name}: {components:?}");
        }
    }
    let numbers = &entities[&integrator.at(&paths::cost_numbers("rk4"))];
    for name in ["setting", "cpu_ms", "rhs_evals", "error"] {
        let found = numbers.components.iter().any(|c| c.ends_with(name));
        assert!(found, "{name}: {:?}", numbers.components);
    }
    let elements = Root::of_setting("elements");
    let of_elements = |path: &str| entities.contains_key(&elements.at(path));
    assert!(of_elements("cpu_time/points/quadratic_elements"));
    assert!(!of_elements("rhs_evals/points/quadratic_elements"));
    assert!(!of_elements("cpu_time/reference_error"));
    for root in [&integrator, &elements] {
        assert!(entities.contains_key(&root.at(paths::SETTING_TEXT)));
    }
    assert!(entities.contains_key(paths::ABOUT));
    let run = entities
        .keys()
        .find(|path| path.ends_with(paths::RUN_PROPERTY));
    assert!(run.is_some(), "versions, scene and command");
    // The part file was removed.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn plots_of_a_setting_share_their_error_axis() {
    let study = study();
    let integrator = pictures(&study, CostSetting::Integrator);
    let [time, rhs_evals] = &integrator[..] else {
        panic!("two pictures");
    };
    assert_eq!(
        time.panel.y, rhs_evals.panel.y,
        "both plots have the same error axis"
    );
    assert_eq!(rhs_evals.panel.x.range, [2000.0, 1e4]);
    // The decade above the errors is for failed runs.
    assert_eq!(time.panel.y.range, [1e-10, 1e-1]);
    // A zero error does not extend the axis: it is drawn at its lower end.
    let elements = pictures(&study, CostSetting::Elements);
    let [time] = &elements[..] else {
        panic!("one picture");
    };
    assert_eq!(time.panel.y.range, [1e-4, 1e-3]);
    let plot = time.view.plot(&time.panel);
    assert_eq!(plot.at(1.0, 0.0)[1], plot.height);
}

#[test]
fn the_text_has_settings_and_recommendations() {
    let study = study();
    let text = words::setting(&study, CostSetting::Integrator);
    for part in [
        "| 1e-4 | lawson54, tolerance 1e-4 | 4 | 4000 | 2.0e-5 |",
        "squeakscope cost test --write",
        "| 6.4e-6 | 5.19 | 2500 | failed: the solution diverged |",
        "Method and tolerance",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let text = words::setting(&study, CostSetting::Elements);
    assert!(
        text.contains("| 40 | 1.6 | – | 1.0e-4 |") && !text.contains("Recommended"),
        "{text}"
    );
    let settings = [CostSetting::Integrator, CostSetting::Elements];
    let about = words::about(&study, &settings);
    assert!(
        about.contains("over 4 ms") && about.contains("**elements**"),
        "{about}"
    );
}

#[test]
fn an_unwritable_path_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let error = save_cost(folder.path(), &plan(), &study(), "").unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}
