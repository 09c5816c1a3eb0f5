//! The end of a transient, from the energies of the modes of a vibration.
//!
//! The energy of each mode is averaged over blocks of a few periods. The mean of its logarithm is compared
//! between the third and the last quarter of all blocks so far. This is the idea of J. Geweke's diagnostic
//! for Markov chains, Bayesian Statistics 4 (1992) 169–193; the logarithm is used because vibrations grow
//! and decay exponentially. The transient has ended when no mode's mean has changed by more than 5 % or
//! three standard errors. Every mode counts, however weak, because a change of regime first appears in the
//! mode that grows. Modes below 1e-12 of the total energy are ignored.
//!
//! Some transients look settled for a long time, for example transient chaos that ends in a tone. Therefore
//! the motion after the transient is tested as well: it has changed if a mode with a significant share of
//! the energy differs between its two halves.

use crate::stats::{mean, trend};

/// Share of the total energy below which a mode is ignored.
const NEGLIGIBLE_SHARE: f64 = 1e-12;

/// Change of the logarithm of a mode's energy that still counts as stationary.
const MAX_DRIFT: f64 = 0.05;

/// Number of standard errors within which two means count as equal.
const MAX_ERRORS: f64 = 3.0;

/// A change of motion: minimum change of the logarithm of a mode's energy, minimum number of standard
/// errors, and minimum share of the total energy of the mode.
const MIN_CHANGE: f64 = 0.2;
const MIN_ERRORS: f64 = 5.0;
const MIN_SHARE: f64 = 0.01;

/// Minimum number of blocks for a decision.
const MIN_BLOCKS: usize = 16;

/// Block averages of the energies of modes.
#[derive(Clone, Debug)]
pub struct TransientDetector {
    /// Logarithms of the mean energy of each mode, then of the total energy, one for each block.
    channels: Vec<Vec<f64>>,
    /// Sums of the current block, and its samples so far.
    sums: Vec<f64>,
    count: usize,
    /// Samples per block.
    length: usize,
}

impl TransientDetector {
    /// Creates a detector for `modes` modes and blocks of `length` samples.
    pub fn new(modes: usize, length: usize) -> Self {
        Self {
            channels: vec![Vec::new(); modes + 1],
            sums: vec![0.0; modes],
            count: 0,
            length: length.max(1),
        }
    }

    /// Adds the energies of the modes at a time. Returns whether they completed a block.
    pub fn push(&mut self, energies: impl Iterator<Item = f64>) -> bool {
        for (sum, energy) in self.sums.iter_mut().zip(energies) {
            *sum += energy;
        }
        self.count += 1;
        if self.count < self.length {
            return false;
        }
        let all: f64 = self.sums.iter().sum();
        let least = (NEGLIGIBLE_SHARE * all).max(f64::MIN_POSITIVE);
        let sums = self.sums.iter().chain([&all]);
        for (channel, sum) in self.channels.iter_mut().zip(sums) {
            channel.push(sum.max(least).ln());
        }
        self.sums.fill(0.0);
        self.count = 0;
        true
    }

    /// Whether the transient has ended according to the blocks so far.
    pub fn has_ended(&self) -> bool {
        let count = self.blocks();
        count >= MIN_BLOCKS
            && self.channels.iter().all(|channel| {
                let [before, after] = [count / 2..3 * count / 4, 3 * count / 4..count]
                    .map(|quarter| mean_with_error(&channel[quarter]));
                let error = before[1].hypot(after[1]);
                (after[0] - before[0]).abs() <= (MAX_ERRORS * error).max(MAX_DRIFT)
            })
    }

