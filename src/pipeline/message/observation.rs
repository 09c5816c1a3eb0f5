//! Observations about the motion, as numbers. The text is chosen where they are displayed.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::tones::SpectralLine;
use crate::dynamics::{Attractor, LyapunovSpectrum, Motion};

/// Lyapunov exponents of a run up to a time.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Exponents {
    /// Simulated time, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Exponents averaged since the end of the settling time or the last change of the motion.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
    /// Further properties of the motion.
    pub motion: Motion,
    /// Lowest natural frequency `omega_1`, rad/s. An exponent divided by it refers to the dimensionless time
    /// `tau = omega_1 t`.
    #[serde(rename = "omega_1_rad_per_s")]
    pub omega_1: f64,
    /// Successive motions since the end of the settling time; the last one has the exponents above.
    pub segments: Vec<MotionSegment>,
    /// Lifetime of the chaotic transient before the last motion, s, from the start of the run or the last
    /// change of tilt, load or rotation; `None` if there was none.
    #[serde(rename = "chaotic_transient_s")]
    pub chaotic_transient: Option<f64>,
}

impl Exponents {
    /// The attractor that the exponents indicate.
    pub fn attractor(&self) -> Attractor {
        self.spectrum.attractor_of(self.motion)
    }
}

/// A motion between two changes of attractor, with its exponents.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MotionSegment {
    /// Start time, s: of the averaging for the first motion, else of the change.
    pub start_s: f64,
    /// End time, s.
    pub end_s: f64,
    /// Attractor that the exponents indicate.
    #[schemars(with = "String")]
    pub attractor: Attractor,
    /// Exponents averaged within the motion; of zero averaging time if it is too short.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
}

impl MotionSegment {
    /// Lifetime of the chaotic transient before the last motion, s: the time from `since` (s), when the
    /// motion started under its present parameters, to the end of the last chaotic segment before the last
    /// one. `None` if no earlier motion under these parameters was chaotic.
    pub fn chaotic_transient(segments: &[Self], since: f64) -> Option<f64> {
        let (_, earlier) = segments.split_last()?;
        let mut chaotic = earlier.iter().rev().filter(|s| s.attractor.is_chaotic());
        let end = chaotic.next()?.end_s;
        (end > since).then_some(end - since)
    }
}

/// Distance of the perturbed trajectory from the simulated one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TrajectoryDivergence {
    /// Time of the newest sample, s.
    pub time_s: f64,
    /// Start time of the perturbed trajectory, s.
    pub start_s: f64,
    /// Distance, see [`PerturbedSamples::distance`](super::PerturbedSamples::distance): RMS since the last record.
    pub distance: f64,
    /// Straight line fitted to the logarithm of the distance, from its last rise above
    /// [`PerturbedSamples::floor`](super::PerturbedSamples::floor) until saturation; `None` if there are too few
    /// distances.
    pub line: Option<DivergenceFit>,
    /// Time at which the distance reached 0.1 of the largest norm of the motion, s: exponential growth ends.
    pub saturated_s: Option<f64>,
}

/// `ln(distance) = intercept + rate (t - start)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DivergenceFit {
    /// Rate of divergence, 1/s: the slope, an estimate of the largest Lyapunov exponent.
    pub rate_per_s: f64,
    /// Half-width of its 95 % confidence interval from the scatter about the line, 1/s.
    #[schemars(with = "Option<f64>")]
    pub half_width_per_s: f64,
    /// Time since which distances are used for the fit, s.
    pub since_s: f64,
    /// Logarithm of the distance at the start.
    pub intercept: f64,
}

impl DivergenceFit {
    /// Whether the 95 % confidence interval of the rate is positive.
    pub fn grows(&self) -> bool {
        self.rate_per_s > self.half_width_per_s
    }

    /// Whether the 95 % confidence interval of the rate is negative.
    pub fn shrinks(&self) -> bool {
        self.rate_per_s < -self.half_width_per_s
    }
}

