//! The words beside the pictures.

use rerun::{EntityPath, RecordingInfo, TextDocument, TextLog, TextLogLevel};

use super::{
    RERUN_VERSION,
    error::RecordError,
    paths,
    stream::{self, RecordingStream},
    style::{self, Quantity},
};
use crate::escape;
use crate::pipeline::message::{AnalysisKind, Header, JointInfo, SignalInfo, Subject, Summary};

/// A document of Markdown for the viewer. Names in it are escaped where they are put in; here, whatever else changes
/// how text is shown, and pictures, which a viewer would fetch from anywhere.
pub fn document(markdown: impl AsRef<str>) -> TextDocument {
    TextDocument::from_markdown(escape::lines(markdown.as_ref()).replace("![", "!\\["))
}

/// How to read the views that the run has.
fn reading(header: &Header) -> String {
    let joint = header.joint().is_some();
    let small = matches!(header.subject, Subject::Small(_));
    let has = |kind| header.has(kind);
    let rows = [
        (
            header.computed.is_some(),
            "**Lesson** | the mechanism that the scene shows: what was computed of it before the run, and what has been measured in it so far, beside the pictures that prove it",
        ),
        (
            header
                .joint()
                .is_some_and(|joint| !joint.outline.vertices.is_empty()),
            "**Ball and beam**, or **Body of** a file | the vibrating body, its motion drawn much too large; yellow moves most",
        ),
        (
            joint,
            "**Contact patch** | where the ball bears on the socket, seen along the load: *blue* nodes slide, *orange* ones stick (they only creep), *white* ones have lifted off; a node grows with its pressure; pink arrows are the friction on the ball; the yellow ring is the edge; the white dot is the beam's axis, with circles of equal tilt round it",
        ),
        (
            joint,
            "**Phase portrait** | velocity against displacement of the contact's centre along the sliding, the last 20 ms: a closed loop is a pure tone, a woven band a torus, a tangle chaos",
        ),
        (
            small,
            "**Phase portrait** | velocity against displacement, the last forty natural periods, in the colour of what the system does: a closed loop is periodic, a tangle chaos",
        ),
        (
            small,
            "**What it does** | the smooth law that holds, from one jump or kink to the next: steps end exactly there; the time series have the same colours",
        ),
        (
            has(AnalysisKind::Recurrence),
            "**Recurrence plot** | bright where the motion comes back: unbroken diagonals mean a tone, broken ones chaos",
        ),
        (
            has(AnalysisKind::Spectrum) || has(AnalysisKind::Spectrogram),
            "**Spectrum, spectrogram** | how strong each frequency is, now and over the whole run; the spectrogram begins and ends half a window inside",
        ),
        (
            has(AnalysisKind::Recurrence),
            "**Delay embedding** | the motion rebuilt from one signal and its own past: what shape is it drawn to?",
        ),
        (
            has(AnalysisKind::Delay),
            "**Mutual information** | what the signal now tells of the signal a lag later; the first minimum is the delay τ",
        ),
        (
            has(AnalysisKind::Delay),
            "**False neighbours** | states that look alike only because too few coordinates are seen; where none is left is the dimension m",
        ),
        (
            has(AnalysisKind::Section),
            "**Poincaré section** | where the motion passes through a plane, bright now: a few points are a tone, a closed curve a torus, a cloud chaos",
        ),
        (
            has(AnalysisKind::Section),
            "**Return map** | one passage against the next: on the diagonal the motion repeats",
        ),
        (
            has(AnalysisKind::Quantification),
            "**Recurrence measures** | RR how much comes back; DET how much of it along diagonals, LAM along verticals; L and Lmax how long it then stays together; TT, T1, T2 how soon it leaves and comes back; ENTR how varied the diagonals are; TREND whether it drifts",
        ),
        (
            has(AnalysisKind::Chaos),
            "**How neighbours part** | mean log distance of states that were alike; its straight part (orange) has the largest exponent λ as slope: above zero is chaos",
        ),
        (
            has(AnalysisKind::Chaos),
            "**0-1 test** | a path that stays bounded (K near 0) is regular, one that wanders like chance (K near 1) chaotic",
        ),
        (
            has(AnalysisKind::Regime),
            "**Kind of motion** | the verdict over time, how sure it is, and the evidence behind it",
        ),
        (
            has(AnalysisKind::Exponents),
            "**Lyapunov exponents** | how fast neighbouring motions part (above zero) or meet (below), one a direction, from the flow of the simulation itself; thin lines are the ends of the 95 % intervals",
        ),
        (
            has(AnalysisKind::Butterfly),
            "**Butterfly** | a second copy of the joint (orange) that started almost like the first: its distance on a logarithmic scale grows with the largest exponent as its slope, until it is as large as the motion",
        ),
        (
            joint || small,
            "**Health** | the largest local error that the integrator sees in the steps of a frame, over the tolerance (1 is all that is allowed); what a simulated millisecond costs in steps and calls of the right-hand side, and how fast that is here",
        ),
    ];
    let rows = rows.iter().filter(|(there, _)| *there);
    let rows: String = rows.map(|(_, row)| format!("| {row} |\n")).collect();
    format!("| view | what it shows |\n|---|---|\n{rows}")
}

