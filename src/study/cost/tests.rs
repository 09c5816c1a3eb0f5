use std::sync::LazyLock;

use super::settings::{adaptive, finest, levels, verified, with};
use super::*;
use crate::scene::PRESETS;
use crate::study::response::{ResponsePlan, response};
use crate::study::{Stopped, Trial};

#[test]
fn the_error_falls_with_the_tolerance() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let mut go_on = |_: f64, _: &str| Ok(());
    let mut runner = Runner::settle(&scene, &mut go_on).unwrap();
    let own = adaptive(&scene).unwrap();
    let mut motion = |tolerance: f64| {
        let varied = with(&own, Setting::Tolerance, tolerance).unwrap();
        runner.motion(&varied, 0).unwrap()
    };
    let reference = motion(1e-9);
    let errors = [1e-3, 1e-4, 1e-5, 1e-6].map(|tolerance| motion(tolerance).difference(&reference));
    assert!(errors[0] > 1e-5 && errors[0] < 1e-2, "{errors:?}");
    assert!(errors[1] < 0.3 * errors[0], "{errors:?}");
    assert!(errors[2] < 0.3 * errors[1], "{errors:?}");
    assert!(errors[3] < errors[2], "{errors:?}");
}

/// A small system, which has neither nodes nor elements; its complete runs are short.
fn belt() -> Scene {
    let set = [("time.duration_ms", "100"), ("time.sample_rate_khz", "20")];
    let scene = Scene::load("mass-on-belt").unwrap();
    scene.with_overrides(&set).unwrap()
}

/// The study of this system.
pub(crate) static OF_THE_BELT: LazyLock<Cost> =
    LazyLock::new(|| cost(&belt(), None, &mut |_, _| Ok(())).unwrap());

#[test]
fn a_small_system_is_studied() {
    let study = &*OF_THE_BELT;
    assert_eq!(study.settings.len(), 6);
    assert!(
        study
            .settings
            .iter()
            .all(|set| set.setting == Setting::Tolerance)
    );
    let points = || study.settings.iter().flat_map(|set| &set.points);
    assert!(points().all(|p| p.failed.is_none() && p.cpu_s > 0.0 && p.rhs_evals_per_s > 0.0));
    assert_eq!(study.choices.len(), 2 * TARGETS.len());
    assert!(
        study.choices.iter().all(|choice| choice.is_met),
        "{:?}",
        study.choices
    );
    assert!(study.run_cpu_s_per_s > Some(0.0) && !study.stopped);
    crate::report::agreement::check(study, &[]);
}

/// The verified error is that of a run of the scene file with the finer settings.
#[test]
fn the_verified_error_is_that_of_a_finer_run() {
    let scene = Scene::load("impact-oscillator").unwrap();
    let mut go_on = |_: f64, _: &str| Ok(());
    let mut runner = Runner::settle(&scene, &mut go_on).unwrap();
    let variant = with(&adaptive(&scene).unwrap(), Setting::Tolerance, 1e-6).unwrap();
    let choice = verified(&mut runner, [1e-2, 0.0], Origin::Cheapest, &variant).unwrap();
    let measure = |tolerance: &str| {
        let set = [("time.tolerance", tolerance)];
        let scene = scene.with_overrides(&set).unwrap().without_analyses();
        let plan = ResponsePlan {
            exponents: 1,
            max_rhs_evals: None,
            ..runner.plan
        };
        let trial = Trial::of_scene(scene).unwrap();
        let found = response(trial, runner.settled.as_ref(), &plan, &mut || Ok(()));
        found.unwrap()
    };
    let [coarse, fine] = ["1e-6", "3e-7"].map(measure);
    let mut errors = vec![(coarse.rms_velocity_m_per_s / fine.rms_velocity_m_per_s - 1.0).abs()];
    if choice.error != errors[0] {
        let [coarse, fine] = [&coarse.lines[0], &fine.lines[0]];
        errors.push((coarse.frequency / fine.frequency - 1.0).abs());
        errors.push((coarse.amplitude / fine.amplitude - 1.0).abs());
    }
    assert_eq!(choice.error, errors.iter().copied().fold(0.0, f64::max));
    assert!(choice.error > 0.0);
}

