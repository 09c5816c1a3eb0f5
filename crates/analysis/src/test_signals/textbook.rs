//! Textbook signals with parameters drawn at random, and the verdicts that are right for each.
//!
//! The truth comes from the equations, not from the signal: closed forms, parameters with known
//! attractors, and for chaos a positive largest exponent of the system. Signals are numbered: numbers below
//! [`JUDGING`] are for the fit, those from it on for judging only. Families
//! with `judged_only` serve for judging alone.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::systems::{self, Flow};
use super::{noise, trajectory};
use squeakscope_analysis::regime::Regime::{
    self, Chaotic, Noise, Periodic, QuasiPeriodic, Transient, Undetermined,
};

/// First number of the signals for judging.
pub const JUDGING: u64 = 1_000_000;

/// Period of the Roessler system, in its unit of time.
pub(super) const ROESSLER: f64 = 5.9;

/// Largest exponents per period, of perturbations at equal phase of the drive: chaos; no divergence; neither
/// divergence nor convergence, as on a driven oscillator's torus (if it is locked to the drive they converge).
pub(super) const CHAOS: [f64; 2] = [0.03, f64::INFINITY];
const REGULAR: [f64; 2] = [f64::NEG_INFINITY, 0.002];
const NEUTRAL: [f64; 2] = [-0.002, 0.002];

/// A family of textbook signals.
pub struct Textbook {
    pub name: &'static str,
    /// Right verdicts; the first is the expected one. Undetermined without being listed is no error, but not
    /// right either.
    pub right: &'static [Regime],
    pub judged_only: bool,
    make: fn(&mut Draw) -> Vec<f64>,
}

impl Textbook {
    /// The signal of this number, and the power of its background; 0 if unknown.
    pub fn signal(&self, number: u64) -> (Vec<f64>, f64) {
        let name = self.name.bytes().fold(0_u64, |hash, byte| {
            hash.wrapping_mul(31).wrapping_add(u64::from(byte))
        });
        let seed = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ name;
        let mut draw = Draw {
            rng: ChaCha8Rng::seed_from_u64(seed),
            background: 0.0,
        };
        ((self.make)(&mut draw), draw.background)
    }
}

/// Random parameters.
pub(super) struct Draw {
    pub rng: ChaCha8Rng,
    /// Power of the background of a recording.
    pub background: f64,
}

