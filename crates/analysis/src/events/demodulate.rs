//! A signal along a ridge, brought to a constant frequency.

use super::{Span, TonalEvent};
use crate::AnalysisError;
use crate::filter::{HALF_TAPS, taps};

/// The samples of `span` in a time in which the fundamental of `event` has the constant frequency
/// [`TonalEvent::frequency_hz`]: the warped time `tau` has `dtau / dt = f(t) / f_mean` along the ridge, so
/// that every harmonic becomes steady, too. The rate of the result is `rate_hz`; its length is
/// that of the span up to the ratio of the mean frequencies. Interpolation with a windowed sinc of 48
/// samples: frequencies up to 0.45 of the rate are kept to 60 dB.
///
/// # Errors
/// [`AnalysisError::TooShort`] if the span holds fewer than 16 samples.
pub fn demodulate(
    samples: &[f64],
    rate_hz: f64,
    event: &TonalEvent,
    span: Span,
) -> Result<Vec<f64>, AnalysisError> {
    let first = (span.start_s * rate_hz).ceil().max(0.0) as usize;
    let end = ((span.end_s * rate_hz).floor().max(0.0) as usize).min(samples.len());
    AnalysisError::check_length("demodulation along a ridge", end.saturating_sub(first), 16)?;
    let mut warped = Vec::with_capacity(end - first);
    let mut at = first as f64;
    while at < end as f64 {
        warped.push(interpolated(samples, at));
        // Midpoint rule for dt = f_mean / f(t) dtau.
        let slope = |t: f64| event.frequency_hz / event.frequency_at(t / rate_hz);
        at += slope(at + 0.5 * slope(at));
    }
    Ok(warped)
}

/// The signal at a position between samples.
fn interpolated(samples: &[f64], at: f64) -> f64 {
    let base = at.floor();
    let first = base as isize + 1 - HALF_TAPS as isize;
    let taps = taps(at - base);
    let term = |(k, tap): (usize, &f64)| {
        Some(tap * samples.get(usize::try_from(first + k as isize).ok()?)?)
    };
    taps.iter().enumerate().filter_map(term).sum()
}
