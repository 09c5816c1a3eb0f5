//! The integrator: states at requested times, independent of the steps.

mod method;
mod nearby;

pub use method::{Method, MethodName};
use nearby::PerturbedTrajectory;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::auto::{NO_DERIVATIVE, Steppers};
use super::events::{Events, SearchedStep};
use super::step_controller::StepController;
use super::stepper::{Law, switching};
use super::tangents::Tangents;
use super::{DynamicsError, ErrorEstimate, SolverStats, Stopped, System};

/// Integrates a [`System`] and returns its state at any times in ascending order.
///
/// The integrator chooses its own steps and interpolates samples between them ([`Integrator::sample`]).
/// If the system changes at a known time, [`Integrator::integrate_to`] makes a step end there, and
/// [`Integrator::restart`] continues with the changed system.
///
/// The integrator borrows its system, or owns it if it is given a pointer such as an [`Arc`]. Steps and samples
/// allocate nothing. If a step fails, [`Integrator::state`] still returns the last accepted state.
#[derive(Clone, Debug)]
pub struct Integrator<'a> {
    system: Arc<dyn System + 'a>,
    stepper: Steppers,
    step_controller: StepController,
    method: Method,
    /// Event location, if enabled.
    events: Option<Events>,
    /// Tangent vectors, if enabled.
    tangents: Option<Tangents>,
    /// Perturbed trajectory, if enabled.
    perturbed: Option<PerturbedTrajectory<'a>>,
    /// Stop flag, checked before each step.
    stop: Option<Arc<AtomicBool>>,
}