    /// Whether the motion changed between the first and the second half of the blocks.
    pub fn has_changed(&self) -> bool {
        if self.blocks() < MIN_BLOCKS {
            return false;
        }
        let halves = self.channels.iter().map(|channel| {
            let (first, second) = channel.split_at(channel.len() / 2);
            [first, second].map(mean_with_error)
        });
        let halves: Vec<[[f64; 2]; 2]> = halves.collect();
        let total = halves[halves.len() - 1];
        halves.into_iter().any(|[before, after]| {
            let part = |mean: [f64; 2], of: [f64; 2]| mean[0] - of[0] > MIN_SHARE.ln();
            let takes_part = part(before, total[0]) || part(after, total[1]);
            let change = (after[0] - before[0]).abs();
            takes_part && change > (MIN_ERRORS * before[1].hypot(after[1])).max(MIN_CHANGE)
        })
    }

    /// Number of complete blocks.
    pub fn blocks(&self) -> usize {
        self.channels[0].len()
    }
}

/// Mean and its standard error for independent values. A linear trend does not count as scatter.
fn mean_with_error(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let [_, residual] = trend(values);
    let variance = residual / (n - 2.0).max(1.0);
    [mean(values), (variance / n).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::noise;

    /// Energies of two oscillators, of which the second has thrice the frequency, at rest with these displacements.
    fn energies([a, b]: [f64; 2]) -> impl Iterator<Item = f64> {
        [a * a, 9.0 * b * b].into_iter()
    }

    /// Number of blocks until the detector reports the end of the transient of two oscillators with these
    /// amplitudes per block; `None` if it does not within 400 blocks.
    fn blocks_until_end(amplitudes: impl Fn(usize) -> [f64; 2]) -> Option<usize> {
        let mut detector = TransientDetector::new(2, 1);
        (0..400).find(|&block| detector.push(energies(amplitudes(block))) && detector.has_ended())
    }

    #[test]
    fn a_stationary_motion_is_settled_at_the_first_possible_block() {
        assert_eq!(blocks_until_end(|_| [1.0, 0.3]), Some(MIN_BLOCKS - 1));
        let noise = noise(5, 400, 0.05);
        let fluctuating = blocks_until_end(|k| [1.0 + noise[k], 0.3]);
        assert!(fluctuating.unwrap() < 40, "{fluctuating:?}");
    }

    #[test]
    fn a_growing_motion_is_not_settled() {
        // Grows by e in 10 blocks until it is 1 after 100 blocks.
        let end = blocks_until_end(|k| [((k as f64 - 100.0) / 10.0).exp().min(1.0), 1e-9]).unwrap();
        assert!((150..260).contains(&end), "{end}");
    }

    #[test]
    fn a_weak_growing_mode_is_detected() {
        let end = blocks_until_end(|k| {
            let weak = (1e-5 * (k as f64 / 10.0).exp()).min(0.8);
            [1.0 - weak, weak]
        });
        // It dominates from about block 115.
        assert!(end.is_none_or(|end| end > 160), "{end:?}");
    }

    #[test]
    fn a_change_of_motion_is_detected() {
        let changed = |amplitudes: &dyn Fn(usize) -> [f64; 2]| {
            let mut detector = TransientDetector::new(2, 1);
            for block in 0..200 {
                detector.push(energies(amplitudes(block)));
            }
            detector.has_changed()
        };
        let noise = noise(5, 200, 0.3);
        let fluctuating = |k: usize| [1.0 + noise[k], 0.3];
        assert!(!changed(&fluctuating));
        assert!(changed(&|k| if k < 60 {
            fluctuating(k)
        } else {
            [0.01, 0.3]
        }));
        // A mode with a negligible share of the energy may still decay.
        assert!(!changed(&|k| [
            1.0 + noise[k],
            1e-3 * (-0.1 * k as f64).exp()
        ]));
    }

    #[test]
    fn an_exponential_decay_is_not_stationary() {
        assert_eq!(blocks_until_end(|k| [(-0.02 * k as f64).exp(), 0.0]), None);
        assert_eq!(blocks_until_end(|_| [0.0, 0.0]), Some(MIN_BLOCKS - 1));
    }
}
