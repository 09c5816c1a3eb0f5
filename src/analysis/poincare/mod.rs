//! Poincare sections: where a trajectory passes through a surface.
//!
//! The surface is a plane, `normal . x = offset`. Samples hardly ever lie on it; each passage is
//! located between two samples on the polynomial through those about it ([`SectionFinder`]), and
//! all coordinates are taken at that instant. On smooth signals that is good to 1e-9 of the
//! sample spacing and better, so that the points of a section are as sharp as the motion itself.
//!
//! What a section looks like tells the motion (Fig. 10): a periodic one comes back to a few
//! points, a torus fills a closed curve, chaos an arc or a cloud. [`SectionShape`] says which,
//! [`clusters`] counts the points.

mod crossing;
mod finder;
mod interpolation;
mod shape;

use serde::{Deserialize, Serialize};

use super::{AnalysisError, DelayVectors};

pub use crossing::{Crossing, Direction};
pub use finder::SectionFinder;
pub use shape::{Clusters, SectionShape, clusters, section_shape};

/// A passage as a point of the section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SectionPoint {
    /// When, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Where on the section: its two coordinates.
    pub at: [f64; 2],
}

/// Passages of the trajectory with these `channels` through the plane `normal . x = offset`, in
/// the order of time. [`SectionFinder`] says what counts as a passage and how it is located.
///
/// # Errors
/// [`AnalysisError::NoPlane`] if the normal is zero throughout,
/// [`AnalysisError::ChannelCount`] if it has not one component for each channel,
/// [`AnalysisError::UnevenChannels`] if the channels differ in length.
pub fn plane_section(
    channels: &[&[f64]],
    normal: &[f64],
    offset: f64,
    direction: Direction,
) -> Result<Vec<Crossing>, AnalysisError> {
    let finder = SectionFinder::plane(normal, offset, direction)?;
    all_crossings(finder, channels)
}

/// Passages of the delay trajectory of Fig. 10 through `y(t + lag) = level`; the point of each is
/// `(y(t), y(t + lag), y(t + 2 lag), ...)`, `dimension` values, the second of them the level; the
/// instant is `t`.
///
/// # Errors
/// [`AnalysisError::NoDelay`] for a lag of 0, [`AnalysisError::FlatSection`] for a dimension below
/// 2, [`AnalysisError::TooShort`] if not even one delay vector fits.
pub fn delay_section(
    samples: &[f64],
    lag: usize,
    dimension: usize,
    level: f64,
    direction: Direction,
) -> Result<Vec<Crossing>, AnalysisError> {
    let finder = SectionFinder::delay(lag, dimension, level, direction)?;
    DelayVectors::new(samples, lag, dimension)?;
    all_crossings(finder, &[samples])
}

fn all_crossings(
    mut finder: SectionFinder,
    channels: &[&[f64]],
) -> Result<Vec<Crossing>, AnalysisError> {
    let mut crossings = Vec::new();
    finder.push(channels, |crossing| crossings.push(crossing))?;
    finder.finish(|crossing| crossings.push(crossing));
    Ok(crossings)
}

/// A value at one passage and at the next: the points of a first-return map. One less than there
/// are values.
pub fn return_map(values: &[f64]) -> Vec<[f64; 2]> {
    values.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[cfg(test)]
mod tests;
