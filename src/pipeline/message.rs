//! What travels on the road: frames from the simulation, records to a sink.

use std::sync::Arc;

pub use super::computed::{
    Computed, ComputedCurve, ComputedMode, ComputedPicture, Coupling, FrictionReading,
};
pub use super::course::{Course, TiltedTone, Way};
pub use super::outline::{Outline, vertex_normals};
use crate::analysis::{DelayChoice, Divergence, Measures, Verdict, ZeroOne};
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
#[derive(Clone, Debug, PartialEq)]
pub struct Exponents {
    /// Simulated time, s.
    pub time: f64,
    /// The exponents, by the growth since the motion has settled.
    pub spectrum: LyapunovSpectrum,
    /// What is known of the motion beside them.
    pub motion: Motion,
    /// The lowest natural frequency `omega_1`, rad/s: an exponent over it belongs to the time
    /// `tau = omega_1 t`.
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

/// How far two copies have parted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parting {
    /// Time of the newest sample, s.
    pub time: f64,
    /// Time of the first sample of the second copy, s.
    pub start: f64,
    /// Their distance, see [`TwinSamples::distance`]: root of the mean square since the last such
    /// record.
    pub distance: f64,
    /// The straight line through the logarithm of the distance, from where it last rose above
    /// [`TwinSamples::floor`] until it is saturated; `None` as long as there are too few distances.
    pub line: Option<PartingLine>,
    /// When the distance had become as large as the motion itself, s; it can grow no more.
    pub saturated: Option<f64>,
}

/// `ln(distance) = intercept + rate (t - start)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartingLine {
    /// The rate, 1/s: an estimate of the largest exponent.
    pub rate: f64,
    /// Half the width of its 95 % interval by the scatter about the line, 1/s.
    pub half_width: f64,
    /// Time of the first distance that the line goes through, s.
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
    /// Status of a small system at each sample, an index of [`SmallInfo::statuses`]; empty for
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
    /// What the coordinates of a [`SectionPoint`] are.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AnalysisKind {
    /// [`Record::Spectrum`].
    Spectrum,
    /// [`Record::SpectrogramColumn`].
    Spectrogram,
    /// [`Record::Recurrence`] and [`Record::Embedding`].
    Recurrence,
    /// [`Record::Delay`].
    Delay,
    /// [`Record::Quantification`].
    Quantification,
    /// [`Record::Section`].
    Section,
    /// [`Record::Chaos`].
    Chaos,
    /// [`Record::Regime`].
    Regime,
    /// [`Record::Exponents`].
    Exponents,
    /// [`Record::Parting`], and [`Frame::twin`].
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
    pub outline: Outline,
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
    /// What it can be doing, by the number in [`Frame::status`].
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

/// A line of a spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Frequency refined below a bin, Hz.
    pub frequency: f64,
    /// Amplitude in the signal's unit (one-sided: a sine of amplitude A gives A).
    pub amplitude: f64,
    /// Name such as `f1`, `3 f1`, `f2 - 3 f1`; empty where nothing fits.
    pub label: String,
}

/// One passage through the Poincare section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPoint {
    /// When, s.
    pub time: f64,
    /// Where on the section: its two coordinates, as [`Header::section`] says.
    pub at: [f64; 2],
}

