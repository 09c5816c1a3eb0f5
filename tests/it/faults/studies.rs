//! Faults during studies: the tables of some grow during the study, all other files are written at the end.

use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use super::{Running, desk, names, on_a_small_disk, size, squeakscope, until};

fn study(folder: &Path, words: &[&str]) -> Command {
    let mut command = squeakscope();
    command.current_dir(folder).args(words);
    command
}

/// A sweep of five points: a table of 240 kB, a recording of 820 kB.
const SWEEP: [&str; 13] = [
    "sweep",
    "doubled-torus-3deg",
    "--tilt",
    "1:3:0.5",
    "--start",
    "fresh",
    "--max-transient",
    "50",
    "--measure",
    "20",
    "--out",
    "s.arrow",
    "--save=s.rrd",
];

/// `--resume` computes the missing points, and the result is identical to that of an uninterrupted study.
#[track_caller]
fn completes_on_resume(folder: &Path) {
    let resume = [&SWEEP[..], &["--resume"]].concat();
    assert!(table(folder, &resume) == *WHOLE);
}

/// The table of an uninterrupted study.
static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| table(desk().0.path(), &SWEEP));

fn table(folder: &Path, words: &[&str]) -> Vec<u8> {
    Running::start(study(folder, words)).end().said(0, &[]);
    std::fs::read(folder.join("s.arrow")).expect("written")
}

#[test]
fn a_disk_full_of_a_recording_keeps_the_table() {
    let (folder, _) = desk();
    let ended = on_a_small_disk(500_000, &study(folder.path(), &SWEEP)).end();
    ended.said(
        1,
        &["cannot write the recording", "File too large", "s.rrd.part"],
    );
    assert_eq!(names(folder.path()), ["s.arrow", "s.rrd.part"]);
    completes_on_resume(folder.path());
}

#[test]
fn a_disk_full_of_a_table_keeps_its_points() {
    let (folder, _) = desk();
    let ended = on_a_small_disk(150_000, &study(folder.path(), &SWEEP)).end();
    ended.said(1, &["s.arrows", "continue with --resume", "File too large"]);
    assert_eq!(names(folder.path()), ["s.arrows"]);
    completes_on_resume(folder.path());
}

#[test]
fn a_killed_sweep_keeps_its_points() {
    let (folder, _) = desk();
    let running = Running::start(study(folder.path(), &SWEEP));
    until("a point", || size(&folder.path().join("s.arrows")) > 50_000);
    running.signal("KILL");
    running.end();
    completes_on_resume(folder.path());
}

/// The results of a study are printed even if they cannot be written.
#[test]
fn a_disk_full_at_the_end_of_a_study_prints_the_results() {
    let command = "lyapunov impact-oscillator --settle 10 --average-time 0.1 --json out.json";
    for more in ["", " --csv out.csv"] {
        let (folder, _) = desk();
        let words = format!("{command}{more}");
        let program = study(folder.path(), &words.split(' ').collect::<Vec<_>>());
        let ended = on_a_small_disk(100, &program).end();
        ended.said(1, &["File too large"]);
        let stdout = &ended.stdout;
        assert!(stdout.contains("averaged"), "{words}: {stdout}");
    }
}

/// Points are written to a deleted file, and hours of computing would be lost at the end.
#[test]
fn a_removed_folder_ends_a_study_at_once() {
    let words = [
        "sweep",
        "doubled-torus-3deg",
        "--tilt",
        "1:8:0.01",
        "--max-transient",
        "50",
        "--measure",
        "20",
        "--out",
        "results/s.arrow",
    ];
    let (folder, _) = desk();
    let results = folder.path().join("results");
    std::fs::create_dir(&results).expect("created");
    let running = Running::start(study(folder.path(), &words));
    let table = results.join("s.arrows");
    until("a table", || size(&table) > 0);
    // The table exists under its final name and receives points.
    let begun = size(&table);
    until("a point", || size(&table) > begun);
    std::fs::remove_dir_all(&results).expect("removed");
    let ended = running.end();
    ended.said(1, &["s.arrows` was removed or moved", "No such file"]);
}

/// The long-running commands with all their outputs.
const LONG: [&[&str]; 5] = [
    &[
        "lyapunov",
        "chaos-5deg",
        "--average-time",
        "1000",
        "--csv",
        "l.csv",
        "--figures",
        "l.png",
    ],
    &[
        "sweep",
        "doubled-torus-3deg",
        "--tilt",
        "1:8:0.01",
        "--max-transient",
        "50",
        "--measure",
        "20",
        "--save",
        "s.rrd",
        "--figures",
        "figures",
    ],
    &[
        "basins",
        "doubled-torus-3deg",
        "--kicks",
        "1000",
        "--max-transient",
        "50",
        "--measure",
        "20",
        "--save",
        "b.rrd",
        "--figures",
        "figures",
    ],
    &["cost", "chaos-5deg", "--figures", "figures"],
    &["paper"],
];

/// All files below a folder.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).expect("folder");
    let paths = entries.map(|entry| entry.expect("entry").path());
    paths
        .flat_map(|path| match path.is_dir() {
            true => files(&path),
            false => vec![path],
        })
        .collect()
}

/// Every long-running command can be interrupted, reports it, and leaves no incomplete file.
#[test]
fn every_long_command_can_be_interrupted() {
    for (signal, moment) in [("INT", 300), ("TERM", 1500)] {
        for words in LONG {
            let (folder, _) = desk();
            let words = [words, &["--json", "out.json"]].concat();
            let running = Running::start(study(folder.path(), &words));
            std::thread::sleep(Duration::from_millis(moment));
            running.signal_alone(signal);
            let sent = Instant::now();
            let ended = running.end();
            println!("{}: {:?} after {signal}", words[0], sent.elapsed());
            ended.said(130, &["interrupted"]);
            for file in files(folder.path()) {
                let name = file.display().to_string();
                assert!(!name.contains(".part") && size(&file) > 0, "{name}");
                if name.ends_with(".json") {
                    let text = std::fs::read(&file).expect("there");
                    let _: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
                }
            }
        }
    }
}
