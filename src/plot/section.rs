//! The Poincaré section, its return map, and the times between its crossings.
//!
//! A periodic motion has one or a few points, a torus a closed curve, chaos a scattered set. The return map shows each
//! intersection over the previous one; points on the diagonal are periodic. The times between crossings are those of a
//! clock for a periodic motion, and spread for others.

use super::{Axis, Color, Layer, Panel, Unit, letter, range_shown, round_up, units};
use crate::analysis::{poincare::return_map, stats::range};
use crate::pipeline::message::{Header, Subject};
use crate::scene::StateCoordinate;

/// Width of the axes over the range of the intersections.
const MARGIN: f64 = 1.2;
/// Smallest half-width of an axis over the amplitude of the motion, so that a periodic motion appears as a point.
const LEAST_SHARE: f64 = 0.15;
/// An axis is fitted again if it is this many times too wide.
const OUTGROWN: f64 = 2.0;
/// Smallest and largest number of bins of a histogram: about the square root of the number of values.
const BINS: [usize; 2] = [13, 61];
/// One in this many times at each end does not determine the axis of the histogram: pauses between events would
/// stretch it.
const RARE: usize = 25;

/// A coordinate with an axis that is kept as long as it fits, so that the plot does not jump.
#[derive(Clone, Debug, PartialEq)]
struct Coordinate {
    name: String,
    /// Unit of the values, without a prefix.
    unit: String,
    /// Mean of the motion, and half-width of the axis without values.
    middle: f64,
    smallest: f64,
    range: [f64; 2],
}

impl Coordinate {
    fn new(name: impl Into<String>, unit: &str, [middle, smallest]: [f64; 2]) -> Self {
        Self {
            name: name.into(),
            unit: unit.to_owned(),
            middle,
            smallest,
            range: [middle; 2],
        }
    }

    /// Half-width of an axis for values from `low` to `high`, at least a fraction of the motion.
    fn half_width(&self, [low, high]: [f64; 2]) -> f64 {
        if low > high {
            return self.smallest;
        }
        let motion = (low - self.middle).abs().max((high - self.middle).abs());
        let spread = 0.5 * MARGIN * (high - low);
        spread.max(LEAST_SHARE * motion).max(self.smallest)
    }

    /// Fits the axis to values from `low` to `high`.
    fn fit(&mut self, [low, high]: [f64; 2], half: f64) {
        let [from, to] = self.range;
        let serves = from <= low && high <= to && to - from <= 2.0 * OUTGROWN * half;
        if low > high {
            self.range = [self.middle - half, self.middle + half];
        } else if !serves {
            let centre = 0.5 * (low + high);
            self.range = [centre - half, centre + half];
        }
    }
}

/// The axes of Poincaré sections, their return maps and return times: square, and as small as possible.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionAxes {
    coordinates: [Coordinate; 2],
    time: Coordinate,
}

impl SectionAxes {
    /// The axes of a delay section of samples with a symbol and a unit, about a middle, and with a smallest half-width.
    pub fn delayed(letter: &str, unit: &str, span: [f64; 2]) -> Self {
        let names = [format!("{letter}(t)"), format!("{letter}(t + 2τ)")];
        Self::new(names.map(|name| Coordinate::new(name, unit, span)))
    }

    /// The axes of the section of a run.
    pub fn of_run(header: &Header) -> Self {
        let [unit, _] = units(&header.subject);
        let mode = |index: usize| {
            let mode = header.joint().and_then(|joint| joint.modes.get(index));
            mode.map_or_else(|| format!("mode {index}"), |mode| mode.label.clone())
        };
        let letter = letter(&header.subject);
        let small = matches!(header.subject, Subject::Small(_));
        let span = match &header.subject {
            Subject::Joint(_) | Subject::Small(_) => [0.0, 1e-12],
            Subject::Signal(signal) => range_shown(signal.span),
        };
        let names = match header.section() {
            None => [format!("{letter}(t)"), format!("{letter}(t + 2τ)")].map(|name| (name, unit)),
            Some(shown) => shown.map(|coordinate| match coordinate {
                // The modal coordinate of a mass of 1 kg is the displacement.
                StateCoordinate::Q(_) if small => ("x".to_owned(), "m"),
                StateCoordinate::Qdot(_) if small => ("dx/dt".to_owned(), "m/s"),
                StateCoordinate::Q(index) => (format!("q, {}", mode(index)), "√kg m"),
                StateCoordinate::Qdot(index) => (format!("dq/dt, {}", mode(index)), "√kg m/s"),
            }),
        };
        Self::new(names.map(|(name, unit)| Coordinate::new(name, unit, span)))
    }

