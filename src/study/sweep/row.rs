//! A sweep point as a table row: one column per field of a [`SettledResponse`].

use std::borrow::Cow;
use std::sync::Arc;

use arrow_schema::{DataType, FieldRef};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize, Serializer};
use serde_arrow::schema::{SchemaLike, TracingOptions};

use super::{Place, Start, SweepPoint};
use crate::analysis::{
    ClosedCurves, Measures, RecurrenceKind, RecurrencePeriod, Regime, SpectralLine,
};
use crate::dynamics::{Exponent, LyapunovSpectrum, SolverStats};
use crate::joint::NamedMode;
use crate::study::StabilityAt;
use crate::study::response::{PhasePortrait, SettledResponse};

/// A table row without the values of the parameters; missing values are null.
#[derive(Serialize, Deserialize)]
pub(super) struct Row {
    /// Index of the point, from 0; the first axis varies fastest, the start slowest.
    index: usize,
    /// Start of the point.
    start: Start,
    /// Error message of a point without a response.
    error: Option<String>,
    #[serde(flatten)]
    leading: Leading,
    #[serde(flatten)]
    found: Option<SettledResponse>,
}

/// The first entries of the lists of a response, and numbers that follow from them: for readers that have no lists.
#[derive(Default, Serialize, Deserialize)]
struct Leading {
    /// Frequency of line 1, the strongest, Hz.
    line_1_hz: Option<f64>,
    /// Amplitude of line 1, m.
    line_1_amplitude_m: Option<f64>,
    /// Name of line 1.
    line_1_name: Option<String>,
    /// Frequency of line 2, the second strongest, Hz.
    line_2_hz: Option<f64>,
    /// Amplitude of line 2, m.
    line_2_amplitude_m: Option<f64>,
    /// Name of line 2.
    line_2_name: Option<String>,
    /// Exponent 1, the largest, 1/s.
    exponent_1_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 1, 1/s.
    exponent_1_half_width_per_s: Option<f64>,
    /// Exponent 2, 1/s.
    exponent_2_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 2, 1/s.
    exponent_2_half_width_per_s: Option<f64>,
    /// Exponent 3, 1/s.
    exponent_3_per_s: Option<f64>,
    /// Half-width of the 95 % interval of exponent 3, 1/s.
    exponent_3_half_width_per_s: Option<f64>,
    /// Finest recurrence period, s.
    recurrence_period_finest_s: Option<f64>,
    /// Recurrence period of the beat, s.
    recurrence_period_beat_s: Option<f64>,
    /// Doubled recurrence period, s.
    recurrence_period_doubled_s: Option<f64>,
    /// Number of unstable linear modes.
    unstable_modes: Option<u64>,
}

impl Leading {
    /// Every value, where the response has one line and one exponent.
    fn complete(found: &SettledResponse) -> Self {
        Self {
            line_2_hz: Some(0.0),
            line_2_amplitude_m: Some(0.0),
            line_2_name: Some(String::new()),
            exponent_2_per_s: Some(0.0),
            exponent_2_half_width_per_s: Some(0.0),
            exponent_3_per_s: Some(0.0),
            exponent_3_half_width_per_s: Some(0.0),
            recurrence_period_beat_s: Some(0.0),
            recurrence_period_doubled_s: Some(0.0),
            ..Self::of(found)
        }
    }

