//! Real faults: full disks, removed folders, crashed viewers, signals at any moment, panics. Each ends the
//! program in time with a clear message and the right exit code, and keeps the promised files.
//!
//! Full disks are simulated by a limit on the file size, which every user can set, and by a small tmpfs where
//! namespaces are allowed. Viewers are simulated by listeners; the tests with a real viewer are ignored by
//! default, since they need another program:
//!
//! ```sh
//! SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored
//! ```

mod disk;
mod environment;
mod outputs;
mod panics;
mod signals;
mod slow;
mod studies;
mod threads;
mod viewers;

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use squeakscope::record::{Series, paths, read_series};

/// Timeout for everything in these tests, on a busy machine too.
const DEADLINE: Duration = Duration::from_secs(60);
/// A simulated time that no test reaches, ms.
const ENDLESS: &str = "100000";
/// Sample rate of the simulated scene, Hz.
const SAMPLE_RATE: f64 = 200e3;

/// The tested program.
fn squeakscope() -> Command {
    Command::new(env!("CARGO_BIN_EXE_squeakscope"))
}

/// Runs the joint for a simulated time (ms), with output to the current folder.
fn run(folder: &Path, duration_ms: &str, more: &[&str]) -> Command {
    let mut command = squeakscope();
    command
        .current_dir(folder)
        .args(["run", "doubled-torus-3deg", "--duration", duration_ms])
        .args(more);
    command
}

/// Runs a program with a file size limit, which simulates a full disk. Any user may set it. The corresponding
/// signal kills the program unless it is ignored, as it is here.
fn on_a_small_disk(bytes: u64, program: &Command) -> Running {
    let mut shell = Command::new("sh");
    let script = format!("trap '' XFSZ; exec prlimit --fsize={bytes} \"$@\"");
    shell
        .args(["-c", &script, "sh"])
        .arg(program.get_program())
        .args(program.get_args());
    if let Some(folder) = program.get_current_dir() {
        shell.current_dir(folder);
    }
    Running::start(shell)
}

/// A running program in its own process group, stopped at the end of its test.
struct Running {
    child: Child,
    began: Instant,
}

/// Result of a program.
struct Ended {
    status: ExitStatus,
    stdout: String,
    stderr: String,
    took: Duration,
}

impl Running {
    fn start(asked: Command) -> Self {
        // A background job may have inherited ignored signals.
        let mut command = Command::new("/usr/bin/env");
        command
            .arg("--default-signal=HUP,INT,TERM")
            .arg(asked.get_program())
            .args(asked.get_args());
        if let Some(folder) = asked.get_current_dir() {
            command.current_dir(folder);
        }
        for (name, value) in asked.get_envs() {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0);
        let child = command.spawn().expect("started");
        let pid = child.id().to_string();
        // A signal sent before `env` has reset its action would be lost.
        while ignores_interrupt("self") && ignores_interrupt(&pid) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Self {
            child,
            began: Instant::now(),
        }
    }

    /// Sends a signal to the program and all its children, as a terminal does.
    fn signal(&self, name: &str) {
        kill(name, &format!("-{}", self.child.id()));
    }

    /// Sends a signal to the program only.
    fn signal_alone(&self, name: &str) {
        kill(name, &self.child.id().to_string());
    }

    /// Waits for the end of the program, which must come before the deadline.
    fn end(mut self) -> Ended {
        while self.child.try_wait().expect("status").is_none() {
            assert!(self.began.elapsed() < DEADLINE, "the program hangs");
            std::thread::sleep(Duration::from_millis(2));
        }
        let took = self.began.elapsed();
        let text = |stream: &mut dyn std::io::Read| {
            let mut text = String::new();
            stream.read_to_string(&mut text).expect("text");
            text
        };
        let stdout = text(self.child.stdout.as_mut().expect("piped"));
        let stderr = text(self.child.stderr.as_mut().expect("piped"));
        Ended {
            status: self.child.wait().expect("status"),
            stdout,
            stderr,
            took,
        }
    }
}

/// Whether a process ignores SIGINT; `false` where the system does not tell.
fn ignores_interrupt(pid: &str) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 2 != 0)
}

fn kill(signal: &str, whom: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, "--", whom])
        .status();
    assert!(
        sent.expect("kill").success(),
        "cannot send {signal} to {whom}"
    );
}

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            self.signal("KILL");
            let _ = self.child.wait();
        }
    }
}

impl Ended {
    /// Checks the exit code, and one line of the standard error that contains all of `words`.
    #[track_caller]
    fn said(&self, code: i32, words: &[&str]) {
        assert_eq!(
            self.status.code(),
            Some(code),
            "{:?}: {}",
            self.status,
            self.stderr
        );
        for word in words {
            assert!(
                self.stderr.contains(word),
                "`{word}` is missing in: {}",
                self.stderr
            );
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }
}

/// Waits until a condition holds.
#[track_caller]
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < DEADLINE, "timeout: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |there| there.len())
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let mut names: Vec<String> = entries
        .map(|entry| {
            entry
                .expect("entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

/// The samples in a recording, without gaps.
#[track_caller]
fn samples(recording: &Path) -> Series {
    let series = read_series(recording, Some(paths::DISPLACEMENT)).expect("readable");
    for (k, time) in series.times.iter().enumerate() {
        assert!(
            (time * SAMPLE_RATE - k as f64).abs() < 0.1,
            "sample {k} at {time} s"
        );
    }
    assert!(series.values.iter().all(|value| value.is_finite()));
    series
}

/// A folder, and the path of a recording in it.
fn desk() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let recording = folder.path().join("run.rrd");
    (folder, recording)
}
