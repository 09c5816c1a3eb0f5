//! What kind of motion is it? A verdict with its evidence and a confidence.
//!
//! No single number tells a torus from chaos or chaos from noise, least of all in the short piece
//! of signal that there is when one listens. So [`classify`] measures many, says of each what it
//! speaks for, how strongly and in a sentence, and joins them by a rule that is written down:
//! Dempster's (Shafer 1976). Evidence for a set of kinds with weight `w` gives the share `w` of
//! all belief to that set; two pieces give the product of their shares to what their sets have in
//! common, and what falls on nothing in common is dropped and the rest scaled up. The kind with
//! more than half of all belief to itself is the verdict, that share its confidence; if there is
//! none, it is not sure, and the confidence is that of the likeliest. The rule takes the pieces
//! for independent, which they are not quite: a confidence ranks verdicts, it is no probability.
//!
//! # The evidence
//!
//! In delay vectors of dimension 5, at the lag of the first clear minimum of the mutual
//! information; a turn is four lags. Weights run from 0 at the first limit to the last column at
//! the second.
//!
//! | what | is | speaks for | limits | weight |
//! |---|---|---|---|---|
//! | envelope | change of ln rms over the record, and over its error | transient | 0.08, 0.3; 3, 6 | 0.95 |
//! | tempo | the same of ln time between passages | transient | 0.01, 0.04; 5, 12 | 0.95 |
//! | spectral lines | one tone (or two in step, or a second below 2.5 % of the first); two or more | periodic; quasi-periodic | | 0.6 |
//! | floor | share of the power between the lines | periodic or quasi-periodic | 1e-3, 1e-6 | 0.7 |
//! | coloured floor | the part of it that is not white | chaotic (or noise) | 2.5e-4, 2.5e-3 | 0.8 |
//! | lawful floor | floor over `near^2`, what noise would make it | chaotic | 8, 50 | 0.8 |
//! | Poincare section | points; a loop; an arc | periodic; quasi-periodic; neither periodic nor noise | | 0.7; 0.8; 0.2 |
//! | repetition | distance of passages a period apart over `near` | periodic; not periodic | 2, 1.2; 3, 6 | 0.6; 0.7 |
//! | lasting prediction | `far / near` | periodic or quasi-periodic | 3, 1.5 | 0.7 |
//! | lost prediction | `far / near`, of a bent law | chaotic | 4, 10 | 0.7 |
//! | slow parting | ln of the distance of neighbours late over that early, of a bent law | chaotic (or transient) | 0.25, 0.5 | 0.8 |
//! | no prediction | `near / linear` | noise | 0.8, 0.95 | 0.9 |
//! | 0-1 test | `K` | regular; chaotic or noise | 0.4, 0.1; 0.6, 0.9 | 0.3; 0.5 |
//! | exponent | rate at which neighbours part over its error, of a bent law | chaotic | 3, 8 | 0.6 |
//!
//! `near` and `far` are errors of prediction by analogues (E. N. Lorenz, J. Atmos. Sci. 26, 636,
//! 1969), over the deviation: half the mean square difference of a state's successor and its
//! nearest neighbour's, one lag and ten turns ahead. For noise added to a law the first is the
//! noise (the delta test of Pi and Peterson, Neural Comput. 6, 509, 1994). `linear` is that of the
//! best linear map one lag ahead; a law is bent if neighbours do far better than it (0.7, 0.3),
//! and noise, whatever its colour, is not (after Casdagli, J. R. Stat. Soc. B 54, 303, 1992).
//!
//! Slow parting is what tells weak chaos, whose neighbours part by a few percent a turn, from a
//! torus, whose neighbours keep their distance, whatever its tones and however many: the root mean
//! square difference of two neighbours from 15 to 30 % of the record on, over that from 2 to 5 %
//! on, when they have found the direction in which they part (the mean logarithm is that of
//! Rosenstein, Collins and De Luca, Physica D 65, 117, 1993, of which only the growth is taken: it
//! is too short for a rate). Where it shows, the lines and the lasting prediction count for less to
//! the same extent. It says `chaotic or transient` where the nearest state a third of the record
//! away is more than `exp 0.6` times as far as the nearest of all: then the motion itself wanders
//! off, and takes one neighbour from the other (compare Schreiber, Phys. Rev. Lett. 78, 843, 1997).
//!
//! Where the record still changes, all other evidence counts for less, to the extent that it
//! does. Where it holds fewer than 40 turns all counts for less, and for nothing below 10. Further
//! conditions stand with the constants in the source. Recurrence quantification takes no part:
//! it counts the same neighbours as the predictions do, and would be believed twice.
//!
//! # What the limits rest on
//!
//! 8000 samples (50 a turn for tones, `dt` 0.1 for Roessler, 0.02 for Lorenz); deviation of added
//! noise in brackets, tones of amplitude 1:
//!
//! | signal | floor | coloured | lawful | section | repetition | near | near/linear | far | parting | K | said |
//! |---|---|---|---|---|---|---|---|---|---|---|---|
//! | sine (0.01) | 2e-4 | 0 | 0.8 | 1 point | 0.8 | 0.016 | 0.92 | 0.016 | 0.02 | -0.01 | periodic 0.95 |
//! | sine (0.05) | 5e-3 | 0 | 0.8 | cloud | 0.8 | 0.078 | 0.91 | 0.078 | 0.01 | 0.07 | periodic 0.84 |
//! | two tones | 4e-12 | 4e-12 | 0.0 | loop | 53 | 0.010 | large | 0.010 | 0.00 | 0.00 | quasi-periodic 0.97 |
//! | two tones (0.05) | 4e-3 | 0 | 0.5 | cloud | 5.2 | 0.098 | 0.74 | 0.087 | 0.02 | 0.05 | quasi-periodic 0.75 |
//! | two, bent | 3e-11 | 3e-11 | 0.0 | loop | 51 | 0.015 | 0.02 | 0.016 | 0.00 | 0.56 | quasi-periodic 0.97 |
//! | three tones | 3e-11 | 3e-11 | 0.0 | cloud | 20 | 0.031 | 0.13 | 0.031 | 0.00 | 0.01 | quasi-periodic 0.84 |
//! | second tone 0.05 (0.05) | 5e-3 | 0 | 0.7 | cloud | 0.8 | 0.086 | 0.87 | 0.081 | 0.01 | 0.05 | not sure 0.40 |
//! | Roessler 2.5 | 5e-11 | 5e-11 | 0.0 | 1 point | 0.0 | 0.000 | 0.02 | 0.000 | 0.00 | 0.00 | periodic 0.95 |
//! | Roessler 4.15 | 3e-10 | 3e-10 | 0.0 | 8 points | 0.0 | 0.003 | 0.01 | 0.003 | 0.00 | 0.15 | periodic 0.95 |
//! | Roessler 4.3 | 3e-3 | 3e-3 | 18 | arc | 5.7 | 0.013 | 0.04 | 0.050 | 0.93 | 0.16 | chaotic 0.97 |
//! | Roessler 4.5 | 3e-2 | 3e-2 | 220 | arc | 9.1 | 0.012 | 0.04 | 0.092 | 1.55 | 0.35 | chaotic 0.99 |
//! | Roessler 5.7 | 4e-2 | 4e-2 | 90 | arc | 20 | 0.021 | 0.05 | 0.276 | 1.68 | 0.74 | chaotic 1.00 |
//! | Lorenz x | 1 | 1 | 340 | arc | 7.5 | 0.054 | 0.08 | 0.967 | 0.24 | 1.00 | chaotic 1.00 |
//! | white noise | 1 | 0 | 0.9 | cloud | 0.8 | 1.031 | 1.03 | 1.012 | -0.01 | 1.00 | noise 0.90 |
//! | AR(1), 0.8 | 1 | 0.8 | 1.0 | cloud | 1.0 | 0.978 | 0.98 | 1.004 | 0.07 | 1.00 | noise 0.88 |
//! | AR(1), 0.99 | 0.8 | 0.8 | 6.1 | cloud | 0.8 | 0.364 | 1.05 | 0.981 | 0.06 | 0.99 | noise 0.77 |
//! | AR(2), radius 0.997 | 0.3 | 0.3 | 2.1 | cloud | 1.6 | 0.385 | 1.06 | 0.958 | 0.14 | 0.94 | noise 0.85 |
//!
//! The squeaks that come with the program (displacement at 200 kHz, windows every 10 to 15 ms after
//! the start has died away, seeds that end in the motion named). Parting, least, median and
//! largest, and the windows called periodic P, quasi-periodic Q, chaotic C, not sure ?:
//!
//! | squeak | 20 ms | 40 ms | 100 ms | 200 ms |
//! |---|---|---|---|---|
//! | `periodic-2deg`, `mode-shift-3.5deg` | 0.00; P 48 | 0.00; P 44 | 0.00; P 22 | 0.00; P 8 |
//! | `torus-3deg`, seeds 1, 4, 5 | 0.20, 0.35, 0.53; Q 75, ? 9 | 0.00, 0.01, 0.14; Q 78 | -0.09, 0.00, 0.17; Q 39 | 0.00, 0.04, 0.27; Q 21 |
//! | `torus-3deg`, seed 3; `chaos-5deg`, seed 3 | 0.00, 0.00, 0.01; Q 56 | -0.01, 0.00, 0.00; Q 52 | 0.00; Q 26 | 0.00; Q 14 |
//! | `chaos-5deg`, seeds 1, 2, 4 | 0.08, 0.57, 0.95; C 67, ? 7, Q 10 | 0.14, 0.80, 1.15; C 75, ? 3 | 0.15, 0.73, 1.35; C 39 | 0.45, 0.67, 1.16; C 21 |
//! | `chaos-5deg`, seed 5 | 0.12, 0.33, 0.52; C 11, ? 15, Q 2 | 0.07, 0.10, 0.12; Q 26 | 0.00, 0.01, 0.03; Q 13 | 0.02, 0.03, 0.04; Q 7 |
//!
//! In 20 ms, 84 turns, they cannot be told apart for sure: that torus swells at 40 Hz, too, so that
//! it does not come back in so short a time; and the chaos, whose neighbours part by `exp(50 t / s)`,
//! has calm stretches. Seed 5 ends in a torus that looks like chaos for so long.
//!
//! The time for 8000 samples is 6 ms, at most 15 ms, on one core.