    fn new(coordinates: [Coordinate; 2]) -> Self {
        let time = Coordinate::new("time between crossings", "s", [0.0, 1e-12]);
        Self { coordinates, time }
    }

    /// Fits the axes to the intersections, but at least to a fraction of the motion, so that a periodic motion appears as
    /// a point. Two axes of the same quantity have the same scale.
    pub fn fit<'a>(&mut self, points: impl Iterator<Item = &'a [f64; 2]> + Clone) {
        let spans = [0, 1].map(|c| range(points.clone().map(|point| point[c])));
        let halves = [0, 1].map(|c| self.coordinates[c].half_width(spans[c]));
        let alike = self.coordinates[0].unit == self.coordinates[1].unit;
        let largest = halves[0].max(halves[1]);
        for (c, coordinate) in self.coordinates.iter_mut().enumerate() {
            coordinate.fit(spans[c], if alike { largest } else { halves[c] });
        }
    }

    /// Name and unit of each coordinate.
    pub fn names(&self) -> [[&str; 2]; 2] {
        let names = self.coordinates.each_ref();
        names.map(|own| [&*own.name, &*own.unit])
    }

    /// The axis of a coordinate. Coordinates of the same quantity have the same unit, in the return map, too.
    fn axis(&self, own: &Coordinate, suffix: &str) -> Axis {
        let all = self.coordinates.iter().chain([&self.time]);
        let alike = all.filter(|other| other.unit == own.unit);
        let reach = alike.flat_map(|other| other.range).map(f64::abs);
        let axis = Axis::linear(format!("{}{suffix}", own.name), own.range);
        axis.written_in(Unit::of(&own.unit, reach.fold(0.0, f64::max)))
    }

    /// The section: intersections, oldest first.
    pub fn section(&self, points: &[[f64; 2]], color: Color) -> Panel {
        let [x, y] = self.coordinates.each_ref().map(|own| self.axis(own, ""));
        let cloud = cloud(points.to_vec(), color);
        Panel::new("Poincaré section", x, y, vec![cloud]).square()
    }

    /// The return map of the first coordinate.
    pub fn return_map(&self, points: &[[f64; 2]], color: Color) -> Panel {
        let x = self.axis(&self.coordinates[0], " at an intersection");
        let y = self.axis(&self.coordinates[0], " at the next");
        let values: Vec<f64> = points.iter().map(|point| point[0]).collect();
        let ends = x.range.map(|end| [end; 2]).to_vec();
        let diagonal = Layer::line(ends, Color::Pale).with_id("diagonal");
        let layers = vec![diagonal, cloud(return_map(&values), color)];
        Panel::new("return map", x, y, layers).square()
    }

    /// Histogram of the times between crossings, for their times in s in ascending order.
    pub fn return_times(&mut self, times: &[f64], color: Color) -> Panel {
        let mut returns: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        returns.sort_by(f64::total_cmp);
        let (all, rare) = (returns.len(), returns.len() / RARE);
        let span = range(returns[rare..all - rare].iter().copied());
        self.time.fit(span, self.time.half_width(span));
        let mut x = self.axis(&self.time, "");
        x.range[0] = x.range[0].max(0.0);
        let [low, high] = x.range;
        returns.retain(|time| (low..=high).contains(time));
        // An odd number: neither the middle of the axis nor the ends of the data are edges, at which rounding would divide
        // equal times.
        let bins = returns.len().isqrt().clamp(BINS[0], BINS[1]) | 1;
        let width = (high - low) / bins as f64;
        let mut counts = vec![0.0; bins];
        for time in &returns {
            let bin = ((time - low) / width) as usize;
            counts[bin.min(bins - 1)] += 1.0;
        }
        let most = counts.iter().copied().fold(1.0, f64::max);
        let bars = counts.iter().enumerate().filter(|(_, count)| **count > 0.0);
        let bars = bars.map(|(bin, &count)| {
            let [left, right] = [bin, bin + 1].map(|edge| low + width * edge as f64);
            vec![[left, 0.0], [right, 0.0], [right, count], [left, count]]
        });
        let bars = Layer::areas(bars.collect(), 0.6, color).with_id("bars");
        let y = Axis::linear("number of crossings", [0.0, round_up(1.05 * most)]);
        let panel = Panel::new("times between crossings", x, y, vec![bars]);
        match all - returns.len() {
            _ if all == 0 => panel.with_note("fewer than two crossings"),
            0 => panel,
            outside => panel.with_caption(format!("outside the axis: {outside} of {all}")),
        }
    }
}

