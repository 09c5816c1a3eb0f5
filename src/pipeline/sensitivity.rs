//! Lyapunov exponents and the perturbed trajectory of a running simulation.

use super::message::{Exponents, Frame, MotionSegment};
use super::motion_changes::ChangeDetector;
use super::perturbed::PerturbedTrajectory;
use crate::dynamics::{DynamicsError, Integrator};
use crate::scene::{Scene, SystemSpec};

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
        let seed = scene.start.seed;
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
                .map(|spec| PerturbedTrajectory::new(spec, seed)),
            floor: floor(scene),
        }
    }

    /// Advances to the sample with an index at a time (s) and in a state `z`, which is already in the frame, and adds the
    /// results to the frame. `probe` maps a state to displacement (m) and velocity (m/s).
    pub fn follow(
        &mut self,
        integrator: &mut Integrator<'_>,
        (index, time): (u64, f64),
        z: &[f64],
        probe: impl Fn(&[f64]) -> [f64; 2],
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
            let [displacement, velocity] = probe(state);
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
        let spectrum = segments.last()?.spectrum.clone();
        (spectrum.time > 0.0).then(|| Exponents {
            time,
            spectrum,
            motion: integrator.motion(),
            omega_1: integrator
                .system()
                .omega()
                .iter()
                .copied()
                .fold(f64::NAN, f64::min),
            chaotic_transient: MotionSegment::chaotic_transient(&segments, self.constant_since),
            segments,
        })
    }
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
