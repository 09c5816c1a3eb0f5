//! What accuracy costs: work-precision sets, and the advice that follows.
//!
//! Each knob of a scene is turned with all others at their reference, and the error is set against the
//! work: CPU time (medians of repeated runs; all threads together, so that what runs on many cores is not
//! told as cheap) and calls of the right-hand side, which are free of noise. The error of the reference
//! itself is the floor of a set. What fails is a point, too.
//!
//! Errors of a trajectory make sense only up to a horizon that the largest Lyapunov exponent allows
//! ([`CostStudy::horizon`]); beyond it, what does not depend on the trajectory is compared.

mod advice;
mod averages;
mod body;
mod modes;
mod trajectory;

#[cfg(test)]
mod tests;

use cpu_time::ProcessTime;
use serde::{Serialize, Serializer};

use super::pool::NoThread;
use super::response::{From, ResponseError, ResponsePlan, response};
use crate::analysis::AnalysisError;
use crate::dynamics::{DynamicsError, Exponent};
use crate::fem::FemError;
use crate::joint::{AssemblyError, BallJoint};
use crate::pipeline::PipelineError;
use crate::scene::{Held, Scene, SceneError};
pub use advice::{Advice, TARGETS, advice};
use averages::{exponent_sets, invariant_sets, recurrence_sets};
use body::element_sets;
use modes::mode_sets;
use trajectory::{event_sets, integrator_sets, node_sets};

/// What can be turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(into = "KnobRecord")]
#[strum(serialize_all = "lowercase")]
pub enum Knob {
    /// Method and tolerance, by the trajectory.
    Integrator,
    /// Tolerance, by what does not depend on the trajectory.
    Invariants,
    /// Through events or exactly there.
    Events,
    /// Family and number of contact nodes.
    Nodes,
    /// Number of modes.
    Modes,
    /// Order and size of the finite elements.
    Elements,
    /// Length of averaging for Lyapunov exponents.
    Exponents,
    /// Length and threshold of recurrence quantification.
    Recurrence,
}

/// A knob as JSON has it.
#[derive(Serialize)]
struct KnobRecord {
    knob: &'static str,
    error_is: &'static str,
}

impl std::convert::From<Knob> for KnobRecord {
    fn from(knob: Knob) -> Self {
        Self {
            knob: knob.name(),
            error_is: knob.error(),
        }
    }
}

impl Knob {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Integrator,
        Self::Invariants,
        Self::Events,
        Self::Nodes,
        Self::Modes,
        Self::Elements,
        Self::Exponents,
        Self::Recurrence,
    ];

    /// Its name, as on the command line.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What the error of its points is.
    pub fn error(self) -> &'static str {
        match self {
            Self::Integrator | Self::Events | Self::Nodes => "largest error of the state",
            Self::Modes | Self::Invariants => "relative error",
            Self::Elements => "largest error of a natural frequency",
            Self::Exponents => "half width of λ1, 1/s",
            Self::Recurrence => "error of the determinism",
        }
    }
}

/// A knob turned through a family of settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostSet {
    /// The knob.
    #[serde(flatten)]
    pub knob: Knob,
    /// The settings' family: a method, a quadrature, a threshold.
    pub family: String,
    /// What is turned within it: `tolerance`, `nodes`.
    pub turned: &'static str,
    /// The error of the reference itself; `None` where there is none to compare with.
    #[serde(rename = "reference_error")]
    pub floor: Option<f64>,
    /// The points.
    pub points: Vec<CostPoint>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostPoint {
    /// The setting, in the unit of [`CostSet::turned`].
    pub value: f64,
    /// CPU time, s: the median of the repeated runs.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Calls of the right-hand side; 0 where there are none.
    pub calls: u64,
    /// Its error, or why there is none.
    #[serde(flatten, serialize_with = "error_or_reason")]
    pub error: Result<f64, String>,
    /// What its value does not tell: which modes these are, how many events there were. Empty where that
    /// is nothing.
    pub detail: String,
}

/// The error, or why there is none, as JSON has it.
fn error_or_reason<S: Serializer>(
    error: &Result<f64, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record<'a> {
        error: Option<f64>,
        failed: Option<&'a String>,
    }
    let (error, failed) = (error.as_ref().ok().copied(), error.as_ref().err());
    Record { error, failed }.serialize(serializer)
}

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

