//! A recording of a made-up sweep, read back from the file.

use super::*;
use crate::{
    analysis::{RecurrenceImage, Regime},
    dynamics::{Exponent, LyapunovSpectrum},
    pipeline::message::SpectralLine,
    record::{portrait::Field, tests::read},
};

/// A motion of one frequency, or at rest.
fn response(regime: Regime, amplitude: f64) -> ResponseView {
    let moves = regime != Regime::Silent;
    let wave = |phase: f64| {
        let size = if moves { amplitude } else { 0.0 };
        let values = (0..400).map(move |k| (size * (0.1 * f64::from(k) + phase).sin()) as f32);
        values.collect::<Vec<f32>>()
    };
    let exponent = |value: f64, half_width: f64| Exponent { value, half_width };
    ResponseView {
        transient: 0.06,
        settled: moves,
        regime,
        confidence: 0.9,
        amplitude,
        rms_velocity: 1e4 * amplitude,
        maxima: if moves {
            vec![amplitude; 40]
        } else {
            Vec::new()
        },
        section: match moves {
            true => vec![[-amplitude, amplitude], [-0.9 * amplitude, amplitude]],
            false => Vec::new(),
        },
        lines: vec![SpectralLine {
            frequency: 4100.0,
            amplitude,
            label: "f1".to_owned(),
        }],
        exponents: Some(LyapunovSpectrum {
            exponents: vec![exponent(12.0, 3.0), exponent(f64::NEG_INFINITY, 0.0)],
            time: 0.2,
            dimension: 22,
            resolution: 5.0,
            kaplan_yorke: None,
        }),
        measures: None,
        unstable: Some(vec![UnstableMode {
            label: "2nd bending".to_owned(),
            frequency: 4090.0,
            growth: 55.0,
        }]),
        motion: Some(MotionView {
            dt: 5e-6,
            displacement: wave(0.0),
            velocity: wave(1.5).iter().map(|v| 1e4 * v).collect(),
            bin: 5.0,
            spectrum: vec![1e-12; 4001],
        }),
        recurrence: moves.then(|| RecurrenceImage {
            window: 5e-3,
            size: 32,
            distance: vec![100; 1024],
            recurrent: vec![0; 1024],
            threshold: Some(1e-7),
            rate: 0.1,
            lag: 60e-6,
            dimension: 5,
        }),
    }
}

/// Up: rest, a tone, nothing, not done; down: all of one kind but the last.
fn sweep() -> SweepView {
    let point = |value: f64, outcome: Result<ResponseView, &str>| PointView {
        value,
        from: Some(value - 0.5).filter(|from| *from >= 1.0),
        outcome: outcome.map_err(str::to_owned),
    };
    let tone = |amplitude| Ok(response(Regime::Periodic, amplitude));
    let up = vec![
        point(1.0, Ok(response(Regime::Silent, 1e-11))),
        point(1.5, tone(1e-6)),
        point(2.0, Err("it fell over")),
    ];
    let down = vec![
        point(1.0, tone(2e-6)),
        point(1.5, tone(2e-6)),
        point(2.0, tone(2e-6)),
        point(2.5, Ok(response(Regime::Chaotic, 1e-6))),
    ];
    let start = |key: &str, points| StartView {
        key: key.to_owned(),
        words: format!("continued {key}"),
        points,
    };
    SweepView {
        scene: "test".to_owned(),
        title: "A test".to_owned(),
        about: "Made up.".to_owned(),
        scene_text: "duration_ms = 1".to_owned(),
        command: "squeakscope sweep test".to_owned(),
        letter: "u",
        lag: 60e-6,
        parameter: ParameterView {
            name: "tilt".to_owned(),
            unit: "deg".to_owned(),
            label: "tilt of the load, deg".to_owned(),
        },
        values: vec![1.0, 1.5, 2.0, 2.5, 3.0],
        starts: vec![start("up", up), start("down", down)],
        body: Some(BodyView {
            outline: crate::record::demo::joint().outline,
            modes: vec![ShapeView {
                name: "1st bending pair".to_owned(),
                frequency: 1698.0,
                mode: 0,
                turns: false,
            }],
        }),
    }
}

