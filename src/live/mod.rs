//! Interactive runs and the web page that controls and displays them.
//!
//! ```text
//!               commands                  records
//!  page, keys ----------> Session: run -----------> ViewStore -> the page's own views
//!       ^                    |                     Hub ----> web viewers
//!       |                    |                     AudioStream -> listeners
//!       +------ Panel -------+-- StatusStore         Recorder -> files
//! ```
//!
//! * [`Session`] runs one scene after another, and validates and applies commands.
//! * [`ViewStore`] holds the present picture of the run; each client takes what is new as often as it can draw.
//! * [`Hub`] stores the data that a viewer needs when it connects. A slow viewer never delays the run.
//! * [`Page`] serves controls, views, and on request Rerun's web viewer, by default only to this machine.
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
mod tour;
mod views;

pub use audio::AudioStream;
pub use bands::{RegimeBands, RegimeRow};
pub use command::{Command, HARD_KICK, KICK_RANGE, Rejected, SPEED_RANGE};
pub use hub::{Bytes, Hub, Name, Subscription, Update};
pub use panel::{Event, Panel};
pub use recorder::SavedFile;
pub use server::{BoundListener, Page, PageContent, bind};
pub use session::{Session, SessionOptions, ViewTarget};
pub use session_thread::SessionThread;
pub use tour::{Tour, TourError, TourQuantity, TourStep, TourView};
pub use views::{ViewCursor, ViewStore};
