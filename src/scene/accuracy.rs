//! Settings of the integrator for a wanted accuracy, as `squeakscope cost` advises them.

use super::error::{Fault, Place, SceneError};
use toml_edit::Value;

use super::schema::join;
use super::spec::Scene;
use super::tables::accuracy::ADVICE;

/// The longest step of an advised method that chooses its own, s: a limit in the way of none. Advice is
/// found with it.
pub const LONGEST_STEP: f64 = 1e-4;

impl Scene {
    /// The same scene with advice on its integrator: the error, the method by its name, its tolerance or
    /// step in s. Errors that a scene has no key for are left out.
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

    /// The same scene with the cheapest integrator for an error that it has advice for.
    ///
    /// # Errors
    /// If it has none for an error so small.
    pub fn with_accuracy(&self, error: f64) -> Result<Self, SceneError> {
        // The largest error that is allowed is the cheapest.
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
                        "advice goes down to {finest:e}: for less give the scene a time.tolerance"
                    ),
                    false => {
                        "find one by `squeakscope cost SCENE --write FILE.toml`, SCENE being this \
                              one's name or file, and take that file"
                            .to_owned()
                    }
                },
            };
            return Err(fault.at(Place {
                file: "--accuracy".to_owned(),
                line: None,
            }));
        };
        let fixed = advised.method.has_fixed_step();
        let step = if fixed { advised.value } else { LONGEST_STEP };
        // Sums of decimals are written as decimals.
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
    use crate::scene::Advised;

    #[test]
    fn scenes_with_advice_take_that_for_1e_4_by_default() {
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
    fn advice_is_written_read_and_followed() {
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
        assert_eq!(fine.max_step, LONGEST_STEP);
        let coarse = found(0.3);
        assert_eq!(coarse.method, MethodName::Rk4);
        assert!((coarse.max_step / 1.6e-6 - 1.0).abs() < 1e-12);
        // Between two the better one.
        assert_eq!(found(5e-3).method, MethodName::Dop853);
        let refused = |error: f64| advised.with_accuracy(error).unwrap_err().to_string();
        assert!(
            refused(1e-6).contains("`squeakscope cost SCENE --write FILE.toml`"),
            "{}",
            refused(1e-6)
        );
        assert!(refused(1e-9).contains("goes down to 1e-6"));
        for text in [
            "dop853",
            "dop 1e-3",
            "rk4 -1",
            "rk4 x",
            "auto 3",
            "rk4 1e-12",
            "auto 1e-99",
        ] {
            assert_eq!(Advised::read(1e-2, text), None, "{text}");
        }
    }
}
