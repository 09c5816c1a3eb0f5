//! A figure as SVG; one user unit is a point (1/72 inch).

use kurbo::Rect;

use super::canvas::{
    Anchor, Canvas, LINE_HEIGHT, PlotArea, TextStyle, draw, label_peaks, legend_sample,
};
use super::text::{self, FALLBACK, escape};
use super::{Axis, Color, Figure, FigureOptions, Layer, Panel, Scale};

/// Points per millimetre.
const POINTS: f64 = 72.0 / 25.4;
/// Smallest width and height of a plot area, relative to the font size.
const LEAST_PLOT: [f64; 2] = [6.0, 3.5];
/// Space between the edge of a cell and its texts, and between the labels of an axis and the axis.
const EDGE: f64 = 0.6;
const GAP: f64 = 0.65;
/// Width of a legend sample, and space after it and after its text, relative to the font size.
const SAMPLE: f64 = 0.9;
const AFTER: [f64; 2] = [0.4, 1.2];
/// Height of the labels and the name of a horizontal axis, relative to the font size.
const BELOW: f64 = 3.6;
/// Largest number of ticks of an axis.
const MOST_TICKS: usize = 10;
/// The styles of texts: size, weight and colour.
const LARGE: TextStyle = (1.25, true, Color::Ink);
const BOLD: TextStyle = (1.1, true, Color::Ink);
const PLAIN: TextStyle = (1.0, false, Color::Ink);
const FAINT: TextStyle = (1.0, false, Color::Faint);

/// The smallest share of the height for plot areas that a larger font must leave.
const PLOTS: f64 = 0.5;

/// Size (mm) and font size (points) of a figure. The default size grows until everything has room.
pub fn layout(figure: &Figure, options: &FigureOptions) -> ([f64; 2], f64) {
    let size = options.size.unwrap_or(options.default_mm(figure.size_mm));
    let grown = (0..100).map(|k| size.map(|side| side * (1.0 + 0.02 * f64::from(k))));
    let mut sizes = grown.take(if options.size.is_some() { 1 } else { 100 });
    let fitting = sizes.find_map(|mm| Some((mm, font_size(figure, options, mm)?)));
    fitting.unwrap_or((size, options.font_sizes()[0]))
}

/// The largest font size of the style with which everything has room on a page of a size (mm) and the plot areas take
/// half of the height, or else the smallest; `None` if the page is too small.
pub fn font_size(figure: &Figure, options: &FigureOptions, mm: [f64; 2]) -> Option<f64> {
    let [least, most] = options.font_sizes();
    let sizes = (0..).map(|k| most - f64::from(k));
    sizes.take_while(|size| *size >= least).find(|size| {
        let page = page(figure, options, (mm, *size), false);
        page.fits && (page.plots >= PLOTS || *size == least)
    })
}

