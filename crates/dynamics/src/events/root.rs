//! Location of the first zero of the guards in a bracket.

use super::{Events, SearchedStep};

impl Events {
    /// Locates the first zero of a guard between `low` and `high` (s). All guards are positive or zero
    /// at `low` (`above`), and some are negative at `high` (`below`). Returns the time immediately after
    /// the zero, to the rounding of the time; `below` then holds the guards at that time.
    ///
    /// The method is that of I. F. D. Oliveira and R. H. C. Takahashi, An enhancement of the bisection
    /// method average performance preserving minmax optimality, ACM Trans. Math. Softw. 47 (2021) 5: a
    /// secant step shifted slightly towards the middle, at most one evaluation slower than bisection.
    /// The secant is that of the guard with the earliest predicted zero.
    pub(super) fn locate(
        &mut self,
        searched: &mut SearchedStep<'_>,
        mut low: f64,
        mut high: f64,
    ) -> f64 {
        let start = searched.stepper.step().start_time;
        let resolution = 2.0 * f64::EPSILON * high.abs().max(start.abs());
        let first_width = high - low;
        // Permitted width of the bracket, as if it were halved from here on.
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
            self.sample_at(searched, guess);
            if self.between.iter().any(|&h| h < 0.0) {
                high = guess;
                std::mem::swap(&mut self.below, &mut self.between);
            } else {
                low = guess;
                std::mem::swap(&mut self.above, &mut self.between);
            }
        }
        self.merge_simultaneous(searched, high)
    }

    /// The earliest zero of the secants of all falling guards, as a fraction of the bracket from 0 to 1.
    ///
    /// A guard of zero was just crossed and initially rises. Its secant is dominated by rounding, so its
    /// zero is assumed in the middle.
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

    /// Shifts the located time (s) by its rounding error if another guard is zero within the rounding of
    /// its values, so that both belong to one event.
    fn merge_simultaneous(&mut self, searched: &mut SearchedStep<'_>, t: f64) -> f64 {
        let step = searched.stepper.step();
        let (start, end) = (step.start_time, step.end_time);
        let later = t + 8.0 * f64::EPSILON * t.abs().max(start.abs());
        let is_rounding = |guard: usize, h: f64| {
            let start = self.samples[0][guard];
            (0.0..=16.0 * f64::EPSILON * start.abs()).contains(&h) && h < start
        };
        let mut guards = self.below.iter().enumerate();
        if later < end && guards.any(|(guard, &h)| is_rounding(guard, h)) {
            self.sample_at(searched, later);
            // The first guard may be positive again if it fell only slightly; the shift is then not
            // used.
            let mut pairs = self.below.iter().zip(&self.between);
            if pairs.all(|(before, after)| *before >= 0.0 || *after < 0.0) {
                std::mem::swap(&mut self.below, &mut self.between);
                return later;
            }
        }
        t
    }
}
