//! The road from simulation to record, and the threads of a run.

mod along;
mod analyse;
mod computed;
mod error;
#[cfg(test)]
mod flow_tests;
mod health;
#[cfg_attr(
    not(feature = "live"),
    allow(dead_code, reason = "only a live run thins pictures out by time")
)]
mod latest;
pub mod message;
mod outlet;
mod pending;
mod playback;
mod prepare;
mod run;
mod simulate;
mod sink;
mod small;
#[cfg(test)]
mod small_tests;
mod source;
mod stages;
mod start;
mod steer;
#[cfg(test)]
mod stop_tests;
mod twin;

pub use analyse::Analyser;
pub use error::{AnalyseError, PipelineError, RecorderGone};
pub use pending::{KICKS_A_FRAME, Order, Pending, TooManyKicks};
pub use playback::Playback;
pub use prepare::{Prepared, initial_state, prepare, prepare_on};
// The command line takes the live runs along.
#[cfg(feature = "live")]
pub(crate) use latest::Latest;
#[cfg(feature = "live")]
pub(crate) use run::panic_message;
pub use run::{Monitor, drive, run};
pub use simulate::Simulation;
pub use sink::{Delivery, Sink, SinkError, Tee};
pub use small::SmallSimulation;
pub use source::{Source, Steerable};
#[cfg(test)]
pub(crate) use stages::synthetic_tests::header as synthetic_header;
pub use start::{source, steerable};
pub use steer::{Gait, Helm, Steered};
