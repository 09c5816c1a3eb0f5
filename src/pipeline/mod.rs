//! The road from simulation to record, and the threads of a run.

mod along;
mod analyse;
mod computed;
mod course;
mod error;
#[cfg(test)]
mod flow_tests;
mod health;
pub mod message;
mod outlet;
mod outline;
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
mod steer;
#[cfg(test)]
mod stop_tests;
mod twin;

pub use analyse::{AnalyseError, Analyser};
pub use error::PipelineError;
pub use outlet::RecorderGone;
pub use pending::{KICKS_A_FRAME, Pending, TooManyKicks};
pub use playback::Playback;
pub use prepare::{Prepared, initial_state, prepare, prepare_on};
// The command line takes the live runs along.
#[cfg(feature = "live")]
pub(crate) use run::panic_message;
pub use run::{Monitor, drive, run};
pub use simulate::Simulation;
pub use sink::{Delivery, Sink, SinkError, Tee};
pub use small::SmallSimulation;
pub use source::{Source, Steerable, source, steerable};
pub use steer::{Gait, Helm, Order, Steered};
