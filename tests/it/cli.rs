//! The command line: exit codes, one-line messages for bad input, JSON, help, completions and man pages.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;
use squeakscope::scene::{PRESETS, Scene};

fn squeakscope(folder: &Path, words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(folder).args(words).assert()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("temporary folder")
}

/// Checks for bad input: exit code 2, empty standard output, one line of error. Returns the line.
fn refused(folder: &Path, words: &[&str]) -> String {
    let assert = squeakscope(folder, words).code(2).stdout("");
    let message = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
    assert!(message.starts_with("error: "), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    message
}

#[test]
fn scenes_lists_all_scenes() {
    let test = folder();
    let mut assert = squeakscope(test.path(), &["scenes", "--json", "scenes.json"]).success();
    for preset in PRESETS {
        assert = assert.stdout(predicate::str::contains(preset.name));
    }
    let json = std::fs::read(test.path().join("scenes.json")).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let scenes = json["scenes"].as_array().expect("a list");
    assert_eq!(scenes.len(), PRESETS.len());
    for scene in scenes {
        let text = scene["toml"].as_str().expect("text");
        let parsed = Scene::parse("json", text).expect("valid");
        assert_eq!(scene["name"], parsed.name.as_str());
        assert_eq!(scene["duration_s"], parsed.duration);
    }
}

#[test]
fn a_printed_scene_can_be_saved_and_checked() {
    let test = folder();
    for preset in PRESETS {
        let assert = squeakscope(test.path(), &["scenes", preset.name])
            .success()
            .stderr("");
        let printed = assert.get_output().stdout.clone();
        assert_eq!(printed, preset.text.as_bytes());
        std::fs::write(test.path().join("mine.toml"), printed).expect("written");
        squeakscope(test.path(), &["scenes", "mine.toml"])
            .success()
            .stdout(preset.text);
    }
}

#[test]
fn scenes_prints_every_key() {
    let assert = squeakscope(folder().path(), &["scenes", "--keys"]).success();
    assert
        .stdout(predicate::str::contains("`[friction]`"))
        .stdout(predicate::str::contains("| `tilt_deg` |"));
}

#[test]
fn an_unknown_scene_suggests_a_similar_name() {
    let test = folder();
    for command in ["scenes", "run", "stability"] {
        let message = refused(test.path(), &[command, "chaos-5"]);
        assert!(message.contains("did you mean `chaos-5deg`?"), "{message}");
    }
    let message = refused(test.path(), &["model", "chaos-5", "--out", "m.npz"]);
    assert!(message.contains("did you mean `chaos-5deg`?"), "{message}");
}

#[test]
fn errors_in_scene_files_name_file_line_and_key() {
    let test = folder();
    let cases: [(&str, &str); 7] = [
        (
            "[load]\nload_m = 150\n",
            "mine.toml:2: unknown key `load.load_m` (did you mean `load.load_n`?)",
        ),
        (
            "[load]\nload_n = -150\n",
            "mine.toml:2: `load.load_n` = -150 is out of range; it must be",
        ),
        (
            "[load]\nload_n = nan\n",
            "mine.toml:2: `load.load_n` = nan is out of range; it must be",
        ),
        (
            "[load]\nload_n = 1\ntilt_deg = 91\n[time]\nduration_ms = 1\n",
            "mine.toml:3: `load.tilt_deg` = 91",
        ),
        (
            "[contact]\nnodes = 0\n[load]\nload_n = 1\ntilt_deg = 1\n",
            "mine.toml:2: `contact.nodes` = 0",
        ),
        ("[load]\n", "mine.toml:1: `load.load_n` is missing"),
        ("[load\n", "mine.toml:1: not valid TOML"),
    ];
    for (text, expected) in cases {
        std::fs::write(test.path().join("mine.toml"), text).expect("written");
        for command in ["scenes", "run"] {
            let message = refused(test.path(), &[command, "mine.toml"]);
            assert!(message.contains(expected), "{message}");
        }
    }
    let names = std::fs::read_dir(test.path()).expect("a folder").count();
    assert_eq!(names, 1, "a refused scene writes no file");
}

#[test]
fn unreadable_scenes_are_refused_with_the_reason() {
    let test = folder();
    let message = refused(test.path(), &["run", "absent/mine.toml"]);
    assert!(
        message.contains("cannot read the scene file `absent/mine.toml`"),
        "{message}"
    );
    refused(test.path(), &["run", "."]);
    std::fs::write(test.path().join("bytes.toml"), b"\xff\xfe\x00").expect("written");
    let message = refused(test.path(), &["run", "bytes.toml"]);
    assert!(
        message.contains("bytes.toml:1: the scene file is not UTF-8"),
        "{message}"
    );
}

#[test]
fn kinetic_above_static_friction_is_a_warning() {
    let test = folder();
    let text = "load = { load_n = 1, tilt_deg = 1 }\ntime.duration_ms = 1\n\
                friction = { mu_s = 0.2, mu_d = 0.5 }\n";
    std::fs::write(test.path().join("mine.toml"), text).expect("written");
    let warning = "warning: friction.mu_d = 0.5 exceeds friction.mu_s = 0.2";
    squeakscope(test.path(), &["scenes", "mine.toml"])
        .success()
        .stdout(text)
        .stderr(predicate::str::starts_with(warning));
}

#[test]
fn outputs_are_checked_before_any_work() {
    let test = folder();
    let scene = "periodic-2deg";
    for (option, ending) in [("--save", "rrd"), ("--npz", "npz"), ("--json", "json")] {
        std::fs::create_dir_all(test.path().join(format!("folder.{ending}"))).expect("made");
        for path in [format!("folder.{ending}"), format!("absent/out.{ending}")] {
            let message = refused(test.path(), &["run", scene, option, &path]);
            assert!(
                message.contains(&format!("`{path}` ({option})")),
                "{message}"
            );
        }
        let message = refused(test.path(), &["run", scene, option, "out.txt"]);
        let told = format!(
            "`out.txt` ({option}) has the wrong ending for this output; give a name that ends in .{ending}"
        );
        assert!(message.contains(&told), "{message}");
    }
    refused(test.path(), &["scenes", "--json", "folder.json"]);
    refused(
        test.path(),
        &["stability", scene, "--json", "absent/out.json"],
    );
    refused(test.path(), &["model", scene, "--out", "folder.npz"]);
}

#[test]
fn options_have_the_ranges_of_the_scene_keys() {
    let test = folder();
    let message = refused(test.path(), &["run", "periodic-2deg", "--tilt", "91"]);
    assert!(message.contains("a number from -90 to 90 deg"), "{message}");
    refused(test.path(), &["run", "periodic-2deg", "--tilt", "nan"]);
    let message = refused(test.path(), &["run", "periodic-2deg", "--duration", "-1"]);
    assert!(
        message.contains("`time.duration_ms` = -1 is out of range"),
        "{message}"
    );
}

#[test]
fn usage_errors_have_exit_code_2() {
    let test = folder();
    let usages: [&[&str]; 8] = [
        &["rnu"],
        &["run", "--til", "3"],
        &["run", "--tilt", "three"],
        &["run", "--spawn", "--connect"],
        &["run", "--connect", "example.org"],
        &["model"],
        &["stability", "--tilt", "0:7"],
        &["stability", "--tilt", "0:7:-1"],
    ];
    for words in usages {
        squeakscope(test.path(), words)
            .code(2)
            .stdout("")
            .stderr(predicate::str::starts_with("error: "));
    }
    squeakscope(test.path(), &["stability", "--tilt", "0:7:-1"]).stderr(predicate::str::contains(
        "a step of -1 does not lead from 0 to 7",
    ));
    squeakscope(test.path(), &["--version"])
        .success()
        .stdout(format!("squeakscope {}\n", squeakscope::VERSION));
    squeakscope(test.path(), &["run", "--help"]).success();
}

/// Numbers that are each in range, but do not make a valid joint, are bad input and write no file.
#[test]
fn invalid_joints_are_bad_input() {
    let test = folder();
    let printed = squeakscope::scene::preset("doubled-torus-3deg")
        .expect("preset")
        .text;
    assert!(printed.contains("load_n = 150") && printed.contains("tilt_deg = 3"));
    let text = printed
        .replace("load_n = 150", "load_n = 4000")
        .replace("tilt_deg = 3", "tilt_deg = 90");
    std::fs::write(test.path().join("scene.toml"), text).expect("written");
    let thick = ["--set=beam_diameter_mm=31", "--set=frequencies=fe"];
    let words = ["run", "scene.toml", thick[0], thick[1], "--save", "out.rrd"];
    let message = refused(test.path(), &words);
    assert!(message.contains("reaches the beam"), "{message}");
    let left = std::fs::read_dir(test.path()).expect("folder").count();
    assert_eq!(left, 1, "only the scene file");
}

/// Errors of limits that several keys share name the file and the line.
#[test]
fn shared_limits_name_file_and_line() {
    let test = folder();
    let printed = squeakscope::scene::preset("doubled-torus-3deg")
        .expect("preset")
        .text;
    for (new, expected) in [
        (
            "frequencies = \"fe\"\nbending_pairs = 50\ntorsion_modes = 40",
            "at most 128",
        ),
        ("frequencies = \"fe\"\nelement_size_mm = 1", "at most 2000"),
    ] {
        let text = printed.replace("frequencies = \"published\"", new);
        assert_ne!(text, printed);
        std::fs::write(test.path().join("scene.toml"), text).expect("written");
        let message = refused(test.path(), &["run", "scene.toml", "--save", "out.rrd"]);
        assert!(
            message.starts_with("error: scene.toml:") && message.contains(expected),
            "{message}"
        );
    }
}

/// A quantity that varies with time is held constant with a warning; a sweep over it is refused.
#[test]
fn time_dependent_loads_are_held_with_a_warning() {
    let test = folder();
    std::fs::create_dir(test.path().join("mine")).expect("made");
    let text = "load = { load_csv = \"load.csv\", tilt_deg = 1 }\ntime.duration_ms = 1\n\
                friction = { mu_s = 0.5, mu_d = 0.2 }\n";
    std::fs::write(test.path().join("mine/scene.toml"), text).expect("written");
    let scene = "mine/scene.toml";
    let message = refused(test.path(), &["run", scene, "--save", "out.rrd"]);
    assert!(
        message.contains(
            "mine/scene.toml:1: `load.load_csv`: the file `mine/load.csv` cannot be read"
        ),
        "{message}"
    );
    let table = test.path().join("mine/load.csv");
    std::fs::write(&table, "time_ms,load_n\n0,100\n1,x\n").expect("written");
    let message = refused(test.path(), &["run", scene, "--save", "out.rrd"]);
    assert!(
        message.contains("mine/load.csv:3: `load.load.load_n` is `x`"),
        "{message}"
    );

    std::fs::write(&table, "time_ms,load_n\n0,100\n1,150\n").expect("written");
    squeakscope(test.path(), &["stability", scene])
        .success()
        .stderr(predicate::str::contains(
            "uses its initial values: load 100 N",
        ));
    let sweep = [
        "sweep",
        scene,
        "--param",
        "load.load_n=100:150:50",
        "--out",
        "s.arrow",
    ];
    let message = refused(test.path(), &sweep);
    assert!(
        message.contains("the load of this scene is a function of time"),
        "{message}"
    );
}

/// An existing output is kept, except with `--force`, and except for the default recording.
#[test]
fn existing_outputs_are_replaced_by_force_only() {
    let test = folder();
    let run = ["run", "mass-on-belt", "--duration", "5"];
    for (words, name) in [
        (&["--json", "a.json"][..], "a.json"),
        (&["--save", "a.rrd"], "a.rrd"),
    ] {
        let words = [&run[..], words].concat();
        std::fs::write(test.path().join(name), "kept").expect("written");
        let message = refused(test.path(), &words);
        assert!(
            message.contains(&format!("`{name}`")) && message.contains("--force"),
            "{message}"
        );
        assert_eq!(
            std::fs::read(test.path().join(name)).expect("kept"),
            b"kept"
        );
        squeakscope(test.path(), &[&words[..], &["--force"]].concat()).success();
        let replaced = std::fs::read(test.path().join(name)).expect("there");
        assert_ne!(replaced, b"kept");
    }
    for _ in 0..2 {
        squeakscope(test.path(), &run).success();
    }
}

/// An output that would replace the scene is refused.
#[test]
fn the_scene_is_not_overwritten() {
    let test = folder();
    let printed = squeakscope::scene::preset("doubled-torus-3deg")
        .expect("preset")
        .text;
    std::fs::write(test.path().join("scene.toml"), printed).expect("written");
    let message = refused(
        test.path(),
        &["run", "scene.toml", "--save", "./scene.toml"],
    );
    assert!(message.contains("is the input"), "{message}");
    assert_eq!(
        std::fs::read(test.path().join("scene.toml")).expect("there"),
        printed.as_bytes()
    );
}

#[test]
fn help_groups_the_commands_and_ends_with_examples() {
    let test = folder();
    let help = |words: &[&str]| {
        let assert = squeakscope(test.path(), words).success().stderr("");
        String::from_utf8(assert.get_output().stdout.clone()).expect("text")
    };
    let main = help(&["--help"]);
    for heading in [
        "Simulate:",
        "Watch:",
        "Study:",
        "Analyse a signal:",
        "Inspect:",
        "Options:",
        "Examples:",
    ] {
        assert!(
            main.lines().any(|line| line == heading),
            "{heading}: {main}"
        );
    }
    let sweep = help(&["sweep", "--help"]);
    for heading in [
        "Parameters:",
        "Response:",
        "Execution:",
        "Output:",
        "Figures:",
        "Examples:",
    ] {
        assert!(
            sweep.lines().any(|line| line == heading),
            "{heading}: {sweep}"
        );
    }
    let last = sweep.trim_end().lines().last().expect("a line");
    assert!(
        last.trim_start().starts_with("squeakscope sweep "),
        "{last}"
    );
}

#[test]
fn completions_and_man_pages_are_written() {
    let test = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        squeakscope(test.path(), &["completions", shell])
            .success()
            .stderr("")
            .stdout(predicate::str::contains("max-transient"));
    }
    squeakscope(test.path(), &["completions", "tcsh"]).code(2);
    squeakscope(test.path(), &["man", "man1"])
        .success()
        .stdout("")
        .stderr("");
    let page = std::fs::read_to_string(test.path().join("man1/squeakscope-sweep.1")).expect("page");
    assert!(page.contains("max\\-transient"), "{page}");
    std::fs::write(test.path().join("file"), "x").expect("written");
    refused(test.path(), &["man", "file"]);
}

