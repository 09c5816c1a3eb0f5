//! Observations about the motion, as numbers. The text is chosen where they are displayed.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::frame::Exponents;
use crate::analysis::tones::SpectralLine;

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
