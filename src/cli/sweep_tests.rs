//! `sweep` and `merge`, with short simulations.

use std::num::NonZero;

use super::*;
use crate::cli::common_args::{AccuracyArgs, SceneArgs};
use crate::cli::steps::Steps;
use crate::cli::study_args::SweepStart;
use crate::scene::Scene;
use crate::study::sweep::Start;

fn steps(text: &str) -> Steps {
    text.parse().unwrap()
}

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

    fn outputs(&self, name: &str) -> SweepOutputs {
        SweepOutputs {
            out: self.path(name),
            figures: None,
            overwrite: Default::default(),
            drawn: Default::default(),
            save: None,
            json: Some(self.path(name).with_extension("json")),
        }
    }

    fn args(&self, name: &str) -> SweepArgs {
        SweepArgs {
            scene: SceneArgs {
                scene: Some(self.path("few.toml").to_string_lossy().into_owned()),
                ..SceneArgs::default()
            },
            tilt: Some(steps("1:2:0.5")),
            param: Vec::new(),
            start: SweepStart::Both,
            seed: Some(3),
            response: ResponseArgs {
                min_transient: 20.0,
                max_transient: 20.0,
                measure: 10.0,
                exponents: 1,
                tolerance: Some(1e-4),
                accuracy: AccuracyArgs::default(),
            },
            work: WorkArgs {
                threads: NonZero::new(2),
                ..WorkArgs::default()
            },
            outputs: self.outputs(name),
        }
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }
}

fn no_stop() -> AtomicBool {
    AtomicBool::new(false)
}

