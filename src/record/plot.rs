//! Axes of two-dimensional views. The viewer has none, so frame, ticks and labels are logged as lines and
//! points. Scene units are pixels; y points down.

use crate::record::sdk::{LineStrips2D, Points2D, Radius};

use super::paths;
use super::stream::{Moment, RecordingStream};
use crate::plot::{Axis, Color, shown};

/// Width of a character of a legend and of the space after an entry, pixels.
const LETTER: f32 = 10.0;
const SPACE: f32 = 34.0;
/// Space for a tick and its label along the horizontal and the vertical axis, pixels.
const TICKS: [f32; 2] = [75.0, 55.0];

/// Space for labels around a plot area, pixels: left, right, above, below.
const MARGINS: [f32; 4] = [52.0, 22.0, 42.0, 84.0];

/// Bounds of a view of a plot area of a size, with its labels and a space above it, pixels: left and right, top and bottom.
pub fn bounds([width, height]: [f32; 2], top_margin: f32) -> [[f32; 2]; 2] {
    let [left, right, above, below] = MARGINS;
    let y = [-above - top_margin, height + below];
    [[-left, width + right], y]
}

/// A plot of fixed size.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Width of the plot area, pixels.
    pub width: f32,
    /// Height of the plot area, pixels.
    pub height: f32,
    /// Space for legend, caption or labels between the plot area and the name of the vertical axis, pixels.
    pub top_margin: f32,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Whether grid lines are drawn.
    pub grid: bool,
    /// Entries of the legend; a plot with some needs a top margin of [`legend_height`].
    pub legend: Vec<(String, Color)>,
}

impl Plot {
    /// Position of a pair of values, clamped to the plot area.
    pub fn at(&self, x: f64, y: f64) -> [f32; 2] {
        // NaN is drawn at the lower end.
        let share = |share: f64| {
            if share > 0.0 {
                share.min(1.0) as f32
            } else {
                0.0
            }
        };
        [
            self.width * share(self.x.fraction(x)),
            self.height * (1.0 - share(self.y.fraction(y))),
        ]
    }

    /// Ticks of both axes.
    fn ticks(&self) -> [Vec<(f64, String)>; 2] {
        let most = |length: f32, spacing: f32| ((length / spacing) as usize).max(3);
        [
            self.x.ticks(most(self.width, TICKS[0])),
            self.y.ticks(most(self.height, TICKS[1])),
        ]
    }

    /// Bounds of a view of the plot: the plot area and its labels.
    pub fn bounds(&self) -> [[f32; 2]; 2] {
        bounds([self.width, self.height], self.top_margin)
    }

    /// Logs the axes of the plot at `path` from a moment on, and its static legend.
    pub fn draw(&self, rec: &RecordingStream, path: &str, from: Moment) {
        rec.log(paths::axis_lines(path), from, &self.lines());
        rec.log(paths::axis_labels(path), from, &self.labels());
        if !self.legend.is_empty() {
            let places = legend_positions(self.width, &self.legend).into_iter();
            let entries = places.zip(self.legend.iter().cloned());
            let entries = entries.map(|(at, (name, color))| (at, name, color));
            rec.log_static(format!("{path}/legend"), &texts(entries.collect()));
        }
    }

    /// Frame, and ticks or grid lines.
    fn lines(&self) -> LineStrips2D {
        let (w, h) = (self.width, self.height);
        let (top, right, color) = if self.grid {
            (0.0, w, Color::Grid)
        } else {
            (h, 0.0, Color::Faint)
        };
        let [x_ticks, y_ticks] = self.ticks();
        let x_lines = x_ticks.iter().map(|(tick, _)| {
            let [x, _] = self.at(*tick, self.y.range[0]);
            vec![[x, top], [x, h + 4.0]]
        });
        let y_lines = y_ticks.iter().map(|(tick, _)| {
            let [_, y] = self.at(self.x.range[0], *tick);
            vec![[-4.0, y], [right, y]]
        });
        let frame = vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h], [0.0, 0.0]];
        let count = x_ticks.len() + y_ticks.len();
        LineStrips2D::new(x_lines.chain(y_lines).chain([frame]))
            .with_colors(std::iter::repeat_n(color, count).chain([Color::Faint]))
            .with_radii([Radius::new_ui_points(0.5)])
            .with_draw_order(-1.0)
    }

    /// Tick labels and names.
    fn labels(&self) -> Points2D {
        let [x_ticks, y_ticks] = self.ticks();
        let [left, bottom] = [self.x.range[0], self.y.range[0]];
        let below = |(tick, label)| ([self.at(tick, bottom)[0], self.height + 11.0], label);
        let beside = |(tick, label)| ([-26.0, self.at(left, tick)[1] - 12.0], label);
        let middle = 0.5 * self.width;
        let name = ([middle, self.height + 44.0], shown(&self.x.label()));
        let above = ([middle, -36.0 - self.top_margin], shown(&self.y.label()));
        let ticks = { x_ticks.into_iter().map(below) }.chain(y_ticks.into_iter().map(beside));
        let above = Some(above).filter(|(_, name)| !name.is_empty());
        let all = ticks.chain([name]).chain(above);
        texts(all.map(|(at, text)| (at, text, Color::Faint)).collect())
    }
}

