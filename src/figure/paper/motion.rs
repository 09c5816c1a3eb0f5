//! Fig. 4 to 8: one motion from all sides, and how it is embedded.

use crate::analysis::DelayChoice;
use crate::figure::panel::{Axis, Mark, Panel};
use crate::figure::style::{BLUE, FAINT, INK, PALE, Rgb, SKY, VERMILION};
use crate::figure::sweep::color_of;
use crate::figure::{Figure, FigureError};
use crate::joint::{Cause, ExplainedMode};
use crate::study::response::{Portrait, Response};

/// Delay of the reconstruction, s: a quarter of a period of 4.1 kHz.
pub(super) const LAG: f64 = 60e-6;

/// Length of time series and recurrence plots, s.
const WINDOW: f64 = 5e-3;

/// The highest frequency of a spectrum, Hz.
const HIGHEST: f64 = 15e3;

/// Lines with names shown in a spectrum.
const NAMED: usize = 5;

/// Fig. 4 to 7: growth of the linear modes, time series, phase plot, spectrum, delay reconstruction
/// and recurrence plot of the motion at a tilt (degrees), whose linear modes are `modes`.
///
/// # Errors
/// [`FigureError`].
pub fn motion(
    number: usize,
    tilt_deg: f64,
    response: &Response,
    modes: &[ExplainedMode],
) -> Result<Figure, FigureError> {
    let title = format!(
        "Fig. {number} — {tilt_deg}°: {}, {:.0} % sure",
        response.regime,
        100.0 * response.confidence
    );
    let mut rows = vec![vec![growth(modes)]];
    if let Some(portrait) = &response.portrait {
        let color = color_of(response.regime);
        rows = vec![
            vec![
                growth(modes),
                series(portrait, color),
                phase(portrait, color),
            ],
            vec![
                spectrum(response, portrait),
                reconstruction(portrait, color),
                recurrence("f  recurrence plot".to_owned(), portrait),
            ],
        ];
    }
    Figure::new(format!("figure-{number}"), &title, [1300, 860], &rows)
}

/// Growth of each oscillating mode, and what feeds and damps it: the shares add up to the growth.
fn growth(modes: &[ExplainedMode]) -> Panel {
    const WIDTH: f64 = 0.45;
    let mut marks = vec![Mark::Level { y: 0.0 }];
    let feeds = [
        (&[Cause::Slope][..], SKY, "slope"),
        (&[Cause::Coupling], BLUE, "coupling"),
        (
            &[
                Cause::Direction,
                Cause::Structure,
                Cause::ContactDamping,
                Cause::Convection,
            ],
            PALE,
            "damping",
        ),
    ];
    // Bars that feed stand upon each other, and so do those that damp.
    let mut ends = vec![[0.0_f64; 2]; modes.len()];
    for (causes, color, label) in feeds {
        let spans = modes.iter().zip(&mut ends).map(|(mode, ends)| {
            let of = mode.causes.iter().filter(|c| causes.contains(&c.cause));
            let share: f64 = of.map(|cause| cause.share).sum();
            let end = &mut ends[usize::from(share < 0.0)];
            let from = *end;
            *end += share;
            [1e-3 * mode.frequency_hz, from, *end]
        });
        marks.push(Mark::Columns {
            spans: spans.collect(),
            width: WIDTH,
            color,
            label: label.to_owned(),
        });
    }
    let unstable = modes.iter().filter(|mode| mode.growth > 0.0).count();
    for (growing, color) in [(true, VERMILION), (false, INK)] {
        let chosen = modes.iter().filter(|mode| (mode.growth > 0.0) == growing);
        marks.push(Mark::Dots {
            points: chosen
                .map(|mode| [1e-3 * mode.frequency_hz, mode.growth])
                .collect(),
            radius: 3.5,
            color,
            label: String::new(),
        });
    }
    let highest = modes.iter().map(|mode| mode.growth).fold(100.0, f64::max);
    Panel {
        title: format!("a  {unstable} unstable modes"),
        x: Axis::linear("frequency, kHz", [0.0, 13.0]),
        y: Axis::linear(
            "growth rate (dots) and its causes (bars), 1/s",
            [-0.4 * highest, 1.25 * highest],
        ),
        marks,
    }
}

/// Points drawn for each sample: lines between samples would show as corners.
const FINER: usize = 5;

