//! States of a joint for the training and for the check of a cubature rule, computed from the joint itself.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::snapshots::amplitudes;
use crate::dynamics::{Accuracy, DynamicsError, Integrator, Method, System};
use crate::joint::Joint;

/// Excitation of a joint: the simulations from which states are taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// Standard deviations of the initial modal velocities. With 1 a single mode moves a node as fast as
    /// steady sliding.
    pub kicks: Vec<f64>,
    /// Simulated time after each kick, s.
    pub duration: f64,
    /// Number of states from each simulation, including the initial one.
    pub states: usize,
    /// Seed of the kicks.
    pub seed: u64,
}

impl Default for Excitation {
    fn default() -> Self {
        Self {
            kicks: vec![0.05, 0.1, 0.3],
            duration: 15e-3,
            states: 80,
            seed: 1,
        }
    }
}

impl Excitation {
    /// States `[q | dq/dt]` of simulations of a joint; the same for the same joint and seed.
    ///
    /// # Errors
    /// If a simulation fails.
    pub fn states_of(&self, joint: &Joint) -> Result<Vec<Vec<f64>>, DynamicsError> {
        let m = joint.modes();
        let [_, unit] = amplitudes(joint);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let accuracy = Accuracy {
            floor: 1e-9 * unit,
            ..Accuracy::relative(1e-4)
        };
        let mut found = Vec::new();
        for kick in &self.kicks {
            let mut z = vec![0.0; joint.dim()];
            for velocity in &mut z[m..2 * m] {
                let normal: f64 = StandardNormal.sample(&mut rng);
                *velocity = kick * unit * normal;
            }
            let method = Method::Auto {
                accuracy,
                max_step: self.duration,
            };
            let mut integrator = Integrator::new(method, joint)?;
            integrator.start(joint, 0.0, &z)?;
            found.push(z[..2 * m].to_vec());
            for k in 1..self.states {
                let t = self.duration * k as f64 / (self.states - 1) as f64;
                integrator.sample(joint, t, &mut z)?;
                found.push(z[..2 * m].to_vec());
            }
        }
        Ok(found)
    }
}
