//! The quantities of an error budget.

use serde::{Deserialize, Serialize};

/// A quantity whose total error is bounded.
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
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Quantity {
    /// Frequency of the strongest line of the displacement, Hz.
    Frequency,
    /// Half the peak-to-peak displacement, m.
    Amplitude,
    /// RMS velocity, m/s.
    Rms,
    /// Largest growth rate of the linear modes of steady sliding, 1/s.
    Growth,
    /// Largest Lyapunov exponent, 1/s.
    Lyapunov,
    /// Tilt nearest to that of the scene at which steady sliding becomes unstable, deg.
    Border,
}

impl Quantity {
    /// The default quantities.
    pub const DEFAULT: [Self; 3] = [Self::Frequency, Self::Amplitude, Self::Rms];

    /// Name, as on the command line and in `[[accuracy.budget]]`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Unit of the value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Frequency => "Hz",
            Self::Amplitude => "m",
            Self::Rms => "m/s",
            Self::Growth | Self::Lyapunov => "1/s",
            Self::Border => "deg",
        }
    }

    /// Whether the quantity follows from the linear modes alone, without a simulation.
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Growth | Self::Border)
    }
}

/// A quantity of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QuantityValue {
    /// The quantity.
    pub quantity: Quantity,
    /// Its value, in SI units (the border in degrees); `None` if it is not defined for this motion.
    pub value: Option<f64>,
    /// Reason why it is undefined.
    pub undefined: Option<String>,
}

/// Targets of a budget, unless others are requested.
pub const BUDGET_TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];
