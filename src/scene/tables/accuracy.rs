//! Advice on the integrator, `[accuracy]`.

use crate::dynamics::MethodName;
use crate::scene::document::Document;
use crate::scene::error::SceneError;
use crate::scene::schema::kind::Text;
use crate::scene::schema::{Key, Otherwise};

/// Keys of advice on the integrator, by the error.
pub static ADVICE: [(f64, Key<Text>); 4] = [
    (
        1e-2,
        key(
            "error_1e-2",
            "The cheapest integrator for an error of 1e-2 of the state, such as `lawson54 1e-3`: its name and tolerance (of `rk4` its step in s), which `--accuracy 1e-2` takes. `squeakscope cost --write` finds it.",
        ),
    ),
    (1e-3, key("error_1e-3", "For 1e-3.")),
    (1e-4, key("error_1e-4", "For 1e-4.")),
    (1e-6, key("error_1e-6", "For 1e-6.")),
];

const fn key(name: &'static str, meaning: &'static str) -> Key<Text> {
    Key {
        name,
        meaning,
        otherwise: Otherwise::Else("no advice"),
        kind: Text,
    }
}

/// The cheapest setting of the integrator for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advised {
    /// The error of the state over a few milliseconds, relative to its size.
    pub error: f64,
    /// The method.
    pub method: MethodName,
    /// Its tolerance, or its step in s where it is fixed.
    pub value: f64,
}

impl Advised {
    /// Reads `lawson54 1e-4`.
    pub(in crate::scene) fn read(error: f64, text: &str) -> Option<Self> {
        let (name, value) = text.split_once(' ')?;
        let method: MethodName = name.parse().ok()?;
        let value: f64 = value.trim().parse().ok()?;
        // As of the keys that will take it.
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

/// What the scene knows of cheap integrators.
pub fn advice(document: &Document<'_>) -> Result<Vec<Advised>, SceneError> {
    let table = document.table("accuracy");
    let mut advice = Vec::new();
    for (error, key) in &ADVICE {
        let Some(text) = table.find(key)? else {
            continue;
        };
        advice.push(Advised::read(*error, &text).ok_or_else(|| {
            table.inconsistent(
                key.name,
                &[],
                "it is no method with a tolerance from 1e-13 to 1e-2, or a fixed step from 1e-9 to 1e-3 s",
                "write such as \"lawson54 1e-4\", or let `squeakscope cost --write` find it",
            )
        })?);
    }
    Ok(advice)
}
