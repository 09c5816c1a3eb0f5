//! Kinds of events of families of sounds that were not used for the fit: tones, noise of a resonance, and impacts, in noise.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::kind::CLASSES;
use super::{EventKind, EventOptions, tonal_events};
use crate::generator::spectrum::{add, log_uniform, normal, rms, shaped_noise};

/// Length of a recording, s.
const LENGTH_S: f64 = 5.0;

/// What draws a sound of root mean square 1 that lasts for the whole recording at a rate (Hz).
type Draw = fn(f64, &mut ChaCha8Rng) -> Vec<f64>;

/// Families of sounds with their kind.
const FAMILIES: [(&str, EventKind, Draw); 11] = [
    ("tone", EventKind::Tone, |rate, rng| {
        let hz = log_uniform(rng, 250.0, 7000.0);
        tones(rate, rng, &[hz], |_| 1.0, |_| 0.0)
    }),
    ("modulated tone", EventKind::Tone, |rate, rng| {
        let hz = log_uniform(rng, 400.0, 7000.0);
        let (slow, depth) = (log_uniform(rng, 4.0, 80.0), rng.random_range(0.3..0.95));
        tones(
            rate,
            rng,
            &[hz],
            |t| 1.0 + depth * (TAU * slow * t).sin(),
            |_| 0.0,
        )
    }),
    (
        "drifting tone with vibrato",
        EventKind::Tone,
        |rate, rng| {
            let hz = log_uniform(rng, 250.0, 7000.0);
            let (drift, slow) = (rng.random_range(-0.02..0.02), log_uniform(rng, 3.0, 10.0));
            let size = rng.random_range(0.0..0.006);
            tones(
                rate,
                rng,
                &[hz],
                |_| 1.0,
                |t| drift * t + size * (TAU * slow * t).sin(),
            )
        },
    ),
    ("two tones", EventKind::Tone, |rate, rng| {
        let hz = log_uniform(rng, 300.0, 3500.0);
        let ratio = rng.random_range(1.08..1.9);
        tones(rate, rng, &[hz, ratio * hz], |_| 1.0, |_| 0.0)
    }),
    (
        "tone with starts and stops",
        EventKind::Tone,
        |rate, rng| {
            let hz = log_uniform(rng, 250.0, 7000.0);
            let (on, off) = (rng.random_range(0.3..0.8), rng.random_range(0.25..0.6));
            let ramp = |t: f64| (t.min(on - t) / 0.02).clamp(0.0, 1.0);
            tones(rate, rng, &[hz], |t| ramp(t % (on + off)), |_| 0.0)
        },
    ),
    (
        "noise, Q 5 to 20",
        EventKind::NarrowBandNoise,
        |rate, rng| resonance_noise(rate, rng, 5.0, 20.0),
    ),
    (
        "noise, Q 20 to 100",
        EventKind::NarrowBandNoise,
        |rate, rng| resonance_noise(rate, rng, 20.0, 100.0),
    ),
    (
        "chatter, regular impacts",
        EventKind::Bursts,
        |rate, rng| {
            let scatter = log_uniform(rng, 1e-4, 3e-3);
            impacts(rate, rng, 1, |rng, gap| {
                (gap * (1.0 + scatter * normal(rng)), 1.0)
            })
        },
    ),
    ("chatter, two resonances", EventKind::Bursts, |rate, rng| {
        impacts(rate, rng, 2, |rng, gap| {
            (
                gap * rng.random_range(0.95..1.05),
                rng.random_range(0.7..1.3),
            )
        })
    }),
    ("creak, irregular pulses", EventKind::Bursts, |rate, rng| {
        impacts(rate, rng, 1, |rng, gap| {
            (gap * log_uniform(rng, 0.5, 2.0), rng.random_range(0.5..1.5))
        })
    }),
    (
        "rattle, three resonances",
        EventKind::Bursts,
        |rate, rng| {
            impacts(rate, rng, 3, |rng, gap| {
                (gap * log_uniform(rng, 0.3, 3.0), log_uniform(rng, 0.2, 2.0))
            })
        },
    ),
];

/// Tones with up to two harmonics; level and relative deviation of frequency as functions of time (s).
fn tones(
    rate: f64,
    rng: &mut ChaCha8Rng,
    frequencies: &[f64],
    level: impl Fn(f64) -> f64,
    bend: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let mut sum = vec![0.0; (LENGTH_S * rate) as usize];
    for hz in frequencies {
        let harmonics: Vec<f64> = (0..rng.random_range(0..3))
            .map(|_| rng.random_range(0.05..0.6))
            .collect();
        let size = rng.random_range(0.4..1.0);
        let mut turn = 0.0;
        for (i, x) in sum.iter_mut().enumerate() {
            let t = i as f64 / rate;
            turn = (turn + hz * (1.0 + bend(t)) / rate).fract();
            let partials = std::iter::once(&1.0).chain(&harmonics).zip(1..);
            let heard = partials.filter(|(_, k)| f64::from(*k) * hz < 0.45 * rate);
            *x += size
                * level(t)
                * heard
                    .map(|(a, k)| a * (TAU * f64::from(k) * turn).sin())
                    .sum::<f64>();
        }
    }
    sum
}

