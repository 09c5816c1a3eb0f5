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
/// the signal; delay and dimension from the report. Without an embedding or recurrence: only spectrum, spectrogram and
/// regime.
#[expect(
    clippy::too_many_lines,
    reason = "the settings of one analysis after the other"
)]
pub fn live_analysis(report: &SignalAnalysis) -> AnalysisSpec {
    let (rate, duration) = (report.signal.rate, report.signal.duration());
    let event = report.event().map(|event| event.frequency_hz);
    let embedding = report.embedding.get().ok();
    let lag = embedding.map(|embedding| embedding.choice.lag);
    let samples_per_period = period_of(event, &report.tones.lines, lag, rate);
    let period = samples_per_period / rate;
    let spectrogram = spectrogram_window(report.signal.samples.len(), samples_per_period);
    let window = |window: f64| window.min(duration / 4.0);
    let every = |evaluations: f64| (duration / evaluations).max(1.0 / rate);
    // A window of a number of periods, limited to a range of samples and to a quarter of the signal.
    let long_window = |periods: f64, samples: [f64; 2]| {
        let [fewest, most] = samples.map(|samples| samples / rate);
        window((periods * period).clamp(fewest, most))
    };
    let spec = AnalysisSpec {
        spectrum: Some(SpectrumSpec {
            window: window(SPECTRUM_PERIODS * period),
            every: every(EVALUATIONS),
            rest: None,
        }),
        spectrogram: Some(SpectrogramSpec {
            window: window(spectrogram as f64 / rate),
            every: every(2.0 * EVALUATIONS),
            max_frequency: report.highest_frequency(FREQUENCY_MARGIN),
        }),
        regime: Some(RegimeSpec {
            window: long_window(REGIME_PERIODS, REGIME_SAMPLES),
            every: every(EVALUATIONS / 4.0),
            silence: 0.0,
        }),
        ..AnalysisSpec::default()
    };
    let (Some(embedding), Ok(recurrence)) = (embedding, report.recurrence.get()) else {
        return spec;
    };
    let (choice, lag) = (&embedding.choice, embedding.lag_s);
    let chaos = long_window(CHAOS_PERIODS, CHAOS_SAMPLES);
    let samples = (chaos * rate) as usize;
    let rules = DivergenceSearch::for_delay(choice.lag, choice.dimension, choice.theiler, samples);
    let delay_vectors = EmbeddingSpec {
        lag: Some(lag),
        dimension: Some(choice.dimension),
    };
    let stride = recurrence.stride_samples.div_ceil(recurrence.interpolation);
    let step = stride as f64 / rate;
    let criterion = ThresholdSpec {
        norm: recurrence.rule.norm,
        threshold: recurrence.rule.threshold,
    };
    AnalysisSpec {
        delay: Some(DelaySpec {
            window: chaos,
            every: every(EVALUATIONS / 10.0),
            largest_lag: (4.0 * lag).min(samples as f64 / rate / 25.0).max(lag),
            largest_dimension: 10,
            bins: 32,
            false_share: 0.01,
        }),
        section: Some(SectionSpec {
            every: duration / EVALUATIONS,
            surface: SectionSurface::Delay {
                lag: Some(lag),
                level: report.facts.mean,
            },
            direction: Direction::Rising,
        }),
        chaos: Some(ChaosSpec {
            window: chaos,
            every: every(EVALUATIONS / 5.0),
            embedding: delay_vectors,
            theiler: embedding.theiler_s,
            horizon: rules.horizon as f64 / rate,
            method: DivergenceMethod::Rosenstein,
        }),
        recurrence: Some(RecurrenceSpec {
            window: window(PLOT_PERIODS * period),
            every: every(EVALUATIONS),
            size: 288,
            embedding: delay_vectors,
            criterion,
        }),
        quantification: Some(QuantificationSpec {
            window: window(1000.0 * step),
            every: every(EVALUATIONS),
            step,
            embedding: delay_vectors,
            criterion,
            theiler: lag,
            least_diagonal: 2,
            least_vertical: 2,
        }),
        ..spec
    }
}
