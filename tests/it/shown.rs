//! Names and texts of foreign files are escaped in terminals and figures, and unchanged in JSON.

use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use serde_json::Value;
use squeakscope::numpy::{Array, encode_npz};

/// Clears the terminal, sets a colour in two notations, reverses the line, and fakes a message.
const NAME: &str = "a\u{1b}[2J\u{1b}[35mb\u{9b}35m\u{202e}c\u{2066}\nerror: faked\rd";

/// [`NAME`] as shown in a terminal.
const SHOWN: &str = "a\\u001b[2J\\u001b[35mb\\u009b35m\\u202ec\\u2066\\nerror: faked\\rd";

/// Runs a command as in a terminal with colours.
fn squeakscope(folder: &Path, args: &[&str]) -> Assert {
    Command::new(env!("CARGO_BIN_EXE_squeakscope"))
        .current_dir(folder)
        .env("CLICOLOR_FORCE", "1")
        .args(args)
        .assert()
}

/// Asserts that no part of a name acts on the terminal: only line breaks and the program's own colours
/// remain.
#[track_caller]
fn assert_harmless(text: &str) {
    let hidden =
        |c: char| c.is_control() && !"\n\u{1b}".contains(c) || "\u{202e}\u{2066}".contains(c);
    assert!(!text.contains(hidden), "{text:?}");
    for piece in text.split('\u{1b}').skip(1) {
        let code = piece
            .strip_prefix('[')
            .and_then(|rest| rest.split_once('m'));
        let code = code.unwrap_or_else(|| panic!("{text:?}")).0;
        assert!(
            code.chars().all(|c| c.is_ascii_digit()) && code != "35",
            "{text:?}"
        );
    }
    let fakes = |line: &str| line.starts_with("error: faked");
    assert!(!text.lines().any(fakes), "{text:?}");
}

/// Asserts an error message of one line that contains `name`, and no other output on standard error.
#[track_caller]
fn assert_error(assert: Assert, code: i32, name: &str) {
    let assert = assert.code(code);
    let message = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
    assert_harmless(&message);
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains(name), "{message}");
}

/// The standard output, which contains `name`.
#[track_caller]
fn printed(assert: Assert, name: &str) -> String {
    let assert = assert.success();
    let output = assert.get_output();
    for stream in [&output.stdout, &output.stderr] {
        assert_harmless(&String::from_utf8(stream.clone()).expect("text"));
    }
    let text = String::from_utf8(output.stdout.clone()).expect("text");
    assert!(text.contains(name), "{text}");
    text
}

fn json(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("out.json")).expect("written");
    serde_json::from_slice(&text).expect("JSON")
}

#[test]
fn names_of_arrays_are_escaped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let samples = (0..600)
        .map(|k| (0.13 * f64::from(k)).sin())
        .collect::<Vec<_>>();
    let array = || Array::vector(samples.clone());
    let arrays = [(NAME, array()), ("other", array())];
    let npz = std::fs::File::create(folder.path().join("a.npz")).expect("created");
    encode_npz(npz, &arrays).expect("written");
    assert_error(squeakscope(folder.path(), &["analyse", "a.npz"]), 2, SHOWN);
    let args = [
        "analyse",
        "a.npz",
        "--column",
        NAME,
        "--rate",
        "1000",
        "--json",
        "out.json",
        "--figures",
        "figures",
    ];
    printed(squeakscope(folder.path(), &args), SHOWN);
    assert_eq!(json(folder.path())["signal"]["name"], NAME);
    assert!(folder.path().join("figures/regime.png").exists());
}

