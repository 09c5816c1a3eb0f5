//! What `squeakscope analyse` says.
//!
//! Amplitudes, levels and distances are in the signal's own unit; a field without a unit in its
//! name is one of these, a share (0 to 1) or a count.

mod words;

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::report::FileReport;
use crate::VERSION;
use crate::analysis::{
    Bases, Divergence, LagReason, Measures, Norm, SectionShape, Threshold, deviation, range,
};
use crate::study::signal::{RecurrenceReport, SignalReport};

/// Result of `squeakscope analyse`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnalyseReport {
    /// Version of the program.
    pub version: &'static str,
    /// The file.
    pub file: PathBuf,
    /// The signal.
    pub signal: SignalFacts,
    /// The kind of motion.
    pub verdict: VerdictReport,
    /// What it is made of.
    pub spectrum: SpectrumReport,
    /// Samples that the methods below used, the newest ones.
    pub nonlinear_samples: usize,
    /// The state space.
    pub embedding: EmbeddingReport,
    /// When it comes back.
    pub recurrence: RecurrenceMeasures,
    /// Where it passes through a surface.
    pub section: SectionReport,
    /// How nearest neighbours part (Rosenstein).
    pub rosenstein: DivergenceReport,
    /// How neighbourhoods part (Kantz).
    pub kantz: DivergenceReport,
    /// The 0-1 test for chaos.
    pub zero_one: ZeroOneReport,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// Facts of a signal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignalFacts {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// How many samples.
    pub samples: usize,
    /// Samples a second.
    pub rate_hz: f64,
    /// Time of the first sample.
    pub start_s: f64,
    /// How long it lasts.
    pub duration_s: f64,
    /// Smallest sample.
    pub smallest: f64,
    /// Largest sample.
    pub largest: f64,
    /// Mean.
    pub mean: f64,
    /// Root mean square about the mean.
    pub deviation: f64,
}

/// The kind of motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerdictReport {
    /// `silent`, `transient`, `periodic`, `quasi-periodic`, `chaotic`, `noise`, `not sure`.
    pub regime: String,
    /// How sure, 0 to 1.
    pub confidence: f64,
    /// What led there, strongest first.
    pub evidence: Vec<EvidenceReport>,
}

/// One piece of evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EvidenceReport {
    /// What was measured.
    pub what: &'static str,
    /// The number.
    pub value: f64,
    /// The kinds it speaks for: one of them.
    pub says: String,
    /// How strongly, 0 to 1.
    pub weight: f64,
    /// A sentence.
    pub words: String,
}

/// Spectrum and its lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpectrumReport {
    /// Spacing of the bins.
    pub bin_hz: f64,
    /// Share of the power in the noise floor.
    pub floor_share: f64,
    /// First base frequency.
    pub f1_hz: Option<f64>,
    /// Second base frequency.
    pub f2_hz: Option<f64>,
    /// Lowest difference frequency of both.
    pub beat_hz: Option<f64>,
    /// Probability that chance would name as many lines.
    pub chance: f64,
    /// The lines, strongest first.
    pub lines: Vec<NamedLineReport>,
}

/// A spectral line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedLineReport {
    /// Frequency.
    pub frequency_hz: f64,
    /// Amplitude.
    pub amplitude: f64,
    /// Name such as `f1`, `3 f1`, `f2 - 3 f1`; empty where nothing fits.
    pub label: String,
    /// Frequency less that of the name.
    pub misfit_hz: Option<f64>,
}

/// The state space.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EmbeddingReport {
    /// Delay, samples.
    pub lag_samples: usize,
    /// Delay.
    pub lag_s: f64,
    /// `first minimum`, `first decay`, `largest`: of the mutual information; `given`.
    pub lag_reason: &'static str,
    /// Dimension.
    pub dimension: usize,
    /// Whether the share of false neighbours came down to 1 % there.
    pub unfolded: bool,
    /// Theiler window.
    pub theiler_s: f64,
    /// Mutual information at the lags 0, 1, ... samples.
    pub mutual_information_bits: Vec<f64>,
    /// Share of false neighbours in the dimensions 1, 2, ...
    pub false_neighbours: Vec<f64>,
}

/// Recurrence quantification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecurrenceMeasures {
    /// `euclidean`, `maximum` or `manhattan`.
    pub norm: &'static str,
    /// `rate`, `distance`, `spread` or `neighbours`.
    pub threshold: &'static str,
    /// Its value.
    pub threshold_value: f64,
    /// The distance that it comes to.
    pub epsilon: Option<f64>,
    /// Every so many samples one state was taken.
    pub stride_samples: usize,
    /// How many states.
    pub states: usize,
    /// Theiler window.
    pub theiler_s: f64,
    /// Most frequent spacing of the diagonals.
    pub period_s: Option<f64>,
    /// The measures.
    pub whole: MeasuresReport,
    /// The measures of windows along the signal.
    pub along: Vec<MeasuresAtReport>,
}

