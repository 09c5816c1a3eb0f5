//! Guards that dip below zero and come back between two places.

use super::{Events, QUARTERS, TOUCH};
use crate::dynamics::stepper::Stepper;
use crate::dynamics::{Switching, Tally};

/// Evaluations after which a minimum is given up: what is left of the dip is within rounding.
const EVALUATIONS: usize = 40;

/// Three places and a guard's values there; the middle one is the lowest.
#[derive(Clone, Copy, Debug)]
struct Valley {
    t: [f64; 3],
    h: [f64; 3],
}

impl Valley {
    /// Place and value of the lowest point of the parabola through the three; `None` if it has none.
    fn vertex(&self) -> Option<(f64, f64)> {
        let [a, m, b] = self.t;
        let left = (self.h[1] - self.h[0]) / (m - a);
        let right = (self.h[2] - self.h[1]) / (b - m);
        let curvature = (right - left) / (b - a);
        // The slope at the middle.
        let slope = left + curvature * (m - a);
        (curvature > 0.0).then(|| {
            let t = m - 0.5 * slope / curvature;
            (t, self.h[1] - 0.25 * slope * slope / curvature)
        })
    }

    /// The three around the lowest once another place is known, from the four of them in order.
    fn with(&self, t: f64, h: f64) -> Option<Self> {
        let at = self.t.iter().filter(|&&other| other < t).count();
        let mut all = [(t, h); 4];
        let old = self.t.into_iter().zip(self.h);
        for (k, pair) in old.enumerate() {
            all[if k < at { k } else { k + 1 }] = pair;
        }
        let lowest = if all[1].1 <= all[2].1 { 1 } else { 2 };
        let [a, m, b] = [all[lowest - 1], all[lowest], all[lowest + 1]];
        (m.1 <= a.1 && m.1 <= b.1).then_some(Self {
            t: [a.0, m.0, b.0],
            h: [a.1, m.1, b.1],
        })
    }
}

/// What a dip comes to.
enum Depth {
    /// It falls through zero, and is negative at this time, s.
    Below(f64),
    /// It comes to zero within rounding.
    Touch,
    /// It stays above zero.
    Above,
}

impl Events {
    /// Looks for guards that fall through zero within a quarter of the step and come back.
    /// Returns a time (s) at which one is negative, with the guards there in `below`.
    pub(super) fn dip<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        quarter: usize,
        tally: &mut Tally,
    ) -> Option<f64> {
        let mut found = None;
        for k in 0..self.near.len() {
            let guard = self.near[k];
            let values = std::array::from_fn(|k| self.looks[k][guard]);
            let Some(middle) = suspect(&values, quarter) else {
                continue;
            };
            let scale = values.iter().fold(0.0, |max, h| f64::max(max, h.abs()));
            let valley = Valley {
                t: [0, 1, 2].map(|k| self.place(middle - 1 + k)),
                h: [0, 1, 2].map(|k| values[middle - 1 + k]),
            };
            match self.depth(switching, stepper, guard, valley, scale) {
                Depth::Below(t) => {
                    if found.is_none_or(|earlier| t < earlier) {
                        found = Some(t);
                        std::mem::swap(&mut self.below, &mut self.between);
                    }
                }
                Depth::Touch => tally.grazings += 1,
                Depth::Above => {}
            }
        }
        found
    }

    /// Goes down a dip to its lowest point.
    fn depth<M: Stepper>(
        &mut self,
        switching: &dyn Switching,
        stepper: &mut M,
        guard: usize,
        mut valley: Valley,
        scale: f64,
    ) -> Depth {
        let touch = TOUCH * scale;
        for _ in 0..EVALUATIONS {
            let [start, middle, end] = valley.t;
            let Some((vertex, predicted)) = valley.vertex() else {
                break;
            };
            // A place too near to a known one tells nothing new.
            let apart = 1e-3 * (end - start);
            let mut t = vertex.clamp(start + apart, end - apart);
            if (t - middle).abs() < apart {
                let gain = valley.h[1] - predicted;
                if gain <= 4.0 * f64::EPSILON * scale {
                    break;
                }
                let far = if end - middle > middle - start {
                    1.0
                } else {
                    -1.0
                };
                t = middle + far * apart;
            }
            self.look_between(switching, stepper, t);
            let h = self.between[guard];
            if h < -touch {
                return Depth::Below(t);
            }
            if predicted > touch && (h - predicted).abs() <= 0.25 * predicted {
                return Depth::Above;
            }
            let Some(narrower) = valley.with(t, h) else {
                return Depth::Above;
            };
            valley = narrower;
        }
        if valley.h[1] <= touch {
            Depth::Touch
        } else {
            Depth::Above
        }
    }
}

/// The place in the middle of the three whose parabola comes down to zero within a quarter of the
/// step, as far as the third differences let it be told; `None` if it stays above.
fn suspect(values: &[f64; QUARTERS + 1], quarter: usize) -> Option<usize> {
    if values[quarter - 1] < 0.0 || values[quarter] < 0.0 {
        return None;
    }
    let third = |k: usize| values[k + 3] - 3.0 * (values[k + 2] - values[k + 1]) - values[k];
    let doubt = 0.125 * third(0).abs().max(third(1).abs());
    let scale = values.iter().fold(0.0, |max, h| f64::max(max, h.abs()));
    let [first, last] = [quarter.max(2) - 1, quarter.min(QUARTERS - 1)];
    (first..=last).find(|&middle| {
        let [a, m, b] = [0, 1, 2].map(|k| values[middle - 1 + k]);
        let (slope, curvature) = (0.5 * (b - a), a - 2.0 * m + b);
        if curvature <= 0.0 {
            return false;
        }
        // In quarters from the start of the step.
        let vertex = middle as f64 - slope / curvature;
        // A guard that starts from zero and rises is at its lowest there.
        let rises = values[0] <= TOUCH * scale && vertex < 0.05;
        let inside = (quarter as f64 - 1.0..quarter as f64).contains(&vertex);
        inside && !rises && m - 0.5 * slope * slope / curvature <= doubt + TOUCH * scale
    })
}