impl Draw {
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.rng.random::<f64>()
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.rng.random_range(0..from.len())]
    }

    /// Number of samples.
    pub fn count(&mut self) -> usize {
        self.between(2500.0, 10_000.0) as usize
    }

    /// Samples per period.
    pub fn rate(&mut self) -> f64 {
        self.between(16.0, 50.0)
    }

    pub fn phase(&mut self) -> f64 {
        self.between(0.0, TAU)
    }

    /// Adds white noise of a share of the standard deviation.
    pub fn with_noise(&mut self, signal: Vec<f64>, share: f64) -> Vec<f64> {
        let deviation = squeakscope_analysis::stats::deviation(&signal);
        let noise = noise(self.rng.random(), signal.len(), share * deviation);
        signal.iter().zip(noise).map(|(x, e)| x + e).collect()
    }

    /// Adds a little noise or none.
    pub fn with_floor(&mut self, signal: Vec<f64>) -> Vec<f64> {
        let share = self.pick(&[0.0, 1e-4, 1e-3, 1e-2, 3e-2]);
        self.with_noise(signal, share)
    }

    /// Component 0 of a flow from a state on its attractor on, `rate` samples per `period`.
    fn flow<const N: usize>(&mut self, flow: &Flow<N>, settled: [f64; N], period: f64) -> Vec<f64> {
        let (n, rate) = (self.count(), self.rate());
        let skipped = self.between(0.0, 10.0) * period;
        let states = trajectory(flow, settled, skipped, n, period / rate, period / 300.0);
        let signal = states.iter().map(|state| state[0]).collect();
        self.with_floor(signal)
    }

    /// The same of the first flow drawn whose largest exponent per period is in a range.
    pub fn attractor<const N: usize>(
        &mut self,
        draw: fn(&mut Self) -> Flow<N>,
        start: [f64; N],
        period: f64,
        exponents: [f64; 2],
    ) -> Vec<f64> {
        loop {
            let flow = draw(self);
            let start = start.map(|x| x + self.between(-0.1, 0.1));
            let settled = super::advance(&flow, start, 200.0 * period, period / 300.0);
            let exponent =
                period * systems::exponent(&flow, settled, 400.0 * period, period / 200.0);
            if (exponents[0]..exponents[1]).contains(&exponent) {
                return self.flow(&flow, settled, period);
            }
        }
    }

    /// Values at `phase(periods)` of the given number of samples, `rate` per period.
    pub fn closed(&mut self, value: impl Fn(f64) -> f64) -> Vec<f64> {
        let (n, rate) = (self.count(), self.rate());
        (0..n).map(|i| value(i as f64 / rate)).collect()
    }

    /// A periodic function of a phase: one to five harmonics.
    pub fn wave(&mut self) -> impl Fn(f64) -> f64 + use<> {
        let harmonics = self.pick(&[1, 2, 3, 5]);
        let list: Vec<[f64; 2]> = (0..harmonics)
            .map(|k| [self.between(0.1, 0.6).powi(k), self.phase()])
            .collect();
        move |phase| {
            let terms = list.iter().enumerate();
            terms
                .map(|(k, [a, shift])| a * ((k + 1) as f64 * phase + shift).sin())
                .sum()
        }
    }

    /// A ratio of frequencies that is far from ratios of small integers.
    pub fn irrational(&mut self) -> f64 {
        self.pick(&[
            0.618_034, 1.618_034, 0.414_214, 2.302_776, 0.732_051, 1.324_718,
        ]) * self.between(0.998, 1.002)
    }
}

