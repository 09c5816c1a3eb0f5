//! What accuracy and effects cost: the error of each numerical setting against time, the price of each effect of a
//! scene, and the cheapest settings for a total error.
//!
//! Every run starts from one settled state, settles for the same time and is measured in the same window. An error is
//! the largest relative difference of the strongest line's frequency and amplitude and of the rms velocity from those of
//! a reference, which is one level finer than the finest level that is shown. A chaotic motion has neither a line nor an
//! amplitude that converges: its error is that of the rms velocity, and no smaller than the scatter of the average.

mod effects;
mod motion;
mod report;
mod settings;

#[cfg(test)]
pub(crate) mod tests;

use schemars::JsonSchema;
use serde::Serialize;

use super::{OnProgress, StudyError};
use crate::scene::{FixedAt, LoadedJoint, Scene};

pub use effects::{Effect, RunAll};
pub use motion::Motion;
pub use settings::{Choice, Origin, Setting, Settings, TARGETS, WorkPrecision, WorkPrecisionPoint};

use motion::Runner;

/// Result of a cost study.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Cost {
    /// Values at which the scheduled parameters of the scene are fixed while its motion is measured.
    pub fixed_at: FixedAt,
    /// Time for which each run settles before it is measured, s.
    pub settling_s: f64,
    /// Time for which the settled motion is measured, s.
    pub measurement_s: f64,
    /// The settled motion at the finest settings.
    pub reference: Motion,
    /// Relative difference of two successive measurements of the reference; `null` unless the motion is chaotic. Smaller
    /// errors of a chaotic motion cannot be seen.
    pub scatter: Option<f64>,
    /// Error against time of each numerical setting.
    pub settings: Vec<WorkPrecision>,
    /// CPU time of a complete run, s per simulated second, with the analyses and the recording of the scene; `null` if the
    /// study was stopped before.
    pub run_cpu_s_per_s: Option<f64>,
    /// Price of each effect that the scene has on.
    pub effects: Vec<Effect>,
    /// Settings for total errors, each verified by one run at the next finer level of everything.
    pub choices: Vec<Choice>,
    /// Whether the study was stopped early: the rest is missing.
    pub stopped: bool,
}

/// Runs a cost study on the calling thread, so that times are comparable. `run_all` runs a scene with everything that
/// it records, for the price of the recording; without it, there is none. If it is stopped, the result has what
/// is complete.
///
/// # Errors
/// [`StudyError::Stopped`] if nothing is complete; if the scene is at rest, or has no settled motion that can be measured.
pub fn cost(
    scene: &Scene,
    run_all: Option<RunAll<'_>>,
    progress: OnProgress<'_>,
) -> Result<Cost, StudyError> {
    let mut runner = Runner::settle(scene, progress)?;
    runner.begin("reference", 0.05);
    let finest = Settings::reference(scene).apply(scene)?;
    let (reference, again) = runner.twice(&finest)?;
    let mut study = Cost {
        fixed_at: scene
            .joint()
            .map(LoadedJoint::fixed_at_start)
            .unwrap_or_default(),
        settling_s: runner.plan.min_transient_s,
        measurement_s: runner.plan.measurement_s,
        scatter: (!reference.has_lines()).then(|| again.difference(&reference)),
        reference,
        settings: Vec::new(),
        run_cpu_s_per_s: None,
        effects: Vec::new(),
        choices: Vec::new(),
        stopped: false,
    };
    let done = settings::vary(&mut runner, &mut study)
        .and_then(|()| settings::choose(&mut runner, &mut study))
        .and_then(|()| effects::price(&mut runner, run_all, &mut study));
    match done {
        Err(StudyError::Stopped(_)) if !study.settings.is_empty() => study.stopped = true,
        done => done?,
    }
    Ok(study)
}
