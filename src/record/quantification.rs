//! Recurrence quantification over time, one series per measure.

use crate::record::sdk::Scalars;

use super::{
    error::RecordError,
    paths,
    samples::name_series,
    stream::{self, RecordingStream},
    style,
};
use crate::analysis::{Measures, RecurrenceKind, RecurrencePeriods};
use crate::plot::Unit;

/// Number of states beyond which durations use the larger unit.
const LONG: f64 = 1e3;

/// Draws recurrence measures.
#[derive(Debug, Default)]
pub struct Quantification {
    /// Units of short and long durations, determined by the first measures.
    units: Option<Units>,
}

/// Factors from SI to the units of the series.
#[derive(Clone, Copy, Debug)]
struct Units {
    short: f64,
    long: f64,
}

impl Quantification {
    /// Draws the measures of a window that ends at `time` (s), with states `dt` (s) apart; `periods` in s. An
    /// undefined measure is a gap.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        dt: f64,
        measures: &Measures,
        periods: &RecurrencePeriods,
    ) -> Result<(), RecordError> {
        let units = match self.units {
            Some(units) => units,
            None => name_measures(rec, dt)?,
        };
        self.units = Some(units);
        let short = |states: f64| units.short * dt * states;
        let long = |states: f64| units.long * dt * states;
        let rows = [
            (paths::RECURRENCE_RATE, Some(measures.recurrence_rate)),
            (paths::DETERMINISM, measures.determinism),
            (paths::LAMINARITY, measures.laminarity),
            (paths::MEAN_DIAGONAL, measures.mean_diagonal.map(long)),
            (
                paths::LONGEST_DIAGONAL,
                Some(long(measures.longest_diagonal)),
            ),
            (paths::TRAPPING_TIME, measures.trapping_time.map(short)),
            (
                paths::RECURRENCE_TIME_1,
                measures.recurrence_time_1.map(short),
            ),
            (
                paths::RECURRENCE_TIME_2,
                measures.recurrence_time_2.map(short),
            ),
            (paths::ENTROPY, measures.entropy),
            (
                paths::DIVERGENCE_RATE,
                measures.divergence.map(|div| div / (units.long * dt)),
            ),
            // TREND is per thousand states; converted to a rate over time.
            (
                paths::TREND,
                measures.trend.map(|trend| trend / (1e3 * units.long * dt)),
            ),
        ];
        for (path, value) in rows {
            let value = value.unwrap_or(f64::NAN);
            stream::log_at(rec, path, time, &Scalars::single(value))?;
        }
        let kinds = [
            RecurrenceKind::Finest,
            RecurrenceKind::Beat,
            RecurrenceKind::Doubled,
        ];
        let period = |kind| periods.last(kind).map_or(f64::NAN, |found| found.period);
        let scaled = kinds.map(|kind| units.short * period(kind));
        stream::log_at(rec, paths::PERIOD, time, &Scalars::new(scaled))
    }
}

/// Names the series; the units depend on the spacing of the states (s).
fn name_measures(rec: &RecordingStream, dt: f64) -> Result<Units, RecordError> {
    let short = Unit::of("s", dt);
    let long = Unit::of("s", LONG * dt);
    let (s, l) = (&short.symbol, &long.symbol);
    let series = [
        (paths::RECURRENCE_RATE, "RR".to_owned(), style::SIGNAL),
        (paths::DETERMINISM, "DET".to_owned(), style::ACCENT),
        (paths::LAMINARITY, "LAM".to_owned(), style::ROTATION),
        (paths::MEAN_DIAGONAL, format!("L, {l}"), style::SIGNAL),
        (paths::LONGEST_DIAGONAL, format!("Lmax, {l}"), style::ACCENT),
        (paths::TRAPPING_TIME, format!("TT, {s}"), style::SIGNAL),
        (
            paths::RECURRENCE_TIME_1,
            format!("T1, {s}"),
            style::ROTATION,
        ),
        (
            paths::RECURRENCE_TIME_2,
            format!("T2, {s}"),
            style::FRICTION,
        ),
        (paths::ENTROPY, "ENTR, nats".to_owned(), style::SIGNAL),
        (paths::DIVERGENCE_RATE, format!("DIV, 1/{l}"), style::ACCENT),
        (paths::TREND, format!("TREND, 1/{l}"), style::FRICTION),
    ];
    for (path, name, color) in series {
        name_series(rec, path, [name], [color])?;
    }
    let names = ["finest period", "beat", "doubled period"].map(|name| format!("{name}, {s}"));
    let colors = [style::ACCENT, style::SIGNAL, style::FRICTION];
    name_series(rec, paths::PERIOD, names, colors)?;
    Ok(Units {
        short: short.factor,
        long: long.factor,
    })
}
