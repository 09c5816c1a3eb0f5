//! The texts of a recording: description, narration and log.

use crate::record::sdk::components::Text;
use crate::record::sdk::{
    DynamicArchetype, EntityPath, RecordingInfo, TextDocument, TextLog, TextLogLevel,
};

use super::{RERUN_VERSION, paths, stream::RecordingStream, style};
use crate::pipeline::message::{Header, JointInfo, SignalInfo, Subject, Summary};
use crate::plot::{Unit, shown};
use crate::scene::Scene;
use crate::{VERSION, escape};

/// A Markdown document for the viewer, its numbers outside of code as figures show them. Names are escaped when they are
/// inserted. This function escapes control characters, and images, because a viewer would fetch them from any address.
pub fn document(markdown: impl AsRef<str>) -> TextDocument {
    let parts = markdown.as_ref().split('`').enumerate();
    let parts = parts.map(|(k, part)| {
        if k.is_multiple_of(2) {
            shown(part)
        } else {
            escape::lines(part)
        }
    });
    let text = parts.collect::<Vec<_>>().join("`");
    TextDocument::from_markdown(text.replace("![", "!\\["))
}

/// Logs the properties of the recording: its name in the viewer; versions, name and text of the scene, command line.
pub fn send_properties(rec: &RecordingStream, name: &str, [scene, scene_text, command]: [&str; 3]) {
    let name = RecordingInfo::update_fields().with_name(&*escape::line(name));
    rec.log_static(EntityPath::properties(), &name);
    let fields = [
        ("scene", scene),
        ("scene_text", scene_text),
        ("command", command),
        ("squeakscope_version", VERSION),
        ("rerun_version", RERUN_VERSION),
    ];
    let mut run = DynamicArchetype::new("squeakscope.Run");
    for (name, value) in fields {
        run = run.with_component::<Text>(name, [value.to_owned()]);
    }
    let path = EntityPath::properties().join(&EntityPath::from(paths::RUN_PROPERTY));
    rec.log_static(path, &run);
}

/// Logs the description of the run, and the initial narration.
pub fn log_about(rec: &RecordingStream, header: &Header) {
    let about = format!(
        "# {title}\n\n{about}\n\n## Views\n\n{reading}\n\n{subject}\
         squeakscope {version}, Rerun {RERUN_VERSION}. Command: {command}.\n",
        title = escape::markdown(&header.title),
        about = header.about,
        reading = crate::text::views(header),
        subject = match &header.subject {
            Subject::Joint(joint) => joint_about(header, joint),
            Subject::Small(_) => scene_about(header),
            Subject::Signal(signal) => signal_about(header, signal),
        },
        version = VERSION,
        command = escape::code(&header.command),
    );
    rec.log_static(paths::ABOUT, &document(about));
    let opening = match header.subject {
        Subject::Joint(_) => {
            "## Start of the run\n\nThe joint slides steadily; a small kick excites its modes."
        }
        Subject::Small(_) => {
            "## Start of the run\n\nThe type of motion is classified after a few periods."
        }
        Subject::Signal(_) => "## Start of the signal\n\nNo data analysed yet.",
    };
    narrate(rec, header, header.start(), opening)
}

/// Table of the modes, scene and reference of the model.
fn joint_about(header: &Header, joint: &JointInfo) -> String {
    let modes = joint.modes.iter();
    let modes = modes.map(|mode| format!("| {} | {:.1} |\n", mode.label, mode.frequency_hz));
    let modes: String = modes.collect();
    format!(
        "## Modes\n\n| mode | natural frequency, Hz |\n|---|---|\n{modes}\n\
         {scene}\
         Model: J. Kang, *Nonlinear Vibration Induced by Friction in a Ball Joint System*, \
         Lubricants 2022, 10, 201.\n\n",
        scene = scene_about(header),
    )
}

/// The scene file.
fn scene_about(header: &Header) -> String {
    let scene = escape::code(&header.scene);
    let text = escape::block("toml", &header.scene_text);
    format!("## Scene {scene}\n\n{text}\n\n")
}

/// The scene of a study, and its command line.
pub fn study_about(scene: &Scene, command: &str) -> String {
    format!(
        "## Scene {name}: {title}\n\n{about}\n\n{text}\n\n\
         squeakscope {VERSION}, Rerun {RERUN_VERSION}. Command: {command}.\n",
        name = escape::code(&scene.name),
        title = escape::markdown(&scene.title),
        about = scene.about,
        text = escape::block("toml", &scene.text),
        command = escape::code(command),
    )
}