#[test]
fn headings_and_fields_of_tables_are_escaped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    // With other control characters it is not text and is rejected.
    let (name, shown) = ("b\u{9b}35m\u{202e}c\u{2066}", "b\\u009b35m\\u202ec\\u2066");
    let rows: String = (0..600)
        .map(|k| format!("{},1\n", (0.13 * f64::from(k)).sin()))
        .collect();
    let path = folder.path().join("a.csv");
    std::fs::write(&path, format!("{name},b\n{rows}")).expect("written");
    assert_error(squeakscope(folder.path(), &["analyse", "a.csv"]), 2, shown);
    let args = [
        "analyse", "a.csv", "--column", name, "--rate", "1000", "--json", "out.json",
    ];
    printed(squeakscope(folder.path(), &args), shown);
    assert_eq!(json(folder.path())["signal"]["name"], name);
    std::fs::write(&path, format!("u,b\n{rows}{name},1\n")).expect("written");
    let args = ["analyse", "a.csv", "--column", "u", "--rate", "1000"];
    assert_error(squeakscope(folder.path(), &args), 2, shown);
}

#[test]
fn paths_and_arguments_are_escaped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    assert_error(squeakscope(folder.path(), &["analyse", NAME]), 2, SHOWN);
    assert_error(squeakscope(folder.path(), &["run", NAME]), 2, SHOWN);
    std::fs::write(folder.path().join(format!("{NAME}.wav")), "RIFF").expect("written");
    assert_error(
        squeakscope(folder.path(), &["analyse", &format!("{NAME}.wav")]),
        2,
        SHOWN,
    );
    // The argument parser formats its own lines.
    let option = format!("--{NAME}");
    let rejected = squeakscope(folder.path(), &["run", &option]).code(2);
    let message = String::from_utf8(rejected.get_output().stderr.clone()).expect("text");
    assert_harmless(&message);
    assert!(message.contains(SHOWN), "{message}");
}

/// A scene with a malicious name, title and description.
fn scene(folder: &Path) {
    let text = squeakscope::scene::preset("periodic-2deg")
        .expect("preset")
        .text;
    let body = &text[text.find("[body]").expect("a table")..];
    // TOML and JSON have the same notation for such text.
    let name = serde_json::to_string(NAME).expect("text");
    let head = format!("name = {name}\ntitle = {name}\nabout = {name}\n");
    std::fs::write(folder.join("evil.toml"), head + body).expect("written");
}

#[test]
fn texts_of_scenes_are_escaped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let folder = folder.path();
    scene(folder);
    let args = [
        "run",
        "evil.toml",
        "--duration",
        "5",
        "--npz",
        "a.npz",
        "--json",
        "out.json",
    ];
    printed(squeakscope(folder, &args), SHOWN);
    assert_eq!(json(folder)["scene"], NAME);
    printed(
        squeakscope(folder, &["stability", "evil.toml", "--tilt", "2"]),
        SHOWN,
    );
    printed(
        squeakscope(folder, &["model", "evil.toml", "--out", "m.npz"]),
        SHOWN,
    );
    printed(squeakscope(folder, &["scenes", "evil.toml"]), "\\u009b35m");
    let args = [
        "sweep",
        "evil.toml",
        "--tilt",
        "2:3:1",
        "--start",
        "fresh",
        "--max-transient",
        "50",
        "--measure",
        "5",
        "--exponents",
        "0",
        "--figures",
        "figures",
    ];
    printed(squeakscope(folder, &args), SHOWN);
    let figure = std::fs::read_to_string(folder.join("figures/bifurcation.svg")).expect("text");
    assert!(figure.contains("\\u001b[2J"), "the title");
    assert!(!figure.contains(|c: char| c.is_control() && c != '\n' || c == '\u{202e}'));
}

/// Names of entities are set by the author of the recording.
#[test]
fn columns_of_recordings_are_escaped() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let rec = rerun::RecordingStreamBuilder::new("foreign")
        .save(folder.path().join("a.rrd"))
        .expect("opened");
    for k in 0..3 {
        rec.set_duration_secs("t", f64::from(k));
        for name in [NAME, "other"] {
            let path = rerun::EntityPath::from_single_string(name);
            rec.log(
                path,
                &re_sdk_types::archetypes::Scalars::single(f64::from(k)),
            )
            .expect("logged");
        }
    }
    rec.flush_blocking().expect("written");
    drop(rec);
    let rejected = squeakscope(folder.path(), &["analyse", "a.rrd"]);
    assert_error(rejected, 2, "35m");
}
