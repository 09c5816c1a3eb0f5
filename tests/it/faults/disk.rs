//! Disks that fill up and folders that vanish.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{
    ENDLESS, Running, desk, names, on_a_small_disk, run, samples, size, squeakscope, until,
};

#[test]
fn a_full_disk_ends_the_run_and_keeps_what_is_there() {
    let (folder, recording) = desk();
    std::fs::write(&recording, "an older one").expect("written");
    let program = run(folder.path(), ENDLESS, &["--save", "run.rrd"]);
    let ended = on_a_small_disk(3_000_000, &program).end();
    ended.said(
        1,
        &[
            "cannot go on writing",
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

/// Where not even a beginning fits, nothing is begun.
#[test]
fn a_disk_that_is_full_from_the_start_has_no_part() {
    let (folder, _) = desk();
    let program = run(folder.path(), ENDLESS, &["--save", "run.rrd"]);
    let ended = on_a_small_disk(8, &program).end();
    ended.said(1, &["cannot write a recording", "run.rrd", "has space"]);
    assert!(
        names(folder.path()).is_empty(),
        "{:?}",
        names(folder.path())
    );
}

/// Words that nobody takes change neither what is done nor the exit code.
#[test]
fn a_full_disk_for_words_is_told_by_the_exit_code() {
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
    let run = ["run", "torus-3deg", "--duration", "5", "--save", "run.rrd"];
    // The warning that there are no exponents is not heard.
    assert_eq!(status(&run, Stdio::null(), full().into()), Some(0));
    assert!(!samples(&recording).values.is_empty());
    assert_eq!(status(&run, full().into(), Stdio::null()), Some(1));
    // Whoever has seen enough, as `| head` has, is no fault.
    let (_, unread) = std::io::pipe().expect("a pipe");
    assert_eq!(status(&run, unread.into(), Stdio::null()), Some(0));
    let absent = ["run", "no-such-scene"];
    assert_eq!(status(&absent, Stdio::null(), full().into()), Some(2));
}

/// The arrays wait in files without a name, so that nothing at all must be left.
#[test]
fn a_full_disk_is_told_of_samples_too() {
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

/// Whichever of two files is full first, what is left of the recording is told. That depends on how long
/// each waits for more of its kind.
#[test]
fn a_disk_that_is_full_of_samples_and_recording_leaves_the_recording_to_be_found() {
    let (folder, _) = desk();
    let outputs = ["--npz", "run.npz", "--save", "run.rrd"];
    let program = run(folder.path(), ENDLESS, &outputs);
    let ended = on_a_small_disk(3_000_000, &program).end();
    ended.said(1, &["File too large", "can be opened", "run.rrd.part"]);
    assert_eq!(names(folder.path()), ["run.rrd.part"]);
    let there = samples(&folder.path().join("run.rrd.part"));
    assert!(!there.values.is_empty());
}

/// The same where it is not the recording that failed.
#[test]
fn a_disk_that_is_full_of_samples_leaves_the_recording_on_another_to_be_found() {
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
            "can be opened",
            "run.rrd.part",
        ],
    );
    assert_eq!(names(folder.path()), ["disk", "run.rrd.part"]);
    let there = samples(&folder.path().join("run.rrd.part"));
    assert!(!there.values.is_empty());
}

/// The index goes to the end of the file, when all else is there: a disk that is full then, too, keeps
/// all samples.
#[test]
fn a_disk_that_is_full_at_the_end_keeps_all_samples() {
    let (folder, recording) = desk();
    let short = || run(folder.path(), "40", &["--save", "run.rrd"]);
    Running::start(short()).end().said(0, &[]);
    let (bytes, expected) = (size(&recording), samples(&recording).values.len());
    std::fs::remove_file(&recording).expect("removed");
    // The index has some 500 kilobytes, and two runs are alike to a few.
    let ended = on_a_small_disk(bytes - 250_000, &short()).end();
    ended.said(1, &["File too large", "run.rrd.part"]);
    assert!(!recording.exists());
    let part = folder.path().join("run.rrd.part");
    assert_eq!(samples(&part).values.len(), expected);
}

/// A program with a tmpfs at `disk` in its folder, in a namespace of its own so that no mount is left
/// behind, and what a shell does there after it. That takes root, or a system on which every user may
/// make namespaces; `None` elsewhere.
fn on_a_small_tmpfs(size: &str, program: &Command, after: &str) -> Option<Running> {
    let folder = program.get_current_dir().expect("a folder");
    let namespace = |script: &str| {
        let mut unshare = Command::new("unshare");
        unshare.args(["--map-root-user", "--mount", "sh", "-c", script]);
        unshare.current_dir(folder);
        unshare
    };
    std::fs::create_dir(folder.join("disk")).expect("made");
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
fn a_full_tmpfs_ends_the_run_and_keeps_what_is_there() {
    let (folder, _) = desk();
    let kept = folder.path().join("kept");
    let program = run(folder.path(), ENDLESS, &["--save", "disk/run.rrd"]);
    // What is on the tmpfs goes with its namespace.
    let Some(running) = on_a_small_tmpfs("3m", &program, "cp -R disk kept") else {
        return;
    };
    let ended = running.end();
    ended.said(
        1,
        &[
            "cannot go on writing",
            "No space left on device",
            "run.rrd.part",
        ],
    );
    assert_eq!(names(&kept), ["run.rrd.part"]);
    let there = samples(&kept.join("run.rrd.part"));
    assert!(there.values.len() > 1000, "{}", there.values.len());
}

/// A file without a name takes everything, and is gone when the program ends: the run must not go on
/// for hours to say so then.
#[test]
fn a_folder_that_vanishes_ends_the_run_at_once() {
    let gone = |take_away: &dyn Fn(&Path)| {
        let (folder, _) = desk();
        let results = folder.path().join("results");
        std::fs::create_dir(&results).expect("made");
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
                "a folder that stays",
            ],
        );
        assert!(since.elapsed().as_secs() < 10, "{:?}", since.elapsed());
    };
    gone(&|results| std::fs::remove_dir_all(results).expect("removed"));
    gone(&|results| std::fs::rename(results, results.with_extension("old")).expect("moved"));
}

/// A folder stands where the recording should: what is whole is kept beside it.
#[test]
fn a_place_that_is_taken_meanwhile_does_not_cost_the_recording() {
    let (folder, recording) = desk();
    let part = folder.path().join("run.rrd.part");
    let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
    until("a part", || size(&part) > 100_000);
    std::fs::create_dir(&recording).expect("made");
    running.signal("INT");
    let ended = running.end();
    ended.said(
        1,
        &[
            "is whole, but cannot be moved",
            "move it by hand",
            "Is a directory",
        ],
    );
    assert!(!samples(&part).values.is_empty());
}
