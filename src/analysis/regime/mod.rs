//! What kind of motion is it? A verdict with its evidence and a confidence.

mod belief;
mod signs;
mod weigh;

use std::fmt;

use super::AnalysisError;
use belief::Belief;
use signs::Signs;

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
    /// The kinds it speaks for: one of them, without saying which.
    pub says: &'static [Regime],
    /// How strongly, 0 to 1.
    pub weight: f64,
    /// A sentence with the number in it.
    pub words: String,
}

impl Evidence {
    /// The kinds it speaks for, in words: `periodic or quasi-periodic`.
    pub fn kinds(&self) -> String {
        let kinds: Vec<String> = self.says.iter().map(Regime::to_string).collect();
        kinds.join(" or ")
    }
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

impl RegimeSearch {
    /// The fewest samples that are judged.
    pub const FEWEST_SAMPLES: usize = 64;

    /// The most samples that are judged; of a longer record the last ones.
    pub const MOST_SAMPLES: usize = 8192;
}

/// A verdict needs this share of all belief.
const BELIEVED: f64 = 0.5;

/// Samples that differ by less than this share of the largest do so by rounding.
const ROUNDING: f64 = 1e-12;

/// Tells the kind of motion of a signal. Of more than [`RegimeSearch::MOST_SAMPLES`] samples the
/// last ones count; neither amplitude nor offset matter unless [`RegimeSearch::silence`] is given.
///
/// # Errors
/// [`AnalysisError::TooShort`] below [`RegimeSearch::FEWEST_SAMPLES`].
pub fn classify(samples: &[f64], search: &RegimeSearch) -> Result<Verdict, AnalysisError> {
    if samples.len() < RegimeSearch::FEWEST_SAMPLES {
        return Err(AnalysisError::TooShort {
            what: "kind of motion",
            have: samples.len(),
            need: RegimeSearch::FEWEST_SAMPLES,
        });
    }
    let recent = &samples[samples.len().saturating_sub(RegimeSearch::MOST_SAMPLES)..];
    let low = recent.iter().copied().fold(f64::INFINITY, f64::min);
    let high = recent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let amplitude = 0.5 * (high - low);
    if amplitude <= ROUNDING * low.abs().max(high.abs()) || amplitude < search.silence {
        return Ok(silent(amplitude, search.silence));
    }
    let scaled: Vec<f64> = recent.iter().map(|x| (x - low) / amplitude - 1.0).collect();
    let evidence = weigh::evidence(&Signs::of(&scaled, search.sample_rate)?);
    let mut belief = Belief::open();
    for piece in evidence.iter().filter(|e| e.says != [Regime::Unsure]) {
        belief.join(piece.says, piece.weight);
    }
    let (kind, confidence) = belief.strongest();
    Ok(Verdict {
        regime: if confidence >= BELIEVED {
            kind
        } else {
            Regime::Unsure
        },
        confidence,
        evidence,
    })
}

/// The verdict on a signal that hardly moves.
fn silent(amplitude: f64, silence: f64) -> Verdict {
    // At the limit itself it might as well be called faint.
    let confidence = 1.0 - 0.5 * amplitude / silence.max(amplitude).max(f64::MIN_POSITIVE);
    let confidence = if silence > 0.0 { confidence } else { 1.0 };
    Verdict {
        regime: Regime::Silent,
        confidence,
        evidence: vec![Evidence {
            what: "amplitude",
            value: amplitude,
            says: &[Regime::Silent],
            weight: confidence,
            words: format!("The amplitude is {amplitude:.3e}; below {silence:.3e} it is silent."),
        }],
    }
}

#[cfg(test)]
mod tests;
