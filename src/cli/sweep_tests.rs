//! The commands of sweeps, with real short sweeps.

use std::num::NonZero;

use super::*;
use crate::cli::common_args::{AccuracyArgs, SceneArgs};
use crate::cli::steps::Steps;
use crate::scene::Scene;

fn steps(text: &str) -> Steps {
    text.parse().unwrap()
}

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let scene = Scene::load("torus-3deg").unwrap();
        let few = [(Parameter::named("nodes").unwrap(), 28.0)];
        std::fs::write(desk.path("few.toml"), scene.with_values(&few).unwrap().text).unwrap();
        desk
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn outputs(&self, name: &str) -> SweepOutputs {
        SweepOutputs {
            out: self.path(name),
            figures: None,
            drawn: Default::default(),
            save: None,
            json: Some(self.path(name).with_extension("json")),
        }
    }

    fn args(&self, name: &str) -> SweepArgs {
        SweepArgs {
            scene: SceneArgs {
                scene: Some(self.path("few.toml").to_string_lossy().into_owned()),
            },
            tilt: Some(steps("1:2:0.5")),
            over: Vec::new(),
            start: SweepStart::Both,
            seed: Some(3),
            response: ResponseArgs {
                least: 20.0,
                most: 20.0,
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
fn a_sweep_leaves_its_tables_figures_and_words() {
    let desk = Desk::new();
    let mut args = desk.args("a.arrow");
    args.outputs.figures = Some(desk.path("figures/new"));
    execute(&args, &no_stop()).unwrap();
    let report = desk.json("a.json");
    assert_eq!(report["points_known"], 6);
    assert_eq!(report["points"][4]["values"][0], 1.5);
    assert_eq!(report["points"][4]["start"], "down");
    assert_eq!(report["points"][0]["unstable_modes"], 4);
    assert_eq!(report["files"].as_array().unwrap().len(), 4);
    assert_eq!(
        report["points"][0]["amplitude_m"].as_f64().map(|a| a > 0.0),
        Some(true)
    );
    assert_eq!(
        report["points"][0]["exponent_per_s"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    assert_eq!(report["points"][0]["error"], serde_json::Value::Null);
    let svg = std::fs::read_to_string(desk.path("figures/new/bifurcation.svg")).unwrap();
    let title = "<title>torus-3deg: continued up, continued down</title>";
    assert!(svg.contains(title), "{svg}");
    assert_eq!(
        std::fs::read_to_string(desk.path("a.csv"))
            .unwrap()
            .lines()
            .count(),
        7
    );
    // A table is never replaced by accident, and going on with a whole one changes nothing.
    let refused = execute(&args, &no_stop()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(refused.to_string().contains("--resume"), "{refused}");
    let before = std::fs::read(desk.path("a.arrow")).unwrap();
    args.work.resume = true;
    execute(&args, &no_stop()).unwrap();
    assert_eq!(std::fs::read(desk.path("a.arrow")).unwrap(), before);
    // Nor is it mixed with another sweep.
    args.response.measure = 11.0;
    let refused = execute(&args, &no_stop()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(refused.to_string().contains("another sweep"), "{refused}");
    assert_eq!(std::fs::read(desk.path("a.arrow")).unwrap(), before);
}

#[test]
fn an_interrupted_sweep_goes_on_to_the_same_table() {
    let desk = Desk::new();
    execute(&desk.args("whole.arrow"), &no_stop()).unwrap();
    let mut args = desk.args("part.arrow");
    let ended = execute(&args, &AtomicBool::new(true)).unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    assert_eq!(desk.json("part.json")["interrupted"], true);
    args.work.resume = true;
    execute(&args, &no_stop()).unwrap();
    assert_eq!(
        std::fs::read(desk.path("whole.arrow")).unwrap(),
        std::fs::read(desk.path("part.arrow")).unwrap()
    );
}

#[test]
fn shards_merge_to_the_whole() {
    let desk = Desk::new();
    execute(&desk.args("whole.arrow"), &no_stop()).unwrap();
    for number in 1..=2 {
        let mut args = desk.args(&format!("part-{number}.arrow"));
        args.work.shard = Some(Shard { number, of: 2 });
        execute(&args, &no_stop()).unwrap();
        assert_eq!(desk.json(&format!("part-{number}.json"))["points_known"], 3);
    }
    let parts = |last: &str| MergeArgs {
        tables: vec![desk.path("part-1.arrow"), desk.path(last)],
        outputs: desk.outputs("merged.arrow"),
    };
    merge(&parts("part-2.arrow")).unwrap();
    for ending in ["arrow", "csv"] {
        assert_eq!(
            std::fs::read(desk.path("whole").with_extension(ending)).unwrap(),
            std::fs::read(desk.path("merged").with_extension(ending)).unwrap()
        );
    }
    let mut other = desk.args("other.arrow");
    other.seed = Some(4);
    execute(&other, &no_stop()).unwrap();
    for bad in ["other.arrow", "few.toml", "missing.arrow"] {
        let refused = merge(&parts(bad)).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(bad), "{refused}");
    }
}

#[test]
fn a_recording_is_of_one_parameter() {
    let desk = Desk::new();
    let mut args = desk.args("a.arrow");
    args.outputs.save = Some(desk.path("a.rrd"));
    execute(&args, &no_stop()).unwrap();
    let saved = |name: &str| desk.path(name).metadata().map_or(0, |there| there.len());
    assert!(saved("a.rrd") > 0);
    let report = desk.json("a.json");
    let files = report["files"].as_array().unwrap();
    assert!(files[2]["path"].as_str().unwrap().ends_with("a.rrd"));
    // From a table as well.
    let again = MergeArgs {
        tables: vec![desk.path("a.arrow")],
        outputs: SweepOutputs {
            save: Some(desk.path("b.rrd")),
            ..desk.outputs("b.arrow")
        },
    };
    merge(&again).unwrap();
    assert!(saved("b.rrd") > 0);
    // What a recording cannot show, or would overwrite, is refused before anything is done.
    let both = SweepArgs {
        over: vec!["load_n=100:150:50".parse().unwrap()],
        outputs: SweepOutputs {
            save: Some(desk.path("map.rrd")),
            ..desk.outputs("map.arrow")
        },
        ..desk.args("map.arrow")
    };
    let same = SweepArgs {
        outputs: SweepOutputs {
            save: Some(desk.path("map.csv")),
            ..desk.outputs("map.arrow")
        },
        ..desk.args("map.arrow")
    };
    for (args, word) in [(both, "one parameter"), (same, "asked for twice")] {
        let refused = execute(&args, &no_stop()).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains(word), "{refused}");
        assert!(!desk.path("map.arrow").exists() && !desk.path("map.rrd").exists());
    }
}

#[test]
fn an_interrupted_sweep_records_what_it_has() {
    let desk = Desk::new();
    let mut args = desk.args("part.arrow");
    args.outputs.save = Some(desk.path("part.rrd"));
    let ended = execute(&args, &AtomicBool::new(true)).unwrap_err();
    assert_eq!(ended.exit_code(), 130);
    let known = desk.json("part.json")["points_known"].as_u64().unwrap();
    assert_eq!(desk.path("part.rrd").exists(), known > 0);
}

#[test]
fn bad_input_is_found_before_any_work() {
    let desk = Desk::new();
    let over = |texts: &[&str]| SweepArgs {
        tilt: None,
        over: texts.iter().map(|text| text.parse().unwrap()).collect(),
        ..desk.args("bad.arrow")
    };
    let same_file = SweepArgs {
        outputs: SweepOutputs {
            json: Some(desk.path("bad.csv")),
            ..desk.outputs("bad.arrow")
        },
        ..desk.args("bad.arrow")
    };
    let bad = [
        over(&["contact.stifness_factor=1:2:1"]),
        over(&["contact.stiffness_factor=1:20000:5000"]),
        over(&["contact.nodes=1:2:0.3"]),
        over(&["load_n=1:2:1", "load_n=1:2:1"]),
        over(&["load_n=1:2:1", "nodes=1:2:1", "seed=1:2:1"]),
        same_file,
    ];
    for args in bad {
        let refused = execute(&args, &no_stop()).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(!desk.path("bad.arrow").exists());
    }
}
