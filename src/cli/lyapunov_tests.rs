//! The command with a study that is made by hand.

use super::*;
use crate::cli::figures::FigureArgs;
use crate::cli::report::Report;
use crate::dynamics::{DynamicsError, Exponent, LyapunovSpectrum, Motion, Tally};
use crate::pipeline::PipelineError;
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
            scene: Some("chaos-5deg".to_owned()),
            json: Some(self.path("out.json")),
            ..LyapunovArgs::default()
        }
    }

    fn json(&self) -> serde_json::Value {
        let text = std::fs::read(self.path("out.json")).expect("written");
        serde_json::from_slice(&text).expect("JSON")
    }
}

/// Stands for a study: two exponents of 22, the second not known, and a stop that is heeded.
fn pretend(
    scene: &Scene,
    request: &LyapunovRequest,
    watch: Watch<'_, LyapunovProgress>,
) -> Result<SceneLyapunov, Cause> {
    let largest = Exponent {
        value: 60.0,
        half_width: 1.25,
    };
    let unknown = Exponent {
        value: f64::NEG_INFINITY,
        half_width: f64::INFINITY,
    };
    let goes_on = watch(LyapunovProgress {
        phase: Phase::Averaging,
        share: 0.5,
        largest: Some(largest),
    });
    let exponents = vec![largest, unknown];
    let time = match request.goal {
        Goal::Time(time) => time,
        Goal::HalfWidth(_) | Goal::Verdict => 2.0,
    };
    let spectrum = LyapunovSpectrum {
        exponents: exponents.clone(),
        time,
        dimension: 22,
        resolution: 1.0,
        ..LyapunovSpectrum::default()
    };
    Ok(SceneLyapunov {
        study: LyapunovStudy {
            spectrum,
            motion: Motion::Free,
            running: vec![RunningExponents { time, exponents }],
            mean_trace: None,
            ending: if goes_on {
                Ending::Reached
            } else {
                Ending::Stopped
            },
            settled: request.settle.unwrap_or(0.0),
            tally: Tally {
                steps: 1000,
                overrun: 7,
                ..Tally::default()
            },
            followed: time,
            busy_seconds: 1.0,
        },
        tilt: scene.joint().ok().map(|joint| joint.tilt.at(1.0)),
        held: Default::default(),
        transient: scene.duration,
        tolerance: request.tolerance.or(Some(1e-5)),
        omega_1: 10_000.0,
    })
}

const TOOLS: Tools = Tools {
    follow: pretend,
    draw: |name, _| Figure::new("lyapunov", name, 60.0, Vec::new()),
};

#[test]
fn every_number_is_written() {
    let desk = Desk::new();
    let args = LyapunovArgs {
        tilt: Some(6.0),
        duration: Some(120.0),
        settle: Some(30.0),
        until: Some(1.5),
        csv: Some(desk.path("running.csv")),
        figures: Some(desk.path("figures")),
        drawn: FigureArgs {
            format: vec![Format::Svg, Format::Png],
            ..FigureArgs::default()
        },
        ..desk.args()
    };
    execute(&args, &desk.stop, &TOOLS).expect("done");
    let json = desk.json();
    assert_eq!(json["tilt_deg"], 6.0);
    assert_eq!(json["transient_s"], 0.12);
    assert_eq!(json["settle_s"], 0.03);
    assert_eq!(json["averaged_s"], 1.5);
    assert_eq!(json["exponents"][0]["value_per_s"], 60.0);
    assert_eq!(json["exponents"][0]["value_over_omega_1"], 6e-3);
    assert_eq!(json["exponents"][0]["sign"], "positive");
    assert_eq!(json["overrun"], 7);
    assert_eq!(json["tolerance"], 1e-5);
    assert_eq!(json["exponents"][1]["value_per_s"], serde_json::Value::Null);
    let csv = std::fs::read_to_string(desk.path("running.csv")).expect("written");
    assert!(csv.starts_with("time_s,exponent_1_per_s,half_width_1_per_s,exponent_2_per_s"));
    assert!(csv.contains("\n1.5,60,1.25,-inf,inf\n"), "{csv}");
    let drawn = std::fs::read_to_string(desk.path("figures/lyapunov.svg")).expect("drawn");
    assert!(
        drawn.contains("<title>chaos-5deg at 6 deg</title>"),
        "{drawn}"
    );
    let drawn = std::fs::read(desk.path("figures/lyapunov.png")).expect("drawn");
    assert!(drawn.starts_with(b"\x89PNG"));
    assert_eq!(json["files"].as_array().expect("a list").len(), 3);
}

#[test]
fn an_interrupted_study_keeps_its_results() {
    let desk = Desk::new();
    desk.stop.store(true, Ordering::Relaxed);
    let args = LyapunovArgs {
        figures: Some(desk.path("mine.png")),
        ..desk.args()
    };
    let error = execute(&args, &desk.stop, &TOOLS).expect_err("interrupted");
    assert_eq!(error.exit_code(), 130);
    assert_eq!(desk.json()["interrupted"], true);
    assert_eq!(desk.json()["goal_reached"], false);
    assert!(desk.path("mine.png").is_file());
}

