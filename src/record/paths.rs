//! Every name inside a recording: the timeline and the entity paths. No other file spells one.

/// The only timeline of a run: simulated time as a duration, in ns. (That of a sweep counts the swept
/// parameter and is called after it.)
pub const TIMELINE: &str = "sim_time";

/// Recording property with versions, command and scene.
pub const RUN_PROPERTY: &str = "squeakscope";

/// What is seen now, in words.
pub const NARRATION: &str = "narration";
/// The lesson of a scene that shows a mechanism.
pub const LESSON: &str = "lesson/words";
/// Logarithm (to the base of ten) of how loud it is, mm/s.
pub const LESSON_LEVEL: &str = "lesson/level";
/// The same as computed.
pub const LESSON_FORETOLD: &str = "lesson/foretold";
/// Picture of what was computed.
pub const LESSON_COMPUTED: &str = "lesson/computed";
/// Its curves.
pub const LESSON_COMPUTED_CURVES: &str = "lesson/computed/curves";
/// Where the run is on them.
pub const LESSON_COMPUTED_MARKS: &str = "lesson/computed/marks";
/// Pitch over tilt, up and down.
pub const LESSON_LOOP: &str = "lesson/loop";
/// On the way up.
pub const LESSON_LOOP_UP: &str = "lesson/loop/up";
/// On the way down.
pub const LESSON_LOOP_DOWN: &str = "lesson/loop/down";
/// Now.
pub const LESSON_LOOP_NOW: &str = "lesson/loop/now";
/// The scene, its text, how to read the views, versions.
pub const ABOUT: &str = "about";
/// Warnings and the summary, as a log.
pub const LOG: &str = "log";

/// Displacement of the probe, um.
pub const DISPLACEMENT: &str = "probe/displacement";
/// Velocity of the probe, mm/s.
pub const VELOCITY: &str = "probe/velocity";
/// What a small system is doing: flying, sticking, touching.
pub const STATUS: &str = "probe/status";
/// Samples of a signal from a file, in its own unit.
pub const WAVEFORM: &str = "signal";
/// Tilt of the load, degrees.
pub const TILT: &str = "tilt";
/// Load, N, where it varies.
pub const LOAD_NOW: &str = "load";
/// Factor on the rotation, where it varies.
pub const ROTATION_FACTOR: &str = "rotation_factor";

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
/// Delay embedding.
pub const EMBEDDING: &str = "embedding";
/// Trail of delay vectors.
pub const EMBEDDING_TRAIL: &str = "embedding/trail";

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
/// Computed frequencies of the modes that grow.
pub const SPECTRUM_COMPUTED: &str = "spectrum/computed";

/// Spectrogram.
pub const SPECTROGRAM: &str = "spectrogram";

/// Recurrence plot.
pub const RECURRENCE: &str = "recurrence";
/// Picture of the recurrence plot.
pub const RECURRENCE_IMAGE: &str = "recurrence/image";

/// Average mutual information.
pub const DELAY_MUTUAL: &str = "delay/mutual_information";
/// Its curve over the lag.
pub const DELAY_MUTUAL_CURVE: &str = "delay/mutual_information/curve";
/// The lag chosen.
pub const DELAY_MUTUAL_CHOSEN: &str = "delay/mutual_information/chosen";
/// False nearest neighbours.
pub const DELAY_NEIGHBOURS: &str = "delay/false_neighbours";
/// Share of false neighbours over the dimension.
pub const DELAY_NEIGHBOURS_CURVE: &str = "delay/false_neighbours/curve";
/// The same, one point a dimension.
pub const DELAY_NEIGHBOURS_POINTS: &str = "delay/false_neighbours/points";
/// The dimension chosen.
pub const DELAY_NEIGHBOURS_CHOSEN: &str = "delay/false_neighbours/chosen";

/// Poincare section.
pub const SECTION: &str = "section";
/// Passages through the section.
pub const SECTION_POINTS: &str = "section/points";
/// Return map of the section.
pub const RETURN_MAP: &str = "return_map";
/// A value at one passage against the next.
pub const RETURN_MAP_POINTS: &str = "return_map/points";
/// Where a passage repeats the one before.
pub const RETURN_MAP_DIAGONAL: &str = "return_map/diagonal";

