//! Measures of a settled motion from the probe's samples.

use super::recurrence::{recurrence_periods, thinned};
use super::settled::{PhasePortrait, SettledResponse};
use crate::analysis::{
    AnalysisError,
    delay::DelayVectors,
    poincare::{
        ClosedCurves, Direction, SectionShape, closed_curves, delay_section, section_shape,
    },
    recurrence::{
        Measures, Norm, RateBase, RecurrenceCriterion, RecurrencePeriods, Recurrences, Threshold,
    },
    regime::{Regime, RegimeSearch, classify},
    stats::{deviation, range},
    tones::{Bases, FREQUENCY_UNCERTAINTY, LineCriterion, SpectrumAnalyser, Window, follow_lines},
};
use crate::dynamics::SolverStats;
use crate::scene::{AutoOr, Scene, SectionSurface};

/// Maximum number of maxima and section points kept; the newest ones are kept.
const MAX_POINTS: usize = 400;

/// Maximum number of section points in which closed curves are searched.
const MAX_CURVE_POINTS: usize = 1600;

/// Maximum number of spectral lines: enough for the weak lines of a doubling beside those of the torus.
const MAX_LINES: usize = 32;

/// Default section delay, s: a quarter period of 4.1 kHz.
pub(super) const LAG: f64 = 60e-6;

/// States per delay.
const STATES_PER_LAG: usize = 6;

/// Maximum number of states compared for recurrence.
const STATES: usize = 2000;

/// Embedding dimension of these states, from Section 3 of the paper.
pub(super) const DIMENSION: usize = 5;

/// Recurrence threshold, standard deviations of the displacement.
const THRESHOLD: f64 = 0.5;

/// Minimum diagonal length, in delays (four quarter periods), and minimum vertical length, in states.
const MIN_DIAGONAL_LAGS: usize = 4;
const MIN_VERTICAL: usize = 2;

/// Length of the motion kept for phase portraits, s.
const KEPT_TIME: f64 = 0.02;

/// Highest frequency of the spectrum kept, Hz.
const MAX_FREQUENCY: f64 = 20e3;

/// Probe samples of the measurement window.
pub(super) struct Samples {
    rate: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Samples {
    /// Creates an empty buffer for `count` samples at `rate` (Hz).
    pub fn new(rate: f64, count: usize) -> Self {
        Self {
            rate,
            displacement: Vec::with_capacity(count),
            velocity: Vec::with_capacity(count),
        }
    }

    pub fn push(&mut self, [displacement, velocity]: [f64; 2]) {
        self.displacement.push(displacement);
        self.velocity.push(velocity);
    }

    /// The fields of a response that follow from the samples; the others are left empty. `lag` is that of the section, s. A
    /// displacement amplitude below `silence` (m) counts as silent. `previous` are the base frequencies of the motion
    /// from which this one continues.
    pub fn response(
        &self,
        lag: f64,
        silence: f64,
        previous: Bases,
    ) -> Result<SettledResponse, AnalysisError> {
        let u = &self.displacement[..];
        let [low, high] = range(u.iter().copied());
        let amplitude = 0.5 * (high - low);
        let moves = amplitude > silence.max(1e-12 * high.abs().max(low.abs()));
        let squares = self.velocity.iter().map(|v| v * v);
        let rms_velocity = (squares.sum::<f64>() / self.velocity.len() as f64).sqrt();
        let speeds = self.velocity.iter().map(|v| v.abs());
        let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, self.rate).analyse(u)?;
        let search = RegimeSearch {
            sample_rate: self.rate,
            silence,
            background: 0.0,
        };
        let verdict = classify(u, &search)?;
        let criterion = LineCriterion {
            max_lines: MAX_LINES,
            ..LineCriterion::default()
        };
        let lines = if moves {
            spectrum.lines(&criterion)
        } else {
            Vec::new()
        };
        let naming = follow_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin, previous);
        let lag = ((lag * self.rate).round() as usize).max(1);
        let mut section = if moves { section(u, lag)? } else { Vec::new() };
        let curves = curves(&section, high - low);
        section.drain(..section.len().saturating_sub(MAX_POINTS));
        let recurrence = if moves { self.recurrence(lag)? } else { None };
        Ok(SettledResponse {
            transient: 0.0,
            settled: false,
            amplitude,
            mean: u.iter().sum::<f64>() / u.len() as f64,
            rms_velocity,
            peak_velocity: speeds.fold(0.0, f64::max),
            maxima: if moves { maxima(u) } else { Vec::new() },
            section,
            curves,
            doubling: match verdict.regime {
                Regime::Periodic | Regime::QuasiPeriodic => naming.doubling,
                _ => 0,
            },
            lines: naming.label(&lines),
            broadband_share: spectrum.broadband_share(),
            exponents: None,
            recurrence_periods: if moves {
                recurrence_periods(u, lag, DIMENSION, Norm::Euclidean)?.in_seconds(1.0 / self.rate)
            } else {
                RecurrencePeriods::default()
            },
            recurrence,
            linear: None,
            regime: verdict.regime,
            confidence: verdict.confidence,
            portrait: Some(self.portrait(&spectrum.amplitude, spectrum.bin)),
            state: Vec::new(),
            stats: SolverStats::default(),
        })
    }

    /// Recurrence measures of the newest states, lengths in s.
    fn recurrence(&self, lag: usize) -> Result<Option<Measures>, AnalysisError> {
        let step = (lag / STATES_PER_LAG).max(1);
        let lag = (lag as f64 / step as f64).round() as usize;
        let taken = thinned(&self.displacement, step);
        let needed = DelayVectors::samples_for(STATES, lag, DIMENSION);
        let taken = &taken[taken.len().saturating_sub(needed)..];
        if taken.len() < DelayVectors::samples_for(2 * lag, lag, DIMENSION) {
            return Ok(None);
        }
        let vectors = DelayVectors::new(taken, lag, DIMENSION)?;
        let rule = RecurrenceCriterion {
            norm: Norm::Euclidean,
            threshold: Threshold::Distance(THRESHOLD * deviation(taken)),
            theiler: lag,
        };
        let counts = Recurrences::of(&vectors, &rule)?.counts();
        let measures = counts.measures(MIN_DIAGONAL_LAGS * lag, MIN_VERTICAL, RateBase::Counted);
        Ok(Some(measures.in_seconds(step as f64 / self.rate)))
    }

    fn portrait(&self, spectrum: &[f64], bin: f64) -> PhasePortrait {
        let kept = ((KEPT_TIME * self.rate) as usize).min(self.displacement.len());
        let newest = |values: &[f64]| -> Vec<f32> {
            values[values.len() - kept..]
                .iter()
                .map(|&v| v as f32)
                .collect()
        };
        let bins = ((MAX_FREQUENCY / bin) as usize + 1).min(spectrum.len());
        PhasePortrait {
            dt: 1.0 / self.rate,
            displacement: newest(&self.displacement),
            velocity: newest(&self.velocity),
            bin,
            spectrum: spectrum[..bins].iter().map(|&a| a as f32).collect(),
        }
    }
}

