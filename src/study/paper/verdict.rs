//! The verdict on a claim.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// The claim holds at every tilt to which it refers.
    Met,
    /// The claim holds at some of these tilts.
    Partly {
        /// Share of the tilts at which it holds, between 0 and 1.
        share: f64,
    },
    /// The claim does not hold.
    NotMet,
    /// The paper does not state enough to compare, or there is no result to compare with.
    NotComparable,
}

impl Verdict {
    /// Name in text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Partly { .. } => "partly met",
            Self::NotMet => "not met",
            Self::NotComparable => "not comparable",
        }
    }

    /// Share to which the claim holds, 0 to 1; zero if it cannot be compared.
    pub fn share(self) -> f64 {
        match self {
            Self::Met => 1.0,
            Self::Partly { share } => share,
            Self::NotMet | Self::NotComparable => 0.0,
        }
    }

    /// Compares a result, if there is one.
    pub(super) fn when<T>(found: Option<T>, is_so: impl Fn(T) -> bool) -> Self {
        match found.map(is_so) {
            None => Self::NotComparable,
            Some(true) => Self::Met,
            Some(false) => Self::NotMet,
        }
    }

    /// Compares by counts.
    pub(super) fn of(holding: usize, all: usize) -> Self {
        match (holding, all) {
            (_, 0) => Self::NotComparable,
            (0, _) => Self::NotMet,
            (holding, all) if holding == all => Self::Met,
            (holding, all) => Self::Partly {
                share: holding as f64 / all as f64,
            },
        }
    }
}
