//! Classification of the type of motion, with a confidence and its evidence.
//!
//! No single number distinguishes a torus from chaos or chaos from noise, least of all in a short record.
//! [`classify`] measures the features below and enters them into one multinomial logistic model, which gives the
//! probability of each regime. The verdict is the likeliest regime if its probability is
//! at least 0.6 and the record has at least ten periods and 500 samples; this probability is the confidence. The model
//! is fitted to textbook signals and synthetic recordings whose regime follows from their equations, and judged on
//! other seeds and on families that the fit never saw: see the page *Types of motion* of the program's guide.
//!
//! | feature | quantity |
//! |---|---|
//! | one tone | share of the lines' power that is in no harmonic or subharmonic of one base |
//! | two tones | share of the lines' power that is in no combination of two bases |
//! | broadband floor | share of the power between the lines, less twice the background |
//! | white floor | share of the power in white noise of the level of the upper quarter of the frequencies |
//! | noise | power between the lines over that of noise of the size of the prediction error |
//! | repetition | distance of crossings of a Poincare section, at the mean or a standard deviation above it, one period apart, over that explained by noise |
//! | predictability | error of prediction by analogues |
//! | determinism | this error over that of the best linear map |
//! | divergence | growth of the distance of neighbours from 2 to 5 % of the record to its second eighth |
//! | 0-1 test | `K` |
//! | drift | distance to the nearest state at least half a record apart over that to the nearest state at any other time, median over the states |
//! | level | ratio of the largest to the smallest level of an eighth of the record, without the two extremes |
//! | lull | level of the quietest eighth of the record over that of the whole |
//! | trend of the period | slope of the period over its standard error |
//!
//! Delay vectors have the dimension 5 and the lag of the first clear minimum of the mutual information; a period is
//! four lags. Prediction by analogues is that of E. N. Lorenz (J. Atmos. Sci. 26, 636, 1969): the square root of half
//! the mean square difference between the successor of a state and that of its nearest neighbour, over the standard
//! deviation. For a deterministic signal with added noise the error one lag ahead is the noise (Pi and Peterson, Neural
//! Comput. 6, 509, 1994). The time ahead is the lag, or the half, quarter, ... of it at which neighbours are furthest
//! ahead of the best linear map: strong chaos is not predictable over a lag, and noise of any colour is predicted as
//! well by a linear map (after Casdagli, J. R. Stat. Soc. B 54, 303, 1992). A drift of the motion separates neighbours
//! (compare Schreiber, Phys. Rev. Lett. 78, 843, 1997).
//!
//! A floor that is stronger than a white floor is coloured: that of chaos or of a resonance. How strong matters, not only
//! its colour: the window of a spectrum leaks in colour, too.
//!
//! Sections and neighbours need more samples than a spectrum: a signal with lines is interpolated to 8 samples per
//! period of its highest line of at least 1 % of the strongest.

mod evidence;
mod features;
mod neighbourhood;

use std::ops::Range;
use std::sync::LazyLock;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use strum::VariantArray as _;

use crate::significant;
use crate::{
    AnalysisError,
    chaos::ROUNDING,
    delay::LAGS_PER_PERIOD,
    events::Span,
    logistic::Model,
    stats::{deviation, mean, range},
    tones::{LineCriterion, SpectrumAnalyser, Window},
};
pub use evidence::{Evidence, Limitation, Regime};
use features::{Feature, Features};
use neighbourhood::REFERENCES;

/// Result of the classification.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// Regime.
    pub regime: Regime,
    /// Confidence: estimated probability that the regime is right, from signals of known regime, 0 to 1. Of an
    /// undetermined regime, the probability of the likeliest one, which is not shown.
    pub confidence: f64,
    /// The two likeliest regimes, likeliest first; fewer if others are no likelier than by chance.
    pub likeliest: Vec<Regime>,
    /// Why the regime is undetermined, or what the signal leaves open.
    pub limitation: Option<Limitation>,
    /// Evidence, strongest first, with what contradicts the verdict; not empty.
    pub evidence: Vec<Evidence>,
    /// The intervals that are classified, s from the first sample: the record, or parts that are spread over it.
    pub intervals: Vec<Span>,
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
                let plain = regime.with_confidence(self.confidence);
                plain.replacen(',', ", modulated,", 1)
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

    /// Number of samples that are classified at once. A longer record is divided into intervals. If it is oversampled,
    /// successive samples are averaged (low-pass) before, as long as 12 averages per period remain: an interval
    /// has 200 ms of a 4 kHz tone at 200 kHz, and 50 ms of a 12 kHz tone.
    pub const MAX_SAMPLES: usize = 10_000;
}

