//! Eq. (20) to (22): the tangent flow, taken along with the state.
//!
//! The vectors go through the very stages of the step that the state has taken, so that what they
//! give is the derivative of the numerical flow itself, whatever its tolerance. They are followed
//! only after the step has been accepted.

mod frame;
mod saltation;

use super::stepper::{Picture, Stepper, accumulate, differentiable};
use super::{DynamicsError, Switching, System, lyapunov::Growth};
use frame::Frame;
pub(super) use saltation::Saltation;

/// Tangent vectors side by side, component after component: component `c` of vector `l` is at
/// `c * width + l`.
#[derive(Clone, Debug)]
pub(super) struct Tangents {
    /// The number of vectors.
    pub width: usize,
    /// At the start of the last step.
    start: Vec<f64>,
    /// At the end of the last step, `tangent_dim x width`.
    pub end: Vec<f64>,
    /// At a stage.
    stage: Vec<f64>,
    /// Slopes at the stages, `stages x tangent_dim x width`.
    slopes: Vec<f64>,
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
    /// So many vectors for a system, for a method of so many stages.
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize, seed: u64, stages: usize) -> Self {
        let numbers = sys.tangent_dim() * width;
        let mut tangents = Self {
            width,
            start: vec![0.0; numbers],
            end: vec![0.0; numbers],
            stage: vec![0.0; numbers],
            slopes: vec![0.0; stages * numbers],
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
        self.frame.start(&mut self.end);
        self.start.copy_from_slice(&self.end);
        self.upkeep = Upkeep::Orthonormal;
        self.growth.clear(t);
        self.moved = false;
    }

    /// Goes on with these vectors, and leaves them to the flow.
    pub fn replace(&mut self, vectors: &[f64]) {
        self.end.copy_from_slice(vectors);
        self.start.copy_from_slice(vectors);
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
        self.start.copy_from_slice(&self.end);
        Ok(())
    }

    /// Makes the vectors orthonormal, and keeps their growth up to time `t` (s).
    fn renew(&mut self, t: f64) -> Result<(), DynamicsError> {
        if t <= self.growth.last() {
            return Ok(());
        }
        self.frame.orthonormalise(&mut self.end);
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
            self.frame.orthonormalise(&mut self.end);
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
        switching.settle_tangents(status, &mut self.end, self.width);
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
        self.end.len() / self.width
    }

    /// Takes the last step back, to its start at time `t` (s).
    pub fn rewind(&mut self, t: f64) {
        self.end.copy_from_slice(&self.start);
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

    /// Eq. (21): `delta z(t) = Phi_t delta z_0`, by the stages that the stepper has just gone
    /// through, up to where its step ends or was cut.
    ///
    /// Eq. (22): `dPhi_t/dt = dF/dz . Phi_t`, the equation that each of the vectors obeys.
    pub fn advance<Y: System + ?Sized, P: Picture, const S: usize>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stepper: &mut Stepper<P, S>,
    ) {
        let (width, numbers) = (self.width, self.end.len());
        // Quadratures, which come last, say nothing of the motion.
        let n = self.dimension();
        self.moved = self.moved || stepper.start[..n] != stepper.end[..n];
        let derivative = differentiable(sys);
        let tableau = stepper.tableau;
        let h = stepper.length();
        // The last stage sits at the end of the step, and only the dense output needs its slope.
        let stages = if stepper.is_cut() { S } else { S - 1 };
        for stage in 0..stages {
            self.stage.copy_from_slice(&self.start);
            if stage > 0 {
                let weights = &tableau.stages[stage][..stage];
                accumulate(&mut self.stage, h, &self.slopes, weights);
                stepper.picture.push(stage, &mut self.stage, width);
            }
            let slope = &mut self.slopes[stage * numbers..][..numbers];
            derivative.product(
                status,
                &mut stepper.records[stage],
                &self.stage,
                width,
                &mut slope[sys.modes() * width..],
            );
            stepper.picture.complete(sys, &self.stage, slope, width);
            if stage > 0 {
                stepper.picture.pull(stage, slope, width);
            }
        }
        self.end.copy_from_slice(&self.start);
        if stepper.is_cut() {
            let offset = stepper.end_time - stepper.start_time;
            accumulate(&mut self.end, h, &self.slopes, &tableau.weights(offset / h));
            stepper.picture.push_by(offset, &mut self.end, width);
        } else {
            accumulate(
                &mut self.end,
                h,
                &self.slopes,
                &tableau.stages[S - 1][..S - 1],
            );
            stepper.picture.push(S - 1, &mut self.end, width);
        }
    }
}
