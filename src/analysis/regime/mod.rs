//! Classification of the type of motion, with its evidence and a confidence.
//!
//! No single number distinguishes a torus from chaos or chaos from noise, least of all in a short
//! record. [`classify`] therefore measures many quantities. Each is a piece of evidence: a set of
//! regimes that it supports, a weight and a sentence. They are combined by Dempster's rule (Shafer
//! 1976). Evidence for a set of regimes with weight `w` assigns the share `w` of all belief to that set.
//! Two pieces assign the product of their shares to the intersection of their sets; the share of empty
//! intersections is dropped and the rest normalised to 1. The verdict is the regime with more than half
//! of all belief to itself. The rule assumes independent evidence, which is only approximately true; the
//! confidence is therefore not that share but the probability of a right verdict at that share, fitted to
//! textbook signals of known regime. Without a regime with more than half of all belief the verdict is
//! undetermined, and says why and which regimes are likeliest. Evidence that contradicts the verdict says what its
//! method cannot see.
//!
//! # Evidence
//!
//! Delay vectors have the dimension 5 and the lag of the first clear minimum of the mutual information.
//! A period is four lags. Weights increase from 0 at the first limit to the value of the last column at
//! the second limit.
//!
//! | evidence | quantity | supports | limits | weight |
//! |---|---|---|---|---|
//! | envelope | change of ln rms over the record, and over its error | transient | 0.08, 0.3; 3, 6 | 0.95 |
//! | period drift | the same for ln time between crossings | transient | 0.01, 0.04; 5, 12 | 0.95 |
//! | change of motion | lasting change of ln rms, or of ln of the difference of successive periods; over its error | transient | 0.1, 0.3; 8, 14 | 0.95 |
//! | spectral lines | one tone (or two phase-locked tones, or a second below 2.5 % of the first); two or more | periodic; quasi-periodic | | 0.6 |
//! | broadband share | share of the power in the noise floor | periodic or quasi-periodic | 1e-3, 1e-6 | 0.7 |
//! | coloured broadband share | the part of it that is not white | chaotic (or noise) | 2.5e-4, 2.5e-3 | 0.8 |
//! | deterministic broadband share | broadband share over `short^2`, its value for noise | chaotic | 8, 50 | 0.8 |
//! | Poincare section | points; a loop; an arc | periodic; quasi-periodic; neither periodic nor noise | | 0.7; 0.8; 0.2 |
//! | repetition | distance of crossings one period apart over the noise, or over that of a weak second tone | periodic; not periodic | 2, 1.2; 3, 6 | 0.6; 0.7 |
//! | long-term predictability | `long / short` | periodic or quasi-periodic | 3, 1.5 | 0.7 |
//! | loss of predictability | `long / short`, of a nonlinear signal | chaotic | 4, 10 | 0.7 |
//! | slow divergence | ln of the distance of neighbours late over that early, of a nonlinear signal | chaotic (or transient) | 0.25, 0.5 | 0.8 |
//! | unpredictability | `short / linear` | noise | 0.8, 0.95 | 0.9 |
//! | 0-1 test | `K` | regular; chaotic or noise | 0.4, 0.1; 0.6, 0.9 | 0.3; 0.5 |
//! | Lyapunov exponent | rate of divergence of neighbours over its error, of a nonlinear signal | chaotic | 3, 8 | 0.6 |
//!
//! `short` and `long` are errors of prediction by analogues (E. N. Lorenz, J. Atmos. Sci. 26, 636, 1969)
//! over the standard deviation: the square root of half the mean square difference between the successor
//! of a state and that of its nearest neighbour, one lag and ten periods ahead. For a deterministic
//! signal with added noise the first is the noise (the delta test of Pi and Peterson, Neural Comput. 6,
//! 509, 1994). Where neighbours do not predict one lag ahead, as in strong chaos and in maps, the time is halved
//! as often as it brings them further ahead of the linear map. The noise is the smaller of `short` and the
//! square root of the broadband share: between sparse states `short` is larger than the noise. `linear` is the error of the best linear map one lag ahead. A signal is nonlinear if
//! neighbours predict it far better than the linear map (0.7, 0.3). Noise of any colour is not (after
//! Casdagli, J. R. Stat. Soc. B 54, 303, 1992).
//!
//! Slow divergence distinguishes weak chaos, with neighbours that diverge by a few percent per period,
//! from a torus of any number of frequencies, with neighbours at constant distance. It is the
//! root-mean-square difference of two neighbours after 15 to 30 % of the record, over that after 2 to
//! 5 %, when it has aligned with the direction of growth (the mean logarithm is that of Rosenstein,
//! Collins and De Luca, Physica D 65, 117, 1993; only the growth is used because the time is too short
//! for a rate). It reduces the weight of the lines and of the long-term predictability to the same
//! extent. It supports `chaotic or transient` if the nearest state at least a third of the record away
//! in time is more than `exp 0.6` times as far as the nearest of all: then the motion itself drifts and
//! separates neighbours (compare Schreiber, Phys. Rev. Lett. 78, 843, 1997).
//!
//! A change of motion is searched in eighths of the record: two or more before the change have one level, two or
//! more after it another, within their scatter (Welch's statistic). Of 24 families of stationary textbook signals
//! none exceeds 8.5; a chaotic motion that ends on a limit cycle has 14 to 180.
//!
//! Nonstationarity of the record reduces the weight of all other evidence. A record of fewer than 40
//! periods reduces all weights, to 0 below 10 periods. Further conditions are documented with the
//! constants in the source. Recurrence quantification is not used: it counts the same neighbours as the
//! predictions and would count them twice.
//!
//! # Basis of the limits
//!
//! 8000 samples (50 per period for tones, `dt` 0.1 for Roessler, 0.02 for Lorenz); standard deviation of
//! added noise in parentheses, tones of amplitude 1; verdict with its share of all belief:
//!
//! | signal | broadband | coloured | deterministic | section | repetition | short | short/linear | long | divergence | K | verdict |
//! |---|---|---|---|---|---|---|---|---|---|---|---|
//! | sine (0.01) | 2e-4 | 0 | 0.8 | 1 point | 0.8 | 0.016 | 0.92 | 0.016 | 0.02 | -0.01 | periodic 0.95 |
//! | sine (0.05) | 5e-3 | 0 | 0.8 | cloud | 0.8 | 0.078 | 0.91 | 0.078 | 0.01 | 0.07 | periodic 0.84 |
//! | two tones | 4e-12 | 4e-12 | 0.0 | loop | 53 | 0.010 | large | 0.010 | 0.00 | 0.00 | quasi-periodic 0.97 |
//! | two tones (0.05) | 4e-3 | 0 | 0.5 | cloud | 5.2 | 0.098 | 0.74 | 0.087 | 0.02 | 0.05 | quasi-periodic 0.75 |
//! | two tones, nonlinear | 3e-11 | 3e-11 | 0.0 | loop | 51 | 0.015 | 0.02 | 0.016 | 0.00 | 0.56 | quasi-periodic 0.97 |
//! | three tones | 3e-11 | 3e-11 | 0.0 | cloud | 20 | 0.031 | 0.13 | 0.031 | 0.00 | 0.01 | quasi-periodic 0.84 |
//! | second tone 0.05 (0.05) | 5e-3 | 0 | 0.7 | cloud | 0.8 | 0.086 | 0.87 | 0.081 | 0.01 | 0.05 | undetermined 0.40 |
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
//! Squeaks of the built-in scenes (displacement at 200 kHz, windows every 10 to 15 ms after the initial
//! transient, seeds that lead to the named motion). Minimum, median and maximum of the slow divergence,
//! and the number of windows classified as periodic P, quasi-periodic Q, chaotic C, undetermined ?:
//!
//! | squeak | 20 ms | 40 ms | 100 ms | 200 ms |
//! |---|---|---|---|---|
//! | `periodic-2deg`, `mode-shift-3.5deg` | 0.00; P 48 | 0.00; P 44 | 0.00; P 22 | 0.00; P 8 |
//! | `doubled-torus-3deg`, seeds 1, 4, 5 | 0.20, 0.35, 0.53; Q 75, ? 9 | 0.00, 0.01, 0.14; Q 78 | -0.09, 0.00, 0.17; Q 39 | 0.00, 0.04, 0.27; Q 21 |
//! | `doubled-torus-3deg`, seed 3; `chaos-5deg`, seed 3 | 0.00, 0.00, 0.01; Q 56 | -0.01, 0.00, 0.00; Q 52 | 0.00; Q 26 | 0.00; Q 14 |
//! | `chaos-5deg`, seeds 1, 2, 4 | 0.08, 0.57, 0.95; C 67, ? 7, Q 10 | 0.14, 0.80, 1.15; C 75, ? 3 | 0.15, 0.73, 1.35; C 39 | 0.45, 0.67, 1.16; C 21 |
//! | `chaos-5deg`, seed 5 | 0.12, 0.33, 0.52; C 11, ? 15, Q 2 | 0.07, 0.10, 0.12; Q 26 | 0.00, 0.01, 0.03; Q 13 | 0.02, 0.03, 0.04; Q 7 |
//!
//! In 20 ms, or 84 periods, torus and chaos cannot be distinguished reliably: that torus is also
//! modulated at 40 Hz, too slow to recur in so short a time; and the chaos, whose neighbours diverge by
//! `exp(50 t / s)`, has nearly regular phases. Seed 5 ends on a torus that looks like chaos in windows
//! of this length.
//!
//! 8000 samples take 6 ms, at most 15 ms, on one core.

