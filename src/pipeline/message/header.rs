//! What is known of a run before its first frame.

use std::sync::Arc;

use serde::Serialize;

use super::computed::Computed;
use crate::fem::SurfaceMesh;

/// One mode, for labels.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeInfo {
    /// Short name, such as `2nd bending x`.
    pub label: String,
    /// Natural frequency used, Hz.
    pub frequency_hz: f64,
}

/// What is known before the first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Name of the scene, or of the file.
    pub scene: String,
    /// One line that says what the scene shows.
    pub title: String,
    /// A few sentences (Markdown): what to look for.
    pub about: String,
    /// The whole scene file's text; empty where there is no scene.
    pub scene_text: String,
    /// How the program was started.
    pub command: String,
    /// Samples a second, Hz.
    pub sample_rate: f64,
    /// Time planned, s: simulated time, or the length of the signal.
    pub duration: f64,
    /// Whether the run goes on after that, until somebody ends it.
    pub endless: bool,
    /// The analyses whose records will come.
    pub analyses: Vec<AnalysisKind>,
    /// What the coordinates of a [`SectionPoint`](super::SectionPoint) are.
    pub section: [SectionCoordinate; 2],
    /// Where the samples come from.
    pub subject: Subject,
    /// What was computed of a scene that shows a mechanism; `None` for all others.
    pub computed: Option<Arc<Computed>>,
}

impl Header {
    /// The joint, if that is the subject.
    pub fn joint(&self) -> Option<&JointInfo> {
        match &self.subject {
            Subject::Joint(joint) => Some(joint),
            Subject::Small(_) | Subject::Signal(_) => None,
        }
    }

    /// Whether records of this analysis will come.
    pub fn has(&self, analysis: AnalysisKind) -> bool {
        self.analyses.contains(&analysis)
    }

    /// Time of the first sample, s.
    pub fn start(&self) -> f64 {
        match &self.subject {
            Subject::Joint(_) | Subject::Small(_) => 0.0,
            Subject::Signal(signal) => signal.start,
        }
    }
}

/// An analysis of a run, by the records that it makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnalysisKind {
    /// [`Record::Spectrum`](super::Record::Spectrum).
    Spectrum,
    /// [`Record::SpectrogramColumn`](super::Record::SpectrogramColumn).
    Spectrogram,
    /// [`Record::Recurrence`](super::Record::Recurrence) and [`Record::Embedding`](super::Record::Embedding).
    Recurrence,
    /// [`Record::Delay`](super::Record::Delay).
    Delay,
    /// [`Record::Quantification`](super::Record::Quantification).
    Quantification,
    /// [`Record::Section`](super::Record::Section).
    Section,
    /// [`Record::Chaos`](super::Record::Chaos).
    Chaos,
    /// [`Record::Regime`](super::Record::Regime).
    Regime,
    /// [`Record::Exponents`](super::Record::Exponents).
    Exponents,
    /// [`Record::Parting`](super::Record::Parting), and [`Frame::twin`](super::Frame::twin).
    Butterfly,
}

/// A coordinate of a passage through a Poincare section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SectionCoordinate {
    /// The displacement so many delays after `y(t)`, m: 2 is `y(t + 2 tau)`.
    Delayed(usize),
    /// The modal coordinate of the mode with this index, sqrt(kg) m.
    Q(usize),
    /// The modal velocity of the mode with this index, sqrt(kg) m/s.
    Qdot(usize),
}

impl SectionCoordinate {
    /// Those of the section of Fig. 10, `(y(t), y(t + 2 tau))`.
    pub const DELAYED: [Self; 2] = [Self::Delayed(0), Self::Delayed(2)];
}

/// Where the samples come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A simulated joint. Samples are the displacement (m) and velocity (m/s) of the probe.
    Joint(JointInfo),
    /// A simulated small system. Samples are its displacement (m) and velocity (m/s).
    Small(SmallInfo),
    /// A signal from a file. Displacement and velocity are both the signal in its own unit, and
    /// where a record says m or m/s that unit is meant.
    Signal(SignalInfo),
}

/// The joint of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct JointInfo {
    /// What the body is, in a few words: `Ball and beam`.
    pub body: String,
    /// The modes, in the order of the modal coordinates.
    pub modes: Vec<ModeInfo>,
    /// The smallest tilt that the scene plans, rad.
    pub min_tilt: f64,
    /// The largest tilt that the scene plans to reach, rad.
    pub max_tilt: f64,
    /// The tilts that may be asked for while it runs, rad; `None` where nobody steers.
    pub reach: Option<[f64; 2]>,
    /// Direction that the load tilts towards, from +x to +y, rad.
    pub azimuth: f64,
    /// The body's surface; empty where it is not known.
    pub outline: SurfaceMesh,
    /// Rotation of the ball where its factor is 1, rad/s.
    pub rotation: [f64; 3],
    /// The smallest and the largest factor on the rotation that the scene plans; both 1 where it is
    /// constant.
    pub rotation_span: [f64; 2],
    /// The smallest and the largest load that the scene plans, N; the same where it is constant.
    pub load_span: [f64; 2],
    /// Radius of the ball, m.
    pub ball_radius: f64,
    /// Radius of the contact patch under the largest load, m.
    pub patch_radius: f64,
    /// Slip speed at the central contact point in steady sliding at the first tilt, where the factor on
    /// the rotation is 1, m/s.
    pub sliding_speed: f64,
}

impl JointInfo {
    /// The largest load that the scene plans, N.
    pub fn largest_load(&self) -> f64 {
        self.load_span[1]
    }

    /// The largest slip speed in steady sliding that the scene plans, as [`JointInfo::sliding_speed`],
    /// m/s.
    pub fn largest_sliding_speed(&self) -> f64 {
        self.sliding_speed * self.rotation_span[1]
    }

    /// Whether the load changes.
    pub fn load_varies(&self) -> bool {
        self.load_span[0] != self.load_span[1]
    }

    /// Whether the rotation changes.
    pub fn rotation_varies(&self) -> bool {
        self.rotation_span[0] != self.rotation_span[1]
    }
}

/// The small system of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SmallInfo {
    /// What it is, in a few words: `an impact oscillator`.
    pub words: String,
    /// Its natural frequency, Hz.
    pub frequency_hz: f64,
    /// Highest frequency worth showing, Hz.
    pub highest_frequency: f64,
    /// What it can be doing, by the number in [`Frame::status`](super::Frame::status).
    pub statuses: Vec<StatusInfo>,
    /// What its transitions are: `impacts`.
    pub transition: String,
}

/// Something that a small system can be doing, for as long as one smooth law holds.
#[derive(Clone, Debug, PartialEq)]
pub struct StatusInfo {
    /// In words: `sticks`.
    pub label: String,
    /// By which it is drawn.
    pub kind: StatusKind,
}

/// The kinds of status of a small system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// It moves freely: off the wall, out of contact, sliding the usual way.
    Free,
    /// Something holds it: it sticks, rests or touches.
    Held,
    /// It moves in another way than usual.
    Other,
}

/// A signal that somebody else made.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalInfo {
    /// Where it was read from, such as a file's name.
    pub source: String,
    /// Name of the column or channel; empty if the source has only one without a name.
    pub column: String,
    /// Unit of the samples; empty if unknown.
    pub unit: String,
    /// Time of the first sample, s.
    pub start: f64,
    /// Smallest and largest sample.
    pub span: [f64; 2],
    /// Highest frequency worth showing, Hz.
    pub highest_frequency: f64,
}
