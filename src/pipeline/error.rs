//! What can end a run early.

use super::SinkError;
use super::analyse::AnalyseError;
use super::outlet::RecorderGone;
use crate::dynamics::DynamicsError;
use crate::joint::{AssemblyError, StabilityError};
use crate::scene::SceneError;

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The scene does not run what is needed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The joint cannot be assembled.
    #[error("the joint cannot be assembled")]
    Assembly(#[from] AssemblyError),
    /// The growth rates that a lesson compares with cannot be computed.
    #[error("the growth rates for the scene's mechanism cannot be computed")]
    Stability(#[from] StabilityError),
    /// A fixed step is too long for the fastest motion of the system, contact and friction included.
    #[error(
        "a fixed step of {step_us} us is unstable for the fastest motion about the start: choose \
         time.max_step_us below {limit_us:.3}, or an adaptive method"
    )]
    Step {
        /// The step, us.
        step_us: f64,
        /// The longest stable one, us.
        limit_us: f64,
    },
    /// The integration failed.
    #[error("the simulation stopped")]
    Dynamics(#[from] DynamicsError),
    /// An analysis failed.
    #[error("an analysis stopped")]
    Analysis(#[from] AnalyseError),
    /// A record could not be kept.
    #[error("the recording stopped")]
    Sink(#[source] SinkError),
    /// The recorder went away before the others; its own error is reported instead.
    #[error(transparent)]
    RecorderGone(#[from] RecorderGone),
    /// The windows of the analyses do not fit into memory.
    #[error(
        "the windows of the analyses take about {megabytes} MB, which the system refuses; choose shorter \
         windows (analysis.*.window_ms) or a lower time.sample_rate_khz, or raise the limit of memory"
    )]
    Memory {
        /// What they take, MB.
        megabytes: u64,
    },
    /// A thread could not be started.
    #[error("the thread `{name}` cannot be started; free some memory or raise the process limit")]
    Thread {
        /// Name of the thread.
        name: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A thread panicked: a fault of this program.
    #[error("the thread `{name}` panicked: {message}; please report this, with the scene")]
    Panic {
        /// Name of the thread.
        name: &'static str,
        /// What it said.
        message: String,
    },
}
