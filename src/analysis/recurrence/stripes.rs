//! Stripes of a recurrence plot: the diagonals around the multiples of their finest spacing.
//!
//! A motion of period `P` recurs after `P`, `2 P`, ... for any waveform: the recurrence rate along the
//! diagonals (the tau-recurrence rate, Marwan et al., Phys. Rep. 438, 237, 2007, section 3.7) has peaks
//! there.

use std::ops::Range;

use realfft::RealFftPlanner;

use super::RecurrenceCounts;

/// Bins per diagonal of the mean profile of a stripe.
const BINS: f64 = 4.0;
/// Minimum number of stripes.
const MIN_STRIPES: usize = 6;
/// Minimum spacing, diagonals.
const MIN_SPACING: f64 = 3.0;
/// Minimum mean number of recurrent points per diagonal.
const MIN_POINTS: f64 = 2.0;
/// Number of spacings tried.
const CANDIDATES: usize = 4;
/// Iterations of the refinement of a spacing.
const REFINEMENTS: usize = 6;
/// Minimum share of the stripes that are brighter near the multiple of the spacing.
const MIN_REGULAR: f64 = 0.75;
/// Minimum ratio of the recurrence rate near the multiples of the spacing to that between them.
const MIN_CONTRAST: f64 = 2.0;

/// The stripes at the multiples of the finest spacing.
#[derive(Clone, Debug)]
pub struct Stripes {
    /// Finest spacing, states.
    pub spacing: f64,
    /// Standard uncertainty of the spacing, states.
    pub uncertainty: f64,
    /// Height of the stripe at the multiple 1, 2, ..., relative to the mean profile of all stripes.
    pub heights: Vec<f64>,
    /// Highest recurrence rate of a diagonal of the stripe.
    pub peaks: Vec<f64>,
    /// Share of all recurrent points that lies in the same stripe, between its half heights.
    pub shares: Vec<f64>,
}

impl Stripes {
    /// The stripes of a plot; `None` without a regular spacing.
    ///
    /// The spacing is that of the strongest cosine in the recurrence rate over the offset, refined by the
    /// centres of all stripes. Within a quarter of the spacing of its multiples the rate must be at least
    /// twice that between them, in the nearer and in the farther half of the plot.
    pub fn of(counts: &RecurrenceCounts) -> Option<Self> {
        let offsets = counts.reliable_offsets();
        let points: u64 = offsets.clone().map(|k| counts.by_offset[k]).sum();
        if offsets.len() < MIN_STRIPES || (points as f64) < MIN_POINTS * offsets.len() as f64 {
            return None;
        }
        let rates: Vec<f64> = (0..offsets.end).map(|k| counts.rate_at(k)).collect();
        let candidates = strong_spacings(&rates, offsets.start);
        let grids = candidates.into_iter().filter_map(|spacing| {
            let offsets = offsets.clone();
            Grid { spacing, offsets }.refined(&rates)
        });
        let (grid, uncertainty) = grids
            .into_iter()
            .find(|(grid, _)| grid.is_regular(&rates))?;
        let profile = grid.profile(counts, &rates);
        let half = 0.5 * profile.iter().copied().fold(0.0, f64::max);
        // Relative to the profile at positions between the diagonals, the height of a narrow stripe does not
        // depend on the distance of its centre from the nearest diagonal.
        let height = |j: usize| {
            let shape = |k: usize| profile[grid.bin(j, k)];
            let sum: f64 = grid.cell(j).map(|k| rates[k]).sum();
            let expected: f64 = grid.cell(j).map(shape).sum();
            if expected > 0.0 { sum / expected } else { 1.0 }
        };
        let share = |j: usize| {
            let inside = grid.cell(j).filter(|&k| profile[grid.bin(j, k)] >= half);
            inside.map(|k| counts.by_offset[k]).sum::<u64>() as f64 / points as f64
        };
        Some(Self {
            spacing: grid.spacing,
            uncertainty,
            heights: (1..=grid.count()).map(height).collect(),
            peaks: (1..=grid.count())
                .map(|j| grid.cell(j).map(|k| rates[k]).fold(0.0, f64::max))
                .collect(),
            shares: (1..=grid.count()).map(share).collect(),
        })
    }
}

/// Spacings of the strongest cosines in the rates from the diagonal `first` on, strongest first. Their
/// maxima are at the multiples of the spacing: the phase is that of a return.
fn strong_spacings(rates: &[f64], first: usize) -> Vec<f64> {
    let counted = &rates[first..];
    let weight = |i: usize| 1.0 - 0.9 * i as f64 / counted.len() as f64;
    let weights: f64 = (0..counted.len()).map(weight).sum();
    let weighted = counted.iter().enumerate().map(|(i, rate)| weight(i) * rate);
    let mean = weighted.sum::<f64>() / weights;
    let size = (8 * rates.len()).next_power_of_two();
    let mut padded = vec![0.0; size];
    for (i, rate) in counted.iter().enumerate() {
        padded[first + i] = weight(i) * (rate - mean);
    }
    let fft = RealFftPlanner::new().plan_fft_forward(size);
    let mut spectrum = fft.make_output_vec();
    if fft.process(&mut padded, &mut spectrum).is_err() {
        return Vec::new();
    }
    let spacing = |bin: usize| size as f64 / bin as f64;
    let inside = |bin: &usize| {
        spacing(*bin) >= MIN_SPACING && spacing(*bin) * MIN_STRIPES as f64 <= rates.len() as f64
    };
    let top = |bin: &usize| {
        let [before, here, after] = [bin - 1, *bin, bin + 1].map(|bin| spectrum[bin].re);
        here > 0.0 && before < here && here >= after
    };
    let bins = (1..spectrum.len() - 1).filter(inside).filter(top);
    let mut bins: Vec<usize> = bins.collect();
    bins.sort_by(|&a, &b| spectrum[b].re.total_cmp(&spectrum[a].re));
    bins.truncate(CANDIDATES);
    bins.into_iter().map(spacing).collect()
}

