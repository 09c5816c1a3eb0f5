//! Draws panels by the plot library.

use std::fmt::Write as _;
use std::sync::Once;

use base64::Engine as _;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, RGBColor, register_font};

use super::FigureError;
use super::panel::{Axis, Mark, Panel, Scale};
use super::style::{self, Rgb};
use crate::escape;

/// The library places things on whole units: this many make a point.
const FINE: u32 = 10;
/// Height of the title, points.
const TITLE: u32 = 40;
/// The library divides sizes of letters by this.
const LETTER: f64 = 1.24;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Failed = Box<dyn std::error::Error + Send + Sync>;

/// An SVG document of rows of panels.
pub fn draw(title: &str, size: [u32; 2], rows: &[Vec<Panel>]) -> Result<String, FigureError> {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        for (face, style) in style::FACES
            .into_iter()
            .zip([FontStyle::Normal, FontStyle::Bold])
        {
            // The face is one of ours; text would only be placed less well without it.
            let _ = register_font(style::FAMILY, style, face);
        }
    });
    let mut svg = String::new();
    let pictures = render(&mut svg, title, size, rows).map_err(|reason| FigureError::Draw {
        title: title.to_owned(),
        reason: reason.to_string(),
    })?;
    Ok(escape::lines(&finish(&svg, size, &pictures)).into_owned())
}

