//! Connections to viewers, and delivery of messages without blocking the run.
//!
//! Rerun's connection blocks without a timeout if a viewer does not read, when sending and when closing. A
//! viewer therefore has its own thread, which is not joined:
//!
//! * [`Feed`] reads the file that is being saved and sends its messages. A slow viewer lags behind, a
//!   disconnected one is not an error, and one that reconnects receives everything from the start.
//! * [`LiveConnection`] sends messages if no file is saved. The sender waits for a slow viewer as long as the
//!   viewer makes progress; the loss of the viewer ends the run.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Result as IoResult};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::record::sdk::SpawnOptions;
use crate::record::sdk::external::re_log_encoding::DecoderApp;
use crate::record::sdk::external::re_uri::ProxyUri;
use crate::record::sdk::log::LogMsg;
use crate::record::sdk::sink::{GrpcSink, GrpcSinkConnectionState, LogSink};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};

use super::{error::RecordError, stream::MessageSink};

/// Timeout of a connection to a viewer's port.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);
/// Time without progress after which a viewer counts as stuck.
const SEND_TIMEOUT: Duration = Duration::from_secs(5);
/// Timeout for the viewer's confirmation that it has received everything; later data are discarded.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(10);
/// Waiting time at the end that is not reported to the user.
const QUIET_WAIT: Duration = Duration::from_secs(1);
/// Interval of the attempts to reconnect to a viewer.
const RECONNECT_EVERY: Duration = Duration::from_millis(500);
/// Time after which a new connection counts as that of a viewer.
const STABLE_AFTER: Duration = Duration::from_secs(1);
/// Polling interval at the end of a growing file; short, so that the display appears live.
const POLL_EVERY: Duration = Duration::from_millis(10);
/// Maximum number of messages in the queue of a viewer's thread.
const QUEUE_LENGTH: usize = 16;
/// Maximum number of messages in Rerun's connection, which would otherwise queue 100 without reporting
/// progress.
const IN_CONNECTION: u64 = 8;

/// Parses a viewer's address and checks that a server listens there.
pub fn reachable(url: &str) -> Result<ProxyUri, RecordError> {
    let address = url.parse::<ProxyUri>();
    let address =
        address.map_err(|error| RecordError::Address(url.to_owned(), format!("{error}")))?;
    check_reachable(&address)
        .map_err(|error| RecordError::Viewer(url.to_owned(), error.to_string()))?;
    Ok(address)
}

/// Checks that a server listens at an address.
fn check_reachable(address: &ProxyUri) -> IoResult<()> {
    let host = address.origin.host.to_string();
    let mut result = Err(ErrorKind::AddrNotAvailable.into());
    for socket in (host.trim_matches(['[', ']']), address.origin.port).to_socket_addrs()? {
        result = TcpStream::connect_timeout(&socket, CONNECT_TIMEOUT).map(drop);
        if result.is_ok() {
            break;
        }
    }
    result
}

/// Starts a viewer and returns its address.
pub fn spawn() -> Result<ProxyUri, RecordError> {
    let options = SpawnOptions {
        wait_for_bind: true,
        hide_welcome_screen: true,
        // By default the viewer listens on all network interfaces.
        extra_args: vec!["--bind".to_owned(), "127.0.0.1".to_owned()],
        ..SpawnOptions::default()
    };
    let info = crate::record::sdk::spawn(&options).map_err(|error| {
        // The full error text includes installation instructions; its first line is the reason.
        let text = error.to_string();
        let reason = text.lines().next().unwrap_or_default();
        RecordError::Spawn(reason.trim_end_matches('.').to_owned())
    })?;
    let url = format!("rerun+http://127.0.0.1:{}/proxy", info.port);
    let address = url.parse::<ProxyUri>();
    address.map_err(|error| RecordError::Spawn(error.to_string()))
}

/// State shared by a viewer's thread and the recorder.
#[derive(Debug, Default)]
struct Shared {
    /// Number of messages forwarded; its growth distinguishes a slow viewer from a stuck one.
    sent: AtomicU64,
    /// No viewer is connected.
    away: AtomicBool,
    /// Nothing more will be written.
    finished: AtomicBool,
}

impl Shared {
    fn is_away(&self) -> bool {
        self.away.load(Ordering::Acquire)
    }

    fn set_away(&self, away: bool) {
        self.away.store(away, Ordering::Release);
    }

