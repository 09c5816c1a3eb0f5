//! The part of an event in which it is stationary.

use super::baseband::LOUDEST_S;
use super::{RidgePoint, Span, TonalEvent};

/// Largest change of the averaged level within a stationary stretch, dB.
const LEVEL_CHANGE_DB: f64 = 6.0;

/// The longest stationary stretch of an event: the longest interval in which the level, averaged over
/// 0.2 s, stays within 6 dB. The frequency may drift: analyse the stretch of the [`demodulate`]d signal.
/// The averages take power and not decibels, so that deep modulation faster than 5 Hz does not count.
///
/// [`demodulate`]: super::demodulate
pub fn stationary_stretch(event: &TonalEvent) -> Span {
    let (times, levels) = averaged(&event.ridge);
    let mut best = (0, 0);
    for first in 0..levels.len() {
        let (mut low, mut high) = (levels[first], levels[first]);
        let within = levels[first..].iter().take_while(|level| {
            (low, high) = (low.min(**level), high.max(**level));
            high - low <= LEVEL_CHANGE_DB
        });
        let last = first + within.count() - 1;
        if last - first > best.1 - best.0 {
            best = (first, last);
        }
    }
    if best.1 > best.0 {
        Span {
            start_s: times[best.0].max(event.start_s),
            end_s: times[best.1].min(event.end_s),
        }
    } else {
        event.span()
    }
}

/// Times of the ridge and its level from the mean power around each of them, dB.
fn averaged(ridge: &[RidgePoint]) -> (Vec<f64>, Vec<f64>) {
    let mut sums = vec![0.0];
    for point in ridge {
        sums.push(sums[sums.len() - 1] + 10f64.powf(0.1 * point.level_db));
    }
    let times: Vec<f64> = ridge.iter().map(|point| point.time_s).collect();
    let level = |time: &f64| {
        let first = times.partition_point(|t| *t < time - LOUDEST_S);
        let end = times.partition_point(|t| *t <= time + LOUDEST_S);
        10.0 * ((sums[end] - sums[first]) / (end - first) as f64).log10()
    };
    let levels = times.iter().map(level).collect();
    (times, levels)
}
