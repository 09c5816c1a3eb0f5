//! The words figures are made of.

use super::style::Rgb;
use crate::analysis::range;

/// One field with two axes and marks upon them.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What it shows, in a few words.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The marks, the first at the bottom.
    pub marks: Vec<Mark>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name and unit.
    pub name: String,
    /// Smallest and largest value shown.
    pub range: [f64; 2],
    /// How values become places.
    pub scale: Scale,
}

/// How values become places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// In proportion.
    Linear,
    /// By their decimal logarithm; values must be positive.
    Decades,
}

/// Something drawn on a panel. Values outside the axes are cut off; what is not finite is left
/// out. An empty label gives no entry in the legend.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A curve through points.
    Line {
        /// The points.
        points: Vec<[f64; 2]>,
        /// Its colour.
        color: Rgb,
        /// Its name.
        label: String,
    },
    /// A thin curve through points, without a name: one wire of many.
    Wire {
        /// The points.
        points: Vec<[f64; 2]>,
        /// Its colour.
        color: Rgb,
    },
    /// Upright bars between two values each, all equally wide.
    Columns {
        /// Place of the middle on the horizontal axis, and the two ends.
        spans: Vec<[f64; 3]>,
        /// Width on the horizontal axis.
        width: f64,
        /// Their colour.
        color: Rgb,
        /// Their name.
        label: String,
    },
    /// Dots.
    Dots {
        /// Where.
        points: Vec<[f64; 2]>,
        /// Radius in points.
        radius: f64,
        /// Their colour.
        color: Rgb,
        /// Their name.
        label: String,
    },
    /// A band between two curves, lightly filled: an interval along an axis. It has no entry in the
    /// legend; the curve in its middle has one.
    Band {
        /// Place on the horizontal axis, lower and upper end; a place without a finite end is left
        /// out.
        spans: Vec<[f64; 3]>,
        /// Its colour, of which it has a fifth.
        color: Rgb,
    },
    /// Upright strokes between two values each, with caps: intervals of single values.
    Intervals {
        /// Place on the horizontal axis, lower and upper end; one without a finite end is left out.
        spans: Vec<[f64; 3]>,
        /// Their colour.
        color: Rgb,
    },
    /// A level line across the panel, thin and dark: zero, say.
    Level {
        /// The value on the vertical axis.
        y: f64,
    },
    /// An upright line at a value of the horizontal axis, with words at its top.
    Upright {
        /// Where.
        x: f64,
        /// The words.
        words: String,
        /// Its colour.
        color: Rgb,
    },
    /// A bar from the left edge at each whole number of the vertical axis, the first at the top.
    Bars {
        /// How far, what it says, and in which colour.
        bars: Vec<Bar>,
    },
    /// A picture that fills a rectangle of the axes.
    Picture {
        /// Left and right.
        x: [f64; 2],
        /// Lower and upper.
        y: [f64; 2],
        /// Columns and rows.
        size: [usize; 2],
        /// Pixels, row-major, the upper row first.
        pixels: Vec<Rgb>,
    },
    /// Words at a place.
    Words {
        /// Where their left end is.
        at: [f64; 2],
        /// The words.
        words: String,
    },
}

/// One bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// How far it reaches.
    pub value: f64,
    /// What it says.
    pub words: String,
    /// Its colour.
    pub color: Rgb,
}

impl Axis {
    /// An axis in proportion over a range. A range that is empty or not finite is widened to
    /// something that can be drawn.
    pub fn linear(name: impl Into<String>, range: [f64; 2]) -> Self {
        Self {
            name: name.into(),
            range: drawable(range),
            scale: Scale::Linear,
        }
    }

    /// An axis of decades from `10^low` to `10^high`.
    pub fn decades(name: impl Into<String>, [low, high]: [i32; 2]) -> Self {
        Self {
            name: name.into(),
            range: [10_f64.powi(low), 10_f64.powi(high.max(low + 1))],
            scale: Scale::Decades,
        }
    }

    /// An axis in proportion that shows all `values` with a margin.
    pub fn around(name: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = extent(values);
        let margin = 0.05 * (high - low);
        Self::linear(name, [low - margin, high + margin])
    }

    /// The place of a value, in the axis' own measure.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Decades => value.max(f64::MIN_POSITIVE).log10(),
        }
    }

    /// Both ends, in the axis' own measure.
    pub(super) fn ends(&self) -> [f64; 2] {
        self.range.map(|value| self.place(value))
    }
}

/// The smallest and the largest of the finite values; 0 and 1 if there is none.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = range(values.filter(|v| v.is_finite()));
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

fn drawable([low, high]: [f64; 2]) -> [f64; 2] {
    let usable = low.is_finite() && high.is_finite() && low <= high;
    let [low, high] = if usable { [low, high] } else { [0.0, 1.0] };
    let least = 1e-9 * low.abs().max(high.abs());
    if high - low > least {
        return [low, high];
    }
    let half = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    [low - half, high + half]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_can_always_be_drawn() {
        for range in [[0.0, 0.0], [3.0, 3.0], [f64::NAN, 1.0], [2.0, -2.0]] {
            let axis = Axis::linear("x", range);
            assert!(axis.range[1] > axis.range[0], "{range:?}");
        }
        assert_eq!(Axis::around("x", [].into_iter()).range, [-0.05, 1.05]);
        assert_eq!(Axis::decades("x", [2, 2]).ends(), [2.0, 3.0]);
    }
}
