//! Viewers that are absent, do not read, disconnect, and reconnect.

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use squeakscope::record::{paths, read_series};

use super::{ENDLESS, Running, desk, names, run, samples, size, until};

/// First bytes of a connection to a viewer.
const GREETING: &[u8] = b"PRI * HTTP/2.0";

fn listener() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let url = url(listener.local_addr().expect("bound").port());
    (listener, url)
}

fn url(port: u16) -> String {
    format!("rerun+http://127.0.0.1:{port}/proxy")
}

/// A viewer that disconnects after the given number of bytes and closes its port.
fn hangs_up_after(listener: TcpListener, bytes: usize) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.expect("a connection");
            let mut left = bytes;
            let mut buffer = [0; 4096];
            while left > 0 {
                match stream.read(&mut buffer) {
                    // A client that only checks whether there is a viewer.
                    Ok(0) | Err(_) => break,
                    Ok(count) => left = left.saturating_sub(count),
                }
            }
            if left == 0 {
                return;
            }
        }
    })
}

#[test]
fn an_absent_viewer_is_reported_before_any_work() {
    let (listener, url) = listener();
    drop(listener);
    for more in [
        &["--connect", &url][..],
        &["--connect", &url, "--save", "run.rrd"],
    ] {
        let (folder, _) = desk();
        let ended = Running::start(run(folder.path(), ENDLESS, more)).end();
        ended.said(1, &["no viewer at", &url, "start one with `rerun`"]);
        assert!(ended.took < Duration::from_secs(10), "{:?}", ended.took);
        assert!(
            names(folder.path()).is_empty(),
            "{:?}",
            names(folder.path())
        );
    }
}

#[test]
fn a_viewer_that_is_not_installed_is_reported_before_any_work() {
    let (folder, _) = desk();
    let mut command = run(folder.path(), ENDLESS, &["--spawn", "--save", "run.rrd"]);
    command.env("PATH", folder.path());
    let ended = Running::start(command).end();
    ended.said(
        1,
        &["cannot start the Rerun viewer", "pip install rerun-sdk"],
    );
    assert!(
        names(folder.path()).is_empty(),
        "{:?}",
        names(folder.path())
    );
}

/// The port accepts connections, but nothing reads: a stopped viewer, or another program. It ends a run that is not saved,
/// does not delay one that is, nor its end by Ctrl-C.
#[test]
fn a_viewer_that_never_reads() {
    let (_listener, url) = listener();
    // All at the same time: each waits for the viewer.
    let start = |folder: &Path, duration_ms, more: &[&str]| {
        let words = [&["--connect", &url][..], more].concat();
        Running::start(run(folder, duration_ms, &words))
    };
    let saves = ["--save", "run.rrd"];
    let (unsaved, (saved, recording), (stopped, part)) = (desk().0, desk(), desk());
    let [not_saved, saved, interrupted] = [
        start(unsaved.path(), ENDLESS, &[]),
        start(saved.path(), "300", &saves),
        start(stopped.path(), ENDLESS, &saves),
    ];
    until("a part", || {
        size(&part.with_extension("rrd.part")) > 500_000
    });
    interrupted.signal("INT");
    let ended = not_saved.end();
    ended.said(
        1,
        &[&url, "does not respond", "no file is saved", "--save FILE"],
    );
    assert!(ended.took < Duration::from_secs(30), "{:?}", ended.took);
    interrupted
        .end()
        .said(130, &["interrupted", "the file is complete"]);
    assert!(!samples(&part).values.is_empty());
    let ended = saved.end();
    ended.said(0, &["warning: the viewer at", &url, "the file is complete"]);
    assert_eq!(samples(&recording).values.len(), 60_000);
    assert!(
        ended.stdout.contains("open with: squeakscope view"),
        "{}",
        ended.stdout
    );
}

