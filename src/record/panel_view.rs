//! A panel of a figure in the viewer; its layers are entities below the path of the panel.
//!
//! | element | entity |
//! |---|---|
//! | axes, legend | `PATH/axes`, `PATH/legend` |
//! | a layer, or several with one id | `PATH/ID` |
//! | labels of peaks and lines to the peaks | `PATH/names`, `PATH/stems` |
//! | caption, note | `PATH/caption`, `PATH/note` |

use std::collections::BTreeMap;

use crate::record::sdk::components::ImageFormat;
use crate::record::sdk::datatypes::ChannelDatatype;
use crate::record::sdk::{
    AnnotationContext, ClassDescription, Clear, LineStrips2D, Points2D, Radius, Rgba32,
    SegmentationImage, Transform3D,
};

use super::blueprint::layout::Row;
use super::blueprint::tree::View;
use super::paths::Root;
use super::plot::{CAPTION_HEIGHT, Plot, legend_height, texts};
use super::stream::{Moment, RecordingStream};
use super::style;
use crate::escape;
use crate::plot::{Color, Image, Layer, Panel, Shape, shown};

/// Lengths of the dashes and gaps of a dashed line, pixels.
const STROKE: f32 = 8.0;
const GAP: f32 = 6.0;
/// Width of a character, pixels: an upper limit, because the viewer uses a fixed font size.
const LETTER: f32 = 8.0;
/// Screen points per point on paper.
const ENLARGED: f64 = 0.8;

/// The path and size of panels of one type, and the state of what is drawn there.
#[derive(Debug, Default)]
pub struct PanelView {
    path: String,
    field: [f32; 2],
    /// Axes, caption and note as drawn last.
    axes: Option<Plot>,
    caption: String,
    note: String,
    /// Size and palette length of the current image.
    image: Option<([usize; 2], usize)>,
}

/// The panels below a root, by their names in the layout.
#[derive(Debug)]
pub struct PanelViews {
    root: Root,
    views: BTreeMap<&'static str, PanelView>,
}

impl PanelViews {
    /// No panels yet.
    pub fn new(root: Root) -> Self {
        Self {
            root,
            views: BTreeMap::new(),
        }
    }

    /// The panel of a name.
    pub fn of(&mut self, name: &'static str) -> &mut PanelView {
        let view = self.views.entry(name);
        view.or_insert_with(|| PanelView::of(name, &self.root))
    }
}

/// The components of one entity: lines and points with their colours, if it has any.
#[derive(Default)]
struct Entity {
    strips: Option<Vec<(Vec<[f32; 2]>, Color)>>,
    points: Option<Vec<([f32; 2], Color)>>,
    /// Half-width of lines and radius of points.
    radius: f32,
    order: f32,
}

impl PanelView {
    /// The picture of a name in the layout, below a root.
    ///
    /// # Panics
    /// If the layout has no such picture.
    pub fn of(name: &str, root: &Root) -> Self {
        let row = Row::of(name).expect("a picture of the layout");
        let (field, _) = row.field().expect("a picture has a size");
        Self {
            path: root.at(row.paths[0]),
            field,
            ..Self::default()
        }
    }

    /// A view of a panel, under the title of the panel.
    pub fn view(&self, panel: &Panel) -> View {
        View::picture(panel.title.as_str(), &self.path, self.plot(panel).bounds())
    }

    /// Axes, legend and size of a panel.
    pub fn plot(&self, panel: &Panel) -> Plot {
        let has_peaks = |layer: &Layer| matches!(layer.shape, Shape::Peaks(_));
        let [width, height] = self.field;
        let legend = legend(panel);
        Plot {
            width,
            height,
            top_margin: match legend_height(width, &legend) {
                _ if panel.layers.iter().any(has_peaks) => NAMES_HEIGHT,
                0.0 if !panel.caption.is_empty() => CAPTION_HEIGHT,
                height => height,
            },
            x: panel.x.clone(),
            y: panel.y.clone(),
            grid: !panel.has_image(),
            legend,
        }
    }

    /// Draws the axes and the legend of a panel from a moment on, if the axes have changed.
    pub fn draw_axes(&mut self, rec: &RecordingStream, at: Moment, panel: &Panel) -> Plot {
        let plot = self.plot(panel);
        if self.axes.as_ref() != Some(&plot) {
            plot.draw(rec, &self.path, at);
            self.axes = Some(plot.clone());
        }
        plot
    }

