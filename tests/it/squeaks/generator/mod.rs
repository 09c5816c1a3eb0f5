//! Recordings of squeaks as an ordinary microphone makes them, with the truth about each squeak.
//!
//! Nothing here knows the detector. A recording has 5 to 10 s at 16 to 96 kHz: noise, in part of the recordings
//! road noise, rumble, hum, knocks, speech, music, a reverberating room, the low-pass of a lossy format and
//! clipping, rounded to 16 bits.
//!
//! # Truth
//!
//! * A squeak *sounds* from the first to the last time at which the power of its fundamental at the microphone is at
//!   least a tenth (-10 dB) of the mean power of its loudest 100 ms. The reverberation is part of the sound at
//!   the microphone, so a reverberating room makes it end later; the tail below -10 dB does not count.
//! * Its *frequency* is the mean over this time of the instantaneous frequency of the fundamental at the
//!   microphone, weighted by power.
//! * Its *signal-to-noise ratio* is the mean power of the fundamental over this time, divided by the mean power over
//!   the same time of all that is no squeak (knocks excepted: they are short, and their mean power says
//!   nothing about the rest of the time) in the third octave around its frequency, `f 2^(-1/6)` to `f 2^(1/6)`.
//!   Other squeaks do not count as noise.
//!
//! A squeak whose power stays below a tenth for more than 0.1 s between its ends would be two, and is drawn again.
//! Two squeaks that sound together (or less than 0.4 s apart) never have fundamentals within 6 % of each other or
//! of a multiple up to 6: nobody could say whether that is one squeak or two.

mod background;
mod decoys;
pub mod spectrum;
mod squeak;

use std::ops::{Range, RangeInclusive};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustfft::num_complex::Complex64;

use background::amplitude;
use spectrum::{Room, add, filtered, log_uniform, rms};
use squeak::{Plan, Sound};

/// Seeds for the development of methods.
pub const TUNING_SEEDS: Range<u64> = 0..1_000_000;

/// Seeds that nothing may be adjusted to.
pub const JUDGING_SEEDS: Range<u64> = 1_000_000..2_000_000;

/// Sampling rates, Hz.
pub const RATES_HZ: [f64; 8] = [
    16_000.0, 22_050.0, 24_000.0, 32_000.0, 44_100.0, 48_000.0, 88_200.0, 96_000.0,
];

/// Longest time within a squeak in which its power stays below a tenth of that of its loudest 100 ms, s.
const LONGEST_PAUSE_S: f64 = 0.1;

/// What a recording is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// One to three squeaks, in part of the recordings with speech or music.
    Squeaks,
    /// No squeak: noise, rumble, hum, knocks.
    Noise,
    /// No squeak: speech-like sound over noise.
    Speech,
    /// No squeak: musical sound over noise.
    Music,
    /// No squeak: noise of a narrow resonance over noise.
    Resonance,
    /// No squeak: creak, chatter or rattle over noise.
    Bursts,
    /// One to three squeaks whose type of motion changes: a second tone sets in.
    Change,
    /// One to three squeaks with an incommensurate second tone: a torus.
    Torus,
    /// One to three squeaks with lines between the harmonics: a doubled period.
    Doubled,
    /// One to three squeaks with chaotic motion.
    Chaos,
    /// No squeak: noise of a damped resonance over noise.
    DampedResonance,
    /// No squeak: impacts, regular or not, that excite a resonance, over noise.
    Impacts,
}

/// The truth about a squeak; the module says how each quantity is defined.
#[derive(Clone, Debug)]
pub struct Squeak {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Mean frequency of the fundamental, Hz.
    pub frequency_hz: f64,
    /// Signal-to-noise ratio in the squeak's own third octave, dB.
    pub snr_db: f64,
    /// Number of partials below 0.48 of the sampling rate, the fundamental included.
    pub harmonics: usize,
    /// Rate of the amplitude modulation, Hz, and its depth (0 to 1).
    pub modulation: Option<(f64, f64)>,
    /// Frequency of the strongest line of a second tone, Hz, and its amplitude over that of the fundamental.
    pub second: Option<[f64; 2]>,
}

