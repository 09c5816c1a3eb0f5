//! Direction in which a tilt changes.

use serde::Serialize;

/// Direction in which a tilt changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TiltDirection {
    /// Rising, or at the maximum.
    Up,
    /// Falling, or at the minimum after a fall.
    Down,
}
