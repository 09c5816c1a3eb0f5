//! The SVG document under construction, and the mapping of values to positions on the page.

use std::fmt::Write as _;

use super::text::{escape, shown, width};
use super::{Axis, Color, Panel, Rgb, figure::FAR};

/// Line height over font size.
pub const LINE_HEIGHT: f64 = 1.4;

/// Boxes that overlap by rounding errors only are apart, points.
const ROUNDING: f64 = 0.01;

/// Size relative to the font size, weight and colour of a text.
pub type TextStyle = (f64, bool, Color);

/// A rectangle in points; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Left and top.
    pub at: [f64; 2],
    /// Width and height.
    pub size: [f64; 2],
}

impl Rect {
    /// A rectangle of a size.
    pub fn new(at: [f64; 2], size: [f64; 2]) -> Self {
        Self { at, size }
    }

    /// Right and bottom.
    pub fn end(&self) -> [f64; 2] {
        [0, 1].map(|c| self.at[c] + self.size[c])
    }

    /// Whether the rectangle lies inside another.
    pub fn is_in(&self, other: &Self) -> bool {
        let [ends, other_ends] = [self.end(), other.end()];
        (0..2).all(|c| self.at[c] >= other.at[c] - ROUNDING && ends[c] <= other_ends[c] + ROUNDING)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let [ends, other_ends] = [self.end(), other.end()];
        (0..2).all(|c| ends[c] > other.at[c] + ROUNDING && other_ends[c] > self.at[c] + ROUNDING)
    }
}

/// The document so far, with the boxes of its texts.
pub struct Canvas {
    pub out: String,
    /// Font size, points.
    pub font_size: f64,
    pub page: Rect,
    texts: Vec<Rect>,
    /// Whether everything has room: no text covers another or leaves the page, and each plot area has ticks and a
    /// useful size.
    pub fits: bool,
    /// Share of the plot areas in the height of the page.
    pub plots: f64,
}

/// Anchor of a text: its horizontal alignment relative to its position.
#[derive(Clone, Copy, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
    /// An empty page of a size and a font size in points.
    pub fn new(size: [f64; 2], font_size: f64) -> Self {
        Self {
            out: String::new(),
            font_size,
            page: Rect::new([0.0; 2], size),
            texts: Vec::new(),
            fits: true,
            plots: 0.0,
        }
    }

    /// Appends elements. Writing to a string cannot fail.
    pub fn push(&mut self, elements: std::fmt::Arguments<'_>) {
        let _ = self.out.write_fmt(elements);
        self.out.push('\n');
    }

    /// Scales a length that is specified for a font size of 8 points.
    pub fn scaled(&self, length: f64) -> f64 {
        length * self.font_size / 8.0
    }

    /// Draws a straight line.
    pub fn line(&mut self, [x1, y1, x2, y2]: [f64; 4], color: Color, width: f64, more: &str) {
        let (color, width) = (hex(color), self.scaled(width));
        self.push(format_args!(
            "<path d=\"M{x1:.2},{y1:.2}L{x2:.2},{y2:.2}\" stroke=\"{color}\" \
             stroke-width=\"{width:.2}\" fill=\"none\"{more}/>"
        ));
    }

    /// Whether a box is on the page and covers no text.
    pub fn is_free(&self, place: &Rect) -> bool {
        place.is_in(&self.page) && !self.texts.iter().any(|text| text.overlaps(place))
    }

    /// Draws a text, vertically centred at a position.
    pub fn text(&mut self, [x, y]: [f64; 2], text: &str, anchor: Anchor, style: TextStyle) {
        let (size, bold, _) = style;
        let height = size * self.font_size;
        let width = width(&shown(text), height, bold);
        let left = x - 0.5 * f64::from(anchor as u8) * width;
        let (name, base): (&str, f64) = (anchor.into(), y + 0.36 * height);
        let place = format!("x=\"{x:.2}\" y=\"{base:.2}\" text-anchor=\"{name}\"");
        // From the top of the capital letters to the bottom of letters such as "g".
        let taken = Rect::new([left, y - 0.42 * height], [width, height]);
        self.write(taken, &place, text, style);
    }

    /// Draws a text that is read from below, centred at a position.
    pub fn turned_text(&mut self, [x, y]: [f64; 2], text: &str, color: Color) {
        let (width, height) = (self.font_size, width(&shown(text), self.font_size, false));
        let base = x + 0.36 * width;
        let place =
            format!("transform=\"translate({base:.2},{y:.2}) rotate(-90)\" text-anchor=\"middle\"");
        let taken = Rect::new([x - 0.42 * width, y - 0.5 * height], [width, height]);
        self.write(taken, &place, text, (1.0, false, color));
    }

    /// Draws lines of a text, vertically centred at a position.
    pub fn lines(&mut self, [x, y]: [f64; 2], lines: &[String], anchor: Anchor, style: TextStyle) {
        let step = 1.15 * self.font_size;
        let first = y - 0.5 * step * (lines.len() as f64 - 1.0);
        for (k, line) in lines.iter().enumerate() {
            self.text([x, first + step * k as f64], line, anchor, style);
        }
    }

    fn write(&mut self, taken: Rect, place: &str, text: &str, (size, bold, color): TextStyle) {
        let is_empty = taken.size.contains(&0.0);
        self.fits &= is_empty || self.is_free(&taken);
        self.texts.push(taken);
        let weight = if bold { " font-weight=\"600\"" } else { "" };
        let (size, color) = (size * self.font_size, hex(color));
        let text = escape(&shown(text));
        self.push(format_args!(
            "<text {place} font-size=\"{size:.2}\" fill=\"{color}\"{weight}>{text}</text>"
        ));
    }
}

/// A colour of SVG on a white background, such as `#d55e00`.
pub fn hex(color: Color) -> String {
    let [r, g, b]: Rgb = color.on_light();
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The area of a plot: a panel and its rectangle on the page.
pub struct PlotArea<'a> {
    pub panel: &'a Panel,
    pub rect: Rect,
}

impl PlotArea<'_> {
    /// Position of a pair of values; `None` if either is not finite.
    pub fn position(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        // Lines across the panel end at its edges: layers as wide as lines far beyond take memory. Other positions far
        // outside are clamped, because SVG viewers use single precision.
        let share = |axis: &Axis, value: f64| {
            let end = f64::from(value > 0.0);
            let near = axis.fraction(value).clamp(-1e3, 1e3);
            if value.abs() == FAR { end } else { near }
        };
        let shares = [share(&self.panel.x, x), 1.0 - share(&self.panel.y, y)];
        let Rect { at, size } = self.rect;
        (x.is_finite() && y.is_finite()).then(|| [0, 1].map(|c| at[c] + shares[c] * size[c]))
    }

    /// Positions of the points within the axes.
    pub fn inside<'b>(&self, points: impl IntoIterator<Item = &'b [f64; 2]>) -> Vec<[f64; 2]> {
        let points = points.into_iter().filter(|[x, y]| {
            let mut shares = [self.panel.x.fraction(*x), self.panel.y.fraction(*y)].into_iter();
            shares.all(|share| (-1e-9..=1.0 + 1e-9).contains(&share))
        });
        points.filter_map(|point| self.position(*point)).collect()
    }
}
