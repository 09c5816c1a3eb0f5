//! Lyapunov exponents: running values, spectrum with errors, and text.

use rerun::{Color, Scalars, SeriesLines};

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths::{self, Root},
    plot::Bounds,
    samples::name_series,
    stream::{self, Moment, RecordingStream},
    style::{self, FullScale},
    text,
};
use crate::{
    dynamics::{Exponent, LyapunovSpectrum},
    pipeline::message::{Exponents, Header},
    plot::{self, Axis, Layer, Panel},
    report::{Measured, Report as _, markdown},
    study::lyapunov::Classified,
};

/// Size of the plot of the spectrum, pixels.
const FIELD: [f32; 2] = [400.0, 260.0];
/// Averaging time relative to the duration of the run below which the running values are not drawn: their errors would set
/// the scale.
const SHORT: f64 = 0.1;
/// Smallest full scale of the spectrum, 1/s.
const SMALLEST: f64 = 1.0;

/// Draws Lyapunov exponents.
#[derive(Debug)]
pub struct ExponentsPlot {
    scale: FullScale,
    view: PanelView,
    named: bool,
}

impl ExponentsPlot {
    /// Starts without exponents.
    pub fn new() -> Self {
        Self {
            scale: FullScale::new(SMALLEST),
            view: spectrum_view(),
            named: false,
        }
    }

    /// Bounds of the view of the spectrum.
    pub fn bounds() -> Bounds {
        spectrum_view().bounds(&spectrum_panel(&LyapunovSpectrum::default(), 1.0))
    }

    /// Draws the current exponents of a run.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        header: &Header,
        exponents: &Exponents,
    ) -> Result<(), RecordError> {
        let spectrum = &exponents.spectrum;
        let time = exponents.time;
        if !self.named {
            self.named = true;
            name_exponents(rec, &Root::of_run(), spectrum.exponents.len())?;
        }
        if spectrum.time > SHORT * header.duration {
            log_exponents(rec, &Root::of_run(), time, &spectrum.exponents)?;
        }
        self.draw_spectrum(rec, time, spectrum)?;
        let text = markdown(&Classified::run(exponents).blocks(""));
        stream::log_at(rec, paths::EXPONENTS_TEXT, time, &text::document(text))
    }

    fn draw_spectrum(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        spectrum: &LyapunovSpectrum,
    ) -> Result<(), RecordError> {
        // Exponents of minus infinity have no position on the axis.
        let values = spectrum.exponents.iter().map(|exponent| exponent.value);
        let values = values.filter(|value| value.is_finite());
        let largest = values.fold(0.0, |a: f64, value| a.max(value.abs()));
        self.scale.update(1.1 * largest, SMALLEST);
        let panel = spectrum_panel(spectrum, self.scale.get());
        self.view.draw(rec, Some(Moment::from(time)), &panel)
    }
}

/// Colour of exponent `k`, from 0.
pub fn color(k: usize) -> Color {
    style::on_dark(plot::Color::Exponent(k))
}

fn spectrum_view() -> PanelView {
    PanelView::new(paths::EXPONENTS_SPECTRUM, FIELD)
}

/// The exponents with their intervals by index, on an axis of ± `full`.
fn spectrum_panel(spectrum: &LyapunovSpectrum, full: f64) -> Panel {
    let numbered = || (0..).zip(&spectrum.exponents);
    let mut layers = vec![Layer::horizontal_line(0.0).with_id("zero")];
    layers.extend(numbered().map(|(k, exponent)| {
        let span = [k as f64 + 1.0, exponent.low(), exponent.high()];
        Layer::intervals(&[span], plot::Color::Exponent(k))
    }));
    layers.extend(numbered().map(|(k, exponent)| {
        let point = [k as f64 + 1.0, exponent.value];
        Layer::points(vec![point], 3.3, plot::Color::Exponent(k))
    }));
    let caption = match &spectrum.kaplan_yorke {
        Some(dimension) => format!("Kaplan-Yorke dimension {}", Measured::from(dimension)),
        None => "95 % intervals".to_owned(),
    };
    let index = Axis::integers("index", spectrum.exponents.len().max(1));
    let values = Axis::linear("exponent, 1/s", [-full, full]);
    Panel::new("exponents", index, values, layers).with_caption(caption)
}

/// Logs a row of exponents with their intervals, and the zero line.
pub fn log_exponents(
    rec: &RecordingStream,
    root: &Root,
    at: impl Into<Moment>,
    exponents: &[Exponent],
) -> Result<(), RecordError> {
    let at = at.into();
    let row = exponents.iter().flat_map(|exponent| {
        // Without an error there is no interval: a gap.
        let half = Some(exponent.half_width).filter(|half| half.is_finite());
        let half = half.unwrap_or(f64::NAN);
        [exponent.value - half, exponent.value, exponent.value + half]
    });
    stream::log_at(
        rec,
        root.at(paths::EXPONENTS_RUNNING),
        at,
        &Scalars::new(row),
    )?;
    stream::log_at(
        rec,
        root.at(paths::EXPONENTS_ZERO),
        at,
        &Scalars::single(0.0),
    )
}

/// Names and colours of the exponents of [`log_exponents`].
pub fn name_exponents(rec: &RecordingStream, root: &Root, count: usize) -> Result<(), RecordError> {
    let names = (1..=count).flat_map(|k| {
        [
            format!("λ{k}, lower end, 1/s"),
            format!("λ{k}, 1/s"),
            format!("λ{k}, upper end, 1/s"),
        ]
    });
    let colors = (0..count).flat_map(|k| {
        let faint = style::faded(color(k), 0.55);
        [faint, color(k), faint]
    });
    let running = root.at(paths::EXPONENTS_RUNNING);
    name_series(rec, &running, names, colors)?;
    let widths = SeriesLines::update_fields().with_widths([0.8, 2.0, 0.8].repeat(count));
    rec.log_static(running, &widths)?;
    name_series(
        rec,
        &root.at(paths::EXPONENTS_ZERO),
        ["zero".to_owned()],
        [style::AXIS],
    )
}