#[test]
fn a_closed_viewer_ends_a_run_that_is_not_saved() {
    let (listener, url) = listener();
    let viewer = hangs_up_after(listener, 20_000);
    let (folder, _) = desk();
    let ended = Running::start(run(folder.path(), ENDLESS, &["--connect", &url])).end();
    ended.said(1, &[&url, "was closed", "no file is saved", "--save FILE"]);
    assert!(ended.took < Duration::from_secs(20), "{:?}", ended.took);
    viewer.join().expect("disconnected");
}

/// The run continues without the viewer and reconnects to it.
#[test]
fn a_reconnected_viewer_receives_the_recording() {
    let (listener, url) = listener();
    let address = listener.local_addr().expect("bound");
    let viewer = hangs_up_after(listener, 20_000);
    let (folder, recording) = desk();
    let part = folder.path().join("run.rrd.part");
    let running = Running::start(run(
        folder.path(),
        ENDLESS,
        &["--connect", &url, "--save", "run.rrd"],
    ));
    viewer.join().expect("disconnected");
    let before = size(&part);
    until("the run continues", || size(&part) > before + 500_000);
    let back = TcpListener::bind(address).expect("the port again");
    let mut greeted = Vec::new();
    until("a greeting", || {
        let (stream, _) = back.accept().expect("a connection");
        greeted.clear();
        stream
            .take(GREETING.len() as u64)
            .read_to_end(&mut greeted)
            .is_ok()
            && !greeted.is_empty()
    });
    assert_eq!(greeted, GREETING);
    drop(back);
    running.signal("INT");
    let ended = running.end();
    ended.said(130, &["disconnected; the run continues"]);
    assert!(!samples(&recording).values.is_empty());
}

/// A real viewer without a window, which saves the received data.
struct Viewer {
    running: Running,
    port: u16,
}

impl Viewer {
    /// Starts a viewer on a port.
    fn start(port: u16, save: &Path) -> Self {
        let program = std::env::var_os("SQUEAKSCOPE_VIEWER").unwrap_or_else(|| "rerun".into());
        let found = Command::new(&program).arg("--version").output();
        assert!(
            found.is_ok_and(|output| output.status.success()),
            "no Rerun viewer {program:?}: add it to the PATH, or set SQUEAKSCOPE_VIEWER"
        );
        let mut command = Command::new(program);
        command
            .args(["--bind", "127.0.0.1", "--port", &port.to_string(), "--save"])
            .arg(save);
        let running = Running::start(command);
        until("a viewer", || {
            TcpStream::connect(("127.0.0.1", port)).is_ok()
        });
        Self { running, port }
    }

    fn url(&self) -> String {
        url(self.port)
    }

    /// Kills the viewer, as by closing its terminal.
    fn kill(self) {
        self.running.signal("KILL");
        self.running.end();
    }

    /// Closes the viewer after all samples have arrived.
    fn close(self, seen: &Path, expected: usize) {
        until("all samples", || {
            let series = read_series(seen, Some(paths::DISPLACEMENT));
            series.is_ok_and(|series| series.values.len() >= expected)
        });
        self.running.signal("TERM");
        self.running.end();
    }
}

fn free_port() -> u16 {
    let (listener, _) = listener();
    listener.local_addr().expect("bound").port()
}

#[test]
#[ignore = "needs the Rerun viewer: SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored"]
fn a_real_viewer_that_is_killed_and_restarted_has_all_data() {
    let (folder, recording) = desk();
    let seen = ["first.rrd", "second.rrd"].map(|name| folder.path().join(name));
    let port = free_port();
    let viewer = Viewer::start(port, &seen[0]);
    let words = ["--connect", &viewer.url(), "--save", "run.rrd"];
    let running = Running::start(run(folder.path(), ENDLESS, &words));
    until("something seen", || size(&seen[0]) > 500_000);
    viewer.kill();
    let part = folder.path().join("run.rrd.part");
    let before = size(&part);
    until("the run continues", || size(&part) > before + 1_000_000);
    let viewer = Viewer::start(port, &seen[1]);
    until("something seen again", || size(&seen[1]) > before);
    running.signal("INT");
    running
        .end()
        .said(130, &["disconnected; the run continues", "has reconnected"]);
    let saved = samples(&recording);
    viewer.close(&seen[1], saved.values.len());
    let watched = samples(&seen[1]);
    assert_eq!(watched.values, saved.values);
    assert!(saved.values.len() > 10_000, "{}", saved.values.len());
    // The first viewer has received its part.
    assert!(!samples(&seen[0]).values.is_empty());
}

