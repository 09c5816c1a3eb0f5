//! Unwritable outputs and insufficient memory are detected before the work starts.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{Ended, Running, desk, names, squeakscope};

fn asked(folder: &Path, words: &str) -> Command {
    let mut command = squeakscope();
    command.current_dir(folder).args(words.split(' '));
    command
}

fn ended(folder: &Path, words: &str) -> Ended {
    Running::start(asked(folder, words)).end()
}

/// All outputs of all commands; `%` is replaced by the file. Each command would run for minutes.
const OUTPUTS: &[(&str, &str)] = &[
    ("run --duration 100000 --save %", "a.rrd"),
    ("run --duration 100000 --npz %", "a.npz"),
    ("run --duration 100000 --wav %", "a.wav"),
    ("run --duration 100000 --json %", "a.json"),
    ("live --no-browser --port 0 --save %", "a.rrd"),
    ("live --no-browser --port 0 --wav %", "a.wav"),
    ("scenes --json %", "a.json"),
    ("stability --json %", "a.json"),
    ("model --out %", "a.npz"),
    ("model --out b.npz --json %", "a.json"),
    ("lyapunov --average-time 100 --figures %", "a.png"),
    ("lyapunov --average-time 100 --csv %", "a.csv"),
    ("lyapunov --average-time 100 --json %", "a.json"),
    ("sweep --out %", "a.arrow"),
    ("sweep --resume --out %", "a.arrow"),
    ("sweep --save %", "a.rrd"),
    ("sweep --json %", "a.json"),
    ("basins --out %", "a.arrow"),
    ("basins --save %", "a.rrd"),
    ("basins --json %", "a.json"),
    ("paper --json %", "a.json"),
    ("cost --json %", "a.json"),
    ("analyse s.csv --rate 1000 --save %", "a.rrd"),
    ("analyse s.csv --rate 1000 --json %", "a.json"),
];

/// All output folders of all commands, and a file written there.
const DIRECTORIES: &[(&str, &str)] = &[
    ("lyapunov --average-time 100 --figures %", "lyapunov.png"),
    ("sweep --figures %", "bifurcation.svg"),
    ("basins --figures %", "basins.png"),
    ("paper --out %", "figure-11.svg"),
    ("paper --out %", "sweep.arrows"),
    ("paper --out %", "README.md"),
    ("cost --figures %", "cost.svg"),
    ("analyse s.csv --rate 1000 --figures %", "zero-one.png"),
];

/// A folder with a signal file.
fn folder() -> tempfile::TempDir {
    let (folder, _) = desk();
    let rows: String = (0..600)
        .map(|k| format!("{}\n", (0.13 * f64::from(k)).sin()))
        .collect();
    std::fs::write(folder.path().join("s.csv"), format!("u\n{rows}")).expect("written");
    folder
}

fn protect(path: &Path) {
    std::fs::write(path, "kept").expect("written");
    std::fs::set_permissions(path, Permissions::from_mode(0o444)).expect("protected");
}

#[test]
fn a_protected_output_is_rejected_before_the_work() {
    for (words, name) in OUTPUTS {
        let folder = folder();
        let path = folder.path().join(name);
        protect(&path);
        let ended = ended(folder.path(), &words.replace('%', name));
        ended.said(2, &["is write-protected", name]);
        assert_eq!(std::fs::read(&path).expect("there"), b"kept", "{words}");
        assert_eq!(names(folder.path()).len(), 2, "{words}");
    }
    for (words, name) in DIRECTORIES {
        let folder = folder();
        let directory = folder.path().join("there");
        std::fs::create_dir(&directory).expect("created");
        protect(&directory.join(name));
        let ended = ended(folder.path(), &words.replace('%', "there"));
        ended.said(2, &["is write-protected", name]);
        assert_eq!(names(&directory), [*name], "{words}");
    }
}

/// The table that grows is an output, too.
#[test]
fn a_protected_growing_table_is_rejected_before_the_work() {
    let folder = folder();
    protect(&folder.path().join("a.arrows"));
    ended(folder.path(), "sweep --out a.arrow").said(2, &["is write-protected", "a.arrows"]);
}

#[test]
fn a_file_name_that_is_too_long_is_rejected_before_the_work() {
    let folder = folder();
    for (words, name) in OUTPUTS {
        let (_, ending) = name.split_once('.').expect("an ending");
        let long = format!("{}.{ending}", "x".repeat(254 - ending.len()));
        ended(folder.path(), &words.replace('%', &long))
            .said(2, &["is too long for the file system"]);
        assert_eq!(names(folder.path()), ["s.csv"], "{words}");
    }
    for (words, _) in DIRECTORIES {
        let long = "x".repeat(256);
        ended(folder.path(), &words.replace('%', &long))
            .said(2, &["is too long for the file system"]);
        assert_eq!(names(folder.path()), ["s.csv"], "{words}");
    }
    // The longest valid name.
    let fits = format!("{}.npz", "x".repeat(243));
    ended(folder.path(), &format!("run --duration 1 --npz {fits}")).said(0, &[]);
    assert_eq!(names(folder.path()), ["s.csv", &fits]);
}

