//! Ctrl-C, SIGTERM, a closed terminal and kill -9 at any moment.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use super::{DEADLINE, ENDLESS, Running, desk, names, run, samples, size, squeakscope, until};

/// Moment of the interrupt.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// Time after the start, ms. Depending on the machine, the program is being loaded, sets up, opens its
    /// files or simulates.
    After(u64),
    /// Size of the recording, bytes.
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
            // The program had not started yet and has left nothing.
            assert!(written == 0, "killed by {signal}, {moment:?}");
            assert!(
                names(folder.path()).is_empty(),
                "{:?}",
                names(folder.path())
            );
            continue;
        }
        if names(folder.path()).is_empty() {
            // During the set-up.
            ended.said(130, &["interrupted before the computation started"]);
            assert!(written == 0, "{moment:?}");
            continue;
        }
        ended.said(130, &["interrupted; the results so far are saved"]);
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
fn ctrl_c_at_any_moment_keeps_the_samples() {
    interrupted_at_any_moment("INT", 2);
}

#[test]
fn sigterm_at_any_moment_has_the_effect_of_ctrl_c() {
    interrupted_at_any_moment("TERM", 15);
}

#[test]
fn a_closed_terminal_has_the_effect_of_ctrl_c() {
    let (folder, recording) = desk();
    let running = Running::start(run(folder.path(), ENDLESS, &["--save", "run.rrd"]));
    until("a part", || {
        size(&folder.path().join("run.rrd.part")) > 100_000
    });
    running.signal("HUP");
    running.end().said(130, &["interrupted"]);
    assert!(!samples(&recording).values.is_empty());
}

/// Ten thousand nodes with steps of 10 ns: a frame takes minutes.
const SLOW_FRAMES: &str = "
load = { load_n = 150, tilt_deg = 3 }
friction = { mu_s = 0.55, mu_d = 0.25 }
contact.nodes = 10000
time = { duration_ms = 100, max_step_us = 0.01, frame_samples = 65536 }
";

/// Much less than the duration of a frame or of the set-up.
const SOON: Duration = Duration::from_secs(5);