/// An observation worth a few sentences.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// The present vibration.
    Vibration(Box<Vibration>),
    /// The perturbed trajectory has separated from the simulated one.
    Separated {
        /// Initial distance, relative to the motion.
        initial_distance: f64,
        /// Time from the start until the distance reached 0.1 of the largest norm of the motion, s.
        after: f64,
        /// Time in which the distance grew by the factor e, s; `None` if no growth was measured.
        e_fold_time: Option<f64>,
    },
    /// Lyapunov exponents at the end of the run.
    Exponents(Arc<Exponents>),
}

/// A vibration, by its envelope and its spectrum since the last change of the envelope.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vibration {
    /// Appearance.
    pub appearance: Appearance,
    /// Growth rate of the envelope, 1/s.
    pub growth_rate: f64,
    /// Spectral lines of the velocity, strongest first.
    pub lines: Vec<SpectralLine>,
    /// First base frequency, Hz, if the lines have one.
    pub f1: Option<f64>,
    /// Second base frequency, Hz, if the lines have one.
    pub f2: Option<f64>,
    /// Lowest difference frequency of the two, Hz.
    pub beat: Option<f64>,
    /// Amplitude ratio of the second tone to the first.
    pub second_tone: f64,
    /// Broadband share of the power, 0 to 1.
    pub broadband_share: f64,
    /// Peak speed of the contact point, m/s.
    pub peak_speed: f64,
    /// Peak backward speed, against the sliding direction, m/s, at least 0.
    pub backward_speed: f64,
    /// Half the peak-to-peak displacement, m.
    pub half_range: f64,
    /// The operating point of the joint now.
    pub now: OperatingPoint,
}

/// Operating point of the joint at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OperatingPoint {
    /// Tilt, rad.
    pub tilt: f64,
    /// Load, N; `None` if it is constant.
    pub load: Option<f64>,
    /// Rotation factor; `None` if it is constant.
    pub rotation_factor: Option<f64>,
    /// Slip speed in steady sliding, m/s, the reference of velocities.
    pub sliding_speed: f64,
}

/// Appearance of a vibration. A spectrum and an envelope prove neither a torus nor chaos.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    /// At rest: the motion, if any, is below [`Header::rest_speed`](super::Header::rest_speed).
    AtRest,
    /// Almost no motion.
    Silent,
    /// Rising envelope.
    Growing,
    /// Falling envelope.
    Fading,
    /// The envelope has just become stationary; too early for a classification.
    Settling,
    /// One fundamental with its harmonics; a second tone is weak or absent.
    Tone,
    /// Two base frequencies and their combinations.
    TwoTones,
    /// Lines over a broadband floor.
    Broad,
    /// Lines without a simple pattern, or no lines.
    Unsettled,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transient_lives_until_its_last_chaotic_motion_ends() {
        let segment = |start, end, attractor| MotionSegment {
            start_s: start,
            end_s: end,
            attractor,
            spectrum: LyapunovSpectrum::default(),
        };
        let [chaos, approach, cycle] = [
            segment(0.1, 0.8, Attractor::Chaos),
            segment(0.8, 0.9, Attractor::Undecided),
            segment(0.9, 2.0, Attractor::Cycle),
        ];
        let lifetime = |segments: &[&MotionSegment], since| {
            let segments: Vec<MotionSegment> = segments.iter().copied().cloned().collect();
            MotionSegment::chaotic_transient(&segments, since)
        };
        assert_eq!(lifetime(&[&chaos, &cycle], 0.0), Some(0.8));
        assert_eq!(
            lifetime(&[&chaos, &approach, &cycle], 0.25),
            Some(0.8 - 0.25)
        );
        // The chaos belongs to other parameters.
        assert_eq!(lifetime(&[&chaos, &cycle], 0.85), None);
        assert_eq!(lifetime(&[&approach, &cycle], 0.0), None);
        assert_eq!(lifetime(&[&cycle, &chaos], 0.0), None);
        assert_eq!(lifetime(&[&chaos], 0.0), None);
        assert_eq!(lifetime(&[], 0.0), None);
    }
}
