//! Advice on integrator settings, `[accuracy]`.

use crate::dynamics::MethodName;
use crate::scene::document::Document;
use crate::scene::error::SceneError;
use crate::scene::schema::kind::Text;
use crate::scene::schema::{IfAbsent, Key};

/// The advice keys with their errors.
pub static ADVICE: [(f64, Key<Text>); 4] = [
    (
        1e-2,
        key(
            "error_1e-2",
            "Cheapest integrator for a relative error of 1e-2 of the state, selected by `--accuracy 1e-2`: name and tolerance (for `rk4` the step in s), such as `lawson54 1e-3`. `squeakscope cost --write` determines it.",
        ),
    ),
    (1e-3, key("error_1e-3", "The same for an error of 1e-3.")),
    (1e-4, key("error_1e-4", "The same for an error of 1e-4.")),
    (1e-6, key("error_1e-6", "The same for an error of 1e-6.")),
];

const fn key(name: &'static str, meaning: &'static str) -> Key<Text> {
    Key {
        name,
        meaning,
        if_absent: IfAbsent::Described("no advice"),
        kind: Text,
        old_name: None,
    }
}

/// The cheapest integrator setting for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorAdvice {
    /// Error of the state after a few milliseconds, relative to its norm.
    pub error: f64,
    /// Integration method.
    pub method: MethodName,
    /// Tolerance, or step (s) of a method with fixed step.
    pub value: f64,
}

impl IntegratorAdvice {
    /// Parses text such as `lawson54 1e-4`.
    pub(in crate::scene) fn read(error: f64, text: &str) -> Option<Self> {
        let (name, value) = text.split_once(' ')?;
        let method: MethodName = name.parse().ok()?;
        let value: f64 = value.trim().parse().ok()?;
        // The ranges of `time.max_step_us` and `time.tolerance`.
        let sound = match method.has_fixed_step() {
            true => (1e-9..=1e-3).contains(&value),
            false => (1e-13..=1e-2).contains(&value),
        };
        sound.then_some(Self {
            error,
            method,
            value,
        })
    }
}

/// Reads the integrator advice of a scene.
pub fn advice(document: &Document<'_>) -> Result<Vec<IntegratorAdvice>, SceneError> {
    let table = document.table("accuracy");
    let mut advice = Vec::new();
    for (error, key) in &ADVICE {
        let Some(text) = table.find(key)? else {
            continue;
        };
        advice.push(IntegratorAdvice::read(*error, &text).ok_or_else(|| {
            table.inconsistent(
                key.name,
                &[],
                "this is not a method followed by a tolerance from 1e-13 to 1e-2 or a fixed step from 1e-9 to 1e-3 s",
                "write for example \"lawson54 1e-4\", or determine it with `squeakscope cost --write`",
            )
        })?);
    }
    Ok(advice)
}
