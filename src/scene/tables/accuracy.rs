//! Settings for a required accuracy, `[accuracy]`: error budgets, and advice on the integrator.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::dynamics::MethodName;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::SceneError;
use crate::scene::schema::kind::Range::{Closed, Positive};
use crate::scene::schema::kind::{NamedNumbers, Settings, Tables, Text, number};
use crate::scene::schema::unit::{MILLISECOND, ONE};
use crate::scene::schema::{IfAbsent, Key, Schema, keys};
use crate::scene::setting::SceneSetting;

/// Path of the list of error budgets.
pub const BUDGETS: &str = "accuracy.budget";

/// Numerical settings of a scene for a required error, with their verified errors: an error budget of
/// `squeakscope cost`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyBudget {
    /// The target: the requested total relative error.
    pub target: f64,
    /// Numerical settings.
    pub settings: Vec<SceneSetting>,
    /// Time over which the settled motion is averaged, s.
    #[serde(rename = "averaging_time_s")]
    pub averaging_time: f64,
    /// Verified relative error of each quantity, by its name.
    pub errors: BTreeMap<String, f64>,
    /// Fingerprint of the scene with these settings ([`Scene::fingerprint`](crate::scene::Scene::fingerprint)).
    pub fingerprint: String,
}

keys! {
    /// Error budgets: for each requested error all numerical settings, and their verified errors. `squeakscope cost --write` determines them, `--accuracy` selects one.
    static LIST: Tables = "budget": Tables(16), else "no budget";

    AccuracyBudget {
        /// The target: the requested total relative error.
        target = "error": number(ONE, Positive(1.0));
        /// Keys of the scene and their values for this error; the word `absent` removes a key.
        settings = "settings": Settings;
        /// Time over which the settled motion is averaged.
        averaging_time = "averaging_ms": number(MILLISECOND, Positive(1e5));
        /// Verified relative errors of the quantities.
        errors = "errors": NamedNumbers(number(ONE, Closed(0.0, 1e3)));
        /// Fingerprint of the scene; the errors are unknown if the scene has changed since.
        fingerprint = "fingerprint": Text;
    }
}

/// Adds the keys of `[accuracy]`.
pub fn declare(schema: &mut Schema) {
    for (_, key) in &ADVICE {
        schema.add("accuracy", key);
    }
    schema.add("accuracy", &LIST);
    AccuracyBudget::declare(schema, BUDGETS);
}

/// Reads the error budgets of a scene.
pub fn budgets(document: &Document<'_>) -> Result<Vec<AccuracyBudget>, SceneError> {
    let list = document.table("accuracy").list(&LIST)?;
    let read = |table: Table<'_>| {
        let budget = AccuracyBudget::read(table)?;
        let paths = budget.settings.iter().map(|setting| &setting.key);
        match paths
            .into_iter()
            .find(|key| document.schema.find(key).is_none())
        {
            None => Ok(budget),
            Some(key) => Err(table.inconsistent(
                "settings",
                &[],
                format!("`{key}` is not a key of a scene"),
                "correct it, or determine the budget with `squeakscope cost --write`",
            )),
        }
    };
    list.into_iter().map(read).collect()
}

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
