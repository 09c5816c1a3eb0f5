//! A figure as SVG; one user unit is a point (1/72 inch).

use super::canvas::{Anchor, Canvas, LINE_HEIGHT, PlotArea, Rect, TextStyle};
use super::text::{self, FALLBACK, escape};
use super::{Axis, Color, Figure, FigureOptions, Layer, Panel, Scale, Shape, marks};

/// Points per millimetre.
const POINTS: f64 = 72.0 / 25.4;
/// Smallest width and height of a plot area, relative to the font size.
const LEAST_PLOT: [f64; 2] = [6.0, 3.5];
/// Space between the edge of a cell and its texts, and between the labels of an axis and the axis.
const EDGE: f64 = 0.6;
const GAP: f64 = 0.65;
/// Space after a legend sample and after its text, relative to the font size.
const AFTER: [f64; 2] = [0.4, 1.2];
/// Largest share of the width of a cell that the names of rows take.
const NAMES: f64 = 0.42;
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
    let size = options.size_mm(figure.size_mm);
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
    (mm, font_size): ([f64; 2], f64),
    marks: bool,
) -> Canvas {
    let [width, height] = mm.map(|side| side * POINTS);
    let mut canvas = Canvas::new([width, height], font_size);
    let [mm_width, mm_height] = mm;
    let title = escape(&figure.title);
    canvas.push(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{mm_width:.2}mm\" height=\"{mm_height:.2}mm\" viewBox=\"0 0 {width:.2} {height:.2}\" \
         font-family=\"{FALLBACK}\">\n<title>{title}</title>"
    ));
    if !figure.caption.is_empty() {
        canvas.push(format_args!("<desc>{}</desc>", escape(&figure.caption)));
    }
    canvas.push(format_args!(
        "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    ));
    let mut top = 0.3 * font_size;
    if options.has_title() {
        let size = LARGE.0 * font_size;
        for line in text::wrap(&figure.title, width - 2.0 * font_size, size, true) {
            let at = [EDGE * font_size, top + 0.5 * LINE_HEIGHT * size];
            canvas.text(at, &line, Anchor::Start, LARGE);
            top += LINE_HEIGHT * size;
        }
    }
    let body = Rect::new([0.0, top], [width, height - top]);
    rows(&mut canvas, figure, body, marks);
    canvas.out.push_str("</svg>\n");
    canvas
}

fn rows(canvas: &mut Canvas, figure: &Figure, body: Rect, marks: bool) {
    let em = canvas.font_size;
    let [body_width, body_height] = body.size;
    let height = body_height / figure.rows.len().max(1) as f64;
    // The margins are the same for rows with as many panels, so that plot areas are aligned. They depend on the ticks,
    // these on the height of the plot areas, and this on the headers, whose lines depend on the margins.
    let mut margins = vec![[5.0 * em, 2.0 * em]; figure.rows.len()];
    let mut heights = vec![height - 6.0 * em; figure.rows.len()];
    let mut placed: Vec<Vec<Texts<'_>>> = Vec::new();
    for _ in 0..3 {
        let rows = figure.rows.iter().zip(&heights).zip(&margins);
        let texts = rows.map(|((row, plot), margins)| {
            let cell = [body_width / row.len().max(1) as f64, *plot];
            let texts = |panel| Texts::new(panel, cell, *margins, em);
            row.iter().map(texts).collect()
        });
        placed = texts.collect();
        let widest = |len: usize, side: usize| {
            let aligned = placed.iter().filter(|row| row.len() == len).flatten();
            aligned.map(|texts| texts.margins[side]).fold(0.0, f64::max)
        };
        let both = |row: &Vec<Texts<'_>>| [0, 1].map(|side| widest(row.len(), side));
        margins = placed.iter().map(both).collect();
        let left_over = placed.iter().map(|row| {
            let headers = row.iter().map(|texts| texts.header_height(em));
            height - (headers.fold(0.0, f64::max) + BELOW * em)
        });
        heights = left_over.collect();
    }
    for (number, row) in placed.iter().enumerate() {
        canvas.plots += heights[number] / canvas.page.size[1];
        let cell = body_width / row.len().max(1) as f64;
        let [left, right] = margins[number];
        for (place, texts) in row.iter().enumerate() {
            let cell_x = body.at[0] + place as f64 * cell;
            let cell_y = body.at[1] + number as f64 * height;
            let plot = [cell - left - right, heights[number]];
            canvas.fits &= plot[0] >= LEAST_PLOT[0] * em && plot[1] >= LEAST_PLOT[1] * em;
            let header = [cell_x + indent(texts.panel, left, em), cell_y + 0.2 * em];
            texts.draw_header(canvas, header);
            let size = sides(texts.panel, plot);
            let frame_x = cell_x + left + 0.5 * (plot[0] - size[0]);
            let frame_y = cell_y + height - plot[1] - BELOW * em;
            let frame = Rect::new([frame_x, frame_y], size.map(|side| side.max(em)));
            draw_panel(canvas, texts, frame, marks);
            let name = texts.panel.y.label();
            let half = 0.5 * text::width(&name, em, false) + 0.3 * em;
            let [low, high] = [cell_y + half, cell_y + height - half];
            let y = (frame.at[1] + 0.5 * frame.size[1]).min(high).max(low);
            canvas.turned_text([frame.at[0] - left + em, y], &name, Color::Faint);
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
    /// Positions on the axes and their labels; those of the vertical axis by lines.
    x_ticks: Vec<(f64, String)>,
    y_ticks: Vec<(f64, Vec<String>)>,
    /// Space to the left and to the right of the plot area.
    margins: [f64; 2],
}

impl<'a> Texts<'a> {
    /// The texts for the width of a cell and the height of the plot area, and for the margins to its left and right.
    fn new(panel: &'a Panel, [width, plot]: [f64; 2], [left, right]: [f64; 2], em: f64) -> Self {
        let [along, up] = sides(panel, [width - left - right, plot]);
        let x_ticks = ticks(&panel.x, along, em, [5.0, 0.6 * em]);
        let close = match panel.y.scale {
            _ if panel.square => 5.0,
            Scale::Logarithmic => 2.0,
            _ => 2.8,
        };
        let y_ticks = ticks(&panel.y, up, em, [close, 0.0]).into_iter();
        let y_ticks = y_ticks.map(|(tick, label)| {
            let lines = text::wrap(&label, NAMES * width, em, false);
            (tick, lines)
        });
        let y_ticks = Vec::from_iter(y_ticks);
        let overhangs = x_ticks.iter().map(|(tick, label)| {
            0.5 * text::width(label, em, false) - along * (1.0 - panel.x.fraction(*tick))
        });
        let labels = y_ticks.iter().flat_map(|(_, lines)| lines);
        let labels = labels.map(|line| text::width(line, em, false));
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

    fn header_height(&self, em: f64) -> f64 {
        (LINE_HEIGHT * (self.header.len() + self.legend.len()) as f64 + 0.8) * em
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
                let sample = sample_width(layer) * em;
                marks::legend_sample(canvas, layer, [x, y], sample);
                let at = [x + sample + AFTER[0] * em, y];
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
    let after = sample_width(layer) + AFTER[0] + AFTER[1];
    text::width(&layer.label, em, false) + after * em
}

/// Width of a legend sample, relative to the font size.
fn sample_width(layer: &Layer) -> f64 {
    match layer.shape {
        Shape::Points(_) => 0.7,
        Shape::Areas(_) => 1.0,
        _ => 1.9,
    }
}

/// As many ticks of an axis of a length as are `spacing` font sizes apart, but at least two, with labels that keep a
/// gap; labels of a vertical axis have the height of a line.
fn ticks(axis: &Axis, length: f64, em: f64, [spacing, gap]: [f64; 2]) -> Vec<(f64, String)> {
    let most = ((length / (spacing * em)) as usize).clamp(2, MOST_TICKS);
    let half = |label: &str| match gap {
        0.0 => 0.55 * em,
        gap => 0.5 * (text::width(label, em, false) + gap),
    };
    let is_apart = |pair: &[(f64, String)]| {
        let apart = axis.fraction(pair[1].0) - axis.fraction(pair[0].0);
        apart * length >= half(&pair[0].1) + half(&pair[1].1)
    };
    let are_apart = |ticks: &Vec<(f64, String)>| {
        axis.scale == Scale::Rows || ticks.len() > 1 && ticks.windows(2).all(is_apart)
    };
    let numbers = (1..=most).rev().chain(most + 1..=MOST_TICKS);
    let found = numbers.map(|number| axis.ticks(number)).find(are_apart);
    found.unwrap_or_else(|| axis.ticks(most))
}

fn draw_panel(canvas: &mut Canvas, texts: &Texts<'_>, frame: Rect, marks: bool) {
    axes(canvas, texts, frame);
    let panel = texts.panel;
    let ([x, y], [width, height], em) = (frame.at, frame.size, canvas.font_size);
    let area = PlotArea { panel, rect: frame };
    if marks {
        // A nested SVG element clips its content and needs no identifier that another figure could share.
        canvas.push(format_args!(
            "<svg x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
             viewBox=\"{x:.2} {y:.2} {width:.2} {height:.2}\" overflow=\"hidden\">"
        ));
        for layer in &panel.layers {
            marks::draw(canvas, &area, layer);
        }
        canvas.push(format_args!("</svg>"));
    }
    let lines = text::wrap(&panel.note, width - em, em, false);
    let middle = [x + 0.5 * width, y + 0.5 * height];
    canvas.lines(middle, &lines, Anchor::Middle, FAINT);
    for layer in &panel.layers {
        marks::label_peaks(canvas, &area, layer);
    }
}

/// Grid, ticks with labels, names and lines of both axes.
fn axes(canvas: &mut Canvas, texts: &Texts<'_>, frame: Rect) {
    let em = canvas.font_size;
    let panel = texts.panel;
    let ([left, top], [right, bottom]) = (frame.at, frame.end());
    let grid = !panel.has_image();
    let tick = 0.4 * em;
    let counts = [texts.x_ticks.len(), texts.y_ticks.len()];
    for (axis, count) in [&panel.x, &panel.y].into_iter().zip(counts) {
        canvas.fits &= count > 1 || axis.scale != Scale::Linear;
    }
    for (value, label) in &texts.x_ticks {
        let x = left + frame.size[0] * panel.x.fraction(*value);
        if grid {
            canvas.line([x, top, x, bottom], Color::Grid, 0.7, "");
        }
        canvas.line([x, bottom, x, bottom + tick], Color::Faint, 0.7, "");
        let below = [x, bottom + tick + 0.8 * em];
        canvas.text(below, label, Anchor::Middle, PLAIN);
    }
    let middle = [0.5 * (left + right), bottom + 2.4 * em];
    canvas.text(middle, &panel.x.label(), Anchor::Middle, FAINT);
    for (value, label) in &texts.y_ticks {
        let y = bottom - frame.size[1] * panel.y.fraction(*value);
        if panel.y.scale != Scale::Rows {
            if grid {
                canvas.line([left, y, right, y], Color::Grid, 0.7, "");
            }
            canvas.line([left - tick, y, left, y], Color::Faint, 0.7, "");
        }
        canvas.lines([left - GAP * em, y], label, Anchor::End, PLAIN);
    }
    canvas.line([left, top, left, bottom], Color::Faint, 0.7, "");
    canvas.line([left, bottom, right, bottom], Color::Faint, 0.7, "");
    if !grid {
        canvas.line([left, top, right, top], Color::Faint, 0.7, "");
        canvas.line([right, top, right, bottom], Color::Faint, 0.7, "");
    }
}
