//! The first zero of the guards in a bracket.

use super::Events;
use crate::dynamics::Switching;
use crate::dynamics::stepper::Stepper;

impl Events {
    /// The first fall of a guard between `low` and `high` (s): all guards are positive or zero at
    /// `low` (`above`), and some negative at `high` (`below`). Returns the time just after it, to
    /// the rounding of the time, with the guards there in `below`.
    ///
    /// The method is that of I. F. D. Oliveira and R. H. C. Takahashi, An enhancement of the bisection
    /// method average performance preserving minmax optimality, ACM Trans. Math. Softw. 47 (2021)
    /// 5: secants moved a little towards the middle, never more than one evaluation behind
    /// bisection. The secant taken is that of the guard which falls first.
    pub(super) fn locate<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        mut low: f64,
        mut high: f64,
    ) -> f64 {
        let resolution = 2.0 * f64::EPSILON * high.abs().max(stepper.step().start_time.abs());
        let first_width = high - low;
        // How wide the bracket may still be, if it were halved from here on.
        let mut allowed = first_width.max(resolution);
        while high - low > resolution {
            let width = high - low;
            let secant = low + width * self.first_zero();
            let middle = low + 0.5 * width;
            let towards = (middle - secant).signum();
            let shift = (0.01 * width * (width / first_width)).max(0.5 * resolution);
            let moved = if shift <= (middle - secant).abs() {
                secant + towards * shift
            } else {
                middle
            };
            let reach = allowed - 0.5 * width;
            let guess = if (moved - middle).abs() <= reach {
                moved
            } else {
                middle - towards * reach
            };
            allowed *= 0.5;
            if guess <= low || guess >= high {
                break;
            }
            self.look_between(switching, stepper, guess);
            if self.between.iter().any(|&h| h < 0.0) {
                high = guess;
                std::mem::swap(&mut self.below, &mut self.between);
            } else {
                low = guess;
                std::mem::swap(&mut self.above, &mut self.between);
            }
        }
        self.group(switching, stepper, high)
    }

    /// Where in the bracket, from 0 to 1, the secant of a falling guard is zero first.
    ///
    /// A guard of zero has just been crossed and rises at first, so its secant says nothing, and would
    /// lead to where the guard is rounding: it counts as falling through zero in the middle.
    fn first_zero(&self) -> f64 {
        let falling = self.above.iter().zip(&self.below);
        falling
            .filter(|(_, below)| **below < 0.0)
            .map(|(above, below)| match above {
                0.0 => 0.5,
                _ => (above / (above - below)).clamp(0.0, 1.0),
            })
            .fold(1.0, f64::min)
    }

    /// Moves the time found (s) on by its rounding, where another guard has come to zero within
    /// the rounding of its values: then it falls at the same time.
    fn group<M: Stepper>(&mut self, switching: &dyn Switching, stepper: &mut M, t: f64) -> f64 {
        let later = t + 8.0 * f64::EPSILON * t.abs().max(stepper.step().start_time.abs());
        let near = |guard: usize, h: f64| {
            let start = self.looks[0][guard];
            (0.0..=16.0 * f64::EPSILON * start.abs()).contains(&h) && h < start
        };
        let mut guards = self.below.iter().enumerate();
        if later < stepper.step().end_time && guards.any(|(guard, &h)| near(guard, h)) {
            self.look_between(switching, stepper, later);
            // The first guard may have come back up if it hardly fell: then nothing is gained.
            let mut pairs = self.below.iter().zip(&self.between);
            if pairs.all(|(before, after)| *before >= 0.0 || *after < 0.0) {
                std::mem::swap(&mut self.below, &mut self.between);
                return later;
            }
        }
        t
    }
}
