//! Results that may be skipped with a reason.

use schemars::JsonSchema;
use serde::Serialize;

/// Outcome of an analysis: its result, or the reason why it was skipped. In JSON it is the result itself,
/// or an object with the field `skipped`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome<T> {
    /// The result.
    Computed(T),
    /// An assumption of the analysis does not hold.
    Skipped {
        /// Reason why the analysis was skipped.
        skipped: SkipReason,
    },
}

/// Reason why an analysis was skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, thiserror::Error)]
#[serde(rename_all = "kebab-case")]
pub enum SkipReason {
    /// The event has no stationary stretch of sufficient length.
    #[error("the event has no stationary stretch of sufficient length")]
    NotStationary,
    /// The analysed stretch contains clipped samples.
    #[error("the stretch contains clipped samples")]
    Clipped,
    /// There are tonal events, but the noise in the analysed stretch hides the motion.
    #[error("the noise in the stretch hides the motion")]
    Noise,
    /// The motion is a transient.
    #[error("the motion is a transient, so averages over time are meaningless")]
    Transient,
    /// The signal is constant, or constant with dither of one step of its resolution.
    #[error("the signal is constant")]
    Silent,
}

impl<T> Outcome<T> {
    /// Computes a result unless there is a reason to skip it.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn unless<E>(
        reason: Option<SkipReason>,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<Self, E> {
        match reason {
            Some(skipped) => Ok(Self::Skipped { skipped }),
            None => compute().map(Self::Computed),
        }
    }

    /// Computes another result from this one; if this one was skipped, so is the other.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn try_map<U, E>(&self, compute: impl FnOnce(&T) -> Result<U, E>) -> Result<Outcome<U>, E> {
        match self {
            Self::Computed(result) => compute(result).map(Outcome::Computed),
            Self::Skipped { skipped } => Ok(Outcome::Skipped { skipped: *skipped }),
        }
    }

    /// The result.
    ///
    /// # Errors
    /// The reason, if the analysis was skipped.
    pub fn get(&self) -> Result<&T, SkipReason> {
        match self {
            Self::Computed(result) => Ok(result),
            Self::Skipped { skipped } => Err(*skipped),
        }
    }
}
