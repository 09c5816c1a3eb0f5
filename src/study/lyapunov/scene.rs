//! The exponents of a scene's motion.

use std::f64::consts::TAU;

use serde::Serialize;

use super::{Count, Goal, LyapunovPlan, LyapunovProgress, LyapunovStudy, Phase, lyapunov};
use crate::dynamics::{Integrator, PERIODS_FOR_ZERO, System};
use crate::pipeline::{PipelineError, Prepared, Simulation, Source, prepare};
use crate::scene::{Held, Loading, Scene, SubjectSpec};
use crate::study::Watch;

/// What is asked of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovRequest {
    /// How many exponents.
    pub count: Count,
    /// Time in which the vectors settle, s; [`SETTLE_PERIODS`] where nothing is said.
    pub settle: Option<f64>,
    /// When to end.
    pub goal: Goal,
    /// Error allowed in a step while vectors are followed, relative to the size of the state. Where
    /// nothing is said it is the scene's, and where all exponents are followed at most [`RESOLVING`].
    pub tolerance: Option<f64>,
}

/// What it came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneLyapunov {
    /// The exponents and all that goes with them.
    #[serde(flatten)]
    pub study: LyapunovStudy,
    /// Tilt of the load meanwhile, rad; `None` where there is no load.
    #[serde(rename = "tilt_rad")]
    pub tilt: Option<f64>,
    /// The last values of what varies in the scene, which were held meanwhile.
    pub held: Held,
    /// Time for which the scene ran before, s.
    #[serde(rename = "transient_s")]
    pub transient: f64,
    /// Error allowed in a step while vectors were followed; `None` for a fixed step.
    pub tolerance: Option<f64>,
    /// Circular frequency of the slowest mode, rad/s, by which exponents are divided to be compared
    /// with those of the time `tau` of Eq. (23).
    #[serde(rename = "omega_1_rad_per_s")]
    pub omega_1: f64,
}

/// Periods of the slowest mode in which the vectors settle.
pub const SETTLE_PERIODS: f64 = 100.0;
/// The least number of its periods averaged for a goal other than time.
pub const LEAST_PERIODS: f64 = PERIODS_FOR_ZERO;
/// The largest number of its periods averaged for a verdict.
pub const MOST_PERIODS: f64 = 5000.0;
/// The longest time averaged for a half width, s.
pub const LONGEST: f64 = 100.0;

/// Error allowed in a step where all exponents are followed. A node that nearly sticks contracts the
/// fastest direction of a joint by `e` in 5 us on average and far faster at times, which does not
/// show in the error of the state: at the tolerance of the scenes, 1e-5, the sum of all exponents is
/// 12 % off the mean trace, at 1e-6 1.5 %, at 5e-8 0.04 %, for 2.3 times the time. Shorter steps by a
/// bound on their length cost 3.3 times for 0.2 %.
pub const RESOLVING: f64 = 5e-8;

/// Runs a scene as it stands, transient, ramp and all; then holds the tilt, the load and the rotation
/// that it has come to, and averages the growth of tangent vectors from the state that it has come to.
/// The transient keeps the scene's tolerance, so that it leads where the scene does; from there on
/// [`LyapunovRequest::tolerance`] holds.
///
/// A scene whose tilt rises therefore gives the exponents of the motion that was continued up to
/// its last tilt, which may be another one than a kick at that tilt leads to. Stopped before its
/// end, it gives no exponents.
///
/// # Errors
/// If the scene's system cannot be made, more exponents are asked for than there are, or the integration
/// cannot go on.
pub fn scene_lyapunov(
    scene: &Scene,
    request: &LyapunovRequest,
    watch: Watch<'_, LyapunovProgress>,
) -> Result<SceneLyapunov, PipelineError> {
    // What the scene would have analysed along its run is not asked for here.
    let mut motion = Motion::new(&scene.clone().without_analyses())?;
    let width = request.count.width(motion.system());
    // That there are so many is told now, not after the transient.
    let all = width == motion.system().tangent_dim();
    let following = |integrator: Integrator, system: &dyn System| {
        let scenes = integrator.tolerance().unwrap_or(scene.integrator.tolerance);
        let finest = if all { RESOLVING } else { f64::INFINITY };
        let tolerance = request.tolerance.unwrap_or(scenes.min(finest));
        integrator
            .with_tolerance(tolerance)?
            .with_tangents(system, width, scene.start.seed)
    };
    following(motion.integrator().clone(), motion.system())?;

    let slowest = motion.system().omega().iter().copied();
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
        look: if all { 1.0 } else { 64.0 } / scene.sample_rate,
    };

    // What the vectors cost beside the state, roughly.
    let dearer = 1.0 + width as f64 / 3.0;
    let before = scene.duration / (scene.duration + dearer * (settle + plan.expected()));
    let mut transient = 0.0;
    let mut stopped = false;
    while !stopped && let Some(reached) = motion.on()? {
        transient = reached;
        stopped = !watch(LyapunovProgress {
            phase: Phase::Transient,
            share: before * (transient / scene.duration).min(1.0),
            largest: None,
        });
    }

    if !stopped {
        motion.hold_last_loading()?;
    }
    let loading = motion.loading();
    let held = match (scene.joint(), loading) {
        (Ok(joint), Some(loading)) => joint.held_at(loading),
        _ => Held::default(),
    };
    let (system, integrator) = motion.into_parts();
    let mut tolerance = integrator.tolerance();
    let study = if stopped {
        LyapunovStudy::stopped(system.tangent_dim())
    } else {
        let (time, state) = (integrator.time(), integrator.state().to_vec());
        let mut integrator = following(integrator, &*system)?;
        integrator.start(&*system, time, &state)?;
        tolerance = integrator.tolerance();
        lyapunov(&*system, &mut integrator, &plan, &mut |progress| {
            watch(LyapunovProgress {
                share: before + (1.0 - before) * progress.share,
                ..progress
            })
        })?
    };
    Ok(SceneLyapunov {
        study,
        tilt: loading.map(|loading| loading.tilt),
        held,
        transient,
        tolerance,
        omega_1,
    })
}

