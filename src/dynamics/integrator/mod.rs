//! The front: states at the times asked for, whatever the steps.

#[macro_use]
mod engine;

mod checks;
mod companions;
mod method;
mod neighbour;

use checks::{check_modes, check_size};
use engine::{Engine, LACKS_DERIVATIVE};
pub use method::{Method, MethodName};

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::control::{Control, Size};
use super::events::Events;
use super::pace::{Pace, Progress};
use super::stepper::{Stepper, switching};
use super::tangents::{Crossing, Tangents};
use super::{DynamicsError, ErrorEstimate, System, Tally};

/// Integrates a [`System`] and gives its state at any times in rising order.
///
/// The steps are the integrator's own; samples are interpolated ([`Integrator::sample`]). Where
/// the system itself changes at a known time, [`Integrator::land`] makes a step end there and
/// [`Integrator::restart`] goes on from there with the changed system.
///
/// The system is passed to each call and must stay the same between `start` or `restart` and the
/// next of these. Nothing is allocated after [`Integrator::new`]. When a step fails, the last good
/// state is still held by [`Integrator::state`].
#[derive(Clone, Debug)]
pub struct Integrator {
    engine: Engine,
    pace: Pace,
    /// The longest step by the method's parameters, s; the linear part may allow less.
    max_step: f64,
    dim: usize,
    /// The search for events, where steps stop at them.
    events: Option<Events>,
    /// The tangent vectors that go along, if any.
    tangents: Option<Tangents>,
    /// The neighbour that goes along, if any.
    neighbour: Option<Neighbour>,
    /// Looked at before each step, if any.
    stop: Option<Arc<AtomicBool>>,
}

/// A motion that ends its steps where another one does, and between them only at its own events. It holds an
/// [`Integrator`], as an integrator holds it.
#[derive(Clone, Debug)]
struct Neighbour {
    follower: Box<Integrator>,
    /// Since when it is there, s.
    born: f64,
    /// The first motion's steps that it has still to take.
    ends: VecDeque<Taken>,
}

/// A step that the first motion has taken.
#[derive(Clone, Copy, Debug)]
struct Taken {
    /// Its end, s.
    end: f64,
    is_implicit: bool,
}

