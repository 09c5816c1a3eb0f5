//! Changes of the mean in a stationary, autocorrelated series: has the motion changed its attractor?
//!
//! [`BlockMeans`](crate::stats::BlockMeans) condenses a stream of local quantities (exponents, logarithms of energies) to 64 to 128
//! blocks. [`change_points`] tests the blocks by binary segmentation. Each test uses the self-normalised
//! CUSUM statistic of X. Shao and X. Zhang, J. Am. Stat. Assoc. 105 (2010) 1228-1240: it needs no estimate
//! of the variance or of the correlation time, so neither a change nor slow fluctuations bias it.
//!
//! A drift is not a change: where a straight line explains the blocks better than a step, nothing is found.
//!
//! A change counts only if the motion does not return to its earlier state. If an episode like the state
//! before the change occurs after it, or the reverse, for at least a fifth of the state's own duration, the
//! two are phases of one intermittent motion: a motion does not return from another attractor. A single
//! long phase without precedent cannot be distinguished from a change.

mod cusum;

use cusum::cusum;

use std::ops::Range;

use crate::stats::{deviation, mean, trend};

/// Maximum number of channels in a test.
pub const MAX_CHANNELS: usize = 10;

/// Value that the largest statistic of one channel of independent blocks in any of the [`WINDOWS`] exceeds
/// with a probability of `1e-3 / MAX_CHANNELS`: 252 in 64 blocks, 237 in 128 (200,000 series each).
const CRITICAL: f64 = 245.0;

/// Minimum number of blocks in a series to be tested.
const MIN_BLOCKS: usize = 32;

/// Ranges that are tested, in quarters of the series. A second change in the whole series would count as
/// scatter and hide the first.
const WINDOWS: [[usize; 2]; 6] = [[0, 4], [0, 3], [1, 4], [0, 2], [1, 3], [2, 4]];

/// Minimum number of blocks in a window.
const MIN_WINDOW: usize = 16;

/// Minimum number of blocks in a segment.
const MIN_SEGMENT: usize = 4;

/// Length of an earlier episode of a state, relative to its present length, that makes it a phase of
/// intermittency.
const EPISODE: f64 = 0.2;

/// Difference of the means of an episode and a state, relative to the change, up to which they are alike.
const CLOSE: f64 = 0.25;

/// A channel: one quantity in successive blocks of equal length, and the change of its mean that matters.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Mean in each block, in any unit. A channel with a value that is not finite is ignored.
    pub values: Vec<f64>,
    /// Minimum change of the mean, in the unit of the values.
    pub min_change: f64,
    /// Minimum change of the mean times the number of blocks of the shorter side. For a growth rate times
    /// the length of a block this is the growth by which the sides differ.
    pub min_sum: f64,
}

impl Channel {
    /// Whether the means before and after a block differ by enough to matter.
    fn matters(&self, window: &Range<usize>, at: usize) -> bool {
        let [before, after] =
            [window.start..at, at..window.end].map(|side| mean(&self.values[side]));
        let shorter = (at - window.start).min(window.end - at);
        let change = (after - before).abs();
        change >= self.min_change && change * shorter as f64 >= self.min_sum
    }

    /// Whether a straight line explains the values better than a step at a block does.
    fn is_drift(&self, window: &Range<usize>, at: usize) -> bool {
        let values = &self.values[window.clone()];
        let squares = |side: &[f64]| side.len() as f64 * deviation(side).powi(2);
        let step = squares(&self.values[window.start..at]) + squares(&self.values[at..window.end]);
        trend(values)[1] < step
    }

    /// Whether an episode like the state before a block occurs after it, or the reverse, in the whole series.
    fn is_phase(&self, window: &Range<usize>, at: usize) -> bool {
        let (before, after) = (&self.values[window.start..at], &self.values[at..window.end]);
        let change = (mean(after) - mean(before)).abs();
        let episode = |of: &[f64], within: &[f64]| {
            let length = (EPISODE * of.len() as f64).ceil() as usize;
            let mut windows = within.windows(length.max(1));
            windows.any(|window| (mean(window) - mean(of)).abs() <= CLOSE * change)
        };
        episode(after, &self.values[..at]) || episode(before, &self.values[at..])
    }
}

/// First block of each new state, in ascending order; empty for a stationary series.
///
/// A stationary series has a false change with a probability of about 1e-3, if a block is at least
/// as long as the correlation time. A change by three standard deviations of a block is found once the new
/// state has lasted for a sixth of the series. At most [`MAX_CHANNELS`] channels are tested, the first ones.
///
/// # Panics
/// If the channels differ in length.
pub fn change_points(channels: &[Channel]) -> Vec<usize> {
    let finite = channels.iter().take(MAX_CHANNELS);
    let finite = finite.filter(|channel| channel.values.iter().all(|x| x.is_finite()));
    let channels: Vec<&Channel> = finite.collect();
    let Some(count) = channels.first().map(|channel| channel.values.len()) else {
        return Vec::new();
    };
    assert!(channels.iter().all(|channel| channel.values.len() == count));
    let mut changes = Vec::new();
    if count >= MIN_BLOCKS {
        split(&channels, 0..count, &mut changes);
        changes.sort_unstable();
    }
    changes
}

/// Adds the changes within a range of blocks.
fn split(channels: &[&Channel], all: Range<usize>, changes: &mut Vec<usize>) {
    let Some(at) = change(channels, &all) else {
        return;
    };
    changes.push(at);
    split(channels, all.start..at, changes);
    split(channels, at..all.end, changes);
}

/// The most significant change within a range of blocks.
fn change(channels: &[&Channel], all: &Range<usize>) -> Option<usize> {
    let quarter = |k: usize| all.start + k * all.len() / 4;
    let windows = WINDOWS.map(|[from, to]| quarter(from)..quarter(to));
    let tests = windows.iter().filter(|window| window.len() >= MIN_WINDOW);
    let tests = tests.flat_map(|window| channels.iter().map(move |channel| (window, channel)));
    let found = tests.filter_map(|(window, channel)| {
        let values = &channel.values[window.clone()];
        let statistic = cusum(values, MIN_SEGMENT);
        if statistic <= CRITICAL {
            return None;
        }
        let at = window.start + most_likely_border(values, MIN_SEGMENT);
        let is_change = channel.matters(window, at)
            && !channel.is_drift(window, at)
            && !channel.is_phase(window, at);
        is_change.then_some((statistic, at))
    });
    let strongest = found.max_by(|a, b| a.0.total_cmp(&b.0));
    strongest.map(|(_, at)| at)
}

/// The border of maximum likelihood between two normal distributions of different mean and variance.
fn most_likely_border(values: &[f64], min: usize) -> usize {
    // A tone has no scatter at all: the floor keeps the logarithm finite.
    let floor = (1e-3 * deviation(values)).powi(2).max(f64::MIN_POSITIVE);
    let cost = |side: &[f64]| side.len() as f64 * (deviation(side).powi(2) + floor).ln();
    let costs = (min..=values.len() - min).map(|at| {
        let (before, after) = values.split_at(at);
        (cost(before) + cost(after), at)
    });
    costs
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, at)| at)
}

#[cfg(test)]
mod tests;