/// A study in which all exponents were followed at a tolerance, with a mean trace.
fn balanced(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> LyapunovReport {
    let request = LyapunovRequest {
        count: Count::All,
        settle: None,
        goal: Goal::Time(2.0),
        tolerance,
    };
    let scene = Scene::load("chaos-5deg").expect("preset");
    let mut found = pretend(&scene, &request, &mut |_| true).expect("pretended");
    let one = |&value: &f64| Exponent {
        value,
        half_width: 0.1,
    };
    found.study.spectrum.exponents = values.iter().map(one).collect();
    found.study.spectrum.dimension = if trace.is_some() { values.len() } else { 22 };
    found.study.mean_trace = trace;
    LyapunovReport::new("made", &request, &found, Vec::new())
}

#[test]
fn steps_too_long_for_the_contractions_are_told() {
    // Conservative motion has a trace of zero.
    let still = balanced(&[3.0, 0.0, -3.0], Some(0.0), None).text();
    assert!(!still.contains("too long"), "{still}");
    let off = balanced(&[3.0, 0.0, -30.0], Some(-30.0), Some(1e-9)).text();
    assert!(off.contains("differ by 9.1 %"), "{off}");
    assert!(off.contains("give --tolerance 1e-11"), "{off}");
    // A step takes 2 ms here: the last one shrinks by e^0.6, or e^2.
    let fine = balanced(&[3.0, -300.0], None, None).text();
    assert!(!fine.contains("resolved"), "{fine}");
    let coarse = balanced(&[3.0, -1000.0], None, None).text();
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
    let report = balanced(&[-7.0, -12.7, -6.3, -6.2], None, None);
    assert_eq!(report.unsettled, [2]);
    assert!(
        report
            .text()
            .contains("have not settled (the order of exponents 2)")
    );
    assert!(balanced(&[3.0, 0.0, -3.0], None, None).unsettled.is_empty());
}

#[test]
fn a_study_without_exponents_has_no_numbers() {
    let empty = balanced(&[], None, None);
    let json = serde_json::to_value(&empty).expect("JSON");
    assert!(json["resolution_per_s"].is_null() && json["kaplan_yorke"].is_null());
    assert_eq!(json["attractor"], "undecided");
    let text = empty.text();
    assert!(
        !text.contains("NaN") && !text.contains("nearer to zero"),
        "{text}"
    );
}

#[test]
fn the_words_fit_what_there_is() {
    let found = balanced(&[], None, None);
    assert_eq!(found.words, "undecided: no growth was averaged");
    let told = |values: &[f64], dimension, motion| {
        let study = LyapunovStudy {
            spectrum: LyapunovSpectrum {
                exponents: values
                    .iter()
                    .map(|&value| Exponent {
                        value,
                        half_width: 0.1,
                    })
                    .collect(),
                time: 10.0,
                dimension,
                resolution: 0.5,
                kaplan_yorke: None,
            },
            motion,
            ..LyapunovStudy::stopped(dimension)
        };
        let scene = SceneLyapunov {
            study,
            tilt: None,
            held: Default::default(),
            transient: 0.0,
            tolerance: None,
            omega_1: 1.0,
        };
        let request = LyapunovRequest {
            count: Count::All,
            settle: None,
            goal: Goal::Verdict,
            tolerance: None,
        };
        let report = LyapunovReport::new("made", &request, &scene, Vec::new());
        (report.attractor, report.words)
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
    let too_many = Tools {
        follow: |_, _, _| {
            let fault = DynamicsError::Width {
                asked: 23,
                dimension: 22,
            };
            Err(PipelineError::from(fault).into())
        },
        ..TOOLS
    };
    let error = execute(&desk.args(), &desk.stop, &too_many).expect_err("refused");
    assert_eq!(error.exit_code(), 2);
    let said = error.to_string();
    assert!(
        said.contains("`--exponents` = 23") && said.contains("give 1 to 22"),
        "{said}"
    );
    let fault = Tools {
        follow: |_, _, _| Err("the state left the numbers".into()),
        ..TOOLS
    };
    let error = execute(&desk.args(), &desk.stop, &fault).expect_err("failed");
    assert_eq!(error.exit_code(), 1);
    assert!(!desk.path("out.json").exists());
}

#[test]
fn bad_input_is_found_before_any_work() {
    let desk = Desk::new();
    std::fs::write(desk.path("file"), "x").expect("written");
    let never = Tools {
        follow: |_, _, _| panic!("no work must be done"),
        ..TOOLS
    };
    let bad = [
        LyapunovArgs {
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
            scene: Some("chaos".to_owned()),
            ..desk.args()
        },
    ];
    for args in bad {
        let error = execute(&args, &desk.stop, &never).expect_err("refused");
        assert_eq!(error.exit_code(), 2, "{error}");
    }
}

#[test]
fn values_have_as_many_places_as_they_are_worth() {
    let brief = |value, half_width| in_brief(Exponent { value, half_width });
    assert_eq!(brief(61.237, 1.25), "61.2 +- 1.2");
    assert_eq!(brief(-1234.5, 31.0), "-1234 +- 31");
    assert_eq!(brief(1.0, f64::INFINITY), "1.000 +- ?");
    assert_eq!(brief(f64::NEG_INFINITY, 0.0), "-infinite +- 0.000");
}