mod belief;
mod calibration;
mod change;
mod evidence;
mod features;
mod neighbourhood;
mod weights;

use schemars::JsonSchema;
use serde::Serialize;

use super::{AnalysisError, mean, range};
use belief::Belief;
use calibration::confidence;
pub use evidence::{BlindSpot, Evidence, Limitation, Regime};
use features::Features;

/// Result of the classification.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// Regime.
    pub regime: Regime,
    /// Confidence: estimated probability that the regime is right, from textbook signals of known regime, 0
    /// to 1. Of an undetermined regime, the share of the evidence for the likeliest one: not a probability, and
    /// not shown.
    pub confidence: f64,
    /// The two likeliest regimes, likeliest first; fewer if there is no evidence for others.
    pub likeliest: Vec<Regime>,
    /// Limitations: why the regime is undetermined, or what the signal leaves open.
    pub limitations: Vec<Limitation>,
    /// Evidence, strongest first; not empty.
    pub evidence: Vec<Evidence>,
}

impl Verdict {
    /// The regime with its confidence, such as `chaotic, confidence 94 %`; of an undetermined one the likeliest
    /// regimes instead, such as `undetermined: quasi-periodic or chaotic`.
    pub fn summary(&self) -> String {
        let likeliest: Vec<String> = self.likeliest.iter().map(Regime::to_string).collect();
        match self.regime {
            Regime::Undetermined if !likeliest.is_empty() => {
                format!("{}: {}", self.regime, likeliest.join(" or "))
            }
            regime => regime.with_confidence(self.confidence),
        }
    }

