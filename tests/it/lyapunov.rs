//! `squeakscope lyapunov`: exit codes, JSON, figure, interruption.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

fn squeakscope(folder: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command
        .current_dir(folder)
        .arg("lyapunov")
        .args(arguments)
        .assert()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("temporary folder")
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).expect("written")).expect("JSON")
}

#[test]
fn a_short_run_writes_consistent_outputs() {
    let folder = folder();
    let arguments = [
        "doubled-torus-3deg",
        "--duration",
        "100",
        "--settle",
        "2",
        "--average-time",
        "0.01",
        "--json",
        "out.json",
        "--csv",
        "out.csv",
        "--figures",
        "figures",
    ];
    let assert = squeakscope(folder.path(), &arguments).success().stderr("");
    let text = String::from_utf8(assert.get_output().stdout.clone()).expect("text");
    assert!(text.starts_with("doubled-torus-3deg at 3 deg: "), "{text}");

    let found = json(&folder.path().join("out.json"));
    assert_eq!(found["tilt_rad"], 3.0_f64.to_radians());
    assert_eq!(found["interrupted"], false);
    assert_eq!(found["goal"], "time");
    assert_eq!(found["goal_reached"], true);
    assert_eq!(found["dimension"], 22);
    let exponents = found["exponents_per_s"].as_array().expect("a list");
    assert_eq!(exponents.len(), 22);
    let averaged = found["averaged_s"].as_f64().expect("a number");
    assert!((averaged - 0.01).abs() < 2e-4, "{averaged}");
    let omega_1 = found["omega_1_rad_per_s"].as_f64().expect("a number");
    assert!(
        (omega_1 / std::f64::consts::TAU - 1698.0).abs() < 0.1,
        "{omega_1}"
    );
    let value = |exponent: &serde_json::Value| exponent["value"].as_f64().expect("a number");
    let scaled = found["exponents_over_omega_1"].as_array();
    for (exponent, scaled) in exponents.iter().zip(scaled.expect("a list")) {
        let error = value(scaled) * omega_1 - value(exponent);
        assert!(error.abs() < 1e-9 * value(exponent).abs());
    }
    let sum: f64 = exponents.iter().map(value).sum();
    let expected = found["sum_per_s"].as_f64().expect("a number");
    assert!((sum - expected).abs() < 1e-6 * expected.abs());
    let rows = std::fs::read_to_string(folder.path().join("out.csv")).expect("written");
    let running = found["running"].as_array().expect("a list");
    assert_eq!(rows.lines().count(), 1 + running.len());
    let png = std::fs::read(folder.path().join("figures/lyapunov.png")).expect("drawn");
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn json_replaces_the_table_on_stdout() {
    let folder = folder();
    let arguments = [
        "doubled-torus-3deg",
        "--exponents",
        "2",
        "--duration",
        "2",
        "--settle",
        "1",
        "--average-time",
        "0.004",
        "--json",
        "-",
    ];
    let assert = squeakscope(folder.path(), &arguments).success();
    let found: serde_json::Value =
        serde_json::from_slice(&assert.get_output().stdout).expect("JSON and nothing else");
    assert_eq!(
        found["exponents_per_s"].as_array().expect("a list").len(),
        2
    );
    assert_eq!(found["sum_per_s"], serde_json::Value::Null);
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 0);
}

#[test]
fn csv_replaces_the_table_on_stdout() {
    let folder = folder();
    let arguments = ["doubled-torus-3deg", "--exponents", "1", "--duration", "2"];
    let more = ["--settle", "1", "--average-time", "0.004", "--csv", "-"];
    let assert = squeakscope(folder.path(), &[&arguments[..], &more[..]].concat()).success();
    let text = String::from_utf8(assert.get_output().stdout.clone()).expect("text");
    let mut lines = text.lines();
    let heading = lines.next().expect("a heading");
    assert_eq!(heading, "time_s,exponent_1_per_s,half_width_1_per_s");
    let times: Vec<f64> = lines
        .map(|line| line.split(',').next().unwrap().parse().expect("a number"))
        .collect();
    assert!(
        !times.is_empty() && times.is_sorted_by(|a, b| a < b),
        "{times:?}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 0);
}

#[test]
fn invalid_input_is_rejected_in_one_line() {
    let folder = folder();
    std::fs::write(folder.path().join("file"), "x").expect("written");
    let rejected: [(&[&str], &str); 12] = [
        (&["chaos-5"], "did you mean `chaos-5deg`?"),
        (
            &["chaos-5deg", "--tilt", "91"],
            "a number from -90 to 90 deg",
        ),
        (&["chaos-5deg", "--tolerance", "1"], "`time.tolerance` = 1"),
        (
            &["chaos-5deg", "--exponents", "23"],
            "--exponents 23: the system has 22 exponents",
        ),
        (
            &["chaos-5deg", "--exponents", "0"],
            "a whole number of at least 1, or `all`",
        ),
        (&["chaos-5deg", "--average-time", "0"], "a number above 0"),
        (
            &["chaos-5deg", "--target-half-width", "nan"],
            "a number above 0",
        ),
        (
            &[
                "chaos-5deg",
                "--average-time",
                "1",
                "--target-half-width",
                "1",
            ],
            "cannot be used with",
        ),
        (&["chaos-5deg", "--figures", "file"], "`file` (--figures)"),
        (
            &["chaos-5deg", "--json", "out"],
            "give a name that ends in .json",
        ),
        (
            &["chaos-5deg", "--figures", ".", "--csv", "lyapunov.png"],
            "give a name that ends in .csv",
        ),
        (
            &["chaos-5deg", "--json", "-", "--csv", "-"],
            "used for two outputs",
        ),
    ];
    for (arguments, expected) in rejected {
        let assert = squeakscope(folder.path(), arguments).code(2).stdout("");
        let message = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
        assert!(message.starts_with("error: "), "{message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
        assert!(!message.contains("simulation stopped"), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1);
}

/// Ctrl-C: the exit code of an interruption, and the results obtained so far.
#[cfg(unix)]
#[test]
fn an_interruption_keeps_the_results_so_far() {
    let folder = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
        .current_dir(folder.path())
        .args([
            "lyapunov",
            "chaos-5deg",
            "--exponents",
            "1",
            "--duration",
            "1",
        ])
        .args(["--average-time", "100000", "--json", "out.json"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    std::thread::sleep(Duration::from_millis(1500));
    let signalled = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill is there");
    assert!(signalled.success());
    assert_eq!(child.wait().expect("ended").code(), Some(130));
    let found = json(&folder.path().join("out.json"));
    assert_eq!(found["interrupted"], true);
    assert_eq!(found["goal_reached"], false);
    let averaged = found["averaged_s"].as_f64().expect("a number");
    assert!(averaged < 1e4, "{averaged}");
    // On a busy machine the interruption may come before the first result.
    let exponents = found["exponents_per_s"].as_array().expect("a list");
    assert_eq!(exponents.is_empty(), averaged == 0.0);
}
