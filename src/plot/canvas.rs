//! The SVG document under construction, and the mapping of values to positions on the page.

use std::fmt::Write as _;

use base64::Engine as _;
use kurbo::Rect;

use super::text::{escape, shown, width};
use super::{Axis, Color, Image, Layer, Marker, Panel, Rgb, Shape, figure::FAR};

/// Line height over font size.
pub const LINE_HEIGHT: f64 = 1.4;

/// Boxes that overlap by rounding errors only are apart, points.
const ROUNDING: f64 = 0.01;

/// Size relative to the font size, weight and colour of a text.
pub type TextStyle = (f64, bool, Color);

/// The document so far, with the boxes of its texts.
#[derive(Default)]
pub struct Canvas {
    pub out: String,
    /// Font size, points.
    pub font_size: f64,
    /// In points; y points down.
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
    pub fn new([width, height]: [f64; 2], font_size: f64) -> Self {
        Self {
            font_size,
            page: Rect::from_origin_size((0.0, 0.0), (width, height)),
            fits: true,
            ..Self::default()
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
    pub fn line(&mut self, [x1, y1, x2, y2]: [f64; 4], color: Color, width: f64) {
        let (color, width) = (hex(color), self.scaled(width));
        self.push(format_args!(
            "<path d=\"M{x1:.2},{y1:.2}L{x2:.2},{y2:.2}\" stroke=\"{color}\" \
             stroke-width=\"{width:.2}\" fill=\"none\"/>"
        ));
    }

    /// Whether a box is on the page and covers no text.
    pub fn is_free(&self, place: Rect) -> bool {
        let place = place.inflate(-ROUNDING, -ROUNDING);
        self.page.contains_rect(place) && !self.texts.iter().any(|text| text.overlaps(place))
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
        let taken = Rect::from_origin_size((left, y - 0.42 * height), (width, height));
        self.write(taken, &place, text, style);
    }

    /// Draws a text that is read from below, centred at a position.
    pub fn turned_text(&mut self, [x, y]: [f64; 2], text: &str, color: Color) {
        let (width, height) = (self.font_size, width(&shown(text), self.font_size, false));
        let base = x + 0.36 * width;
        let place =
            format!("transform=\"translate({base:.2},{y:.2}) rotate(-90)\" text-anchor=\"middle\"");
        let corner = (x - 0.42 * width, y - 0.5 * height);
        let taken = Rect::from_origin_size(corner, (width, height));
        self.write(taken, &place, text, (1.0, false, color));
    }

    fn write(&mut self, taken: Rect, place: &str, text: &str, (size, bold, color): TextStyle) {
        self.fits &= taken.is_zero_area() || self.is_free(taken);
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
        let right = self.rect.x0 + self.rect.width() * share(&self.panel.x, x);
        let down = self.rect.y1 - self.rect.height() * share(&self.panel.y, y);
        (x.is_finite() && y.is_finite()).then_some([right, down])
    }

    /// Positions of the points within the axes.
    pub fn inside<'b>(&self, points: impl IntoIterator<Item = &'b [f64; 2]>) -> Vec<[f64; 2]> {
        let room = self.rect.inflate(ROUNDING, ROUNDING);
        let places = points.into_iter().filter_map(|point| self.position(*point));
        places.filter(|[x, y]| room.contains((*x, *y))).collect()
    }
}

/// Radius of the marker of a legend entry.
const SAMPLE: f64 = 2.3;
/// Rows above a peak that are tried for its label.
const NAME_ROWS: usize = 4;

/// Draws the part of a layer within the axes.
pub fn draw(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    let path = match &layer.shape {
        Shape::Lines(strips) | Shape::Areas(strips) => {
            let places = strips.iter().map(|strip| strip.iter().copied());
            let places = places.map(|strip| line(strip.filter_map(|point| area.position(point))));
            places.collect()
        }
        Shape::Points(points) => markers(canvas, layer, layer.size, area.inside(points)),
        Shape::Peaks(peaks) => {
            let points = peaks.iter().map(|(point, _)| point);
            markers(canvas, layer, layer.size, area.inside(points))
        }
        Shape::Image(image) => return canvas.out.extend(image_element(area, image)),
    };
    draw_path(canvas, layer, &path);
}

/// Draws the legend sample of a layer, starting at a position.
pub fn legend_sample(canvas: &mut Canvas, layer: &Layer, [x, y]: [f64; 2], width: f64) {
    let [top, bottom] = [-0.4, 0.4].map(|half| y + half * canvas.font_size);
    let (middle, end) = (x + 0.5 * width, x + width);
    let path = match &layer.shape {
        Shape::Lines(_) => line([[x, y], [end, y]]),
        Shape::Points(_) | Shape::Peaks(_) => markers(canvas, layer, SAMPLE, vec![[middle, y]]),
        _ => line([[x, top], [end, top], [end, bottom], [x, bottom]]),
    };
    draw_path(canvas, layer, &path);
}

fn draw_path(canvas: &mut Canvas, layer: &Layer, path: &str) {
    let (color, size) = (hex(layer.color), layer.size);
    let [width, thin, dash, gap] = [size, 1.0, 2.7, 1.8].map(|length| canvas.scaled(length));
    let paint = match (&layer.shape, layer.marker) {
        (Shape::Lines(_), _) => {
            let dashes = format!(" stroke-dasharray=\"{dash:.2} {gap:.2}\"");
            let dashes = if layer.dashed { &*dashes } else { "" };
            format!(
                "fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" \
                 stroke-linejoin=\"round\"{dashes}"
            )
        }
        (Shape::Areas(_), _) => format!("fill=\"{color}\" fill-opacity=\"{size}\""),
        (_, Marker::Ring | Marker::Cross) => {
            format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{thin:.2}\"")
        }
        _ => format!("fill=\"{color}\""),
    };
    canvas.push(format_args!("<path d=\"{path}\" {paint}/>"));
}

