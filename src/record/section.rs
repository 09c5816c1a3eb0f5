//! The Poincare section and its return map: passages as points, the newest brightest.
//!
//! A tone passes at one point (or a few), a torus along a closed curve, chaos all over a cloud.
//! The return map sets each passage against the one before: points on the diagonal repeat.

use std::collections::VecDeque;

use rerun::{LineStrips2D, Points2D, Radius, RecordingStream};

use super::{
    error::RecordError,
    paths,
    plot::{Axes, Axis, Bounds, Plot},
    portrait, stream,
    style::{self, FullScale, Quantity},
};
use crate::pipeline::message::{Header, SectionCoordinate, SectionPoint, Subject};

/// Passages on show: a quarter of a second of a squeak at 4 kHz would be a thousand.
const PASSAGES: usize = 600;
/// Side of both fields, pixels.
const SIDE: f32 = 400.0;

/// Draws passages.
#[derive(Debug)]
pub struct Section {
    coordinates: [Coordinate; 2],
    /// The newest passages, oldest first.
    recent: VecDeque<[f64; 2]>,
    /// Axes of the section and of its return map.
    axes: [Axes; 2],
}

/// How one coordinate is drawn.
#[derive(Debug)]
struct Coordinate {
    name: String,
    quantity: Quantity,
    /// The value in the middle of the axis, and the smallest range to either side of it.
    middle: f64,
    smallest: f64,
    scale: FullScale,
    /// Whether the axis goes below the middle, and above it.
    sides: [bool; 2],
}

impl Coordinate {
    fn new(header: &Header, coordinate: SectionCoordinate) -> Self {
        let mode = |index: usize| {
            let mode = header.joint().and_then(|joint| joint.modes.get(index));
            mode.map_or_else(|| format!("mode {index}"), |mode| mode.label.clone())
        };
        let letter = style::letter(&header.subject);
        let (name, quantity) = match coordinate {
            SectionCoordinate::Delayed(0) => (format!("{letter}(t)"), None),
            SectionCoordinate::Delayed(1) => (format!("{letter}(t + τ)"), None),
            SectionCoordinate::Delayed(n) => (format!("{letter}(t + {n}τ)"), None),
            SectionCoordinate::Q(index) => (format!("q, {}", mode(index)), Some(Quantity::Modal)),
            SectionCoordinate::Qdot(index) => (
                format!("dq/dt, {}", mode(index)),
                Some(Quantity::ModalSpeed),
            ),
        };
        let (middle, smallest) = match &header.subject {
            Subject::Joint(_) => (0.0, 1e-12),
            Subject::Signal(signal) => style::range_shown(signal.span),
        };
        Self {
            name,
            quantity: quantity.unwrap_or_else(|| Quantity::displacement(&header.subject)),
            middle,
            smallest,
            scale: FullScale::new(smallest),
            sides: [true; 2],
        }
    }

    /// The axis, and how many of its units make an SI unit.
    fn axis(&self, suffix: &str) -> (Axis, f64) {
        let full = self.scale.get();
        let unit = self.quantity.unit(full);
        let name = style::with_unit(&format!("{}{suffix}", self.name), &unit.symbol);
        let [below, above] = self.sides.map(|side| if side { full } else { 0.0 });
        let [low, high] = [-below, above].map(|part| unit.per_si * (self.middle + part));
        (Axis::linear(name, low, high, 4), unit.per_si)
    }
}

impl Section {
    /// Starts empty; draws the diagonal of the return map.
    pub fn new(rec: &RecordingStream, header: &Header) -> Result<Self, RecordError> {
        let diagonal = LineStrips2D::new([[[0.0, SIDE], [SIDE, 0.0]]])
            .with_colors([style::RULER])
            .with_radii([Radius::new_ui_points(0.8)])
            .with_draw_order(-1.0);
        rec.log_static(paths::RETURN_MAP_DIAGONAL, &diagonal)?;
        Ok(Self {
            coordinates: header.section.map(|c| Coordinate::new(header, c)),
            recent: VecDeque::with_capacity(PASSAGES),
            axes: Default::default(),
        })
    }

    /// What both views must show.
    pub fn bounds() -> Bounds {
        let axis = || Axis::linear("", -1.0, 1.0, 1);
        plot(axis(), axis()).bounds()
    }

    /// Takes passages, complete up to `time` (s).
    pub fn push(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        points: &[SectionPoint],
    ) -> Result<(), RecordError> {
        if points.is_empty() {
            return Ok(());
        }
        self.recent.extend(points.iter().map(|point| point.at));
        let surplus = self.recent.len().saturating_sub(PASSAGES);
        self.recent.drain(..surplus);
        self.scale();
        self.draw_section(rec, time)?;
        self.draw_map(rec, time)
    }

