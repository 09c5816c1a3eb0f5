//! A sweep point as a table row: one column per field of a [`SettledResponse`].

use arrow_schema::FieldRef;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_arrow::schema::{SchemaLike, TracingOptions};

use super::{Place, Start, SweepPoint};
use crate::analysis::{
    ClosedCurves, Measures, RecurrenceKind, RecurrencePeriod, Regime, SpectralLine,
};
use crate::dynamics::{Exponent, LyapunovSpectrum, SolverStats};
use crate::joint::NamedMode;
use crate::study::StabilityAt;
use crate::study::response::{PhasePortrait, SettledResponse};

/// A table row; missing values are null.
#[derive(Serialize, Deserialize)]
pub(super) struct Row {
    #[serde(flatten)]
    place: Place,
    error: Option<String>,
    #[serde(flatten)]
    found: Option<SettledResponse>,
}

impl Row {
    /// The row of a point.
    pub fn new(point: &SweepPoint) -> Self {
        Self {
            place: point.place.clone(),
            error: point.outcome.as_ref().err().cloned(),
            found: point.outcome.as_ref().ok().cloned(),
        }
    }

    /// The point of a row, or the reason why the row is invalid.
    pub fn into_point(self) -> Result<SweepPoint, String> {
        let outcome = match (self.error, self.found) {
            (Some(error), _) => Err(error),
            (None, Some(found)) => Ok(found),
            (None, None) => {
                return Err(format!(
                    "the response of point {} is incomplete",
                    self.place.index
                ));
            }
        };
        Ok(SweepPoint {
            place: self.place,
            outcome,
        })
    }

    /// The columns of all rows.
    pub fn fields() -> Result<Vec<FieldRef>, serde_arrow::Error> {
        let options = TracingOptions::default()
            .map_as_struct(true)
            .enums_without_data_as_strings(true);
        Vec::from_samples(&[Self::complete(), Self::empty()], options)
    }

    /// A row without a response; it determines which columns are nullable.
    fn empty() -> Self {
        Self {
            place: Place {
                index: 0,
                start: Start::Fresh,
                values: vec![0.0],
            },
            error: None,
            found: None,
        }
    }

    /// A row with every value; it determines the types of the columns.
    fn complete() -> Self {
        let exponent = Exponent {
            value: 0.0,
            half_width: 0.0,
        };
        let found = SettledResponse {
            transient: 0.0,
            settled: true,
            amplitude: 0.0,
            rms_velocity: 0.0,
            peak_velocity: 0.0,
            regime: Regime::Silent,
            confidence: 0.0,
            broadband_share: 0.0,
            maxima: vec![0.0],
            section: vec![[0.0; 2]],
            curves: Some(ClosedCurves {
                count: 1,
                windings: 1,
            }),
            doubling: 0,
            lines: vec![SpectralLine {
                frequency: 0.0,
                amplitude: 0.0,
                label: String::new(),
            }],
            exponents: Some(LyapunovSpectrum {
                exponents: vec![exponent],
                time: 0.0,
                dimension: 0,
                resolution: 0.0,
                kaplan_yorke: Some(exponent),
            }),
            recurrence: Some(Measures {
                recurrence_rate: 0.0,
                determinism: Some(0.0),
                mean_diagonal: Some(0.0),
                longest_diagonal: 0.0,
                divergence: Some(0.0),
                entropy: Some(0.0),
                trend: Some(0.0),
                laminarity: Some(0.0),
                trapping_time: Some(0.0),
                longest_vertical: 0.0,
                recurrence_time_1: Some(0.0),
                recurrence_time_2: Some(0.0),
            }),
            recurrence_periods: [RecurrencePeriod {
                kind: RecurrenceKind::Finest,
                period: 0.0,
                uncertainty: 0.0,
                share: 0.0,
            }]
            .into_iter()
            .collect(),
            linear: Some(StabilityAt {
                tilt: 0.0,
                modes: vec![NamedMode {
                    frequency_hz: 0.0,
                    growth: 0.0,
                    label: String::new(),
                    unstable: false,
                }],
            }),
            state: vec![0.0],
            stats: SolverStats::default(),
            portrait: Some(PhasePortrait {
                dt: 0.0,
                displacement: vec![0.0],
                velocity: vec![0.0],
                bin: 0.0,
                spectrum: vec![0.0],
            }),
        };
        Self {
            error: Some(String::new()),
            found: Some(found),
            ..Self::empty()
        }
    }
}

/// A point in JSON: without the portrait and the final state, which only the table has.
#[derive(Serialize, Deserialize)]
struct Record {
    /// Row of the point in the table.
    #[serde(flatten)]
    row: Row,
    /// Number of unstable linear modes.
    unstable_modes: Option<usize>,
}

impl Serialize for SweepPoint {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut point = self.clone();
        let mut unstable_modes = None;
        if let Ok(found) = &mut point.outcome {
            let linear = found.linear.as_ref();
            unstable_modes = linear.map(|linear| linear.unstable().count());
            found.portrait = None;
            found.state.clear();
        }
        let row = Row::new(&point);
        let record = Record {
            row,
            unstable_modes,
        };
        record.serialize(to)
    }
}

impl<'de> Deserialize<'de> for SweepPoint {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let record = Record::deserialize(from)?;
        record.row.into_point().map_err(D::Error::custom)
    }
}
