//! Full disks and removed folders.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{
    ENDLESS, Running, desk, names, on_a_small_disk, run, samples, size, squeakscope, until,
};

#[test]
fn a_full_disk_ends_the_run_and_keeps_the_partial_recording() {
    let (folder, recording) = desk();
    std::fs::write(&recording, "an older one").expect("written");
    let program = run(folder.path(), ENDLESS, &["--force", "--save", "run.rrd"]);
    let ended = on_a_small_disk(3_000_000, &program).end();
    ended.said(
        1,
        &[
            "cannot write the recording",
            "File too large",
            "free some space",
            "run.rrd.part",
        ],
    );
    assert_eq!(std::fs::read(&recording).expect("there"), b"an older one");
    let part = folder.path().join("run.rrd.part");
    assert!(
        (2_000_000..=3_000_000).contains(&size(&part)),
        "{}",
        size(&part)
    );
    let kept = samples(&part);
    assert!(kept.values.len() > 1000, "{}", kept.values.len());
}

/// If not even the header fits, no file is created.
#[test]
fn a_disk_full_from_the_start_leaves_no_partial_file() {
    let (folder, _) = desk();
    let program = run(folder.path(), ENDLESS, &["--save", "run.rrd"]);
    let ended = on_a_small_disk(8, &program).end();
    ended.said(1, &["cannot write a recording", "run.rrd", "free space"]);
    assert!(
        names(folder.path()).is_empty(),
        "{:?}",
        names(folder.path())
    );
}

/// Errors on the standard output change neither the result nor the exit code.
#[test]
fn a_full_disk_for_the_output_sets_the_exit_code() {
    let full = || {
        let full = std::fs::File::options().write(true).open("/dev/full");
        full.expect("a device that is full")
    };
    let (folder, recording) = desk();
    let status = |words: &[&str], stdout: Stdio, stderr: Stdio| {
        let mut command = squeakscope();
        command.current_dir(folder.path()).args(words);
        let status = command.stdout(stdout).stderr(stderr).status();
        status.expect("started").code()
    };
    let run = "run doubled-torus-3deg --duration 5 --force --save run.rrd";
    let run: Vec<&str> = run.split(' ').collect();
    // The warning about missing exponents is lost.
    assert_eq!(status(&run, Stdio::null(), full().into()), Some(0));
    assert!(!samples(&recording).values.is_empty());
    assert_eq!(status(&run, full().into(), Stdio::null()), Some(1));
    // A closed pipe, as in `| head`, is not an error.
    let (_, unread) = std::io::pipe().expect("a pipe");
    assert_eq!(status(&run, unread.into(), Stdio::null()), Some(0));
    let absent = ["run", "no-such-scene"];
    assert_eq!(status(&absent, Stdio::null(), full().into()), Some(2));
}

/// The arrays wait in unnamed files: nothing may remain.
#[test]
fn a_full_disk_is_reported_for_samples_too() {
    let (folder, _) = desk();
    let program = run(folder.path(), ENDLESS, &["--npz", "run.npz"]);
    let ended = on_a_small_disk(1_000_000, &program).end();
    ended.said(
        1,
        &["cannot write", "run.npz", "has space", "File too large"],
    );
    assert!(
        names(folder.path()).is_empty(),
        "{:?}",
        names(folder.path())
    );
}

/// If two files fill the disk, the rest of the recording is reported, whichever file fails first. The order
/// depends on the buffering of each.
#[test]
fn a_full_disk_with_samples_and_recording_keeps_the_recording() {
    let (folder, _) = desk();
    let outputs = ["--npz", "run.npz", "--save", "run.rrd"];
    let program = run(folder.path(), ENDLESS, &outputs);
    let ended = on_a_small_disk(3_000_000, &program).end();
    ended.said(1, &["File too large", "can be opened", "run.rrd.part"]);
    assert_eq!(names(folder.path()), ["run.rrd.part"]);
    let there = samples(&folder.path().join("run.rrd.part"));
    assert!(!there.values.is_empty());
}

/// The same if the recording has not failed.
#[test]
fn a_disk_full_of_samples_keeps_the_recording_on_another_disk() {
    let (folder, _) = desk();
    let outputs = ["--npz", "disk/run.npz", "--save", "run.rrd"];
    let program = run(folder.path(), ENDLESS, &outputs);
    let Some(running) = on_a_small_tmpfs("1m", &program, "true") else {
        return;
    };
    running.end().said(
        1,
        &[
            "disk/run.npz",
            "No space left on device",
            "the recording up to the failure can be opened",
            "run.rrd.part",
        ],
    );
    assert_eq!(names(folder.path()), ["disk", "run.rrd.part"]);
    let there = samples(&folder.path().join("run.rrd.part"));
    assert!(!there.values.is_empty());
}

