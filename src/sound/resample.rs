//! Sample-rate conversion, block by block.

use rubato::audioadapter_buffers::direct::InterleavedSlice;
use rubato::{
    Adjustable as _, Async, FixedAsync, Indexing, Resampler as _, SincInterpolationParameters,
    WindowFunction,
};

use super::RATE;

/// Number of samples per block.
const PIECE: usize = 256;
/// Length of the filter at the lower of the two rates, in samples of that rate.
const FILTER: usize = 128;
/// Range of relative rate changes without a new filter, whose replacement is audible: a higher rate would
/// alias, a lower rate would lose high frequencies.
const SLACK: [f64; 2] = [0.75, 1.05];
/// The corresponding parameter of the library.
const LARGEST_CHANGE: f64 = 1.4;

/// Resamples a signal to [`RATE`].
pub struct Resampler {
    inner: Async<f32>,
    /// Input rate for which the filter was designed, Hz.
    rate: f64,
    waiting: Vec<f32>,
    /// Number of output samples to drop: the delay of the filter before the first sample.
    delay: usize,
}

impl Resampler {
    /// For an input rate `rate`, Hz.
    pub fn new(rate: f64) -> Self {
        let ratio = f64::from(RATE) / rate;
        // The filter length is in input samples: a higher input rate needs a longer filter for the same
        // steepness.
        let length = (FILTER as f64 / ratio.min(1.0)).min(4096.0);
        let length = (length / 8.0).ceil() as usize * 8;
        let parameters = SincInterpolationParameters::new(length, WindowFunction::BlackmanHarris2);
        let inner = Async::new_sinc(
            ratio,
            LARGEST_CHANGE,
            &parameters,
            PIECE,
            1,
            FixedAsync::Input,
        )
        .expect("the ratio of two rates is positive");
        Self {
            // The first sample counts for the delay, too.
            delay: inner.output_delay().saturating_sub(1),
            inner,
            rate,
            waiting: Vec::with_capacity(2 * PIECE),
        }
    }

    /// Changes the input rate, Hz.
    pub fn set_rate(&mut self, rate: f64) {
        let change = rate / self.rate;
        if (SLACK[0]..=SLACK[1]).contains(&change) {
            let ratio = f64::from(RATE) / rate;
            // A gradual change avoids an audible step.
            let changed = self.inner.set_resample_ratio(ratio, true);
            return changed.expect("the change is within the configured range");
        }
        let waiting = std::mem::take(&mut self.waiting);
        *self = Self {
            waiting,
            ..Self::new(rate)
        };
    }

    /// Processes samples and appends the complete audio.
    pub fn push(&mut self, samples: impl Iterator<Item = f64>, sound: &mut Vec<f32>) {
        self.waiting.extend(samples.map(|x| x as f32));
        let mut taken = 0;
        while self.waiting.len() - taken >= PIECE {
            self.piece(taken, None, sound);
            taken += PIECE;
        }
        self.waiting.drain(..taken);
    }

    /// Appends the remaining audio, at most `count` samples.
    pub fn finish(&mut self, sound: &mut Vec<f32>, count: usize) {
        let end = sound.len() + count;
        let mut left = self.waiting.len();
        // Zeros flush the filter.
        while sound.len() < end {
            self.waiting.resize(PIECE, 0.0);
            self.piece(0, Some(left), sound);
            left = 0;
            self.waiting.fill(0.0);
        }
        sound.truncate(end);
    }

    fn piece(&mut self, from: usize, count: Option<usize>, sound: &mut Vec<f32>) {
        let piece = &self.waiting[from..from + PIECE];
        let piece = InterleavedSlice::new(piece, 1, PIECE).expect("one channel of PIECE samples");
        let mut indexing = Indexing::new();
        if let Some(count) = count {
            indexing = indexing.partial_len(count);
        }
        let out = self
            .inner
            .process(&piece, Some(&indexing))
            .expect("the block has the configured size");
        let out = out.take_data();
        let skipped = self.delay.min(out.len());
        self.delay -= skipped;
        sound.extend_from_slice(&out[skipped..]);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Audio of a sine of `frequency` (Hz) sampled at `rate` (Hz).
    fn resampled_sine(frequency: f64, rate: f64, seconds: f64) -> Vec<f32> {
        let count = (seconds * rate) as usize;
        let samples: Vec<f64> = (0..count)
            .map(|k| (TAU * frequency * k as f64 / rate).sin())
            .collect();
        let (mut resampler, mut sound) = (Resampler::new(rate), Vec::new());
        for piece in samples.chunks(333) {
            resampler.push(piece.iter().copied(), &mut sound);
        }
        let whole = (seconds * f64::from(RATE)).round() as usize;
        let left = whole - sound.len();
        resampler.finish(&mut sound, left);
        assert_eq!(sound.len(), whole);
        sound
    }

    #[test]
    fn a_tone_keeps_frequency_amplitude_and_phase() {
        for rate in [200e3, 48e3, 20e3] {
            let frequency = 4117.0;
            let sound = resampled_sine(frequency, rate, 0.2);
            let angle = |k: usize| TAU * frequency * k as f64 / f64::from(RATE);
            // Over whole periods sine and cosine are orthogonal.
            let part = 2000..2000 + 48_000 / 4117 * 300;
            let sum = |of: fn(f64) -> f64| {
                let products = part.clone().map(|k| f64::from(sound[k]) * of(angle(k)));
                2.0 * products.sum::<f64>() / part.len() as f64
            };
            let (sine, cosine) = (sum(f64::sin), sum(f64::cos));
            assert!(
                (sine.hypot(cosine) - 1.0).abs() < 5e-3,
                "{rate} Hz: {sine}, {cosine}"
            );
            let delay = cosine.atan2(sine) / (TAU * frequency) * f64::from(RATE);
            assert!(delay.abs() < 1.0, "{rate} Hz: {delay} samples off");
            for k in part {
                let due = sine * angle(k).sin() + cosine * angle(k).cos();
                assert!((f64::from(sound[k]) - due).abs() < 1e-2, "{rate} Hz, {k}");
            }
        }
    }

    /// Frequencies above half the audio rate are not aliased.
    #[test]
    fn frequencies_above_nyquist_are_removed() {
        for frequency in [30e3, 43e3, 52e3, 95e3] {
            let sound = resampled_sine(frequency, 200e3, 0.1);
            let loudest = sound[1000..4000]
                .iter()
                .fold(0.0, |m: f32, x| x.abs().max(m));
            assert!(loudest < 1e-4, "{frequency} Hz: {loudest}");
        }
    }

    #[test]
    fn a_lower_rate_lowers_the_pitch() {
        let (rate, mut sound) = (200e3, Vec::new());
        let mut resampler = Resampler::new(rate);
        let mut samples = (0..).map(|k| (TAU * 4e3 * f64::from(k) / rate).sin());
        resampler.push(samples.by_ref().take(20_000), &mut sound);
        resampler.set_rate(0.25 * rate);
        sound.clear();
        resampler.push(samples.by_ref().take(40_000), &mut sound);
        let middle = &sound[2000..][..24_000];
        let rises = middle
            .windows(2)
            .filter(|w| w[0] < 0.0 && w[1] >= 0.0)
            .count();
        assert!(
            rises.abs_diff(500) <= 1,
            "half a second of 1 kHz, not {rises}"
        );
    }
}
