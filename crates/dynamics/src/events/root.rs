//! Location of the first zero of the guards in a bracket.

use super::{Events, SearchedStep};
use crate::root_bracket::RootBracket;

impl Events {
    /// Locates the first zero of a guard between `low` and `high` (s). All guards are positive or zero
    /// at `low` (`above`), and some are negative at `high` (`below`). Returns the time immediately after
    /// the zero, to the rounding of the time; `below` then holds the guards at that time.
    ///
    /// The secant is that of the guard with the earliest predicted zero.
    pub(super) fn locate(&mut self, searched: &mut SearchedStep<'_>, low: f64, high: f64) -> f64 {
        let start = searched.stepper.step().start_time;
        let resolution = 2.0 * f64::EPSILON * high.abs().max(start.abs());
        let mut bracket = RootBracket::new([low, high], resolution);
        while let Some(guess) = bracket.guess(self.first_zero()) {
            self.sample_at(searched, guess);
            if self.between.iter().any(|&h| h < 0.0) {
                bracket.ends[1] = guess;
                std::mem::swap(&mut self.below, &mut self.between);
            } else {
                bracket.ends[0] = guess;
                std::mem::swap(&mut self.above, &mut self.between);
            }
        }
        self.merge_simultaneous(searched, bracket.ends[1])
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
