//! When a transient is over, told from the motion itself.
//!
//! The energy of each mode is averaged over blocks of a few periods, and its logarithm compared
//! between the third and the last quarter of all blocks so far (the idea of J. Geweke's diagnostic
//! for Markov chains, Bayesian Statistics 4 (1992) 169–193, on the logarithm because vibrations
//! grow and die by factors). The transient is over when no mode's mean has changed by more than a
//! few per cent or three of its standard errors. Every mode counts, however weak: a motion that is
//! about to give way to another one is first seen in the mode that grows. Only what lies below a
//! millionth of a millionth of the whole is not looked at.
//!
//! Some transients look settled for a long time: a chaotic one, say, that ends in a tone at last. So the
//! stretch that is measured is looked at, too: if a mode with a part in the motion has another
//! energy in its second half than in its first, it was not one motion.
//!
//! A motion that dies away for good is over when it has fallen below what counts as silence.

use std::ops::Range;

/// A mode with a smaller share of the energy is not looked at.
const FAINTEST: f64 = 1e-12;

/// Change of the logarithm of a mode's energy that is no change.
const STEADY: f64 = 0.05;

/// Standard errors by which means may differ.
const ERRORS: f64 = 3.0;

/// Change of the logarithm of a mode's energy that makes another motion, standard errors by which it must
/// be beyond doubt, and the least share of the energy of a mode with a part in the motion.
const CHANGED: f64 = 0.2;
const BEYOND_DOUBT: f64 = 5.0;
const PART: f64 = 0.01;

/// The fewest blocks by which anything is told.
const FEWEST: usize = 16;

/// Energies by blocks, and the verdict on them.
#[derive(Clone, Debug)]
pub(super) struct Settling {
    modes: usize,
    /// Logarithms of the modes' mean energies, then of the whole, `blocks x (modes + 1)`.
    blocks: Vec<f64>,
    /// Sums of the block that is being filled, and its samples so far.
    sums: Vec<f64>,
    count: usize,
    /// Samples a block.
    length: usize,
}

impl Settling {
    /// For so many modes, in blocks of `length` samples.
    pub fn new(modes: usize, length: usize) -> Self {
        Self {
            modes,
            blocks: Vec::new(),
            sums: vec![0.0; modes],
            count: 0,
            length: length.max(1),
        }
    }

    /// Takes a state `[q | dq/dt | ...]`; `omega` are the circular frequencies of the modes, rad/s.
    /// Whether a block has been filled by it.
    pub fn push(&mut self, z: &[f64], omega: &[f64]) -> bool {
        let (q, rest) = z.split_at(self.modes);
        let modes = q.iter().zip(rest).zip(omega);
        for (sum, ((q, v), omega)) in self.sums.iter_mut().zip(modes) {
            *sum += v * v + (omega * q).powi(2);
        }
        self.count += 1;
        if self.count < self.length {
            return false;
        }
        let all: f64 = self.sums.iter().sum();
        let least = (FAINTEST * all).max(f64::MIN_POSITIVE);
        self.blocks
            .extend(self.sums.iter().map(|sum| sum.max(least).ln()));
        self.blocks.push(all.max(f64::MIN_POSITIVE).ln());
        self.sums.fill(0.0);
        self.count = 0;
        true
    }

    /// Whether the transient is over, by the blocks so far.
    pub fn is_over(&self) -> bool {
        let width = self.modes + 1;
        let count = self.blocks.len() / width;
        if count < FEWEST {
            return false;
        }
        let (third, last) = (count / 2..3 * count / 4, 3 * count / 4..count);
        (0..width).all(|k| {
            let (before, after) = (self.mean(k, third.clone()), self.mean(k, last.clone()));
            let error = before[1].hypot(after[1]);
            (after[0] - before[0]).abs() <= (ERRORS * error).max(STEADY)
        })
    }

    /// Whether the blocks begin in one motion and end in another.
    pub fn has_changed(&self) -> bool {
        let width = self.modes + 1;
        let count = self.blocks.len() / width;
        if count < FEWEST {
            return false;
        }
        let halves = |k| [0..count / 2, count / 2..count].map(|half| self.mean(k, half));
        let whole = halves(self.modes);
        (0..width).any(|k| {
            let [before, after] = halves(k);
            let part = |mean: [f64; 2], of: [f64; 2]| mean[0] - of[0] > PART.ln();
            let takes_part = part(before, whole[0]) || part(after, whole[1]);
            let change = (after[0] - before[0]).abs();
            takes_part && change > (BEYOND_DOUBT * before[1].hypot(after[1])).max(CHANGED)
        })
    }

