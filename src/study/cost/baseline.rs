//! Plan of a cost study, and the baseline that all settings start from.

use cpu_time::ProcessTime;

use super::CostSetting;
use super::budget::{BUDGET_TARGETS, Quantity};
use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
use crate::fem::FemError;
use crate::joint::{AssemblyError, BallJoint};
use crate::pipeline::PipelineError;
use crate::scene::{Scene, SceneError};
use crate::study::StudyError;
use crate::study::pool::ThreadSpawnError;
use crate::study::response::ResponseError;

/// Plan of a cost study.
#[derive(Clone, Debug, PartialEq)]
pub struct CostPlan {
    /// The scene; tilt, load and rotation are fixed at their initial values.
    pub scene: Scene,
    /// The settings to vary.
    pub settings: Vec<CostSetting>,
    /// Repeats of each point, at least 1.
    pub repeats: usize,
    /// Maximum horizon, s.
    pub horizon: f64,
    /// Quantities of the error budget.
    pub quantities: Vec<Quantity>,
    /// Total relative errors for which the error budget chooses settings.
    pub targets: Vec<f64>,
    /// Factor on the settling and averaging times of the error budget: 1 for a vibration of some kHz.
    pub time_factor: f64,
}

impl CostPlan {
    /// All settings of a scene; one without the ball on a beam has no nodes, modes or elements to vary.
    pub fn new(scene: Scene) -> Self {
        let of_beam = |setting: &CostSetting| {
            matches!(
                setting,
                CostSetting::Nodes | CostSetting::Modes | CostSetting::Elements
            )
        };
        let beam = scene.ball_on_beam().is_ok();
        let joint = scene.joint().is_ok();
        let fits = |setting: &CostSetting| beam || !of_beam(setting);
        Self {
            scene: scene.without_analyses(),
            settings: CostSetting::ALL.into_iter().filter(fits).collect(),
            repeats: 5,
            // Enough periods; the small systems are slower.
            horizon: if joint { 4e-3 } else { 50e-3 },
            quantities: Quantity::DEFAULT.to_vec(),
            targets: BUDGET_TARGETS.to_vec(),
            time_factor: if joint { 1.0 } else { 3.0 },
        }
    }
}

/// Error of a cost study.
#[derive(Debug, thiserror::Error)]
pub enum CostError {
    /// The scene does not support the study.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's system cannot be built.
    #[error(transparent)]
    System(#[from] PipelineError),
    /// The joint cannot be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The body's modes cannot be computed.
    #[error(transparent)]
    Body(#[from] FemError),
    /// The settled motion cannot be computed.
    #[error("the settled motion, the baseline of all settings, cannot be computed")]
    Settled(#[from] ResponseError),
    /// The scene stays at rest.
    #[error(
        "the scene stays at rest, so there is no motion to compare; give it a kick (start.kick_mm_per_s)"
    )]
    AtRest,
    /// The linear modes cannot be computed.
    #[error(transparent)]
    Linear(#[from] StudyError),
    /// The reference solution failed.
    #[error("the reference solution failed: {0}")]
    NoReference(String),
    /// The integration failed.
    #[error(transparent)]
    Motion(#[from] DynamicsError),
    /// A complete run failed.
    #[error("a run failed")]
    Run(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// An analysis rejected the samples.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// No thread could be started.
    #[error(transparent)]
    ThreadSpawnError(#[from] ThreadSpawnError),
}

/// Baseline that all settings start from.
pub struct Baseline<'a> {
    pub plan: &'a CostPlan,
    /// Settled state `[q | dq/dt]`.
    pub state: Vec<f64>,
    /// Transient time before it, s.
    pub transient: f64,
    pub horizon: f64,
    pub ball: Option<BallJoint>,
}

/// Result of some work, and the median CPU time of all threads over repeated runs, s. With several runs,
/// one more comes first to warm up the caches and is not counted.
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
