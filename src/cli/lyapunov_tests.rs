//! The command with a small system, and what is said of studies that are made by hand.

use super::*;
use crate::cli::common_args::SceneArgs;
use crate::cli::figures::FigureArgs;
use crate::dynamics::{Exponent, LyapunovSpectrum, Motion, Tally};
use crate::study::lyapunov::{LyapunovStudy, RunningExponents};

struct Desk {
    folder: tempfile::TempDir,
    stop: AtomicBool,
}

impl Desk {
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
    let desk = Desk::new();
    let args = LyapunovArgs {
        duration: Some(120.0),
        settle: Some(30.0),
        until: Some(1.5),
        tolerance: Some(1e-7),
        csv: Some(desk.path("running.csv")),
        figures: Some(desk.path("figures")),
        drawn: FigureArgs {
            format: vec![Format::Svg, Format::Png],
            ..FigureArgs::default()
        },
        ..desk.args()
    };
    execute(&args, &desk.stop).expect("done");
    let json = desk.json();
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
    let csv = std::fs::read_to_string(desk.path("running.csv")).expect("written");
    assert!(csv.starts_with("time_s,exponent_1_per_s,half_width_1_per_s,exponent_2_per_s"));
    assert_eq!(csv.lines().count(), running.len() + 1);
    let drawn = std::fs::read_to_string(desk.path("figures/lyapunov.svg")).expect("drawn");
    assert!(
        drawn.contains("<title>Lyapunov exponents of impact-oscillator</title>"),
        "{drawn}"
    );
    let drawn = std::fs::read(desk.path("figures/lyapunov.png")).expect("drawn");
    assert!(drawn.starts_with(b"\x89PNG"));
    assert_eq!(json["files"].as_array().expect("a list").len(), 3);
}

#[test]
fn what_collapses_or_is_not_known_is_written_as_such() {
    let running = [RunningExponents {
        time: 1.5,
        exponents: exponents(&[(60.0, 1.25), (f64::NEG_INFINITY, f64::INFINITY)]),
    }];
    assert!(csv(&running).contains("\n1.5,60,1.25,-inf,inf\n"));
    let mut found = study(&[60.0, f64::NEG_INFINITY], None, None);
    found.tilt = Some(0.1);
    let json = serde_json::to_value(Found::new(Goal::Verdict, &found)).expect("JSON");
    assert_eq!(json["tilt_rad"], 0.1);
    assert_eq!(json["exponents_per_s"][0]["value"], 60.0);
    assert_eq!(json["exponents_over_omega_1"][0]["value"], 6e-3);
    assert_eq!(json["signs"][0], "positive");
    assert_eq!(json["overrun"], 7);
    assert!(json["exponents_per_s"][1]["value"].is_null());
}

#[test]
fn an_interrupted_study_keeps_its_results() {
    let desk = Desk::new();
    desk.stop.store(true, Ordering::Relaxed);
    let args = LyapunovArgs {
        figures: Some(desk.path("mine.png")),
        ..desk.args()
    };
    let error = execute(&args, &desk.stop).expect_err("interrupted");
    assert_eq!(error.exit_code(), 130);
    assert_eq!(desk.json()["interrupted"], true);
    assert_eq!(desk.json()["goal_reached"], false);
    assert!(desk.path("mine.png").is_file());
}

fn exponents(values: &[(f64, f64)]) -> Vec<Exponent> {
    let values = values.iter();
    values
        .map(|&(value, half_width)| Exponent { value, half_width })
        .collect()
}

/// A study of 2 s in 1000 steps, 7 of which ran over events; with a trace, of all exponents.
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
            tally: Tally {
                steps: 1000,
                overrun: 7,
                ..Tally::default()
            },
            followed: 2.0,
            busy_seconds: 1.0,
            ..LyapunovStudy::stopped(dimension)
        },
        tilt: None,
        held: Default::default(),
        transient: 0.12,
        tolerance,
        omega_1: 10_000.0,
    }
}

