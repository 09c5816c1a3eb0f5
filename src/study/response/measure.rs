//! Measures of a settled motion from the probe's samples.

use super::{PhasePortrait, SettledResponse};
use crate::analysis::{
    AnalysisError,
    delay::DelayVectors,
    poincare::{
        ClosedCurves, Direction, SectionShape, closed_curves, delay_section, section_shape,
    },
    recurrence::{
        Measures, Norm, RateBase, RecurrenceCriterion, RecurrenceImage, RecurrencePeriods,
        Recurrences, Threshold,
    },
    regime::{RegimeSearch, classify},
    stats::{deviation, range},
    tones::{Bases, FREQUENCY_UNCERTAINTY, LineCriterion, SpectrumAnalyser, Window, follow_lines},
};
use crate::scene::{Scene, SectionSurface};

/// Maximum number of maxima and section points kept; the newest ones are kept.
const MAX_POINTS: usize = 400;

/// Maximum number of section points in which closed curves are searched.
const MAX_CURVE_POINTS: usize = 1600;

/// Maximum number of spectral lines: enough for the weak lines of a doubling beside those of the torus.
const MAX_LINES: usize = 32;

/// Default section delay, s: a quarter period of 4.1 kHz.
const LAG: f64 = 60e-6;

/// States per delay.
const STATES_PER_LAG: usize = 6;

/// Maximum number of states compared for recurrence.
const STATES: usize = 2000;

/// Embedding dimension of these states, from Section 3 of the paper.
const DIMENSION: usize = 5;

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
    /// Sample rate, Hz.
    pub rate: f64,
    /// Displacement of the probe, m.
    pub displacement: Vec<f64>,
    /// Its velocity, m/s.
    pub velocity: Vec<f64>,
}

impl Samples {
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
        let squares = self.velocity.iter().map(|v| v * v);
        let speeds = self.velocity.iter().map(|v| v.abs());
        let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, self.rate).analyse(u)?;
        let search = RegimeSearch {
            sample_rate: self.rate,
            silence,
            background: 0.0,
        };
        let verdict = classify(u, &search)?;
        let mut found = SettledResponse {
            amplitude_m: amplitude,
            mean_m: u.iter().sum::<f64>() / u.len() as f64,
            rms_velocity_m_per_s: (squares.sum::<f64>() / self.velocity.len() as f64).sqrt(),
            peak_velocity_m_per_s: speeds.fold(0.0, f64::max),
            broadband_share: spectrum.broadband_share(),
            regime: verdict.regime,
            confidence: verdict.confidence,
            portrait: Some(self.portrait(&spectrum.amplitude, spectrum.bin)),
            ..SettledResponse::default()
        };
        if amplitude <= silence.max(1e-12 * high.abs().max(low.abs())) {
            return Ok(found);
        }
        let lines = spectrum.lines(&LineCriterion {
            max_lines: MAX_LINES,
            ..LineCriterion::default()
        });
        let naming = follow_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin, previous);
        found.lines = naming.label(&lines);
        found.doubling = naming.doubling;
        let lag = ((lag * self.rate).round() as usize).max(1);
        found.maxima_m = maxima(u);
        found.section_m = section(u, lag)?;
        found.curves = curves(&found.section_m, high - low);
        let surplus = found.section_m.len().saturating_sub(MAX_POINTS);
        found.section_m.drain(..surplus);
        found.recurrence = self.recurrence(lag)?;
        let periods = recurrence_periods(u, lag, DIMENSION, Norm::Euclidean)?;
        found.recurrence_periods = periods.in_seconds(1.0 / self.rate);
        Ok(found)
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
            let newest = values[values.len() - kept..].iter();
            newest.map(|&v| v as f32).collect()
        };
        let bins = ((MAX_FREQUENCY / bin) as usize + 1).min(spectrum.len());
        PhasePortrait {
            dt_s: 1.0 / self.rate,
            u_m: newest(&self.displacement),
            v_m_per_s: newest(&self.velocity),
            spectrum_bin_hz: bin,
            spectrum_m: spectrum[..bins].iter().map(|&a| a as f32).collect(),
        }
    }
}