    fn of(found: &SettledResponse) -> Self {
        let line = |k: usize| found.lines.get(k);
        let exponent = |k: usize| found.exponents.as_ref()?.exponents.get(k);
        let period = |found: Option<&RecurrencePeriod>| found.map(|found| found.period);
        let linear = found.linear.as_ref();
        Self {
            line_1_hz: line(0).map(|line| line.frequency),
            line_1_amplitude_m: line(0).map(|line| line.amplitude),
            line_1_name: line(0).map(|line| line.label.clone()),
            line_2_hz: line(1).map(|line| line.frequency),
            line_2_amplitude_m: line(1).map(|line| line.amplitude),
            line_2_name: line(1).map(|line| line.label.clone()),
            exponent_1_per_s: exponent(0).map(|e| e.value),
            exponent_1_half_width_per_s: exponent(0).map(|e| e.half_width),
            exponent_2_per_s: exponent(1).map(|e| e.value),
            exponent_2_half_width_per_s: exponent(1).map(|e| e.half_width),
            exponent_3_per_s: exponent(2).map(|e| e.value),
            exponent_3_half_width_per_s: exponent(2).map(|e| e.half_width),
            recurrence_period_finest_s: period(found.recurrence_periods.finest()),
            recurrence_period_beat_s: period(found.recurrence_periods.beat()),
            recurrence_period_doubled_s: period(found.recurrence_periods.doubled()),
            unstable_modes: linear.map(|linear| linear.unstable().count() as u64),
        }
    }
}

impl Row {
    /// The row of a point.
    pub fn new(point: &SweepPoint) -> Self {
        let found = point.outcome.as_ref().ok();
        Self {
            index: point.place.index,
            start: point.place.start,
            error: point.outcome.as_ref().err().cloned(),
            leading: found.map(Leading::of).unwrap_or_default(),
            found: found.cloned(),
        }
    }

    /// The point of a row with these values of the parameters, or the reason why the row is invalid.
    pub fn into_point(self, values: Vec<f64>) -> Result<SweepPoint, String> {
        let place = Place {
            index: self.index,
            start: self.start,
            values,
        };
        point(place, self.error, self.found)
    }

    /// The columns of all rows.
    pub fn fields() -> Result<Vec<FieldRef>, serde_arrow::Error> {
        let options = TracingOptions::default()
            .map_as_struct(true)
            .enums_without_data_as_strings(true);
        let fields = Vec::<FieldRef>::from_samples(&[Self::complete(), Self::empty()], options)?;
        // Words as plain text: the batches of an Arrow file may not differ in a dictionary.
        let plain = |field: FieldRef| match field.data_type() {
            DataType::Dictionary(..) => {
                Arc::new(field.as_ref().clone().with_data_type(DataType::LargeUtf8))
            }
            _ => field,
        };
        Ok(fields.into_iter().map(plain).collect())
    }

    /// A row without a response; it determines which columns are nullable.
    fn empty() -> Self {
        Self {
            index: 0,
            start: Start::Fresh,
            error: None,
            leading: Leading::default(),
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
            leading: Leading::complete(&found),
            found: Some(found),
            ..Self::empty()
        }
    }
}

/// The point of an error or of a response.
fn point(
    place: Place,
    error: Option<String>,
    found: Option<SettledResponse>,
) -> Result<SweepPoint, String> {
    let outcome = match (error, found) {
        (Some(error), _) => Err(error),
        (None, Some(found)) => Ok(found),
        (None, None) => {
            return Err(format!(
                "the response of point {} is incomplete",
                place.index
            ));
        }
    };
    Ok(SweepPoint { place, outcome })
}

/// A point in JSON: without the portrait and the final state, which only the table has.
#[derive(Serialize, JsonSchema)]
struct Record {
    #[serde(flatten)]
    place: Place,
    /// Error message of a point without a response.
    error: Option<String>,
    #[serde(flatten)]
    found: Option<SettledResponse>,
    /// Number of unstable linear modes.
    unstable_modes: Option<usize>,
}

impl Serialize for SweepPoint {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let SweepPoint { place, outcome } = self.clone();
        let error = outcome.as_ref().err().cloned();
        let mut found = outcome.ok();
        let mut unstable_modes = None;
        if let Some(found) = &mut found {
            let linear = found.linear.as_ref();
            unstable_modes = linear.map(|linear| linear.unstable().count());
            found.portrait = None;
            found.state.clear();
        }
        let record = Record {
            place,
            error,
            found,
            unstable_modes,
        };
        record.serialize(to)
    }
}

impl JsonSchema for SweepPoint {
    fn schema_name() -> Cow<'static, str> {
        "SweepPoint".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Record::json_schema(generator)
    }
}
