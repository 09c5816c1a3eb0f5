//! What sounds when in a measured sound, and the condition of the recording.

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::{
    AnalysisError,
    condition::{RecordingCondition, recording_condition},
    events::{EventKind, EventOptions, Hum, Span, TonalEvent, TonalEvents, tonal_events},
    levels::LevelReference,
    stats::deviation,
};
use crate::import::Signal;

/// Sample rates of sound, Hz. A signal with another rate has no tonal events.
pub const SOUND_RATES_HZ: RangeInclusive<f64> = 8e3..=192e3;

/// Maximum number of samples in which events are searched at once: 44 s at 48 kHz. An event that continues
/// across the border of two blocks is joined.
const BLOCK_SAMPLES: usize = 1 << 21;

/// Maximum distance of the two parts of an event from the border, s, and relative difference of frequency.
const JOIN_S: f64 = 0.1;
const JOIN_RATIO: f64 = 0.01;

/// Level of the weakest event that is analysed without request, dB below that of the recording.
const WEAKEST_DB: f64 = 40.0;

/// Measured sound: its tonal events and the condition of the recording. Times are those of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredSound {
    /// What sounds when.
    #[serde(flatten)]
    pub tonal: TonalEvents,
    /// Condition of the recording: clipping, offset, dropouts, silence.
    pub condition: RecordingCondition,
    /// Level reference: what the levels of events, hum and recording are relative to.
    pub level_reference: LevelReference,
    /// Level of the recording: power without the offset, dB relative to the level reference.
    pub recording_level_db: f64,
}

impl MeasuredSound {
    /// The tonal events of a signal and its condition; `None` for a signal whose sample rate is not that of
    /// sound ([`SOUND_RATES_HZ`]) or that is too short for the search (0.2 s). Levels are relative to
    /// [`LevelReference::of`] its unit.
    ///
    /// # Errors
    /// As [`tonal_events`], except for a short signal.
    pub fn of(signal: &Signal, faint: bool) -> Result<Option<Self>, AnalysisError> {
        if !SOUND_RATES_HZ.contains(&signal.rate) {
            return Ok(None);
        }
        let largest = signal.samples.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let level_reference = LevelReference::of(&signal.unit, largest);
        let options = EventOptions {
            full_scale: level_reference.amplitude(largest),
            faint,
            ..EventOptions::default()
        };
        let tonal = match by_blocks(signal, &options) {
            Err(AnalysisError::TooShort { .. }) => return Ok(None),
            tonal => tonal?,
        };
        let mut condition = recording_condition(&signal.samples, signal.rate);
        let spans = [
            &mut condition.clipped,
            &mut condition.dropouts,
            &mut condition.silence,
        ];
        for span in spans.into_iter().flatten() {
            span.start_s += signal.start;
            span.end_s += signal.start;
        }
        let power = deviation(&signal.samples).powi(2);
        let full = 0.5 * options.full_scale.powi(2);
        Ok(Some(Self {
            tonal,
            condition,
            level_reference,
            recording_level_db: 10.0 * (power / full).log10(),
        }))
    }

    /// Index of the tone with the largest energy, mean power times duration, of those that are at most 40 dB
    /// below the level of the recording: weaker ones can be traces of stronger tones, such as quantisation.
    pub fn strongest(&self) -> Option<usize> {
        let energy =
            |event: &TonalEvent| 10f64.powf(0.1 * event.level_db) * (event.end_s - event.start_s);
        let least = self.recording_level_db - WEAKEST_DB;
        let events = &self.tonal.events;
        let is_loud =
            |k: &usize| events[*k].kind == EventKind::Tone && events[*k].level_db >= least;
        (0..events.len())
            .filter(is_loud)
            .max_by(|a, b| energy(&events[*a]).total_cmp(&energy(&events[*b])))
    }
}

/// Searches events in blocks, so that the search of a long signal takes no more memory than that of a block.
fn by_blocks(signal: &Signal, options: &EventOptions) -> Result<TonalEvents, AnalysisError> {
    let count = signal.samples.len();
    let blocks = count.div_ceil(BLOCK_SAMPLES).max(1);
    let mut all = TonalEvents::default();
    for block in 0..blocks {
        let [first, end] = [block, block + 1].map(|k| count * k / blocks);
        let start_s = signal.time(first as f64);
        let found = tonal_events(&signal.samples[first..end], signal.rate, options)?;
        for mut event in found.events {
            shift(&mut event, start_s);
            let mut before = all.events.iter_mut();
            match before.find(|before| continues(before, &event, start_s)) {
                Some(before) => join(before, event),
                None => all.events.push(event),
            }
        }
        let level = |hum: Option<Hum>| hum.map_or(f64::NEG_INFINITY, |hum| hum.level_db);
        if level(found.hum) > level(all.hum) {
            all.hum = found.hum;
        }
    }
    Ok(all)
}

/// Whether an event continues another one across the border (s) between two blocks.
fn continues(before: &TonalEvent, event: &TonalEvent, border_s: f64) -> bool {
    let gap = (border_s - before.end_s).max(event.start_s - border_s);
    let [end, start] = [
        before.frequency_at(before.end_s),
        event.frequency_at(event.start_s),
    ];
    // The ends of events are uncertain, and may lie beyond the border.
    let is_new = event.start_s >= border_s - JOIN_S && before.end_s <= border_s + JOIN_S;
    is_new && gap < JOIN_S && (start / end - 1.0).abs() < JOIN_RATIO
}

/// Appends the second part of an event, with the modulation of the longer part.
fn join(event: &mut TonalEvent, mut next: TonalEvent) {
    let durations = [event.span().length_s(), next.span().length_s()];
    let mean = |a: f64, b: f64, [u, v]: [f64; 2]| (a * u + b * v) / (u + v);
    let db = |value: f64| 10f64.powf(0.1 * value);
    let powers = [db(event.level_db), db(next.level_db)];
    let energies = [powers[0] * durations[0], powers[1] * durations[1]];
    event.frequency_hz = mean(event.frequency_hz, next.frequency_hz, energies);
    event.frequency_low_hz = event.frequency_low_hz.min(next.frequency_low_hz);
    event.frequency_high_hz = event.frequency_high_hz.max(next.frequency_high_hz);
    event.harmonics = event.harmonics.max(next.harmonics);
    event.level_db = 10.0 * mean(powers[0], powers[1], durations).log10();
    event.snr_db = 10.0 * mean(db(event.snr_db), db(next.snr_db), durations).log10();
    if durations[1] > durations[0] {
        event.modulation = next.modulation;
        event.vibrato = next.vibrato;
    }
    event.end_s = next.end_s;
    let last_s = event.ridge.last().map(|point| point.time_s);
    next.ridge.retain(|point| Some(point.time_s) > last_s);
    event.ridge.append(&mut next.ridge);
}

/// Adds a time (s) to all times of an event.
pub(super) fn shift(event: &mut TonalEvent, by_s: f64) {
    event.start_s += by_s;
    event.end_s += by_s;
    for point in &mut event.ridge {
        point.time_s += by_s;
    }
}

/// Whether two intervals have a common part.
pub(super) fn overlap(a: Span, b: Span) -> bool {
    a.start_s < b.end_s && b.start_s < a.end_s
}

#[cfg(test)]
#[path = "sound_tests.rs"]
mod tests;
