//! Growth accumulated over batches of equal time, in bounded memory.

/// Maximum number of batches. When it is reached, batches are merged in pairs.
const MAX_BATCHES: usize = 128;

/// Logarithmic growth of a vector over a time interval, with its range within the interval, relative to
/// the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GrowthInterval {
    /// Growth from start to end.
    pub growth: f64,
    /// Minimum growth within the interval.
    pub low: f64,
    /// Maximum growth within the interval.
    pub high: f64,
}

impl GrowthInterval {
    /// Growth at a constant rate.
    fn uniform(growth: f64) -> Self {
        Self {
            growth,
            low: growth.min(0.0),
            high: growth.max(0.0),
        }
    }

    /// Concatenates two successive intervals.
    pub fn then(self, next: Self) -> Self {
        Self {
            growth: self.growth + next.growth,
            low: self.low.min(self.growth + next.low),
            high: self.high.max(self.growth + next.high),
        }
    }

    /// Difference between maximum and minimum growth.
    pub fn range(self) -> f64 {
        self.high - self.low
    }
}

/// Growth of several vectors in batches of equal time. When the storage is full, adjacent batches are
/// merged. After the first 64 batches there are always 64 to 128, however long the integration.
#[derive(Clone, Debug)]
pub(crate) struct Growth {
    /// Number of vectors.
    pub width: usize,
    /// Growth in each full batch, batch by batch.
    full: Vec<GrowthInterval>,
    /// Growth in the incomplete batch.
    filling: Vec<GrowthInterval>,
    /// Start time of the first batch, s.
    pub start: f64,
    /// Time up to which growth is recorded, s.
    pub last: f64,
    /// Length of a batch, s; zero before the first entry.
    pub length: f64,
}

impl Growth {
    pub fn new(width: usize) -> Self {
        Self {
            width,
            full: Vec::with_capacity(MAX_BATCHES * width),
            filling: vec![GrowthInterval::default(); width],
            start: 0.0,
            last: 0.0,
            length: 0.0,
        }
    }

    /// Discards everything up to time `t` (s).
    pub fn clear(&mut self, t: f64) {
        self.full.clear();
        self.filling.fill(GrowthInterval::default());
        self.start = t;
        self.last = t;
        self.length = 0.0;
    }

    /// The part between two times (s), as far as full batches lie within it; the incomplete batch belongs
    /// to it if `to` is not before its end.
    pub fn between(&self, from: f64, to: f64) -> Self {
        // Borders are sums of rounded lengths.
        let slack = 1e-6 * self.length;
        let end = |batch: usize| self.start + (batch + 1) as f64 * self.length;
        let first = (0..self.count()).find(|&b| end(b) - self.length >= from - slack);
        let first = first.unwrap_or(self.count());
        let until = (first..self.count()).find(|&b| end(b) > to + slack);
        let until = until.unwrap_or(self.count());
        let border = |batch: usize| self.start + batch as f64 * self.length;
        let is_open =
            until == self.count() && to + slack >= self.last && border(first) >= from - slack;
        let mut part = Self::new(self.width);
        part.full
            .extend_from_slice(&self.full[first * self.width..until * self.width]);
        part.start = border(first).min(self.last);
        part.last = border(until).min(self.last);
        part.length = self.length;
        if is_open {
            part.filling.copy_from_slice(&self.filling);
            part.last = self.last;
        }
        part
    }

    /// Growth of a vector over the whole time.
    pub fn total(&self, vector: usize) -> f64 {
        let full = self.full.iter().skip(vector).step_by(self.width);
        full.chain(&self.filling[vector..=vector])
            .map(|interval| interval.growth)
            .sum()
    }

    /// Number of full batches.
    pub fn count(&self) -> usize {
        self.full.len() / self.width
    }

    /// Growth of a vector in a full batch.
    pub fn get(&self, batch: usize, vector: usize) -> GrowthInterval {
        self.full[batch * self.width + vector]
    }

    /// Adds the growth up to time `t` (s), distributed evenly over the time since the last entry.
    pub fn push(&mut self, t: f64, growth: &[f64]) {
        let span = t - self.last;
        if self.length == 0.0 {
            self.length = span;
        }
        // Merging in advance prevents a long interval from filling the storage repeatedly.
        while span > 0.25 * MAX_BATCHES as f64 * self.length {
            self.merge();
        }
        loop {
            if self.count() == MAX_BATCHES {
                self.merge();
            }
            let border = self.start + (self.count() + 1) as f64 * self.length;
            let until = t.min(border);
            let share = (until - self.last) / span;
            if share > 0.0 {
                for (sum, growth) in self.filling.iter_mut().zip(growth) {
                    *sum = sum.then(GrowthInterval::uniform(share * growth));
                }
            }
            self.last = until;
            if until < border {
                return;
            }
            self.full.extend_from_slice(&self.filling);
            self.filling.fill(GrowthInterval::default());
            if until >= t {
                return;
            }
        }
    }

