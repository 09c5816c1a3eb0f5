//! What else a microphone hears: noise, hum and knocks.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::spectrum::{add, log_uniform, normal, shaped_noise};

/// Ratio of amplitudes of a level in dB.
pub fn amplitude(level_db: f64) -> f64 {
    10f64.powf(level_db / 20.0)
}

/// Noise and hum, and the names of the parts: noise with a power density of about 1/f (root mean square 1) with
/// the microphone's own white noise, and in about half of the recordings each road noise, rumble and hum.
pub fn steady(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> (Vec<f64>, Vec<&'static str>) {
    let exponent = rng.random_range(0.7..1.3);
    let mut sum = shaped_noise(n, rate_hz, rng, |f| f.max(20.0).powf(-exponent / 2.0));
    let white = shaped_noise(n, rate_hz, rng, |_| 1.0);
    add(&mut sum, amplitude(rng.random_range(-50.0..-30.0)), &white);
    let mut parts = vec!["pink noise"];
    if rng.random_bool(0.5) {
        let level = rng.random_range(-5.0..15.0);
        add(&mut sum, amplitude(level), &road(n, rate_hz, rng));
        parts.push("road noise");
    }
    if rng.random_bool(0.6) {
        let corner = rng.random_range(40.0..100.0f64);
        let rumble = shaped_noise(n, rate_hz, rng, |f| 1.0 / (1.0 + (f / corner).powi(4)));
        add(&mut sum, amplitude(rng.random_range(5.0..30.0)), &rumble);
        parts.push("rumble");
    }
    if rng.random_bool(0.5) {
        add(
            &mut sum,
            amplitude(rng.random_range(-15.0..15.0)),
            &hum(n, rate_hz, rng),
        );
        parts.push("hum");
    }
    (sum, parts)
}

/// Tyres on asphalt: noise with a maximum near 1 kHz and the resonance of the air in the tyre, falling off on
/// both sides, that swells and fades with the surface.
fn road(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (corner, hump) = (
        rng.random_range(150.0..500.0),
        rng.random_range(700.0..1100.0),
    );
    let (air, quality) = (rng.random_range(180.0..240.0), rng.random_range(4.0..8.0));
    let resonance = |f: f64, f0: f64, q: f64| 1.0 / (1.0 + (q * (f / f0 - f0 / f)).powi(2)).sqrt();
    let mut noise = shaped_noise(n, rate_hz, rng, |f| {
        1.0 / (1.0 + (f / corner).powi(2))
            + 0.3 * resonance(f, hump, 1.5)
            + resonance(f, air, quality)
    });
    let swell = Wander::draw(rng, 0.2, 2.0);
    for (k, x) in noise.iter_mut().enumerate() {
        *x *= amplitude(2.0 * swell.at(k as f64 / rate_hz));
    }
    noise
}

/// Hum of the mains: 50 or 60 Hz, off by at most 0.05 Hz, with up to 20 harmonics of falling amplitude.
fn hum(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mains = if rng.random_bool(0.5) { 50.0 } else { 60.0 };
    let base = mains + rng.random_range(-0.05..0.05);
    let count = rng.random_range(1..=20);
    let fall = rng.random_range(0.7..1.5);
    let mut sum = vec![0.0; n];
    for harmonic in 1..=count {
        let k = f64::from(harmonic);
        let strength = if harmonic == 1 {
            1.0
        } else {
            rng.random_range(0.05..1.0)
        };
        let (gain, phase) = (strength * k.powf(-fall), rng.random_range(0.0..TAU));
        for (i, x) in sum.iter_mut().enumerate() {
            *x += gain * (TAU * k * base * i as f64 / rate_hz + phase).sin();
        }
    }
    let scale = super::spectrum::rms(&sum).recip();
    sum.iter_mut().for_each(|x| *x *= scale);
    sum
}

/// One to eight knocks of peak 2 to 30: a click that excites two to five damped modes of a panel.
pub fn knocks(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut sum = vec![0.0; n];
    for _ in 0..rng.random_range(1..=8) {
        let mut knock = vec![0.0; (0.3 * rate_hz) as usize];
        let click_s = rng.random_range(0.0005..0.003);
        for (k, x) in knock.iter_mut().enumerate() {
            *x = 0.5 * normal(rng) * (-(k as f64) / rate_hz / click_s).exp();
        }
        for _ in 0..rng.random_range(2..=5) {
            let (frequency, decay_s) = (
                log_uniform(rng, 100.0, 4000.0),
                log_uniform(rng, 0.002, 0.03),
            );
            let (gain, phase) = (rng.random_range(0.2..1.0), rng.random_range(0.0..TAU));
            for (k, x) in knock.iter_mut().enumerate() {
                let t = k as f64 / rate_hz;
                *x += gain * (-t / decay_s).exp() * (TAU * frequency * t + phase).sin();
            }
        }
        let peak = knock.iter().fold(0.0f64, |peak, x| peak.max(x.abs()));
        let at = rng.random_range(0..n);
        add(&mut sum[at..], log_uniform(rng, 2.0, 30.0) / peak, &knock);
    }
    sum
}

/// A smooth random function of time with mean 0 and root mean square 1.
pub struct Wander([(f64, f64); 4]);

impl Wander {
    /// Four sines with random frequencies between `low` and `high`, Hz.
    pub fn draw(rng: &mut ChaCha8Rng, low: f64, high: f64) -> Self {
        Self(std::array::from_fn(|_| {
            (rng.random_range(low..high), rng.random_range(0.0..TAU))
        }))
    }

    /// The value at a time in s.
    pub fn at(&self, t: f64) -> f64 {
        let sines = self.0.iter().map(|(f, phase)| (TAU * f * t + phase).sin());
        sines.sum::<f64>() / 2f64.sqrt()
    }
}