/// Noise of a resonance of 250 Hz to 6 kHz.
fn resonance_noise(rate: f64, rng: &mut ChaCha8Rng, low: f64, high: f64) -> Vec<f64> {
    let (hz, q) = (log_uniform(rng, 250.0, 6000.0), log_uniform(rng, low, high));
    let gain = |f: f64| 1.0 / (1.0 - (f / hz).powi(2)).hypot(f / hz / q);
    shaped_noise((LENGTH_S * rate) as usize, rate, rng, gain)
}

/// Impacts, 5 to 80 per second, on resonances of 300 Hz to 6 kHz that die out within 0.4 of the mean distance; `next` draws the
/// distance and the height from the mean distance (s).
fn impacts(
    rate: f64,
    rng: &mut ChaCha8Rng,
    resonances: usize,
    next: impl Fn(&mut ChaCha8Rng, f64) -> (f64, f64),
) -> Vec<f64> {
    let gap = 1.0 / log_uniform(rng, 5.0, 80.0);
    let modes: Vec<[f64; 2]> = (0..resonances)
        .map(|_| {
            let hz = log_uniform(rng, 300.0, 6000.0);
            let decay = log_uniform(rng, 8.0, 80.0) / (PI * hz);
            [hz, decay.min(0.4 * gap)]
        })
        .collect();
    let mut sum = vec![0.0; (LENGTH_S * rate) as usize];
    let mut start = rng.random_range(0.0..gap);
    while start < LENGTH_S {
        let (distance, height) = next(rng, gap);
        let first = (start * rate).ceil();
        for [hz, decay] in &modes {
            for (i, x) in sum[first as usize..].iter_mut().enumerate() {
                let t = (first + i as f64) / rate - start;
                if t > 10.0 * decay {
                    break;
                }
                *x += height * (-t / decay).exp() * (TAU * hz * t).sin();
            }
        }
        start += distance;
    }
    sum
}

/// A sound between two times in noise whose power falls with frequency, 10 to 40 dB below the sound in all; its rate and ends.
fn recorded(draw: Draw, seed: u64) -> (Vec<f64>, f64, [f64; 2]) {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let rate = [16_000.0, 32_000.0, 48_000.0][rng.random_range(0..3)];
    let mut sound = draw(rate, rng);
    let ends = [rng.random_range(0.5..1.0), rng.random_range(1.8..4.5)];
    for (i, x) in sound.iter_mut().enumerate() {
        let t = i as f64 / rate;
        *x *= ((t - ends[0]).min(ends[1] - t) / 0.02).clamp(0.0, 1.0);
    }
    let fall = rng.random_range(0.0..0.6);
    let mut samples = shaped_noise(sound.len(), rate, rng, |f| f.max(50.0).powf(-fall));
    let gain = 10f64.powf(rng.random_range(10.0..40.0) / 20.0) / rms(&sound);
    add(&mut samples, 0.1 * gain, &sound);
    (samples, rate, ends)
}

/// Number of sounds whose loudest event has each of the classes, and of those with a tone.
fn counts(draw: Draw, seeds: Range<u64>) -> ([usize; CLASSES.len()], usize) {
    let events_of = |seed| {
        let (samples, rate, [start, end]) = recorded(draw, seed);
        let found = tonal_events(&samples, rate, &EventOptions::default());
        let mut events = found.unwrap().events;
        events.retain(|event| event.start_s < end && start < event.end_s);
        events.sort_by(|a, b| b.level_db.total_cmp(&a.level_db));
        events.iter().map(|event| event.kind).collect()
    };
    let all: Vec<Vec<EventKind>> = seeds.into_par_iter().map(events_of).collect();
    let loudest = |class| {
        all.iter()
            .filter(move |kinds| kinds.first().copied() == class)
    };
    let with_tone = all.iter().filter(|kinds| kinds.contains(&EventKind::Tone));
    (
        CLASSES.map(|class| loudest(class).count()),
        with_tone.count(),
    )
}

#[test]
fn sounds_of_which_the_fit_knows_nothing_have_their_kind() {
    for (name, kind, draw) in FAMILIES {
        let ([none, tone, noise, bursts], with_tone) = counts(draw, 0..8);
        let (right, least) = match kind {
            EventKind::Tone => (tone, 8),
            EventKind::NarrowBandNoise => (noise, 6),
            EventKind::Bursts => (bursts, 6 - none.min(3)),
        };
        assert!(right >= least, "{name}: {none} {tone} {noise} {bursts}");
        assert!(
            kind == EventKind::Tone || with_tone <= 2,
            "{name}: {with_tone} with a tone"
        );
    }
}

/// `cargo test --release -p squeakscope-analysis table_of_kinds -- --ignored --nocapture` prints the table of the guide's page on
/// tonal events.
#[test]
#[ignore = "prints a table"]
fn table_of_kinds() {
    for (name, _, draw) in FAMILIES {
        let ([none, tone, noise, bursts], with_tone) = counts(draw, 7000..7040);
        println!("| {name} | {tone} | {noise} | {bursts} | {none} | {with_tone} |");
    }
}
