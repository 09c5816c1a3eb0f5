//! Axes for pictures. A 2-D view of the viewer has none of its own, so the frame, the ticks and
//! their labels are logged as lines and points. Scene units are picture pixels; y points down.

use rerun::{Color, LineStrips2D, Points2D, Radius};

use super::{
    error::RecordError,
    paths,
    stream::{self, Moment, RecordingStream},
    style,
};
use crate::plot::Axis;

/// Width of a letter of a key and of the space after a word, pixels.
const LETTER: f32 = 9.0;
const SPACE: f32 = 22.0;
/// Pixels that a tick and its label take along the width and along the height.
const TICKS: [f32; 2] = [75.0, 55.0];

/// A plot of fixed size.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Width of the field, pixels.
    pub width: f32,
    /// Height of the field, pixels.
    pub height: f32,
    /// Room between the field and the name of the upright axis, pixels.
    pub head: f32,
    /// Axis along the width.
    pub x: Axis,
    /// Axis along the height.
    pub y: Axis,
    /// Whether ticks run on as lines across the field.
    pub grid: bool,
}

impl Plot {
    /// Space for labels round the field, pixels: left, right, above, below.
    const MARGINS: [f32; 4] = [52.0, 22.0, 42.0, 80.0];

    /// The picture position of a pair of values; outside the axes, the nearest on them.
    pub fn at(&self, x: f64, y: f64) -> [f32; 2] {
        // Not-a-number is at the lower end.
        let share = |share: f64| {
            if share > 0.0 {
                share.min(1.0) as f32
            } else {
                0.0
            }
        };
        [
            self.width * share(self.x.share(x)),
            self.height * (1.0 - share(self.y.share(y))),
        ]
    }

    /// Ticks of both axes.
    fn ticks(&self) -> [Vec<f64>; 2] {
        let most = |length: f32, room: f32| ((length / room) as usize).max(3);
        [
            self.x.ticks(most(self.width, TICKS[0])),
            self.y.ticks(most(self.height, TICKS[1])),
        ]
    }

    /// What a view must show: the field and its labels.
    pub fn bounds(&self) -> Bounds {
        let [left, right, above, below] = Self::MARGINS;
        Bounds {
            x: [-left, self.width + right],
            y: [-above - self.head, self.height + below],
        }
    }

    /// Logs the axes of the picture at `path`, for all times or from a moment on.
    pub fn draw(
        &self,
        rec: &RecordingStream,
        path: &str,
        from: Option<Moment>,
    ) -> Result<(), RecordError> {
        let (lines, labels) = (self.lines(), self.labels());
        let (line_path, label_path) = (paths::axis_lines(path), paths::axis_labels(path));
        match from {
            Some(from) => {
                stream::log_at(rec, line_path, from, &lines)?;
                stream::log_at(rec, label_path, from, &labels)
            }
            None => {
                rec.log_static(line_path, &lines)?;
                rec.log_static(label_path, &labels)
            }
        }
    }

