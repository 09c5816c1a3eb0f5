//! Settings for a required accuracy, as found by `squeakscope cost`: error budgets of all numerical settings,
//! and the cheapest integrator alone.

use toml_edit::{ArrayOfTables, InlineTable, Table, Value};

use super::edit::{number, remove, set_list};
use super::error::{Fault, Location, SceneError};
use super::schema::join;
use super::setting::{SceneSetting, SettingValue};
use super::spec::Scene;
use super::tables::accuracy::{ADVICE, AccuracyBudget, BUDGETS};

/// Maximum step of an advised adaptive method, s. The advice is determined with this limit, which is large
/// enough not to restrict the step control.
pub const MAX_ADVISED_STEP: f64 = 1e-4;

impl Scene {
    /// Returns the scene with new integrator advice. Each entry gives the error, the name of the method and
    /// its tolerance or fixed step (s). Errors without a key in `[accuracy]` are ignored.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with_advice(&self, advice: &[(f64, &str, f64)]) -> Result<Self, SceneError> {
        let entries = ADVICE.iter().filter_map(|(error, key)| {
            let (_, method, value) = advice.iter().find(|(of, ..)| of == error)?;
            let path = join("accuracy", key.name);
            Some((path, Value::from(format!("{method} {value:e}"))))
        });
        self.with_entries(entries)
    }

    /// Returns the scene with other values of some keys.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with_settings(&self, settings: &[SceneSetting]) -> Result<Self, SceneError> {
        let absent = SettingValue::Word(SceneSetting::ABSENT.to_owned());
        let (removed, set): (Vec<_>, Vec<_>) =
            settings.iter().partition(|setting| setting.value == absent);
        let mut document = self.document()?;
        for setting in removed {
            remove(&mut document, &setting.key);
        }
        let scene = self.with_document(&document)?;
        scene.with_entries(
            set.into_iter()
                .map(|setting| (&setting.key, value(setting))),
        )
    }

    /// Returns the scene with new error budgets; their fingerprints are determined here.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with_budgets(&self, budgets: &[AccuracyBudget]) -> Result<Self, SceneError> {
        let mut list = ArrayOfTables::new();
        for budget in budgets {
            let settings = budget.settings.iter();
            let settings: InlineTable = settings.map(|s| (&s.key, value(s))).collect();
            let errors = budget.errors.iter();
            let errors: InlineTable = errors.map(|(name, e)| (name, rounded_up(*e))).collect();
            let mut table = Table::new();
            for (key, value) in [
                ("error", Value::from(budget.target)),
                (
                    "averaging_ms",
                    number((1e9 * budget.averaging_time).round() / 1e6),
                ),
                ("settings", Value::InlineTable(settings)),
                ("errors", Value::InlineTable(errors)),
                (
                    "fingerprint",
                    Value::from(self.with_settings(&budget.settings)?.fingerprint()),
                ),
            ] {
                table.insert(key, toml_edit::value(value));
            }
            list.push(table);
        }
        let mut document = self.document()?;
        set_list(&mut document, BUDGETS, list);
        self.with_document(&document)
    }

    /// Identifies the model and its numerical settings: a change of system, initial state, integrator or
    /// sampling rate changes the fingerprint; analyses and recording do not.
    pub fn fingerprint(&self) -> String {
        let Self {
            subject,
            start,
            integrator,
            sample_rate,
            ..
        } = self;
        let model = format!("{subject:?} {start:?} {integrator:?} {sample_rate}");
        // FNV-1a, 64 bits.
        let hash = model.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}")
    }

    /// The budget whose errors hold for this scene, to which [`Scene::with_accuracy`] applied `error`.
    ///
    /// # Errors
    /// The reason why the errors are not known.
    pub fn verified_errors(&self, error: f64) -> Result<&AccuracyBudget, String> {
        let Some(budget) = self.budget(error) else {
            return Err("only the integrator was chosen for this accuracy; determine the errors of all settings \
                        with `squeakscope cost --write`"
                .to_owned());
        };
        let fixed = self
            .joint()
            .ok()
            .and_then(|joint| joint.fixed_at_start().description());
        if let Some(values) = fixed {
            return Err(format!(
                "the budget holds for constant parameters ({values}), but they change during the run"
            ));
        }
        if self.fingerprint() != budget.fingerprint {
            return Err(
                "the scene has changed since `squeakscope cost` determined its budget".to_owned(),
            );
        }
        let window = self
            .analysis
            .spectrum
            .as_ref()
            .map(|spectrum| spectrum.sliding.window);
        let window = window.filter(|window| *window >= budget.averaging_time * (1.0 - 1e-9));
        let duration = budget
            .settings
            .iter()
            .find(|setting| setting.key == "time.duration_ms");
        let is_long = duration.is_none_or(|least| match least.value {
            SettingValue::Number(ms) => 1e3 * self.duration >= ms * (1.0 - 1e-9),
            SettingValue::Word(_) => false,
        });
        match window.is_some() && is_long {
            true => Ok(budget),
            false => Err(format!(
                "the budget needs the settled motion of {} ms in analysis.spectrum.window_ms",
                (1e6 * budget.averaging_time).round() / 1e3
            )),
        }
    }

    /// The cheapest budget for an error: the one with the largest permitted error.
    fn budget(&self, error: f64) -> Option<&AccuracyBudget> {
        let fitting = self
            .budgets
            .iter()
            .filter(|b| b.target <= error * (1.0 + 1e-9));
        fitting.max_by(|a, b| a.target.total_cmp(&b.target))
    }

    /// Returns the scene with the numerical settings of its error budget for `error`. Without a budget, only
    /// the integrator is chosen: the cheapest advised one whose error does not exceed `error`.
    ///
    /// # Errors
    /// If the scene has neither for an error this small.
    pub fn with_accuracy(&self, error: f64) -> Result<Self, SceneError> {
        match self.budget(error) {
            Some(budget) => self.with_settings(&budget.settings),
            None => self.with_advised_integrator(error),
        }
    }

    /// The scene with the cheapest advised integrator for `error`.
    fn with_advised_integrator(&self, error: f64) -> Result<Self, SceneError> {
        // The advice with the largest permitted error is the cheapest.
        let fitting = self
            .advice
            .iter()
            .filter(|advised| advised.error <= error * (1.0 + 1e-9));
        let Some(advised) = fitting.max_by(|a, b| a.error.total_cmp(&b.error)) else {
            let finest = ADVICE
                .iter()
                .map(|(error, _)| *error)
                .fold(f64::INFINITY, f64::min);
            let fault = Fault::NoAdvice {
                scene: self.name.clone(),
                error: format!("{error:e}"),
                remedy: match error < finest * (1.0 - 1e-9) {
                    true => format!(
                        "advice is available down to {finest:e}; for a smaller error set time.tolerance in the scene"
                    ),
                    false => {
                        "run `squeakscope cost SCENE --write FILE.toml` with the name or file of this scene as SCENE, \
                         and use FILE.toml"
                            .to_owned()
                    }
                },
            };
            return Err(fault.at(Location {
                file: "--accuracy".to_owned(),
                line: None,
            }));
        };
        let fixed = advised.method.has_fixed_step();
        let step = if fixed {
            advised.value
        } else {
            MAX_ADVISED_STEP
        };
        // Rounding to 1 ps keeps the decimal short in the text.
        let step_us = (1e9 * step).round() / 1e3;
        let mut entries = vec![
            ("time.method", Value::from(advised.method.name())),
            ("time.max_step_us", Value::from(step_us)),
        ];
        if !fixed {
            entries.push(("time.tolerance", Value::from(advised.value)));
        }
        self.with_entries(entries)
    }
}

