//! States between the ends of a step.
//!
//! The stages of a step determine a polynomial in the picture's coordinates,
//! `y(t_n + theta h) = y_n + h sum_i b_i(theta) k_i`, which costs no further call. In the
//! interaction picture the polynomial has only the effect of the force to follow; the free
//! vibration at the sample's own time is then put back exactly.

use super::stepper::{Picture, Stepper, accumulate};

impl<P: Picture, const S: usize> Stepper<P, S> {
    /// Writes the state at time `t` (s) within the last step.
    pub fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        if t == self.end_time {
            out.copy_from_slice(&self.end);
            return;
        }
        out.copy_from_slice(&self.start);
        if t == self.start_time {
            return;
        }
        let h = self.length();
        let offset = t - self.start_time;
        accumulate(out, h, &self.slopes, &self.tableau.weights(offset / h));
        self.picture.push_by(offset, out, 1);
    }

    /// Ends the last step at time `t` (s) within it, at the state of the dense output there.
    pub fn cut(&mut self, t: f64) {
        // An event at the very end cuts nothing.
        if t == self.end_time {
            return;
        }
        let mut end = std::mem::take(&mut self.end);
        self.interpolate(t, &mut end);
        self.end = end;
        self.end_time = t;
    }
}