#[test]
fn a_sweep_writes_tables_figures_and_json() {
    let test = TestFolder::new();
    let mut args = test.args("a.arrow");
    args.outputs.figures = Some(test.path("figures/new"));
    execute(&args, &no_stop()).unwrap();
    let report = test.json("a.json");
    assert_eq!(report["points_computed"], 6);
    assert_eq!(report["points"][4]["values"][0], 1.5);
    let start = serde_json::to_value(Start::Downward).unwrap();
    assert_eq!(report["points"][4]["start"], start);
    assert_eq!(report["points"][0]["unstable_modes"], 4);
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
    let refused = execute(&args, &no_stop()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(refused.to_string().contains("--resume"), "{refused}");
    let before = std::fs::read(test.path("a.arrow")).unwrap();
    args.work.resume = true;
    execute(&args, &no_stop()).unwrap();
    assert_eq!(std::fs::read(test.path("a.arrow")).unwrap(), before);
    let forced = SweepOutputs {
        overwrite: Overwrite::ALLOWED,
        ..test.outputs("a.arrow")
    };
    let again = SweepArgs {
        outputs: forced,
        ..test.args("a.arrow")
    };
    execute(&again, &no_stop()).unwrap();
    assert_eq!(std::fs::read(test.path("a.arrow")).unwrap(), before);
    // A table is not mixed with another sweep.
    args.response.measure = 11.0;
    let refused = execute(&args, &no_stop()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert_eq!(std::fs::read(test.path("a.arrow")).unwrap(), before);
}

#[test]
fn an_interrupted_sweep_resumes_to_the_same_table() {
    let test = TestFolder::new();
    execute(&test.args("whole.arrow"), &no_stop()).unwrap();
    let mut args = test.args("part.arrow");
    let ended = execute(&args, &AtomicBool::new(true)).unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    assert_eq!(test.json("part.json")["interrupted"], true);
    assert!(test.path("part.arrows").exists() && !test.path("part.arrow").exists());
    args.work.resume = true;
    execute(&args, &no_stop()).unwrap();
    assert_eq!(
        std::fs::read(test.path("whole.arrow")).unwrap(),
        std::fs::read(test.path("part.arrow")).unwrap()
    );
}

#[test]
fn merged_shards_equal_the_whole_sweep() {
    let test = TestFolder::new();
    execute(&test.args("whole.arrow"), &no_stop()).unwrap();
    for number in 1..=2 {
        let mut args = test.args(&format!("part-{number}.arrow"));
        args.work.shard = Some(Shard { number, of: 2 });
        execute(&args, &no_stop()).unwrap();
        assert_eq!(
            test.json(&format!("part-{number}.json"))["points_computed"],
            3
        );
    }
    let parts = |last: &str| MergeArgs {
        tables: vec![test.path("part-1.arrow"), test.path(last)],
        outputs: SweepOutputs {
            overwrite: Overwrite::ALLOWED,
            ..test.outputs("merged.arrow")
        },
    };
    merge(&parts("part-2.arrow"), &no_stop()).unwrap();
    assert_eq!(
        std::fs::read(test.path("whole.arrow")).unwrap(),
        std::fs::read(test.path("merged.arrow")).unwrap()
    );
    // A merge of one table converts it, to Parquet and back without a change.
    for [from, to] in [["merged.arrow", "a.parquet"], ["a.parquet", "again.arrow"]] {
        let convert = MergeArgs {
            tables: vec![test.path(from)],
            outputs: test.outputs(to),
        };
        merge(&convert, &no_stop()).unwrap();
    }
    assert_eq!(
        std::fs::read(test.path("whole.arrow")).unwrap(),
        std::fs::read(test.path("again.arrow")).unwrap()
    );
    let mut other = test.args("other.arrow");
    other.seed = Some(4);
    execute(&other, &no_stop()).unwrap();
    for bad in ["other.arrow", "few.toml", "missing.arrow"] {
        let refused = merge(&parts(bad), &no_stop()).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(bad), "{refused}");
    }
}

#[test]
fn a_recording_needs_a_single_parameter() {
    let test = TestFolder::new();
    let mut args = test.args("a.arrow");
    args.outputs.save = Some(test.path("a.rrd"));
    execute(&args, &no_stop()).unwrap();
    let saved = |name: &str| test.path(name).metadata().map_or(0, |there| there.len());
    assert!(saved("a.rrd") > 0);
    let report = test.json("a.json");
    let files = report["files"].as_array().unwrap();
    assert!(files[1]["path"].as_str().unwrap().ends_with("a.rrd"));
    // From a table, too.
    let again = MergeArgs {
        tables: vec![test.path("a.arrow")],
        outputs: SweepOutputs {
            save: Some(test.path("b.rrd")),
            ..test.outputs("b.arrow")
        },
    };
    merge(&again, &no_stop()).unwrap();
    assert!(saved("b.rrd") > 0);
    // Two parameters, and a recording in place of a table, are refused before any work.
    let both = SweepArgs {
        param: vec!["load_n=100:150:50".parse().unwrap()],
        outputs: SweepOutputs {
            save: Some(test.path("map.rrd")),
            ..test.outputs("map.arrow")
        },
        ..test.args("map.arrow")
    };
    let same = SweepArgs {
        outputs: SweepOutputs {
            save: Some(test.path("map.csv")),
            ..test.outputs("map.arrow")
        },
        ..test.args("map.arrow")
    };
    for (args, word) in [(both, "one parameter"), (same, "ends in .rrd")] {
        let refused = execute(&args, &no_stop()).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(word), "{refused}");
        assert!(!test.path("map.arrow").exists() && !test.path("map.rrd").exists());
    }
}

#[test]
fn an_interrupted_sweep_records_its_points() {
    let test = TestFolder::new();
    let mut args = test.args("part.arrow");
    args.outputs.save = Some(test.path("part.rrd"));
    let ended = execute(&args, &AtomicBool::new(true)).unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    let known = test.json("part.json")["points_computed"].as_u64().unwrap();
    assert_eq!(test.path("part.rrd").exists(), known > 0);
}

#[test]
fn bad_input_is_found_before_any_work() {
    let test = TestFolder::new();
    let vary = |texts: &[&str]| SweepArgs {
        tilt: None,
        param: texts.iter().map(|text| text.parse().unwrap()).collect(),
        ..test.args("bad.arrow")
    };
    let same_file = SweepArgs {
        outputs: SweepOutputs {
            json: Some(test.path("bad.arrow")),
            ..test.outputs("bad.arrow")
        },
        ..test.args("bad.arrow")
    };
    let bad = [
        vary(&["contact.stifness_factor=1:2:1"]),
        vary(&["contact.stiffness_factor=1:20000:5000"]),
        vary(&["contact.nodes=1:2:0.3"]),
        vary(&["load_n=1:2:1", "load_n=1:2:1"]),
        vary(&["load_n=1:2:1", "nodes=1:2:1", "seed=1:2:1"]),
        same_file,
    ];
    for args in bad {
        let refused = execute(&args, &no_stop()).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(!test.path("bad.arrow").exists());
    }
}
