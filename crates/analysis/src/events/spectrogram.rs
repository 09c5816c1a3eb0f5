//! Spectral peaks over the noise floor, column by column.

use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::floor::Floor;
use crate::tones::Window;

/// Smallest ratio of power to floor of a peak that is kept.
const LEAST_RATIO: f64 = 2.0;

/// Degrees of freedom of the floor, half of them: a median of 24 bins under a Hann window, which are worth 12
/// independent ones, has the variance of a mean of 6; three columns and the greater of two sides make 24.
const FLOOR_FREEDOM: f64 = 24.0;

/// Lowest bin of a peak: below, the mean of the signal leaks into it.
const LEAST_BIN: usize = 6;

/// Bins from the middle of a line to beyond its main lobe.
pub(super) const LOBE: usize = 3;

/// A spectral peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    /// Frequency, bins.
    pub bin: f64,
    /// Power over the floor, as a variable that is exponential with mean 1 in noise.
    pub ratio: f64,
    /// Power of a sine at the peak, square of the signal's unit.
    pub power: f64,
    /// Noise power per hertz at the peak.
    pub noise: f64,
}

/// The peaks of a spectrogram.
pub(super) struct Peaks {
    /// Peaks of each column, by frequency.
    pub columns: Vec<Vec<Peak>>,
    /// Step between columns, s; the first is at 0.
    pub step_s: f64,
    /// Spacing of the bins, Hz.
    pub bin_hz: f64,
    /// Bins searched in a column.
    pub bins: usize,
    /// Mean power of the signal from the lowest bin searched on, square of its unit.
    pub power: f64,
    floor: Floor,
}

impl Peaks {
    /// Time of a column, s.
    pub fn time(&self, column: usize) -> f64 {
        self.step_s * column as f64
    }

    /// Noise power per hertz at a time (s) and a frequency (Hz).
    pub fn noise(&self, time_s: f64, frequency_hz: f64) -> f64 {
        let column = ((time_s / self.step_s).round() as usize).min(self.columns.len() - 1);
        2.0 * self
            .floor
            .at(column, (frequency_hz / self.bin_hz).round() as usize)
            / (1.5 * self.bin_hz)
    }
}

/// Length of a window of about `duration` (s): even, and a product of small primes.
pub(super) fn window_length(duration: f64, rate_hz: f64) -> usize {
    let wanted = duration * rate_hz;
    let unit = 2f64.powf(wanted.log2().floor() - 3.0).max(2.0);
    ((wanted / unit).round() * unit) as usize
}

/// The peaks of `samples` between two frequencies (Hz), with Hann windows of about `duration` (s) that overlap by half.
pub(super) fn peaks(samples: &[f64], rate_hz: f64, duration: f64, band: [f64; 2]) -> Peaks {
    let length = window_length(duration, rate_hz);
    let hop = length / 2;
    let bin_hz = rate_hz / length as f64;
    let bins = (band[1].min(0.5 * rate_hz) / bin_hz) as usize;
    let first = ((band[0] / bin_hz) as usize).max(LEAST_BIN);
    let powers = powers(samples, length, (bins + 1).max(Floor::LEAST_BINS));
    let step_s = hop as f64 / rate_hz;
    // The bins of a sine of amplitude A under a Hann window have the sum 1.5 A^2 / 4.
    let above = |column: &Vec<f64>| column[first.min(column.len())..].iter().sum::<f64>();
    let power = powers.iter().map(above).sum::<f64>() / powers.len() as f64 * 2.0 / 1.5;
    let floor = Floor::new(&powers, step_s);
    // A Hann window has the noise bandwidth of 1.5 bins.
    let per_hertz = 1.0 / (1.5 * bin_hz);
    let column = |t: usize| {
        let power = &powers[t];
        let is_peak = |k: &usize| power[*k] > power[k - 1] && power[*k] >= power[k + 1];
        let all = (first..bins.min(power.len() - 1)).filter(is_peak);
        let over = all.filter_map(|k| {
            let noise = floor.at(t, k);
            let ratio = power[k] / noise;
            let (shift, height) = vertex([power[k - 1], power[k], power[k + 1]]);
            (ratio > LEAST_RATIO).then_some(Peak {
                bin: k as f64 + shift,
                ratio: FLOOR_FREEDOM * (ratio / FLOOR_FREEDOM).ln_1p(),
                power: 2.0 * height,
                noise: 2.0 * noise * per_hertz,
            })
        });
        over.collect()
    };
    Peaks {
        columns: (0..powers.len()).into_par_iter().map(column).collect(),
        step_s,
        bin_hz,
        bins: bins.saturating_sub(first),
        power,
        floor,
    }
}

/// Offset and height of the vertex of a parabola through the logarithms of three powers around a peak.
pub(super) fn vertex(powers: [f64; 3]) -> (f64, f64) {
    let [l, m, r] = powers.map(|p| p.max(1e-300).ln());
    let bend = l - 2.0 * m + r;
    let shift = if bend < 0.0 {
        0.5 * (l - r) / bend
    } else {
        0.0
    };
    (shift, (m - 0.25 * (l - r) * shift).exp())
}

/// Power spectra |X|^2 of the windowed columns, the first `bins` of each, where a sine of amplitude `A` gives
/// `A^2 / 4`. The columns are centred at multiples of half a window; the signal is continued by zeros.
pub(super) fn powers(samples: &[f64], length: usize, bins: usize) -> Vec<Vec<f64>> {
    let hop = length / 2;
    let fft = RealFftPlanner::new().plan_fft_forward(length);
    let weights = Window::Hann.samples(length);
    let scale = 1.0 / (0.5 * length as f64).powi(2);
    let column = |(input, output, scratch): &mut (Vec<f64>, Vec<_>, Vec<_>), t: usize| {
        let from = (t * hop) as isize - hop as isize;
        for (i, (value, w)) in input.iter_mut().zip(&weights).enumerate() {
            let at = usize::try_from(from + i as isize).ok();
            *value = w * at.and_then(|at| samples.get(at)).unwrap_or(&0.0);
        }
        fft.process_with_scratch(input, output, scratch)
            .expect("the buffers have the lengths of the plan");
        let powers = output[..bins.min(output.len())].iter();
        powers
            .map(|x: &realfft::num_complex::Complex<f64>| scale * x.norm_sqr())
            .collect()
    };
    let buffers = || {
        (
            fft.make_input_vec(),
            fft.make_output_vec(),
            fft.make_scratch_vec(),
        )
    };
    (0..=samples.len() / hop)
        .into_par_iter()
        .map_init(buffers, column)
        .collect()
}
