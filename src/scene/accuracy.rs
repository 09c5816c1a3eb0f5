//! Integrator settings for a required accuracy, as found by `squeakscope cost`.

use super::error::{Fault, Location, SceneError};
use toml_edit::Value;

use super::schema::join;
use super::spec::Scene;
use super::tables::accuracy::ADVICE;

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

    /// Returns the scene with the cheapest advised integrator whose error does not exceed `error`.
    ///
    /// # Errors
    /// If the scene has no advice for an error this small.
    pub fn with_accuracy(&self, error: f64) -> Result<Self, SceneError> {
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