#[test]
fn a_recording_holds_every_entity_at_every_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.rrd");
    save_sweep(&path, &sweep()).unwrap();
    let (entities, blueprint) = read(&path, "tilt, mdeg");
    assert!(blueprint > 20, "a blueprint is there: {blueprint} chunks");
    for start in ["up", "down"] {
        let root = paths::Root::of_start(start);
        for path in [
            paths::POINT_WORDS,
            paths::DIAGRAM_CURSOR,
            paths::PORTRAIT_TRAIL,
            paths::PORTRAIT_NOW,
            paths::EMBEDDING_TRAIL,
            paths::SECTION_POINTS,
            paths::SPECTRUM_CURVE,
            paths::SPECTRUM_PEAKS,
            paths::SPECTRUM_NAMES,
            paths::SPECTRUM_STEMS,
            paths::RECURRENCE_CAPTION,
            paths::EXPONENTS_RUNNING,
            paths::EXPONENTS_ZERO,
            &paths::note(paths::PORTRAIT),
            &paths::note(paths::SECTION),
            &paths::note(paths::SPECTRUM),
        ] {
            let entity = &entities[&root.at(path)];
            // At 3 deg there is no point at all.
            assert_eq!(entity.rows, 4, "{path}");
            assert_eq!(entity.range, Some((1000, 2500)), "{path}");
        }
        for path in [paths::DIAGRAM_POINTS, paths::DIAGRAM_KEY] {
            assert_eq!(entities[&root.at(path)].rows, 0, "{path} is static");
        }
        for axes in [
            paths::DIAGRAM_AXES,
            paths::PORTRAIT_AXES,
            paths::SECTION_AXES,
            paths::SPECTRUM_AXES,
        ] {
            let axes = paths::axis_labels(&root.at(axes));
            assert!(entities.contains_key(&axes), "{axes}");
        }
    }
    // A picture and its place for the tone; three times nothing.
    assert!(entities["sweep/up/recurrence/image"].rows >= 5);
    assert!(entities.contains_key(paths::ABOUT));
    assert!(entities.contains_key(&paths::mode_shape(0)));
    assert!(entities.contains_key(paths::SHAPE_NAMES));
    let run = entities
        .iter()
        .find(|(path, _)| path.contains("properties") && path.ends_with(paths::RUN_PROPERTY));
    let (_, run) = run.expect("the sweep's properties");
    for field in ["scene_text", "command", "rerun_version"] {
        let found = run.components.iter().any(|name| name.contains(field));
        assert!(found, "{field}: {:?}", run.components);
    }
    // Only the recording is left.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_is_not_there_is_told() {
    let sweep = sweep();
    let [up, down] = &sweep.starts[..] else {
        panic!("two starts");
    };
    let told = |start: &StartView, value| words::point(&sweep, start, value, start.at(value));
    let tone = told(up, 1.5);
    for part in [
        "## Tilt 1.5 deg",
        "*Continued up*",
        "### Periodic",
        "90 % sure",
        "settled state at 1 deg",
        "Settled after 60 ms",
        "| f1 | 4100.0 | 1 µm |",
        "| λ1 | 12 ± 3 | above zero |",
        "**chaos**",
        "| 2nd bending | 4090.0 | 55 |",
    ] {
        assert!(tone.contains(part), "{part} in {tone}");
    }
    let rest = told(up, 1.0);
    assert!(rest.contains("own kick") && rest.contains("**Not settled**"));
    let none = told(up, 2.0);
    assert!(none.contains("No response") && none.contains("it fell over"));
    assert!(told(up, 2.5).contains("Not computed yet"));
    assert!(told(down, 2.5).contains("### Chaotic"));
    let about = words::about(&sweep, "tilt, mdeg");
    assert!(about.contains("| 2 | no response | periodic |"), "{about}");
    assert!(about.contains("| 1 | silent\\* | periodic |"), "{about}");
}

#[test]
fn points_at_a_value_share_their_scales() {
    let sweep = sweep();
    let scope = Scope::new(&sweep);
    let found = |value: f64| -> Vec<&ResponseView> {
        let points = sweep.starts.iter().filter_map(|start| start.at(value));
        points
            .filter_map(|point| point.outcome.as_ref().ok())
            .collect()
    };
    let ends = |value: f64| Field::new(scope.reach(&found(value))).plot.x.high;
    assert_eq!((ends(1.0), ends(2.5)), (3.0, 1.5));
    // Silence is drawn small: a hundredth of the largest motion, in nm.
    assert!((ends(3.0) - 30.0).abs() < 1e-9, "{}", ends(3.0));
    // Tones are points: the field is no smaller than a share of the motion.
    let (plot, unit) = scope.section(&found(1.0));
    assert_eq!(unit.symbol, "µm");
    assert!(plot.x.low < -2.0 && plot.x.high > -1.8 && plot.x.high - plot.x.low > 0.5);
    assert_eq!(scope.exponents, 2);
    let [low, high] = scope.exponent_range;
    assert!(low < -1.0 && (15.0..20.0).contains(&high));
    assert_eq!(scope.spectrum.plot.x.high, 5.0);
    // With nothing at all there still is a plot.
    let none = SweepView {
        values: Vec::new(),
        starts: Vec::new(),
        ..sweep.clone()
    };
    let empty = Scope::new(&none);
    assert!(empty.diagram.0.x.low < empty.diagram.0.x.high);
    assert!(empty.section(&[]).0.x.low < 0.0);
}

#[test]
fn a_recording_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let error = save_sweep(folder.path(), &sweep()).unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}
