//! Axes for pictures. A 2-D view of the viewer has none of its own, so the frame, the ticks and
//! their labels are logged as lines and points. Scene units are picture pixels; y points down.

use rerun::{Color, LineStrips2D, Points2D, Radius};

use super::{
    error::RecordError,
    paths,
    stream::{self, Moment, RecordingStream},
    style::{self, short},
};

/// An axis over more decades than this has a tick at every other one.
const MOST_POWERS: i32 = 12;
/// An axis with more round numbers than this has ticks at the powers of ten alone.
const MOST_TICKS: usize = 9;
/// Width of a letter of a key and of the space after a word, pixels.
const LETTER: f32 = 9.0;
const SPACE: f32 = 22.0;

/// How an axis maps its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// In proportion.
    Linear,
    /// In proportion to the logarithm; both ends positive.
    Logarithmic,
}

/// One axis of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name and unit, such as `frequency, kHz`; may be empty on the upright axis.
    pub name: String,
    /// Value at the left or lower end.
    pub low: f64,
    /// Value at the right or upper end; above `low`.
    pub high: f64,
    /// How values map.
    pub scaling: Scaling,
    /// Where ticks stand.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// A linear axis with about `count` ticks at round values.
    pub fn linear(name: impl Into<String>, low: f64, high: f64, count: usize) -> Self {
        let rough = (high - low) / count.max(1) as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0]
            .map(|d| d * decade)
            .into_iter()
            .find(|s| *s >= rough * (1.0 - 1e-9))
            .unwrap_or(rough);
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        Self {
            name: name.into(),
            low,
            high,
            scaling: Scaling::Linear,
            ticks: (first..=last).map(|k| k as f64 * step).collect(),
        }
    }

    /// A logarithmic axis over whole decades, `10^low` to `10^high`, a tick every other one.
    pub fn decades(name: impl Into<String>, low: i32, high: i32) -> Self {
        Self {
            name: name.into(),
            low: 10f64.powi(low),
            high: 10f64.powi(high),
            scaling: Scaling::Logarithmic,
            ticks: (low + 1..=high).step_by(2).map(|k| 10f64.powi(k)).collect(),
        }
    }

    /// A logarithmic axis over whole decades, `10^low` to `10^high`, with a tick at each, or at every
    /// other where there are many.
    pub fn powers(name: impl Into<String>, [low, high]: [i32; 2]) -> Self {
        let step = if high - low > MOST_POWERS { 2 } else { 1 };
        Self {
            ticks: (low..=high).step_by(step).map(|k| 10f64.powi(k)).collect(),
            ..Self::decades(name, low, high)
        }
    }

    /// A logarithmic axis that holds two different positive values closely: from and to 1, 2 or 5 times
    /// a power of ten, with ticks at these, or at the powers alone where there are many.
    pub fn closely(name: impl Into<String>, [low, high]: [f64; 2]) -> Self {
        let powers = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
        let round = powers.flat_map(|k| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(k)));
        let below = round.clone().rfind(|value| *value <= low * (1.0 + 1e-9));
        let above = round.clone().find(|value| *value >= high * (1.0 - 1e-9));
        let mut axis = Self {
            name: name.into(),
            low: below.unwrap_or(low),
            high: above.unwrap_or(high),
            scaling: Scaling::Logarithmic,
            ticks: Vec::new(),
        };
        let inside = round.filter(|value| (axis.low..=axis.high).contains(value));
        axis.ticks = inside.collect();
        if axis.ticks.len() > MOST_TICKS {
            axis.ticks.retain(|tick| is_power_of_ten(*tick));
        }
        axis
    }

    /// What stands at a tick. On a logarithmic axis all are powers of ten, unless all read well as they
    /// are.
    fn words(&self, tick: f64) -> String {
        let plain = self.ticks.iter().all(|tick| (1e-2..=1e3).contains(tick));
        let powers = self.ticks.iter().all(|tick| is_power_of_ten(*tick));
        match self.scaling {
            Scaling::Logarithmic if powers && !plain => power_of_ten(tick),
            Scaling::Logarithmic | Scaling::Linear => short(tick),
        }
    }

    /// Where `value` lies, 0 at the lower end to 1 at the upper; clamped to the axis.
    pub fn share(&self, value: f64) -> f64 {
        let share = match self.scaling {
            Scaling::Linear => (value - self.low) / (self.high - self.low),
            Scaling::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        // Not-a-number, the logarithm of a negative value, is not positive either.
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    }
}

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

    /// The picture position of a pair of values.
    pub fn at(&self, x: f64, y: f64) -> [f32; 2] {
        [
            self.width * self.x.share(x) as f32,
            self.height * (1.0 - self.y.share(y) as f32),
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

    /// Logs the axes below `path`, for all times or from a moment on.
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
        for &tick in &self.x.ticks {
            let [x, _] = self.at(tick, self.y.low);
            let top = if self.grid { 0.0 } else { h };
            strips.push(vec![[x, top], [x, h + 4.0]]);
            colors.push(if self.grid { style::GRID } else { style::AXIS });
        }
        for &tick in &self.y.ticks {
            let [_, y] = self.at(self.x.low, tick);
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
        for &tick in &self.x.ticks {
            points.push([self.at(tick, self.y.low)[0], self.height + 11.0]);
            words.push(self.x.words(tick));
        }
        for &tick in &self.y.ticks {
            points.push([-26.0, self.at(self.x.low, tick)[1] - 12.0]);
            words.push(self.y.words(tick));
        }
        points.push([0.5 * self.width, self.height + 40.0]);
        words.push(self.x.name.clone());
        if !self.y.name.is_empty() {
            points.push([0.5 * self.width, -36.0 - self.head]);
            words.push(self.y.name.clone());
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

    /// Writes words above the field, below the name of the upright axis: a plot that has both
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
        stream::log_at(rec, path, at, &caption)
    }
}

impl Plot {
    /// Says for all times what the colours mean, above the field: a plot that has such a key needs a head
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
        rec.log_static(path, &key)
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

/// Whether a positive value is one.
fn is_power_of_ten(value: f64) -> bool {
    let exponent = value.log10();
    (exponent - exponent.round()).abs() < 1e-9
}

/// A power of ten, such as `10⁻³`.
fn power_of_ten(value: f64) -> String {
    let exponent = format!("{:.0}", value.log10());
    let raised = exponent.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
}

/// Height of a line of words above the field, pixels.
pub const CAPTION_HEIGHT: f32 = 26.0;

/// Axes that are logged only when they change.
#[derive(Debug, Default)]
pub struct Axes(Option<Plot>);

impl Axes {
    /// Logs the axes of `plot` below `path` from a moment on, unless they stand there already.
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
    fn ticks_are_round_and_inside() {
        let axis = Axis::linear("f, kHz", 0.0, 15.0, 5);
        assert_eq!(axis.ticks, [0.0, 5.0, 10.0, 15.0]);
        let axis = Axis::linear("u", -2.0, 2.0, 4);
        assert_eq!(axis.ticks, [-2.0, -1.0, 0.0, 1.0, 2.0]);
        let axis = Axis::decades("v", -2, 1);
        assert_eq!(axis.ticks, [0.1, 10.0]);
        assert!((axis.share(0.1) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn powers_of_ten_are_words() {
        let axis = Axis::powers("error", [-4, 1]);
        assert_eq!(axis.ticks.len(), 6);
        assert_eq!(axis.words(1e-4), "10⁻⁴");
        assert_eq!(axis.words(10.0), "10¹");
        let axis = Axis::powers("CPU time, ms", [-1, 2]);
        assert_eq!(
            (axis.words(0.1), axis.words(100.0)),
            ("0.1".into(), "100".into())
        );
        assert_eq!(Axis::powers("error", [-16, 0]).ticks.len(), 9);
    }

    #[test]
    fn an_axis_holds_its_values_closely() {
        let axis = Axis::closely("calls", [1600.0, 40e3]);
        assert_eq!(axis.ticks, [1e3, 2e3, 5e3, 1e4, 2e4, 5e4]);
        assert_eq!((axis.low, axis.high), (1e3, 5e4));
        assert_eq!(axis.words(2e3), "2000");
        let axis = Axis::closely("calls", [30.0, 3e5]);
        assert_eq!(axis.ticks, [1e2, 1e3, 1e4, 1e5]);
        assert_eq!(axis.words(1e4), "10⁴");
    }

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
            x: Axis::linear("x", 0.0, 10.0, 5),
            y: Axis::decades("y", -2, 2),
            grid: true,
        };
        assert_eq!(plot.at(0.0, 1e-2), [0.0, 100.0]);
        assert_eq!(plot.at(5.0, 1.0), [100.0, 50.0]);
        assert_eq!(plot.at(99.0, 1e9), [200.0, 0.0]);
        assert_eq!(plot.at(-1.0, -1.0), [0.0, 100.0], "clamped, no NaN");
        assert_eq!(plot.at(0.0, 0.0), [0.0, 100.0]);
    }
}
