//! Lyapunov exponents and the perturbed trajectory of a running simulation.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::message::{Exponents, Frame, MotionSegment};
use super::motion_changes::ChangeDetector;
use super::simulate::observe;
use crate::dynamics::{DynamicsError, Integrator, System};
use crate::scene::{PerturbedTrajectorySpec, Scene, SystemSpec};

/// Stream of the random numbers for the direction; the kick uses the first stream.
const STREAM: u64 = 1;

/// Computes exponents and the perturbed trajectory at the samples of a simulation.
#[derive(Debug)]
pub(super) struct SensitivityTracker {
    /// If the scene requests exponents: the sample at which averaging starts, and the number of samples between two reports.
    exponents: Option<[u64; 2]>,
    /// Changes of the motion, from the start of the averaging on.
    detector: Option<ChangeDetector>,
    /// Sampling interval, s.
    interval: f64,
    /// Time of the last change of a parameter, s.
    constant_since: f64,
    /// The perturbed trajectory, if the scene requests it.
    perturbed: Option<PerturbedTrajectory>,
    /// See [`PerturbedSamples::floor`](super::message::PerturbedSamples::floor).
    floor: f64,
}

impl SensitivityTracker {
    /// Sets up the analyses that a scene requests.
    pub fn new(scene: &Scene) -> Self {
        let rate = scene.sample_rate;
        let analysis = &scene.analysis;
        Self {
            exponents: analysis.exponents.map(|spec| {
                let every = (spec.every * rate).round().max(1.0);
                [(spec.settle * rate).ceil() as u64, every as u64]
            }),
            detector: None,
            interval: 1.0 / rate,
            constant_since: 0.0,
            perturbed: analysis
                .perturbed_trajectory
                .map(|spec| PerturbedTrajectory {
                    spec,
                    seed: scene.start.seed,
                    size: 0.0,
                    z: Vec::new(),
                }),
            floor: floor(scene),
        }
    }

    /// Advances to the sample with an index at a time (s) and in a state `z`, which is already in the frame, and adds the
    /// results to the frame. `probe` maps modal coordinates to the displacement of the probe.
    pub fn follow(
        &mut self,
        integrator: &mut Integrator<'_>,
        (index, time): (u64, f64),
        z: &[f64],
        probe: &[f64],
        frame: &mut Frame,
    ) -> Result<(), DynamicsError> {
        let exponents = self.exponents(integrator, (index, time), z);
        frame.exponents.extend(exponents);
        let Some(perturbed) = &mut self.perturbed else {
            return Ok(());
        };
        let samples = frame.perturbed.get_or_insert_default();
        samples.floor = self.floor;
        if let Some((state, distance)) = perturbed.sample(integrator, time, z)? {
            let [displacement, velocity] = observe(probe, state);
            samples.displacement.push(displacement);
            samples.velocity.push(velocity);
            samples.distance.push(distance);
        }
        Ok(())
    }

    /// Records a change of tilt, load or rotation at a time, s.
    pub fn parameters_changed(&mut self, time: f64) {
        self.constant_since = time;
    }

    /// Follows the exponents to a sample; returns them if they are due.
    fn exponents(
        &mut self,
        integrator: &mut Integrator<'_>,
        (index, time): (u64, f64),
        z: &[f64],
    ) -> Option<Exponents> {
        let [from, every] = self.exponents?;
        let since = index.checked_sub(from)?;
        if self.detector.is_none() {
            integrator.reset_growth();
            self.detector = Some(ChangeDetector::new(integrator, time, self.interval));
            return None;
        }
        let detector = self.detector.as_mut()?;
        detector.push(integrator, z);
        if since % every != 0 {
            return None;
        }
        let segments = detector.segments(integrator);
        let omega = integrator.system().omega().iter().copied();
        let spectrum = segments.last()?.spectrum.clone();
        (spectrum.time > 0.0).then(|| Exponents {
            time,
            spectrum,
            motion: integrator.motion(),
            omega_1: omega.fold(f64::NAN, f64::min),
            chaotic_transient: MotionSegment::chaotic_transient(&segments, self.constant_since),
            segments,
        })
    }
}

