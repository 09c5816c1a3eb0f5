//! Squeaks: tones with an onset, an end, drift, vibrato, modulation and harmonics.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rustfft::num_complex::Complex64;

use super::Kind;
use super::background::{Wander, amplitude};
use super::spectrum::{Room, log_uniform};

/// How the amplitude rises at the start and falls at the end.
enum Edge {
    /// A raised cosine of this duration, s: the load is applied or taken off.
    Ramp(f64),
    /// Exponential growth or decay with this time constant, s: growth of a vibration into saturation, or a
    /// vibration that dies out.
    Exponential(f64),
}

impl Edge {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_bool(0.5) {
            true => Self::Ramp(log_uniform(rng, 0.01, 0.12)),
            false => Self::Exponential(log_uniform(rng, 0.005, 0.04)),
        }
    }

    /// The amplitude, `inside` seconds after the start (or before the end).
    fn at(&self, inside: f64) -> f64 {
        match *self {
            Self::Ramp(duration) => {
                let share = (inside / duration).clamp(0.0, 1.0);
                0.5 - 0.5 * (share * TAU / 2.0).cos()
            }
            Self::Exponential(time) => 1.0 / (1.0 + (-inside / time).exp()),
        }
    }
}

/// A second tone, and its combinations with the first: they change the type of motion.
pub struct SecondTone {
    /// Frequency over that of the squeak, and amplitude over that of its fundamental, strongest first.
    lines: Vec<[f64; 2]>,
    /// When it sets in, share of the duration; negative for one that sounds from the start.
    onset: f64,
}

impl SecondTone {
    /// A subharmonic or incommensurate tone that sets in during the squeak.
    pub fn that_sets_in(rng: &mut ChaCha8Rng) -> Self {
        let ratio = [0.5, 0.618, 1.5, 1.414][rng.random_range(0..4)];
        Self {
            lines: vec![[ratio, rng.random_range(0.3..1.0)]],
            onset: rng.random_range(0.35..0.65),
        }
    }

    /// A period of two: lines between the harmonics.
    pub fn subharmonic(rng: &mut ChaCha8Rng) -> Self {
        let orders = [[0.5, 1.5], [1.5, 0.5], [1.5, 2.5]][rng.random_range(0..3)];
        let size = log_uniform(rng, 0.1, 0.8);
        Self {
            lines: vec![[orders[0], size], [orders[1], 0.5 * size]],
            onset: -1.0,
        }
    }

    /// An incommensurate tone, in half of the squeaks with combinations; or, in a third, the side lines of a fast
    /// modulation. None is above `highest`, over the frequency of the squeak.
    pub fn incommensurate(highest: f64, rng: &mut ChaCha8Rng) -> Self {
        let size = log_uniform(rng, 0.15, 1.0);
        let mut lines = if rng.random_bool(0.33) {
            let ratio = 1.0 + log_uniform(rng, 0.025, 0.3);
            let other = rng.random_range(0.3..1.0);
            vec![[ratio, 0.5 * size], [2.0 - ratio, 0.5 * size * other]]
        } else {
            let ratio = loop {
                let ratio = log_uniform(rng, 0.35, 2.7f64.min(highest));
                let off = |q: f64| (q * ratio - (q * ratio).round()).abs();
                if (1..=4).all(|q| off(f64::from(q)) > 0.03) {
                    break ratio;
                }
            };
            let combinations = [1.0 + ratio, (2.0 - ratio).abs(), (1.0 - ratio).abs()];
            let share = f64::from(u8::from(rng.random_bool(0.5)));
            let others =
                combinations.map(|line| [line, share * size * rng.random_range(0.02..0.5)]);
            [[ratio, size]].into_iter().chain(others).collect()
        };
        lines.retain(|[ratio, _]| *ratio < highest);
        Self { lines, onset: -1.0 }
    }

    /// The strongest line: its frequency and amplitude over those of the squeak's fundamental.
    pub fn strongest(&self) -> [f64; 2] {
        self.lines[0]
    }