/// Recurrence rate RR, 0 to 1.
pub const RECURRENCE_RATE: &str = "quantification/recurrence_rate";
/// Determinism DET, 0 to 1.
pub const DETERMINISM: &str = "quantification/determinism";
/// Laminarity LAM, 0 to 1.
pub const LAMINARITY: &str = "quantification/laminarity";
/// Mean length L of diagonals.
pub const MEAN_DIAGONAL: &str = "quantification/mean_diagonal";
/// Length Lmax of the longest diagonal.
pub const LONGEST_DIAGONAL: &str = "quantification/longest_diagonal";
/// Mean length TT of verticals.
pub const TRAPPING_TIME: &str = "quantification/trapping_time";
/// Mean recurrence time of the first type.
pub const RECURRENCE_TIME_1: &str = "quantification/recurrence_time_1";
/// Mean recurrence time of the second type.
pub const RECURRENCE_TIME_2: &str = "quantification/recurrence_time_2";
/// The most frequent spacing of diagonals.
pub const PERIOD: &str = "quantification/period";
/// Entropy ENTR of the lengths of diagonals, nats.
pub const ENTROPY: &str = "quantification/entropy";
/// DIV, the inverse of Lmax.
pub const DIVERGENCE_RATE: &str = "quantification/divergence";
/// How fast recurrences thin out away from the main diagonal.
pub const TREND: &str = "quantification/trend";

/// How neighbours part.
pub const DIVERGENCE: &str = "chaos/divergence";
/// Mean logarithm of the distance of neighbours.
pub const DIVERGENCE_CURVE: &str = "chaos/divergence/curve";
/// Its straight part.
pub const DIVERGENCE_LINE: &str = "chaos/divergence/line";
/// The largest exponent and the ends of its error, 1/s.
pub const EXPONENT: &str = "chaos/exponent";
/// Result K of the 0-1 test.
pub const ZERO_ONE: &str = "chaos/zero_one";
/// Picture of the 0-1 test.
pub const ZERO_ONE_PICTURE: &str = "chaos/translation";
/// Path of the translation variables of the 0-1 test.
pub const ZERO_ONE_PATH: &str = "chaos/translation/path";

/// The Lyapunov exponents so far and the ends of their intervals, 1/s.
pub const EXPONENTS_RUNNING: &str = "lyapunov/running";
/// Zero, to compare with.
pub const EXPONENTS_ZERO: &str = "lyapunov/zero";
/// Picture of the present exponents.
pub const EXPONENTS_SPECTRUM: &str = "lyapunov/spectrum";
/// The present exponents as points.
pub const EXPONENTS_POINTS: &str = "lyapunov/spectrum/points";
/// Their intervals.
pub const EXPONENTS_BARS: &str = "lyapunov/spectrum/intervals";
/// Where an exponent is zero.
pub const EXPONENTS_ZERO_LINE: &str = "lyapunov/spectrum/zero";
/// The exponents and what they say, in words.
pub const EXPONENTS_WORDS: &str = "lyapunov/words";

/// Displacement of the second copy's probe, um.
pub const BUTTERFLY_DISPLACEMENT: &str = "butterfly/displacement";
/// Logarithm (to the base of ten) of the distance of the two copies over the motion's size.
pub const BUTTERFLY_DISTANCE: &str = "butterfly/distance";
/// The straight line through it.
pub const BUTTERFLY_LINE: &str = "butterfly/line";
/// Phase portraits of both copies.
pub const BUTTERFLY_PORTRAIT: &str = "butterfly/portrait";
/// Trail of the first copy.
pub const BUTTERFLY_FIRST: &str = "butterfly/portrait/first";
/// The first copy now.
pub const BUTTERFLY_FIRST_NOW: &str = "butterfly/portrait/first_now";
/// Trail of the second copy.
pub const BUTTERFLY_SECOND: &str = "butterfly/portrait/second";
/// The second copy now.
pub const BUTTERFLY_SECOND_NOW: &str = "butterfly/portrait/second_now";
/// How far they have parted, in words.
pub const BUTTERFLY_WORDS: &str = "butterfly/words";

