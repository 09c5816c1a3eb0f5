//! Settings of the sliding analyses, derived from the analysis of the whole signal.

use super::SignalAnalysis;
use super::analyse::{period_of, spectrogram_window};
use crate::analysis::{
    chaos::{DivergenceMethod, DivergenceSearch},
    poincare::Direction,
};
use crate::scene::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, QuantificationSpec, RecurrenceSpec,
    RegimeSpec, SectionSpec, SectionSurface, SpectrogramSpec, SpectrumSpec, ThresholdSpec,
};

/// Evaluations of a window along the whole signal.
const EVALUATIONS: f64 = 200.0;

/// Periods per window of the spectrum, of a recurrence plot, and of the windows for chaos and for the regime.
const SPECTRUM_PERIODS: f64 = 100.0;
const PLOT_PERIODS: f64 = 10.0;
const CHAOS_PERIODS: f64 = 80.0;
const REGIME_PERIODS: f64 = 400.0;

/// Ratio of the upper limit of frequency axes to the highest line or harmonic, in a recording.
pub const FREQUENCY_MARGIN: f64 = 1.5;

/// Minimum and maximum samples of the windows for chaos and for the regime. The regime may use more: it thins
/// densely sampled signals, and weak chaos needs long windows.
const CHAOS_SAMPLES: [f64; 2] = [2000.0, 8000.0];
const REGIME_SAMPLES: [f64; 2] = [2000.0, 40_000.0];

/// Settings of sliding analyses for a signal: windows of a number of dominant periods, at most a quarter of
/// the signal; delay and dimension from the report.
pub fn live_analysis(report: &SignalAnalysis) -> AnalysisSpec {
    let fit = Fit::new(report);
    let samples = report.signal.samples.len();
    let spectrogram = spectrogram_window(samples, fit.period * fit.rate) as f64 / fit.rate;
    let mut spec = AnalysisSpec {
        spectrum: Some(SpectrumSpec {
            window: fit.window(SPECTRUM_PERIODS * fit.period),
            every: fit.every(EVALUATIONS),
            rest: None,
        }),
        spectrogram: Some(SpectrogramSpec {
            window: fit.window(spectrogram),
            every: fit.every(2.0 * EVALUATIONS),
            max_frequency: report.highest_frequency(FREQUENCY_MARGIN),
        }),
        regime: Some(RegimeSpec {
            window: fit.window(fit.long(REGIME_PERIODS, REGIME_SAMPLES)),
            every: fit.every(EVALUATIONS / 4.0),
            silence: 0.0,
        }),
        ..AnalysisSpec::default()
    };
    fit.add_embedded(report, &mut spec);
    spec
}

/// What the windows are fitted to.
struct Fit {
    /// Sample rate of the signal, Hz.
    rate: f64,
    /// Duration of the signal, s.
    duration: f64,
    /// Dominant period, s.
    period: f64,
}

impl Fit {
    fn new(report: &SignalAnalysis) -> Self {
        let rate = report.signal.rate;
        let event = report.event().map(|event| event.frequency_hz);
        let embedding = report.embedding.get().ok();
        let lag = embedding.map(|embedding| embedding.choice.lag);
        Self {
            rate,
            duration: report.signal.duration(),
            period: period_of(event, &report.tones.lines, lag, rate) / rate,
        }
    }

    /// A window length, at most a quarter of the signal.
    fn window(&self, window: f64) -> f64 {
        window.min(self.duration / 4.0)
    }

    /// The interval between a number of evaluations along the signal.
    fn every(&self, evaluations: f64) -> f64 {
        (self.duration / evaluations).max(1.0 / self.rate)
    }

    /// A number of periods, limited to a range of samples.
    fn long(&self, periods: f64, samples: [f64; 2]) -> f64 {
        let [fewest, most] = samples.map(|samples| samples / self.rate);
        (periods * self.period).clamp(fewest, most)
    }

    /// Adds the analyses of the delay embedding, unless it was skipped: section, divergence of nearby trajectories, and
    /// recurrence.
    fn add_embedded(&self, report: &SignalAnalysis, spec: &mut AnalysisSpec) {
        let (Ok(embedding), Ok(recurrence)) = (report.embedding.get(), report.recurrence.get())
        else {
            return;
        };
        let (choice, lag) = (&embedding.choice, embedding.lag_s);
        let window = self.window(self.long(CHAOS_PERIODS, CHAOS_SAMPLES));
        let samples = (window * self.rate) as usize;
        let rules =
            DivergenceSearch::for_delay(choice.lag, choice.dimension, choice.theiler, samples);
        // A filtered stretch has another mean than the signal.
        let level = match (&report.part, report.section.get()) {
            (None, Ok(section)) => section.level,
            _ => report.facts.mean,
        };
        let lag_limit = samples as f64 / self.rate / 25.0;
        let delay_vectors = EmbeddingSpec {
            lag: Some(lag),
            dimension: Some(choice.dimension),
        };
        spec.delay = Some(DelaySpec {
            window,
            every: self.every(EVALUATIONS / 10.0),
            largest_lag: (4.0 * lag).min(lag_limit).max(lag),
            largest_dimension: 10,
            bins: 32,
            false_share: 0.01,
        });
        spec.section = Some(SectionSpec {
            every: self.duration / EVALUATIONS,
            surface: SectionSurface::Delay {
                lag: Some(lag),
                level,
            },
            direction: Direction::Rising,
        });
        spec.chaos = Some(ChaosSpec {
            window,
            every: self.every(EVALUATIONS / 5.0),
            embedding: delay_vectors,
            theiler: embedding.theiler_s,
            horizon: rules.horizon as f64 / self.rate,
            method: DivergenceMethod::Rosenstein,
        });
        let step = recurrence.stride_samples as f64 / self.rate;
        let criterion = ThresholdSpec {
            norm: recurrence.rule.norm,
            threshold: recurrence.rule.threshold,
        };
        spec.recurrence = Some(RecurrenceSpec {
            window: self.window(PLOT_PERIODS * self.period),
            every: self.every(EVALUATIONS),
            size: 288,
            embedding: delay_vectors,
            criterion,
        });
        spec.quantification = Some(QuantificationSpec {
            window: self.window(1000.0 * step),
            every: self.every(EVALUATIONS),
            step,
            embedding: delay_vectors,
            criterion,
            theiler: lag,
            least_diagonal: 2,
            least_vertical: 2,
        });
    }
}
