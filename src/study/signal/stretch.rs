//! The part of a sound from which spectrum, embedding, recurrence, exponents and type of motion follow.

use std::ops::Range;

use super::sound::{MeasuredSound, SOUND_RATES_HZ, overlap, shift};
use super::{AnalysedStretch, MIN_SAMPLES, SignalError, SkipReason};
use crate::analysis::{
    events::{Span, TonalEvent, demodulate, stationary_stretch},
    filter::band_pass,
};
use crate::import::Signal;

/// Minimum length of a stationary stretch, periods of the fundamental.
const MIN_PERIODS: f64 = 40.0;

/// Maximum length of a stretch, samples; of a longer one the end is used.
pub(super) const MAX_SAMPLES: usize = 1 << 20;

/// A ridge whose frequencies, without the extreme twentieth on either side, differ by more than this share
/// drifts, unless the drift is below this number of bins of the stretch.
const DRIFT: f64 = 5e-4;
const DRIFT_BINS: f64 = 4.0;
const EXTREME: f64 = 0.05;

/// Lower edge of the pass band: the lowest fundamental divided by this.
const SUBHARMONIC: f64 = 3.0;

/// Share of the power outside the pass band above which the stretch is filtered.
const OUTSIDE_SHARE: f64 = 0.01;

/// Time by which the filtered samples extend beyond the stretch, periods of the lower edge.
const MARGIN_PERIODS: f64 = 10.0;

/// Distance between a stretch and the ends of the signal that counts as none: the accuracy of the ends of
/// an event, s, and at most this share of the signal.
const END_S: f64 = 0.1;
const END_SHARE: f64 = 0.1;

/// The stretch to analyse and its samples.
pub(super) struct Selected {
    pub stretch: AnalysedStretch,
    /// The samples of the stretch, filtered and demodulated as the stretch says; `None` for the signal itself.
    pub part: Option<Signal>,
    /// Why methods that assume stationarity are skipped.
    pub obstacle: Option<SkipReason>,
}

/// Selects the stretch: of the event with this number (from 1), or of the strongest event; without events
/// the whole signal.
///
/// # Errors
/// [`SignalError::NoEvent`] and [`SignalError::NotSound`] for an event that does not exist.
pub(super) fn select(
    signal: &Signal,
    sound: Option<&MeasuredSound>,
    number: Option<usize>,
) -> Result<Selected, SignalError> {
    let whole = Span {
        start_s: signal.start,
        end_s: signal.start + signal.duration(),
    };
    let clipped = sound.is_some_and(|sound| sound.is_clipped(whole));
    let all = |event: Option<usize>| Selected {
        stretch: AnalysedStretch::new(whole, event, clipped),
        part: None,
        obstacle: None,
    };
    let event = chosen(sound, number)?;
    let Some((sound, index, event)) = event else {
        return Ok(all(None));
    };
    let number = index + 1;
    let (span, obstacle) = stretch_of(event, sound, signal.rate);
    let band = pass_band(&sound.tonal.events, span, signal.rate);
    let drifts = drifts(event, span);
    let near = END_S.min(END_SHARE * signal.duration());
    let is_whole = span.start_s - whole.start_s <= near && whole.end_s - span.end_s <= near;
    let part = Part::new(signal, span, band);
    if is_whole && !drifts && part.band.is_none() && obstacle.is_none() {
        return Ok(all(Some(number)));
    }
    let stretch = AnalysedStretch {
        demodulated: drifts,
        band_hz: part.band,
        ..AnalysedStretch::new(span, Some(number), sound.is_clipped(span))
    };
    let samples = part.samples(event, span, drifts)?;
    let part = Signal {
        name: signal.name.clone(),
        unit: signal.unit.clone(),
        rate: signal.rate,
        start: span.start_s,
        samples,
    };
    Ok(Selected {
        stretch,
        part: Some(part),
        obstacle,
    })
}

/// The sound, and the requested event with its index; without a request the strongest one.
fn chosen(
    sound: Option<&MeasuredSound>,
    number: Option<usize>,
) -> Result<Option<(&MeasuredSound, usize, &TonalEvent)>, SignalError> {
    let rates = SOUND_RATES_HZ;
    let Some(sound) = sound else {
        return number.map_or(Ok(None), |_| Err(SignalError::NotSound { rates }));
    };
    let index = match number {
        Some(number) => Some(number.wrapping_sub(1)),
        None => sound.strongest(),
    };
    let found = sound.tonal.events.len();
    match (
        index.and_then(|index| Some((sound, index, sound.tonal.events.get(index)?))),
        number,
    ) {
        (None, Some(number)) => Err(SignalError::NoEvent { number, found }),
        (chosen, _) => Ok(chosen),
    }
}

