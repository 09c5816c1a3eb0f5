//! Data of a run that are known before its first frame.

use std::sync::Arc;

use super::lesson::MechanismPrediction;
use crate::analysis::{events::TonalEvent, levels::LevelReference};
use crate::fem::SurfaceMesh;
use crate::scene::{AnalysisSpec, Control, Parameter, SectionSurface, StateCoordinate};

/// A mode, for labels.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeInfo {
    /// Short name, such as `2nd bending x`.
    pub label: String,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
}

/// Data known before the first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Name of the scene or of the file.
    pub scene: String,
    /// One-line description of the scene.
    pub title: String,
    /// A few sentences (Markdown) about the scene.
    pub about: String,
    /// Full text of the scene file; empty for a signal from a file.
    pub scene_text: String,
    /// Command line of the program.
    pub command: String,
    /// Sample rate, Hz.
    pub sample_rate: f64,
    /// Planned duration, s of simulated time, or duration of the signal.
    pub duration: f64,
    /// Whether the run continues after the planned duration until it is stopped.
    pub endless: bool,
    /// Numbers of the scene that commands can change; empty unless the run is interactive.
    pub controls: Vec<Control>,
    /// Analyses whose records follow.
    pub analysis: AnalysisSpec,
    /// Peak velocity below which a vibration is at rest, m/s: neither its lines nor its type are named. 0 for a
    /// signal from a file.
    pub rest_speed: f64,
    /// Source of the samples.
    pub subject: Subject,
    /// Linear prediction for the scene's mechanism; `None` if the scene has none.
    pub computed: Option<Arc<MechanismPrediction>>,
}

/// Ratio of peak velocity to sliding speed below which a vibration is silent.
pub const SILENCE_RATIO: f64 = 0.5e-3;
/// Smallest such velocity, m/s.
const SMALLEST_SILENCE: f64 = 1e-8;

impl Header {
    /// The joint, if the subject is a joint.
    pub fn joint(&self) -> Option<&JointInfo> {
        match &self.subject {
            Subject::Joint(joint) => Some(joint),
            Subject::Small(_) | Subject::Signal(_) => None,
        }
    }

    /// Peak velocity below which a vibration is silent, m/s: scales of pictures do not go below it, and its lines are not
    /// named.
    pub fn silence(&self) -> f64 {
        let sliding = self.joint().map_or(0.0, JointInfo::largest_sliding_speed);
        self.rest_speed
            .max(SILENCE_RATIO * sliding)
            .max(SMALLEST_SILENCE)
    }

    /// Range of the slider of the tilt, degrees; `None` if commands cannot change the tilt.
    pub fn tilt_slider(&self) -> Option<[f64; 2]> {
        let mut controls = self.controls.iter();
        let tilt = controls.find(|control| control.parameter == Parameter::tilt())?;
        Some(tilt.range)
    }

    /// Coordinates of a [`SectionPoint`](super::SectionPoint); `None` for the displacement `y` of the probe as in Fig. 10,
    /// `(y(t), y(t + 2 tau))`.
    pub fn section(&self) -> Option<[StateCoordinate; 2]> {
        match self.analysis.section.as_ref()?.surface {
            SectionSurface::State { shown, .. } => Some(shown),
            SectionSurface::Delay { .. } => None,
        }
    }

    /// Upper limit of frequency axes, Hz: for a joint 20 % above the highest mode, rounded up to a multiple of 5 kHz.
    pub fn highest_frequency(&self) -> f64 {
        match &self.subject {
            Subject::Joint(joint) => {
                let modes = joint.modes.iter().map(|mode| mode.frequency_hz);
                (1.2 * modes.fold(0.0, f64::max) / 5e3).ceil().max(1.0) * 5e3
            }
            Subject::Small(small) => small.highest_frequency,
            Subject::Signal(signal) => signal.highest_frequency,
        }
    }

    /// Time of the first sample, s.
    pub fn start(&self) -> f64 {
        match &self.subject {
            Subject::Joint(_) | Subject::Small(_) => 0.0,
            Subject::Signal(signal) => signal.start,
        }
    }
}

