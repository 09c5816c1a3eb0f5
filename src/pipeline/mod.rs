//! The road from simulation to record, and the only threads.

mod analyse;
pub mod message;
mod sink;
mod stages;

pub use analyse::{AnalyseError, Analyser};
pub use sink::{Sink, SinkError};
