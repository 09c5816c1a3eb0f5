//! A figure as data, independent of the output format.

use serde::Serialize;
use strum::VariantArray as _;

use super::{Axis, Color, Rgb};
use crate::analysis::regime::Regime;

/// Rows of panels with a title and a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Stem of the file name, such as `recurrence`.
    pub name: String,
    /// The title; omitted in the style `paper`.
    pub title: String,
    /// The caption (Markdown), written into the metadata of the file, not into the image.
    pub caption: String,
    /// Width and height in the style `paper`, mm; other styles enlarge it.
    pub size_mm: [f64; 2],
    /// The panels by rows. All rows have the same height, and all panels of a row the same width.
    pub rows: Vec<Vec<Panel>>,
}

/// The ends of a horizontal bar, and its colour.
pub type Bar = ([f64; 2], Color);

/// Text width of a page, mm.
pub const PAGE_MM: f64 = 180.0;
/// Width of a figure of one square panel, mm.
const SQUARE_MM: f64 = 108.0;

impl Figure {
    /// A figure of page width, or narrower if it is a single square, without a caption; `height_mm` is the height of
    /// the whole figure.
    pub fn new(name: &str, title: &str, height_mm: f64, rows: Vec<Vec<Panel>>) -> Self {
        let is_square = matches!(&rows[..], [row] if matches!(&row[..], [one] if one.square));
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: String::new(),
            size_mm: [if is_square { SQUARE_MM } else { PAGE_MM }, height_mm],
            rows,
        }
    }

    /// Panels in rows of at most `columns`, each row `row_mm` high.
    pub fn grid(name: &str, title: &str, row_mm: f64, columns: usize, panels: Vec<Panel>) -> Self {
        let rows = Vec::from_iter(panels.chunks(columns).map(<[Panel]>::to_vec));
        let height = row_mm * rows.len().max(1) as f64;
        Self::new(name, title, height, rows)
    }

    /// A figure for each panel, with the number of the panel in its name. A figure of one panel remains as it is.
    pub fn panels(&self) -> Vec<Self> {
        let panels = self.rows.concat();
        if panels.len() == 1 {
            return vec![self.clone()];
        }
        let figures = panels.into_iter().zip(1..).map(|(panel, number)| Self {
            name: format!("{}-{number}", self.name),
            rows: vec![vec![panel]],
            ..self.clone()
        });
        figures.collect()
    }
}

/// Two axes with layers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Panel {
    /// A short title.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The layers from bottom to top. The legend has the same order.
    pub layers: Vec<Layer>,
    /// Whether the plot area is a square.
    pub square: bool,
    /// A note in the centre that says why there is no data; empty if there is data.
    pub note: String,
    /// Values printed above the plot area; may be empty.
    pub caption: String,
}

impl Panel {
    /// A panel with layers.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, layers: Vec<Layer>) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            layers,
            square: false,
            note: String::new(),
            caption: String::new(),
        }
    }

    /// Horizontal bars in rows with names, the first row at the top. A bar is its ends and its colour.
    pub fn bars(title: &str, x: Axis, rows: Vec<(String, Vec<Bar>)>) -> Self {
        let (names, bars): (_, Vec<_>) = rows.into_iter().unzip();
        let y = Axis::rows(names);
        let mut layers = Vec::new();
        for (row, bars) in bars.into_iter().enumerate() {
            let [low, high] = [-0.32, 0.32].map(|half| y.row(row) + half);
            layers.extend(bars.into_iter().map(|([from, to], color)| {
                let outline = vec![[from, low], [to, low], [to, high], [from, high]];
                Layer::areas(vec![outline], 1.0, color)
            }));
        }
        let zero = vec![[0.0, 0.0], [0.0, y.range[1]]];
        layers.push(Layer::line(zero, Color::Ink));
        Self::new(title, x, y, layers)
    }

    /// Sets the title.
    pub fn with_title(self, title: impl Into<String>) -> Self {
        let title = title.into();
        Self { title, ..self }
    }

    /// Makes the plot area square.
    pub fn square(mut self) -> Self {
        self.square = true;
        self
    }

    /// Sets the note in the centre.
    pub fn with_note(self, note: impl Into<String>) -> Self {
        let note = note.into();
        Self { note, ..self }
    }

    /// Sets the caption.
    pub fn with_caption(self, caption: impl Into<String>) -> Self {
        let caption = caption.into();
        Self { caption, ..self }
    }

    /// Whether an image fills the plot area and would hide a grid.
    pub fn has_image(&self) -> bool {
        let mut layers = self.layers.iter();
        layers.any(|layer| matches!(layer.shape, Shape::Image(_)))
    }
}