/// Displacement (m) and velocity (m/s) between the samples: the cubic through displacements with the
/// velocities as slopes, and its slope.
fn between_samples(portrait: &Portrait) -> Vec<[f64; 2]> {
    let h = portrait.dt;
    let samples = portrait.displacement.iter().zip(&portrait.velocity);
    let samples: Vec<[f64; 2]> = samples.map(|(&u, &v)| [u, v].map(f64::from)).collect();
    let pieces = samples.windows(2).flat_map(|pair| {
        let [[u0, v0], [u1, v1]] = [pair[0], pair[1]];
        (0..FINER).map(move |k| {
            let s = k as f64 / FINER as f64;
            let rise = u1 - u0;
            let (a, b) = (h * v0 - rise, rise - h * v1);
            let r = 1.0 - s;
            let u = r * u0 + s * u1 + s * r * (r * a + s * b);
            let slope = rise + (1.0 - 2.0 * s) * (r * a + s * b) + s * r * (b - a);
            [u, slope / h]
        })
    });
    pieces.chain(samples.last().copied()).collect()
}

fn series(portrait: &Portrait, color: Rgb) -> Panel {
    let dt = portrait.dt / FINER as f64;
    let fine = between_samples(portrait);
    let shown = &fine[fine
        .len()
        .saturating_sub((WINDOW / dt).round() as usize + 1)..];
    let points = shown.iter().enumerate();
    let points = points.map(|(k, [u, _])| [1e3 * dt * k as f64, 1e6 * u]);
    let points: Vec<[f64; 2]> = points.collect();
    Panel {
        title: "b  displacement at the middle of the patch".to_owned(),
        x: Axis::linear("time, ms", [0.0, 1e3 * WINDOW]),
        y: Axis::around("u, µm", points.iter().map(|p| p[1])),
        marks: vec![line(points, color)],
    }
}

fn phase(portrait: &Portrait, color: Rgb) -> Panel {
    let fine = between_samples(portrait).into_iter();
    let points: Vec<[f64; 2]> = fine.map(|[u, v]| [1e6 * u, 1e3 * v]).collect();
    Panel {
        title: "c  phase plot".to_owned(),
        x: Axis::around("u, µm", points.iter().map(|p| p[0])),
        y: Axis::around("v, mm/s", points.iter().map(|p| p[1])),
        marks: vec![line(points, color)],
    }
}

fn spectrum(response: &Response, portrait: &Portrait) -> Panel {
    let points = portrait.spectrum.iter().enumerate().skip(1);
    let points = points.map(|(k, a)| [1e-3 * portrait.bin * k as f64, 1e6 * f64::from(*a)]);
    let points: Vec<[f64; 2]> = points.collect();
    let highest = points.iter().map(|p| p[1]).fold(1e-12, f64::max);
    let top = highest.log10().ceil() as i32;
    let mut marks = vec![line(points, INK)];
    let shown = response
        .lines
        .iter()
        .filter(|tone| tone.frequency < HIGHEST);
    let mut words: Vec<[f64; 2]> = Vec::new();
    for tone in shown.take(NAMED) {
        // Words upon each other say nothing.
        let place = [1e-3 * tone.frequency, tone.amplitude.log10()];
        let near = |at: &[f64; 2]| (at[0] - place[0]).abs() < 1.0 && (at[1] - place[1]).abs() < 0.2;
        if words.iter().any(near) {
            continue;
        }
        words.push(place);
        let name = match tone.label.as_str() {
            "" => String::new(),
            name => format!(" = {name}"),
        };
        marks.push(Mark::Dots {
            points: vec![[1e-3 * tone.frequency, 1e6 * tone.amplitude]],
            radius: 3.0,
            color: VERMILION,
            label: String::new(),
        });
        marks.push(Mark::Words {
            // The words must not leave the field.
            at: [
                (1e-3 * tone.frequency + 0.2).min(1e-3 * HIGHEST - 3.5),
                1.6e6 * tone.amplitude,
            ],
            words: format!("{:.2}{name}", 1e-3 * tone.frequency),
        });
    }
    Panel {
        title: "d  spectrum".to_owned(),
        x: Axis::linear("frequency, kHz", [0.0, 1e-3 * HIGHEST]),
        y: Axis::decades("amplitude, µm", [top - 6, top]),
        marks,
    }
}

/// Two of the coordinates of the delay space.
fn reconstruction(portrait: &Portrait, color: Rgb) -> Panel {
    let u: Vec<f64> = between_samples(portrait)
        .iter()
        .map(|[u, _]| 1e6 * u)
        .collect();
    let lag = (FINER as f64 * LAG / portrait.dt).round().max(1.0) as usize;
    let pairs = u.iter().zip(u.iter().skip(lag));
    let points: Vec<[f64; 2]> = pairs.map(|(a, b)| [*a, *b]).collect();
    Panel {
        title: format!("e  delay reconstruction, τ = {:.0} µs", 1e6 * LAG),
        x: Axis::around("y(t), µm", points.iter().map(|p| p[0])),
        y: Axis::around("y(t + τ), µm", points.iter().map(|p| p[1])),
        marks: vec![line(points, color)],
    }
}

