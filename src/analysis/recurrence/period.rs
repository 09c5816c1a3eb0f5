//! Periods of a motion from the spacing of the diagonals in its recurrence plot.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::RecurrenceCounts;
use super::modulation::{Modulation, modulations};
use super::stripes::Stripes;
use crate::analysis::mean;

/// Minimum recurrence rate along the highest diagonals at the better half of the multiples of a longer period.
/// On a torus it is close to 1: all states return together. Chaotic motion returns only in part.
const MIN_RATE: f64 = 0.85;

/// What a recurrence period is in relation to the shorter ones of the same plot.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    JsonSchema,
    strum::Display,
    strum::EnumString,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum RecurrenceKind {
    /// The finest spacing of the diagonals: the period of a periodic motion.
    Finest,
    /// A longer period in which the motion returns closer: the beat of a torus, or a subharmonic.
    Beat,
    /// Twice a shorter period of the set, or a further doubling of it.
    Doubled,
}

/// A spacing of the diagonals of a recurrence plot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RecurrencePeriod {
    /// Relation to the shorter periods.
    pub kind: RecurrenceKind,
    /// The period, states (s in output).
    #[serde(rename = "period_s")]
    pub period: f64,
    /// Standard uncertainty of the period, states (s in output).
    #[serde(rename = "uncertainty_s")]
    pub uncertainty: f64,
    /// Share of the recurrent points that lie on the diagonals nearest to the multiples of the period, 0
    /// to 1. Diagonals belong to the stripe of a multiple of the finest period down to half its height.
    pub share: f64,
}

/// The set of spacings of the diagonals of a recurrence plot, shortest first.
///
/// A motion of period `P` recurs after `P`, `2 P`, ...: its plot has stripes at these offsets. A periodic
/// motion has one spacing. On a torus the stripes are widest and densest where the longer period recurs as
/// well; their heights repeat with the beat. After a period doubling every second stripe is higher. Noise
/// has none, chaos none or the finest: it returns by chance, and less with time. A doubling of less than a fifth
/// of the amplitude may be missed. Kang et al. (2022) read the
/// periods from the plots in this way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct RecurrencePeriods {
    /// The recurrence periods, shortest first.
    periods: Vec<RecurrencePeriod>,
}

impl RecurrencePeriods {
    /// The periods, shortest first.
    pub fn iter(&self) -> std::slice::Iter<'_, RecurrencePeriod> {
        self.periods.iter()
    }

    /// The finest spacing of the diagonals.
    pub fn finest(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Finest)
    }

    /// The longest beat.
    pub fn beat(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Beat)
    }

    /// The longest doubled period.
    pub fn doubled(&self) -> Option<&RecurrencePeriod> {
        self.last(RecurrenceKind::Doubled)
    }

    /// The longest period of a kind.
    pub fn last(&self, kind: RecurrenceKind) -> Option<&RecurrencePeriod> {
        self.periods.iter().rfind(|period| period.kind == kind)
    }

    /// Converts states to times. `state` is the time between successive states, s.
    pub fn in_seconds(mut self, state: f64) -> Self {
        for period in &mut self.periods {
            period.period *= state;
            period.uncertainty *= state;
        }
        self
    }
}

impl FromIterator<RecurrencePeriod> for RecurrencePeriods {
    fn from_iter<I: IntoIterator<Item = RecurrencePeriod>>(periods: I) -> Self {
        let mut all: Vec<_> = periods.into_iter().collect();
        all.sort_by(|a, b| a.period.total_cmp(&b.period));
        Self { periods: all }
    }
}

impl RecurrenceCounts {
    /// Spacings of the diagonals, states.
    pub fn periods(&self) -> RecurrencePeriods {
        let Some(stripes) = Stripes::of(self) else {
            return RecurrencePeriods::default();
        };
        let mut all = vec![RecurrencePeriod {
            kind: RecurrenceKind::Finest,
            period: stripes.spacing,
            uncertainty: stripes.uncertainty,
            share: stripes.shares.iter().sum(),
        }];
        let longer = modulations(&stripes.heights);
        all.extend(longer.iter().filter_map(|found| stripes.at(found)));
        all.into_iter().collect()
    }
}

impl Stripes {
    /// The period of a modulation, if most states return after its multiples.
    fn at(&self, found: &Modulation) -> Option<RecurrencePeriod> {
        let ratio = 1.0 / found.frequency;
        let nearest = (1..).map(|i| (f64::from(i) * ratio).round() as usize - 1);
        let multiples: Vec<usize> = nearest.take_while(|&j| j < self.shares.len()).collect();
        let mut rates: Vec<f64> = multiples.iter().map(|&j| self.peaks[j]).collect();
        rates.sort_by(f64::total_cmp);
        // A third period lowers the rate at some of the multiples.
        let best = &rates[rates.len() / 2..];
        let rate = mean(best);
        let uncertainty = self
            .uncertainty
            .hypot(ratio * found.uncertainty * self.spacing);
        (rate >= MIN_RATE).then(|| RecurrencePeriod {
            kind: match found.doubled {
                true => RecurrenceKind::Doubled,
                false => RecurrenceKind::Beat,
            },
            period: ratio * self.spacing,
            uncertainty: ratio * uncertainty,
            share: multiples.iter().map(|&j| self.shares[j]).sum(),
        })
    }
}

#[cfg(test)]
#[path = "period_tests.rs"]
mod tests;
