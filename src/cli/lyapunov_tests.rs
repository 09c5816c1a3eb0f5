//! The command with a small system, and the report on constructed results.

use super::*;
use crate::cli::common_args::SceneArgs;
use crate::cli::figures::FigureArgs;
use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Motion, SolverStats, Stability};
use crate::pipeline::message::MotionSegment;
use crate::study::lyapunov::{LyapunovStudy, RunningExponents};

struct TestFolder {
    folder: tempfile::TempDir,
    stop: AtomicBool,
}

impl TestFolder {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("temporary folder"),
            stop: AtomicBool::new(false),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn args(&self) -> LyapunovArgs {
        LyapunovArgs {
            scene: SceneArgs {
                scene: Some("impact-oscillator".to_owned()),
                ..SceneArgs::default()
            },
            json: Some(self.path("out.json")),
            ..LyapunovArgs::default()
        }
    }

    fn json(&self) -> serde_json::Value {
        let text = std::fs::read(self.path("out.json")).expect("written");
        serde_json::from_slice(&text).expect("JSON")
    }
}

#[test]
fn every_number_is_written() {
    let test = TestFolder::new();
    let args = LyapunovArgs {
        duration: Some(120.0),
        settle: Some(30.0),
        average_time: Some(1.5),
        tolerance: Some(1e-7),
        csv: Some(test.path("running.csv")),
        figures: Some(test.path("figures")),
        drawn: FigureArgs {
            format: vec![Format::Svg, Format::Png],
            ..FigureArgs::default()
        },
        ..test.args()
    };
    execute(&args, &test.stop).expect("success");
    let json = test.json();
    assert_eq!(json["scene"], "impact-oscillator");
    assert_eq!(json["tilt_rad"], serde_json::Value::Null);
    assert_eq!(json["transient_s"], 0.12);
    let time = |name: &str| json[name].as_f64().expect("a number");
    assert!((time("settle_s") - 0.03).abs() < 1e-3);
    assert!((time("averaged_s") - 1.5).abs() < 1e-3);
    let exponents = json["exponents_per_s"].as_array().expect("a list");
    assert_eq!(json["dimension"], exponents.len());
    assert_eq!(
        json["signs"].as_array().expect("a list").len(),
        exponents.len()
    );
    let scaled = time("omega_1_rad_per_s")
        * json["exponents_over_omega_1"][0]["value"]
            .as_f64()
            .expect("a number");
    let first = exponents[0]["value"].as_f64().expect("a number");
    assert!((scaled - first).abs() <= 1e-12 * first.abs());
    assert_eq!(json["tolerance"], 1e-7);
    assert_eq!(json["goal"], "time");
    assert_eq!(json["goal_reached"], true);
    let running = json["running"].as_array().expect("a list");
    let last = &running[running.len() - 1];
    assert_eq!(last["exponents_per_s"], json["exponents_per_s"]);
    let csv = std::fs::read_to_string(test.path("running.csv")).expect("written");
    assert!(csv.starts_with("time_s,exponent_1_per_s,half_width_1_per_s,exponent_2_per_s"));
    assert_eq!(csv.lines().count(), running.len() + 1);
    let drawn = std::fs::read_to_string(test.path("figures/lyapunov.svg")).expect("drawn");
    assert!(
        drawn.contains("<title>Lyapunov exponents of impact-oscillator</title>"),
        "{drawn}"
    );
    let drawn = std::fs::read(test.path("figures/lyapunov.png")).expect("drawn");
    assert!(drawn.starts_with(b"\x89PNG"));
    assert_eq!(json["files"].as_array().expect("a list").len(), 3);
}

#[test]
fn non_finite_exponents_are_inf_in_csv_and_null_in_json() {
    let running = [RunningExponents {
        time: 1.5,
        exponents: exponents(&[(60.0, 1.25), (f64::NEG_INFINITY, f64::INFINITY)]),
    }];
    assert!(csv(&running).contains("\n1.5,60,1.25,-inf,inf\n"));
    let mut found = study(&[60.0, f64::NEG_INFINITY], None, None);
    found.tilt = Some(0.1);
    let json =
        serde_json::to_value(LyapunovResult::new(Goal::Classification, &found)).expect("JSON");
    assert_eq!(json["tilt_rad"], 0.1);
    assert_eq!(json["exponents_per_s"][0]["value"], 60.0);
    assert_eq!(json["exponents_over_omega_1"][0]["value"], 6e-3);
    assert_eq!(json["signs"][0], "positive");
    assert_eq!(json["steps_without_event_location"], 7);
    assert!(json["exponents_per_s"][1]["value"].is_null());
}

