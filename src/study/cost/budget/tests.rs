//! Error budgets: contributions of synthetic sequences, short budgets, and comparison with finer runs.

use super::*;
use crate::scene::SettingValue;
use crate::study::cost::{CostPlan, CostSetting, cost};
use crate::study::response::{InitialState, ResponsePlan, response};

/// The budget of a plan.
fn budget_of(plan: CostPlan) -> ErrorBudget {
    let plan = CostPlan {
        settings: vec![CostSetting::Budget],
        repeats: 1,
        ..plan
    };
    cost(&plan, &mut |_| true).unwrap().unwrap().budget.unwrap()
}

/// An observation of one quantity.
fn observed(value: f64) -> Vec<Observation> {
    vec![Observation {
        values: vec![Ok(value)],
        half_widths: vec![0.0],
        state: Vec::new(),
        rhs_evals: 1.0,
    }]
}

/// The true error of every level of a convergent sequence is at most its contribution, and not much smaller.
#[test]
fn contributions_bound_the_errors_of_a_convergent_sequence() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let mut refinement = integrator(&scene);
    for ratio in [0.1, 0.25, 0.5] {
        let exact = 3.0;
        let error = |level: usize| 0.1 * f64::powi(ratio, level as i32);
        let runs: Vec<_> = (0..refinement.levels.len())
            .map(|level| observed(exact * (1.0 + error(level))))
            .collect();
        for (level, found) in contributions(&refinement, &runs, 0).into_iter().enumerate() {
            // Relative to the exact value instead of that of the reference.
            let found = found.unwrap() * (1.0 + error(refinement.reference()));
            let truth = error(level);
            assert!(
                found >= truth * (1.0 - 1e-9),
                "{ratio} {level}: {found} {truth}"
            );
            assert!(found <= 1.2 * truth, "{ratio} {level}: {found} {truth}");
        }
    }
    // A difference that vanishes by chance does not count as accuracy.
    let values = [1.1, 1.0, 1.01, 1.005, 1.001, 1.0002, 1.0001, 1.0];
    let runs: Vec<_> = values.map(observed).into();
    let found = contributions(&refinement, &runs, 0);
    assert!(found[1].unwrap() >= 0.01, "{found:?}");
    // The exact level has no error; a level without a value is not usable.
    refinement.exact = true;
    let mut runs = runs;
    runs[3][0].values[0] = Err("at rest".to_owned());
    let found = contributions(&refinement, &runs, 0);
    assert_eq!((found[7], found[3]), (Some(0.0), None));
}

/// A small mechanism on which nothing was tuned: the verified errors bound the difference from a run with a much
/// smaller tolerance, averaged over another and longer window.
#[test]
fn verified_errors_bound_the_difference_from_a_much_finer_run() {
    let scene = Scene::load("mass-on-belt").unwrap();
    let plan = CostPlan {
        targets: vec![1e-2],
        time_factor: 1.0,
        ..CostPlan::new(scene.clone())
    };
    let budget = budget_of(plan);
    let [choice] = &budget.choices[..] else {
        panic!("{budget:?}");
    };
    assert!(choice.verified, "{choice:?}");
    let sum: f64 = choice.shares.iter().map(|share| share.errors[0]).sum();
    assert!((sum - choice.predicted[0]).abs() <= 1e-12);
    let measure = |scene: &Scene, time: f64| {
        let look = ResponsePlan {
            min_transient: 0.3,
            max_transient: 0.3,
            measurement_time: time,
            exponents: 0,
            orbits: false,
            portrait: false,
            max_rhs_evals: None,
        };
        let found = response(scene, InitialState::Fresh, &look, &mut None, &mut |_| true);
        let found = found.unwrap().unwrap();
        [
            found.lines[0].frequency,
            found.amplitude,
            found.rms_velocity,
        ]
    };
    let chosen = scene.with_settings(&choice.budget.settings).unwrap();
    let fine = scene.with_tolerance(1e-12).unwrap();
    let found = measure(&chosen, choice.budget.averaging_time);
    let fine = measure(&fine, 2.0);
    for ((quantity, found), fine) in Quantity::DEFAULT.iter().zip(found).zip(fine) {
        let (error, bound) = (
            (found / fine - 1.0).abs(),
            choice.budget.errors[quantity.name()],
        );
        assert!(error <= bound, "{}: {error} {bound}", quantity.name());
    }
}