#[test]
fn ctrl_c_stops_the_run_within_a_frame() {
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
        running
            .end()
            .said(130, &["interrupted; the results so far are saved"]);
        assert!(sent.elapsed() < SOON, "{signal}: {:?}", sent.elapsed());
        assert_eq!(names(folder.path()), ["run.json", "run.rrd", "slow.toml"]);
        let json = std::fs::read(folder.path().join("run.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        let simulated = json["simulated_s"].as_f64().expect("a number");
        let kept = samples(&recording).values.len() as f64;
        assert!((kept / super::SAMPLE_RATE - simulated).abs() < 1e-9);
    }
}

/// The scene is read from a pipe without a writer.
#[test]
fn ctrl_c_before_the_run_starts_ends_at_once() {
    for command in [&["run"][..], &["sweep"], &["lyapunov"]] {
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
        ended.said(130, &["interrupted before the computation started"]);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert!(sent.elapsed() < SOON, "{command:?}: {:?}", sent.elapsed());
        assert_eq!(names(folder.path()), ["pipe"]);
    }
}

/// A pipe as a table would block forever. As a scene it is valid: `<(...)` creates one.
#[test]
fn a_pipe_is_valid_as_a_scene_but_not_as_a_table() {
    let (folder, _) = desk();
    let made = Command::new("mkfifo")
        .arg(folder.path().join("pipe.csv"))
        .status();
    assert!(made.expect("mkfifo").success());
    for (load, message) in [
        (
            "load_csv = \"pipe.csv\"",
            "pipe.csv` cannot be read (this is a pipe or a device",
        ),
        (
            "load_csv = \"/dev/null\"",
            "/dev/null` cannot be read (this is a pipe or a device",
        ),
    ] {
        let scene = SLOW_FRAMES.replace("load_n = 150", load);
        std::fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let mut run = squeakscope();
        run.current_dir(folder.path()).args(["run", "scene.toml"]);
        Running::start(run).end().said(2, &[message]);
    }
    let mut shell = Command::new("sh");
    let script = "\"$0\" scenes periodic-2deg | \"$0\" run /dev/stdin --duration 10 --save run.rrd";
    shell
        .current_dir(folder.path())
        .args(["-c", script, env!("CARGO_BIN_EXE_squeakscope")]);
    Running::start(shell).end().said(0, &[]);
}

/// A second Ctrl-C ends the program immediately; the recording is partial or complete.
#[test]
fn a_second_ctrl_c_ends_the_program_immediately() {
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

/// The partial recording of a killed run can be analysed.
#[test]
fn a_killed_run_leaves_a_readable_partial_recording() {
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
    // The next run does not touch it.
    Running::start(run(folder.path(), "10", &["--save", "run.rrd"]))
        .end()
        .said(0, &[]);
    assert_eq!(names(folder.path()), ["a.json", "run.rrd", "run.rrd.part"]);
}

/// Environment variable with the recording path for the child process of
/// [`a_killed_recording_misses_less_than_a_second`].
const CHILD: &str = "SQUEAKSCOPE_TEST_RECORD_TO";

/// Not a test: the process that is killed. It prints its simulated time.
#[test]
fn child_that_is_killed() {
    use squeakscope::pipeline::{Monitor, run};
    use squeakscope::record::{Output, RerunSink};
    use squeakscope::scene::Scene;

    let Some(path) = std::env::var_os(CHILD).map(PathBuf::from) else {
        return;
    };
    let scene = Scene::load("doubled-torus-3deg").expect("preset");
    let mut scene = scene.with_duration(1e5).expect("in range");
    // So slow that samples are sent because of their age, not their number.
    scene.integrator.tolerance = 1e-11;
    let output = Output {
        save: Some(path),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, scene.record).expect("opened");
    let monitor = Monitor {
        progress: &|time| {
            // Not `println`, whose output the test harness captures.
            let mut out = std::io::stdout();
            let _ = out.write_all(format!("reached {time}\n").as_bytes());
            let _ = out.flush();
        },
        ..Monitor::default()
    };
    run(&scene, "test", &mut sink, monitor).expect("never ends");
}

/// Times of kill -9, ms after the first frame; the recorder flushes every 0.8 s.
const KILLS: [u64; 2] = [1500, 2100];

/// The last sample of a killed recording was computed at most 1 s earlier.
#[test]
fn a_killed_recording_misses_less_than_a_second() {
    for moment in KILLS {
        let lost = lost_by_a_kill(Duration::from_millis(moment));
        println!("{moment} ms: lost {} ms of computing", lost.as_millis());
        assert!(lost < Duration::from_secs(1), "{lost:?}");
    }
}

/// Wall time of the computation that is missing in a killed recording.
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
    let (sender, times) = mpsc::channel();
    let lines = BufReader::new(child.child.stdout.take().expect("piped"));
    let reader = std::thread::spawn(move || {
        for line in lines.lines().map_while(Result::ok) {
            let time = line.strip_prefix("reached ");
            if let Some(time) = time.and_then(|time| time.parse::<f64>().ok()) {
                sender.send((Instant::now(), time)).expect("listening");
            }
        }
    });
    let mut reached = vec![times.recv_timeout(DEADLINE).expect("a frame")];
    std::thread::sleep(moment);
    child.signal("KILL");
    let killed = Instant::now();
    child.child.wait().expect("ended");
    reader.join().expect("all lines");
    reached.extend(times.iter());
    let kept = samples(&recording.with_extension("rrd.part"));
    let last = *kept.times.last().expect("samples");
    let after = reached.iter().find(|(_, time)| *time > last);
    killed.saturating_duration_since(after.expect("something is lost").0)
}