fn render(
    svg: &mut String,
    title: &str,
    size: [u32; 2],
    rows: &[Vec<Panel>],
) -> Result<String, Failed> {
    let [width, height] = size.map(|s| s * FINE);
    let root = SVGBackend::with_string(svg, (width, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let heading = font(17.0, true, style::INK);
    root.draw(&Text::new(
        title.to_owned(),
        (units(18.0), units(16.0)),
        heading,
    ))?;
    let (_, body) = root.split_vertically(TITLE * FINE);
    let mut pictures = String::new();
    let areas = body.split_evenly((rows.len().max(1), 1));
    for (row, area) in rows.iter().zip(areas) {
        let cells = area.split_evenly((1, row.len().max(1)));
        for (panel, cell) in row.iter().zip(cells) {
            draw_panel(&cell, panel, &mut pictures)?;
        }
    }
    root.present()?;
    drop(root);
    Ok(pictures)
}

/// The library's document with our sizes, font and pictures.
fn finish(svg: &str, [width, height]: [u32; 2], pictures: &str) -> String {
    let (fine_width, fine_height) = (width * FINE, height * FINE);
    let svg = svg.replacen(
        &format!("<svg width=\"{fine_width}\" height=\"{fine_height}\""),
        &format!("<svg width=\"{width}\" height=\"{height}\""),
        1,
    );
    let family = |name: &str| format!("font-family=\"{name}\"");
    let svg = svg.replace(&family(style::FAMILY), &family(style::FALLBACK));
    let svg = svg.replace("font-weight=\"bold\"", "font-weight=\"600\"");
    // Pictures go right on the background, below axes and marks.
    let ground = svg
        .find("<rect")
        .and_then(|at| svg[at..].find("/>").map(|end| at + end + 2));
    match ground {
        Some(at) => format!("{}\n{pictures}{}", &svg[..at], &svg[at..]),
        None => svg,
    }
}

fn units(points: f64) -> i32 {
    (points * f64::from(FINE)).round() as i32
}

fn color([r, g, b]: Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

fn font(points: f64, bold: bool, ink: Rgb) -> TextStyle<'static> {
    let style = if bold {
        FontStyle::Bold
    } else {
        FontStyle::Normal
    };
    let size = points * LETTER * f64::from(FINE);
    let mut text = (style::FAMILY, size, style).into_text_style(&(1, 1));
    text.color = color(ink).to_backend_color();
    text
}

fn draw_panel(cell: &Area<'_>, panel: &Panel, pictures: &mut String) -> Result<(), Failed> {
    let has_bars = panel.marks.iter().any(|m| matches!(m, Mark::Bars { .. }));
    let ([left, right], [low, high]) = (panel.x.ends(), panel.y.ends());
    let title = font(13.0, true, style::INK).pos(Pos::new(HPos::Left, VPos::Top));
    cell.draw(&Text::new(
        panel.title.clone(),
        (units(18.0), units(2.0)),
        title,
    ))?;
    draw_legend(cell, &panel.marks)?;
    let mut chart = ChartBuilder::on(cell)
        .margin_left(units(10.0))
        .margin_right(units(22.0))
        .margin_top(units(26.0))
        .margin_bottom(units(8.0))
        .x_label_area_size(units(44.0))
        .y_label_area_size(units(if has_bars { 8.0 } else { 64.0 }))
        .build_cartesian_2d(left..right, low..high)?;
    let is_picture = |m: &Mark| matches!(m, Mark::Picture { .. });
    let grid = !panel.marks.iter().any(is_picture);
    mesh(&mut chart, panel, grid, has_bars)?;
    for mark in &panel.marks {
        draw_mark(&mut chart, panel, mark, pictures)?;
    }
    Ok(())
}

/// The legend, from the right end of the title's line towards the left: there it hides no mark.
fn draw_legend(cell: &Area<'_>, marks: &[Mark]) -> Result<(), Failed> {
    let (width, _) = cell.dim_in_pixel();
    let mut right = width as i32 - units(22.0);
    for mark in marks.iter().rev() {
        let (label, ink) = match mark {
            Mark::Line { label, color, .. }
            | Mark::Dots { label, color, .. }
            | Mark::Columns { label, color, .. } => (label, *color),
            _ => continue,
        };
        if label.is_empty() {
            continue;
        }
        let text = font(11.0, false, style::INK).pos(Pos::new(HPos::Right, VPos::Center));
        let ((from, _), (to, _)) = text.font.layout_box(label)?;
        let middle = units(9.0);
        cell.draw(&Text::new(label.clone(), (right, middle), text))?;
        right -= to - from + units(6.0);
        if matches!(mark, Mark::Columns { .. }) {
            let sample = [
                (right - units(12.0), middle - units(4.0)),
                (right, middle + units(4.0)),
            ];
            cell.draw(&Rectangle::new(sample, color(ink).filled()))?;
        } else if matches!(mark, Mark::Line { .. }) {
            let stroke = color(ink).stroke_width(2 * FINE);
            let sample = [(right - units(18.0), middle), (right, middle)];
            cell.draw(&PathElement::new(sample, stroke))?;
        } else {
            let place = (right - units(9.0), middle);
            cell.draw(&Circle::new(place, units(2.5), color(ink).filled()))?;
        }
        right -= units(34.0);
    }
    Ok(())
}

fn mesh(chart: &mut Chart<'_, '_>, panel: &Panel, grid: bool, bars: bool) -> Result<(), Failed> {
    let (width, height) = chart.plotting_area().dim_in_pixel();
    let labels = |axis: &Axis, pixels: u32, points: u32| match axis.scale {
        Scale::Linear => (pixels / (points * FINE)).clamp(2, 9) as usize,
        Scale::Decades => {
            let [low, high] = axis.ends();
            let most = (pixels / (30 * FINE)).max(2);
            ((high - low).round() as u32 + 1).min(most) as usize
        }
    };
    let (x_scale, y_scale) = (panel.x.scale, panel.y.scale);
    let (x_ends, y_ends) = (panel.x.ends(), panel.y.ends());
    let x_words = move |v: &f64| tick(*v, x_scale, x_ends);
    let y_words = move |v: &f64| tick(*v, y_scale, y_ends);
    let mut mesh = chart.configure_mesh();
    mesh.x_labels(labels(&panel.x, width, 70))
        .y_labels(if bars {
            0
        } else {
            labels(&panel.y, height, 34)
        })
        .max_light_lines(0)
        .bold_line_style(color(style::GRID).stroke_width(FINE))
        .axis_style(color(style::FAINT).stroke_width(FINE))
        .label_style(font(11.0, false, style::INK))
        .axis_desc_style(font(11.5, false, style::FAINT))
        .set_all_tick_mark_size(units(4.0))
        .x_label_formatter(&x_words)
        .y_label_formatter(&y_words)
        .x_desc(&panel.x.name)
        .y_desc(&panel.y.name);
    if !grid {
        mesh.disable_mesh();
    }
    if bars {
        mesh.disable_y_mesh().disable_y_axis();
    }
    mesh.draw()?;
    Ok(())
}

/// A tick's words: short, without a trailing zero; powers of ten as such.
fn tick(value: f64, scale: Scale, [low, high]: [f64; 2]) -> String {
    match scale {
        Scale::Decades if (value - value.round()).abs() > 1e-6 => String::new(),
        Scale::Decades => {
            let digits = format!("{value:.0}");
            let raised = digits.chars().map(|c| match c {
                '-' => '⁻',
                '1' => '¹',
                '2' => '²',
                '3' => '³',
                digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
            });
            format!("10{}", raised.collect::<String>())
        }
        Scale::Linear => {
            // Zero comes out of the library's sums as some 1e-17.
            let value = if value.abs() < 1e-9 * (high - low) {
                0.0
            } else {
                value
            };
            let largest = low.abs().max(high.abs());
            if value != 0.0 && !(1e-3..1e5).contains(&largest) {
                return format!("{value:.1e}").replace('-', "−");
            }
            let decimals = (2.0 - (high - low).log10().floor()).clamp(0.0, 6.0) as usize;
            let text = format!("{value:.decimals$}");
            let text = match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.'),
                false => &text,
            };
            text.replace('-', "−")
        }
    }
}

fn draw_mark(
    chart: &mut Chart<'_, '_>,
    panel: &Panel,
    mark: &Mark,
    pictures: &mut String,
) -> Result<(), Failed> {
    let at = |[x, y]: [f64; 2]| (panel.x.place(x), panel.y.place(y));
    let finite = |p: &&[f64; 2]| p.iter().all(|v| v.is_finite());
    let ([left, right], [low, high]) = (panel.x.ends(), panel.y.ends());
    match mark {
        Mark::Line {
            points, color: c, ..
        }
        | Mark::Wire { points, color: c } => {
            let wire = matches!(mark, Mark::Wire { .. });
            let width = if wire { FINE * 2 / 3 } else { FINE * 3 / 2 };
            let style = color(*c).stroke_width(width);
            let points: Vec<_> = points.iter().filter(finite).map(|p| at(*p)).collect();
            for piece in pieces(&points, [left, right], [low, high]) {
                chart.draw_series(LineSeries::new(piece, style))?;
            }
        }
        Mark::Columns {
            spans,
            width,
            color: c,
            ..
        } => {
            let columns = spans.iter().filter(|s| s.iter().all(|v| v.is_finite()));
            let columns = columns.filter_map(|&[x, from, to]| {
                let ends = [[x - 0.5 * width, from], [x + 0.5 * width, to]].map(at);
                let [a, b] = ends.map(|(x, y)| (x.clamp(left, right), y.clamp(low, high)));
                let seen = a.0 < b.0 && a.1 != b.1;
                seen.then(|| Rectangle::new([a, b], color(*c).filled()))
            });
            chart.draw_series(columns)?;
        }
        Mark::Dots {
            points,
            radius,
            color: c,
            ..
        } => {
            let (radius, style) = (units(*radius), color(*c).filled());
            let inside =
                |p: &(f64, f64)| (left..=right).contains(&p.0) && (low..=high).contains(&p.1);
            let points = points.iter().filter(finite).map(|p| at(*p)).filter(inside);
            let dots = points.map(|p| Circle::new(p, radius, style));
            chart.draw_series(dots)?;
        }
        Mark::Band { spans, color: c } => {
            let spans = spans.iter().filter(|s| s.iter().all(|v| v.is_finite()));
            // The library cuts lines off at the axes, but not what they enclose.
            let end = |s: &[f64; 3], k: usize| {
                let (x, y) = at([s[0], s[k]]);
                (x.clamp(left, right), y.clamp(low, high))
            };
            let lower = spans.clone().map(|s| end(s, 1));
            let upper = spans.clone().rev().map(|s| end(s, 2));
            let outline: Vec<_> = lower.chain(upper).collect();
            if outline.len() > 2 {
                chart.draw_series([Polygon::new(outline, color(*c).mix(0.2).filled())])?;
            }
        }
        Mark::Intervals { spans, color: c } => {
            let style = color(*c).stroke_width(3 * FINE / 2);
            let cap = units(3.0);
            let spans = spans.iter().filter(|s| s.iter().all(|v| v.is_finite()));
            for &[x, from, to] in spans {
                let (x, from) = at([x, from]);
                let (_, to) = at([x, to]);
                if x < left || x > right || to < low || from > high {
                    continue;
                }
                let stroke = vec![(x, from.max(low)), (x, to.min(high))];
                chart.draw_series([PathElement::new(stroke, style)])?;
                let ends = [from, to].into_iter().filter(|y| (low..=high).contains(y));
                let caps = ends.map(|y| {
                    EmptyElement::at((x, y)) + PathElement::new(vec![(-cap, 0), (cap, 0)], style)
                });
                chart.draw_series(caps)?;
            }
        }
        Mark::Level { y } => {
            let y = panel.y.place(*y);
            if (low..=high).contains(&y) {
                let style = color(style::INK).stroke_width(FINE);
                chart.draw_series([PathElement::new(vec![(left, y), (right, y)], style)])?;
            }
        }
        Mark::Upright { x, words, color: c } => {
            let x = panel.x.place(*x);
            let style = color(*c).stroke_width(FINE);
            let line = DashedLineSeries::new([(x, low), (x, high)], units(4.0), units(3.0), style);
            chart.draw_series(line)?;
            let on_left = x < 0.5 * (left + right);
            let side = if on_left { HPos::Left } else { HPos::Right };
            let text = font(11.5, true, *c).pos(Pos::new(side, VPos::Top));
            let shift = units(if on_left { 5.0 } else { -5.0 });
            let text = Text::new(words.clone(), (shift, units(3.0)), text);
            chart.draw_series([EmptyElement::at((x, high)) + text])?;
        }
        Mark::Bars { bars } => {
            for (row, bar) in bars.iter().enumerate() {
                let middle = high - 0.5 - row as f64;
                let corners = [
                    (left, middle - 0.32),
                    (panel.x.place(bar.value), middle + 0.02),
                ];
                chart.draw_series([Rectangle::new(corners, color(bar.color).filled())])?;
                let text = font(11.0, false, style::INK);
                let text = text.pos(Pos::new(HPos::Left, VPos::Bottom));
                let text = Text::new(bar.words.clone(), (0, units(-2.0)), text);
                chart.draw_series([EmptyElement::at((left, middle + 0.06)) + text])?;
            }
        }
        Mark::Picture { x, y, size, pixels } => {
            let corner = |x, y| chart.backend_coord(&at([x, y]));
            let ((x0, y0), (x1, y1)) = (corner(x[0], y[1]), corner(x[1], y[0]));
            let data = base64::engine::general_purpose::STANDARD.encode(encode(*size, pixels)?);
            writeln!(
                pictures,
                "<image x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\" \
                 preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" \
                 xlink:href=\"data:image/png;base64,{data}\" \
                 xmlns:xlink=\"http://www.w3.org/1999/xlink\"/>",
                x1 - x0,
                y1 - y0,
            )?;
        }
        Mark::Words { at: place, words } => {
            let text = font(12.0, false, style::INK);
            let text = Text::new(words.clone(), at(*place), text);
            chart.draw_series([text])?;
        }
    }
    Ok(())
}

/// The parts of a curve within the axes. The library would draw the others along the frame.
fn pieces(
    points: &[(f64, f64)],
    [left, right]: [f64; 2],
    [low, high]: [f64; 2],
) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    for pair in points.windows(2) {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        // The share of the stretch that is within both ranges, from `from` to `to`.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (start, by, [low, high]) in [(x0, x1 - x0, [left, right]), (y0, y1 - y0, [low, high])] {
            if by == 0.0 && !(low..=high).contains(&start) {
                to = -1.0;
            } else if by != 0.0 {
                let [a, b] = [low, high].map(|end| (end - start) / by);
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            }
        }
        if from > to {
            continue;
        }
        let place = |share: f64| match share {
            0.0 => pair[0],
            1.0 => pair[1],
            share => (x0 + share * (x1 - x0), y0 + share * (y1 - y0)),
        };
        let (from, to) = (place(from), place(to));
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// Pixels as a PNG.
fn encode([width, height]: [usize; 2], pixels: &[Rgb]) -> Result<Vec<u8>, Failed> {
    let mut data = Vec::new();
    let mut encoder = png::Encoder::new(&mut data, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_ends_where_it_leaves_the_axes() {
        let square = |points: &[(f64, f64)]| pieces(points, [0.0, 2.0], [0.0, 1.0]);
        let inside = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.5)];
        assert_eq!(square(&inside), [inside.to_vec()]);
        let out_and_in = square(&[(0.0, 0.0), (1.0, 2.0), (2.0, 0.0)]);
        assert_eq!(
            out_and_in,
            [vec![(0.0, 0.0), (0.5, 1.0)], vec![(1.5, 1.0), (2.0, 0.0)]]
        );
        assert!(square(&[(0.0, 3.0), (1.0, 2.0), (1.5, 2.0)]).is_empty());
        assert_eq!(
            square(&[(-1.0, 0.5), (3.0, 0.5)]),
            [vec![(0.0, 0.5), (2.0, 0.5)]]
        );
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!(tick(0.5, Scale::Linear, [0.0, 1.0]), "0.5");
        assert_eq!(tick(-20.0, Scale::Linear, [-40.0, 0.0]), "−20");
        assert_eq!(tick(1e-17, Scale::Linear, [-1.0, 1.0]), "0");
        assert_eq!(tick(2e-7, Scale::Linear, [0.0, 1e-6]), "2.0e−7");
        assert_eq!(tick(1000.0, Scale::Linear, [0.0, 4000.0]), "1000");
        assert_eq!(tick(-3.0, Scale::Decades, [-6.0, 0.0]), "10⁻³");
        assert_eq!(tick(-2.5, Scale::Decades, [-6.0, 0.0]), "");
        assert_eq!(tick(10.0, Scale::Decades, [0.0, 12.0]), "10¹⁰");
    }
}
