//! Periods of a motion from the peaks of the recurrence rate over the offset.
//!
//! A motion of period `P` recurs after `P`, `2 P`, ... for any waveform: the recurrence rate along the
//! diagonals (the tau-recurrence rate, Marwan et al., Phys. Rep. 438, 237, 2007, section 3.7) has peaks
//! there, the stripes of the plot. Where a longer period recurs as well, they are higher.

use std::f64::consts::TAU;
use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::RecurrenceCounts;
use crate::analysis::mean;

/// Minimum number of stripes.
const MIN_STRIPES: usize = 6;
/// Minimum spacing of the stripes, diagonals.
const MIN_SPACING: f64 = 3.0;
/// Minimum mean number of recurrent points per diagonal.
const MIN_POINTS: f64 = 2.0;
/// Peaks that are tried as the first stripe. Noise has many.
const MAX_TRIED: usize = 64;
/// Minimum ratio of the recurrence rate near the multiples of the spacing to that between them.
const MIN_CONTRAST: f64 = 2.0;
/// Minimum share of the stripes that are brighter near the multiple of the spacing, and of the multiples of a
/// doubled period that are higher than their neighbours.
const MIN_REGULAR: f64 = 0.75;
/// Bins per diagonal of the mean profile of a stripe.
const BINS: f64 = 4.0;
/// Minimum modulation of the heights by a longer period, peak to peak, relative to the mean height.
const MIN_DEPTH: f64 = 0.1;
/// Minimum share of the variance of the heights that a beat and its first harmonics explain.
const MIN_EXPLAINED: f64 = 0.5;
/// Minimum number of returns after a longer period.
const MIN_RETURNS: usize = 2;
/// Minimum recurrence rate along the highest diagonals at the better half of the multiples of a longer period.
/// On a torus it is close to 1: all states return together. Chaotic motion returns only in part.
const MIN_RATE: f64 = 0.85;

/// What a recurrence period is in relation to the shorter ones of the same plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, strum::Display)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum RecurrenceKind {
    /// The finest spacing of the diagonals: the period of a periodic motion.
    Finest,
    /// A longer period in which the motion returns closer: the beat of a torus, or a subharmonic.
    Beat,
    /// Twice a shorter period of the set, or a further doubling of it.
    Doubled,
}

/// A spacing of the diagonals of a recurrence plot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecurrencePeriod {
    /// Relation to the shorter periods.
    pub kind: RecurrenceKind,
    /// The period, states (s in output).
    #[serde(rename = "period_s")]
    pub period: f64,
    /// Standard uncertainty of the period, states (s in output).
    #[serde(rename = "uncertainty_s")]
    pub uncertainty: f64,
    /// Share of the recurrent points that lie on the diagonals nearest to the multiples of the period, 0
    /// to 1. Diagonals belong to the stripe of a multiple of the finest period down to half its height.
    pub share: f64,
}

/// The set of spacings of the diagonals of a recurrence plot, shortest first.
///
/// A motion of period `P` recurs after `P`, `2 P`, ...: its plot has stripes at these offsets. A periodic
/// motion has one spacing. On a torus the stripes are widest and densest where the longer period recurs as
/// well; their heights repeat with the beat. After a period doubling every second stripe is higher. Noise
/// has none, chaos none or the finest: it returns by chance, and less with time. A doubling of less than a fifth
/// of the amplitude may be missed, and of two beats only the shorter one is found. Kang et al. (2022) read the
/// periods from the plots in this way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct RecurrencePeriods {
    /// The recurrence periods, shortest first.
    periods: Vec<RecurrencePeriod>,
}

impl RecurrencePeriods {
    /// The periods, shortest first.
    pub fn iter(&self) -> std::slice::Iter<'_, RecurrencePeriod> {
        self.periods.iter()
    }

    /// The finest spacing of the diagonals.
    pub fn finest(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Finest)
    }

    /// The beat.
    pub fn beat(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Beat)
    }

    /// The longest doubled period.
    pub fn doubled(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Doubled)
    }

    /// The longest period of a kind.
    pub fn last(&self, kind: RecurrenceKind) -> Option<&RecurrencePeriod> {
        self.periods.iter().rfind(|period| period.kind == kind)
    }

    /// Converts states to times. `state` is the time between successive states, s.
    pub fn in_seconds(mut self, state: f64) -> Self {
        for period in &mut self.periods {
            period.period *= state;
            period.uncertainty *= state;
        }
        self
    }
}