/// Runs a command with a limited address space, kB.
fn cramped(folder: &Path, kilobytes: u32, words: &str) -> Ended {
    let mut shell = Command::new("sh");
    let script = format!("ulimit -v {kilobytes}; exec \"$@\"");
    shell
        .args(["-c", &script, "sh"])
        .arg(squeakscope().get_program());
    shell.args(words.split(' ')).current_dir(folder);
    Running::start(shell).end()
}

/// 300 MB are sufficient for everything except recordings, which report this before the work.
#[test]
fn insufficient_memory_ends_in_an_error() {
    let folder = folder();
    for words in [
        "run --duration 100000",
        "run doubled-torus-3deg --duration 5 --npz a.npz --wav a.wav --json a.json",
        "sweep doubled-torus-3deg --tilt 2:3:1 --out b.arrow",
        "sweep --save a.rrd --out a.arrow",
        "basins --save a.rrd --out a.arrow",
        "cost --figures cost",
        "paper --out paper",
        "analyse s.csv --rate 1000 --save a.rrd",
        "live --no-browser --port 0",
    ] {
        let ended = cramped(folder.path(), 300_000, words);
        ended.said(1, &["MB of address space, which the system does not grant"]);
        assert_eq!(ended.stderr.matches("error").count(), 1, "{}", ended.stderr);
        assert_eq!(names(folder.path()), ["s.csv"], "{words}");
    }
    for words in [
        "stability --tilt 2",
        "lyapunov impact-oscillator --average-time 0.1 --figures a.png",
    ] {
        cramped(folder.path(), 300_000, words).said(0, &[]);
    }
    // With the maximum number of elements.
    let text = squeakscope::scene::preset("periodic-2deg")
        .expect("preset")
        .text;
    let text = text.replace("[body] ", "[body]\nelement_size_mm = 1.4 #");
    std::fs::write(folder.path().join("fine.toml"), text).expect("written");
    for words in [
        "model fine.toml --out m.npz",
        "stability fine.toml --tilt 2",
    ] {
        let ended = cramped(folder.path(), 300_000, words);
        ended.said(1, &["the finite elements need about", "larger elements"]);
    }
    // Windows of 10 s at 2 MHz.
    let scene = squeakscope::scene::preset("impact-oscillator")
        .expect("preset")
        .text;
    let head = scene.split("[analysis").next().expect("text");
    let text = format!("{head}[analysis.spectrum]\nwindow_ms = 10000\nevery_ms = 100\n");
    let text = text.replace("sample_rate_khz = 20\n", "sample_rate_khz = 2000\n");
    std::fs::write(folder.path().join("long.toml"), text).expect("written");
    let ended = cramped(folder.path(), 500_000, "run long.toml --npz c.npz");
    ended.said(1, &["the analysis windows need about", "window_ms"]);
    assert!(!folder.path().join("c.npz").exists());
}

/// A step so long that the energy audit fails, with and without `--strict`.
#[test]
fn a_failed_audit_is_reported_in_every_output() {
    let (folder, _) = desk();
    let text = squeakscope::scene::preset("doubled-torus-3deg")
        .expect("preset")
        .text;
    let coarse = text
        .replace("tolerance = 1e-5", "max_step_us = 8")
        .replace("method = \"lawson54\"", "method = \"rk4\"");
    assert_ne!(coarse, text);
    std::fs::write(folder.path().join("coarse.toml"), coarse).expect("written");
    let audit = || -> Value {
        let json = std::fs::read(folder.path().join("a.json")).expect("written");
        serde_json::from_slice::<Value>(&json).expect("JSON")["audit"].take()
    };
    let words = "run coarse.toml --duration 20 --npz a.npz --json a.json --force";
    let lax = ended(folder.path(), words);
    lax.said(0, &["warning: the energy audit failed", "time.max_step_us"]);
    assert!(audit()["residual"].as_f64() > Some(0.05), "{}", audit());
    assert_eq!(audit()["limit"], 0.05);
    assert_eq!(audit()["holds"], false);
    std::fs::remove_file(folder.path().join("a.json")).expect("removed");
    let strict = ended(folder.path(), &format!("{words} --strict"));
    strict.said(1, &["error: the energy audit failed", "(--strict)"]);
    assert_eq!(audit()["holds"], false, "written nevertheless");
    // A passed audit, and no audit.
    let fine = "run doubled-torus-3deg --duration 20 --npz a.npz --json a.json --strict --force";
    ended(folder.path(), fine).said(0, &[]);
    assert_eq!(audit()["holds"], true);
    let none = "run impact-oscillator --duration 20 --npz a.npz --json a.json --force";
    ended(folder.path(), none).said(0, &[]);
    assert!(audit().is_null());
    let strict = ended(folder.path(), &format!("{none} --strict"));
    strict.said(2, &["no energy audit (--strict)"]);
}
