//! Styles: font size, size and title of figures.

use std::path::Path;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::EnumString, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase", ascii_case_insensitive)]
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
    /// The format of a file by its extension.
    pub fn of(path: &Path) -> Option<Self> {
        path.extension()?.to_str()?.parse().ok()
    }

    /// The file extension.
    pub fn ending(self) -> &'static str {
        self.into()
    }
}

/// Width and height of a slide, mm.
const SLIDE_MM: [f64; 2] = [254.0, 143.0];

/// Width and height of a figure, mm, from a text such as `180x120`.
///
/// # Errors
/// What to write, if the text is not two sides within the allowed range.
pub fn parse_size(text: &str) -> Result<[f64; 2], &'static str> {
    let side = |text: &str| {
        let side = text.trim().parse().ok();
        side.filter(|side| (20.0..=2000.0).contains(side))
    };
    let sides = text.split_once('x');
    let sides = sides.and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or("write WIDTHxHEIGHT in mm, each 20 to 2000, such as 180x120")
}

/// Style and size of figures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FigureOptions {
    /// The style.
    pub style: Style,
    /// Width and height of all figures, mm; `None` for the default size of each.
    pub size: Option<[f64; 2]>,
}

impl FigureOptions {
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
        assert_eq!(parse_size("180x120.5"), Ok([180.0, 120.5]));
        for text in ["180", "180x", "x3", "0x10", "180x1e9", "nanx50", "a x b"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }
}
