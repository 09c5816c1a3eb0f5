//! The mechanisms by which friction makes things squeal: what a scene can teach.

use strum::VariantArray;

/// A mechanism that a scene shows. Its lesson explains it beside the picture that proves it, with
/// numbers measured in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Mechanism {
    /// Friction that falls with the sliding speed feeds one mode.
    NegativeSlope,
    /// Two modes flutter together under a constant coefficient of friction.
    ModeCoupling,
    /// What slides comes to rest on what drags it, and tears itself off again.
    StickSlip,
    /// The contact opens and hammers.
    LiftOff,
    /// The two slope factors of Eq. (5) as printed, and exchanged: silence or squeal.
    ExchangedFriction,
    /// Several modes are unstable, and the kick decides which one is heard.
    WhichModeWins,
    /// The motion changes at another tilt on the way up than on the way down.
    Hysteresis,
    /// Two tones without a common period, and their difference.
    Torus,
    /// Two copies that start almost alike part.
    Chaos,
    /// What the complex eigenvalues foretell, against what is heard.
    Prediction,
}

impl Mechanism {
    /// All of them.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// Its name in a scene file.
    pub fn name(self) -> &'static str {
        self.into()
    }
}