impl<'a> Integrator<'a> {
    /// An integrator for a system. Its state is zero at time zero until [`Integrator::start`].
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] if a parameter of the method is out of range,
    /// [`DynamicsError::Mode`] or [`DynamicsError::Size`] for an invalid linear part,
    /// [`DynamicsError::MissingCapability`] if the method is implicit and the system has no
    /// [`System::differentiable`].
    pub fn new(method: Method, system: impl System + 'a) -> Result<Self, DynamicsError> {
        let step_controller = method.controller()?;
        check_modes(&system)?;
        let stepper = Steppers::new(method, &system)?;
        let mut integrator = Self {
            system: Arc::new(system),
            stepper,
            step_controller,
            method,
            events: None,
            tangents: None,
            perturbed: None,
            stop: None,
        };
        integrator.limit_step();
        Ok(integrator)
    }

    /// The system.
    pub fn system(&self) -> &(dyn System + 'a) {
        &*self.system
    }

    /// The system, without the integration.
    pub fn into_system(self) -> Arc<dyn System + 'a> {
        self.system
    }

    /// Enables event location from the next start on: the status is frozen during a step, and a step
    /// ends where a guard falls through zero. Without it the law of a non-smooth system is evaluated at
    /// each stage, and steps cross its kinks.
    ///
    /// Guard crossings within the rounding of the time are one event. More than 10,000 events within the
    /// maximum step count as chattering ([`Integrator::with_crossing_limit`] sets other limits). A system that is continuous at its events
    /// ([`Switching::is_continuous`](super::Switching::is_continuous)) is then integrated without event
    /// location for the rest of that interval ([`SolverStats::steps_without_event_location`]). For any other system chattering is
    /// an error.
    ///
    /// # Errors
    /// [`DynamicsError::MissingCapability`] if the system has no [`System::switching`].
    pub fn with_events(mut self) -> Result<Self, DynamicsError> {
        let switching = self
            .system
            .switching()
            .ok_or(DynamicsError::MissingCapability {
                what: "guards",
                purpose: "event location",
            })?;
        self.events = Some(Events::new(switching, self.method.max_step));
        Ok(self)
    }

    /// An integrator at time zero in a state, of which the quadratures may be missing; with event location if the system
    /// jumps. The whole state is returned, too.
    ///
    /// # Errors
    /// As [`Integrator::new`] and [`Integrator::start`].
    pub fn started(
        method: Method,
        system: &'a dyn System,
        state: &[f64],
    ) -> Result<(Self, Vec<f64>), DynamicsError> {
        let mut integrator = Self::new(method, system)?;
        if system.jumps() {
            integrator = integrator.with_events()?;
        }
        let mut z = state.to_vec();
        z.resize(system.dim(), 0.0);
        integrator.start(0.0, &z)?;
        Ok((integrator, z))
    }

    /// Sets the number of events within a time (s) above which the system chatters, after
    /// [`Integrator::with_events`].
    pub fn with_crossing_limit(mut self, events: usize, within: f64) -> Self {
        if let Some(known) = &mut self.events {
            (known.limit, known.window) = (events, within);
        }
        self
    }

    /// Sets a stop flag. Once it is true, an operation that needs another step returns
    /// [`DynamicsError::Stopped`]. Times reached by then can still be sampled.
    pub fn set_stop_flag(&mut self, stop: Arc<AtomicBool>) {
        self.stop = Some(stop);
    }

    /// Starts at time `t` (s) from the state `z` (length [`System::dim`]). The [`Integrator::stats`] is
    /// kept; the history and any perturbed trajectory are discarded. Costs one evaluation of the
    /// right-hand side.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] if `z` has a different length, [`DynamicsError::Time`] if `t` is not finite,
    /// [`DynamicsError::NonFinite`] if the state or the right-hand side there is not finite.
    pub fn start(&mut self, t: f64, z: &[f64]) -> Result<(), DynamicsError> {
        check_size("the initial state", self.state().len(), z.len())?;
        if !t.is_finite() {
            return Err(DynamicsError::Time {
                asked: t,
                earliest: f64::MIN,
            });
        }
        let step = self.stepper.step_mut();
        step.end_time = t;
        step.end.copy_from_slice(z);
        self.step_controller.forget_norm();
        if let Some(tangents) = &mut self.tangents {
            tangents.restart(t);
        }
        self.perturbed = None;
        self.begin()?;
        self.step_controller.start(&*self.stepper, &*self.system);
        Ok(())
    }

    /// Continues from the present time and state with a changed system of the same size, at the present
    /// step length. Earlier times can no longer be sampled. Costs one evaluation of the right-hand side.
    /// A perturbed trajectory continues from the time of the last [`Integrator::integrate_to`].
    ///
    /// # Errors
    /// [`DynamicsError::Size`] if the system has a different size, [`DynamicsError::Mode`] for an
    /// invalid linear part, [`DynamicsError::NonFinite`] if the present state or the right-hand side
    /// there is not finite.
    pub fn restart(&mut self, system: Arc<dyn System + 'a>) -> Result<(), DynamicsError> {
        check_modes(&*system)?;
        let modes = self.system.modes();
        check_size("the list of natural frequencies", modes, system.modes())?;
        check_size("the state of the system", self.state().len(), system.dim())?;
        if self.step_controller.implicit && system.differentiable().is_none() {
            return Err(NO_DERIVATIVE);
        }
        self.system = system;
        self.begin()?;
        match &mut self.perturbed {
            Some(perturbed) => {
                perturbed.integrator.system = Arc::clone(&self.system);
                perturbed.integrator.begin()
            }
            None => Ok(()),
        }
    }

    /// Begins at the present time and state.
    fn begin(&mut self) -> Result<(), DynamicsError> {
        let sys = &*self.system;
        self.stepper.explicit.form.update_linear_part(sys);
        self.limit_step();
        let sys = &*self.system;
        let status = self.events.as_mut().map(|events| {
            let step = self.stepper.step();
            events.start(switching(sys), step.end_time, &step.end);
            events.status.as_slice()
        });
        let law = Law { sys, status };
        self.step_controller.reinitialise(&mut *self.stepper, law)
    }

    /// Adds constants to the first components of the present state, one for each number of `by`, and the
    /// same constants to a perturbed trajectory: both change by a jump of the coordinates. Tangent vectors are
    /// differences of states and do not change. [`Integrator::restart`] must follow before the next step;
    /// [`Integrator::integrate_to`] comes before, so that both trajectories are at the same time.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] if there are more constants than components.
    pub fn translate(&mut self, by: &[f64]) -> Result<(), DynamicsError> {
        let dim = self.state().len();
        check_size("the translation", dim, by.len().max(dim))?;
        for (z, by) in self.stepper.step_mut().end.iter_mut().zip(by) {
            *z += by;
        }
        match &mut self.perturbed {
            Some(perturbed) => perturbed.integrator.translate(by),
            None => Ok(()),
        }
    }

    /// Writes the state at time `t` (s) to `out` (length [`System::dim`]) and takes the necessary steps.
    /// `t` must not be before the start of the last step. At the exact time of a pending event it is the
    /// state before the event.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] if `out` has a different length, [`DynamicsError::Time`] if `t` is not
    /// available, [`DynamicsError::NonFinite`], [`DynamicsError::StepUnderflow`] and
    /// [`DynamicsError::Chatter`] if the integration cannot continue, [`DynamicsError::Stopped`] if the
    /// stop flag is set ([`Integrator::set_stop_flag`]).
    pub fn sample(&mut self, t: f64, out: &mut [f64]) -> Result<(), DynamicsError> {
        check_size("the sample", self.state().len(), out.len())?;
        self.advance_past(t, f64::INFINITY)?;
        let law = Law {
            sys: &*self.system,
            status: self.events.as_ref().and_then(Events::frozen_status),
        };
        if self.stepper.step().at_end(t).is_none() {
            // With event location this was done under the status of the step.
            self.stepper.prepare_dense_output(law);
        }
        self.stepper.interpolate(t, out);
        law.settle(t, out, (&mut [], 0));
        Ok(())
    }

    /// Integrates to exactly time `t` (s): [`Integrator::time`] is then `t` and [`Integrator::state`]
    /// the state there, at the full order of the method. A step beyond `t` is repeated with a shorter
    /// length; the length of later steps is not affected. At the exact time of an event it is the state
    /// after the event.
    ///
    /// # Errors
    /// [`DynamicsError::Time`] if `t` is not available, [`DynamicsError::NonFinite`],
    /// [`DynamicsError::StepUnderflow`] and [`DynamicsError::Chatter`] if the integration cannot
    /// continue, [`DynamicsError::Stopped`] if the stop flag is set.
    pub fn integrate_to(&mut self, t: f64) -> Result<(), DynamicsError> {
        self.check_time(t)?;
        if self.time() > t {
            let sys = &*self.system;
            self.step_controller.reject_step(&mut self.stepper, sys);
            self.perturbed.take_if(|perturbed| perturbed.start_time > t);
            let step = self.stepper.step();
            if let Some(tangents) = &mut self.tangents {
                tangents.reject_step(step.end_time);
            }
            if let Some(events) = &mut self.events {
                events.find_negative(switching(sys), step.end_time, &step.end);
            }
        }
        self.advance_past(t, t)?;
        self.cross()?;
        match &mut self.perturbed {
            Some(perturbed) => perturbed.integrator.integrate_to(t),
            None => Ok(()),
        }
    }

    /// Integrates to the next event, or to time `limit` (s) if there is no earlier event. Returns the
    /// guards crossed; none at the limit. The state is the one after the event, and earlier times can no
    /// longer be sampled.
    ///
    /// # Errors
    /// As for [`Integrator::integrate_to`].
    pub fn next_event(&mut self, limit: f64) -> Result<&[usize], DynamicsError> {
        if self.time() > limit {
            self.integrate_to(limit)?;
        }
        while self.pending().is_empty() && self.time() < limit {
            self.step(limit)?;
        }
        if self.pending().is_empty() {
            return Ok(&[]);
        }
        self.cross()?;
        Ok(self.events.as_ref().map_or(&[], |events| &events.crossed))
    }

    /// The present status with event location; empty without it.
    pub fn status(&self) -> &[u8] {
        self.events.as_ref().map_or(&[], |events| &events.status)
    }

    /// The time reached, s: the end of the last step.
    pub fn time(&self) -> f64 {
        self.stepper.step().end_time
    }

    /// The state at [`Integrator::time`].
    pub fn state(&self) -> &[f64] {
        &self.stepper.step().end
    }

    /// The tolerance per step, relative to the norm of the state; `None` for a fixed step.
    pub fn tolerance(&self) -> Option<f64> {
        let accuracy = self.step_controller.accuracy;
        accuracy.map(|accuracy| accuracy.relative)
    }

    /// Sets the tolerance per step, relative to the norm of the state, from the next step on: 1e-13 to
    /// 0.1. It has no effect on a fixed step.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] if the tolerance is out of range.
    pub fn with_tolerance(mut self, relative: f64) -> Result<Self, DynamicsError> {
        if let Some(accuracy) = &mut self.step_controller.accuracy {
            accuracy.relative = relative;
            accuracy.check()?;
        }
        Ok(self)
    }

    /// Whether the last step was implicit.
    pub fn is_implicit(&self) -> bool {
        self.stepper.is_implicit
    }

    /// Length of the next full step, s.
    pub fn step_size(&self) -> f64 {
        self.step_controller.step
    }

    /// Work done since [`Integrator::new`], or since [`Integrator::reset_stats`].
    pub fn stats(&self) -> SolverStats {
        self.stepper.step().stats
    }

    /// Counts the work from here on.
    pub fn reset_stats(&mut self) {
        self.stepper.explicit.step.stats = SolverStats::default();
        if let Some(implicit) = &mut self.stepper.implicit {
            implicit.step.stats = SolverStats::default();
        }
    }

    /// The largest local error estimate of the steps accepted since the last call, or since
    /// [`Integrator::new`]; `None` without steps or for fixed steps. A step that was shortened at an
    /// event or reverted counts in full.
    pub fn take_error_estimate(&mut self) -> Option<ErrorEstimate> {
        let tolerance = self.tolerance()?;
        let ratio = self.step_controller.largest_ratio.take()?;
        Some(ErrorEstimate { ratio, tolerance })
    }

    /// Steps until time `t` (s) is reached; no step ends after `limit` (s).
    fn advance_past(&mut self, t: f64, limit: f64) -> Result<(), DynamicsError> {
        self.check_time(t)?;
        while self.time() < t {
            self.step(limit)?;
        }
        Ok(())
    }

    /// Guards to be crossed before the next step.
    fn pending(&self) -> &[usize] {
        self.events.as_ref().map_or(&[], |events| &events.pending)
    }

    /// Takes one step up to `limit` (s) or the first event, with tangent vectors and perturbed
    /// trajectory.
    fn step(&mut self, limit: f64) -> Result<(), DynamicsError> {
        if let Some(stop) = &self.stop
            && stop.load(Ordering::Relaxed)
        {
            return Err(Stopped.into());
        }
        let time = self.time();
        if let Some(PerturbedTrajectory { integrator, .. }) = &mut self.perturbed {
            // Its steps end where those of this trajectory end. Beyond an own event of a reverted step it goes on from there.
            if integrator.stepper.step().start_time <= time {
                integrator.integrate_to(time)?;
            }
        }
        self.cross()?;
        let Self {
            system,
            stepper,
            step_controller,
            events,
            tangents,
            perturbed,
            ..
        } = self;
        let sys = &**system;
        if let Some(tangents) = tangents {
            tangents.begin_step(stepper.step().end_time)?;
        }
        let status = events.as_ref().and_then(Events::frozen_status);
        step_controller.step(stepper, Law { sys, status }, limit)?;
        if let Some(PerturbedTrajectory { integrator, .. }) = perturbed {
            integrator.stepper.prescribed = Some(stepper.is_implicit);
        }
        let stepper = &mut **stepper;
        let held = status.is_some();
        if let Some(events) = events {
            if events.has_guards() {
                let status = events.frozen_status();
                stepper.prepare_dense_output(Law { sys, status });
            }
            if !held {
                let step = stepper.step_mut();
                events.skip_events(switching(sys), step.end_time, &step.end);
                events.update_window(step.end_time);
                step.stats.steps_without_event_location += 1;
            } else if events.find_first(SearchedStep {
                switching: switching(sys),
                stepper: &mut *stepper,
            }) {
                step_controller.update_norm(stepper, sys);
            }
        }
        if let Some(tangents) = tangents {
            let status = events
                .as_ref()
                .filter(|_| held)
                .map(|events| events.status.as_slice());
            tangents.advance(Law { sys, status }, stepper);
        }
        Ok(())
    }

    /// Crosses the guards at which the last step ended, and those that become negative as a result.
    fn cross(&mut self) -> Result<(), DynamicsError> {
        let Some(events) = self
            .events
            .as_mut()
            .filter(|events| !events.pending.is_empty())
        else {
            return Ok(());
        };
        let mut tangents = self.tangents.as_mut();
        let sys = &*self.system;
        let switching = switching(sys);
        let continuous = switching.is_continuous();
        let step = self.stepper.step_mut();
        let t = step.end_time;
        step.stats.events += 1;
        events.crossed.clear();
        if continuous {
            // Tangent vectors do not change.
            tangents = None;
        }
        if let Some(tangents) = &mut tangents {
            tangents.begin_event(&events.pending);
        }
        while let Some(&guard) = events.pending.first() {
            // If the state may jump, the jump of one guard can keep another guard from becoming
            // negative.
            let together = if continuous { events.pending.len() } else { 1 };
            for k in 0..together {
                let guard = events.pending[k];
                if let Some(tangents) = &mut tangents {
                    let (saltation, block) = (&mut tangents.saltation, &mut tangents.block);
                    let state = (events.status.as_slice(), step.end.as_slice());
                    saltation.before(switching, (guard, t), state, block);
                }
                switching.cross(guard, t, &mut step.end, &mut events.status);
                events.record_crossing(guard);
                step.stats.crossings += 1;
                if let Some(tangents) = &mut tangents {
                    let (saltation, block) = (&mut tangents.saltation, &mut tangents.block);
                    let state = (events.status.as_slice(), step.end.as_slice());
                    saltation.after(switching, t, state, block);
                }
            }
            let chatters = events.count_event(t);
            if chatters && !continuous {
                let crossings = events.events_in_window;
                return Err(DynamicsError::Chatter {
                    time: t,
                    guard,
                    crossings,
                });
            }
            events.find_negative(switching, t, &step.end);
            if chatters {
                events.pending.clear();
            }
        }
        let status = Some(events.status.as_slice());
        let law = Law { sys, status };
        self.step_controller.reinitialise(&mut *self.stepper, law)
    }

    /// Checks that a time is not before the start of the last step.
    fn check_time(&self, t: f64) -> Result<(), DynamicsError> {
        let earliest = self.stepper.step().start_time;
        if t >= earliest && t.is_finite() {
            Ok(())
        } else {
            Err(DynamicsError::Time { asked: t, earliest })
        }
    }

    /// Limits the step to the maximum of the parameters and of the linear part.
    fn limit_step(&mut self) {
        let longest = self.stepper.explicit.form.max_step_of_linear_part();
        let longest = self.method.max_step.min(longest);
        self.step_controller.set_max_step(longest);
    }
}

/// Checks that every mode is an oscillator.
fn check_modes(sys: &dyn System) -> Result<(), DynamicsError> {
    if !sys.damping().is_empty() {
        check_size(
            "the list of damping ratios",
            sys.modes(),
            sys.damping().len(),
        )?;
    }
    for (mode, &omega) in sys.omega().iter().enumerate() {
        let damping = sys.damping().get(mode).copied().unwrap_or(0.0);
        if !(omega >= 0.0 && omega.is_finite() && damping.abs() < 1.0) {
            return Err(DynamicsError::Mode {
                mode,
                omega,
                damping,
            });
        }
    }
    Ok(())
}

/// Checks the length of a slice.
fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), DynamicsError> {
    if expected == found {
        Ok(())
    } else {
        Err(DynamicsError::Size {
            what,
            expected,
            found,
        })
    }
}
