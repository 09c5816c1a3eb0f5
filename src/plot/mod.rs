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
mod embedding;
mod figure;
mod lesson;
mod lyapunov;
mod marks;
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
mod unit;

#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod tests;

pub use axis::{Axis, FullScale, Scale, round_up};
pub use basins::basins_figure;
pub use branch::{branch_figure, map_figure, modes_figure, multipliers_figure, multipliers_panel};
pub use color::{Color, INFERNO, Rgb, gradient};
pub use cost::cost_figure;
use embedding::{false_neighbours, mutual_information};
pub use figure::{Figure, FigureError, Image, Layer, Marker, Panel, Shape};
pub use lesson::{LessonPictures, prediction_panel, tone_loop};
pub use lyapunov::lyapunov_figure;
pub use response::NAMED_LINES;
pub use run::{
    RUN_FIGURES, RedrawTimer, RunFigures, RunPanels, full_scale, letter, range_shown, units,
};
pub use section::SectionAxes;
pub use sensitivities::{causes_figure, sensitivities_figure};
pub use signal::{signal_figure_names, signal_figures};
pub use style::{FigureOptions, Format, Size, SizeError, Style};
pub use sweep::{exponents, maxima, start_label, sweep_figures};
pub use text::shown;
pub use unit::{PREFIXES, Unit};

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
    /// The smallest size of the proportions of the chosen one at which all texts have room; `None` if they have room.
    pub fn needed_size(&self, figures: &[Figure]) -> Option<Size> {
        let has_room = |size: &Size| {
            let mut figures = figures.iter();
            figures.all(|figure| svg::font_size(figure, self, size.0).is_some())
        };
        let Size(sides) = self.size.filter(|size| !has_room(size))?;
        let larger = (0..500).map(|k| {
            let grown = sides.map(|side| side * (1.0 + 0.01 * f64::from(k)));
            Size(grown.map(f64::ceil))
        });
        // Of very long or high pages none may suffice.
        let square = Size(self.default_mm([figure::PAGE_MM; 2]));
        larger.chain([square]).find(has_room).or(Some(square))
    }
}
