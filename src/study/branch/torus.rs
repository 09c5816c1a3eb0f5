//! A torus beyond a Neimark-Sacker point.

use schemars::JsonSchema;
use serde::Serialize;

use super::at::At;

/// The motion at a value of the parameter beyond a Neimark-Sacker point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum TorusKind {
    /// Two base frequencies.
    Torus,
    /// Two base frequencies, with lines at halves of their combinations: the torus is doubled.
    Doubled,
    /// Phase-locked: a periodic motion whose frequencies have a ratio of integers.
    Locked,
    /// Without a second tone: the torus has vanished.
    Vanished,
    /// Frequencies that do not settle: the motion is irregular.
    Irregular,
}

/// A settled motion beyond a Neimark-Sacker point.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TorusPoint {
    /// Kind of the motion.
    pub kind: TorusKind,
    /// Frequency of the first tone, Hz.
    pub first_hz: f64,
    /// Second base frequency: distance of the side lines from the first tone, Hz. `None` without a second tone.
    pub second_hz: Option<f64>,
    /// Amplitude of the strongest side line relative to the strongest line.
    pub side_line: f64,
    /// Rotation number: the second frequency over the first.
    pub rotation_number: Option<f64>,
    /// Error of the rotation number: half the difference between the halves of the time. Zero if the motion is locked.
    pub rotation_number_error: Option<f64>,
    /// Phase locking: rotation number `p/q` as `[p, q]` if the motion is locked.
    pub locking: Option<[u32; 2]>,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// A phase-locked tongue: an interval of the parameter with a stable periodic orbit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Tongue {
    /// Phase locking: rotation number `p/q` as `[p, q]`.
    pub locking: [u32; 2],
    /// The folds that are its borders, in ascending order; `None` where the orbit ends in another way.
    pub borders: [Option<f64>; 2],
}

/// A torus from its birth on.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Torus {
    /// Number of the branch of periodic orbits from which it is born.
    pub branch: usize,
    /// Value of the parameter at which the torus is born: the Neimark-Sacker point.
    pub born: f64,
    /// The settled motions, in their order away from this point.
    pub points: Vec<TorusPoint>,
    /// The phase-locked tongues found, each with its `locking` as `[p, q]` and its two `borders` in ascending order.
    pub tongues: Vec<Tongue>,
    /// Why the study of the torus ended before the last value, if it did.
    pub ended: Option<String>,
}
