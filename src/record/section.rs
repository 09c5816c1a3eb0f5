//! The Poincaré section and its return map; the latest intersections are the brightest.
//!
//! A periodic motion has one or a few points, a torus a closed curve, chaos a scattered set. The return map
//! shows each intersection over the previous one; points on the diagonal are periodic.

use std::collections::VecDeque;

use rerun::{LineStrips2D, Points2D, Radius};

use super::{
    error::RecordError,
    paths,
    plot::{Axes, Bounds, Plot},
    portrait,
    redraw::RedrawTimer,
    stream::{self, RecordingStream},
    style::{self, Quantity},
};
use crate::{
    analysis::range,
    pipeline::message::{Header, SectionCoordinate, SectionPoint, Subject},
    plot::Axis,
};

/// Number of intersections shown; a 4 kHz squeak has 1,000 in 0.25 s.
const PASSAGES: usize = 600;
/// Width of the axes over the range of the intersections.
const MARGIN: f64 = 1.2;
/// Smallest half-width of an axis over the amplitude of the motion.
const LEAST_SHARE: f64 = 0.15;
/// An axis is fitted again if it is this many times too wide.
const OUTGROWN: f64 = 2.0;
/// Side of both plot areas, pixels.
const SIDE: f32 = 400.0;

/// Draws intersections.
#[derive(Debug)]
pub struct Section {
    coordinates: [Coordinate; 2],
    /// The latest intersections, oldest first.
    recent: VecDeque<[f64; 2]>,
    /// Axes of the section and of its return map.
    axes: [Axes; 2],
    /// Limits the redraw rate.
    pub redraw: RedrawTimer,
}

/// One coordinate of the section, with its axis.
#[derive(Debug)]
struct Coordinate {
    name: String,
    quantity: Quantity,
    /// Mean of the motion, and smallest half-width of the axis.
    middle: f64,
    smallest: f64,
    /// Both ends of the axis.
    range: [f64; 2],
}

impl Coordinate {
    fn new(header: &Header, coordinate: SectionCoordinate) -> Self {
        let mode = |index: usize| {
            let mode = header.joint().and_then(|joint| joint.modes.get(index));
            mode.map_or_else(|| format!("mode {index}"), |mode| mode.label.clone())
        };
        let letter = style::letter(&header.subject);
        let small = matches!(header.subject, Subject::Small(_));
        let (name, quantity) = match coordinate {
            SectionCoordinate::Delayed(0) => (format!("{letter}(t)"), None),
            SectionCoordinate::Delayed(1) => (format!("{letter}(t + τ)"), None),
            SectionCoordinate::Delayed(n) => (format!("{letter}(t + {n}τ)"), None),
            // The modal coordinate of a mass of 1 kg is the displacement.
            SectionCoordinate::Q(_) if small => ("x".to_owned(), Some(Quantity::Length)),
            SectionCoordinate::Qdot(_) if small => ("dx/dt".to_owned(), Some(Quantity::Speed)),
            SectionCoordinate::Q(index) => (format!("q, {}", mode(index)), Some(Quantity::Modal)),
            SectionCoordinate::Qdot(index) => (
                format!("dq/dt, {}", mode(index)),
                Some(Quantity::ModalSpeed),
            ),
        };
        let (middle, smallest) = match &header.subject {
            Subject::Joint(_) | Subject::Small(_) => (0.0, 1e-12),
            Subject::Signal(signal) => style::range_shown(signal.span),
        };
        Self {
            name,
            quantity: quantity.unwrap_or_else(|| Quantity::displacement(&header.subject)),
            middle,
            smallest,
            range: [middle; 2],
        }
    }

    /// Half-width of an axis for values from `low` to `high`, at least a fraction of the motion.
    fn half_width(&self, [low, high]: [f64; 2]) -> f64 {
        let motion = (low - self.middle).abs().max((high - self.middle).abs());
        let spread = 0.5 * MARGIN * (high - low);
        spread.max(LEAST_SHARE * motion).max(self.smallest)
    }

    /// Fits the axis. An axis that still fits is kept, so that the plot does not jump.
    fn fit(&mut self, [low, high]: [f64; 2], half: f64) {
        let [from, to] = self.range;
        let serves = from <= low && high <= to && to - from <= 2.0 * OUTGROWN * half;
        if !serves {
            let centre = 0.5 * (low + high);
            self.range = [centre - half, centre + half];
        }
    }

