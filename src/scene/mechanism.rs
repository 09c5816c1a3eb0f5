//! The mechanisms by which friction makes things squeal: what a scene can teach.

/// A mechanism that a scene shows. Its lesson explains it beside the picture that proves it, with
/// numbers measured in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    pub const ALL: [Self; 10] = [
        Self::NegativeSlope,
        Self::ModeCoupling,
        Self::StickSlip,
        Self::LiftOff,
        Self::ExchangedFriction,
        Self::WhichModeWins,
        Self::Hysteresis,
        Self::Torus,
        Self::Chaos,
        Self::Prediction,
    ];

    /// Its name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NegativeSlope => "negative-slope",
            Self::ModeCoupling => "mode-coupling",
            Self::StickSlip => "stick-slip",
            Self::LiftOff => "lift-off",
            Self::ExchangedFriction => "exchanged-friction",
            Self::WhichModeWins => "which-mode-wins",
            Self::Hysteresis => "hysteresis",
            Self::Torus => "torus",
            Self::Chaos => "chaos",
            Self::Prediction => "prediction",
        }
    }
}