#[test]
#[ignore = "needs the Rerun viewer: SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored"]
fn a_killed_real_viewer_ends_a_run_that_is_not_saved() {
    let (folder, _) = desk();
    let seen = folder.path().join("seen.rrd");
    let viewer = Viewer::start(free_port(), &seen);
    let running = Running::start(run(folder.path(), ENDLESS, &["--connect", &viewer.url()]));
    until("something seen", || size(&seen) > 500_000);
    viewer.kill();
    running.end().said(1, &["was closed", "no file is saved"]);
}

/// A proxy between a run and its viewer with a limited data rate, bytes per second.
fn throttle(to: u16, bytes_per_second: usize) -> (u16, Arc<AtomicUsize>) {
    let (listener, _) = listener();
    let port = listener.local_addr().expect("bound").port();
    let passed = Arc::new(AtomicUsize::new(0));
    let total = Arc::clone(&passed);
    thread::spawn(move || {
        for run in listener.incoming().map_while(Result::ok) {
            let Ok(viewer) = TcpStream::connect(("127.0.0.1", to)) else {
                return;
            };
            let mut answers = (
                viewer.try_clone().expect("socket"),
                run.try_clone().expect("socket"),
            );
            thread::spawn(move || std::io::copy(&mut answers.0, &mut answers.1));
            let (mut run, mut viewer) = (run, viewer);
            let total = Arc::clone(&total);
            thread::spawn(move || {
                let mut buffer = vec![0; bytes_per_second / 100];
                while let Ok(count @ 1..) = run.read(&mut buffer) {
                    if std::io::Write::write_all(&mut viewer, &buffer[..count]).is_err() {
                        break;
                    }
                    total.fetch_add(count, Ordering::Relaxed);
                    thread::sleep(Duration::from_secs_f64(
                        count as f64 / bytes_per_second as f64,
                    ));
                }
                let _ = viewer.shutdown(std::net::Shutdown::Write);
            });
        }
    });
    (port, passed)
}

/// A viewer ten times too slow still receives every sample; only old pictures are dropped.
#[test]
#[ignore = "needs the Rerun viewer: SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored"]
fn a_real_viewer_ten_times_too_slow_gets_every_sample() {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _turn = ONE_AT_A_TIME.lock();
    for more in [&[][..], &["--save", "run.rrd"]] {
        let (folder, _) = desk();
        let seen = folder.path().join("seen.rrd");
        let viewer = Viewer::start(free_port(), &seen);
        // Data rate of a run of 0.3 s without a limit.
        let began = std::time::Instant::now();
        let (port, passed) = throttle(viewer.port, 1 << 30);
        let connect = url(port);
        let words = ["--connect", &connect];
        Running::start(run(folder.path(), "300", &words))
            .end()
            .said(0, &[]);
        let rate = passed.load(Ordering::Relaxed) as f64 / began.elapsed().as_secs_f64();
        viewer.close(&seen, 60_000);

        let viewer = Viewer::start(free_port(), &seen);
        let (port, _) = throttle(viewer.port, (0.1 * rate) as usize);
        let connect = url(port);
        let words = [&["--connect", &connect][..], more].concat();
        let ended = Running::start(run(folder.path(), "300", &words)).end();
        println!("{rate:.0} bytes/s, then {:?} {more:?}", ended.took);
        ended.said(0, &[]);
        // A message about waiting is allowed, but not one about a closed connection.
        assert!(!ended.stderr.contains("closed"), "{}", ended.stderr);
        viewer.close(&seen, 60_000);
        assert_eq!(samples(&seen).values.len(), 60_000);
    }
}
