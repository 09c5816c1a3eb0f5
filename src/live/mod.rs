//! Interactive runs and the web page that controls and displays them.
//!
//! ```text
//!               commands                  records
//!  page, keys ----------> Session: run -----------> Hub ----> web viewers
//!       ^                    |                     AudioStream -> listeners
//!       +------ Panel -------+-- StatusStore         Recorder -> files
//! ```
//!
//! * [`Session`] runs one scene after another, and validates and applies commands.
//! * [`Hub`] stores the data that a viewer needs when it connects. A slow viewer never delays the run.
//! * [`Page`] serves a control panel next to Rerun's web viewer, by default only to this machine.
//!
//! Every command becomes an event on the timeline of the recording.

mod audio;
mod bands;
mod command;
mod diagram;
mod flow_control;
mod hub;
mod panel;
mod recorder;
mod server;
mod session;
mod session_thread;
mod throttled_sink;

pub use audio::AudioStream;
pub use bands::RegimeBands;
pub use command::{Command, HARD_KICK, KICK_RANGE, Rejected, SPEED_RANGE};
pub use hub::{Bytes, Hub, Name, Subscription, Update};
pub use panel::{Event, Panel};
pub use recorder::SavedFile;
pub use server::{BoundListener, Page, bind};
pub use session::{Session, SessionOptions, ViewTarget};
pub use session_thread::SessionThread;
