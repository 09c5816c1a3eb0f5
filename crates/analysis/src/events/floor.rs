//! The noise floor of a spectrogram from order statistics.
//!
//! First, the shape of the spectrum: the median of each bin over the quietest fifth of the columns, smoothed: the greater of the medians of 8 bins on each
//! side, which follows slopes, resonances and the edge of a low-pass but not a line. Relative to it, the floor at a bin
//! is the median of 24 bins on each side; the greater of the two counts (the greatest-of rule of radar
//! detection: Hansen and Sawyers, IEEE Trans. Aerosp. Electron. Syst. 16, 115, 1980). Each median is the greater of that
//! in the column and the median of it over 0.2 s, so that a knock raises the floor in its own columns only.

use std::f64::consts::LN_2;

use rayon::prelude::*;

use super::baseband::median;
use super::spectrogram::LOBE;

/// Bins in a block, and distance between the starts of blocks.
const BLOCK: usize = 24;
const STRIDE: usize = 8;

/// Half of the time over which the floor is compared, s.
const HALF_FLOOR_S: f64 = 0.1;

/// Part of the columns, the quietest ones, from which the shape of the spectrum is determined, and about how many of
/// them: where no loud tone sounds. The level of the floor is that of each column.
const QUIET_PART: usize = 5;
const SHAPE_COLUMNS: usize = 48;

/// Bins on each side from which the shape is smoothed, and rank of the quantile among them.
const SHAPE_BINS: usize = 8;
const SHAPE_RANK: usize = 3;

/// Smallest power relative to the mean power of all bins that is not rounding.
const ROUNDING: f64 = 1e-22;

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
        let medians: Vec<Vec<f64>> = powers
            .par_iter()
            .map(|column| block_medians(column, &shape))
            .collect();
        let half = (HALF_FLOOR_S / step_s).round().max(1.0) as usize;
        let blocks = |t: usize| {
            let around = &medians[t.saturating_sub(half)..(t + half + 1).min(medians.len())];
            floors(&medians[t], around)
        };
        Self {
            blocks: (0..medians.len()).into_par_iter().map(blocks).collect(),
            shape,
        }
    }

    /// Noise power of bin `k` in column `t`.
    pub fn at(&self, t: usize, k: usize) -> f64 {
        let blocks = &self.blocks[t];
        let last = blocks.len() - 1;
        let below = k.saturating_sub(LOBE + BLOCK) / STRIDE;
        let above = (k + LOBE + 1).div_ceil(STRIDE);
        self.shape[k.min(self.shape.len() - 1)]
            * blocks[below.min(last)].max(blocks[above.min(last)])
    }

    /// Smallest number of bins of a column.
    pub const LEAST_BINS: usize = 2 * BLOCK;
}

/// The shape of the spectrum.
fn shape(powers: &[Vec<f64>]) -> Vec<f64> {
    let mut quietest: Vec<(f64, &Vec<f64>)> = powers
        .iter()
        .map(|column| (column.iter().sum(), column))
        .collect();
    // Digital silence has no spectrum.
    if quietest.iter().any(|(power, _)| *power > 0.0) {
        quietest.retain(|(power, _)| *power > 0.0);
    }
    quietest.sort_by(|a, b| a.0.total_cmp(&b.0));
    quietest.truncate((powers.len() / QUIET_PART).max(SHAPE_COLUMNS.min(powers.len())));
    let step = quietest.len().div_ceil(SHAPE_COLUMNS).max(1);
    let columns: Vec<&Vec<f64>> = quietest
        .into_iter()
        .step_by(step)
        .map(|(_, column)| column)
        .collect();
    let bins = powers[0].len();
    let median_of = |k: usize| median(columns.iter().map(|column| column[k]));
    let medians: Vec<f64> = (0..bins).map(median_of).collect();
    let least = ROUNDING * medians.iter().sum::<f64>() + f64::MIN_POSITIVE;
    let side = |near: &[f64]| {
        let mut sorted = [f64::INFINITY; SHAPE_BINS];
        sorted[..near.len()].copy_from_slice(near);
        let rank = SHAPE_RANK * near.len() / SHAPE_BINS;
        if near.is_empty() {
            0.0
        } else {
            *sorted.select_nth_unstable_by(rank, f64::total_cmp).1
        }
    };
    let smooth = |k: usize| {
        let below = side(&medians[k.saturating_sub(SHAPE_BINS)..k]);
        let above = side(&medians[k + 1..(k + 1 + SHAPE_BINS).min(bins)]);
        below.max(above).max(least)
    };
    (0..bins).map(smooth).collect()
}

/// Noise power relative to the shape from the median of each block of bins.
fn block_medians(power: &[f64], shape: &[f64]) -> Vec<f64> {
    let relative: Vec<f64> = power.iter().zip(shape).map(|(p, s)| p / s).collect();
    let starts = (0..=relative.len() - BLOCK).step_by(STRIDE);
    starts
        .map(|start| median(relative[start..start + BLOCK].iter().copied()) / LN_2)
        .collect()
}

/// The floor of each block: that of the column, at least the median over the columns around.
fn floors(own: &[f64], around: &[Vec<f64>]) -> Vec<f64> {
    let floor = |j: usize| own[j].max(median(around.iter().map(|column| column[j])));
    (0..own.len()).map(floor).collect()
}
