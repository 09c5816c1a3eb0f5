//! Measurements of a run that demonstrates a mechanism, for comparison with the linear prediction.

use std::sync::Arc;

use serde::Serialize;

use super::computed::MechanismPrediction;
use super::computed::TiltDirection;
use super::frame::{Exponents, Kick};
use super::observation::TrajectoryDivergence;
use crate::analysis::{regime::Regime, tones::SpectralLine};

/// Linear prediction for the scene's mechanism, and the measurements so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// Simulated time, s.
    pub time: f64,
    /// Prediction made before the run.
    pub computed: Arc<MechanismPrediction>,
    /// Measurements so far.
    pub measured: Measurements,
}

/// Measurements of a run that demonstrates a mechanism. Shares refer to the last 25 ms. All are computed from
/// samples at fixed instants of simulated time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measurements {
    /// Growth rate of the velocity level while the vibration is small.
    pub growth: Option<Growth>,
    /// Whether the linear growth has ended: the vibration has become too large for the linear theory.
    pub growth_ended: bool,
    /// Frequency while the vibration is small.
    pub small_frequency: Option<SmallFrequency>,
    /// Peak speed: largest magnitude of the velocity in the last 25 ms, m/s.
    pub peak_speed: Option<f64>,
    /// First nonzero level, m/s.
    pub first_level: Option<f64>,
    /// Velocity level: RMS over the last half natural period, m/s.
    pub level: f64,
    /// Whether the vibration is at rest: the level is below [`Header::rest_speed`](super::Header::rest_speed).
    pub at_rest: bool,
    /// Type of motion by the last classification.
    pub regime: Option<Regime>,
    /// Kicks after the one at the start of the run: their number.
    pub kicks: usize,
    /// The last of these kicks.
    pub last_kick: Option<Kick>,
    /// Lines of the last spectrum, strongest first; empty before the first spectrum.
    pub lines: Vec<SpectralLine>,
    /// States of the contact nodes, for a joint with a patch rate.
    pub nodes: Option<NodeShares>,
    /// States of a small system.
    pub statuses: Option<StatusShares>,
    /// The leader at the end of the growth: the family of modes with the most energy.
    pub leader_at_end: Option<String>,
    /// Family of modes with the most energy.
    pub leader: Option<String>,
    /// Present tilt, rad.
    pub tilt: Option<f64>,
    /// Other numbers of the scene that commands have changed: name, present value and unit.
    pub changed: Vec<String>,
    /// Strongest spectral line while the tilt rises and falls, if hysteresis or articulation is the mechanism.
    pub tilts: Option<TiltLoop>,
    /// The squeak in each pass of a joint that turns to and fro, if articulation is the mechanism.
    pub passes: Vec<SqueakPass>,
    /// The second tone of a torus, if its birth is the mechanism.
    pub second_tone: Option<SecondToneLevel>,
    /// Distance of the perturbed trajectory: first and last value.
    pub separation: Option<[TrajectoryDivergence; 2]>,
    /// Last Lyapunov exponents.
    #[serde(skip)]
    pub exponents: Option<Arc<Exponents>>,
}

/// A growth rate with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// Growth rate, 1/s.
    pub rate: f64,
    /// Half-width of its 95 % confidence interval, 1/s.
    pub half_width: f64,
}

/// The frequency of a small vibration with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SmallFrequency {
    /// Mean frequency, Hz.
    pub frequency_hz: f64,
    /// Half-width of its 95 % confidence interval, Hz.
    pub half_width_hz: f64,
}

/// The squeak while a joint turns in one direction, from one reversal to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SqueakPass {
    /// Direction in which the tilt changes.
    pub way: TiltDirection,
    /// Tilts at which the velocity level first and last exceeded a twentieth of the largest sliding speed, rad.
    pub squeak: Option<[f64; 2]>,
    /// Whether the level has been lower since then, for 5 ms.
    pub has_ended: bool,
}

/// Level of the second tone of a torus that is born.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SecondToneLevel {
    /// Amplitude of its two side lines relative to that of the first tone, root of the sum of squares, in the last window.
    pub ratio: f64,
    /// The last measured decay, at tilts at which the multipliers are inside the unit circle.
    pub decay: Option<ToneGrowth>,
    /// The last measured growth, at tilts at which they are outside.
    pub growth: Option<ToneGrowth>,
}

/// Growth of a small second tone over an interval of the tilt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToneGrowth {
    /// Tilts at the first and at the last window, rad.
    pub tilts: [f64; 2],
    /// Mean growth rate.
    pub growth: Growth,
    /// Computed mean growth rate by the Floquet multipliers at these tilts, 1/s.
    pub computed_per_s: f64,
}

/// Shares of contact nodes that stick or have separated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NodeShares {
    /// Mean share of sticking nodes, 0 to 1.
    pub stuck: f64,
    /// The most stuck nodes: largest share that sticks simultaneously, 0 to 1.
    pub most_stuck: f64,
    /// Share of the time in which at least half of the nodes stick, 0 to 1.
    pub half_stuck: f64,
    /// Mean share of separated nodes, 0 to 1.
    pub separated: f64,
    /// The most separated nodes: largest share that is separated simultaneously, 0 to 1.
    pub most_separated: f64,
    /// Share of the time in which all nodes are separated, 0 to 1.
    pub all_separated: f64,
    /// Separations per node and second, 1/s.
    pub separations_per_s: f64,
}

/// Shares of the states of a small system.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatusShares {
    /// Share of the time in which it sticks, rests or touches, 0 to 1.
    pub held: f64,
    /// Number of releases per second, 1/s.
    pub releases_per_s: f64,
}

/// Loop over the tilt: the strongest spectral line over a tilt that rises and falls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TiltLoop {
    /// Tilt of the last line, rad; `None` before the tilt changes.
    pub tilt: Option<f64>,
    /// Whether the tilt has decreased at least once.
    pub has_decreased: bool,
    /// Lasting changes of the line while the tilt rises.
    pub up: Vec<ToneChange>,
    /// Lasting changes of the line while the tilt falls.
    pub down: Vec<ToneChange>,
    /// Smallest and largest tilt, rad, of the differing lines between rise and fall.
    pub differing: Option<[f64; 2]>,
    /// Tilt of the last change during the rise, rad.
    pub last_up: Option<f64>,
    /// Tilt of the change back during the fall, rad, if it is smaller.
    pub back: Option<f64>,
}

/// A change of the strongest spectral line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToneChange {
    /// Frequency before the change, Hz.
    pub from: f64,
    /// The new line at its first occurrence.
    pub to: TiltedTone,
}

/// Level and strongest spectral line at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSample {
    /// Simulated time, s.
    pub time: f64,
    /// Measured level: RMS velocity of the probe over the half natural period that ends at `time`, m/s.
    pub level: f64,
    /// Predicted level: growth at the largest computed rate, m/s; `None` once the vibration is too large for
    /// the linear theory.
    pub predicted: Option<f64>,
    /// Strongest line at its tilt, if the tilt varies.
    pub tone: Option<TiltedTone>,
}

/// The strongest spectral line at a tilt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TiltedTone {
    /// Tilt at the centre of the window of the spectrum, rad.
    pub tilt: f64,
    /// Direction in which the tilt changes.
    pub way: TiltDirection,
    /// Frequency of the line, Hz.
    pub frequency: f64,
}