/// Growth rate and border need no simulation; their errors hold against a Gauss rule and finer elements than any
/// level.
#[test]
fn linear_quantities_of_a_joint_have_a_budget_without_a_simulation() {
    let scene = Scene::load("mode-shift-3.5deg").unwrap();
    let plan = CostPlan {
        quantities: vec![Quantity::Growth, Quantity::Border],
        targets: vec![1e-2, 1e-4],
        ..CostPlan::new(scene.clone())
    };
    let budget = budget_of(plan);
    let sources: Vec<Source> = budget.sources.iter().map(|source| source.source).collect();
    assert_eq!(sources, [Source::Nodes, Source::Elements]);
    let finest = [
        SceneSetting::number("contact.nodes", 1500.0),
        SceneSetting::word("contact.quadrature", "gauss"),
        SceneSetting::number("body.element_size_mm", 4.0),
        SceneSetting::number("body.element_order", 5.0),
    ];
    let linear = |settings: &[SceneSetting]| {
        let scene = scene.with_settings(settings).unwrap();
        let window = Window {
            start: &[],
            settling: 0.0,
            time: 0.0,
        };
        let quantities = [Quantity::Growth, Quantity::Border];
        let found = observe(&scene, &quantities, &window, &mut None, &mut || true);
        found.unwrap().unwrap().values
    };
    let fine = linear(&finest);
    for choice in &budget.choices {
        assert!(choice.verified && choice.rhs_evals == 0, "{choice:?}");
        let found = linear(&choice.budget.settings);
        for (k, (found, fine)) in found.iter().zip(&fine).enumerate() {
            let Ok((found, fine)) = found.clone().and_then(|found| Ok((found, fine.clone()?)))
            else {
                assert_eq!(budget.quantities[k].value, None);
                continue;
            };
            let name = budget.quantities[k].quantity.name();
            let (error, bound) = ((found / fine - 1.0).abs(), choice.budget.errors[name]);
            assert!(
                error <= bound && bound <= choice.budget.target,
                "{name}: {error} {bound}"
            );
        }
    }
    assert!(!budget.choices.is_empty(), "{budget:?}");
}

/// Chaos has no line and no amplitude that converges; its rms velocity has a statistical interval.
#[test]
fn quantities_that_are_not_defined_are_reported() {
    let scene = Scene::load("impact-oscillator").unwrap();
    let plan = CostPlan {
        targets: vec![1e-6],
        time_factor: 0.5,
        ..CostPlan::new(scene)
    };
    let budget = budget_of(plan);
    let reason = |k: usize| budget.quantities[k].undefined.clone().unwrap_or_default();
    for k in [0, 1] {
        assert!(
            reason(k).contains("does not converge"),
            "{:?}",
            budget.quantities
        );
    }
    assert!(budget.quantities[2].value.is_some_and(|rms| rms > 0.0));
    let [unreached] = &budget.unreached[..] else {
        panic!("{budget:?}");
    };
    assert!(unreached.reason.contains("rms"), "{unreached:?}");
    assert!(budget.verified().is_empty());
}

