//! Switching between explicit and implicit steps as the motion becomes stiff and ceases to be.
//!
//! Slip that comes to rest makes a joint stiff for a while: what it feels of friction changes from a
//! force that hardly depends on the velocity to a strong damper. The exponential pair of order 5(4)
//! then is held down by stability, and the method of Rosenbrock and Wanner takes over; it hands back
//! when its own steps are so short that the explicit method could go as far at the same price.
//!
//! What decides is `h rho`, with the length of the step `h` and the fastest rate of the force `rho`
//! (1/s), against the stretch of the negative axis on which the explicit method is stable:
//!
//! * in explicit steps `rho` is the change of the force over that of the state between the last two
//!   stages, which sit at the same time (E. Hairer, G. Wanner, Solving Ordinary Differential Equations
//!   II, 2nd ed., Springer 1996, Section IV.2). Steps held down by stability come near the bound again
//!   and again; [`PATIENCE`] of them, with few others between, are enough, and more each time after
//!   the implicit steps were in vain;
//! * in implicit steps it is the largest eigenvalue of the force's Jacobian, by the power method.
//!   [`HASTE`] steps that lie within [`WORTH`] times the bound are enough, and more each time after
//!   the explicit steps were in vain.
//!
//! Both rates are those of a smooth law, and a law as sharp as dry friction can hide from them: explicit
//! steps then hop from one side of rest to the other, far beyond the creep region in which the law is
//! steep, and what they see of it is the jump of a force over a change of velocity that the step itself
//! has made, `h rho` about 1, however short the step. What tells is how far the other method got. So
//! the mean step of each is remembered while the other is at work, explicit steps [`PRICE`] times as
//! short as implicit ones count as held down, and implicit steps are tried where explicit ones have
//! become shorter than [`TINY`] for no reason that the rates know of.
//!
//! A change costs one call. Both methods have dense output of order 4.

use super::control::{Rule, Size};
use super::exponential::Interaction;
use super::rosenbrock::Rosenbrock;
use super::runge_kutta::RungeKutta;
use super::stepper::{Step, Stepper};
use super::tangents::Bundle;
use super::{System, Tally};

/// The pair of Tsitouras is stable for real rates up to this over the step.
const BOUND: f64 = 3.5;

/// Part of the bound above which an explicit step counts as held down by stability. The control of the
/// error keeps a good distance from the bound.
const NEAR: f64 = 0.5;

/// So many explicit steps held down by stability call for implicit ones, at first.
const PATIENCE: u32 = 15;

/// And at most so many.
const MOST_PATIENCE: u32 = 480;

/// Fewer implicit steps than this were in vain.
const BRIEF: u32 = 12;

/// So many explicit steps that are not, one after another, make up for those that were.
const RELIEF: u32 = 6;

/// Bounds within which an implicit step is too short to be worth its price, that of about three explicit
/// ones.
const WORTH: f64 = 2.5;

/// So many implicit steps that are too short, one after another, call for explicit ones, at first.
const HASTE: u32 = 3;

/// And at most so many.
const MOST_HASTE: u32 = 480;

/// Explicit steps for the price of an implicit one.
const PRICE: f64 = 3.0;

/// Explicit steps shorter than this over the fastest natural frequency follow no vibration: something
/// else holds them down.
const TINY: f64 = 1e-3;

/// Both methods, of which one is at work.
#[derive(Clone, Debug)]
pub(super) struct Auto {
    explicit: RungeKutta<Interaction, 7>,
    implicit: Rosenbrock,
    is_implicit: bool,
    watch: Watch,
    /// Which one is to be at work, whatever the watch says.
    led: Option<bool>,
    /// A difference of two states, or of their slopes, without quadratures.
    difference: Vec<f64>,
}

/// Looks out for steps that the other method should take.
#[derive(Clone, Copy, Debug)]
struct Watch {
    /// `h rho` of the last step tried, until it has been counted.
    last: Option<f64>,
    /// Steps that speak for the other method.
    hits: u32,
    /// Steps since then that do not.
    misses: u32,
    /// Steps of the method at work.
    stay: u32,
    /// The time that they have covered, s.
    covered: f64,
    /// Mean step of the other method when it was last at work, s; zero before.
    other: f64,
    /// Explicit steps that it takes to call for implicit ones: more after those have been in vain.
    patience: u32,
    /// Implicit steps that it takes to call for explicit ones: more after those have been in vain.
    haste: u32,
}

impl Watch {
    fn new() -> Self {
        Self {
            last: None,
            hits: 0,
            misses: 0,
            stay: 0,
            covered: 0.0,
            other: 0.0,
            patience: PATIENCE,
            haste: HASTE,
        }
    }

    /// Starts afresh, the other method at work.
    fn change(&mut self, was_implicit: bool) {
        let mean = self.covered / f64::from(self.stay.max(1));
        let (mut patience, mut haste) = (self.patience, self.haste);
        if was_implicit {
            // Implicit steps that got no further for their price were in vain, as far as that is known.
            let further = self.other > 0.0 && mean > PRICE * self.other;
            patience = if self.stay < BRIEF && !further {
                MOST_PATIENCE.min(2 * patience)
            } else {
                PATIENCE
            };
        } else if self.other > 0.0 {
            haste = if PRICE * mean < self.other {
                MOST_HASTE.min(2 * haste)
            } else {
                HASTE
            };
        }
        *self = Self {
            other: mean,
            patience,
            haste,
            ..Self::new()
        };
    }

