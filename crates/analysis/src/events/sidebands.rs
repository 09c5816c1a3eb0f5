//! Sidebands of a modulated tone.

use super::group::SAME;
use super::partial::SIDEBAND_RATIO;
use super::{EventKind, TonalEvent};

/// Difference of the ends of a tone and of its sidebands, s.
const ENDS_S: f64 = 0.05;

/// Distance of sidebands from their tone, in its frequency, up to which they are no subharmonics.
const WIDEST: f64 = 0.45;

/// Joins tones with a louder tone of which they are sidebands: they begin and end with it, are as weak as sidebands, and lie at
/// multiples of its frequency `f1` plus or minus up to three times `fm`, where both `f1 - fm` and `f1 + fm` are among them. They
/// lie in the band of its harmonics, `n` of which may be the odd ones, so that the filter of its stretch passes them.
pub(super) fn join_sidebands(mut events: Vec<TonalEvent>) -> Vec<TonalEvent> {
    events.sort_by(|a, b| b.level_db.total_cmp(&a.level_db));
    let mut k = 0;
    while k < events.len() {
        let carrier = events[k].clone();
        let f1 = carrier.frequency_hz;
        let is_beside = |event: &TonalEvent| {
            [carrier.kind, event.kind] == [EventKind::Tone; 2]
                && event.level_db < carrier.level_db - 10.0 * SIDEBAND_RATIO.log10()
                && (event.start_s - carrier.start_s).abs() < ENDS_S
                && (event.end_s - carrier.end_s).abs() < ENDS_S
        };
        let beside = events.iter().filter(|event| is_beside(event));
        let distances: Vec<f64> = beside.map(|event| event.frequency_hz - f1).collect();
        let is_pair = |fm: &f64| distances.iter().any(|d| (d + fm).abs() < SAME * fm);
        let pairs = distances.iter().copied().filter(is_pair);
        if let Some(fm) = pairs.reduce(f64::min).filter(|fm| *fm < WIDEST * f1) {
            let is_side = |event: &&TonalEvent| {
                let nearest = (event.frequency_hz / f1).round().max(1.0) * f1;
                let order = (event.frequency_hz - nearest) / fm;
                let is_multiple = (order - order.round()).abs() < SAME;
                let is_near = event.frequency_hz < (2.0 * carrier.harmonics as f64 - 0.5) * f1;
                is_beside(event) && is_multiple && is_near && (0.5..3.5).contains(&order.abs())
            };
            let joined = events.iter().filter(is_side).chain([&carrier]);
            let power: f64 = joined.map(|event| 10f64.powf(0.1 * event.level_db)).sum();
            events.retain(|event| !is_side(&event));
            events[k].level_db = 10.0 * power.log10();
        }
        k += 1;
    }
    events.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    events.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    events
}
