//! Clients that connect, disconnect, flood and never read: the resources of the run stay bounded.

use std::fmt::Write as _;
use std::io::{Read, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::Message;

use super::{DEADLINE, Live, Socket, set_read_timeout, tilt};

/// Approximate number of rows of the table.
const ROWS: u32 = 120;
/// Playback speed, ms of simulated time per s of wall time: real time.
const PACE: f64 = 1000.0;
/// Descriptors of the clients.
const OF_CLIENTS: usize = 40;
/// Additional threads compared with a quiet run: they load scenes and prepare the next run.
const MORE_THREADS: usize = 16;
/// Additional memory compared with a quiet run, MB: data queued for clients that do not read.
const MORE_MEMORY: f64 = 400.0;

/// Resources of the run.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Wall time since the first sample, s.
    wall: f64,
    threads: usize,
    descriptors: usize,
    memory_mb: f64,
    /// Playback speed since the previous sample, ms/s.
    speed: f64,
}

/// Present resources of a process, as counted by the system.
fn taken(process: u32) -> (usize, usize, f64) {
    let folder = PathBuf::from(format!("/proc/{process}"));
    let entries = |name| {
        std::fs::read_dir(folder.join(name))
            .expect("a process")
            .count()
    };
    let status = std::fs::read_to_string(folder.join("status")).expect("a process");
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = resident.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    (
        entries("task"),
        entries("fd"),
        kilobytes.expect("a size") / 1024.0,
    )
}

/// Duration of the test, and the commands of the clients.
struct Plan {
    duration: Duration,
    /// Whether to record and to restart the scene.
    renewed: bool,
}

struct Soak<'a> {
    host: &'a str,
    folder: &'a Path,
    over: AtomicBool,
}

impl Soak<'_> {
    fn is_running(&self) -> bool {
        !self.over.load(Ordering::Relaxed)
    }

    fn rest(&self, time: Duration) {
        let until = Instant::now() + time;
        while self.is_running() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// A socket, unless the server is full.
    fn socket(&self, path: &str) -> Option<Socket> {
        let (mut socket, _) = tungstenite::connect(format!("ws://{}{path}", self.host)).ok()?;
        set_read_timeout(&mut socket, DEADLINE);
        Some(Socket(socket))
    }

    /// Loads the page, views and listens for a moment, and disconnects.
    fn visitor(&self) {
        while self.is_running() {
            if let Ok(mut stream) = TcpStream::connect(self.host) {
                let asked = write!(stream, "GET / HTTP/1.1\r\nHost: {}\r\n\r\n", self.host);
                // A full server may close the connection.
                let _ = asked.and_then(|()| stream.read_to_end(&mut Vec::new()));
            }
            let mut open = ["/control", "/views", "/sound"].map(|path| self.socket(path));
            for socket in open.iter_mut().flatten() {
                set_read_timeout(&mut socket.0, Duration::from_millis(100));
            }
            for _ in 0..10 {
                for socket in open.iter_mut().flatten() {
                    // The server may have closed it, or waits for an acknowledgement of its views.
                    let _ = socket.0.read();
                }
            }
            self.rest(Duration::from_millis(100));
        }
    }

    /// Sends kicks and tilts as fast as the server accepts them. A client that does not read is disconnected.
    fn flood(&self, reads: bool) {
        let commands = [
            json!({ "do": "kick", "mm_per_s": 0.01 }),
            tilt(2.9),
            tilt(3.1),
            json!({ "do": "speed", "ms_per_s": PACE }),
        ]
        .map(|command| Message::text(command.to_string()));
        while self.is_running() {
            let Some(mut socket) = self.socket("/control") else {
                self.rest(Duration::from_millis(200));
                continue;
            };
            for command in commands.iter().cycle().take(3000) {
                if !self.is_running() || socket.0.send(command.clone()).is_err() {
                    break;
                }
                if reads && socket.0.read().is_err() {
                    break;
                }
            }
        }
    }

    /// Opens sockets without reading, and requests without end.
    fn mute(&self) {
        while self.is_running() {
            let _sockets = ["/views", "/sound"].map(|path| self.socket(path));
            let _requests = [(); 8].map(|()| {
                let mut stream = TcpStream::connect(self.host)?;
                stream.write_all(b"GET / HTTP/1.1\r\nHost: ")?;
                std::io::Result::Ok(stream)
            });
            self.rest(Duration::from_secs(15));
        }
    }

    /// Records for a while, then restarts the scene.
    fn renewer(&self) {
        while self.is_running() {
            for command in ["record", "stop-recording", "reset"] {
                if let Some(mut control) = self.socket("/control") {
                    control.ask(&json!({ "do": command }));
                }
                self.rest(Duration::from_secs(1));
            }
            for file in std::fs::read_dir(self.folder).expect("a folder").flatten() {
                // A file that is being written stays until the next time.
                if file.path().extension().is_some_and(|end| end == "rrd") {
                    std::fs::remove_file(file.path()).expect("removed");
                }
            }
            self.rest(Duration::from_secs(2));
        }
    }
}

