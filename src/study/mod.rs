//! Studies: many simulations of one scene.

pub mod basins;
pub mod branch;
pub mod cost;
pub mod friction_fit;
pub mod lyapunov;
pub mod paper;
mod pool;
pub mod response;
pub mod signal;
mod stability;
mod subject;
pub mod sweep;
#[cfg(feature = "table")]
mod table;

use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
pub use crate::dynamics::Stopped;
use crate::dynamics::equilibrium::EquilibriumError;
use crate::joint::AssemblyError;
use crate::pipeline::PipelineError;
use crate::scene::SceneError;
pub use pool::threads;
pub use stability::{ModesAt, StabilityAt, StabilityResult, stability};
pub use subject::{Subject, Trial};

/// Receives the progress of a study: the share of the work that is done, 0 to 1, and the task. It stops the study with an
/// error.
pub type OnProgress<'a> = &'a mut dyn FnMut(f64, &str) -> Result<(), Stopped>;

/// Called regularly during work of unknown duration; an error stops the work.
pub type StopCheck<'a> = &'a mut dyn FnMut() -> Result<(), Stopped>;

/// Samples of a run between two calls of its progress.
const POLL: u64 = 16;

/// Why a study has no result. A variant that only passes on its cause shows the message of the cause and keeps it as its
/// source, so that callers find it.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A value of a parameter, or a setting, is invalid.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// The system cannot be built or run.
    #[error("{0}")]
    Pipeline(#[from] PipelineError),
    /// The joint cannot be assembled.
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
    /// The equilibrium cannot be found or analysed.
    #[error("{0}")]
    Equilibrium(#[from] EquilibriumError),
    /// An integration failed.
    #[error("{0}")]
    Dynamics(#[from] DynamicsError),
    /// An analysis rejected the samples.
    #[error("the settled motion cannot be analysed")]
    Analysis(#[from] AnalysisError),
    /// No periodic orbit can be found at a start; why.
    #[error("{0}")]
    NoOrbit(String),
    /// The run reached `max_rhs_evals` right-hand-side evaluations.
    #[error(
        "stopped after {rhs_evals} right-hand-side evaluations at {:.3} ms: the motion needs very small time \
         steps",
        1e3 * time
    )]
    TooManyEvaluations {
        /// Evaluations so far.
        rhs_evals: u64,
        /// Simulated time reached, s.
        time: f64,
    },
    /// The scene of a cost study stays at rest.
    #[error(
        "the scene stays at rest, so there is no motion to compare; give it a kick (start.kick_mm_per_s), or choose a \
         scene that squeaks"
    )]
    AtRest,
    /// A complete run failed.
    #[error("a run failed")]
    Run(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// No thread could be started.
    #[error("cannot start a thread ({0}); raise the process limit (ulimit -u) or free some memory")]
    Threads(String),
    /// The caller stopped it.
    #[error("stopped")]
    Stopped(#[from] Stopped),
}