    /// Draws a panel from a moment on.
    pub fn draw(&mut self, rec: &RecordingStream, at: Moment, panel: &Panel) {
        if rec.keep(&self.path, || panel.clone()) {
            return;
        }
        let plot = self.draw_axes(rec, at, panel);
        self.draw_layers(rec, at, &plot, &panel.layers);
        let [middle, height] = [0.5 * plot.width, 0.5 * plot.height];
        if self.note != panel.note {
            self.note.clone_from(&panel.note);
            let note = text(&panel.note, [middle, height], Color::Ink);
            rec.log(self.at("note"), at, &note);
        }
        if self.caption != panel.caption {
            self.caption.clone_from(&panel.caption);
            let caption = text(&panel.caption, [middle, -36.0], Color::Faint);
            rec.log(self.at("caption"), at, &caption);
        }
    }

    /// Draws a vertical line at an abscissa over a panel that is drawn, solid because marks of a panel are dashed.
    pub fn draw_cursor(&mut self, rec: &RecordingStream, at: Moment, panel: &Panel, x: f64) {
        let cursor = Layer {
            dashed: false,
            ..Layer::vertical_lines([x], Color::Ink).with_id("cursor")
        };
        let plot = self.plot(panel);
        self.draw_layers(rec, at, &plot, &[cursor]);
    }

    /// Draws layers; layers with the same id form one entity.
    pub fn draw_layers(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        plot: &Plot,
        layers: &[Layer],
    ) {
        let mut entities: Vec<(&str, Entity)> = Vec::new();
        for (number, layer) in layers.iter().enumerate() {
            match &layer.shape {
                Shape::Image(image) => self.draw_image(rec, at, plot, (&layer.id, image)),
                Shape::Peaks(peaks) => self.draw_peaks(rec, at, plot, (layer, peaks)),
                _ => {
                    let place = entities.iter().position(|(id, _)| *id == layer.id);
                    let place = place.unwrap_or(entities.len());
                    if place == entities.len() {
                        entities.push((&layer.id, Entity::default()));
                    }
                    entities[place].1.add(plot, layer, number as f32);
                }
            }
        }
        for (id, entity) in entities {
            entity.log(rec, &self.at(id), at);
        }
    }

    fn at(&self, id: &str) -> String {
        format!("{}/{id}", self.path)
    }

    fn draw_image(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        plot: &Plot,
        (id, image): (&str, &Image),
    ) {
        let path = self.at(id);
        if image.pixels.is_empty() {
            // The size is logged again with the next image.
            self.image = None;
            return rec.log(path, at, &Clear::flat());
        }
        let now = Some((image.size, image.palette.len()));
        if self.image != now {
            self.image = now;
            let classes = image.palette.iter().zip(0u16..).map(|((color, name), id)| {
                let [r, g, b] = color.on_dark();
                ClassDescription::from((id, &**name, Rgba32::from_rgb(r, g, b)))
            });
            let classes = AnnotationContext::new(classes.collect::<Vec<_>>());
            rec.log_static(&*path, &classes);
            let [left, top] = plot.at(image.x[0], image.y[1]);
            let [right, bottom] = plot.at(image.x[1], image.y[0]);
            let [columns, rows] = image.size.map(|side| side as f32);
            let scale = [(right - left) / columns, (bottom - top) / rows, 1.0];
            let place = Transform3D::from_translation([left, top, 0.0]).with_scale(scale);
            rec.log(&*path, at, &place);
        }
        let size = image.size.map(|side| side as u32);
        let format = ImageFormat::segmentation(size, ChannelDatatype::U8);
        let picture = SegmentationImage::new(image.pixels.clone(), format)
            .with_opacity(1.0)
            .with_draw_order(-2.0);
        rec.log(path, at, &picture);
    }

    fn draw_peaks(
        &self,
        rec: &RecordingStream,
        at: Moment,
        plot: &Plot,
        (layer, peaks): (&Layer, &[([f64; 2], String)]),
    ) {
        let color = layer.color;
        let tips: Vec<[f32; 2]> = peaks.iter().map(|([x, y], _)| plot.at(*x, *y)).collect();
        let points = Points2D::new(tips.iter().copied())
            .with_colors([color])
            .with_radii([Radius::new_ui_points(2.5)]);
        rec.log(self.at(&layer.id), at, &points);
        let named = tips.into_iter().zip(peaks.iter().map(|(_, name)| &**name));
        let labels = place_names(plot.width, named);
        let names = labels.iter();
        let names = names.map(|label| (label.at, shown(label.name), color));
        rec.log(self.at("names"), at, &texts(names.collect()));
        // The lines start below the label, which the viewer draws below its position.
        let stems = labels.iter().map(|label| {
            let [x, tip] = label.tip;
            [[x, label.at[1] + NAME_HEIGHT], [x, tip]]
        });
        let stems = LineStrips2D::new(stems)
            .with_colors([style::faded(color, 0.5)])
            .with_radii([Radius::new_ui_points(0.5)]);
        rec.log(self.at("stems"), at, &stems);
    }
}