/// Families of closed forms, flows and maps.
pub const TEXTBOOK: &[Textbook] = &[
    family("periodic", &[Periodic], |draw| {
        let wave = draw.wave();
        let signal = draw.closed(|t| wave(TAU * t));
        draw.with_floor(signal)
    }),
    family("noisy periodic", &[Periodic], |draw| {
        let wave = draw.wave();
        let signal = draw.closed(|t| wave(TAU * t));
        let share = draw.between(0.02, 0.1);
        draw.with_noise(signal, share)
    }),
    family("period doubling cascade", &[Periodic], |draw| {
        let flow = |draw: &mut Draw| {
            let windows = [[2.0, 2.7], [3.0, 3.7], [3.92, 4.09], [4.13, 4.18]];
            let [low, high] = draw.pick(&windows);
            systems::driven_roessler(draw.between(low, high), 0.0, 1.0)
        };
        draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, REGULAR)
    }),
    family("locked 1:3", &[Periodic], |draw| {
        let share = draw.between(-0.9, 0.9);
        locking(draw, share)
    }),
    family("Mackey-Glass, periodic", &[Periodic], |draw| {
        let delay = draw.between(7.0, 12.0);
        let (n, rate) = (draw.count(), draw.rate());
        let signal = systems::mackey_glass(n, 4.0 * delay / rate, delay, draw.between(0.5, 1.2));
        draw.with_floor(signal)
    }),
    family("periodic after an onset", &[Periodic], |draw| {
        let wave = draw.wave();
        let signal = draw.closed(|t| wave(TAU * t));
        let signal = after_onset(draw, signal);
        draw.with_floor(signal)
    }),
    family("periodic, with a residue", &[Periodic], |draw| {
        // A decaying second motion, or an amplitude that is not settled.
        let (wave, shift, ratio) = (draw.wave(), draw.phase(), draw.irrational());
        let (ratio, decibels) = (draw.pick(&[ratio, 1.0]), draw.between(-40.0, -20.0));
        let (size, decay) = (10.0_f64.powf(decibels / 20.0), draw.between(3.0, 40.0));
        let signal = draw.closed(|t| {
            let residue = size * (-t / decay).exp() * (TAU * ratio * t + shift).sin();
            wave(TAU * t) + residue
        });
        draw.with_floor(signal)
    }),
    family("periodic, with a second mode", &[Periodic], |draw| {
        let (wave, n, rate) = (draw.wave(), draw.count(), draw.rate());
        let mode = second_mode(draw, n, TAU / rate);
        let (square, cube) = (draw.between(0.0, 0.4), draw.between(-0.2, 0.0));
        let at = |(i, mode): (usize, f64)| {
            let x = wave(TAU * i as f64 / rate) + mode;
            x + square * x * x + cube * x.powi(3)
        };
        let signal = mode.into_iter().enumerate().map(at).collect();
        draw.with_floor(signal)
    }),
    family("periodic, in a ramp", &[Periodic], |draw| {
        // Another waveform, level and frequency at the end.
        let (first, last, share) = (draw.wave(), draw.wave(), draw.between(0.0, 0.15));
        let (bend, n) = (draw.between(-3e-3, 3e-3), 300.0);
        let signal = draw.closed(|t| {
            let phase = TAU * t * (1.0 + 0.5 * bend * t / n);
            first(phase) + share * t / n * last(phase)
        });
        draw.with_floor(signal)
    }),
    judged("van der Pol, locked", &[Periodic], |draw| {
        // Strongly driven near its own frequency: entrained.
        let flow = |draw: &mut Draw| {
            systems::van_der_pol(draw.between(0.1, 0.5), 1.0, draw.between(0.95, 1.05))
        };
        draw.attractor(flow, [1.0, 0.0, 0.0], TAU, REGULAR)
    }),
    judged("Duffing, periodic", &[Periodic], |draw| {
        let flow = |draw: &mut Draw| {
            systems::duffing(draw.between(0.1, 0.3), 1.0, draw.between(0.1, 0.3), 1.0)
        };
        draw.attractor(flow, [0.1, 0.0, 0.0], TAU, REGULAR)
    }),
    family("near locking 1:3", &[QuasiPeriodic], |draw| {
        let share = draw.between(1.1, 3.0) * draw.pick(&[-1.0, 1.0]);
        locking(draw, share)
    }),
    family("torus", &[QuasiPeriodic], |draw| {
        let signal = torus(draw);
        draw.with_floor(signal)
    }),
    family("noisy torus", &[QuasiPeriodic], |draw| {
        let signal = torus(draw);
        let share = draw.between(0.02, 0.06);
        draw.with_noise(signal, share)
    }),
    family("torus after an onset", &[QuasiPeriodic], |draw| {
        let signal = torus(draw);
        let signal = after_onset(draw, signal);
        draw.with_floor(signal)
    }),
    judged("amplitude modulated", &[QuasiPeriodic], |draw| {
        let (wave, depth, shift) = (draw.wave(), draw.between(0.1, 0.8), draw.phase());
        let slow = draw.between(0.04, 0.2);
        let signal =
            draw.closed(|t| (1.0 + depth * (TAU * slow * t + shift).sin()) * wave(TAU * t));
        draw.with_floor(signal)
    }),
    family("frequency modulated", &[QuasiPeriodic], |draw| {
        let (wave, depth, shift) = (draw.wave(), draw.between(0.2, 1.0), draw.phase());
        let slow = draw.between(0.04, 0.2);
        let signal = draw.closed(|t| wave(TAU * t + depth * (TAU * slow * t + shift).sin()));
        draw.with_floor(signal)
    }),
    family(
        "torus doubling, driven Roessler",
        &[QuasiPeriodic],
        |draw| {
            let flow = |draw: &mut Draw| {
                let [low, high, size] =
                    draw.pick(&[[2.2, 2.6, 0.3], [3.05, 3.5, 0.3], [3.92, 4.0, 0.1]]);
                let (size, ratio) = (size * draw.between(0.5, 1.0), draw.irrational());
                systems::driven_roessler(draw.between(low, high), size, ratio * TAU / ROESSLER)
            };
            draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, NEUTRAL)
        },
    ),
    judged("torus doubling, Kaneko's map", &[QuasiPeriodic], |draw| {
        let (a, e) = (draw.between(3.1, 3.35), draw.between(0.01, 0.04));
        let map = systems::kaneko(a, e, TAU * draw.irrational());
        let states = systems::iterate(map, [0.3, 0.0], draw.count());
        states.iter().map(|state| state[0]).collect()
    }),
    judged("van der Pol, torus", &[QuasiPeriodic], |draw| {
        let flow = |draw: &mut Draw| {
            let ratio = draw.irrational();
            systems::van_der_pol(draw.between(0.1, 0.4), draw.between(0.3, 0.6), ratio)
        };
        draw.attractor(flow, [1.0, 0.0, 0.0], TAU, NEUTRAL)
    }),
    family("Lorenz", &[Chaotic], |draw| {
        let period = 0.75;
        let flow = |draw: &mut Draw| systems::lorenz(draw.between(26.0, 40.0));
        draw.attractor(flow, [1.0, 1.0, 20.0], period, CHAOS)
    }),
    family("Roessler", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| systems::driven_roessler(draw.between(4.4, 9.0), 0.0, 1.0);
        draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, CHAOS)
    }),
    family("chaos after torus doubling", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| {
            let (size, ratio) = (draw.between(0.1, 0.4), draw.irrational());
            systems::driven_roessler(draw.between(4.3, 6.0), size, ratio * TAU / ROESSLER)
        };
        draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, CHAOS)
    }),
    family("chaos after an onset", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| systems::driven_roessler(draw.between(4.4, 9.0), 0.0, 1.0);
        let signal = draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, CHAOS);
        after_onset(draw, signal)
    }),
    family("Duffing, two wells", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| {
            systems::duffing(draw.between(0.15, 0.3), -1.0, draw.between(0.28, 0.45), 1.0)
        };
        draw.attractor(flow, [0.1, 0.1, 0.0], TAU, CHAOS)
    }),
    family("Mackey-Glass", &[Chaotic], |draw| {
        let delay = draw.pick(&[17.0, 22.0, 23.0, 30.0]);
        let (n, rate) = (draw.count(), draw.rate());
        let signal = systems::mackey_glass(n, 50.0 / rate, delay, draw.between(0.5, 1.2));
        draw.with_floor(signal)
    }),
    family("intermittency, logistic map", &[Chaotic], |draw| {
        // The window of period 3 starts at 1 + sqrt 8.
        let map = systems::logistic(1.0 + 8.0_f64.sqrt() - draw.between(1e-4, 2e-3));
        let states = systems::iterate(map, [draw.between(0.1, 0.9)], draw.count());
        states.iter().map(|state| state[0]).collect()
    }),
    family("crisis, logistic map", &[Chaotic], |draw| {
        // The three bands of the window of period 3 merge at 3.8568.
        let map = systems::logistic(draw.between(3.857, 3.87));
        let states = systems::iterate(map, [draw.between(0.1, 0.9)], draw.count());
        states.iter().map(|state| state[0]).collect()
    }),
    judged("intermittency, Lorenz", &[Chaotic], |draw| {
        // A limit cycle disappears at 166.06.
        let flow = |draw: &mut Draw| systems::lorenz(draw.between(166.3, 168.0));
        draw.attractor(flow, [1.0, 1.0, 160.0], 0.4, CHAOS)
    }),
    judged("Ueda", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| {
            systems::duffing(draw.between(0.05, 0.1), 0.0, draw.between(7.5, 12.0), 1.0)
        };
        draw.attractor(flow, [1.0, 0.1, 0.0], TAU / 2.0, CHAOS)
    }),
    judged("Chua", &[Chaotic], |draw| {
        let flow = |draw: &mut Draw| systems::chua(draw.between(8.9, 9.6));
        draw.attractor(flow, [0.5, 0.1, 0.0], 2.4, CHAOS)
    }),
    judged("Henon", &[Chaotic], |draw| {
        let states = systems::iterate(systems::henon(1.4), [0.1, 0.1], draw.count());
        states.iter().map(|state| state[0]).collect()
    }),
    family("white noise", &[Noise], |draw| {
        let (seed, n) = (draw.rng.random(), draw.count());
        noise(seed, n, 1.0)
    }),
    family("coloured noise, first order", &[Noise], |draw| {
        let memory = draw.between(0.3, 0.99);
        coloured(draw, memory, 0.0)
    }),
    family("rumble", &[Noise, Undetermined], |draw| {
        let angle = TAU / draw.between(50.0, 500.0);
        let radius = (-draw.between(0.2, 1.0) * angle).exp();
        coloured(draw, 2.0 * radius * angle.cos(), -radius * radius)
    }),
    family("coloured noise, resonance", &[Noise], |draw| {
        let radius: f64 = draw.between(0.9, 0.997);
        let angle = TAU * draw.between(0.02, 0.06);
        coloured(draw, 2.0 * radius * angle.cos(), -radius * radius)
    }),
    judged("pink noise", &[Noise], |draw| {
        let n = draw.count();
        let octave = |k: i32| {
            let decay = 1.0 - 0.5 / 4.0_f64.powi(k);
            let driven = noise(draw.rng.random(), n + 2000, (1.0 - decay * decay).sqrt());
            autoregressive(&driven, decay, 0.0)
        };
        let octaves: Vec<Vec<f64>> = (0..5).map(octave).collect();
        (0..n).map(|i| octaves.iter().map(|x| x[i]).sum()).collect()
    }),
    judged(
        "random amplitude",
        &[Noise, Undetermined, Transient],
        |draw| {
            let (wave, n, rate) = (draw.wave(), draw.count(), draw.rate());
            let decay = (-1.0 / (draw.between(3.0, 20.0) * rate)).exp();
            let driven = noise(draw.rng.random(), n + 2000, (1.0 - decay * decay).sqrt());
            let envelope = autoregressive(&driven, decay, 0.0);
            let at = |(i, e): (usize, &f64)| (1.0 + 0.4 * e) * wave(TAU * i as f64 / rate);
            envelope.iter().enumerate().map(at).collect()
        },
    ),
    family("decay or growth", &[Transient], |draw| {
        let (signal, rate) = (
            torus_or_wave(draw),
            draw.between(0.5, 4.0) * draw.pick(&[-1.0, 1.0]),
        );
        let n = signal.len() as f64;
        let shaped = signal.iter().enumerate();
        let shaped = shaped
            .map(|(i, x)| x * (rate * i as f64 / n).exp())
            .collect();
        draw.with_floor(shaped)
    }),
    family("one burst", &[Transient], |draw| {
        let (signal, share) = (torus_or_wave(draw), draw.between(-8.0, -0.7).exp());
        let n = signal.len() as f64;
        let first = draw.between(0.0, 1.0 - share) * n;
        let burst = first as usize..=(first + share * n) as usize;
        let within = |(i, x): (usize, &f64)| if burst.contains(&i) { *x } else { 0.0 };
        let shaped = signal.iter().enumerate().map(within).collect();
        draw.with_floor(shaped)
    }),
    family("chirp", &[Transient, Undetermined], |draw| {
        let (wave, widening) = (draw.wave(), draw.between(0.05, 0.5));
        let (n, rate) = (draw.count() as f64, draw.rate());
        let phase = |i: f64| TAU * i / rate * (1.0 + 0.5 * widening * i / n);
        (0..n as usize).map(|i| wave(phase(i as f64))).collect()
    }),
    judged(
        "transient chaos, Lorenz",
        &[Transient, Undetermined],
        |draw| {
            // Between 13.93 and 24.06 chaos decays to a fixed point.
            let (dt, n) = (0.75 / draw.rate(), draw.count());
            loop {
                let flow = systems::lorenz(draw.between(21.0, 23.0));
                let start = [1.0, 20.0, 20.0].map(|x| x * draw.between(0.5, 1.5));
                let states = trajectory(flow, start, 20.0, n, dt, 0.0025);
                let x: Vec<f64> = states.iter().map(|state| state[0]).collect();
                let last = x[n - 1].signum();
                let decays = x.iter().rposition(|x| x.signum() != last).unwrap_or(0);
                if (0.3..0.7).contains(&(decays as f64 / n as f64)) {
                    return x;
                }
            }
        },
    ),
    family(
        "chaos, then a limit cycle",
        &[Transient, Undetermined],
        |draw| {
            let c = [draw.between(5.4, 5.8), draw.between(2.2, 3.7)];
            switched(draw, c, 0.0)
        },
    ),
    family(
        "limit cycle, then a torus",
        &[Transient, Undetermined],
        |draw| {
            let c = draw.between(2.2, 3.6);
            switched(draw, [c, c], 0.5)
        },
    ),
    family("short", &[Undetermined], |draw| {
        let (periods, rate) = (draw.between(4.0, 10.0), draw.between(16.0, 60.0));
        let (wave, ratio, size) = (draw.wave(), draw.irrational(), draw.pick(&[0.0, 0.5]));
        let at = |i: usize| {
            let phase = TAU * i as f64 / rate;
            wave(phase) + size * (ratio * phase).sin()
        };
        (0..(periods * rate) as usize).map(at).collect()
    }),
];