/// Exponents that decide give the type of motion; otherwise the last displacement is classified, whether or not the scene
/// asks for that.
#[test]
fn a_run_names_its_type_of_motion_and_says_when_it_is_quiet() {
    let test = folder();
    let run = |scene: &str, set: &[&str]| {
        let mut words = vec!["run", scene, "--json", "run.json", "--force"];
        words.extend(set.iter().flat_map(|set| ["--set", *set]));
        squeakscope(test.path(), &words).success();
        let json = std::fs::read(test.path().join("run.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        json
    };
    let chaotic = run("chaos-5deg", &[]);
    assert_eq!(chaotic["exponents"]["attractor"], "chaos");
    assert_eq!(chaotic["motion"], "chaotic");
    assert_eq!(chaotic["motion_confidence"], serde_json::Value::Null);
    let plain = ["analysis=absent", "mechanism=absent"];
    for set in [&plain[..], &[]] {
        let tone = run("periodic-2deg", set);
        assert_eq!(
            (&tone["motion"], &tone["quiet"]),
            (&"periodic".into(), &false.into())
        );
        assert!(tone["motion_confidence"].as_f64() > Some(0.5));
    }
    let less_friction = run("periodic-2deg", &["friction.mu_s=0.25"]);
    assert_eq!(less_friction["quiet"], true);
    assert_eq!(less_friction["motion"], "fixed point");
    let damped = [&plain[..], &["damping.ratio=0.08", "duration_ms=200"]].concat();
    let cured = run("periodic-2deg", &damped);
    assert_eq!(
        (&cured["motion"], &cured["quiet"]),
        (&"at rest".into(), &true.into())
    );
}

#[test]
fn printed_json_is_alone_on_the_standard_output() {
    let test = folder();
    let sample = |k: u32| format!("{}\n", (0.1 * f64::from(k)).sin());
    let samples: String = (0..2000).map(sample).collect();
    std::fs::write(test.path().join("a.csv"), samples).expect("written");
    for words in [
        &["run", "mass-on-belt", "--duration", "20"][..],
        &["analyse", "a.csv", "--rate", "1000"],
    ] {
        let words = [words, &["--json", "-", "--save", "out.rrd", "--force"]].concat();
        let assert = squeakscope(test.path(), &words).success();
        let printed = &assert.get_output().stdout;
        serde_json::from_slice::<serde_json::Value>(printed).expect("JSON alone");
    }
}
