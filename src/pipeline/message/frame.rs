//! Messages from the simulation to the analysis.

use std::sync::Arc;

use serde::Serialize;

use super::observation::Exponents;
use crate::dynamics::{ErrorEstimate, SolverStats};
use crate::pipeline::RunState;
use crate::scene::Parameter;

/// The state of one contact node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum NodeState {
    /// In contact, with a slip speed in the creep range of the friction curve and below a tenth of steady
    /// sliding.
    Stick,
    /// In contact and sliding.
    Slip,
    /// Separated: the normal force is zero.
    Separated,
}

/// The shown contact nodes, shared by all frames with the same tilt, load and rotation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchGeometry {
    /// Positions of the nodes relative to the ball's centre, m.
    pub positions: Vec<[f64; 3]>,
    /// Area of each node, m^2.
    pub areas: Vec<f64>,
    /// Pre-stress of each node, Pa.
    pub pre_stress: Vec<f64>,
    /// Unit vector from the ball's centre to the patch centre (against the load).
    pub direction: [f64; 3],
    /// Radius of the patch, m.
    pub radius: f64,
}

/// The shown contact nodes at one instant. Each vector has one entry per node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchSnapshot {
    /// Simulated time, s.
    pub time: f64,
    /// State of each node.
    pub states: Vec<NodeState>,
    /// Normal force on each node, N (stress times area, at least 0).
    pub normal_force: Vec<f64>,
    /// Friction force on the ball at each node, N.
    pub friction: Vec<[f64; 3]>,
}

impl PatchSnapshot {
    /// Number of nodes in a state.
    pub fn count(&self, state: NodeState) -> usize {
        self.states.iter().filter(|&&s| s == state).count()
    }

    /// Normal force and friction on the ball, N, each summed over the nodes.
    pub fn forces(&self) -> [f64; 2] {
        let friction = (0..3).map(|c| self.friction.iter().map(|f| f[c]).sum::<f64>());
        let friction = friction.map(|c| c * c).sum::<f64>().sqrt();
        [self.normal_force.iter().sum(), friction]
    }
}

/// Counts of the shown contact nodes at one instant.
///
/// The instants are multiples of a fixed interval of simulated time, that of the scene's patch rate, at every
/// playback speed: a share over `N` of them is off by at most `k / N` if the state changes `k` times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSample {
    /// Simulated time, s.
    pub time: f64,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of sticking nodes.
    pub stuck: usize,
    /// Number of separated nodes.
    pub separated: usize,
    /// Number of nodes that are separated now and were closed at the previous instant.
    pub separations: usize,
}

impl ContactSample {
    /// The counts of a snapshot; `before` holds the states at the previous instant, empty at the first one.
    pub fn of(snapshot: &PatchSnapshot, before: &[NodeState]) -> Self {
        let pairs = before.iter().zip(&snapshot.states);
        let separations = pairs.filter(|(before, now)| {
            **before != NodeState::Separated && **now == NodeState::Separated
        });
        Self {
            time: snapshot.time,
            nodes: snapshot.states.len(),
            stuck: snapshot.count(NodeState::Stick),
            separated: snapshot.count(NodeState::Separated),
            separations: separations.count(),
        }
    }
}

/// A kick: a random velocity added to each mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Kick {
    /// Simulated time, s.
    pub time_s: f64,
    /// Standard deviation of the modal velocities, sqrt(kg) m/s.
    pub size: f64,
    /// Seed of the random velocities.
    pub seed: u64,
}

/// Energies at one instant, J, as differences from the steady-sliding equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergySample {
    /// Simulated time, s.
    pub time: f64,
    /// Vibration energy of each mode, `(q'^2 + omega^2 q^2) / 2`.
    pub modal: Vec<f64>,
    /// Total stored energy (modes, contact springs, pre-load), J.
    pub total: f64,
    /// Work of friction on the vibration since the start, J.
    pub friction_work: f64,
    /// Residual of the audit, J: present energy - initial energy - work of friction - energy added by kicks
    /// and by changes of tilt, load and rotation.
    pub residual: f64,
}

/// The perturbed trajectory at the last samples of a frame: at all of them, unless it starts in the frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PerturbedSamples {
    /// Displacement of its probe, m.
    pub displacement: Vec<f64>,
    /// Velocity of its probe, m/s.
    pub velocity: Vec<f64>,
    /// Distance of the two states in the energy norm, divided by the largest norm of the simulated state so
    /// far.
    pub distance: Vec<f64>,
    /// Distance below which step errors, and not the flow, may dominate.
    pub floor: f64,
}

