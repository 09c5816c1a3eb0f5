//! Layers as SVG elements.

use base64::Engine as _;

use super::canvas::{Anchor, Canvas, PlotArea, hex};
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

/// Draws the texts of a layer, which may extend beyond the axes.
pub fn draw_text(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    match &layer.shape {
        Shape::Text(place, words) => {
            if let Some([x, y]) = area.position(*place).filter(|_| area.contains(*place)) {
                // A text that starts at the vertical axis must not touch it.
                let at = [x.max(area.rect.x + 0.5 * canvas.font_size), y];
                canvas.text(at, words, Anchor::Start, (1.0, false, layer.color));
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
    match dashed {
        true => format!(
            " stroke-dasharray=\"{:.2} {:.2}\"",
            canvas.scaled(3.2),
            canvas.scaled(2.4)
        ),
        false => String::new(),
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

/// Labels the peaks above their tips in the given order. Each label takes the lowest row in which it overlaps
/// no other; a label without space is omitted.
fn label_peaks(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    peaks: &[([f64; 2], String)],
    color: Color,
) {
    let font_size = canvas.font_size;
    let (left, right) = (area.rect.x, area.rect.x + area.rect.width);
    let mut taken: Vec<[f64; 3]> = Vec::new();
    for (point, name) in peaks.iter().filter(|(_, name)| !name.is_empty()) {
        let Some([x, tip]) = area.position(*point).filter(|_| area.contains(*point)) else {
            continue;
        };
        let half = 0.5 * text::width(name, font_size, false) + 0.2 * font_size;
        let middle = x.clamp((left + half).min(right - half), right - half);
        let above = |k: usize| [middle, tip - (1.0 + 1.2 * k as f64) * font_size];
        // Next to the tip, for peaks just below the top.
        let beside = [
            x + half + 0.7 * font_size,
            tip.max(area.rect.y + 0.7 * font_size),
        ];
        let is_free = |[middle, y]: &[f64; 2]| {
            let covers = |[other, width, height]: &[f64; 3]| {
                (other - middle).abs() < width + half && (height - y).abs() < 1.15 * font_size
            };
            *y > area.rect.y && middle + half <= right + 0.01 && !taken.iter().any(covers)
        };
        let mut places = (0..NAME_ROWS).map(above).chain([beside]);
        let Some([middle, y]) = places.find(is_free) else {
            continue;
        };
        taken.push([middle, half, y]);
        // A translucent background keeps the label legible.
        canvas.push(format_args!(
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"#fff\" fill-opacity=\"0.8\"/>",
            middle - half,
            y - 0.55 * font_size,
            2.0 * half,
            1.1 * font_size
        ));
        if y < tip - 1.5 * font_size {
            canvas.line([x, y + 0.6 * font_size, x, tip], color, 0.5, "");
        }
        canvas.text([middle, y], name, Anchor::Middle, (0.95, false, Color::Ink));
    }
}
