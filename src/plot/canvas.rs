//! What figures are drawn upon.

use std::fmt::Write as _;

use super::color::{Color, Rgb};
use super::figure::Panel;
use super::text::escape;

/// Height of a line of text over the size of its letters.
pub const LINE: f64 = 1.4;

/// A rectangle, points; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

/// What is drawn upon: the document so far, and the size of letters.
pub struct Canvas {
    pub out: String,
    /// Size of letters, points.
    pub letters: f64,
}

/// Where a text is attached to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
    /// Adds elements. Writing to a string cannot fail.
    pub fn put(&mut self, elements: std::fmt::Arguments<'_>) {
        let _ = self.out.write_fmt(elements);
        self.out.push('\n');
    }

    /// A length that is given for letters of 8 points.
    pub fn scaled(&self, length: f64) -> f64 {
        length * self.letters / 8.0
    }

    /// A straight line.
    pub fn stroke(&mut self, [x1, y1, x2, y2]: [f64; 4], color: Color, width: f64, more: &str) {
        let (color, width) = (hex(color.on_light()), self.scaled(width));
        self.put(format_args!(
            "<path d=\"M{x1:.2},{y1:.2}L{x2:.2},{y2:.2}\" stroke=\"{color}\" \
             stroke-width=\"{width:.2}\" fill=\"none\"{more}/>"
        ));
    }

    /// A text with its middle height at a place; `size` in sizes of letters.
    pub fn write(
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
        let size = size * self.letters;
        let (y, color, text) = (y + 0.36 * size, hex(color.on_light()), escape(text));
        self.put(format_args!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" fill=\"{color}\"{anchor}{weight}>{text}</text>"
        ));
    }
}

/// A colour as SVG writes it.
pub fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A panel and its field on the page.
pub struct Field<'a> {
    pub panel: &'a Panel,
    pub frame: Frame,
}

impl Field<'_> {
    /// The place of a pair of values; `None` if it has none.
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let shares = [self.panel.x.share(x), self.panel.y.share(y)];
        // Far outside is far enough: viewers reckon in single precision.
        let [x, y] = shares.map(|share| share.clamp(-1e3, 1e3));
        let frame = &self.frame;
        Some([
            frame.x + x * frame.width,
            frame.y + (1.0 - y) * frame.height,
        ])
    }

    /// Whether a pair of values lies between the axes.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let shares = [self.panel.x.share(x), self.panel.y.share(y)];
        shares
            .iter()
            .all(|share| (-1e-9..=1.0 + 1e-9).contains(share))
    }
}
