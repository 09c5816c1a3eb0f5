//! Styles: font size, size and title of figures.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// The medium of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Style {
    /// Print: page width, small font, no title (the caption contains it), 300 dpi.
    Paper,
    /// Screen: titles, 1,000 points wide, rendered at twice that resolution.
    #[default]
    Screen,
    /// Slides: 16:9, one panel a file, the largest font with which everything has room.
    Slides,
}

/// A file format of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Format {
    /// Scalable Vector Graphics.
    Svg,
    /// Portable Network Graphics.
    Png,
    /// Portable Document Format, with embedded fonts.
    Pdf,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Svg, Self::Png, Self::Pdf];

    /// The format of a file by its extension.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        let mut all = Self::ALL.into_iter();
        all.find(|format| ending.eq_ignore_ascii_case(format.ending()))
    }

    /// The file extension.
    pub fn ending(self) -> &'static str {
        self.into()
    }
}

/// Width and height of a figure, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size(pub [f64; 2]);

/// Smallest and largest side of a figure, mm.
const SIDES: [f64; 2] = [20.0, 2000.0];

/// Width and height of a slide, mm.
const SLIDE_MM: [f64; 2] = [254.0, 143.0];

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self([width, height]) = self;
        write!(f, "{width}x{height}")
    }
}

impl FromStr for Size {
    type Err = SizeError;

    fn from_str(text: &str) -> Result<Self, SizeError> {
        let (width, height) = text.split_once('x').ok_or(SizeError)?;
        let side = |text: &str| text.trim().parse().map_err(|_| SizeError);
        let sides = [side(width)?, side(height)?];
        let [least, most] = SIDES;
        let is_allowed = sides.iter().all(|side| (least..=most).contains(side));
        is_allowed.then_some(Self(sides)).ok_or(SizeError)
    }
}

/// A size that is not two sides within the allowed range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write WIDTHxHEIGHT in mm, each {} to {}, such as 180x120", SIDES[0], SIDES[1])]
pub struct SizeError;

/// Style and size of figures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FigureOptions {
    /// The style.
    pub style: Style,
    /// The size of all figures; `None` for the default size of each.
    pub size: Option<Size>,
}

impl FigureOptions {
    /// The size of a figure whose size on paper is `own`, mm.
    pub fn size_mm(&self, own: [f64; 2]) -> [f64; 2] {
        self.size.map_or(self.default_mm(own), |Size(size)| size)
    }

    /// The default size of a figure whose size on paper is `own`, mm.
    pub fn default_mm(&self, own: [f64; 2]) -> [f64; 2] {
        match self.style {
            Style::Paper => own,
            // The page width becomes 1,000 points of 1/96 inch.
            Style::Screen => own.map(|side| 1.47 * side),
            Style::Slides => SLIDE_MM,
        }
    }

    /// The smallest and the largest font size, points.
    pub fn font_sizes(&self) -> [f64; 2] {
        match self.style {
            Style::Paper => [7.5, 7.5],
            Style::Screen => [8.5, 8.5],
            Style::Slides => [9.0, 18.0],
        }
    }

    /// Whether figures have a title.
    pub fn has_title(&self) -> bool {
        self.style != Style::Paper
    }

    /// Resolution, pixels per inch.
    pub fn resolution(&self) -> f32 {
        match self.style {
            Style::Paper => 300.0,
            Style::Screen => 192.0,
            Style::Slides => 150.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_sides() {
        assert_eq!("180x120.5".parse(), Ok(Size([180.0, 120.5])));
        for text in ["180", "180x", "x3", "0x10", "180x1e9", "nanx50", "a x b"] {
            assert_eq!(text.parse::<Size>(), Err(SizeError), "{text}");
        }
    }
}