/// Most intervals of a long record.
const INTERVALS: usize = 5;

/// Minimum probability of a verdict.
const MIN_PROBABILITY: f64 = 0.6;

/// Number of periods below which there is no verdict.
const MIN_PERIODS: f64 = 10.0;

/// The fitted model; the ignored test `the_model_is_fitted` repeats the fit.
static MODEL: LazyLock<Model> = LazyLock::new(|| Model::of_program(include_str!("model.json")));

/// The classes of the model: the regimes between silent and undetermined.
fn classes() -> &'static [Regime] {
    &Regime::VARIANTS[1..Regime::Undetermined as usize]
}

/// Classifies the type of motion of a signal. Amplitude and offset do not matter, except for the
/// comparison with [`RegimeSearch::silence`]. A constant signal is silent. Of a record longer than
/// [`RegimeSearch::MAX_SAMPLES`] intervals are classified that are spread evenly over it: a probability is the mean of
/// those in the intervals, and the evidence is that of the interval that is nearest to this mean. An interval with less
/// than half the level of the loudest one is part of a transient. The result does not depend on the number of threads.
///
/// # Errors
/// [`AnalysisError::TooShort`] below [`RegimeSearch::MIN_SAMPLES`].
pub fn classify(samples: &[f64], search: &RegimeSearch) -> Result<Verdict, AnalysisError> {
    let need = RegimeSearch::MIN_SAMPLES;
    AnalysisError::check_length("classification of motion", samples.len(), need)?;
    let (intervals, averaged) = intervals(samples)?;
    let found = features(samples, &intervals, averaged, search)?;
    let amplitudes = found.iter().map(|found| found.0);
    let silent = silent(range(amplitudes)[1], search.silence);
    let spans = intervals.iter().map(|interval| Span {
        start_s: interval.start as f64 / search.sample_rate,
        end_s: interval.end as f64 / search.sample_rate,
    });
    Ok(Verdict {
        intervals: spans.collect(),
        ..verdict(found.into_iter().map(|found| found.1)).unwrap_or(silent)
    })
}

/// Amplitude of each interval of a record, and its features unless it is silent or quiet.
fn features(
    samples: &[f64],
    intervals: &[Range<usize>],
    averaged: usize,
    search: &RegimeSearch,
) -> Result<Vec<(f64, Option<Features>)>, AnalysisError> {
    let averages = |interval: &Range<usize>| -> Vec<f64> {
        let samples = samples[interval.clone()].chunks_exact(averaged);
        samples.map(mean).collect()
    };
    let intervals: Vec<Vec<f64>> = intervals.iter().map(averages).collect();
    let [_, loudest] = range(intervals.iter().map(|samples| deviation(samples)));
    let of_interval = |part: &Vec<f64>| {
        let [low, high] = range(part.iter().copied());
        let amplitude = 0.5 * (high - low);
        let is_silent = amplitude <= ROUNDING * low.abs().max(high.abs());
        if is_silent || amplitude < search.silence || deviation(part) < 0.5 * loudest {
            return Ok((amplitude, None));
        }
        let scaled: Vec<f64> = part.iter().map(|x| (x - low) / amplitude - 1.0).collect();
        let background = search.background / (amplitude * amplitude);
        let features = Features::of(&scaled, search.sample_rate / averaged as f64, background)?;
        Ok((amplitude, Some(features)))
    };
    intervals.par_iter().map(of_interval).collect()
}

/// The features of an interval, the probability of each class, and the contribution of each feature to its logarithm.
type Assessment = (Features, Vec<f64>, Vec<Vec<f64>>);

fn assessed(features: Features) -> Assessment {
    let inputs = features.inputs.iter().map(|feature| feature.input);
    let inputs: Vec<f64> = inputs.collect();
    let mut probabilities = MODEL.probabilities(&inputs);
    let mut terms: Vec<Vec<f64>> = MODEL.contributions(&inputs).collect();
    // A tone that is modulated slowly, as an ordinary squeak is, has the lines of a torus, and is periodic either way.
    if features.lines.is_slow {
        let [tone, torus] =
            [Regime::Periodic, Regime::QuasiPeriodic].map(|regime| regime as usize - 1);
        let sum = probabilities[tone] + probabilities[torus];
        let share = probabilities[torus] / sum.max(f64::MIN_POSITIVE);
        // The logarithm of a sum changes with the mean of the logarithms.
        for term in &mut terms {
            term[tone] += share * (term[torus] - term[tone]);
        }
        probabilities[tone] += std::mem::take(&mut probabilities[torus]);
    }
    (features, probabilities, terms)
}

