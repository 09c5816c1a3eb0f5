//! What can be turned, and what comes of it.

use serde::{Serialize, Serializer};

/// What can be turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(into = "KnobRecord")]
#[strum(serialize_all = "lowercase")]
pub enum Knob {
    /// Method and tolerance, by the trajectory.
    Integrator,
    /// Tolerance, by what does not depend on the trajectory.
    Invariants,
    /// Through events or exactly there.
    Events,
    /// Family and number of contact nodes.
    Nodes,
    /// Number of modes.
    Modes,
    /// Order and size of the finite elements.
    Elements,
    /// Length of averaging for Lyapunov exponents.
    Exponents,
    /// Length and threshold of recurrence quantification.
    Recurrence,
}

/// A knob as JSON has it.
#[derive(Serialize)]
struct KnobRecord {
    /// The knob, as on the command line.
    knob: &'static str,
    /// What the error of its points is.
    error_is: &'static str,
}

impl From<Knob> for KnobRecord {
    fn from(knob: Knob) -> Self {
        Self {
            knob: knob.name(),
            error_is: knob.error(),
        }
    }
}

impl Knob {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Integrator,
        Self::Invariants,
        Self::Events,
        Self::Nodes,
        Self::Modes,
        Self::Elements,
        Self::Exponents,
        Self::Recurrence,
    ];

    /// Its name, as on the command line.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What the error of its points is.
    pub fn error(self) -> &'static str {
        match self {
            Self::Integrator | Self::Events | Self::Nodes => "largest error of the state",
            Self::Modes | Self::Invariants => "relative error",
            Self::Elements => "largest error of a natural frequency",
            Self::Exponents => "half width of λ1, 1/s",
            Self::Recurrence => "error of the determinism",
        }
    }
}

/// A knob turned through a family of settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostSet {
    /// The knob.
    #[serde(flatten)]
    pub knob: Knob,
    /// The settings' family: a method, a quadrature, a threshold.
    pub family: String,
    /// What is turned within it: `tolerance`, `nodes`.
    pub turned: &'static str,
    /// The error of the reference itself; `None` where there is none to compare with.
    #[serde(rename = "reference_error")]
    pub floor: Option<f64>,
    /// The points.
    pub points: Vec<CostPoint>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostPoint {
    /// The setting, in the unit of [`CostSet::turned`].
    pub value: f64,
    /// CPU time, s: the median of the repeated runs.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Calls of the right-hand side; 0 where there are none.
    pub calls: u64,
    /// Its error, or why there is none.
    #[serde(flatten, serialize_with = "error_or_reason")]
    pub error: Result<f64, String>,
    /// What its value does not tell: which modes these are, how many events there were. Empty where that
    /// is nothing.
    pub detail: String,
}

/// The error, or why there is none, as JSON has it.
fn error_or_reason<S: Serializer>(
    error: &Result<f64, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record<'a> {
        /// Its error; `null` where it failed.
        error: Option<f64>,
        /// Why it failed; `null` where it did not.
        failed: Option<&'a String>,
    }
    let (error, failed) = (error.as_ref().ok().copied(), error.as_ref().err());
    Record { error, failed }.serialize(serializer)
}