/// Source and properties of a signal.
fn signal_about(header: &Header, signal: &SignalInfo) -> String {
    let [low, high] = signal.span.map(|value| Unit::write(value, &signal.unit));
    let rows = [
        ("source", escape::markdown(&signal.source)),
        ("column", escape::markdown(&signal.column)),
        ("sample rate, Hz", style::short(header.sample_rate)),
        (
            "time of the first sample",
            style::format_time(header, header.start()),
        ),
        ("duration", Unit::write(header.duration, "s")),
        ("minimum", low),
        ("maximum", high),
    ];
    let rows = rows.iter().filter(|(_, value)| !value.is_empty());
    let rows = rows.map(|(name, value)| format!("| {name} | {value} |\n"));
    let rows: String = rows.collect();
    format!("## Signal\n\n| property | value |\n|---|---|\n{rows}\n")
}

/// Logs the narration: an observation as Markdown with its own heading, and below it the title and the
/// description of the scene, which describe the scene as written and not the present motion.
pub fn narrate(rec: &RecordingStream, header: &Header, time: f64, words: &str) {
    let facts = match &header.subject {
        Subject::Joint(joint) => {
            let ball = 2e3 * joint.ball_radius;
            let load = style::format_range(joint.load_span, style::short);
            let speed = |factor: f64| format!("{:.1}", 1e3 * factor * joint.sliding_speed);
            let speed = style::format_range(joint.rotation_span, speed);
            format!("Ball diameter {ball:.2} mm, load {load} N, sliding speed {speed} mm/s.")
        }
        Subject::Small(small) => {
            let frequency = Unit::write(small.frequency_hz, "Hz");
            format!("System: {}, natural frequency {frequency}.", small.words)
        }
        Subject::Signal(signal) => {
            let column = escape::code(&signal.column);
            let rate = style::short(header.sample_rate);
            let duration = Unit::write(header.duration, "s");
            format!("{column}, sample rate {rate} Hz, duration {duration}.")
        }
    };
    let text = format!(
        "{words}\n\n*Observed at {now}.*\n\n---\n\n**{written}{title}**\n\n{about}\n\n\
         *{facts} The views are described in the tab “About”.*\n\n`squeakscope {version}`",
        title = escape::markdown(&header.title),
        written = match header.subject {
            Subject::Joint(_) | Subject::Small(_) => "The scene as written: ",
            Subject::Signal(_) => "",
        },
        now = style::format_time(header, time),
        about = header.about,
        version = VERSION,
    );
    rec.log(paths::NARRATION, time, &document(text));
}

/// Logs an event of the run, or a warning.
pub fn note(rec: &RecordingStream, time: f64, words: &str, level: &str) {
    let line = TextLog::new(&*escape::line(words)).with_level(level);
    rec.log(paths::LOG, time, &line);
}

/// Logs the summary of the run.
pub fn summarise(rec: &RecordingStream, header: &Header, summary: &Summary) {
    let lines = summary.lines.iter().take(4);
    let lines = lines.map(|line| Unit::write(line.frequency, "Hz"));
    let lines: Vec<String> = lines.collect();
    let end = if summary.interrupted {
        "Interrupted"
    } else {
        "Finished"
    };
    let lines = match lines.join(", ") {
        none if none.is_empty() => "no spectral line".to_owned(),
        lines => format!("spectral lines {lines}"),
    };
    let lines = (!summary.at_rest).then_some(lines);
    let facts: Vec<String> = summary.describe_motion().into_iter().chain(lines).collect();
    let time = style::format_time(header, summary.simulated_s);
    let end = format!("{end} after {time}: {}", facts.join("; "));
    let simulated = |transitions: &str| {
        format!(
            "{end}; amplitude {amplitude:.3} µm, peak velocity {peak:.1} mm/s; {factor:.2} times real \
             time; {steps} steps, {rejections} rejected, {calls} RHS evaluations, {count} {transitions}",
            amplitude = 1e6 * summary.amplitude_m,
            peak = 1e3 * summary.peak_velocity_m_per_s,
            factor = summary.real_time_factor,
            steps = summary.stats.steps,
            rejections = summary.stats.rejections,
            calls = summary.stats.rhs_evals,
            count = summary.transitions,
        )
    };
    let words = match &header.subject {
        Subject::Joint(_) => {
            let audit = summary.energy_residual;
            let audit = audit.map(|residual| format!("energy residual {residual:.1e}"));
            let audit = audit.unwrap_or_else(|| "no energy audit".to_owned());
            simulated(&format!("contact transitions; {audit}"))
        }
        Subject::Small(small) => simulated(small.transition),
        Subject::Signal(signal) => {
            let amplitude = Unit::write(summary.amplitude_m, &signal.unit);
            format!("{end}; amplitude {amplitude}")
        }
    };
    let line = TextLog::new(words).with_level(TextLogLevel::INFO);
    rec.log(paths::LOG, header.start() + summary.simulated_s, &line);
}