/// The verdict of the model on the intervals of a record, of which some are silent or quiet; `None` if all are.
fn verdict(intervals: impl Iterator<Item = Option<Features>>) -> Option<Verdict> {
    let all: Vec<_> = intervals.map(|found| found.map(assessed)).collect();
    let mean_of = |class: usize| {
        let if_quiet = f64::from(u8::from(class + 1 == Regime::Transient as usize));
        let each = all.iter();
        let each = each.map(|it| it.as_ref().map_or(if_quiet, |it| it.1[class]));
        each.sum::<f64>() / all.len() as f64
    };
    let probabilities: Vec<f64> = (0..classes().len()).map(mean_of).collect();
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|a, b| probabilities[*b].total_cmp(&probabilities[*a]));
    let likeliest = [order[0], order[1]];
    let (first, confidence) = (classes()[order[0]], probabilities[order[0]]);
    let distance = |it: &Assessment| (it.1[order[0]] - confidence).abs();
    let sounding = all.into_iter().flatten();
    let typical = sounding.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let (features, _, terms) = typical?;
    let lines = features.lines;
    // Four lags are less than a period of some motions. The strongest line of noise is no period.
    let periods = match first {
        Regime::Noise => features.periods,
        _ => features.periods.min(features.cycles),
    };
    let is_long = periods >= MIN_PERIODS && features.samples >= REFERENCES;
    let (regime, limitation) = match first {
        _ if !is_long => (Regime::Undetermined, Some(Limitation::TooShort)),
        _ if confidence < MIN_PROBABILITY => (Regime::Undetermined, Some(Limitation::NoEvidence)),
        Regime::Periodic if features.is_modulated => (first, Some(Limitation::Modulated)),
        Regime::QuasiPeriodic if lines.is_modulated => (first, Some(Limitation::Modulation)),
        _ => (first, None),
    };
    // Others are named if they are likelier than by chance.
    let by_chance = 1.0 / probabilities.len() as f64;
    let likely = likeliest
        .iter()
        .filter(|class| probabilities[**class] > by_chance);
    Some(Verdict {
        regime,
        confidence,
        likeliest: likely.map(|class| classes()[*class]).collect(),
        limitation,
        evidence: evidence(features.inputs, terms, likeliest),
        intervals: Vec::new(),
    })
}

/// The contribution of each feature, with its terms in the logarithm of the probability of each class, to the odds of
/// the likeliest class against the next, strongest first.
fn evidence(
    features: Vec<Feature>,
    terms: Vec<Vec<f64>>,
    [first, second]: [usize; 2],
) -> Vec<Evidence> {
    let evidence = |(feature, term): (Feature, Vec<f64>)| {
        let contribution = term[first] - term[second];
        let supported = if contribution < 0.0 { second } else { first };
        Evidence {
            criterion: feature.criterion.to_owned(),
            supports: classes()[supported],
            contribution: contribution.abs(),
            description: feature.description,
        }
    };
    let mut all: Vec<Evidence> = features.into_iter().zip(terms).map(evidence).collect();
    all.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
    all
}

/// The intervals to classify, and the number of samples that are averaged in each.
fn intervals(samples: &[f64]) -> Result<(Vec<Range<usize>>, usize), AnalysisError> {
    let (all, max) = (samples.len(), RegimeSearch::MAX_SAMPLES);
    if all <= max {
        return Ok((std::iter::once(0..all).collect(), 1));
    }
    let period = (LAGS_PER_PERIOD * features::lag(&samples[all - max..])?) as f64;
    let spectrum =
        SpectrumAnalyser::new(Window::BlackmanHarris, 1.0).analyse_welch(samples, max)?;
    let lines = spectrum.lines(&LineCriterion::default());
    let period = lines
        .first()
        .map_or(period, |line| period.min(1.0 / line.frequency));
    // Three averages per lag remain.
    let averaged = (period as usize / (3 * LAGS_PER_PERIOD)).clamp(1, all.div_ceil(max));
    let means = all / averaged;
    let (count, size) = (means.div_ceil(max).min(INTERVALS), means.min(max));
    let interval = |k: usize| {
        let first = k * (means - size) / (count - 1).max(1) * averaged;
        first..first + size * averaged
    };
    Ok(((0..count).map(interval).collect(), averaged))
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
        intervals: Vec::new(),
    }
}

#[cfg(test)]
mod fit_tests;
#[cfg(test)]
mod recording_tests;
#[cfg(test)]
mod tests;
