//! Figures of synthetic sweeps.

use super::*;
use crate::analysis::{recurrence::RecurrencePeriods, tones::SpectralLine};
use crate::dynamics::{LyapunovSpectrum, SolverStats};
use crate::plot::{FigureOptions, Format, Shape};
use crate::scene::{Parameter, Scene};
use crate::study::response::ResponsePlan;
use crate::study::sweep::Axis as SweptAxis;

/// A plan shared the tilt, and over the stiffness if `two` is set.
fn plan(two: bool) -> SweepPlan {
    let mut axes = vec![SweptAxis::new(
        Parameter::tilt(),
        (0..29).map(|k| 1.0 + 0.25 * f64::from(k)),
    )];
    if two {
        let factor = Parameter::named("stiffness_factor").unwrap();
        axes.push(SweptAxis::new(factor, (1..9).map(f64::from)));
    }
    SweepPlan {
        subject: Scene::load("doubled-torus-3deg").unwrap(),
        axes,
        starts: vec![Start::Upward, Start::Fresh],
        response: ResponsePlan::default(),
    }
}

/// A periodic, quasi-periodic or chaotic response, depending on the tilt.
fn response(tilt: f64, k: usize) -> SettledResponse {
    let (regime, count) = match tilt {
        t if t < 2.0 => (Regime::Periodic, 1),
        t if t < 4.5 => (Regime::QuasiPeriodic, 2),
        _ => (Regime::Chaotic, 3),
    };
    let wobble = |j: usize| (0.7 * j as f64 + k as f64).sin();
    let exponent = |value, half_width| Exponent { value, half_width };
    SettledResponse {
        transient_s: 0.1,
        settled: true,
        amplitude_m: 7e-7,
        mean_m: 0.0,
        rms_velocity_m_per_s: 0.01,
        peak_velocity_m_per_s: 0.0178,
        maxima_m: (0..200)
            .map(|j| 7e-7 * (1.0 + 0.1 * (count - 1) as f64 * wobble(j)))
            .collect(),
        section_m: Vec::new(),
        lines: (0..count)
            .map(|j| SpectralLine {
                frequency: [4110.0, 3870.0, 12330.0][j],
                amplitude: 7e-7 / (1.0 + 3.0 * j as f64),
                label: String::new(),
            })
            .collect(),
        curves: None,
        doubling: 0,
        broadband_share: 1e-9,
        exponents: Some(LyapunovSpectrum {
            exponents: vec![
                exponent(if count == 3 { 70.0 } else { 0.1 }, 8.0),
                exponent(if count > 1 { 0.0 } else { -60.0 }, 1.0),
                exponent(-90.0, 2.0),
            ],
            time: 0.2,
            dimension: 22,
            resolution: 11.5,
            kaplan_yorke: None,
        }),
        recurrence: None,
        recurrence_periods: RecurrencePeriods::default(),
        linear: None,
        regime,
        confidence: 0.9,
        portrait: None,
        state: Vec::new(),
        stats: SolverStats::default(),
    }
}

fn points(plan: &SweepPlan) -> Vec<SweepPoint> {
    let point = |index| {
        let place = plan.place(index);
        let outcome = match index % 17 {
            5 => Err("the solution diverged".to_owned()),
            _ => Ok(response(place.values[0], index)),
        };
        SweepPoint { place, outcome }
    };
    (0..plan.size()).map(point).collect()
}

#[test]
fn each_start_has_a_figure() {
    for (two, names) in [
        (false, vec!["bifurcation".to_owned()]),
        (
            true,
            vec![
                format!("regimes-{}", Start::Upward),
                format!("regimes-{}", Start::Fresh),
            ],
        ),
    ] {
        let plan = plan(two);
        let points = points(&plan);
        let figures = sweep_figures(&plan, &points);
        let named = |figures: &[Figure]| figures.iter().map(|f| &f.name).eq(&names);
        assert!(named(&figures));
        for figure in &figures {
            let svg = figure.svg(&FigureOptions::default());
            assert!(
                !svg.contains("NaN") && !svg.contains("inf"),
                "{}",
                figure.name
            );
            for word in ["quasi-periodic", "chaotic", "tilt, deg"] {
                assert!(svg.contains(word), "{}: {word}", figure.name);
            }
        }
        // A partial or empty sweep gives figures of the same names.
        for part in [&points[..5], &[]] {
            assert!(named(&sweep_figures(&plan, part)));
        }
        if let Ok(folder) = std::env::var("SQUEAKSCOPE_FIGURES") {
            for figure in &figures {
                let path = std::path::Path::new(&folder).join(format!("{}.png", figure.name));
                std::fs::write(
                    path,
                    figure.file(&FigureOptions::default(), Format::Png).unwrap(),
                )
                .unwrap();
            }
        }
    }
}

#[test]
fn starts_are_offset_and_have_different_markers() {
    let plan = plan(false);
    let points = points(&plan);
    let shared = ParameterPanels::new(&plan, &points, &plan.starts);
    let panel = shared.exponents(EXPONENTS).unwrap();
    // The legend lists the exponents first, then the starts.
    let legend = panel.layers.iter().filter(|layer| !layer.label.is_empty());
    let legend: Vec<&str> = legend.map(|layer| &*layer.label).collect();
    assert_eq!(legend, ["λ1", "λ2", "λ3", "upward", "fresh"]);
    let first = |wanted: Marker| {
        let mut points = panel.layers.iter().filter_map(|layer| match &layer.shape {
            Shape::Points(points) if layer.marker == wanted => points.first(),
            _ => None,
        });
        points.next().unwrap()[0]
    };
    assert!(first(Marker::Up) < 1.0 && first(Marker::Dot) > 1.0);
    // The points of a tilt are closer to it than to the next tilt.
    assert!((first(Marker::Up) - 1.0).abs() < 0.125);
}

#[test]
fn a_doubling_is_marked_between_its_points() {
    let plan = plan(false);
    let mut points = points(&plan);
    let marks = |points: &[SweepPoint]| {
        let panel = ParameterPanels::new(&plan, points, &[Start::Upward]).maxima();
        let dashed = panel.layers.iter().filter(|layer| layer.id == "chosen");
        // Each line has two ends.
        dashed.flat_map(Layer::points_of).count() / 2
    };
    assert_eq!(marks(&points), 0);
    for point in &mut points {
        let doubled = (2.5..3.5).contains(&point.place.values[0]);
        let found = response(point.place.values[0], 0);
        point.outcome = Ok(SettledResponse {
            doubling: u32::from(doubled),
            ..found
        });
    }
    // At 2.375 and 3.375 degrees.
    assert_eq!(marks(&points), 2);
}
