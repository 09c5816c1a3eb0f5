//! Poincare sections: crossings of a surface by a trajectory.
//!
//! The surface is a level of one coordinate. Samples are almost never on it. Each crossing is
//! located between two samples on an interpolating polynomial ([`SectionFinder`]), and all coordinates
//! are evaluated at that instant. For smooth signals the error is 1e-9 of the sample spacing or less,
//! which makes the points of a section as sharp as the motion.
//!
//! The shape of a section characterises the motion (Fig. 10): a periodic motion gives a few points, a
//! torus a closed curve, chaos an arc or a cloud. [`SectionShape`] classifies it,
//! [`closed_curves`] counts the curves of a doubled torus.

mod curves;
mod finder;
mod interpolation;
mod shape;

use schemars::JsonSchema;
use serde::Serialize;

use crate::{AnalysisError, delay::DelayVectors};

pub use curves::{ClosedCurves, closed_curves};
pub use finder::{Crossing, Direction, SectionFinder};
pub use shape::{SectionShape, section_shape};

/// A crossing as a point of the section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SectionPoint {
    /// Time, s.
    pub time_s: f64,
    /// The point at which the section is crossed: two coordinates.
    pub at: [f64; 2],
}

/// Crossings of `y(t + lag) = level` by the delay trajectory of Fig. 10. The point of each is
/// `(y(t), y(t + lag), y(t + 2 lag), ...)` with `dimension` values, the second of which is the level.
/// The instant is `t`.
///
/// # Errors
/// [`AnalysisError::InvalidDelay`] for a lag of 0 and a dimension below 2; [`AnalysisError::TooShort`] if there are too few samples for one delay vector.
pub fn delay_section(
    samples: &[f64],
    lag: usize,
    dimension: usize,
    level: f64,
    direction: Direction,
) -> Result<Vec<Crossing>, AnalysisError> {
    if dimension < 2 {
        return Err(AnalysisError::InvalidDelay { lag, dimension });
    }
    DelayVectors::new(samples, lag, dimension)?;
    let mut finder = SectionFinder::delay(lag, dimension, level, direction);
    let mut crossings = Vec::new();
    finder.push(&[samples], |crossing| crossings.push(crossing));
    finder.finish(|crossing| crossings.push(crossing));
    Ok(crossings)
}

/// First-return map: each value with the next one. It has one point fewer than there are values.
pub fn return_map(values: &[f64]) -> Vec<[f64; 2]> {
    values.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[cfg(test)]
mod curves_tests;
#[cfg(test)]
mod tests;