/// One element of a panel. Values outside the axes are clipped; non-finite values are skipped.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Layer {
    /// Entity of the layer in a recording, relative to that of the panel.
    pub id: String,
    /// Legend entry; empty for none.
    pub label: String,
    /// Colour of the layer.
    pub color: Color,
    /// Geometry of the layer.
    pub shape: Shape,
    /// Width of lines or radius of points, in points for a font size of 8 points; opacity of areas, 0 to 1.
    pub size: f64,
    /// Shape of the markers of points; the viewer has dots for all.
    pub marker: Marker,
    /// Whether lines are dashed.
    pub dashed: bool,
    /// Whether points fade with age in a recording, the oldest first.
    pub fading: bool,
}

/// The geometry of a layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Shape {
    /// Polylines: the vertices of each.
    Lines(Vec<Vec<[f64; 2]>>),
    /// Points.
    Points(Vec<[f64; 2]>),
    /// Peaks of a curve: labelled points. A label that would overlap another is omitted.
    Peaks(Vec<([f64; 2], String)>),
    /// Filled polygons: the vertices of each.
    Areas(Vec<Vec<[f64; 2]>>),
    /// An image in a rectangle of the axes.
    Image(Image),
}

/// The shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Marker {
    /// A filled circle.
    Dot,
    /// An open circle.
    Ring,
    /// A cross.
    Cross,
    /// A triangle pointing up.
    Up,
    /// A triangle pointing down.
    Down,
}

/// An indexed image of at most 256 colours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Image {
    /// Left and right end on the horizontal axis.
    pub x: [f64; 2],
    /// Lower and upper end on the vertical axis.
    pub y: [f64; 2],
    /// Numbers of columns and rows.
    pub size: [usize; 2],
    /// Palette index of each pixel, row by row from the top.
    pub pixels: Vec<u8>,
    /// Colours with their meanings, which are empty if the index is the meaning.
    pub palette: Vec<(Color, String)>,
}

/// Colour of a cell without a result.
const UNKNOWN: Rgb = [245, 246, 247];

/// A coordinate beyond the end of every axis.
pub(super) const FAR: f64 = 1e300;

impl Layer {
    fn new(id: &str, color: Color, size: f64, shape: Shape) -> Self {
        Self {
            id: id.to_owned(),
            label: String::new(),
            color,
            shape,
            size,
            marker: Marker::Dot,
            dashed: false,
            fading: false,
        }
    }

    /// A polyline.
    pub fn line(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::lines(vec![points], color)
    }

    /// Several polylines.
    pub fn lines(strips: Vec<Vec<[f64; 2]>>, color: Color) -> Self {
        Self::new("curve", color, 1.1, Shape::Lines(strips))
    }

    /// Points with a radius.
    pub fn points(points: Vec<[f64; 2]>, radius: f64, color: Color) -> Self {
        Self::new("points", color, radius, Shape::Points(points))
    }

    /// Peaks with labels.
    pub fn peaks(peaks: Vec<([f64; 2], String)>) -> Self {
        Self::new("peaks", Color::Accent, 2.3, Shape::Peaks(peaks))
    }

    /// Filled polygons.
    pub fn areas(outlines: Vec<Vec<[f64; 2]>>, opacity: f64, color: Color) -> Self {
        Self::new("areas", color, opacity, Shape::Areas(outlines))
    }

    /// The area between two curves, with low opacity. Each span is abscissa, lower and upper end; spans with
    /// a non-finite value are skipped.
    pub fn band(spans: impl IntoIterator<Item = [f64; 3]>, color: Color) -> Self {
        let spans = spans.into_iter();
        let spans = Vec::from_iter(spans.filter(|span| span.iter().all(|c| c.is_finite())));
        let lower = spans.iter().map(|[x, from, _]| [*x, *from]);
        let upper = spans.iter().rev().map(|[x, _, to]| [*x, *to]);
        Self::areas(vec![lower.chain(upper).collect()], 0.2, color)
    }

    /// Vertical error bars. Each span is abscissa, lower and upper end.
    pub fn intervals(spans: impl IntoIterator<Item = [f64; 3]>, color: Color) -> Self {
        let spans = spans.into_iter();
        let strips = spans.map(|[x, from, to]| vec![[x, from], [x, to]]);
        Self::lines(strips.collect(), color).with_id("intervals")
    }

