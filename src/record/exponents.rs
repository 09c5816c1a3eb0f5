//! Lyapunov exponents: running values, spectrum with errors, and text.

use super::{paths, stream::RecordingStream, style, text};
use crate::pipeline::message::{Exponents, Header, RunExponents};
use crate::plot::Color;
use crate::report::{Report as _, markdown};

/// Averaging time relative to the duration of the run below which the running values are not drawn: their errors would set
/// the scale.
const SHORT: f64 = 0.1;

/// Logs the current exponents of a run with their intervals, and their description.
pub fn draw(rec: &RecordingStream, header: &Header, found: &Exponents) {
    let (spectrum, time) = (&found.spectrum, found.time);
    let names = (0..spectrum.exponents.len()).flat_map(|k| {
        let color = Color::Series(k);
        let faint = style::faded(color, 0.55);
        let [low, high] = ["lower end, ", "upper end, "].map(|part| (part, faint, 0.8));
        let parts = [low, ("", color, 2.0), high];
        parts.map(|(part, color, width)| (format!("λ{}, {part}1/s", k + 1), color, width))
    });
    rec.start(paths::EXPONENTS_RUNNING, names.collect(), true);
    rec.name(paths::EXPONENTS_ZERO, [("zero", Color::Faint)]);
    if spectrum.time > SHORT * header.duration {
        let row = spectrum.exponents.iter().flat_map(|exponent| {
            // Without an error there is no interval: a gap.
            let half = Some(exponent.half_width).filter(|half| half.is_finite());
            let half = half.unwrap_or(f64::NAN);
            [exponent.value - half, exponent.value, exponent.value + half]
        });
        rec.row(paths::EXPONENTS_RUNNING, time, row);
        rec.row(paths::EXPONENTS_ZERO, time, [0.0]);
    }
    let text = markdown(&RunExponents::new(found).blocks(""));
    rec.log("lyapunov/text", time, &text::document(text));
}