/// The value of a setting in a scene file.
fn value(setting: &SceneSetting) -> Value {
    match &setting.value {
        SettingValue::Number(x) => number(*x),
        SettingValue::Word(word) => Value::from(word.as_str()),
    }
}

/// A bound with two digits, not smaller than the error.
fn rounded_up(error: f64) -> f64 {
    if error <= 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(error.log10().floor() - 1.0);
    let digits = (error / unit).ceil();
    // Through text, so that the decimal is short.
    format!("{:.1e}", digits * unit).parse().unwrap_or(error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::MethodName;
    use crate::scene::IntegratorAdvice;

    #[test]
    fn default_integrators_are_the_advice_for_1e_4() {
        let scenes = crate::scene::PRESETS
            .iter()
            .map(|preset| preset.scene().unwrap());
        let advised: Vec<Scene> = scenes.filter(|scene| !scene.advice.is_empty()).collect();
        assert!(advised.len() >= 3);
        for scene in advised {
            let found = scene.with_accuracy(1e-4).unwrap().integrator;
            let default = scene.integrator;
            assert_eq!(
                (found.method, found.tolerance),
                (default.method, default.tolerance),
                "{}",
                scene.name
            );
        }
    }

    #[test]
    fn advice_round_trips_through_the_text() {
        let text = Scene::load("mode-shift-3.5deg").unwrap().text;
        let (without, _) = text.split_once("[accuracy]").unwrap();
        let scene = Scene::parse("mine.toml", without).unwrap();
        let advised = scene
            .with_advice(&[
                (1e-2, "rk4", 1.6e-6),
                (1e-4, "dop853", 1e-4),
                (0.5, "auto", 1e-3),
            ])
            .unwrap();
        assert!(
            advised.text.contains("error_1e-4 = \"dop853 1e-4\""),
            "{}",
            advised.text
        );
        let found = |error: f64| advised.with_accuracy(error).unwrap().integrator;
        let fine = found(1e-4);
        assert_eq!((fine.method, fine.tolerance), (MethodName::Dop853, 1e-4));
        assert_eq!(fine.max_step, MAX_ADVISED_STEP);
        let coarse = found(0.3);
        assert_eq!(coarse.method, MethodName::Rk4);
        assert!((coarse.max_step / 1.6e-6 - 1.0).abs() < 1e-12);
        // An error between two entries takes the more accurate one.
        assert_eq!(found(5e-3).method, MethodName::Dop853);
        let refused = |error: f64| advised.with_accuracy(error).unwrap_err().to_string();
        assert!(
            refused(1e-6).contains("`squeakscope cost SCENE --write FILE.toml`"),
            "{}",
            refused(1e-6)
        );
        assert!(refused(1e-9).contains("down to 1e-6"));
        for text in [
            "dop853",
            "dop 1e-3",
            "rk4 -1",
            "rk4 x",
            "auto 3",
            "rk4 1e-12",
            "auto 1e-99",
        ] {
            assert_eq!(IntegratorAdvice::read(1e-2, text), None, "{text}");
        }
    }
}
