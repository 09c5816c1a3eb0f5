//! A panel of a figure in the viewer; its layers are entities below the path of the panel.
//!
//! | element | entity |
//! |---|---|
//! | axes, legend | `PATH/axes`, `PATH/legend` |
//! | a layer, or several with one id | `PATH/ID` |
//! | labels of peaks and lines to the peaks | `PATH/names`, `PATH/stems` |
//! | caption, note | `PATH/caption`, `PATH/note` |

use rerun::{
    AnnotationContext, AsComponents, Clear, Color, LineStrips2D, Points2D, Radius,
    SegmentationImage, Transform3D, components::ImageFormat, datatypes::ChannelDatatype,
};

use super::{
    error::RecordError,
    paths,
    peak_names::{NAMES_HEIGHT, Named, names_and_stems},
    plot::{Axes, Bounds, CAPTION_HEIGHT, Plot, legend_height},
    stream::{self, Moment, RecordingStream},
    style,
};
use crate::{
    escape,
    plot::{Image, Layer, Marker, Panel, Shape, shown},
};

/// Half the size of a cross, pixels.
const CROSS: f32 = 6.0;
/// Lengths of the dashes and gaps of a dashed line, pixels.
const STROKE: f32 = 8.0;
const GAP: f32 = 6.0;
/// Width of a character, pixels.
const LETTER: f32 = 8.0;
/// Screen points per point on paper.
const ENLARGED: f64 = 0.8;

/// The path and size of panels of one type, and the state of what is drawn there.
#[derive(Debug)]
pub struct PanelView {
    path: String,
    field: [f32; 2],
    axes: Axes,
    /// Size and palette length of the current image.
    image: Option<([usize; 2], usize)>,
}

/// The components of one entity.
#[derive(Default)]
struct Entity {
    strips: Vec<Vec<[f32; 2]>>,
    strip_colors: Vec<Color>,
    points: Vec<[f32; 2]>,
    point_colors: Vec<Color>,
    labels: Vec<String>,
    /// Half-width of lines and radius of points; `None` for the defaults of the view.
    radius: Option<f32>,
    has_strips: bool,
    has_points: bool,
    /// Whether the labels are always visible, and not only as tooltips.
    written: bool,
    order: f32,
}

impl PanelView {
    /// Panels at a path with a plot area of a size in pixels.
    pub fn new(path: impl Into<String>, field: [f32; 2]) -> Self {
        Self {
            path: path.into(),
            field,
            axes: Axes::default(),
            image: None,
        }
    }

    /// Path of the panels.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Bounds of a view of the panel.
    pub fn bounds(&self, panel: &Panel) -> Bounds {
        self.plot(panel).bounds()
    }

    /// Axes and size of a panel.
    pub fn plot(&self, panel: &Panel) -> Plot {
        let has_peaks = |layer: &Layer| matches!(layer.shape, Shape::Peaks(_));
        let [width, height] = self.field;
        Plot {
            width,
            height,
            top_margin: match panel.layers.iter().any(has_peaks) {
                true => NAMES_HEIGHT,
                false => match &key(panel)[..] {
                    [] if panel.caption.is_empty() => 0.0,
                    [] => CAPTION_HEIGHT,
                    key => legend_height(width, key),
                },
            },
            x: panel.x.clone(),
            y: panel.y.clone(),
            grid: !panel.has_image(),
        }
    }

