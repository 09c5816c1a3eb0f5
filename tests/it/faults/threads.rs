//! Limited number of threads: each command ends in an error or continues with fewer threads, and none panics.
//!
//! Root has no limit. The program therefore runs as an otherwise unused user, which only root can do.

use std::f64::consts::TAU;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use super::Running;

/// Maximum number of tested threads, including the main thread; beyond it everything works.
const MOST: u32 = 14;

/// A copy of the program in a world-readable folder, for another user; `None` if no program can be started as
/// another user.
fn stranger() -> Option<(tempfile::TempDir, u32)> {
    let user = 40_000 + std::process::id() % 20_000;
    let folder = tempfile::tempdir().expect("temporary folder");
    let everybody = std::fs::Permissions::from_mode(0o777);
    std::fs::set_permissions(folder.path(), everybody).expect("set");
    let program = env!("CARGO_BIN_EXE_squeakscope");
    std::fs::copy(program, folder.path().join("squeakscope")).expect("copied");
    let tried = Command::new("setpriv")
        .args(as_user(user))
        .args(["./squeakscope", "--version"])
        .current_dir(folder.path())
        .output();
    if !tried.is_ok_and(|tried| tried.status.success()) {
        eprintln!("not tested: no program can be started as another user here");
        return None;
    }
    Some((folder, user))
}

fn as_user(user: u32) -> [String; 3] {
    [
        format!("--reuid={user}"),
        format!("--regid={user}"),
        "--clear-groups".to_owned(),
    ]
}

/// Runs the program with a thread limit for its user.
fn limited(folder: &Path, user: u32, threads: u32, words: &[&str]) -> Running {
    let mut command = Command::new("setpriv");
    command
        .current_dir(folder)
        .args(as_user(user))
        .args(["prlimit", &format!("--nproc={threads}"), "./squeakscope"])
        .env("RAYON_NUM_THREADS", "2")
        .args(words);
    Running::start(command)
}

/// A tone of 1 kHz.
fn tone(path: &Path) {
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 48_000,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::create(path, spec).expect("created");
    for k in 0..2400 {
        let phase = TAU * 1000.0 * f64::from(k) / 48_000.0;
        writer
            .write_sample((10_000.0 * phase.sin()) as i16)
            .expect("written");
    }
    writer.finalize().expect("written");
}

/// Runs a command with an increasing thread limit until it succeeds.
fn never_panics(words: &[&str]) {
    let Some((folder, user)) = stranger() else {
        return;
    };
    tone(&folder.path().join("tone.wav"));
    let mut failed = 0;
    for threads in 1..=MOST {
        // A new file each time: a study does not overwrite the previous table.
        let number = threads.to_string();
        let words: Vec<String> = words
            .iter()
            .map(|word| word.replace('#', &number))
            .collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let ended = limited(folder.path(), user, threads, &words).end();
        println!(
            "{threads}: {:?} {}",
            ended.status.code(),
            ended.stderr.trim_end()
        );
        assert!(
            !ended.stderr.contains("panicked"),
            "{threads}: {}",
            ended.stderr
        );
        match ended.status.code() {
            Some(0) => {
                assert!(failed > 0, "the command needs no thread");
                return;
            }
            Some(1) => {
                let words = ["thread", "ulimit -u", "process limit"];
                let is_named = words.iter().any(|word| ended.stderr.contains(word));
                assert!(is_named, "{threads}: {}", ended.stderr);
                failed += 1;
            }
            other => panic!("{threads}: {other:?}, {}", ended.stderr),
        }
    }
    panic!("{MOST} threads are not sufficient");
}

#[test]
fn a_run_without_threads_ends_in_an_error() {
    let words = "run doubled-torus-3deg --duration 5 --force --save run.rrd";
    never_panics(&words.split(' ').collect::<Vec<_>>());
}

#[test]
fn a_sweep_without_threads_ends_in_an_error() {
    let words = "sweep doubled-torus-3deg --tilt 1:2:1 --threads 3 --min-transient 5 --max-transient 5 --measure 5 --out sweep-#.arrow";
    never_panics(&words.split(' ').collect::<Vec<_>>());
}

#[test]
fn an_analysis_without_threads_ends_in_an_error() {
    never_panics(&["analyse", "tone.wav", "--force", "--save", "tone.rrd"]);
}
