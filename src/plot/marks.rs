//! What layers look like in SVG.

use base64::Engine as _;

use super::canvas::{Anchor, Canvas, Field, hex};
use super::color::Color;
use super::figure::{Image, Layer, Marker, Shape};
use super::text;

/// Radius of the dots on peaks.
const PEAK: f64 = 2.3;
/// Lines of names above a peak that are tried.
const TRIES: usize = 4;

/// Draws what a layer has between the axes.
pub fn draw(canvas: &mut Canvas, field: &Field<'_>, layer: &Layer) {
    match &layer.shape {
        Shape::Lines {
            strips,
            width,
            dashed,
        } => {
            for strip in strips {
                polyline(canvas, field, strip, layer.color, (*width, *dashed));
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
                if let Some(at) = field.at(*point).filter(|_| field.holds(*point)) {
                    let radius = canvas.scaled(*radius);
                    put_marker(canvas, at, radius, *marker, hover);
                }
            }
            canvas.put(format_args!("</g>"));
        }
        Shape::Peaks(peaks) => {
            open_group(canvas, layer.color, Marker::Dot);
            for (point, _) in peaks {
                if let Some(at) = field.at(*point).filter(|_| field.holds(*point)) {
                    let radius = canvas.scaled(PEAK);
                    put_marker(canvas, at, radius, Marker::Dot, "");
                }
            }
            canvas.put(format_args!("</g>"));
        }
        Shape::Areas { outlines, opacity } => {
            for outline in outlines {
                area(canvas, field, outline, layer.color, *opacity);
            }
        }
        Shape::Image(image) => draw_image(canvas, field, image),
        Shape::Text(..) => {}
    }
}

/// Writes the texts of a layer, which may stand out over the axes.
pub fn write(canvas: &mut Canvas, field: &Field<'_>, layer: &Layer) {
    match &layer.shape {
        Shape::Text(place, words) => {
            if let Some([x, y]) = field.at(*place).filter(|_| field.holds(*place)) {
                // Clear of an axis that it begins at.
                let at = [x.max(field.frame.x + 0.5 * canvas.letters), y];
                canvas.write(at, words, Anchor::Start, (1.0, false, layer.color));
            }
        }
        Shape::Peaks(peaks) => name_peaks(canvas, field, peaks, layer.color),
        _ => {}
    }
}

/// The sample of a layer in a legend, from a place on.
pub fn sample(canvas: &mut Canvas, layer: &Layer, [x, y]: [f64; 2], width: f64) {
    match &layer.shape {
        Shape::Lines {
            width: line,
            dashed,
            ..
        } => {
            let more = dashes(canvas, *dashed);
            canvas.stroke([x, y, x + width, y], layer.color, line.max(1.1), &more);
        }
        Shape::Areas { .. } | Shape::Image(_) => {
            let (color, height) = (hex(layer.color.on_light()), 0.8 * canvas.letters);
            let top = y - 0.5 * height;
            canvas.put(format_args!(
                "<rect x=\"{x:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\"/>"
            ));
        }
        Shape::Points { marker, .. } => {
            open_group(canvas, layer.color, *marker);
            let radius = canvas.scaled(2.3);
            put_marker(canvas, [x + 0.5 * width, y], radius, *marker, "");
            canvas.put(format_args!("</g>"));
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
    field: &Field<'_>,
    points: &[[f64; 2]],
    color: Color,
    (width, dashed): (f64, bool),
) {
    let places = places(field, points);
    let (color, dashes) = (hex(color.on_light()), dashes(canvas, dashed));
    let width = canvas.scaled(width);
    canvas.put(format_args!(
        "<polyline points=\"{places}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" \
         stroke-linejoin=\"round\"{dashes}/>"
    ));
}

/// Begins the points of one colour and form.
fn open_group(canvas: &mut Canvas, color: Color, marker: Marker) {
    let (color, width) = (hex(color.on_light()), canvas.scaled(1.0));
    match marker {
        Marker::Dot | Marker::Up | Marker::Down => canvas.put(format_args!("<g fill=\"{color}\">")),
        Marker::Ring | Marker::Cross => canvas.put(format_args!(
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
            canvas.put(format_args!(
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
    canvas.put(format_args!("<path d=\"{path}\">{title}</path>"));
}

fn area(canvas: &mut Canvas, field: &Field<'_>, outline: &[[f64; 2]], color: Color, opacity: f64) {
    let (places, color) = (places(field, outline), hex(color.on_light()));
    canvas.put(format_args!(
        "<polygon points=\"{places}\" fill=\"{color}\" fill-opacity=\"{opacity}\"/>"
    ));
}

/// Places of points as SVG writes them.
fn places(field: &Field<'_>, points: &[[f64; 2]]) -> String {
    let places = points.iter().filter_map(|point| field.at(*point));
    let places: Vec<String> = places.map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
    places.join(" ")
}

fn draw_image(canvas: &mut Canvas, field: &Field<'_>, image: &Image) {
    let corners = [[image.x[0], image.y[1]], [image.x[1], image.y[0]]];
    let [Some([x1, y1]), Some([x2, y2])] = corners.map(|corner| field.at(corner)) else {
        return;
    };
    let Some(png) = encode(image) else {
        return;
    };
    let data = base64::engine::general_purpose::STANDARD.encode(png);
    let (width, height) = (x2 - x1, y2 - y1);
    canvas.put(format_args!(
        "<image x=\"{x1:.2}\" y=\"{y1:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
         preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" \
         xlink:href=\"data:image/png;base64,{data}\"/>"
    ));
}

/// Pixels as a PNG with a palette; `None` of an image without pixels.
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

/// Names of peaks above their tips, in the order given: each takes the lowest line where it covers no
/// other; one without room is left out.
fn name_peaks(canvas: &mut Canvas, field: &Field<'_>, peaks: &[([f64; 2], String)], color: Color) {
    let letters = canvas.letters;
    let (left, right) = (field.frame.x, field.frame.x + field.frame.width);
    let mut taken: Vec<[f64; 3]> = Vec::new();
    for (point, name) in peaks.iter().filter(|(_, name)| !name.is_empty()) {
        let Some([x, tip]) = field.at(*point).filter(|_| field.holds(*point)) else {
            continue;
        };
        let half = 0.5 * text::width(name, letters, false) + 0.2 * letters;
        let middle = x.clamp((left + half).min(right - half), right - half);
        let above = |k: usize| [middle, tip - (1.0 + 1.2 * k as f64) * letters];
        // A tip just below the top has its name beside it.
        let beside = [
            x + half + 0.7 * letters,
            tip.max(field.frame.y + 0.7 * letters),
        ];
        let is_free = |[middle, y]: &[f64; 2]| {
            let covers = |[other, width, height]: &[f64; 3]| {
                (other - middle).abs() < width + half && (height - y).abs() < 1.15 * letters
            };
            *y > field.frame.y && middle + half <= right + 0.01 && !taken.iter().any(covers)
        };
        let mut places = (0..TRIES).map(above).chain([beside]);
        let Some([middle, y]) = places.find(is_free) else {
            continue;
        };
        taken.push([middle, half, y]);
        // What it stands on shines through, no more.
        canvas.put(format_args!(
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"#fff\" fill-opacity=\"0.8\"/>",
            middle - half,
            y - 0.55 * letters,
            2.0 * half,
            1.1 * letters
        ));
        if y < tip - 1.5 * letters {
            canvas.stroke([x, y + 0.6 * letters, x, tip], color, 0.5, "");
        }
        canvas.write([middle, y], name, Anchor::Middle, (0.95, false, Color::Ink));
    }
}
