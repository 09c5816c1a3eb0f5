//! Every name inside a recording: the timeline and the entity paths. No other file spells one.

/// The only timeline: simulated time as a duration, in ns.
pub const TIMELINE: &str = "sim_time";

/// Recording property with versions, command and scene.
pub const RUN_PROPERTY: &str = "squeakscope";

/// What is seen now, in words.
pub const NARRATION: &str = "narration";
/// The scene, its text, how to read the views, versions.
pub const ABOUT: &str = "about";
/// Warnings and the summary, as a log.
pub const LOG: &str = "log";

/// Displacement of the probe, um.
pub const DISPLACEMENT: &str = "probe/displacement";
/// Velocity of the probe, mm/s.
pub const VELOCITY: &str = "probe/velocity";
/// Samples of a signal from a file, in its own unit.
pub const WAVEFORM: &str = "signal";
/// Tilt of the load, degrees.
pub const TILT: &str = "tilt";

/// Modal coordinates, one series a mode.
pub const MODES_Q: &str = "modes/q";
/// Modal velocities, one series a mode.
pub const MODES_QDOT: &str = "modes/qdot";
/// Vibration energy, one series a mode.
pub const MODES_ENERGY: &str = "modes/energy";
/// What the colours of the modes mean.
pub const MODES_KEY: &str = "modes_key";
/// Stored energy, work of friction, residual of the audit.
pub const ENERGY: &str = "energy";

/// All that is drawn in the body's frame.
pub const SCENE_3D: &str = "joint";
/// Surface of ball and beam, deformed.
pub const BODY: &str = "joint/body";
/// What the colours of the surface mean.
pub const BODY_LEGEND: &str = "joint/legend";
/// The load on the ball.
pub const LOAD: &str = "joint/load";
/// The rotation of the ball.
pub const ROTATION: &str = "joint/rotation";
/// Contact nodes.
pub const NODES: &str = "joint/patch/nodes";
/// Friction force at each contact node.
pub const FRICTION: &str = "joint/patch/friction";
/// Edge of the contact patch.
pub const RIM: &str = "joint/patch/rim";
/// What the colours of the nodes mean.
pub const NODE_KEY: &str = "joint/patch/key";
/// An arrow of known friction.
pub const FRICTION_KEY: &str = "joint/patch/key_friction";
/// Where the beam's axis meets the ball.
pub const POLE: &str = "joint/patch/pole";
/// Circles of equal polar angle on the ball.
pub const TILT_CIRCLES: &str = "joint/patch/circles";
/// How many nodes stick, slip, have lifted off.
pub const NODE_COUNTS: &str = "contact/nodes";
/// Normal and friction force summed over the nodes.
pub const CONTACT_FORCE: &str = "contact/force";

/// Phase portrait.
pub const PORTRAIT: &str = "portrait";
/// Trail of the phase portrait.
pub const PORTRAIT_TRAIL: &str = "portrait/trail";
/// Present point of the phase portrait.
pub const PORTRAIT_NOW: &str = "portrait/now";
/// Axes of the phase portrait.
pub const PORTRAIT_AXES: &str = "portrait/axes";
/// Delay embedding.
pub const EMBEDDING: &str = "embedding";
/// Trail of delay vectors.
pub const EMBEDDING_TRAIL: &str = "embedding/trail";
/// Box and names of the axes round the delay vectors.
pub const EMBEDDING_AXES: &str = "embedding/axes";

/// Amplitude spectrum.
pub const SPECTRUM: &str = "spectrum";
/// Curve of the spectrum.
pub const SPECTRUM_CURVE: &str = "spectrum/curve";
/// Names of the strongest lines of the spectrum.
pub const SPECTRUM_NAMES: &str = "spectrum/names";
/// Threads from the names to the lines.
pub const SPECTRUM_STEMS: &str = "spectrum/stems";
/// Tips of the strongest lines of the spectrum.
pub const SPECTRUM_PEAKS: &str = "spectrum/peaks";
/// Axes of the spectrum.
pub const SPECTRUM_AXES: &str = "spectrum/axes";

/// Spectrogram.
pub const SPECTROGRAM: &str = "spectrogram";
/// Axes of the spectrogram.
pub const SPECTROGRAM_AXES: &str = "spectrogram/axes";

/// Recurrence plot.
pub const RECURRENCE: &str = "recurrence";
/// Picture of the recurrence plot.
pub const RECURRENCE_IMAGE: &str = "recurrence/image";
/// Axes of the recurrence plot.
pub const RECURRENCE_AXES: &str = "recurrence/axes";
/// Recurrence rate and threshold, in words.
pub const RECURRENCE_CAPTION: &str = "recurrence/caption";

/// Simulated seconds a second.
pub const HEALTH_SPEED: &str = "health/real_time_factor";
/// Steps, rejections, calls and contact transitions, per simulated ms.
pub const HEALTH_WORK: &str = "health/work";
/// Frames and records waiting, pictures replaced.
pub const HEALTH_QUEUES: &str = "health/queues";
/// Energy audit.
pub const HEALTH_AUDIT: &str = "health/audit";

/// One tile of the spectrogram, from 0.
pub fn spectrogram_tile(index: usize) -> String {
    format!("{SPECTROGRAM}/tile_{index:02}")
}

/// Curves and names of a plot's axes live in two entities below the plot's axes.
pub fn axis_lines(axes: &str) -> String {
    format!("{axes}/lines")
}

/// See [`axis_lines`].
pub fn axis_labels(axes: &str) -> String {
    format!("{axes}/labels")
}
