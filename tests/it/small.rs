//! Scenes of small systems through the binary.

use assert_cmd::Command;
use predicates::str::contains;

fn squeakscope() -> Command {
    Command::new(env!("CARGO_BIN_EXE_squeakscope"))
}

#[test]
fn small_scenes_run_and_report() {
    let folder = tempfile::tempdir().expect("temporary folder");
    for name in ["impact-oscillator", "mass-on-belt", "damped-contact"] {
        let (save, json) = (
            folder.path().join("run.rrd"),
            folder.path().join("run.json"),
        );
        let mut run = squeakscope();
        run.args(["run", name, "--duration", "50", "--force", "--save"])
            .arg(&save)
            .arg("--json")
            .arg(&json);
        run.assert().success();
        let report: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&json).expect("written")).expect("JSON");
        assert_eq!(report["scene"], name);
        assert!(
            report["transitions"].as_u64().expect("a count") > 10,
            "{name}"
        );
        assert!(report["energy_residual"].is_null(), "{name}");
        assert!(std::fs::metadata(&save).expect("saved").len() > 10_000);
    }
}

#[test]
fn commands_for_joints_reject_small_scenes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let out = folder.path().join("model.npz");
    let model = [
        "model",
        "mass-on-belt",
        "--out",
        out.to_str().expect("UTF-8"),
    ];
    for args in [
        &["stability", "mass-on-belt"][..],
        &["stability", "mass-on-belt", "--tilt", "0:2:1"],
        &["run", "mass-on-belt", "--tilt", "2"],
        &model,
    ] {
        squeakscope()
            .args(args)
            .assert()
            .code(2)
            .stderr(contains("defines a mass on a belt"))
            .stderr(contains("a ball joint is required"));
    }
    assert!(!out.exists());
}
