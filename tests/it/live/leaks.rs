//! A long session with recordings, resets and scenes leaks no resources.
#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::Arc;
use std::time::{Duration, Instant};

use squeakscope::live::{Command, Panel, Session, SessionOptions};
use squeakscope::scene::Scene;
use squeakscope::sound::Source;

use super::DEADLINE;

/// Environment variable with the recording folder for the child process of [`a_long_session_leaks_nothing`].
const CHILD: &str = "SQUEAKSCOPE_TEST_LONG_SESSION";
/// Number of repetitions of each operation.
const TIMES: usize = 20;
/// Number of repetitions before the measurement, for one-time allocations such as entity names.
const WARM_UP: usize = 10;
/// Allowed increase of the allocated memory, kB: a fraction of one recording. A leaked thread per recording,
/// reset and scene would add 600 kB each.
const ALLOWED_KB: usize = 2_000;

/// Resources of a process.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    threads: usize,
    descriptors: usize,
    kilobytes: usize,
}

impl Held {
    fn now() -> Self {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
        let number = |name: &str| -> usize {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            let words = line.expect("the line exists").split_whitespace().next();
            words.expect("a number").parse().expect("a number")
        };
        Self {
            threads: number("Threads:"),
            descriptors: std::fs::read_dir("/proc/self/fd").expect("Linux").count(),
            kilobytes: number("VmRSS:"),
        }
    }
}

/// A session in its own process without other activity.
struct LongSession(Arc<Session>);

impl LongSession {
    fn until(&self, what: &str, holds: impl Fn(&Panel) -> bool) {
        let began = Instant::now();
        while !holds(&self.0.panel()) {
            assert!(began.elapsed() < DEADLINE, "timeout: {what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn ask(&self, command: Command) {
        self.0.apply(&command).expect("applied");
    }

    fn record(&self) {
        self.ask(Command::Record {});
        self.until("a recording", |panel| panel.recording.is_some());
        self.ask(Command::StopRecording {});
        self.until("its end", |panel| panel.recording.is_none());
    }

    /// Starts another run and waits for its first samples.
    fn restart(&self, command: Command) {
        let run = self.0.panel().run;
        self.ask(command);
        self.until("another run", |panel| panel.run > run && panel.time_s > 0.0);
    }

    fn work(&self, times: usize) {
        // A joint, whose recordings have the most entities, and two systems that start quickly.
        let scenes = ["doubled-torus-3deg", "mass-on-belt", "impact-oscillator"];
        for k in 0..times {
            self.record();
            self.restart(Command::Reset {});
            let name = scenes[if k % 10 == 0 { 0 } else { 1 + k % 2 }].to_owned();
            self.restart(Command::Scene { name });
        }
        let name = "mass-on-belt".to_owned();
        self.restart(Command::Scene { name });
    }
}

/// Not a test: the process of the session.
#[test]
fn child_with_a_long_session() {
    let Some(folder) = std::env::var_os(CHILD).map(PathBuf::from) else {
        return;
    };
    let session = Arc::new(Session::new(SessionOptions {
        scene: Scene::load("mass-on-belt").expect("preset"),
        command: "test".to_owned(),
        speed: 1.0,
        lyapunov: true,
        viewer: None,
        computes_diagram: true,
        folder: folder.clone(),
        save: None,
        wav: None,
        source: Source::default(),
        tour: None,
    }));
    session.start().expect("started");
    let long = LongSession(session);
    long.until("samples", |panel| panel.time_s > 0.0);
    long.work(WARM_UP);
    let before = Held::now();
    long.work(TIMES);
    let began = Instant::now();
    let mut after = Held::now();
    // A joined thread may still be counted for a moment.
    while (after.threads, after.descriptors) != (before.threads, before.descriptors) {
        assert!(began.elapsed() < DEADLINE, "{before:?}, then {after:?}");
        std::thread::sleep(Duration::from_millis(5));
        after = Held::now();
    }
    println!("{before:?}, then {after:?}");
    assert!(
        after.kilobytes < before.kilobytes + ALLOWED_KB,
        "{before:?}, then {after:?}"
    );
    long.0.end();
    long.0.join().expect("no error");
    let saved = long.0.saved(true);
    assert_eq!(saved.len(), WARM_UP + TIMES);
    assert!(saved.iter().all(|file| file.outcome.is_ok()));
}

#[test]
fn a_long_session_leaks_nothing() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let child = Process::new(std::env::current_exe().expect("this test"))
        .args([
            "--exact",
            "live::leaks::child_with_a_long_session",
            "--nocapture",
        ])
        .env(CHILD, folder.path())
        // Otherwise each thread has its own arena, and the memory varies randomly.
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .expect("started");
    let output = String::from_utf8_lossy(&child.stdout);
    println!("{output}{}", String::from_utf8_lossy(&child.stderr));
    assert!(child.status.success());
    assert!(output.contains("1 passed"), "the child process did not run");
    assert!(recordings(folder.path()).count() == WARM_UP + TIMES);
}

fn recordings(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let paths = entries.map(|entry| entry.expect("entry").path());
    paths.filter(|path| path.extension().is_some_and(|end| end == "rrd"))
}
