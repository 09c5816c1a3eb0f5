//! Search for tonal events.

use rayon::prelude::*;

use super::baseband::Baseband;
use super::decoys::sustained;
use super::group::{Group, groups};
use super::hum::Lines;
use super::modulation::{modulation, vibrato};
use super::partial::Partial;
use super::paths::{paths, threshold};
use super::ridge::{Ridge, select};
use super::spectrogram::{Peaks, peaks};
use super::wow::wow;
use super::{RidgePoint, TonalEvent, TonalEvents};
use crate::analysis::{AnalysisError, MAX_SAMPLE};

/// Options of the search for tonal events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventOptions {
    /// Lowest frequency of a fundamental, Hz.
    pub low_hz: f64,
    /// Highest frequency of a fundamental, Hz.
    pub high_hz: f64,
    /// Amplitude of full scale, in the unit of the samples.
    pub full_scale: f64,
    /// Shortest event, s.
    pub shortest_s: f64,
    /// Probability of a false event in a recording of noise.
    pub false_alarm: f64,
}

impl Default for EventOptions {
    /// Fundamentals from 200 Hz to 12 kHz, full scale 1, events of at least 0.2 s, 1 % false alarms.
    fn default() -> Self {
        Self {
            low_hz: 200.0,
            high_hz: 12_000.0,
            full_scale: 1.0,
            shortest_s: 0.2,
            false_alarm: 0.01,
        }
    }
}

/// Durations of the windows, s, and the lowest frequency that each searches, Hz: a faster change of frequency
/// needs a shorter window, and changes in hertz are larger at higher frequencies.
const WINDOWS: [(f64, f64); 5] = [
    (0.186, 100.0),
    (0.093, 100.0),
    (0.046, 300.0),
    (0.023, 600.0),
    (0.012, 2000.0),
];

/// Least signal-to-noise ratio in the own third octave of an event, dB.
const LEAST_SNR_DB: f64 = -6.0;

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
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let samples: Vec<f64> = samples.iter().map(|x| x - mean).collect();
    let (mut ridges, reference) = ridges(&samples, rate_hz, options);
    let hum = Lines::find(&samples, rate_hz);
    if let Some(hum) = &hum {
        ridges.retain(|ridge| !hum.has(ridge));
    }
    let partial = |ridge: &Ridge| {
        let noise = ridge.points.iter().map(|p| p.noise).sum::<f64>() / ridge.points.len() as f64;
        Baseband::new(&samples, rate_hz, ridge).partial(noise)
    };
    let partials: Vec<Partial> = ridges.par_iter().filter_map(partial).collect();
    let below = |of: &Partial, k: usize| {
        let ridge = Ridge::below(of, k, &reference);
        let is_in_band = of.frequency_hz >= k as f64 * options.low_hz;
        let stands_out = || Baseband::new(&samples, rate_hz, &ridge).stands_out(of);
        (is_in_band && stands_out()).then(|| partial(&ridge))?
    };
    let groups = groups(partials, below);
    let mut candidates: Vec<TonalEvent> = groups
        .iter()
        .filter(|g| (options.low_hz..=options.high_hz).contains(&g.fundamental().frequency_hz))
        .map(|group| event(group, options))
        .filter(|event| event.snr_db > LEAST_SNR_DB)
        .collect();
    let events = sustained(distinct(candidates), options.shortest_s);
    Ok(TonalEvents {
        wow: wow(&events),
        events,
        hum: hum.map(|hum| hum.hum(options.full_scale)),
    })
}

/// Leaves the event of the greatest energy of those that sound together within 3 % of one frequency, in the order
/// of starts.
fn distinct(mut candidates: Vec<TonalEvent>) -> Vec<TonalEvent> {
    let energy = |event: &TonalEvent| event.snr_db + 10.0 * event.span().length_s().log10();
    candidates.sort_by(|a, b| energy(b).total_cmp(&energy(a)));
    let mut kept: Vec<TonalEvent> = Vec::new();
    for event in candidates {
        let is_same = |other: &TonalEvent| {
            let together = event.end_s.min(other.end_s) - event.start_s.max(other.start_s);
            together > 0.0 && (event.frequency_hz / other.frequency_hz - 1.0).abs() < 0.03
        };
        if !kept.iter().any(is_same) {
            kept.push(event);
        }
    }
    kept.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    kept
}

/// The ridges of all resolutions, one for each partial, and the peaks of the window of the noise floor.
fn ridges(samples: &[f64], rate_hz: f64, options: &EventOptions) -> (Vec<Ridge>, Peaks) {
    let share = options.false_alarm / WINDOWS.len() as f64;
    let mut all: Vec<Peaks> = WINDOWS
        .par_iter()
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
    let frequencies: Vec<f64> = strong
        .map(|(i, _)| leader.frequency_at(leader.time(i)) / *multiple as f64)
        .collect();
    let third = frequency_hz * (2f64.powf(1.0 / 6.0) - 2f64.powf(-1.0 / 6.0));
    let full = 0.5 * options.full_scale.powi(2);
    let db = |ratio: f64| 10.0 * ratio.max(1e-20).log10();
    let power: f64 = group.partials.iter().map(|(_, p)| p.power).sum();
    TonalEvent {
        start_s: leader.start_s,
        end_s: leader.end_s,
        frequency_hz,
        frequency_low_hz: frequencies.iter().fold(frequency_hz, |low, f| low.min(*f)),
        frequency_high_hz: frequencies
            .iter()
            .fold(frequency_hz, |high, f| high.max(*f)),
        harmonics: group.partials.len(),
        level_db_fs: db(power / full),
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
                level_db_fs: db(p.1 / full),
            })
            .collect(),
    }
}