/// The scene takes a budget over, and the error is known exactly as long as nothing changes.
#[test]
fn a_written_budget_is_applied_and_checked() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let settings = vec![
        SceneSetting::number("time.tolerance", 1e-4),
        SceneSetting::number("contact.nodes", 1000.0),
        SceneSetting::number("time.duration_ms", 300.0),
        SceneSetting::number("analysis.spectrum.window_ms", 160.0),
    ];
    let budget = AccuracyBudget {
        target: 1e-3,
        averaging_time: 0.16,
        errors: [("rms".to_owned(), 2.34e-4)].into(),
        fingerprint: scene.with_settings(&settings).unwrap().fingerprint(),
        settings,
    };
    let written = scene.with_budgets(std::slice::from_ref(&budget)).unwrap();
    assert!(
        written.text.contains("[[accuracy.budget]]"),
        "{}",
        written.text
    );
    // As from a file.
    let read = Scene::parse("periodic-2deg", written.text.clone()).unwrap();
    assert_eq!(read.budgets[0].errors["rms"], 2.4e-4);
    let accurate = read.with_accuracy(2e-3).unwrap();
    assert_eq!(accurate.joint().unwrap().spec.contact.nodes, 1000);
    assert_eq!(accurate.integrator.tolerance, 1e-4);
    assert!(accurate.verified_errors(2e-3).is_ok());
    let why = |scene: Scene| scene.verified_errors(2e-3).unwrap_err();
    assert!(why(accurate.clone().with_tilt(2.5).unwrap()).contains("has changed"));
    assert!(why(accurate.clone().with_tolerance(1e-3).unwrap()).contains("has changed"));
    assert!(why(accurate.with_duration(100.0).unwrap()).contains("160 ms"));
    // Tighter than any budget: only the integrator is known.
    let integrator = read.with_accuracy(1e-4).unwrap();
    assert_eq!(integrator.joint().unwrap().spec.contact.nodes, 100);
    assert!(
        integrator
            .verified_errors(1e-4)
            .unwrap_err()
            .contains("only the integrator")
    );
    // Keys that do not exist are rejected when the scene is read.
    let wrong = written
        .text
        .replace("\"contact.nodes\"", "\"contact.knots\"");
    let error = Scene::parse("wrong.toml", wrong).unwrap_err().to_string();
    assert!(
        error.contains("contact.knots") && error.contains("cost --write"),
        "{error}"
    );
    assert!(matches!(budget.settings[0].value, SettingValue::Number(_)));
}

/// Prints the budget of the scene `SCENE`, and its difference from a much finer run:
/// `SCENE=torus-3deg cargo test --release --lib print_budget -- --ignored --nocapture`.
#[test]
#[ignore = "takes a minute and prints numbers for the guide"]
fn print_budget() {
    let name = std::env::var("SCENE").unwrap_or_else(|_| "torus-3deg".to_owned());
    let scene = Scene::load(&name).unwrap();
    let began = std::time::Instant::now();
    let budget = budget_of(CostPlan::new(scene.clone()));
    println!(
        "{:.1?}\n{}",
        began.elapsed(),
        serde_json::to_string_pretty(&budget).unwrap()
    );
    let mut fine = fine_settings(&scene);
    fine.extend([
        SceneSetting::number("time.tolerance", 1e-9),
        SceneSetting::number("contact.nodes", 3000.0),
        SceneSetting::number("body.element_size_mm", 4.0),
    ]);
    let look = ResponsePlan {
        max_transient: 0.8,
        min_transient: 0.3,
        measurement_time: 1.0,
        exponents: 0,
        orbits: false,
        portrait: false,
        max_rhs_evals: None,
    };
    let measure = |settings: &[SceneSetting], time: f64| {
        let scene = scene.with_settings(settings).unwrap();
        let look = ResponsePlan {
            measurement_time: time,
            ..look
        };
        let found = response(&scene, InitialState::Fresh, &look, &mut None, &mut |_| true);
        let found = found.unwrap().unwrap();
        [
            found.lines[0].frequency,
            found.amplitude,
            found.rms_velocity,
        ]
    };
    let fine = measure(&fine, 1.0);
    for choice in &budget.choices {
        let found = measure(&choice.budget.settings, choice.budget.averaging_time);
        for ((quantity, found), fine) in Quantity::DEFAULT.iter().zip(found).zip(fine) {
            let bound = choice.budget.errors[quantity.name()];
            println!(
                "{:e} {}: difference {:.1e}, bound {bound:.1e}",
                choice.budget.target,
                quantity.name(),
                (found / fine - 1.0).abs()
            );
        }
    }
}
