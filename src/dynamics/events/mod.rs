//! Events: where a guard falls through zero, found without calling the right-hand side.
//!
//! The status is frozen while a step lasts, so that each step is smooth and keeps the method's
//! order. Afterwards the guards are looked at along the dense output of the step. Where one has
//! fallen through zero, the first such instant is located, and the step is cut there; all guards
//! negative just after it belong to the same event.
//!
//! # Where a step is looked at
//!
//! A step whose dense output is of order 4 is looked at as a whole, one with a higher order in two
//! pieces. What follows is said of a whole step.
//!
//! At its middle and its end (its start is the end of the one before). That is all where each guard
//! is further from zero than it has moved between these places. Otherwise the quarters are looked at,
//! too: the five values determine a guard as well as the dense output does, which is of order 4.
//! A guard that dips below zero and comes back between two places is told by the parabola through
//! three of them, within the third differences, and its minimum is then sought on the dense output
//! itself. What escapes is a dip that five values of the step do not show, which is below the
//! error of the dense output.
//!
//! A dip that comes to zero within the rounding of the guard is a grazing: it is counted and not
//! crossed.

mod dip;
mod root;

use super::stepper::Stepper;
use super::{Switching, Tally};

/// Quarters of a piece of a step: its start, and so many places after it.
const QUARTERS: usize = 4;

/// Guards this near to zero, relative to their largest value in the step, touch it.
const TOUCH: f64 = 1e-12;

/// Events within the longest step before they count as chatter.
pub(super) const CHATTER: usize = 10_000;

/// The status, and the search for the end of its law.
#[derive(Clone, Debug)]
pub(super) struct Events {
    /// The present status.
    pub status: Vec<u8>,
    /// Guards negative at the end of the last step: to be crossed before the next one.
    pub pending: Vec<usize>,
    /// Guards crossed at the last event, in order.
    pub crossed: Vec<usize>,
    /// Start and end of the piece of the step that is looked at, s.
    piece: [f64; 2],
    /// Guards' values at the quarters of the piece; the first are known before.
    looks: [Vec<f64>; QUARTERS + 1],
    /// Guards that come near to zero in the step.
    near: Vec<usize>,
    /// Guards' values at the two ends of the bracket, and at a place between them.
    above: Vec<f64>,
    below: Vec<f64>,
    between: Vec<f64>,
    /// A state between the ends of the step.
    state: Vec<f64>,
    /// Events since `window_start`, s: what chatter is measured by.
    recent: usize,
    window_start: f64,
}

impl Events {
    /// Ready for a system, with no status yet.
    pub fn new(switching: &dyn Switching, dim: usize) -> Self {
        let values = vec![0.0; switching.guards()];
        Self {
            status: vec![0; switching.status_len()],
            pending: Vec::with_capacity(values.len()),
            crossed: Vec::with_capacity(values.len() + CHATTER),
            piece: [0.0; 2],
            looks: std::array::from_fn(|_| values.clone()),
            near: Vec::with_capacity(values.len()),
            above: values.clone(),
            below: values.clone(),
            between: values,
            state: vec![0.0; dim],
            recent: 0,
            window_start: f64::NEG_INFINITY,
        }
    }

    /// Takes the status of a state, and forgets all events.
    pub fn start(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.status_of(t, z, &mut self.status);
        self.look(switching, t, z);
        self.recent = 0;
        self.window_start = t;
    }

    /// Goes on after a step that ran over its guards.
    pub fn overrun(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.status_of(t, z, &mut self.status);
        self.look(switching, t, z);
        self.pending.clear();
    }

    /// Takes note of one more event at time `t` (s); whether there have been more than [`CHATTER`]
    /// within `window` (s).
    pub fn count(&mut self, t: f64, window: f64) -> bool {
        self.pass(t, window);
        self.recent += 1;
        self.recent > CHATTER
    }

    /// Forgets the events of a window (s) that is over at time `t` (s).
    pub fn pass(&mut self, t: f64, window: f64) {
        if t - self.window_start > window {
            self.window_start = t;
            self.recent = 0;
        }
    }

    /// Events in the present window.
    pub fn recent(&self) -> usize {
        self.recent
    }

    /// Takes note of a guard crossed.
    pub fn note(&mut self, guard: usize) {
        // Only chatter fills the list; it must not grow while steps are taken.
        if self.crossed.len() < self.crossed.capacity() {
            self.crossed.push(guard);
        }
    }

    /// The status to hold in the next step; `None` where the step has to run over its guards.
    pub fn held(&self) -> Option<&[u8]> {
        (self.recent <= CHATTER).then_some(self.status.as_slice())
    }

    /// The guards that are negative at a state under the present status become `pending`. The next
    /// step starts there.
    pub fn look(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.guard_values(&self.status, t, z, &mut self.looks[0]);
        self.pending.clear();
        let negative = self.looks[0].iter().enumerate().filter(|(_, h)| **h < 0.0);
        self.pending.extend(negative.map(|(guard, _)| guard));
    }

