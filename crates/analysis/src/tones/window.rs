//! Window functions for spectra.
//!
//! Truncating a sine spreads its line over the spectrum. A window trades the width of the main lobe
//! (neighbouring lines merge) against the height of the side lobes (a strong line hides distant weak
//! ones). All windows here are sums of a few cosines with closed-form transforms (F. J. Harris, Proc.
//! IEEE 66, 51, 1978).

use std::f64::consts::PI;

/// A cosine-sum window, `w(s) = a0 + a1 cos(2 pi s) + a2 cos(4 pi s) + ...` for `s` in `[-1/2, 1/2)`,
/// sampled periodically as a discrete Fourier transform requires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// Narrow main lobe (2 bins on each side); side lobes from -31 dB, decreasing by 18 dB per octave.
    #[default]
    Hann,
    /// Four terms: main lobe of 4 bins on each side, all side lobes below -92 dB.
    BlackmanHarris,
}

impl Window {
    /// Coefficients `a0, a1, ...`, which sum to 1.
    fn coefficients(self) -> &'static [f64] {
        match self {
            Window::Hann => &[0.5, 0.5],
            Window::BlackmanHarris => &[0.35875, 0.48829, 0.14128, 0.01168],
        }
    }

    /// Samples of the window at `n` points. The maximum is 1 at index `n / 2`.
    pub fn samples(self, n: usize) -> Vec<f64> {
        let (constant, others) = self
            .coefficients()
            .split_first()
            .expect("a window has coefficients");
        let weight = |i: usize| {
            let cosine = (2.0 * PI * (i as f64 / n as f64 - 0.5)).cos();
            // Clenshaw's recurrence: cosines of multiples of an angle from that of the angle.
            let terms = others.iter().rev();
            let [last, before] = terms.fold([0.0; 2], |[last, before], a| {
                [a + 2.0 * cosine * last - before, last]
            });
            constant + cosine * last - before
        };
        let mut weights: Vec<f64> = (0..n.min(n / 2 + 1)).map(weight).collect();
        // The other half is the mirror image.
        for i in weights.len()..n {
            weights.push(weights[n - i]);
        }
        weights
    }

    /// Coherent gain: the mean of the window, which scales the amplitude of a line.
    pub fn coherent_gain(self) -> f64 {
        self.coefficients()[0]
    }

    /// Half-width of the main lobe: distance from a line to the first zero, bins.
    pub fn half_lobe(self) -> usize {
        self.coefficients().len()
    }

    /// Response to a line `offset` bins away from a bin, relative to a line at the bin: 1 at 0, 0 at the
    /// edge of the main lobe. Exact for long windows (error of order `1 / n^2`).
    pub fn response(self, offset: f64) -> f64 {
        let a = self.coefficients();
        let pair = |k: usize| 0.5 * (sinc(offset - k as f64) + sinc(offset + k as f64));
        let sum: f64 = a.iter().enumerate().map(|(k, a)| a * pair(k)).sum();
        sum / a[0]
    }
}

/// Amplitude of a line at an angular frequency (rad per sample) in a signal, with a window of the same length. Lines within
/// the main lobe of the window are not separated.
pub fn line_amplitude(signal: &[f64], window: &[f64], omega: f64) -> f64 {
    let (sine, cosine) = omega.sin_cos();
    let mut sum = [0.0; 2];
    let [mut re, mut im] = [1.0, 0.0];
    for (x, w) in signal.iter().zip(window) {
        sum[0] += x * w * re;
        sum[1] += x * w * im;
        [re, im] = [re * cosine - im * sine, re * sine + im * cosine];
    }
    2.0 * sum[0].hypot(sum[1]) / window.iter().sum::<f64>()
}

/// `sin(pi x) / (pi x)`.
fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Window; 2] = [Window::Hann, Window::BlackmanHarris];

    #[test]
    fn mean_of_the_samples_is_the_coherent_gain() {
        for window in ALL {
            for n in [16, 77, 1000] {
                let mean = window.samples(n).iter().sum::<f64>() / n as f64;
                assert!((mean - window.coherent_gain()).abs() < 1e-14, "{window:?}");
            }
        }
    }

    #[test]
    fn largest_value_is_one_in_the_middle() {
        for window in ALL {
            let w = window.samples(64);
            assert!((w[32] - 1.0).abs() < 1e-15);
            assert!(w.iter().all(|&x| x <= w[32] && x >= 0.0));
        }
    }

    #[test]
    fn response_is_the_transform_of_the_samples() {
        let n = 4000;
        for window in ALL {
            let w = window.samples(n);
            for offset in [0.0, 0.3, 1.0, 1.7, 2.5, 6.4] {
                // The window is symmetric about its middle: its transform is a sum of cosines.
                let phase = |i: usize| 2.0 * PI * offset * (i as f64 / n as f64 - 0.5);
                let sum: f64 = (0..n).map(|i| w[i] * phase(i).cos()).sum();
                let direct = sum / (n as f64 * window.coherent_gain());
                assert!((direct - window.response(offset)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_amplitude_of_a_line_is_that_of_its_sine() {
        let n = 5000;
        let window = Window::BlackmanHarris.samples(n);
        let tone = |i: usize, bins: f64| (2.0 * PI * bins * i as f64 / n as f64 + 0.3).sin();
        let signal: Vec<f64> = (0..n)
            .map(|i| 2.0 * tone(i, 100.2) + 1e-3 * tone(i, 106.0))
            .collect();
        let at = |bins: f64| line_amplitude(&signal, &window, 2.0 * PI * bins / n as f64);
        assert!((at(100.2) - 2.0).abs() < 1e-4);
        assert!((at(106.0) / 1e-3 - 1.0).abs() < 0.05);
        assert!(at(112.0) < 1e-4);
    }

    #[test]
    fn side_lobes_have_the_published_levels() {
        // Harris, Table 1: highest side lobe -31 dB (Hann: -31.5), -92 dB (four-term).
        for (window, level_db) in [(Window::Hann, -31.0), (Window::BlackmanHarris, -92.0)] {
            let edge = window.half_lobe();
            assert!(window.response(edge as f64).abs() < 1e-15);
            let beyond = (0..4000).map(|i| edge as f64 + 0.01 * f64::from(i));
            let highest = beyond.map(|x| window.response(x).abs()).fold(0.0, f64::max);
            let highest_db = 20.0 * highest.log10();
            assert!(
                highest_db < level_db && highest_db > level_db - 1.0,
                "{highest_db}"
            );
        }
    }
}
