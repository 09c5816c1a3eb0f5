//! Sample rate and start time of a signal.

use std::sync::Arc;

use super::Problem;

/// Time information of a source.
#[derive(Clone)]
pub(super) enum Timing {
    /// Sample rate, Hz, if it is known; the first sample is at 0 s.
    Rate(Option<f64>),
    /// The time of each sample.
    Times {
        /// Times, s.
        times: Arc<Vec<f64>>,
        /// Uncertainty of a time due to its number of digits, s.
        resolution: f64,
        /// Relative uncertainty, as a fraction of the largest time.
        relative: f64,
    },
    /// Times that have been evaluated already.
    Uniform(Uniform),
}

/// Evenly spaced times.
#[derive(Clone, Copy)]
pub(super) struct Uniform {
    /// Sample rate, Hz.
    pub rate: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// Relative uncertainty of the rate.
    pub uncertainty: f64,
}

impl Uniform {
    /// From the first time and the spacing, s, with its relative uncertainty. If that permits it, the rate is rounded to
    /// a whole number of Hz: 44100, not 44099.9999.
    pub fn new(start: f64, spacing: f64, uncertainty: f64) -> Self {
        let rate = 1.0 / spacing;
        let whole = rate.round();
        let is_whole = whole > 0.0 && (rate / whole - 1.0).abs() <= uncertainty;
        Self {
            rate: if is_whole { whole } else { rate },
            start,
            uncertainty,
        }
    }
}

/// Tolerated deviation of a sample from its nominal time, in sample spacings, in addition to the number of
/// digits.
const TIME_TOLERANCE: f64 = 1e-3;

/// Maximum tolerance due to the number of digits, in sample spacings: a missing sample deviates more.
const MAX_DIGIT_TOLERANCE: f64 = 0.2;

/// An interval of this many usual ones is a gap.
const GAP: f64 = 1.5;

/// With more gaps than one in this many samples the clock is uneven.
const RARE: usize = 100;

/// Relative tolerance of a given rate from that of the file.
const SAME_RATE: f64 = 1e-6;

impl Timing {
    /// Sample rate (Hz) and time of the first sample (s); `asked` is the rate given by the user.
    pub fn rate_and_start(self, asked: Option<f64>) -> Result<(f64, f64), Problem> {
        if let Some(rate) = asked {
            valid_rate(rate)?;
        }
        let own = match self {
            // A header may be wrong, unlike the times of the samples.
            Self::Rate(rate) => {
                let rate = asked.or(rate).ok_or_else(Problem::no_rate)?;
                return Ok((valid_rate(rate)?, 0.0));
            }
            Self::Times {
                times,
                resolution,
                relative,
            } => uniform(&times, resolution, relative)?,
            Self::Uniform(uniform) => {
                valid_rate(uniform.rate)?;
                uniform
            }
        };
        match asked {
            Some(asked) if (asked / own.rate - 1.0).abs() > SAME_RATE.max(own.uncertainty) => {
                let own = own.rate;
                Err(Problem::Content(format!(
                    "the file has a sample rate of {own} Hz, not {asked} Hz; omit --rate"
                )))
            }
            _ => Ok((own.rate, own.start)),
        }
    }
}

/// Valid rates, Hz: they include all instruments, and times and frequencies can be drawn in single precision.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e15;

fn valid_rate(rate: f64) -> Result<f64, Problem> {
    if RATES.contains(&rate) {
        Ok(rate)
    } else {
        Err(Problem::Content(format!(
            "the sample rate {rate} Hz is invalid; give a rate from 1e-12 to 1e15 Hz with --rate HZ"
        )))
    }
}

/// Checks that times are evenly spaced. The spacing follows from the first and the last time; every other time
/// must lie on the line between them. `resolution` and `relative` as in [`Timing::Times`].
pub(super) fn uniform(times: &[f64], resolution: f64, relative: f64) -> Result<Uniform, Problem> {
    let (&[first, .., last], count) = (times, times.len()) else {
        return Err(Problem::no_rate());
    };
    // Also where one of them is NaN.
    let stalls = |pair: &[f64]| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less);
    if let Some(before) = times.windows(2).position(stalls) {
        return Err(Problem::Content(format!(
            "the time does not increase: sample {} is at {} s, the previous one at {} s; correct the times, or remove \
             them and give --rate",
            before + 1,
            times[before + 1],
            times[before]
        )));
    }
    let spacing = (last - first) / (count - 1) as f64;
    let resolution = resolution
        .max(relative * first.abs().max(last.abs()))
        .min(MAX_DIGIT_TOLERANCE * spacing);
    let tolerance = TIME_TOLERANCE + resolution / spacing;
    let off = |(index, time): (usize, &f64)| ((time - first) / spacing - index as f64).abs();
    let fault = times.iter().enumerate().find(|time| off(*time) > tolerance);
    let Some((index, time)) = fault else {
        let rounding = f64::EPSILON * first.abs().max(last.abs());
        let uncertainty = (resolution + rounding) / (last - first);
        return Ok(Uniform::new(first, spacing, uncertainty));
    };
    // Intervals that are longer than the others are gaps.
    let intervals = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let longest = intervals().fold(0.0, f64::max);
    let usual = (last - first - longest) / (count - 2).max(1) as f64;
    let mut gaps = intervals().enumerate().filter(|gap| gap.1 > GAP * usual);
    Err(Problem::Content(match (gaps.next(), gaps.count() + 1) {
        (Some((sample, interval)), gaps) if gaps <= 1 + count / RARE => format!(
            "the time has {}: {interval:.6} s pass after sample {sample} (at {} s), instead of {usual:.3e} s; save the \
             parts before and after it as files of their own",
            if gaps == 1 {
                "a gap".to_owned()
            } else {
                format!("{gaps} gaps")
            },
            times[sample]
        ),
        _ => format!(
            "the samples are not evenly spaced in time: sample {index} is at {time} s, {:.3} sample spacings from its \
             nominal time; resample the signal, or remove the times and give --rate",
            off((index, time))
        ),
    }))
}