/// From periods, shortest first.
impl FromIterator<RecurrencePeriod> for RecurrencePeriods {
    fn from_iter<I: IntoIterator<Item = RecurrencePeriod>>(periods: I) -> Self {
        let periods = periods.into_iter().collect();
        Self { periods }
    }
}

impl RecurrenceCounts {
    /// Spacings of the diagonals, states.
    pub fn periods(&self) -> RecurrencePeriods {
        let offsets = self.reliable_offsets();
        let points: u64 = offsets.clone().map(|k| self.by_offset[k]).sum();
        if offsets.len() < MIN_STRIPES || (points as f64) < MIN_POINTS * offsets.len() as f64 {
            return RecurrencePeriods::default();
        }
        let mut rates: Vec<f64> = (0..offsets.end).map(|k| self.rate_at(k)).collect();
        rates[..offsets.start].fill(0.0);
        let Some(grid) = Grid::finest(&rates, offsets.start) else {
            return RecurrencePeriods::default();
        };
        let stripes = grid.stripes(self, points as f64);
        let finest = RecurrencePeriod {
            kind: RecurrenceKind::Finest,
            period: grid.spacing,
            uncertainty: grid.uncertainty,
            share: stripes.shares.iter().sum(),
        };
        let mut periods = vec![finest];
        let at = |kind, ratio, uncertainty| RecurrencePeriod {
            kind,
            period: ratio * grid.spacing,
            uncertainty: f64::hypot(ratio * grid.uncertainty, uncertainty * grid.spacing),
            share: stripes.multiples(ratio).map(|j| stripes.shares[j]).sum(),
        };
        let (mut ratio, mut uncertainty) = (1.0, 0.0);
        if !stripes.is_doubled(ratio)
            && let Some(beat) = stripes.beat()
        {
            [ratio, uncertainty] = beat;
            periods.push(at(RecurrenceKind::Beat, ratio, uncertainty));
        }
        while stripes.is_doubled(ratio) {
            ratio *= 2.0;
            uncertainty *= 2.0;
            periods.push(at(RecurrenceKind::Doubled, ratio, uncertainty));
        }
        periods.into_iter().collect()
    }
}

/// The stripes at the multiples 1, 2, ... of the finest spacing; the line of identity has index 0.
#[derive(Default)]
struct Stripes {
    /// Sum of the recurrence rates relative to that of the mean profile.
    heights: Vec<f64>,
    /// Highest recurrence rate of a diagonal.
    rates: Vec<f64>,
    /// Share of all recurrent points, between the half heights of the mean profile.
    shares: Vec<f64>,
}

impl Stripes {
    /// The stripes nearest to the multiples of `ratio` finest spacings.
    fn multiples(&self, ratio: f64) -> impl Iterator<Item = usize> + use<> {
        let count = (self.heights.len() - 1) as f64 / ratio;
        (1..=count as usize).map(move |m| (m as f64 * ratio).round() as usize)
    }

    /// Whether most states return after the multiples of `ratio` finest spacings.
    fn returns(&self, ratio: f64) -> bool {
        let mut rates: Vec<f64> = self.multiples(ratio).map(|j| self.rates[j]).collect();
        rates.sort_by(f64::total_cmp);
        // A third period lowers the rate at some of the multiples.
        rates.len() >= MIN_RETURNS && mean(&rates[rates.len() / 2..]) >= MIN_RATE
    }

    /// Whether every second multiple of `ratio` finest spacings is higher.
    fn is_doubled(&self, ratio: f64) -> bool {
        let heights: Vec<f64> = self.multiples(ratio).map(|j| self.heights[j]).collect();
        let odd: Vec<f64> = heights.iter().copied().step_by(2).collect();
        let even: Vec<f64> = heights.iter().copied().skip(1).step_by(2).collect();
        let is_higher = |&m: &usize| odd[m..].iter().take(2).all(|odd| *odd < even[m]);
        self.returns(2.0 * ratio)
            && (0..even.len()).filter(is_higher).count() as f64 >= MIN_REGULAR * even.len() as f64
            && mean(&even) - mean(&odd) >= 0.5 * MIN_DEPTH * mean(&self.heights[1..])
    }