/// A line as path data of SVG.
fn line(places: impl IntoIterator<Item = [f64; 2]>) -> String {
    let steps = std::iter::once('M').chain(std::iter::repeat('L'));
    let path = steps.zip(places);
    path.map(|(step, [x, y])| format!("{step}{x:.2},{y:.2}"))
        .collect()
}

/// Markers with a radius for a font size of 8 points as path data of SVG.
fn markers(canvas: &Canvas, layer: &Layer, radius: f64, places: Vec<[f64; 2]>) -> String {
    let r = canvas.scaled(radius);
    let [half, low, high, d] = [1.1 * r, 0.72 * r, 1.92 * r, 2.0 * r];
    let outline = match layer.marker {
        // Almost a full turn.
        Marker::Dot | Marker::Ring => format!("m0,-{r:.2}a{r:.2},{r:.2} 0 1 1-.01,0z"),
        Marker::Cross => format!("m-{r:.2},-{r:.2}l{d:.2},{d:.2}m0,-{d:.2}l-{d:.2},{d:.2}"),
        Marker::Up => format!("m-{half:.2},{low:.2}l{half:.2},-{high:.2} {half:.2},{high:.2}z"),
        Marker::Down => format!("m-{half:.2},-{low:.2}l{half:.2},{high:.2} {half:.2},-{high:.2}z"),
    };
    let places = places.iter();
    let markers = places.map(|[x, y]| format!("M{x:.2},{y:.2}{outline}"));
    markers.collect()
}

/// An image as an element with a PNG that has its palette; `None` if it has no pixels.
fn image_element(area: &PlotArea<'_>, image: &Image) -> Option<String> {
    let [x1, y1] = area.position([image.x[0], image.y[1]])?;
    let [x2, y2] = area.position([image.x[1], image.y[0]])?;
    let [columns, rows] = image.size.map(|side| side as u32);
    let colors = image.palette.iter();
    let palette: Vec<u8> = colors.flat_map(|(color, _)| color.on_light()).collect();
    let mut data = Vec::new();
    let mut encoder = png::Encoder::new(&mut data, columns, rows);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&image.pixels).ok()?;
    writer.finish().ok()?;
    let data = base64::engine::general_purpose::STANDARD.encode(data);
    let (width, height) = (x2 - x1, y2 - y1);
    Some(format!(
        "<image x=\"{x1:.2}\" y=\"{y1:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
         preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" \
         xlink:href=\"data:image/png;base64,{data}\"/>\n"
    ))
}

/// Labels the peaks of a layer in the given order, each above its tip, beside it, or in a free row above with a line to the
/// tip. A label covers no other peak, and a line no label.
pub fn label_peaks(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    let Shape::Peaks(peaks) = &layer.shape else {
        return;
    };
    let em = canvas.font_size;
    let (left, right) = (area.rect.x0, area.rect.x1);
    let tips = peaks.iter();
    let tips = tips.filter_map(|(point, name)| Some((area.inside([point]).pop()?, name)));
    let tips: Vec<([f64; 2], &String)> = tips.collect();
    for &([x, tip], name) in tips.iter().filter(|(_, name)| !name.is_empty()) {
        let width = width(&shown(name), em, false) + 0.4 * em;
        let half = 0.5 * width;
        let background =
            |[x, y]: [f64; 2]| Rect::new(x - half, y - 0.48 * em, x + half, y + 0.67 * em);
        let centre = x.clamp((left + half).min(right - half), right - half);
        let row = |k: usize| [centre, tip - (1.0 + 1.2 * k as f64) * em];
        // Next to the tip, also for peaks just below the top.
        let level = tip.max(area.rect.y0 + 0.7 * em);
        let beside = [1.0, -1.0].map(|side| [x + side * (half + 0.7 * em), level]);
        let places = [row(0)].into_iter().chain(beside);
        let mut places = places.chain((1..NAME_ROWS).map(row));
        let place = places.find(|&[middle, y]| {
            let line = Rect::new(x, y + 0.6 * em, x + 0.1 * em, tip);
            let background = background([middle, y]);
            let wide = background.inflate(0.3 * em, 0.2 * em);
            let room = area.rect.inflate(ROUNDING, ROUNDING);
            room.contains_rect(background)
                && canvas.is_free(background)
                && !tips.iter().any(|&([x, tip], _)| wide.contains((x, tip)))
                && (y > tip - 1.5 * em || canvas.is_free(line))
        });
        let Some(place) = place else {
            continue;
        };
        let Rect { x0, y0, .. } = background(place);
        let height = 1.15 * em;
        // A translucent background keeps the label legible.
        canvas.push(format_args!(
            "<rect x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"#fff\" fill-opacity=\"0.85\"/>"
        ));
        canvas.text(place, name, Anchor::Middle, (1.0, false, Color::Ink));
        if place[1] < tip - 1.5 * em {
            canvas.line([x, place[1] + 0.6 * em, x, tip], layer.color, 0.5);
        }
    }
}