pub(super) const fn family(
    name: &'static str,
    right: &'static [Regime],
    make: fn(&mut Draw) -> Vec<f64>,
) -> Textbook {
    let judged_only = false;
    Textbook {
        name,
        right,
        judged_only,
        make,
    }
}

pub(super) const fn judged(
    name: &'static str,
    right: &'static [Regime],
    make: fn(&mut Draw) -> Vec<f64>,
) -> Textbook {
    let judged_only = true;
    Textbook {
        name,
        right,
        judged_only,
        make,
    }
}

/// Two oscillators near 1:3, `p' = 1`, `q' = 3 + e (share + sin(3 p - q))`: locked (R. Adler, Proc. IRE 34,
/// 351, 1946) if `share` is between -1 and 1. Otherwise the phases slip, here at least 6 times in the
/// record.
fn locking(draw: &mut Draw, share: f64) -> Vec<f64> {
    // Fifteen harmonics of the slower oscillator.
    let (n, rate) = (draw.count(), draw.between(40.0, 80.0));
    let slips = draw.between(6.0, 30.0);
    let slip = TAU * slips / (n as f64 * TAU / rate);
    let strength = match share.abs() {
        inside if inside < 1.0 => draw.between(0.03, 0.2),
        outside => slip / (outside * outside - 1.0).sqrt(),
    };
    let flow: Flow<2> =
        Box::new(move |[p, q]| [1.0, 3.0 + strength * (share + (3.0 * p - q).sin())]);
    let states = trajectory(
        flow,
        [draw.phase(), draw.phase()],
        1000.0,
        n,
        TAU / rate,
        0.02,
    );
    let (first, second, size) = (draw.wave(), draw.wave(), draw.between(0.3, 0.8));
    let signal = states.iter().map(|[p, q]| first(*p) + size * second(*q));
    let signal = signal.collect();
    draw.with_floor(signal)
}

