//! A recording of a synthetic sweep, read back from the file.

use super::*;
use crate::{
    analysis::{regime::Regime, tones::SpectralLine},
    dynamics::{Exponent, LyapunovSpectrum, SolverStats},
    joint::{BallJoint, NamedMode},
    plot::{
        Color, Layer, Panel, ParameterPanels,
        response::{common_range, phase_portrait, section},
    },
    record::tests::{assert_shown, read},
    scene::{Parameter, Scene},
    study::{
        StabilityAt,
        response::{PhasePortrait, ResponsePlan, SettledResponse},
        sweep::{Axis, Start, SweepPlan},
    },
};

/// A response with one frequency, or without vibration.
fn response(regime: Regime, amplitude: f64) -> SettledResponse {
    let moves = regime != Regime::Silent;
    let wave = |phase: f64| {
        let size = if moves { amplitude } else { 0.0 };
        let values = (0..1400).map(move |k| (size * (0.1 * f64::from(k) + phase).sin()) as f32);
        values.collect::<Vec<f32>>()
    };
    let exponent = |value: f64, half_width: f64| Exponent { value, half_width };
    SettledResponse {
        transient_s: 0.06,
        settled: moves,
        regime,
        confidence: 0.9,
        amplitude_m: amplitude,
        mean_m: 0.0,
        rms_velocity_m_per_s: 1e4 * amplitude,
        peak_velocity_m_per_s: 1.4e4 * amplitude,
        maxima_m: if moves {
            vec![amplitude; 40]
        } else {
            Vec::new()
        },
        section_m: if moves {
            vec![[-amplitude, amplitude], [-0.9 * amplitude, amplitude]]
        } else {
            Vec::new()
        },
        lines: vec![SpectralLine {
            frequency: 4100.0,
            amplitude,
            label: "f1".to_owned(),
        }],
        curves: None,
        doubling: 0,
        broadband_share: 0.0,
        exponents: Some(LyapunovSpectrum {
            exponents: vec![exponent(12.0, 3.0), exponent(f64::NEG_INFINITY, 0.0)],
            time: 0.2,
            dimension: 22,
            resolution: 5.0,
            kaplan_yorke: None,
        }),
        recurrence: None,
        recurrence_periods: crate::analysis::recurrence::RecurrencePeriods::default(),
        linear: Some(StabilityAt {
            tilt: 0.0,
            modes: vec![NamedMode {
                frequency_hz: 4090.0,
                growth: 55.0,
                unstable: true,
                label: "2nd bending".to_owned(),
            }],
        }),
        portrait: Some(PhasePortrait {
            dt_s: 5e-6,
            u_m: wave(0.0),
            v_m_per_s: wave(1.5).iter().map(|v| 1e4 * v).collect(),
            spectrum_bin_hz: 5.0,
            spectrum_m: vec![1e-12; 4001],
        }),
        state: Vec::new(),
        stats: SolverStats::default(),
    }
}

/// Values from 1 to 3 degrees, upward and downward.
fn plan() -> SweepPlan {
    SweepPlan {
        subject: Scene::load("doubled-torus-3deg").unwrap(),
        axes: vec![Axis::new(Parameter::tilt(), [1.0, 1.5, 2.0, 2.5, 3.0])],
        starts: vec![Start::Upward, Start::Downward],
        response: ResponsePlan::default(),
    }
}

/// Upward: silent, periodic, failed, not computed; downward: periodic, except the last.
fn points(plan: &SweepPlan) -> Vec<SweepPoint> {
    let tone = |amplitude| Ok(response(Regime::Periodic, amplitude));
    let of = |start: Start, value: f64| match (start, value) {
        (Start::Upward, 1.0) => Some(Ok(response(Regime::Silent, 1e-11))),
        (Start::Upward, 1.5) => Some(tone(1e-6)),
        (Start::Upward, 2.0) => Some(Err("the solution diverged".to_owned())),
        (Start::Downward, 1.0 | 1.5 | 2.0) => Some(tone(2e-6)),
        (Start::Downward, 2.5) => Some(Ok(response(Regime::Chaotic, 1e-6))),
        _ => None,
    };
    let places = (0..plan.size()).map(|index| plan.place(index));
    let points = places.filter_map(|place| {
        let outcome = of(place.start, place.values[0])?;
        Some(SweepPoint { place, outcome })
    });
    points.collect()
}