/// Section delay of a scene, s: the delay of its section if it has a delay section, else 60 µs.
pub fn section_lag(scene: &Scene) -> f64 {
    match scene
        .analysis
        .section
        .as_ref()
        .map(|section| &section.surface)
    {
        Some(SectionSurface::Delay {
            lag: AutoOr::Given(lag),
            ..
        }) => *lag,
        _ => LAG,
    }
}

/// The newest local maxima: for each, the vertex of the parabola through three samples.
fn maxima(samples: &[f64]) -> Vec<f64> {
    let tops = samples.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]);
    let mut maxima: Vec<f64> = tops
        .rev()
        .take(MAX_POINTS)
        .map(|w| {
            let (slope, bend) = (0.5 * (w[2] - w[0]), w[0] - 2.0 * w[1] + w[2]);
            w[1] - 0.5 * slope * slope / bend
        })
        .collect();
    maxima.reverse();
    maxima
}

/// First and third delay coordinate of the zero crossings of the second. The first and the last crossing
/// are omitted, as they are interpolated from fewer samples.
fn section(samples: &[f64], lag: usize) -> Result<Vec<[f64; 2]>, AnalysisError> {
    let passages = delay_section(samples, lag, 3, 0.0, Direction::Rising)?;
    let inner = passages.get(1..passages.len().saturating_sub(1));
    let points = inner.unwrap_or(&[]).iter();
    Ok(points.map(|c| [c.point[0], c.point[2]]).collect())
}

/// Closed curves of a section of a motion of the given size; `None` if it consists of a few points.
fn curves(section: &[[f64; 2]], size: f64) -> Option<ClosedCurves> {
    let points: Vec<&[f64]> = section.iter().map(|point| &point[..]).collect();
    let newest = |count: usize| &points[points.len().saturating_sub(count)..];
    match section_shape(newest(MAX_POINTS), size) {
        SectionShape::Points(_) => None,
        // A slow modulation is visible only in many points, or absent from few.
        _ => closed_curves(newest(MAX_CURVE_POINTS)).or_else(|| closed_curves(newest(MAX_POINTS))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::recurrence::RecurrenceKind;
    use crate::test_signals::sines;

    #[test]
    fn maxima_are_interpolated_between_samples() {
        let tone = sines(200e3, 4000, &[(4100.0, 0.7, 0.3)]);
        let tops = maxima(&tone);
        assert_eq!(tops.len(), 82);
        for top in tops {
            // The parabola's error is a few hundredths of (2 pi 4100 / 200e3)^4.
            assert!((top - 0.7).abs() < 6e-6, "{top}");
        }
        // Flat tops count once.
        assert_eq!(maxima(&[0.0, 1.0, 1.0, 0.0]), [1.125]);
        assert!(maxima(&[1.0; 9]).is_empty());
    }

    #[test]
    fn two_tones_are_classified_as_quasi_periodic() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let u = sines(200e3, 40_000, &[(4110.0, 1e-6, 0.1), (3870.0, 4e-7, 0.9)]);
        let found = super::super::tests::measured(&scene, 200e3, &u).unwrap();
        assert_eq!(found.regime, Regime::QuasiPeriodic);
        assert_eq!(found.motion(), "quasi-periodic");
        assert!(
            (found.lines[0].frequency - 4110.0).abs() < 0.1,
            "{:?}",
            found.lines
        );
        assert!((found.lines[1].amplitude / 4e-7 - 1.0).abs() < 1e-3);
        assert_eq!(
            (&*found.lines[0].label, &*found.lines[1].label),
            ("f1", "f2")
        );
        assert_eq!(found.maxima.len(), MAX_POINTS);
        assert!((found.amplitude - 1.4e-6).abs() < 1e-8);
        let beat = found.recurrence_periods.last(RecurrenceKind::Beat).unwrap();
        assert!((beat.period * 240.0 - 1.0).abs() < 0.01, "{beat:?}");
        let determinism = found.recurrence.unwrap().determinism.unwrap();
        assert!(determinism > 0.85, "{determinism}");
        let one = ClosedCurves {
            count: 1,
            windings: 1,
        };
        assert_eq!((found.curves, found.doubling), (Some(one), 0));
        assert_eq!(found.section.len(), MAX_POINTS);
        let portrait = found.portrait.unwrap();
        assert_eq!(portrait.displacement.len(), 4000);
        assert!((portrait.bin - 5.0).abs() < 0.01);
    }
}