/// What it came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostStudy {
    /// Name of the scene.
    pub scene: String,
    /// Where it was held, of what varies in the scene.
    pub held: Held,
    /// Time over which trajectories are compared, s.
    #[serde(rename = "horizon_s")]
    pub horizon: f64,
    /// The largest Lyapunov exponent, 1/s, by which the horizon was chosen.
    #[serde(rename = "exponent_per_s")]
    pub exponent: Option<Exponent>,
    /// The sets, knob by knob.
    pub sets: Vec<CostSet>,
    /// The cheapest setting of the integrator for each error.
    pub advice: Vec<Advice>,
    /// Whether it was told to stop: then the knobs that were not done are missing.
    pub stopped: bool,
}

/// Is told which knob is turned and the share of all work that is done, and answers whether to go on.
pub type Watch<'a> = &'a mut dyn FnMut(Knob, f64) -> bool;

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
struct Ground<'a> {
    plan: &'a CostPlan,
    /// The settled state `[q | dq/dt]`.
    state: Vec<f64>,
    horizon: f64,
    ball: Option<BallJoint>,
}

/// Turns all knobs of a plan, on the caller's thread alone, so that times can be compared. If `watch` says
/// no, what is done by then; `None` if that is nothing.
///
/// # Errors
/// If there is no settled motion or no reference to compare with.
pub fn cost(plan: &CostPlan, watch: Watch<'_>) -> Result<Option<CostStudy>, CostError> {
    let first = plan.knobs.first().copied().unwrap_or(Knob::Integrator);
    let mut ball = None;
    let look = ResponsePlan {
        exponents: 1,
        portrait: false,
        most: 0.4,
        measure: 0.1,
        ..ResponsePlan::default()
    };
    let goes_on = &mut |_| watch(first, 0.0);
    let Some(settled) = response(&plan.scene, From::Cold, &look, &mut ball, goes_on)? else {
        return Ok(None);
    };
    if settled.state.iter().all(|x| *x == 0.0) {
        return Err(CostError::AtRest);
    }
    let exponent = settled
        .exponents
        .and_then(|spectrum| spectrum.exponents.first().copied());
    let mut ground = Ground {
        plan,
        state: settled.state,
        horizon: horizon(plan.horizon, exponent),
        ball,
    };
    let (mut sets, mut stopped) = (Vec::new(), false);
    for (done, &knob) in plan.knobs.iter().enumerate() {
        let share = |part: f64| (done as f64 + part) / plan.knobs.len() as f64;
        let goes_on = &mut |part: f64| watch(knob, share(part));
        let turned = match knob {
            Knob::Integrator => integrator_sets(&mut ground, goes_on)?,
            Knob::Invariants => invariant_sets(&mut ground, goes_on)?,
            Knob::Events => event_sets(&mut ground, goes_on)?,
            Knob::Nodes => node_sets(&mut ground, goes_on)?,
            Knob::Modes => mode_sets(&mut ground, goes_on)?,
            Knob::Elements => element_sets(&mut ground, goes_on)?,
            Knob::Exponents => exponent_sets(&mut ground, goes_on)?,
            Knob::Recurrence => recurrence_sets(&mut ground, goes_on)?,
        };
        let Some(turned) = turned else {
            stopped = true;
            break;
        };
        sets.extend(turned);
    }
    if stopped && sets.is_empty() {
        return Ok(None);
    }
    Ok(Some(CostStudy {
        stopped,
        scene: plan.scene.name.clone(),
        held: held(&plan.scene),
        horizon: ground.horizon,
        exponent,
        advice: advice(&sets),
        sets,
    }))
}

/// Where a study of one state of the joint holds what varies.
fn held(scene: &Scene) -> Held {
    let joint = scene.joint();
    joint.map_or_else(|_| Held::default(), |joint| joint.held_at_first())
}

/// Within this many times the inverse of the exponent an error grows by no more than `e`.
fn horizon(longest: f64, exponent: Option<Exponent>) -> f64 {
    match exponent {
        Some(e) if e.value > 0.0 => longest.min(e.value.recip()),
        _ => longest,
    }
}

/// Result of some work, and the median of the CPU time of all threads over repeated runs, s. Where there
/// are several, one more comes first, which finds the caches cold and is not counted.
pub(super) fn timed<T>(repeats: usize, mut work: impl FnMut() -> T) -> (T, f64) {
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