/// Two tones through a nonlinear function.
fn torus(draw: &mut Draw) -> Vec<f64> {
    let (ratio, size, phase) = (draw.irrational(), draw.between(0.2, 0.8), draw.phase());
    let (square, cube) = (draw.between(0.0, 0.4), draw.between(-0.2, 0.0));
    draw.closed(|t| {
        let x = (TAU * t).sin() + size * (TAU * ratio * t + phase).sin();
        x + square * x * x + cube * x.powi(3)
    })
}

fn torus_or_wave(draw: &mut Draw) -> Vec<f64> {
    if draw.between(0.0, 1.0) < 0.5 {
        return torus(draw);
    }
    let wave = draw.wave();
    draw.closed(|t| wave(TAU * t))
}

/// A motion that grows exponentially from a small amplitude, and has settled before a sixth of the record.
fn after_onset(draw: &mut Draw, settled: Vec<f64>) -> Vec<f64> {
    let (half, rate) = (draw.between(0.0, 0.1), draw.between(30.0, 200.0));
    let n = settled.len() as f64;
    let envelope = |i: usize| 1.0 / (1.0 + (2.0 * rate * (half - i as f64 / n)).exp()).sqrt();
    settled
        .iter()
        .enumerate()
        .map(|(i, x)| x * envelope(i))
        .collect()
}