/// How to move in time.
fn moving(header: &Header) -> &'static str {
    match header.subject {
        Subject::Joint(_) => {
            "Drag the cursor at the bottom, or press play: it runs a hundred times slower than life."
        }
        Subject::Small(_) | Subject::Signal(_) => "Drag the cursor at the bottom, or press play.",
    }
}

/// Where a recording is from.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// What it is called in the viewer.
    pub name: &'a str,
    /// Name of the scene.
    pub scene: &'a str,
    /// The scene file's text.
    pub scene_text: &'a str,
    /// How the program was started.
    pub command: &'a str,
}

impl<'a> From<&'a Header> for Origin<'a> {
    fn from(header: &'a Header) -> Self {
        Self {
            name: &header.scene,
            scene: &header.scene,
            scene_text: &header.scene_text,
            command: &header.command,
        }
    }
}

/// Properties of the recording: versions, scene, command.
pub fn send_properties(rec: &RecordingStream, origin: Origin<'_>) -> Result<(), RecordError> {
    let name = RecordingInfo::update_fields().with_name(&*escape::line(origin.name));
    rec.log_static(EntityPath::properties(), &name)?;
    let fields = [
        ("scene", origin.scene),
        ("scene_text", origin.scene_text),
        ("command", origin.command),
        ("squeakscope_version", crate::VERSION),
        ("rerun_version", RERUN_VERSION),
    ];
    let run = fields.into_iter().fold(
        rerun::DynamicArchetype::new("squeakscope.Run"),
        |run, (name, value)| {
            run.with_component::<rerun::components::Text>(name, [value.to_owned()])
        },
    );
    let path = EntityPath::properties().join(&EntityPath::from(paths::RUN_PROPERTY));
    rec.log_static(path, &run)
}

/// What is known before the first frame.
pub fn log_about(rec: &RecordingStream, header: &Header) -> Result<(), RecordError> {
    let about = format!(
        "# {title}\n\n{about}\n\n## Reading the screen\n\n{reading}\n{moving}\n\n{subject}\
         squeakscope {version}, Rerun {RERUN_VERSION}. Started as {command}.\n",
        title = escape::markdown(&header.title),
        about = header.about,
        reading = reading(header),
        moving = moving(header),
        subject = match &header.subject {
            Subject::Joint(joint) => joint_about(header, joint),
            Subject::Small(_) => scene_about(header),
            Subject::Signal(signal) => signal_about(header, signal),
        },
        version = crate::VERSION,
        command = escape::code(&header.command),
    );
    rec.log_static(paths::ABOUT, &document(about))?;
    let opening = match header.subject {
        Subject::Joint(_) => {
            "## A small kick\n\nThe run starts from steady sliding, ever so slightly disturbed."
        }
        Subject::Small(_) => {
            "## It starts\n\nA few periods pass before its kind of motion can be told."
        }
        Subject::Signal(_) => "## A signal\n\nNothing is known of it yet.",
    };
    narrate(rec, header, header.start(), opening)
}

/// Modes and scene.
fn joint_about(header: &Header, joint: &JointInfo) -> String {
    let modes: String = joint
        .modes
        .iter()
        .map(|mode| format!("| {} | {:.1} |\n", mode.label, mode.frequency_hz))
        .collect();
    format!(
        "## Modes\n\n| mode | natural frequency, Hz |\n|---|---|\n{modes}\n\
         {scene}\
         Model: J. Kang, *Nonlinear Vibration Induced by Friction in a Ball Joint System*, \
         Lubricants 2022, 10, 201.\n\n",
        scene = scene_about(header),
    )
}

/// The scene.
fn scene_about(header: &Header) -> String {
    format!(
        "## Scene {scene}\n\n{text}\n\n",
        scene = escape::code(&header.scene),
        text = escape::block("toml", &header.scene_text),
    )
}

/// Where the signal is from, and its size.
fn signal_about(header: &Header, signal: &SignalInfo) -> String {
    let quantity = Quantity::displacement(&header.subject);
    let [low, high] = signal.span.map(|value| quantity.words(value));
    let rows = [
        ("source", escape::markdown(&signal.source)),
        ("column", escape::markdown(&signal.column)),
        ("samples a second", style::short(header.sample_rate)),
        ("first sample at", style::moment(header, header.start())),
        ("length", Quantity::Time.words(header.duration)),
        ("smallest sample", low),
        ("largest sample", high),
    ];
    let rows: String = rows
        .iter()
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| format!("| {name} | {value} |\n"))
        .collect();
    format!("## Signal\n\n| what | value |\n|---|---|\n{rows}\n")
}

