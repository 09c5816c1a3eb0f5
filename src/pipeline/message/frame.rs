//! What travels from the simulation to the analysis.

use std::sync::Arc;

use serde::Serialize;

use crate::dynamics::{Attractor, ErrorEstimate, LyapunovSpectrum, Motion, Tally};

/// The state of one contact node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum NodeState {
    /// In contact, slip speed in the creep region of the friction curve and below a tenth of steady
    /// sliding.
    Stick,
    /// In contact and sliding.
    Slip,
    /// Lifted off: the normal force is zero.
    Separated,
}

/// Where the contact nodes are; shared by all frames of one tilt, load and rotation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchGeometry {
    /// Positions of the nodes from the ball's centre, m.
    pub positions: Vec<[f64; 3]>,
    /// Outward unit normals of the ball at the nodes.
    pub normals: Vec<[f64; 3]>,
    /// Area of each node, m^2.
    pub areas: Vec<f64>,
    /// Pre-stress of each node, Pa.
    pub pre_stress: Vec<f64>,
    /// Unit vector from the ball's centre to the centre of the patch (against the load).
    pub direction: [f64; 3],
    /// Radius of the patch, m.
    pub radius: f64,
}

/// The contact nodes at one instant; vectors run over the nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchSnapshot {
    /// Simulated time, s.
    pub time: f64,
    /// State of each node.
    pub states: Vec<NodeState>,
    /// Normal force on each node, N (stress times area, never negative).
    pub normal_force: Vec<f64>,
    /// Friction force on the ball at each node, N.
    pub friction: Vec<[f64; 3]>,
}

impl PatchSnapshot {
    /// How many nodes are in a state.
    pub fn count(&self, state: NodeState) -> usize {
        self.states.iter().filter(|&&s| s == state).count()
    }
}

/// Energies at one instant, J, as differences from the steady-sliding equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergySample {
    /// Simulated time, s.
    pub time: f64,
    /// Vibration energy of each mode, `(q'^2 + omega^2 q^2) / 2`.
    pub modal: Vec<f64>,
    /// All that is stored (modes, contact springs, pre-load), J.
    pub total: f64,
    /// Work of friction on the vibration since the start, J.
    pub friction_work: f64,
    /// What the audit misses: total now - total at the start - work of friction - what changes of tilt,
    /// load and rotation brought in, J.
    pub residual: f64,
}

/// Lyapunov exponents of a run so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exponents {
    /// Simulated time, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// The exponents, by the growth since the motion has settled.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
    /// What is known of the motion beside them.
    pub motion: Motion,
    /// The lowest natural frequency `omega_1`, rad/s: an exponent over it belongs to the time
    /// `tau = omega_1 t`.
    #[serde(rename = "omega_1_rad_per_s")]
    pub omega_1: f64,
}

impl Exponents {
    /// What the motion comes to.
    pub fn attractor(&self) -> Attractor {
        self.spectrum.attractor_of(self.motion)
    }
}

/// A second copy of the joint that started almost in the state of the first, at the samples of a
/// frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TwinSamples {
    /// Index of the first sample of the frame at which there is a second copy; the vectors begin
    /// there.
    pub first: usize,
    /// Displacement of the second copy's probe, m.
    pub displacement: Vec<f64>,
    /// Velocity of the second copy's probe, m/s.
    pub velocity: Vec<f64>,
    /// Distance of the two states in the norm of the vibration's energy, over the largest size
    /// (norm of the state) that the first copy has had.
    pub distance: Vec<f64>,
    /// Distance below which the two may be parted by the errors of their steps, and not by the flow.
    pub floor: f64,
}

/// A batch of uniform samples with what belongs to the same stretch of time. Owned data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// Time of the first sample, s.
    pub t0: f64,
    /// Sample spacing, s.
    pub dt: f64,
    /// Number of modes `m`.
    pub modes: usize,
    /// Modal coordinates in the perturbation from equilibrium, `samples x m`, row-major, sqrt(kg) m.
    pub q: Vec<f64>,
    /// Modal velocities, `samples x m`, row-major, sqrt(kg) m/s.
    pub qdot: Vec<f64>,
    /// Displacement of the central contact point in the sliding direction, Eq. (24), m.
    pub displacement: Vec<f64>,
    /// Velocity of the same point in the same direction, m/s.
    pub velocity: Vec<f64>,
    /// Tilt of the load during this frame, rad.
    pub tilt: f64,
    /// Load during this frame, N.
    pub load: f64,
    /// Factor on the rotation during this frame.
    pub rotation_factor: f64,
    /// Contact nodes of this frame.
    pub geometry: Arc<PatchGeometry>,
    /// Snapshots of the contact nodes, in time order, at the scene's patch rate.
    pub patch: Vec<PatchSnapshot>,
    /// Energies, in time order.
    pub energy: Vec<EnergySample>,
    /// Contact transitions in this frame: of a joint, nodes opening or closing between samples; of a
    /// small system, guards crossed.
    pub transitions: u64,
    /// Exponents where they were due in this frame, in time order; none unless asked for.
    pub exponents: Vec<Exponents>,
    /// The second copy, beside the samples; `None` unless asked for.
    pub twin: Option<TwinSamples>,
    /// Status of a small system at each sample, an index of [`SmallInfo::statuses`](super::SmallInfo::statuses); empty for
    /// others.
    pub status: Vec<u8>,
    /// Work of the integrator since the start.
    pub tally: Tally,
    /// The largest local error of the steps to this frame; `None` where steps have no estimate.
    pub error: Option<ErrorEstimate>,
    /// Wall time the simulation thread has spent integrating since the start, s.
    pub busy_seconds: f64,
    /// What was done to the run at the first sample, in words.
    pub events: Vec<String>,
    /// How much of it is to be drawn; `None` for all that the scene asks for.
    pub shown: Option<Shown>,
}

/// How much of a run is drawn while somebody watches it, whatever its pace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Pictures of body and patch in a simulated second.
    pub pictures: f64,
    /// Of the series every so many samples one is drawn, at least 1.
    pub every: usize,
    /// Windows of an analysis are looked at that end so many samples apart, or more.
    pub apart: u64,
}

impl Frame {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.displacement.len()
    }

    /// Whether the frame holds no sample.
    pub fn is_empty(&self) -> bool {
        self.displacement.is_empty()
    }

    /// Samples from one window of an analysis that is looked at to the next, at least; 0 for all that the scene
    /// asks for.
    pub fn apart(&self) -> u64 {
        self.shown.map_or(0, |shown| shown.apart)
    }

    /// Time of sample `k`, s.
    pub fn time(&self, k: usize) -> f64 {
        self.t0 + k as f64 * self.dt
    }

    /// Time just past the last sample, s: where the next frame starts.
    pub fn end(&self) -> f64 {
        self.time(self.len())
    }
}