mod belief;
mod evidence;
mod neighbourhood;
mod signs;
mod weigh;

use serde::{Deserialize, Serialize};

use super::{AnalysisError, range};
use belief::Belief;
pub use evidence::{Evidence, Regime};
use signs::Signs;

/// The verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The kind.
    pub regime: Regime,
    /// The share of all belief that is the kind's alone, 0 to 1; where none has half of it, the
    /// largest there is.
    pub confidence: f64,
    /// What led there, strongest first; not empty.
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

    /// The most samples that are judged. Of a longer record the last ones are; if it is sampled
    /// finely, means of a few samples each (a low-pass), as long as 12 of them are left in a turn:
    /// 200 ms of a tone of 4 kHz at 200 kHz are judged whole, 50 ms of one of 12 kHz.
    pub const MOST_SAMPLES: usize = 10_000;
}

/// Samples of a long record are joined until this many are left in a lag, a quarter turn.
const LEFT_IN_A_LAG: usize = 3;

/// A verdict needs this share of all belief.
const BELIEVED: f64 = 0.5;

/// Samples that differ by less than this share of the largest do so by rounding.
const ROUNDING: f64 = 1e-12;

/// Tells the kind of motion of a signal. Neither its amplitude nor its offset matter unless
/// [`RegimeSearch::silence`] is given, and at most [`RegimeSearch::MOST_SAMPLES`] samples count. A
/// signal that does not change at all is silent. The result does not depend on the number of
/// threads.
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
    let (recent, joined) = recent(samples)?;
    let [low, high] = range(recent.iter().copied());
    let amplitude = 0.5 * (high - low);
    if amplitude <= ROUNDING * low.abs().max(high.abs()) || amplitude < search.silence {
        return Ok(silent(amplitude, search.silence));
    }
    let scaled: Vec<f64> = recent.iter().map(|x| (x - low) / amplitude - 1.0).collect();
    let evidence = weigh::evidence(&Signs::of(&scaled, search.sample_rate / joined as f64)?);
    let mut belief = Belief::open();
    for piece in evidence.iter().filter(|e| e.says != [Regime::Unsure]) {
        belief.join(&piece.says, piece.weight);
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

/// The samples to judge, and how many of the record's each is the mean of.
fn recent(samples: &[f64]) -> Result<(Vec<f64>, usize), AnalysisError> {
    let last = |count: usize| &samples[samples.len().saturating_sub(count)..];
    let most = RegimeSearch::MOST_SAMPLES;
    if samples.len() <= most {
        return Ok((samples.to_vec(), 1));
    }
    let wanted = samples.len().div_ceil(most);
    let joined = (signs::lag(last(most))? / LEFT_IN_A_LAG).clamp(1, wanted);
    let whole = samples.len().min(most * joined) / joined * joined;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / joined as f64;
    let means = last(whole).chunks_exact(joined).map(mean);
    Ok((means.collect(), joined))
}

/// The verdict on a signal that hardly moves.
fn silent(amplitude: f64, silence: f64) -> Verdict {
    // At the limit itself it might as well be called faint.
    let confidence = 1.0 - 0.5 * amplitude / silence.max(amplitude).max(f64::MIN_POSITIVE);
    let confidence = if silence > 0.0 { confidence } else { 1.0 };
    Verdict {
        regime: Regime::Silent,
        confidence,
        evidence: vec![Evidence::new(
            "amplitude",
            amplitude,
            &[Regime::Silent],
            confidence,
            format!("The amplitude is {amplitude:.3e}; below {silence:.3e} it is silent."),
        )],
    }
}

#[cfg(test)]
mod tests;
