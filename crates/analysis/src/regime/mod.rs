//! Classification of the type of motion, with a confidence and its evidence.
//!
//! No single number distinguishes a torus from chaos or chaos from noise, least of all in a short record.
//! [`classify`] measures the features below and enters them into one multinomial logistic model, which gives the
//! probability of each regime and of *not enough evidence*. The verdict is the likeliest regime if its probability is
//! at least 0.6 and the record has at least ten periods and 500 samples; this probability is the confidence. The model is fitted to textbook signals and synthetic recordings
//! whose regime follows from their equations, and judged on other seeds and on families that the fit never saw: see
//! the page *Types of motion* of the program's guide.
//!
//! | feature | quantities |
//! |---|---|
//! | one tone | share of the lines' power that is in no harmonic or subharmonic of one base |
//! | two tones | share of the lines' power that is in no combination of two bases |
//! | broadband floor | share of the power between the lines, what exceeds twice the background, its coloured part, its ratio to noise of the size of the prediction error |
//! | Poincare section | whether the crossings form a closed curve, or points |
//! | repetition | distance of crossings one period apart over that explained by noise |
//! | predictability | error of prediction by analogues ten periods ahead; one lag ahead over that of the best linear map |
//! | divergence | growth of the distance of neighbours from 2 to 5 % of the record to 15 to 30 %; distance to states distant in time over that to the nearest |
//! | 0-1 test | `K` |
//! | steadiness | change of the level, of the motion and of the period along the record |
//! | record length | number of periods |
//!
//! Delay vectors have the dimension 5 and the lag of the first clear minimum of the mutual information; a period is
//! four lags. Prediction by analogues is that of E. N. Lorenz (J. Atmos. Sci. 26, 636, 1969): the square root of half
//! the mean square difference between the successor of a state and that of its nearest neighbour, over the standard
//! deviation. For a deterministic signal with added noise the error one lag ahead is the noise (Pi and Peterson, Neural
//! Comput. 6, 509, 1994). Where neighbours do not predict one lag ahead, as in strong chaos and in maps, the time is
//! halved as often as it brings them further ahead of the linear map. Noise of any colour is predicted as well by a
//! linear map (after Casdagli, J. R. Stat. Soc. B 54, 303, 1992). A slow divergence tells weak chaos from a torus of any
//! number of frequencies (only the growth is used; the time is too short for the rate of Rosenstein, Collins and De
//! Luca, Physica D 65, 117, 1993). A drift of the motion separates neighbours, too (compare Schreiber, Phys. Rev. Lett.
//! 78, 843, 1997). A change of motion is searched in eighths of the record by Welch's statistic.
//!
//! Sections and neighbours need more samples than a spectrum: a tonal signal is interpolated to 16 samples per period of
//! its highest line of at least 1 % of the strongest.

mod change;
mod evidence;
mod features;
mod model;
mod neighbourhood;

use schemars::JsonSchema;
use serde::Serialize;

use crate::significant;
use crate::{
    AnalysisError,
    stats::{mean, range},
};
pub use evidence::{Evidence, Limitation, Regime};
use features::Features;
use model::{CLASSES, INPUTS, Inputs, MODEL};
use neighbourhood::LONG_PERIODS;

/// Result of the classification.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// Regime.
    pub regime: Regime,
    /// Confidence: estimated probability that the regime is right, from signals of known regime, 0 to 1. Of an
    /// undetermined regime, the probability of the likeliest one, which is not shown.
    pub confidence: f64,
    /// The two likeliest regimes, likeliest first; fewer if others have a probability below 0.1.
    pub likeliest: Vec<Regime>,
    /// Why the regime is undetermined, or what the signal leaves open.
    pub limitation: Option<Limitation>,
    /// Evidence, strongest first, with what contradicts the verdict; not empty.
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
            regime if self.limitation == Some(Limitation::Modulated) => {
                format!(
                    "{regime}, modulated, confidence {:.0} %",
                    1e2 * self.confidence
                )
            }
            regime => regime.with_confidence(self.confidence),
        }
    }

    /// The regime without its confidence, such as `chaotic`; of an undetermined one also the likeliest regimes.
    pub fn name(&self) -> String {
        match self.regime {
            Regime::Undetermined => self.summary(),
            regime => regime.to_string(),
        }
    }

    /// The confidence of a decided regime; `None` if the regime is undetermined.
    pub fn decided_confidence(&self) -> Option<f64> {
        (self.regime != Regime::Undetermined).then_some(self.confidence)
    }
}

/// Parameters of [`classify`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegimeSearch {
    /// Sample rate, Hz.
    pub sample_rate: f64,
    /// Silence threshold of the amplitude, in the signal's unit; 0 if unknown.
    pub silence: f64,
    /// Power of the background of a recording, in the square of the signal's unit; 0 if unknown.
    pub background: f64,
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

/// Minimum probability of a verdict.
const MIN_PROBABILITY: f64 = 0.6;

