//! Errors that end a run.

use super::endpoints::SinkError;
use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
use crate::dynamics::equilibrium::EquilibriumError;
use crate::joint::AssemblyError;
use crate::scene::SceneError;

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The scene does not contain the required subject.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// The joint cannot be assembled.
    #[error("cannot assemble the joint")]
    Assembly(#[from] AssemblyError),
    /// The growth rates of the linearised joint, with which a lesson compares its measurements, cannot be
    /// computed.
    #[error("cannot compute the growth rates for the scene's mechanism")]
    Stability(#[from] EquilibriumError),
    /// A fixed step is too long for the fastest motion of the linearised system, including contact and
    /// friction.
    #[error(
        "a fixed step of {step_us} µs is unstable for the fastest motion near the initial state: set \
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
    /// A window is too short for its analysis.
    #[error("an analysis of the probe signal failed")]
    Analysis(#[from] AnalysisError),
    /// A sink could not store a record.
    #[error("the recording failed")]
    Sink(#[from] SinkError),
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
