//! What a long session leaves behind when its recordings, resets and scenes are over: nothing.
#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::Arc;
use std::time::{Duration, Instant};

use squeakscope::live::{Command, Panel, Plan, Running, Session, Watcher};
use squeakscope::scene::Scene;
use squeakscope::sound::Source;

use super::DEADLINE;

/// Tells the child of [`a_long_session_leaves_nothing_behind`] where to record.
const CHILD: &str = "SQUEAKSCOPE_TEST_LONG_SESSION";
/// How often each thing is done.
const TIMES: usize = 200;
/// How often it is done before, so that what is made once is there, such as names of entities.
const WARM_UP: usize = 20;
/// What the allocator may hold more of afterwards, kB: a part of one recording. With threads left behind it was
/// 600 for each recording, reset and scene.
const ALLOWED_KB: usize = 16_000;

/// What a process holds.
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
            let words = line.expect("told").split_whitespace().next();
            words.expect("a number").parse().expect("a number")
        };
        Self {
            threads: number("Threads:"),
            descriptors: std::fs::read_dir("/proc/self/fd").expect("Linux").count(),
            kilobytes: number("VmRSS:"),
        }
    }
}

/// A session in a process of its own, in which nothing else comes and goes.
struct LongSession(Arc<Session>);

impl LongSession {
    fn until(&self, what: &str, holds: impl Fn(&Panel) -> bool) {
        let began = Instant::now();
        while !holds(&self.0.panel()) {
            assert!(began.elapsed() < DEADLINE, "waited in vain: {what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn ask(&self, command: Command) {
        self.0.obey(&command).expect("carried out");
    }

    fn record(&self) {
        self.ask(Command::Record {});
        self.until("a recording", |panel| panel.recording.is_some());
        self.ask(Command::StopRecording {});
        self.until("its end", |panel| panel.recording.is_none());
    }

    /// Asks for another run, and waits for its first samples.
    fn begin_anew(&self, command: Command) {
        let run = self.0.panel().run;
        self.ask(command);
        self.until("another run", |panel| panel.run > run && panel.time_s > 0.0);
    }

    fn work(&self, times: usize) {
        // A joint, whose recordings have the most entities, and two systems that are begun in no time.
        let scenes = ["torus-3deg", "mass-on-belt", "impact-oscillator"];
        for k in 0..times {
            self.record();
            self.begin_anew(Command::Reset {});
            let name = scenes[if k % 10 == 0 { 0 } else { 1 + k % 2 }].to_owned();
            self.begin_anew(Command::Scene { name });
        }
        let name = "mass-on-belt".to_owned();
        self.begin_anew(Command::Scene { name });
    }
}

/// Not a test: the process of the session.
#[test]
fn child_with_a_long_session() {
    let Some(folder) = std::env::var_os(CHILD).map(PathBuf::from) else {
        return;
    };
    let session = Arc::new(Session::new(Plan {
        scene: Scene::load("mass-on-belt").expect("preset"),
        command: "test".to_owned(),
        pace: 1.0,
        neighbours: true,
        watcher: Watcher::Page,
        folder: folder.clone(),
        save: None,
        wav: None,
        source: Source::default(),
    }));
    let running = Running::start(&session, Arc::new(|_| ())).expect("started");
    let long = LongSession(session);
    long.until("samples", |panel| panel.time_s > 0.0);
    long.work(WARM_UP);
    let before = Held::now();
    long.work(TIMES);
    let began = Instant::now();
    let mut after = Held::now();
    // A thread that is joined is counted for an instant more.
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
    running.end().expect("no fault");
    let saved = long.0.saved();
    assert_eq!(saved.len(), WARM_UP + TIMES);
    assert!(saved.iter().all(|file| file.outcome.is_ok()));
}

#[test]
fn a_long_session_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let child = Process::new(std::env::current_exe().expect("this test"))
        .args([
            "--exact",
            "live::leaks::child_with_a_long_session",
            "--nocapture",
        ])
        .env(CHILD, folder.path())
        // Else each thread keeps memory of its own, more or less of it by chance.
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .expect("started");
    let told = String::from_utf8_lossy(&child.stdout);
    println!("{told}{}", String::from_utf8_lossy(&child.stderr));
    assert!(child.status.success());
    assert!(told.contains("1 passed"), "no child");
    assert!(recordings(folder.path()).count() == WARM_UP + TIMES);
}

fn recordings(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let paths = entries.map(|entry| entry.expect("entry").path());
    paths.filter(|path| path.extension().is_some_and(|end| end == "rrd"))
}