/// Total simulated time, across restarts of scenes.
#[derive(Default)]
struct Clock {
    run: Value,
    time: f64,
    sum: f64,
}

impl Clock {
    fn see(&mut self, panel: &Value) {
        let time = panel["time_s"].as_f64().expect("a time");
        if panel["run"] == self.run {
            self.sum += (time - self.time).max(0.0);
        }
        self.time = time;
        self.run.clone_from(&panel["run"]);
    }
}

/// Samples the resources of a run under load; the first sample is taken before the load, the last one after
/// it.
fn soak(plan: &Plan) -> Vec<Sample> {
    let live = Live::start(
        "doubled-torus-3deg",
        &["--speed", &PACE.to_string(), "--no-lyapunov"],
    );
    let process = live.child.id();
    let mut control = live.socket("/control");
    control.panel(|panel| panel["time_s"].as_f64() > Some(0.2));
    let began = Instant::now();
    let sample = |speed: f64| {
        let (threads, descriptors, memory_mb) = taken(process);
        let wall = began.elapsed().as_secs_f64();
        Sample {
            wall,
            threads,
            descriptors,
            memory_mb,
            speed,
        }
    };
    let mut samples = vec![sample(f64::NAN)];
    let soak = Soak {
        host: &live.host,
        folder: live.folder(),
        over: AtomicBool::new(false),
    };
    std::thread::scope(|scope| {
        let soak = &soak;
        scope.spawn(|| soak.visitor());
        scope.spawn(|| soak.visitor());
        scope.spawn(|| soak.flood(true));
        scope.spawn(|| soak.flood(true));
        scope.spawn(|| soak.flood(false));
        scope.spawn(|| soak.mute());
        if plan.renewed {
            scope.spawn(|| soak.renewer());
        }
        let mut clock = Clock::default();
        let mut last = (Instant::now(), 0.0);
        while began.elapsed() < plan.duration {
            clock.see(&control.panel(|_| true));
            let wall = last.0.elapsed();
            if wall > plan.duration / ROWS {
                samples.push(sample(1e3 * (clock.sum - last.1) / wall.as_secs_f64()));
                last = (Instant::now(), clock.sum);
            }
        }
        soak.over.store(true, Ordering::Relaxed);
    });
    // The run itself must not delay the release on a busy machine.
    control.ask(&json!({ "do": "speed", "ms_per_s": 1 }));
    // Resources are released after connections and their threads have ended.
    let quiet = samples[0];
    let left = Instant::now();
    loop {
        let now = sample(f64::NAN);
        let is_back = now.threads <= quiet.threads && now.descriptors <= quiet.descriptors;
        if is_back || left.elapsed() > DEADLINE {
            samples.push(now);
            return samples;
        }
        control.panel(|_| true);
    }
}

/// Bounds that hold on a busy machine, too.
fn assert_bounded(samples: &[Sample]) {
    let quiet = samples[0];
    for sample in samples {
        let held = sample.threads <= quiet.threads + MORE_THREADS
            && sample.descriptors <= quiet.descriptors + OF_CLIENTS + 8
            && sample.memory_mb <= quiet.memory_mb + MORE_MEMORY;
        assert!(held, "{quiet:?} has grown to {sample:?}");
    }
    let last = samples[samples.len() - 1];
    let is_back = last.threads <= quiet.threads && last.descriptors <= quiet.descriptors;
    assert!(is_back, "{last:?} without clients, but {quiet:?} before");
}

