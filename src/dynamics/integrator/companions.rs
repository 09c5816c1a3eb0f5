//! What goes along with a motion: tangent vectors and a neighbour.

use std::f64::consts::TAU;

use super::checks::check_size;
use super::{Engine, Integrator, Neighbour};
use crate::dynamics::pace::{Pace, Progress};
use crate::dynamics::stepper::Stepper;
use crate::dynamics::tangents::Tangents;
use crate::dynamics::{DynamicsError, LyapunovSpectrum, Motion, PERIODS_FOR_ZERO, System, Tally};

impl Integrator {
    /// Follows so many tangent vectors, `width`, along with the state from the next start on; `seed`
    /// gives their first directions. They give the largest exponents, or all of them.
    ///
    /// # Errors
    /// [`DynamicsError::Lacks`] when the system has no [`System::differentiable`],
    /// [`DynamicsError::Width`] for more vectors than dimensions, or none.
    pub fn with_tangents<Y: System + ?Sized>(
        mut self,
        sys: &Y,
        width: usize,
        seed: u64,
    ) -> Result<Self, DynamicsError> {
        sys.differentiable().ok_or(DynamicsError::Lacks {
            what: "derivative of its force",
            wish: "exponents",
        })?;
        let dimension = sys.tangent_dim();
        if !(1..=dimension).contains(&width) {
            return Err(DynamicsError::Width {
                asked: width,
                dimension,
            });
        }
        let slopes = with_stepper!(&mut self.engine, stepper => stepper.record(sys));
        self.tangents = Some(Tangents::new(sys, width, seed, slopes));
        Ok(self)
    }

    /// The exponents by the growth of the tangent vectors up to [`Integrator::time`]; `None` where
    /// none are followed, or vectors of one's own ([`Integrator::follow_vectors`]).
    pub fn exponents(&self) -> Option<LyapunovSpectrum> {
        let tangents = self.tangents.as_ref()?;
        let growth = tangents.growth(self.time())?;
        let modes = self.pace.omega.iter().filter(|&&omega| omega > 0.0);
        let slowest = modes.copied().fold(f64::INFINITY, f64::min);
        let patience = PERIODS_FOR_ZERO * TAU / slowest;
        Some(growth.spectrum(tangents.dimension(), patience))
    }

    /// What is known, beside the exponents, of the motion that they belong to
    /// ([`LyapunovSpectrum::attractor_of`]). Whether the state has moved is seen only along with
    /// tangent vectors.
    pub fn motion<Y: System + ?Sized>(&self, sys: &Y) -> Motion {
        match &self.tangents {
            Some(tangents) if !tangents.moved() => Motion::Still,
            _ if sys.is_autonomous() => Motion::Free,
            _ => Motion::Driven,
        }
    }

    /// Forgets the growth of the tangent vectors so far, but not the vectors: the transient is over.
    pub fn forget_growth(&mut self) {
        let t = self.time();
        if let Some(tangents) = &mut self.tangents {
            tangents.forget(t);
        }
    }

    /// The tangent vectors at [`Integrator::time`], `tangent_dim x width` numbers in the order of
    /// [`Differentiable::product`](crate::dynamics::Differentiable::product); `None` where none are followed.
    pub fn tangent_vectors(&self) -> Option<&[f64]> {
        Some(&self.tangents.as_ref()?.bundle.end)
    }

    /// Takes these vectors, in the order of [`Integrator::tangent_vectors`], as the tangent vectors
    /// at [`Integrator::time`], and never makes them orthonormal, so that they become the flow's
    /// derivative times the vectors given; until the next [`Integrator::start`]. To be called where
    /// [`Integrator::start`] or [`Integrator::land`] has led: at a time within a step the vectors
    /// would come too early.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] when there are not as many numbers as [`Integrator::with_tangents`]
    /// has made room for.
    pub fn follow_vectors(&mut self, vectors: &[f64]) -> Result<(), DynamicsError> {
        let room = self
            .tangents
            .as_ref()
            .map_or(0, |tangents| tangents.bundle.end.len());
        check_size("the list of tangent vectors", room, vectors.len())?;
        if let Some(tangents) = &mut self.tangents {
            tangents.replace(vectors);
        }
        Ok(())
    }

    /// Lets a neighbour go along from the present time on, from the state `z` (length
    /// [`System::dim`]), in place of any there was. It takes the steps that this motion takes,
    /// whatever they come to for it, and beyond these ends its steps only at its own events: however
    /// near the two are, they part as the flow parts them, and not by the errors of their steps;
    /// but for steps that only one of the two has cut at an event, whose errors differ.
    ///
    /// [`Integrator::land`] may take the last step back. A neighbour that has been sampled past an
    /// event of its own in that step cannot go back before that event: landing there is
    /// [`DynamicsError::Time`].
    ///
    /// # Errors
    /// Those of [`Integrator::start`].
    pub fn add_neighbour<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        z: &[f64],
    ) -> Result<(), DynamicsError> {
        self.neighbour = Some(Neighbour::new(self, sys, z)?);
        Ok(())
    }

    /// Since when there is a neighbour, s; `None` where there is none: before
    /// [`Integrator::add_neighbour`], and after [`Integrator::land`] has led to a time before that.
    pub fn neighbour_since(&self) -> Option<f64> {
        self.neighbour.as_ref().map(Neighbour::born)
    }

    /// Writes the neighbour's state at time `t` (s) to `out` (length [`System::dim`]), as
    /// [`Integrator::sample`] writes that of this motion.
    ///
    /// # Errors
    /// As [`Integrator::sample`]; [`DynamicsError::Lacks`] where there is no neighbour.
    pub fn sample_neighbour<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.go_past(sys, t, f64::INFINITY)?;
        let neighbour = self.neighbour.as_mut().ok_or(DynamicsError::Lacks {
            what: "neighbour",
            wish: "a sample of it",
        })?;
        neighbour.sample(sys, t, out)
    }

    /// A copy without what goes along, and with a tally of its own.
    pub(super) fn alone(&self) -> Self {
        let mut engine = self.engine.clone();
        with_stepper!(&mut engine, stepper => stepper.forget_records());
        Self {
            engine,
            pace: Pace {
                progress: Progress::default(),
                tally: Tally::default(),
                largest_ratio: None,
                ..self.pace.clone()
            },
            events: self.events.clone(),
            tangents: None,
            neighbour: None,
            // Whom it goes along with stops for both.
            stop: None,
            ..*self
        }
    }
}