/// Measures of one recurrence plot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuresReport {
    /// RR.
    pub recurrence_rate: f64,
    /// DET.
    pub determinism: Option<f64>,
    /// L.
    pub mean_diagonal_s: Option<f64>,
    /// Lmax.
    pub longest_diagonal_s: f64,
    /// DIV.
    pub divergence_per_s: Option<f64>,
    /// ENTR.
    pub entropy_nats: Option<f64>,
    /// TREND.
    pub trend_per_1000_states: Option<f64>,
    /// LAM.
    pub laminarity: Option<f64>,
    /// TT.
    pub trapping_time_s: Option<f64>,
    /// Vmax.
    pub longest_vertical_s: f64,
    /// T1.
    pub recurrence_time_1_s: Option<f64>,
    /// T2.
    pub recurrence_time_2_s: Option<f64>,
}

/// Measures of one window.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuresAtReport {
    /// Centre of the window.
    pub time_s: f64,
    /// The measures.
    #[serde(flatten)]
    pub measures: MeasuresReport,
}

/// The section `y(t + lag) = level`, rising.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionReport {
    /// The level.
    pub level: f64,
    /// `points`, `loop`, `arc`, `cloud` or `too few`.
    pub shape: &'static str,
    /// How many points, where it is points.
    pub points: Option<usize>,
    /// Mean time from one passage to the next.
    pub mean_return_s: Option<f64>,
    /// The passages.
    pub passages: Vec<PassageReport>,
}

/// One passage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassageReport {
    /// When: the `t` of `y(t)`.
    pub time_s: f64,
    /// `y(t)`.
    pub y: f64,
    /// `y(t + 2 lag)`.
    pub y_two_lags_later: f64,
}

/// How neighbours part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DivergenceReport {
    /// The largest Lyapunov exponent, if the curve has a straight part.
    pub exponent_per_s: Option<f64>,
    /// Its standard error.
    pub error_per_s: Option<f64>,
    /// Begin of the straight part.
    pub from_s: Option<f64>,
    /// End of the straight part.
    pub to_s: Option<f64>,
    /// Spacing of the curve.
    pub step_s: f64,
    /// Mean natural logarithm of the distance.
    pub curve: Vec<f64>,
}

/// The 0-1 test for chaos.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZeroOneReport {
    /// Near 0 regular, near 1 chaotic (or noise).
    pub k: f64,
    /// Every so many samples one was taken.
    pub stride_samples: usize,
    /// How many samples were taken.
    pub samples: usize,
}

impl AnalyseReport {
    /// What there is to say of an analysed signal.
    pub fn new(file: &Path, report: &SignalReport, files: Vec<FileReport>) -> Self {
        let signal = &report.signal;
        let rate = signal.rate;
        let delay = &report.delay;
        let ahead = signal.samples.len() - report.nonlinear_samples;
        let passages = report.section.iter().map(|crossing| PassageReport {
            time_s: signal.start + (ahead as f64 + crossing.sample) / rate,
            y: crossing.point[0],
            y_two_lags_later: crossing.point[2],
        });
        let (shape, points) = match report.shape {
            SectionShape::TooFew => ("too few", None),
            SectionShape::Points(count) => ("points", Some(count)),
            SectionShape::Loop => ("loop", None),
            SectionShape::Arc => ("arc", None),
            SectionShape::Cloud => ("cloud", None),
        };
        let mean_return = match &report.section[..] {
            [first, .., last] => {
                let returns = (report.section.len() - 1) as f64;
                Some((last.sample - first.sample) / returns / rate)
            }
            _ => None,
        };
        Self {
            version: VERSION,
            file: file.to_owned(),
            signal: facts(report),
            verdict: verdict(report),
            spectrum: spectrum(report),
            nonlinear_samples: report.nonlinear_samples,
            embedding: EmbeddingReport {
                lag_samples: delay.lag,
                lag_s: delay.lag as f64 / rate,
                lag_reason: match delay.reason {
                    LagReason::FirstMinimum => "first minimum",
                    LagReason::FirstDecay => "first decay",
                    LagReason::Largest => "largest",
                },
                dimension: delay.dimension,
                unfolded: delay.unfolded,
                theiler_s: delay.theiler as f64 / rate,
                mutual_information_bits: delay.mutual.bits.clone(),
                false_neighbours: delay.neighbours.share.clone(),
            },
            recurrence: recurrence(&report.recurrence, rate),
            section: SectionReport {
                level: report.level,
                shape,
                points,
                mean_return_s: mean_return,
                passages: passages.collect(),
            },
            rosenstein: parting(&report.rosenstein, rate),
            kantz: parting(&report.kantz, rate),
            zero_one: ZeroOneReport {
                k: report.zero_one.k,
                stride_samples: report.zero_one_stride,
                samples: report.zero_one.samples,
            },
            files,
        }
    }
}