    /// Counts the last step, of length `h` (s), of a system whose fastest natural frequency is `omega`
    /// (rad/s); whether the other method should take the next one.
    fn is_due(&mut self, is_implicit: bool, h: f64, omega: f64) -> bool {
        let Some(last) = self.last.take() else {
            return false;
        };
        self.stay += 1;
        self.covered += h;
        let (hit, enough, relief) = if is_implicit {
            (last < WORTH * BOUND, self.haste, 1)
        } else {
            // After a change of the law the last step has no length.
            let short = h > 0.0 && (PRICE * h < self.other || h * omega < TINY);
            (last > NEAR * BOUND || short, self.patience, RELIEF)
        };
        if hit {
            self.hits += 1;
            self.misses = 0;
        } else {
            self.misses += 1;
            if self.misses >= relief {
                self.hits = 0;
            }
        }
        self.hits >= enough
    }
}

/// Does the same with whichever method is at work.
macro_rules! at_work {
    ($auto:expr, $stepper:ident => $body:expr) => {
        if $auto.is_implicit {
            let $stepper = &mut $auto.implicit;
            $body
        } else {
            let $stepper = &mut $auto.explicit;
            $body
        }
    };
}

impl Auto {
    pub fn new(explicit: RungeKutta<Interaction, 7>, implicit: Rosenbrock, n: usize) -> Self {
        Self {
            explicit,
            implicit,
            is_implicit: false,
            watch: Watch::new(),
            led: None,
            difference: vec![0.0; n],
        }
    }

    /// Whether the implicit method is at work.
    pub fn is_implicit(&self) -> bool {
        self.is_implicit
    }

    /// Leaves the choice to someone else: from the next step on, this one.
    pub fn lead(&mut self, is_implicit: bool) {
        self.led = Some(is_implicit);
    }

    /// Puts the other method to work.
    fn switch<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        let (from, to) = (&mut self.explicit.step, &mut self.implicit.step);
        let (from, to) = if self.is_implicit {
            (to, from)
        } else {
            (from, to)
        };
        to.end_time = from.end_time;
        to.end.copy_from_slice(&from.end);
        self.watch.change(self.is_implicit);
        self.is_implicit = !self.is_implicit;
        tally.switches += 1;
        at_work!(self, stepper => stepper.refresh(sys, status, tally));
    }

    /// `h rho` of the explicit step just tried.
    fn explicit_rate(&mut self, omega: &[f64]) -> f64 {
        let RungeKutta {
            tableau,
            step,
            slopes,
            ..
        } = &self.explicit;
        let (dim, h, end) = (step.dim(), step.length(), tableau.end);
        let out = &mut self.difference;
        let size = |z: &[f64]| {
            let size = Size::of(z, omega);
            size.vibration + size.first_order
        };
        let rows = slopes[(end - 1) * dim..(end + 1) * dim].split_at(dim);
        for (out, (before, last)) in out.iter_mut().zip(rows.0.iter().zip(rows.1)) {
            *out = last - before;
        }
        let change = size(out);
        for (c, out) in out.iter_mut().enumerate() {
            let weights = tableau.stages[end].iter().zip(&tableau.stages[end - 1]);
            let terms = weights.enumerate();
            *out = terms.map(|(j, (b, a))| (b - a) * slopes[j * dim + c]).sum();
        }
        let apart = size(out);
        // Below this it is made of rounding errors.
        if h * apart > 1e-13 * size(&step.end[..out.len()]) {
            change / apart
        } else {
            0.0
        }
    }
}

impl Stepper for Auto {
    fn step(&self) -> &Step {
        if self.is_implicit {
            &self.implicit.step
        } else {
            &self.explicit.step
        }
    }

    fn step_mut(&mut self) -> &mut Step {
        at_work!(self, stepper => stepper.step_mut())
    }

    fn rule(&self) -> &'static Rule {
        if self.is_implicit {
            self.implicit.rule()
        } else {
            self.explicit.rule()
        }
    }

    fn reread<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.explicit.reread(sys);
    }

    fn longest_step(&self) -> f64 {
        self.explicit.longest_step()
    }

    fn refresh<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        at_work!(self, stepper => stepper.refresh(sys, status, tally));
    }

    fn follow<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        let fastest = sys.omega().iter().fold(0.0, |a: f64, b| a.max(*b));
        let h = self.step().length();
        let due = self.watch.is_due(self.is_implicit, h, fastest);
        if self.led.map_or(due, |led| led != self.is_implicit) {
            self.switch(sys, status, tally);
        }
        at_work!(self, stepper => stepper.follow(sys, status, tally));
    }

    fn rewind(&mut self) {
        self.watch.last = None;
        at_work!(self, stepper => stepper.rewind());
    }

    fn attempt<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        end_time: f64,
        tally: &mut Tally,
    ) {
        at_work!(self, stepper => stepper.attempt(sys, status, end_time, tally));
        self.watch.last = Some(if self.is_implicit {
            self.implicit.step.length() * self.implicit.fastest_rate
        } else {
            self.explicit_rate(sys.omega())
        });
    }

    fn error(&self, omega: &[f64]) -> Size {
        if self.is_implicit {
            self.implicit.error(omega)
        } else {
            self.explicit.error(omega)
        }
    }

    fn densify<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        at_work!(self, stepper => stepper.densify(sys, status, tally));
    }

    fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        at_work!(self, stepper => stepper.interpolate(t, out));
    }

    fn record<Y: System + ?Sized>(&mut self, sys: &Y) -> usize {
        self.explicit.record(sys).max(self.implicit.record(sys))
    }

    fn forget_records(&mut self) {
        self.explicit.forget_records();
    }

    fn carry<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        bundle: &mut Bundle,
        tally: &mut Tally,
    ) {
        at_work!(self, stepper => stepper.carry(sys, status, bundle, tally));
    }
}
