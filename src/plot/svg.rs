//! A figure as SVG; one user unit is a point (1/72 inch).

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, LINE_HEIGHT, PlotArea, Rect};
use super::color::Color;
use super::figure::{Figure, Layer, Panel};
use super::marks;
use super::style::FigureOptions;
use super::text::{self, FALLBACK, escape};

/// Points per millimetre.
const POINTS: f64 = 72.0 / 25.4;
/// The SVG document of a figure.
pub fn document(figure: &Figure, look: &FigureOptions) -> String {
    let mm = look.size_mm(figure.size_mm);
    let [width, height] = mm.map(|side| side * POINTS);
    let mut canvas = Canvas {
        out: String::new(),
        font_size: look.font_size(),
    };
    let [mm_width, mm_height] = mm;
    canvas.push(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{mm_width:.2}mm\" height=\"{mm_height:.2}mm\" viewBox=\"0 0 {width:.2} {height:.2}\" \
         font-family=\"{FALLBACK}\">\n<title>{}</title>",
        escape(&figure.title)
    ));
    if !figure.caption.is_empty() {
        canvas.push(format_args!("<desc>{}</desc>", escape(&figure.caption)));
    }
    canvas.push(format_args!(
        "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    ));
    let font_size = canvas.font_size;
    let mut top = 0.5 * font_size;
    if look.has_title() {
        let large = 1.35;
        let lines = text::wrap(
            &figure.title,
            width - 2.0 * font_size,
            large * font_size,
            true,
        );
        for line in lines {
            let at = [font_size, top + 0.8 * large * font_size];
            canvas.text(at, &line, Anchor::Start, (large, true, Color::Ink));
            top += LINE_HEIGHT * large * font_size;
        }
        top += 0.5 * font_size;
    }
    let body = Rect {
        x: 0.0,
        y: top,
        width,
        height: height - top,
    };
    rows(&mut canvas, figure, body);
    canvas.out.push_str("</svg>\n");
    canvas.out
}

fn rows(canvas: &mut Canvas, figure: &Figure, body: Rect) {
    let height = body.height / figure.rows.len().max(1) as f64;
    // The same width for all panels, so that plot areas are vertically aligned.
    let panels = figure.rows.iter().flatten();
    let ticks = panels.map(|panel| label_width(panel, height, canvas.font_size));
    let left = ticks.fold(0.0, f64::max);
    let font_size = canvas.font_size;
    let margins = figure.rows.iter().flat_map(|row| {
        let width = body.width / row.len().max(1) as f64 - left;
        row.iter()
            .map(move |panel| right_margin(panel, width, font_size))
    });
    let right = margins.fold(0.0, f64::max);
    for (number, row) in figure.rows.iter().enumerate() {
        let width = body.width / row.len().max(1) as f64;
        let headers: Vec<PanelHeader> = row
            .iter()
            .map(|panel| PanelHeader::new(panel, width - 2.0 * canvas.font_size, canvas.font_size))
            .collect();
        let tallest = headers.iter().map(|header| header.height(canvas.font_size));
        let tallest = tallest.fold(0.0, f64::max);
        for (place, (panel, header)) in row.iter().zip(&headers).enumerate() {
            let cell = Rect {
                x: body.x + place as f64 * width,
                y: body.y + number as f64 * height,
                width,
                height,
            };
            header.draw(canvas, cell);
            let area = plot_area(panel, cell, tallest, [left, right], canvas.font_size);
            draw_panel(canvas, panel, area);
        }
    }
}

/// Width of the tick labels and of the name of the vertical axis.
fn label_width(panel: &Panel, height: f64, font_size: f64) -> f64 {
    let ticks = panel
        .y
        .ticks(max_ticks(&panel.y, height, font_size, !panel.square));
    let labels = panel.y.labels(&ticks);
    let widths = labels
        .iter()
        .map(|label| text::width(label, font_size, false));
    let name = if panel.y.label().is_empty() {
        0.0
    } else {
        1.6 * font_size
    };
    widths.fold(0.0, f64::max) + name
}

/// Space to the right of a plot area of about `width` for the last label of the horizontal axis, which is centred
/// on its tick.
fn right_margin(panel: &Panel, width: f64, font_size: f64) -> f64 {
    let ticks = panel.x.ticks(max_ticks(&panel.x, width, font_size, false));
    let labels = panel.x.labels(&ticks);
    let overhangs = ticks.iter().zip(&labels).map(|(tick, label)| {
        0.5 * text::width(label, font_size, false) - width * (1.0 - panel.x.fraction(*tick))
    });
    overhangs.fold(0.8 * font_size, f64::max) + 0.8 * font_size
}

/// Maximum number of ticks of an axis of a length. Ticks of a vertical axis are closer (`close`), except in a
/// square panel, where both axes have the same number.
fn max_ticks(axis: &Axis, length: f64, font_size: f64, close: bool) -> usize {
    let available = match (close, axis.scale) {
        (true, Scale::Logarithmic) => 2.0,
        (true, _) => 3.5,
        (false, _) => 7.0,
    };
    ((length / (available * font_size)) as usize).clamp(3, 10)
}

/// The plot area of a panel.
fn plot_area(
    panel: &Panel,
    cell: Rect,
    header: f64,
    [left, right]: [f64; 2],
    font_size: f64,
) -> Rect {
    let left = left + 1.8 * font_size;
    let below = 3.8 * font_size;
    let width = (cell.width - left - right).max(font_size);
    let height = (cell.height - header - below).max(font_size);
    let side = width.min(height);
    let [width, height] = if panel.square {
        [side, side]
    } else {
        [width, height]
    };
    Rect {
        x: cell.x + left,
        y: cell.y + header,
        width,
        height,
    }
}

/// Title, caption and legend above a plot area, as lines.
struct PanelHeader<'a> {
    title: Vec<String>,
    caption: Vec<String>,
    legend: Vec<Vec<&'a Layer>>,
}