    /// Whether there is anything to look for.
    pub fn has_guards(&self) -> bool {
        !self.above.is_empty()
    }

    /// Looks for the first event in the step just taken, made ready for states between its ends. If
    /// there is one, the step is cut there and its guards are `pending`.
    pub fn find<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        tally: &mut Tally,
    ) -> bool {
        self.pending.clear();
        if !self.has_guards() {
            return false;
        }
        let pieces = stepper.rule().pieces;
        let (start, end) = (stepper.step().start_time, stepper.step().end_time);
        (1..=pieces).any(|piece| {
            let edge = |k: usize| start + (end - start) * k as f64 / pieces as f64;
            self.piece = [
                edge(piece - 1),
                if piece == pieces { end } else { edge(piece) },
            ];
            self.find_in_piece(switching, stepper, tally)
        })
    }

    /// Looks for the first event in a piece of the step, before which there is none.
    fn find_in_piece<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        tally: &mut Tally,
    ) -> bool {
        self.look_along(switching, stepper, 2);
        self.look_along(switching, stepper, 4);
        if !self.is_doubtful() {
            self.looks.swap(0, QUARTERS);
            return false;
        }
        self.look_along(switching, stepper, 1);
        self.look_along(switching, stepper, 3);
        self.list_near();
        self.smooth_touches();
        for quarter in 1..=QUARTERS {
            let high = match self.dip(switching, stepper, quarter, tally) {
                Some(high) => high,
                None if self.looks[quarter].iter().any(|&h| h < 0.0) => {
                    self.below.copy_from_slice(&self.looks[quarter]);
                    self.place(quarter)
                }
                None => continue,
            };
            self.above.copy_from_slice(&self.looks[quarter - 1]);
            let low = self.place(quarter - 1);
            let t = self.locate(switching, stepper, low, high);
            stepper.cut(t);
            switching.settle(&self.status, t, &mut stepper.step_mut().end);
            let negative = self.below.iter().enumerate().filter(|(_, h)| **h < 0.0);
            self.pending.extend(negative.map(|(guard, _)| guard));
            return true;
        }
        self.looks.swap(0, QUARTERS);
        false
    }

    /// Evaluates the guards at a quarter of the step.
    fn look_along<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        quarter: usize,
    ) {
        let t = self.place(quarter);
        stepper.interpolate(t, &mut self.state);
        switching.guard_values(&self.status, t, &self.state, &mut self.looks[quarter]);
    }

    /// Evaluates the guards at a time `t` (s) of the step, into `between`.
    fn look_between<M: Stepper>(&mut self, switching: &dyn Switching, stepper: &mut M, t: f64) {
        stepper.interpolate(t, &mut self.state);
        switching.guard_values(&self.status, t, &self.state, &mut self.between);
    }

    /// Whether some guard is no further from zero than it has moved, by its values at the start,
    /// the middle and the end of the step.
    fn is_doubtful(&self) -> bool {
        let ends = self.looks[0].iter().zip(&self.looks[QUARTERS]);
        let mut doubtful = false;
        // No early exit: the whole loop is one pass of vector operations.
        for ((&start, &end), &middle) in ends.zip(&self.looks[QUARTERS / 2]) {
            let low = start.min(middle).min(end);
            let high = start.max(middle).max(end);
            doubtful |= low <= high - low;
        }
        doubtful
    }

    /// Lists the guards that may be negative somewhere in the step: between two looks a guard is lower
    /// than at both by an eighth of its second difference, and a little more as that changes.
    fn list_near(&mut self) {
        let [a, b, c, d, e] = &self.looks;
        let n = a.len();
        let (a, b, c, d, e) = (&a[..n], &b[..n], &c[..n], &d[..n], &e[..n]);
        self.near.clear();
        for k in 0..n {
            let (a, b, c, d, e) = (a[k], b[k], c[k], d[k], e[k]);
            let low = a.min(b).min(c).min(d).min(e);
            let bend = (a - 2.0 * b + c).max(b - 2.0 * c + d).max(c - 2.0 * d + e);
            if low <= bend.max(0.0) {
                self.near.push(k);
            }
        }
    }

    /// Sets a guard that touches zero between two positive places to zero there.
    fn smooth_touches(&mut self) {
        for quarter in 1..QUARTERS {
            for &guard in &self.near {
                let [before, here, after] = [0, 1, 2].map(|k| self.looks[quarter - 1 + k][guard]);
                if here < 0.0 && here >= -TOUCH * before.abs().max(after.abs()) && after > 0.0 {
                    self.looks[quarter][guard] = 0.0;
                }
            }
        }
    }

    /// The time of a quarter of the piece of the step that is looked at, s.
    fn place(&self, quarter: usize) -> f64 {
        let [start, end] = self.piece;
        if quarter == QUARTERS {
            return end;
        }
        start + (end - start) * quarter as f64 / QUARTERS as f64
    }
}