/// What is being seen now, between the scene's title and its description. `words` are Markdown
/// with a heading of their own.
pub fn narrate(
    rec: &RecordingStream,
    header: &Header,
    time: f64,
    words: &str,
) -> Result<(), RecordError> {
    let facts = match &header.subject {
        Subject::Joint(joint) => format!(
            "Ball {ball:.2} mm across, pressed by {load} N, sliding at {speed} mm/s.",
            ball = 2e3 * joint.ball_radius,
            load = style::span(joint.load_span, style::short),
            speed = style::span(joint.rotation_span, |factor| {
                format!("{:.1}", 1e3 * factor * joint.sliding_speed)
            }),
        ),
        Subject::Small(small) => format!(
            "This is {}, with a natural frequency of {}.",
            small.words,
            Quantity::Frequency.words(small.frequency_hz),
        ),
        Subject::Signal(signal) => format!(
            "{}, {} samples a second, {} long.",
            escape::code(style::signal_name(signal)),
            style::short(header.sample_rate),
            Quantity::Time.words(header.duration),
        ),
    };
    let text = format!(
        "**{title}**\n\n{words}\n\n*Seen at {now}.*\n\n---\n\n{about}\n\n\
         *{facts} How to read the views: tab “About”.*\n\n`squeakscope {version}`",
        title = escape::markdown(&header.title),
        now = style::moment(header, time),
        about = header.about,
        version = crate::VERSION,
    );
    stream::log_at(rec, paths::NARRATION, time, &document(text))
}

/// A line of the log: what was done to the run.
pub fn note(rec: &RecordingStream, time: f64, words: &str) -> Result<(), RecordError> {
    let line = TextLog::new(&*escape::line(words)).with_level(TextLogLevel::INFO);
    stream::log_at(rec, paths::LOG, time, &line)
}

/// A line of the log: what the user should know.
pub fn warn(rec: &RecordingStream, time: f64, words: &str) -> Result<(), RecordError> {
    let line = TextLog::new(&*escape::line(words)).with_level(TextLogLevel::WARN);
    stream::log_at(rec, paths::LOG, time, &line)
}

/// The last line of the log.
pub fn summarise(
    rec: &RecordingStream,
    header: &Header,
    summary: &Summary,
) -> Result<(), RecordError> {
    let lines: Vec<String> = summary
        .peaks
        .iter()
        .take(4)
        .map(|peak| {
            let unit = Quantity::Frequency.unit(peak.frequency);
            format!("{:.2} {}", unit.per_si * peak.frequency, unit.symbol)
        })
        .collect();
    let end = if summary.interrupted {
        "Interrupted"
    } else {
        "Finished"
    };
    let lines = if lines.is_empty() {
        "no line".to_owned()
    } else {
        lines.join(", ")
    };
    let end = format!(
        "{end} after {}: {lines}",
        style::moment(header, summary.simulated)
    );
    let words = match header.subject {
        Subject::Joint(_) => format!(
            "{end}; amplitude {amplitude:.3} µm, peak velocity {peak:.1} mm/s; {factor:.2} of real \
             time; {steps} steps, {rejections} rejected, {calls} right-hand sides, {transitions} \
             contact transitions; {audit}",
            amplitude = 1e6 * summary.amplitude,
            peak = 1e3 * summary.peak_velocity,
            factor = summary.real_time_factor,
            steps = summary.tally.steps,
            rejections = summary.tally.rejections,
            calls = summary.tally.calls,
            transitions = summary.transitions,
            audit = match summary.audit {
                Some(residual) => format!("energy audit {residual:.1e}"),
                None => "energy not audited".to_owned(),
            },
        ),
        Subject::Small(ref small) => format!(
            "{end}; amplitude {amplitude:.3} µm, peak velocity {peak:.1} mm/s; {factor:.2} of real \
             time; {steps} steps, {rejections} rejected, {calls} right-hand sides, {transitions} {what}",
            amplitude = 1e6 * summary.amplitude,
            peak = 1e3 * summary.peak_velocity,
            factor = summary.real_time_factor,
            steps = summary.tally.steps,
            rejections = summary.tally.rejections,
            calls = summary.tally.calls,
            transitions = summary.transitions,
            what = small.transition,
        ),
        Subject::Signal(_) => {
            let quantity = Quantity::displacement(&header.subject);
            format!("{end}; amplitude {}", quantity.words(summary.amplitude))
        }
    };
    let line = TextLog::new(words).with_level(TextLogLevel::INFO);
    stream::log_at(rec, paths::LOG, header.start() + summary.simulated, &line)
}
