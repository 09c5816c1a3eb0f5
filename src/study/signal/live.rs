//! The analyses that slide along a stream, fitted to a signal that has been analysed as a whole.

use super::SignalReport;
use super::analyse::{period_of, spectrogram_window};
use crate::analysis::{Direction, DivergenceMethod, DivergenceSearch};
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
    let fit = Fit::new(report);
    AnalysisSpec {
        spectrum: Some(SpectrumSpec {
            sliding: fit.sliding(SPECTRUM_PERIODS * fit.period, LOOKS),
        }),
        spectrogram: Some(fit.spectrogram()),
        delay: Some(fit.delay()),
        recurrence: Some(RecurrenceSpec {
            sliding: fit.sliding(PLOT_PERIODS * fit.period, LOOKS),
            size: 288,
            embedding: fit.embedding(),
            nearness: fit.nearness(),
        }),
        quantification: Some(fit.quantification()),
        section: Some(SectionSpec {
            every: fit.duration / LOOKS,
            surface: SectionSurface::Delay {
                lag: Setting::Given(report.embedding.lag_s),
                level: report.section.level,
            },
            direction: Direction::Rising,
        }),
        chaos: Some(fit.chaos()),
        regime: Some(RegimeSpec {
            sliding: fit.sliding(fit.long(VERDICT_PERIODS, VERDICT_SAMPLES), LOOKS / 4.0),
            silence: 0.0,
        }),
        exponents: None,
        butterfly: None,
    }
}

/// A signal that windows are fitted to; times in s.
struct Fit<'a> {
    report: &'a SignalReport,
    rate: f64,
    duration: f64,
    /// The dominant period.
    period: f64,
    /// A window in which neighbours are followed.
    parting: f64,
}

impl<'a> Fit<'a> {
    fn new(report: &'a SignalReport) -> Self {
        let rate = report.signal.rate;
        let mut fit = Self {
            report,
            rate,
            duration: report.signal.duration(),
            period: period_of(&report.tones.lines, &report.embedding.choice, rate) / rate,
            parting: 0.0,
        };
        fit.parting = fit.long(CHAOS_PERIODS, CHAOS_SAMPLES);
        fit
    }

    /// A window, so often along the signal.
    fn sliding(&self, window: f64, looks: f64) -> SlidingSpec {
        SlidingSpec {
            window: window.min(self.duration / 4.0),
            every: (self.duration / looks).max(1.0 / self.rate),
        }
    }

    /// So many periods, within these numbers of samples.
    fn long(&self, periods: f64, samples: [f64; 2]) -> f64 {
        let [fewest, most] = samples.map(|samples| samples / self.rate);
        (periods * self.period).clamp(fewest, most)
    }

    /// Samples of the window in which neighbours are followed.
    fn parting_samples(&self) -> usize {
        (self.parting.min(self.duration / 4.0) * self.rate) as usize
    }

    fn embedding(&self) -> EmbeddingSpec {
        EmbeddingSpec {
            lag: Setting::Given(self.report.embedding.lag_s),
            dimension: Setting::Given(self.report.embedding.choice.dimension),
        }
    }

    fn nearness(&self) -> NearnessSpec {
        let rule = self.report.recurrence.rule;
        NearnessSpec {
            norm: rule.norm,
            threshold: rule.threshold,
        }
    }

    fn spectrogram(&self) -> SpectrogramSpec {
        let samples = self.report.signal.samples.len();
        let window = spectrogram_window(samples, self.period * self.rate) as f64 / self.rate;
        SpectrogramSpec {
            sliding: self.sliding(window, 2.0 * LOOKS),
            max_frequency: highest_frequency(self.report),
        }
    }

    fn delay(&self) -> DelaySpec {
        let lag = self.report.embedding.lag_s;
        DelaySpec {
            sliding: self.sliding(self.parting, LOOKS / 10.0),
            largest_lag: (4.0 * lag)
                .min(self.parting_samples() as f64 / self.rate / 25.0)
                .max(lag),
            largest_dimension: 10,
            bins: 32,
            false_share: 0.01,
        }
    }

    fn quantification(&self) -> QuantificationSpec {
        let step = self.report.recurrence.stride_samples as f64 / self.rate;
        QuantificationSpec {
            sliding: self.sliding(1000.0 * step, LOOKS),
            step,
            embedding: self.embedding(),
            nearness: self.nearness(),
            theiler: self.report.embedding.lag_s,
            least_diagonal: 2,
            least_vertical: 2,
        }
    }

    fn chaos(&self) -> ChaosSpec {
        let choice = &self.report.embedding.choice;
        let rules = DivergenceSearch::for_delay(
            choice.lag,
            choice.dimension,
            choice.theiler,
            self.parting_samples(),
        );
        ChaosSpec {
            sliding: self.sliding(self.parting, LOOKS / 5.0),
            embedding: self.embedding(),
            theiler: self.report.embedding.theiler_s,
            horizon: rules.horizon as f64 / self.rate,
            method: DivergenceMethod::Rosenstein,
        }
    }
}

/// The highest frequency worth showing, Hz: half as much again as that of the highest line, or all
/// there is.
pub fn highest_frequency(report: &SignalReport) -> f64 {
    let nyquist = 0.5 * report.signal.rate;
    let lines = report.tones.lines.iter().map(|named| named.line.frequency);
    let highest = lines.fold(0.0, f64::max);
    if highest > 0.0 {
        (1.5 * highest).min(nyquist)
    } else {
        nyquist
    }
}
