//! How a study is done, and what all knobs start from.

use cpu_time::ProcessTime;

use super::Knob;
use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
use crate::fem::FemError;
use crate::joint::{AssemblyError, BallJoint};
use crate::pipeline::PipelineError;
use crate::scene::{Scene, SceneError};
use crate::study::pool::NoThread;
use crate::study::response::ResponseError;

/// How a study is done.
#[derive(Clone, Debug, PartialEq)]
pub struct CostPlan {
    /// The scene, held at its first tilt, load and rotation.
    pub scene: Scene,
    /// The knobs to turn.
    pub knobs: Vec<Knob>,
    /// Runs of each setting, 1 or more.
    pub repeats: usize,
    /// The longest horizon, s.
    pub horizon: f64,
}

impl CostPlan {
    /// All knobs of a scene; one without ball and beam has no nodes, modes and elements to choose.
    pub fn new(scene: Scene) -> Self {
        let of_beam = |knob: &Knob| matches!(knob, Knob::Nodes | Knob::Modes | Knob::Elements);
        let beam = scene.ball_on_beam().is_ok();
        let joint = scene.joint().is_ok();
        Self {
            scene: scene.without_analyses(),
            knobs: Knob::ALL
                .into_iter()
                .filter(|knob| beam || !of_beam(knob))
                .collect(),
            repeats: 5,
            // A good number of periods: small systems are slow.
            horizon: if joint { 4e-3 } else { 50e-3 },
        }
    }
}

/// Why a study cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum CostError {
    /// The scene does not go with it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's system cannot be made.
    #[error(transparent)]
    System(#[from] PipelineError),
    /// The joint cannot be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The body's modes cannot be found.
    #[error(transparent)]
    Body(#[from] FemError),
    /// The settled motion cannot be found.
    #[error("the settled motion that all settings start from cannot be found")]
    Settled(#[from] ResponseError),
    /// Nothing moves.
    #[error(
        "the scene stays at rest, so that there is no motion to compare; give it a kick (start.kick_mm_per_s)"
    )]
    AtRest,
    /// The reference cannot be integrated.
    #[error("the reference cannot be integrated: {0}")]
    NoReference(String),
    /// The settled motion cannot be followed.
    #[error(transparent)]
    Motion(#[from] DynamicsError),
    /// A whole run has failed.
    #[error("a run has failed")]
    Run(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// An analysis does not take the samples.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// There are no threads to measure with.
    #[error(transparent)]
    NoThread(#[from] NoThread),
}

/// What all knobs start from.
pub struct Ground<'a> {
    pub plan: &'a CostPlan,
    /// The settled state `[q | dq/dt]`.
    pub state: Vec<f64>,
    pub horizon: f64,
    pub ball: Option<BallJoint>,
}

/// Result of some work, and the median of the CPU time of all threads over repeated runs, s. Where there
/// are several, one more comes first, which finds the caches cold and is not counted.
pub fn timed<T>(repeats: usize, mut work: impl FnMut() -> T) -> (T, f64) {
    let mut times = Vec::new();
    let mut once = || {
        let began = ProcessTime::now();
        let result = work();
        times.push(began.elapsed().as_secs_f64());
        result
    };
    let mut result = once();
    for _ in 1..repeats {
        result = once();
    }
    if repeats > 1 {
        result = once();
        times.remove(0);
    }
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    let median = match times.len() % 2 {
        0 => 0.5 * (times[middle - 1] + times[middle]),
        _ => times[middle],
    };
    (result, median)
}
