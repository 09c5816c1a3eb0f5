//! Filters over a whole recording, in the frequency domain: noise of a given spectrum, ideal bands and low-pass,
//! and rooms.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

/// A standard normal number.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A number whose logarithm is uniform between those of `low` and `high`.
pub fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

/// Root of the mean square.
pub fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|x| x * x).sum::<f64>() / signal.len() as f64).sqrt()
}

/// Adds `gain` times a signal.
pub fn add(sum: &mut [f64], gain: f64, signal: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(signal) {
        *sum += gain * x;
    }
}

/// Gaussian noise of root mean square 1 whose amplitude density is proportional to `gain(frequency in Hz)`.
pub fn shaped_noise(
    n: usize,
    rate_hz: f64,
    rng: &mut ChaCha8Rng,
    gain: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let inverse = RealFftPlanner::new().plan_fft_inverse(n);
    let mut spectrum = inverse.make_input_vec();
    let last = spectrum.len() - 1;
    // Mean and Nyquist frequency stay zero, which suits a microphone.
    for (k, bin) in spectrum.iter_mut().enumerate().take(last).skip(1) {
        *bin = gain(k as f64 * rate_hz / n as f64) * Complex64::new(normal(rng), normal(rng));
    }
    let mut noise = inverse.make_output_vec();
    inverse.process(&mut spectrum, &mut noise).unwrap();
    let scale = rms(&noise).recip();
    noise.iter_mut().for_each(|x| *x *= scale);
    noise
}

/// A signal with its spectrum multiplied by `gain(frequency in Hz)`, without a change of phase.
pub fn filtered(signal: &[f64], rate_hz: f64, gain: impl Fn(f64) -> f64) -> Vec<f64> {
    let n = signal.len();
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let mut spectrum = forward.make_output_vec();
    forward
        .process(&mut signal.to_vec(), &mut spectrum)
        .unwrap();
    for (k, bin) in spectrum.iter_mut().enumerate() {
        *bin *= gain(k as f64 * rate_hz / n as f64) / n as f64;
    }
    let mut output = inverse.make_output_vec();
    inverse.process(&mut spectrum, &mut output).unwrap();
    output
}

/// A room between source and microphone: the direct sound, and a tail of noise that decays exponentially.
pub struct Room {
    /// The spectrum of the impulse response, at the length of a padded recording.
    response: Vec<Complex64>,
}

impl Room {
    /// From a small car to a furnished room: the tail decays by 60 dB in 0.08 to 0.6 s, and is as strong as the
    /// direct sound or up to 12 dB below it.
    pub fn draw(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Self {
        let reverberation_s = log_uniform(rng, 0.08, 0.6);
        let gap = (rng.random_range(0.002..0.008) * rate_hz) as usize;
        let tail_power = 10f64.powf(-rng.random_range(0.0..12.0) / 10.0);
        let padded = n + rate_hz as usize;
        let mut impulse = vec![Complex64::ZERO; padded];
        let length = (reverberation_s * rate_hz) as usize;
        let mut energy = 0.0;
        for k in 0..length {
            let value = normal(rng) * 10f64.powf(-3.0 * k as f64 / length as f64);
            impulse[gap + k].re = value;
            energy += value * value;
        }
        let scale = (tail_power / energy).sqrt();
        impulse.iter_mut().for_each(|x| *x *= scale);
        impulse[0].re = 1.0;
        FftPlanner::new()
            .plan_fft_forward(padded)
            .process(&mut impulse);
        Self { response: impulse }
    }

    /// The sound at the microphone; the real and the imaginary part are two sounds.
    pub fn at_microphone(&self, source: &[Complex64]) -> Vec<Complex64> {
        let padded = self.response.len();
        let mut planner = FftPlanner::new();
        let mut buffer = source.to_vec();
        buffer.resize(padded, Complex64::ZERO);
        planner.plan_fft_forward(padded).process(&mut buffer);
        for (bin, gain) in buffer.iter_mut().zip(&self.response) {
            *bin *= gain / padded as f64;
        }
        planner.plan_fft_inverse(padded).process(&mut buffer);
        buffer.truncate(source.len());
        buffer
    }
}
