//! What a run shows of the mechanism of its scene: measurements to set against what was computed.

use std::sync::Arc;

use serde::Serialize;

use super::computed::Computed;
use super::frame::Exponents;
use super::observation::Parting;
use crate::analysis::SpectralLine;

/// What was computed of the scene's mechanism, and what has been measured so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// Simulated time, s.
    pub time: f64,
    /// What was computed before the run.
    pub computed: Arc<Computed>,
    /// What has been measured.
    pub measured: Measurements,
}

/// What has been measured in a run that shows a mechanism; shares are of the last 25 ms.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measurements {
    /// Growth of the velocity level, as long as it is small.
    pub growth: Option<Growth>,
    /// Whether the vibration has become too large for the linear theory.
    pub growth_ended: bool,
    /// The first level that is not zero, m/s.
    pub first_level: Option<f64>,
    /// Root mean square of the velocity over the last half natural period, m/s.
    pub level: f64,
    /// Lines of the last spectrum, the strongest first; empty before the first one.
    pub lines: Vec<SpectralLine>,
    /// States of the contact nodes, of a joint with snapshots of them.
    pub nodes: Option<NodeShares>,
    /// Statuses, of a small system.
    pub statuses: Option<StatusShares>,
    /// The modes with the most energy when growth ended.
    pub leader_at_end: Option<String>,
    /// The modes with the most energy.
    pub leader: Option<String>,
    /// The tilt now, rad.
    pub tilt: Option<f64>,
    /// The strongest line over a tilt that goes up and comes down, where that is the mechanism.
    pub tilts: Option<TiltLoop>,
    /// Distance of the perturbed trajectory: the first one, and the last.
    pub separation: Option<[Parting; 2]>,
    /// The last exponents.
    #[serde(skip)]
    pub exponents: Option<Arc<Exponents>>,
}

/// A growth rate with its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// The rate, 1/s.
    pub rate: f64,
    /// Half the width of its 95 % interval, 1/s.
    pub half_width: f64,
}

/// Contact nodes that stick and that have separated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NodeShares {
    /// Mean share of the nodes that stick.
    pub stuck: f64,
    /// Largest share of the nodes that stick at once.
    pub most_stuck: f64,
    /// Share of the time in which half of the nodes stick.
    pub half_stuck: f64,
    /// Mean share of the nodes that are separated.
    pub separated: f64,
    /// Largest share of the nodes that are separated at once.
    pub most_separated: f64,
    /// Share of the time in which all nodes are separated.
    pub all_separated: f64,
    /// How often a node separates, 1/s.
    pub separations_per_s: f64,
}

/// What a small system has been doing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatusShares {
    /// Share of the time in which it sticks, rests or touches.
    pub held: f64,
    /// How often that ends, 1/s.
    pub releases_per_s: f64,
}

/// The strongest line over a tilt that goes up and comes down.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TiltLoop {
    /// The tilt of the last line, rad; `None` before the tilt has moved.
    pub tilt: Option<f64>,
    /// Whether the tilt has come down, be it a little.
    pub has_come_down: bool,
    /// Changes from one lasting line to another on the way up.
    pub up: Vec<ToneChange>,
    /// The same on the way down.
    pub down: Vec<ToneChange>,
    /// The smallest and the largest tilt with different lines up and down, rad.
    pub differing: Option<[f64; 2]>,
    /// Tilt of the last change on the way up, rad.
    pub last_up: Option<f64>,
    /// Tilt of the change back after it, rad, if it is smaller.
    pub back: Option<f64>,
}

/// A change of the strongest line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToneChange {
    /// The line before, Hz.
    pub from: f64,
    /// The new line, where it first appeared.
    pub to: TiltedTone,
}

/// Level and strongest line at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Simulated time, s.
    pub time: f64,
    /// Measured: root mean square of the probe's velocity over the half natural period that ends then, m/s.
    pub level: f64,
    /// Computed: where the level would be if it had grown at the largest computed growth rate;
    /// `None` once the vibration is too large for the linear theory.
    pub predicted: Option<f64>,
    /// The strongest line at a tilt, where the tilt changes.
    pub tone: Option<TiltedTone>,
}

/// The strongest line at a tilt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TiltedTone {
    /// Tilt in the middle of the window of the spectrum, rad.
    pub tilt: f64,
    /// Which way the tilt went.
    pub way: Way,
    /// The line, Hz.
    pub frequency: f64,
}

/// Which way a tilt goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// Up, and at the top.
    Up,
    /// Down, and at the bottom afterwards.
    Down,
}
