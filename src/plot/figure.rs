//! A figure as data: what is drawn, not how.

use super::axis::Axis;
use super::color::{Color, Rgb};

/// Rows of panels with a title and a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Stem of its file name, such as `recurrence`.
    pub name: String,
    /// The title; the style `paper` leaves it out.
    pub title: String,
    /// The caption (Markdown); written into the files' metadata, not into the picture.
    pub caption: String,
    /// Width and height on paper, mm; other styles enlarge it.
    pub size_mm: [f64; 2],
    /// The panels, row by row. All rows are equally high, all panels of a row equally wide.
    pub rows: Vec<Vec<Panel>>,
}

/// Width of a page of text, mm.
pub const PAGE_MM: f64 = 180.0;

impl Figure {
    /// A figure as wide as a page, without a caption; `height_mm` is that of the figure.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        height_mm: f64,
        rows: Vec<Vec<Panel>>,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            caption: String::new(),
            size_mm: [PAGE_MM, height_mm],
            rows,
        }
    }

    /// Panels in rows of at most `columns`, each row `row_mm` high.
    pub fn grid(
        name: impl Into<String>,
        title: impl Into<String>,
        row_mm: f64,
        columns: usize,
        panels: &[Panel],
    ) -> Self {
        let rows: Vec<Vec<Panel>> = panels.chunks(columns).map(<[Panel]>::to_vec).collect();
        let height = row_mm * rows.len().max(1) as f64;
        Self::new(name, title, height, rows)
    }

    /// The same figure, narrower than a page.
    #[must_use]
    pub fn with_width(mut self, width_mm: f64) -> Self {
        self.size_mm[0] = width_mm;
        self
    }
}

/// Two axes with layers between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What it shows, in a few words.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The layers, the lowest first. The legend has the same order.
    pub layers: Vec<Layer>,
    /// Whether the field between the axes is a square.
    pub square: bool,
    /// Why there is nothing to see, written in the middle; empty where there is something.
    pub note: String,
    /// Numbers that belong to it, written above the field; may be empty.
    pub caption: String,
}

impl Panel {
    /// A panel of layers.
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

    /// A list of bars, the first at the top, each with its text above it.
    pub fn bars(title: impl Into<String>, x: Axis, bars: Vec<Bar>) -> Self {
        let y = Axis::hidden([0.0, bars.len().max(1) as f64]);
        let top = y.range[1];
        let left = x.range[0];
        let layers = bars.into_iter().zip(0..).flat_map(|(bar, row)| {
            let top = top - f64::from(row);
            let ends = [top - 0.85, top - 0.55];
            let [low, high] = ends.map(|y| [[left, y], [bar.value, y]]);
            let outline = vec![low[0], low[1], high[1], high[0]];
            [
                Layer::areas(vec![outline], 1.0, bar.color).at("bars"),
                Layer::text([left, top - 0.3], bar.text),
            ]
        });
        let layers = layers.collect();
        Self::new(title, x, y, layers)
    }

    /// The same panel with another title.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The same panel with a square field.
    #[must_use]
    pub fn square(mut self) -> Self {
        self.square = true;
        self
    }

    /// The same panel with a note in the middle.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// The same panel with a caption.
    #[must_use]
    pub fn with_caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Whether an image fills the field, which a grid would hide.
    pub fn has_image(&self) -> bool {
        let mut shapes = self.layers.iter().map(|layer| &layer.shape);
        shapes.any(|shape| matches!(shape, Shape::Image(_)))
    }
}

/// One thing on a panel. Values outside the axes are cut off; values that are not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name of the layer's entity in a recording, below that of the panel.
    pub id: String,
    /// Entry in the legend; empty for none.
    pub label: String,
    /// Its colour.
    pub color: Color,
    /// What is drawn.
    pub shape: Shape,
}

/// What a layer draws. Widths and radii are in points at a font size of 8 points.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Lines through points.
    Lines {
        /// The points of each line.
        strips: Vec<Vec<[f64; 2]>>,
        /// Width of the lines.
        width: f64,
        /// Whether the lines are dashed.
        dashed: bool,
    },
    /// Points.
    Points {
        /// Where they are.
        points: Vec<[f64; 2]>,
        /// Half their size.
        radius: f64,
        /// Their form.
        marker: Marker,
        /// What the pointer shows at each; empty for nothing.
        hover: Vec<String>,
    },
    /// Peaks of a curve: points with names, which stand where no other name does.
    Peaks(Vec<([f64; 2], String)>),
    /// Filled polygons.
    Areas {
        /// The corners of each.
        outlines: Vec<Vec<[f64; 2]>>,
        /// How much of what is below they hide, 0 to 1.
        opacity: f64,
    },
    /// An image that fills a rectangle of the axes.
    Image(Image),
    /// A text, from its left end on.
    Text([f64; 2], String),
}

/// The form of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    #[default]
    Dot,
    /// An open circle.
    Ring,
    /// A cross.
    Cross,
    /// A triangle that points up.
    Up,
    /// A triangle that points down.
    Down,
}

/// A horizontal bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// How far it reaches.
    pub value: f64,
    /// The text above it.
    pub text: String,
    /// Its colour.
    pub color: Color,
}

/// An image of at most 256 colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub y: [f64; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// The colour of each pixel as a place in the palette, row by row, the upper row first.
    pub pixels: Vec<u8>,
    /// The colours.
    pub palette: Vec<Swatch>,
}

/// A colour of a palette and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Swatch {
    /// On a light background.
    pub light: Rgb,
    /// On a dark background.
    pub dark: Rgb,
    /// Meaning; empty where the place in the palette says it.
    pub name: String,
}