/// Width of a legend sample, and of the gap to its label, relative to the font size.
const SAMPLE: f64 = 1.8;
const GAP: f64 = 0.5;

impl<'a> PanelHeader<'a> {
    fn new(panel: &'a Panel, available: f64, font_size: f64) -> Self {
        let mut legend: Vec<Vec<&Layer>> = Vec::new();
        let mut taken = f64::INFINITY;
        for layer in panel.layers.iter().filter(|layer| !layer.label.is_empty()) {
            let entry = entry_width(layer, font_size);
            if taken + entry > available {
                legend.push(Vec::new());
                taken = 0.0;
            }
            taken += entry;
            legend
                .last_mut()
                .expect("the first entry starts a line")
                .push(layer);
        }
        Self {
            title: text::wrap(&panel.title, available, 1.1 * font_size, true),
            caption: text::wrap(&panel.caption, available, font_size, false),
            legend,
        }
    }

    fn height(&self, font_size: f64) -> f64 {
        let lines = self.title.len() + self.caption.len() + self.legend.len();
        (LINE_HEIGHT * lines as f64 + 0.9) * font_size
    }

    fn draw(&self, canvas: &mut Canvas, cell: Rect) {
        let font_size = canvas.font_size;
        let mut y = cell.y + 0.5 * LINE_HEIGHT * font_size;
        let titles = self
            .title
            .iter()
            .map(|line| (line, (1.1, true, Color::Ink)));
        let captions = self
            .caption
            .iter()
            .map(|line| (line, (1.0, false, Color::Faint)));
        for (line, style) in titles.chain(captions) {
            canvas.text([cell.x + font_size, y], line, Anchor::Start, style);
            y += LINE_HEIGHT * font_size;
        }
        for line in &self.legend {
            let mut x = cell.x + font_size;
            for layer in line {
                marks::legend_sample(canvas, layer, [x, y], SAMPLE * font_size);
                let at = [x + (SAMPLE + GAP) * font_size, y];
                canvas.text(at, &layer.label, Anchor::Start, (1.0, false, Color::Ink));
                x += entry_width(layer, font_size);
            }
            y += LINE_HEIGHT * font_size;
        }
    }
}

