//! Sounds that are no squeaks: speech and music, noise of a resonance, bursts.
//!
//! A tone that is held for a large part of a second is a tonal event whatever makes it. The decoys therefore have no
//! sung or bowed notes: the pitch of a voice moves all the time, and the notes of the music are struck and die out.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rustfft::num_complex::Complex64;

use super::spectrum::{add, log_uniform, normal, rms};

/// First three formants of five vowels of a man, Hz.
const VOWELS: [[f64; 3]; 5] = [
    [270.0, 2290.0, 3010.0],
    [530.0, 1840.0, 2480.0],
    [730.0, 1090.0, 2440.0],
    [570.0, 840.0, 2410.0],
    [300.0, 870.0, 2240.0],
];

/// A resonance of two poles with gain 1 at zero frequency.
#[derive(Default, Clone, Copy)]
struct Resonator {
    gain: f64,
    feedback: [f64; 2],
    past: [f64; 2],
}

impl Resonator {
    fn tune(&mut self, frequency_hz: f64, width_hz: f64, rate_hz: f64) {
        let radius = (-TAU / 2.0 * width_hz / rate_hz).exp();
        self.feedback = [
            2.0 * radius * (TAU * frequency_hz / rate_hz).cos(),
            -radius * radius,
        ];
        self.gain = 1.0 - self.feedback[0] - self.feedback[1];
    }

    fn next(&mut self, input: f64) -> f64 {
        let [one, two] = self.past;
        let output = self.gain * input + self.feedback[0] * one + self.feedback[1] * two;
        self.past = [output, one];
        output
    }
}

/// The flow of air through the glottis over one period: it opens slowly and closes fast.
fn glottis(phase: f64) -> f64 {
    match phase {
        p if p < 0.4 => 0.5 - 0.5 * (TAU / 2.0 * p / 0.4).cos(),
        p if p < 0.56 => (TAU / 4.0 * (p - 0.4) / 0.16).cos(),
        _ => 0.0,
    }
}

/// A voice: what stays the same from syllable to syllable.
struct Voice {
    rate_hz: f64,
    pitch_hz: f64,
    /// Formants relative to a man's.
    size: f64,
    /// Loudness of the breath.
    breath: f64,
    phase: f64,
    tract: [Resonator; 4],
}

impl Voice {
    fn draw(rate_hz: f64, rng: &mut ChaCha8Rng) -> Self {
        let pitch_hz = log_uniform(rng, 90.0, 240.0);
        Self {
            rate_hz,
            pitch_hz,
            size: 1.0 + 0.2 * (pitch_hz / 90.0f64).log2().min(1.0),
            breath: rng.random_range(0.01..0.05),
            phase: 0.0,
            tract: Default::default(),
        }
    }

    /// Voiced sound of `n` samples; pitch (relative, in octaves) and vowel glide between the given values.
    fn voiced(
        &mut self,
        n: usize,
        pitch: [f64; 2],
        vowels: [[f64; 3]; 2],
        rng: &mut ChaCha8Rng,
    ) -> Vec<f64> {
        let every = (0.002 * self.rate_hz) as usize;
        let (mut jitter, mut shimmer, mut flow) = (1.0, 1.0, glottis(self.phase));
        let mut output = Vec::with_capacity(n);
        for i in 0..n {
            let share = i as f64 / n as f64;
            if i % every == 0 {
                for (k, resonator) in self.tract.iter_mut().enumerate() {
                    let formant = match k {
                        3 => 3500.0,
                        _ => vowels[0][k] + (vowels[1][k] - vowels[0][k]) * share,
                    };
                    let width = [70.0, 90.0, 130.0, 180.0][k];
                    resonator.tune(self.size * formant, width, self.rate_hz);
                }
            }
            let octaves = pitch[0] + (pitch[1] - pitch[0]) * share;
            let frequency = (self.pitch_hz * octaves.exp2()).clamp(80.0, 300.0);
            self.phase += jitter * frequency / self.rate_hz;
            if self.phase >= 1.0 {
                self.phase -= 1.0;
                jitter = 1.0 + 0.007 * normal(rng);
                shimmer = 1.0 + 0.05 * normal(rng);
            }
            let next = shimmer * glottis(self.phase);
            let source = (next - flow) * self.rate_hz / frequency / 10.0;
            flow = next;
            let excited = source + self.breath * normal(rng);
            let sound = self.tract.iter_mut().fold(excited, |x, r| r.next(x));
            output.push(sound * (TAU / 2.0 * share).sin().sqrt());
        }
        output
    }
}

/// A consonant without voice: noise around 1.5 to 7 kHz.
fn unvoiced(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let centre = log_uniform(rng, 1500.0, 7000f64.min(0.42 * rate_hz));
    let mut filter = Resonator::default();
    filter.tune(centre, 0.4 * centre, rate_hz);
    let mut before = 0.0;
    let mut at = |i: usize| {
        let sound = filter.next(normal(rng));
        let high = sound - before;
        before = sound;
        high * (TAU / 2.0 * i as f64 / n as f64).sin()
    };
    (0..n).map(&mut at).collect()
}