/// The longest stationary stretch of an event, between clipped samples and dropouts if one of the pieces
/// between them has half of its length. The whole event, and a reason, if the stretch is too short.
fn stretch_of(event: &TonalEvent, sound: &MeasuredSound, rate: f64) -> (Span, Option<SkipReason>) {
    let stationary = stationary_stretch(event);
    let intact = longest_intact(stationary, sound);
    let least = (MIN_PERIODS / event.frequency_hz).max(MIN_SAMPLES as f64 / rate);
    let (mut span, obstacle) = if intact.length_s() >= least.max(0.5 * stationary.length_s()) {
        (intact, None)
    } else if stationary.length_s() >= least {
        (stationary, None)
    } else {
        (event.span(), Some(SkipReason::NotStationary))
    };
    span.start_s = span.start_s.max(span.end_s - MAX_SAMPLES as f64 / rate);
    (span, obstacle)
}

/// The longest part of an interval without clipped samples and dropouts.
fn longest_intact(span: Span, sound: &MeasuredSound) -> Span {
    let condition = &sound.condition;
    let faults = condition.clipped.iter().chain(&condition.dropouts);
    let mut faults: Vec<Span> = faults.filter(|f| overlap(**f, span)).copied().collect();
    faults.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let mut start_s = span.start_s;
    let mut parts = Vec::with_capacity(faults.len() + 1);
    for fault in faults {
        let end_s = fault.start_s;
        parts.push(Span { start_s, end_s });
        start_s = start_s.max(fault.end_s);
    }
    parts.push(Span { start_s, ..span });
    let longest = parts
        .into_iter()
        .max_by(|a, b| a.length_s().total_cmp(&b.length_s()));
    longest.unwrap_or(span)
}

/// Whether the fundamental of an event drifts within an interval.
fn drifts(event: &TonalEvent, span: Span) -> bool {
    let inside = |time: f64| (span.start_s..=span.end_s).contains(&time);
    let points = event.ridge.iter().filter(|point| inside(point.time_s));
    let mut frequencies: Vec<f64> = points.map(|point| point.frequency_hz).collect();
    frequencies.sort_by(f64::total_cmp);
    let extreme = (EXTREME * frequencies.len() as f64) as usize;
    let kept = &frequencies[extreme..frequencies.len() - extreme];
    let least = (DRIFT * event.frequency_hz).max(DRIFT_BINS / span.length_s());
    match kept {
        [low, .., high] => high - low > least,
        _ => false,
    }
}

/// Band of the events that sound in an interval, Hz: from a third of the lowest fundamental, so that a
/// subharmonic is kept, to half a harmonic above the highest one. `n` harmonics may be the odd ones only.
fn pass_band(events: &[TonalEvent], span: Span, rate: f64) -> [f64; 2] {
    let sounding = events.iter().filter(|event| overlap(event.span(), span));
    let edges = sounding.map(|event| {
        let order = 2.0 * event.harmonics.max(1) as f64 - 0.5;
        [
            event.frequency_low_hz / SUBHARMONIC,
            event.frequency_high_hz * order,
        ]
    });
    edges.fold([0.5 * rate, 0.0], |[low, high], [from, to]| {
        [low.min(from), high.max(to).min(0.5 * rate)]
    })
}

/// Indices of the samples of a signal in an interval.
pub(super) fn index_range(signal: &Signal, span: Span) -> Range<usize> {
    let index = |time: f64| ((time - signal.start) * signal.rate).round().max(0.0) as usize;
    let end = index(span.end_s).min(signal.samples.len());
    index(span.start_s).min(end)..end
}

/// The samples around a stretch, filtered if there is power outside the pass band.
struct Part {
    samples: Vec<f64>,
    rate: f64,
    /// Time of the first sample, s.
    start_s: f64,
    /// Pass band of the filter, Hz; `None` if it is not needed.
    band: Option<[f64; 2]>,
}

impl Part {
    fn new(signal: &Signal, span: Span, band: [f64; 2]) -> Self {
        let margin = MARGIN_PERIODS / band[0];
        let wider = Span {
            start_s: span.start_s - margin,
            end_s: span.end_s + margin,
        };
        let range = index_range(signal, wider);
        let first = range.start;
        let raw = &signal.samples[range];
        let filtered = band_pass(raw, signal.rate, band);
        let (band, samples) = if filtered.outside_share > OUTSIDE_SHARE {
            (Some(band), filtered.samples)
        } else {
            (None, raw.to_vec())
        };
        Self {
            band,
            samples,
            rate: signal.rate,
            start_s: signal.start + first as f64 / signal.rate,
        }
    }

    /// The samples of the stretch, along the ridge of the event if it drifts.
    fn samples(
        &self,
        event: &TonalEvent,
        span: Span,
        drifts: bool,
    ) -> Result<Vec<f64>, SignalError> {
        let local = Span {
            start_s: span.start_s - self.start_s,
            end_s: span.end_s - self.start_s,
        };
        if drifts {
            let mut event = event.clone();
            shift(&mut event, -self.start_s);
            return Ok(demodulate(&self.samples, self.rate, &event, local)?);
        }
        let index = |time: f64| (time * self.rate).round().max(0.0) as usize;
        let end = index(local.end_s).min(self.samples.len());
        Ok(self.samples[index(local.start_s).min(end)..end].to_vec())
    }
}

#[cfg(test)]
#[path = "stretch_tests.rs"]
mod tests;
