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
    let (spectrum, omega_1) = (&found.study.spectrum, found.omega_1_rad_per_s);
    let count = spectrum.exponents.len();
    let all = by_sign(spectrum, count, (1.0, "exponent, 1/s"));
    let scale = (1e3 / omega_1, "exponent over ω1, 1e−3");
    let largest = by_sign(spectrum, shown(spectrum), scale);
    let title = format!("largest over ω1 = {omega_1:.0} rad/s; grey: zero");
    let below = vec![
        all.with_title(summary(spectrum) + "; grey: zero"),
        largest.with_title(title),
    ];
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
        Layer::band(spans, Color::Series(k))
    }));
    layers.extend((0..count).map(|k| {
        let points = running.iter().map(|at| [at.time, at.exponents[k].value]);
        Layer::line(points.collect(), Color::Series(k)).with_label(format!("λ{}", k + 1))
    }));
    // The first estimates are far off; the second half of the run determines the axis.
    let late = running[running.len() / 2..].iter();
    let late = late.flat_map(|at| &at.exponents[..count]);
    let late = late.flat_map(|e| [e.value, e.low(), e.high()]);
    let since = match study.segments.as_slice() {
        [_, .., last] => format!(" after the motion changed at {:.3} s", last.start_s),
        _ => String::new(),
    };
    let averaged = spectrum.time;
    let title = format!("running value with 95 % interval, {averaged:.3} s averaged{since}");
    let times = running.iter().map(|at| at.time);
    let x = Axis::rounded_logarithmic("averaging time, s", times);
    let y = Axis::with_margin("exponent, 1/s", late.chain([0.0]));
    Panel::new(title, x, y, layers)
}

/// How many exponents there are, and their sum.
fn summary(spectrum: &LyapunovSpectrum) -> String {
    let count = spectrum.exponents.len();
    let values = spectrum.exponents.iter().map(|e| e.value);
    let sum: f64 = values.clone().sum();
    let shown = match spectrum.dimension {
        dimension if dimension > count => format!("the largest {count} of {dimension}"),
        _ if sum.is_finite() => format!("all {count}, sum {sum:.1} 1/s"),
        _ => format!("all {count}"),
    };
    // Exponents of minus infinity have no position on the axis.
    match values.filter(|value| *value == f64::NEG_INFINITY).count() {
        0 => shown,
        collapsed => format!("{shown}; minus infinity: {collapsed}"),
    }
}

/// The exponents so far with their intervals, on an axis of ± `full` (1/s).
pub fn current_spectrum(spectrum: &LyapunovSpectrum, full: f64) -> Panel {
    let numbered = (0..).zip(&spectrum.exponents);
    let mut layers = vec![Layer::horizontal_line(0.0).with_id("zero")];
    layers.extend(numbered.flat_map(|(k, exponent)| {
        let (x, color) = (k as f64 + 1.0, Color::Series(k));
        let point = Layer::points(vec![[x, exponent.value]], 3.3, color);
        [Layer::intervals([span(x, *exponent)], color), point]
    }));
    let caption = match &spectrum.kaplan_yorke {
        Some(dimension) => format!("Kaplan-Yorke dimension {}", Measured::from(dimension)),
        None => "95 % intervals".to_owned(),
    };
    let index = Axis::integers("index", spectrum.exponents.len());
    let values = Axis::linear("exponent, 1/s", [-full, full]);
    Panel::new("Lyapunov exponents", index, values, layers).with_caption(caption)
}

/// The first exponents times a factor with their intervals, with one marker for each sign, on an axis with a name; in
/// grey the values that count as zero.
fn by_sign(spectrum: &LyapunovSpectrum, count: usize, (factor, name): (f64, &str)) -> Panel {
    let bound = factor * spectrum.resolution;
    let x = Axis::integers("index", count);
    let mut layers = vec![
        Layer::band(x.range.map(|x| [x, -bound, bound]), Color::Faint),
        Layer::horizontal_line(0.0),
    ];
    for (sign, marker, label) in [
        (Sign::Positive, Marker::Up, "positive"),
        (Sign::Zero, Marker::Ring, "zero"),
        (Sign::Negative, Marker::Down, "negative"),
        (Sign::Undetermined, Marker::Cross, "undetermined"),
    ] {
        let own = || (0..count).filter(|k| spectrum.sign(*k) == sign);
        let spans = own().map(|k| span(k as f64 + 1.0, spectrum.exponents[k]));
        let spans = spans.map(|[x, low, high]| [x, factor * low, factor * high]);
        let points = own().map(|k| [k as f64 + 1.0, factor * spectrum.exponents[k].value]);
        let points = Layer::points(points.collect(), 2.4, Color::Series(0));
        if points.has_points() {
            layers.push(Layer::intervals(spans, Color::Series(0)));
            layers.push(points.with_marker(marker).with_label(label));
        }
    }
    let values = layers.iter().flat_map(Layer::points_of).map(|p| p[1]);
    let y = Axis::with_margin(name, values.chain([-bound, bound]));
    Panel::new("", x, y, layers)
}

/// Index of an exponent and the ends of its interval.
fn span(x: f64, exponent: Exponent) -> [f64; 3] {
    [x, exponent.low(), exponent.high()]
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
