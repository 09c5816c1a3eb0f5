//! Sounds of whole recordings, prepared as an analysis of a recording prepares them.

use super::Regime::{self, Chaotic, Noise, Periodic, QuasiPeriodic, Transient, Undetermined};
use super::*;
use crate::events::{
    EventKind, EventOptions, TonalEvent, demodulate, stationary_stretch, tonal_events,
};
use crate::filter::band_pass;
use crate::generator::{Kind, Recording, Squeak, recording};
use crate::stats::deviation;

/// Least power of a second tone over the background, dB, for which it is the type of motion.
const SECOND_DB: f64 = 10.0;

/// The stationary stretch of a sound, and the right verdicts on it.
pub struct Stretch {
    pub samples: Vec<f64>,
    pub search: RegimeSearch,
    pub right: &'static [Regime],
}

/// The squeaks that are found in a recording, without those that sound together with another one, or its noise or bursts of
/// a resonance. Squeaks have signal-to-noise ratios (dB) between two values.
pub fn stretches(kind: Kind, snr_db: [f64; 2], seed: u64) -> Vec<Stretch> {
    let recording = recording(kind, snr_db[0]..=snr_db[1], seed);
    let options = EventOptions::default();
    let found = tonal_events(&recording.samples, recording.rate_hz, &options);
    let events = found.unwrap().events;
    let known = events.iter().filter_map(|event| {
        let band = pass_band(&events, event, 0.5 * recording.rate_hz);
        let right = if recording.resonance_hz.is_some() {
            right_for_resonance(kind, &recording, event)?
        } else {
            right_for_squeak(kind, &recording, event, band)?
        };
        Some(stretch(&recording, &events, event, band, right))
    });
    known.collect()
}

/// The right verdicts on a squeak that is found as an event, itself or by its second tone: the lines of a modulated
/// tone are those of a torus. `None` if a second tone is outside the band or hidden by noise.
fn right_for_squeak(
    kind: Kind,
    recording: &Recording,
    event: &TonalEvent,
    [low, high]: [f64; 2],
) -> Option<&'static [Regime]> {
    let sounding = recording
        .squeaks
        .iter()
        .filter(|squeak| squeak.start_s < event.end_s && event.start_s < squeak.end_s);
    let [squeak] = sounding.collect::<Vec<&Squeak>>()[..] else {
        return None;
    };
    // The mean frequency of chaos, weighted by power, is not that of its strongest line.
    let reach = if kind == Kind::Chaos { 0.1 } else { 0.02 };
    let is_at = |hz: f64| (event.frequency_hz / hz - 1.0).abs() < reach;
    let Some([second_hz, size]) = squeak.second else {
        let right: &[Regime] = match squeak.modulation {
            _ if kind == Kind::Chaos => &[Chaotic],
            Some(_) => &[Periodic, QuasiPeriodic],
            None => &[Periodic],
        };
        return is_at(squeak.frequency_hz).then_some(right);
    };
    let right: &[Regime] = match kind {
        Kind::Change => &[Transient, Undetermined],
        Kind::Torus => &[QuasiPeriodic],
        _ if squeak.modulation.is_some() => &[Periodic, QuasiPeriodic],
        _ => &[Periodic],
    };
    let is_within = [squeak.frequency_hz, second_hz]
        .iter()
        .all(|hz| (low..high).contains(hz));
    let is_loud = squeak.snr_db + 20.0 * size.log10() > SECOND_DB;
    let is_sound = is_at(squeak.frequency_hz) || is_at(second_hz);
    (is_sound && (kind == Kind::Change || is_within && is_loud)).then_some(right)
}

fn right_for_resonance(
    kind: Kind,
    recording: &Recording,
    event: &TonalEvent,
) -> Option<&'static [Regime]> {
    let off = (event.frequency_hz / recording.resonance_hz? - 1.0).abs();
    let (right, reach): (&[Regime], f64) = match kind {
        Kind::Resonance => (&[Noise], 0.12),
        _ => (&[Noise, Transient, Undetermined], 0.3),
    };
    (off < reach).then_some(right)
}

/// The band of an event and of the tones that sound with it: from a third of the lowest fundamental to half a harmonic
/// above the highest one.
fn pass_band(events: &[TonalEvent], analysed: &TonalEvent, nyquist: f64) -> [f64; 2] {
    let span = stationary_stretch(analysed);
    let sounding = events.iter().filter(|event| {
        let is_tone = event.kind == EventKind::Tone || *event == analysed;
        is_tone && event.start_s < span.end_s && span.start_s < event.end_s
    });
    sounding.fold([nyquist, 0.0], |[low, high], event| {
        let highest = event.frequency_high_hz * (2.0 * event.harmonics.max(1) as f64 - 0.5);
        [
            low.min(event.frequency_low_hz / 3.0),
            high.max(highest).min(nyquist),
        ]
    })
}

/// The stationary stretch of an event in a band, at constant frequency.
fn stretch(
    recording: &Recording,
    events: &[TonalEvent],
    event: &TonalEvent,
    band: [f64; 2],
    right: &'static [Regime],
) -> Stretch {
    let rate = recording.rate_hz;
    let filtered = band_pass(&recording.samples, rate, band).samples;
    let samples = demodulate(&filtered, rate, event, stationary_stretch(event)).unwrap();
    let is_quiet = |time: f64| {
        let near = |event: &TonalEvent| (event.start_s - 0.1..event.end_s + 0.1).contains(&time);
        !events.iter().any(near)
    };
    let quiet = filtered.iter().enumerate();
    let quiet = quiet.filter(|(i, _)| is_quiet(*i as f64 / rate));
    let quiet: Vec<f64> = quiet.map(|(_, x)| *x).collect();
    let background = if quiet.is_empty() {
        0.0
    } else {
        deviation(&quiet).powi(2)
    };
    Stretch {
        samples,
        search: RegimeSearch {
            sample_rate: rate,
            silence: 0.0,
            background,
        },
        right,
    }
}