/// A batch of uniform samples with all data of the same interval. Owned data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Index of the frame, from 0.
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
    /// State at the last sample, from which a run can continue; `None` unless the run is live.
    pub state: Option<RunState>,
    /// Tilt of the load during this frame, rad.
    pub tilt: f64,
    /// Load during this frame, N.
    pub load: f64,
    /// Factor on the rotation during this frame.
    pub rotation_factor: f64,
    /// Shown contact nodes of this frame.
    pub geometry: Arc<PatchGeometry>,
    /// Snapshots of the contact nodes for display, in time order: at the scene's patch rate; in a live run at the last
    /// sample, and densely at the beginning, where a stroboscope chooses among them.
    pub patch: Vec<PatchSnapshot>,
    /// Counts of contact nodes, in time order, at the scene's patch rate.
    pub contacts: Vec<ContactSample>,
    /// Energies, in time order, at the scene's energy rate.
    pub energy: Vec<EnergySample>,
    /// Contact transitions in this frame: for a joint, simulated nodes that separate or close between samples; for a
    /// small system, events.
    pub transitions: u64,
    /// Time since which some steps do not locate their events, s, in the frame in which the first of them is.
    pub unlocated_since: Option<f64>,
    /// Lyapunov exponents due in this frame, in time order; empty unless requested.
    pub exponents: Vec<Exponents>,
    /// The perturbed trajectory at the samples; `None` unless requested.
    pub perturbed: Option<PerturbedSamples>,
    /// State of a small system at each sample, an index of
    /// [`SmallInfo::statuses`](super::SmallInfo::statuses); empty for other subjects.
    pub status: Vec<u8>,
    /// Solver statistics since the start.
    pub stats: SolverStats,
    /// Largest local error of the steps of this frame; `None` without an error estimate.
    pub error: Option<ErrorEstimate>,
    /// Wall time of the integration since the start, s.
    pub busy_seconds: f64,
    /// Descriptions of the commands applied at the first sample.
    pub events: Vec<String>,
    /// Kicks applied at the first sample, after the one at the start of the run.
    pub kicks: Vec<Kick>,
    /// Numbers of the scene that commands have changed so far, with their present values in the units of a scene file.
    pub changed: Arc<Vec<(Parameter, f64)>>,
    /// Display rates of a live run; `None` to display everything that the scene requests.
    pub shown: Option<DisplayRates>,
}

/// Display rates of a live run, which depend on the playback speed. They apply to pictures; the numbers of a
/// run do not depend on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayRates {
    /// Playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Pictures of body and patch per simulated second in a viewer.
    pub pictures: f64,
    /// Number of samples per displayed sample of the time series, at least 1.
    pub every: usize,
    /// Minimum number of samples between the ends of two windows of an analysis that is only displayed.
    pub apart: u64,
}

impl DisplayRates {
    /// Frames per second of wall time. A command takes effect at the start of the next frame.
    const FRAMES: f64 = 60.0;
    /// Pictures of body and contact patch per second of wall time in a viewer.
    const PICTURES: f64 = 20.0;
    /// Snapshots of the contact nodes at the beginning of a frame: rate, Hz, and span, s. They resolve the phase of a squeak
    /// and cover a period from 2 kHz.
    const STROBE_RATE: f64 = 100e3;
    const STROBE_SPAN: f64 = 0.5e-3;
    /// Approximate number of rows of time series per second of wall time that a viewer can display.
    const ROWS: f64 = 20e3;
    /// Maximum number of windows per second of wall time that a displayed analysis evaluates: slightly more
    /// than are displayed.
    const WINDOWS: f64 = 8.0;
    /// Energy samples per snapshot.
    const ENERGIES: f64 = 20.0;
    /// Maximum number of samples per frame.
    const MAX_FRAME_SAMPLES: f64 = 8192.0;

    /// Number of samples per frame, and display rates, at a playback speed (simulated seconds per second of
    /// wall time) of samples at `rate` (Hz).
    pub fn at_speed(speed: f64, rate: f64) -> (usize, Self) {
        let samples = (speed * rate / Self::FRAMES).round();
        let shown = Self {
            speed,
            pictures: (Self::PICTURES / speed).min(rate),
            every: (speed * rate / Self::ROWS).round().max(1.0) as usize,
            apart: (speed * rate / Self::WINDOWS).round() as u64,
        };
        (samples.clamp(1.0, Self::MAX_FRAME_SAMPLES) as usize, shown)
    }

    /// Whether a live run takes a snapshot of the contact nodes at a sample of a frame of `samples` samples at `rate` (Hz).
    pub fn is_snapshot(index: u64, samples: u64, rate: f64) -> bool {
        let every = (rate / Self::STROBE_RATE).max(1.0) as u64;
        let is_dense = index.is_multiple_of(every) && index as f64 <= Self::STROBE_SPAN * rate;
        is_dense || index + 1 == samples
    }

    /// Displayed energy samples per simulated second.
    pub fn energies(&self) -> f64 {
        Self::ENERGIES * self.pictures
    }
}

impl Frame {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.displacement.len()
    }

    /// Whether the frame contains no sample.
    pub fn is_empty(&self) -> bool {
        self.displacement.is_empty()
    }

    /// Time of sample `k`, s.
    pub fn time(&self, k: usize) -> f64 {
        self.t0 + k as f64 * self.dt
    }

    /// Time just after the last sample, s: the start of the next frame.
    pub fn end(&self) -> f64 {
        self.time(self.len())
    }
}
