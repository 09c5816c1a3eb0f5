//! The exponents of a scene's motion.

use std::f64::consts::TAU;

use super::{Count, Goal, LyapunovPlan, LyapunovProgress, LyapunovStudy, Phase, Watch, lyapunov};
use crate::dynamics::{Integrator, LyapunovSpectrum, System};
use crate::pipeline::{PipelineError, Simulation, Source};
use crate::scene::Scene;

/// What is asked of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovRequest {
    /// How many exponents.
    pub count: Count,
    /// Time in which the vectors settle, s; [`SETTLE_PERIODS`] where nothing is said.
    pub settle: Option<f64>,
    /// When to end.
    pub goal: Goal,
}

/// What it came to.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLyapunov {
    /// The exponents and all that goes with them.
    pub study: LyapunovStudy,
    /// Tilt of the load meanwhile, rad.
    pub tilt: f64,
    /// Time for which the scene ran before, s.
    pub transient: f64,
    /// Time in which the vectors settled, s.
    pub settle: f64,
    /// Circular frequency of the slowest mode, rad/s, by which exponents are divided to be compared
    /// with those of the time `tau` of Eq. (23).
    pub omega_1: f64,
}

/// Periods of the slowest mode in which the vectors settle.
pub const SETTLE_PERIODS: f64 = 100.0;
/// The least number of its periods averaged for a goal other than time.
pub const LEAST_PERIODS: f64 = 1000.0;
/// The largest number of its periods averaged for a verdict.
pub const MOST_PERIODS: f64 = 5000.0;
/// The longest time averaged for a half width, s.
pub const LONGEST: f64 = 100.0;

/// Runs a scene as it stands, transient, ramp and all; then holds the tilt that it has come to, and
/// averages the growth of tangent vectors from the state that it has come to.
///
/// A scene whose tilt rises therefore gives the exponents of the motion that was continued up to
/// its last tilt, which may be another one than a kick at that tilt leads to. Stopped before its
/// end, it gives no exponents.
///
/// # Errors
/// If the joint cannot be assembled, more exponents are asked for than there are, or the integration
/// cannot go on.
pub fn scene_lyapunov(
    scene: &Scene,
    request: &LyapunovRequest,
    watch: Watch<'_>,
) -> Result<SceneLyapunov, PipelineError> {
    let mut simulation = Simulation::new(scene)?;
    let width = request.count.width(simulation.joint());
    // That there are so many is told now, not after the transient.
    let following = |integrator: Integrator, joint: &_| {
        integrator.with_tangents(joint, width, scene.start.seed)
    };
    following(simulation.integrator().clone(), simulation.joint())?;

    let slowest = simulation.joint().omega().iter().copied();
    let omega_1 = slowest.fold(f64::INFINITY, f64::min);
    let period = TAU / omega_1;
    let settle = request.settle.unwrap_or(SETTLE_PERIODS * period);
    let plan = LyapunovPlan {
        settle,
        goal: request.goal,
        least: LEAST_PERIODS * period,
        most: match request.goal {
            Goal::HalfWidth(_) => LONGEST,
            Goal::Time(_) | Goal::Verdict => MOST_PERIODS * period,
        },
        // Only the mean trace, which belongs to the sum of all exponents, needs every sample.
        look: match request.count {
            Count::All => 1.0,
            Count::Largest(_) => 64.0,
        } / scene.sample_rate,
    };

    // What the vectors cost beside the state, roughly.
    let dearer = 1.0 + width as f64 / 3.0;
    let rest = dearer * (settle + plan.expected());
    let before = scene.duration / (scene.duration + rest);
    let mut transient = 0.0;
    let mut stopped = false;
    while let Some(frame) = simulation.next_frame()? {
        transient = frame.end();
        let progress = LyapunovProgress {
            phase: Phase::Transient,
            share: before * transient / scene.duration,
            largest: None,
        };
        if !watch(progress) {
            stopped = true;
            break;
        }
    }

    let tilt = simulation.tilt();
    let (joint, integrator) = simulation.into_parts();
    let study = if stopped {
        LyapunovStudy {
            spectrum: LyapunovSpectrum {
                dimension: joint.tangent_dim(),
                ..LyapunovSpectrum::default()
            },
            ..LyapunovStudy::stopped()
        }
    } else {
        let (time, state) = (integrator.time(), integrator.state().to_vec());
        let mut integrator = following(integrator, &joint)?;
        integrator.start(&joint, time, &state)?;
        lyapunov(&joint, &mut integrator, &plan, &mut |progress| {
            watch(LyapunovProgress {
                share: before + (1.0 - before) * progress.share,
                ..progress
            })
        })?
    };
    Ok(SceneLyapunov {
        study,
        tilt,
        transient,
        settle,
        omega_1,
    })
}
