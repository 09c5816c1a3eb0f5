//! All names in a recording: the timeline and the entity paths.

/// The timeline of a run: simulated time as a duration in ns. The timeline of a sweep is named after the
/// swept parameter.
pub const TIMELINE: &str = "sim_time";

/// Recording property with versions, command and scene.
pub const RUN_PROPERTY: &str = "squeakscope";

/// Current observation, as text.
pub const NARRATION: &str = "narration";
/// Lesson of a scene with a mechanism, as text.
pub const LESSON: &str = "lesson/text";
/// Logarithm (base 10) of the velocity level in mm/s.
pub const LESSON_VELOCITY_LEVEL: &str = "lesson/velocity_level";
/// Velocity level predicted by the computed growth rate.
pub const LESSON_PREDICTED: &str = "lesson/predicted_level";
/// Description of the scene and of the views, versions.
pub const ABOUT: &str = "about";
/// Log of warnings, events and the summary.
pub const LOG: &str = "log";

/// Displacement of the probe, µm.
pub const DISPLACEMENT: &str = "probe/displacement";
/// Velocity of the probe, mm/s.
pub const VELOCITY: &str = "probe/velocity";
/// Status of a small system: flying, sticking, in contact.
pub const STATUS: &str = "probe/status";
/// Samples of a signal from a file, in its own unit.
pub const WAVEFORM: &str = "signal";
/// Tilt of the load, degrees.
pub const TILT: &str = "tilt";
/// Load, N, if it varies.
pub const LOAD_NOW: &str = "load";
/// Rotation factor, if it varies.
pub const ROTATION_FACTOR: &str = "rotation_factor";

/// Modal coordinates, √kg µm, one series per mode.
pub const MODES_Q: &str = "modes/q";
/// Modal velocities, √kg mm/s, one series per mode.
pub const MODES_QDOT: &str = "modes/qdot";
/// Vibration energy, µJ, one series per mode.
pub const MODES_ENERGY: &str = "modes/energy";
/// Legend of the modes.
pub const MODES_LEGEND: &str = "modes_legend";
/// Stored energy, work of friction, and residual of the energy balance, µJ.
pub const ENERGY: &str = "energy";

/// Root of all entities in the frame of the ball centre.
pub const SCENE_3D: &str = "joint";
/// Deformed surface of ball and beam.
pub const BODY: &str = "joint/body";
/// Meaning of the surface colours.
pub const BODY_LEGEND: &str = "joint/legend";
/// The load on the ball, as an arrow.
pub const LOAD: &str = "joint/load";
/// The rotation of the ball, as an arrow.
pub const ROTATION: &str = "joint/rotation";
/// Contact nodes.
pub const NODES: &str = "joint/patch/nodes";
/// Friction force at each contact node.
pub const FRICTION: &str = "joint/patch/friction";
/// Edge of the contact patch.
pub const RIM: &str = "joint/patch/rim";
/// Legend of the node colours.
pub const NODE_LEGEND: &str = "joint/patch/legend";
/// Legend of the friction arrows.
pub const FRICTION_LEGEND: &str = "joint/patch/legend_friction";
/// Intersection of the beam axis and the ball.
pub const POLE: &str = "joint/patch/pole";
/// Circles of equal tilt on the ball.
pub const TILT_CIRCLES: &str = "joint/patch/circles";
/// Numbers of slipping, sticking and separated nodes.
pub const NODE_COUNTS: &str = "contact/nodes";
/// Normal force and friction, N, summed over the nodes.
pub const CONTACT_FORCE: &str = "contact/force";

/// Phase portrait.
pub const PORTRAIT: &str = "phase_portrait";
/// Trail of the phase portrait.
pub const PORTRAIT_TRAIL: &str = "phase_portrait/trail";
/// Current point of the phase portrait.
pub const PORTRAIT_NOW: &str = "phase_portrait/now";
/// Delay embedding.
pub const EMBEDDING: &str = "embedding";
/// Trail of the delay vectors.
pub const EMBEDDING_TRAIL: &str = "embedding/trail";

/// Spectrogram.
pub const SPECTROGRAM: &str = "spectrogram";
/// Ridges of the tonal events of a sound: the fundamental over time.
pub const SPECTROGRAM_RIDGES: &str = "spectrogram/events/ridges";
/// Numbers of the tonal events, at their starts.
pub const SPECTROGRAM_NUMBERS: &str = "spectrogram/events/numbers";

/// Image of the recurrence plot.
pub const RECURRENCE_IMAGE: &str = "recurrence/image";

/// Average mutual information over the delay.
pub const DELAY_MUTUAL_CURVE: &str = "delay/mutual_information/curve";

/// Recurrence rate RR, 0 to 1.
pub const RECURRENCE_RATE: &str = "quantification/recurrence_rate";
/// Determinism DET, 0 to 1.
pub const DETERMINISM: &str = "quantification/determinism";
/// Laminarity LAM, 0 to 1.
pub const LAMINARITY: &str = "quantification/laminarity";
/// Mean length L of diagonal lines.
pub const MEAN_DIAGONAL: &str = "quantification/mean_diagonal";
/// Length Lmax of the longest diagonal line.
pub const LONGEST_DIAGONAL: &str = "quantification/longest_diagonal";
/// Trapping time TT: mean length of vertical lines.
pub const TRAPPING_TIME: &str = "quantification/trapping_time";
/// Mean recurrence time T1 of the first type.
pub const RECURRENCE_TIME_1: &str = "quantification/recurrence_time_1";
/// Mean recurrence time T2 of the second type.
pub const RECURRENCE_TIME_2: &str = "quantification/recurrence_time_2";
/// The most frequent spacing of diagonal lines.
pub const PERIOD: &str = "quantification/period";
/// Entropy ENTR of the diagonal line lengths, nats.
pub const ENTROPY: &str = "quantification/entropy";
/// Divergence DIV, the inverse of Lmax.
pub const DIVERGENCE_RATE: &str = "quantification/divergence";
/// TREND: decrease of the recurrence rate with the distance from the main diagonal.
pub const TREND: &str = "quantification/trend";

