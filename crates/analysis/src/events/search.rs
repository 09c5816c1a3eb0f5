//! Search for tonal events.

use rayon::prelude::*;

use super::baseband::Baseband;
use super::group::{Group, SAME, groups};
use super::hum::Lines;
use super::kind::{inputs, likeliest};
use super::modulation::{modulation, vibrato};
use super::partial::Partial;
use super::paths::{paths, threshold};
use super::ridge::{Ridge, select};
use super::spectrogram::{Peaks, peaks};
use super::{EventKind, RidgePoint, TonalEvent, TonalEvents};
use crate::condition::quantum;
use crate::stats::{mean, range};
use crate::{AnalysisError, MAX_SAMPLE};

/// Options of the search for tonal events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventOptions {
    /// Lowest frequency of a fundamental, Hz.
    pub low_hz: f64,
    /// Highest frequency of a fundamental, Hz.
    pub high_hz: f64,
    /// Level reference: amplitude of a sine of 0 dB, such as full scale, in the unit of the samples.
    pub full_scale: f64,
    /// Shortest event, s.
    pub shortest_s: f64,
    /// Expected number of paths that noise produces in the spectrograms of a recording, above 0. Their shape shows that
    /// they are no events; more of them take time, fewer cost faint events.
    pub false_paths: f64,
    /// Whether to list events more than 40 dB below the recording, too.
    pub faint: bool,
}

impl Default for EventOptions {
    /// Fundamentals from 200 Hz to 12 kHz, full scale 1, events of at least 0.2 s, one path through noise, none faint.
    fn default() -> Self {
        Self {
            low_hz: 200.0,
            high_hz: 12_000.0,
            full_scale: 1.0,
            shortest_s: 0.2,
            false_paths: 1.0,
            faint: false,
        }
    }
}

impl EventOptions {
    /// Level of a power, dB.
    pub(super) fn level_db(&self, power: f64) -> f64 {
        10.0 * (power / (0.5 * self.full_scale.powi(2))).log10()
    }

    /// Whether an event is long and loud enough in a recording of a level, dB.
    pub(super) fn admits(&self, event: &TonalEvent, recording_db: f64) -> bool {
        let is_loud = self.faint || event.level_db >= recording_db - FAINT_DB;
        is_loud && event.span().length_s() >= self.shortest_s
    }
}

/// Durations of the windows, s, and the lowest frequency that each searches, Hz: a faster change of frequency
/// needs a shorter window, and changes in hertz are larger at higher frequencies.
const WINDOWS: [(f64, f64); 5] = [
    (0.186, 100.0),
    (0.093, 180.0),
    (0.046, 450.0),
    (0.023, 1200.0),
    (0.012, 3500.0),
];

/// Largest ratio of a floor to the noise of quantisation that is nothing else, and least fall of the floor over an octave
/// that makes the edge of a low-pass.
const ROUNDING_RATIO: f64 = 4.0;
const EDGE_RATIO: f64 = 30.0;

/// Level of an event below that of the recording above 180 Hz at which it is faint, dB.
const FAINT_DB: f64 = 40.0;

/// Highest frequency of a partial, Hz.
const HIGHEST_HZ: f64 = 24_000.0;

/// Finds the tonal events of a recording of `samples` at `rate_hz`.
///
/// # Errors
/// [`AnalysisError::TooShort`] for less than 0.2 s, [`AnalysisError::SampleRange`] for samples that are
/// not finite or too large.
pub fn tonal_events(
    samples: &[f64],
    rate_hz: f64,
    options: &EventOptions,
) -> Result<TonalEvents, AnalysisError> {
    let need = (0.2 * rate_hz) as usize;
    if samples.len() < need {
        return Err(AnalysisError::TooShort {
            what: "tonal events",
            have: samples.len(),
            need,
        });
    }
    // A comparison that is false for values that are no numbers, too.
    if !samples.iter().all(|x| x.abs() <= MAX_SAMPLE) {
        return Err(AnalysisError::SampleRange);
    }
    let offset = mean(samples);
    let samples: Vec<f64> = samples.iter().map(|x| x - offset).collect();
    let (candidates, hum, power) = candidates(&samples, rate_hz, options);
    let recording_db = options.level_db(power);
    let sounds = candidates.iter().enumerate();
    let known = sounds.filter(|(_, (event, _))| options.admits(event, recording_db));
    let events = known.filter_map(|(k, (event, _))| {
        let (kind, probability) = likeliest(&inputs(k, &candidates));
        Some(TonalEvent {
            kind: kind?,
            probability,
            ..event.clone()
        })
    });
    Ok(TonalEvents {
        events: events.collect(),
        hum: hum.map(|hum| hum.hum(options.full_scale)),
    })
}

