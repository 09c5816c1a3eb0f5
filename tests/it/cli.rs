//! The command line keeps its promises: exit codes, one message for bad input, stable JSON.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;
use squeakscope::scene::{PRESETS, Scene};

fn squeakscope(folder: &Path, words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(folder).args(words).assert()
}

fn desk() -> tempfile::TempDir {
    tempfile::tempdir().expect("temporary folder")
}

/// Bad input: exit code 2, nothing on the standard output, one line that begins with `error:`.
fn refused(folder: &Path, words: &[&str]) -> String {
    let assert = squeakscope(folder, words).code(2).stdout("");
    let message = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
    assert!(message.starts_with("error: "), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    message
}

#[test]
fn scenes_lists_all() {
    let desk = desk();
    let mut assert = squeakscope(desk.path(), &["scenes", "--json", "scenes.json"]).success();
    for preset in PRESETS {
        assert = assert.stdout(predicate::str::contains(preset.name));
    }
    let json = std::fs::read(desk.path().join("scenes.json")).expect("written");
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
    let desk = desk();
    for preset in PRESETS {
        let assert = squeakscope(desk.path(), &["scenes", preset.name])
            .success()
            .stderr("");
        let printed = assert.get_output().stdout.clone();
        assert_eq!(printed, preset.text.as_bytes());
        std::fs::write(desk.path().join("mine.toml"), printed).expect("written");
        squeakscope(desk.path(), &["scenes", "mine.toml"])
            .success()
            .stdout(preset.text);
    }
}

#[test]
fn scenes_prints_every_key() {
    let assert = squeakscope(desk().path(), &["scenes", "--keys"]).success();
    assert
        .stdout(predicate::str::contains("`[friction]`"))
        .stdout(predicate::str::contains("| `tilt_deg` |"));
}

#[test]
fn unknown_scenes_offer_the_nearest() {
    let desk = desk();
    for command in ["scenes", "run", "stability"] {
        let message = refused(desk.path(), &[command, "chaos-5"]);
        assert!(message.contains("did you mean `chaos-5deg`?"), "{message}");
    }
    let message = refused(desk.path(), &["model", "chaos-5", "--out", "m.npz"]);
    assert!(message.contains("did you mean `chaos-5deg`?"), "{message}");
}

#[test]
fn faulty_scene_files_are_refused_by_file_line_and_key() {
    let desk = desk();
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
        std::fs::write(desk.path().join("mine.toml"), text).expect("written");
        for command in ["scenes", "run"] {
            let message = refused(desk.path(), &[command, "mine.toml"]);
            assert!(message.contains(expected), "{message}");
        }
    }
    let names = std::fs::read_dir(desk.path()).expect("a folder").count();
    assert_eq!(names, 1, "a refused scene leaves no file behind");
}

#[test]
fn unreadable_scenes_say_why() {
    let desk = desk();
    let message = refused(desk.path(), &["run", "absent/mine.toml"]);
    assert!(
        message.contains("cannot read the scene file `absent/mine.toml`"),
        "{message}"
    );
    refused(desk.path(), &["run", "."]);
    std::fs::write(desk.path().join("bytes.toml"), b"\xff\xfe\x00").expect("written");
    let message = refused(desk.path(), &["run", "bytes.toml"]);
    assert!(
        message.contains("bytes.toml:1: the scene file is not UTF-8"),
        "{message}"
    );
}

#[test]
fn kinetic_above_static_friction_is_warned_of() {
    let desk = desk();
    let text = "load = { load_n = 1, tilt_deg = 1 }\ntime.duration_ms = 1\n\
                friction = { mu_s = 0.2, mu_d = 0.5 }\n";
    std::fs::write(desk.path().join("mine.toml"), text).expect("written");
    let warning = "warning: friction.mu_d = 0.5 exceeds friction.mu_s = 0.2";
    squeakscope(desk.path(), &["scenes", "mine.toml"])
        .success()
        .stdout(text)
        .stderr(predicate::str::starts_with(warning));
}

#[test]
fn outputs_are_checked_before_any_work() {
    let desk = desk();
    std::fs::create_dir(desk.path().join("folder")).expect("made");
    let scene = "periodic-2deg";
    for option in ["--save", "--npz", "--json"] {
        let message = refused(desk.path(), &["run", scene, option, "folder"]);
        assert!(
            message.contains(&format!("`folder` ({option})")),
            "{message}"
        );
        let message = refused(desk.path(), &["run", scene, option, "absent/out"]);
        assert!(
            message.contains(&format!("`absent/out` ({option})")),
            "{message}"
        );
    }
    refused(desk.path(), &["scenes", "--json", "folder"]);
    refused(desk.path(), &["stability", scene, "--json", "absent/out"]);
    refused(desk.path(), &["model", scene, "--out", "folder"]);
    refused(
        desk.path(),
        &["model", scene, "--out", "same", "--json", "same"],
    );
}