/// Beyond the end of every axis.
const FAR: f64 = 1e300;

impl Layer {
    fn new(id: &str, color: Color, shape: Shape) -> Self {
        Self {
            id: id.to_owned(),
            label: String::new(),
            color,
            shape,
        }
    }

    /// A line through points.
    pub fn line(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::lines(vec![points], color)
    }

    /// Several lines.
    pub fn lines(strips: Vec<Vec<[f64; 2]>>, color: Color) -> Self {
        let (width, dashed) = (1.1, false);
        let lines = Shape::Lines {
            strips,
            width,
            dashed,
        };
        Self::new("curve", color, lines)
    }

    /// Points of some radius.
    pub fn points(points: Vec<[f64; 2]>, radius: f64, color: Color) -> Self {
        let points = Shape::Points {
            points,
            radius,
            marker: Marker::Dot,
            hover: Vec::new(),
        };
        Self::new("points", color, points)
    }

    /// Peaks with their names.
    pub fn peaks(peaks: Vec<([f64; 2], String)>) -> Self {
        Self::new("peaks", Color::Accent, Shape::Peaks(peaks))
    }

    /// Filled polygons.
    pub fn areas(outlines: Vec<Vec<[f64; 2]>>, opacity: f64, color: Color) -> Self {
        Self::new("areas", color, Shape::Areas { outlines, opacity })
    }

    /// The area between two curves, lightly filled: place on the horizontal axis, lower and upper end. A
    /// place without a finite end is left out.
    pub fn band(spans: &[[f64; 3]], color: Color) -> Self {
        let spans = spans
            .iter()
            .filter(|span| span.iter().all(|c| c.is_finite()));
        let lower = spans.clone().map(|[x, from, _]| [*x, *from]);
        let upper = spans.rev().map(|[x, _, to]| [*x, *to]);
        Self::areas(vec![lower.chain(upper).collect()], 0.2, color).at("band")
    }

    /// Intervals of single values: place on the horizontal axis, lower and upper end.
    pub fn intervals(spans: &[[f64; 3]], color: Color) -> Self {
        let strips = spans
            .iter()
            .map(|[x, from, to]| vec![[*x, *from], [*x, *to]]);
        Self::lines(strips.collect(), color).at("intervals")
    }

    /// Vertical bars of a width: place of the middle on the horizontal axis, and the two ends.
    pub fn columns(spans: &[[f64; 3]], width: f64, color: Color) -> Self {
        let outlines = spans.iter().map(|[x, from, to]| {
            let [left, right] = [x - 0.5 * width, x + 0.5 * width];
            vec![[left, *from], [right, *from], [right, *to], [left, *to]]
        });
        Self::areas(outlines.collect(), 1.0, color).at("columns")
    }

    /// A horizontal line across the field.
    pub fn level(y: f64) -> Self {
        let ends = [[-FAR, y], [FAR, y]];
        Self::line(ends.to_vec(), Color::Ink).wide(0.8).at("level")
    }

    /// A dashed vertical line across the field.
    pub fn upright(x: f64, color: Color) -> Self {
        let ends = [[x, -FAR], [x, FAR]];
        Self::line(ends.to_vec(), color).dashed().at("chosen")
    }

    /// An image.
    pub fn image(image: Image) -> Self {
        Self::new("image", Color::Ink, Shape::Image(image))
    }

    /// A text.
    pub fn text(at: [f64; 2], text: impl Into<String>) -> Self {
        Self::new("text", Color::Ink, Shape::Text(at, text.into()))
    }

    /// An entry in the legend alone.
    pub fn key(label: impl Into<String>, color: Color) -> Self {
        Self::points(Vec::new(), 2.5, color).named(label)
    }

    /// The last point of its last line.
    pub fn last_point(&self) -> Option<[f64; 2]> {
        match &self.shape {
            Shape::Lines { strips, .. } => strips.last()?.last().copied(),
            _ => None,
        }
    }

    /// Whether it has points.
    pub fn has_points(&self) -> bool {
        matches!(&self.shape, Shape::Points { points, .. } if !points.is_empty())
    }

    /// The same layer with an entry in the legend.
    #[must_use]
    pub fn named(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// The same layer as another entity of a recording.
    #[must_use]
    pub fn at(mut self, id: impl Into<String>) -> Self {
        self.id = id.into();
        self
    }

    /// The same lines with another width.
    #[must_use]
    pub fn wide(mut self, new: f64) -> Self {
        if let Shape::Lines { width, .. } = &mut self.shape {
            *width = new;
        }
        self
    }

    /// The same lines, dashed.
    #[must_use]
    pub fn dashed(mut self) -> Self {
        if let Shape::Lines { dashed, .. } = &mut self.shape {
            *dashed = true;
        }
        self
    }

    /// The same points in another form.
    #[must_use]
    pub fn marked(mut self, new: Marker) -> Self {
        if let Shape::Points { marker, .. } = &mut self.shape {
            *marker = new;
        }
        self
    }

    /// The same points with texts for the pointer.
    #[must_use]
    pub fn hovered(mut self, texts: Vec<String>) -> Self {
        if let Shape::Points { hover, .. } = &mut self.shape {
            *hover = texts;
        }
        self
    }
}

impl Swatch {
    /// A colour on any background.
    pub fn plain(color: Rgb) -> Self {
        Self {
            light: color,
            dark: color,
            name: String::new(),
        }
    }
}

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the figure could not be drawn: {0}")]
pub struct FigureError(pub(super) String);
