//! Eq. (20) to (22): propagation of tangent vectors with the state.
//!
//! Tangent vectors are propagated after a step is accepted, through the stages of the state.

mod frame;
mod saltation;

use super::stepper::{Law, Stepper};
use super::{DynamicsError, System, lyapunov::Growth};
use frame::Frame;
pub(super) use saltation::Saltation;

/// Tangent vectors during a step, stored component by component: component `c` of vector `l` is at `c *
/// width + l`.
#[derive(Clone, Debug)]
pub(super) struct TangentBlock {
    /// Number of vectors.
    pub width: usize,
    /// At the start of the last step.
    pub start: Vec<f64>,
    /// At the end of the last step, `tangent_dim x width`.
    pub end: Vec<f64>,
    /// At a stage.
    pub stage: Vec<f64>,
    /// Slopes at the stages, `stages x tangent_dim x width`.
    pub slopes: Vec<f64>,
}

/// Tangent vectors with orthonormalisation and growth statistics.
#[derive(Clone, Debug)]
pub(super) struct Tangents {
    pub block: TangentBlock,
    /// Norm and orthonormalisation.
    frame: Frame,
    /// Whether vectors are orthonormalised when needed and their growth is accumulated. Otherwise they are not modified.
    is_orthonormalised: bool,
    /// Accumulated growth.
    growth: Growth,
    /// Whether any bit of the state has changed in any step since the last reset of the growth.
    pub moved: bool,
    /// Correction at events.
    pub saltation: Saltation,
}

impl Tangents {
    /// `width` vectors for a system, for a method with `stages` slopes per step.
    pub fn new(sys: &dyn System, width: usize, seed: u64, stages: usize) -> Self {
        let numbers = sys.tangent_dim() * width;
        let mut tangents = Self {
            block: TangentBlock {
                width,
                start: vec![0.0; numbers],
                end: vec![0.0; numbers],
                stage: vec![0.0; numbers],
                slopes: vec![0.0; stages * numbers],
            },
            frame: Frame::new(sys, width, seed),
            is_orthonormalised: true,
            growth: Growth::new(width),
            moved: false,
            saltation: Saltation::new(sys, width),
        };
        tangents.restart(0.0);
        tangents
    }

    /// Restarts at time `t` (s) with the orthonormal vectors of the seed.
    pub fn restart(&mut self, t: f64) {
        self.frame.start(&mut self.block.end);
        self.block.start.copy_from_slice(&self.block.end);
        self.is_orthonormalised = true;
        self.growth.clear(t);
        self.moved = false;
    }

    /// Replaces the vectors and disables orthonormalisation.
    pub fn replace(&mut self, vectors: &[f64]) {
        self.block.end.copy_from_slice(vectors);
        self.block.start.copy_from_slice(vectors);
        self.is_orthonormalised = false;
    }

    /// Moves the start of the next step to the end of the last one, at time `t` (s), and orthonormalises
    /// the vectors if due.
    ///
    /// # Errors
    /// [`DynamicsError::Tangent`] for a vector that is not finite.
    pub fn begin_step(&mut self, t: f64) -> Result<(), DynamicsError> {
        if self.is_orthonormalised && self.frame.is_due() {
            self.orthonormalise(t)?;
        }
        self.block.start.copy_from_slice(&self.block.end);
        Ok(())
    }

    /// Orthonormalises the vectors and accumulates their growth up to time `t` (s).
    fn orthonormalise(&mut self, t: f64) -> Result<(), DynamicsError> {
        if t <= self.growth.last {
            return Ok(());
        }
        self.frame.orthonormalise(&mut self.block.end);
        let logarithms = &self.frame.logarithms;
        // A collapsed direction gives minus infinity; only plus infinity and NaN are errors.
        if let Some(vector) = logarithms
            .iter()
            .position(|x| x.is_nan() || *x == f64::INFINITY)
        {
            return Err(DynamicsError::Tangent { time: t, vector });
        }
        self.growth.push(t, logarithms);
        Ok(())
    }

    /// Discards the growth up to time `t` (s) but keeps the directions.
    pub fn forget(&mut self, t: f64) {
        if self.is_orthonormalised {
            self.frame.orthonormalise(&mut self.block.end);
        }
        self.growth.clear(t);
        self.moved = false;
    }

    /// The growth up to time `t` (s); `None` for user-supplied vectors.
    pub fn growth(&self, t: f64) -> Option<Growth> {
        self.is_orthonormalised.then(|| {
            let mut now = self.clone();
            // Non-finite vectors make the next step fail; the growth up to the last frame is valid.
            match now.orthonormalise(t) {
                Ok(()) => now.growth,
                Err(_) => self.growth.clone(),
            }
        })
    }

    /// Length of a vector, which is the total number of exponents.
    pub fn dimension(&self) -> usize {
        self.block.end.len() / self.block.width
    }

    /// Reverts the last step to its start at time `t` (s).
    pub fn reject_step(&mut self, t: f64) {
        self.block.end.copy_from_slice(&self.block.start);
        if self.growth.last > t {
            // The growth was reset within the step.
            self.forget(t);
        }
    }

    /// Prepares for crossing the guards in `falling`. The flow may jump there, so the vectors are
    /// orthonormalised before the next step.
    pub fn begin_event(&mut self, falling: &[usize]) {
        self.saltation.begin(falling);
        self.frame.require_next();
    }

    /// Eq. (21): `delta z(t) = Phi_t delta z_0`, over the last step up to its end, shortened or not.
    ///
    /// Eq. (22): `dPhi_t/dt = dF/dz . Phi_t`, the variational equation of each vector.
    pub fn advance(&mut self, law: Law<'_>, stepper: &mut dyn Stepper) {
        // Quadratures, which come last, do not count as motion.
        let n = self.dimension();
        let step = stepper.step();
        self.moved = self.moved || step.start[..n] != step.end[..n];
        if stepper.traits().is_stiff {
            // A stiff step can align the vectors within one step.
            self.frame.require_next();
        }
        stepper.propagate_tangents(law, &mut self.block);
        // At each step, because orthonormalisation replaces collapsed vectors by arbitrary ones.
        let (step, block) = (stepper.step_mut(), &mut self.block);
        law.settle(step.end_time, &mut step.end, (&mut block.end, block.width));
    }
}
