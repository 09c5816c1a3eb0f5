//! How many samples a second, and when the first one was taken.

use std::cmp::Ordering;

use super::Problem;

/// What a file says of the times of its samples.
#[derive(Clone, Debug, PartialEq)]
pub enum Clock {
    /// Nothing.
    Unknown,
    /// Samples a second, Hz; the first at 0 s.
    Rate(f64),
    /// The time of each.
    Times {
        /// Times, s.
        times: Vec<f64>,
        /// By how much a time may be off because of the digits it was written with, s.
        resolution: f64,
    },
}

/// A sample may be this much of a spacing off its place, besides what the digits make.
const TOLERANCE: f64 = 1e-3;

/// The digits excuse at most this much of a spacing: a sample that is missing shows as more.
const COARSEST: f64 = 0.2;

/// A rate asked for is that of the file if it differs by no more than this share.
const SAME_RATE: f64 = 1e-6;

impl Clock {
    /// Samples a second (Hz) and the time of the first sample (s); `asked` is the rate the user
    /// gives.
    pub(super) fn rate_and_start(&self, asked: Option<f64>) -> Result<(f64, f64), Problem> {
        if let Some(rate) = asked {
            possible(rate)?;
        }
        let (own, start, uncertainty) = match self {
            Self::Unknown => return Ok((asked.ok_or(Problem::NoRate)?, 0.0)),
            Self::Rate(rate) => (possible(*rate)?, 0.0, 0.0),
            Self::Times { times, resolution } => uniform(times, *resolution)?,
        };
        match asked {
            Some(asked) if (asked / own - 1.0).abs() > SAME_RATE.max(uncertainty) => {
                Err(Problem::OtherRate { asked, own })
            }
            _ => Ok((own, start)),
        }
    }
}

/// Rates that can be, Hz: beyond any instrument, and yet times and frequencies can be drawn in
/// single precision.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e15;

fn possible(rate: f64) -> Result<f64, Problem> {
    if RATES.contains(&rate) {
        Ok(rate)
    } else {
        Err(Problem::BadRate(rate))
    }
}

/// Rate, start and the relative uncertainty of the rate of evenly spaced times.
///
/// The spacing is that of the first and the last; every other time must lie on the line between
/// them. Where the digits leave room for it, the rate is a whole number of Hz: 44100, not
/// 44099.9999.
pub(super) fn uniform(times: &[f64], resolution: f64) -> Result<(f64, f64, f64), Problem> {
    let &[first, .., last] = times else {
        return Err(Problem::NoRate);
    };
    let steps = (times.len() - 1) as f64;
    let spacing = (last - first) / steps;
    let stalls = |pair: &[f64]| pair[0].partial_cmp(&pair[1]) != Some(Ordering::Less);
    if let Some(before) = times.windows(2).position(stalls) {
        return Err(Problem::NotRising {
            index: before + 1,
            time: times[before + 1],
            before: times[before],
        });
    }
    let resolution = resolution.min(COARSEST * spacing);
    let tolerance = TOLERANCE + resolution / spacing;
    for (index, &time) in times.iter().enumerate() {
        let off = ((time - first) / spacing - index as f64).abs();
        if off > tolerance {
            return Err(Problem::NotUniform { index, time, off });
        }
    }
    let rounding = f64::EPSILON * first.abs().max(last.abs());
    let uncertainty = (resolution + rounding) / (last - first);
    let rate = 1.0 / spacing;
    let whole = rate.round();
    let is_whole = whole > 0.0 && (rate / whole - 1.0).abs() <= uncertainty;
    Ok((if is_whole { whole } else { rate }, first, uncertainty))
}