/// Speech-like sound of root mean square 1: glottal pulses at 80 to 300 Hz through moving formants, syllables,
/// noise, pauses.
pub fn speech(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut voice = Voice::draw(rate_hz, rng);
    let mut sum = vec![0.0; n];
    let mut at = (rng.random_range(0.05..0.5) * rate_hz) as usize;
    let samples = |seconds: f64| (seconds * rate_hz) as usize;
    while at < n {
        let syllables = rng.random_range(3..=10);
        let mut pitch = 0.15 + 0.1 * normal(rng);
        let mut vowel = VOWELS[rng.random_range(0..5)];
        for syllable in 0..syllables {
            if at < n && rng.random_bool(0.6) {
                let mut noise = unvoiced(samples(rng.random_range(0.04..0.12)), rate_hz, rng);
                let scale = rng.random_range(0.1..0.5) / rms(&noise);
                noise.iter_mut().for_each(|x| *x *= scale);
                add(&mut sum[at..], 1.0, &noise);
                at += noise.len();
            }
            let last = if syllable + 1 == syllables { 1.3 } else { 1.0 };
            let length = samples(last * rng.random_range(0.08..0.23));
            // The pitch falls over a phrase, with an accent on each syllable.
            let to =
                0.15 - 0.4 * f64::from(syllable + 1) / f64::from(syllables) + 0.1 * normal(rng);
            let next = VOWELS[rng.random_range(0..5)];
            let sound = voice.voiced(length, [pitch, to], [vowel, next], rng);
            let scale = rng.random_range(0.5..1.2) / rms(&sound);
            if at < n {
                add(&mut sum[at..], scale, &sound);
            }
            (pitch, vowel) = (to, next);
            at += length + samples(rng.random_range(0.0..0.04));
        }
        at += samples(rng.random_range(0.2..0.7));
    }
    scaled(sum)
}

fn scaled(mut signal: Vec<f64>) -> Vec<f64> {
    let scale = rms(&signal).recip();
    signal.iter_mut().for_each(|x| *x *= scale);
    signal
}

/// A struck or plucked note: slightly stretched partials that die out, the higher ones faster, until it is damped
/// after `held_s`.
fn note(pitch_hz: f64, decay_s: f64, held_s: f64, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let attack_s = rng.random_range(0.002..0.012);
    let fall = rng.random_range(0.8..1.8);
    let n = ((held_s + 0.25) * rate_hz) as usize;
    let mut sum = vec![0.0; n];
    for k in 1..=rng.random_range(5..=12) {
        let k = f64::from(k);
        let frequency = k * pitch_hz * (1.0 + 2e-4 * k * k).sqrt();
        if frequency > 0.45 * rate_hz {
            break;
        }
        let step = Complex64::from_polar(
            (-(1.0 + 0.3 * (k - 1.0)) / decay_s / rate_hz).exp(),
            TAU * frequency / rate_hz,
        );
        let gain = k.powf(-fall) * rng.random_range(0.3..1.0);
        let mut phasor = Complex64::from_polar(gain, rng.random_range(0.0..TAU));
        for x in &mut sum {
            *x += phasor.re;
            phasor *= step;
        }
    }
    for (i, x) in sum.iter_mut().enumerate() {
        let t = i as f64 / rate_hz;
        *x *= (t / attack_s).min(1.0) * (-(t - held_s).max(0.0) / 0.04).exp();
    }
    sum
}

/// Musical sound of root mean square 1: chords and runs of struck notes in a major scale, two to six changes a
/// second, with a drum in half of them.
pub fn music(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let tonic_hz = log_uniform(rng, 98.0, 196.0);
    let step_s = log_uniform(rng, 0.17, 0.5);
    let decay_s = log_uniform(rng, 0.1, 0.6);
    let drum = rng.random_bool(0.5);
    let scale = [0, 2, 4, 5, 7, 9, 11];
    let mut sum = vec![0.0; n];
    let mut at_s = rng.random_range(0.0..0.3);
    while at_s * rate_hz < n as f64 {
        let at = (at_s * rate_hz) as usize;
        let root = rng.random_range(0..7usize);
        for voice in 0..rng.random_range(1..=4usize) {
            let degree = root + 2 * voice;
            let octave = (degree / 7) as i32 + rng.random_range(0..=2);
            let semitones = f64::from(scale[degree % 7] + 12 * octave);
            let pitch_hz = tonic_hz * (semitones / 12.0).exp2();
            let held_s = step_s * f64::from(rng.random_range(1..=2));
            let sound = note(pitch_hz, decay_s, held_s, rate_hz, rng);
            add(&mut sum[at..], rng.random_range(0.4..1.0), &sound);
        }
        if drum && rng.random_bool(0.5) {
            let decay_s = log_uniform(rng, 0.015, 0.08);
            let count = (6.0 * decay_s * rate_hz) as usize;
            let beat: Vec<f64> = (0..count)
                .map(|k| normal(rng) * (-(k as f64) / rate_hz / decay_s).exp())
                .collect();
            add(&mut sum[at..], rng.random_range(0.3..1.0), &beat);
        }
        at_s += step_s * f64::from(rng.random_range(1..=2)) * rng.random_range(0.97..1.03);
    }
    scaled(sum)
}

