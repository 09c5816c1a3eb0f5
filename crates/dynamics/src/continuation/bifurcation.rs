//! Bifurcations of periodic orbits.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Multiplier, PeriodicOrbit};

/// The type of a bifurcation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum BifurcationKind {
    /// Fold: a multiplier at 1, and the branch turns in the parameter.
    Fold,
    /// Period doubling: a multiplier at -1.
    #[strum(serialize = "period doubling")]
    PeriodDoubling,
    /// Neimark-Sacker: a complex pair on the unit circle. A torus is born.
    #[strum(serialize = "Neimark-Sacker")]
    NeimarkSacker,
    /// Branch point: a multiplier at 1 without a fold. Another branch crosses.
    #[strum(serialize = "branch point")]
    BranchPoint,
    /// Grazing: a guard touches zero.
    Grazing,
}

/// A strong resonance of a Neimark-Sacker point: a rotation number close to 1/2, 1/3 or 1/4, at which the theory of the
/// torus does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
pub enum Resonance {
    /// Rotation number 1/2.
    #[serde(rename = "1:2")]
    #[strum(serialize = "1:2")]
    OneToTwo,
    /// Rotation number 1/3.
    #[serde(rename = "1:3")]
    #[strum(serialize = "1:3")]
    OneToThree,
    /// Rotation number 1/4.
    #[serde(rename = "1:4")]
    #[strum(serialize = "1:4")]
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

/// How a motion is born at a bifurcation at which another one loses its stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Criticality {
    /// It exists where the other one is unstable, and attracts if nothing else is unstable.
    Supercritical,
    /// It exists where the other one is stable, and repels.
    Subcritical,
    /// The sign of the cubic coefficient cannot be determined.
    Undetermined,
}

/// The birth of a motion at a period doubling or a Neimark-Sacker point, by the normal form of the return map.
///
/// Next to the point, the complex amplitude `w` of the critical direction, in units of the size of the orbit, becomes
/// `w exp(i phi) (1 + ln|multiplier| + a |w|^2)` over a return; at a period doubling it is real and becomes
/// `-w (1 + ln|multiplier|) + c w^3`. The amplitude of the new motion is `sqrt(-ln|multiplier| / a)`, or
/// `sqrt(ln|multiplier| / c)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MotionBirth {
    /// Criticality of the bifurcation.
    pub criticality: Criticality,
    /// Cubic coefficient `a` of a Neimark-Sacker point, or `c` of a period doubling.
    pub coefficient: f64,
    /// Error estimate of the coefficient.
    pub coefficient_error: f64,
}

/// A bifurcation of a branch of periodic orbits.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
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
    /// The birth of the motion of twice the period or of the torus; `None` for other bifurcations, and at a strong resonance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub birth: Option<MotionBirth>,
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

impl Bifurcation {
    /// Whether the motion attracts on one side: no multiplier except the critical ones is outside the unit circle.
    ///
    /// The critical ones do not count, wherever the located orbit has them: at a fold they leave the unit circle with the
    /// square root of the distance from it, on one side or the other.
    pub fn has_stable_side(&self) -> bool {
        let critical = critical_multiplier(self.kind, &self.orbit);
        let is_critical = |multiplier: &Multiplier| {
            critical.is_some_and(|critical| {
                multiplier.ln_magnitude == critical.ln_magnitude
                    && multiplier.angle.abs() == critical.angle.abs()
            })
        };
        let all = self.orbit.nontrivial_multipliers();
        let mut others = all.filter(|multiplier| !is_critical(multiplier));
        !others.any(|multiplier| multiplier.ln_magnitude > self.orbit.circle_width())
    }
}

/// The critical multiplier of an orbit at or near a bifurcation, of a pair the one with the positive angle.
pub(super) fn critical_multiplier(
    kind: BifurcationKind,
    orbit: &PeriodicOrbit,
) -> Option<Multiplier> {
    let all = orbit.nontrivial_multipliers();
    let distance: &dyn Fn(&Multiplier) -> f64 = match kind {
        BifurcationKind::Fold | BifurcationKind::BranchPoint => {
            &|multiplier| multiplier.distance_from(1.0)
        }
        BifurcationKind::PeriodDoubling => &|multiplier| multiplier.distance_from(-1.0),
        BifurcationKind::NeimarkSacker => {
            return all
                .filter(|multiplier| !multiplier.is_real() && multiplier.angle > 0.0)
                .min_by(|a, b| a.ln_magnitude.abs().total_cmp(&b.ln_magnitude.abs()));
        }
        BifurcationKind::Grazing => return None,
    };
    all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
