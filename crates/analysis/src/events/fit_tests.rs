//! Fit of the model of kinds to recordings whose sounds are known.

use rayon::prelude::*;

use super::kind::{CLASSES, MODEL, inputs};
use super::search::candidates;
use super::{EventKind, EventOptions, TonalEvent};
use crate::generator::{Kind, Recording, TUNING_SEEDS, recording};
use crate::logistic::Model;
use crate::logistic::fit::Example;

/// Recordings of squeaks at -10 to 30 dB, of a resonance and of bursts, which have few events each, of damped resonances and
/// of impacts, which have many, and of each other sound.
const SQUEAKS: u64 = 750;
const RESONANCES: u64 = 160;
const DAMPED: u64 = 40;
const OTHERS: u64 = 120;

/// The first seed.
const FIRST: u64 = TUNING_SEEDS.start + 600_000;

/// What a sound is: a tone if it is a squeak with the right ends and frequency, noise or bursts at the frequency of the
/// resonance, otherwise no event. A part of a squeak is undecided.
fn truth(kind: Kind, recording: &Recording, event: &TonalEvent) -> Option<Option<EventKind>> {
    for squeak in &recording.squeaks {
        let [start, end] =
            [event.start_s - squeak.start_s, event.end_s - squeak.end_s].map(f64::abs);
        let off = (event.frequency_hz / squeak.frequency_hz - 1.0).abs();
        if off < 0.005 && start < 0.1 && end < 0.1 {
            return Some(Some(EventKind::Tone));
        }
        let common = event.end_s.min(squeak.end_s) - event.start_s.max(squeak.start_s);
        if off < 0.02 && common > 0.3 * (squeak.end_s - squeak.start_s) {
            return None;
        }
    }
    let (kind, reach) = match kind {
        Kind::Resonance => (EventKind::NarrowBandNoise, 0.12),
        Kind::Bursts => (EventKind::Bursts, 0.3),
        Kind::DampedResonance => (EventKind::NarrowBandNoise, 0.5),
        Kind::Impacts => (EventKind::Bursts, 0.5),
        _ => return Some(None),
    };
    let is_near = |hz: f64| (event.frequency_hz / hz - 1.0).abs() < reach;
    Some(recording.resonance_hz.is_some_and(is_near).then_some(kind))
}

/// The sounds of a recording that are long and loud enough for events, with the names of the inputs.
fn examples(kind: Kind, seed: u64) -> Vec<(Vec<&'static str>, Example)> {
    let recording = recording(kind, -10.0..=30.0, seed);
    let options = EventOptions::default();
    let (candidates, _, recording_db) = candidates(&recording.samples, recording.rate_hz, &options);
    let sounds = candidates
        .iter()
        .enumerate()
        .filter(|(_, (event, _))| options.admits(event, recording_db));
    let example = |(k, (event, _)): (usize, &(TonalEvent, _))| {
        let right = truth(kind, &recording, event)?;
        let (names, inputs) = inputs(k, &candidates).into_iter().unzip();
        let right = CLASSES.map(|class| class == right).to_vec();
        Some((names, Example { inputs, right }))
    };
    sounds.filter_map(example).collect()
}

/// `cargo test --release -p squeakscope-analysis events::fit_tests -- --ignored` fits the model anew and compares; with
/// `SQUEAKSCOPE_MODEL=FILE` it writes it to a file.
#[test]
#[ignore = "the fit takes some minutes"]
fn the_model_is_fitted() {
    let sets = [
        (Kind::Squeaks, SQUEAKS),
        (Kind::Noise, OTHERS),
        (Kind::Speech, OTHERS),
        (Kind::Music, OTHERS),
        (Kind::Resonance, RESONANCES),
        (Kind::Bursts, RESONANCES),
        (Kind::DampedResonance, DAMPED),
        (Kind::Impacts, DAMPED),
    ];
    let seeds = sets.into_iter();
    let seeds =
        seeds.flat_map(|(kind, count)| (FIRST..FIRST + count).map(move |seed| (kind, seed)));
    let seeds: Vec<(Kind, u64)> = seeds.collect();
    let of_recording = |(kind, seed): (Kind, u64)| examples(kind, seed);
    let (names, all): (Vec<_>, Vec<_>) =
        seeds.into_par_iter().flat_map_iter(of_recording).collect();
    Model::fitted(&names[0], &all).write_or_compare(&MODEL);
}