/// The page of a figure at a size (mm) and a font size (points). Without `marks` only the texts are placed, to find
/// out whether they have room.
pub fn page(
    figure: &Figure,
    options: &FigureOptions,
    ([mm_width, mm_height], font_size): ([f64; 2], f64),
    marks: bool,
) -> Canvas {
    let [width, height] = [mm_width, mm_height].map(|side| side * POINTS);
    let mut canvas = Canvas::new([width, height], font_size);
    let title = escape(&figure.title);
    canvas.push(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{mm_width:.2}mm\" height=\"{mm_height:.2}mm\" viewBox=\"0 0 {width:.2} {height:.2}\" \
         font-family=\"{FALLBACK}\">\n<title>{title}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    ));
    if !figure.caption.is_empty() {
        canvas.push(format_args!("<desc>{}</desc>", escape(&figure.caption)));
    }
    let mut top = 0.3 * font_size;
    if options.has_title() {
        let size = LARGE.0 * font_size;
        for line in text::wrap(&figure.title, width - 2.0 * font_size, size, true) {
            let at = [EDGE * font_size, top + 0.5 * LINE_HEIGHT * size];
            canvas.text(at, &line, Anchor::Start, LARGE);
            top += LINE_HEIGHT * size;
        }
    }
    rows(&mut canvas, figure, top, marks);
    canvas.out.push_str("</svg>\n");
    canvas
}

/// The panels below the title.
fn rows(canvas: &mut Canvas, figure: &Figure, top: f64, marks: bool) {
    let (em, page) = (canvas.font_size, canvas.page);
    let height = (page.height() - top) / figure.rows.len().max(1) as f64;
    // The margins are the same for rows with as many panels, so that plot areas are aligned. They depend on the ticks,
    // these on the height of the plot areas, and this on the headers, whose lines depend on the margins.
    let mut spaces = vec![([5.0 * em, 2.0 * em], height - 6.0 * em); figure.rows.len()];
    let mut placed: Vec<Vec<Texts<'_>>> = Vec::new();
    for _ in 0..3 {
        let rows = figure.rows.iter().zip(&spaces);
        let texts = rows.map(|(row, (margins, plot))| {
            let cell = [page.width() / row.len().max(1) as f64, *plot];
            let texts = |panel| Texts::new(panel, cell, *margins, em);
            row.iter().map(texts).collect()
        });
        placed = texts.collect();
        let found = placed.iter().map(|row: &Vec<Texts<'_>>| {
            let aligned = placed.iter().filter(|other| other.len() == row.len());
            let margins = aligned.flatten().map(|texts| texts.margins);
            let margins = margins.fold([0.0_f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
            let lines = row.iter().map(|it| it.header.len() + it.legend.len());
            let header = LINE_HEIGHT * lines.max().unwrap_or(0) as f64 + 0.8;
            (margins, height - (header + BELOW) * em)
        });
        spaces = found.collect();
    }
    for (number, (row, ([left, right], plot))) in placed.iter().zip(spaces).enumerate() {
        canvas.plots += plot / page.height();
        let cell = page.width() / row.len().max(1) as f64;
        let y = top + number as f64 * height;
        for (place, texts) in row.iter().enumerate() {
            let x = place as f64 * cell;
            let plot = [cell - left - right, plot];
            canvas.fits &= plot[0] >= LEAST_PLOT[0] * em && plot[1] >= LEAST_PLOT[1] * em;
            texts.draw_header(canvas, [x + indent(texts.panel, left, em), y + 0.2 * em]);
            let [along, up] = sides(texts.panel, plot);
            let above = y + height - plot[1] - BELOW * em;
            let corner = (x + left + 0.5 * (plot[0] - along), above);
            let frame = Rect::from_origin_size(corner, (along.max(em), up.max(em)));
            draw_panel(canvas, texts, frame, marks);
            let name = texts.panel.y.label();
            let half = 0.5 * text::width(&name, em, false) + 0.3 * em;
            let middle = frame.center().y.min(y + height - half).max(y + half);
            canvas.turned_text([frame.x0 - left + em, middle], &name, Color::Faint);
        }
    }
}

/// Width and height of the plot area of a panel where it may take a size.
fn sides(panel: &Panel, sides: [f64; 2]) -> [f64; 2] {
    let square = [sides[0].min(sides[1]); 2];
    if panel.square { square } else { sides }
}

/// The texts of a panel, broken into lines.
struct Texts<'a> {
    panel: &'a Panel,
    /// The title and the caption.
    header: Vec<(String, TextStyle)>,
    /// Layers with a legend entry, by lines.
    legend: Vec<Vec<&'a Layer>>,
    /// Positions on the axes and their labels.
    x_ticks: Vec<(f64, String)>,
    y_ticks: Vec<(f64, String)>,
    /// Space to the left and to the right of the plot area.
    margins: [f64; 2],
}

impl<'a> Texts<'a> {
    /// The texts for the width of a cell and the height of the plot area, and for the margins to its left and right.
    fn new(panel: &'a Panel, [width, plot]: [f64; 2], [left, right]: [f64; 2], em: f64) -> Self {
        let [along, up] = sides(panel, [width - left - right, plot]);
        let across = |label: &str| text::width(label, em, false) + 0.6 * em;
        let x_ticks = ticks(&panel.x, along, 5.0 * em, across);
        let close = if panel.square { 5.0 } else { 2.8 };
        let y_ticks = ticks(&panel.y, up, close * em, |_| 1.1 * em);
        let overhangs = x_ticks.iter().map(|(tick, label)| {
            0.5 * text::width(label, em, false) - along * (1.0 - panel.x.fraction(*tick))
        });
        let labels = y_ticks.iter();
        let labels = labels.map(|(_, label)| text::width(&text::shown(label), em, false));
        let name = LINE_HEIGHT * f64::from(u8::from(!panel.y.label().is_empty()));
        let margins = [
            labels.fold(0.0, f64::max) + (name + EDGE + GAP) * em,
            overhangs.fold(GAP * em, f64::max) + EDGE * em,
        ];
        let header = (width - indent(panel, left, em) - EDGE * em).max(em);
        let title = text::wrap(&panel.title, header, BOLD.0 * em, true).into_iter();
        let caption = text::wrap(&panel.caption, header, em, false).into_iter();
        let lines = title.map(|line| (line, BOLD));
        Self {
            panel,
            header: lines.chain(caption.map(|line| (line, FAINT))).collect(),
            legend: legend(panel, header, em),
            x_ticks,
            y_ticks,
            margins,
        }
    }

    fn draw_header(&self, canvas: &mut Canvas, [left, top]: [f64; 2]) {
        let em = canvas.font_size;
        let mut y = top + 0.5 * LINE_HEIGHT * em;
        for (line, style) in &self.header {
            canvas.text([left, y], line, Anchor::Start, *style);
            y += LINE_HEIGHT * em;
        }
        for line in &self.legend {
            let mut x = left;
            for layer in line {
                legend_sample(canvas, layer, [x, y], SAMPLE * em);
                let at = [x + (SAMPLE + AFTER[0]) * em, y];
                canvas.text(at, &layer.label, Anchor::Start, PLAIN);
                x += entry_width(layer, em);
            }
            y += LINE_HEIGHT * em;
        }
    }
}

/// Distance of the header from the left edge. It leaves room for the name of the vertical axis.
fn indent(panel: &Panel, left: f64, em: f64) -> f64 {
    let has_names = panel.y.scale == Scale::Rows;
    if has_names { EDGE * em } else { left }
}

/// The layers of the legend in lines of a width.
fn legend(panel: &Panel, available: f64, em: f64) -> Vec<Vec<&Layer>> {
    let mut lines: Vec<Vec<&Layer>> = Vec::new();
    let mut taken = f64::INFINITY;
    for layer in panel.layers.iter().filter(|layer| !layer.label.is_empty()) {
        let entry = entry_width(layer, em);
        if taken + entry > available + AFTER[1] * em {
            lines.push(Vec::new());
            taken = 0.0;
        }
        taken += entry;
        let line = lines.last_mut().expect("the first entry starts a line");
        line.push(layer);
    }
    lines
}

fn entry_width(layer: &Layer, em: f64) -> f64 {
    text::width(&layer.label, em, false) + (SAMPLE + AFTER[0] + AFTER[1]) * em
}

/// Ticks of an axis of a length, at least two, as many as are `spacing` apart and have labels of a size that do not
/// overlap.
fn ticks(axis: &Axis, length: f64, spacing: f64, size: impl Fn(&str) -> f64) -> Vec<(f64, String)> {
    let most = ((length / spacing) as usize).clamp(2, MOST_TICKS);
    let is_apart = |pair: &[(f64, String)]| {
        let apart = axis.fraction(pair[1].0) - axis.fraction(pair[0].0);
        apart * length >= 0.5 * (size(&pair[0].1) + size(&pair[1].1))
    };
    let are_apart = |ticks: &Vec<_>| ticks.len() > 1 && ticks.windows(2).all(is_apart);
    let numbers = (1..=most).rev().chain(most + 1..=MOST_TICKS);
    let found = numbers.map(|number| axis.ticks(number)).find(are_apart);
    found.unwrap_or_else(|| axis.ticks(most))
}

fn draw_panel(canvas: &mut Canvas, texts: &Texts<'_>, frame: Rect, marks: bool) {
    axes(canvas, texts, frame);
    let (panel, em) = (texts.panel, canvas.font_size);
    let ([x, y], [width, height]) = ([frame.x0, frame.y0], [frame.width(), frame.height()]);
    let area = PlotArea { panel, rect: frame };
    if marks {
        // A nested SVG element clips its content and needs no identifier that another figure could share.
        canvas.push(format_args!(
            "<svg x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
             viewBox=\"{x:.2} {y:.2} {width:.2} {height:.2}\" overflow=\"hidden\">"
        ));
        for layer in &panel.layers {
            draw(canvas, &area, layer);
        }
        canvas.push(format_args!("</svg>"));
    }
    let lines = text::wrap(&panel.note, width - em, em, false);
    let first = y + 0.5 * (height - 1.15 * em * (lines.len() as f64 - 1.0));
    for (k, line) in lines.iter().enumerate() {
        let at = [x + 0.5 * width, first + 1.15 * em * k as f64];
        canvas.text(at, line, Anchor::Middle, FAINT);
    }
    for layer in &panel.layers {
        label_peaks(canvas, &area, layer);
    }
}

/// Ticks with labels, which are grid lines unless an image would hide them, names and lines of both axes.
fn axes(canvas: &mut Canvas, texts: &Texts<'_>, frame: Rect) {
    let (panel, em) = (texts.panel, canvas.font_size);
    let Rect { x0, y0, x1, y1 } = frame;
    let (left, below) = (x0 - 0.4 * em, y1 + 0.4 * em);
    let image = panel.has_image();
    let [right, top] = if image { [x0, y1] } else { [x1, y0] };
    let color = if image { Color::Faint } else { Color::Grid };
    let enough = |axis: &Axis, count| count > 1 || axis.scale != Scale::Linear;
    canvas.fits &= enough(&panel.x, texts.x_ticks.len()) && enough(&panel.y, texts.y_ticks.len());
    for (value, label) in &texts.x_ticks {
        let x = x0 + frame.width() * panel.x.fraction(*value);
        canvas.line([x, top, x, below], color, 0.7);
        canvas.text([x, below + 0.8 * em], label, Anchor::Middle, PLAIN);
    }
    let middle = [frame.center().x, y1 + 2.4 * em];
    canvas.text(middle, &panel.x.label(), Anchor::Middle, FAINT);
    for (value, label) in &texts.y_ticks {
        let y = y1 - frame.height() * panel.y.fraction(*value);
        if panel.y.scale != Scale::Rows {
            canvas.line([left, y, right, y], color, 0.7);
        }
        canvas.text([x0 - GAP * em, y], label, Anchor::End, PLAIN);
    }
    let [left, bottom] = [[x0, y0, x0, y1], [x0, y1, x1, y1]];
    let sides = [left, bottom, [x0, y0, x1, y0], [x1, y0, x1, y1]];
    for side in &sides[..if image { 4 } else { 2 }] {
        canvas.line(*side, Color::Faint, 0.7);
    }
}