    /// The tone at a share of the duration and a phase of the squeak, rad.
    fn at(&self, share: f64, phase: f64) -> f64 {
        let rise = ((share - self.onset) / 0.05).clamp(0.0, 1.0);
        let lines = self.lines.iter();
        rise * lines
            .map(|[ratio, size]| size * (ratio * phase).cos())
            .sum::<f64>()
    }
}

/// A Roessler system with a chaotic parameter, whose plane is that of an analytic signal.
#[derive(Clone)]
pub struct Chaos {
    parameter: f64,
    state: [f64; 3],
}

impl Chaos {
    /// Mean period in the unit of time of the system.
    const PERIOD: f64 = 5.9;

    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        // Between windows of periodic motion; the largest exponent is at least 0.3 per period.
        let chaotic = [[4.5, 4.6], [4.9, 5.1], [5.65, 5.95], [6.1, 6.5], [7.4, 7.8]];
        let [low, high] = chaotic[rng.random_range(0..chaotic.len())];
        let mut chaos = Self {
            parameter: rng.random_range(low..high),
            state: [1.0, 1.0, 0.0],
        };
        chaos.advance(rng.random_range(100.0..200.0));
        chaos
    }

    fn flow(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [-y - z, x + 0.2 * y, 0.2 + z * (x - self.parameter)]
    }

    /// Advances by a number of mean periods with the classical Runge-Kutta method.
    fn advance(&mut self, periods: f64) {
        let steps = (periods * Self::PERIOD / 0.05).ceil();
        let h = periods * Self::PERIOD / steps;
        let ahead = |s: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|c| s[c] + h * k[c]);
        for _ in 0..steps as usize {
            let s = self.state;
            let k1 = self.flow(s);
            let k2 = self.flow(ahead(s, k1, 0.5 * h));
            let k3 = self.flow(ahead(s, k2, 0.5 * h));
            let k4 = self.flow(ahead(s, k3, h));
            let slope = |c: usize| (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]) / 6.0;
            self.state = std::array::from_fn(|c| s[c] + h * slope(c));
        }
    }
}

/// A squeak to be made.
pub struct Plan {
    start_s: f64,
    duration_s: f64,
    /// Frequency in the middle, Hz.
    pub base_hz: f64,
    /// Relative change of frequency from start to end, linear and quadratic part.
    drift: [f64; 2],
    vibrato: (f64, f64),
    jitter: (f64, Wander),
    /// Rate in Hz and depth of the amplitude modulation; the depth is 0 without.
    pub modulation: (f64, f64),
    swell: (f64, Wander),
    /// A second tone.
    pub second: Option<SecondTone>,
    /// A chaotic motion instead of a tone with partials.
    pub chaos: Option<Chaos>,
    edges: [Edge; 2],
    /// Amplitudes of all partials, the first is 1.
    pub partials: Vec<f64>,
    /// Ratio of the fundamental's power to the background's in the third octave, dB.
    pub snr_db: f64,
}