/// A scene's motion without its exponents.
#[allow(
    clippy::large_enum_variant,
    reason = "a study has one motion: its size does not matter"
)]
enum Motion {
    /// A joint, whose tilt, load and rotation may follow schedules.
    Joint(Simulation),
    /// A small system.
    Small {
        prepared: Prepared,
        frame: f64,
        frames: u64,
        duration: f64,
    },
}

impl Motion {
    fn new(scene: &Scene) -> Result<Self, PipelineError> {
        Ok(match &scene.subject {
            SubjectSpec::Joint(_) => Self::Joint(Simulation::new(scene)?),
            SubjectSpec::Small(_) => {
                let mut prepared = prepare(scene)?;
                let (system, state) = (&*prepared.system, &prepared.state);
                prepared.integrator.start(system, 0.0, state)?;
                Self::Small {
                    prepared,
                    frame: scene.frame_samples as f64 / scene.sample_rate,
                    frames: 0,
                    duration: scene.duration,
                }
            }
        })
    }

    fn system(&self) -> &dyn System {
        match self {
            Self::Joint(simulation) => simulation.joint(),
            Self::Small { prepared, .. } => &*prepared.system,
        }
    }

    fn integrator(&self) -> &Integrator {
        match self {
            Self::Joint(simulation) => simulation.integrator(),
            Self::Small { prepared, .. } => &prepared.integrator,
        }
    }

    /// Goes on by a frame; the time reached, s, or `None` at the end.
    fn on(&mut self) -> Result<Option<f64>, PipelineError> {
        match self {
            Self::Joint(simulation) => Ok(simulation.next_frame()?.map(|frame| frame.end())),
            Self::Small {
                prepared,
                frame,
                frames,
                duration,
            } => {
                if prepared.integrator.time() >= *duration {
                    return Ok(None);
                }
                *frames += 1;
                let time = (*frames as f64 * *frame).min(*duration);
                prepared.integrator.land(&*prepared.system, time)?;
                Ok(Some(time))
            }
        }
    }

    /// Takes tilt, load and rotation to where their schedules are at the end of the run: the last frame
    /// still has those of its start.
    fn hold_last_loading(&mut self) -> Result<(), PipelineError> {
        match self {
            Self::Joint(simulation) => simulation.hold_last_loading(),
            Self::Small { .. } => Ok(()),
        }
    }

    /// What acts on the joint at present; `None` where there is none.
    fn loading(&self) -> Option<Loading> {
        match self {
            Self::Joint(simulation) => Some(simulation.loading()),
            Self::Small { .. } => None,
        }
    }

    fn into_parts(self) -> (Box<dyn System + Send>, Integrator) {
        match self {
            Self::Joint(simulation) => {
                let (joint, integrator) = simulation.into_parts();
                (Box::new(joint), integrator)
            }
            Self::Small { prepared, .. } => (prepared.system, prepared.integrator),
        }
    }
}