/// Texts in the viewer: labels of invisible points.
pub fn texts(texts: Vec<([f32; 2], String, Color)>) -> Points2D {
    Points2D::new(texts.iter().map(|(at, ..)| *at))
        .with_labels(texts.iter().map(|(_, text, _)| text.as_str()))
        .with_colors(texts.iter().map(|(.., color)| *color))
        .with_radii([Radius::new_ui_points(0.0)])
        .with_show_labels(true)
}

/// Width of a legend entry with the space after it.
fn entry_width(word: &(String, Color)) -> f32 {
    LETTER * word.0.chars().count() as f32 + SPACE
}

/// The rows of a legend, as many as the entries need.
fn legend_rows(width: f32, words: &[(String, Color)]) -> std::slice::Chunks<'_, (String, Color)> {
    let rows = (words.iter().map(entry_width).sum::<f32>() / width).ceil();
    words.chunks(words.len().div_ceil(rows.max(1.0) as usize).max(1))
}

/// Height of a legend above a plot area of some width, pixels.
pub fn legend_height(width: f32, words: &[(String, Color)]) -> f32 {
    legend_rows(width, words).len() as f32 * CAPTION_HEIGHT
}

/// Positions of the legend entries: side by side, centred above the plot area.
fn legend_positions(width: f32, words: &[(String, Color)]) -> Vec<[f32; 2]> {
    let lines = legend_rows(width, words);
    let mut places = Vec::new();
    for (above, line) in (0..lines.len()).rev().zip(lines) {
        let mut left = 0.5 * (width - line.iter().map(entry_width).sum::<f32>());
        for word in line {
            let height = -36.0 - above as f32 * CAPTION_HEIGHT;
            places.push([left + 0.5 * entry_width(word), height]);
            left += entry_width(word);
        }
    }
    places
}

/// Height of a line of text above the plot area, pixels. The viewer has a fixed font size: lines must be apart in a small
/// view, too, whose pixels are smaller than those of the screen.
pub const CAPTION_HEIGHT: f32 = 32.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_has_as_many_rows_as_it_needs() {
        let word = |name: &str| (name.to_owned(), Color::Faint);
        let words = [word("silent"), word("periodic")];
        let one = legend_positions(560.0, &words);
        assert!(one[0][0] < one[1][0] && one[0][1] == one[1][1]);
        let words = [word("quasi-periodic"), word("periodic")];
        let two = legend_positions(200.0, &words);
        assert_eq!((two[0][0], two[1][0]), (100.0, 100.0));
        assert!(two[0][1] < two[1][1], "the first entry is above the second");
        assert_eq!(legend_height(200.0, &words), 2.0 * CAPTION_HEIGHT);
        let words = [word("quasi-periodic"), word("chaotic"), word("transient")];
        assert_eq!(legend_height(200.0, &words), 3.0 * CAPTION_HEIGHT);
    }

    #[test]
    fn positions_are_clamped_and_y_points_up() {
        let plot = Plot {
            width: 200.0,
            height: 100.0,
            top_margin: 0.0,
            x: Axis::linear("x", [0.0, 10.0]),
            y: Axis::decades("y", [-2, 2]),
            grid: true,
            legend: Vec::new(),
        };
        assert_eq!(plot.at(0.0, 1e-2), [0.0, 100.0]);
        assert_eq!(plot.at(5.0, 1.0), [100.0, 50.0]);
        assert_eq!(plot.at(99.0, 1e9), [200.0, 0.0]);
        assert_eq!(plot.at(-1.0, -1.0), [0.0, 100.0], "clamped, not NaN");
        assert_eq!(plot.at(0.0, 0.0), [0.0, 100.0]);
    }
}
