//! `squeakscope branch` and `stability --sensitivities` from the command line.

use assert_cmd::Command;
use predicates::prelude::*;
use serde_json::Value;

fn squeakscope(folder: &std::path::Path, words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(folder).args(words).assert()
}

const SLOPE: &str = "friction.stribeck_slope_s_per_m=0:12";

#[test]
fn a_branch_has_hopf_points_a_table_and_figures() {
    let test = tempfile::tempdir().unwrap();
    let words = [
        "branch",
        "doubled-torus-3deg",
        "--param",
        SLOPE,
        "--points",
        "9",
        "--equilibria",
        "--out",
        "branch.arrow",
        "--json",
        "branch.json",
        "--figures",
        "figures",
    ];
    squeakscope(test.path(), &words)
        .success()
        .stdout(predicate::str::contains("Hopf").and(predicate::str::contains("critical")));
    let json = std::fs::read(test.path().join("branch.json")).unwrap();
    let json: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["parameter"], "friction.stribeck_slope_s_per_m");
    let points = json["equilibria"].as_array().unwrap();
    assert!(points.len() >= 9);
    assert_eq!(points[0]["stribeck_slope_s_per_m"], 0.0);
    assert_eq!(points[0]["unstable_modes"], 3);
    let bifurcations = json["bifurcations"].as_array().unwrap();
    assert!(!bifurcations.is_empty());
    for hopf in bifurcations {
        assert_eq!(hopf["kind"], "hopf");
        assert!(hopf["frequency_hz"].as_f64().unwrap() > 1000.0);
        assert!(hopf["stribeck_slope_s_per_m"].as_f64().unwrap() > 0.0);
        assert!(hopf["cycle"]["first_lyapunov"].is_number());
    }
    for file in ["branch.arrow", "figures/modes.svg", "figures/modes.png"] {
        assert!(
            test.path().join(file).metadata().unwrap().len() > 0,
            "{file}"
        );
    }
}

#[test]
fn two_parameters_make_a_map() {
    let test = tempfile::tempdir().unwrap();
    let words = [
        "branch",
        "doubled-torus-3deg",
        "--tilt",
        "0:4",
        "--param",
        SLOPE,
        "--points",
        "4",
        "--json",
        "-",
        "--figures",
        "figures",
    ];
    let out = squeakscope(test.path(), &words).success();
    let json: Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
    assert_eq!(json["grid"].as_array().unwrap().len(), 16);
    assert_eq!(json["axes"][0]["parameter"], "load.tilt_deg");
    assert!(!json["curves"].as_array().unwrap().is_empty());
    assert!(test.path().join("figures/stability-map.png").exists());
}

#[test]
fn sensitivities_are_printed_and_drawn() {
    let test = tempfile::tempdir().unwrap();
    let words = [
        "stability",
        "periodic-2deg",
        "--sensitivities",
        // Sensitivities need many bodies.
        "--set",
        "body.element_order=2",
        "--json",
        "out.json",
        "--figures",
        "figures",
    ];
    squeakscope(test.path(), &words)
        .success()
        .stdout(predicate::str::contains("friction.mu_s"));
    let json = std::fs::read(test.path().join("out.json")).unwrap();
    let json: Value = serde_json::from_slice(&json).unwrap();
    let modes = json["tilts"][0]["sensitivities"].as_array().unwrap();
    assert!(modes.len() >= 10);
    assert!(modes[0]["parameters"][0]["growth_per_percent"].is_number());
    assert!(test.path().join("figures/sensitivities.png").exists());
}

#[test]
fn bad_intervals_and_parameters_are_refused() {
    let test = tempfile::tempdir().unwrap();
    for (words, expected) in [
        (&["--tilt", "8:0"][..], "8:0 is not an interval"),
        (&["--tilt", "0"], "give A:B"),
        (&["--tilt", "0:91"], "`load.tilt_deg` = 91"),
        (&["--param", "mu_s"], "give KEY=RANGE"),
        (
            &["--param", "contact.nodes=10:20"],
            "`contact.nodes` is a count or a seed",
        ),
        (&["--param", "mu_z=0:1"], "mu_z"),
        (&["--tilt", "0:1", "--param", "tilt_deg=0:1"], "swept twice"),
        (&["--out", "table.txt"], "wrong ending"),
        (
            &["--start", "0", "--tilt", "6:8"],
            "the start at tilt_deg = 0 is outside the interval from 6 to 8",
        ),
        (
            &["--tilt", "0:1", "--param", SLOPE, "--out", "a.arrow"],
            "--out needs one parameter",
        ),
    ] {
        let words: Vec<&str> = ["branch", "doubled-torus-3deg"]
            .iter()
            .chain(words)
            .copied()
            .collect();
        squeakscope(test.path(), &words)
            .code(2)
            .stderr(predicate::str::contains(expected));
    }
    squeakscope(test.path(), &["branch", "mass-on-belt"])
        .code(2)
        .stderr(predicate::str::contains("no load"));
}
