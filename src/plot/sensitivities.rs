//! Figure of the sensitivities of the modes of steady sliding (tornado chart).

use super::axis::Axis;
use super::color::Color;
use super::figure::{Figure, Layer, Panel};
use crate::number::significant;
use crate::study::branch::{ModeSensitivities, ParameterSensitivity};

/// Largest number of bars.
const MOST: usize = 9;
/// Height of a bar with its text, mm, and of the rest of a row of panels.
const BAR_MM: [f64; 2] = [7.0, 26.0];
/// Colours of a growing and a decreasing growth rate.
const COLORS: [Color; 2] = [Color::Series(4), Color::Series(3)];

/// The figure `sensitivities`: for each mode the numbers of the scene with the largest change of the growth rate per
/// 1 %, from the top. `title` names the scene.
pub fn sensitivities_figure(title: &str, modes: &[&ModeSensitivities]) -> Figure {
    let panels: Vec<Panel> = modes.iter().map(|mode| panel(mode)).collect();
    let columns = if panels.len() == 1 { 1 } else { 2 };
    let row = BAR_MM[1] + BAR_MM[0] * MOST as f64;
    let title = format!("{title}: change of the growth rate if a number increases by 1 %");
    Figure::grid("sensitivities", title, row, columns, &panels)
}

fn panel(mode: &ModeSensitivities) -> Panel {
    let shown: Vec<&ParameterSensitivity> = mode
        .parameters
        .iter()
        .filter(|parameter| parameter.growth_per_percent != 0.0)
        .take(MOST)
        .collect();
    let largest = shown
        .iter()
        .map(|parameter| parameter.growth_per_percent.abs())
        .fold(f64::MIN_POSITIVE, f64::max);
    let x = Axis::linear(
        "change of the growth rate, 1/s",
        [-1.1 * largest, 1.1 * largest],
    );
    let top = MOST as f64;
    let mut layers = vec![Layer::line(vec![[0.0, 0.0], [0.0, top]], Color::Ink).with_id("zero")];
    for (row, parameter) in (0..).zip(&shown) {
        let value = parameter.growth_per_percent;
        let top = top - f64::from(row);
        let [low, high] = [top - 0.88, top - 0.6];
        let outline = vec![[0.0, low], [value, low], [value, high], [0.0, high]];
        let color = COLORS[usize::from(value < 0.0)];
        layers.push(Layer::areas(vec![outline], 1.0, color).with_id("bars"));
        let text = format!("{}: {}", parameter.parameter, significant(value, 3));
        layers.push(Layer::text([-1.07 * largest, top - 0.36], text));
    }
    let title = format!(
        "{}, {:.1} Hz, growth rate {} 1/s",
        mode.mode.label,
        mode.mode.frequency_hz,
        significant(mode.mode.growth, 4)
    );
    Panel::new(title, x, Axis::hidden([0.0, top]), layers)
}