    /// Frame, and ticks or grid.
    fn lines(&self) -> LineStrips2D {
        let (w, h) = (self.width, self.height);
        let mut strips = Vec::new();
        let mut colors = Vec::new();
        let [x_ticks, y_ticks] = self.ticks();
        for tick in x_ticks {
            let [x, _] = self.at(tick, self.y.range[0]);
            let top = if self.grid { 0.0 } else { h };
            strips.push(vec![[x, top], [x, h + 4.0]]);
            colors.push(if self.grid { style::GRID } else { style::AXIS });
        }
        for tick in y_ticks {
            let [_, y] = self.at(self.x.range[0], tick);
            let right = if self.grid { w } else { 0.0 };
            strips.push(vec![[-4.0, y], [right, y]]);
            colors.push(if self.grid { style::GRID } else { style::AXIS });
        }
        strips.push(vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h], [0.0, 0.0]]);
        colors.push(style::AXIS);
        LineStrips2D::new(strips)
            .with_colors(colors)
            .with_radii([Radius::new_ui_points(0.5)])
            .with_draw_order(-1.0)
    }

    /// Tick labels and names: invisible points that carry words.
    fn labels(&self) -> Points2D {
        let mut points = Vec::new();
        let mut words = Vec::new();
        let [x_ticks, y_ticks] = self.ticks();
        words.extend(self.x.labels(&x_ticks));
        words.extend(self.y.labels(&y_ticks));
        let [left, bottom] = [self.x.range[0], self.y.range[0]];
        let below = |tick: f64| [self.at(tick, bottom)[0], self.height + 11.0];
        let beside = |tick: f64| [-26.0, self.at(left, tick)[1] - 12.0];
        points.extend(x_ticks.into_iter().map(below));
        points.extend(y_ticks.into_iter().map(beside));
        points.push([0.5 * self.width, self.height + 40.0]);
        words.push(self.x.label());
        if !self.y.label().is_empty() {
            points.push([0.5 * self.width, -36.0 - self.head]);
            words.push(self.y.label());
        }
        let count = points.len();
        Points2D::new(points)
            .with_labels(words)
            .with_colors(vec![style::AXIS; count])
            .with_radii([Radius::new_ui_points(0.0)])
            .with_show_labels(true)
    }
}

impl Plot {
    /// Draws a curve of the given colour and width (half of it, in points of the screen).
    pub fn draw_curve(
        &self,
        rec: &RecordingStream,
        path: &str,
        at: impl Into<Moment>,
        points: impl Iterator<Item = [f64; 2]>,
        (color, radius): (Color, f32),
    ) -> Result<(), RecordError> {
        let curve = points.map(|[x, y]| self.at(x, y)).collect::<Vec<_>>();
        // Nothing to draw is no strip, rather than one without points.
        let curve = LineStrips2D::new(Some(curve).filter(|curve| !curve.is_empty()))
            .with_colors([color])
            .with_radii([Radius::new_ui_points(radius)]);
        stream::log_at(rec, path, at, &curve)
    }

    /// Draws points of the given colour and radius (points of the screen).
    pub fn draw_points(
        &self,
        rec: &RecordingStream,
        path: &str,
        at: impl Into<Moment>,
        points: impl Iterator<Item = [f64; 2]>,
        (color, radius): (Color, f32),
    ) -> Result<(), RecordError> {
        let points = Points2D::new(points.map(|[x, y]| self.at(x, y)))
            .with_colors([color])
            .with_radii([Radius::new_ui_points(radius)]);
        stream::log_at(rec, path, at, &points)
    }

    /// Marks what was chosen: an upright line through the field at a point of a curve.
    pub fn draw_stem(
        &self,
        rec: &RecordingStream,
        path: &str,
        at: impl Into<Moment>,
        [x, y]: [f64; 2],
    ) -> Result<(), RecordError> {
        let [across, height] = self.at(x, y);
        let gap = 6.0;
        // Two pieces that leave the point itself free.
        let strips = [
            [[across, 0.0], [across, (height - gap).max(0.0)]],
            [
                [across, (height + gap).min(self.height)],
                [across, self.height],
            ],
        ];
        let stem = LineStrips2D::new(strips)
            .with_colors([style::ACCENT])
            .with_radii([Radius::new_ui_points(1.0)])
            .with_draw_order(1.0);
        stream::log_at(rec, path, at, &stem)
    }

    /// Writes words above the field of the picture at `path`, below the name of the upright axis: a plot that has both
    /// needs a head of [`CAPTION_HEIGHT`].
    pub fn draw_caption(
        &self,
        rec: &RecordingStream,
        path: &str,
        at: impl Into<Moment>,
        words: &str,
    ) -> Result<(), RecordError> {
        let caption = Points2D::new([[0.5 * self.width, -36.0]])
            .with_labels([words])
            .with_show_labels(true)
            .with_colors([style::AXIS])
            .with_radii([Radius::new_ui_points(0.0)]);
        stream::log_at(rec, paths::caption(path), at, &caption)
    }
}

