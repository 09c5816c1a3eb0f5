//! Errors that end a run.

use super::sink::SinkError;
use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
use crate::joint::{AssemblyError, StabilityError};
use crate::scene::SceneError;

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The scene does not contain the required subject.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The joint cannot be assembled.
    #[error("cannot assemble the joint")]
    Assembly(#[from] AssemblyError),
    /// The growth rates of the linearised joint, with which a lesson compares its measurements, cannot be
    /// computed.
    #[error("cannot compute the growth rates for the scene's mechanism")]
    Stability(#[from] StabilityError),
    /// A fixed step is too long for the fastest motion of the linearised system, including contact and
    /// friction.
    #[error(
        "a fixed step of {step_us} us is unstable for the fastest motion near the initial state: set \
         time.max_step_us below {limit_us:.3}, or choose an adaptive method"
    )]
    Step {
        /// Step size, us.
        step_us: f64,
        /// Longest stable step size, us.
        limit_us: f64,
    },
    /// The integration failed.
    #[error("the simulation failed")]
    Dynamics(#[from] DynamicsError),
    /// An analysis failed.
    #[error("an analysis failed")]
    Analysis(#[from] AnalyseError),
    /// A sink could not store a record.
    #[error("the recording failed")]
    Sink(#[source] SinkError),
    /// The windows of the analyses do not fit into memory.
    #[error(
        "the analysis windows need about {megabytes} MB, which the system does not grant; choose shorter \
         windows (analysis.*.window_ms) or a lower time.sample_rate_khz, or raise the memory limit"
    )]
    Memory {
        /// Memory needed, MB.
        megabytes: u64,
    },
    /// A thread could not be started.
    #[error("cannot start the thread `{name}`; free some memory or raise the process limit")]
    Thread {
        /// Name of the thread.
        name: &'static str,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A thread panicked, which is a bug of this program.
    #[error(
        "the thread `{name}` panicked: {message}; please report this bug together with the scene"
    )]
    Panic {
        /// Name of the thread.
        name: &'static str,
        /// Message of the panic.
        message: String,
    },
}

/// Error of the analysis thread.
#[derive(Debug, thiserror::Error)]
pub enum AnalyseError {
    /// A frame does not start where the one before it ended.
    #[error(
        "frame {index} starts at {found} s with a sample spacing of {dt} s, but sample {sample} of the run \
         is expected at {due} s; frames must be contiguous and have the sample rate of the header"
    )]
    Gap {
        /// Index of the frame.
        index: u64,
        /// Start time of the frame, s.
        found: f64,
        /// Sample spacing of the frame, s.
        dt: f64,
        /// Index of the expected first sample, counted from the first sample of the run.
        sample: u64,
        /// Time of that sample, s.
        due: f64,
    },
    /// A window of the scene is too short for its analysis.
    #[error("analysis of the probe signal: {0}")]
    Signal(#[from] AnalysisError),
    /// The sink did not accept a record.
    #[error("cannot store a record: {0}")]
    Sink(#[source] SinkError),
}
