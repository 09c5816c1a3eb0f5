//! Squeaks in recordings: what [`tonal_events`](squeakscope::analysis::events::tonal_events) finds in recordings whose squeaks
//! are known, on seeds that nothing was adjusted to.

mod generator;
#[cfg(feature = "figure")]
mod guide;
mod score;
mod study;

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use rayon::prelude::*;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use squeakscope::analysis::events::{EventKind, EventOptions, TonalEvent, tonal_events};

use generator::{JUDGING_SEEDS, Kind, Recording, TUNING_SEEDS, recording};
use score::{Found, Score};

/// Recordings without squeaks.
const OTHERS: [Kind; 5] = [
    Kind::Noise,
    Kind::Speech,
    Kind::Music,
    Kind::Resonance,
    Kind::Bursts,
];

fn events(recording: &Recording) -> Vec<TonalEvent> {
    let options = EventOptions::default();
    let found = tonal_events(&recording.samples, recording.rate_hz, &options);
    found.expect("events").events
}

/// The score of the tones among the events of a recording.
fn score(recording: &Recording, events: &[TonalEvent]) -> Score {
    let tones = events.iter().filter(|event| event.kind == EventKind::Tone);
    let tones = tones.map(|event| Found {
        start_s: event.start_s,
        end_s: event.end_s,
        frequency_hz: event.frequency_hz,
    });
    Score::of(&recording.squeaks, &tones.collect::<Vec<_>>())
}

/// Recordings of a kind and range of signal-to-noise ratios, with the score of each.
fn scores(
    kind: Kind,
    snr_db: RangeInclusive<f64>,
    seeds: std::ops::Range<u64>,
) -> Vec<(Recording, Score)> {
    let one = |seed| {
        let mut recording = recording(kind, snr_db.clone(), seed);
        let score = score(&recording, &events(&recording));
        recording.samples.clear();
        (recording, score)
    };
    seeds.into_par_iter().map(one).collect()
}

/// The sum of the scores of the first `count` seeds for judging.
fn judged(kind: Kind, snr_db: RangeInclusive<f64>, count: u64) -> Score {
    let seeds = JUDGING_SEEDS.start..JUDGING_SEEDS.start + count;
    scores(kind, snr_db, seeds)
        .iter()
        .map(|(_, score)| *score)
        .sum()
}

/// The aim is 95 % of each; the guide's page on tonal events has the result over 600 recordings.
#[test]
fn squeaks_at_10_db_or_more_are_found_with_few_false_events() {
    let score = judged(Kind::Squeaks, 10.0..=30.0, 24);
    assert!(score.squeaks >= 30, "{score:?}");
    assert!(score.recall() >= 0.92, "{score:?}");
    assert!(score.precision() >= 0.92, "{score:?}");
}

/// The aim is 80 %.
#[test]
fn most_squeaks_at_0_db_are_found() {
    let score = judged(Kind::Squeaks, 0.0..=0.0, 16);
    assert!(score.squeaks >= 20, "{score:?}");
    assert!(score.recall() >= 0.6, "{score:?}");
}

type Judged = (Recording, Vec<TonalEvent>);

/// Recordings for judging of noise and of bursts of a resonance, with their events.
static OF_RESONANCES: LazyLock<[Vec<Judged>; 4]> = LazyLock::new(|| {
    use Kind::{Bursts, DampedResonance, Impacts, Resonance};
    [Resonance, DampedResonance, Bursts, Impacts].map(|kind| {
        let one = |seed| {
            let mut recording = recording(kind, 0.0..=0.0, seed);
            let events = events(&recording);
            recording.samples.clear();
            (recording, events)
        };
        let seeds = JUDGING_SEEDS.start..JUDGING_SEEDS.start + 24;
        seeds.into_par_iter().map(one).collect()
    })
});

/// The aim is a tone in 3 % of these recordings.
#[test]
fn hardly_a_recording_without_squeaks_has_a_tone() {
    let others = [Kind::Noise, Kind::Speech, Kind::Music];
    let others = others.map(|kind| judged(kind, 0.0..=0.0, 8));
    let of_resonances = OF_RESONANCES.iter().step_by(2);
    let of_resonances = of_resonances.flat_map(|found| &found[..8]);
    let of_resonances = of_resonances.map(|(recording, events)| score(recording, events));
    let score: Score = others.into_iter().chain(of_resonances).sum();
    assert!(score.with_false <= 2, "{score:?}");
}

#[test]
fn noise_and_bursts_of_a_resonance_have_their_kind() {
    let noise = [EventKind::NarrowBandNoise; 2];
    let kinds = noise.into_iter().chain([EventKind::Bursts; 2]);
    for (found, right) in OF_RESONANCES.iter().zip(kinds) {
        let of_resonance = found.iter().flat_map(|(recording, events)| {
            let hz = recording.resonance_hz.expect("a resonance");
            let is_near = move |event: &&TonalEvent| (event.frequency_hz / hz - 1.0).abs() < 0.12;
            events.iter().filter(is_near)
        });
        let all: Vec<_> = of_resonance.collect();
        let count = all.iter().filter(|event| event.kind == right).count();
        assert!(
            all.len() > 15 && count as f64 > 0.8 * all.len() as f64,
            "{right:?}: {count} of {}",
            all.len()
        );
    }
}