/// Noise of a resonance 6 to 60 Hz wide, such as that of a tyre's cavity, of root mean square 1: its samples and frequency, Hz.
pub fn resonance(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
    let frequency = log_uniform(rng, 180.0, 4000.0);
    let mut filter = Resonator::default();
    filter.tune(frequency, log_uniform(rng, 6.0, 60.0), rate_hz);
    let noise = (0..n).map(|_| filter.next(normal(rng))).collect();
    (scaled(noise), frequency)
}

/// Noise of a resonance with a quality of 4 to 120 in stretches of 0.4 to 4 s, such as of a panel, of root mean square 1: its
/// samples and frequency, Hz.
pub fn damped_resonance(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
    let frequency = log_uniform(rng, 150.0, 0.4 * rate_hz.min(18e3));
    let mut filter = Resonator::default();
    filter.tune(frequency, frequency / log_uniform(rng, 4.0, 120.0), rate_hz);
    let mut noise: Vec<f64> = (0..n).map(|_| filter.next(normal(rng))).collect();
    let mut at_s = 0.0;
    while at_s * rate_hz < n as f64 {
        let end_s = at_s + log_uniform(rng, 0.4, 4.0);
        let pause_s = rng.random_range(0.3..1.5);
        let pause = [end_s, end_s + pause_s].map(|t| ((t * rate_hz) as usize).min(n));
        noise[pause[0]..pause[1]].fill(0.0);
        at_s = end_s + pause_s;
    }
    (scaled(noise), frequency)
}

/// Chatter of root mean square 1: series of impacts at 4 to 100 per second, regular to 0.01 to 50 %, that excite a resonance from
/// rest; its samples and the frequency of the resonance, Hz.
pub fn impacts(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
    let frequency = log_uniform(rng, 250.0, 0.4 * rate_hz.min(18e3));
    let mut sum = vec![0.0; n];
    let mut at_s = rng.random_range(0.0..1.0);
    while at_s * rate_hz < n as f64 {
        let distance_s = 1.0 / log_uniform(rng, 4.0, 100.0);
        let end_s = at_s + log_uniform(rng, 0.4, 4.0);
        let scatter = [log_uniform(rng, 1e-4, 0.5), log_uniform(rng, 0.01, 0.5)];
        let decay_s = distance_s * log_uniform(rng, 0.05, 0.5);
        while at_s < end_s && at_s * rate_hz < n as f64 {
            let gain = (scatter[1] * normal(rng)).exp();
            let first = (at_s * rate_hz).ceil();
            let count = (8.0 * decay_s * rate_hz) as usize;
            for (i, x) in sum[first as usize..].iter_mut().enumerate().take(count) {
                let t = (first + i as f64) / rate_hz - at_s;
                *x += gain * (-t / decay_s).exp() * (TAU * frequency * t).sin();
            }
            at_s += distance_s * (scatter[0] * normal(rng)).exp();
        }
        at_s += rng.random_range(0.3..1.5);
    }
    (scaled(sum), frequency)
}

/// Creak, chatter or rattle of root mean square 1: series of bursts at 5 to 60 per second that excite one resonance, with
/// scatter of their distances and heights; its samples and the frequency of the resonance, Hz.
pub fn bursts(n: usize, rate_hz: f64, rng: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
    let frequency = log_uniform(rng, 300.0, 5000.0);
    let decay_s = log_uniform(rng, 0.003, 0.03);
    let scatter = log_uniform(rng, 0.02, 0.4);
    let mut sum = vec![0.0; n];
    let mut at_s = rng.random_range(0.1..1.0);
    while at_s * rate_hz < n as f64 {
        let distance_s = log_uniform(rng, 1.0 / 60.0, 0.2);
        let end_s = at_s + log_uniform(rng, 0.4, 3.0);
        while at_s < end_s && at_s * rate_hz < n as f64 {
            let phase = rng.random_range(0.0..TAU);
            let gain = (scatter * normal(rng)).exp();
            for (i, x) in sum[(at_s * rate_hz) as usize..].iter_mut().enumerate() {
                let t = i as f64 / rate_hz;
                if t > 8.0 * decay_s {
                    break;
                }
                *x += gain * (-t / decay_s).exp() * (TAU * frequency * t + phase).sin();
            }
            at_s += distance_s * (1.0 + scatter * normal(rng)).clamp(0.2, 2.0);
        }
        at_s += rng.random_range(0.3..1.5);
    }
    (scaled(sum), frequency)
}
