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

/// What a source says of the times of its samples.
pub(super) enum Timing {
    /// Nothing.
    Unknown,
    /// Samples a second, Hz; the first at 0 s.
    Rate(f64),
    /// The time of each, which the source gives one by one.
    Times {
        /// How many.
        count: usize,
        /// By how much a time may be off because of the digits it was written with, s.
        resolution: f64,
        /// The same over the largest time.
        relative: f64,
    },
    /// Times that were gone through already.
    Uniform(Uniform),
}

/// Evenly spaced times.
#[derive(Clone, Copy)]
pub(super) struct Uniform {
    /// Samples a second, Hz.
    pub rate: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// Relative uncertainty of the rate.
    pub uncertainty: f64,
}

/// Calls a function for each time, s, from the first; may be asked to do so again.
pub(super) type EachTime<'a> = dyn FnMut(&mut dyn FnMut(f64)) -> Result<(), Problem> + 'a;

/// A sample may be this much of a spacing off its place, besides what the digits make.
const TOLERANCE: f64 = 1e-3;

/// The digits excuse at most this much of a spacing: a sample that is missing shows as more.
const COARSEST: f64 = 0.2;

/// A rate asked for is that of the file if it differs by no more than this share.
const SAME_RATE: f64 = 1e-6;

impl Timing {
    /// Samples a second (Hz) and the time of the first sample (s); `asked` is the rate the user
    /// gives.
    pub fn rate_and_start(
        self,
        asked: Option<f64>,
        times: &mut EachTime<'_>,
    ) -> Result<(f64, f64), Problem> {
        if let Some(rate) = asked {
            possible(rate)?;
        }
        let own = match self {
            Self::Unknown => return Ok((asked.ok_or(Problem::NoRate)?, 0.0)),
            Self::Rate(rate) => Uniform {
                rate: possible(rate)?,
                start: 0.0,
                uncertainty: 0.0,
            },
            Self::Times {
                resolution,
                relative,
                ..
            } => uniform(times, resolution, relative)?,
            Self::Uniform(uniform) => uniform,
        };
        match asked {
            Some(asked) if (asked / own.rate - 1.0).abs() > SAME_RATE.max(own.uncertainty) => {
                Err(Problem::OtherRate {
                    asked,
                    own: own.rate,
                })
            }
            _ => Ok((own.rate, own.start)),
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

/// Whether times are evenly spaced, which takes two passes: the spacing is that of the first and the
/// last; every other time must lie on the line between them. Where the digits leave room for it, the rate
/// is a whole number of Hz: 44100, not 44099.9999. `resolution` and `relative` as in [`Timing::Times`].
pub(super) fn uniform(
    times: &mut EachTime<'_>,
    resolution: f64,
    relative: f64,
) -> Result<Uniform, Problem> {
    let (mut count, mut first, mut last, mut largest) = (0, f64::NAN, f64::NAN, 0.0_f64);
    let mut stall = None;
    times(&mut |time| {
        if count == 0 {
            first = time;
        } else if last.partial_cmp(&time) != Some(Ordering::Less) && stall.is_none() {
            stall = Some(Problem::NotRising {
                index: count,
                time,
                before: last,
            });
        }
        last = time;
        largest = largest.max(time.abs());
        count += 1;
    })?;
    if count < 2 {
        return Err(Problem::NoRate);
    }
    if let Some(stall) = stall {
        return Err(stall);
    }
    let spacing = (last - first) / (count - 1) as f64;
    let resolution = resolution.max(relative * largest).min(COARSEST * spacing);
    let tolerance = TOLERANCE + resolution / spacing;
    let mut index = 0;
    let mut fault = None;
    times(&mut |time| {
        let off = ((time - first) / spacing - index as f64).abs();
        if off > tolerance && fault.is_none() {
            fault = Some(Problem::NotUniform { index, time, off });
        }
        index += 1;
    })?;
    if let Some(fault) = fault {
        return Err(fault);
    }
    let rounding = f64::EPSILON * first.abs().max(last.abs());
    let uncertainty = (resolution + rounding) / (last - first);
    let rate = 1.0 / spacing;
    let whole = rate.round();
    let is_whole = whole > 0.0 && (rate / whole - 1.0).abs() <= uncertainty;
    Ok(Uniform {
        rate: if is_whole { whole } else { rate },
        start: first,
        uncertainty,
    })
}