/// Section delay of a scene, s: the delay of its section if it has a delay section, else 60 µs.
pub fn section_lag(scene: &Scene) -> f64 {
    let section = scene.analysis.section.as_ref();
    match section.map(|section| &section.surface) {
        Some(SectionSurface::Delay { lag: Some(lag), .. }) => *lag,
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

/// Length of the window, s; less if fewer samples were kept.
const PORTRAIT_WINDOW: f64 = 5e-3;

/// Maximum number of states compared, and maximum side of the picture in pixels.
const PORTRAIT_STATES: usize = 1000;
const SIZE: usize = 340;

/// Minimum number of states for a plot.
const MIN_STATES: usize = 16;

/// Recurrence rate that sets the threshold of the recurrence plot and periods, as in the scenes of the joint:
/// plots of strong and weak motions are then comparable.
const RATE: f64 = 0.1;

/// States per delay and maximum number of states for the recurrence periods.
const PERIOD_STATES_PER_LAG: usize = 12;
const PERIOD_STATES: usize = 4000;

/// The recurrence periods of the newest states of a signal for a delay (samples), in samples. They need wide stripes: more
/// states per delay and more recurrent pairs than the measures. There are none in too few samples.
///
/// # Errors
/// If the samples are not finite, or all are equal.
pub(in crate::study) fn recurrence_periods(
    samples: &[f64],
    lag: usize,
    dimension: usize,
    norm: Norm,
) -> Result<RecurrencePeriods, AnalysisError> {
    let step = (lag / PERIOD_STATES_PER_LAG).max(1);
    let lag = (lag / step).max(1);
    let taken = thinned(samples, step);
    let needed = DelayVectors::samples_for(PERIOD_STATES, lag, dimension);
    let taken = &taken[taken.len().saturating_sub(needed)..];
    if taken.len() < DelayVectors::samples_for(2 * lag, lag, dimension) {
        return Ok(RecurrencePeriods::default());
    }
    let vectors = DelayVectors::new(taken, lag, dimension)?;
    let rule = RecurrenceCriterion {
        norm,
        threshold: Threshold::Rate(RATE),
        theiler: lag,
    };
    let counts = Recurrences::of(&vectors, &rule)?.counts();
    Ok(counts.periods().in_seconds(step as f64))
}

/// Every `step`-th sample, including the newest.
pub(in crate::study) fn thinned(samples: &[f64], step: usize) -> Vec<f64> {
    let first = samples.len().saturating_sub(1) % step;
    samples[first..].iter().step_by(step).copied().collect()
}

impl PhasePortrait {
    /// The recurrence plot of the newest 5 ms: delay vectors of dimension 5 with a delay of 60 µs, a quarter
    /// period of 4.1 kHz. `None` if too few samples were kept.
    ///
    /// A pixel covers a few successive states. It is recurrent if any pair of its states is. Without this
    /// pooling, states spaced by a large part of a period show spurious broad bands, because the diagonals
    /// of a high tone fall between the pixels (aliasing).
    ///
    /// # Errors
    /// If the samples are not finite.
    pub fn recurrence(&self) -> Result<Option<RecurrenceImage>, AnalysisError> {
        let lag = ((LAG / self.dt_s).round() as usize).max(1);
        let reach = DelayVectors::samples_for(0, lag, DIMENSION);
        let wanted = (PORTRAIT_WINDOW / self.dt_s).round() as usize;
        let vectors = wanted.min(self.u_m.len().saturating_sub(reach));
        if vectors < MIN_STATES {
            return Ok(None);
        }
        let needed = DelayVectors::samples_for(vectors, lag, DIMENSION);
        let newest = &self.u_m[self.u_m.len() - needed..];
        let newest: Vec<f64> = newest.iter().map(|&u| f64::from(u)).collect();
        let step = vectors.div_ceil(PORTRAIT_STATES);
        let side = (vectors / step).div_ceil(SIZE);
        let size = vectors / step / side;
        // Counted from the newest state.
        let picks = (0..size * side).rev().map(|k| vectors - 1 - k * step);
        let criterion = RecurrenceCriterion {
            norm: Norm::Euclidean,
            threshold: Threshold::Rate(RATE),
            theiler: 1,
        };
        let found = RecurrenceImage::new(
            &DelayVectors::new(&newest, lag, DIMENSION)?,
            &picks.collect::<Vec<_>>(),
            &criterion,
            (size * side * step) as f64 * self.dt_s,
            self.dt_s,
        )?;
        Ok(Some(RecurrenceImage {
            size,
            distance: pooled(&found.distance, side, u8::min),
            recurrent: pooled(&found.recurrent, side, u8::max),
            ..found
        }))
    }
}

/// A square picture reduced by pooling `side x side` pixels into one.
fn pooled(picture: &[u8], side: usize, combine: fn(u8, u8) -> u8) -> Vec<u8> {
    let size = picture.len().isqrt();
    let rows = picture.chunks_exact((size * side).max(1));
    let combine = |a: Option<u8>, &b: &u8| Some(a.map_or(b, |a| combine(a, b)));
    rows.flat_map(|rows| {
        (0..size / side).map(move |column| {
            let pieces = rows.chunks_exact(size);
            let pieces = pieces.flat_map(|row| &row[column * side..][..side]);
            pieces.fold(None, combine).unwrap_or_default()
        })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{recurrence::RecurrenceKind, regime::Regime};
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
        assert_eq!(found.maxima_m.len(), MAX_POINTS);
        assert!((found.amplitude_m - 1.4e-6).abs() < 1e-8);
        let beat = found.recurrence_periods.last(RecurrenceKind::Beat).unwrap();
        assert!((beat.period * 240.0 - 1.0).abs() < 0.01, "{beat:?}");
        let determinism = found.recurrence.unwrap().determinism.unwrap();
        assert!(determinism > 0.85, "{determinism}");
        let one = ClosedCurves {
            count: 1,
            windings: 1,
        };
        assert_eq!((found.curves, found.doubling), (Some(one), 0));
        assert_eq!(found.section_m.len(), MAX_POINTS);
        let portrait = found.portrait.unwrap();
        assert_eq!(portrait.u_m.len(), 4000);
        assert!((portrait.spectrum_bin_hz - 5.0).abs() < 0.01);
    }

    fn portrait(samples: usize) -> PhasePortrait {
        let tone = sines(200e3, samples, &[(4000.0, 1e-6, 0.0)]);
        PhasePortrait {
            dt_s: 5e-6,
            u_m: tone.iter().map(|&u| u as f32).collect(),
            v_m_per_s: vec![0.0; samples],
            spectrum_bin_hz: 5.0,
            spectrum_m: Vec::new(),
        }
    }

    #[test]
    fn a_tone_recurs_after_its_period() {
        let plot = portrait(2000).recurrence().unwrap().unwrap();
        assert_eq!((plot.size, plot.dimension), (333, 5));
        assert!((plot.window - 4.995e-3).abs() < 1e-12 && (plot.lag - 60e-6).abs() < 1e-12);
        assert!((plot.rate - 0.1).abs() < 0.02, "{}", plot.rate);
        // 250 us are 50 samples; a pixel pools three.
        assert_eq!((plot.recurrent[50 / 3], plot.recurrent[25 / 3]), (255, 0));
        assert_eq!(plot.distance[0], 0);
    }

    #[test]
    fn a_short_signal_has_a_small_plot_or_none() {
        let plot = portrait(200).recurrence().unwrap().unwrap();
        assert_eq!(plot.size * plot.size, plot.recurrent.len());
        assert!(plot.size < 200);
        assert_eq!(portrait(50).recurrence().unwrap(), None);
        assert_eq!(portrait(0).recurrence().unwrap(), None);
    }

    #[test]
    fn pixels_are_pooled_in_squares() {
        let picture: Vec<u8> = (0..16).collect();
        assert_eq!(pooled(&picture, 2, u8::max), [5, 7, 13, 15]);
        assert_eq!(pooled(&picture, 2, u8::min), [0, 2, 8, 10]);
        assert_eq!(pooled(&picture, 1, u8::min), picture);
    }
}
