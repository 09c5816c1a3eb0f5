//! Wow: a slow variation of the speed of a recording, common to all its tones.

use super::modulation::{line, strongest};
use super::partial::STEP_S;
use super::{TonalEvent, Wow};

/// Range of the frequency of wow, Hz (IEC 60386: 0.1 to 10 Hz; slower variations need longer events).
const BAND_HZ: [f64; 2] = [0.3, 10.0];

/// Smallest relative deviation that is reported.
const LEAST_DEPTH: f64 = 2e-4;

/// Largest difference between the relative deviations of two tones, relative to their mean.
const LARGEST_DIFFERENCE: f64 = 0.3;

/// Deviation of the ratio of two frequencies from an integer below which they can be partials of one tone.
const HARMONIC_DEVIATION: f64 = 0.01;

/// The largest variation of speed that two simultaneous events have in common: the same relative deviation of
/// frequency at the same time. Partials of one tone vary together anyway and do not count.
pub(super) fn wow(events: &[TonalEvent]) -> Option<Wow> {
    let pairs = (0..events.len()).flat_map(|i| (0..i).map(move |k| (&events[k], &events[i])));
    pairs
        .filter_map(|(a, b)| common(a, b))
        .max_by(|a, b| a.wow_depth.total_cmp(&b.wow_depth))
}

/// The variation of speed common to two events.
fn common(a: &TonalEvent, b: &TonalEvent) -> Option<Wow> {
    let ratio = (a.frequency_hz / b.frequency_hz).max(b.frequency_hz / a.frequency_hz);
    if (ratio - ratio.round()).abs() < HARMONIC_DEVIATION * ratio {
        return None;
    }
    let (start, end) = (a.start_s.max(b.start_s), a.end_s.min(b.end_s));
    let count = ((end - start) / STEP_S).max(0.0) as usize;
    let logarithms = |event: &TonalEvent| -> Vec<f64> {
        let at = |i: usize| event.frequency_at(start + i as f64 * STEP_S).ln();
        (0..count).map(at).collect()
    };
    let (a, b) = (logarithms(a), logarithms(b));
    let combined = |sign: f64| -> Vec<f64> {
        let pairs = a.iter().zip(&b);
        pairs.map(|(a, b)| 0.5 * (a + sign * b)).collect()
    };
    let (wow_hz, wow_depth) = strongest(&combined(1.0), BAND_HZ)?;
    // The deviations differ by twice the half difference.
    let difference = 2.0 * line(&combined(-1.0), wow_hz);
    (wow_depth > LEAST_DEPTH && difference < LARGEST_DIFFERENCE * wow_depth)
        .then_some(Wow { wow_hz, wow_depth })
}
