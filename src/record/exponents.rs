//! Lyapunov exponents: running values, spectrum with errors, and text.

use crate::record::sdk::{Color, Scalars, SeriesLines};

use super::{
    error::RecordError,
    paths::{self, Root},
    samples::name_series,
    stream::{self, Moment, RecordingStream},
    style, text,
};
use crate::{
    dynamics::Exponent,
    pipeline::message::{Exponents, Header},
    plot,
    report::{Report as _, markdown},
    study::lyapunov::Classified,
};

/// Averaging time relative to the duration of the run below which the running values are not drawn: their errors would set
/// the scale.
const SHORT: f64 = 0.1;
/// Writes the running Lyapunov exponents of a run.
#[derive(Debug, Default)]
pub struct RunningExponents {
    named: bool,
}

impl RunningExponents {
    /// Logs the current exponents, and their description.
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
        let text = markdown(&Classified::run(exponents).blocks(""));
        stream::log_at(rec, paths::EXPONENTS_TEXT, time, &text::document(text))
    }
}

/// Colour of exponent `k`, from 0.
pub fn color(k: usize) -> Color {
    style::on_dark(plot::Color::Exponent(k))
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