impl Kind {
    /// Whether its recordings have squeaks.
    fn has_squeaks(self) -> bool {
        use Kind::{Change, Chaos, Doubled, Squeaks, Torus};
        matches!(self, Squeaks | Change | Torus | Doubled | Chaos)
    }
}

/// A recording and what is in it.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Samples; full scale is 1.
    pub samples: Vec<f64>,
    /// The squeaks by start; none in recordings of other sounds.
    pub squeaks: Vec<Squeak>,
    /// What else is in it, in words.
    pub parts: Vec<&'static str>,
    /// Frequency of the resonance that noise or bursts excite, Hz.
    pub resonance_hz: Option<f64>,
}

/// The recording of a kind and seed; each squeak's signal-to-noise ratio in dB is uniform in `snr_db`.
pub fn recording(kind: Kind, snr_db: RangeInclusive<f64>, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(kind as u64);
    let rng = &mut rng;
    let rate_hz = RATES_HZ[rng.random_range(0..RATES_HZ.len())];
    // A whole number of tenths of a second, for which the Fourier transforms are fast.
    let n = rng.random_range(50..=100) * (rate_hz / 10.0) as usize;
    let (mut sum, mut parts) = background::steady(n, rate_hz, rng);
    let room = rng.random_bool(0.4).then(|| Room::draw(n, rate_hz, rng));
    parts.extend(room.iter().map(|_| "reverberation"));
    let decoy = add_decoy(kind, &mut sum, rate_hz, room.as_ref(), rng);
    parts.extend(decoy.map(|decoy| decoy.0));

    let plans = plans(kind, n, rate_hz, &snr_db, room.as_ref(), rng);
    let mut samples = sum.clone();
    let mut squeaks = Vec::new();
    for (plan, sound) in &plans {
        squeaks.push(add_squeak(&mut samples, &sum, plan, sound, rate_hz));
    }
    squeaks.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));

    if rng.random_bool(0.4) {
        let knocks = background::knocks(n, rate_hz, rng);
        add(&mut samples, 1.0, &in_room(&knocks, room.as_ref()));
        parts.push("knocks");
    }
    let highest = plans
        .iter()
        .fold(0.0f64, |f, (plan, _)| f.max(plan.base_hz));
    parts.extend(encode(&mut samples, rate_hz, highest, rng));
    Recording {
        rate_hz,
        samples,
        squeaks,
        parts,
        resonance_hz: decoy.and_then(|decoy| decoy.1),
    }
}

/// A sound at the microphone.
fn in_room(source: &[f64], room: Option<&Room>) -> Vec<f64> {
    let Some(room) = room else {
        return source.to_vec();
    };
    let source: Vec<Complex64> = source.iter().map(|&x| x.into()).collect();
    let sound = room.at_microphone(&source);
    sound.iter().map(|z| z.re).collect()
}

/// Adds another sound: always in a recording of it; speech and music in one of ten recordings each of squeaks. Returns its name
/// and the frequency of a resonance, Hz.
fn add_decoy(
    kind: Kind,
    sum: &mut [f64],
    rate_hz: f64,
    room: Option<&Room>,
    rng: &mut ChaCha8Rng,
) -> Option<(&'static str, Option<f64>)> {
    let n = sum.len();
    let choice = rng.random_range(0..10);
    let unpitched = |sound| (sound, None);
    let pitched = |(sound, frequency)| (sound, Some(frequency));
    let (name, (sound, resonance_hz), level_db) = match (kind, choice) {
        (Kind::Speech, _) => (
            "speech",
            unpitched(decoys::speech(n, rate_hz, rng)),
            0.0..30.0,
        ),
        (Kind::Music, _) => (
            "music",
            unpitched(decoys::music(n, rate_hz, rng)),
            0.0..30.0,
        ),
        (Kind::Resonance, _) => (
            "resonance",
            pitched(decoys::resonance(n, rate_hz, rng)),
            -20.0..15.0,
        ),
        (Kind::Bursts, _) => (
            "bursts",
            pitched(decoys::bursts(n, rate_hz, rng)),
            -15.0..20.0,
        ),
        (Kind::DampedResonance, _) => (
            "damped resonance",
            pitched(decoys::damped_resonance(n, rate_hz, rng)),
            -10.0..25.0,
        ),
        (Kind::Impacts, _) => (
            "impacts",
            pitched(decoys::impacts(n, rate_hz, rng)),
            -10.0..25.0,
        ),
        (Kind::Squeaks, 0) => (
            "speech",
            unpitched(decoys::speech(n, rate_hz, rng)),
            -10.0..10.0,
        ),
        (Kind::Squeaks, 1) => (
            "music",
            unpitched(decoys::music(n, rate_hz, rng)),
            -10.0..10.0,
        ),
        _ => return None,
    };
    let gain = amplitude(rng.random_range(level_db));
    add(sum, gain, &in_room(&sound, room));
    Some((name, resonance_hz))
}

