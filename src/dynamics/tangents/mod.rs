//! Eq. (20) to (22): the tangent flow, taken along with the state.
//!
//! The vectors are followed only after the step has been accepted: with an explicit method through the
//! very stages that the state has gone through, with an implicit one by a method of their own along
//! the dense output of the step.

mod bundle;
mod frame;
mod saltation;

use super::stepper::Stepper;
use super::{DynamicsError, Switching, System, Tally, lyapunov::Growth};
pub(super) use bundle::Bundle;
use frame::Frame;
pub(super) use saltation::{Crossing, Saltation};

/// Tangent vectors, and what becomes of them.
#[derive(Clone, Debug)]
pub(super) struct Tangents {
    pub bundle: Bundle,
    /// The measure of lengths, and the orthonormalisation.
    frame: Frame,
    /// What becomes of the vectors from step to step.
    upkeep: Upkeep,
    /// How the vectors have grown.
    growth: Growth,
    /// Whether the state has moved in any step since growth is counted.
    moved: bool,
    /// The correction at events.
    pub saltation: Saltation,
}

/// What becomes of tangent vectors from step to step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Upkeep {
    /// They are made orthonormal where they have grown apart, and their growth is kept.
    Orthonormal,
    /// They are left as the flow makes them.
    None,
}

impl Tangents {
    /// So many vectors for a system, for a method with so many slopes a step.
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize, seed: u64, stages: usize) -> Self {
        let numbers = sys.tangent_dim() * width;
        let mut tangents = Self {
            bundle: Bundle {
                width,
                start: vec![0.0; numbers],
                end: vec![0.0; numbers],
                stage: vec![0.0; numbers],
                slopes: vec![0.0; stages * numbers],
            },
            frame: Frame::new(sys, width, seed),
            upkeep: Upkeep::Orthonormal,
            growth: Growth::new(width),
            moved: false,
            saltation: Saltation::new(sys, width),
        };
        tangents.restart(0.0);
        tangents
    }

    /// Starts at time `t` (s) with the orthonormal vectors of the seed.
    pub fn restart(&mut self, t: f64) {
        self.frame.start(&mut self.bundle.end);
        self.bundle.start.copy_from_slice(&self.bundle.end);
        self.upkeep = Upkeep::Orthonormal;
        self.growth.clear(t);
        self.moved = false;
    }

    /// Goes on with these vectors, and leaves them to the flow.
    pub fn replace(&mut self, vectors: &[f64]) {
        self.bundle.end.copy_from_slice(vectors);
        self.bundle.start.copy_from_slice(vectors);
        self.upkeep = Upkeep::None;
    }

    /// Lets the next step, from time `t` (s) on, start where the last one ended, with the vectors
    /// made orthonormal where it is due.
    ///
    /// # Errors
    /// [`DynamicsError::Tangent`] for a vector that is not finite.
    pub fn follow(&mut self, t: f64) -> Result<(), DynamicsError> {
        if self.upkeep == Upkeep::Orthonormal && self.frame.is_due() {
            self.renew(t)?;
        }
        self.bundle.start.copy_from_slice(&self.bundle.end);
        Ok(())
    }

    /// Makes the vectors orthonormal, and keeps their growth up to time `t` (s).
    fn renew(&mut self, t: f64) -> Result<(), DynamicsError> {
        if t <= self.growth.last() {
            return Ok(());
        }
        self.frame.orthonormalise(&mut self.bundle.end);
        let logarithms = self.frame.logarithms();
        // A collapsed direction is minus infinity, an overflow is not.
        if let Some(vector) = logarithms
            .iter()
            .position(|x| x.is_nan() || *x == f64::INFINITY)
        {
            return Err(DynamicsError::Tangent { time: t, vector });
        }
        self.growth.push(t, logarithms);
        Ok(())
    }

    /// Forgets the growth up to time `t` (s), but not the directions.
    pub fn forget(&mut self, t: f64) {
        if self.upkeep == Upkeep::Orthonormal {
            self.frame.orthonormalise(&mut self.bundle.end);
        }
        self.growth.clear(t);
        self.moved = false;
    }

    /// Whether the state has moved in any step since growth is counted, by as little as a bit.
    pub fn moved(&self) -> bool {
        self.moved
    }

    /// Holds fixed in the vectors what a status held in the last step holds fixed in the state. At
    /// each step, since a new frame may have put any vectors in the place of those that vanished.
    pub fn settle_into(&mut self, switching: &dyn Switching, status: &[u8]) {
        switching.settle_tangents(status, &mut self.bundle.end, self.bundle.width);
    }

    /// The growth up to time `t` (s); `None` where vectors are left to the flow.
    pub fn growth(&self, t: f64) -> Option<Growth> {
        (self.upkeep == Upkeep::Orthonormal).then(|| {
            let mut now = self.clone();
            // Vectors that are not finite end the next step; up to the last frame all is well.
            match now.renew(t) {
                Ok(()) => now.growth,
                Err(_) => self.growth.clone(),
            }
        })
    }

    /// Components of a vector: how many exponents there are in all.
    pub fn dimension(&self) -> usize {
        self.bundle.end.len() / self.bundle.width
    }

    /// Takes the last step back, to its start at time `t` (s).
    pub fn rewind(&mut self, t: f64) {
        self.bundle.end.copy_from_slice(&self.bundle.start);
        if self.growth.last() > t {
            // The growth was forgotten within the step.
            self.forget(t);
        }
    }

    /// Guards that have fallen are about to be crossed, and the flow may jump: the vectors are made
    /// orthonormal before the next step.
    pub fn jump_begins(&mut self, falling: &[usize]) {
        self.saltation.begin(falling);
        self.frame.hasten();
    }

    /// Eq. (21): `delta z(t) = Phi_t delta z_0`, along the step that the stepper has just taken, up to
    /// where it ends or was cut.
    ///
    /// Eq. (22): `dPhi_t/dt = dF/dz . Phi_t`, the equation that each of the vectors obeys.
    pub fn advance<Y: System + ?Sized, M: Stepper>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stepper: &mut M,
        tally: &mut Tally,
    ) {
        // Quadratures, which come last, say nothing of the motion.
        let n = self.dimension();
        let step = stepper.step();
        self.moved = self.moved || step.start[..n] != step.end[..n];
        if stepper.rule().is_stiff {
            // What is stiff presses the vectors together within one step.
            self.frame.hasten();
        }
        stepper.carry(sys, status, &mut self.bundle, tally);
    }
}
