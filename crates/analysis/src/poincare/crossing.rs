//! A crossing of a surface, and its direction.

/// Direction of the crossings that count.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumString,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Direction {
    /// From negative to positive.
    #[default]
    Rising,
    /// From positive to negative.
    Falling,
    /// Both directions.
    Both,
}

impl Direction {
    /// Whether a crossing in this direction counts.
    pub(super) fn counts(self, rising: bool) -> bool {
        match self {
            Self::Rising => rising,
            Self::Falling => !rising,
            Self::Both => true,
        }
    }
}

/// A crossing of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Instant, in samples from the first one; fractional.
    pub sample: f64,
    /// Value of each channel at that instant.
    pub point: Vec<f64>,
    /// Whether it goes from negative to positive.
    pub rising: bool,
}