fn facts(report: &SignalReport) -> SignalFacts {
    let signal = &report.signal;
    let samples = &signal.samples;
    let [smallest, largest] = range(samples.iter().copied());
    SignalFacts {
        name: signal.name.clone(),
        unit: signal.unit.clone(),
        samples: samples.len(),
        rate_hz: signal.rate,
        start_s: signal.start,
        duration_s: signal.duration(),
        smallest,
        largest,
        mean: samples.iter().sum::<f64>() / samples.len() as f64,
        deviation: deviation(samples),
    }
}

fn verdict(report: &SignalReport) -> VerdictReport {
    let evidence = report.verdict.evidence.iter().map(|e| EvidenceReport {
        what: e.what,
        value: e.value,
        says: e.kinds(),
        weight: e.weight,
        words: e.words.clone(),
    });
    VerdictReport {
        regime: report.verdict.regime.to_string(),
        confidence: report.verdict.confidence,
        evidence: evidence.collect(),
    }
}

fn spectrum(report: &SignalReport) -> SpectrumReport {
    let (f1, f2) = match report.naming.bases {
        Bases::None => (None, None),
        Bases::One { f1 } => (Some(f1), None),
        Bases::Two { f1, f2 } => (Some(f1), Some(f2)),
    };
    let lines = report.lines.iter().map(|named| NamedLineReport {
        frequency_hz: named.line.frequency,
        amplitude: named.line.amplitude,
        label: named.name.map_or_else(String::new, |name| name.to_string()),
        misfit_hz: named.misfit,
    });
    SpectrumReport {
        bin_hz: report.spectrum.bin,
        floor_share: report.floor_share,
        f1_hz: f1,
        f2_hz: f2,
        beat_hz: report.naming.bases.beat(),
        chance: report.naming.chance,
        lines: lines.collect(),
    }
}

fn recurrence(report: &RecurrenceReport, rate: f64) -> RecurrenceMeasures {
    let state = report.stride as f64 / rate;
    let (threshold, threshold_value) = match report.rule.threshold {
        Threshold::Rate(rate) => ("rate", rate),
        Threshold::Distance(distance) => ("distance", distance),
        Threshold::Spread(spread) => ("spread", spread),
        Threshold::Neighbours(count) => ("neighbours", count as f64),
    };
    let along = report.along.iter().map(|at| MeasuresAtReport {
        time_s: at.time,
        measures: measures(&at.measures, state),
    });
    RecurrenceMeasures {
        norm: match report.rule.norm {
            Norm::Euclidean => "euclidean",
            Norm::Maximum => "maximum",
            Norm::Manhattan => "manhattan",
        },
        threshold,
        threshold_value,
        epsilon: report.epsilon,
        stride_samples: report.stride,
        states: report.counts.columns,
        theiler_s: report.rule.theiler as f64 * state,
        period_s: report.period,
        whole: measures(&report.measures, state),
        along: along.collect(),
    }
}

/// Measures in seconds; `state` is the time from one state to the next, s.
fn measures(measures: &Measures, state: f64) -> MeasuresReport {
    let seconds = |states: Option<f64>| states.map(|states| states * state);
    MeasuresReport {
        recurrence_rate: measures.recurrence_rate,
        determinism: measures.determinism,
        mean_diagonal_s: seconds(measures.mean_diagonal),
        longest_diagonal_s: measures.longest_diagonal as f64 * state,
        divergence_per_s: measures.divergence.map(|per_state| per_state / state),
        entropy_nats: measures.entropy,
        trend_per_1000_states: measures.trend,
        laminarity: measures.laminarity,
        trapping_time_s: seconds(measures.trapping_time),
        longest_vertical_s: measures.longest_vertical as f64 * state,
        recurrence_time_1_s: seconds(measures.recurrence_time_1),
        recurrence_time_2_s: seconds(measures.recurrence_time_2),
    }
}

fn parting(divergence: &Divergence, rate: f64) -> DivergenceReport {
    let region = divergence.region;
    DivergenceReport {
        exponent_per_s: region.map(|r| r.slope * rate),
        error_per_s: region.map(|r| r.error * rate),
        from_s: region.map(|r| r.from as f64 / rate),
        to_s: region.map(|r| r.to as f64 / rate),
        step_s: 1.0 / rate,
        curve: divergence.curve.clone(),
    }
}
