//! Tangent vectors and perturbed trajectory of an integration.
//!
//! Two integrations of nearby states with independent step control separate because of their different
//! local errors, long before the flow separates them. On identical steps the local errors are nearly
//! identical. A difference of even one millionth of the local error then grows at the rate of the flow.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::{Integrator, check_size};
use crate::auto::Steppers;
use crate::lyapunov::Growth;
use crate::step_controller::StepController;
use crate::stepper::Law;
use crate::tangents::Tangents;
use crate::{DynamicsError, LyapunovSpectrum, MIN_PERIODS_FOR_ZERO, Motion};

impl Integrator<'_> {
    /// Propagates `width` tangent vectors with the state from the next start on; `seed` sets their
    /// random initial directions. They give the `width` largest Lyapunov exponents.
    ///
    /// # Errors
    /// [`DynamicsError::MissingCapability`] if the system has no [`System::differentiable`](crate::System::differentiable),
    /// [`DynamicsError::TangentCount`] if `width` is zero or exceeds the dimension.
    pub fn with_tangents(mut self, width: usize, seed: u64) -> Result<Self, DynamicsError> {
        let sys = &*self.system;
        sys.differentiable()
            .ok_or(DynamicsError::MissingCapability {
                what: "derivative of the force",
                purpose: "Lyapunov exponents",
            })?;
        let dimension = sys.tangent_dim();
        if !(1..=dimension).contains(&width) {
            return Err(DynamicsError::TangentCount {
                asked: width,
                dimension,
            });
        }
        let slopes = self.stepper.enable_tangents(Law { sys, status: None });
        self.tangents = Some(Tangents::new(sys, width, seed, slopes));
        Ok(self)
    }

    /// The Lyapunov exponents from the growth of the tangent vectors up to [`Integrator::time`]; `None`
    /// without tangent vectors or with user-supplied ones ([`Integrator::set_tangent_vectors`]).
    pub fn exponents(&self) -> Option<LyapunovSpectrum> {
        let tangents = self.tangents.as_ref()?;
        Some(self.spectrum(tangents, &tangents.growth(self.time())?))
    }

    /// The Lyapunov exponents from the growth between two times (s), which are rounded inwards by up to a
    /// 64th of the time since the last reset. `None` as for [`Integrator::exponents`]; over no time the
    /// intervals are infinite.
    pub fn exponents_between(&self, from: f64, to: f64) -> Option<LyapunovSpectrum> {
        let tangents = self.tangents.as_ref()?;
        let growth = tangents.growth(self.time())?.between(from, to);
        Some(self.spectrum(tangents, &growth))
    }

    fn spectrum(&self, tangents: &Tangents, growth: &Growth) -> LyapunovSpectrum {
        let modes = self.system.omega().iter().copied();
        let slowest = modes
            .filter(|&omega| omega > 0.0)
            .fold(f64::INFINITY, f64::min);
        let mut spectrum =
            growth.spectrum(tangents.dimension(), MIN_PERIODS_FOR_ZERO * TAU / slowest);
        // An equilibrium is a point, whatever its exponents.
        if !tangents.moved {
            spectrum.kaplan_yorke = None;
        }
        spectrum
    }

    /// The type of motion that classification needs in addition to the exponents
    /// ([`LyapunovSpectrum::attractor_of`]). An equilibrium is recognised only if tangent vectors are
    /// propagated.
    pub fn motion(&self) -> Motion {
        match &self.tangents {
            Some(tangents) if !tangents.moved => Motion::Still,
            _ if self.system.is_autonomous() => Motion::Free,
            _ => Motion::Driven,
        }
    }

    /// Discards the accumulated growth of the tangent vectors but keeps the vectors, for use at the end
    /// of a transient.
    pub fn reset_growth(&mut self) {
        let t = self.time();
        if let Some(tangents) = &mut self.tangents {
            tangents.forget(t);
        }
    }

    /// The tangent vectors at [`Integrator::time`], `tangent_dim x width` numbers in the order of
    /// [`Differentiable::product`](crate::Differentiable::product); `None` without tangent
    /// vectors.
    pub fn tangent_vectors(&self) -> Option<&[f64]> {
        Some(&self.tangents.as_ref()?.block.end)
    }

    /// Replaces the tangent vectors at [`Integrator::time`] by `vectors`, in the order of
    /// [`Integrator::tangent_vectors`], and disables orthonormalisation until the next
    /// [`Integrator::start`]. The vectors then equal the derivative of the flow times the given vectors.
    /// Call it after [`Integrator::start`] or [`Integrator::integrate_to`]: at a time within a step the vectors
    /// would be assigned to the end of the step.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] if the number of values differs from `tangent_dim x width` of
    /// [`Integrator::with_tangents`].
    pub fn set_tangent_vectors(&mut self, vectors: &[f64]) -> Result<(), DynamicsError> {
        let needed = self
            .tangents
            .as_ref()
            .map_or(0, |tangents| tangents.block.end.len());
        check_size("the list of tangent vectors", needed, vectors.len())?;
        if let Some(tangents) = &mut self.tangents {
            tangents.replace(vectors);
        }
        Ok(())
    }

    /// Starts a perturbed trajectory at the present time from the state `z` (length [`System::dim`](crate::System::dim)) and
    /// replaces an existing one. It takes the same steps as the reference trajectory, whatever their
    /// error for it, and additional steps end only at its own events. The two trajectories therefore
    /// separate at the rate of the flow and not by local errors, however close they are. An exception is
    /// a step that only one of the two ends at an event: the local errors then differ.
    ///
    /// [`Integrator::integrate_to`] may revert the last step. A perturbed trajectory that has been sampled
    /// beyond one of its own events in that step cannot return to a time before the event; this is
    /// [`DynamicsError::Time`].
    ///
    /// # Errors
    /// Those of [`Integrator::start`].
    pub fn add_perturbed(&mut self, z: &[f64]) -> Result<(), DynamicsError> {
        let implicit = self.step_controller.implicit;
        let mut integrator = Integrator {
            system: Arc::clone(&self.system),
            stepper: Steppers::new(self.method, &*self.system)?,
            // Steps end where those of the reference trajectory end, whatever the error.
            step_controller: StepController::new(None, f64::INFINITY, implicit),
            events: self.events.clone(),
            tangents: None,
            perturbed: None,
            // The reference trajectory checks the stop flag for both.
            stop: None,
            ..*self
        };
        integrator.start(self.time(), z)?;
        self.perturbed = Some(PerturbedTrajectory {
            integrator: Box::new(integrator),
            start_time: self.time(),
        });
        Ok(())
    }

    /// Start time of the perturbed trajectory, s; `None` before [`Integrator::add_perturbed`] and after
    /// [`Integrator::integrate_to`] to an earlier time.
    pub fn perturbed_since(&self) -> Option<f64> {
        Some(self.perturbed.as_ref()?.start_time)
    }

    /// Writes the perturbed state at time `t` (s) to `out` (length [`System::dim`](crate::System::dim)), like
    /// [`Integrator::sample`].
    ///
    /// # Errors
    /// As for [`Integrator::sample`], and [`DynamicsError::MissingCapability`] without a perturbed trajectory.
    pub fn sample_perturbed(&mut self, t: f64, out: &mut [f64]) -> Result<(), DynamicsError> {
        self.advance_past(t, f64::INFINITY)?;
        let limit = self.time();
        let perturbed = self
            .perturbed
            .as_mut()
            .ok_or(DynamicsError::MissingCapability {
                what: "perturbed trajectory",
                purpose: "sampling it",
            })?;
        perturbed.integrator.advance_past(t, limit)?;
        perturbed.integrator.sample(t, out)
    }
}

/// A second state of a run: its steps end where those of the first end, and at its own events.
#[derive(Clone, Debug)]
pub(super) struct PerturbedTrajectory<'a> {
    pub integrator: Box<Integrator<'a>>,
    /// Time of its start, s.
    pub start_time: f64,
}
