//! Viewers: how one is reached, and how messages come to it without holding up what matters more.
//!
//! Rerun's connection blocks whoever sends to a viewer that does not read, without end, and so does
//! closing it. So a viewer has a thread of its own here, which may be left behind:
//!
//! * [`Feed`] reads the file that is being saved, and sends what is in it. A slow viewer lags behind, a
//!   dead one is no fault, and one that is back is sent everything from the start.
//! * [`Live`] takes messages where nothing is saved. The sender waits for a slow viewer, as long as it
//!   takes anything at all; a viewer that has gone is the end of the run.

use std::{
    fs::File,
    io::{BufReader, ErrorKind, Read, Result as IoResult},
    net::{TcpStream, ToSocketAddrs},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use rerun::{
    SpawnOptions,
    external::{re_log_encoding::DecoderApp, re_uri::ProxyUri},
    log::LogMsg,
    sink::{GrpcSink, GrpcSinkConnectionState, LogSink},
};

use super::{error::RecordError, stream::MessageSink};

/// How long to wait for a viewer's port.
const CONNECT_PATIENCE: Duration = Duration::from_secs(2);
/// How long a viewer may take nothing before it counts as stuck.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long it may take to say that it has everything: what is under way by then is seen by nobody.
const LAST_PATIENCE: Duration = Duration::from_secs(10);
/// A wait that nobody notices.
const UNNOTICED: Duration = Duration::from_secs(1);
/// How often a viewer that has gone is looked for.
const KNOCK_EVERY: Duration = Duration::from_millis(500);
/// How long a viewer must have been back to be believed.
const STAYS: Duration = Duration::from_secs(1);
/// How often the end of a growing file is looked at: often enough to seem live.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Messages that may wait for the thread of a viewer.
const WAITING: usize = 16;
/// Messages that may wait in Rerun's connection, which would hold a hundred without a sign of progress.
const IN_CONNECTION: u64 = 8;

/// Reads a viewer's address and makes sure that something listens there.
pub fn reachable(url: &str) -> Result<ProxyUri, RecordError> {
    let address: ProxyUri = url.parse().map_err(|error| RecordError::Address {
        url: url.to_owned(),
        reason: format!("{error}"),
    })?;
    answers(&address).map_err(|error| RecordError::Viewer {
        url: url.to_owned(),
        reason: error.to_string(),
    })?;
    Ok(address)
}

/// Whether something listens at an address.
fn answers(address: &ProxyUri) -> IoResult<()> {
    let host = address.origin.host.to_string();
    let mut result = Err(ErrorKind::AddrNotAvailable.into());
    for socket in (host.trim_matches(['[', ']']), address.origin.port).to_socket_addrs()? {
        result = TcpStream::connect_timeout(&socket, CONNECT_PATIENCE).map(drop);
        if result.is_ok() {
            break;
        }
    }
    result
}

/// Starts a viewer and gives its address.
pub fn spawn() -> Result<ProxyUri, RecordError> {
    let fault = |reason: String| RecordError::Spawn { reason };
    let options = SpawnOptions {
        wait_for_bind: true,
        hide_welcome_screen: true,
        // Left alone, the viewer would listen to the whole network.
        extra_args: vec!["--bind".to_owned(), "127.0.0.1".to_owned()],
        ..SpawnOptions::default()
    };
    let info = rerun::spawn(&options).map_err(|error| {
        // The full text of the error is a page on installing; its first line is the reason.
        let text = error.to_string();
        fault(
            text.lines()
                .next()
                .unwrap_or_default()
                .trim_end_matches('.')
                .to_owned(),
        )
    })?;
    let url = format!("rerun+http://127.0.0.1:{}/proxy", info.port);
    url.parse::<ProxyUri>()
        .map_err(|error| fault(error.to_string()))
}

/// What a viewer's thread and the recorder tell each other.
#[derive(Debug, Default)]
struct Shared {
    /// Messages handed on: tells a slow viewer from a stuck one.
    sent: AtomicU64,
    /// There is no viewer now.
    away: AtomicBool,
    /// Nothing more will be written.
    over: AtomicBool,
}

impl Shared {
    fn is_over(&self) -> bool {
        self.over.load(Ordering::Acquire)
    }

    fn is_away(&self) -> bool {
        self.away.load(Ordering::Acquire)
    }

    fn set_away(&self, away: bool) {
        self.away.store(away, Ordering::Release);
    }

    /// Sends a message, and waits for a viewer that has too many of them before it; whether there is one.
    fn hand_on(&self, viewer: &GrpcSink, message: LogMsg) -> bool {
        LogSink::send(viewer, message);
        let sent = self.sent.fetch_add(1, Ordering::Relaxed);
        let full = sent.is_multiple_of(IN_CONNECTION);
        let flushed = !full || LogSink::flush_blocking(viewer, Duration::MAX).is_ok();
        flushed && !hung_up(viewer)
    }

    /// Waits for an answer as long as messages go out meanwhile.
    fn wait<T>(&self, answer: &Receiver<T>, patience: Duration) -> Option<T> {
        loop {
            let before = self.sent.load(Ordering::Relaxed);
            match answer.recv_timeout(patience) {
                Ok(answer) => return Some(answer),
                Err(RecvTimeoutError::Timeout) if self.sent.load(Ordering::Relaxed) > before => {}
                Err(_) => return None,
            }
        }
    }
}

/// Opens a connection. Rerun panics where there is no thread for it, so that one is asked for before.
fn open(address: ProxyUri) -> IoResult<GrpcSink> {
    let spare = thread::Builder::new().spawn(|| ())?;
    // It does nothing that could fail.
    let _ = spare.join();
    Ok(GrpcSink::new(address))
}

fn hung_up(viewer: &GrpcSink) -> bool {
    matches!(viewer.status(), GrpcSinkConnectionState::Disconnected(_))
}

/// Closes a connection once the viewer has said that it has everything; whether it did.
fn part_in_peace(viewer: GrpcSink) -> bool {
    let flushed = LogSink::flush_blocking(&viewer, Duration::MAX).is_ok() && !hung_up(&viewer);
    // Ends the stream, and waits for the answer to it.
    drop(viewer);
    flushed
}

fn thread_error(url: &str, error: &std::io::Error) -> RecordError {
    RecordError::Viewer {
        url: url.to_owned(),
        reason: format!("no thread for it, {error}; raise the limit of processes (ulimit -u)"),
    }
}

/// Sends a growing file to a viewer.
#[derive(Debug)]
pub struct Feed {
    url: String,
    shared: Arc<Shared>,
    /// Whether the viewer has everything.
    ended: Receiver<bool>,
}

impl Feed {
    /// Begins with what is in the file.
    ///
    /// # Errors
    /// [`RecordError::Viewer`] if there is no thread to be had.
    pub fn start(file: &Path, address: ProxyUri) -> Result<Self, RecordError> {
        let url = address.to_string();
        let shared = Arc::<Shared>::default();
        let (tell, ended) = bounded(1);
        let (file, to_feed) = (file.to_owned(), Arc::clone(&shared));
        // Not joined: it may be stuck with a viewer that does not read.
        thread::Builder::new()
            .name("viewer".to_owned())
            .spawn(move || {
                let served = feed(&file, &address, &to_feed);
                // Nobody asks after a run that failed.
                let _ = tell.send(served);
            })
            .map_err(|error| thread_error(&url, &error))?;
        Ok(Self { url, shared, ended })
    }

    /// The viewer's address.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Whether there is no viewer now.
    pub fn is_away(&self) -> bool {
        self.shared.is_away()
    }

    /// To be called when nothing more will be written.
    pub fn end(&self) {
        self.shared.over.store(true, Ordering::Release);
    }

    /// Waits until the viewer has everything, as long as it takes any of it; whether it has. A wait
    /// that whoever started the run will notice is told.
    pub fn drain(&self, waiting: impl FnOnce()) -> bool {
        self.end();
        if let Ok(served) = self.ended.recv_timeout(UNNOTICED) {
            self.shared.set_away(!served);
            return served;
        }
        waiting();
        let served = self
            .shared
            .wait(&self.ended, LAST_PATIENCE)
            .unwrap_or(false);
        self.shared.set_away(!served);
        served
    }
}

/// Serves one viewer after another at the same address; whether the last one has everything.
fn feed(file: &Path, address: &ProxyUri, shared: &Shared) -> bool {
    loop {
        if serve(file, address, shared) {
            return true;
        }
        shared.set_away(true);
        loop {
            if shared.is_over() {
                return false;
            }
            thread::sleep(KNOCK_EVERY);
            if answers(address).is_ok() {
                break;
            }
        }
    }
}

/// Sends the file from its start to its end; whether the viewer has it all.
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
        // Whatever takes connections and hangs up is no viewer that is back.
        if began.elapsed() > STAYS {
            shared.set_away(false);
        }
        message.is_ok_and(|message| shared.hand_on(&viewer, message))
    });
    drop(messages);
    sent_all && part_in_peace(viewer)
}

