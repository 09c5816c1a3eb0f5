//! Result of an error budget.

use serde::{Deserialize, Serialize};

use std::borrow::Cow;

use super::model::ErrorSource;
use super::quantity::{Quantity, QuantityValue};
use super::refinement::Source;
use crate::scene::AccuracyBudget;
use crate::study::cost::set::{CostSetting, WorkPrecisionPoint, WorkPrecisionSet};

/// Error budget of a scene: for each target the cheapest numerical settings, verified by a finer run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBudget {
    /// The requested quantities.
    pub quantities: Vec<QuantityValue>,
    /// The sources of error with their measured levels. Errors are in the order of the defined quantities.
    pub sources: Vec<ErrorSource>,
    /// The choices, one per target that the model reaches.
    pub choices: Vec<BudgetChoice>,
    /// Unreached targets: those without a choice.
    pub unreached: Vec<UnreachedTarget>,
    /// Trade-off of the model: CPU time, s, and largest total error of a quantity, for the combinations that no
    /// other one surpasses in both; in ascending order of time.
    pub trade_off: Vec<[f64; 2]>,
}

/// The choice of a budget: the settings for a target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BudgetChoice {
    /// The settings with their verified errors.
    #[serde(flatten)]
    pub budget: AccuracyBudget,
    /// Whether all verified errors are within the target.
    pub verified: bool,
    /// Number of combinations that were run.
    pub tries: usize,
    /// Errors that the model predicts, in the order of the defined quantities.
    pub predicted: Vec<f64>,
    /// The sources with their shares.
    pub shares: Vec<SourceShare>,
    /// The source to refine next: it reduces the largest error most per added time. `None` if no source does.
    pub next: Option<Source>,
    /// CPU time of a run, s: setup, settling and measurement, without analyses.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Right-hand-side evaluations of a run.
    pub rhs_evals: u64,
}

/// Share of a source in error and cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceShare {
    /// The source.
    pub source: Source,
    /// Its setting, such as `100 nodes in rings`.
    pub setting: String,
    /// Contributions to the predicted errors, in the order of the defined quantities.
    pub errors: Vec<f64>,
    /// CPU time that its cheapest level would save, s.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
}

/// An unreached target: no combination of levels is within it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnreachedTarget {
    /// The target: the requested relative error.
    pub target: f64,
    /// Reason, with the smallest possible error.
    pub reason: String,
}

impl ErrorBudget {
    /// The quantities that are defined for this motion.
    pub fn defined(&self) -> impl Iterator<Item = Quantity> {
        let defined = self
            .quantities
            .iter()
            .filter(|quantity| quantity.value.is_some());
        defined.map(|quantity| quantity.quantity)
    }

    /// The budgets that were verified, for the scene.
    pub fn verified(&self) -> Vec<AccuracyBudget> {
        let verified = self.choices.iter().filter(|choice| choice.verified);
        verified.map(|choice| choice.budget.clone()).collect()
    }
}

/// The budget as work-precision sets: for each quantity the verified error of the choices, from the loosest
/// target to the tightest.
pub fn budget_sets(budget: &ErrorBudget) -> Vec<WorkPrecisionSet> {
    let sets = budget.defined().map(|quantity| {
        let points = budget.choices.iter().map(|choice| WorkPrecisionPoint {
            value: choice.budget.target,
            seconds: choice.seconds,
            rhs_evals: choice.rhs_evals,
            error: match choice.budget.errors.get(quantity.name()) {
                Some(error) if error.is_finite() => Ok(*error),
                _ => Err("the motion of the finer run is of another type".to_owned()),
            },
            detail: choice
                .shares
                .iter()
                .map(|share| &share.setting[..])
                .collect::<Vec<_>>()
                .join(", "),
        });
        WorkPrecisionSet {
            setting: CostSetting::Budget,
            family: quantity.name().to_owned(),
            parameter: Cow::Borrowed("target error"),
            floor: None,
            points: points.collect(),
        }
    });
    sets.collect()
}
