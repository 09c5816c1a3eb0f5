//! A partial of a sound between its ends.

use super::baseband::LOW_PASS_S;
use super::group::SAME;

/// Least ratio of the power of a tone to that of a sideband of its modulation. At a modulation depth of 1, it is 4.
pub(super) const SIDEBAND_RATIO: f64 = 3.0;

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
    /// Logarithm of the standard deviation of the power over its mean.
    pub unevenness: f64,
    /// Logarithm of the share of the variance of the level that a straight fall does not explain: small for a note that dies out.
    pub decay: f64,
    /// Logarithm of the incoherence of the phase over that of a tone in the same noise: about 0 for a tone.
    pub incoherence: f64,
    /// Logarithm of the share of the power that is new within 15 ms: small for a tone.
    pub innovation: f64,
    /// Logarithm of the kurtosis of the amplitude: 0 for a steady tone, ln 2 for noise, more for bursts.
    pub kurtosis: f64,
    /// Amplitude through the shortest low-pass in steps of [`STEP_S`] from the start.
    pub amplitudes: Vec<f64>,
    /// Frequency (Hz) and power of the tone in steps of [`STEP_S`] from the start.
    pub track: Vec<(f64, f64)>,
}

impl Partial {
    pub fn duration(&self) -> f64 {
        self.end_s - self.start_s
    }

    /// Time in which both sound, s; below 0 if they do not.
    pub fn shared_with(&self, other: &Self) -> f64 {
        self.end_s.min(other.end_s) - self.start_s.max(other.start_s)
    }

    /// Mean ratio of the frequency to that of another partial while both sound, weighted by the powers.
    pub fn ratio_to(&self, other: &Self) -> f64 {
        let start_s = self.start_s.max(other.start_s);
        let first =
            |p: &Self| (((start_s - p.start_s) / STEP_S).round() as usize).min(p.track.len());
        let pairs = self.track[first(self)..]
            .iter()
            .zip(&other.track[first(other)..]);
        let (sum, weight) = pairs.fold((0.0, 0.0), |(sum, weight), (a, b)| {
            (sum + a.1 * b.1 * a.0 / b.0, weight + a.1 * b.1)
        });
        sum / weight
    }

    /// Whether another partial has the same frequency, to a share or to the resolution of the longest low-pass, or this is a
    /// sideband of its modulation: in the band of the shortest low-pass, through which modulation is measured, and weak.
    fn belongs_to(&self, other: &Self) -> bool {
        let [resolution, band] = LOW_PASS_S.map(f64::recip);
        let distance = (self.frequency_hz - other.frequency_hz).abs();
        distance < resolution.max(SAME * other.frequency_hz)
            || distance < band && SIDEBAND_RATIO * self.power < other.power
    }

    /// Of partials that sound together at one frequency, those of the greatest energy for their incoherence: a ridge of the
    /// best resolution loses least energy and leads to no other sound. Sidebands belong to their carrier.
    pub fn distinct(mut partials: Vec<Self>) -> Vec<Self> {
        let energy = |p: &Self| p.power * p.duration() * (-p.incoherence).exp();
        partials.sort_by(|a, b| energy(b).total_cmp(&energy(a)));
        let mut kept: Vec<Self> = Vec::new();
        for partial in partials {
            let is_known =
                |other: &Self| partial.shared_with(other) > 0.0 && partial.belongs_to(other);
            if !kept.iter().any(is_known) {
                kept.push(partial);
            }
        }
        kept
    }
}
