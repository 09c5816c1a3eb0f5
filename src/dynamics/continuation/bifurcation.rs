//! Bifurcations of periodic orbits.

use serde::{Deserialize, Serialize};

use super::PeriodicOrbit;

/// The type of a bifurcation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BifurcationKind {
    /// Fold: a multiplier at 1, and the branch turns in the parameter.
    Fold,
    /// Period doubling: a multiplier at -1.
    PeriodDoubling,
    /// Neimark-Sacker: a complex pair on the unit circle. A torus is born.
    NeimarkSacker,
    /// Branch point: a multiplier at 1 without a fold. Another branch crosses.
    BranchPoint,
    /// A branch point at which the critical direction breaks the symmetry of the family and of the orbit.
    SymmetryBreaking,
    /// Grazing: a guard touches zero.
    Grazing,
}

/// A strong resonance of a Neimark-Sacker point: a rotation number close to 1/2, 1/3 or 1/4, at which the theory of the
/// torus does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Resonance {
    /// Rotation number 1/2.
    #[serde(rename = "1:2")]
    OneToTwo,
    /// Rotation number 1/3.
    #[serde(rename = "1:3")]
    OneToThree,
    /// Rotation number 1/4.
    #[serde(rename = "1:4")]
    OneToFour,
}

impl Resonance {
    /// Distance of the rotation number from a strong resonance within which it is flagged.
    pub const WIDTH: f64 = 0.005;

    /// The strong resonance of a rotation number, if there is one.
    pub fn of(rotation_number: f64) -> Option<Self> {
        let all = [
            (0.5, Self::OneToTwo),
            (1.0 / 3.0, Self::OneToThree),
            (0.25, Self::OneToFour),
        ];
        all.into_iter()
            .find(|(at, _)| (rotation_number - at).abs() <= Self::WIDTH)
            .map(|(_, resonance)| resonance)
    }
}

/// A bifurcation of a branch of periodic orbits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bifurcation {
    /// Type.
    pub kind: BifurcationKind,
    /// Value of the parameter.
    pub parameter: f64,
    /// Estimated error of the parameter, in its unit.
    pub accuracy: f64,
    /// Frequency of the orbit, Hz.
    pub frequency_hz: f64,
    /// Rotation number of the torus, 0 to 1/2, for a Neimark-Sacker point.
    pub rotation_number: Option<f64>,
    /// Second base frequency of the torus, Hz: the rotation number times the frequency, for a Neimark-Sacker point.
    pub torus_frequency_hz: Option<f64>,
    /// Strong resonance of a Neimark-Sacker point.
    pub resonance: Option<Resonance>,
    /// Rate `d ln|multiplier| / d parameter` of the critical multiplier along the branch, for a period doubling or a
    /// Neimark-Sacker point. It is not zero if the bifurcation is non-degenerate.
    pub crossing_rate: Option<f64>,
    /// Second derivative of the parameter with respect to the arclength at a fold, in the unit of the parameter. It is
    /// negative if the orbits exist below this value, and not zero if the fold is non-degenerate.
    pub fold_curvature: Option<f64>,
    /// Index of the guard that touches zero, for a grazing.
    pub guard: Option<usize>,
    /// The change of the number of multipliers outside the unit circle, in the order of the points of the branch.
    pub unstable_change: i32,
    /// The orbit; for a branch point an orbit close to it.
    pub orbit: PeriodicOrbit,
}