/// Result K of the 0-1 test.
pub const ZERO_ONE: &str = "chaos/zero_one";

/// Running Lyapunov exponents and the ends of their intervals, 1/s.
pub const EXPONENTS_RUNNING: &str = "lyapunov/running";
/// Zero line of the running exponents.
pub const EXPONENTS_ZERO: &str = "lyapunov/zero";
/// Exponents and attractor, as text.
pub const EXPONENTS_TEXT: &str = "lyapunov/text";

/// Displacement of the perturbed trajectory at the probe, µm.
pub const PERTURBED_DISPLACEMENT: &str = "divergence/displacement";
/// Logarithm (base 10) of the distance of reference and perturbed trajectory, relative to the motion.
pub const DIVERGENCE_DISTANCE: &str = "divergence/distance";
/// Line fitted to the logarithmic distance.
pub const DIVERGENCE_FIT: &str = "divergence/fit";
/// Divergence of both trajectories, as text.
pub const DIVERGENCE_TEXT: &str = "divergence/text";

/// Confidence of the classification, 0 to 1, one series per type of motion.
pub const REGIME_CONFIDENCE: &str = "regime/confidence";
/// Type of motion and evidence, as text.
pub const REGIME_VERDICT: &str = "regime/verdict";

/// Accuracy and cost of the current steps, as text.
pub const SOLVER_TEXT: &str = "solver/text";
/// Largest local error estimate of a step, over the tolerance.
pub const SOLVER_ERROR: &str = "solver/local_error";
/// Right-hand-side evaluations per simulated ms.
pub const SOLVER_RHS_EVALS: &str = "solver/rhs_evals";
/// Simulated seconds per second of wall time.
pub const SOLVER_SPEED: &str = "solver/real_time_factor";
/// Steps, rejected steps and contact transitions per simulated ms.
pub const SOLVER_STEPS: &str = "solver/steps";
/// Frames and records in queues, pictures replaced.
pub const SOLVER_QUEUES: &str = "solver/queues";
/// Relative residual of the energy audit.
pub const SOLVER_ENERGY_RESIDUAL: &str = "solver/energy_residual";

/// Root of a sweep, with a folder for each start.
pub const SWEEP: &str = "sweep";

/// Natural modes of ball and beam.
pub const MODE_SHAPES: &str = "mode_shapes";
/// The beam axis at rest, one line per mode.
pub const MODE_SHAPE_AXES: &str = "mode_shapes/axes";
/// Labels of the modes.
pub const MODE_SHAPE_NAMES: &str = "mode_shapes/names";
/// Description of a point of a sweep, as text.
pub const POINT_TEXT: &str = "text";

/// Note of a panel without data.
pub const PANEL_NOTE: &str = "note";
/// Labels of the peaks of a panel.
pub const PANEL_NAMES: &str = "names";
/// Lines from the labels to the peaks.
pub const PANEL_STEMS: &str = "stems";
/// The current parameter value in the bifurcation diagram.
pub const CURSOR: &str = "cursor";
/// The current point of a phase portrait.
pub const NOW: &str = "now";

/// Root of a study of branches, with a folder for each branch.
pub const BRANCH: &str = "branch";

/// Root path of a part of the recording: empty for a run, one folder per start for a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Root(String);

impl Root {
    /// The root of a run.
    pub fn of_run() -> Self {
        Self::default()
    }

    /// The root of one start of a sweep.
    pub fn of_start(start: &str) -> Self {
        Self(format!("{SWEEP}/{start}/"))
    }

    /// The root of one branch of periodic orbits.
    pub fn of_branch(number: usize) -> Self {
        Self(format!("{BRANCH}/{number}/"))
    }

    /// The full path of a path relative to this root.
    pub fn at(&self, path: &str) -> String {
        format!("{}{path}", self.0)
    }
}

/// Natural mode of ball and beam, numbered from 0.
pub fn mode_shape(index: usize) -> String {
    format!("{MODE_SHAPES}/mode_{index:02}")
}

/// Tile of the spectrogram, numbered from 0.
pub fn spectrogram_tile(index: usize) -> String {
    format!("{SPECTROGRAM}/tile_{index:02}")
}

/// Frame, ticks and grid of the plot at a path.
pub fn axis_lines(plot: &str) -> String {
    format!("{plot}/axes/lines")
}

/// Names and tick labels of the axes of the plot at a path.
pub fn axis_labels(plot: &str) -> String {
    format!("{plot}/axes/labels")
}

/// Legend of the plot at a path.
pub fn legend(plot: &str) -> String {
    format!("{plot}/legend")
}

/// Caption of the plot at a path.
pub fn caption(plot: &str) -> String {
    format!("{plot}/caption")
}
