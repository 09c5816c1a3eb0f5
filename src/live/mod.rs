//! Interactive runs and the web page that controls and displays them.
//!
//! ```text
//!            commands                  records
//!  page -----------------> Session: run -----------> ViewStore -> the views of the page
//!    ^                       |                       AudioSink -> listeners
//!    +-------- Panel --------+-- StatusStore         Recorder -> files
//! ```
//!
//! * [`Session`] runs one scene after another, and validates and applies commands.
//! * [`ViewStore`] holds the present picture of the run; each client takes what is new as often as it can draw.
//! * [`Page`] serves controls and views, by default only to this machine.
//!
//! Every command becomes an event on the timeline of the recording.

mod audio;
mod command;
mod diagram;
mod panel;
mod recorder;
mod server;
mod session;
mod tour;
mod views;

pub use command::{Command, HARD_KICK, KICK_RANGE, Promise, Rejected, SPEED_RANGE};
pub use panel::{Event, Panel};
pub use recorder::SavedFile;
pub use server::{Limits, Page, bind};
pub use session::{Session, SessionOptions};
pub use tour::{Tour, TourError, TourQuantity, TourStep, TourView};
pub use views::{ViewCursor, ViewStore};

#[cfg(test)]
mod frames_tests;

use crate::pipeline::lock;