/// The recurrence plot of the newest 5 ms; empty where nothing moves.
pub(super) fn recurrence(title: String, portrait: &Portrait) -> Panel {
    let end = 1e3 * WINDOW;
    let moves = portrait
        .displacement
        .windows(2)
        .any(|pair| pair[0] != pair[1]);
    let found = portrait.recurrence().ok().flatten().filter(|_| moves);
    let picture = found.map(|found| Mark::Picture {
        x: [0.0, 1e3 * found.window],
        y: [0.0, 1e3 * found.window],
        size: [found.size, found.size],
        // The upper row first: there the latest.
        pixels: found
            .recurrent
            .chunks(found.size.max(1))
            .rev()
            .flatten()
            .map(|&pixel| if pixel == 0 { [255; 3] } else { INK })
            .collect(),
    });
    Panel {
        title,
        x: Axis::linear("time, ms", [0.0, end]),
        y: Axis::linear("time, ms", [0.0, end]),
        marks: picture.into_iter().collect(),
    }
}

fn line(points: Vec<[f64; 2]>, color: Rgb) -> Mark {
    Mark::Line {
        points,
        color,
        label: String::new(),
    }
}

/// Fig. 8: mutual information and share of false neighbours of the motion at a tilt (degrees), sampled
/// every `dt` (s).
///
/// # Errors
/// [`FigureError`].
pub fn embedding(tilt_deg: f64, choice: &DelayChoice, dt: f64) -> Result<Figure, FigureError> {
    let mutual = choice.mutual.bits.iter().enumerate();
    let mutual: Vec<[f64; 2]> = mutual
        .map(|(k, bits)| [1e6 * dt * k as f64, *bits])
        .collect();
    let most = mutual.iter().map(|p| p[1]).fold(0.1, f64::max);
    let information = Panel {
        title: format!(
            "a  average mutual information: delay {:.0} µs",
            1e6 * dt * choice.lag as f64
        ),
        x: Axis::linear("delay, µs", [0.0, mutual.last().map_or(1.0, |p| p[0])]),
        y: Axis::linear("information, bit", [0.0, 1.05 * most]),
        marks: vec![
            line(mutual, BLUE),
            Mark::Upright {
                x: 1e6 * dt * choice.lag as f64,
                words: format!("{} samples", choice.lag),
                color: VERMILION,
            },
        ],
    };
    let shares = choice.neighbours.share.iter().enumerate();
    let shares: Vec<[f64; 2]> = shares
        .map(|(k, share)| [(k + 1) as f64, 100.0 * share])
        .collect();
    let neighbours = Panel {
        title: format!(
            "b  false nearest neighbours: dimension {}",
            choice.dimension
        ),
        x: Axis::linear("dimension", [0.5, shares.len() as f64 + 0.5]),
        y: Axis::linear("false neighbours, %", [0.0, 105.0]),
        marks: vec![
            line(shares.clone(), FAINT),
            Mark::Dots {
                points: shares,
                radius: 3.5,
                color: VERMILION,
                label: String::new(),
            },
        ],
    };
    let title = format!("Fig. 8 — choice of delay and dimension at {tilt_deg}°");
    Figure::new(
        "figure-8",
        &title,
        [1100, 480],
        &[vec![information, neighbours]],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_is_smooth_between_its_samples() {
        let dt = 5e-6;
        let omega = std::f64::consts::TAU * 12.4e3;
        let wave = |k: usize| omega * dt * k as f64;
        let portrait = Portrait {
            dt,
            displacement: (0..50).map(|k| wave(k).sin() as f32).collect(),
            velocity: (0..50).map(|k| (omega * wave(k).cos()) as f32).collect(),
            bin: 1.0,
            spectrum: Vec::new(),
        };
        let fine = between_samples(&portrait);
        assert_eq!(fine.len(), 49 * FINER + 1);
        for (k, [u, v]) in fine.into_iter().enumerate() {
            let phase = omega * dt * k as f64 / FINER as f64;
            assert!((u - phase.sin()).abs() < 2e-4, "{k}: {u}");
            assert!((v / omega - phase.cos()).abs() < 3e-3, "{k}: {v}");
        }
    }
}