    /// Fits the axes. They show the size of the motion, not only the spread of the passages: the
    /// passages of a tone must look like a point. Half the field is not wasted, though, where all
    /// passages are on one side; and where both axes measure the same they have the same scale.
    fn scale(&mut self) {
        let spans: [[f64; 2]; 2] = std::array::from_fn(|c| {
            let middle = self.coordinates[c].middle;
            let values = || self.recent.iter().map(|point| point[c] - middle);
            [
                values().fold(0.0, f64::min).abs(),
                values().fold(0.0, f64::max),
            ]
        });
        let peaks = spans.map(|[below, above]| below.max(above));
        let sides = spans.map(|span| {
            let least = 0.02 * span[0].max(span[1]);
            span.map(|side| side > least)
        });
        let both = sides.contains(&[true; 2]) || sides.contains(&[false; 2]);
        let alike = self.coordinates[0].quantity == self.coordinates[1].quantity;
        for (c, coordinate) in self.coordinates.iter_mut().enumerate() {
            let peak = if alike {
                peaks[0].max(peaks[1])
            } else {
                peaks[c]
            };
            coordinate.scale.update(peak, coordinate.smallest);
            coordinate.sides = if both { [true; 2] } else { sides[c] };
        }
    }

    fn draw_section(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let [(x, x_unit), (y, y_unit)] = self.coordinates.each_ref().map(|c| c.axis(""));
        let plot = plot(x, y);
        self.axes[0].draw(rec, paths::SECTION_AXES, time, &plot)?;
        let points = self.recent.iter();
        let points = points.map(|[x, y]| plot.at(x_unit * x, y_unit * y));
        draw_cloud(rec, paths::SECTION_POINTS, time, points)
    }

    fn draw_map(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let coordinate = &self.coordinates[0];
        let (x, unit) = coordinate.axis(" at one passage");
        let (y, _) = coordinate.axis(" at the next");
        let plot = plot(x, y);
        self.axes[1].draw(rec, paths::RETURN_MAP_AXES, time, &plot)?;
        let pairs = self.recent.iter().zip(self.recent.iter().skip(1));
        let points = pairs.map(|(one, next)| plot.at(unit * one[0], unit * next[0]));
        draw_cloud(rec, paths::RETURN_MAP_POINTS, time, points)
    }
}

/// Points that fade with age, oldest first.
fn draw_cloud(
    rec: &RecordingStream,
    path: &str,
    time: f64,
    points: impl ExactSizeIterator<Item = [f32; 2]>,
) -> Result<(), RecordError> {
    let count = points.len();
    let points = Points2D::new(points)
        .with_colors((1..=count).map(|k| portrait::fade(k, count)))
        .with_radii([Radius::new_ui_points(1.8)]);
    stream::log_at(rec, path, time, &points)
}

fn plot(x: Axis, y: Axis) -> Plot {
    Plot {
        width: SIDE,
        height: SIDE,
        head: 0.0,
        x,
        y,
        grid: true,
    }
}

#[cfg(test)]
mod tests {
    use rerun::RecordingStreamBuilder;

    use super::*;
    use crate::record::demo;

    #[test]
    fn axes_are_alike_and_hold_the_newest_passages() {
        let (rec, _) = RecordingStreamBuilder::new("test").memory().unwrap();
        let mut section = Section::new(&rec, &demo::header(0.1)).unwrap();
        let point = |k: usize| SectionPoint {
            time: 1e-4 * k as f64,
            at: [1e-7, -2e-7 * (1.0 + (k % 2) as f64)],
        };
        let points: Vec<_> = (0..2 * PASSAGES).map(point).collect();
        section.push(&rec, 0.05, &points[..PASSAGES + 5]).unwrap();
        assert_eq!(section.recent.len(), PASSAGES);
        let [x, y] = section.coordinates.each_ref().map(|c| c.axis("").0);
        // The first is always above zero and the second below: the other halves are left out.
        assert_eq!((x.low, y.high), (0.0, 0.0));
        assert_eq!(x.high, -y.low);
        assert!((x.high - 0.4).abs() < 1e-12);
        assert_eq!(
            (x.name.as_str(), y.name.as_str()),
            ("u(t), µm", "u(t + 2τ), µm")
        );
    }

    #[test]
    fn modal_coordinates_have_axes_of_their_own() {
        let (rec, _) = RecordingStreamBuilder::new("test").memory().unwrap();
        let header = Header {
            section: [SectionCoordinate::Q(2), SectionCoordinate::Qdot(2)],
            ..demo::header(0.1)
        };
        let mut section = Section::new(&rec, &header).unwrap();
        let points = [SectionPoint {
            time: 0.0,
            at: [3e-7, 5e-3],
        }];
        section.push(&rec, 0.05, &points).unwrap();
        let names = section.coordinates.each_ref().map(|c| c.axis("").0.name);
        assert_eq!(
            names,
            ["q, 2nd bending x, √kg µm", "dq/dt, 2nd bending x, √kg mm/s"]
        );
    }
}
