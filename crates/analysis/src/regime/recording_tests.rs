//! Sounds of whole recordings, prepared as an analysis of a recording prepares them.

use super::Regime::{self, Noise, Periodic, QuasiPeriodic, Transient, Undetermined};
use super::*;
use crate::events::{EventOptions, TonalEvent, demodulate, stationary_stretch, tonal_events};
use crate::filter::band_pass;
use crate::generator::{Kind, Recording, Squeak, recording};
use crate::stats::deviation;

/// Most samples of a stretch that an analysis classifies.
const NEWEST: usize = 50_000;

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
        let right = match kind {
            Kind::Squeaks | Kind::Change => right_for_squeak(kind, &recording, event)?,
            _ => right_for_resonance(kind, &recording, event)?,
        };
        Some(stretch(&recording, &events, event, right))
    });
    known.collect()
}

/// The right verdicts on a squeak: the lines of a modulated tone are those of a torus.
fn right_for_squeak(
    kind: Kind,
    recording: &Recording,
    event: &TonalEvent,
) -> Option<&'static [Regime]> {
    let sounding = recording
        .squeaks
        .iter()
        .filter(|squeak| squeak.start_s < event.end_s && event.start_s < squeak.end_s);
    let [squeak] = sounding.collect::<Vec<&Squeak>>()[..] else {
        return None;
    };
    let is_squeak = (event.frequency_hz / squeak.frequency_hz - 1.0).abs() < 0.02;
    is_squeak.then_some(match squeak.modulation {
        _ if kind == Kind::Change => &[Transient, Undetermined],
        Some(_) => &[Periodic, QuasiPeriodic],
        None => &[Periodic],
    })
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

/// The stationary stretch of an event in the band of its harmonics, at constant frequency.
fn stretch(
    recording: &Recording,
    events: &[TonalEvent],
    event: &TonalEvent,
    right: &'static [Regime],
) -> Stretch {
    let rate = recording.rate_hz;
    let highest = event.frequency_high_hz * (2.0 * event.harmonics.max(1) as f64 - 0.5);
    let band = [event.frequency_low_hz / 3.0, highest.min(0.5 * rate)];
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
        samples: samples[samples.len().saturating_sub(NEWEST)..].to_vec(),
        search: RegimeSearch {
            sample_rate: rate,
            silence: 0.0,
            background,
        },
        right,
    }
}
