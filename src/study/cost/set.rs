//! The settings of a cost study and their work-precision sets.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A setting of the scene whose cost and error are measured.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    strum::EnumString,
    strum::IntoStaticStr,
)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(into = "SettingRecord", try_from = "SettingRecord")]
#[strum(serialize_all = "lowercase")]
pub enum CostSetting {
    /// Method and tolerance, by the error of the trajectory.
    Integrator,
    /// Tolerance, by the error of invariants.
    Invariants,
    /// Event handling: steps through events, or exact event location.
    Events,
    /// Quadrature and number of contact nodes.
    Nodes,
    /// Number of modes.
    Modes,
    /// Order and size of the finite elements.
    Elements,
    /// Averaging time of Lyapunov exponents.
    Exponents,
    /// Number of states and threshold of recurrence quantification.
    Recurrence,
    /// All settings together: the cheapest combination for a total error.
    Budget,
}

/// JSON form of a setting.
#[derive(Serialize, Deserialize)]
struct SettingRecord {
    /// Name of the setting, as on the command line.
    setting: Cow<'static, str>,
    /// Measure of the error of the points.
    error_measure: Cow<'static, str>,
}

impl From<CostSetting> for SettingRecord {
    fn from(setting: CostSetting) -> Self {
        Self {
            setting: setting.name().into(),
            error_measure: setting.error().into(),
        }
    }
}

impl TryFrom<SettingRecord> for CostSetting {
    type Error = strum::ParseError;

    fn try_from(record: SettingRecord) -> Result<Self, strum::ParseError> {
        record.setting.parse()
    }
}

impl CostSetting {
    /// All settings.
    pub const ALL: [Self; 9] = [
        Self::Integrator,
        Self::Invariants,
        Self::Events,
        Self::Nodes,
        Self::Modes,
        Self::Elements,
        Self::Exponents,
        Self::Recurrence,
        Self::Budget,
    ];

    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Measure of the error of the points.
    pub fn error(self) -> &'static str {
        match self {
            Self::Integrator | Self::Events | Self::Nodes => "largest error of the state",
            Self::Modes | Self::Invariants => "relative error",
            Self::Elements => "largest error of a natural frequency",
            Self::Exponents => "half-width of λ1, 1/s",
            Self::Recurrence => "error of the determinism",
            Self::Budget => "verified total relative error",
        }
    }
}

/// A work-precision set: one setting varied within a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkPrecisionSet {
    /// The setting.
    #[serde(flatten)]
    pub setting: CostSetting,
    /// Family: a method, a quadrature or a threshold.
    pub family: String,
    /// Name and unit of the varied parameter, such as `tolerance`.
    #[serde(rename = "parameter")]
    pub parameter: Cow<'static, str>,
    /// Error of the reference solution; `None` if it is unknown.
    #[serde(rename = "reference_error")]
    pub floor: Option<f64>,
    /// The points in order of the varied parameter.
    pub points: Vec<WorkPrecisionPoint>,
}

/// A work-precision point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkPrecisionPoint {
    /// Value of the varied parameter, in the unit given by `parameter` of the set.
    pub value: f64,
    /// Median CPU time of the repeats, s.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Right-hand-side evaluations; 0 if there are none.
    pub rhs_evals: u64,
    /// The error, or the error message of a failed run.
    #[serde(flatten, with = "ErrorOrReason")]
    pub error: Result<f64, String>,
    /// Detail of the point, such as the modes or the number of events; may be empty.
    pub detail: String,
}

/// JSON form of the error.
#[derive(Serialize, Deserialize)]
struct ErrorOrReason {
    /// Error of the point; `null` if the run failed.
    error: Option<f64>,
    /// Error message of a failed run; `null` otherwise.
    failed: Option<String>,
}

impl ErrorOrReason {
    fn serialize<S: Serializer>(error: &Result<f64, String>, to: S) -> Result<S::Ok, S::Error> {
        let record = Self {
            error: error.as_ref().ok().copied(),
            failed: error.as_ref().err().cloned(),
        };
        Serialize::serialize(&record, to)
    }

    fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Result<f64, String>, D::Error> {
        let record = <Self as Deserialize>::deserialize(from)?;
        let error = record.error.unwrap_or(f64::INFINITY);
        Ok(record.failed.map_or(Ok(error), Err))
    }
}
