//! Files of a live run: messages about them are correct.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use squeakscope::record::{paths, read_series};

use super::{DEADLINE, Live, Socket};

/// Whether a message is on the panel.
fn has_message(panel: &Value, words: &str) -> bool {
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
        assert!(began.elapsed() < DEADLINE, "timeout: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn size(path: &Path) -> u64 {
    path.metadata().map_or(0, |there| there.len())
}

/// Checks that a session reports a missing file in one line with all of `words`, and does not name it
/// elsewhere.
#[track_caller]
fn is_missing(live: Live, file: &str, words: &[&str]) {
    let (code, stdout, stderr) = live.end();
    assert_eq!(code, Some(1), "{stderr}");
    let line = stderr.lines().find(|line| line.contains("was not saved"));
    let line = line.unwrap_or_else(|| panic!("no message about a file in: {stderr}"));
    for word in words.iter().chain([&file]) {
        assert!(line.contains(word), "`{word}` is missing in: {line}");
    }
    assert!(!stdout.lines().any(|line| line.ends_with(file)), "{stdout}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

/// A shell that runs the program with a file size limit, which simulates a full disk.
#[cfg(target_os = "linux")]
fn full_at(bytes: u64) -> [String; 4] {
    let script = format!("trap '' XFSZ; exec prlimit --fsize={bytes} \"$@\"");
    ["sh".to_owned(), "-c".to_owned(), script, "sh".to_owned()]
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_a_partial_file_that_is_named() {
    let launcher = full_at(2_000_000);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(
        &launcher,
        "doubled-torus-3deg",
        &["--speed", "1000", "--save", "run.rrd"],
    );
    let mut control = live.socket("/control");
    control.panel(|panel| has_message(panel, "run.rrd: "));
    let part = live.folder().join("run.rrd.part");
    let there = read_series(&part, Some(paths::DISPLACEMENT)).expect("readable");
    assert!(there.values.len() > 1000, "{}", there.values.len());
    let words = ["File too large", "can be opened", "run.rrd.part"];
    is_missing(live, "run.rrd", &words);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_full_from_the_start_leaves_nothing() {
    let launcher = full_at(8);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(&launcher, "mass-on-belt", &["--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| has_message(panel, "run.rrd: "));
    assert_eq!(live.folder().read_dir().expect("folder").count(), 0);
    is_missing(
        live,
        "run.rrd",
        &["cannot write a recording", "File too large"],
    );
}

/// A WAV file is written at the end. If it does not fit on the disk, the program reports an error.
#[cfg(target_os = "linux")]
#[test]
fn a_wav_file_that_does_not_fit_is_reported() {
    let launcher = full_at(5000);
    let launcher = launcher.each_ref().map(String::as_str);
    let live = Live::start_by(
        &launcher,
        "doubled-torus-3deg",
        &["--speed", "200", "--wav", "run.wav"],
    );
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.05));
    assert!(!live.folder().join("run.wav").exists());
    is_missing(live, "run.wav", &["the run failed"]);
}

#[test]
fn a_removed_folder_ends_the_recording() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let results = folder.path().join("results");
    std::fs::create_dir(&results).expect("created");
    let place = results.to_str().expect("text");
    let live = Live::start("mass-on-belt", &["--speed", "1000", "--record-dir", place]);
    let mut control = live.socket("/control");
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    until("a part", || size(&results.join("live-1.rrd.part")) > 10_000);
    std::fs::remove_dir_all(&results).expect("removed");
    control.panel(|panel| has_message(panel, "is lost"));
    // Another recording cannot start without the folder.
    let refused = control.ask(&json!({ "do": "record" })).expect("refused");
    assert!(refused.contains("cannot write a recording"), "{refused}");
    is_missing(live, "live-1.rrd", &["is lost", "removed or moved"]);
}

#[test]
fn a_removed_complete_file_is_reported() {
    let live = Live::start("mass-on-belt", &["--speed", "1000", "--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    std::fs::remove_file(live.folder().join("run.rrd")).expect("complete");
    is_missing(live, "run.rrd", &["was complete", "has been removed"]);
}

#[test]
fn files_recorded_during_the_session_are_named_at_the_end() {
    let live = Live::start("mass-on-belt", &["--save", "run.rrd"]);
    let mut control = live.socket("/control");
    control.panel(|panel| panel["recording"].is_string());
    assert_eq!(control.ask(&json!({ "do": "stop-recording" })), None);
    control.panel(|panel| panel["recording"].is_null());
    assert_eq!(control.ask(&json!({ "do": "record" })), None);
    let folder = live.folder().to_owned();
    until("a part", || size(&folder.join("live-1.rrd.part")) > 0);
    let (code, stdout, stderr) = live.end();
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    for name in ["run.rrd", "live-1.rrd"] {
        assert!(stdout.lines().any(|line| line.ends_with(name)), "{stdout}");
    }
}

/// The reported files exist, whenever the program is interrupted.
#[test]
fn an_immediate_interrupt_reports_existing_files() {
    for delay in (0..80).step_by(8) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let child = Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .current_dir(folder.path())
            .args(["live", "doubled-torus-3deg", "--port", "0", "--no-browser"])
            .args(["--save", "run.rrd", "--wav", "run.wav"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        // The assertions hold for every moment.
        std::thread::sleep(Duration::from_millis(delay));
        let id = child.id().to_string();
        // Not SIGINT, which a shell may ignore before the program installs its handler.
        let sent = Command::new("kill").args(["-TERM", &id]).status();
        assert!(sent.expect("kill").success());
        let ended = child.wait_with_output().expect("ended");
        let [stdout, stderr] = [&ended.stdout, &ended.stderr].map(|s| String::from_utf8_lossy(s));
        // Before the handler is installed, the signal kills the program as usual.
        let Some(code) = ended.status.code() else {
            continue;
        };
        let before_work = stderr.contains("before the computation started");
        let mut missing = 0;
        for name in ["run.rrd", "run.wav"] {
            let there = folder.path().join(name).exists();
            let is_printed = stdout
                .lines()
                .any(|line| line == folder_path(&folder, name));
            assert_eq!(is_printed, there, "{name}: {stdout}{stderr}");
            let is_reported = stderr
                .lines()
                .any(|line| line.contains(name) && line.contains("not saved"));
            assert_eq!(
                is_reported,
                !there && !before_work,
                "{name}: {stdout}{stderr}"
            );
            missing += usize::from(is_reported);
        }
        let expected = match (missing, before_work) {
            (0, true) => 130,
            (0, false) => 0,
            _ => 1,
        };
        assert_eq!(code, expected, "{stdout}{stderr}");
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

/// Two servers with the same folder record to different files.
#[test]
fn two_servers_in_one_folder_use_different_files() {
    const EACH: usize = 5;
    let folder = tempfile::tempdir().expect("temporary folder");
    let place = folder.path().to_str().expect("text");
    let servers: Vec<Live> = (0..2)
        .map(|_| {
            Live::start(
                "doubled-torus-3deg",
                &["--speed", "1000", "--record-dir", place],
            )
        })
        .collect();
    let record = |control: &mut Socket| {
        let mut files = Vec::new();
        for _ in 0..EACH {
            assert_eq!(control.ask(&json!({ "do": "record" })), None);
            let panel = control.panel(|panel| panel["recording"].is_string());
            files.push(panel["recording"].as_str().expect("a path").to_owned());
            // The panel is updated after the recorder. The file therefore contains samples of two frames.
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
            (Some(0), EACH),
            "{stdout}{stderr}"
        );
    }
}
