//! The words beside the pictures.

use rerun::{EntityPath, RecordingInfo, TextDocument, TextLog, TextLogLevel};

use super::{
    RERUN_VERSION,
    error::RecordError,
    paths,
    stream::{self, RecordingStream},
    style::{self, Quantity},
};
use crate::pipeline::message::{Header, JointInfo, SignalInfo, Subject, Summary};
use crate::scene::Scene;
use crate::{VERSION, escape};

/// A document of Markdown for the viewer. Names in it are escaped where they are put in; here, whatever else changes
/// how text is shown, and pictures, which a viewer would fetch from anywhere.
pub fn document(markdown: impl AsRef<str>) -> TextDocument {
    TextDocument::from_markdown(escape::lines(markdown.as_ref()).replace("![", "!\\["))
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
        ("squeakscope_version", VERSION),
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
        reading = crate::text::views(header),
        moving = moving(header),
        subject = match &header.subject {
            Subject::Joint(joint) => joint_about(header, joint),
            Subject::Small(_) => scene_about(header),
            Subject::Signal(signal) => signal_about(header, signal),
        },
        version = VERSION,
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

/// The scene of a study, and how the study was started.
pub fn study_about(scene: &Scene, command: &str) -> String {
    format!(
        "## Scene {name}: {title}\n\n{about}\n\n{text}\n\n\
         squeakscope {VERSION}, Rerun {RERUN_VERSION}. Started as {command}.\n",
        name = escape::code(&scene.name),
        title = escape::markdown(&scene.title),
        about = scene.about,
        text = escape::block("toml", &scene.text),
        command = escape::code(command),
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
        version = VERSION,
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