    /// Mean over some blocks of the logarithm of a mode's energy, or of the whole after the last mode,
    /// and its standard error.
    fn mean(&self, mode: usize, blocks: Range<usize>) -> [f64; 2] {
        let width = self.modes + 1;
        let values: Vec<f64> = blocks
            .map(|block| self.blocks[block * width + mode])
            .collect();
        mean_with_error(&values)
    }

    /// Blocks filled so far.
    pub fn blocks(&self) -> usize {
        self.blocks.len() / (self.modes + 1)
    }
}

/// Mean and its standard error, as if values were independent; a trend in them does not count as
/// scatter.
fn mean_with_error(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let middle = 0.5 * (n - 1.0);
    let places = || (0..values.len()).map(|k| k as f64 - middle);
    let squares: f64 = places().map(|x| x * x).sum();
    let slope = places().zip(values).map(|(x, y)| x * y).sum::<f64>() / squares;
    let about = places()
        .zip(values)
        .map(|(x, y)| (y - mean - slope * x).powi(2));
    let variance = about.sum::<f64>() / (n - 2.0).max(1.0);
    [mean, (variance / n).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::test_signals::noise;

    const OMEGA: [f64; 2] = [1.0, 3.0];

    /// Blocks until the transient of two oscillators with these amplitudes over the block's number
    /// is over; `None` if it is not within 400 blocks.
    fn over_after(amplitudes: impl Fn(usize) -> [f64; 2]) -> Option<usize> {
        let mut settling = Settling::new(2, 1);
        (0..400).find(|&block| {
            let [a, b] = amplitudes(block);
            settling.push(&[a, b, 0.0, 0.0], &OMEGA) && settling.is_over()
        })
    }

    #[test]
    fn a_steady_motion_is_settled_as_soon_as_it_can_be_told() {
        assert_eq!(over_after(|_| [1.0, 0.3]), Some(FEWEST - 1));
        let noise = noise(5, 400, 0.05);
        let fluctuating = over_after(|k| [1.0 + noise[k], 0.3]);
        assert!(fluctuating.unwrap() < 40, "{fluctuating:?}");
    }

    #[test]
    fn growth_is_waited_for() {
        // Grows by e in 10 blocks until it is 1 after 100 blocks.
        let end = over_after(|k| [((k as f64 - 100.0) / 10.0).exp().min(1.0), 1e-9]).unwrap();
        assert!((150..260).contains(&end), "{end}");
    }

    #[test]
    fn a_weak_mode_that_grows_is_seen() {
        let end = over_after(|k| {
            let weak = (1e-5 * (k as f64 / 10.0).exp()).min(0.8);
            [1.0 - weak, weak]
        });
        // It takes over at about block 115.
        assert!(end.is_none_or(|end| end > 160), "{end:?}");
    }

    #[test]
    fn a_motion_that_gives_way_to_another_one_has_changed() {
        let changed = |amplitudes: &dyn Fn(usize) -> [f64; 2]| {
            let mut settling = Settling::new(2, 1);
            for block in 0..200 {
                let [a, b] = amplitudes(block);
                settling.push(&[a, b, 0.0, 0.0], &OMEGA);
            }
            settling.has_changed()
        };
        let noise = noise(5, 200, 0.3);
        let fluctuating = |k: usize| [1.0 + noise[k], 0.3];
        assert!(!changed(&fluctuating));
        assert!(changed(&|k| if k < 60 {
            fluctuating(k)
        } else {
            [0.01, 0.3]
        }));
        // What has no part in the motion may still die away.
        assert!(!changed(&|k| [
            1.0 + noise[k],
            1e-3 * (-0.1 * k as f64).exp()
        ]));
    }

    #[test]
    fn what_dies_away_is_never_settled_by_itself() {
        assert_eq!(over_after(|k| [(-0.02 * k as f64).exp(), 0.0]), None);
        assert_eq!(over_after(|_| [0.0, 0.0]), Some(FEWEST - 1));
    }
}
