//! Errors of recordings.

use std::io;
use std::path::PathBuf;

/// An error of a recording: what failed, where, and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// No output is configured.
    #[error(
        "no output for the recording: save it to a file, connect to a viewer, or start a viewer"
    )]
    NoOutput,
    /// The file at a path cannot be created.
    #[error("cannot write a recording at {}; choose a writable folder with free space (an existing file there is unchanged)", .0.display())]
    Create(PathBuf, #[source] io::Error),
    /// Not enough address space. The Rerun SDK would abort the program instead of returning an error.
    #[error(
        "a recording needs {} MB of address space, which the system does not grant; raise the limit (`ulimit -v`), \
         or omit the recording (`run --npz FILE` writes the samples only)",
        super::ADDRESS_SPACE >> 20
    )]
    Memory,
    /// The thread that writes the file at a path cannot be started.
    #[error("cannot start the thread that writes the recording at {}; raise the limit of processes (`ulimit -u`) or free memory", .0.display())]
    Thread(PathBuf, #[source] io::Error),
    /// Writing the file failed.
    #[error("cannot write the recording for {}: {reason}; free some space or choose another path (the part written so far can be opened: {}; an existing recording is unchanged)", path.display(), part.display())]
    Write {
        /// Path of the recording.
        path: PathBuf,
        /// Path of the incomplete recording.
        part: PathBuf,
        /// Reason of the failure.
        reason: String,
    },
    /// The part file was removed while it was being written.
    #[error("the recording for {} is lost: {} was removed or moved while it was being written; run again with a folder that is not modified", path.display(), part.display())]
    Removed {
        /// Path of the recording.
        path: PathBuf,
        /// Former path of the incomplete recording.
        part: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The complete recording cannot be renamed.
    #[error("the recording is complete, but cannot be moved from {} to {}; move it manually", part.display(), path.display())]
    Rename {
        /// Path of the recording.
        path: PathBuf,
        /// Path of the complete recording.
        part: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The viewer address is invalid: address and reason.
    #[error(
        "`{0}` is not a viewer address ({1}); an example is {example}",
        example = crate::record::sdk::DEFAULT_CONNECT_URL
    )]
    Address(String, String),
    /// The viewer program cannot be started, with the reason.
    #[error("cannot start the Rerun viewer: {0}; install it with `pip install rerun-sdk=={version}` or `cargo install rerun-cli --version {version} --locked` so that `rerun` is on the PATH, or save to a file", version = super::RERUN_VERSION)]
    Spawn(String),
    /// No viewer answers at the start: address and reason.
    #[error("no viewer at {0}: {1}; start one with `rerun`, or save to a file")]
    Viewer(String, String),
    /// The viewer at an address disconnected or does not respond, and no file is saved.
    #[error(
        "the viewer at {0} was closed or does not respond, and no file is saved; start the viewer with `rerun` and run again, or add --save FILE: the run then continues without a viewer and sends all data when it reconnects"
    )]
    ViewerLost(String),
    /// Data that cannot be encoded.
    #[error("cannot encode the recording: {0}; this is a bug, please report it")]
    Encode(String),
    /// A record before the header.
    #[error("a record arrived before the header; send the header first")]
    NoHeader,
}
