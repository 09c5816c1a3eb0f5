//! The figure of synthetic exponents.

use super::*;
use crate::dynamics::{Motion, SolverStats};
use crate::plot::{FigureOptions, Format};
use crate::study::lyapunov::{Ending, LyapunovStudy, RunningExponents};

/// Synthetic exponents of a chaotic motion that converge to `values` with the averaging time.
fn found(values: &[f64], dimension: usize) -> LyapunovResult {
    let at = |time: f64| -> Vec<Exponent> {
        let wave = |k: usize| (7.0 * time.ln() + k as f64).sin();
        let near = |(k, v): (usize, &f64)| Exponent {
            value: v + 6.0 / time.sqrt() * wave(k),
            half_width: 9.0 / time.sqrt(),
        };
        values.iter().enumerate().map(near).collect()
    };
    let times = (0..150).map(|k| 0.02 * 1.034_f64.powi(k));
    let running: Vec<RunningExponents> = times
        .map(|time| RunningExponents {
            time,
            exponents: at(time),
        })
        .collect();
    let time = running.last().unwrap().time;
    let spectrum = LyapunovSpectrum {
        exponents: at(time),
        time,
        dimension,
        resolution: 8.0,
        ..LyapunovSpectrum::default()
    };
    LyapunovResult {
        study: LyapunovStudy {
            spectrum,
            motion: Motion::Free,
            running,
            segments: Vec::new(),
            mean_trace_per_s: None,
            ending: Ending::Reached,
            settle_s: 0.06,
            stats: SolverStats::default(),
            simulated_s: time,
            busy_seconds: 1.0,
            ..LyapunovStudy::default()
        },
        tilt_rad: Some(0.087),
        fixed_at: Default::default(),
        transient_s: 0.25,
        tolerance: Some(1e-5),
        omega_1_rad_per_s: 10_669.0,
    }
}

/// The whole spectrum of a joint: one positive, one zero, twenty negative.
fn whole() -> Vec<f64> {
    let rest = (0..20).map(|k| -20.0 - 9.0 * f64::from(k * k));
    [62.0, 0.0].into_iter().chain(rest).collect()
}

fn svg(figure: &Figure) -> String {
    figure.svg(&FigureOptions::default())
}

fn is_finite(figure: &Figure) -> bool {
    let svg = svg(figure);
    let mut words = svg.split(['"', ',', ' ', '(']);
    !words.any(|word| ["NaN", "inf", "-inf"].contains(&word))
}

/// `SQUEAKSCOPE_FIGURES=DIR cargo test figure` saves the figure for inspection.
#[test]
fn exponents_are_drawn() {
    let figure = lyapunov_figure("chaos-5deg at 5°", &found(&whole(), 22));
    assert!(is_finite(&figure));
    for said in ["all 22", "positive", "negative", "λ1", "ω1 = 10669 rad/s"] {
        assert!(svg(&figure).contains(said), "{said}");
    }
    let png = figure.file(&FigureOptions::default(), Format::Png).unwrap();
    if let Some(folder) = std::env::var_os("SQUEAKSCOPE_FIGURES") {
        let path = std::path::Path::new(&folder).join("lyapunov.png");
        std::fs::write(path, png).unwrap();
    }
}

/// Infinite intervals, a single exponent, an exponent of minus infinity, no exponents.
#[test]
fn unknown_values_are_omitted() {
    let mut short = found(&whole(), 22);
    let exponents = short.study.spectrum.exponents.iter_mut();
    let running = short
        .study
        .running
        .iter_mut()
        .flat_map(|r| &mut r.exponents);
    for exponent in exponents.chain(running) {
        exponent.half_width = f64::INFINITY;
    }
    short.study.spectrum.exponents[21].value = f64::NEG_INFINITY;
    let figure = lyapunov_figure("short", &short);
    assert!(is_finite(&figure) && svg(&figure).contains("undetermined"));
    assert!(svg(&figure).contains("all 22; minus infinity: 1"));

    let one = lyapunov_figure("one", &found(&[62.0], 22));
    assert!(is_finite(&one) && svg(&one).contains("the largest 1 of 22"));

    let mut none = found(&[], 22);
    none.study.running.clear();
    assert!(is_finite(&lyapunov_figure("none", &none)));
}