    /// Draws a panel, either static or from a moment on.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: Option<Moment>,
        panel: &Panel,
    ) -> Result<(), RecordError> {
        let plot = self.plot(panel);
        match at {
            Some(at) => self.axes.draw(rec, &self.path, at, &plot)?,
            None => plot.draw(rec, &self.path, None)?,
        }
        let key = key(panel);
        if !key.is_empty() {
            plot.draw_legend(rec, &self.path, &key)?;
        }
        self.draw_layers(rec, at, &plot, &panel.layers)?;
        // A panel that changes with time updates its note each time, also to clear it.
        if at.is_some() {
            let middle = [0.5 * plot.width, 0.5 * plot.height];
            log(
                rec,
                &self.at(paths::PANEL_NOTE),
                at,
                &words(&panel.note, middle, style::POLE),
            )?;
        }
        if !panel.caption.is_empty() {
            let above = words(&panel.caption, [0.5 * plot.width, -36.0], style::AXIS);
            log(rec, &paths::caption(&self.path), at, &above)?;
        }
        Ok(())
    }

    /// Draws layers; layers with the same id form one entity.
    pub fn draw_layers(
        &mut self,
        rec: &RecordingStream,
        at: Option<Moment>,
        plot: &Plot,
        layers: &[Layer],
    ) -> Result<(), RecordError> {
        let mut entities: Vec<(&str, Entity)> = Vec::new();
        for (number, layer) in layers.iter().enumerate() {
            match &layer.shape {
                Shape::Image(image) => self.draw_image(rec, at, plot, &layer.id, image)?,
                Shape::Peaks(peaks) => self.draw_peaks(rec, at, plot, layer, peaks)?,
                _ => {
                    let place = entities.iter().position(|(id, _)| *id == layer.id);
                    let place = place.unwrap_or_else(|| {
                        entities.push((&layer.id, Entity::default()));
                        entities.len() - 1
                    });
                    entities[place].1.add(plot, layer, number as f32);
                }
            }
        }
        for (id, entity) in entities {
            entity.log(rec, &self.at(id), at)?;
        }
        Ok(())
    }

    fn at(&self, id: &str) -> String {
        format!("{}/{id}", self.path)
    }

    fn draw_image(
        &mut self,
        rec: &RecordingStream,
        at: Option<Moment>,
        plot: &Plot,
        id: &str,
        image: &Image,
    ) -> Result<(), RecordError> {
        let path = self.at(id);
        if image.pixels.is_empty() {
            // The size is logged again with the next image.
            self.image = None;
            return log(rec, &path, at, &Clear::flat());
        }
        let now = Some((image.size, image.palette.len()));
        if self.image != now {
            self.image = now;
            let classes = image.palette.iter().zip(0u16..).map(|(swatch, id)| {
                let [r, g, b] = swatch.dark;
                let color = rerun::Rgba32::from_rgb(r, g, b);
                rerun::ClassDescription::from((id, &*swatch.name, color))
            });
            let classes = AnnotationContext::new(classes.collect::<Vec<_>>());
            rec.log_static(&*path, &classes)?;
            let [left, top] = plot.at(image.x[0], image.y[1]);
            let [right, bottom] = plot.at(image.x[1], image.y[0]);
            let [columns, rows] = image.size.map(|side| side as f32);
            let scale = [(right - left) / columns, (bottom - top) / rows, 1.0];
            let place = Transform3D::from_translation([left, top, 0.0]).with_scale(scale);
            log(rec, &path, at, &place)?;
        }
        let size = image.size.map(|side| side as u32);
        let format = ImageFormat::segmentation(size, ChannelDatatype::U8);
        let picture = SegmentationImage::new(image.pixels.clone(), format)
            .with_opacity(1.0)
            .with_draw_order(-2.0);
        log(rec, &path, at, &picture)
    }

    fn draw_peaks(
        &self,
        rec: &RecordingStream,
        at: Option<Moment>,
        plot: &Plot,
        layer: &Layer,
        peaks: &[([f64; 2], String)],
    ) -> Result<(), RecordError> {
        let color = style::on_dark(layer.color);
        let tips: Vec<[f32; 2]> = peaks.iter().map(|([x, y], _)| plot.at(*x, *y)).collect();
        let points = Points2D::new(tips.iter().copied())
            .with_colors([color])
            .with_radii([Radius::new_ui_points(2.5)]);
        log(rec, &self.at(&layer.id), at, &points)?;
        let named = tips.iter().zip(peaks).map(|(tip, (_, name))| Named {
            tip: *tip,
            name: name.clone(),
        });
        let (names, stems) = names_and_stems(plot.width, named, color);
        log(rec, &self.at(paths::PANEL_NAMES), at, &names)?;
        log(rec, &self.at(paths::PANEL_STEMS), at, &stems)
    }
}

