//! One passage through a surface, and its direction.

/// Which way through the surface counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Direction {
    /// From negative to positive.
    #[default]
    Rising,
    /// From positive to negative.
    Falling,
    /// Both.
    Both,
}

impl Direction {
    /// Whether a passage this way counts.
    pub(super) fn counts(self, rising: bool) -> bool {
        match self {
            Self::Rising => rising,
            Self::Falling => !rising,
            Self::Both => true,
        }
    }
}

/// One passage.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// When, in samples from the first one; fractional.
    pub sample: f64,
    /// Where: the value of each channel then.
    pub point: Vec<f64>,
    /// Whether it went from negative to positive.
    pub rising: bool,
}