/// How sure the verdict is, 0 to 1, in the series of its kind.
pub const REGIME_CONFIDENCE: &str = "regime/confidence";
/// Kind and evidence, in words.
pub const REGIME_VERDICT: &str = "regime/verdict";

/// How accurate the steps are and what they cost now, in words.
pub const HEALTH_WORDS: &str = "health/words";
/// The largest local error of a step, over the error allowed.
pub const HEALTH_ERROR: &str = "health/local_error";
/// Calls of the right-hand side, per simulated ms.
pub const HEALTH_CALLS: &str = "health/calls";
/// Simulated seconds a second.
pub const HEALTH_SPEED: &str = "health/real_time_factor";
/// Steps, rejections and contact transitions, per simulated ms.
pub const HEALTH_WORK: &str = "health/work";
/// Frames and records waiting, pictures replaced.
pub const HEALTH_QUEUES: &str = "health/queues";
/// Energy audit.
pub const HEALTH_AUDIT: &str = "health/audit";

/// All that a sweep holds, start by start.
pub const SWEEP: &str = "sweep";

/// Natural modes of ball and beam.
pub const SHAPES: &str = "shapes";
/// The beam's axis at rest, a line a mode.
pub const SHAPE_AXES: &str = "shapes/axes";
/// What the modes are called.
pub const SHAPE_NAMES: &str = "shapes/names";
/// Bifurcation diagram: the settled maxima over the swept parameter.
pub const DIAGRAM: &str = "diagram";
/// Everything about a point of a sweep, in words.
pub const POINT_WORDS: &str = "words";

/// What a panel says where there is nothing to draw.
pub const PANEL_NOTE: &str = "note";
/// Names of the peaks of a panel.
pub const PANEL_NAMES: &str = "names";
/// Lines from the names to the peaks.
pub const PANEL_STEMS: &str = "stems";
/// The present value, in the diagram of a sweep.
pub const CURSOR: &str = "cursor";
/// The present point, in a phase plot.
pub const NOW: &str = "now";

/// All that a recording of what accuracy costs holds, knob by knob.
pub const COST: &str = "cost";
/// What a knob is, the cheapest settings, all its points, in words.
pub const KNOB_WORDS: &str = "words";
/// Error over CPU time.
pub const COST_TIME: &str = "time";
/// Error over calls of the right-hand side.
pub const COST_CALLS: &str = "calls";

/// Where a part of the recording stands: empty for a run, a folder a start for a sweep, a folder a knob
/// for what accuracy costs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Root(String);

impl Root {
    /// That of a run.
    pub fn of_run() -> Self {
        Self::default()
    }

    /// That of the points of a sweep that were started in one way.
    pub fn of_start(start: &str) -> Self {
        Self(format!("{SWEEP}/{start}/"))
    }

    /// That of the settings of one knob.
    pub fn of_knob(knob: &str) -> Self {
        Self(format!("{COST}/{knob}/"))
    }

    /// The whole path of one of the paths of this file.
    pub fn at(&self, path: &str) -> String {
        format!("{}{path}", self.0)
    }
}

/// One natural mode of ball and beam, from 0.
pub fn mode_shape(index: usize) -> String {
    format!("{SHAPES}/mode_{index:02}")
}

/// One tile of the spectrogram, from 0.
pub fn spectrogram_tile(index: usize) -> String {
    format!("{SPECTROGRAM}/tile_{index:02}")
}

/// The numbers of a family of settings.
pub fn cost_numbers(family: &str) -> String {
    format!("numbers/{}", name_of(family))
}

/// Words as a part of a path, which needs no escapes then.
fn name_of(words: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    words.replace(|c| !plain(c), "_")
}

/// Frame, ticks and grid of the picture at a path.
pub fn axis_lines(picture: &str) -> String {
    format!("{picture}/axes/lines")
}

/// Names and numbers of the axes of the picture at a path.
pub fn axis_labels(picture: &str) -> String {
    format!("{picture}/axes/labels")
}

/// What the colours of the picture at a path mean.
pub fn key(picture: &str) -> String {
    format!("{picture}/key")
}

/// The numbers that belong to the picture at a path.
pub fn caption(picture: &str) -> String {
    format!("{picture}/caption")
}