impl Plot {
    /// Says for all times what the colours of the picture at `path` mean, above the field: a plot that has such a key needs a head
    /// of [`key_height`].
    pub fn draw_key(
        &self,
        rec: &RecordingStream,
        path: &str,
        words: &[(String, Color)],
    ) -> Result<(), RecordError> {
        let places = place_key(self.width, words);
        let key = Points2D::new(places)
            .with_labels(words.iter().map(|(name, _)| name.as_str()))
            .with_show_labels(true)
            .with_colors(words.iter().map(|(_, color)| *color))
            .with_radii([Radius::new_ui_points(0.0)]);
        rec.log_static(paths::key(path), &key)
    }
}

/// Width of a word of a key, with the space after it.
fn room(word: &(String, Color)) -> f32 {
    LETTER * word.0.chars().count() as f32 + SPACE
}

/// The lines of a key: a second one where the width does not hold all words.
fn key_lines(width: f32, words: &[(String, Color)]) -> Vec<&[(String, Color)]> {
    if words.iter().map(room).sum::<f32>() > width {
        let (first, second) = words.split_at(words.len().div_ceil(2));
        vec![first, second]
    } else {
        vec![words]
    }
}

/// What a key needs above a field of some width, pixels.
pub fn key_height(width: f32, words: &[(String, Color)]) -> f32 {
    key_lines(width, words).len() as f32 * CAPTION_HEIGHT
}

/// Where the words of a key stand: side by side in the middle above a field.
fn place_key(width: f32, words: &[(String, Color)]) -> Vec<[f32; 2]> {
    let lines = key_lines(width, words);
    let mut places = Vec::new();
    for (above, line) in (0..lines.len()).rev().zip(lines) {
        let mut left = 0.5 * (width - line.iter().map(room).sum::<f32>());
        for word in line {
            let height = -36.0 - above as f32 * CAPTION_HEIGHT;
            places.push([left + 0.5 * room(word), height]);
            left += room(word);
        }
    }
    places
}

/// Height of a line of words above the field, pixels.
pub const CAPTION_HEIGHT: f32 = 26.0;

/// Axes that are logged only when they change.
#[derive(Debug, Default)]
pub struct Axes(Option<Plot>);

impl Axes {
    /// Logs the axes of `plot`, the picture at `path`, from a moment on, unless they stand there already.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        path: &str,
        at: impl Into<Moment>,
        plot: &Plot,
    ) -> Result<(), RecordError> {
        if self.0.as_ref() == Some(plot) {
            return Ok(());
        }
        plot.draw(rec, path, Some(at.into()))?;
        self.0 = Some(plot.clone());
        Ok(())
    }
}

/// A rectangle of a picture, pixels; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Left and right.
    pub x: [f32; 2],
    /// Upper and lower.
    pub y: [f32; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_stands_side_by_side_and_breaks_once() {
        let word = |name: &str| (name.to_owned(), style::AXIS);
        let words = [word("silent"), word("periodic")];
        let one = place_key(560.0, &words);
        assert!(one[0][0] < one[1][0] && one[0][1] == one[1][1]);
        let words = [word("quasi-periodic"), word("periodic")];
        let two = place_key(200.0, &words);
        assert_eq!((two[0][0], two[1][0]), (100.0, 100.0));
        assert!(two[0][1] < two[1][1], "the first above the second");
        assert_eq!(key_height(200.0, &words), 2.0 * CAPTION_HEIGHT);
    }

    #[test]
    fn values_map_into_the_field_with_y_upwards() {
        let plot = Plot {
            width: 200.0,
            height: 100.0,
            head: 0.0,
            x: Axis::linear("x", [0.0, 10.0]),
            y: Axis::decades("y", [-2, 2]),
            grid: true,
        };
        assert_eq!(plot.at(0.0, 1e-2), [0.0, 100.0]);
        assert_eq!(plot.at(5.0, 1.0), [100.0, 50.0]);
        assert_eq!(plot.at(99.0, 1e9), [200.0, 0.0]);
        assert_eq!(plot.at(-1.0, -1.0), [0.0, 100.0], "clamped, no NaN");
        assert_eq!(plot.at(0.0, 0.0), [0.0, 100.0]);
    }
}