impl Plan {
    /// A squeak of 0.3 to 5 s within a recording.
    pub fn draw(
        rate_hz: f64,
        length_s: f64,
        snr_db: &RangeInclusive<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let duration_s = log_uniform(rng, 0.3, 5f64.min(length_s - 1.0));
        let base_hz = log_uniform(rng, 205.0, 11_600f64.min(0.43 * rate_hz));
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let mut with = |chance: f64, low: f64, high: f64| match rng.random_bool(chance) {
            true => log_uniform(rng, low, high),
            false => 0.0,
        };
        let drift = [sign * with(0.6, 0.001, 0.03), with(0.3, 0.001, 0.01)];
        let vibrato_depth = with(0.3, 0.0005, 0.005);
        let modulation_depth = with(0.4, 0.1, 0.8);
        let fall = rng.random_range(0.7..2.5);
        let partials = (1..=rng.random_range(1..=6)).map(|k: i32| match k {
            1 => 1.0,
            _ => f64::from(k).powf(-fall) * rng.random_range(0.4..1.0),
        });
        Self {
            partials: partials.collect(),
            start_s: rng.random_range(0.3..length_s - 0.4 - duration_s),
            duration_s,
            base_hz,
            drift,
            vibrato: (rng.random_range(3.0..8.0), vibrato_depth),
            jitter: (log_uniform(rng, 1e-5, 5e-4), Wander::draw(rng, 1.0, 10.0)),
            modulation: (log_uniform(rng, 4.0, 40.0), modulation_depth),
            swell: (rng.random_range(0.0..1.5), Wander::draw(rng, 0.3, 3.0)),
            edges: [Edge::draw(rng), Edge::draw(rng)],
            snr_db: rng.random_range(snr_db.clone()),
            second: None,
            chaos: None,
        }
    }

    /// Makes the motion that of a kind of recordings. A second frequency or chaos is not modulated besides.
    pub fn change_motion(&mut self, kind: Kind, rate_hz: f64, rng: &mut ChaCha8Rng) {
        let highest = 0.45 * rate_hz / self.base_hz;
        match kind {
            Kind::Change => self.second = Some(SecondTone::that_sets_in(rng)),
            Kind::Doubled => {
                self.base_hz = self.base_hz.min(0.17 * rate_hz);
                self.second = Some(SecondTone::subharmonic(rng));
            }
            Kind::Torus => self.second = Some(SecondTone::incommensurate(highest, rng)),
            Kind::Chaos => {
                // Its spectrum must end below half of the rate.
                self.base_hz = self.base_hz.min(0.1 * rate_hz);
                self.partials.truncate(1);
                self.chaos = Some(Chaos::draw(rng));
            }
            _ => {}
        }
        if matches!(kind, Kind::Torus | Kind::Chaos) {
            self.modulation.1 = 0.0;
        }
    }

    /// Whether two squeaks could be one: together in time (or less than 0.4 s apart), one's fundamental within
    /// 6 % of a partial of the other.
    pub fn is_like(&self, other: &Self) -> bool {
        let gap = (self.start_s - other.start_s - other.duration_s)
            .max(other.start_s - self.start_s - self.duration_s);
        let ratio = (self.base_hz / other.base_hz).max(other.base_hz / self.base_hz);
        gap < 0.4 && ratio < 6.5 && (ratio / ratio.round() - 1.0).abs() < 0.06
    }

    /// Frequency `u` of the duration after the middle (-1/2 to 1/2), at the time `t` after the start.
    fn frequency(&self, u: f64, t: f64) -> f64 {
        let [linear, quadratic] = self.drift;
        let vibrato = self.vibrato.1 * (TAU * self.vibrato.0 * t).sin();
        let jitter = self.jitter.0 * self.jitter.1.at(t);
        self.base_hz * (1.0 + linear * u + 4.0 * quadratic * u * u + vibrato + jitter)
    }

