//! The second copy of a butterfly: from almost the same state, along the same road.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dynamics::{DynamicsError, Integrator, System};
use crate::scene::ButterflySpec;

/// The stream of random numbers that the direction is drawn from; the kick has the first one.
const STREAM: u64 = 1;

/// A second copy: waits for its time, then runs beside the first one.
#[derive(Debug)]
pub(super) struct Twin {
    spec: ButterflySpec,
    seed: u64,
    /// The largest size of the first copy so far, sqrt(J).
    size: f64,
    /// Its state at the last sample.
    z: Vec<f64>,
}

/// The second copy at a sample.
#[derive(Debug)]
pub(super) struct TwinState<'a> {
    /// Its state.
    pub z: &'a [f64],
    /// Its distance from the first copy, relative to the first one's size.
    pub distance: f64,
}

impl Twin {
    /// A second copy as a scene asks for it; `seed` gives the direction in which it starts.
    pub fn new(spec: ButterflySpec, seed: u64) -> Self {
        Self {
            spec,
            seed,
            size: 0.0,
            z: Vec::new(),
        }
    }

    /// Goes to the time (s) of a sample at which the first copy, integrated by `first`, has the
    /// state `z`. `None` as long as there is no second copy.
    pub fn sample<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        first: &mut Integrator,
        time: f64,
        z: &[f64],
    ) -> Result<Option<TwinState<'_>>, DynamicsError> {
        self.size = self.size.max(norm(sys, z.iter().copied()));
        if first.neighbour_since().is_none() && time >= self.spec.start {
            self.start(sys, first)?;
        }
        // The first copy has gone past the sample, and the second one starts where it is.
        if first.neighbour_since().is_none_or(|start| time < start) {
            return Ok(None);
        }
        first.sample_neighbour(sys, time, &mut self.z)?;
        let apart = self.z.iter().zip(z).map(|(a, b)| a - b);
        Ok(Some(TwinState {
            distance: norm(sys, apart) / self.size.max(f64::MIN_POSITIVE),
            z: &self.z,
        }))
    }

    /// Starts where the first copy is, displaced in a random direction.
    fn start<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        first: &mut Integrator,
    ) -> Result<(), DynamicsError> {
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
        first.add_neighbour(sys, &self.z)
    }
}

/// The norm of the vibration's energy, `sqrt(sum (q'^2 + omega^2 q^2) / 2)`, sqrt(J).
fn norm<Y: System + ?Sized>(sys: &Y, z: impl Iterator<Item = f64>) -> f64 {
    let omega = sys.omega().iter().copied();
    let factors = omega.chain(std::iter::repeat_n(1.0, sys.modes()));
    let squares = z.zip(factors).map(|(z, factor)| (factor * z).powi(2));
    (0.5 * squares.sum::<f64>()).sqrt()
}