fn study<'a>(plan: &'a SweepPlan, points: &'a [SweepPoint]) -> SweepStudy<'a> {
    SweepStudy {
        plan,
        points,
        report: &[],
        command: "squeakscope sweep test",
        ball: None,
    }
}

#[test]
fn a_recording_contains_every_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.rrd");
    let plan = plan();
    let points = points(&plan);
    let ball = BallJoint::new(&plan.subject.joint().unwrap().spec).unwrap();
    let sweep = SweepStudy {
        ball: Some(&ball),
        ..study(&plan, &points)
    };
    save_sweep(&path, &sweep).unwrap();
    assert_shown(&path, "tilt, mdeg");
    let (entities, _) = read(&path, "tilt, mdeg");
    for start in ["upward", "downward"] {
        let root = paths::Root::of_start(start);
        for path in [
            "text",
            paths::PORTRAIT_TRAIL,
            "poincare_section/points",
            "spectrum/curve",
            "bifurcation_diagram/cursor",
            "exponents/cursor",
        ] {
            let entity = &entities[&root.at(path)];
            // There is no point at 3 deg.
            assert_eq!(entity.rows, 4, "{path}");
            assert_eq!(entity.range, Some((1000, 2500)), "{path}");
        }
    }
    // An image and its transform for the periodic motion; three cleared images.
    assert!(entities["sweep/upward/recurrence/image"].rows >= 5);
    let run = entities
        .iter()
        .find(|(path, _)| path.contains("properties") && path.ends_with(paths::RUN_PROPERTY));
    let (_, run) = run.expect("the sweep's properties");
    for field in ["scene_text", "command", "rerun_version"] {
        let found = run.components.iter().any(|name| name.contains(field));
        assert!(found, "{field}: {:?}", run.components);
    }
    // The part file was removed.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn points_are_described() {
    let plan = plan();
    let points = points(&plan);
    let sweep = study(&plan, &points);
    let [up, down] = [Start::Upward, Start::Downward];
    let text = |start, value| description::point(&sweep, start, value, sweep.at(start, value));
    let tone = text(up, 1.5);
    for part in [
        "## Tilt 1.5 deg: upward continuation",
        "**Periodic**, confidence 90 %",
        "Initial state: steady state at 1 deg",
        "Steady state after 60 ms",
        "| f1 | 4100.0 | 1 µm |",
        "| 1 | 12.0 | 3.0 | **positive** |",
        "chaos: one exponent is positive",
        "| 2nd bending | 4090.0 | 55 |",
    ] {
        assert!(tone.contains(part), "{part} in {tone}");
    }
    let rest = text(up, 1.0);
    assert!(rest.contains("kick of the scene") && rest.contains("not in steady state"));
    let none = text(up, 2.0);
    assert!(none.contains("no response") && none.contains("the solution diverged"));
    assert!(text(up, 2.5).contains("not computed yet"));
    assert!(text(down, 2.5).contains("**Chaotic**"));
    let report = [Block::heading("a scene", ""), Block::text("hysteresis")];
    let sweep = SweepStudy {
        report: &report,
        ..sweep
    };
    let about = description::about(&sweep, "tilt, mdeg");
    assert!(about.starts_with("## a scene\n\nhysteresis\n"), "{about}");
}

