//! What sounds when in a measured sound, for the terminal.

use super::report::HEADING;
use crate::analysis::{Hum, LevelReference, RecordingCondition, Span, TonalEvent};
use crate::number::significant;
use crate::study::signal::MeasuredSound;
use crate::table::Table;

/// Relative offset above which it is mentioned.
const LARGE_OFFSET: f64 = 0.1;

/// Number of intervals in a list; the others are counted.
const LISTED: usize = 4;

/// The table of tonal events, and what the condition of the recording gives reason to mention.
/// `duration_s` is that of the signal; `amount` formats a value in its unit.
pub(super) fn sound_text(
    sound: &MeasuredSound,
    duration_s: f64,
    amount: &dyn Fn(f64) -> String,
) -> String {
    let events = match &sound.tonal.events[..] {
        [] => format!("{HEADING}no tonal events{HEADING:#}\n"),
        events => {
            let table = table(events, sound.level_reference);
            format!("{HEADING}tonal events{HEADING:#}\n{table}")
        }
    };
    let mut lines = condition(&sound.condition, duration_s, amount);
    lines.extend(hum_text(sound.tonal.hum, sound.level_reference));
    let lines: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    match &*lines {
        "" => events,
        lines => format!("{events}\n{HEADING}recording{HEADING:#}\n{lines}"),
    }
}

fn table(events: &[TonalEvent], reference: LevelReference) -> String {
    let mut table = Table::default()
        .right("event")
        .left("kind")
        .right("start, s")
        .right("end, s")
        .right("frequency, Hz")
        .right("low to high, Hz")
        .right("harmonics")
        .right(format!("level, {reference}"))
        .right("SNR, dB")
        .left("modulation");
    for (event, number) in events.iter().zip(1..) {
        table.row([
            format!("{number}"),
            format!("{}, {:.0} %", event.kind, 100.0 * event.probability),
            format!("{:.3}", event.start_s),
            format!("{:.3}", event.end_s),
            format!("{:.1}", event.frequency_hz),
            format!(
                "{:.1} to {:.1}",
                event.frequency_low_hz, event.frequency_high_hz
            ),
            format!("{}", event.harmonics),
            format!("{:.1}", event.level_db),
            format!("{:.1}", event.snr_db),
            modulation(event),
        ]);
    }
    table.text()
}

/// Modulation of amplitude and frequency; empty if there is none.
fn modulation(event: &TonalEvent) -> String {
    let amplitude = event.modulation.map(|m| {
        let depth = 100.0 * m.modulation_depth;
        format!(
            "amplitude {} Hz, depth {depth:.0} %",
            significant(m.modulation_hz, 3)
        )
    });
    let frequency = event.vibrato.map(|v| {
        let [rate, deviation] = [v.vibrato_hz, v.vibrato_deviation_hz].map(|hz| significant(hz, 3));
        format!("vibrato {rate} Hz, deviation {deviation} Hz")
    });
    let parts: Vec<String> = amplitude.into_iter().chain(frequency).collect();
    parts.join("; ")
}

/// Faults of the recording.
fn condition(
    condition: &RecordingCondition,
    duration_s: f64,
    amount: &dyn Fn(f64) -> String,
) -> Vec<String> {
    let mut lines = Vec::new();
    if !condition.clipped.is_empty() {
        let share = significant(100.0 * condition.clipped_share, 2);
        let spans = list(&condition.clipped);
        lines.push(format!("clipping: {share} % of the samples, {spans}"));
    }
    if condition.relative_offset.abs() > LARGE_OFFSET {
        let (mean, share) = (amount(condition.offset), condition.relative_offset.abs());
        lines.push(format!(
            "offset: mean {mean}, {share:.2} times the RMS deviation"
        ));
    }
    if !condition.dropouts.is_empty() {
        lines.push(format!("dropouts: {}", list(&condition.dropouts)));
    }
    let silent: f64 = condition.silence.iter().map(Span::length_s).sum();
    if silent > 0.0 {
        let share = 100.0 * silent / duration_s;
        let spans = list(&condition.silence);
        lines.push(format!("silence: {share:.0} % of the time, {spans}"));
    }
    lines
}

/// Mains hum.
fn hum_text(hum: Option<Hum>, reference: LevelReference) -> Option<String> {
    hum.map(|hum| {
        let frequency = significant(hum.fundamental_hz, 4);
        let level = hum.level_db;
        match hum.harmonics {
            1 => format!("mains hum: {frequency} Hz, {level:.1} {reference}"),
            n => format!("mains hum: {n} multiples of {frequency} Hz, {level:.1} {reference}"),
        }
    })
}

/// The first intervals, and the number of others.
fn list(spans: &[Span]) -> String {
    let shown = spans.iter().take(LISTED);
    let shown = shown.map(|span| format!("{:.3} to {:.3} s", span.start_s, span.end_s));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match spans.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
