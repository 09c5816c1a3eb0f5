//! Layers as SVG elements.

use base64::Engine as _;

use super::canvas::{Anchor, Canvas, PlotArea, Rect, hex};
use super::color::Color;
use super::figure::{Image, Layer, Marker, Shape};
use super::text;

/// Radius of the markers of peaks.
const PEAK: f64 = 2.3;
/// Rows above a peak that are tried for its label.
const NAME_ROWS: usize = 4;

/// Draws the part of a layer within the axes.
pub fn draw(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    match &layer.shape {
        Shape::Lines {
            strips,
            width,
            dashed,
        } => {
            for strip in strips {
                polyline(canvas, area, strip, layer.color, (*width, *dashed));
            }
        }
        Shape::Points {
            points,
            radius,
            marker,
            hover,
        } => {
            let hover = hover.iter().map(String::as_str);
            let hover = hover.chain(std::iter::repeat(""));
            open_group(canvas, layer.color, *marker);
            for (point, hover) in points.iter().zip(hover) {
                if let Some(at) = area.position(*point).filter(|_| area.contains(*point)) {
                    let radius = canvas.scaled(*radius);
                    put_marker(canvas, at, radius, *marker, hover);
                }
            }
            canvas.push(format_args!("</g>"));
        }
        Shape::Peaks(peaks) => {
            open_group(canvas, layer.color, Marker::Dot);
            for (point, _) in peaks {
                if let Some(at) = area.position(*point).filter(|_| area.contains(*point)) {
                    let radius = canvas.scaled(PEAK);
                    put_marker(canvas, at, radius, Marker::Dot, "");
                }
            }
            canvas.push(format_args!("</g>"));
        }
        Shape::Areas { outlines, opacity } => {
            for outline in outlines {
                polygon(canvas, area, outline, layer.color, *opacity);
            }
        }
        Shape::Image(image) => draw_image(canvas, area, image),
        Shape::Text(..) => {}
    }
}

/// Draws the texts of a layer where they cover no other text. A text without such a place is omitted.
pub fn draw_text(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    match &layer.shape {
        Shape::Text(at, name) => {
            let (half, em) = (0.5 * label_width(canvas, name), canvas.font_size);
            if let Some([x, y]) = area.position(*at).filter(|_| area.contains(*at)) {
                let at = [x.max(area.rect.x) + half, y];
                let rows = (0..NAME_ROWS).map(|k| [at[0], y - (0.9 + 1.2 * k as f64) * em]);
                label(canvas, area, rows, name);
            }
        }
        Shape::Peaks(peaks) => label_peaks(canvas, area, peaks, layer.color),
        _ => {}
    }
}

/// Draws the legend sample of a layer, starting at a position.
pub fn legend_sample(canvas: &mut Canvas, layer: &Layer, [x, y]: [f64; 2], width: f64) {
    match &layer.shape {
        Shape::Lines {
            width: line,
            dashed,
            ..
        } => {
            let more = dashes(canvas, *dashed);
            canvas.line([x, y, x + width, y], layer.color, line.max(1.1), &more);
        }
        Shape::Areas { .. } | Shape::Image(_) => {
            let (color, height) = (hex(layer.color.on_light()), 0.8 * canvas.font_size);
            let top = y - 0.5 * height;
            canvas.push(format_args!(
                "<rect x=\"{x:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\"/>"
            ));
        }
        Shape::Points { marker, .. } => {
            open_group(canvas, layer.color, *marker);
            let radius = canvas.scaled(2.3);
            put_marker(canvas, [x + 0.5 * width, y], radius, *marker, "");
            canvas.push(format_args!("</g>"));
        }
        _ => {}
    }
}

fn dashes(canvas: &Canvas, dashed: bool) -> String {
    if dashed {
        format!(
            " stroke-dasharray=\"{:.2} {:.2}\"",
            canvas.scaled(3.2),
            canvas.scaled(2.4)
        )
    } else {
        String::new()
    }
}

fn polyline(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    points: &[[f64; 2]],
    color: Color,
    (width, dashed): (f64, bool),
) {
    let places = places(area, points);
    let (color, dashes) = (hex(color.on_light()), dashes(canvas, dashed));
    let width = canvas.scaled(width);
    canvas.push(format_args!(
        "<polyline points=\"{places}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" \
         stroke-linejoin=\"round\"{dashes}/>"
    ));
}

/// Opens the group of the points of one layer.
fn open_group(canvas: &mut Canvas, color: Color, marker: Marker) {
    let (color, width) = (hex(color.on_light()), canvas.scaled(1.0));
    match marker {
        Marker::Dot | Marker::Up | Marker::Down => {
            canvas.push(format_args!("<g fill=\"{color}\">"))
        }
        Marker::Ring | Marker::Cross => canvas.push(format_args!(
            "<g fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\">"
        )),
    }
}

fn put_marker(canvas: &mut Canvas, [x, y]: [f64; 2], r: f64, marker: Marker, hover: &str) {
    let title = match hover {
        "" => String::new(),
        hover => format!("<title>{}</title>", text::escape(hover)),
    };
    let path = match marker {
        Marker::Dot | Marker::Ring => {
            canvas.push(format_args!(
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\">{title}</circle>"
            ));
            return;
        }
        Marker::Cross => format!(
            "M{:.2},{:.2}L{:.2},{:.2}M{:.2},{:.2}L{:.2},{:.2}",
            x - r,
            y - r,
            x + r,
            y + r,
            x - r,
            y + r,
            x + r,
            y - r
        ),
        Marker::Up | Marker::Down => {
            let up = if marker == Marker::Up {
                -1.2 * r
            } else {
                1.2 * r
            };
            format!(
                "M{:.2},{:.2}L{:.2},{:.2}L{:.2},{:.2}Z",
                x - 1.1 * r,
                y - 0.6 * up,
                x + 1.1 * r,
                y - 0.6 * up,
                x,
                y + up
            )
        }
    };
    canvas.push(format_args!("<path d=\"{path}\">{title}</path>"));
}

