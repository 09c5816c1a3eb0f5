//! All names in a recording: the timeline and the entity paths.

/// The timeline of a run: simulated time as a duration in ns. The timeline of a sweep is named after the
/// swept parameter.
pub const TIMELINE: &str = "sim_time";

/// Recording property with versions, command and scene.
pub const RUN_PROPERTY: &str = "squeakscope";

/// Current observation, as text.
pub const NARRATION: &str = "narration";
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
/// Numbers of slipping, sticking and separated nodes.
pub const NODE_COUNTS: &str = "contact/nodes";
/// Normal force and friction, N, summed over the nodes.
pub const CONTACT_FORCE: &str = "contact/force";

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

/// Result K of the 0-1 test.
pub const ZERO_ONE: &str = "chaos/zero_one";

/// Running Lyapunov exponents and the ends of their intervals, 1/s.
pub const EXPONENTS_RUNNING: &str = "lyapunov/running";
/// Zero line of the running exponents.
pub const EXPONENTS_ZERO: &str = "lyapunov/zero";

/// Displacement of the perturbed trajectory at the probe, µm.
pub const PERTURBED_DISPLACEMENT: &str = "divergence/displacement";
/// Logarithm (base 10) of the distance of reference and perturbed trajectory, relative to the motion.
pub const DIVERGENCE_DISTANCE: &str = "divergence/distance";
/// Line fitted to the logarithmic distance.
pub const DIVERGENCE_FIT: &str = "divergence/fit";

/// Confidence of the classification, 0 to 1, one series per type of motion.
pub const REGIME_CONFIDENCE: &str = "regime/confidence";

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
        Self(format!("sweep/{start}/"))
    }

    /// The root of one branch of periodic orbits.
    pub fn of_branch(number: usize) -> Self {
        Self(format!("branch/{number}/"))
    }

    /// The full path of a path relative to this root.
    pub fn at(&self, path: &str) -> String {
        format!("{}{path}", self.0)
    }
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
