//! Figure of the Lyapunov exponents: convergence, and final spectrum.

use super::{Axis, Color, Figure, Layer, Marker, Panel};
use crate::dynamics::{Exponent, LyapunovSpectrum, Sign};
use crate::report::Measured;
use crate::study::lyapunov::{LyapunovResult, LyapunovStudy};

/// Number of negative exponents shown besides the non-negative ones.
const NEGATIVE: usize = 2;
/// Maximum number of exponents in the detail panels.
const MOST: usize = 5;

/// The running exponents over the averaging time with their intervals; below them all exponents in 1/s, and
/// the largest ones over `omega_1`. `name` names the motion.
pub fn lyapunov_figure(name: &str, found: &LyapunovResult) -> Figure {
    let spectrum = &found.study.spectrum;
    let below = vec![all(spectrum), largest(spectrum, found.omega_1_rad_per_s)];
    let title = format!("Lyapunov exponents of {name}");
    let rows = vec![vec![running(&found.study)], below];
    Figure::new("lyapunov", &title, 135.0, rows)
}

/// Number of exponents in the detail panels: the non-negative ones and a few negative ones.
fn shown(spectrum: &LyapunovSpectrum) -> usize {
    let count = spectrum.exponents.len();
    let above = (0..count).filter(|&k| spectrum.sign(k) != Sign::Negative);
    (above.count() + NEGATIVE).min(count).min(MOST)
}

fn running(study: &LyapunovStudy) -> Panel {
    let (running, spectrum) = (&study.running, &study.spectrum);
    let count = shown(spectrum);
    let mut layers = vec![Layer::horizontal_line(0.0)];
    layers.extend((0..count).map(|k| {
        let spans = running.iter().map(|at| span(at.time, at.exponents[k]));
        Layer::band(spans, Color::Exponent(k))
    }));
    layers.extend((0..count).map(|k| {
        let points = running.iter().map(|at| [at.time, at.exponents[k].value]);
        Layer::line(points.collect(), Color::Exponent(k)).with_label(format!("λ{}", k + 1))
    }));
    // The first estimates are far off; the second half of the run determines the axis.
    let late = running[running.len() / 2..].iter();
    let late = late.flat_map(|at| &at.exponents[..count]);
    let late = late.flat_map(|e| [e.value, e.low(), e.high()]);
    let times = match running.as_slice() {
        [first, .., last] => [first.time, last.time],
        _ => [0.1, 1.0],
    };
    let since = match study.segments.as_slice() {
        [_, .., last] => format!(" after the motion changed at {:.3} s", last.start_s),
        _ => String::new(),
    };
    let averaged = spectrum.time;
    let title = format!("running value with 95 % interval, {averaged:.3} s averaged{since}");
    let x = Axis::logarithmic("averaging time, s", times);
    let y = Axis::with_margin("exponent, 1/s", late.chain([0.0]));
    Panel::new(title, x, y, layers)
}

fn all(spectrum: &LyapunovSpectrum) -> Panel {
    let count = spectrum.exponents.len();
    let values = spectrum.exponents.iter().map(|e| e.value);
    let sum: f64 = values.clone().sum();
    let mut title = match spectrum.dimension {
        dimension if dimension > count => format!("the largest {count} of {dimension}"),
        _ if sum.is_finite() => format!("all {count}, sum {sum:.1} 1/s"),
        _ => format!("all {count}"),
    };
    // Exponents of minus infinity have no position on the axis.
    let collapsed = values.filter(|value| *value == f64::NEG_INFINITY).count();
    if collapsed > 0 {
        title += &format!("; minus infinity: {collapsed}");
    }
    let mut layers = vec![Layer::horizontal_line(0.0)];
    layers.extend(by_sign(spectrum, count, 1.0));
    let values = layers.iter().flat_map(Layer::points_of).map(|p| p[1]);
    let y = Axis::with_margin("exponent, 1/s", values);
    Panel::new(title, Axis::integers("index", count), y, layers)
}

fn largest(spectrum: &LyapunovSpectrum, omega_1: f64) -> Panel {
    let count = shown(spectrum);
    let factor = 1e3 / omega_1;
    let bound = factor * spectrum.resolution;
    let x = Axis::integers("index", count);
    let mut layers = vec![
        Layer::band(x.range.map(|x| [x, -bound, bound]), Color::Faint),
        Layer::horizontal_line(0.0),
    ];
    layers.extend(by_sign(spectrum, count, factor));
    let values = layers.iter().flat_map(Layer::points_of).map(|p| p[1]);
    let y = Axis::with_margin("exponent over ω1, 1e−3", values.chain([-bound, bound]));
    let title = format!("largest over ω1 = {omega_1:.0} rad/s; grey: zero");
    Panel::new(title, x, y, layers)
}

/// The exponents so far with their intervals, on an axis of ± `full` (1/s).
pub fn current_spectrum(spectrum: &LyapunovSpectrum, full: f64) -> Panel {
    let numbered = || (0..).zip(&spectrum.exponents);
    let mut layers = vec![Layer::horizontal_line(0.0).with_id("zero")];
    layers.extend(numbered().map(|(k, exponent)| {
        Layer::intervals([span(k as f64 + 1.0, *exponent)], Color::Exponent(k))
    }));
    layers.extend(numbered().map(|(k, exponent)| {
        let point = [k as f64 + 1.0, exponent.value];
        Layer::points(vec![point], 3.3, Color::Exponent(k))
    }));
    let caption = match &spectrum.kaplan_yorke {
        Some(dimension) => format!("Kaplan-Yorke dimension {}", Measured::from(dimension)),
        None => "95 % intervals".to_owned(),
    };
    let index = Axis::integers("index", spectrum.exponents.len());
    let values = Axis::linear("exponent, 1/s", [-full, full]);
    Panel::new("Lyapunov exponents", index, values, layers).with_caption(caption)
}

/// The first exponents times a factor with their intervals, with one marker for each sign.
fn by_sign(spectrum: &LyapunovSpectrum, count: usize, factor: f64) -> impl Iterator<Item = Layer> {
    let kinds = [
        (Sign::Positive, Marker::Up, "positive"),
        (Sign::Zero, Marker::Ring, "zero"),
        (Sign::Negative, Marker::Down, "negative"),
        (Sign::Undetermined, Marker::Cross, "undetermined"),
    ];
    let layers = kinds.into_iter().flat_map(move |(sign, marker, label)| {
        let own = (0..count).filter(|k| spectrum.sign(*k) == sign);
        let own = own.map(|k| {
            let Exponent { value, half_width } = spectrum.exponents[k];
            let [value, half_width] = [value, half_width].map(|x| factor * x);
            (k as f64 + 1.0, Exponent { value, half_width })
        });
        let spans = own.clone().map(|(x, exponent)| span(x, exponent));
        let points = own.map(|(x, exponent)| [x, exponent.value]).collect();
        let points = Layer::points(points, 2.4, Color::Exponent(0)).with_marker(marker);
        let intervals = Layer::intervals(spans, Color::Exponent(0));
        [intervals, points.with_label(label)]
    });
    layers.filter(Layer::has_points)
}

/// Index of an exponent and the ends of its interval.
fn span(x: f64, exponent: Exponent) -> [f64; 3] {
    [x, exponent.low(), exponent.high()]
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
