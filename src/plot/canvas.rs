//! The SVG document under construction, and the mapping of values to positions on the page.

use std::fmt::Write as _;

use super::color::{Color, Rgb};
use super::figure::Panel;
use super::text::escape;

/// Line height over font size.
pub const LINE_HEIGHT: f64 = 1.4;

/// A rectangle (rect) in points; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

/// The document so far, and the font size.
pub struct Canvas {
    pub out: String,
    /// Font size, points.
    pub font_size: f64,
}

/// Anchor of a text: its horizontal alignment relative to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
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
        let (color, width) = (hex(color.on_light()), self.scaled(width));
        self.push(format_args!(
            "<path d=\"M{x1:.2},{y1:.2}L{x2:.2},{y2:.2}\" stroke=\"{color}\" \
             stroke-width=\"{width:.2}\" fill=\"none\"{more}/>"
        ));
    }

    /// Draws a text, vertically centred at a position; `size` is relative to the font size.
    pub fn text(
        &mut self,
        [x, y]: [f64; 2],
        text: &str,
        anchor: Anchor,
        (size, bold, color): (f64, bool, Color),
    ) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if bold { " font-weight=\"600\"" } else { "" };
        let size = size * self.font_size;
        let (y, color, text) = (y + 0.36 * size, hex(color.on_light()), escape(text));
        self.push(format_args!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" fill=\"{color}\"{anchor}{weight}>{text}</text>"
        ));
    }
}

/// An SVG colour, such as `#d55e00`.
pub fn hex([r, g, b]: Rgb) -> String {
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
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let shares = [self.panel.x.fraction(x), self.panel.y.fraction(y)];
        // Positions far outside are clamped, because SVG viewers use single precision.
        let [x, y] = shares.map(|share| share.clamp(-1e3, 1e3));
        let rect = &self.rect;
        Some([rect.x + x * rect.width, rect.y + (1.0 - y) * rect.height])
    }

    /// Whether a pair of values lies within the axes.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let shares = [self.panel.x.fraction(x), self.panel.y.fraction(y)];
        shares
            .iter()
            .all(|share| (-1e-9..=1.0 + 1e-9).contains(share))
    }
}