#[test]
fn an_interrupted_study_keeps_its_results() {
    let test = TestFolder::new();
    test.stop.store(true, Ordering::Relaxed);
    let args = LyapunovArgs {
        figures: Some(test.path("mine.png")),
        ..test.args()
    };
    let error = execute(&args, &test.stop).expect_err("interrupted");
    assert_eq!(error.exit_code(), 130);
    assert_eq!(test.json()["interrupted"], true);
    assert_eq!(test.json()["goal_reached"], false);
    assert!(test.path("mine.png").is_file());
}

fn exponents(values: &[(f64, f64)]) -> Vec<Exponent> {
    let values = values.iter();
    values
        .map(|&(value, half_width)| Exponent { value, half_width })
        .collect()
}

/// A study of 2 s in 1000 steps, of which 7 passed events. With a trace, all exponents are computed.
fn study(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> SceneLyapunov {
    let dimension = if trace.is_some() { values.len() } else { 22 };
    let values: Vec<_> = values.iter().map(|&value| (value, 0.1)).collect();
    let spectrum = LyapunovSpectrum {
        exponents: exponents(&values),
        time: 2.0,
        dimension,
        resolution: 1.0,
        kaplan_yorke: None,
    };
    SceneLyapunov {
        study: LyapunovStudy {
            spectrum,
            motion: Motion::Free,
            mean_trace: trace,
            ending: Ending::Reached,
            stats: SolverStats {
                steps: 1000,
                steps_without_event_location: 7,
                ..SolverStats::default()
            },
            simulated: 2.0,
            busy_seconds: 1.0,
            ..LyapunovStudy::stopped(dimension)
        },
        tilt: None,
        fixed_at: Default::default(),
        transient: 0.12,
        chaotic_transient: None,
        tolerance,
        omega_1: 10_000.0,
    }
}

/// The report on such a study.
fn report_text(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> String {
    let found = study(values, trace, tolerance);
    text("made", &LyapunovResult::new(Goal::Time(2.0), &found))
}

#[test]
fn steps_too_long_for_the_contractions_are_reported() {
    // The trace of a conservative system is zero.
    let conservative = report_text(&[3.0, 0.0, -3.0], Some(0.0), Some(1e-5));
    assert!(!conservative.contains("too long"), "{conservative}");
    let off = report_text(&[3.0, 0.0, -30.0], Some(-30.0), Some(1e-9));
    assert!(
        off.contains("differs from the mean trace by 9.1 %"),
        "{off}"
    );
    assert!(off.contains("set --tolerance 1e-11"), "{off}");
    // The mean step is 2 ms: the last tangent vector shrinks by e^0.6, or by e^2.
    let fine = report_text(&[3.0, -300.0], None, Some(1e-5));
    assert!(!fine.contains("resolved"), "{fine}");
    let coarse = report_text(&[3.0, -1000.0], None, Some(1e-5));
    assert!(
        coarse.contains("shrinks by a factor of e^2.0 per step on average; set --tolerance 5e-8"),
        "{coarse}"
    );
    assert!(coarse.contains("7 of 1000 steps passed events"), "{coarse}");
}

#[test]
fn the_motions_before_the_last_one_are_listed() {
    let mut found = study(&[0.0, -30.0], None, Some(1e-5));
    let segment = |start, end, values: &[f64]| {
        let spectrum = study(values, None, None).study.spectrum;
        MotionSegment {
            start,
            end,
            attractor: spectrum.attractor(),
            spectrum,
        }
    };
    let last = segment(0.83, 2.0, &[0.0, -30.0]);
    found.study.segments = vec![last.clone()];
    let text_of =
        |found: &SceneLyapunov| text("made", &LyapunovResult::new(Goal::Time(2.0), found));
    assert!(!text_of(&found).contains("start, s"));
    found.study.segments = vec![segment(0.31, 0.83, &[240.0, 140.0, 0.0, -30.0]), last];
    found.chaotic_transient = Some(0.83);
    let report = text_of(&found);
    let words = ": chaotic transient of 830 ms, then limit cycle: one exponent is zero";
    assert!(report.contains(words), "{report}");
    assert!(report.contains("0.830  hyperchaos"), "{report}");
    let json = serde_json::to_value(LyapunovResult::new(Goal::Time(2.0), &found)).expect("JSON");
    assert_eq!(json["chaotic_transient_s"], 0.83);
    assert_eq!(json["attractor"], "cycle");
    assert_eq!(json["segments"][0]["attractor"], "hyperchaos");
    assert_eq!(json["segments"][0]["end_s"], 0.83);
    assert_eq!(json["segments"][0]["exponents_per_s"][1]["value"], 140.0);
}

#[test]
fn unaligned_tangent_vectors_are_reported() {
    // The half-widths are 0.1.
    let found = study(&[-7.0, -12.7, -6.3, -6.2], None, Some(1e-5));
    let result = LyapunovResult::new(Goal::Classification, &found);
    assert_eq!(result.unsettled, [2]);
    assert!(text("made", &result).contains("are not aligned (out-of-order exponents: 2)"));
    let found = study(&[3.0, 0.0, -3.0], None, Some(1e-5));
    assert!(
        LyapunovResult::new(Goal::Classification, &found)
            .unsettled
            .is_empty()
    );
}

#[test]
fn a_study_without_exponents_has_no_numbers() {
    let found = SceneLyapunov {
        study: LyapunovStudy::stopped(22),
        ..study(&[], None, Some(1e-5))
    };
    let result = LyapunovResult::new(Goal::Classification, &found);
    let json = serde_json::to_value(&result).expect("JSON");
    assert!(json["resolution_per_s"].is_null() && json["kaplan_yorke"].is_null());
    assert_eq!(json["attractor"], "undecided");
    assert_eq!(
        result.classification.description,
        "undecided: the averaging has not started"
    );
    let text = text("made", &result);
    assert!(
        !text.contains("NaN") && !text.contains("resolution"),
        "{text}"
    );
}

#[test]
fn the_description_has_the_attractor_and_the_reason() {
    let check = |values: &[f64], dimension, motion, expected: Attractor, reason: &str| {
        let mut found = study(values, None, None);
        let spectrum = &mut found.study.spectrum;
        (spectrum.time, spectrum.dimension, spectrum.resolution) = (10.0, dimension, 0.5);
        found.study.motion = motion;
        let classification = LyapunovResult::new(Goal::Classification, &found).classification;
        assert_eq!(found.study.attractor(), expected);
        assert_eq!(classification.attractor, expected);
        assert_eq!(classification.description, format!("{expected}: {reason}"));
    };
    check(
        &[0.0, 0.0],
        2,
        Motion::Free,
        Attractor::Torus(2),
        "2 exponents are zero",
    );
    check(
        &[0.0, -3.0],
        4,
        Motion::Free,
        Attractor::Cycle,
        "one exponent is zero, the others are negative",
    );
    check(
        &[0.0, -3.0],
        2,
        Motion::Driven,
        Attractor::Torus(2),
        "one frequency is that of the drive; one exponent is zero, the others are negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Driven,
        Attractor::PhaseLocked,
        "all exponents are negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Free,
        Attractor::FixedPoint,
        "all exponents are negative",
    );
    check(
        &[9.0, -3.0],
        2,
        Motion::Still,
        Attractor::Equilibrium(Stability::Unstable),
        "the state is constant, but small perturbations grow",
    );
}

#[test]
fn too_many_exponents_are_bad_input() {
    let test = TestFolder::new();
    let args = LyapunovArgs {
        exponents: Some(ExponentCount::Largest(23)),
        ..test.args()
    };
    let error = execute(&args, &test.stop).expect_err("refused");
    assert_eq!(error.exit_code(), 2);
    let message = error.to_string();
    assert!(
        message.contains("--exponents 23") && message.contains("give 1 to 2"),
        "{message}"
    );
    assert!(!test.path("out.json").exists());
    assert_eq!(failure("the state is not finite".into()).exit_code(), 1);
}

#[test]
fn bad_input_is_found_before_any_work() {
    let test = TestFolder::new();
    std::fs::write(test.path("file"), "x").expect("written");
    let bad = [
        LyapunovArgs {
            scene: SceneArgs {
                scene: Some("chaos-5deg".to_owned()),
                ..SceneArgs::default()
            },
            tilt: Some(91.0),
            ..test.args()
        },
        LyapunovArgs {
            tolerance: Some(0.5),
            ..test.args()
        },
        LyapunovArgs {
            csv: test.args().json,
            ..test.args()
        },
        // The figure is also `lyapunov.png` in the folder.
        LyapunovArgs {
            csv: Some(test.path("lyapunov.png")),
            figures: Some(test.path(".")),
            ..test.args()
        },
        LyapunovArgs {
            csv: Some(test.path("new.csv")),
            figures: Some(test.path("new.csv")),
            ..test.args()
        },
        LyapunovArgs {
            csv: Some("-".into()),
            json: Some("-".into()),
            ..test.args()
        },
        LyapunovArgs {
            figures: Some(test.path("file")),
            ..test.args()
        },
        LyapunovArgs {
            figures: Some(test.path("absent/out.png")),
            ..test.args()
        },
        LyapunovArgs {
            scene: SceneArgs {
                scene: Some("chaos".to_owned()),
                ..SceneArgs::default()
            },
            ..test.args()
        },
    ];
    for args in bad {
        let error = execute(&args, &test.stop).expect_err("refused");
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(!test.path("out.json").exists());
    }
}