#[test]
fn only_effects_that_are_on_are_listed() {
    let named = |name: &str, set: &[(&str, &str)]| -> Vec<String> {
        let scene = Scene::load(name).unwrap().with_overrides(set).unwrap();
        let effects = effects::effects_of(&scene).into_iter();
        effects.map(|(_, effect, _)| effect.name).collect()
    };
    let plain = named("doubled-torus-3deg", &[]);
    let has = |names: &[String], name: &str| names.iter().any(|other| other == name);
    assert!(
        has(&plain, "separation of nodes") && has(&plain, "spectrum"),
        "{plain:?}"
    );
    for off in ["contact damping", "memory of friction", "moving patch"] {
        assert!(!has(&plain, off), "{off}: {plain:?}");
    }
    let damped = named(
        "doubled-torus-3deg",
        &[
            ("contact_damping.law", "kelvin-voigt"),
            ("contact_damping.retardation_time_us", "0.1"),
        ],
    );
    assert!(has(&damped, "contact damping"), "{damped:?}");
    assert_eq!(damped.len(), plain.len() + 1);
    let bonded = named("doubled-torus-3deg", &[("contact.unilateral", "false")]);
    assert!(!has(&bonded, "separation of nodes"), "{bonded:?}");
    assert!(has(&named("bristles", &[]), "memory of friction"));
}

#[test]
fn a_scene_at_rest_has_one_clear_error() {
    let set = [("start.kick_mm_per_s", "0")];
    let scene = Scene::load("doubled-torus-3deg")
        .unwrap()
        .with_overrides(&set);
    let refused = cost(&scene.unwrap(), None, &mut |_, _| Ok(())).unwrap_err();
    assert!(matches!(refused, StudyError::AtRest), "{refused}");
}

#[test]
fn a_stopped_study_has_what_is_complete() {
    let scene = belt();
    let stopped = cost(&scene, None, &mut |_, _| Err(Stopped)).unwrap_err();
    assert!(matches!(stopped, StudyError::Stopped(_)));
    // The tolerances of the first method are complete at a share of 0.16.
    let part = cost(&scene, None, &mut |share, _| {
        if share < 0.15 { Ok(()) } else { Err(Stopped) }
    })
    .unwrap();
    assert!(part.stopped && part.settings.len() == 1 && part.effects.is_empty());
}

/// Every level of every setting makes a valid scene.
#[test]
fn the_levels_are_valid_in_every_scene() {
    for preset in PRESETS {
        let scene = preset.scene().unwrap();
        let own = adaptive(&scene).unwrap();
        for setting in Setting::ALL {
            for value in levels(&scene, setting) {
                let varied = Settings::of(&with(&own, setting, value).unwrap());
                let found = match setting {
                    Setting::Tolerance => Some(varied.tolerance),
                    Setting::Nodes => varied.nodes.map(|nodes| nodes as f64),
                    Setting::ElementSize => varied.element_size_mm,
                };
                assert_eq!(found, Some(value), "{}", preset.name);
            }
        }
    }
}

/// The rule of `--accuracy` holds in every scene that vibrates: the error of its settings, from a run at the next finer
/// level of everything, is at most the required one; of a chaotic motion, within the scatter of its average.
#[test]
#[ignore = "takes minutes: cargo test --release --lib the_accuracy_rule_holds -- --ignored --nocapture"]
fn the_accuracy_rule_holds_in_every_scene() {
    let mut missed = Vec::new();
    for preset in PRESETS {
        let scene = preset.scene().unwrap();
        let mut go_on = |_: f64, _: &str| Ok(());
        let mut runner = match Runner::settle(&scene, &mut go_on) {
            Err(StudyError::AtRest) => continue,
            found => found.unwrap(),
        };
        let (reference, again) = runner.twice(&finest(&scene).unwrap()).unwrap();
        let scatter = again.difference(&reference);
        for target in TARGETS {
            let rule = adaptive(&scene).unwrap().with_accuracy(target).unwrap();
            let choice = verified(&mut runner, [target, 0.0], Origin::Accuracy, &rule).unwrap();
            let bound = if reference.has_lines() {
                target
            } else {
                target.max(3.0 * scatter)
            };
            println!(
                "| {} | {} | {target:.0e} | {:.1e} | {scatter:.1e} | {:?} |",
                preset.name, reference.regime, choice.error, choice.exponents_agree
            );
            if choice.error > bound {
                missed.push((preset.name, target, choice.error));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
