//! Events: where a guard falls through zero, found without calling the right-hand side.
//!
//! The status is frozen while a step lasts, so that each step is smooth and keeps the method's
//! order. Afterwards the guards are looked at along the dense output of the step. Where one has
//! fallen through zero, the first such instant is located, and the step is cut there; all guards
//! negative just after it belong to the same event.

use super::Switching;
use super::stepper::{Picture, Stepper};

/// Places along a step, beside its start, at which the guards are looked at.
const LOOKS: usize = 4;

/// The status, and the search for the end of its law.
#[derive(Clone, Debug)]
pub(super) struct Events {
    /// The present status.
    pub status: Vec<u8>,
    /// Guards negative at the end of the last step: to be crossed before the next one.
    pub pending: Vec<usize>,
    /// Guards' values at the places looked at.
    looks: [Vec<f64>; LOOKS + 1],
    /// Guards' values at the two ends of the bracket.
    above: Vec<f64>,
    below: Vec<f64>,
    /// A state between the ends of the step.
    state: Vec<f64>,
    /// Guards crossed at the last event.
    pub crossed: Vec<usize>,
    /// Crossings since `window_start`, s: what chatter is measured by.
    recent: usize,
    window_start: f64,
}

/// Crossings within the longest step before they count as chatter.
pub(super) const CHATTER: usize = 10_000;

impl Events {
    /// Ready for a system, with no status yet.
    pub fn new(switching: &dyn Switching, dim: usize) -> Self {
        let values = vec![0.0; switching.guards()];
        Self {
            status: vec![0; switching.status_len()],
            pending: Vec::with_capacity(values.len()),
            looks: std::array::from_fn(|_| values.clone()),
            above: values.clone(),
            below: values,
            state: vec![0.0; dim],
            crossed: Vec::new(),
            recent: 0,
            window_start: f64::NEG_INFINITY,
        }
    }

    /// Takes the status of a state, and forgets all crossings.
    pub fn start(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        switching.status_of(t, z, &mut self.status);
        self.pending.clear();
        self.recent = 0;
        self.window_start = t;
    }

    /// Counts crossings at time `t` (s); whether there have been more than [`CHATTER`] within `window` (s).
    pub fn count(&mut self, crossings: usize, t: f64, window: f64) -> bool {
        if t - self.window_start > window {
            self.window_start = t;
            self.recent = 0;
        }
        self.recent += crossings;
        self.recent > CHATTER
    }

    /// Crossings in the present window.
    pub fn crossings(&self) -> usize {
        self.recent
    }

    /// The status to hold in the next step; `None` where the step has to run over its guards.
    pub fn held(&self) -> Option<&[u8]> {
        (self.recent <= CHATTER).then_some(self.status.as_slice())
    }

    /// Goes on after a step that ran over its guards.
    pub fn overrun(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        self.start(switching, t, z);
    }

    /// Looks for the first event in the step just taken. If there is one, the step is cut there
    /// and its guards are `pending`.
    pub fn find<P: Picture, const S: usize>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut Stepper<P, S>,
    ) -> bool {
        self.pending.clear();
        if switching.guards() == 0 {
            return false;
        }
        let (start, end) = (stepper.start_time, stepper.end_time);
        let time = |look: usize| start + (end - start) * look as f64 / LOOKS as f64;
        for look in 1..=LOOKS {
            let t = if look == LOOKS { end } else { time(look) };
            stepper.interpolate(t, &mut self.state);
            let values = &mut self.looks[look];
            switching.guard_values(&self.status, t, &self.state, values);
            if values.iter().any(|&h| h < 0.0) {
                let from = time(look - 1);
                stepper.interpolate(from, &mut self.state);
                switching.guard_values(&self.status, from, &self.state, &mut self.above);
                self.below.copy_from_slice(&self.looks[look]);
                self.locate(switching, stepper, from, t);
                return true;
            }
        }
        false
    }

    /// Cuts the step at the first fall of a guard between `low` and `high` (s).
    fn locate<P: Picture, const S: usize>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut Stepper<P, S>,
        mut low: f64,
        mut high: f64,
    ) {
        let mut bisect = false;
        loop {
            let width = high - low;
            if width <= 4.0 * f64::EPSILON * high.abs().max(stepper.length()) {
                break;
            }
            let mut guess = 0.5 * (low + high);
            if !bisect {
                // The secants of all that fall: the first of their zeros.
                for (&a, &b) in self.above.iter().zip(&self.below) {
                    if b < 0.0 && a > b {
                        guess = guess.min(low + width * (a / (a - b)).clamp(0.0, 1.0));
                    }
                }
                let margin = 2.0 * f64::EPSILON * high.abs().max(stepper.length());
                guess = guess.clamp(low + margin, high - margin);
            }
            bisect = !bisect;
            stepper.interpolate(guess, &mut self.state);
            let values = &mut self.looks[0];
            switching.guard_values(&self.status, guess, &self.state, values);
            if values.iter().any(|&h| h < 0.0) {
                high = guess;
                std::mem::swap(&mut self.below, &mut self.looks[0]);
            } else {
                low = guess;
                std::mem::swap(&mut self.above, &mut self.looks[0]);
            }
        }
        stepper.cut(high);
        let negative = self.below.iter().enumerate().filter(|(_, h)| **h < 0.0);
        self.pending.extend(negative.map(|(guard, _)| guard));
    }

    /// The guards that are negative at a state under the present status become `pending`.
    pub fn look(&mut self, switching: &dyn Switching, t: f64, z: &[f64]) {
        self.pending.clear();
        switching.guard_values(&self.status, t, z, &mut self.looks[0]);
        let negative = self.looks[0].iter().enumerate().filter(|(_, h)| **h < 0.0);
        self.pending.extend(negative.map(|(guard, _)| guard));
    }
}
