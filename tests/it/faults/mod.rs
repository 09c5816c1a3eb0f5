//! What goes wrong goes wrong for real here: full disks, folders that vanish, viewers that die, signals
//! at any moment, panics. Each ends in time, with a clear word and the right exit code, and keeps what
//! was promised.
//!
//! Disks are filled by a limit on the size of files, which every user can set, and by a small tmpfs
//! where namespaces are allowed. Viewers are played by listeners; the tests with a real one are ignored
//! unless asked for, since it is a program of its own:
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

/// Long after anything here should be over, on a busy machine too.
const DEADLINE: Duration = Duration::from_secs(60);
/// Simulated time that no test waits for, ms.
const ENDLESS: &str = "100000";
/// Samples a second of the scene that is run.
const SAMPLE_RATE: f64 = 200e3;

/// The program that is tested.
fn squeakscope() -> Command {
    Command::new(env!("CARGO_BIN_EXE_squeakscope"))
}

/// The joint for a simulated time (ms), into the current folder.
fn run(folder: &Path, duration_ms: &str, more: &[&str]) -> Command {
    let mut command = squeakscope();
    command
        .current_dir(folder)
        .args(["run", "torus-3deg", "--duration", duration_ms])
        .args(more);
    command
}

/// A program whose files must not grow beyond a size, as if the disk were full then. Any user may do
/// that. Unless the signal that goes with it is ignored, as it is here, it kills.
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

/// A program that is running, with a process group of its own, and does not outlive its test.
struct Running {
    child: Child,
    began: Instant,
}

/// How a program ended.
struct Ended {
    status: ExitStatus,
    stdout: String,
    stderr: String,
    took: Duration,
}

impl Running {
    fn start(asked: Command) -> Self {
        // Whoever starts the tests in the background may have them ignore signals from birth.
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
        Self {
            child: command.spawn().expect("started"),
            began: Instant::now(),
        }
    }

    /// Sends a signal to it and to all that it has started, as a terminal does.
    fn signal(&self, name: &str) {
        kill(name, &format!("-{}", self.child.id()));
    }

    /// Sends a signal to it alone.
    fn signal_alone(&self, name: &str) {
        kill(name, &self.child.id().to_string());
    }

    /// Waits for its end, which must come before the deadline.
    fn end(mut self) -> Ended {
        while self.child.try_wait().expect("status").is_none() {
            assert!(self.began.elapsed() < DEADLINE, "it hangs");
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

fn kill(signal: &str, whom: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, "--", whom])
        .status();
    assert!(sent.expect("kill").success(), "no {signal} for {whom}");
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
    /// The exit code, and one line for a human that has all of `words`.
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
                "no `{word}` in: {}",
                self.stderr
            );
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }
}

/// Waits until something holds.
#[track_caller]
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < DEADLINE, "waited in vain: {what}");
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

/// The samples in a recording, none missing between the first and the last.
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

/// A folder, and the place of a recording in it.
fn desk() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let recording = folder.path().join("run.rrd");
    (folder, recording)
}