/// A weak mode beside a limit cycle that advances by `angle` per sample: it decays after the onset, while the cycle has its
/// level already, or noise excites it.
fn second_mode(draw: &mut Draw, n: usize, angle: f64) -> Vec<f64> {
    let (ratio, near) = (draw.irrational(), draw.between(0.8, 1.2));
    let angle = angle * draw.pick(&[ratio, near]);
    if draw.pick(&[true, false]) {
        let (decibels, shift) = (draw.between(-40.0, -20.0), draw.phase());
        let (size, decay) = (
            10.0_f64.powf(decibels / 20.0),
            draw.between(0.05, 0.3) * n as f64,
        );
        let at = |i: f64| size * (-i / decay).exp() * (angle * i + shift).sin();
        return (0..n).map(|i| at(i as f64)).collect();
    }
    let decay = draw.between(5.0, 40.0) * TAU / angle;
    let radius = (-1.0 / decay).exp();
    let driven = noise(draw.rng.random(), n + 2000, 1.0);
    let mode = autoregressive(&driven, 2.0 * radius * angle.cos(), -radius * radius);
    let size = 10.0_f64.powf(draw.between(-45.0, -22.0) / 20.0);
    let scale = size / squeakscope_analysis::stats::deviation(&mode);
    mode.iter().map(|x| scale * x).collect()
}

