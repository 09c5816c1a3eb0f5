//! A figure as SVG: one user unit is a point (1/72 inch).

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Field, Frame, LINE};
use super::color::Color;
use super::figure::{Figure, Layer, Panel};
use super::marks;
use super::style::Look;
use super::text::{self, FALLBACK, escape};

/// Points a millimetre.
const POINTS: f64 = 72.0 / 25.4;
/// The SVG document of a figure.
pub fn document(figure: &Figure, look: &Look) -> String {
    let mm = look.size_mm(figure.size_mm);
    let [width, height] = mm.map(|side| side * POINTS);
    let mut canvas = Canvas {
        out: String::new(),
        letters: look.letters(),
    };
    let [mm_width, mm_height] = mm;
    canvas.put(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{mm_width:.2}mm\" height=\"{mm_height:.2}mm\" viewBox=\"0 0 {width:.2} {height:.2}\" \
         font-family=\"{FALLBACK}\">\n<title>{}</title>",
        escape(&figure.title)
    ));
    if !figure.caption.is_empty() {
        canvas.put(format_args!("<desc>{}</desc>", escape(&figure.caption)));
    }
    canvas.put(format_args!(
        "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    ));
    let letters = canvas.letters;
    let mut top = 0.5 * letters;
    if look.has_title() {
        let large = 1.35;
        let lines = text::wrap(&figure.title, width - 2.0 * letters, large * letters, true);
        for line in lines {
            let at = [letters, top + 0.8 * large * letters];
            canvas.write(at, &line, Anchor::Start, (large, true, Color::Ink));
            top += LINE * large * letters;
        }
        top += 0.5 * letters;
    }
    let body = Frame {
        x: 0.0,
        y: top,
        width,
        height: height - top,
    };
    rows(&mut canvas, figure, body);
    canvas.out.push_str("</svg>\n");
    canvas.out
}

fn rows(canvas: &mut Canvas, figure: &Figure, body: Frame) {
    let height = body.height / figure.rows.len().max(1) as f64;
    // The same for all panels, so that fields stand below each other.
    let panels = figure.rows.iter().flatten();
    let ticks = panels.map(|panel| names_width(panel, height, canvas.letters));
    let left = ticks.fold(0.0, f64::max);
    for (number, row) in figure.rows.iter().enumerate() {
        let width = body.width / row.len().max(1) as f64;
        let heads: Vec<Head> = row
            .iter()
            .map(|panel| Head::new(panel, width - 2.0 * canvas.letters, canvas.letters))
            .collect();
        let tallest = heads.iter().map(|head| head.height(canvas.letters));
        let tallest = tallest.fold(0.0, f64::max);
        for (place, (panel, head)) in row.iter().zip(&heads).enumerate() {
            let cell = Frame {
                x: body.x + place as f64 * width,
                y: body.y + number as f64 * height,
                width,
                height,
            };
            head.draw(canvas, cell);
            let field = field(panel, cell, tallest, left, canvas.letters);
            draw_panel(canvas, panel, field);
        }
    }
}

/// Width of the labels of the vertical axis and of its name.
fn names_width(panel: &Panel, height: f64, letters: f64) -> f64 {
    let ticks = panel
        .y
        .ticks(most_ticks(&panel.y, height, letters, !panel.square));
    let labels = panel.y.labels(&ticks);
    let widths = labels
        .iter()
        .map(|label| text::width(label, letters, false));
    let name = if panel.y.label().is_empty() {
        0.0
    } else {
        1.6 * letters
    };
    widths.fold(0.0, f64::max) + name
}

/// How many ticks an axis of a length has room for: an upright one for more, unless it is a side of a square, of which
/// both have the same.
fn most_ticks(axis: &Axis, length: f64, letters: f64, close: bool) -> usize {
    let room = match (close, axis.scale) {
        (true, Scale::Logarithmic) => 2.0,
        (true, _) => 3.5,
        (false, _) => 7.0,
    };
    ((length / (room * letters)) as usize).clamp(3, 10)
}

/// The field of a panel between its axes.
fn field(panel: &Panel, cell: Frame, head: f64, left: f64, letters: f64) -> Frame {
    let left = left + 1.8 * letters;
    let below = 3.8 * letters;
    let width = (cell.width - left - 1.6 * letters).max(letters);
    let height = (cell.height - head - below).max(letters);
    let side = width.min(height);
    let [width, height] = if panel.square {
        [side, side]
    } else {
        [width, height]
    };
    Frame {
        x: cell.x + left,
        y: cell.y + head,
        width,
        height,
    }
}

/// What stands above a field: title and legend, in lines.
struct Head<'a> {
    title: Vec<String>,
    caption: Vec<String>,
    legend: Vec<Vec<&'a Layer>>,
}

/// Width of a sample in a legend, and of the gap to its name, in sizes of letters.
const SAMPLE: f64 = 1.8;
const GAP: f64 = 0.5;

impl<'a> Head<'a> {
    fn new(panel: &'a Panel, room: f64, letters: f64) -> Self {
        let mut legend: Vec<Vec<&Layer>> = Vec::new();
        let mut taken = f64::INFINITY;
        for layer in panel.layers.iter().filter(|layer| !layer.label.is_empty()) {
            let entry = entry_width(layer, letters);
            if taken + entry > room {
                legend.push(Vec::new());
                taken = 0.0;
            }
            taken += entry;
            legend.last_mut().expect("a line was begun").push(layer);
        }
        Self {
            title: text::wrap(&panel.title, room, 1.1 * letters, true),
            caption: text::wrap(&panel.caption, room, letters, false),
            legend,
        }
    }

