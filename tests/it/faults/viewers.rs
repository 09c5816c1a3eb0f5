//! Viewers that are not there, do not read, hang up, and come back.

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

/// What a connection to a viewer begins with.
const GREETING: &[u8] = b"PRI * HTTP/2.0";

fn listener() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let url = url(listener.local_addr().expect("bound").port());
    (listener, url)
}

fn url(port: u16) -> String {
    format!("rerun+http://127.0.0.1:{port}/proxy")
}

/// Listens as a viewer does that hangs up once it has read so many bytes of a connection, and whose
/// port is closed then.
fn hangs_up_after(listener: TcpListener, bytes: usize) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.expect("a connection");
            let mut left = bytes;
            let mut buffer = [0; 4096];
            while left > 0 {
                match stream.read(&mut buffer) {
                    // Somebody who only looked whether there is a viewer.
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
fn a_viewer_that_was_never_there_is_told_before_any_work() {
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
fn a_viewer_that_is_not_installed_is_told_before_any_work() {
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

/// Its port takes connections, and then nothing: stopped, or not a viewer at all.
#[test]
fn a_viewer_that_never_reads_ends_a_run_that_is_only_watched() {
    let (_listener, url) = listener();
    let (folder, _) = desk();
    let ended = Running::start(run(folder.path(), ENDLESS, &["--connect", &url])).end();
    ended.said(
        1,
        &[
            &url,
            "takes nothing any more",
            "nothing was saved",
            "--save FILE",
        ],
    );
    assert!(ended.took < Duration::from_secs(30), "{:?}", ended.took);
}

#[test]
fn a_viewer_that_never_reads_does_not_hold_up_what_is_saved() {
    let (_listener, url) = listener();
    let (folder, recording) = desk();
    let ended = Running::start(run(
        folder.path(),
        "300",
        &["--connect", &url, "--save", "run.rrd"],
    ))
    .end();
    ended.said(0, &["warning: the viewer at", &url, "all is in the file"]);
    assert_eq!(samples(&recording).values.len(), 60_000);
    assert!(
        ended.stdout.contains("open it with: rerun"),
        "{}",
        ended.stdout
    );
}

#[test]
fn a_viewer_that_is_closed_ends_a_run_that_is_only_watched() {
    let (listener, url) = listener();
    let viewer = hangs_up_after(listener, 20_000);
    let (folder, _) = desk();
    let ended = Running::start(run(folder.path(), ENDLESS, &["--connect", &url])).end();
    ended.said(1, &[&url, "was closed", "nothing was saved", "--save FILE"]);
    assert!(ended.took < Duration::from_secs(20), "{:?}", ended.took);
    viewer.join().expect("hung up");
}

/// The run goes on without it, and greets it again when it is back.
#[test]
fn a_viewer_that_is_back_is_sent_what_is_saved() {
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
    viewer.join().expect("hung up");
    let before = size(&part);
    until("the run goes on", || size(&part) > before + 500_000);
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
    ended.said(130, &["has gone; the run goes on into the file"]);
    assert!(!samples(&recording).values.is_empty());
}

/// Ctrl-C is for a run whose viewer is stuck, too.
#[test]
fn ctrl_c_ends_a_run_whose_viewer_never_reads() {
    let (_listener, url) = listener();
    let (folder, recording) = desk();
    let running = Running::start(run(
        folder.path(),
        ENDLESS,
        &["--connect", &url, "--save", "run.rrd"],
    ));
    until("a part", || {
        size(&folder.path().join("run.rrd.part")) > 500_000
    });
    running.signal("INT");
    running
        .end()
        .said(130, &["interrupted", "all is in the file"]);
    assert!(!samples(&recording).values.is_empty());
}

/// A real viewer without a window, which saves what it is sent.
struct Viewer {
    running: Running,
    port: u16,
}

impl Viewer {
    /// Starts one at a port.
    fn start(port: u16, save: &Path) -> Self {
        let program = std::env::var_os("SQUEAKSCOPE_VIEWER").unwrap_or_else(|| "rerun".into());
        let found = Command::new(&program).arg("--version").output();
        assert!(
            found.is_ok_and(|output| output.status.success()),
            "no Rerun viewer {program:?}: put it on the PATH, or name it by SQUEAKSCOPE_VIEWER"
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

    /// As by somebody who closes its terminal.
    fn kill(self) {
        self.running.signal("KILL");
        self.running.end();
    }

    /// As by somebody who is done with it, once all samples have come.
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
fn a_real_viewer_that_is_killed_and_back_has_everything() {
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
    until("the run goes on", || size(&part) > before + 1_000_000);
    let viewer = Viewer::start(port, &seen[1]);
    until("something seen again", || size(&seen[1]) > before);
    running.signal("INT");
    running
        .end()
        .said(130, &["has gone; the run goes on", "is back"]);
    let saved = samples(&recording);
    viewer.close(&seen[1], saved.values.len());
    let watched = samples(&seen[1]);
    assert_eq!(watched.values, saved.values);
    assert!(saved.values.len() > 10_000, "{}", saved.values.len());
    // Whoever was there first has seen its part.
    assert!(!samples(&seen[0]).values.is_empty());
}

#[test]
#[ignore = "needs the Rerun viewer: SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored"]
fn a_real_viewer_that_is_killed_ends_a_run_that_is_only_watched() {
    let (folder, _) = desk();
    let seen = folder.path().join("seen.rrd");
    let viewer = Viewer::start(free_port(), &seen);
    let running = Running::start(run(folder.path(), ENDLESS, &["--connect", &viewer.url()]));
    until("something seen", || size(&seen) > 500_000);
    viewer.kill();
    running.end().said(1, &["was closed", "nothing was saved"]);
}

/// Between a run and its viewer, lets so many bytes a second through.
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

/// Ten times too slow, it is sent every sample all the same; only old pictures give way.
#[test]
#[ignore = "needs the Rerun viewer: SQUEAKSCOPE_VIEWER=rerun cargo test --release --test it faults::viewers -- --ignored"]
fn a_real_viewer_ten_times_too_slow_gets_every_sample() {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _turn = ONE_AT_A_TIME.lock();
    for more in [&[][..], &["--save", "run.rrd"]] {
        let (folder, _) = desk();
        let seen = folder.path().join("seen.rrd");
        let viewer = Viewer::start(free_port(), &seen);
        // How many bytes a second it would be: a run of 0.3 s that takes as long as it likes.
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
        // That it is waited for may be said, but not that it is given up.
        assert!(!ended.stderr.contains("closed"), "{}", ended.stderr);
        viewer.close(&seen, 60_000);
        assert_eq!(samples(&seen).values.len(), 60_000);
    }
}
