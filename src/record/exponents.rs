//! Lyapunov exponents: running values, spectrum with errors, and text.

use crate::record::sdk::{Color, Scalars};

use super::{
    paths::{self, Root},
    stream::{Moment, RecordingStream},
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

/// Logs the current exponents of a run, and their description.
pub fn draw(rec: &RecordingStream, header: &Header, exponents: &Exponents) {
    let (spectrum, time) = (&exponents.spectrum, exponents.time);
    name_exponents(rec, &Root::of_run(), spectrum.exponents.len());
    if spectrum.time > SHORT * header.duration {
        log_exponents(rec, &Root::of_run(), time.into(), &spectrum.exponents);
    }
    let text = markdown(&Classified::run(exponents).blocks(""));
    rec.log(paths::EXPONENTS_TEXT, time, &text::document(text));
}

/// Colour of exponent `k`, from 0.
pub fn color(k: usize) -> Color {
    style::on_dark(plot::Color::Exponent(k))
}

/// Logs a row of exponents with their intervals, and the zero line.
pub fn log_exponents(rec: &RecordingStream, root: &Root, at: Moment, exponents: &[Exponent]) {
    let row = exponents.iter().flat_map(|exponent| {
        // Without an error there is no interval: a gap.
        let half = Some(exponent.half_width).filter(|half| half.is_finite());
        let half = half.unwrap_or(f64::NAN);
        [exponent.value - half, exponent.value, exponent.value + half]
    });
    rec.log(root.at(paths::EXPONENTS_RUNNING), at, &Scalars::new(row));
    rec.log(root.at(paths::EXPONENTS_ZERO), at, &Scalars::single(0.0));
}

/// Names and colours of the exponents of [`log_exponents`].
pub fn name_exponents(rec: &RecordingStream, root: &Root, count: usize) {
    let series = (0..count).flat_map(|k| {
        let faint = style::faded(color(k), 0.55);
        let parts = [
            ("lower end, ", faint),
            ("", color(k)),
            ("upper end, ", faint),
        ];
        parts.map(|(part, color)| (format!("λ{}, {part}1/s", k + 1), color))
    });
    let widths = [0.8, 2.0, 0.8].repeat(count);
    rec.name_with_widths(&root.at(paths::EXPONENTS_RUNNING), widths, series);
    rec.name(&root.at(paths::EXPONENTS_ZERO), [("zero", style::AXIS)]);
}
