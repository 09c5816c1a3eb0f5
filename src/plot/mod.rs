//! Figures: described once, drawn as SVG, PNG and PDF, or shown by the Rerun viewer.
//!
//! A [`Figure`] is data: rows of [`Panel`]s, each with two [`Axis`] and [`Layer`]s between them. A result has
//! a function that makes its figures ([`sweep_figures`], [`cost_figures`], ...), one file a result. What
//! draws them knows no result: [`Figure::svg`], [`Figure::png`] and [`Figure::pdf`] here, and the
//! recordings of studies in `record`. How large a figure is and whether it carries a title is its
//! [`Look`]; what a colour means is its [`Color`].
//!
//! The SVG is the figure; PNG and PDF are that SVG, drawn by resvg and svg2pdf with a font of our own.
//! All come out the same, byte for byte, on every machine.

mod axis;
mod basins;
mod color;
pub(crate) mod cost;
mod figure;
mod growth;
mod lyapunov;
pub(crate) mod paper;
pub(crate) mod response;
mod signal;
mod sweep;
mod unit;

#[cfg(feature = "figure")]
mod canvas;
#[cfg(feature = "figure")]
mod marks;
#[cfg(feature = "figure")]
mod raster;
#[cfg(feature = "figure")]
mod style;
#[cfg(feature = "figure")]
mod svg;
#[cfg(feature = "figure")]
mod text;

#[cfg(test)]
mod tests;

pub use axis::{Axis, Scale, round_up};
pub use basins::basins_figure;
pub use color::{Color, Rgb};
pub use cost::{Work, cost_figures, error_panels};
pub use figure::{Bar, Figure, FigureError, Image, Layer, Marker, Panel, Shape, Swatch};
pub use growth::growth_figure;
pub use lyapunov::lyapunov_figure;
pub use signal::{SIGNAL_FIGURES, signal_figures};
#[cfg(feature = "figure")]
pub use style::{Format, Look, Size, SizeError, Style};
pub use sweep::{exponent_ends, maxima, sweep_figures, words};
pub use unit::Unit;

#[cfg(feature = "figure")]
impl Figure {
    /// The figure as an SVG document.
    pub fn svg(&self, look: &Look) -> String {
        svg::document(self, look)
    }

    /// The figure as a PNG.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn png(&self, look: &Look) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.svg(look), look.resolution())
    }

    /// The figure as a PDF of one page.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn pdf(&self, look: &Look) -> Result<Vec<u8>, FigureError> {
        raster::pdf(&self.svg(look))
    }

    /// The figure as a file of a format.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn file(&self, look: &Look, format: Format) -> Result<Vec<u8>, FigureError> {
        match format {
            Format::Svg => Ok(self.svg(look).into_bytes()),
            Format::Png => self.png(look),
            Format::Pdf => self.pdf(look),
        }
    }
}