#[test]
fn overrides_obey_the_ranges_of_the_scene() {
    let desk = desk();
    let message = refused(desk.path(), &["run", "periodic-2deg", "--tilt", "91"]);
    assert!(message.contains("a number from -90 to 90 deg"), "{message}");
    refused(desk.path(), &["run", "periodic-2deg", "--tilt", "nan"]);
    let message = refused(desk.path(), &["run", "periodic-2deg", "--duration", "-1"]);
    assert!(
        message.contains("`time.duration_ms` = -1 is out of range"),
        "{message}"
    );
}

#[test]
fn usage_errors_are_bad_input_too() {
    let desk = desk();
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
        squeakscope(desk.path(), words)
            .code(2)
            .stdout("")
            .stderr(predicate::str::starts_with("error: "));
    }
    squeakscope(desk.path(), &["stability", "--tilt", "0:7:-1"]).stderr(predicate::str::contains(
        "a step of -1 does not lead from 0 to 7",
    ));
    squeakscope(desk.path(), &["--version"])
        .success()
        .stdout(format!("squeakscope {}\n", squeakscope::VERSION));
    squeakscope(desk.path(), &["run", "--help"]).success();
}

/// Numbers that are each in range but make no joint together: bad input, with a remedy, and nothing
/// left behind.
#[test]
fn joints_that_cannot_be_are_bad_input() {
    let desk = desk();
    let printed = squeakscope::scene::preset("torus-3deg")
        .expect("preset")
        .text;
    assert!(printed.contains("load_n = 150") && printed.contains("tilt_deg = 3"));
    let text = printed
        .replace("load_n = 150", "load_n = 1e6")
        .replace("tilt_deg = 3", "tilt_deg = 80");
    std::fs::write(desk.path().join("scene.toml"), text).expect("written");
    let message = refused(desk.path(), &["run", "scene.toml", "--save", "out.rrd"]);
    assert!(message.contains("reaches the beam"), "{message}");
    let left = std::fs::read_dir(desk.path()).expect("folder").count();
    assert_eq!(left, 1, "only the scene");
}

/// Limits that several keys share are told with file, line and key like any other.
#[test]
fn shared_limits_are_told_at_their_line() {
    let desk = desk();
    let printed = squeakscope::scene::preset("torus-3deg")
        .expect("preset")
        .text;
    for (new, said) in [
        (
            "frequencies = \"fe\"\nbending_pairs = 50\ntorsion = 40",
            "at most 128",
        ),
        ("frequencies = \"fe\"\nelement_size_mm = 1", "at most 2000"),
    ] {
        let text = printed.replace("frequencies = \"published\"", new);
        assert_ne!(text, printed);
        std::fs::write(desk.path().join("scene.toml"), text).expect("written");
        let message = refused(desk.path(), &["run", "scene.toml", "--save", "out.rrd"]);
        assert!(
            message.starts_with("error: scene.toml:") && message.contains(said),
            "{message}"
        );
    }
}

/// What is held though it varies is told; what cannot be varied is refused.
#[test]
fn what_changes_with_time_is_held_and_told() {
    let desk = desk();
    std::fs::create_dir(desk.path().join("mine")).expect("made");
    let text = "load = { load_csv = \"load.csv\", tilt_deg = 1 }\ntime.duration_ms = 1\n\
                friction = { mu_s = 0.5, mu_d = 0.2 }\n";
    std::fs::write(desk.path().join("mine/scene.toml"), text).expect("written");
    let scene = "mine/scene.toml";
    let message = refused(desk.path(), &["run", scene, "--save", "out.rrd"]);
    assert!(
        message.contains(
            "mine/scene.toml:1: `load.load_csv`: the file `mine/load.csv` cannot be read"
        ),
        "{message}"
    );
    let table = desk.path().join("mine/load.csv");
    std::fs::write(&table, "time_ms,load_n\n0,100\n1,x\n").expect("written");
    let message = refused(desk.path(), &["run", scene, "--save", "out.rrd"]);
    assert!(
        message.contains("mine/load.csv:3: `load.load.load_n` is `x`"),
        "{message}"
    );

    std::fs::write(&table, "time_ms,load_n\n0,100\n1,150\n").expect("written");
    squeakscope(desk.path(), &["stability", scene])
        .success()
        .stderr(predicate::str::contains(
            "held at its first values: load 100 N",
        ));
    let over = [
        "sweep",
        scene,
        "--over",
        "load.load_n=100:150:50",
        "--out",
        "s.arrow",
    ];
    let message = refused(desk.path(), &over);
    assert!(
        message.contains("the load of this scene is a function of time"),
        "{message}"
    );
}

/// An output that would replace the scene is refused.
#[test]
fn the_scene_is_not_overwritten() {
    let desk = desk();
    let printed = squeakscope::scene::preset("torus-3deg")
        .expect("preset")
        .text;
    std::fs::write(desk.path().join("scene.toml"), printed).expect("written");
    let message = refused(
        desk.path(),
        &["run", "scene.toml", "--save", "./scene.toml"],
    );
    assert!(message.contains("is the input itself"), "{message}");
    assert_eq!(
        std::fs::read(desk.path().join("scene.toml")).expect("there"),
        printed.as_bytes()
    );
}
