//! The background of a recording.

use super::stretch::index_range;
use crate::analysis::{
    events::{Span, TonalEvent},
    filter::band_pass,
    stats::deviation,
};
use crate::import::Signal;

/// Shortest interval without events in which the background is measured, s.
const SHORTEST_S: f64 = 0.1;

/// Distance of this interval from events, s: they end gradually, and reverberate.
const MARGIN_S: f64 = 0.1;

/// Largest number of samples of this interval that are used: those of the longest stretch.
const MAX_SAMPLES: usize = super::stretch::MAX_SAMPLES;

/// Power of a recording in a band (Hz; `None` for all frequencies) in the longest interval without events, in the
/// square of the unit of the signal; `None` if there is no event, or no such interval.
pub(super) fn background_power(
    signal: &Signal,
    events: &[TonalEvent],
    band: Option<[f64; 2]>,
) -> Option<f64> {
    if events.is_empty() {
        return None;
    }
    let mut start_s = signal.start;
    let mut gaps = Vec::with_capacity(events.len() + 1);
    for event in events {
        gaps.push([start_s, event.start_s - MARGIN_S]);
        start_s = start_s.max(event.end_s + MARGIN_S);
    }
    gaps.push([start_s, signal.start + signal.duration()]);
    let length = |gap: &[f64; 2]| gap[1] - gap[0];
    let [start_s, end_s] = gaps
        .into_iter()
        .max_by(|a, b| length(a).total_cmp(&length(b)))
        .filter(|gap| length(gap) >= SHORTEST_S)?;
    let samples = &signal.samples[index_range(signal, Span { start_s, end_s })];
    let samples = &samples[..samples.len().min(MAX_SAMPLES)];
    let deviation = match band {
        Some(band) => deviation(&band_pass(samples, signal.rate, band).samples),
        None => deviation(samples),
    };
    Some(deviation.powi(2))
}