#[test]
fn recordings_are_the_same_for_a_seed_and_differ_between_seeds() {
    let make = |seed| recording(Kind::Squeaks, 0.0..=30.0, seed).samples;
    let start = TUNING_SEEDS.start;
    assert!(make(start) == make(start));
    assert!(make(start) != make(start + 1));
    const { assert!(TUNING_SEEDS.end <= JUDGING_SEEDS.start) };
}

/// Mean power of the samples between two times in a third octave.
fn band_power(recording: &Recording, span_s: [f64; 2], centre_hz: f64) -> f64 {
    let [first, last] = span_s.map(|t| (t * recording.rate_hz) as usize);
    let n = last - first;
    let turn = std::f64::consts::TAU / n as f64;
    let hann = |i: usize| 0.5 - 0.5 * (turn * i as f64).cos();
    let part = recording.samples[first..last].iter().enumerate();
    let mut spectrum: Vec<Complex64> = part.map(|(i, x)| (x * hann(i)).into()).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut spectrum);
    let bin =
        |side: f64| (centre_hz * 2f64.powf(side / 6.0) * n as f64 / recording.rate_hz) as usize;
    let band = &spectrum[bin(-1.0) + 1..=bin(1.0)];
    // The mean square of the window is 3/8.
    band.iter().map(|x| x.norm_sqr()).sum::<f64>() * 2.0 / (0.375 * (n * n) as f64)
}

#[track_caller]
fn assert_range(recording: &Recording, shortest_s: f64) {
    let length_s = recording.samples.len() as f64 / recording.rate_hz;
    assert!((5.0..=10.0).contains(&length_s));
    assert!((16e3..=96e3).contains(&recording.rate_hz));
    assert!((1..=3).contains(&recording.squeaks.len()));
    assert!(recording.samples.iter().all(|x| x.abs() <= 1.0));
    for squeak in &recording.squeaks {
        assert!(
            0.0 < squeak.start_s && squeak.end_s < length_s,
            "{squeak:?}"
        );
        assert!(squeak.end_s - squeak.start_s > shortest_s, "{squeak:?}");
        let highest = 12e3f64.min(0.45 * recording.rate_hz);
        assert!(
            (200.0..highest).contains(&squeak.frequency_hz),
            "{squeak:?}"
        );
        assert!((1..=6).contains(&squeak.harmonics), "{squeak:?}");
        if let Some((rate_hz, depth)) = squeak.modulation {
            assert!((4.0..=40.0).contains(&rate_hz) && (0.1..=0.8).contains(&depth));
        }
    }
}

#[test]
fn recordings_have_the_stated_range() {
    for seed in TUNING_SEEDS.take(6) {
        for kind in [Kind::Squeaks, Kind::Change] {
            assert_range(&recording(kind, -10.0..=30.0, seed), 0.25);
        }
    }
    for seed in TUNING_SEEDS.take(3) {
        for kind in [Kind::Torus, Kind::Doubled, Kind::Chaos] {
            let recording = recording(kind, 10.0..=30.0, seed);
            if kind != Kind::Chaos {
                // At the minimum of a beat the level is too low to belong to the squeak.
                assert_range(&recording, 0.2);
            }
            for squeak in &recording.squeaks {
                let has_second = squeak.second.is_some_and(|[frequency_hz, size]| {
                    frequency_hz < 0.5 * recording.rate_hz && (0.05..=1.0).contains(&size)
                });
                assert_eq!(has_second, kind != Kind::Chaos, "{squeak:?}");
            }
        }
    }
}

#[test]
fn recordings_have_the_stated_range_and_signal_to_noise_ratio() {
    let mut checked = 0;
    for seed in TUNING_SEEDS.take(24) {
        let recording = recording(Kind::Squeaks, 6.0..=12.0, seed);
        assert_range(&recording, 0.25);
        // One squeak, after enough noise that stays the same.
        let steady = |part: &&str| ["pink noise", "rumble", "hum"].contains(part);
        let [squeak] = &recording.squeaks[..] else {
            continue;
        };
        if squeak.start_s < 1.2 || !recording.parts.iter().all(steady) {
            continue;
        }
        let power = |from, to| band_power(&recording, [from, to], squeak.frequency_hz);
        let noise = power(0.0, squeak.start_s - 0.3);
        let both = power(squeak.start_s, squeak.end_s);
        let snr_db = 10.0 * (both / noise - 1.0).log10();
        let error_db = snr_db - squeak.snr_db;
        assert!(error_db.abs() < 3.0, "{seed}: {snr_db} {squeak:?}");
        checked += 1;
    }
    assert!(checked >= 3, "{checked}");
}
