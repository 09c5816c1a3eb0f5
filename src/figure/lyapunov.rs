//! The figure of the Lyapunov exponents: how they converged, and what they came to.

use super::panel::{Axis, Mark, Panel, Scale};
use super::style::{BLUE, FAINT, GREEN, INK, PURPLE, Rgb, VERMILION};
use super::{Figure, FigureError};
use crate::dynamics::{Exponent, LyapunovSpectrum, Sign};
use crate::study::lyapunov::{RunningExponents, SceneLyapunov};

/// Colours of the largest exponents, in turn.
const COLORS: [Rgb; 5] = [VERMILION, BLUE, GREEN, PURPLE, INK];
/// Negative exponents shown beside those that are not.
const NEGATIVE: usize = 2;
/// The most exponents of the close views.
const MOST: usize = COLORS.len();

/// The running exponents against the time averaged, with their intervals; below them all exponents
/// in 1/s, and the largest ones over `omega_1`. `name` says which motion it is.
///
/// # Errors
/// [`FigureError`].
pub fn lyapunov_figure(name: &str, found: &SceneLyapunov) -> Result<Figure, FigureError> {
    let spectrum = &found.study.spectrum;
    let title = format!("Lyapunov exponents — {name}");
    Figure::new(
        "lyapunov",
        &title,
        [1000, 760],
        &[
            vec![running(&found.study.running, spectrum)],
            vec![all(spectrum), largest(spectrum, found.omega_1)],
        ],
    )
}

/// How many exponents the close views show: all that are not negative, and a few below.
fn shown(spectrum: &LyapunovSpectrum) -> usize {
    let count = spectrum.exponents.len();
    let above = (0..count).filter(|&k| spectrum.sign(k) != Sign::Negative);
    (above.count() + NEGATIVE).min(count).min(MOST)
}

fn running(running: &[RunningExponents], spectrum: &LyapunovSpectrum) -> Panel {
    let count = shown(spectrum);
    let mut marks = vec![Mark::Level { y: 0.0 }];
    for (k, &color) in COLORS.iter().enumerate().take(count) {
        let spans = running.iter().map(|at| span(at.time, at.exponents[k]));
        marks.push(Mark::Band {
            spans: spans.collect(),
            color,
        });
    }
    for (k, &color) in COLORS.iter().enumerate().take(count) {
        let points = running.iter().map(|at| [at.time, at.exponents[k].value]);
        marks.push(Mark::Line {
            points: points.collect(),
            color,
            label: format!("λ{}", k + 1),
        });
    }
    // The first estimates are far off and would hide all later ones: the later half sets the axis.
    let late = &running[running.len() / 2..];
    let ends = late.iter().flat_map(|at| &at.exponents[..count]);
    let ends = ends.flat_map(|e| [e.value, e.low(), e.high()]);
    let times = match running {
        [first, .., last] => [first.time, last.time],
        _ => [0.1, 1.0],
    };
    Panel {
        title: format!(
            "running value with its 95 % interval, {:.3} s averaged",
            spectrum.time
        ),
        x: Axis {
            scale: Scale::Decades,
            ..Axis::linear("time averaged, s", times)
        },
        y: Axis::around("exponent, 1/s", ends.chain([0.0])),
        marks,
    }
}

fn all(spectrum: &LyapunovSpectrum) -> Panel {
    let points = spectrum.exponents.iter().copied();
    let mut marks = vec![Mark::Level { y: 0.0 }];
    marks.extend(by_sign(spectrum, points.clone().collect()));
    let (sum, count) = (
        points.clone().map(|e| e.value).sum::<f64>(),
        spectrum.exponents.len(),
    );
    let collapsed = points
        .clone()
        .filter(|e| e.value == f64::NEG_INFINITY)
        .count();
    let mut title = match count == spectrum.dimension {
        true if sum.is_finite() => format!("all {count}, in sum {sum:.1} 1/s"),
        true => format!("all {count}"),
        false => format!("the largest {count} of {}", spectrum.dimension),
    };
    // They have no place on the axis.
    if collapsed > 0 {
        title += &format!("; minus infinity: {collapsed}");
    }
    Panel {
        title,
        x: Axis::linear("number", [0.5, count.max(1) as f64 + 0.5]),
        y: Axis::around("exponent, 1/s", ends(points).chain([0.0])),
        marks,
    }
}

fn largest(spectrum: &LyapunovSpectrum, omega_1: f64) -> Panel {
    let count = shown(spectrum);
    let scale = 1e3 / omega_1;
    let points = spectrum.exponents[..count].iter().map(|e| Exponent {
        value: scale * e.value,
        half_width: scale * e.half_width,
    });
    let mut marks = vec![
        Mark::Band {
            spans: [0.5, count.max(1) as f64 + 0.5]
                .map(|x| [x, -scale * spectrum.resolution, scale * spectrum.resolution])
                .to_vec(),
            color: FAINT,
        },
        Mark::Level { y: 0.0 },
    ];
    marks.extend(by_sign(spectrum, points.clone().collect()));
    let bound = scale * spectrum.resolution;
    Panel {
        title: "the largest; grey is not told from zero".to_owned(),
        x: Axis::linear("number", [0.5, count.max(1) as f64 + 0.5]),
        y: Axis::around(
            format!("exponent over ω1 = {omega_1:.0} rad/s, 1e−3"),
            ends(points).chain([-bound, bound]),
        ),
        marks,
    }
}

/// Values with their intervals as dots, in a colour a sign.
fn by_sign(spectrum: &LyapunovSpectrum, points: Vec<Exponent>) -> Vec<Mark> {
    let kinds = [
        (Sign::Positive, VERMILION, "positive"),
        (Sign::Zero, INK, "zero"),
        (Sign::Negative, BLUE, "negative"),
        (Sign::Doubtful, PURPLE, "doubtful"),
    ];
    let mut marks = Vec::new();
    for (sign, color, label) in kinds {
        let of_sign = points.iter().enumerate();
        let of_sign = of_sign.filter(|(k, _)| spectrum.sign(*k) == sign);
        let of_sign = of_sign.map(|(k, e)| (k as f64 + 1.0, *e));
        let dots: Vec<[f64; 2]> = of_sign.clone().map(|(x, e)| [x, e.value]).collect();
        if dots.is_empty() {
            continue;
        }
        let spans = of_sign.map(|(x, e)| span(x, e)).collect();
        marks.push(Mark::Dots {
            points: dots,
            radius: 3.5,
            color,
            label: label.to_owned(),
        });
        marks.push(Mark::Intervals { spans, color });
    }
    marks
}

/// An exponent's place, and the ends of its interval.
fn span(x: f64, exponent: Exponent) -> [f64; 3] {
    [x, exponent.low(), exponent.high()]
}

/// Both ends of all intervals, and the values.
fn ends<'a>(points: impl Iterator<Item = Exponent> + 'a) -> impl Iterator<Item = f64> + 'a {
    points.flat_map(|e| [e.value, e.low(), e.high()])
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