    /// The axis, and the factor from SI to its unit.
    fn axis(&self, suffix: &str) -> (Axis, f64) {
        let [low, high] = self.range;
        let unit = self.quantity.unit(low.abs().max(high.abs()));
        let name = style::with_unit(&format!("{}{suffix}", self.name), &unit.symbol);
        let axis = Axis::linear(name, [low, high].map(|end| unit.per_si * end));
        (axis, unit.per_si)
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
            redraw: RedrawTimer::default(),
        })
    }

    /// Bounds of both views.
    pub fn bounds() -> Bounds {
        let axis = || Axis::linear("", [-1.0, 1.0]);
        plot(axis(), axis()).bounds()
    }

    /// Adds intersections, complete up to `time` (s).
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
        if !self.redraw.is_due(time) {
            return Ok(());
        }
        self.scale();
        self.draw_section(rec, time)?;
        self.draw_map(rec, time)
    }

    /// Fits the axes to the intersections, but at least to a fraction of the motion, so that a periodic
    /// motion appears as a point. Two axes of the same quantity have the same scale.
    fn scale(&mut self) {
        let spans: [[f64; 2]; 2] =
            std::array::from_fn(|c| range(self.recent.iter().map(|point| point[c])));
        let halves: [f64; 2] = std::array::from_fn(|c| self.coordinates[c].half_width(spans[c]));
        let alike = self.coordinates[0].quantity == self.coordinates[1].quantity;
        let largest = halves[0].max(halves[1]);
        for (c, coordinate) in self.coordinates.iter_mut().enumerate() {
            coordinate.fit(spans[c], if alike { largest } else { halves[c] });
        }
    }

    fn draw_section(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let [(x, x_unit), (y, y_unit)] = self.coordinates.each_ref().map(|c| c.axis(""));
        let plot = plot(x, y);
        self.axes[0].draw(rec, paths::SECTION, time, &plot)?;
        let points = self.recent.iter();
        let points = points.map(|[x, y]| plot.at(x_unit * x, y_unit * y));
        draw_cloud(rec, paths::SECTION_POINTS, time, points)
    }

    fn draw_map(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let coordinate = &self.coordinates[0];
        let (x, unit) = coordinate.axis(" at an intersection");
        let (y, _) = coordinate.axis(" at the next");
        let plot = plot(x, y);
        self.axes[1].draw(rec, paths::RETURN_MAP, time, &plot)?;
        let pairs = self.recent.iter().zip(self.recent.iter().skip(1));
        let points = pairs.map(|(one, next)| plot.at(unit * one[0], unit * next[0]));
        draw_cloud(rec, paths::RETURN_MAP_POINTS, time, points)
    }
}

/// Draws points that fade with age, oldest first.
fn draw_cloud(
    rec: &RecordingStream,
    path: &str,
    time: f64,
    points: impl ExactSizeIterator<Item = [f32; 2]>,
) -> Result<(), RecordError> {
    let count = points.len();
    let points = Points2D::new(points)
        .with_colors((1..=count).map(|k| portrait::fade(style::SIGNAL, k, count)))
        .with_radii([Radius::new_ui_points(1.8)]);
    stream::log_at(rec, path, time, &points)
}

fn plot(x: Axis, y: Axis) -> Plot {
    Plot {
        width: SIDE,
        height: SIDE,
        top_margin: 0.0,
        x,
        y,
        grid: true,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rerun::log::LogMsg;

    use super::*;
    use crate::record::stream::MessageSink;
    use crate::record::tests::demo;

    /// A sink that keeps nothing.
    struct Discarded;

    impl MessageSink for Discarded {
        fn send(&self, _: LogMsg) {}
    }

    #[test]
    fn axes_have_the_same_scale_and_contain_the_latest_intersections() {
        let rec = RecordingStream::new("test", Arc::new(Discarded)).unwrap();
        let mut section = Section::new(&rec, &demo::header(0.1)).unwrap();
        let point = |k: usize| SectionPoint {
            time: 1e-4 * k as f64,
            at: [1e-7, -2e-7 * (1.0 + (k % 2) as f64)],
        };
        let points: Vec<_> = (0..2 * PASSAGES).map(point).collect();
        section.push(&rec, 0.05, &points[..PASSAGES + 5]).unwrap();
        assert_eq!(section.recent.len(), PASSAGES);
        let [x, y] = section.coordinates.each_ref().map(|c| c.axis("").0);
        // The second coordinate has a range of 0.2 µm; the margin is the same on both axes.
        for (axis, low, high) in [(&x, 0.1, 0.1), (&y, -0.4, -0.2)] {
            let [from, to] = axis.range;
            let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
            assert!((centre - 0.5 * (low + high)).abs() < 1e-12);
            assert!((half - 0.1 * MARGIN).abs() < 1e-12);
        }
        // A point within the axes keeps them; a point outside changes them.
        let drawn = section.coordinates[0].range;
        section.push(&rec, 0.06, &points[..1]).unwrap();
        assert_eq!(section.coordinates[0].range, drawn);
        let stray = SectionPoint {
            time: 0.06,
            at: [5e-7, -2e-7],
        };
        section.push(&rec, 0.07, &[stray]).unwrap();
        let [low, high] = section.coordinates[0].range;
        assert!(low < 1e-7 && 5e-7 < high && [low, high] != drawn);
        assert_eq!([x.label(), y.label()], ["u(t), µm", "u(t + 2τ), µm"]);
    }

    #[test]
    fn modal_coordinates_have_separate_axes() {
        let rec = RecordingStream::new("test", Arc::new(Discarded)).unwrap();
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
        let names = section.coordinates.each_ref().map(|c| c.axis("").0.label());
        assert_eq!(
            names,
            ["q, 2nd bending x, √kg µm", "dq/dt, 2nd bending x, √kg mm/s"]
        );
    }
}
