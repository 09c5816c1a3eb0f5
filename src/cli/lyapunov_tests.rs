//! The command with a small system.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::*;
use crate::cli::tests::parsed;
use crate::dynamics::Exponent;

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

    /// Runs the command on the impact oscillator, with JSON; `@` in the arguments is the folder.
    fn run(&self, line: &str) -> Result<(), CliError> {
        self.run_scene(&format!("impact-oscillator --json @/out.json {line}"))
    }

    fn run_scene(&self, line: &str) -> Result<(), CliError> {
        let folder = self.folder.path().display().to_string();
        execute(&parsed(&line.replace('@', &folder)), &self.stop)
    }

    fn json(&self) -> serde_json::Value {
        let text = std::fs::read(self.path("out.json")).expect("written");
        serde_json::from_slice(&text).expect("JSON")
    }
}

#[test]
fn every_number_is_written() {
    let test = TestFolder::new();
    let averaging = "--duration 120 --settle 30 --average-time 1.5 --tolerance 1e-7";
    let outputs = "--csv @/running.csv --figures @/figures --format svg,png";
    test.run(&format!("{averaging} {outputs}"))
        .expect("success");
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
fn non_finite_exponents_are_inf_in_csv() {
    let exponent = |value, half_width| Exponent { value, half_width };
    let running = [RunningExponents {
        time: 1.5,
        exponents: vec![
            exponent(60.0, 1.25),
            exponent(f64::NEG_INFINITY, f64::INFINITY),
        ],
    }];
    assert!(csv(&running).contains("\n1.5,60,1.25,-inf,inf\n"));
}

#[test]
fn an_interrupted_study_keeps_its_results() {
    let test = TestFolder::new();
    test.stop.store(true, Ordering::Relaxed);
    let error = test.run("--figures @/mine.png").expect_err("interrupted");
    assert_eq!(error.exit_code(), 130);
    assert_eq!(test.json()["interrupted"], true);
    assert_eq!(test.json()["goal_reached"], false);
    assert!(test.path("mine.png").is_file());
}

#[test]
fn too_many_exponents_are_bad_input() {
    let test = TestFolder::new();
    let error = test.run("--exponents 23").expect_err("refused");
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
    for line in [
        "chaos-5deg --tilt 91",
        "chaos --json @/out.json",
        "impact-oscillator --tolerance 0.5",
        "impact-oscillator --csv @/out.json --json @/out.json",
        // The figure is also `lyapunov.png` in the folder.
        "impact-oscillator --csv @/lyapunov.png --figures @/.",
        "impact-oscillator --csv @/new.csv --figures @/new.csv",
        "impact-oscillator --csv - --json -",
        "impact-oscillator --figures @/file",
        "impact-oscillator --figures @/absent/out.png",
    ] {
        let error = test.run_scene(line).expect_err(line);
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(!test.path("out.json").exists());
    }
}
