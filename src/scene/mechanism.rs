//! Mechanisms of friction-induced vibration that a scene can demonstrate.

use strum::VariantArray;

/// A mechanism that a scene demonstrates. Its lesson explains the mechanism next to the view that shows it,
/// with numbers measured in the run.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Hash,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumString,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Mechanism {
    /// Friction that decreases with sliding speed excites one mode.
    NegativeSlope,
    /// Two modes couple and flutter at a constant coefficient of friction.
    ModeCoupling,
    /// A mass or contact node sticks to the moving surface and slips periodically.
    StickSlip,
    /// Contact nodes separate and impact.
    LiftOff,
    /// The two slope factors of Eq. (5) as printed and exchanged: stable sliding or squeak.
    ExchangedFriction,
    /// Several modes are unstable, and the initial kick determines the mode that dominates.
    WhichModeWins,
    /// The regime changes at a higher tilt on the upward ramp than on the downward ramp.
    Hysteresis,
    /// Two incommensurate frequencies and their combination frequencies.
    Torus,
    /// A periodic motion becomes a torus when a pair of its Floquet multipliers leaves the unit circle.
    TorusBirth,
    /// A perturbed trajectory diverges exponentially from the original.
    Chaos,
    /// Elastic bristles bend before the contact slides, and reduce the slope of friction for fast oscillations.
    Bristles,
    /// Friction follows the sliding speed only after a slip distance.
    ContactAge,
    /// Friction given by the points of a measurement.
    MeasuredFriction,
    /// A joint that turns to and fro squeaks between two tilts of each pass.
    Articulation,
    /// Predictions of the complex eigenvalues compared with the simulated vibration.
    Prediction,
}

impl Mechanism {
    /// All mechanisms.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// Name in a scene file.
    pub fn name(self) -> &'static str {
        self.into()
    }
}
