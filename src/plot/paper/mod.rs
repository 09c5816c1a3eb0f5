//! Counterparts of the paper's figures.
//!
//! | figure | here |
//! |---|---|
//! | 1 | [`configuration`]: ball, beam, load and rotation; pre-stress on the patch |
//! | 2 | [`mode_shapes`] |
//! | 3 | [`friction_curves`]: as printed, and exchanged |
//! | 4 to 7 | [`motion`]: growth, time series, phase plot, spectrum, delay reconstruction, recurrence plot |
//! | 8 | [`embedding`]: mutual information and false neighbours |
//! | 9 | [`recurrence_plots`] |
//! | 10 | [`sections`] |
//! | 11 | [`bifurcation`]: maxima, exponents and lines over the tilt |

mod body;
mod friction;
mod motion;

pub use super::sweep::bifurcation;
pub use body::{configuration, mode_shapes};
pub use friction::friction_curves;
pub use motion::{embedding, motion, recurrence_plots, sections};
