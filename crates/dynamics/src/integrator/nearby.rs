//! Tangent vectors and perturbed trajectory of an integration.

use std::f64::consts::TAU;

use super::{Integrator, PerturbedTrajectory, check_size};
use crate::lyapunov::Growth;
use crate::step_controller::{Progress, StepController};
use crate::tangents::Tangents;
use crate::{DynamicsError, LyapunovSpectrum, MIN_PERIODS_FOR_ZERO, Motion, SolverStats, System};

impl Integrator {
    /// Propagates `width` tangent vectors with the state from the next start on; `seed` sets their
    /// random initial directions. They give the `width` largest Lyapunov exponents.
    ///
    /// # Errors
    /// [`DynamicsError::MissingCapability`] if the system has no [`System::differentiable`],
    /// [`DynamicsError::TangentCount`] if `width` is zero or exceeds the dimension.
    pub fn with_tangents(
        mut self,
        sys: &dyn System,
        width: usize,
        seed: u64,
    ) -> Result<Self, DynamicsError> {
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
        let slopes = self.stepper.enable_tangents(sys);
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
        let modes = self
            .step_controller
            .omega
            .iter()
            .filter(|&&omega| omega > 0.0);
        let slowest = modes.copied().fold(f64::INFINITY, f64::min);
        let mut spectrum =
            growth.spectrum(tangents.dimension(), MIN_PERIODS_FOR_ZERO * TAU / slowest);
        // An equilibrium is a point, whatever its exponents.
        if !tangents.moved() {
            spectrum.kaplan_yorke = None;
        }
        spectrum
    }

    /// The type of motion that classification needs in addition to the exponents
    /// ([`LyapunovSpectrum::attractor_of`]). An equilibrium is recognised only if tangent vectors are
    /// propagated.
    pub fn motion(&self, sys: &dyn System) -> Motion {
        match &self.tangents {
            Some(tangents) if !tangents.moved() => Motion::Still,
            _ if sys.is_autonomous() => Motion::Free,
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

    /// Starts a perturbed trajectory at the present time from the state `z` (length [`System::dim`]) and
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
    pub fn add_perturbed(&mut self, sys: &dyn System, z: &[f64]) -> Result<(), DynamicsError> {
        self.perturbed = Some(PerturbedTrajectory::new(self, sys, z)?);
        Ok(())
    }

    /// Start time of the perturbed trajectory, s; `None` before [`Integrator::add_perturbed`] and after
    /// [`Integrator::integrate_to`] to an earlier time.
    pub fn perturbed_since(&self) -> Option<f64> {
        Some(self.perturbed.as_ref()?.start_time)
    }

    /// Writes the perturbed state at time `t` (s) to `out` (length [`System::dim`]), like
    /// [`Integrator::sample`].
    ///
    /// # Errors
    /// As for [`Integrator::sample`], and [`DynamicsError::MissingCapability`] without a perturbed trajectory.
    pub fn sample_perturbed(
        &mut self,
        sys: &dyn System,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.advance_past(sys, t, f64::INFINITY)?;
        let perturbed = self
            .perturbed
            .as_mut()
            .ok_or(DynamicsError::MissingCapability {
                what: "perturbed trajectory",
                purpose: "sampling it",
            })?;
        perturbed.sample(sys, t, out)
    }

    /// A copy without tangent vectors and perturbed trajectory, with its own counters.
    pub(super) fn without_nearby(&self) -> Self {
        let mut stepper = self.stepper.clone();
        stepper.disable_tangents();
        Self {
            stepper,
            step_controller: StepController {
                progress: Progress::default(),
                stats: SolverStats::default(),
                largest_ratio: None,
                ..self.step_controller.clone()
            },
            events: self.events.clone(),
            tangents: None,
            perturbed: None,
            // The reference integrator checks the stop flag for both.
            stop: None,
            ..*self
        }
    }
}
