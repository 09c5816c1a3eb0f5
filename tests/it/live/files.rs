//! Files that a live run was asked for: what is said of them is true.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use squeakscope::record::{paths, read_series};

use super::{DEADLINE, Live, Socket};

/// Whether something has been told on the page.
fn told(panel: &Value, words: &str) -> bool {
    let events = panel["events"].as_array().expect("events");
    let has = |event: &Value| {
        event["text"]
            .as_str()
            .is_some_and(|text| text.contains(words))
    };
    events.iter().any(has)
}

fn until(what: &str, holds: impl Fn() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < DEADLINE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn size(path: &Path) -> u64 {
    path.metadata().map_or(0, |there| there.len())
}

/// A session of which a file is missing says so, in one line with all of `words`, and names it nowhere else.
#[track_caller]
fn is_missing(live: Live, file: &str, words: &[&str]) {
    let (code, stdout, stderr) = live.end();
    assert_eq!(code, Some(1), "{stderr}");
    let line = stderr.lines().find(|line| line.contains("was not saved"));
    let line = line.unwrap_or_else(|| panic!("nothing of a file in: {stderr}"));
    for word in words.iter().chain([&file]) {
        assert!(line.contains(word), "no `{word}` in: {line}");
    }
    assert!(!stdout.lines().any(|line| line.ends_with(file)), "{stdout}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

/// A shell that gives way to the program, whose files must not grow beyond a size, as if the disk were full.
#[cfg(target_os = "linux")]
fn full_at(bytes: u64) -> [String; 4] {
    let script = format!("trap '' XFSZ; exec prlimit --fsize={bytes} \"$@\"");
    ["sh".to_owned(), "-c".to_owned(), script, "sh".to_owned()]
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_a_part_that_is_named() {
    let launcher = full_at(2_000_000);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(
        &launcher,
        "torus-3deg",
        &["--pace", "1000", "--save", "run.rrd"],
    );
    let mut control = live.socket("/control");
    control.panel(|panel| told(panel, "run.rrd cannot be written"));
    let part = live.folder().join("run.rrd.part");
    let there = read_series(&part, Some(paths::DISPLACEMENT)).expect("readable");
    assert!(there.values.len() > 1000, "{}", there.values.len());
    let words = ["File too large", "can be opened", "run.rrd.part"];
    is_missing(live, "run.rrd", &words);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_from_the_start_leaves_nothing() {
    let launcher = full_at(8);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(&launcher, "mass-on-belt", &["--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| told(panel, "run.rrd cannot be written"));
    assert_eq!(live.folder().read_dir().expect("folder").count(), 0);
    is_missing(
        live,
        "run.rrd",
        &["cannot write a recording", "File too large"],
    );
}

/// What a disk has no room for at the end is a fault, too: a sound is written then.
#[cfg(target_os = "linux")]
#[test]
fn a_sound_that_does_not_fit_is_told() {
    let launcher = full_at(5000);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(
        &launcher,
        "torus-3deg",
        &["--pace", "200", "--wav", "run.wav"],
    );
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.05));
    assert!(!live.folder().join("run.wav").exists());
    is_missing(live, "run.wav", &["the run failed"]);
}

#[test]
fn a_folder_that_is_removed_takes_the_recording_with_it() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let results = folder.path().join("results");
    std::fs::create_dir(&results).expect("made");
    let place = results.to_str().expect("text");
    let live = Live::start("mass-on-belt", &["--pace", "1000", "--folder", place]);
    let mut control = live.socket("/control");
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    until("a part", || size(&results.join("live-1.rrd.part")) > 10_000);
    std::fs::remove_dir_all(&results).expect("removed");
    control.panel(|panel| told(panel, "is lost"));
    // There is nowhere to begin another.
    let refused = control.ask(&json!({ "do": "record" })).expect("refused");
    assert!(refused.contains("cannot write a recording"), "{refused}");
    is_missing(live, "live-1.rrd", &["is lost", "removed or moved"]);
}

#[test]
fn what_was_removed_after_it_was_complete_is_told() {
    let live = Live::start("mass-on-belt", &["--pace", "1000", "--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    std::fs::remove_file(live.folder().join("run.rrd")).expect("complete");
    is_missing(live, "run.rrd", &["was complete", "no longer"]);
}

#[test]
fn what_was_recorded_on_the_way_is_named_at_the_end() {
    let live = Live::start("mass-on-belt", &["--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    let folder = live.folder().to_owned();
    until("a part", || size(&folder.join("live-1.rrd.part")) > 0);
    let (code, stdout, stderr) = live.end();
    assert_eq!(code, Some(130), "{stderr}");
    for name in ["run.rrd", "live-1.rrd"] {
        assert!(stdout.lines().any(|line| line.ends_with(name)), "{stdout}");
    }
}

/// Whenever it is interrupted, there is what is said to be there.
#[test]
fn interrupted_at_once_it_says_what_is_there() {
    for delay in 0..40 {
        let folder = tempfile::tempdir().expect("temporary folder");
        let child = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .current_dir(folder.path())
            .args(["live", "torus-3deg", "--serve", "--port", "0", "--no-keys"])
            .args(["--save", "run.rrd", "--wav", "run.wav"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        // Any moment will do: what is checked holds at all of them.
        std::thread::sleep(Duration::from_millis(2 * delay));
        let id = child.id().to_string();
        // Not SIGINT, which a shell may have had ignored until it is caught.
        let sent = Command::new("kill").args(["-TERM", &id]).status();
        assert!(sent.expect("kill").success());
        let ended = child.wait_with_output().expect("ended");
        let [stdout, stderr] = [&ended.stdout, &ended.stderr].map(|s| String::from_utf8_lossy(s));
        // Before Ctrl-C is caught it ends the program as it does any other.
        let Some(code) = ended.status.code() else {
            continue;
        };
        let before_work = stderr.contains("before anything was begun");
        let mut missing = 0;
        for name in ["run.rrd", "run.wav"] {
            let there = folder.path().join(name).exists();
            let is_printed = stdout
                .lines()
                .any(|line| line == folder_path(&folder, name));
            assert_eq!(is_printed, there, "{name}: {stdout}{stderr}");
            let is_told = stderr
                .lines()
                .any(|line| line.contains(name) && line.contains("not saved"));
            assert_eq!(is_told, !there && !before_work, "{name}: {stdout}{stderr}");
            missing += usize::from(is_told);
        }
        assert_eq!(code, if missing > 0 { 1 } else { 130 }, "{stdout}{stderr}");
        let left = folder.path().join("run.rrd.part");
        assert!(
            !left.exists() || stderr.contains("run.rrd.part"),
            "{stderr}"
        );
    }
}

fn folder_path(folder: &tempfile::TempDir, name: &str) -> String {
    let folder = folder.path().canonicalize().expect("a folder");
    folder.join(name).display().to_string()
}

/// Two servers that share a folder record into files of their own.
#[test]
fn two_servers_with_one_folder_never_write_one_file() {
    const EACH: usize = 5;
    let folder = tempfile::tempdir().expect("temporary folder");
    let place = folder.path().to_str().expect("text");
    let servers: Vec<Live> = (0..2)
        .map(|_| Live::start("torus-3deg", &["--pace", "1000", "--folder", place]))
        .collect();
    let record = |control: &mut Socket| {
        let mut files = Vec::new();
        for _ in 0..EACH {
            assert_eq!(control.ask(&json!({ "do": "record" })), None);
            let panel = control.panel(|panel| panel["recording"].is_string());
            files.push(panel["recording"].as_str().expect("a path").to_owned());
            // Samples of two frames are in it: the panel is the last to be told of a frame.
            for _ in 0..2 {
                let seen = control.panel(|_| true)["time_s"].as_f64();
                control.panel(|panel| panel["time_s"].as_f64() > seen);
            }
            assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
            control.panel(|panel| panel["recording"].is_null());
        }
        files
    };
    let mut files: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = servers
            .iter()
            .map(|live| scope.spawn(|| record(&mut live.socket("/control"))))
            .collect();
        let joined = threads
            .into_iter()
            .map(|thread| thread.join().expect("recorded"));
        joined.flatten().collect()
    });
    files.sort();
    files.dedup();
    assert_eq!(files.len(), 2 * EACH, "{files:?}");
    for file in files.iter().map(PathBuf::from) {
        read_series(&file, Some(paths::DISPLACEMENT)).expect("complete");
    }
    for live in servers {
        let (code, stdout, stderr) = live.end();
        assert_eq!(
            (code, stdout.lines().count()),
            (Some(130), EACH),
            "{stdout}{stderr}"
        );
    }
}
