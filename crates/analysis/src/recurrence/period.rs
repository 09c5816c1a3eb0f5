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
use crate::stats::mean;

/// Minimum number of stripes.
const MIN_STRIPES: usize = 6;
/// Minimum spacing of the stripes, diagonals.
const MIN_SPACING: f64 = 3.0;
/// Peaks that are tried as the first stripe. Noise has many.
const MAX_TRIED: usize = 64;
/// Minimum concentration of the recurrence rate near the multiples of the spacing: its mean cosine with this period.
const MIN_CONCENTRATION: f64 = 0.3;
/// Minimum share of the stripes that are brighter near the multiple of the spacing, and of the multiples of a
/// doubled period that are higher than their neighbours.
const MIN_REGULAR: f64 = 0.75;
/// Bins per diagonal of the mean stripe.
const BINS: f64 = 4.0;
/// Minimum modulation of the heights by a longer period, peak to peak, relative to the mean height.
const MIN_DEPTH: f64 = 0.1;
/// Minimum share of the variance of the heights that the cosine of a beat explains.
const MIN_EXPLAINED: f64 = 0.5;
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
pub struct RecurrencePeriods(pub Vec<RecurrencePeriod>);

impl RecurrencePeriods {
    /// The longest period of a kind.
    pub fn last(&self, kind: RecurrenceKind) -> Option<&RecurrencePeriod> {
        self.0.iter().rfind(|period| period.kind == kind)
    }

    /// Converts states to times. `state` is the time between successive states, s.
    pub fn in_seconds(mut self, state: f64) -> Self {
        for period in &mut self.0 {
            period.period *= state;
            period.uncertainty *= state;
        }
        self
    }
}

impl RecurrenceCounts {
    /// Spacings of the diagonals, states.
    pub fn periods(&self) -> RecurrencePeriods {
        let offsets = self.reliable_offsets();
        let rates: Vec<f64> = (0..offsets.end).map(|k| self.rate_at(k)).collect();
        let mut periods = RecurrencePeriods::default();
        let Some(([spacing, error], stripes)) = finest(&rates, offsets.start) else {
            return periods;
        };
        let points: u64 = self.by_offset[offsets].iter().sum();
        let mut add = |kind, [ratio, uncertainty]: [f64; 2]| {
            let inside = multiples(&stripes, ratio).flat_map(|stripe| {
                let is_inside = |k: &usize| rates[*k] >= 0.5 * stripe.rate;
                stripe
                    .cell
                    .clone()
                    .filter(is_inside)
                    .map(|k| self.by_offset[k])
            });
            periods.0.push(RecurrencePeriod {
                kind,
                period: ratio * spacing,
                uncertainty: f64::hypot(ratio * error, uncertainty * spacing),
                share: inside.sum::<u64>() as f64 / points as f64,
            });
        };
        let mut longest = [1.0, 0.0];
        add(RecurrenceKind::Finest, longest);
        if !is_doubled(&stripes, 1.0)
            && let Some(beat) = beat(&stripes)
        {
            longest = beat;
            add(RecurrenceKind::Beat, longest);
        }
        while is_doubled(&stripes, longest[0]) {
            longest = longest.map(|x| 2.0 * x);
            add(RecurrenceKind::Doubled, longest);
        }
        periods
    }
}

/// The diagonals nearest to a multiple of the finest spacing.
struct Stripe {
    cell: Range<usize>,
    /// Projection of the rates on the cosine of the spacing.
    cosine: f64,
    /// Sum of the rates above half the maximum within a quarter of the spacing, and its moment about the multiple.
    mass: f64,
    moment: f64,
    /// Sum and maximum of the rates.
    height: f64,
    rate: f64,
}

