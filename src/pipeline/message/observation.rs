//! What a run shows, as numbers; words are chosen where they are shown.

use std::sync::Arc;

use serde::Serialize;

use super::frame::Exponents;
use crate::analysis::SpectralLine;

/// How far two copies have parted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parting {
    /// Time of the newest sample, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Time of the first sample of the second copy, s.
    #[serde(rename = "start_s")]
    pub start: f64,
    /// Their distance (see [`TwinSamples::distance`](super::TwinSamples::distance)): root of the
    /// mean square since the last such record.
    pub distance: f64,
    /// The straight line through the logarithm of the distance, from where it last rose above
    /// [`TwinSamples::floor`](super::TwinSamples::floor) until it is saturated; `None` as long as there are
    /// too few distances.
    pub line: Option<PartingLine>,
    /// When the distance had become as large as the motion itself, s; it can grow no more.
    #[serde(rename = "saturated_s")]
    pub saturated: Option<f64>,
}

/// `ln(distance) = intercept + rate (t - start)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PartingLine {
    /// The rate, 1/s: an estimate of the largest exponent.
    #[serde(rename = "rate_per_s")]
    pub rate: f64,
    /// Half the width of its 95 % interval by the scatter about the line, 1/s.
    #[serde(rename = "half_width_per_s")]
    pub half_width: f64,
    /// Time of the first distance that the line goes through, s.
    #[serde(rename = "since_s")]
    pub since: f64,
    /// Logarithm of the distance at the start.
    pub intercept: f64,
}

impl PartingLine {
    /// Whether the distance grows, as far as the scatter about the line can tell.
    pub fn grows(&self) -> bool {
        self.rate > self.half_width
    }

    /// Whether the distance shrinks, as far as the scatter about the line can tell.
    pub fn shrinks(&self) -> bool {
        self.rate < -self.half_width
    }
}

/// Something a run shows that is worth a few sentences.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// The vibration now.
    Vibration(Box<Vibration>),
    /// The perturbed trajectory has separated from the first one.
    Separated {
        /// Distance at the start, relative to the motion.
        initial_distance: f64,
        /// Time from the start until the distance was as large as the motion, s.
        after: f64,
        /// Time in which the distance grew by the factor e, s; `None` if growth was not measured.
        e_fold_time: Option<f64>,
    },
    /// The exponents at the end of the run.
    Exponents(Arc<Exponents>),
}

/// A vibration, by its envelope and its spectrum since the envelope last changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vibration {
    /// What it looks like.
    pub appearance: Appearance,
    /// Growth rate of the envelope, 1/s.
    pub growth_rate: f64,
    /// Spectral lines of the velocity, the strongest first.
    pub lines: Vec<SpectralLine>,
    /// The first base frequency, Hz, if the lines have one.
    pub f1: Option<f64>,
    /// The second base frequency, Hz, if the lines have one.
    pub f2: Option<f64>,
    /// The lowest difference frequency of the two, Hz.
    pub beat: Option<f64>,
    /// Amplitude of the second tone over that of the first.
    pub second_tone: f64,
    /// Share of the power in the broadband floor.
    pub floor_share: f64,
    /// Largest speed of the contact point, m/s.
    pub peak_speed: f64,
    /// Largest speed against the sliding direction, m/s, 0 or more.
    pub backward_speed: f64,
    /// Half the range of the displacement, m.
    pub half_range: f64,
    /// What acts on the joint.
    pub now: Circumstances,
}

/// What acts on the joint at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Circumstances {
    /// Tilt, rad.
    pub tilt: f64,
    /// Load, N, where it varies.
    pub load: Option<f64>,
    /// Factor on the rotation, where it varies.
    pub rotation_factor: Option<f64>,
    /// Slip speed in steady sliding, m/s: what velocities are compared with.
    pub sliding_speed: f64,
}

/// What a vibration looks like. A spectrum and an envelope prove neither a torus nor chaos.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    /// Hardly anything moves.
    Silent,
    /// The envelope rises.
    Growing,
    /// The envelope falls.
    Fading,
    /// The envelope has just stopped changing; too early for more.
    Settling,
    /// One fundamental and its harmonics; a second tone at most faint.
    Tone,
    /// Two base frequencies and their combinations.
    TwoTones,
    /// Lines over a broad floor.
    Broad,
    /// Lines without a simple pattern, or none.
    Unsettled,
}