/// Subject of an analysis: the source of the samples.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A simulated joint. Samples are the displacement (m) and velocity (m/s) of the probe.
    Joint(JointInfo),
    /// A simulated small system. Samples are displacement (m) and velocity (m/s) of the observed mass.
    Small(SmallInfo),
    /// A signal from a file. Displacement and velocity are both the signal in its own unit, which replaces
    /// the m and m/s of the records.
    Signal(SignalInfo),
}

/// The joint of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct JointInfo {
    /// The body in a few words: `Ball and beam`.
    pub body: String,
    /// Modes, in the order of the modal coordinates.
    pub modes: Vec<ModeInfo>,
    /// Smallest scheduled tilt, rad.
    pub min_tilt: f64,
    /// Largest scheduled tilt, rad.
    pub max_tilt: f64,
    /// Range of tilts that can be set during an interactive run, rad; `None` for other runs.
    pub tilt_range: Option<[f64; 2]>,
    /// Azimuth of the tilted load, from +x to +y, rad.
    pub azimuth: f64,
    /// Surface mesh of the body; empty if unknown.
    pub outline: SurfaceMesh,
    /// Rotation of the ball at a rotation factor of 1, rad/s.
    pub rotation: [f64; 3],
    /// Smallest and largest scheduled rotation factor; both 1 for a constant rotation.
    pub rotation_span: [f64; 2],
    /// Smallest and largest scheduled load, N; equal for a constant load.
    pub load_span: [f64; 2],
    /// Radius of the ball, m.
    pub ball_radius: f64,
    /// Radius of the contact patch under the largest scheduled load, m.
    pub patch_radius: f64,
    /// Slip speed at the central contact point in steady sliding at the initial tilt and a rotation factor of
    /// 1, m/s.
    pub sliding_speed: f64,
}

impl JointInfo {
    /// Largest scheduled load, N.
    pub fn largest_load(&self) -> f64 {
        self.load_span[1]
    }

    /// Largest scheduled slip speed in steady sliding, as [`JointInfo::sliding_speed`], m/s.
    pub fn largest_sliding_speed(&self) -> f64 {
        let [low, high] = self.rotation_span.map(f64::abs);
        self.sliding_speed * low.max(high)
    }

    /// Whether the load varies.
    pub fn load_varies(&self) -> bool {
        self.load_span[0] != self.load_span[1]
    }

    /// Whether the rotation varies.
    pub fn rotation_varies(&self) -> bool {
        self.rotation_span[0] != self.rotation_span[1]
    }
}

/// The small system of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SmallInfo {
    /// The system in a few words: `an impact oscillator`.
    pub words: &'static str,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Upper limit of frequency axes, Hz.
    pub highest_frequency: f64,
    /// Possible states, indexed by [`Frame::status`](super::Frame::status).
    pub statuses: Vec<StatusInfo>,
    /// Meaning of a transition: `impacts`.
    pub transition: &'static str,
}

/// A discrete state of a small system, within which a smooth law holds.
#[derive(Clone, Debug, PartialEq)]
pub struct StatusInfo {
    /// Name: `sticks`.
    pub label: &'static str,
    /// Kind, which determines the colour.
    pub kind: StatusKind,
}

/// Kinds of discrete states of a small system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// Moves freely: off the wall, out of contact, or sliding in the usual direction.
    Free,
    /// Is held: sticks, rests or touches.
    Held,
    /// Moves in an unusual way.
    Other,
}

/// A recorded signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalInfo {
    /// Origin, such as the file name.
    pub source: String,
    /// Name of the column or channel.
    pub column: String,
    /// Unit of the samples; empty if unknown.
    pub unit: String,
    /// Time of the first sample, s.
    pub start: f64,
    /// Smallest and largest sample, in the unit of the signal.
    pub span: [f64; 2],
    /// Upper limit of frequency axes, Hz.
    pub highest_frequency: f64,
    /// Tonal events, in the time of the file; empty for a signal that is no sound.
    pub events: Vec<TonalEvent>,
    /// What the levels of the events are relative to.
    pub level_reference: LevelReference,
}
