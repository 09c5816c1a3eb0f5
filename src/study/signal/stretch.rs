//! The part of a sound from which spectrum, embedding, recurrence, exponents and type of motion follow.

use std::ops::Range;

use super::sound::{MeasuredSound, overlap, shift};
use super::{AnalysedStretch, MIN_SAMPLES, SignalError, SkipReason};
use crate::analysis::{
    events::{EventKind, Span, TonalEvent, demodulate, stationary_stretch},
    filter::band_pass,
    stats::deviation,
};
use crate::import::Signal;

/// Minimum length of a stationary stretch, periods of the fundamental.
const MIN_PERIODS: f64 = 40.0;

/// Maximum length of a stretch, samples; of a longer one the end is used. Of the background, this many samples are used.
const MAX_SAMPLES: usize = 1 << 20;

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

/// Shortest interval in which the background is measured, s.
const SHORTEST_S: f64 = 0.1;

/// Distance of this interval from events, s: they end gradually, and reverberate.
const MARGIN_S: f64 = 0.1;

/// Selects the stretch of the event with this number (from 1), by default of the strongest tone; without one, the whole
/// signal. Returns the stretch, its filtered and demodulated samples (`None`: those of the signal), and why methods that
/// assume stationarity are skipped, if they are.
///
/// # Errors
/// [`SignalError::NoEvent`] and [`SignalError::NotSound`] for an event that does not exist.
pub(super) fn select(
    signal: &Signal,
    sound: Option<&MeasuredSound>,
    number: Option<usize>,
) -> Result<(AnalysedStretch, Option<Signal>, Option<SkipReason>), SignalError> {
    let whole = whole(signal);
    let clipped = sound.map_or(&[][..], |sound| &sound.condition.clipped);
    let stretch_at = |span: Span, event: Option<usize>| AnalysedStretch {
        start_s: span.start_s,
        end_s: span.end_s,
        event,
        demodulated: false,
        band_hz: None,
        clipped: clipped.iter().any(|other| overlap(*other, span)),
    };
    let strongest = || Some(sound?.strongest()? + 1);
    let Some(number) = number.or_else(strongest) else {
        return Ok((stretch_at(whole, None), None, None));
    };
    let sound = sound.ok_or(SignalError::NotSound)?;
    let events = &sound.tonal.events;
    let (event, found) = (events.get(number.wrapping_sub(1)), events.len());
    let event = event.ok_or(SignalError::NoEvent { number, found })?;
    let (span, obstacle) = stretch_of(event, sound, signal.rate);
    let band = pass_band(events, event, span, signal.rate);
    let demodulated = drifts(event, span);
    let near = END_S.min(END_SHARE * signal.duration());
    let is_whole = span.start_s - whole.start_s <= near && whole.end_s - span.end_s <= near;
    let (mut part, band_hz) = filtered(signal, span, band);
    if is_whole && !demodulated && band_hz.is_none() && obstacle.is_none() {
        return Ok((stretch_at(whole, Some(number)), None, None));
    }
    part.samples = if demodulated {
        let local = Span {
            start_s: span.start_s - part.start,
            end_s: span.end_s - part.start,
        };
        let mut event = event.clone();
        shift(&mut event, -part.start);
        demodulate(&part.samples, part.rate, &event, local)?
    } else {
        part.samples[index_range(&part, span)].to_vec()
    };
    part.start = span.start_s;
    let stretch = AnalysedStretch {
        demodulated,
        band_hz,
        ..stretch_at(span, Some(number))
    };
    Ok((stretch, Some(part), obstacle))
}

/// The interval of a signal.
fn whole(signal: &Signal) -> Span {
    Span {
        start_s: signal.start,
        end_s: signal.start + signal.duration(),
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
    longest_gap(span, faults)
}

/// The longest part of an interval outside some others, which are in ascending order of their starts.
fn longest_gap(span: Span, others: impl IntoIterator<Item = Span>) -> Span {
    let mut gaps = Vec::new();
    let mut start_s = span.start_s;
    for other in others {
        let end_s = other.start_s;
        gaps.push(Span { start_s, end_s });
        start_s = start_s.max(other.end_s);
    }
    gaps.push(Span { start_s, ..span });
    let by_length = |a: &Span, b: &Span| a.length_s().total_cmp(&b.length_s());
    gaps.into_iter().max_by(by_length).unwrap_or(span)
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

/// Whether an event is foreground: a tone, or the analysed event. Other noise and bursts are background.
fn is_foreground(event: &TonalEvent, analysed: &TonalEvent) -> bool {
    event.kind == EventKind::Tone || event == analysed
}

/// Band of the foreground in an interval, Hz: from a third of the lowest fundamental, so that a subharmonic is kept, to
/// half a harmonic above the highest one. `n` harmonics may be the odd ones only.
fn pass_band(events: &[TonalEvent], analysed: &TonalEvent, span: Span, rate: f64) -> [f64; 2] {
    let foreground = events.iter().filter(|event| is_foreground(event, analysed));
    let sounding = foreground.filter(|event| overlap(event.span(), span));
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
fn index_range(signal: &Signal, span: Span) -> Range<usize> {
    let index = |time: f64| ((time - signal.start) * signal.rate).round().max(0.0) as usize;
    let end = index(span.end_s).min(signal.samples.len());
    index(span.start_s).min(end)..end
}

/// The part of a signal around a stretch, filtered if there is power outside the pass band, and the band then.
fn filtered(signal: &Signal, span: Span, band: [f64; 2]) -> (Signal, Option<[f64; 2]>) {
    let margin = MARGIN_PERIODS / band[0];
    let wider = Span {
        start_s: span.start_s - margin,
        end_s: span.end_s + margin,
    };
    let range = index_range(signal, wider);
    let start = signal.time(range.start as f64);
    let raw = &signal.samples[range];
    let filtered = band_pass(raw, signal.rate, band);
    let is_needed = filtered.outside_share > OUTSIDE_SHARE;
    let part = Signal {
        name: signal.name.clone(),
        unit: signal.unit.clone(),
        rate: signal.rate,
        start,
        samples: if is_needed {
            filtered.samples
        } else {
            raw.to_vec()
        },
    };
    (part, is_needed.then_some(band))
}

/// Power of the background of an event, in the band of its stretch and the square of the unit of the signal, in the
/// longest interval without events, where noise and bursts that sound in the stretch do not count; `None` without an
/// analysed event, or without such an interval.
pub(super) fn background_power(
    signal: &Signal,
    events: &[TonalEvent],
    stretch: &AnalysedStretch,
) -> Option<f64> {
    let analysed = events.get(stretch.event? - 1)?;
    let span = Span {
        start_s: stretch.start_s,
        end_s: stretch.end_s,
    };
    let others = events
        .iter()
        .filter(|event| is_foreground(event, analysed) || !overlap(event.span(), span));
    let near = others.map(|event| Span {
        start_s: event.start_s - MARGIN_S,
        end_s: event.end_s + MARGIN_S,
    });
    let gap = Some(longest_gap(whole(signal), near));
    let gap = gap.filter(|gap| gap.length_s() >= SHORTEST_S)?;
    let samples = &signal.samples[index_range(signal, gap)];
    let samples = &samples[..samples.len().min(MAX_SAMPLES)];
    let deviation = match stretch.band_hz {
        Some(band) => deviation(&band_pass(samples, signal.rate, band).samples),
        None => deviation(samples),
    };
    Some(deviation.powi(2))
}

#[cfg(test)]
#[path = "stretch_tests.rs"]
mod tests;
