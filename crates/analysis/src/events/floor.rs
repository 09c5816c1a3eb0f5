//! The noise floor of a spectrogram from order statistics.
//!
//! First, the shape of the spectrum: the median of each bin over the quiet columns, with at most four times the power of the
//! quietest twentieth, where no loud tone sounds. Stationary noise has many of them, a recording full of a squeak few. It is
//! smoothed: the greater of the medians of 8 bins on each side follows slopes, resonances and the edge of a low-pass but not
//! a line. Relative to it, the floor at a bin is the median of 24 bins on each side, in the
//! column or over 0.2 s, whichever is greater: a knock raises the floor in its own columns only. The greater side
//! counts (the greatest-of rule of radar detection: Hansen and Sawyers, IEEE Trans. Aerosp. Electron.
//! Syst. 16, 115, 1980).

use std::f64::consts::LN_2;

use rayon::prelude::*;

use super::baseband::LOUDEST_S;
use super::spectrogram::{LEAST_BIN, LOBE};
use crate::stats::{median, order_statistic};

/// Bins in a block; blocks start a third of this apart.
const BLOCK: usize = 24;

/// A squeak leaves one column in so many quiet.
const QUIET_PART: usize = 20;

/// Noise power of each bin in each column.
pub(super) struct Floor {
    shape: Vec<f64>,
    /// Floor relative to the shape of each block in each column.
    blocks: Vec<Vec<f64>>,
}

impl Floor {
    /// The floor of columns of powers at a distance of `step_s`.
    pub fn new(powers: &[Vec<f64>], step_s: f64) -> Self {
        let shape = shape(powers);
        let blocks = powers.par_iter().map(|column| blocks(column, &shape));
        let blocks: Vec<Vec<f64>> = blocks.collect();
        let half = (LOUDEST_S / step_s).round().max(1.0) as usize;
        let floors = |(t, column): (usize, &Vec<f64>)| {
            let around = &blocks[t.saturating_sub(half)..(t + half + 1).min(blocks.len())];
            let floor = |(j, block): (usize, &f64)| block.max(median(around.iter().map(|b| b[j])));
            column.iter().enumerate().map(floor).collect()
        };
        Self {
            blocks: blocks.par_iter().enumerate().map(floors).collect(),
            shape,
        }
    }

    /// Noise power of bin `k` in column `t`.
    pub fn at(&self, t: usize, k: usize) -> f64 {
        let blocks = &self.blocks[t];
        let last = blocks.len() - 1;
        let below = k.saturating_sub(LOBE + BLOCK) / (BLOCK / 3);
        let above = (k + LOBE + 1).div_ceil(BLOCK / 3);
        self.shape[k] * blocks[below].max(blocks[above.min(last)])
    }
}

/// The shape of the spectrum.
fn shape(powers: &[Vec<f64>]) -> Vec<f64> {
    let power = |column: &Vec<f64>| column[LEAST_BIN.min(column.len())..].iter().sum::<f64>();
    // Digital silence has no spectrum: what is above a constant is rounding.
    let sounds =
        |(power, column): &(f64, &Vec<f64>)| *power > f64::EPSILON * column.iter().sum::<f64>();
    let columns = powers.iter().map(|column| (power(column), column));
    let columns: Vec<(f64, &Vec<f64>)> = columns.filter(sounds).collect();
    let all = columns.iter().map(|c| c.0).collect();
    let most = 4.0 * order_statistic(all, columns.len().div_ceil(QUIET_PART));
    let quiet = columns.iter().filter(|c| c.0 <= most).map(|c| c.1);
    let quiet: Vec<&Vec<f64>> = quiet.collect();
    let bins = powers[0].len();
    let median_of = |k: usize| median(quiet.iter().map(|column| column[k]));
    let medians: Vec<f64> = (0..bins).map(median_of).collect();
    let side = |near: &[f64]| median(near.iter().copied());
    let smooth = |k: usize| {
        let below = side(&medians[k.saturating_sub(BLOCK / 3)..k]);
        let above = side(&medians[k + 1..(k + 1 + BLOCK / 3).min(bins)]);
        below.max(above).max(f64::MIN_POSITIVE)
    };
    (0..bins).map(smooth).collect()
}

/// Noise power of a column relative to the shape, from the median of each block of bins.
fn blocks(power: &[f64], shape: &[f64]) -> Vec<f64> {
    let relative: Vec<f64> = power.iter().zip(shape).map(|(p, s)| p / s).collect();
    let starts = (0..=relative.len().saturating_sub(BLOCK)).step_by(BLOCK / 3);
    let block = |start: usize| relative[start..].iter().take(BLOCK).copied();
    starts.map(|start| median(block(start)) / LN_2).collect()
}