/// One to three squeaks of `n` samples that can be distinguished, with their sounds; none in a recording without squeaks.
fn plans(
    kind: Kind,
    n: usize,
    rate_hz: f64,
    snr_db: &RangeInclusive<f64>,
    room: Option<&Room>,
    rng: &mut ChaCha8Rng,
) -> Vec<(Plan, Sound)> {
    let length_s = n as f64 / rate_hz;
    let mut plans: Vec<(Plan, Sound)> = Vec::new();
    if kind.has_squeaks() {
        let count = [1, 1, 1, 2, 2, 3][rng.random_range(0..6)];
        while plans.len() < count {
            let mut plan = Plan::draw(rate_hz, length_s, snr_db, rng);
            plan.change_motion(kind, rate_hz, rng);
            if plans.iter().any(|(other, _)| plan.is_like(other)) {
                continue;
            }
            let sound = plan.sound(n, rate_hz, room);
            if sound.pause as f64 <= LONGEST_PAUSE_S * rate_hz {
                plans.push((plan, sound));
            }
        }
    }
    plans
}

/// Adds a squeak at its signal-to-noise ratio over the background, and returns the truth.
fn add_squeak(
    samples: &mut [f64],
    background: &[f64],
    plan: &Plan,
    sound: &Sound,
    rate_hz: f64,
) -> Squeak {
    let [first, last] = sound.ends;
    let frequency_hz = sound.frequency_hz(rate_hz);
    let edge = 2f64.powf(1.0 / 6.0);
    let band = filtered(background, rate_hz, |f| {
        f64::from(f >= frequency_hz / edge && f <= frequency_hz * edge)
    });
    let noise = rms(&band[first..=last]);
    let gain = amplitude(plan.snr_db) * noise / sound.power().sqrt();
    for (sample, x) in samples.iter_mut().zip(sound.samples()) {
        *sample += gain * x;
    }
    let heard = 0.48 * rate_hz / plan.base_hz;
    let (rate, depth) = plan.modulation;
    Squeak {
        start_s: first as f64 / rate_hz,
        end_s: last as f64 / rate_hz,
        frequency_hz,
        snr_db: plan.snr_db,
        harmonics: plan.partials.len().min(heard as usize),
        modulation: (depth > 0.0).then_some((rate, depth)),
        second: plan.second.as_ref().map(|second| {
            let [ratio, size] = second.strongest();
            [ratio * frequency_hz, size]
        }),
    }
}

/// The way into the file: in one of five recordings the low-pass of a lossy format, above `highest_hz`; the
/// level; in one of eight clipping; 16 bits.
fn encode(
    samples: &mut Vec<f64>,
    rate_hz: f64,
    highest_hz: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<&'static str> {
    let mut parts = Vec::new();
    let cutoff = log_uniform(rng, 0.25, 0.45) * rate_hz;
    if rng.random_bool(0.2) && cutoff > 1.2 * highest_hz {
        let width = 0.02 * cutoff;
        *samples = filtered(samples, rate_hz, |f| ((cutoff - f) / width).clamp(0.0, 1.0));
        parts.push("low-pass");
    }
    let peak = samples.iter().fold(0.0f64, |peak, x| peak.max(x.abs()));
    let clips = rng.random_bool(0.125);
    let level_db = match clips {
        true => rng.random_range(1.0..6.0),
        false => rng.random_range(-20.0..-0.5),
    };
    parts.extend(clips.then_some("clipping"));
    let (gain, steps) = (amplitude(level_db) / peak, 32_768.0);
    for x in samples {
        let level = (*x * gain * steps).round();
        *x = level.clamp(-steps, steps - 1.0) / steps;
    }
    parts
}
