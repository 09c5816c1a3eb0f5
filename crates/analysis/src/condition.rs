//! The condition of a recording: clipping, offset, dropouts, silence.

use schemars::JsonSchema;
use serde::Serialize;

use crate::events::Span;
use crate::stats::deviation;

/// Condition of a recording: faults that other analyses would take for properties of the motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct RecordingCondition {
    /// Intervals with clipping: flat tops at the highest or the lowest value, joined if less than 0.1 s apart.
    pub clipped: Vec<Span>,
    /// Share of the samples in flat tops.
    pub clipped_share: f64,
    /// Offset: mean of the samples (DC), in their unit.
    pub offset: f64,
    /// Offset over the root-mean-square deviation from it.
    pub relative_offset: f64,
    /// Dropouts: intervals between 1 ms and 0.1 s in which sound stops at one exact value.
    pub dropouts: Vec<Span>,
    /// Silence: intervals of at least 0.1 s 80 dB below the largest magnitude, or at one exact value.
    pub silence: Vec<Span>,
}

/// Shortest flat top, samples.
const FLAT_SAMPLES: usize = 3;

/// Flatness of a flat top, relative to the range of the samples.
const FLATNESS: f64 = 1e-4;

/// Least range of samples in which clipping and dropouts can be seen, in steps of quantisation.
const LEAST_STEPS: f64 = 64.0;

/// Smallest step of quantisation, relative to the range of the samples: smaller differences are rounding.
const ROUNDING: f64 = 1e-10;

/// A step into or out of a flat top, in units of its flatness. At the top of a parabola, `n` samples within
/// `q` are followed by a step of less than `(1 + 4 / n) q`.
const EDGE: f64 = 4.0;

/// Clipped spans closer than this are joined, s.
const JOIN_S: f64 = 0.1;

/// Shortest dropout, s, and shortest silence, s.
const DROPOUT_S: f64 = 0.001;
const SILENCE_S: f64 = 0.1;

/// Time next to a dropout in which there is sound, s.
const NEAR_S: f64 = 0.01;

/// Level of silence relative to the largest deviation.
const SILENT: f64 = 1e-4;

/// Determines the condition of a recording at `rate_hz`.
pub fn recording_condition(samples: &[f64], rate_hz: f64) -> RecordingCondition {
    let count = samples.len().max(1) as f64;
    let offset = samples.iter().sum::<f64>() / count;
    let scatter = deviation(samples);
    let (tops, flat) = flat_tops(samples, (JOIN_S * rate_hz) as usize);
    RecordingCondition {
        clipped_share: flat as f64 / count,
        clipped: spans(&tops, rate_hz),
        offset,
        relative_offset: if scatter > 0.0 { offset / scatter } else { 0.0 },
        dropouts: spans(&dropouts(samples, rate_hz), rate_hz),
        silence: spans(&silences(samples, offset, rate_hz), rate_hz),
    }
}

/// Ranges of samples as spans.
fn spans(ranges: &[(usize, usize)], rate_hz: f64) -> Vec<Span> {
    let second = |index: usize| index as f64 / rate_hz;
    let span = |&(first, end): &(usize, usize)| Span {
        start_s: second(first),
        end_s: second(end),
    };
    ranges.iter().map(span).collect()
}

/// Runs of at least [`FLAT_SAMPLES`] samples at the highest or the lowest value, with a step at one end: ranges of
/// samples in which they are less than `join` samples apart, and number of samples in the runs.
fn flat_tops(samples: &[f64], join: usize) -> (Vec<(usize, usize)>, usize) {
    let [low, high] = crate::stats::range(samples.iter().copied());
    let flatness = FLATNESS * (high - low);
    // Of few steps of quantisation, many are at the top without clipping.
    if high - low < LEAST_STEPS * quantum(samples) {
        return (Vec::new(), 0);
    }
    let side = |x: f64| (high - x <= flatness, x - low <= flatness);
    let step = |a: usize, b: usize| (samples[a] - samples[b]).abs();
    let mut tops = runs(samples, FLAT_SAMPLES, |a, b| side(*a) == side(*b));
    tops.retain(|&(first, end)| {
        let (is_high, is_low) = side(samples[first]);
        let into = first
            .checked_sub(1)
            .map_or(0.0, |before| step(before, first));
        let out_of = if end < samples.len() {
            step(end, end - 1)
        } else {
            0.0
        };
        is_high != is_low && into.max(out_of) > EDGE * flatness
    });
    let flat = tops.iter().map(|(first, end)| end - first).sum();
    tops.dedup_by(|next, last| {
        let joins = next.0 - last.1 < join;
        if joins {
            last.1 = next.1;
        }
        joins
    });
    (tops, flat)
}

/// Maximal runs of at least `least` samples of which any two neighbours satisfy a condition.
fn runs(samples: &[f64], least: usize, same: impl Fn(&f64, &f64) -> bool) -> Vec<(usize, usize)> {
    let mut first = 0;
    let mut out = Vec::new();
    for run in samples.chunk_by(same) {
        if run.len() >= least {
            out.push((first, first + run.len()));
        }
        first += run.len();
    }
    out
}

/// Runs between [`DROPOUT_S`] and [`SILENCE_S`] at one value that is not the highest or lowest, with sound of many steps
/// of quantisation on both sides.
fn dropouts(samples: &[f64], rate_hz: f64) -> Vec<(usize, usize)> {
    let [least, most] = [DROPOUT_S, SILENCE_S].map(|s| (s * rate_hz).ceil() as usize);
    let near = (NEAR_S * rate_hz) as usize;
    let loud = LEAST_STEPS * quantum(samples);
    let sounds = |part: &[f64]| {
        let [low, high] = crate::stats::range(part.iter().copied());
        !part.is_empty() && high - low > loud
    };
    let [low, high] = crate::stats::range(samples.iter().copied());
    let flatness = FLATNESS * (high - low);
    let mut found = runs(samples, least, |a, b| a == b);
    found.retain(|&(first, end)| {
        let value = samples[first];
        end - first < most
            && (value - low).min(high - value) > flatness
            && sounds(&samples[first.saturating_sub(near)..first])
            && sounds(&samples[end..(end + near).min(samples.len())])
    });
    found
}

/// Smallest difference of neighbouring samples that is not 0 nor rounding: a step of quantisation, or infinity.
pub(super) fn quantum(samples: &[f64]) -> f64 {
    let [low, high] = crate::stats::range(samples.iter().copied());
    let steps = samples.windows(2).map(|w| (w[1] - w[0]).abs());
    let steps = steps.filter(|step| *step > ROUNDING * (high - low));
    steps.fold(f64::INFINITY, f64::min)
}

/// Runs of at least [`SILENCE_S`] without sound: within [`SILENT`] of the offset, or constant.
fn silences(samples: &[f64], offset: f64, rate_hz: f64) -> Vec<(usize, usize)> {
    let deviation = |x: &f64| (x - offset).abs();
    let largest = samples.iter().map(deviation).fold(0.0, f64::max);
    let is_quiet = |x: &f64| deviation(x) <= SILENT * largest;
    let least = (SILENCE_S * rate_hz).ceil() as usize;
    runs(samples, least, |a, b| a == b || is_quiet(a) && is_quiet(b))
}
