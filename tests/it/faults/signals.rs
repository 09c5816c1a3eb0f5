//! Ctrl-C, SIGTERM and a closed terminal at any moment; kill -9.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use super::{DEADLINE, ENDLESS, Running, desk, names, run, samples, size, squeakscope, until};

/// When a run is interrupted.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// So many ms after its start: while the program is loaded, sets up, opens its files or computes,
    /// by how fast the machine is.
    After(u64),
    /// When there are so many bytes of the recording.
    Written(u64),
}

const MOMENTS: [Moment; 13] = {
    use Moment::{After, Written};
    [
        After(0),
        After(1),
        After(2),
        After(4),
        After(8),
        After(16),
        After(30),
        After(60),
        After(120),
        After(900),
        Written(1),
        Written(100_000),
        Written(4_000_000),
    ]
};

fn interrupted_at_any_moment(signal: &str, number: i32) {
    for moment in MOMENTS {
        let (folder, recording) = desk();
        let outputs = [
            "--save", "run.rrd", "--npz", "run.npz", "--json", "run.json",
        ];
        let running = Running::start(run(folder.path(), ENDLESS, &outputs));
        let part = folder.path().join("run.rrd.part");
        let written = match moment {
            Moment::After(ms) => {
                std::thread::sleep(Duration::from_millis(ms));
                0
            }
            Moment::Written(bytes) => {
                until("a part", || size(&part) >= bytes);
                bytes
            }
        };
        running.signal(signal);
        let sent = Instant::now();
        let ended = running.end();
        assert!(
            sent.elapsed() < Duration::from_secs(20),
            "{:?}",
            sent.elapsed()
        );
        if ended.status.signal() == Some(number) {
            // Before the program had begun: it has left nothing.
            assert!(written == 0, "{signal} killed it, {moment:?}");
            assert!(
                names(folder.path()).is_empty(),
                "{:?}",
                names(folder.path())
            );
            continue;
        }
        if names(folder.path()).is_empty() {
            // While it set up.
            ended.said(130, &["interrupted before anything was begun"]);
            assert!(written == 0, "{moment:?}");
            continue;
        }
        ended.said(130, &["interrupted; what was reached until then is kept"]);
        assert_eq!(
            names(folder.path()),
            ["run.json", "run.npz", "run.rrd"],
            "{moment:?}"
        );
        let json = std::fs::read(folder.path().join("run.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        assert_eq!(json["interrupted"], true);
        let simulated = json["simulated_s"].as_f64().expect("a number");
        if simulated > 0.0 {
            let kept = samples(&recording).values.len() as f64;
            assert!(
                (kept / super::SAMPLE_RATE - simulated).abs() < 1e-9,
                "{kept}, {simulated} s"
            );
        } else {
            assert!(written < 100_000, "nothing was simulated, {moment:?}");
        }
        assert!(ended.stdout.contains("run.rrd"), "{}", ended.stdout);
    }
}

#[test]
fn ctrl_c_at_any_moment_keeps_what_was_reached() {
    interrupted_at_any_moment("INT", 2);
}

#[test]
fn sigterm_at_any_moment_is_as_ctrl_c() {
    interrupted_at_any_moment("TERM", 15);
}

#[test]
fn a_closed_terminal_is_as_ctrl_c() {
    let (folder, recording) = desk();
    let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
    until("a part", || {
        size(&folder.path().join("run.rrd.part")) > 100_000
    });
    running.signal("HUP");
    running.end().said(130, &["interrupted"]);
    assert!(!samples(&recording).values.is_empty());
}

/// Ten thousand nodes in steps of 10 ns: a frame takes minutes.
const SLOW_FRAMES: &str = "
load = { load_n = 150, tilt_deg = 3 }
friction = { mu_s = 0.55, mu_d = 0.25 }
contact.nodes = 10000
time = { duration_ms = 100, max_step_us = 0.01, frame_samples = 65536 }
";

/// Long before the end of a frame or of the set-up.
const SOON: Duration = Duration::from_secs(5);

#[test]
fn ctrl_c_is_heeded_within_a_frame() {
    for signal in ["INT", "TERM", "HUP"] {
        let (folder, recording) = desk();
        std::fs::write(folder.path().join("slow.toml"), SLOW_FRAMES).expect("written");
        let mut run = squeakscope();
        run.current_dir(folder.path());
        run.args(["run", "slow.toml", "--save=run.rrd", "--json=run.json"]);
        let running = Running::start(run);
        until("a part", || folder.path().join("run.rrd.part").exists());
        std::thread::sleep(Duration::from_millis(500));
        running.signal(signal);
        let sent = Instant::now();
        running.end().said(130, &["interrupted; what was reached"]);
        assert!(sent.elapsed() < SOON, "{signal}: {:?}", sent.elapsed());
        assert_eq!(names(folder.path()), ["run.json", "run.rrd", "slow.toml"]);
        let json = std::fs::read(folder.path().join("run.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        let simulated = json["simulated_s"].as_f64().expect("a number");
        let kept = samples(&recording).values.len() as f64;
        assert!((kept / super::SAMPLE_RATE - simulated).abs() < 1e-9);
    }
}

/// Here the scene is never read to its end, since nobody writes into the pipe.
#[test]
fn ctrl_c_before_the_run_begins_ends_at_once() {
    for command in [
        &["run"][..],
        &["sweep"],
        &["lyapunov"],
        &["scenes", "--effects"],
    ] {
        let (folder, _) = desk();
        let made = Command::new("mkfifo")
            .arg(folder.path().join("pipe"))
            .status();
        assert!(made.expect("mkfifo").success());
        let mut waits = squeakscope();
        waits.current_dir(folder.path()).args(command).arg("./pipe");
        let running = Running::start(waits);
        std::thread::sleep(Duration::from_millis(500));
        running.signal("TERM");
        let sent = Instant::now();
        let ended = running.end();
        ended.said(130, &["interrupted before anything was begun"]);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert!(sent.elapsed() < SOON, "{command:?}: {:?}", sent.elapsed());
        assert_eq!(names(folder.path()), ["pipe"]);
    }
}

/// A pipe as a table would wait for ever; as a scene it is what `<(...)` gives.
#[test]
fn a_pipe_is_a_scene_but_no_table() {
    let (folder, _) = desk();
    let made = Command::new("mkfifo")
        .arg(folder.path().join("pipe.csv"))
        .status();
    assert!(made.expect("mkfifo").success());
    for (load, told) in [
        ("load_csv = \"pipe.csv\"", "pipe.csv` is no regular file"),
        ("load_csv = \"/dev/null\"", "/dev/null` is no regular file"),
    ] {
        let scene = SLOW_FRAMES.replace("load_n = 150", load);
        std::fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let mut run = squeakscope();
        run.current_dir(folder.path()).args(["run", "scene.toml"]);
        Running::start(run).end().said(2, &[told]);
    }
    let mut shell = Command::new("sh");
    let script = "\"$0\" scenes periodic-2deg | \"$0\" run /dev/stdin --duration 10 --save run.rrd";
    shell
        .current_dir(folder.path())
        .args(["-c", script, env!("CARGO_BIN_EXE_squeakscope")]);
    Running::start(shell).end().said(0, &[]);
}

/// Whoever asks twice wants it to end now: what is there is a part, or whole.
#[test]
fn ctrl_c_twice_ends_at_once() {
    for pause in [0, 1, 3, 10, 30] {
        let (folder, recording) = desk();
        let part = folder.path().join("run.rrd.part");
        let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
        until("a part", || size(&part) > 5_000_000);
        running.signal("INT");
        std::thread::sleep(Duration::from_millis(pause));
        running.signal("INT");
        let sent = Instant::now();
        let ended = running.end();
        assert_eq!(ended.status.code(), Some(130), "{}", ended.stderr);
        assert!(
            sent.elapsed() < Duration::from_secs(5),
            "{:?}",
            sent.elapsed()
        );
        let there = if recording.exists() {
            &recording
        } else {
            &part
        };
        samples(there);
    }
}

/// What is in the part of a run that was killed can be analysed.
#[test]
fn a_killed_run_leaves_a_part_that_can_be_analysed() {
    let (folder, _) = desk();
    let part = folder.path().join("run.rrd.part");
    let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
    until("a part", || size(&part) > 10_000_000);
    running.signal("KILL");
    let ended = running.end();
    assert_eq!(ended.status.signal(), Some(9));
    assert_eq!(names(folder.path()), ["run.rrd.part"]);
    let mut analyse = squeakscope();
    let words = [
        "analyse",
        "run.rrd.part",
        "--column",
        "probe/displacement",
        "--json",
        "a.json",
    ];
    analyse.current_dir(folder.path()).args(words);
    Running::start(analyse).end().said(0, &[]);
    let json = std::fs::read(folder.path().join("a.json")).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let duration = json["signal"]["duration_s"].as_f64().expect("a number");
    let kept = samples(&part).values.len() as f64 / super::SAMPLE_RATE;
    assert!(
        (duration - kept).abs() < 1e-6 && kept > 0.04,
        "{duration} s, {kept} s"
    );
    // The next run leaves it alone.
    Running::start(run(folder.path(), "10", &["--save", "run.rrd"]))
        .end()
        .said(0, &[]);
    assert_eq!(names(folder.path()), ["a.json", "run.rrd", "run.rrd.part"]);
}

/// Tells the child of [`a_killed_recording_reads_to_within_a_second`] where to record.
const CHILD: &str = "SQUEAKSCOPE_TEST_RECORD_TO";

/// Not a test: the process that is killed, which says how far its simulation is.
#[test]
fn child_that_is_killed() {
    use squeakscope::pipeline::{Monitor, run};
    use squeakscope::record::{Output, RerunSink};
    use squeakscope::scene::Scene;

    let Some(path) = std::env::var_os(CHILD).map(PathBuf::from) else {
        return;
    };
    let scene = Scene::load("torus-3deg").expect("preset");
    let mut scene = scene.with_duration(1e5).expect("in range");
    // So slow that samples are sent for their age, before there are many of them.
    scene.integrator.tolerance = 1e-11;
    let output = Output {
        save: Some(path),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, scene.record).expect("opened");
    let monitor = Monitor {
        progress: &|time| {
            // Not `println`, which the harness keeps to itself.
            let mut out = std::io::stdout();
            let _ = out.write_all(format!("reached {time}\n").as_bytes());
            let _ = out.flush();
        },
        ..Monitor::default()
    };
    run(&scene, "test", &mut sink, monitor).expect("never ends");
}

/// Moments of kill -9, ms after the first frame: the recorder sends what waits every 0.8 s.
const KILLS: [u64; 4] = [1500, 1700, 1900, 2100];

/// The last sample of a killed recording was computed at most a second before.
#[test]
fn a_killed_recording_reads_to_within_a_second() {
    for moment in KILLS {
        let lost = lost_by_a_kill(Duration::from_millis(moment));
        println!("{moment} ms: lost {} ms of computing", lost.as_millis());
        assert!(lost < Duration::from_secs(1), "{lost:?}");
    }
}

/// Wall time of the computing that is missing in a recording that was killed.
fn lost_by_a_kill(moment: Duration) -> Duration {
    let (_folder, recording) = desk();
    let mut child = Command::new(std::env::current_exe().expect("this test"));
    child
        .args([
            "--exact",
            "faults::signals::child_that_is_killed",
            "--nocapture",
        ])
        .env(CHILD, &recording)
        .stdout(Stdio::piped());
    let mut child = Running::start(child);
    let (tell, told) = mpsc::channel();
    let lines = BufReader::new(child.child.stdout.take().expect("piped"));
    let reader = std::thread::spawn(move || {
        for line in lines.lines().map_while(Result::ok) {
            let time = line.strip_prefix("reached ");
            if let Some(time) = time.and_then(|time| time.parse::<f64>().ok()) {
                tell.send((Instant::now(), time)).expect("listening");
            }
        }
    });
    let mut reached = vec![told.recv_timeout(DEADLINE).expect("a frame")];
    std::thread::sleep(moment);
    child.signal("KILL");
    let killed = Instant::now();
    child.child.wait().expect("dead");
    reader.join().expect("all lines");
    reached.extend(told.iter());
    let kept = samples(&recording.with_extension("rrd.part"));
    let last = *kept.times.last().expect("samples");
    let after = reached.iter().find(|(_, time)| *time > last);
    killed.saturating_duration_since(after.expect("something is lost").0)
}