#[test]
fn points_at_a_value_have_common_scales() {
    let plan = plan();
    let points = points(&plan);
    let scales = SharedScales::new(&study(&plan, &points));
    let found = |value: f64| -> Vec<&SettledResponse> {
        let points = points.iter().filter(|point| point.place.values[0] == value);
        points
            .filter_map(|point| point.outcome.as_ref().ok())
            .collect()
    };
    let ends = |value: f64| {
        let reach = scales.point_scales(&found(value)).0;
        phase_portrait(&[], Some(reach), Color::Ink).x.range[1]
    };
    assert!((ends(1.0) - 3e-6).abs() < 1e-15 && (ends(2.5) - 1.5e-6).abs() < 1e-15);
    // Silence is drawn at 1 % of the largest motion.
    assert!((ends(3.0) - 30e-9).abs() < 1e-18, "{}", ends(3.0));
    assert_eq!(common_range(&[], [1e-6, 1e-3]), [1.5e-6, 1.5e-3]);
    // The axes of a section are at least a fraction of the motion, so a periodic motion is a point.
    let shown = section(&scales.point_scales(&found(1.0)).1, None);
    let [low, high] = shown.x.range.map(|end| 1e6 * end);
    assert_eq!(shown.x.unit.symbol, "µm");
    assert!(low < -2.0 && high > -1.8 && high - low > 0.5);
    assert_eq!(scales.spectrum.x.range[1], 5e3);
    // An empty sweep has valid axes, too.
    let nothing = study(&plan, &[]);
    let empty = SharedScales::new(&nothing);
    let series = StartWriter::new(&nothing, Start::Upward, &empty).series;
    assert!(series.view("diagram").is_some() && series.view("exponents").is_none());
    let shown = section(&empty.point_scales(&[]).1, None);
    assert!(shown.x.range[0] < 0.0);
}

#[test]
fn a_start_shows_its_own_exponents_on_common_axes() {
    let plan = plan();
    let points = points(&plan);
    let exponents = |points: &[SweepPoint], start| {
        ParameterPanels::new(&plan, points, &[start]).exponents(usize::MAX)
    };
    let panels = [Start::Upward, Start::Downward].map(|start| exponents(&points, start));
    let [up, down] = panels.map(|panel| panel.expect("responses with exponents"));
    assert_eq!(up.y, down.y);
    let ends = |panel: &Panel| {
        let intervals = panel.layers.iter().filter(|layer| layer.id == "intervals");
        let ends = intervals.flat_map(Layer::points_of);
        ends.filter(|end| end[1].is_finite()).count()
    };
    // Two and four responses, with one finite exponent each.
    assert_eq!([ends(&up), ends(&down)], [4, 8]);
    assert!(exponents(&[], Start::Upward).is_none());
}

#[test]
fn parameter_names_have_no_units() {
    let name = |parameter: Parameter| {
        let plan = SweepPlan {
            axes: vec![Axis::new(parameter, [1.0, 2.0])],
            ..plan()
        };
        description::parameter(&study(&plan, &[]))
    };
    assert_eq!(name(Parameter::tilt()), "tilt");
    let of = |path: &str| name(Parameter::named(path).unwrap());
    assert_eq!(of("load.load_n"), "load");
    assert_eq!(of("stiffness_factor"), "stiffness factor");
    assert_eq!(of("socket.diameter_mm"), "diameter");
}

#[test]
fn starts_without_points_are_omitted() {
    let plan = plan();
    let points = points(&plan);
    let up: Vec<SweepPoint> = points
        .into_iter()
        .filter(|point| point.place.start == Start::Upward)
        .collect();
    let sweep = study(&plan, &up);
    assert_eq!(sweep.starts().collect::<Vec<_>>(), [Start::Upward]);
    let text = description::point(&sweep, Start::Upward, 2.0, sweep.at(Start::Upward, 2.0));
    assert!(text.contains("steady state at 1.5 deg"));
    // If the neighbouring run failed, the point starts from the scene's kick.
    let failed = |index: usize| SweepPoint {
        place: plan.place(index),
        outcome: Err("the solution diverged".to_owned()),
    };
    let failed = [failed(0), failed(1)];
    let sweep = study(&plan, &failed);
    let second = description::point(&sweep, Start::Upward, 1.5, failed.get(1));
    assert!(second.contains("kick of the scene"), "{second}");
    assert_eq!((sweep.values().len(), sweep.letter()), (5, "u"));
}

#[test]
fn an_unwritable_path_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan();
    let points = points(&plan);
    let error = save_sweep(folder.path(), &study(&plan, &points)).unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}