/// Rows of peak labels above the plot area, and their height, pixels.
const NAME_LINES: usize = 3;
const NAME_HEIGHT: f32 = 24.0;
/// Height of all rows of peak labels, pixels.
pub const NAMES_HEIGHT: f32 = NAME_LINES as f32 * NAME_HEIGHT - 4.0;
/// Space around a label, pixels.
const NAME_PADDING: f32 = 16.0;

/// A label of a peak, its position, and that of the peak.
struct PeakLabel<'a> {
    name: &'a str,
    at: [f32; 2],
    tip: [f32; 2],
}

/// Places the labels of peaks above the plot area, centred over their peaks if possible, in the given order. Each label
/// takes the lowest row in which it overlaps no other; a label without space is omitted, its peak keeps its
/// mark.
fn place_names<'a>(
    width: f32,
    peaks: impl Iterator<Item = ([f32; 2], &'a str)>,
) -> Vec<PeakLabel<'a>> {
    let mut taken: [Vec<[f32; 2]>; NAME_LINES] = Default::default();
    let labels = peaks.filter_map(|(tip, name)| {
        let half = 0.5 * (LETTER * name.chars().count() as f32 + NAME_PADDING);
        let middle = tip[0].clamp(half - NAME_PADDING, width + NAME_PADDING - half);
        let [left, right] = [middle - half, middle + half];
        let is_free = |line: &Vec<[f32; 2]>| line.iter().all(|[a, b]| right <= *a || *b <= left);
        let line = taken.iter().position(is_free)?;
        taken[line].push([left, right]);
        let at = [middle, -(line as f32 + 1.0) * NAME_HEIGHT - 4.0];
        Some(PeakLabel { name, at, tip })
    });
    labels.collect()
}

/// Labels of the layers with their colours.
fn legend(panel: &Panel) -> Vec<(String, Color)> {
    let named = panel.layers.iter().filter(|layer| !layer.label.is_empty());
    let text = |layer: &Layer| shown(&escape::line(&layer.label));
    let named = named.map(|layer| (text(layer), layer.color));
    named.collect()
}

/// A text at a position; an empty text clears the current one.
fn text(text: &str, at: [f32; 2], color: Color) -> Points2D {
    let text = Some(shown(&escape::line(text))).filter(|text| !text.is_empty());
    texts(text.map(|text| (at, text, color)).into_iter().collect())
}

impl Entity {
    /// Adds a layer; `number` is its drawing order.
    fn add(&mut self, plot: &Plot, layer: &Layer, number: f32) {
        let color = layer.color;
        let places = |points: &[[f64; 2]]| -> Vec<[f32; 2]> {
            let finite = points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
            finite.map(|[x, y]| plot.at(*x, *y)).collect()
        };
        self.order = number;
        match &layer.shape {
            Shape::Lines(strips) => {
                self.radius = (ENLARGED * layer.size) as f32;
                for strip in strips.iter().map(|strip| places(strip)) {
                    if layer.dashed {
                        self.add_strips(dashes(&strip), color);
                    } else {
                        self.add_strips([strip], color);
                    }
                }
            }
            Shape::Points(points) => {
                // Smaller points are not visible on a screen.
                self.radius = (1.2 * layer.size).max(1.6) as f32;
                if layer.fading {
                    let fade = |k| style::fade(color, k, points.len());
                    let aged = places(points).into_iter().zip((1..).map(fade));
                    self.points.get_or_insert_default().extend(aged);
                } else {
                    self.add_points(places(points), color);
                }
            }
            Shape::Areas(outlines) => {
                self.radius = 0.6;
                for outline in outlines {
                    let corners = outline.iter().chain(outline.first());
                    self.add_strips([corners.map(|[x, y]| plot.at(*x, *y)).collect()], color);
                }
            }
            Shape::Image(_) | Shape::Peaks(_) => {}
        }
    }

    fn add_strips(&mut self, strips: impl IntoIterator<Item = Vec<[f32; 2]>>, color: Color) {
        // A line with a single point is skipped.
        let strips = strips.into_iter().filter(|strip| strip.len() > 1);
        let colored = strips.map(|strip| (strip, color));
        self.strips.get_or_insert_default().extend(colored);
    }

    /// Adds points of a colour; those within a quarter of a pixel are merged.
    fn add_points(&mut self, points: impl IntoIterator<Item = [f32; 2]>, color: Color) {
        let near = points.into_iter();
        let near = near.map(|point| point.map(|c| (4.0 * c).round() as i32));
        let mut near: Vec<[i32; 2]> = near.collect();
        near.sort_unstable();
        near.dedup();
        let near = near.into_iter();
        let colored = near.map(|at| (at.map(|c| c as f32 / 4.0), color));
        self.points.get_or_insert_default().extend(colored);
    }