/// The index is written to the end of the file after all data. If the disk is full only then, all samples are
/// kept.
#[test]
fn a_disk_full_at_the_end_keeps_all_samples() {
    let (folder, recording) = desk();
    let short = || run(folder.path(), "40", &["--save", "run.rrd"]);
    Running::start(short()).end().said(0, &[]);
    let (bytes, expected) = (size(&recording), samples(&recording).values.len());
    std::fs::remove_file(&recording).expect("removed");
    // The index has about 500 kB, and two runs differ by a few kB only.
    let ended = on_a_small_disk(bytes - 250_000, &short()).end();
    ended.said(1, &["File too large", "run.rrd.part"]);
    assert!(!recording.exists());
    let part = folder.path().join("run.rrd.part");
    assert_eq!(samples(&part).values.len(), expected);
}

/// Runs a program with a tmpfs at `disk` in its folder, in its own mount namespace, which leaves no mount,
/// and a shell command after it. This needs root, or a system on which every user may create namespaces;
/// `None` elsewhere.
fn on_a_small_tmpfs(size: &str, program: &Command, after: &str) -> Option<Running> {
    let folder = program.get_current_dir().expect("a folder");
    let namespace = |script: &str| {
        let mut unshare = Command::new("unshare");
        unshare.args(["--map-root-user", "--mount", "sh", "-c", script]);
        unshare.current_dir(folder);
        unshare
    };
    std::fs::create_dir(folder.join("disk")).expect("created");
    let mount = format!("mount -t tmpfs -o size={size} none disk");
    let allowed = namespace(&mount).output();
    if !allowed.is_ok_and(|output| output.status.success()) {
        eprintln!("not tested: no tmpfs can be mounted here, neither by root nor in a namespace");
        return None;
    }
    let mut script = namespace(&format!(
        "{mount} || exit 99; \"$@\"; code=$?; {after}; exit $code"
    ));
    let words = script.arg("sh").arg(program.get_program());
    words.args(program.get_args());
    Some(Running::start(script))
}

#[test]
fn a_full_tmpfs_ends_the_run_and_keeps_the_partial_recording() {
    let (folder, _) = desk();
    let kept = folder.path().join("kept");
    let program = run(folder.path(), ENDLESS, &["--save", "disk/run.rrd"]);
    // The content of the tmpfs is lost with its namespace.
    let Some(running) = on_a_small_tmpfs("3m", &program, "cp -R disk kept") else {
        return;
    };
    let ended = running.end();
    ended.said(
        1,
        &[
            "cannot write the recording",
            "No space left on device",
            "run.rrd.part",
        ],
    );
    assert_eq!(names(&kept), ["run.rrd.part"]);
    let there = samples(&kept.join("run.rrd.part"));
    assert!(there.values.len() > 1000, "{}", there.values.len());
}

/// A deleted but open file accepts all data and is lost at the end. The run must report this at once, not
/// after hours.
#[test]
fn a_removed_folder_ends_the_run_at_once() {
    let removed = |take_away: &dyn Fn(&Path)| {
        let (folder, _) = desk();
        let results = folder.path().join("results");
        std::fs::create_dir(&results).expect("created");
        let running = Running::start(run(folder.path(), ENDLESS, &["--save", "results/run.rrd"]));
        until("a part", || size(&results.join("run.rrd.part")) > 100_000);
        take_away(&results);
        let since = std::time::Instant::now();
        let ended = running.end();
        ended.said(
            1,
            &[
                "is lost",
                "run.rrd.part was removed or moved",
                "a folder that is not modified",
            ],
        );
        assert!(since.elapsed().as_secs() < 10, "{:?}", since.elapsed());
    };
    removed(&|results| std::fs::remove_dir_all(results).expect("removed"));
    removed(&|results| std::fs::rename(results, results.with_extension("old")).expect("moved"));
}

/// If a folder of the same name exists, the complete recording is kept next to it.
#[test]
fn an_occupied_path_does_not_lose_the_recording() {
    let (folder, recording) = desk();
    let part = folder.path().join("run.rrd.part");
    let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
    until("a part", || size(&part) > 100_000);
    std::fs::create_dir(&recording).expect("created");
    running.signal("INT");
    let ended = running.end();
    ended.said(
        1,
        &[
            "is complete, but cannot be moved",
            "move it manually",
            "Is a directory",
        ],
    );
    assert!(!samples(&part).values.is_empty());
}
