//! Lyapunov exponents of a scene.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use super::{Goal, LyapunovPlan, LyapunovStudy, lyapunov};
use crate::dynamics::{Integrator, MIN_PERIODS_FOR_ZERO};
use crate::pipeline::message::MotionSegment;
use crate::pipeline::{PipelineError, Simulation, Source as _};
use crate::scene::{FixedAt, Scene};
use crate::study::OnProgress;

/// Request for the Lyapunov exponents of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovRequest {
    /// Number of largest exponents, at least 1; `None` for all.
    pub count: Option<usize>,
    /// Settling time of the tangent vectors, s; `None` for [`SETTLE_PERIODS`].
    pub settle: Option<f64>,
    /// Goal that ends the averaging.
    pub goal: Goal,
    /// Relative error tolerance of a time step during settling and averaging. `None` for the scene's
    /// tolerance; with all exponents, at most [`FULL_SPECTRUM_TOLERANCE`].
    pub tolerance: Option<f64>,
}

/// Lyapunov exponents of a scene, and the conditions of the study.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SceneLyapunov {
    /// The Lyapunov study: exponents, running estimates and solver statistics.
    #[serde(flatten)]
    pub study: LyapunovStudy,
    /// Tilt of the load during the study, rad; `None` for a scene without a load.
    pub tilt_rad: Option<f64>,
    /// Final values at which the scheduled parameters are fixed during the study.
    pub fixed_at: FixedAt,
    /// Transient time: the length of the scene's run before the study, s.
    pub transient_s: f64,
    /// Lifetime of the chaotic transient before the last motion, s: the time from the start of the run, or
    /// from the end of its schedules, to the end of the last chaotic motion before the last one. `None` if
    /// no earlier motion was chaotic.
    pub chaotic_transient_s: Option<f64>,
    /// Relative error tolerance of a time step during the study; `None` for a fixed step.
    pub tolerance: Option<f64>,
    /// Angular frequency `omega_1` of the slowest mode, rad/s. Exponents divided by it can be compared with
    /// those in the dimensionless time `tau` of Eq. (23).
    pub omega_1_rad_per_s: f64,
}

/// Default settling time of the tangent vectors, periods of the slowest mode.
pub const SETTLE_PERIODS: f64 = 100.0;
/// Minimum averaging time for a goal other than time, periods of the slowest mode.
pub const MIN_PERIODS: f64 = MIN_PERIODS_FOR_ZERO;
/// Maximum averaging time for a classification, periods of the slowest mode.
pub const MAX_PERIODS: f64 = 5000.0;
/// Maximum averaging time for a target half-width, s.
pub const MAX_TIME: f64 = 100.0;

/// Largest relative tolerance of a time step with all exponents. A node that nearly sticks contracts the
/// fastest direction of a joint by a factor `e` in 5 us on average, and at times much faster, which the error
/// of the state does not show. The sum of all exponents deviates from the mean trace by 12 % at the scenes'
/// tolerance of 1e-5, by 1.5 % at 1e-6, and by 0.04 % at 5e-8, which takes 2.3 times as long as 1e-5. A limit
/// on the step size instead takes 3.3 times as long for 0.2 %.
pub const FULL_SPECTRUM_TOLERANCE: f64 = 5e-8;

/// Computes the Lyapunov exponents of a scene.
///
/// First the scene runs to its end, including its transient and its schedules, at its own tolerance. Then
/// tilt, load and rotation are fixed at their final values, and the growth of tangent vectors is averaged
/// from the final state at [`LyapunovRequest::tolerance`].
///
/// A scene with an increasing tilt therefore gives the exponents of the motion continued up to the final
/// tilt, which may differ from the motion that a kick at that tilt leads to. A study stopped during the run
/// has no exponents.
///
/// # Errors
/// If the scene's system cannot be built, if more exponents are requested than exist, or if the integration
/// fails.
pub fn scene_lyapunov(
    scene: &Scene,
    request: &LyapunovRequest,
    progress: OnProgress<'_>,
) -> Result<SceneLyapunov, PipelineError> {
    // The scene's own analyses are not needed.
    let mut run = Simulation::new(&scene.clone().without_analyses())?;
    let width = request.count.unwrap_or(run.system().tangent_dim());
    // Checked now, so that too many exponents fail before the transient.
    let all = width == run.system().tangent_dim();
    let with_tangents = |integrator: Integrator<'static>| {
        let own = integrator.tolerance().unwrap_or(scene.integrator.tolerance);
        let largest = if all {
            FULL_SPECTRUM_TOLERANCE
        } else {
            f64::INFINITY
        };
        let tolerance = request.tolerance.unwrap_or(own.min(largest));
        integrator
            .with_tolerance(tolerance)?
            .with_tangents(width, scene.start.seed)
    };
    with_tangents(run.integrator().clone())?;

    let slowest = run.system().omega().iter().copied();
    let omega_1 = slowest.fold(f64::INFINITY, f64::min);
    let period = TAU / omega_1;
    let settle = request.settle.unwrap_or(SETTLE_PERIODS * period);
    let plan = LyapunovPlan {
        settle,
        goal: request.goal,
        min_time: MIN_PERIODS * period,
        max_time: match request.goal {
            Goal::HalfWidth(_) => MAX_TIME,
            Goal::Time(_) | Goal::Classification => MAX_PERIODS * period,
        },
        // Only the mean trace, which needs all exponents, needs every sample.
        sample_interval: if all { 1.0 } else { 64.0 } / scene.sample_rate,
    };

    // Approximate cost of the tangent vectors relative to the state.
    let relative_cost = 1.0 + width as f64 / 3.0;
    let before = scene.duration / (scene.duration + relative_cost * (settle + plan.times()[0]));
    let mut transient = 0.0;
    let mut stopped = false;
    while !stopped && run.next_frame()?.is_some() {
        transient = run.time();
        let share = before * (transient / scene.duration).min(1.0);
        stopped = progress(share, "running the scene").is_err();
    }

    if !stopped {
        run.apply_final_loading()?;
    }
    let loading = run.loading();
    let fixed_at = match (scene.joint(), loading) {
        (Ok(joint), Some(loading)) => joint.fixed_at(loading),
        _ => FixedAt::default(),
    };
    let integrator = run.into_integrator();
    let mut tolerance = integrator.tolerance();
    let study = if stopped {
        LyapunovStudy::stopped(integrator.system().tangent_dim())
    } else {
        let (time, state) = (integrator.time(), integrator.state().to_vec());
        let mut integrator = with_tangents(integrator)?;
        integrator.start(time, &state)?;
        tolerance = integrator.tolerance();
        lyapunov(&mut integrator, &plan, &mut |share, task| {
            progress(before + (1.0 - before) * share, task)
        })?
    };
    let constant_since = if fixed_at == FixedAt::default() {
        0.0
    } else {
        transient
    };
    Ok(SceneLyapunov {
        chaotic_transient_s: MotionSegment::chaotic_transient(&study.segments, constant_since),
        study,
        tilt_rad: loading.map(|loading| loading.tilt),
        fixed_at,
        transient_s: transient,
        tolerance,
        omega_1_rad_per_s: omega_1,
    })
}