/// Points that fade with age, oldest first. A few must be visible, many must not overlap.
fn cloud(points: Vec<[f64; 2]>, color: Color) -> Layer {
    let radius = if points.len() > 500 { 1.1 } else { 1.8 };
    Layer {
        fading: true,
        ..Layer::points(points, radius, color)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_the_same_scale_and_contain_all_intersections() {
        let mut axes = SectionAxes::delayed("u", "m", [0.0, 1e-12]);
        let points = [[1e-6, -2e-6], [1e-6, -4e-6]];
        axes.fit(points.iter());
        let panel = axes.section(&points, Color::Ink);
        // The second coordinate has a range of 2 µm; the margin is the same on both axes.
        for (axis, low, high) in [(&panel.x, 1.0, 1.0), (&panel.y, -4.0, -2.0)] {
            let [from, to] = axis.range.map(|end| 1e6 * end);
            assert!((0.5 * (from + to) - 0.5 * (low + high)).abs() < 1e-9);
            assert!((0.5 * (to - from) - MARGIN).abs() < 1e-9);
        }
        assert_eq!(
            [panel.x.label(), panel.y.label()],
            ["u(t), µm", "u(t + 2τ), µm"]
        );
        // Points within the axes keep them; a point outside changes them.
        let before = axes.clone();
        axes.fit([[1e-6, -2.2e-6], [1e-6, -3.8e-6]].iter());
        assert_eq!(axes, before);
        axes.fit([[5e-6, -2e-6]].iter());
        assert_ne!(axes, before);
    }

    /// A small motion far from zero on one axis, near zero on the other.
    #[test]
    fn axes_of_one_quantity_have_one_unit() {
        let mut axes = SectionAxes::delayed("u", "m", [0.0, 1e-12]);
        let points = [[1e-9, 4e-6], [2e-9, 4.1e-6]];
        axes.fit(points.iter());
        let panel = axes.section(&points, Color::Ink);
        assert_eq!([panel.x.unit.symbol, panel.y.unit.symbol], ["µm", "µm"]);
        let map = axes.return_map(&points, Color::Ink);
        assert_eq!([map.x.unit.symbol, map.y.unit.symbol], ["µm", "µm"]);
    }

    /// The histogram of a period-2 motion has two bars of equal height, and that of a clock one.
    #[test]
    fn return_times_are_counted() {
        let bars = |returns: [f64; 2]| {
            let mut time = 0.0;
            let times = (0..101).map(|k| {
                time += returns[k % 2];
                time
            });
            let mut axes = SectionAxes::delayed("u", "m", [0.0, 1e-12]);
            let panel = axes.return_times(&times.collect::<Vec<_>>(), Color::Ink);
            let crate::plot::Shape::Areas(outlines) = &panel.layers[0].shape else {
                panic!("bars are areas");
            };
            let bar =
                |corners: &Vec<[f64; 2]>| (1e6 * corners[0][0], 1e6 * corners[1][0], corners[2][1]);
            (
                panel.x.label(),
                outlines.iter().map(bar).collect::<Vec<_>>(),
            )
        };
        let (axis, two) = bars([2e-4, 3e-4]);
        assert_eq!(axis, "time between crossings, µs");
        assert_eq!((two.len(), two[0].2, two[1].2), (2, 50.0, 50.0));
        assert!(two[0].0 <= 200.0 && 200.0 <= two[0].1, "{two:?}");
        assert!(two[1].0 <= 300.0 && 300.0 <= two[1].1, "{two:?}");
        // Times of very different lengths: the axis has no negative times.
        let (_, two) = bars([1e-5, 1e-3]);
        assert!(two.len() == 2 && two[0].0 >= 0.0, "{two:?}");
        let (_, one) = bars([2.5e-4, 2.5e-4]);
        assert_eq!((one.len(), one[0].2), (1, 100.0), "{one:?}");
    }

    /// Three bursts of a clock: the pauses are counted, but do not stretch the axis.
    #[test]
    fn pauses_do_not_stretch_the_axis_of_return_times() {
        let bursts =
            (0..3).flat_map(|burst| (0..50).map(move |k| [f64::from(burst), f64::from(k)]));
        let times: Vec<f64> = bursts.map(|[burst, k]| 2.0 * burst + 1e-3 * k).collect();
        let mut axes = SectionAxes::delayed("u", "m", [0.0, 1e-12]);
        let panel = axes.return_times(&times, Color::Ink);
        let [low, high] = panel.x.range;
        assert!(low > 0.0 && low < 1e-3 && high > 1e-3 && high < 2e-3);
        assert_eq!(panel.caption, "outside the axis: 2 of 149");
    }
}
