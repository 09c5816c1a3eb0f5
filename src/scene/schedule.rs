//! A quantity as a function of time.

/// Piecewise linear in time through its knots, constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Knots (time in s, value), times strictly increasing; never empty.
    knots: Vec<(f64, f64)>,
}

impl Schedule {
    /// The same value at all times.
    pub fn constant(value: f64) -> Self {
        Self {
            knots: vec![(0.0, value)],
        }
    }

    /// Through the given knots; `None` if there is none, a number is not finite, or the times
    /// do not increase strictly.
    pub fn through(knots: Vec<(f64, f64)>) -> Option<Self> {
        let finite = knots.iter().all(|(t, x)| t.is_finite() && x.is_finite());
        let increasing = knots.windows(2).all(|w| w[0].0 < w[1].0);
        (finite && increasing && !knots.is_empty()).then_some(Self { knots })
    }

    /// The knots (time in s, value).
    pub fn knots(&self) -> &[(f64, f64)] {
        &self.knots
    }

    /// The value at time `t` (s).
    pub fn at(&self, t: f64) -> f64 {
        let after = self.knots.partition_point(|&(knot, _)| knot <= t);
        if after == 0 {
            return self.knots[0].1;
        }
        let (t0, x0) = self.knots[after - 1];
        match self.knots.get(after) {
            None => x0,
            Some(&(t1, x1)) => x0 + (x1 - x0) * (t - t0) / (t1 - t0),
        }
    }

    /// The smallest value it reaches.
    pub fn min(&self) -> f64 {
        self.knots.iter().map(|k| k.1).fold(f64::INFINITY, f64::min)
    }

    /// The largest value it reaches.
    pub fn max(&self) -> f64 {
        self.knots
            .iter()
            .map(|k| k.1)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the value changes.
    pub fn varies(&self) -> bool {
        self.knots.iter().any(|k| k.1 != self.knots[0].1)
    }
}