/// The stripes of a profile of recurrence rates at the multiples 1, 2, ... of a spacing, up to a quarter of it from
/// the end of the profile, and up to a number of them.
fn stripes(rates: &[f64], spacing: f64, most: usize) -> Vec<Stripe> {
    let count = ((rates.len() - 1) as f64 / spacing - 0.25).max(0.0) as usize;
    let edge = |multiple: f64| ((multiple * spacing).ceil() as usize).min(rates.len());
    let stripe = |j: usize| {
        let cell = edge(j as f64 - 0.5)..edge(j as f64 + 0.5);
        let distance = |k: usize| k as f64 - j as f64 * spacing;
        let near = || {
            cell.clone()
                .filter(|&k| distance(k).abs() <= 0.25 * spacing)
        };
        let half = 0.5 * near().map(|k| rates[k]).fold(0.0, f64::max);
        let above = |k: usize| (rates[k] - half).max(0.0);
        let sum =
            |weight: &dyn Fn(usize) -> f64| cell.clone().map(|k| weight(k) * rates[k]).sum::<f64>();
        Stripe {
            cosine: sum(&|k| (TAU * k as f64 / spacing).cos()),
            mass: near().map(above).sum(),
            moment: near().map(|k| above(k) * distance(k)).sum(),
            height: sum(&|_| 1.0),
            rate: rates[cell.clone()].iter().copied().fold(0.0, f64::max),
            cell,
        }
    };
    (1..=count.min(most)).map(stripe).collect()
}

/// The spacing of the stripes with its uncertainty, and the stripes: the spacing is one of the first peaks. The rates
/// from the diagonal `first` on count.
fn finest(rates: &[f64], first: usize) -> Option<([f64; 2], Vec<Stripe>)> {
    let level = 0.1 * mean(rates);
    let is_peak = |&k: &usize| rates[k] > rates[k - 1].max(level) && rates[k] >= rates[k + 1];
    let peaks = (first + 1..rates.len().max(1) - 1)
        .filter(is_peak)
        .take(MAX_TRIED);
    let mut found = peaks.filter_map(|k| {
        // More and more stripes refine the spacing.
        let mut spacing = [k as f64, 0.0];
        for round in 1..=16 {
            if spacing[0] < MIN_SPACING {
                return None;
            }
            spacing = refined(spacing[0], &stripes(rates, spacing[0], 1 << round));
        }
        Some((spacing, stripes(rates, spacing[0], usize::MAX)))
    });
    let (spacing, mut stripes) = found.find(|(_, stripes)| is_regular(stripes))?;
    relate(rates, spacing[0], &mut stripes);
    Some((spacing, stripes))
}

/// The spacing with its uncertainty from the centres of stripes, by least squares.
fn refined(spacing: f64, stripes: &[Stripe]) -> [f64; 2] {
    let stripes = || (1..).map(f64::from).zip(stripes);
    let square: f64 = stripes().map(|(j, stripe)| j * j * stripe.mass).sum();
    let slope = stripes().map(|(j, stripe)| j * stripe.moment).sum::<f64>() / square;
    // A second period shifts the centres in both directions with zero mean.
    let misfit =
        stripes().map(|(j, stripe)| (j * (stripe.moment - slope * j * stripe.mass)).powi(2));
    [spacing + slope, misfit.sum::<f64>().sqrt() / square]
}

/// Whether the rate is concentrated near the multiples, at near and far offsets and at most multiples.
fn is_regular(stripes: &[Stripe]) -> bool {
    let is_concentrated = |part: &[Stripe]| {
        let cosine: f64 = part.iter().map(|stripe| stripe.cosine).sum();
        cosine >= MIN_CONCENTRATION * part.iter().map(|stripe| stripe.height).sum::<f64>()
    };
    let bright = stripes.iter().filter(|stripe| stripe.cosine > 0.0).count();
    let (near, far) = stripes.split_at(stripes.len() / 2);
    stripes.len() >= MIN_STRIPES
        && bright as f64 >= MIN_REGULAR * stripes.len() as f64
        && is_concentrated(near)
        && is_concentrated(far)
}

/// Divides the heights by that of the mean stripe, at positions between the diagonals: the height of a narrow stripe
/// then does not depend on the distance of its centre from the nearest diagonal.
fn relate(rates: &[f64], spacing: f64, stripes: &mut [Stripe]) {
    let bin = |k: usize| (BINS * (k as f64 + 0.5 * spacing).rem_euclid(spacing)) as usize;
    let mut mean = vec![[0.0; 2]; (BINS * spacing) as usize + 1];
    for k in stripes.iter().flat_map(|stripe| stripe.cell.clone()) {
        let [sum, weight] = &mut mean[bin(k)];
        *sum += rates[k];
        *weight += 1.0;
    }
    for stripe in stripes {
        let expected = stripe
            .cell
            .clone()
            .map(|k| mean[bin(k)])
            .map(|[sum, weight]| sum / weight);
        stripe.height /= expected.sum::<f64>();
    }
}

