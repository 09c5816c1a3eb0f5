//! The counts behind the guide's page on tonal events.
//!
//! ```text
//! SQUEAKSCOPE_WRITE=1 cargo test --release --test it squeaks::study::judging -- --ignored --nocapture
//! SQUEAKSCOPE_WRITE=1 cargo test --test it squeaks::guide
//! ```
//!
//! The first writes `results.csv`, the second the page's tables and figure; without `SQUEAKSCOPE_WRITE` nothing is
//! written. `squeaks::study::tuning` prints the same counts for the tuning seeds, and which recordings have misses or
//! false events. `squeaks::study::verdicts` prints the verdicts on squeaks of the guide's page on types of motion.

use std::collections::BTreeMap;
use std::fs;

use rayon::prelude::*;
use squeakscope::import::Signal;
use squeakscope::study::signal::{SignalOptions, analyse_signal};

use super::generator::{JUDGING_SEEDS, Kind, TUNING_SEEDS, recording};
use super::score::{Counts, Score};
use super::{OTHERS, scores};

/// Signal-to-noise ratios, dB.
const LEVELS_DB: [i32; 9] = [-10, -5, 0, 5, 10, 15, 20, 25, 30];

/// Where the counts are.
const RESULTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/squeaks/results.csv");

/// Counts on the seeds from `first`, `number` recordings of a set: by signal-to-noise ratio, by kind, and at 10 to 30 dB
/// by what else is in the recording. Each recording with a miss or a false event is passed to `report`.
fn study(first: u64, number: u64, report: impl Fn(String)) -> Counts {
    let run = |kind, snr_db: i32, from: u64| {
        let level = f64::from(snr_db);
        let scores = scores(kind, level..=level, from..from + number);
        for ((recording, score), seed) in scores.iter().zip(from..) {
            if score.found < score.squeaks || score.false_events > 0 {
                let parts = recording.parts.join(", ");
                report(format!(
                    "{kind:?} {snr_db} dB, seed {seed}: {score:?}; {parts}"
                ));
            }
        }
        scores
    };
    let mut counts = Counts::default();
    let starts = (first..).step_by(number as usize);
    let mut parts = BTreeMap::<&str, Vec<Score>>::new();
    for (snr_db, from) in LEVELS_DB.into_iter().zip(starts) {
        let scores = run(Kind::Squeaks, snr_db, from);
        counts.push(
            format!("{snr_db} dB"),
            scores.iter().map(|(_, score)| *score),
        );
        for (recording, score) in scores.iter().filter(|_| snr_db >= 10) {
            for part in &recording.parts {
                parts.entry(*part).or_default().push(*score);
            }
        }
    }
    for (part, scores) in parts {
        counts.push(format!("with {part}"), scores.into_iter());
    }
    for kind in OTHERS {
        let scores = run(kind, 0, first);
        let name = format!("{kind:?}").to_lowercase();
        counts.push(name, scores.iter().map(|(_, score)| *score));
    }
    counts
}

#[test]
#[ignore = "takes about ten minutes; writes the counts of the guide"]
fn judging() {
    // Seeds that neither the quick tests nor the first judgement use. That found 248 of 265 squeaks at 10 dB or more.
    let counts = study(JUDGING_SEEDS.start + 100_000, 120, |_| ());
    let text = counts.csv("squeakscope");
    println!("{text}");
    if std::env::var_os("SQUEAKSCOPE_WRITE").is_some() {
        fs::write(RESULTS, text).expect("written");
    }
    let sum = |sets: &[&str]| -> Score { sets.iter().map(|set| counts.of(set)).sum() };
    let loud = sum(&["10 dB", "15 dB", "20 dB", "25 dB", "30 dB"]);
    assert!(loud.squeaks > 1000, "{loud:?}");
    assert!(
        loud.recall() >= 0.95 && loud.precision() >= 0.95,
        "{loud:?}"
    );
    let others = sum(&["noise", "speech", "music", "resonance", "bursts"]);
    assert!(others.with_false_share() <= 0.03, "{others:?}");
    let faint = sum(&["0 dB"]);
    assert!(faint.recall() >= 0.8, "{faint:?}");
}

#[test]
#[ignore = "takes some minutes; for the development of the search"]
fn tuning() {
    let counts = study(TUNING_SEEDS.start, 30, |line| println!("{line}"));
    println!("{}", counts.csv("squeakscope"));
}

/// Verdict on the strongest event of a recording with squeaks, or why there is none; `None` if that is no squeak, or
/// another one sounds with it: two tones are quasi-periodic.
fn verdict_on_strongest(snr_db: f64, seed: u64) -> Option<String> {
    let recording = recording(Kind::Squeaks, snr_db..=snr_db, seed);
    let signal = Signal {
        name: String::new(),
        unit: String::new(),
        rate: recording.rate_hz,
        start: 0.0,
        samples: recording.samples,
    };
    let found = analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(()));
    let found = found.expect("analysed");
    let event = &found.sound.as_ref()?.tonal.events[found.stretch.event? - 1];
    let stretch = &found.stretch;
    let sounding = recording.squeaks.iter();
    let sounding = sounding.filter(|it| it.start_s < stretch.end_s && stretch.start_s < it.end_s);
    let [squeak] = sounding.collect::<Vec<_>>()[..] else {
        return None;
    };
    if (event.frequency_hz / squeak.frequency_hz - 1.0).abs() > 0.02 {
        return None;
    }
    Some(match found.verdict.get() {
        Ok(verdict) => verdict.regime.to_string(),
        Err(reason) => reason.to_string(),
    })
}

#[test]
#[ignore = "takes some minutes; prints the guide's table of verdicts on squeaks in recordings"]
fn verdicts() {
    let mut all = BTreeMap::new();
    for snr_db in [10, 15, 20, 30] {
        let first = JUDGING_SEEDS.start + 400_000 + 1000 * snr_db;
        let seeds = (first..first + 24).into_par_iter();
        let found = seeds.filter_map(|seed| verdict_on_strongest(snr_db as f64, seed));
        let mut counts = BTreeMap::new();
        for verdict in found.collect::<Vec<_>>() {
            *counts.entry(verdict.clone()).or_insert(0) += 1;
            *all.entry(verdict).or_insert(0) += 1;
        }
        println!("{snr_db} dB: {counts:?}");
    }
    let [periodic, transient] = ["periodic", "transient"].map(|regime| all.get(regime).copied());
    let (periodic, transient) = (periodic.unwrap_or(0), transient.unwrap_or(0));
    let number: usize = all.values().sum();
    assert!(
        10 * periodic >= 7 * number && 10 * transient <= number,
        "{all:?}"
    );
}
