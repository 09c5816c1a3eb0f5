//! Sample indices and times.

use crate::pipeline::message::Frame;

/// Time of every sample of the run from its index. Rounding errors do not accumulate.
#[derive(Clone, Copy)]
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

    /// Counts the samples of the next frame, which starts where the last one ended.
    pub fn advance(&mut self, frame: &Frame) {
        self.origin.get_or_insert(frame.t0);
        self.seen += frame.len() as u64;
    }

    /// Time of the sample with the (possibly fractional) index `k` of the run, s.
    pub fn time(&self, k: f64) -> f64 {
        self.origin.unwrap_or(0.0) + k * self.dt
    }

    /// Time of the newest sample, s.
    pub fn newest(&self) -> f64 {
        self.time(self.seen as f64 - 1.0)
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
