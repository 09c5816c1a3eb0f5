//! The scales that the pictures of a sweep share, so that they can be compared: those of all points,
//! and those of the points at one value.

use super::{
    ladder::Ladder,
    view::{ResponseView, StartView, SweepView},
};
use crate::{
    analysis::{Regime, range},
    record::{
        plot::{Axis, CAPTION_HEIGHT, Plot},
        spectrum::SpectrumPlot,
        style::{Quantity, Unit, round_up},
    },
};

/// Fields of the diagram and of the section, pixels.
const DIAGRAM: [f32; 2] = [560.0, 300.0];
const SECTION: f32 = 400.0;
/// Decades of a spectrum on show.
const DECADES: i32 = 7;
/// Lines weaker than this share of the strongest need not be on show.
const WEAK: f64 = 3e-3;
/// Frequencies on show are whole multiples of this, Hz.
const FREQUENCY_STEP: f64 = 2.5e3;
/// Smallest full scale of a portrait, as a share of that of the largest motion of the sweep: what
/// is silent beside the others looks silent.
const LEAST_SHARE: f64 = 0.01;
/// Smallest amplitude (m) and speed (m/s) ever shown.
const SMALLEST: [f64; 2] = [1e-12, 1e-8];
/// Intervals (1/s) of exponents are shown so far to either side, and no exponent below the last:
/// one that was hardly averaged would hide all others.
const INTERVAL: f64 = 40.0;
const LOWEST_EXPONENT: f64 = -250.0;

/// What all points share.
#[derive(Clone, Debug)]
pub struct Scope {
    /// The timeline.
    pub ladder: Ladder,
    /// The plot of the maxima over the parameter, and the unit of the maxima.
    pub diagram: (Plot, Unit),
    /// The plot of spectra.
    pub spectrum: SpectrumPlot,
    /// How many exponents there are at the most.
    pub exponents: usize,
    /// The ends of the exponents' axis, 1/s.
    pub exponent_range: [f64; 2],
    /// The largest displacement (m) and speed (m/s).
    largest: [f64; 2],
    /// Letter of the displacement.
    letter: &'static str,
}

/// All responses of some starts.
fn responses(starts: &[StartView]) -> impl Iterator<Item = &ResponseView> {
    let points = starts.iter().flat_map(|start| &start.points);
    points.filter_map(|point| point.outcome.as_ref().ok())
}

impl Scope {
    /// That of a sweep.
    pub fn new(sweep: &SweepView) -> Self {
        let found = || responses(&sweep.starts);
        let largest = found()
            .map(largest)
            .fold(SMALLEST, |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let spectra = found().filter_map(|response| response.exponents.as_ref());
        Self {
            ladder: Ladder::new(&sweep.parameter, &sweep.values),
            diagram: diagram(sweep, largest[0]),
            spectrum: spectrum(sweep, largest[0]),
            exponents: spectra.map(|s| s.exponents.len()).max().unwrap_or(0),
            exponent_range: exponent_range(sweep),
            largest,
            letter: sweep.letter,
        }
    }

    /// Displacement (m) and speed (m/s) to which the pictures of the points at one value reach.
    pub fn reach(&self, found: &[&ResponseView]) -> [f64; 2] {
        let least = self.largest.map(|size| LEAST_SHARE * size);
        let motions = found.iter().map(|response| largest(response));
        let largest = motions.fold(least, |[a, b], [c, d]| [a.max(c), b.max(d)]);
        largest.map(|size| round_up(1.02 * size))
    }

    /// The plane of the section of the points at one value, and its unit: as close as it can be,
    /// but never closer than a share of the motion, since a tone must look like a point.
    pub fn section(&self, found: &[&ResponseView]) -> (Plot, Unit) {
        let points = || found.iter().flat_map(|response| &response.section);
        let ends: [[f64; 2]; 2] = std::array::from_fn(|c| range(points().map(|point| point[c])));
        let motion = points().flatten().fold(0.0, |a: f64, c| a.max(c.abs()));
        let spread = ends
            .iter()
            .map(|[low, high]| high - low)
            .fold(0.0, f64::max);
        let half = match points().next() {
            Some(_) => (0.6 * spread).max(0.15 * motion).max(SMALLEST[0]),
            None => self.largest[0],
        };
        let axes = [0, 1].map(|c| match points().next() {
            Some(_) => 0.5 * (ends[c][0] + ends[c][1]),
            None => 0.0,
        });
        let size = axes.iter().map(|centre| centre.abs() + half);
        let unit = Quantity::Length.unit(size.fold(0.0, f64::max));
        let names = [
            format!("{}(t), {}", self.letter, unit.symbol),
            format!("{}(t + 2τ), {}", self.letter, unit.symbol),
        ];
        let mut names = names.into_iter();
        let [x, y] = axes.map(|centre| {
            let ends = [centre - half, centre + half].map(|end| unit.per_si * end);
            Axis::linear(names.next().unwrap_or_default(), ends[0], ends[1], 4)
        });
        (square(x, y), unit)
    }
}

/// A square field.
pub fn square(x: Axis, y: Axis) -> Plot {
    Plot {
        width: SECTION,
        height: SECTION,
        head: 0.0,
        x,
        y,
        grid: true,
    }
}

/// The largest displacement and speed of a response.
fn largest(response: &ResponseView) -> [f64; 2] {
    let Some(motion) = &response.motion else {
        return [response.amplitude, 0.0];
    };
    [&motion.displacement, &motion.velocity].map(|values| {
        let sizes = values.iter().map(|value| f64::from(value.abs()));
        sizes.fold(0.0, f64::max)
    })
}

/// The heights of a response's marks in the diagram: one at zero where nothing moves.
pub fn tops(response: &ResponseView) -> impl Iterator<Item = f64> + '_ {
    let rests = response.maxima.is_empty().then_some(0.0);
    response.maxima.iter().copied().chain(rests)
}

