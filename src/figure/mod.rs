//! Pictures on disk: SVG and PNG, with the program's own font.
//!
//! A [`Figure`] is a grid of [`Panel`]s; a panel has two axes and marks upon them. What figures
//! a subject has is said in one file a subject; [`signal_figures`] draws the report on a signal,
//! [`lyapunov_figure`] the exponents of a scene, [`sweep_figures`] a sweep.
//!
//! The SVG is the figure; the PNG is that SVG, drawn at twice its size. Both come out the same,
//! byte for byte, on every machine: no font and no library of the system is asked.

mod basins;
mod cost;
mod draw;
mod error;
mod growth;
mod lyapunov;
mod panel;
pub mod paper;
mod raster;
mod signal;
mod style;
mod sweep;

#[cfg(test)]
mod tests;

pub use basins::basins_figure;
pub use cost::cost_figures;
pub use error::FigureError;
pub use growth::growth_figure;
pub use lyapunov::lyapunov_figure;
pub use panel::{Axis, Mark, Panel, Scale};
pub use signal::{SIGNAL_FIGURES, signal_figures};
pub use sweep::{sweep_figure_names, sweep_figures};

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Stem of its file name, such as `recurrence`.
    pub name: String,
    /// The SVG document.
    pub svg: String,
}

impl Figure {
    /// Draws `rows` of panels under a title. All panels of a row are equally wide and all rows
    /// equally high; `size` is the whole in points.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub fn new(
        name: impl Into<String>,
        title: &str,
        size: [u32; 2],
        rows: &[Vec<Panel>],
    ) -> Result<Self, FigureError> {
        Ok(Self {
            name: name.into(),
            svg: draw::draw(title, size, rows)?,
        })
    }

    /// The figure as a PNG of twice its size in pixels.
    ///
    /// # Errors
    /// [`FigureError::Raster`].
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.svg)
    }
}