fn entry_width(layer: &Layer, font_size: f64) -> f64 {
    text::width(&layer.label, font_size, false) + (SAMPLE + GAP + 1.3) * font_size
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel, frame: Rect) {
    axes(canvas, panel, frame);
    let Rect {
        x,
        y,
        width,
        height,
    } = frame;
    // A nested SVG element clips its content and needs no identifier that another figure could share.
    canvas.push(format_args!(
        "<svg x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
         viewBox=\"{x:.2} {y:.2} {width:.2} {height:.2}\" overflow=\"hidden\">"
    ));
    let area = PlotArea { panel, rect: frame };
    for layer in &panel.layers {
        marks::draw(canvas, &area, layer);
    }
    canvas.push(format_args!("</svg>"));
    for layer in &panel.layers {
        marks::draw_text(canvas, &area, layer);
    }
    if !panel.note.is_empty() {
        let middle = [x + 0.5 * width, y + 0.5 * height];
        canvas.text(
            middle,
            &panel.note,
            Anchor::Middle,
            (1.0, false, Color::Faint),
        );
    }
}

/// Grid, ticks with labels, names and lines of both axes.
fn axes(canvas: &mut Canvas, panel: &Panel, frame: Rect) {
    let font_size = canvas.font_size;
    let (left, right) = (frame.x, frame.x + frame.width);
    let (top, bottom) = (frame.y, frame.y + frame.height);
    let grid = !panel.has_image();
    let tick = 0.4 * font_size;
    let ticks = panel
        .x
        .ticks(max_ticks(&panel.x, frame.width, font_size, false));
    for (value, label) in ticks.iter().zip(panel.x.labels(&ticks)) {
        let x = left + frame.width * panel.x.fraction(*value);
        if grid {
            canvas.line([x, top, x, bottom], Color::Grid, 0.7, "");
        }
        canvas.line([x, bottom, x, bottom + tick], Color::Faint, 0.7, "");
        let at = [x, bottom + tick + 0.8 * font_size];
        canvas.text(at, &label, Anchor::Middle, (1.0, false, Color::Ink));
    }
    let middle = [0.5 * (left + right), bottom + 2.5 * font_size];
    let faint = (1.0, false, Color::Faint);
    canvas.text(middle, &panel.x.label(), Anchor::Middle, faint);
    let ticks = panel
        .y
        .ticks(max_ticks(&panel.y, frame.height, font_size, !panel.square));
    let labels = panel.y.labels(&ticks);
    let widths = labels
        .iter()
        .map(|label| text::width(label, font_size, false));
    let widest = widths.fold(0.0, f64::max);
    for (value, label) in ticks.iter().zip(&labels) {
        let y = bottom - frame.height * panel.y.fraction(*value);
        if grid {
            canvas.line([left, y, right, y], Color::Grid, 0.7, "");
        }
        canvas.line([left - tick, y, left, y], Color::Faint, 0.7, "");
        canvas.text(
            [left - 1.6 * tick, y],
            label,
            Anchor::End,
            (1.0, false, Color::Ink),
        );
    }
    let [x, y] = [left - 1.6 * tick - widest - font_size, 0.5 * (top + bottom)];
    canvas.push(format_args!(
        "<g transform=\"translate({x:.2},{y:.2}) rotate(-90)\">"
    ));
    canvas.text([0.0, 0.0], &panel.y.label(), Anchor::Middle, faint);
    canvas.push(format_args!("</g>"));
    canvas.line([left, top, left, bottom], Color::Faint, 0.7, "");
    canvas.line([left, bottom, right, bottom], Color::Faint, 0.7, "");
    if !grid {
        canvas.line([left, top, right, top], Color::Faint, 0.7, "");
        canvas.line([right, top, right, bottom], Color::Faint, 0.7, "");
    }
}
