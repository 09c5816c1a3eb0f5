//! Figures that correspond to those of the paper.
//!
//! | figure | content |
//! |---|---|
//! | 1 | [`configuration`]: ball, beam, load and rotation; pre-stress on the patch |
//! | 2 | [`mode_shapes`] |
//! | 3 | [`friction_curves`]: as printed and as used |
//! | 4 to 7 | [`motion`]: growth rates, time series, phase portrait, spectrum, delay reconstruction, recurrence plot |
//! | 8 | [`embedding`]: mutual information and false nearest neighbours |
//! | 9 | [`recurrence_plots`] |
//! | 10 | [`sections`] |
//! | 11 | [`bifurcation`]: maxima, exponents and spectral lines over the tilt |

mod body;
mod friction;
mod motion;

pub use super::sweep::bifurcation;
pub use body::{configuration, mode_shapes};
pub use friction::friction_curves;
pub use motion::{embedding, motion, recurrence_plots, sections};
