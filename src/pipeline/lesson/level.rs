//! The velocity level, and the growth rate and frequency of a small vibration.

use crate::analysis::stats::LineFit;
use crate::report::Measured;

/// RMS level of the velocity in segments, and its growth rate while the vibration is small.
///
/// The decaying part of a kick must vanish before the growth rate can be measured. The fit therefore starts
/// when the level has risen by the factor [`Level::START_RATIO`], or after [`Level::START_SEGMENTS`]
/// segments.
#[derive(Default)]
pub struct Level {
    /// Samples per segment: half the lowest natural period, the period of the square of a sine.
    segment: usize,
    /// Level up to which the vibration is small, m/s.
    limit: f64,
    squares: f64,
    count: usize,
    pub segments: u64,
    /// RMS velocity of the last segment, m/s.
    pub last: f64,
    /// RMS velocity of the first nonzero segment, m/s.
    pub first: Option<f64>,
    /// Time (s) and level (m/s) at the start of the fit.
    anchor: Option<[f64; 2]>,
    line: LineFit,
    /// Time (s) and velocity (m/s) of the last sample since then.
    before: Option<[f64; 2]>,
    /// Number of upward zero crossings so far.
    crossings: u32,
    /// Their times over their numbers: the slope is the mean period. A vibration of several modes scatters about the line,
    /// which widens the interval.
    periods: LineFit,
    /// Time at which the vibration became too large for the linear theory, s.
    ended: Option<f64>,
}

impl Level {
    /// Factor on the first level, see [`Level`].
    const START_RATIO: f64 = 3.0;
    const START_SEGMENTS: u64 = 40;

    /// `segment`: samples per segment; `limit`: level up to which the vibration is small, m/s.
    pub fn new(segment: usize, limit: f64) -> Self {
        Self {
            segment,
            limit,
            ..Self::default()
        }
    }

    /// Processes a velocity (m/s). Returns whether it completes a segment.
    pub fn push(&mut self, time: f64, velocity: f64) -> bool {
        if self.anchor.is_some()
            && self.ended.is_none()
            && let Some([t, v]) = self.before.replace([time, velocity])
            && v < 0.0
            && velocity >= 0.0
        {
            let at = t + (time - t) * v / (v - velocity);
            self.periods.push(f64::from(self.crossings), at);
            self.crossings += 1;
        }
        self.squares += velocity * velocity;
        self.count += 1;
        if self.count < self.segment {
            return false;
        }
        self.last = (self.squares / self.count as f64).sqrt();
        (self.squares, self.count) = (0.0, 0);
        self.segments += 1;
        if self.last == 0.0 {
            return true;
        }
        let first = *self.first.get_or_insert(self.last);
        if self.last > Self::START_RATIO * first || self.segments >= Self::START_SEGMENTS {
            self.anchor.get_or_insert([time, self.last]);
        }
        if self.last > self.limit {
            self.ended.get_or_insert(time);
        }
        if self.anchor.is_some() && self.ended.is_none() {
            self.line.push(time, self.last.ln());
        }
        true
    }

    /// Slope of the straight line fitted to the logarithm of the level while the vibration is small, 1/s.
    pub fn growth(&self) -> Option<Measured> {
        let fit = self.line.fit()?;
        Some(Measured::new(fit.slope, fit.half_width).unit("1/s"))
    }

    /// Whether the vibration has become too large for the linear theory.
    pub fn has_ended(&self) -> bool {
        self.ended.is_some()
    }

    /// Mean frequency while the vibration is small, from its upward zero crossings, Hz; `None` for fewer crossings than a
    /// fit needs.
    pub fn frequency(&self) -> Option<Measured> {
        let fit = self.periods.fit().filter(|fit| fit.slope > 0.0)?;
        let half_width = fit.half_width / (fit.slope * fit.slope);
        Some(Measured::new(1.0 / fit.slope, half_width).unit("Hz"))
    }

    /// Predicted level at a time (s) for growth at a rate (1/s) since the start of the fit; `None` before it,
    /// and once the vibration is no longer small.
    pub fn predicted(&self, time: f64, rate: f64) -> Option<f64> {
        let [since, level] = self.anchor.filter(|_| self.ended.is_none())?;
        Some(level * (rate * (time - since)).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Growing sine at 1.7 kHz with a second, weaker one.
    fn growing(second: f64) -> Level {
        let mut level = Level::new(59, 1e-2);
        for k in 0..8000 {
            let t = f64::from(k) * 5e-6;
            let phase = std::f64::consts::TAU * t;
            let signal = (1734.5 * phase).sin() + second * (4100.0 * phase).sin();
            level.push(t, 1e-6 * (200.0 * t).exp() * signal);
        }
        level
    }

    #[test]
    fn a_growing_vibration_has_its_rate_and_its_frequency() {
        let level = growing(0.0);
        let (growth, frequency) = (level.growth().unwrap(), level.frequency().unwrap());
        assert!((growth.value / 200.0 - 1.0).abs() < 1e-3, "{growth:?}");
        let off = (frequency.value - 1734.5).abs();
        assert!(off <= frequency.half_width.max(0.1), "{frequency:?}");
        assert!(frequency.half_width < 1.0, "{frequency:?}");
    }

    #[test]
    fn a_second_mode_widens_the_interval_of_the_frequency() {
        let mixed = growing(0.3).frequency().unwrap();
        let off = (mixed.value - 1734.5).abs();
        assert!(off <= mixed.half_width, "{mixed:?}");
        let pure = growing(0.0).frequency().unwrap();
        assert!(mixed.half_width > 3.0 * pure.half_width);
    }

    #[test]
    fn few_crossings_have_no_frequency() {
        let mut level = Level::new(59, 1e-2);
        for k in 0..200 {
            level.push(f64::from(k) * 5e-6, 1e-6);
        }
        assert_eq!(level.frequency(), None);
        assert!(level.growth().is_none() && !level.has_ended());
    }
}
