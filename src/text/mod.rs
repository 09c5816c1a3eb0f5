//! Text for the results of a run: Markdown from the templates under `assets/text`, filled with the values of
//! an observation, and lessons.
//!
//! The pipeline sends values ([`Observation`], [`Lesson`]); the sink that displays them calls this module to
//! turn them into text. The template values of a sweep are in `record/sweep/description.rs`.

#[cfg(feature = "record")]
pub mod branch;
#[cfg(feature = "record")]
pub mod paper;
mod template;
#[cfg(test)]
mod tests;

use std::f64::consts::LN_2;

use minijinja::context;
use minijinja::value::{Serde, Value};

use crate::dynamics::{Motion, Sign};
use crate::number::{quantity, with_error};
use crate::pipeline::lesson::{Fact, MOTION};
use crate::pipeline::message::{Exponents, Header, Lesson, MotionSegment, Observation, Subject};
use crate::report::{Block, markdown};
use crate::scene::Evidence;
use template::fill;

/// Number of exponents listed in a sentence.
const EXPONENTS_SHOWN: usize = 4;

/// The text with its first letter in upper case.
pub(crate) fn capitalize(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// An observation as text: Markdown that starts with a heading `## ...`.
pub fn narration(observation: &Observation) -> String {
    let (name, values) = match observation {
        Observation::Vibration(vibration) => {
            let values = Value::from(Serde(vibration));
            ("narration/vibration", context! { ln2 => LN_2, ..values })
        }
        Observation::Separated {
            initial_distance,
            after,
            e_fold_time,
        } => (
            "narration/separated",
            context! {
                initial_distance => *initial_distance,
                after => *after,
                e_fold_time => *e_fold_time,
            },
        ),
        Observation::Exponents(exponents) => ("narration/exponents", exponent_values(exponents)),
    };
    filled(name, values).trim().to_owned()
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

/// Template variables of the text on exponents.
fn exponent_values(exponents: &Exponents) -> Value {
    let spectrum = &exponents.spectrum;
    let zeros = spectrum.count(Sign::Zero);
    context! {
        attractor => exponents.attractor().name(),
        name => exponents.attractor().to_string(),
        exponents => each_with_error(exponents),
        time => spectrum.time,
        earlier => earlier_motion(&exponents.segments, exponents.chaotic_transient),
        largest => spectrum.exponents.first().map(|first| first.value),
        zeros => zeros,
        more => spectrum.dimension > zeros,
        driven => exponents.motion == Motion::Driven,
    }
}

/// The largest exponents, each with its error.
fn each_with_error(exponents: &Exponents) -> Vec<String> {
    let all = exponents.spectrum.exponents.iter();
    all.take(EXPONENTS_SHOWN)
        .map(|exponent| with_error(exponent.value, exponent.half_width))
        .collect()
}