/// What a stage of analysis says to the sink.
#[derive(Clone, Debug)]
pub enum Record {
    /// First of all, once.
    Header(Arc<Header>),
    /// The samples themselves, every frame, in order.
    Samples(Arc<Frame>),
    /// One-sided amplitude spectrum of the velocity over a sliding window.
    Spectrum {
        /// End of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Amplitudes, m/s.
        amplitude: Vec<f64>,
        /// The strongest lines, strongest first.
        peaks: Vec<Peak>,
    },
    /// One column of the spectrogram.
    SpectrogramColumn {
        /// Centre of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Level of each bin, dB relative to an amplitude of 1 mm/s (of a signal from a file:
        /// of a thousandth of its unit).
        level_db: Vec<f32>,
    },
    /// Recurrence plot, Eq. (26), of the delay vectors, Eq. (25), in a sliding window.
    Recurrence {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Points along a side.
        size: usize,
        /// Row-major pixels: the distance between the two states, 0 (same) to 255 (the largest
        /// of the window). `pixels[i * size + j]`, oldest first.
        distance: Vec<u8>,
        /// Row-major pixels: 255 recurrent, 0 not.
        recurrent: Vec<u8>,
        /// Threshold distance used, m; `None` if each state had its own.
        threshold: Option<f64>,
        /// Recurrence rate reached, 0 to 1.
        rate: f64,
        /// Delay, s.
        lag: f64,
        /// Embedding dimension.
        dimension: usize,
    },
    /// Trail of delay vectors in three dimensions, (u(t), u(t - lag), u(t - 2 lag)), m.
    Embedding {
        /// Time of the newest point, s.
        time: f64,
        /// Points, oldest first.
        points: Vec<[f32; 3]>,
    },
    /// Lag and dimension chosen from a sliding window of the displacement (Fig. 8).
    Delay {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Sample spacing, s.
        dt: f64,
        /// The choice and the curves that led to it.
        choice: Arc<DelayChoice>,
    },
    /// Recurrence quantification of a sliding window of the displacement.
    Quantification {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Spacing of the states, s: lengths of lines times this are durations.
        dt: f64,
        /// Threshold distance used, m; `None` if each state had its own.
        threshold: Option<f64>,
        /// The measures.
        measures: Measures,
        /// The most frequent spacing of diagonals, s.
        period: Option<f64>,
    },
    /// Passages through the Poincare section that have become known since the last such record, in
    /// time order; at least one.
    Section {
        /// Time of the newest sample, s. A passage is known a few samples (of a delay section:
        /// also two delays) after it.
        time: f64,
        /// The passages.
        points: Vec<SectionPoint>,
    },
    /// How neighbours part in a sliding window of the displacement, and the 0-1 test.
    Chaos {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Sample spacing, s.
        dt: f64,
        /// Mean log distance of neighbours, and its straight part.
        divergence: Arc<Divergence>,
        /// The 0-1 test.
        zero_one: Arc<ZeroOne>,
    },
    /// The kind of motion in a sliding window of the displacement.
    Regime {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// The verdict with its evidence.
        verdict: Arc<Verdict>,
    },
    /// Lyapunov exponents of the simulated motion so far.
    Exponents(Arc<Exponents>),
    /// How far the two copies have parted.
    Parting(Parting),
    /// How the run is doing.
    Health(Health),
    /// A few words on what is being seen now: Markdown that starts with a heading `## ...`.
    Narration {
        /// Simulated time, s.
        time: f64,
        /// The words.
        text: String,
    },
    /// Something that was done to the run while it went on.
    Event {
        /// Simulated time, s.
        time: f64,
        /// What was done.
        text: String,
    },
    /// What the run shows of the scene's mechanism so far: Markdown that starts with a heading `## ...`.
    Lesson {
        /// Simulated time, s.
        time: f64,
        /// The words.
        text: String,
    },
    /// One point of the course of a run that shows a mechanism.
    Course(Course),
    /// Something the user should know.
    Warning {
        /// Simulated time, s.
        time: f64,
        /// The words.
        text: String,
    },
    /// Last of all, once, when the run ended well or was interrupted.
    Summary(Arc<Summary>),
}

impl Record {
    /// Whether this is a picture whole in itself, so that a later one of its kind makes it
    /// needless to someone who only watches. A spectrogram column is none: leaving it out
    /// would leave a hole in the spectrogram.
    pub fn is_picture(&self) -> bool {
        matches!(
            self,
            Self::Spectrum { .. }
                | Self::Recurrence { .. }
                | Self::Embedding { .. }
                | Self::Delay { .. }
        )
    }
}

/// How the run is doing, over the last frame or frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Simulated time, s.
    pub time: f64,
    /// Simulated seconds a second of the simulation thread; 0 where nothing is simulated.
    pub real_time_factor: f64,
    /// The largest local error of a step; `None` where there is no estimate.
    pub error: Option<ErrorEstimate>,
    /// Accepted steps per simulated millisecond.
    pub steps_per_ms: f64,
    /// Rejected steps per simulated millisecond.
    pub rejections_per_ms: f64,
    /// Right-hand-side calls per simulated millisecond.
    pub calls_per_ms: f64,
    /// Contact transitions per simulated millisecond.
    pub events_per_ms: f64,
    /// Frames waiting between simulation and analysis.
    pub frames_waiting: usize,
    /// Records waiting between analysis and recorder.
    pub records_waiting: usize,
    /// Pictures replaced by later ones so far (only when viewing without saving).
    pub drops: u64,
    /// Energy audit: largest residual of the last frame relative to the energy turned over and 1e-12 J,
    /// below which nothing is resolved; `None` where none is told.
    pub audit: Option<f64>,
}

/// What the run came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Simulated time, s.
    pub simulated: f64,
    /// Wall time of the whole run, s.
    pub wall: f64,
    /// Simulated seconds a second of the simulation thread; 0 where nothing is simulated.
    pub real_time_factor: f64,
    /// Lines of the last window's spectrum, strongest first.
    pub peaks: Vec<Peak>,
    /// Half the peak-to-peak displacement over the last window, m.
    pub amplitude: f64,
    /// Largest speed of the probe over the last window, m/s.
    pub peak_velocity: f64,
    /// Work of the integrator.
    pub tally: Tally,
    /// Contact transitions.
    pub transitions: u64,
    /// Relative residual of the energy audit at the end; `None` where nothing was audited.
    pub audit: Option<f64>,
    /// The last exponents; `None` unless asked for, or if the run ended before they settled.
    pub exponents: Option<Exponents>,
    /// How far the two copies had parted at the end; `None` unless asked for.
    pub parting: Option<Parting>,
    /// Whether the run was interrupted before its planned end.
    pub interrupted: bool,
}
