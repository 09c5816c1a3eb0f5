//! A run that is steered while it goes on, and the page that shows it.
//!
//! ```text
//!               orders                    records
//!  page, keys ----------> Session: run -----------> Hub ----> web viewers
//!       ^                    |                       Ear ----> listeners
//!       +------ Panel -------+---- Board             Recorder -> files
//! ```
//!
//! * [`Session`] runs one scene after another, checks what is asked for and carries it out.
//! * [`Hub`] keeps what a viewer needs that comes late; nobody who watches ever holds up the run.
//! * [`Page`] is what is served: a control panel beside Rerun's web viewer, on this machine alone unless asked.
//!
//! Every thing that is asked for becomes an event on the timeline of the recording.

mod bands;
mod command;
mod ear;
mod flow;
mod hub;
mod panel;
mod recorder;
mod running;
mod screen;
mod server;
mod session;

pub use bands::Bands;
pub use command::{Command, HARD, KICKS, PACES, Refused};
pub use ear::Ear;
pub use hub::{Bytes, Hub, Name, News, Ticket};
pub use panel::{Event, Panel};
pub use recorder::SavedFile;
pub use running::Running;
pub use server::{Page, Serving, bind};
pub use session::{Plan, Session, Watcher};