    /// Merges adjacent batches and doubles their length.
    fn merge(&mut self) {
        let (width, pairs) = (self.width, self.count() / 2);
        if 2 * pairs < self.count() {
            let odd = &self.full[2 * pairs * width..];
            for (filling, odd) in self.filling.iter_mut().zip(odd) {
                *filling = odd.then(*filling);
            }
        }
        for pair in 0..pairs {
            for l in 0..width {
                let [first, second] = [0, 1].map(|k| self.full[(2 * pair + k) * width + l]);
                self.full[pair * width + l] = first.then(second);
            }
        }
        self.full.truncate(pairs * width);
        self.length *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unequal_intervals_are_distributed_by_time() {
        let mut batches = Growth::new(2);
        batches.clear(5.0);
        let mut t = 5.0;
        for k in 0..5000 {
            let span = 0.01 * f64::from(1 + (7 * k) % 13);
            t += span;
            // One vector grows at a constant rate, the other only in the first half.
            batches.push(t, &[3.0 * span, if k < 2500 { span } else { 0.0 }]);
        }
        assert!((64..=128).contains(&batches.count()), "{}", batches.count());
        assert_eq!(batches.last, t);
        for batch in 0..batches.count() {
            let rate = batches.get(batch, 0).growth / batches.length;
            assert!((rate - 3.0).abs() < 1e-9, "batch {batch}: {rate}");
        }
        let whole: f64 = (0..batches.count()).map(|b| batches.get(b, 1).growth).sum();
        assert!((whole - 0.5 * (t - 5.0)).abs() < 0.01 * t, "{whole} of {t}");
    }

    #[test]
    fn a_part_has_the_batches_within_its_times() {
        let mut batches = Growth::new(2);
        batches.clear(5.0);
        for k in 1..=100 {
            let growth = if k <= 40 { 2.0 } else { 0.0 };
            batches.push(5.0 + 0.1 * f64::from(k), &[growth, 1.0]);
        }
        let early = batches.between(5.0, 8.96);
        assert!((early.start - 5.0).abs() < 1e-9 && (early.last - 8.9).abs() < 1e-9);
        assert!((early.total(0) - 78.0).abs() < 1e-9 && (early.total(1) - 39.0).abs() < 1e-9);
        let late = batches.between(9.04, f64::INFINITY);
        assert!((late.start - 9.1).abs() < 1e-9 && late.last == batches.last);
        assert!((late.total(0)).abs() < 1e-9 && (late.total(1) - 59.0).abs() < 1e-9);
        let all = batches.between(f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(
            (all.start, all.last, all.count()),
            (5.0, batches.last, batches.count())
        );
        let none = batches.between(20.0, 30.0);
        assert_eq!(
            (none.count(), none.last - none.start, none.total(1)),
            (0, 0.0, 0.0)
        );
        let none = batches.between(6.01, 6.05);
        assert_eq!((none.count(), none.last - none.start), (0, 0.0));
    }

    #[test]
    fn merging_keeps_the_range_of_a_wave() {
        let mut batches = Growth::new(1);
        for k in 1..=20_000 {
            let [before, now] = [k - 1, k].map(|k| (0.01 * f64::from(k)).sin());
            batches.push(0.01 * f64::from(k), &[now - before]);
        }
        let whole = (0..batches.count()).map(|b| batches.get(b, 0));
        let whole = whole.fold(GrowthInterval::default(), GrowthInterval::then);
        assert!(
            (whole.low + 1.0).abs() < 1e-3 && (whole.high - 1.0).abs() < 1e-3,
            "{whole:?}"
        );
    }

    #[test]
    fn a_long_interval_keeps_the_memory_bounded() {
        let mut batches = Growth::new(1);
        batches.push(1e-6, &[1.0]);
        batches.push(1e6, &[1e6]);
        batches.push(2e6, &[f64::NEG_INFINITY]);
        batches.push(3e6, &[1e6]);
        assert!(batches.count() <= MAX_BATCHES);
        assert!((0..batches.count()).all(|b| !batches.get(b, 0).growth.is_nan()));
    }
}
