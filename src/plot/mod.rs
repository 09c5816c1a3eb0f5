//! Figures, described once and rendered as SVG, PNG and PDF, or shown by the Rerun viewer.
//!
//! A [`Figure`] is data: rows of [`Panel`]s, each with two [`Axis`] and some [`Layer`]s. Each result type has
//! a function that returns its figures ([`sweep_figures`], [`cost_figure`], ...), one file per result. The
//! renderers do not depend on result types: [`Figure::svg`] and [`Figure::file`] here, and
//! the recordings of studies in `record`. The [`FigureOptions`] determines the size of a figure and whether it has a
//! title; the [`Color`] is the meaning of a colour.
//!
//! PNG and PDF are rendered from the SVG by resvg and svg2pdf with an embedded font, so all formats are
//! identical, byte for byte, on every machine.

mod axis;
mod basins;
mod branch;
mod canvas;
mod chaos;
mod color;
mod cost;
mod figure;
mod figures;
mod lesson;
mod lyapunov;
pub(crate) mod paper;
mod raster;
pub(crate) mod response;
mod run;
mod section;
mod sensitivities;
mod signal;
mod style;
mod svg;
mod sweep;
mod text;

#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod tests;

pub use axis::{Axis, FULL_SCALES, FullScale, Scale, TICK_STEPS, Unit, readable, round_up};
pub use basins::basins_figure;
pub use branch::{branch_figure, branch_figures, map_figure, multipliers_panel};
pub use color::{Color, INFERNO, Rgb, colormap, gradient};
pub use cost::cost_figure;
pub use figure::{Figure, FigureError, Image, Layer, Marker, Panel, Shape};
pub use figures::{figure_names, figures};
pub use lesson::{LessonPictures, prediction_panel, tone_loop};
pub use lyapunov::lyapunov_figure;
pub use response::NAMED_LINES;
pub use run::{RedrawTimer, RunPanels, full_scale, letter, range_shown, units};
pub use section::SectionAxes;
pub use sensitivities::{causes_figure, sensitivities_figure};
pub use signal::{evidence_panel, signal_figures};
pub use style::{FigureOptions, Format, Style, parse_size};
pub use sweep::{ParameterPanels, start_label, sweep_figures};
pub use text::shown;

impl Figure {
    /// The figure as an SVG document.
    pub fn svg(&self, options: &FigureOptions) -> String {
        svg::page(self, options, svg::layout(self, options), true).out
    }

    /// The figure as a file in a format.
    ///
    /// # Errors
    /// [`FigureError`] if the figure cannot be rendered.
    pub fn file(&self, options: &FigureOptions, format: Format) -> Result<Vec<u8>, FigureError> {
        let svg = self.svg(options);
        match format {
            Format::Svg => Ok(svg.into_bytes()),
            Format::Png => raster::png(&svg, options.resolution()),
            Format::Pdf => raster::pdf(&svg),
        }
    }
}

impl FigureOptions {
    /// The smallest width and height, mm, of the proportions of the chosen ones at which all texts have room; `None` if
    /// they have room.
    pub fn needed_size(&self, figures: &[Figure]) -> Option<[f64; 2]> {
        let has_room = |size: &[f64; 2]| {
            let mut figures = figures.iter();
            figures.all(|figure| svg::font_size(figure, self, *size).is_some())
        };
        let size = self.size.filter(|size| !has_room(size))?;
        let larger = (0..500).map(|k| 1.0 + 0.01 * f64::from(k));
        let larger = larger.map(|factor| size.map(|side| (side * factor).ceil()));
        // Of very long or high pages none may suffice.
        let square = self.default_mm([figure::PAGE_MM; 2]);
        larger.chain([square]).find(has_room).or(Some(square))
    }
}
