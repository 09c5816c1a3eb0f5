//! The road from simulation to record, and the only threads.

pub mod message;
mod sink;

pub use sink::{Delivery, Sink, SinkError};
