//! `sweep` and `merge`, with short simulations.

use super::*;
use crate::cli::tests::parsed;
use crate::scene::{Parameter, Scene};
use crate::study::sweep::Start;

struct TestFolder(tempfile::TempDir);

impl TestFolder {
    fn new() -> Self {
        let test = Self(tempfile::tempdir().unwrap());
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let few = [(Parameter::named("nodes").unwrap(), 28.0)];
        std::fs::write(test.path("few.toml"), scene.with_values(&few).unwrap().text).unwrap();
        test
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// `@` in a line is the folder.
    fn line(&self, line: &str) -> String {
        line.replace('@', &self.0.path().display().to_string())
    }

    /// Sweeps the tilt to a table of this name, and JSON beside it.
    fn sweep(&self, name: &str, line: &str, stop: bool) -> Result<(), CliError> {
        self.sweep_over("--tilt 1:2:0.5", name, line, stop)
    }

    fn sweep_over(&self, axes: &str, name: &str, line: &str, stop: bool) -> Result<(), CliError> {
        let response = "--min-transient 20 --max-transient 20 --exponents 1 --tolerance 1e-4";
        let measure = if line.contains("--measure") {
            ""
        } else {
            "--measure 10"
        };
        let seed = if line.contains("--seed") {
            ""
        } else {
            "--seed 3"
        };
        let json = if line.contains("--json") {
            String::new()
        } else {
            json(name)
        };
        let line = format!(
            "@/few.toml {axes} {response} {measure} {seed} --threads 2 --out @/{name} {json} {line}"
        );
        execute(&parsed(&self.line(&line)), &AtomicBool::new(stop))
    }

    fn merge(&self, tables: &str, name: &str, line: &str) -> Result<(), CliError> {
        let line = format!("{tables} --out @/{name} {} {line}", json(name));
        merge(&parsed(&self.line(&line)), &AtomicBool::new(false))
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }
}

fn json(table: &str) -> String {
    let stem = table.split_once('.').map_or(table, |(stem, _)| stem);
    format!("--json @/{stem}.json")
}

#[test]
fn a_sweep_writes_tables_figures_and_json() {
    let test = TestFolder::new();
    let sweep =
        |line: &str| test.sweep("a.arrow", &format!("--figures @/figures/new {line}"), false);
    sweep("").unwrap();
    let report = test.json("a.json");
    assert_eq!(report["points_computed"], 6);
    assert_eq!(report["points"][4]["values"][0], 1.5);
    let start = serde_json::to_value(Start::Downward).unwrap();
    assert_eq!(report["points"][4]["start"], start);
    let modes = report["points"][0]["linear"]["modes"].as_array().unwrap();
    let unstable = modes.iter().filter(|mode| mode["unstable"] == true);
    assert_eq!(unstable.count(), 4);
    assert_eq!(report["files"].as_array().unwrap().len(), 3);
    // The table that grew is gone.
    assert!(test.path("a.arrow").exists() && !test.path("a.arrows").exists());
    assert_eq!(
        report["points"][0]["amplitude_m"].as_f64().map(|a| a > 0.0),
        Some(true)
    );
    assert_eq!(
        report["points"][0]["exponents"]["exponents_per_s"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    assert_eq!(report["points"][0]["error"], serde_json::Value::Null);
    let svg = std::fs::read_to_string(test.path("figures/new/bifurcation.svg")).unwrap();
    let title = "<title>doubled-torus-3deg: ";
    assert!(svg.contains(title), "{svg}");
    // An existing table is not replaced, and resuming a complete table does not change it.
    let refused = sweep("").unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(refused.to_string().contains("--resume"), "{refused}");
    let before = test.bytes("a.arrow");
    for again in ["--resume", "--force"] {
        sweep(again).unwrap();
        assert_eq!(test.bytes("a.arrow"), before);
    }
    // A table is not mixed with another sweep.
    let refused = sweep("--resume --measure 11").unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert_eq!(test.bytes("a.arrow"), before);
}

#[test]
fn an_interrupted_sweep_resumes_to_the_same_table() {
    let test = TestFolder::new();
    test.sweep("whole.arrow", "", false).unwrap();
    let ended = test.sweep("part.arrow", "", true).unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    assert_eq!(test.json("part.json")["interrupted"], true);
    assert!(test.path("part.arrows").exists() && !test.path("part.arrow").exists());
    test.sweep("part.arrow", "--resume", false).unwrap();
    assert_eq!(test.bytes("whole.arrow"), test.bytes("part.arrow"));
}

#[test]
fn merged_shards_equal_the_whole_sweep() {
    let test = TestFolder::new();
    test.sweep("whole.arrow", "", false).unwrap();
    for number in 1..=2 {
        let shard = format!("--shard {number}/2");
        test.sweep(&format!("part-{number}.arrow"), &shard, false)
            .unwrap();
        let part = test.json(&format!("part-{number}.json"));
        assert_eq!(part["points_computed"], 3);
    }
    let parts = |last: &str| {
        test.merge(
            &format!("@/part-1.arrow @/{last}"),
            "merged.arrow",
            "--force",
        )
    };
    parts("part-2.arrow").unwrap();
    assert_eq!(test.bytes("whole.arrow"), test.bytes("merged.arrow"));
    // A merge of one table converts it, to Parquet and back without a change.
    test.merge("@/merged.arrow", "a.parquet", "").unwrap();
    test.merge("@/a.parquet", "again.arrow", "").unwrap();
    assert_eq!(test.bytes("whole.arrow"), test.bytes("again.arrow"));
    test.sweep("other.arrow", "--seed 4", false).unwrap();
    for bad in ["other.arrow", "few.toml", "missing.arrow"] {
        let refused = parts(bad).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(bad), "{refused}");
    }
}

#[test]
fn a_recording_needs_a_single_parameter() {
    let test = TestFolder::new();
    test.sweep("a.arrow", "--save @/a.rrd", false).unwrap();
    let saved = |name: &str| test.path(name).metadata().map_or(0, |file| file.len());
    assert!(saved("a.rrd") > 0);
    let report = test.json("a.json");
    let files = report["files"].as_array().unwrap();
    assert!(files[1]["path"].as_str().unwrap().ends_with("a.rrd"));
    // From a table, too.
    test.merge("@/a.arrow", "b.arrow", "--save @/b.rrd")
        .unwrap();
    assert!(saved("b.rrd") > 0);
    // Two parameters, and a recording in place of a table, are refused before any work.
    for (line, reason) in [
        (
            "--param load_n=100:150:50 --save @/map.rrd",
            "one parameter",
        ),
        ("--save @/map.csv", "ends in .rrd"),
    ] {
        let refused = test.sweep("map.arrow", line, false).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(reason), "{refused}");
        assert!(!test.path("map.arrow").exists() && !test.path("map.rrd").exists());
    }
}

#[test]
fn an_interrupted_sweep_records_its_points() {
    let test = TestFolder::new();
    let ended = test
        .sweep("part.arrow", "--save @/part.rrd", true)
        .unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    let known = test.json("part.json")["points_computed"].as_u64().unwrap();
    assert_eq!(test.path("part.rrd").exists(), known > 0);
}

#[test]
fn bad_input_is_found_before_any_work() {
    let test = TestFolder::new();
    for (axes, line) in [
        ("--param contact.stifness_factor=1:2:1", ""),
        ("--param contact.stiffness_factor=1:20000:5000", ""),
        ("--param contact.nodes=1:2:0.3", ""),
        ("--param load_n=1:2:1 --param load_n=1:2:1", ""),
        (
            "--param load_n=1:2:1 --param nodes=1:2:1 --param seed=1:2:1",
            "",
        ),
        ("--tilt 1:2:0.5", "--json @/bad.arrow"),
    ] {
        let refused = test.sweep_over(axes, "bad.arrow", line, false).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(!test.path("bad.arrow").exists());
    }
}