/// Reads a file that is still being written: its end is where the run ends.
struct Tail<'a> {
    file: File,
    viewer: &'a GrpcSink,
    shared: &'a Shared,
}

impl Read for Tail<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> IoResult<usize> {
        loop {
            // Asked first: what is written before the end is read before it.
            let over = self.shared.is_over();
            let count = self.file.read(buffer)?;
            if count > 0 || over {
                return Ok(count);
            }
            if hung_up(self.viewer) {
                return Err(ErrorKind::ConnectionAborted.into());
            }
            thread::sleep(LOOK_EVERY);
        }
    }
}

/// What the thread of a live viewer is asked to do.
enum Command {
    Send(LogMsg),
    /// Answer when all before has been sent.
    Flush(Sender<()>),
    /// Answer when the viewer has everything, and end.
    Close(Sender<()>),
}

/// Sends to a viewer while nothing is saved; the clones send to the same one.
#[derive(Clone, Debug)]
pub struct Live {
    url: String,
    shared: Arc<Shared>,
    commands: Sender<Command>,
}

impl Live {
    /// Connects to a viewer.
    ///
    /// # Errors
    /// [`RecordError::Viewer`] if there is no thread to be had.
    pub fn start(address: ProxyUri) -> Result<Self, RecordError> {
        let url = address.to_string();
        let shared = Arc::<Shared>::default();
        let (commands, to_do) = bounded(WAITING);
        let to_viewer = Arc::clone(&shared);
        let viewer = open(address).map_err(|error| thread_error(&url, &error))?;
        // Not joined: it may be stuck with a viewer that does not read.
        thread::Builder::new()
            .name("viewer".to_owned())
            .spawn(move || live(viewer, &to_do, &to_viewer))
            .map_err(|error| thread_error(&url, &error))?;
        Ok(Self {
            url,
            shared,
            commands,
        })
    }