    /// Sends a message and waits if too many are queued; returns whether the viewer is connected.
    fn forward(&self, viewer: &GrpcSink, message: LogMsg) -> bool {
        LogSink::send(viewer, message);
        let sent = self.sent.fetch_add(1, Ordering::Relaxed);
        let full = sent.is_multiple_of(IN_CONNECTION);
        let flushed = !full || LogSink::flush_blocking(viewer, Duration::MAX).is_ok();
        flushed && !is_disconnected(viewer)
    }

    /// Waits for an answer as long as messages are being forwarded.
    fn wait<T>(&self, answer: &Receiver<T>, timeout: Duration) -> Option<T> {
        loop {
            let before = self.sent.load(Ordering::Relaxed);
            match answer.recv_timeout(timeout) {
                Ok(answer) => return Some(answer),
                Err(RecvTimeoutError::Timeout) if self.sent.load(Ordering::Relaxed) > before => {}
                Err(_) => return None,
            }
        }
    }
}

/// Opens a connection. Rerun panics if it cannot start a thread, so one is started first as a test.
fn open(address: ProxyUri) -> IoResult<GrpcSink> {
    let spare = thread::Builder::new().spawn(|| ())?;
    // The closure cannot panic.
    let _ = spare.join();
    Ok(GrpcSink::new(address))
}

fn is_disconnected(viewer: &GrpcSink) -> bool {
    matches!(viewer.status(), GrpcSinkConnectionState::Disconnected(_))
}

/// Closes a connection after the viewer has confirmed all data; returns whether it did.
fn close_gracefully(viewer: GrpcSink) -> bool {
    let flushed =
        LogSink::flush_blocking(&viewer, Duration::MAX).is_ok() && !is_disconnected(&viewer);
    // Dropping the connection ends the stream and waits for the reply.
    drop(viewer);
    flushed
}

/// Starts the thread of a viewer. It is not joined: it can block on a viewer that does not read.
fn start_thread(url: &str, work: impl FnOnce() + Send + 'static) -> Result<(), RecordError> {
    let thread = thread::Builder::new().name("viewer".to_owned());
    let started = thread.spawn(work).map(drop);
    started.map_err(|error| thread_error(url, &error))
}

fn thread_error(url: &str, error: &std::io::Error) -> RecordError {
    let reason =
        format!("cannot start a thread, {error}; raise the limit of processes (`ulimit -u`)");
    RecordError::Viewer(url.to_owned(), reason)
}

/// A feed that sends a growing file to a viewer.
#[derive(Debug)]
pub struct Feed {
    url: String,
    shared: Arc<Shared>,
    /// Receives whether the viewer has everything.
    ended: Receiver<bool>,
}

impl Feed {
    /// Starts sending the content of the file.
    ///
    /// # Errors
    /// [`RecordError::Viewer`] if the thread cannot be started.
    pub fn start(file: &Path, address: ProxyUri) -> Result<Self, RecordError> {
        let url = address.to_string();
        let shared = Arc::<Shared>::default();
        let (result, ended) = bounded(1);
        let (file, to_feed) = (file.to_owned(), Arc::clone(&shared));
        start_thread(&url, move || {
            let served = feed(&file, &address, &to_feed);
            // After a failed run there is no receiver.
            let _ = result.send(served);
        })?;
        Ok(Self { url, shared, ended })
    }

    /// Address of the viewer.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Whether no viewer is connected.
    pub fn is_away(&self) -> bool {
        self.shared.is_away()
    }

    /// Marks the file as complete.
    pub fn end(&self) {
        self.shared.finished.store(true, Ordering::Release);
    }

    /// Waits until the viewer has everything, as long as it makes progress; returns whether it has. `waiting`
    /// is called if the user would notice the wait.
    pub fn drain(&self, waiting: impl FnOnce()) -> bool {
        self.end();
        let at_once = self.ended.recv_timeout(QUIET_WAIT).ok();
        let served = at_once.or_else(|| {
            waiting();
            self.shared.wait(&self.ended, CLOSE_TIMEOUT)
        });
        self.shared.set_away(served != Some(true));
        served == Some(true)
    }
}

/// Serves viewers at an address one after the other; returns whether the last one has everything.
fn feed(file: &Path, address: &ProxyUri, shared: &Shared) -> bool {
    while !serve(file, address, shared) {
        shared.set_away(true);
        let mut is_reachable = false;
        while !is_reachable {
            if shared.finished.load(Ordering::Acquire) {
                return false;
            }
            thread::sleep(RECONNECT_EVERY);
            is_reachable = check_reachable(address).is_ok();
        }
    }
    true
}