/// The stripes nearest to the multiples of `ratio` finest spacings.
fn multiples(stripes: &[Stripe], ratio: f64) -> impl Iterator<Item = &Stripe> {
    let count = (stripes.len() as f64 / ratio) as usize;
    (1..=count).map(move |m| &stripes[(m as f64 * ratio).round() as usize - 1])
}

/// Whether most states return after the multiples of `ratio` finest spacings.
fn returns(stripes: &[Stripe], ratio: f64) -> bool {
    let mut rates: Vec<f64> = multiples(stripes, ratio)
        .map(|stripe| stripe.rate)
        .collect();
    rates.sort_by(f64::total_cmp);
    // A third period lowers the rate at some of the multiples.
    rates.len() >= 2 && mean(&rates[rates.len() / 2..]) >= MIN_RATE
}

/// Whether every second multiple of `ratio` finest spacings is higher.
fn is_doubled(stripes: &[Stripe], ratio: f64) -> bool {
    let all: Vec<f64> = stripes.iter().map(|stripe| stripe.height).collect();
    let heights = multiples(stripes, ratio).map(|stripe| stripe.height);
    let (mut odd, mut even) = (Vec::new(), Vec::new());
    for (m, height) in heights.enumerate() {
        let half = if m % 2 == 0 { &mut odd } else { &mut even };
        half.push(height);
    }
    let is_higher = |&m: &usize| odd[m..].iter().take(2).all(|odd| *odd < even[m]);
    returns(stripes, 2.0 * ratio)
        && (0..even.len()).filter(is_higher).count() as f64 >= MIN_REGULAR * even.len() as f64
        && mean(&even) - mean(&odd) >= 0.5 * MIN_DEPTH * mean(&all)
}

/// Period of the strongest modulation of the heights in finest spacings, with its uncertainty. The heights are
/// an even function of the phase of the beat, whose largest value is that of the line of identity.
fn beat(stripes: &[Stripe]) -> Option<[f64; 2]> {
    let heights: Vec<f64> = stripes.iter().map(|stripe| stripe.height).collect();
    let (count, mean) = (heights.len() as f64, mean(&heights));
    // Amplitude of a cosine, and part of the variance that it explains.
    let fit = |frequency: f64| {
        let (mut product, mut square) = (0.0, 0.0);
        for (j, height) in (1..).zip(&heights) {
            let cosine = (TAU * frequency * f64::from(j)).cos();
            product += (height - mean) * cosine;
            square += cosine * cosine;
        }
        [product / square, product.max(0.0).powi(2) / square]
    };
    let best = |frequencies: Range<i32>, start: f64, step: f64| {
        let frequencies = frequencies.map(|k| start + f64::from(k) * step);
        frequencies.max_by(|a, b| fit(*a)[1].total_cmp(&fit(*b)[1]))
    };
    // From one and a half cycles within the plot on.
    let step = 0.125 / count;
    let near = best(12..(4.0 * count) as i32, 0.0, step)?;
    let frequency = best(-64..65, near, step / 64.0)?;
    let [amplitude, explained] = fit(frequency);
    let all: f64 = heights.iter().map(|height| (height - mean).powi(2)).sum();
    let is_beat = explained >= MIN_EXPLAINED * all
        && 2.0 * amplitude >= MIN_DEPTH * mean
        && returns(stripes, frequency.recip());
    // Cramer-Rao bound of the frequency of a cosine of known phase.
    let residual = ((all - explained).max(0.0) / count).sqrt();
    let uncertainty = residual * 6f64.sqrt() / (TAU * amplitude * count.powf(1.5));
    is_beat.then(|| [frequency.recip(), uncertainty / (frequency * frequency)])
}

#[cfg(test)]
#[path = "period_tests.rs"]
mod tests;