    /// The fundamental as an analytic signal, and the sum of the other partials below 0.48 of the sampling rate,
    /// at the source.
    fn source(&self, n: usize, rate_hz: f64) -> (Vec<Complex64>, Vec<Complex64>) {
        let mut fundamental = vec![Complex64::ZERO; n];
        let mut rest = fundamental.clone();
        let mut chaos = self.chaos.clone();
        let (mut phase, mut whole_phase) = (0.0, 0.0);
        let margin = 0.4;
        let first = ((self.start_s - margin).max(0.0) * rate_hz) as usize;
        let last = (((self.start_s + self.duration_s + margin) * rate_hz) as usize).min(n);
        for i in first..last {
            let t = i as f64 / rate_hz - self.start_s;
            let u = (t / self.duration_s - 0.5).clamp(-0.5, 0.5);
            let frequency = self.frequency(u, t);
            phase = (phase + TAU * frequency / rate_hz) % TAU;
            whole_phase += TAU * frequency / rate_hz;
            let (rate, depth) = self.modulation;
            let level = self.edges[0].at(t)
                * self.edges[1].at(self.duration_s - t)
                * amplitude(self.swell.0 * self.swell.1.at(t))
                * (1.0 + depth * (TAU * rate * t).sin());
            fundamental[i] = Complex64::from_polar(level, phase);
            if let Some(chaos) = &mut chaos {
                chaos.advance(frequency / rate_hz);
                let [x, y, _] = chaos.state;
                fundamental[i] = 0.12 * level * Complex64::new(x, y);
            }
            if let Some(second) = &self.second {
                rest[i].re += level * second.at(u + 0.5, whole_phase);
            }
            for (k, gain) in self.partials.iter().enumerate().skip(1) {
                let order = (k + 1) as f64;
                if order * frequency < 0.48 * rate_hz {
                    rest[i].re += level * gain * (order * phase).cos();
                }
            }
        }
        (fundamental, rest)
    }

    /// The sound at the microphone.
    pub fn sound(&self, n: usize, rate_hz: f64, room: Option<&Room>) -> Sound {
        let (fundamental, rest) = self.source(n, rate_hz);
        match room {
            None => Sound::new(fundamental, rest, rate_hz),
            Some(room) => Sound::new(
                room.at_microphone(&fundamental),
                room.at_microphone(&rest),
                rate_hz,
            ),
        }
    }
}

/// A squeak at the microphone, before its level is set.
pub struct Sound {
    fundamental: Vec<Complex64>,
    rest: Vec<Complex64>,
    /// First and last sample at which the power of the fundamental is at least a tenth of the mean power of its
    /// loudest 100 ms.
    pub ends: [usize; 2],
    /// Longest time between the ends in which the power stays below this, samples.
    pub pause: usize,
}

impl Sound {
    fn new(fundamental: Vec<Complex64>, rest: Vec<Complex64>, rate_hz: f64) -> Self {
        let width = (0.1 * rate_hz) as usize;
        let power: Vec<f64> = fundamental.iter().map(|z| z.norm_sqr()).collect();
        let (mut sum, mut loudest) = (0.0, 0.0f64);
        for i in 0..power.len() {
            sum += power[i] - if i < width { 0.0 } else { power[i - width] };
            loudest = loudest.max(sum / width as f64);
        }
        let loud = |power: &f64| *power >= 0.1 * loudest;
        let first = power.iter().position(loud).expect("a squeak has power");
        let last = power.iter().rposition(loud).expect("a squeak has power");
        let pauses = power[first..=last].chunk_by(|a, b| loud(a) == loud(b));
        let pauses = pauses.filter(|part| !loud(&part[0]));
        Self {
            fundamental,
            rest,
            ends: [first, last],
            pause: pauses.map(<[f64]>::len).max().unwrap_or(0),
        }
    }

    /// Mean power of the fundamental between the ends.
    pub fn power(&self) -> f64 {
        let part = &self.fundamental[self.ends[0]..=self.ends[1]];
        part.iter().map(|z| z.norm_sqr()).sum::<f64>() / (2.0 * part.len() as f64)
    }

    /// Mean of the fundamental's frequency between the ends, weighted by its power, Hz.
    pub fn frequency_hz(&self, rate_hz: f64) -> f64 {
        let part = &self.fundamental[self.ends[0]..=self.ends[1]];
        let (mut turn, mut weight) = (0.0, 0.0);
        for pair in part.windows(2) {
            let product = pair[1] * pair[0].conj();
            turn += product.norm() * product.arg();
            weight += product.norm();
        }
        turn / weight * rate_hz / TAU
    }

    /// The sound itself, sample by sample.
    pub fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        let pairs = self.fundamental.iter().zip(&self.rest);
        pairs.map(|(fundamental, rest)| fundamental.re + rest.re)
    }
}
