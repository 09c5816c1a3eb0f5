//! Sample indices and times.

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

    /// Counts the samples of the next frame, which starts where the last one ended, to 1 % of a sample spacing.
    pub fn advance(&mut self, frame: &Frame) -> Result<(), AnalyseError> {
        let origin = *self.origin.get_or_insert(frame.t0);
        let due = origin + self.seen as f64 * self.dt;
        let (late, off) = (frame.t0 - due, frame.dt - self.dt);
        let slack = 0.01 * self.dt;
        // A NaN fails this comparison.
        if late.abs() <= slack && off.abs() * frame.len() as f64 <= slack {
            self.seen += frame.len() as u64;
            return Ok(());
        }
        Err(AnalyseError::Gap {
            index: frame.index,
            found: frame.t0,
            dt: frame.dt,
            sample: self.seen,
            due,
        })
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
