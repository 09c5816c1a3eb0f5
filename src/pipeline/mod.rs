//! Threads, channels and messages of one run, from the simulation to the sinks.

mod analyse;
mod budget;
#[cfg(test)]
mod control_tests;
mod endpoints;
mod error;
mod health;
mod interactive;
mod joint_body;
pub mod lesson;
pub mod message;
mod motion_changes;
mod prepare;
mod result;
mod run;
mod sensitivity;
#[cfg(test)]
mod sensitivity_tests;
mod signal_source;
mod simulate;
mod small_body;
#[cfg(test)]
mod small_tests;
mod stages;
#[cfg(test)]
mod stop_tests;

pub use analyse::Analyser;
pub use endpoints::{Sink, SinkError, Source, Tee};
pub use error::PipelineError;
pub use motion_changes::ChangeDetector;
pub use prepare::{Prepared, initial_state, prepare};
pub use signal_source::SignalSource;
// Only a live run of the command line uses these.
#[cfg(feature = "live")]
pub(crate) use interactive::lock;
pub use interactive::{
    InteractiveSource, MAX_KICKS_PER_FRAME, RunCommand, RunHandle, RunState, RunStatus,
    TooManyKicks,
};
pub use result::{Audit, RunResult};
pub use run::{Monitor, drive, run};
#[cfg(feature = "live")]
pub(crate) use run::{joined, panic_message};
pub use simulate::Simulation;
#[cfg(test)]
pub(crate) use stages::synthetic_tests::header as synthetic_header;
