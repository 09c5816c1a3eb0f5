//! Search for tonal events.

use std::iter::successors;

use rayon::prelude::*;

use super::baseband::{Baseband, END_SHARE, LOUDEST_S, LOW_PASS_S};
use super::group::{Group, groups};
use super::hum::Lines;
use super::kind::{inputs, likeliest};
use super::modulation::{modulation, vibrato};
use super::partial::{Partial, STEP_S};
use super::paths::ridges;
use super::ridge::Ridge;
use super::sidebands::join_sidebands;
use super::spectrogram::{Peaks, peaks};
use super::{EventKind, Hum, RidgePoint, TonalEvent, TonalEvents};
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

/// Level of an event below that of the recording above about 170 Hz at which it is faint, dB.
const FAINT_DB: f64 = 40.0;

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
    AnalysisError::check_length("tonal events", samples.len(), (0.2 * rate_hz) as usize)?;
    // A comparison that is false for values that are no numbers, too.
    if !samples.iter().all(|x| x.abs() <= MAX_SAMPLE) {
        return Err(AnalysisError::SampleRange);
    }
    let (candidates, hum, recording_db) = candidates(samples, rate_hz, options);
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
    let events = join_sidebands(events.collect());
    Ok(TonalEvents { events, hum })
}

/// All tones of a recording, in the order of their starts, its hum and its level, dB. They have no kind yet.
pub(super) fn candidates(
    samples: &[f64],
    rate_hz: f64,
    options: &EventOptions,
) -> (Vec<(TonalEvent, Group)>, Option<Hum>, f64) {
    // Scaled so that products of powers neither overflow nor underflow; division by a power of two is exact.
    let [_, largest] = range(samples.iter().map(|x| x.abs()));
    let scale = largest.max(f64::MIN_POSITIVE).log2().floor().exp2();
    let mut options = *options;
    options.full_scale /= scale;
    let offset = mean(samples);
    let samples: Vec<f64> = samples.iter().map(|x| (x - offset) / scale).collect();
    // A faster change of frequency needs a shorter window.
    let windows = successors(Some(2.0 * LOUDEST_S), |window| Some(0.5 * window));
    let windows: Vec<f64> = windows.take_while(|w| *w >= LOW_PASS_S[1]).collect();
    let share = options.false_paths / windows.len() as f64;
    // One after the other: the powers take as much memory as the samples.
    let all: Vec<Peaks> = windows
        .iter()
        .map(|window| peaks(&samples, rate_hz, *window))
        .collect();
    let ridges: Vec<Ridge> = all
        .par_iter()
        .flat_map_iter(|peaks| ridges(peaks, share))
        .collect();
    let hum = Lines::find(&samples, rate_hz);
    // Lines of hum go first: they last longer than a louder squeak beside them.
    let partials = ridges
        .par_iter()
        .flat_map_iter(|ridge| Baseband::new(&samples, rate_hz, ridge).partials())
        .filter(|partial| hum.as_ref().is_none_or(|hum| !hum.has(partial)));
    let mut groups = groups(Partial::distinct(partials.collect()));
    groups.retain(|g| (options.low_hz..=options.high_hz).contains(&g.fundamental().frequency_hz));
    let mut candidates: Vec<_> = groups
        .into_iter()
        .map(|group| (event(&group, &options), group))
        .collect();
    candidates.sort_by(|a, b| a.0.start_s.total_cmp(&b.0.start_s));
    let hum = hum.map(|hum| hum.hum(options.full_scale));
    (candidates, hum, options.level_db(all[1].power))
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
        .filter(|p| p.1 > END_SHARE * leader.power);
    let frequencies = strong.map(|p| p.0 / *multiple as f64);
    let [frequency_low_hz, frequency_high_hz] = range(frequencies.chain([frequency_hz]));
    // Width of the third octave around the frequency.
    let third = frequency_hz * (2f64.powf(1.0 / 6.0) - 2f64.powf(-1.0 / 6.0));
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
                time_s: leader.start_s + STEP_S * i as f64,
                frequency_hz: p.0 / *multiple as f64,
                level_db: db(p.1 / full),
            })
            .collect(),
    }
}