/// Sends the file from start to end; returns whether the viewer has all of it.
fn serve(file: &Path, address: &ProxyUri, shared: &Shared) -> bool {
    let Ok(file) = File::open(file) else {
        return false;
    };
    let Ok(viewer) = open(address.clone()) else {
        return false;
    };
    let tail = Tail {
        file,
        viewer: &viewer,
        shared,
    };
    let began = Instant::now();
    let mut messages = DecoderApp::decode_lazy(BufReader::with_capacity(1 << 16, tail));
    let sent_all = messages.all(|message| {
        // A server that accepts connections and closes them is not a viewer.
        if began.elapsed() > STABLE_AFTER {
            shared.set_away(false);
        }
        message.is_ok_and(|message| shared.forward(&viewer, message))
    });
    drop(messages);
    sent_all && close_gracefully(viewer)
}

/// Reader of a file that is still being written; its end is the end of the run.
struct Tail<'a> {
    file: File,
    viewer: &'a GrpcSink,
    shared: &'a Shared,
}

impl Read for Tail<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> IoResult<usize> {
        loop {
            // Read the flag before the file, so that data written before the end are not missed.
            let over = self.shared.finished.load(Ordering::Acquire);
            let count = self.file.read(buffer)?;
            if count > 0 || over {
                return Ok(count);
            }
            if is_disconnected(self.viewer) {
                return Err(ErrorKind::ConnectionAborted.into());
            }
            thread::sleep(POLL_EVERY);
        }
    }
}

/// A command for the thread of a live viewer.
enum Command {
    Send(LogMsg),
    /// Reply when all previous messages have been sent.
    Flush(Sender<()>),
    /// Reply when the viewer has everything, and end.
    Close(Sender<()>),
}

/// A live connection to a viewer if no file is saved; clones share it.
#[derive(Clone, Debug)]
pub struct LiveConnection {
    url: String,
    shared: Arc<Shared>,
    commands: Sender<Command>,
}

impl LiveConnection {
    /// Connects to a viewer.
    ///
    /// # Errors
    /// [`RecordError::Viewer`] if the thread cannot be started.
    pub fn start(address: ProxyUri) -> Result<Self, RecordError> {
        let url = address.to_string();
        let shared = Arc::<Shared>::default();
        let (commands, received) = bounded(QUEUE_LENGTH);
        let to_viewer = Arc::clone(&shared);
        let viewer = open(address).map_err(|error| thread_error(&url, &error))?;
        start_thread(&url, move || run_connection(viewer, &received, &to_viewer))?;
        Ok(Self {
            url,
            shared,
            commands,
        })
    }

    /// Waits until all messages are sent, as long as the viewer makes progress; this throttles a fast
    /// simulation.
    ///
    /// # Errors
    /// [`RecordError::ViewerLost`] if the viewer is lost.
    pub fn flush(&self) -> Result<(), RecordError> {
        self.request(Command::Flush, SEND_TIMEOUT)
    }

    /// Waits until the viewer has everything, as long as it makes progress.
    ///
    /// # Errors
    /// [`RecordError::ViewerLost`] if the viewer is lost.
    pub fn close(&self) -> Result<(), RecordError> {
        self.request(Command::Close, CLOSE_TIMEOUT)
    }

    /// Executes a command; a viewer that does not reply counts as lost.
    fn request(
        &self,
        command: fn(Sender<()>) -> Command,
        timeout: Duration,
    ) -> Result<(), RecordError> {
        let (done, answer) = bounded(1);
        self.submit(command(done));
        if !self.shared.is_away() && self.shared.wait(&answer, timeout).is_none() {
            self.shared.set_away(true);
        }
        if self.shared.is_away() {
            return Err(RecordError::ViewerLost(self.url.clone()));
        }
        Ok(())
    }

    fn submit(&self, command: Command) {
        if !self.shared.is_away() && self.commands.send_timeout(command, SEND_TIMEOUT).is_err() {
            self.shared.set_away(true);
        }
    }
}

impl MessageSink for LiveConnection {
    fn send(&self, message: LogMsg) {
        self.submit(Command::Send(message));
    }
}

/// Executes commands until the last one or until the viewer disconnects.
fn run_connection(viewer: GrpcSink, commands: &Receiver<Command>, shared: &Shared) {
    for command in commands {
        let connected = match command {
            Command::Send(message) => shared.forward(&viewer, message),
            Command::Flush(done) => {
                // The recorder may have timed out.
                let _ = done.send(());
                !is_disconnected(&viewer)
            }
            Command::Close(done) => {
                shared.set_away(!close_gracefully(viewer));
                let _ = done.send(());
                return;
            }
        };
        if !connected {
            shared.set_away(true);
            return;
        }
    }
}
