//! The command with a study that is made by hand.

use super::*;
use crate::dynamics::{DynamicsError, Exponent, LyapunovSpectrum, Tally};
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
    watch: Watch<'_>,
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
            running: vec![RunningExponents { time, exponents }],
            mean_trace: None,
            ending: if goes_on {
                Ending::Reached
            } else {
                Ending::Stopped
            },
            tally: Tally::default(),
            followed: time,
            busy_seconds: 1.0,
        },
        tilt: scene.joint().ok().map(|joint| joint.tilt.at(1.0)),
        transient: scene.duration,
        settle: request.settle.unwrap_or(0.0),
        omega_1: 10_000.0,
    })
}

const TOOLS: Tools = Tools {
    follow: pretend,
    draw: |name, _| Ok(name.as_bytes().to_vec()),
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
        png: Some(desk.path("figures")),
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
    assert_eq!(json["exponents"][1]["value_per_s"], serde_json::Value::Null);
    let csv = std::fs::read_to_string(desk.path("running.csv")).expect("written");
    assert!(csv.starts_with("time_s,exponent_1_per_s,half_width_1_per_s,exponent_2_per_s"));
    assert!(csv.contains("\n1.5,60,1.25,-inf,inf\n"), "{csv}");
    let drawn = std::fs::read(desk.path("figures/lyapunov.png")).expect("drawn");
    assert_eq!(drawn, b"chaos-5deg at 6 deg");
    assert_eq!(json["files"].as_array().expect("a list").len(), 2);
}

#[test]
fn an_interrupted_study_keeps_its_results() {
    let desk = Desk::new();
    desk.stop.store(true, Ordering::Relaxed);
    let args = LyapunovArgs {
        png: Some(desk.path("mine.png")),
        ..desk.args()
    };
    let error = execute(&args, &desk.stop, &TOOLS).expect_err("interrupted");
    assert_eq!(error.exit_code(), 130);
    assert_eq!(desk.json()["interrupted"], true);
    assert_eq!(desk.json()["goal_reached"], false);
    assert!(desk.path("mine.png").is_file());
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
        LyapunovArgs {
            png: Some(desk.path("file")),
            ..desk.args()
        },
        LyapunovArgs {
            png: Some(desk.path("absent/out.png")),
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
