//! Recurrence quantification over time, one series per measure.

use super::{error::RecordError, paths, samples::Rows, stream::RecordingStream, style};
use crate::analysis::recurrence::{Measures, RecurrenceKind, RecurrencePeriods};
use crate::plot::Unit;
use crate::record::sdk::Color;

/// Number of states beyond which durations use the larger unit.
const LONG: f64 = 1e3;

/// What a measure counts.
#[derive(Clone, Copy)]
enum Quantity {
    /// A number with its own unit.
    Number,
    /// A number of states, written as a short or as a long duration.
    Short,
    Long,
    /// A number per state, written over a long duration.
    Rate,
}

/// Entity, name, quantity and colour of each measure.
const SERIES: [(&str, &str, Quantity, Color); 11] = {
    use Quantity::{Long, Number, Rate, Short};
    use style::{ACCENT, FRICTION, ROTATION, SIGNAL};
    [
        (paths::RECURRENCE_RATE, "RR", Number, SIGNAL),
        (paths::DETERMINISM, "DET", Number, ACCENT),
        (paths::LAMINARITY, "LAM", Number, ROTATION),
        (paths::MEAN_DIAGONAL, "L", Long, SIGNAL),
        (paths::LONGEST_DIAGONAL, "Lmax", Long, ACCENT),
        (paths::TRAPPING_TIME, "TT", Short, SIGNAL),
        (paths::RECURRENCE_TIME_1, "T1", Short, ROTATION),
        (paths::RECURRENCE_TIME_2, "T2", Short, FRICTION),
        (paths::ENTROPY, "ENTR, nats", Number, SIGNAL),
        (paths::DIVERGENCE_RATE, "DIV", Rate, ACCENT),
        (paths::TREND, "TREND", Rate, FRICTION),
    ]
};

/// Draws recurrence measures.
#[derive(Debug, Default)]
pub struct Quantification {
    /// Units of short and long durations, determined by the first measures.
    units: Option<[Unit; 2]>,
}

impl Quantification {
    /// Draws the measures of a window that ends at `time` (s), with states `dt` (s) apart; `periods` in s.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        rows: &mut Rows,
        (time, dt): (f64, f64),
        (measures, periods): (&Measures, &RecurrencePeriods),
    ) -> Result<(), RecordError> {
        if self.units.is_none() {
            name_measures(rec, rows, dt)?;
        }
        let units = self.units.get_or_insert_with(|| units(dt));
        let [short, long] = units.each_ref().map(|unit| unit.factor * dt);
        // In the order of the series; an undefined measure is a gap.
        let values = [
            Some(measures.recurrence_rate),
            measures.determinism,
            measures.laminarity,
            measures.mean_diagonal,
            Some(measures.longest_diagonal),
            measures.trapping_time,
            measures.recurrence_time_1,
            measures.recurrence_time_2,
            measures.entropy,
            measures.divergence,
            // TREND is per thousand states.
            measures.trend.map(|trend| 1e-3 * trend),
        ];
        for ((path, _, quantity, _), value) in SERIES.into_iter().zip(values) {
            let factor = match quantity {
                Quantity::Number => 1.0,
                Quantity::Short => short,
                Quantity::Long => long,
                Quantity::Rate => long.recip(),
            };
            let value = value.map_or(f64::NAN, |value| factor * value);
            rows.push(path, time, [value]);
        }
        let kinds = [
            RecurrenceKind::Finest,
            RecurrenceKind::Beat,
            RecurrenceKind::Doubled,
        ];
        let period = |kind| periods.last(kind).map_or(f64::NAN, |found| found.period);
        let periods = kinds.map(|kind| units[0].factor * period(kind));
        rows.push(paths::PERIOD, time, periods);
        Ok(())
    }
}

/// Units of short and long durations for the spacing of the states (s).
fn units(dt: f64) -> [Unit; 2] {
    [dt, LONG * dt].map(|duration| Unit::of("s", duration))
}

/// Names the series; the units depend on the spacing of the states (s).
fn name_measures(rec: &RecordingStream, rows: &mut Rows, dt: f64) -> Result<(), RecordError> {
    let [short, long] = units(dt).map(|unit| unit.symbol);
    for (path, name, quantity, color) in SERIES {
        let name = match quantity {
            Quantity::Number => name.to_owned(),
            Quantity::Short => format!("{name}, {short}"),
            Quantity::Long => format!("{name}, {long}"),
            Quantity::Rate => format!("{name}, 1/{long}"),
        };
        rows.name(rec, path, [(name, color)])?;
    }
    let periods = [
        ("finest period", style::ACCENT),
        ("beat", style::SIGNAL),
        ("doubled period", style::FRICTION),
    ];
    let periods = periods.map(|(name, color)| (format!("{name}, {short}"), color));
    rows.name(rec, paths::PERIOD, periods)
}