    fn log(self, rec: &RecordingStream, path: &str, at: Moment) {
        let radius = [Radius::new_ui_points(self.radius)];
        if let Some(strips) = self.strips {
            let (strips, colors): (Vec<_>, _) = strips.into_iter().unzip();
            let strips = LineStrips2D::new(strips)
                .with_colors(single(colors))
                .with_radii(radius)
                .with_draw_order(self.order);
            rec.log(path, at, &strips);
        }
        if let Some(points) = self.points {
            let (points, colors): (Vec<_>, _) = points.into_iter().unzip();
            let points = Points2D::new(points)
                .with_colors(single(colors))
                .with_radii(radius)
                .with_draw_order(self.order);
            rec.log(path, at, &points);
        }
    }
}

/// A single colour if all are equal.
fn single(mut colors: Vec<Color>) -> Vec<Color> {
    if colors.iter().all(|color| Some(color) == colors.first()) {
        colors.truncate(1);
    }
    colors
}

/// The dashes of a dashed line, which Rerun 0.36 does not have. They are measured along the whole line: its vertices do not
/// interrupt them.
fn dashes(line: &[[f32; 2]]) -> Vec<Vec<[f32; 2]>> {
    let mut strokes: Vec<Vec<[f32; 2]>> = Vec::new();
    // Length from the start of the current dash to the current vertex.
    let mut phase = 0.0;
    for pair in line.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        let length = (x1 - x0).hypot(y1 - y0);
        let at = |along: f32| {
            let share = (along / length).clamp(0.0, 1.0);
            [x0 + share * (x1 - x0), y0 + share * (y1 - y0)]
        };
        let mut start = -phase;
        while start < length {
            let end = start + STROKE;
            match strokes.last_mut() {
                Some(stroke) if start < 0.0 && end > 0.0 => stroke.push(at(end)),
                _ if end > 0.0 => strokes.push(vec![at(start), at(end)]),
                _ => {}
            }
            start += STROKE + GAP;
        }
        phase = length - (start - STROKE - GAP);
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_stay_on_the_line() {
        let strokes = dashes(&[[0.0, 5.0], [30.0, 5.0]]);
        assert_eq!(strokes[0], [[0.0, 5.0], [8.0, 5.0]]);
        assert_eq!(strokes.last().unwrap()[1], [30.0, 5.0]);
        assert_eq!(strokes.len(), 3);
    }

    /// A curve of short segments has the dashes of a straight line.
    #[test]
    fn vertices_do_not_interrupt_dashes() {
        let line: Vec<[f32; 2]> = (0..=30).map(|x| [x as f32, 5.0]).collect();
        let strokes = dashes(&line).into_iter();
        let ends = strokes.map(|stroke| [stroke[0][0], stroke[stroke.len() - 1][0]]);
        let expected = [[0.0, 8.0], [14.0, 22.0], [28.0, 30.0]];
        assert_eq!(ends.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn overlapping_points_are_merged() {
        let mut entity = Entity::default();
        let color = Color::Ink;
        entity.add_points([[2.0, 1.0], [1.0, 1.0], [1.05, 1.0]], color);
        let (points, colors): (Vec<_>, _) = entity.points.unwrap().into_iter().unzip();
        assert_eq!(points, [[1.0, 1.0], [2.0, 1.0]]);
        assert_eq!(single(colors), [color]);
    }

    #[test]
    fn labels_do_not_overlap() {
        let named = |x: f32, name: &'static str| ([x, 50.0], name);
        let crowd = [
            (100.0, "f1: 4.12"),
            (103.0, "f2: 3.88"),
            (390.0, "3 f1: 12.36"),
            (97.0, "f3: 4"),
        ];
        let placed = place_names(400.0, crowd.map(|(x, name)| named(x, name)).into_iter());
        let line = |k: usize| (-placed[k].at[1] / NAME_HEIGHT) as usize;
        assert_eq!([line(0), line(1), line(2), line(3)], [1, 2, 1, 3]);
        assert_eq!(placed[0].at[0], 100.0, "over its peak");
        assert!(placed[2].at[0] < 390.0, "within the view");
        // There is no space for a fourth label at the same place.
        let five = [100.0, 101.0, 102.0, 103.0, 300.0].map(|x| named(x, "f1: 4.12"));
        let kept: Vec<_> = place_names(400.0, five.into_iter())
            .iter()
            .map(|p| p.tip[0])
            .collect();
        assert_eq!(kept, [100.0, 101.0, 102.0, 300.0]);
    }
}
