//! From a scene to a system, its integrator and its initial state.

use std::f64::consts::TAU;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::PipelineError;
use crate::dynamics::{Accuracy, Integrator, Switching, System, max_rk4_step};
use crate::joint::{AssemblyError, BallJoint, Joint};
use crate::scene::{self, Events, LoadedJoint, Scene, SmallSystem, SystemSpec};

/// Absolute tolerance of a scene's integrator: of the vibration, sqrt(kg) m/s, and of the work of friction,
/// J. Subtracting the equilibrium leaves rounding noise of about 1e-19 sqrt(kg) m/s per step.
pub(super) const FLOOR: f64 = 1e-12;

/// A prepared run: a system with its integrator and initial state.
pub struct Prepared {
    /// Row that maps modal coordinates to the probe: its displacement is this row times `q` (Eq. (24)), its
    /// velocity this row times `dq/dt`.
    pub probe: Vec<f64>,
    /// The integrator, not started yet, of the small system, or of the joint at its initial tilt without the quadrature of
    /// the energy audit. It stops at events if the scene requests it, and always for a small system.
    pub integrator: Integrator<'static>,
    /// Initial state at time 0, length [`System::dim`].
    pub state: Vec<f64>,
    /// The joint, at any tilt; `None` for another system.
    pub ball: Option<BallJoint>,
}

impl Prepared {
    /// The same system with the final state `[q | dq/dt]` of another run as its initial state, as far as both have it.
    #[must_use]
    pub fn starting_from(mut self, state: &[f64]) -> Self {
        self.state.fill(0.0);
        let common = state.len().min(self.state.len());
        self.state[..common].copy_from_slice(&state[..common]);
        self
    }
}

/// Builds the system of a scene, its integrator and its initial state.
///
/// # Errors
/// If the joint cannot be assembled, or the integrator does not fit the system.
pub fn prepare(scene: &Scene) -> Result<Prepared, PipelineError> {
    let ((integrator, state), probe, ball) = match &scene.subject {
        SystemSpec::Joint(tilted) => {
            let ball = ball_of(tilted)?;
            let joint = Arc::new(ball.joint(tilted.tilt.at(0.0))?);
            let probe = joint.probe().to_vec();
            (joint_integrator(scene, &joint)?, probe, Some(ball))
        }
        SystemSpec::Small(small) => (small_integrator(scene, small)?, small_probe(small), None),
    };
    Ok(Prepared {
        probe,
        integrator,
        state,
        ball,
    })
}

/// The joint under the load and the rotation at time 0.
///
/// # Errors
/// As [`BallJoint::new`].
pub(super) fn ball_of(tilted: &LoadedJoint) -> Result<BallJoint, AssemblyError> {
    let mut ball = BallJoint::new(&tilted.spec)?;
    ball.set_probe_rotation(tilted.full_rotation);
    Ok(ball)
}

/// A small system as a trait object.
pub(super) fn boxed(small: &SmallSystem) -> Box<dyn System> {
    match *small {
        SmallSystem::ImpactOscillator(system) => Box::new(system),
        SmallSystem::MassOnBelt(system) => Box::new(system),
        SmallSystem::TwoModesOnBelt(system) => Box::new(system),
        SmallSystem::DampedContact(system) => Box::new(system),
    }
}

/// Row that maps the modal coordinates of a small system to its displacement.
pub(super) fn small_probe(small: &SmallSystem) -> Vec<f64> {
    match small {
        SmallSystem::TwoModesOnBelt(system) => system.along().to_vec(),
        SmallSystem::ImpactOscillator(_)
        | SmallSystem::MassOnBelt(_)
        | SmallSystem::DampedContact(_) => vec![1.0],
    }
}

/// An integrator that has not started, with its initial state.
pub(super) type Unstarted = (Integrator<'static>, Vec<f64>);

/// The integrator of a scene for its joint, with the initial state. A contact with dashpots has a discontinuous force, and
/// its integrator must stop at events.
pub(super) fn joint_integrator(
    scene: &Scene,
    joint: &Arc<Joint>,
) -> Result<Unstarted, PipelineError> {
    // Contact and friction limit a fixed step, too.
    let rates = || match joint.linear_modes() {
        Ok(modes) => modes
            .iter()
            .map(|mode| [mode.growth, TAU * mode.frequency_hz])
            .collect(),
        Err(_) => natural(&**joint),
    };
    let stops = !joint.is_continuous() || scene.integrator.events == Events::Exact;
    integrator(scene, Arc::clone(joint), rates, stops)
}

/// The integrator of a scene for its small system, with the initial state. Small systems are discontinuous, and their
/// integrator must stop at events.
pub(super) fn small_integrator(
    scene: &Scene,
    small: &SmallSystem,
) -> Result<Unstarted, PipelineError> {
    let system = boxed(small);
    let rates = natural(&*system);
    integrator(scene, system, || rates, true)
}

/// Eigenvalues `[growth, frequency]` of undamped modes.
fn natural(system: &dyn System) -> Vec<[f64; 2]> {
    system.omega().iter().map(|&omega| [0.0, omega]).collect()
}

/// The integrator of a scene. A fixed step must be stable for each of `rates`, the eigenvalues `[growth, frequency]` of the
/// linearised system.
fn integrator(
    scene: &Scene,
    system: impl System + 'static,
    rates: impl FnOnce() -> Vec<[f64; 2]>,
    stops_at_events: bool,
) -> Result<Unstarted, PipelineError> {
    let scene::Integrator {
        method,
        tolerance,
        max_step,
        ..
    } = scene.integrator;
    if method.has_fixed_step() {
        let longest = rates().into_iter().map(max_rk4_step);
        let limit = longest.fold(f64::INFINITY, f64::min);
        if max_step > limit {
            return Err(PipelineError::Step {
                step_us: 1e6 * max_step,
                limit_us: 1e6 * limit,
            });
        }
    }
    let accuracy = Accuracy {
        floor: FLOOR,
        ..Accuracy::relative(tolerance)
    };
    let mut integrator = Integrator::new(method.with(accuracy, max_step), system)?;
    if stops_at_events {
        integrator = integrator.with_events()?;
    }
    let system = integrator.system();
    let mut state = initial_state(scene, system.modes());
    state.resize(system.dim(), 0.0);
    Ok((integrator, state))
}

/// The initial `[q | dq/dt]`: the initial state of the scene plus a seeded Gaussian kick of the velocities.
pub fn initial_state(scene: &Scene, modes: usize) -> Vec<f64> {
    let start = &scene.start;
    let mut z = vec![start.position; 2 * modes];
    let velocities = &mut z[modes..];
    velocities.fill(start.velocity);
    kick(velocities, start.kick, start.seed);
    z
}

/// Adds a seeded Gaussian kick of standard deviation `size` to velocities.
pub(super) fn kick(velocities: &mut [f64], size: f64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for velocity in velocities {
        let normal: f64 = StandardNormal.sample(&mut rng);
        *velocity += size * normal;
    }
}