    /// Why nothing is sent any more, if so.
    fn fault(&self) -> Option<RecordError> {
        self.shared.is_away().then(|| RecordError::ViewerGone {
            url: self.url.clone(),
        })
    }

    /// Takes as long as the viewer takes anything: that is what makes a fast simulation wait.
    ///
    /// # Errors
    /// [`RecordError::ViewerGone`].
    pub fn flush(&self) -> Result<(), RecordError> {
        self.ask(Command::Flush, PATIENCE);
        self.fault().map_or(Ok(()), Err)
    }

    /// Waits until the viewer has everything, as long as it takes any of it.
    ///
    /// # Errors
    /// [`RecordError::ViewerGone`].
    pub fn close(&self) -> Result<(), RecordError> {
        self.ask(Command::Close, LAST_PATIENCE);
        self.fault().map_or(Ok(()), Err)
    }

    /// Has a command carried out; a viewer that does not do it is away.
    fn ask(&self, command: impl FnOnce(Sender<()>) -> Command, patience: Duration) {
        let (done, answer) = bounded(1);
        self.order(command(done));
        if !self.shared.is_away() && self.shared.wait(&answer, patience).is_none() {
            self.shared.set_away(true);
        }
    }

    fn order(&self, command: Command) {
        if !self.shared.is_away() && self.commands.send_timeout(command, PATIENCE).is_err() {
            self.shared.set_away(true);
        }
    }
}

impl MessageSink for Live {
    fn send(&self, message: LogMsg) {
        self.order(Command::Send(message));
    }
}

/// Carries out commands until the last one, or until the viewer hangs up.
fn live(viewer: GrpcSink, commands: &Receiver<Command>, shared: &Shared) {
    for command in commands {
        let there = match command {
            Command::Send(message) => shared.hand_on(&viewer, message),
            Command::Flush(done) => {
                // The recorder may have lost its patience meanwhile.
                let _ = done.send(());
                !hung_up(&viewer)
            }
            Command::Close(done) => {
                shared.set_away(!part_in_peace(viewer));
                let _ = done.send(());
                return;
            }
        };
        if !there {
            shared.set_away(true);
            return;
        }
    }
}