/// All tones of a recording without mean, in the order of their starts, its hum and its power. They have no kind yet.
pub(super) fn candidates(
    samples: &[f64],
    rate_hz: f64,
    options: &EventOptions,
) -> (Vec<(TonalEvent, Group)>, Option<Lines>, f64) {
    let (mut ridges, reference) = ridges(samples, rate_hz, options);
    let rounding = quantum(samples).powi(2) / (6.0 * rate_hz);
    ridges.retain(|ridge| !is_above_edge(ridge, &reference, rounding));
    let hum = Lines::find(samples, rate_hz);
    if let Some(hum) = &hum {
        ridges.retain(|ridge| !hum.has(ridge));
    }
    let partials = |ridge: &Ridge| {
        let noise = ridge.points.iter().map(|p| p.noise).sum::<f64>() / ridge.points.len() as f64;
        Baseband::new(samples, rate_hz, ridge).partials(noise)
    };
    let found: Vec<Partial> = ridges.par_iter().flat_map_iter(partials).collect();
    let groups = groups(found);
    let in_range =
        |g: &Group| (options.low_hz..=options.high_hz).contains(&g.fundamental().frequency_hz);
    let groups = groups.into_iter().filter(in_range);
    let candidates = groups.map(|group| (event(&group, options), group));
    (distinct(candidates.collect()), hum, reference.power)
}

/// Whether a ridge is above the edge of a low-pass: its floor is `rounding`, the noise power per hertz of quantisation,
/// and an octave below there is much more noise.
fn is_above_edge(ridge: &Ridge, reference: &Peaks, rounding: f64) -> bool {
    let middle = ridge.points[ridge.points.len() / 2];
    let below = reference.noise(middle.time_s, 0.5 * middle.frequency_hz);
    middle.noise < ROUNDING_RATIO * rounding && below > EDGE_RATIO * middle.noise
}

/// Leaves the event of the greatest energy of those that sound together within 3 % of one frequency, in the order
/// of starts.
fn distinct(mut candidates: Vec<(TonalEvent, Group)>) -> Vec<(TonalEvent, Group)> {
    let energy = |event: &TonalEvent| event.snr_db + 10.0 * event.span().length_s().log10();
    candidates.sort_by(|a, b| energy(&b.0).total_cmp(&energy(&a.0)));
    let mut kept: Vec<(TonalEvent, Group)> = Vec::new();
    for candidate in candidates {
        let event = &candidate.0;
        let is_same = |(other, _): &(TonalEvent, Group)| {
            let together = event.end_s.min(other.end_s) - event.start_s.max(other.start_s);
            together > 0.0 && (event.frequency_hz / other.frequency_hz - 1.0).abs() < SAME
        };
        if !kept.iter().any(is_same) {
            kept.push(candidate);
        }
    }
    kept.sort_by(|a, b| a.0.start_s.total_cmp(&b.0.start_s));
    kept
}

/// The ridges of all resolutions, one for each partial, and the peaks of the window of the noise floor.
fn ridges(samples: &[f64], rate_hz: f64, options: &EventOptions) -> (Vec<Ridge>, Peaks) {
    let share = options.false_paths / WINDOWS.len() as f64;
    // One after the other: the powers take as much memory as the samples.
    let mut all: Vec<Peaks> = WINDOWS
        .iter()
        .map(|(duration, low)| peaks(samples, rate_hz, *duration, [*low, HIGHEST_HZ]))
        .collect();
    let ridges = |peaks: &Peaks| {
        let least = threshold(peaks.columns.len() * peaks.bins, share);
        let paths = paths(peaks, least);
        paths
            .iter()
            .map(|path| Ridge::new(path, peaks))
            .collect::<Vec<_>>()
    };
    let found: Vec<Ridge> = all.par_iter().flat_map_iter(ridges).collect();
    (select(found), all.swap_remove(1))
}

/// Width of the third octave around a frequency, Hz.
fn third_octave(frequency_hz: f64) -> f64 {
    frequency_hz * (2f64.powf(1.0 / 6.0) - 2f64.powf(-1.0 / 6.0))
}

/// The event of a group: ends and frequency from the partial that stands out most.
fn event(group: &Group, options: &EventOptions) -> TonalEvent {
    let partial = group.fundamental();
    let (multiple, leader) = group.leader();
    let frequency_hz = leader.frequency_hz / *multiple as f64;
    // Where the tone is strong: the frequency of what is left at the ends is noise.
    let strong = leader
        .track
        .iter()
        .enumerate()
        .filter(|(_, p)| p.1 > 0.1 * leader.power);
    let frequencies = strong.map(|(i, _)| leader.frequency_at(leader.time(i)) / *multiple as f64);
    let [frequency_low_hz, frequency_high_hz] = range(frequencies.chain([frequency_hz]));
    let third = third_octave(frequency_hz);
    let full = 0.5 * options.full_scale.powi(2);
    let db = |ratio: f64| 10.0 * ratio.max(1e-20).log10();
    let power: f64 = group.partials.iter().map(|(_, p)| p.power).sum();
    TonalEvent {
        kind: EventKind::Tone,
        probability: 0.0,
        start_s: leader.start_s,
        end_s: leader.end_s,
        frequency_hz,
        frequency_low_hz,
        frequency_high_hz,
        harmonics: group.partials.len(),
        level_db: db(power / full),
        snr_db: db(partial.power / (partial.noise * third)),
        modulation: modulation(leader),
        vibrato: vibrato(leader, *multiple),
        ridge: leader
            .track
            .iter()
            .enumerate()
            .map(|(i, p)| RidgePoint {
                time_s: leader.time(i),
                frequency_hz: p.0 / *multiple as f64,
                level_db: db(p.1 / full),
            })
            .collect(),
    }
}
