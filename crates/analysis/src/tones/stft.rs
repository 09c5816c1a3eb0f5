//! Short-time Fourier transform of a stream.

use super::{SpectrumAnalyser, Window};
use crate::{AnalysisError, sliding::SlidingWindow};

/// Spectrogram columns of a stream. A column is complete once its window is full. Windows overlap if the
/// hop is shorter than the window.
pub struct Stft {
    sliding: SlidingWindow<1>,
    analyser: SpectrumAnalyser,
    length: usize,
}

/// One column of a spectrogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Centre of the window, in samples since the start of the stream.
    pub centre: f64,
    /// Spacing of the bins, Hz; the first is at 0 Hz.
    pub bin: f64,
    /// One-sided amplitude of each bin, in the signal's unit.
    pub amplitude: Vec<f64>,
}

impl Stft {
    /// Creates a transform with `window` of `length` samples, every `hop` samples (may be fractional),
    /// for samples at `sample_rate` (Hz).
    pub fn new(window: Window, length: usize, hop: f64, sample_rate: f64) -> Self {
        Self {
            sliding: SlidingWindow::new(length, hop),
            analyser: SpectrumAnalyser::new(window, sample_rate),
            length,
        }
    }

    /// Appends samples and calls `each` for every column they complete.
    ///
    /// # Errors
    /// [`AnalysisError::TooShort`] if the window is shorter than the minimum of a spectrum, and the
    /// errors of `each`.
    pub fn push<E: From<AnalysisError>>(
        &mut self,
        samples: &[f64],
        mut each: impl FnMut(Column) -> Result<(), E>,
    ) -> Result<(), E> {
        let Self {
            sliding,
            analyser,
            length,
        } = self;
        sliding.push([samples], |view| {
            let spectrum = analyser.analyse(view.channels[0])?;
            each(Column {
                centre: view.seen as f64 - 0.5 * *length as f64,
                bin: spectrum.bin,
                amplitude: spectrum.amplitude,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::sines;

    const RATE: f64 = 200_000.0;

    fn columns(signal: &[f64], block: usize) -> Vec<Column> {
        let mut stft = Stft::new(Window::Hann, 1000, 100.0, RATE);
        let mut out = Vec::new();
        for part in signal.chunks(block) {
            stft.push(part, |column| {
                out.push(column);
                Ok::<(), AnalysisError>(())
            })
            .unwrap();
        }
        out
    }

    #[test]
    fn columns_follow_the_hop_and_do_not_depend_on_block_sizes() {
        let signal = sines(RATE, 3000, &[(4100.0, 1.0, 0.0)]);
        let whole = columns(&signal, 3000);
        let centres: Vec<f64> = whole.iter().map(|c| c.centre).collect();
        let expected: Vec<f64> = (0..21).map(|j| 500.0 + 100.0 * f64::from(j)).collect();
        assert_eq!(centres, expected);
        assert_eq!(columns(&signal, 7), whole);
    }

    #[test]
    fn the_onset_of_a_tone_appears_at_its_time() {
        // Zero for 2000 samples, then a sine: half the amplitude once it fills half the window.
        let mut signal = vec![0.0; 2000];
        signal.extend(sines(RATE, 2000, &[(4000.0, 1.0, 0.0)]));
        for column in columns(&signal, 256) {
            let level = column.amplitude[20];
            if column.centre <= 1500.0 {
                assert_eq!(level, 0.0);
            } else if column.centre >= 2500.0 {
                assert!((level - 1.0).abs() < 1e-12);
            } else if column.centre == 2000.0 {
                assert!((level - 0.5).abs() < 0.01, "{level}");
            }
        }
    }
}
