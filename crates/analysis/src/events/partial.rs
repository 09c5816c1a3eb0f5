//! A partial of a sound between its ends.

use super::baseband::median;

/// Step of the results, s.
pub(super) const STEP_S: f64 = 0.005;

/// A partial between its ends.
#[derive(Clone, Debug)]
pub(super) struct Partial {
    pub start_s: f64,
    pub end_s: f64,
    /// Mean frequency weighted by power, Hz.
    pub frequency_hz: f64,
    /// Mean power of the tone and noise power per hertz, square of the signal's unit.
    pub power: f64,
    pub noise: f64,
    /// Standard deviation of the power over its mean.
    pub unevenness: f64,
    /// Logarithm of the incoherence of the phase over that of a tone in the same noise: about 0 for a tone.
    pub incoherence: f64,
    /// Logarithm of the share of the power that is new within 15 ms: small for a tone.
    pub innovation: f64,
    /// Frequency (Hz) and power of the tone in steps of [`STEP_S`] from the start.
    pub track: Vec<(f64, f64)>,
}

impl Partial {
    pub fn time(&self, i: usize) -> f64 {
        self.start_s + STEP_S * i as f64
    }

    pub fn duration(&self) -> f64 {
        self.end_s - self.start_s
    }

    /// Time in which both sound, s; below 0 if they do not.
    pub fn shared_with(&self, other: &Self) -> f64 {
        self.end_s.min(other.end_s) - self.start_s.max(other.start_s)
    }

    /// Power over noise per hertz.
    pub fn strength(&self) -> f64 {
        self.power / self.noise
    }

    /// Frequency at a time within the partial, mean over 0.05 s weighted by power, Hz.
    pub fn frequency_at(&self, time_s: f64) -> f64 {
        let at = ((time_s - self.start_s) / STEP_S).max(0.0) as usize;
        let last = self.track.len();
        let near = &self.track[at.saturating_sub(5).min(last - 1)..(at + 6).min(last)];
        let weight: f64 = near.iter().map(|p| p.1).sum();
        if weight > 0.0 {
            near.iter().map(|p| p.0 * p.1).sum::<f64>() / weight
        } else {
            self.frequency_hz
        }
    }

    /// Median ratio of the frequency to that of another partial while both sound, and the share of this
    /// partial's duration in which they do.
    pub fn ratio_to(&self, other: &Self) -> Option<(f64, f64)> {
        let (start, shared) = (self.start_s.max(other.start_s), self.shared_with(other));
        if shared < 0.05 {
            return None;
        }
        let ratios = (0..21)
            .map(|k| start + shared * (f64::from(k) + 0.5) / 21.0)
            .map(|t| self.frequency_at(t) / other.frequency_at(t));
        Some((median(ratios), shared / self.duration()))
    }
}