    /// The confidence of a decided regime; `None` if the regime is undetermined.
    pub fn decided_confidence(&self) -> Option<f64> {
        (self.regime != Regime::Undetermined).then_some(self.confidence)
    }

    /// The limitations as a sentence; empty without any.
    pub fn limitations_text(&self) -> String {
        let all: Vec<String> = self.limitations.iter().map(Limitation::to_string).collect();
        let text = all.join("; ");
        let mut letters = text.chars();
        letters.next().map_or_else(String::new, |first| {
            format!("{}{}.", first.to_uppercase(), letters.as_str())
        })
    }
}

/// Parameters of [`classify`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegimeSearch {
    /// Sample rate, Hz.
    pub sample_rate: f64,
    /// Silence threshold of the amplitude, in the signal's unit; 0 if unknown.
    pub silence: f64,
}

impl RegimeSearch {
    /// Minimum number of samples.
    pub const MIN_SAMPLES: usize = 64;

    /// Maximum number of samples. Of a longer record only the end is used. If it is oversampled,
    /// successive samples are averaged (low-pass) as long as 12 averages per period remain: 200 ms of a
    /// 4 kHz tone at 200 kHz are used in full, of a 12 kHz tone 50 ms.
    pub const MAX_SAMPLES: usize = 10_000;
}

/// Minimum number of averages per lag (quarter period) of a long record.
const MIN_PER_LAG: usize = 3;

/// Minimum share of all belief for a verdict.
const MIN_BELIEF: f64 = 0.5;

/// A record is called nonstationary if all other evidence has less than this part of its weight.
const MAX_STATIONARITY: f64 = 0.7;

