//! Layers as SVG elements.

use base64::Engine as _;

use super::canvas::{Anchor, Canvas, PlotArea, Rect, hex};
use super::{Color, Image, Layer, Marker, Shape, text};

/// Radius of the marker of a legend entry.
const SAMPLE: f64 = 2.3;
/// Rows above a peak that are tried for its label.
const NAME_ROWS: usize = 4;

/// Draws the part of a layer within the axes.
pub fn draw(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    let (color, size) = (hex(layer.color), layer.size);
    match &layer.shape {
        Shape::Lines(strips) => {
            let (width, dashes) = (canvas.scaled(size), dashes(canvas, layer));
            for strip in strips {
                let places = places(area, strip);
                canvas.push(format_args!(
                    "<polyline points=\"{places}\" fill=\"none\" stroke=\"{color}\" \
                     stroke-width=\"{width:.2}\" stroke-linejoin=\"round\"{dashes}/>"
                ));
            }
        }
        Shape::Areas(outlines) => {
            for outline in outlines {
                let places = places(area, outline);
                canvas.push(format_args!(
                    "<polygon points=\"{places}\" fill=\"{color}\" fill-opacity=\"{size}\"/>"
                ));
            }
        }
        Shape::Points(points) => put_markers(canvas, layer, size, &area.inside(points)),
        Shape::Peaks(peaks) => {
            let points = peaks.iter().map(|(point, _)| point);
            put_markers(canvas, layer, size, &area.inside(points));
        }
        Shape::Image(image) => draw_image(canvas, area, image),
    }
}

/// Draws the legend sample of a layer, starting at a position.
pub fn legend_sample(canvas: &mut Canvas, layer: &Layer, [x, y]: [f64; 2], width: f64) {
    match &layer.shape {
        Shape::Lines(_) => {
            let (ends, dashes) = ([x, y, x + width, y], dashes(canvas, layer));
            canvas.line(ends, layer.color, layer.size.max(1.1), &dashes);
        }
        Shape::Areas(_) | Shape::Image(_) => {
            let (color, height) = (hex(layer.color), 0.8 * canvas.font_size);
            let top = y - 0.5 * height;
            canvas.push(format_args!(
                "<rect x=\"{x:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\"/>"
            ));
        }
        Shape::Points(_) | Shape::Peaks(_) => {
            put_markers(canvas, layer, SAMPLE, &[[x + 0.5 * width, y]]);
        }
    }
}

fn dashes(canvas: &Canvas, layer: &Layer) -> String {
    let [dash, gap] = [3.2, 2.4].map(|length| canvas.scaled(length));
    let dashes = format!(" stroke-dasharray=\"{dash:.2} {gap:.2}\"");
    if layer.dashed { dashes } else { String::new() }
}

/// Draws the markers of a layer with a radius for a font size of 8 points.
fn put_markers(canvas: &mut Canvas, layer: &Layer, radius: f64, places: &[[f64; 2]]) {
    let (color, width, r) = (hex(layer.color), canvas.scaled(1.0), canvas.scaled(radius));
    if matches!(layer.marker, Marker::Ring | Marker::Cross) {
        canvas.push(format_args!(
            "<g fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\">"
        ));
    } else {
        canvas.push(format_args!("<g fill=\"{color}\">"));
    }
    let lines: &[&[[f64; 2]]] = match layer.marker {
        Marker::Dot | Marker::Ring => &[],
        Marker::Cross => &[&[[-1.0, -1.0], [1.0, 1.0]], &[[-1.0, 1.0], [1.0, -1.0]]],
        Marker::Up => &[&[[-1.1, 0.72], [1.1, 0.72], [0.0, -1.2]]],
        Marker::Down => &[&[[-1.1, -0.72], [1.1, -0.72], [0.0, 1.2]]],
    };
    for [x, y] in places {
        if lines.is_empty() {
            canvas.push(format_args!(
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\"/>"
            ));
            continue;
        }
        let path = lines.iter().map(|line| {
            let corner =
                |[right, down]: &[f64; 2]| format!("{:.2},{:.2}", x + r * right, y + r * down);
            let corners: Vec<String> = line.iter().map(corner).collect();
            format!("M{}", corners.join("L"))
        });
        let path = path.collect::<String>();
        canvas.push(format_args!("<path d=\"{path}\"/>"));
    }
    canvas.push(format_args!("</g>"));
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
    let colors = image.palette.iter();
    let palette: Vec<u8> = colors.flat_map(|(color, _)| color.on_light()).collect();
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

/// Labels the peaks of a layer in the given order, each above its tip, beside it, or in a free row above with a line to the tip.
/// A label covers no other peak, and a line no label.
pub fn label_peaks(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    let Shape::Peaks(peaks) = &layer.shape else {
        return;
    };
    let em = canvas.font_size;
    let (left, right) = (area.rect.at[0], area.rect.end()[0]);
    let tips = peaks.iter();
    let tips = tips.filter_map(|(point, name)| Some((area.inside([point]).pop()?, name)));
    let tips: Vec<([f64; 2], &String)> = tips.collect();
    for &([x, tip], name) in tips.iter().filter(|(_, name)| !name.is_empty()) {
        let width = text::width(&text::shown(name), em, false) + 0.4 * em;
        let half = 0.5 * width;
        let background =
            |[x, y]: [f64; 2]| Rect::new([x - half, y - 0.48 * em], [width, 1.15 * em]);
        let centre = x.clamp((left + half).min(right - half), right - half);
        let row = |k: usize| [centre, tip - (1.0 + 1.2 * k as f64) * em];
        // Next to the tip, also for peaks just below the top.
        let level = tip.max(area.rect.at[1] + 0.7 * em);
        let beside = [1.0, -1.0].map(|side| [x + side * (half + 0.7 * em), level]);
        let places = [row(0)].into_iter().chain(beside);
        let mut places = places.chain((1..NAME_ROWS).map(row));
        let place = places.find(|&[middle, y]| {
            let covers = |([x, tip], _): &([f64; 2], _)| {
                (x - middle).abs() < half + 0.3 * em && (tip - y).abs() < 0.8 * em
            };
            let line = Rect::new([x, y + 0.6 * em], [0.1 * em, tip - y - 0.6 * em]);
            let background = background([middle, y]);
            background.is_in(&area.rect)
                && canvas.is_free(&background)
                && !tips.iter().any(covers)
                && (y > tip - 1.5 * em || canvas.is_free(&line))
        });
        let Some(place) = place else {
            continue;
        };
        let background = background(place);
        let ([left, top], [width, height]) = (background.at, background.size);
        // A translucent background keeps the label legible.
        canvas.push(format_args!(
            "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"#fff\" fill-opacity=\"0.85\"/>"
        ));
        canvas.text(place, name, Anchor::Middle, (1.0, false, Color::Ink));
        if place[1] < tip - 1.5 * em {
            canvas.line([x, place[1] + 0.6 * em, x, tip], layer.color, 0.5, "");
        }
    }
}