    /// Period of the strongest modulation of the heights in finest spacings, with its uncertainty. The heights are
    /// an even function of the phase of the beat, whose largest value is that of the line of identity.
    fn beat(&self) -> Option<[f64; 2]> {
        let heights = &self.heights[1..];
        let (count, mean) = (heights.len() as f64, mean(heights));
        // Projection on a cosine and the square of the cosine.
        let project = |frequency: f64| {
            let twice = 2.0 * (TAU * frequency).cos();
            let (mut before, mut cosine) = (1.0, 0.5 * twice);
            let (mut product, mut square) = (0.0, 0.0);
            for height in heights {
                product += (height - mean) * cosine;
                square += cosine * cosine;
                (before, cosine) = (cosine, twice * cosine - before);
            }
            [product.max(0.0), square]
        };
        let explained = |frequency: f64| {
            let [product, square] = project(frequency);
            product * product / square
        };
        let best = |frequencies: Range<i32>, start: f64, step: f64| {
            let frequencies = frequencies.map(|k| start + f64::from(k) * step);
            frequencies.max_by(|a, b| explained(*a).total_cmp(&explained(*b)))
        };
        let step = 0.125 / count;
        // From one and a half cycles within the plot on.
        let near = best(12..(4.0 * count) as i32, 0.0, step)?;
        let frequency = best(-64..65, near, step / 64.0)?;
        let [product, square] = project(frequency);
        let amplitude = product / square;
        let all: f64 = heights.iter().map(|height| (height - mean).powi(2)).sum();
        let modulation: f64 = [1.0, 2.0, 3.0]
            .map(|k| explained(k * frequency))
            .iter()
            .sum();
        let is_beat = modulation >= MIN_EXPLAINED * all
            && 2.0 * amplitude >= MIN_DEPTH * mean
            && self.returns(frequency.recip());
        // Cramer-Rao bound of the frequency of a cosine of known phase.
        let residual = ((all - modulation).max(0.0) / count).sqrt();
        let uncertainty = residual * 6f64.sqrt() / (TAU * amplitude * count.powf(1.5));
        is_beat.then(|| [frequency.recip(), uncertainty / (frequency * frequency)])
    }
}

/// Division of a profile of recurrence rates among the multiples of a spacing.
struct Grid<'a> {
    rates: &'a [f64],
    spacing: f64,
    uncertainty: f64,
}

/// The part of a profile nearest to a multiple of the spacing: means within a quarter of the spacing and beyond, and
/// the part above half the maximum with its distance from the multiple.
struct Peak {
    near: f64,
    far: f64,
    mass: f64,
    distance: f64,
}

impl<'a> Grid<'a> {
    /// The grid whose spacing is one of the first peaks; the rates from the diagonal `first` on count.
    fn finest(rates: &'a [f64], first: usize) -> Option<Self> {
        let level = 0.1 * mean(rates);
        // Beyond the decay from the line of identity.
        let rise = (first + 1..rates.len()).find(|&k| rates[k] > rates[k - 1].max(level))?;
        let is_peak = |&k: &usize| {
            let nearby = &rates[k.saturating_sub(2)..(k + 3).min(rates.len())];
            rates[k] > rates[k - 1].max(level) && nearby.iter().all(|rate| *rate <= rates[k])
        };
        let grid = |k: usize| Self {
            rates,
            spacing: k as f64,
            uncertainty: 0.0,
        };
        let peaks = (rise..rates.len()).filter(is_peak).take(MAX_TRIED);
        let grids = peaks.filter_map(|k| grid(k).refined());
        grids.into_iter().find(Self::is_regular)
    }

    /// The grid with its spacing refined by the centres of more and more peaks, by least squares.
    fn refined(mut self) -> Option<Self> {
        for round in 1..=16 {
            if self.spacing < MIN_SPACING {
                return None;
            }
            let last = self.count().min(1 << round);
            let peaks: Vec<_> = (1..=last).map(|j| (j as f64, self.peak(j))).collect();
            let square: f64 = peaks.iter().map(|(j, peak)| peak.mass * j * j).sum();
            if !square.is_normal() {
                return None;
            }
            let product = peaks.iter().map(|(j, peak)| peak.mass * j * peak.distance);
            let slope = product.sum::<f64>() / square;
            // A second period shifts the centres in both directions with zero mean.
            let misfit = peaks.iter().map(|(j, peak)| {
                let weight = peak.mass * j / square;
                (weight * (peak.distance - slope * j)).powi(2)
            });
            self.uncertainty = misfit.sum::<f64>().sqrt();
            self.spacing += slope;
        }
        Some(self)
    }