/// Labels of the layers with their colours.
fn key(panel: &Panel) -> Vec<(String, Color)> {
    let named = panel.layers.iter().filter(|layer| !layer.label.is_empty());
    let named = named.map(|layer| {
        (
            shown(&escape::line(&layer.label)),
            style::on_dark(layer.color),
        )
    });
    named.collect()
}

/// A text at a position; an empty text clears the current one.
fn words(text: &str, at: [f32; 2], color: Color) -> Points2D {
    let text = Some(shown(&escape::line(text))).filter(|text| !text.is_empty());
    Points2D::new(text.as_ref().map(|_| at))
        .with_colors(text.as_ref().map(|_| color))
        .with_labels(text.as_deref())
        .with_show_labels(true)
        .with_radii([Radius::new_ui_points(0.0)])
}

fn log(
    rec: &RecordingStream,
    path: &str,
    at: Option<Moment>,
    what: &dyn AsComponents,
) -> Result<(), RecordError> {
    match at {
        Some(at) => stream::log_at(rec, path, at, what),
        None => rec.log_static(path, what),
    }
}

impl Entity {
    /// Adds a layer; `number` is its drawing order.
    fn add(&mut self, plot: &Plot, layer: &Layer, number: f32) {
        let color = style::on_dark(layer.color);
        let place = |[x, y]: [f64; 2]| plot.at(x, y);
        let finite = |point: &&[f64; 2]| point.iter().all(|c| c.is_finite());
        self.order = number;
        match &layer.shape {
            Shape::Lines {
                strips,
                width,
                dashed,
            } => {
                self.radius = Some((ENLARGED * width) as f32);
                for strip in strips {
                    let strip = strip.iter().filter(finite).map(|point| place(*point));
                    let strip: Vec<[f32; 2]> = strip.collect();
                    match dashed {
                        true => self.add_strips(dashes(&strip), color),
                        false => self.add_strips([strip], color),
                    }
                }
            }
            Shape::Points {
                points,
                radius,
                marker,
                ..
            } => {
                let places = points.iter().filter(finite).map(|point| place(*point));
                // Smaller points are not visible on a screen.
                self.radius = Some((1.2 * radius).max(1.6) as f32);
                match marker {
                    Marker::Cross => self.add_strips(places.map(cross), color),
                    _ => self.add_points(places, color),
                }
            }
            Shape::Areas { outlines, .. } => {
                self.radius = Some(0.6);
                for outline in outlines {
                    let corners = outline.iter().chain(outline.first());
                    self.add_strips([corners.map(|point| place(*point)).collect()], color);
                }
            }
            Shape::Text(at, text) => {
                // The viewer centres a label at its position.
                let [x, y] = place(*at);
                let half = 0.5 * LETTER * text.chars().count() as f32 + GAP;
                self.add_points([[x + half, y - 13.0]], color);
                self.labels.push(escape::line(text).into_owned());
                (self.radius, self.written) = (Some(0.0), true);
            }
            Shape::Image(_) | Shape::Peaks(_) => {}
        }
    }

    fn add_strips(&mut self, strips: impl IntoIterator<Item = Vec<[f32; 2]>>, color: Color) {
        self.has_strips = true;
        // A line with a single point is skipped.
        for strip in strips.into_iter().filter(|strip| strip.len() > 1) {
            self.strips.push(strip);
            self.strip_colors.push(color);
        }
    }