/// `x_n = a x_(n-1) + b x_(n-2) + e_n`.
pub(super) fn coloured(draw: &mut Draw, a: f64, b: f64) -> Vec<f64> {
    let (seed, n) = (draw.rng.random(), draw.count());
    autoregressive(&noise(seed, n + 2000, 1.0), a, b)
}

/// The same for given `e`, without the first 2000 values.
pub(super) fn autoregressive(driven: &[f64], a: f64, b: f64) -> Vec<f64> {
    let mut past = [0.0; 2];
    let step = |e: &f64| {
        past = [a * past[0] + b * past[1] + e, past[0]];
        past[0]
    };
    driven.iter().map(step).skip(2000).collect()
}

/// A Roessler system whose parameter changes between a third and two thirds of the record; then with a
/// drive.
fn switched(draw: &mut Draw, [before, after]: [f64; 2], drive: f64) -> Vec<f64> {
    let (n, dt) = (draw.count(), ROESSLER / draw.rate());
    let change = (draw.between(0.33, 0.67) * n as f64) as usize;
    let start = [1.0, 1.0, 0.0, 0.0].map(|x| x + draw.between(-0.1, 0.1));
    let first = systems::driven_roessler(before, 0.0, 0.5 * PI);
    let first = trajectory(first, start, 600.0, change, dt, 0.02);
    let second = systems::driven_roessler(after, drive, 0.618_034 * TAU / ROESSLER);
    let second = trajectory(second, first[change - 1], dt, n - change, dt, 0.02);
    let signal = first.iter().chain(&second).map(|state| state[0]);
    let signal = signal.collect();
    draw.with_floor(signal)
}
