//! The analyses that slide along a stream, fitted to a signal that has been analysed as a whole.

use super::SignalReport;
use super::analyse::{period_of, spectrogram_window};
use crate::analysis::{Direction, DivergenceMethod, DivergenceSearch, Line};
use crate::scene::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, NearnessSpec, QuantificationSpec,
    RecurrenceSpec, RegimeSpec, SectionSpec, SectionSurface, Setting, SlidingSpec, SpectrogramSpec,
    SpectrumSpec,
};

/// Looks at a window along the whole signal.
const LOOKS: f64 = 200.0;

/// Periods in a window whose lines are read, in a recurrence plot, and in a window of which
/// chaos or regime is told.
const SPECTRUM_PERIODS: f64 = 100.0;
const PLOT_PERIODS: f64 = 10.0;
const CHAOS_PERIODS: f64 = 80.0;
const VERDICT_PERIODS: f64 = 400.0;

/// A window of which chaos is told has about so many samples at least and at most. One for the
/// verdict may have more: it thins what is sampled finely, and weak chaos takes long to show.
const CHAOS_SAMPLES: [f64; 2] = [2000.0, 8000.0];
const VERDICT_SAMPLES: [f64; 2] = [2000.0, 40_000.0];

/// Windows along a stream that suit a signal: so many of its dominant periods, never more than a
/// quarter of it; lag and dimension as the report has them.
pub fn live_analysis(report: &SignalReport) -> AnalysisSpec {
    let signal = &report.signal;
    let (rate, duration) = (signal.rate, signal.duration());
    let lines: Vec<Line> = report.lines.iter().map(|named| named.line).collect();
    let period = period_of(&lines, &report.delay, rate) / rate;
    let sliding = |window: f64, looks: f64| SlidingSpec {
        window: window.min(duration / 4.0),
        every: (duration / looks).max(1.0 / rate),
    };
    let long = |periods: f64, samples: [f64; 2]| {
        let [fewest, most] = samples.map(|samples| samples / rate);
        (periods * period).clamp(fewest, most)
    };
    let shortest = spectrogram_window(signal.samples.len(), period * rate) as f64 / rate;
    let lag = report.delay.lag as f64 / rate;
    let embedding = EmbeddingSpec {
        lag: Setting::Given(lag),
        dimension: Setting::Given(report.delay.dimension),
    };
    let nearness = NearnessSpec {
        norm: report.recurrence.rule.norm,
        threshold: report.recurrence.rule.threshold,
    };
    let step = report.recurrence.stride as f64 / rate;
    let parting = long(CHAOS_PERIODS, CHAOS_SAMPLES);
    let parting_samples = (parting.min(duration / 4.0) * rate) as usize;
    AnalysisSpec {
        spectrum: Some(SpectrumSpec {
            sliding: sliding(SPECTRUM_PERIODS * period, LOOKS),
        }),
        spectrogram: Some(SpectrogramSpec {
            sliding: sliding(shortest, 2.0 * LOOKS),
            max_frequency: highest_frequency(report),
        }),
        delay: Some(DelaySpec {
            sliding: sliding(parting, LOOKS / 10.0),
            largest_lag: (4.0 * lag)
                .min(parting_samples as f64 / rate / 25.0)
                .max(lag),
            largest_dimension: 10,
            bins: 32,
            false_share: 0.01,
        }),
        recurrence: Some(RecurrenceSpec {
            sliding: sliding(PLOT_PERIODS * period, LOOKS),
            size: 288,
            embedding,
            nearness,
        }),
        quantification: Some(QuantificationSpec {
            sliding: sliding(1000.0 * step, LOOKS),
            step,
            embedding,
            nearness,
            theiler: lag,
            least_diagonal: 2,
            least_vertical: 2,
        }),
        section: Some(SectionSpec {
            every: duration / LOOKS,
            surface: SectionSurface::Delay {
                lag: Setting::Given(lag),
                level: report.level,
            },
            direction: Direction::Rising,
        }),
        chaos: Some(chaos(
            report,
            sliding(parting, LOOKS / 5.0),
            parting_samples,
        )),
        regime: Some(RegimeSpec {
            sliding: sliding(long(VERDICT_PERIODS, VERDICT_SAMPLES), LOOKS / 4.0),
            silence: 0.0,
        }),
        exponents: None,
        butterfly: None,
    }
}

/// How neighbours part in windows of so many samples.
fn chaos(report: &SignalReport, sliding: SlidingSpec, samples: usize) -> ChaosSpec {
    let (rate, delay) = (report.signal.rate, &report.delay);
    let rules = DivergenceSearch::for_delay(delay.lag, delay.dimension, delay.theiler, samples);
    ChaosSpec {
        sliding,
        embedding: EmbeddingSpec {
            lag: Setting::Given(delay.lag as f64 / rate),
            dimension: Setting::Given(delay.dimension),
        },
        theiler: delay.theiler as f64 / rate,
        horizon: rules.horizon as f64 / rate,
        method: DivergenceMethod::Rosenstein,
    }
}

/// The highest frequency worth showing, Hz: half as much again as that of the highest line, or all
/// there is.
pub fn highest_frequency(report: &SignalReport) -> f64 {
    let nyquist = 0.5 * report.signal.rate;
    let lines = report.lines.iter().map(|named| named.line.frequency);
    let highest = lines.fold(0.0, f64::max);
    if highest > 0.0 {
        (1.5 * highest).min(nyquist)
    } else {
        nyquist
    }
}