/// A perturbed trajectory. It starts at its start time and is then integrated together with the simulation.
#[derive(Debug)]
struct PerturbedTrajectory {
    spec: PerturbedTrajectorySpec,
    /// Seed of the direction of the initial displacement.
    seed: u64,
    /// Largest norm of the simulated state so far, sqrt(J).
    size: f64,
    /// State of the perturbed trajectory at the last sample.
    z: Vec<f64>,
}

impl PerturbedTrajectory {
    /// Advances to the time (s) of a sample at which the simulation, integrated by `first`, has the state
    /// `z`. Returns its state and its distance from the simulated trajectory, relative to the largest norm of the latter;
    /// `None` before its start.
    fn sample(
        &mut self,
        first: &mut Integrator<'_>,
        time: f64,
        z: &[f64],
    ) -> Result<Option<(&[f64], f64)>, DynamicsError> {
        self.size = self.size.max(norm(first.system(), z.iter().copied()));
        if first.perturbed_since().is_none() && time >= self.spec.start {
            self.start(first)?;
        }
        // The integrator is past the sample, and the perturbed trajectory starts at the integrator's time.
        if first.perturbed_since().is_none_or(|start| time < start) {
            return Ok(None);
        }
        first.sample_perturbed(time, &mut self.z)?;
        let apart = self.z.iter().zip(z).map(|(a, b)| a - b);
        let distance = norm(first.system(), apart) / self.size.max(f64::MIN_POSITIVE);
        Ok(Some((&self.z, distance)))
    }

    /// Starts the perturbed trajectory at the state of the simulation plus a random displacement.
    fn start(&mut self, first: &mut Integrator<'_>) -> Result<(), DynamicsError> {
        let sys = first.system();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(STREAM);
        let omega = sys.omega();
        let mut by: Vec<f64> = (0..2 * omega.len())
            .map(|_| StandardNormal.sample(&mut rng))
            .collect();
        for (q, &w) in by.iter_mut().zip(omega) {
            *q /= if w > 0.0 { w } else { 1.0 };
        }
        let scale = self.spec.distance * self.size / norm(sys, by.iter().copied());
        self.z = first.state().to_vec();
        for (z, by) in self.z.iter_mut().zip(by) {
            *z += scale * by;
        }
        first.add_perturbed(&self.z)
    }
}

/// The energy norm of a state, `sqrt(sum (q'^2 + omega^2 q^2) / 2)`, sqrt(J).
fn norm(sys: &dyn System, z: impl Iterator<Item = f64>) -> f64 {
    let omega = sys.omega().iter().copied();
    let factors = omega.chain(std::iter::repeat_n(1.0, sys.modes()));
    let squares = z.zip(factors).map(|(z, factor)| (factor * z).powi(2));
    (0.5 * squares.sum::<f64>()).sqrt()
}

/// Distance of two trajectories below which step errors dominate. On identical steps the errors are identical
/// and only rounding remains. If the state or the force is discontinuous, each trajectory has its own steps,
/// and the difference of their errors separates them at once: trajectories with an initial distance of 1e-12
/// differ by half a tolerance after a few impacts. In a joint nothing is discontinuous, and the errors differ
/// so little that trajectories with an initial distance of 1e-12 separate alike with and without events.
fn floor(scene: &Scene) -> f64 {
    match scene.subject {
        SystemSpec::Small(_) => 10.0 * scene.integrator.tolerance,
        SystemSpec::Joint(_) => 100.0 * f64::EPSILON,
    }
}

/// Adds the tangent vectors that a scene requests to its integrator.
///
/// # Errors
/// [`DynamicsError`] if the system has no derivative, or fewer dimensions than vectors.
pub(super) fn with_tangents<'a>(
    scene: &Scene,
    integrator: Integrator<'a>,
) -> Result<Integrator<'a>, DynamicsError> {
    match scene.analysis.exponents {
        Some(spec) => integrator.with_tangents(spec.count, scene.start.seed),
        None => Ok(integrator),
    }
}