fn diagram(sweep: &SweepView, largest: f64) -> (Plot, Unit) {
    let unit = Quantity::Length.unit(largest);
    let tops = responses(&sweep.starts).flat_map(tops);
    let [low, high] = match range(tops.map(|top| unit.per_si * top)) {
        [low, high] if low < high => [low, high],
        [low, _] if low.is_finite() => [low.min(0.0), low.max(unit.per_si * SMALLEST[0])],
        _ => [0.0, 1.0],
    };
    let margin = 0.05 * (high - low);
    let [first, last] = match sweep.values[..] {
        [first, .., last] => [first, last],
        [only] => [only, only],
        [] => [0.0, 1.0],
    };
    let half = match sweep.values.len() {
        0 | 1 => 0.5 * first.abs().max(1e-3),
        count => 0.5 * (last - first) / (count - 1) as f64,
    };
    let kinds = Regime::ALL.into_iter().filter(|regime| {
        let mut found = responses(&sweep.starts);
        found.any(|response| response.regime == *regime)
    });
    let plot = Plot {
        width: DIAGRAM[0],
        height: DIAGRAM[1],
        // The key may need a second line.
        head: if kinds.count() > 4 { 2.0 } else { 1.0 } * CAPTION_HEIGHT,
        x: Axis::linear(&*sweep.parameter.label, first - half, last + half, 8),
        y: Axis::linear(
            format!("settled maxima of {}, {}", sweep.letter, unit.symbol),
            low - margin,
            high + margin,
            5,
        ),
        grid: true,
    };
    (plot, unit)
}

fn spectrum(sweep: &SweepView, largest: f64) -> SpectrumPlot {
    let unit = Quantity::Length.unit(largest);
    let lines = || responses(&sweep.starts).flat_map(|response| &response.lines);
    let strongest = lines().map(|line| line.amplitude).fold(0.0, f64::max);
    let strong = lines().filter(|line| line.amplitude >= WEAK * strongest);
    let highest = strong.map(|line| line.frequency).fold(0.0, f64::max);
    let motions = responses(&sweep.starts).filter_map(|response| response.motion.as_ref());
    let ends = motions.map(|motion| motion.bin * motion.spectrum.len() as f64);
    let end = ends.fold(0.0, f64::max);
    let highest = (1.1 * highest / FREQUENCY_STEP).ceil().max(2.0) * FREQUENCY_STEP;
    // The last bin may be a little beyond a round number.
    let end = (end / 1e3).round() * 1e3;
    let highest = if end > 0.0 { highest.min(end) } else { highest };
    // Of a displacement without lines there is at least a size.
    let top = if strongest > 0.0 { strongest } else { largest };
    let top = (unit.per_si * top).log10().ceil() as i32;
    SpectrumPlot::new(
        &format!("amplitude of {}", sweep.letter),
        unit,
        [top - DECADES, top],
        highest,
    )
}

fn exponent_range(sweep: &SweepView) -> [f64; 2] {
    let spectra = responses(&sweep.starts).filter_map(|response| response.exponents.as_ref());
    let ends = spectra
        .flat_map(|spectrum| &spectrum.exponents)
        .flat_map(|e| {
            let low = e.low().max(e.value - INTERVAL);
            [e.value, low, e.high().min(e.value + INTERVAL)]
        });
    let ends = ends.filter(|value| value.is_finite() && *value > LOWEST_EXPONENT);
    let [low, high] = range(ends.chain([-1.0, 1.0]));
    let margin = 0.08 * (high - low);
    [low - margin, high + margin]
}