    /// A horizontal line across the panel.
    pub fn horizontal_line(y: f64) -> Self {
        let line = Self::line(vec![[-FAR, y], [FAR, y]], Color::Ink);
        line.with_size(0.8).with_id("level")
    }

    /// Dashed vertical lines across the panel.
    pub fn vertical_lines(places: impl IntoIterator<Item = f64>, color: Color) -> Self {
        let strips = places.into_iter().map(|x| vec![[x, -FAR], [x, FAR]]);
        let lines = Self::lines(strips.collect(), color);
        lines.dashed().with_id("chosen")
    }

    /// An image.
    pub fn image(image: Image) -> Self {
        Self::new("image", Color::Ink, 1.0, Shape::Image(image))
    }

    /// Cells of two axes made by [`Axis::cells`], the lower row first: the index of the colour of each, `None` for an
    /// unknown one.
    pub fn cells(axes: [&Axis; 2], columns: usize, cells: &[Option<u8>], colors: &[Rgb]) -> Self {
        let [x, y] = axes.map(|axis| axis.range);
        let unknown = colors.len() as u8;
        let rows = cells.chunks(columns).rev();
        Self::image(Image {
            x,
            y,
            size: [columns, rows.len()],
            pixels: rows.flatten().map(|cell| cell.unwrap_or(unknown)).collect(),
            palette: plain_palette(colors.iter().copied().chain([UNKNOWN])),
        })
    }

    /// Rings around bifurcations.
    pub fn rings(places: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let rings = Self::points(places.into_iter().collect(), 2.4, Color::Accent);
        rings.with_marker(Marker::Ring).with_id("bifurcations")
    }

    /// A legend entry without data.
    pub fn legend_entry(label: impl Into<String>, color: Color) -> Self {
        Self::points(Vec::new(), 2.5, color).with_label(label)
    }

    /// All points of lines and of points.
    pub fn points_of(&self) -> impl Iterator<Item = [f64; 2]> {
        let strips = match &self.shape {
            Shape::Lines(strips) => &strips[..],
            Shape::Points(points) => std::slice::from_ref(points),
            _ => &[],
        };
        strips.iter().flatten().copied()
    }

    /// Whether the layer has points.
    pub fn has_points(&self) -> bool {
        self.points_of().next().is_some()
    }

    /// Adds a legend entry.
    pub fn with_label(self, label: impl Into<String>) -> Self {
        let label = label.into();
        Self { label, ..self }
    }

    /// Sets the entity of the layer in a recording.
    pub fn with_id(self, id: impl Into<String>) -> Self {
        let id = id.into();
        Self { id, ..self }
    }

    /// Sets the width of lines or the radius of points.
    pub fn with_size(self, size: f64) -> Self {
        Self { size, ..self }
    }

    /// Makes lines dashed.
    pub fn dashed(mut self) -> Self {
        self.dashed = true;
        self
    }

    /// Sets the marker of points.
    pub fn with_marker(self, marker: Marker) -> Self {
        Self { marker, ..self }
    }
}

/// A palette of colours without names.
pub(super) fn plain_palette(colors: impl IntoIterator<Item = Rgb>) -> Vec<(Color, String)> {
    let shades = colors.into_iter().map(|color| Color::Shade([color; 2]));
    shades.map(|shade| (shade, String::new())).collect()
}

/// Legend entries of the types of motion that a picture shows.
pub(super) fn regime_legend(shows: impl Fn(Regime) -> bool) -> impl Iterator<Item = Layer> {
    let shown = Regime::VARIANTS.iter().copied();
    let shown = shown.filter(move |regime| shows(*regime));
    shown.map(|regime| Layer::legend_entry(regime.to_string(), Color::Regime(regime)))
}

/// The panels with letters before their titles.
pub(super) fn lettered(first: char, panels: impl IntoIterator<Item = Panel>) -> Vec<Panel> {
    let lettered = panels.into_iter().zip(first..).map(|(panel, letter)| {
        let title = format!("{letter}: {}", panel.title);
        panel.with_title(title)
    });
    lettered.collect()
}

/// A figure that cannot be rendered.
#[derive(Debug, thiserror::Error)]
#[error("cannot render the figure: {0}")]
pub struct FigureError(pub(super) String);
