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
        } => put_markers(canvas, area, layer.color, (points, *radius, *marker)),
        Shape::Peaks(peaks) => {
            let points: Vec<[f64; 2]> = peaks.iter().map(|(point, _)| *point).collect();
            put_markers(canvas, area, layer.color, (&points, PEAK, Marker::Dot));
        }
        Shape::Areas { outlines, opacity } => {
            for outline in outlines {
                polygon(canvas, area, outline, layer.color, *opacity);
            }
        }
        Shape::Image(image) => draw_image(canvas, area, image),
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
            put_marker(canvas, [x + 0.5 * width, y], 2.3, *marker);
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

/// Draws the points of one layer.
fn put_markers(
    canvas: &mut Canvas,
    area: &PlotArea<'_>,
    color: Color,
    (points, radius, marker): (&[[f64; 2]], f64, Marker),
) {
    open_group(canvas, color, marker);
    let inside = points.iter().filter(|point| area.contains(**point));
    for at in inside.filter_map(|point| area.position(*point)) {
        put_marker(canvas, at, radius, marker);
    }
    canvas.push(format_args!("</g>"));
}

/// Opens the group of the points of one layer.
fn open_group(canvas: &mut Canvas, color: Color, marker: Marker) {
    let (color, width) = (hex(color.on_light()), canvas.scaled(1.0));
    if matches!(marker, Marker::Ring | Marker::Cross) {
        canvas.push(format_args!(
            "<g fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\">"
        ));
    } else {
        canvas.push(format_args!("<g fill=\"{color}\">"));
    }
}

/// Draws a marker of a radius for a font size of 8 points.
fn put_marker(canvas: &mut Canvas, [x, y]: [f64; 2], radius: f64, marker: Marker) {
    let r = canvas.scaled(radius);
    let lines: &[&[[f64; 2]]] = match marker {
        Marker::Dot | Marker::Ring => {
            return canvas.push(format_args!(
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\"/>"
            ));
        }
        Marker::Cross => &[&[[-1.0, -1.0], [1.0, 1.0]], &[[-1.0, 1.0], [1.0, -1.0]]],
        Marker::Up => &[&[[-1.1, 0.72], [1.1, 0.72], [0.0, -1.2]]],
        Marker::Down => &[&[[-1.1, -0.72], [1.1, -0.72], [0.0, 1.2]]],
    };
    let path = lines.iter().map(|line| {
        let corners = line.iter().map(|[right, down]| {
            let (x, y) = (x + r * right, y + r * down);
            format!("{x:.2},{y:.2}")
        });
        format!("M{}", corners.collect::<Vec<_>>().join("L"))
    });
    let path = path.collect::<String>();
    canvas.push(format_args!("<path d=\"{path}\"/>"));
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

/// Labels the peaks of a layer in the given order, each above its tip, beside it, or in a free row above with a line to the tip.
/// A label covers no other peak, and a line no label.
pub fn label_peaks(canvas: &mut Canvas, area: &PlotArea<'_>, layer: &Layer) {
    let Shape::Peaks(peaks) = &layer.shape else {
        return;
    };
    let em = canvas.font_size;
    let (left, right) = (area.rect.at[0], area.rect.end()[0]);
    let shown = peaks.iter().filter(|(point, _)| area.contains(*point));
    let tips = shown.filter_map(|(point, name)| Some((area.position(*point)?, name)));
    let tips: Vec<([f64; 2], &String)> = tips.collect();
    for ([x, tip], name) in tips.iter().filter(|(_, name)| !name.is_empty()) {
        let width = text::width(&text::shown(name), em, false) + 0.4 * em;
        let half = 0.5 * width;
        let background = |[x, y]: [f64; 2]| Rect {
            at: [x - half, y - 0.48 * em],
            size: [width, 1.15 * em],
        };
        let centre = x.clamp((left + half).min(right - half), right - half);
        let row = |k: usize| [centre, tip - (1.0 + 1.2 * k as f64) * em];
        // Next to the tip, also for peaks just below the top.
        let level = tip.max(area.rect.at[1] + 0.7 * em);
        let beside = [1.0, -1.0].map(|side| [x + side * (half + 0.7 * em), level]);
        let mut places = [row(0)]
            .into_iter()
            .chain(beside)
            .chain((1..NAME_ROWS).map(row));
        let place = places.find(|place| {
            let [middle, y] = *place;
            let covers = |([x, tip], _): &([f64; 2], _)| {
                (x - middle).abs() < half + 0.3 * em && (tip - y).abs() < 0.8 * em
            };
            let line = Rect {
                at: [*x, y + 0.6 * em],
                size: [0.1 * em, tip - y - 0.6 * em],
            };
            background(*place).is_in(&area.rect)
                && canvas.is_free(&background(*place))
                && !tips.iter().any(covers)
                && (y > tip - 1.5 * em || canvas.is_free(&line))
        });
        let Some(place) = place else {
            continue;
        };
        let ([left, top], [width, height]) = (background(place).at, background(place).size);
        // A translucent background keeps the label legible.
        canvas.push(format_args!(
            "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"#fff\" fill-opacity=\"0.85\"/>"
        ));
        canvas.text(place, name, Anchor::Middle, (1.0, false, Color::Ink));
        if place[1] < tip - 1.5 * em {
            canvas.line([*x, place[1] + 0.6 * em, *x, *tip], layer.color, 0.5, "");
        }
    }
}