#[test]
fn the_resources_of_a_run_are_bounded() {
    let samples = soak(&Plan {
        duration: Duration::from_secs(4),
        renewed: false,
    });
    assert_bounded(&samples);
}

/// Ten minutes, or `SQUEAKSCOPE_SOAK` seconds. The table and its figure are written to the folder
/// `SQUEAKSCOPE_SOAK_FOLDER`, or next to the build.
#[test]
#[ignore = "ten minutes: cargo test --release --test it live::soak::ten_minutes -- --ignored --nocapture"]
fn ten_minutes() {
    let seconds = std::env::var("SQUEAKSCOPE_SOAK").ok();
    let seconds = seconds.map_or(600, |text| {
        text.parse().expect("SQUEAKSCOPE_SOAK in seconds")
    });
    let samples = soak(&Plan {
        duration: Duration::from_secs(seconds),
        renewed: true,
    });
    let folder = std::env::var_os("SQUEAKSCOPE_SOAK_FOLDER");
    let folder = folder.unwrap_or_else(|| env!("CARGO_TARGET_TMPDIR").into());
    let at = |name: &str| Path::new(&folder).join(name);
    std::fs::write(at("soak.csv"), table(&samples)).expect("written");
    std::fs::write(at("soak.html"), drawn(&samples)).expect("written");
    println!("{}", table(&samples));
    assert_bounded(&samples);
}

type Column = (&'static str, fn(&Sample) -> f64);

const COLUMNS: [Column; 4] = [
    ("threads", |sample| sample.threads as f64),
    ("descriptors", |sample| sample.descriptors as f64),
    ("memory_mb", |sample| sample.memory_mb),
    ("playback_ms_per_s", |sample| sample.speed),
];

fn table(samples: &[Sample]) -> String {
    let mut text = "wall_s".to_owned();
    for (name, _) in COLUMNS {
        text += &format!(",{name}");
    }
    for sample in samples {
        write!(text, "\n{:.1}", sample.wall).expect("a string");
        for (_, value) in COLUMNS {
            write!(text, ",{:.0}", value(sample)).expect("a string");
        }
    }
    text + "\n"
}

/// Plots the columns versus time, each from zero to slightly above its maximum.
fn drawn(samples: &[Sample]) -> String {
    let end = samples
        .iter()
        .fold(0.0, |end: f64, sample| end.max(sample.wall));
    let mut svg =
        "<svg width=\"100%\" viewBox=\"0 0 640 440\" xmlns=\"http://www.w3.org/2000/svg\" \
                   font-family=\"sans-serif\" font-size=\"12\" fill=\"#6E747C\">\n"
            .to_owned();
    for (row, (name, value)) in COLUMNS.iter().enumerate() {
        let known: Vec<_> = samples
            .iter()
            .filter(|sample| value(sample).is_finite())
            .collect();
        let largest = known
            .iter()
            .fold(0.0, |most: f64, sample| most.max(value(sample)));
        let (top, bottom) = (20.0 + 105.0 * row as f64, 100.0 + 105.0 * row as f64);
        let points: String = known
            .iter()
            .map(|sample| {
                let x = 20.0 + 600.0 * sample.wall / end;
                let y = bottom - (bottom - top) * value(sample) / (1.1 * largest);
                format!("{x:.1},{y:.1} ")
            })
            .collect();
        write!(
            svg,
            "<text x=\"20\" y=\"{top}\">{name}, maximum {largest:.0}</text>\n\
             <polyline fill=\"none\" stroke=\"#6E747C\" points=\"20,{bottom} 620,{bottom}\"/>\n\
             <polyline fill=\"none\" stroke=\"#0072B2\" stroke-width=\"1.5\" points=\"{points}\"/>\n"
        )
        .expect("a string");
    }
    svg + &format!("<text x=\"620\" y=\"435\" text-anchor=\"end\">{end:.0} s</text>\n</svg>\n")
}
