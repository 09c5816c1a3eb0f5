//! What kind of motion is it? A verdict with its evidence and a confidence.

use std::fmt;

use super::AnalysisError;

/// Kinds of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Regime {
    /// Hardly anything moves.
    Silent,
    /// It still changes: grows, fades or wanders.
    Transient,
    /// It repeats.
    Periodic,
    /// Two (or more) tones that never come into step.
    QuasiPeriodic,
    /// It never repeats, neighbours part, yet it obeys a law.
    Chaotic,
    /// No law is found in it.
    Noise,
    /// The evidence does not suffice.
    Unsure,
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Silent => "silent",
            Self::Transient => "transient",
            Self::Periodic => "periodic",
            Self::QuasiPeriodic => "quasi-periodic",
            Self::Chaotic => "chaotic",
            Self::Noise => "noise",
            Self::Unsure => "not sure",
        })
    }
}

/// One piece of evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// What was measured, such as `0-1 test`.
    pub what: &'static str,
    /// The number.
    pub value: f64,
    /// Which kind it speaks for.
    pub says: Regime,
    /// How strongly, 0 to 1.
    pub weight: f64,
    /// A sentence with the number in it.
    pub words: String,
}

/// The verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The kind.
    pub regime: Regime,
    /// How sure, 0 to 1.
    pub confidence: f64,
    /// What led there, strongest first.
    pub evidence: Vec<Evidence>,
}

/// What the classification needs to know beside the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegimeSearch {
    /// Samples a second, Hz.
    pub sample_rate: f64,
    /// Amplitude below which it is silent, in the signal's unit; 0 if nothing is known.
    pub silence: f64,
}

/// Tells the kind of motion of a signal.
///
/// # Errors
/// [`AnalysisError`].
pub fn classify(_samples: &[f64], _search: &RegimeSearch) -> Result<Verdict, AnalysisError> {
    unimplemented!()
}
