//! Detection of guards that become negative and positive again between two samples.

use super::{Events, GRAZING_TOLERANCE, QUARTERS, SearchedStep};

/// Maximum number of evaluations in the search for a minimum; the remaining depth is within rounding.
const MAX_EVALUATIONS: usize = 40;

/// Three times (s) and the guard values there, the middle one being the lowest.
#[derive(Clone, Copy, Debug)]
struct MinimumBracket {
    t: [f64; 3],
    h: [f64; 3],
}

impl MinimumBracket {
    /// Time and value of the minimum of the parabola through the three points; `None` if it has none.
    fn vertex(&self) -> Option<(f64, f64)> {
        let [a, m, b] = self.t;
        let left = (self.h[1] - self.h[0]) / (m - a);
        let right = (self.h[2] - self.h[1]) / (b - m);
        let curvature = (right - left) / (b - a);
        // Slope at the middle point.
        let slope = left + curvature * (m - a);
        (curvature > 0.0).then(|| {
            let t = m - 0.5 * slope / curvature;
            (t, self.h[1] - 0.25 * slope * slope / curvature)
        })
    }

    /// The three points around the lowest of four, after adding a point; `None` if the lowest is at an
    /// end.
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

/// Result of the search for a minimum.
enum Minimum {
    /// The guard is negative at this time, s.
    Negative(f64),
    /// The minimum is zero within rounding.
    Grazing,
    /// The minimum is positive.
    Positive,
}

impl Events {
    /// Searches a quarter of the piece for guards that fall through zero and rise again. Returns a time
    /// (s) at which one is negative; `below` then holds the guards at that time.
    pub(super) fn find_dip(
        &mut self,
        searched: &mut SearchedStep<'_>,
        quarter: usize,
    ) -> Option<f64> {
        let mut found = None;
        for k in 0..self.candidates.len() {
            let guard = self.candidates[k];
            let values = std::array::from_fn(|k| self.samples[k][guard]);
            let Some(middle) = middle_of_dip(&values, quarter) else {
                continue;
            };
            let scale = values.iter().fold(0.0, |max, h| f64::max(max, h.abs()));
            let bracket = MinimumBracket {
                t: [0, 1, 2].map(|k| self.quarter_time(middle - 1 + k)),
                h: [0, 1, 2].map(|k| values[middle - 1 + k]),
            };
            match self.find_minimum(searched, guard, bracket, scale) {
                Minimum::Negative(t) => {
                    if found.is_none_or(|earlier| t < earlier) {
                        found = Some(t);
                        std::mem::swap(&mut self.below, &mut self.between);
                    }
                }
                Minimum::Grazing => searched.stepper.step_mut().stats.grazings += 1,
                Minimum::Positive => {}
            }
        }
        found
    }

    /// Locates the minimum of a guard by successive parabolic interpolation.
    fn find_minimum(
        &mut self,
        searched: &mut SearchedStep<'_>,
        guard: usize,
        mut bracket: MinimumBracket,
        scale: f64,
    ) -> Minimum {
        let touch = GRAZING_TOLERANCE * scale;
        for _ in 0..MAX_EVALUATIONS {
            let [start, middle, end] = bracket.t;
            let Some((vertex, predicted)) = bracket.vertex() else {
                break;
            };
            // A point too close to a known one gives no new information.
            let apart = 1e-3 * (end - start);
            let mut t = vertex.clamp(start + apart, end - apart);
            if (t - middle).abs() < apart {
                let gain = bracket.h[1] - predicted;
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
            self.sample_at(searched, t);
            let h = self.between[guard];
            if h < -touch {
                return Minimum::Negative(t);
            }
            if predicted > touch && (h - predicted).abs() <= 0.25 * predicted {
                return Minimum::Positive;
            }
            let Some(narrower) = bracket.with(t, h) else {
                return Minimum::Positive;
            };
            bracket = narrower;
        }
        if bracket.h[1] <= touch {
            Minimum::Grazing
        } else {
            Minimum::Positive
        }
    }
}

/// Index of the middle one of three samples whose parabola reaches zero within a quarter of the piece,
/// allowing for the third differences; `None` if it stays positive.
fn middle_of_dip(values: &[f64; QUARTERS + 1], quarter: usize) -> Option<usize> {
    if values[quarter - 1] < 0.0 || values[quarter] < 0.0 {
        return None;
    }
    let third = |k: usize| values[k + 3] - 3.0 * (values[k + 2] - values[k + 1]) - values[k];
    let uncertainty = 0.125 * third(0).abs().max(third(1).abs());
    let scale = values.iter().fold(0.0, |max, h| f64::max(max, h.abs()));
    let [first, last] = [quarter.max(2) - 1, quarter.min(QUARTERS - 1)];
    (first..=last).find(|&middle| {
        let [a, m, b] = [0, 1, 2].map(|k| values[middle - 1 + k]);
        let (slope, curvature) = (0.5 * (b - a), a - 2.0 * m + b);
        if curvature <= 0.0 {
            return false;
        }
        // In quarters from the start of the piece.
        let vertex = middle as f64 - slope / curvature;
        // A guard that starts from zero and rises has its minimum there.
        let rises = values[0] <= GRAZING_TOLERANCE * scale && vertex < 0.05;
        let inside = (quarter as f64 - 1.0..quarter as f64).contains(&vertex);
        inside
            && !rises
            && m - 0.5 * slope * slope / curvature <= uncertainty + GRAZING_TOLERANCE * scale
    })
}
