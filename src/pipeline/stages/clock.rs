//! Sample indices and times.

use std::sync::Arc;

use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::Frame;

/// Time of every sample of the run from its index. Rounding errors do not accumulate.
pub struct Clock {
    dt: f64,
    origin: Option<f64>,
    seen: u64,
}

impl Clock {
    /// For samples at `rate` (Hz). The first frame defines the origin.
    pub fn new(rate: f64) -> Self {
        Self {
            dt: 1.0 / rate,
            origin: None,
            seen: 0,
        }
    }

    /// Checks that the next frames start where those before them end, to 1 % of a sample spacing, and sets the
    /// origin.
    pub fn check(&mut self, frames: &[Arc<Frame>]) -> Result<(), AnalyseError> {
        let mut sample = self.seen;
        for frame in frames {
            let origin = *self.origin.get_or_insert(frame.t0);
            let due = origin + sample as f64 * self.dt;
            let (late, off) = (frame.t0 - due, frame.dt - self.dt);
            let slack = 0.01 * self.dt;
            // A NaN fails this comparison.
            if !(late.abs() <= slack && off.abs() * frame.len() as f64 <= slack) {
                return Err(AnalyseError::Gap {
                    index: frame.index,
                    found: frame.t0,
                    dt: frame.dt,
                    sample,
                    due,
                });
            }
            sample += frame.len() as u64;
        }
        Ok(())
    }

    /// Counts the samples of an analysed frame.
    pub fn advance(&mut self, frame: &Frame) {
        self.seen += frame.len() as u64;
    }

    /// Number of samples analysed so far.
    pub fn seen(&self) -> u64 {
        self.seen
    }

    /// Time of the sample with the (possibly fractional) index `k` of the run, s.
    pub fn time(&self, k: f64) -> f64 {
        self.origin.unwrap_or(0.0) + k * self.dt
    }

    /// Simulated time so far, s.
    pub fn elapsed(&self) -> f64 {
        self.seen as f64 * self.dt
    }
}

/// A time in samples, at least `least`.
pub fn samples(seconds: f64, rate: f64, least: usize) -> usize {
    ((seconds * rate).round() as usize).max(least)
}