/// Sample differences below this share of the largest sample are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Classifies the type of motion of a signal. Amplitude and offset do not matter, except for the
/// comparison with [`RegimeSearch::silence`]. At most [`RegimeSearch::MAX_SAMPLES`] samples are used. A
/// constant signal is silent. The result does not depend on the number of threads.
///
/// # Errors
/// [`AnalysisError::TooShort`] below [`RegimeSearch::MIN_SAMPLES`].
pub fn classify(samples: &[f64], search: &RegimeSearch) -> Result<Verdict, AnalysisError> {
    if samples.len() < RegimeSearch::MIN_SAMPLES {
        return Err(AnalysisError::TooShort {
            what: "classification of motion",
            have: samples.len(),
            need: RegimeSearch::MIN_SAMPLES,
        });
    }
    let (recent, averaged) = recent(samples)?;
    let [low, high] = range(recent.iter().copied());
    let amplitude = 0.5 * (high - low);
    if amplitude <= ROUNDING * low.abs().max(high.abs()) || amplitude < search.silence {
        return Ok(silent(amplitude, search.silence));
    }
    let scaled: Vec<f64> = recent.iter().map(|x| (x - low) / amplitude - 1.0).collect();
    let features = Features::of(&scaled, search.sample_rate / averaged as f64)?;
    let mut evidence = weights::evidence(&features);
    let mut belief = Belief::vacuous();
    for piece in evidence
        .iter()
        .filter(|e| e.supports != [Regime::Undetermined])
    {
        belief.combine(&piece.supports, piece.weight);
    }
    let (strongest, share) = belief.strongest();
    let regime = match share >= MIN_BELIEF {
        true => strongest,
        false => Regime::Undetermined,
    };
    for piece in &mut evidence {
        piece.blind_spot = piece.blind_spot.filter(|_| piece.contradicts(regime));
    }
    Ok(Verdict {
        regime,
        confidence: match regime {
            Regime::Undetermined => share,
            _ => confidence(share),
        },
        likeliest: belief.likeliest(),
        limitations: limitations(regime, &features, &belief),
        evidence,
    })
}

/// What the signal leaves open.
fn limitations(regime: Regime, features: &Features, belief: &Belief) -> Vec<Limitation> {
    let conditions = match regime {
        Regime::Undetermined => [
            (Limitation::TooShort, weights::is_short(features)),
            (
                Limitation::Nonstationary,
                weights::stationarity(features) < MAX_STATIONARITY,
            ),
            (Limitation::Contradictory, belief.is_contradictory()),
        ],
        Regime::QuasiPeriodic => {
            let modulated = features.modulation.is_some();
            [(Limitation::Modulation, modulated); 3]
        }
        _ => return Vec::new(),
    };
    let first = conditions.into_iter().find(|(_, holds)| *holds);
    let none = (regime == Regime::Undetermined).then_some(Limitation::NoEvidence);
    first
        .map(|(limitation, _)| limitation)
        .or(none)
        .into_iter()
        .collect()
}

/// The samples to classify, and the number of original samples averaged in each.
fn recent(samples: &[f64]) -> Result<(Vec<f64>, usize), AnalysisError> {
    let last = |count: usize| &samples[samples.len().saturating_sub(count)..];
    let max = RegimeSearch::MAX_SAMPLES;
    if samples.len() <= max {
        return Ok((samples.to_vec(), 1));
    }
    let needed = samples.len().div_ceil(max);
    let averaged = (features::lag(last(max))? / MIN_PER_LAG).clamp(1, needed);
    let used = samples.len().min(max * averaged) / averaged * averaged;
    let means = last(used).chunks_exact(averaged).map(mean);
    Ok((means.collect(), averaged))
}

/// Verdict for a silent signal.
fn silent(amplitude: f64, silence: f64) -> Verdict {
    // Confidence is 0.5 at the threshold.
    let confidence = 1.0 - 0.5 * amplitude / silence.max(amplitude).max(f64::MIN_POSITIVE);
    let confidence = if silence > 0.0 { confidence } else { 1.0 };
    Verdict {
        regime: Regime::Silent,
        confidence,
        likeliest: vec![Regime::Silent],
        limitations: Vec::new(),
        evidence: vec![Evidence::new(
            "amplitude",
            amplitude,
            &[Regime::Silent],
            confidence,
            format!("The amplitude is {amplitude:.3e}, the silence threshold {silence:.3e}."),
        )],
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod textbook_tests;
