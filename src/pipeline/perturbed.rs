//! The perturbed trajectory: it starts close to the state of the simulation and is integrated with it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dynamics::{DynamicsError, Integrator, System};
use crate::scene::PerturbedTrajectorySpec;

/// Stream of the random numbers for the direction; the kick uses the first stream.
const STREAM: u64 = 1;

/// A perturbed trajectory. It starts at its start time and is then integrated together with the simulation.
#[derive(Debug)]
pub(super) struct PerturbedTrajectory {
    spec: PerturbedTrajectorySpec,
    seed: u64,
    /// Largest norm of the simulated state so far, sqrt(J).
    size: f64,
    /// State of the perturbed trajectory at the last sample.
    z: Vec<f64>,
}

impl PerturbedTrajectory {
    /// Sets up a perturbed trajectory; `seed` determines the direction of the initial displacement.
    pub fn new(spec: PerturbedTrajectorySpec, seed: u64) -> Self {
        Self {
            spec,
            seed,
            size: 0.0,
            z: Vec::new(),
        }
    }

    /// Advances to the time (s) of a sample at which the simulation, integrated by `first`, has the state
    /// `z`. Returns its state and its distance from the simulated trajectory, relative to the largest norm of the latter;
    /// `None` before its start.
    pub fn sample(
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