/// Division of the diagonals among the multiples of a spacing.
struct Grid {
    spacing: f64,
    /// Diagonals considered.
    offsets: Range<usize>,
}

impl Grid {
    /// The grid with its spacing refined by the centres of the stripes, and the uncertainty of the spacing.
    fn refined(mut self, rates: &[f64]) -> Option<(Self, f64)> {
        let mut uncertainty = 0.0;
        for _ in 0..REFINEMENTS {
            let (correction, deviation) = self.correction(rates)?;
            self.spacing += correction;
            uncertainty = deviation;
        }
        Some((self, uncertainty))
    }

    /// Whether the rate is concentrated near the multiples, at near and far offsets and at most multiples.
    fn is_regular(&self, rates: &[f64]) -> bool {
        let count = self.count();
        let contrast = |part: Range<usize>| self.contrast(rates, part);
        let bright = (1..=count).filter(|&j| contrast(j..j + 1) > 1.0).count();
        count >= MIN_STRIPES
            && [1..count / 2 + 1, count / 2 + 1..count + 1]
                .into_iter()
                .all(|part| contrast(part) >= MIN_CONTRAST)
            && bright as f64 >= MIN_REGULAR * count as f64
    }

    /// Number of multiples whose diagonals are all considered at the far end.
    fn count(&self) -> usize {
        (self.offsets.end as f64 / self.spacing - 0.5) as usize
    }

    /// The diagonals nearest to a multiple.
    fn cell(&self, j: usize) -> Range<usize> {
        let edge = |multiple: f64| (multiple * self.spacing).ceil().max(0.0) as usize;
        let start = edge(j as f64 - 0.5).max(self.offsets.start);
        start..edge(j as f64 + 0.5).min(self.offsets.end).max(start)
    }

    /// Distance of a diagonal from a multiple, diagonals.
    fn distance(&self, j: usize, k: usize) -> f64 {
        k as f64 - j as f64 * self.spacing
    }

    fn bin(&self, j: usize, k: usize) -> usize {
        ((self.distance(j, k) + 0.5 * self.spacing) * BINS).max(0.0) as usize
    }

    /// Mean rate over the distance from the nearest multiple, in bins.
    fn profile(&self, counts: &RecurrenceCounts, rates: &[f64]) -> Vec<f64> {
        let bins = (self.spacing * BINS) as usize + 2;
        let (mut profile, mut weights) = (vec![0.0; bins], vec![0.0; bins]);
        for j in 1..=self.count() {
            for k in self.cell(j) {
                let pairs = counts.rows.min(counts.columns - k) as f64;
                profile[self.bin(j, k)] += pairs * rates[k];
                weights[self.bin(j, k)] += pairs;
            }
        }
        let means = profile.iter().zip(&weights);
        means
            .map(|(sum, &weight)| sum / f64::max(weight, 1.0))
            .collect()
    }

    /// Ratio of the mean rate within a quarter of the spacing of the given multiples to that between them; 0
    /// without recurrences.
    fn contrast(&self, rates: &[f64], multiples: Range<usize>) -> f64 {
        let (mut near, mut far) = ([0.0; 2], [0.0; 2]);
        for j in multiples {
            for k in self.cell(j) {
                let close = self.distance(j, k).abs() <= 0.25 * self.spacing;
                let sums = if close { &mut near } else { &mut far };
                sums[0] += rates[k];
                sums[1] += 1.0;
            }
        }
        let [near, far] = [near, far].map(|[sum, count]| sum / f64::max(count, 1.0));
        if near > 0.0 { near / far } else { 0.0 }
    }

    /// Least-squares correction of the spacing by the centres of the stripes, and its standard uncertainty.
    /// A second period shifts the centres in both directions with zero mean.
    fn correction(&self, rates: &[f64]) -> Option<(f64, f64)> {
        let centres: Vec<[f64; 3]> = (1..=self.count())
            .map(|j| {
                let near = |k: &usize| self.distance(j, *k).abs() <= 0.25 * self.spacing;
                let inside = || self.cell(j).filter(near);
                let half = 0.5 * inside().map(|k| rates[k]).fold(0.0, f64::max);
                let above = |k: usize| (rates[k] - half).max(0.0);
                let mass: f64 = inside().map(above).sum();
                let moment: f64 = inside().map(|k| above(k) * self.distance(j, k)).sum();
                [j as f64, mass, if mass > 0.0 { moment / mass } else { 0.0 }]
            })
            .collect();
        let square: f64 = centres.iter().map(|[j, mass, _]| mass * j * j).sum();
        let product: f64 = centres.iter().map(|[j, mass, x]| mass * j * x).sum();
        let slope = product / square;
        let misfit = centres.iter().map(|[j, mass, x]| {
            let weight = mass * j / square;
            (weight * (x - slope * j)).powi(2)
        });
        square
            .is_normal()
            .then(|| (slope, misfit.sum::<f64>().sqrt()))
    }
}