    /// Whether the rate is concentrated near the multiples, at near and far offsets and at most multiples.
    fn is_regular(&self) -> bool {
        let peaks: Vec<Peak> = (1..=self.count()).map(|j| self.peak(j)).collect();
        let (first, last) = peaks.split_at(peaks.len() / 2);
        let is_concentrated = |part: &[Peak]| {
            let near: f64 = part.iter().map(|peak| peak.near).sum();
            let far: f64 = part.iter().map(|peak| peak.far).sum();
            near > 0.0 && near >= MIN_CONTRAST * far
        };
        let bright = peaks.iter().filter(|peak| peak.near > peak.far).count();
        peaks.len() >= MIN_STRIPES
            && is_concentrated(first)
            && is_concentrated(last)
            && bright as f64 >= MIN_REGULAR * peaks.len() as f64
    }

    /// Number of multiples up to a quarter of the spacing from the end.
    fn count(&self) -> usize {
        ((self.rates.len() - 1) as f64 / self.spacing - 0.25).max(0.0) as usize
    }

    /// The diagonals nearest to a multiple.
    fn cell(&self, j: usize) -> Range<usize> {
        let edge =
            |multiple: f64| ((multiple * self.spacing).ceil() as usize).min(self.rates.len());
        edge(j as f64 - 0.5)..edge(j as f64 + 0.5)
    }

    /// Distance of a diagonal from a multiple, diagonals.
    fn distance(&self, j: usize, k: usize) -> f64 {
        k as f64 - j as f64 * self.spacing
    }

    fn peak(&self, j: usize) -> Peak {
        let is_near = |k: &usize| self.distance(j, *k).abs() <= 0.25 * self.spacing;
        let (near, far): (Vec<usize>, Vec<usize>) = self.cell(j).partition(is_near);
        let mean = |inside: &[usize]| {
            let sum: f64 = inside.iter().map(|&k| self.rates[k]).sum();
            sum / inside.len().max(1) as f64
        };
        let half = 0.5 * near.iter().map(|&k| self.rates[k]).fold(0.0, f64::max);
        let above = |k: usize| (self.rates[k] - half).max(0.0);
        let mass: f64 = near.iter().map(|&k| above(k)).sum();
        let moments = near.iter().map(|&k| above(k) * self.distance(j, k));
        Peak {
            near: mean(&near),
            far: mean(&far),
            mass,
            distance: moments.sum::<f64>() / mass.max(f64::MIN_POSITIVE),
        }
    }

    /// The stripes of a plot with this number of recurrent points.
    fn stripes(&self, counts: &RecurrenceCounts, points: f64) -> Stripes {
        // The mean profile at positions between the diagonals: relative to it, the height of a narrow stripe does
        // not depend on the distance of its centre from the nearest diagonal.
        let bin = |j, k| ((self.distance(j, k) + 0.5 * self.spacing) * BINS).max(0.0) as usize;
        let mut sums = vec![[0.0; 2]; (self.spacing * BINS) as usize + 2];
        for j in 1..=self.count() {
            for k in self.cell(j) {
                let [sum, weight] = &mut sums[bin(j, k)];
                *sum += self.rates[k];
                *weight += 1.0;
            }
        }
        let profile = sums
            .iter()
            .map(|[sum, weight]| sum / f64::max(*weight, 1.0));
        let profile: Vec<f64> = profile.collect();
        let half = 0.5 * profile.iter().copied().fold(0.0, f64::max);
        let mut stripes = Stripes::default();
        for j in 0..=self.count() {
            let expected: f64 = self.cell(j).map(|k| profile[bin(j, k)]).sum();
            let sum: f64 = self.cell(j).map(|k| self.rates[k]).sum();
            let rate = self.cell(j).map(|k| self.rates[k]).fold(0.0, f64::max);
            let inside = self
                .cell(j)
                .filter(|&k| j > 0 && profile[bin(j, k)] >= half);
            let inside: u64 = inside.map(|k| counts.by_offset[k]).sum();
            let height = if expected > 0.0 { sum / expected } else { 1.0 };
            stripes.heights.push(height);
            stripes.rates.push(rate);
            stripes.shares.push(inside as f64 / points);
        }
        stripes
    }
}

#[cfg(test)]
#[path = "period_tests.rs"]
mod tests;
