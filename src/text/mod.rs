//! Text for the results of a run: Markdown from the templates under `assets/text`, filled with the values of
//! an observation, and lessons.
//!
//! The pipeline sends values ([`Observation`], [`Lesson`]); the sink that displays them calls this module to
//! turn them into text.

#[cfg(feature = "record")]
pub mod paper;
mod template;
#[cfg(test)]
mod tests;

use std::f64::consts::LN_2;

use minijinja::context;
use minijinja::value::{Serde, Value};

use crate::number::quantity;
use crate::pipeline::lesson::{Fact, MOTION};
use crate::pipeline::message::{
    Header, Lesson, MotionSegment, Observation, RunExponents, SpectralLine, Subject,
};
use crate::report::{Block, Report as _, markdown};
use crate::scene::Evidence;
use template::fill;

/// The text with its first letter in upper case.
pub(crate) fn capitalize(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// An observation as text: Markdown that starts with a heading `## ...`.
pub fn narration(observation: &Observation) -> String {
    let text = match observation {
        Observation::Vibration(vibration) => {
            let some = |is: fn(&SpectralLine) -> bool| {
                let lines = vibration.lines.iter().filter(|line| is(line));
                Value::from(Serde(lines.collect::<Vec<_>>()))
            };
            let values = context! {
                ln2 => LN_2,
                harmonics => some(SpectralLine::is_harmonic),
                combinations => some(SpectralLine::is_mixed),
                halves => some(SpectralLine::is_half),
                ..Value::from(Serde(vibration))
            };
            filled("narration/vibration", values)
        }
        Observation::Separated {
            initial_distance,
            after,
            e_fold_time,
        } => filled(
            "narration/separated",
            context! {
                initial_distance => *initial_distance,
                after => *after,
                e_fold_time => *e_fold_time,
            },
        ),
        Observation::Exponents(exponents) => markdown(&RunExponents::new(exponents).blocks("")),
    };
    text.trim().to_owned()
}

/// A lesson as text: Markdown that starts with a heading `## ...`.
pub fn lesson(lesson: &Lesson) -> String {
    let (computed, measured) = (&lesson.computed, &lesson.measured);
    let facts = lesson.facts();
    let mut remarks = String::new();
    let is_other = |fact: &Fact| fact.name == MOTION && fact.agrees == Some(false);
    if let Some(motion) = measured.regime.filter(|_| facts.iter().any(is_other)) {
        remarks += &format!(
            "**The motion is now classified as {motion}.** This lesson explains the motion for which the scene was \
             written.\n\n"
        );
    }
    let tilts = computed.tilt.zip(measured.tilt);
    let tilts = tilts.map(|(from, to)| [from, to].map(|tilt| format!("{:.1}°", tilt.to_degrees())));
    let ramps = [Evidence::Turning, Evidence::Loop, Evidence::Birth];
    let is_ramp = ramps.contains(&computed.mechanism.evidence());
    if let Some([from, to]) = tilts.filter(|[from, to]| from != to && !is_ramp) {
        remarks += &format!("The load is now tilted by **{to}**; the lesson is for {from}.\n\n");
    }
    let changed = measured.changed.join(", ");
    if !changed.is_empty() {
        remarks += &format!(
            "**Changed in this run: {changed}.** The computed numbers hold for the scene as written.\n\n"
        );
    }
    let explanation = lesson.explanation();
    let (heading, explanation) = explanation.split_once("\n\n").unwrap_or_default();
    let line = |fact: &Fact| format!("* {}", markdown(&[Block::Text(fact.line())]));
    let facts: String = facts.iter().map(line).collect();
    format!("{heading}\n\n{remarks}{explanation}\n{facts}")
}

/// A Markdown table of the views of a run's recording and what each one shows.
pub fn views(header: &Header) -> String {
    filled("views", view_values(header))
}

/// Template variables of the table of views.
fn view_values(header: &Header) -> Value {
    let joint = header.joint();
    context! {
        joint => joint.is_some(),
        small => matches!(header.subject, Subject::Small(_)),
        body => joint.is_some_and(|joint| !joint.outline.vertices.is_empty()),
        lesson => header.computed.is_some(),
        events => matches!(&header.subject, Subject::Signal(signal) if !signal.events.is_empty()),
        analyses => header.analysis.names(),
    }
}

/// The text of a template with its values, or its error message: a template error must not stop a run.
pub(crate) fn filled(name: &str, values: Value) -> String {
    let text = fill(name, values);
    text.unwrap_or_else(|error| format!("## Text missing\n\n{error:#}; please report this.\n"))
}

/// What preceded the last of several motions in a run, such as `chaotic transient of 830 ms`; `None` for one
/// motion. `chaotic_transient` is the lifetime of the chaotic transient, s.
pub fn earlier_motion(
    segments: &[MotionSegment],
    chaotic_transient: Option<f64>,
) -> Option<String> {
    let (_, earlier) = segments.split_last()?;
    let before = earlier.last()?;
    Some(match chaotic_transient {
        Some(lifetime) => format!("chaotic transient of {}", quantity(lifetime, 3, "s")),
        None => format!(
            "{} until {}",
            before.attractor,
            quantity(before.end_s, 3, "s")
        ),
    })
}