fn polygon(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    outline: &[[f64; 2]],
    color: Color,
    opacity: f64,
) {
    let (places, color) = (places(area, outline), hex(color.on_light()));
    canvas.push(format_args!(
        "<polygon points=\"{places}\" fill=\"{color}\" fill-opacity=\"{opacity}\"/>"
    ));
}

/// Positions in the format of SVG.
fn places(area: &PlotArea<'_>, points: &[[f64; 2]]) -> String {
    let places = points.iter().filter_map(|point| area.position(*point));
    let places: Vec<String> = places.map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
    places.join(" ")
}

fn draw_image(canvas: &mut Canvas, area: &PlotArea<'_>, image: &Image) {
    let corners = [[image.x[0], image.y[1]], [image.x[1], image.y[0]]];
    let [Some([x1, y1]), Some([x2, y2])] = corners.map(|corner| area.position(corner)) else {
        return;
    };
    let Some(png) = encode(image) else {
        return;
    };
    let data = base64::engine::general_purpose::STANDARD.encode(png);
    let (width, height) = (x2 - x1, y2 - y1);
    canvas.push(format_args!(
        "<image x=\"{x1:.2}\" y=\"{y1:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
         preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" \
         xlink:href=\"data:image/png;base64,{data}\"/>"
    ));
}

/// The image as a PNG with a palette; `None` if it has no pixels.
fn encode(image: &Image) -> Option<Vec<u8>> {
    let [width, height] = image.size.map(|side| side as u32);
    let palette: Vec<u8> = image
        .palette
        .iter()
        .flat_map(|swatch| swatch.light)
        .collect();
    let mut data = Vec::new();
    let mut encoder = png::Encoder::new(&mut data, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&image.pixels).ok()?;
    writer.finish().ok()?;
    Some(data)
}

/// Labels the peaks in the given order, each above its tip, beside it, or in a free row above with a line to the tip.
/// A label covers no other peak, and a line no label.
fn label_peaks(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    peaks: &[([f64; 2], String)],
    color: Color,
) {
    let em = canvas.font_size;
    let (left, right) = (area.rect.x, area.rect.x + area.rect.width);
    let shown = peaks.iter().filter(|(point, _)| area.contains(*point));
    let tips = shown.filter_map(|(point, name)| Some((area.position(*point)?, name)));
    let tips: Vec<([f64; 2], &String)> = tips.collect();
    for ([x, tip], name) in tips.iter().filter(|(_, name)| !name.is_empty()) {
        let half = 0.5 * label_width(canvas, name);
        let middle = x.clamp((left + half).min(right - half), right - half);
        let row = |k: usize| [middle, tip - (1.0 + 1.2 * k as f64) * em];
        // Next to the tip, also for peaks just below the top.
        let level = tip.max(area.rect.y + 0.7 * em);
        let beside = [1.0, -1.0].map(|side| [x + side * (half + 0.7 * em), level]);
        let places = [row(0)].into_iter().chain(beside);
        let places = places.chain((1..NAME_ROWS).map(row)).filter(|[middle, y]| {
            let covers = |([x, tip], _): &([f64; 2], _)| {
                (x - middle).abs() < half + 0.3 * em && (tip - y).abs() < 0.8 * em
            };
            let line = Rect {
                x: *x,
                y: y + 0.6 * em,
                width: 0.1 * em,
                height: tip - y - 0.6 * em,
            };
            !tips.iter().any(covers) && (*y > tip - 1.5 * em || canvas.is_free(&line))
        });
        let places: Vec<[f64; 2]> = places.collect();
        let place = label(canvas, area, places.into_iter(), name);
        if let Some([_, y]) = place.filter(|[_, y]| *y < tip - 1.5 * em) {
            canvas.line([*x, y + 0.6 * em, *x, *tip], color, 0.5, "");
        }
    }
}

/// Width of a label with its background.
fn label_width(canvas: &Canvas, name: &str) -> f64 {
    text::width(&text::shown(name), canvas.font_size, false) + 0.4 * canvas.font_size
}

/// Writes a label at the first of some places where it lies in the plot area and covers no other text, and returns the
/// place.
fn label(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    mut places: impl Iterator<Item = [f64; 2]>,
    name: &str,
) -> Option<[f64; 2]> {
    let em = canvas.font_size;
    let (width, height) = (label_width(canvas, name), 1.15 * em);
    let background = |[x, y]: [f64; 2]| Rect {
        x: x - 0.5 * width,
        y: y - 0.48 * em,
        width,
        height,
    };
    let place = places.find(|at| {
        let place = background(*at);
        place.is_in(&area.rect) && canvas.is_free(&place)
    })?;
    let Rect { x, y, .. } = background(place);
    // A translucent background keeps the label legible.
    canvas.push(format_args!(
        "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"#fff\" fill-opacity=\"0.85\"/>"
    ));
    canvas.text(place, name, Anchor::Middle, (1.0, false, Color::Ink));
    Some(place)
}
