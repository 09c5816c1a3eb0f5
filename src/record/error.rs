//! What can go wrong with a recording.

use std::path::PathBuf;

/// The error of a recording: what, where, and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// Nowhere to record to.
    #[error(
        "nothing to record to: give a file to save, a viewer's address, or ask for a viewer to be started"
    )]
    NoOutput,
    /// The file cannot be made.
    #[error("cannot write a recording at {}; choose a writable folder that has space (an existing file there is untouched)", path.display())]
    Create {
        /// The recording asked for.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Too little memory for the SDK, which has no error for that: it ends the program.
    #[error(
        "a recording needs {} MB of address space, which the system refuses; raise the limit (`ulimit -v`), or \
         leave the recording out (`run --npz FILE` writes the samples alone)",
        super::ADDRESS_SPACE >> 20
    )]
    Memory,
    /// The thread that writes the file cannot be started.
    #[error("cannot start the thread that writes the recording at {}; raise the limit of processes (ulimit -u) or free some memory", path.display())]
    Thread {
        /// The recording asked for.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Writing failed along the way.
    #[error("cannot go on writing the recording for {}: {reason}; free some space or choose another place (what was written so far can be opened: {}; the old file, if any, is untouched)", path.display(), part.display())]
    Write {
        /// The recording asked for.
        path: PathBuf,
        /// Where the unfinished recording is.
        part: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The file was taken away while it was being written.
    #[error("the recording for {} is lost: {} was removed or moved while it was being written; run again into a folder that stays", path.display(), part.display())]
    Gone {
        /// The recording asked for.
        path: PathBuf,
        /// Where the unfinished recording was.
        part: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The finished recording cannot take its place.
    #[error("the recording is whole, but cannot be moved from {} to {}; move it by hand", part.display(), path.display())]
    Rename {
        /// The recording asked for.
        path: PathBuf,
        /// Where the finished recording is.
        part: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The viewer's address cannot be read.
    #[error(
        "`{url}` is no viewer address ({reason}); one looks like {}",
        rerun::DEFAULT_CONNECT_URL
    )]
    Address {
        /// The address given.
        url: String,
        /// Why not.
        reason: String,
    },
    /// No viewer program.
    #[error("cannot start the Rerun viewer: {reason}; install it with `pip install rerun-sdk=={version}` or `cargo install rerun-cli --version {version} --locked` so that `rerun` is on the PATH, or save to a file instead", version = super::RERUN_VERSION)]
    Spawn {
        /// Why not.
        reason: String,
    },
    /// The viewer does not answer at the start.
    #[error("no viewer at {url}: {reason}; start one with `rerun`, or save to a file instead")]
    Viewer {
        /// Its address.
        url: String,
        /// What happened.
        reason: String,
    },
    /// The viewer has gone or is stuck, and there is no file.
    #[error(
        "the viewer at {url} was closed or takes nothing any more, and nothing was saved; start it with `rerun` and run again, or add --save FILE: then the run goes on, and a viewer that is back is sent everything"
    )]
    ViewerGone {
        /// Its address.
        url: String,
    },
    /// Data that do not fit the format.
    #[error("cannot encode the recording: {0}; this is a fault of the program, please report it")]
    Encode(String),
    /// Records in the wrong order.
    #[error("a record came before the header; the sender must send the header first")]
    NoHeader,
}

impl From<rerun::log::ChunkError> for RecordError {
    fn from(error: rerun::log::ChunkError) -> Self {
        Self::Encode(error.to_string())
    }
}

impl From<rerun::SerializationError> for RecordError {
    fn from(error: rerun::SerializationError) -> Self {
        Self::Encode(error.to_string())
    }
}
