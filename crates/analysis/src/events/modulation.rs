//! Periodic modulation of the amplitude and of the frequency of an event.

use realfft::RealFftPlanner;

use super::baseband::median;
use super::partial::{Partial, STEP_S};
use super::spectrogram::vertex;
use super::{Modulation, Vibrato};
use crate::tones::Window;

/// Range of the frequency of a modulation, Hz.
const BAND_HZ: [f64; 2] = [2.0, 60.0];

/// Range of the frequency of a vibrato, Hz.
const VIBRATO_BAND_HZ: [f64; 2] = [2.0, 15.0];

/// Least number of periods.
const LEAST_PERIODS: f64 = 3.0;

/// Least ratio of the power of a modulation to the median of its spectrum: noise exceeds it in one of 100 spectra
/// of 100 bins.
const LEAST_RATIO: f64 = 13.0;

/// Smallest depth that is reported.
const LEAST_DEPTH: f64 = 0.05;

/// Smallest relative deviation of frequency that is reported.
const LEAST_DEVIATION: f64 = 2e-4;

/// Modulation of the amplitude of a partial.
pub(super) fn modulation(partial: &Partial) -> Option<Modulation> {
    let amplitudes: Vec<f64> = partial.track.iter().map(|p| p.1.sqrt()).collect();
    let mean = amplitudes.iter().sum::<f64>() / amplitudes.len() as f64;
    let (modulation_hz, amplitude) = strongest(&amplitudes, BAND_HZ)?;
    let modulation_depth = amplitude / mean;
    (modulation_depth > LEAST_DEPTH).then_some(Modulation {
        modulation_hz,
        modulation_depth,
    })
}

/// Modulation of the frequency of a partial, `multiple` times the fundamental.
pub(super) fn vibrato(partial: &Partial, multiple: usize) -> Option<Vibrato> {
    let frequencies: Vec<f64> = partial.track.iter().map(|p| p.0).collect();
    let (vibrato_hz, deviation) = strongest(&frequencies, VIBRATO_BAND_HZ)?;
    (deviation > LEAST_DEVIATION * partial.frequency_hz).then_some(Vibrato {
        vibrato_hz,
        vibrato_deviation_hz: deviation / multiple as f64,
    })
}

/// Frequency (Hz) and amplitude of the strongest line of a function of time in steps of [`STEP_S`], without
/// its parabola, within a range of frequencies (Hz), if it stands out and ends are not its cause.
fn strongest(values: &[f64], band_hz: [f64; 2]) -> Option<(f64, f64)> {
    let count = values.len();
    let duration = count as f64 * STEP_S;
    let [lowest_hz, highest_hz] = [band_hz[0].max(LEAST_PERIODS / duration), band_hz[1]];
    if count < 32 || lowest_hz >= highest_hz {
        return None;
    }
    let fft = RealFftPlanner::new().plan_fft_forward(count);
    let weights = Window::Hann.samples(count);
    let mut input: Vec<f64> = without_parabola(values)
        .iter()
        .zip(&weights)
        .map(|(x, w)| x * w)
        .collect();
    let mut output = fft.make_output_vec();
    fft.process(&mut input, &mut output).ok()?;
    let powers: Vec<f64> = output.iter().map(|x| x.norm_sqr()).collect();
    let [first, last] = [lowest_hz, highest_hz].map(|f| (f * duration).ceil() as usize);
    let last = last.min(powers.len() - 2);
    let best = (first..=last).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
    let median = median(powers[first..].iter().copied());
    let is_peak = powers[best] >= powers[best - 1] && powers[best] >= powers[best + 1];
    if !is_peak || powers[best] < LEAST_RATIO * median {
        return None;
    }
    let (shift, height) = vertex([powers[best - 1], powers[best], powers[best + 1]]);
    Some((
        (best as f64 + shift) / duration,
        2.0 * height.sqrt() / weights.iter().sum::<f64>(),
    ))
}

/// Values less the parabola of least squares, from Legendre polynomials.
fn without_parabola(values: &[f64]) -> Vec<f64> {
    let count = values.len() as f64;
    let x = |i: usize| (2.0 * i as f64 + 1.0) / count - 1.0;
    let terms: [fn(f64) -> f64; 3] = [|_| 1.0, |x| x, |x| 1.5 * x * x - 0.5];
    let factors = terms.map(|term| {
        let (mut product, mut norm) = (0.0, 0.0);
        for (i, value) in values.iter().enumerate() {
            product += value * term(x(i));
            norm += term(x(i)).powi(2);
        }
        product / norm
    });
    let parabola = |i: usize| {
        terms
            .iter()
            .zip(&factors)
            .map(|(t, c)| c * t(x(i)))
            .sum::<f64>()
    };
    values
        .iter()
        .enumerate()
        .map(|(i, value)| value - parabola(i))
        .collect()
}
