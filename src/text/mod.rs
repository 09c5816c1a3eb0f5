//! Text for the results of a run: Markdown from the templates under `assets/text`, filled with the values of
//! an observation.
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

use std::f64::consts::{LN_2, LN_10};

use minijinja::context;
use minijinja::value::{Serde, Value};

use crate::dynamics::{Motion, Sign};
use crate::number::{quantity, with_error};
use crate::pipeline::message::{
    Exponents, FrictionReading, Header, Lesson, Measurements, MechanismPrediction, MotionSegment,
    Observation, Regime, Subject, TorusBirth, fastest, unstable,
};
use crate::scene::Mechanism;
use template::{fill, lesson_name};

/// Velocity level over the sliding speed below which the vibration counts as inaudible.
const SILENT: f64 = 1e-3;
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
    let name = lesson_name(lesson.computed.mechanism);
    let mut text = tidy(&filled(&name, lesson_values(lesson)));
    let changed = lesson.measured.changed.join(", ");
    if !changed.is_empty() {
        text += &format!(
            "\n\n**Changed in this run: {changed}.** The computed numbers hold for the scene as written.\n"
        );
    }
    text
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

/// Template variables of a lesson.
fn lesson_values(lesson: &Lesson) -> Value {
    let Lesson {
        computed, measured, ..
    } = lesson;
    let line = measured.lines.first();
    let near = line.and_then(|line| computed.unstable_near(line.frequency));
    let reading = |reading: &FrictionReading| {
        let values = Value::from(Serde(reading));
        context! { unstable => Serde(unstable(&reading.modes)), ..values }
    };
    let readings = computed.readings.iter().flatten();
    let exponents = measured.exponents.as_deref();
    let alone = computed.memory.as_ref();
    let alone = alone.map(|memory| &memory.modes_of_speed_alone[..]);
    context! {
        ln2 => LN_2,
        ln10 => LN_10,
        computed => Serde(&**computed),
        measured => Serde(measured),
        readings => readings.map(reading).collect::<Vec<_>>(),
        fastest => computed.fastest(),
        birth => computed.torus.as_ref().and_then(TorusBirth::birth).map(Serde),
        memory_fastest => alone.and_then(fastest),
        memory_unstable => alone.map(|modes| unstable(modes).len()),
        unstable => Serde(computed.unstable()),
        line => line.map(Serde),
        near => near.map(|mode| mode.label.as_str()),
        kick => computed.start.kick,
        seed => computed.start.seed,
        silent => silence(computed, measured),
        motion => measured.regime.map(|regime| regime.to_string()),
        contrary => contrary(computed.mechanism, measured.regime).map(|regime| regime.to_string()),
        exponents => exponents.map(each_with_error),
        attractor => exponents.map(|exponents| exponents.attractor().name()),
    }
}

/// The level in words, if it is too small to be heard.
fn silence(computed: &MechanismPrediction, measured: &Measurements) -> Option<&'static str> {
    if measured.at_rest {
        Some("at rest")
    } else {
        (measured.level < SILENT * computed.sliding_speed).then_some("silent")
    }
}

/// The present type of motion, if it is clear and differs from the one that the lesson explains.
fn contrary(mechanism: Mechanism, regime: Option<Regime>) -> Option<Regime> {
    let explained = match mechanism {
        Mechanism::Torus => Regime::QuasiPeriodic,
        Mechanism::Chaos => Regime::Chaotic,
        _ => return None,
    };
    let unclear = [Regime::Transient, Regime::Noise, Regime::Undetermined];
    regime.filter(|regime| *regime != explained && !unclear.contains(regime))
}

/// Trims each line and collapses consecutive empty lines.
fn tidy(text: &str) -> String {
    let mut tidy = String::new();
    for line in text.trim().lines().map(str::trim) {
        if !line.is_empty() || !tidy.ends_with("\n\n") {
            tidy += line;
            tidy += "\n";
        }
    }
    tidy
}