/// What is said of such a study.
fn said(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> String {
    let found = study(values, trace, tolerance);
    text("made", &Found::new(Goal::Time(2.0), &found))
}

#[test]
fn steps_too_long_for_the_contractions_are_told() {
    // Conservative motion has a trace of zero.
    let still = said(&[3.0, 0.0, -3.0], Some(0.0), Some(1e-5));
    assert!(!still.contains("too long"), "{still}");
    let off = said(&[3.0, 0.0, -30.0], Some(-30.0), Some(1e-9));
    assert!(off.contains("differ by 9.1 %"), "{off}");
    assert!(off.contains("give --tolerance 1e-11"), "{off}");
    // A step takes 2 ms here: the last one shrinks by e^0.6, or e^2.
    let fine = said(&[3.0, -300.0], None, Some(1e-5));
    assert!(!fine.contains("resolved"), "{fine}");
    let coarse = said(&[3.0, -1000.0], None, Some(1e-5));
    assert!(
        coarse.contains("shrinks by e^2.0 in a mean step; give --tolerance 5e-8"),
        "{coarse}"
    );
    assert!(
        coarse.contains("7 of 1000 steps ran over events"),
        "{coarse}"
    );
}

#[test]
fn vectors_that_have_not_settled_are_told() {
    // The half widths are 0.1.
    let found = study(&[-7.0, -12.7, -6.3, -6.2], None, Some(1e-5));
    let result = Found::new(Goal::Verdict, &found);
    assert_eq!(result.unsettled, [2]);
    assert!(text("made", &result).contains("have not settled (the order of exponents 2)"));
    let found = study(&[3.0, 0.0, -3.0], None, Some(1e-5));
    assert!(Found::new(Goal::Verdict, &found).unsettled.is_empty());
}

#[test]
fn a_study_without_exponents_has_no_numbers() {
    let found = SceneLyapunov {
        study: LyapunovStudy::stopped(22),
        ..study(&[], None, Some(1e-5))
    };
    let result = Found::new(Goal::Verdict, &found);
    let json = serde_json::to_value(&result).expect("JSON");
    assert!(json["resolution_per_s"].is_null() && json["kaplan_yorke"].is_null());
    assert_eq!(json["attractor"], "undecided");
    assert_eq!(result.reading.words, "undecided: no growth was averaged");
    let text = text("made", &result);
    assert!(
        !text.contains("NaN") && !text.contains("nearer to zero"),
        "{text}"
    );
}

#[test]
fn the_words_fit_what_there_is() {
    let told = |values: &[f64], dimension, motion| {
        let mut found = study(values, None, None);
        let spectrum = &mut found.study.spectrum;
        (spectrum.time, spectrum.dimension, spectrum.resolution) = (10.0, dimension, 0.5);
        found.study.motion = motion;
        let reading = Found::new(Goal::Verdict, &found).reading;
        (reading.attractor, reading.words)
    };
    let check = |values: &[f64], dimension, motion, name: &str, said: &str| {
        let (attractor, words) = told(values, dimension, motion);
        assert_eq!((attractor, words.as_str()), (name, said));
    };
    check(
        &[0.0, 0.0],
        2,
        Motion::Free,
        "torus",
        "torus of 2 tones: 2 exponents are zero",
    );
    check(
        &[0.0, -3.0],
        4,
        Motion::Free,
        "cycle",
        "limit cycle: one exponent is zero, the others are negative",
    );
    check(
        &[0.0, -3.0],
        2,
        Motion::Driven,
        "torus",
        "torus of 2 tones: one tone is the drive's; one exponent is zero, the others are negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Driven,
        "in-step",
        "in step with its drive: every exponent is negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Free,
        "rest",
        "rest: every exponent is negative",
    );
    check(
        &[9.0, -3.0],
        2,
        Motion::Still,
        "unstable-equilibrium",
        "rests on an unstable equilibrium: it does not move, but the least push would grow",
    );
}

#[test]
fn more_exponents_than_there_are_is_bad_input() {
    let desk = Desk::new();
    let args = LyapunovArgs {
        exponents: Some(Count::Largest(23)),
        ..desk.args()
    };
    let error = execute(&args, &desk.stop).expect_err("refused");
    assert_eq!(error.exit_code(), 2);
    let said = error.to_string();
    assert!(
        said.contains("`--exponents` = 23") && said.contains("give 1 to 2"),
        "{said}"
    );
    assert!(!desk.path("out.json").exists());
    assert_eq!(failure("the state left the numbers".into()).exit_code(), 1);
}

#[test]
fn bad_input_is_found_before_any_work() {
    let desk = Desk::new();
    std::fs::write(desk.path("file"), "x").expect("written");
    let bad = [
        LyapunovArgs {
            scene: SceneArgs {
                scene: Some("chaos-5deg".to_owned()),
            },
            tilt: Some(91.0),
            ..desk.args()
        },
        LyapunovArgs {
            tolerance: Some(0.5),
            ..desk.args()
        },
        LyapunovArgs {
            csv: desk.args().json,
            ..desk.args()
        },
        // The figure would be `lyapunov.png` in the folder.
        LyapunovArgs {
            csv: Some(desk.path("lyapunov.png")),
            figures: Some(desk.path(".")),
            ..desk.args()
        },
        LyapunovArgs {
            csv: Some(desk.path("new")),
            figures: Some(desk.path("new")),
            ..desk.args()
        },
        LyapunovArgs {
            csv: Some("-".into()),
            json: Some("-".into()),
            ..desk.args()
        },
        LyapunovArgs {
            figures: Some(desk.path("file")),
            ..desk.args()
        },
        LyapunovArgs {
            figures: Some(desk.path("absent/out.png")),
            ..desk.args()
        },
        LyapunovArgs {
            scene: SceneArgs {
                scene: Some("chaos".to_owned()),
            },
            ..desk.args()
        },
    ];
    for args in bad {
        let error = execute(&args, &desk.stop).expect_err("refused");
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(!desk.path("out.json").exists());
    }
}