    fn add_points(&mut self, points: impl IntoIterator<Item = [f32; 2]>, color: Color) {
        self.has_points = true;
        for point in points {
            self.points.push(point);
            self.point_colors.push(color);
        }
    }

    fn log(
        mut self,
        rec: &RecordingStream,
        path: &str,
        at: Option<Moment>,
    ) -> Result<(), RecordError> {
        if self.has_strips {
            let mut strips = LineStrips2D::new(std::mem::take(&mut self.strips))
                .with_colors(single(std::mem::take(&mut self.strip_colors)));
            if let Some(radius) = self.radius {
                let radius = Radius::new_ui_points(radius);
                strips = strips.with_radii([radius]).with_draw_order(self.order);
            }
            if !self.has_points && !self.labels.is_empty() {
                strips = strips.with_labels(std::mem::take(&mut self.labels));
            }
            log(rec, path, at, &strips)?;
        }
        if !self.has_points {
            return Ok(());
        }
        if self.labels.is_empty() {
            self.thin_out();
        }
        let mut points = Points2D::new(self.points).with_colors(single(self.point_colors));
        if let Some(radius) = self.radius {
            let radius = Radius::new_ui_points(radius);
            points = points.with_radii([radius]).with_draw_order(self.order);
        }
        if !self.labels.is_empty() {
            points = points.with_labels(self.labels);
        }
        if self.written {
            points = points.with_show_labels(true);
        }
        log(rec, path, at, &points)
    }

    /// Merges points within a quarter of a pixel.
    fn thin_out(&mut self) {
        let near = |[x, y]: [f32; 2]| [x, y].map(|c| (4.0 * c).round() as i32);
        let colored = self.points.iter().zip(&self.point_colors);
        let mut colored: Vec<([i32; 2], Color)> = colored.map(|(p, c)| (near(*p), *c)).collect();
        colored.sort_by_key(|(at, _)| *at);
        colored.dedup_by_key(|(at, _)| *at);
        self.points = colored
            .iter()
            .map(|(at, _)| at.map(|c| c as f32 / 4.0))
            .collect();
        self.point_colors = colored.into_iter().map(|(_, color)| color).collect();
    }
}

/// A single colour if all are equal.
fn single(mut colors: Vec<Color>) -> Vec<Color> {
    if colors.iter().all(|color| Some(color) == colors.first()) {
        colors.truncate(1);
    }
    colors
}

/// A cross as one polyline through its centre, so that it has one label.
fn cross([x, y]: [f32; 2]) -> Vec<[f32; 2]> {
    let ends = [
        [-1.0, -1.0],
        [1.0, 1.0],
        [0.0, 0.0],
        [-1.0, 1.0],
        [1.0, -1.0],
    ];
    let ends = ends.map(|[right, down]| [x + CROSS * right, y + CROSS * down]);
    ends.to_vec()
}

/// The dashes of a dashed line.
fn dashes(line: &[[f32; 2]]) -> Vec<Vec<[f32; 2]>> {
    let strokes = line.windows(2).flat_map(|pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        let length = (x1 - x0).hypot(y1 - y0);
        let count = (length / (STROKE + GAP)).ceil() as u32;
        (0..count).map(move |k| {
            let from = k as f32 * (STROKE + GAP);
            let ends = [from, (from + STROKE).min(length)].map(|along| along / length);
            let ends = ends.map(|share| [x0 + share * (x1 - x0), y0 + share * (y1 - y0)]);
            ends.to_vec()
        })
    });
    strokes.collect()
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

    #[test]
    fn overlapping_points_are_merged() {
        let mut entity = Entity::default();
        let color = style::on_dark(crate::plot::Color::Ink);
        entity.add_points([[1.0, 1.0], [1.05, 1.0], [2.0, 1.0]], color);
        entity.thin_out();
        assert_eq!(entity.points, [[1.0, 1.0], [2.0, 1.0]]);
        assert_eq!(single(entity.point_colors), [color]);
    }
}