impl Integrator {
    /// An integrator for systems of this one's size. It rests in the zero state at time zero until
    /// [`Integrator::start`].
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] for a parameter of the method out of its range,
    /// [`DynamicsError::Mode`] or [`DynamicsError::Size`] for a linear part that is no oscillation,
    /// [`DynamicsError::Lacks`] when an implicit method is asked for and the system has no
    /// [`System::differentiable`].
    pub fn new<Y: System + ?Sized>(method: Method, sys: &Y) -> Result<Self, DynamicsError> {
        let control = method.control()?;
        check_modes(sys)?;
        let dim = sys.dim();
        let engine = Engine::new(method, sys)?;
        let implicit = engine.needs_derivative();
        let max_step = control.step();
        let omega = sys.omega().to_vec();
        let pace = Pace {
            control,
            omega,
            size: Size::default(),
            implicit,
            progress: Progress::default(),
            tally: Tally::default(),
            largest_ratio: None,
        };
        let mut integrator = Self {
            engine,
            pace,
            max_step,
            dim,
            events: None,
            tangents: None,
            neighbour: None,
            stop: None,
        };
        integrator.limit_step();
        Ok(integrator)
    }

    /// Stops at events from the next start on: a status is held while a step lasts, and a step ends
    /// where a guard falls through zero. Without this, a system with kinks is stepped through, the
    /// law taken anew at each stage.
    ///
    /// Guards that fall within the rounding of the time are one event. Where events follow each
    /// other too fast to stop at each, more than 10,000 within the longest step, a system whose
    /// events jump nowhere ([`Switching::is_continuous`](super::Switching::is_continuous)) is stepped
    /// through until that time is over ([`Tally::overrun`]); for any other system that is an error.
    ///
    /// # Errors
    /// [`DynamicsError::Lacks`] when the system has no [`System::switching`].
    pub fn with_events<Y: System + ?Sized>(mut self, sys: &Y) -> Result<Self, DynamicsError> {
        let switching = sys.switching().ok_or(DynamicsError::Lacks {
            what: "guards",
            wish: "stopping at events",
        })?;
        self.events = Some(Events::new(switching, self.dim));
        Ok(self)
    }

    /// Takes no step any more once this flag is true: what would need one is
    /// [`DynamicsError::Stopped`]. What has been reached by then can still be sampled.
    pub fn heed(&mut self, stop: Arc<AtomicBool>) {
        self.stop = Some(stop);
    }

    /// Starts at time `t` (s) from the state `z` (length [`System::dim`]), forgetting all before
    /// but the [`Integrator::tally`], and any neighbour. Costs one call.
    ///
    /// # Errors
    /// Those of [`Integrator::restart`], and [`DynamicsError::Size`] when `z` has another length,
    /// [`DynamicsError::Time`] when `t` is not finite.
    pub fn start<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        z: &[f64],
    ) -> Result<(), DynamicsError> {
        check_size("the initial state", self.dim, z.len())?;
        if !t.is_finite() {
            return Err(DynamicsError::Time {
                asked: t,
                earliest: f64::MIN,
            });
        }
        with_stepper!(&mut self.engine, stepper => {
            let step = stepper.step_mut();
            step.end_time = t;
            step.end.copy_from_slice(z);
        });
        self.pace.size = Size::default();
        if let Some(tangents) = &mut self.tangents {
            tangents.restart(t);
        }
        self.neighbour = None;
        self.restart(sys)?;
        let rate = with_stepper!(&self.engine, stepper => self.pace.rate(stepper));
        if let Control::Adaptive(controller) = &mut self.pace.control {
            controller.start(t, self.pace.size, rate);
        }
        Ok(())
    }

    /// Goes on from the present time and state with a changed system of the same size, at the
    /// present length of the step. States before the present time are out of reach from now on.
    /// Costs one call. A neighbour goes on from where [`Integrator::land`] has led it.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] when the system has another size, [`DynamicsError::Mode`] when its
    /// linear part is no oscillation, [`DynamicsError::NonFinite`] when the present state or the
    /// right-hand side there is not finite.
    pub fn restart<Y: System + ?Sized>(&mut self, sys: &Y) -> Result<(), DynamicsError> {
        check_modes(sys)?;
        check_size(
            "the list of natural frequencies",
            self.pace.omega.len(),
            sys.modes(),
        )?;
        check_size("the state of the system", self.dim, sys.dim())?;
        if self.engine.needs_derivative() && sys.differentiable().is_none() {
            return Err(LACKS_DERIVATIVE);
        }
        self.pace.omega.copy_from_slice(sys.omega());
        with_stepper!(&mut self.engine, stepper => stepper.reread(sys));
        self.limit_step();
        with_stepper!(&mut self.engine, stepper => {
            let status = match &mut self.events {
                None => None,
                Some(events) => {
                    events.start(switching(sys), stepper.step().end_time, &stepper.step().end);
                    Some(events.status.as_slice())
                }
            };
            self.pace.refresh(stepper, sys, status)
        })?;
        match &mut self.neighbour {
            Some(neighbour) => neighbour.restart(sys),
            None => Ok(()),
        }
    }

    /// Writes the state at time `t` (s) to `out` (length [`System::dim`]), stepping past it as
    /// needed. Times must not go back before the start of the last step. At the very time of an
    /// event to come it is the state before it.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] when `out` has another length, [`DynamicsError::Time`] when `t` is
    /// out of reach, [`DynamicsError::NonFinite`], [`DynamicsError::StepUnderflow`] and
    /// [`DynamicsError::Chatter`] when the integration cannot go on, [`DynamicsError::Stopped`] when it
    /// was told not to ([`Integrator::heed`]).
    pub fn sample<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        check_size("the sample", self.dim, out.len())?;
        self.go_past(sys, t, f64::INFINITY)?;
        let status = self.events.as_ref().and_then(Events::held);
        with_stepper!(&mut self.engine, stepper => {
            if stepper.step().at_end(t).is_none() {
                // Where steps stop at events, that has been done under the status of the step.
                stepper.densify(sys, status, &mut self.pace.tally);
            }
            stepper.interpolate(t, out);
        });
        if let Some(status) = status {
            switching(sys).settle(status, t, out);
        }
        Ok(())
    }

    /// Makes a step end exactly at time `t` (s): then [`Integrator::time`] is `t` and
    /// [`Integrator::state`] the state there, at the method's full order. A step that has gone past
    /// `t` is taken again, shorter; the length of the steps that follow is not affected. At the
    /// very time of an event it is the state after it.
    ///
    /// # Errors
    /// [`DynamicsError::Time`] when `t` is out of reach, [`DynamicsError::NonFinite`],
    /// [`DynamicsError::StepUnderflow`] and [`DynamicsError::Chatter`] when the integration cannot
    /// go on, [`DynamicsError::Stopped`] when it was told not to.
    pub fn land<Y: System + ?Sized>(&mut self, sys: &Y, t: f64) -> Result<(), DynamicsError> {
        self.check_time(t)?;
        if self.time() > t {
            with_stepper!(&mut self.engine, stepper => self.pace.rewind(stepper));
            if let Some(neighbour) = &mut self.neighbour {
                neighbour.rewind();
            }
            self.neighbour.take_if(|neighbour| neighbour.born() > t);
            let start = self.time();
            if let Some(tangents) = &mut self.tangents {
                tangents.rewind(start);
            }
            if let Some(events) = &mut self.events {
                with_stepper!(&self.engine, stepper => {
                    events.look(switching(sys), stepper.step().end_time, &stepper.step().end);
                });
            }
        }
        self.go_past(sys, t, t)?;
        self.cross(sys)?;
        match &mut self.neighbour {
            Some(neighbour) => neighbour.catch_up(sys, t),
            None => Ok(()),
        }
    }

    /// Goes on to the next event, or to time `limit` (s) if there is none before it: then the time
    /// reached is `limit`. Returns the guards crossed, none for the limit; the state is the one
    /// after the crossing, and times before it are out of reach.
    ///
    /// # Errors
    /// As [`Integrator::land`].
    pub fn next_event<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        limit: f64,
    ) -> Result<&[usize], DynamicsError> {
        if self.time() > limit {
            self.land(sys, limit)?;
        }
        while self.pending().is_empty() && self.time() < limit {
            self.step(sys, limit)?;
        }
        if self.pending().is_empty() {
            return Ok(&[]);
        }
        self.cross(sys)?;
        Ok(self.events.as_ref().map_or(&[], |events| &events.crossed))
    }

    /// The present status, where steps stop at events; empty where they do not.
    pub fn status(&self) -> &[u8] {
        self.events.as_ref().map_or(&[], |events| &events.status)
    }

    /// The time reached, s: the end of the last step.
    pub fn time(&self) -> f64 {
        with_stepper!(&self.engine, stepper => stepper.step().end_time)
    }

    /// The state at [`Integrator::time`].
    pub fn state(&self) -> &[f64] {
        with_stepper!(&self.engine, stepper => &stepper.step().end)
    }

    /// The error allowed in a step, relative to the size of the state; `None` for a fixed step.
    pub fn tolerance(&self) -> Option<f64> {
        match &self.pace.control {
            Control::Fixed(_) => None,
            Control::Adaptive(controller) => Some(controller.tolerance()),
        }
    }

    /// Allows another error in a step, relative to the size of the state, from the next step on:
    /// 1e-13 to 0.1. A fixed step stays as it is.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] for one out of its range.
    pub fn with_tolerance(mut self, relative: f64) -> Result<Self, DynamicsError> {
        if let Control::Adaptive(controller) = &mut self.pace.control {
            controller.allow(relative)?;
        }
        Ok(self)
    }

    /// Whether the last step was an implicit one.
    pub fn is_implicit(&self) -> bool {
        match &self.engine {
            Engine::Rodas5p(_) => true,
            Engine::Auto(auto) => auto.is_implicit(),
            _ => false,
        }
    }

    /// Leaves the choice between explicit and implicit steps to someone else, where there is one.
    fn lead(&mut self, is_implicit: bool) {
        if let Engine::Auto(auto) = &mut self.engine {
            auto.lead(is_implicit);
        }
    }

    /// The length of the next full step, s.
    pub fn step_size(&self) -> f64 {
        self.pace.control.step()
    }

    /// Work done since [`Integrator::new`].
    pub fn tally(&self) -> Tally {
        self.pace.tally
    }

    /// The largest estimate of the local error among the steps accepted since it was last taken, or
    /// since [`Integrator::new`]; `None` where there was no step, or steps are fixed. A step that was
    /// cut at an event or taken back counts as a whole.
    pub fn take_error_estimate(&mut self) -> Option<ErrorEstimate> {
        let tolerance = self.tolerance()?;
        let ratio = self.pace.largest_ratio.take()?;
        Some(ErrorEstimate { ratio, tolerance })
    }

    /// Steps until time `t` (s) is reached, and no step past `limit` (s).
    fn go_past<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        limit: f64,
    ) -> Result<(), DynamicsError> {
        self.check_time(t)?;
        while self.time() < t {
            self.step(sys, limit)?;
        }
        Ok(())
    }

    /// The guards that are to be crossed before the next step.
    fn pending(&self) -> &[usize] {
        self.events.as_ref().map_or(&[], |events| &events.pending)
    }

    /// Takes one step, up to `limit` (s) or the first event, with all that goes along.
    fn step<Y: System + ?Sized>(&mut self, sys: &Y, limit: f64) -> Result<(), DynamicsError> {
        if let Some(stop) = &self.stop
            && stop.load(Ordering::Relaxed)
        {
            return Err(DynamicsError::Stopped { time: self.time() });
        }
        self.cross(sys)?;
        let Self {
            engine,
            pace,
            max_step,
            events,
            tangents,
            ..
        } = self;
        with_stepper!(engine, stepper => {
            if let Some(tangents) = tangents {
                tangents.follow(stepper.step().end_time)?;
            }
            let status = events.as_ref().and_then(Events::held);
            pace.step(stepper, sys, status, limit)?;
            let held = status.is_some();
            if let Some(events) = events {
                if events.has_guards() {
                    let status = events.held();
                    stepper.densify(sys, status, &mut pace.tally);
                }
                if !held {
                    let step = stepper.step();
                    events.overrun(switching(sys), step.end_time, &step.end);
                    events.pass(step.end_time, *max_step);
                    pace.tally.overrun += 1;
                } else if events.find(switching(sys), stepper, &mut pace.tally) {
                    pace.resize(stepper);
                }
            }
            if let Some(tangents) = tangents {
                let status = events.as_ref().filter(|_| held).map(|events| events.status.as_slice());
                tangents.advance(sys, status, stepper, &mut pace.tally);
                if let Some(status) = status {
                    tangents.settle_into(switching(sys), status);
                }
            }
        });
        let (end, is_implicit) = (self.time(), self.is_implicit());
        match &mut self.neighbour {
            Some(neighbour) => neighbour.note(sys, end, is_implicit),
            None => Ok(()),
        }
    }

    /// Crosses the guards at which the last step was cut, and all that this brings about.
    fn cross<Y: System + ?Sized>(&mut self, sys: &Y) -> Result<(), DynamicsError> {
        let Some(events) = self
            .events
            .as_mut()
            .filter(|events| !events.pending.is_empty())
        else {
            return Ok(());
        };
        let (pace, tangents) = (&mut self.pace, &mut self.tangents);
        let switching = switching(sys);
        let continuous = switching.is_continuous();
        with_stepper!(&mut self.engine, stepper => {
            let t = stepper.step().end_time;
            pace.tally.events += 1;
            events.crossed.clear();
            if let Some(tangents) = tangents.as_mut().filter(|_| !continuous) {
                tangents.jump_begins(&events.pending);
            }
            while let Some(&guard) = events.pending.first() {
                // Where the state may jump, one guard's jump may save another one from falling.
                let together = if continuous { events.pending.len() } else { 1 };
                for k in 0..together {
                    let guard = events.pending[k];
                    let crossing = Crossing { switching, guard, t };
                    if let Some(tangents) = tangents.as_mut().filter(|_| !continuous) {
                        tangents.saltation.before(sys, crossing, &events.status, &stepper.step().end);
                    }
                    switching.cross(guard, t, &mut stepper.step_mut().end, &mut events.status);
                    events.note(guard);
                    pace.tally.crossings += 1;
                    if let Some(tangents) = tangents.as_mut().filter(|_| !continuous) {
                        let bundle = &mut tangents.bundle;
                        let vectors = (bundle.end.as_mut_slice(), bundle.width);
                        let (status, end) = (&events.status, &stepper.step().end);
                        tangents.saltation.after(sys, crossing, status, end, vectors);
                    }
                }
                let chatters = events.count(t, self.max_step);
                if chatters && !continuous {
                    let crossings = events.recent();
                    return Err(DynamicsError::Chatter { time: t, guard, crossings });
                }
                events.look(switching, t, &stepper.step().end);
                if chatters {
                    events.pending.clear();
                }
            }
            pace.refresh(stepper, sys, Some(&events.status))
        })
    }

    /// Checks that a time is not before the last step.
    fn check_time(&self, t: f64) -> Result<(), DynamicsError> {
        let earliest = with_stepper!(&self.engine, stepper => stepper.step().start_time);
        if t >= earliest && t.is_finite() {
            Ok(())
        } else {
            Err(DynamicsError::Time { asked: t, earliest })
        }
    }

    /// Keeps the steps within what the parameters and the linear part allow.
    fn limit_step(&mut self) {
        if let Control::Adaptive(controller) = &mut self.pace.control {
            let longest = with_stepper!(&self.engine, stepper => stepper.longest_step());
            controller.limit(self.max_step.min(longest));
        }
    }
}