    fn height(&self, letters: f64) -> f64 {
        let lines = self.title.len() + self.caption.len() + self.legend.len();
        (LINE * lines as f64 + 0.9) * letters
    }

    fn draw(&self, canvas: &mut Canvas, cell: Frame) {
        let letters = canvas.letters;
        let mut y = cell.y + 0.5 * LINE * letters;
        let titles = self
            .title
            .iter()
            .map(|line| (line, (1.1, true, Color::Ink)));
        let captions = self
            .caption
            .iter()
            .map(|line| (line, (1.0, false, Color::Faint)));
        for (line, style) in titles.chain(captions) {
            canvas.write([cell.x + letters, y], line, Anchor::Start, style);
            y += LINE * letters;
        }
        for line in &self.legend {
            let mut x = cell.x + letters;
            for layer in line {
                marks::sample(canvas, layer, [x, y], SAMPLE * letters);
                let at = [x + (SAMPLE + GAP) * letters, y];
                canvas.write(at, &layer.label, Anchor::Start, (1.0, false, Color::Ink));
                x += entry_width(layer, letters);
            }
            y += LINE * letters;
        }
    }
}

fn entry_width(layer: &Layer, letters: f64) -> f64 {
    text::width(&layer.label, letters, false) + (SAMPLE + GAP + 1.3) * letters
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel, frame: Frame) {
    axes(canvas, panel, frame);
    let Frame {
        x,
        y,
        width,
        height,
    } = frame;
    // A drawing of its own cuts off what is outside, without a name that another drawing may have.
    canvas.put(format_args!(
        "<svg x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
         viewBox=\"{x:.2} {y:.2} {width:.2} {height:.2}\" overflow=\"hidden\">"
    ));
    let field = Field { panel, frame };
    for layer in &panel.layers {
        marks::draw(canvas, &field, layer);
    }
    canvas.put(format_args!("</svg>"));
    for layer in &panel.layers {
        marks::write(canvas, &field, layer);
    }
    if !panel.note.is_empty() {
        let middle = [x + 0.5 * width, y + 0.5 * height];
        canvas.write(
            middle,
            &panel.note,
            Anchor::Middle,
            (1.0, false, Color::Faint),
        );
    }
}

/// Grid, ticks with their labels, names, and the lines of both axes.
fn axes(canvas: &mut Canvas, panel: &Panel, frame: Frame) {
    let letters = canvas.letters;
    let (left, right) = (frame.x, frame.x + frame.width);
    let (top, bottom) = (frame.y, frame.y + frame.height);
    let grid = !panel.has_image();
    let tick = 0.4 * letters;
    let ticks = panel
        .x
        .ticks(most_ticks(&panel.x, frame.width, letters, false));
    for (value, label) in ticks.iter().zip(panel.x.labels(&ticks)) {
        let x = left + frame.width * panel.x.share(*value);
        if grid {
            canvas.stroke([x, top, x, bottom], Color::Grid, 0.7, "");
        }
        canvas.stroke([x, bottom, x, bottom + tick], Color::Faint, 0.7, "");
        let at = [x, bottom + tick + 0.8 * letters];
        canvas.write(at, &label, Anchor::Middle, (1.0, false, Color::Ink));
    }
    let middle = [0.5 * (left + right), bottom + 2.5 * letters];
    let faint = (1.0, false, Color::Faint);
    canvas.write(middle, &panel.x.label(), Anchor::Middle, faint);
    let ticks = panel
        .y
        .ticks(most_ticks(&panel.y, frame.height, letters, !panel.square));
    let labels = panel.y.labels(&ticks);
    let widths = labels
        .iter()
        .map(|label| text::width(label, letters, false));
    let widest = widths.fold(0.0, f64::max);
    for (value, label) in ticks.iter().zip(&labels) {
        let y = bottom - frame.height * panel.y.share(*value);
        if grid {
            canvas.stroke([left, y, right, y], Color::Grid, 0.7, "");
        }
        canvas.stroke([left - tick, y, left, y], Color::Faint, 0.7, "");
        canvas.write(
            [left - 1.6 * tick, y],
            label,
            Anchor::End,
            (1.0, false, Color::Ink),
        );
    }
    let [x, y] = [left - 1.6 * tick - widest - letters, 0.5 * (top + bottom)];
    canvas.put(format_args!(
        "<g transform=\"translate({x:.2},{y:.2}) rotate(-90)\">"
    ));
    canvas.write([0.0, 0.0], &panel.y.label(), Anchor::Middle, faint);
    canvas.put(format_args!("</g>"));
    canvas.stroke([left, top, left, bottom], Color::Faint, 0.7, "");
    canvas.stroke([left, bottom, right, bottom], Color::Faint, 0.7, "");
    if !grid {
        canvas.stroke([left, top, right, top], Color::Faint, 0.7, "");
        canvas.stroke([right, top, right, bottom], Color::Faint, 0.7, "");
    }
}