/// Minimum probability of a regime that is named without a verdict.
const MIN_LIKELY: f64 = 0.1;

/// Number of periods below which a record is called short.
const FEW_PERIODS: f64 = 40.0;

/// Number of samples below which there is no verdict.
const MIN_VERDICT_SAMPLES: usize = 500;

/// Side lines nearer to their carrier than this share of its frequency are a slow modulation.
const SLOW: f64 = 0.02;

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
    let (amplitude, features) = features(samples, search)?;
    Ok(match features {
        Some(features) => verdict(&features),
        None => silent(amplitude, search.silence),
    })
}

/// Amplitude of a record, and its features unless it is silent.
fn features(
    samples: &[f64],
    search: &RegimeSearch,
) -> Result<(f64, Option<Features>), AnalysisError> {
    let (recent, averaged) = recent(samples)?;
    let [low, high] = range(recent.iter().copied());
    let amplitude = 0.5 * (high - low);
    if amplitude <= ROUNDING * low.abs().max(high.abs()) || amplitude < search.silence {
        return Ok((amplitude, None));
    }
    let scaled: Vec<f64> = recent.iter().map(|x| (x - low) / amplitude - 1.0).collect();
    let background = search.background / (amplitude * amplitude);
    let features = Features::of(&scaled, search.sample_rate / averaged as f64, background)?;
    Ok((amplitude, Some(features)))
}

/// The verdict of the model.
fn verdict(features: &Features) -> Verdict {
    let inputs = features.inputs();
    let probabilities = MODEL.probabilities(&inputs);
    let mut order: [usize; CLASSES.len()] = std::array::from_fn(|class| class);
    order.sort_by(|a, b| probabilities[*b].total_cmp(&probabilities[*a]));
    let regimes = order
        .into_iter()
        .filter(|class| CLASSES[*class] != Regime::Undetermined);
    let likeliest: Vec<usize> = regimes.take(2).collect();
    let probability = probabilities[likeliest[0]];
    let likeliest: Vec<Regime> = likeliest
        .into_iter()
        .filter(|class| probabilities[*class] >= MIN_LIKELY)
        .map(|class| CLASSES[class])
        .collect();
    let is_long =
        features.periods_seen >= LONG_PERIODS as f64 && features.samples >= MIN_VERDICT_SAMPLES;
    let regime = match likeliest.first() {
        Some(regime) if probability >= MIN_PROBABILITY && is_long => *regime,
        _ => Regime::Undetermined,
    };
    let is_modulated = features.lines.side.is_some_and(|side| side < SLOW);
    let (regime, limitation) = match regime {
        // A tone that is modulated slowly, as an ordinary squeak is, has the lines of a torus.
        Regime::QuasiPeriodic if is_modulated => (Regime::Periodic, Some(Limitation::Modulated)),
        regime => (regime, limitation(regime, features)),
    };
    Verdict {
        regime,
        confidence: probability,
        likeliest,
        limitation,
        evidence: evidence(features, &inputs, [order[0], order[1]]),
    }
}

/// The contribution of each feature to the odds of the likeliest class against the next, strongest first.
fn evidence(features: &Features, inputs: &Inputs, [first, second]: [usize; 2]) -> Vec<Evidence> {
    let terms = MODEL.contributions(inputs.as_slice());
    let mut all: Vec<Evidence> = Vec::new();
    for ((_, criterion), term) in INPUTS.iter().zip(terms) {
        let contribution = term[first] - term[second];
        match all.last_mut() {
            Some(last) if last.criterion == *criterion => last.contribution += contribution,
            _ => all.push(Evidence {
                criterion: (*criterion).to_owned(),
                supports: CLASSES[first],
                contribution,
                description: features.description(criterion),
            }),
        }
    }
    for piece in &mut all {
        if piece.contribution < 0.0 {
            piece.contribution = -piece.contribution;
            piece.supports = CLASSES[second];
        }
    }
    all.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
    all
}

/// What the signal leaves open.
fn limitation(regime: Regime, features: &Features) -> Option<Limitation> {
    match regime {
        Regime::Undetermined
            if features.periods_seen < FEW_PERIODS || features.samples < MIN_VERDICT_SAMPLES =>
        {
            Some(Limitation::TooShort)
        }
        Regime::Undetermined => Some(Limitation::NoEvidence),
        Regime::QuasiPeriodic if features.lines.is_modulated => Some(Limitation::Modulation),
        _ => None,
    }
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
        limitation: None,
        evidence: vec![Evidence {
            criterion: "amplitude".to_owned(),
            supports: Regime::Silent,
            contribution: (confidence / (1.0 - confidence).max(1e-3)).ln(),
            description: if amplitude > 0.0 {
                let [amplitude, silence] = [amplitude, silence].map(|x| significant(x, 3));
                format!("The amplitude is {amplitude}, the silence threshold {silence}.")
            } else {
                "All samples are equal.".to_owned()
            },
        }],
    }
}

#[cfg(test)]
mod fit_tests;
#[cfg(test)]
mod tests;
