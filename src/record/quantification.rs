//! Recurrence quantification over time, one series per measure.

use std::iter::once_with;

use super::stream::RecordingStream;
use super::style::{FRICTION, LOAD, ROTATION};
use crate::analysis::recurrence::{Measures, RecurrenceKind, RecurrencePeriods};
use crate::plot::{Color, Unit};

/// Number of states beyond which durations use the larger unit.
const LONG: f64 = 1e3;

/// Draws the measures of a window that ends at `time` (s), with states `dt` (s) apart; `periods` in s.
pub fn draw(
    rec: &RecordingStream,
    (time, dt): (f64, f64),
    (measures, periods): (&Measures, &RecurrencePeriods),
) {
    let m = measures;
    // Unit and factor of a pure number, of durations given in states, and of numbers per state.
    let units = [dt, LONG * dt].map(|duration| Unit::of("s", duration));
    let number = (String::new(), 1.0);
    let named = |unit: &Unit| (format!(", {}", unit.symbol), unit.factor * dt);
    let [short, long] = units.each_ref().map(named);
    let rate = (format!(", 1/{}", units[1].symbol), long.1.recip());
    // TREND is per thousand states.
    let trend = m.trend.map(|trend| 1e-3 * trend);
    let series = |id: &str, name, (unit, factor): &(String, f64), color, value: Option<f64>| {
        let path = &format!("quantification/{id}");
        rec.name(path, once_with(|| (format!("{name}{unit}"), color)));
        // An undefined measure is a gap.
        let value = value.map_or(f64::NAN, |value| factor * value);
        rec.row(path, time, [value]);
    };
    let (rr, det, longest) = (
        Some(m.recurrence_rate),
        m.determinism,
        Some(m.longest_diagonal),
    );
    let [t1, t2] = [m.recurrence_time_1, m.recurrence_time_2];
    series("recurrence_rate", "RR", &number, Color::Run, rr);
    series("determinism", "DET", &number, Color::Compared, det);
    series("laminarity", "LAM", &number, ROTATION, m.laminarity);
    series("mean_diagonal", "L", &long, Color::Run, m.mean_diagonal);
    series("longest_diagonal", "Lmax", &long, Color::Compared, longest);
    series("trapping_time", "TT", &short, Color::Ink, m.trapping_time);
    series("recurrence_time_1", "T1", &short, ROTATION, t1);
    series("recurrence_time_2", "T2", &short, LOAD, t2);
    series("entropy", "ENTR, nats", &number, Color::Run, m.entropy);
    series("divergence", "DIV", &rate, Color::Compared, m.divergence);
    series("trend", "TREND", &rate, FRICTION, trend);
    let kinds = [
        (RecurrenceKind::Finest, "finest period", Color::Compared),
        (RecurrenceKind::Beat, "beat", Color::Run),
        (RecurrenceKind::Doubled, "doubled period", FRICTION),
    ];
    let names = kinds.iter();
    let names = names.map(|(_, name, color)| (format!("{name}{}", short.0), *color));
    rec.name("quantification/period", names);
    let values = kinds.map(|(kind, ..)| {
        let found = periods.last(kind);
        found.map_or(f64::NAN, |found| units[0].factor * found.period)
    });
    rec.row("quantification/period", time, values);
}
