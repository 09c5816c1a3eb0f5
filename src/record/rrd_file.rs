//! The end of a stream that is a file, written by a thread of its own.
//!
//! Rerun has a sink of its own for files, but once it has met a fault it only says that its thread has
//! ended, and half a message stays at the file's end. Here the fault keeps the system's own words, and
//! a file that cannot be written further breaks off between two messages, where every reader finds its way.
//! A disk that does not answer holds up nobody for longer than a stated time: only then is the thread left
//! behind.

use std::{
    fs::{File, OpenOptions},
    io,
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use rerun::{
    external::{
        re_build_info::CrateVersion,
        re_log_encoding::{EncodeError, Encoder, EncodingOptions},
    },
    log::LogMsg,
};

use super::stream::MessageSink;

/// Messages that may wait for the disk.
const WAITING: usize = 16;
/// How long a disk may take to do what is asked of it before it counts as stuck.
const PATIENCE: Duration = Duration::from_secs(20);

/// A recording that is being written into a file. Dropped, it gets its index, as far as it can be written.
#[derive(Debug)]
pub struct RrdFile {
    writer: ToRrdFile,
    thread: Option<JoinHandle<Result<(), String>>>,
}

/// Sends messages to the thread that writes a file.
#[derive(Clone, Debug)]
pub struct ToRrdFile {
    orders: Sender<Order>,
    /// The disk has not answered for too long.
    stuck: Arc<AtomicBool>,
}

/// What the thread is asked to do.
enum Order {
    Write(LogMsg),
    /// Answer when all before has been written.
    Flush(Sender<Result<(), String>>),
    /// Write the index, and end.
    Seal,
}

impl RrdFile {
    /// Writes what is sent from now on.
    ///
    /// # Errors
    /// What the system says if there is no thread to be had.
    pub fn start(writing: Writing) -> io::Result<Self> {
        let state = State::Writing(Box::new(writing));
        let (orders, asked) = bounded(WAITING);
        let thread = thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || write(state, &asked))?;
        let writer = ToRrdFile {
            orders,
            stuck: Arc::default(),
        };
        Ok(Self {
            writer,
            thread: Some(thread),
        })
    }

    /// Takes messages for the file.
    pub fn writer(&self) -> ToRrdFile {
        self.writer.clone()
    }

    /// Waits until all is written that was sent.
    ///
    /// # Errors
    /// Why it is not.
    pub fn flush(&self) -> Result<(), String> {
        let (done, answer) = bounded(1);
        self.writer.order(Order::Flush(done));
        if !self.writer.is_stuck() {
            match answer.recv_timeout(PATIENCE) {
                Ok(result) => return result,
                Err(RecvTimeoutError::Disconnected) => return Err("its thread ended".to_owned()),
                Err(RecvTimeoutError::Timeout) => self.writer.stuck.store(true, Ordering::Relaxed),
            }
        }
        Err(format!(
            "the disk has not answered for {} s",
            PATIENCE.as_secs()
        ))
    }

    /// Writes the index, after which nothing more is taken.
    ///
    /// # Errors
    /// Why the file is not whole.
    pub fn seal(&mut self) -> Result<(), String> {
        let flushed = self.flush();
        // A disk that has just answered takes as long over the index as its length needs.
        match self.thread.take_if(|_| !self.writer.is_stuck()) {
            Some(thread) => {
                self.writer.order(Order::Seal);
                let ended = thread.join();
                ended.unwrap_or_else(|_| Err("its thread panicked".to_owned()))
            }
            None => flushed,
        }
    }
}

impl Drop for RrdFile {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // Whoever drops it unsealed has an error of its own to report.
            let _ = self.seal();
        }
    }
}

impl ToRrdFile {
    fn is_stuck(&self) -> bool {
        self.stuck.load(Ordering::Relaxed)
    }

    fn order(&self, order: Order) {
        if !self.is_stuck()
            && matches!(self.orders.send_timeout(order, PATIENCE), Err(error) if error.is_timeout())
        {
            self.stuck.store(true, Ordering::Relaxed);
        }
    }
}

impl MessageSink for ToRrdFile {
    fn send(&self, message: LogMsg) {
        self.order(Order::Write(message));
    }
}

enum State {
    Writing(Box<Writing>),
    /// No message can be added any more, and why.
    Broken(String),
}

/// A file that is being written.
pub struct Writing {
    encoder: Encoder<File>,
    /// The same file, to cut off what a failed write leaves of a message.
    file: File,
    /// Bytes of whole messages.
    whole: u64,
}

/// Does what is asked until the last order, or until nobody is left who could ask; why the file is not whole.
fn write(mut state: State, orders: &Receiver<Order>) -> Result<(), String> {
    for order in orders {
        let sealed = matches!(order, Order::Seal);
        if let State::Writing(writing) = &mut state {
            let written = match &order {
                Order::Write(message) => writing.append(message),
                Order::Flush(_) => Ok(()),
                Order::Seal => writing.encoder.finish(),
            };
            if let Err(fault) = written {
                state = writing.broken(&fault);
            }
        }
        let result = match &state {
            State::Writing(_) => Ok(()),
            State::Broken(reason) => Err(reason.clone()),
        };
        if sealed {
            return result;
        }
        if let Order::Flush(done) = order {
            // Whoever asked may have lost its patience meanwhile.
            let _ = done.send(result);
        }
    }
    Ok(())
}

impl Writing {
    /// Begins a recording in a file that is there and empty.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).open(path)?;
        let encoder = Encoder::new_eager(
            CrateVersion::LOCAL,
            EncodingOptions::PROTOBUF_COMPRESSED,
            file.try_clone()?,
        )
        .map_err(|fault| match fault {
            EncodeError::Write(source) => source,
            other => io::Error::other(other),
        })?;
        let whole = file.metadata()?.len();
        Ok(Self {
            encoder,
            file,
            whole,
        })
    }

    fn append(&mut self, message: &LogMsg) -> Result<(), EncodeError> {
        self.whole += self.encoder.append(message)?;
        Ok(())
    }

    /// Gives up, with whole messages only.
    fn broken(&mut self, fault: &EncodeError) -> State {
        // The encoder adds an index when it is dropped, which would come after the gap.
        self.encoder.do_not_emit_footer();
        let cut = self.file.set_len(self.whole);
        let said = match fault {
            EncodeError::Write(source) => source.to_string(),
            other => other.to_string(),
        };
        State::Broken(match cut {
            Ok(()) => said,
            Err(uncut) => format!("{said}, and its last message is torn: {uncut}"),
        })
    }
}
