//! Spectral peaks over the noise floor, column by column.

use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use super::floor::Floor;
use super::paths::gain;
use crate::tones::Window;

/// Fewest periods of a peak in a window, 85 Hz in the longest; the mean of the signal stays below.
pub(super) const LEAST_BIN: usize = 17;

/// Bins from the middle of a line to beyond its main lobe.
pub(super) const LOBE: usize = 3;

/// A spectral peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    /// Frequency, bins.
    pub bin: f64,
    /// Logarithm of the likelihood ratio of a tone against noise, above 0.
    pub gain: f64,
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
}

/// Length of a window of about `duration` (s): even, and a product of small primes.
pub(super) fn window_length(duration: f64, rate_hz: f64) -> usize {
    let wanted = duration * rate_hz;
    let unit = 2f64.powf(wanted.log2().floor() - 3.0).max(2.0);
    ((wanted / unit).round().max(1.0) * unit) as usize
}

/// The peaks of `samples` that a tone explains better than noise, with Hann windows of about `duration` (s) that overlap
/// by half.
pub(super) fn peaks(samples: &[f64], rate_hz: f64, duration: f64) -> Peaks {
    let length = window_length(duration, rate_hz);
    let hop = length / 2;
    let bin_hz = rate_hz / length as f64;
    let powers = powers(samples, length);
    let bins = powers[0].len() - 1;
    let step_s = hop as f64 / rate_hz;
    // The bins of a sine of amplitude A under a Hann window have the sum 1.5 A^2 / 4.
    let above = |column: &Vec<f64>| column[LEAST_BIN.min(bins)..].iter().sum::<f64>();
    let power = powers.iter().map(above).sum::<f64>() / powers.len() as f64 * 2.0 / 1.5;
    let floor = Floor::new(&powers, step_s);
    // A Hann window has the noise bandwidth of 1.5 bins.
    let per_hertz = 1.0 / (1.5 * bin_hz);
    let column = |t: usize| {
        let power = &powers[t];
        let is_peak = |k: &usize| power[*k] > power[k - 1] && power[*k] >= power[k + 1];
        let all = (LEAST_BIN..bins).filter(is_peak);
        let over = all.filter_map(|k| {
            let noise = floor.at(t, k);
            let gain = gain(power[k] / noise);
            let (shift, _) = vertex([power[k - 1], power[k], power[k + 1]]);
            (gain > 0.0).then_some(Peak {
                bin: k as f64 + shift,
                gain,
                noise: 2.0 * noise * per_hertz,
            })
        });
        over.collect()
    };
    Peaks {
        columns: (0..powers.len()).into_par_iter().map(column).collect(),
        step_s,
        bin_hz,
        bins: bins.saturating_sub(LEAST_BIN),
        power,
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

/// Power spectra |X|^2 of the windowed columns, where a sine of amplitude `A` gives `A^2 / 4`. The columns are centred at
/// multiples of half a window; the signal is continued by zeros.
pub(super) fn powers(samples: &[f64], length: usize) -> Vec<Vec<f64>> {
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
        let power = |x: &Complex64| scale * x.norm_sqr();
        output.iter().map(power).collect()
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
