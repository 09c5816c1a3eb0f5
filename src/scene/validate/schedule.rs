//! Quantities that are constants or functions of time: tilt, load, and the factor on the rotation.

use super::csv;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::file::{Document, Element};
use crate::scene::keys::{self, Key, ScheduleKeys};
use crate::scene::kind::{Number, Tables};
use crate::scene::schedule::{Schedule, Sine};

/// The fewest frames to a period of a sine. The joint stays as it is for a frame: in a twentieth of a
/// period a sine goes on by at most a third of its amplitude.
const FRAMES_TO_A_PERIOD: f64 = 20.0;

/// A quantity as it was read.
pub(super) struct Course {
    pub schedule: Schedule,
    /// Whether it was given as a function of time, be it one that does not change.
    pub is_function: bool,
    /// The knots as their file states them, where they came from one.
    pub table: Option<Table>,
}

/// Knots from a file, as stated there.
pub(super) struct Table {
    pub keys: &'static ScheduleKeys,
    /// Time in ms, and value.
    pub knots: Vec<[f64; 2]>,
}

/// The forms in which a quantity can be given.
enum Form {
    Constant(&'static Key<Number>),
    Knots,
    Steps,
    Sine,
    Csv,
}

/// Reads a quantity; `None` where nothing is said of it.
///
/// # Errors
/// When it is given twice, or what is given is not valid.
pub(super) fn find(
    document: &Document<'_>,
    keys: &'static ScheduleKeys,
) -> Result<Option<Course>, SceneError> {
    let forms = [Form::Knots, Form::Steps, Form::Sine, Form::Csv];
    let forms = keys.constant.map(Form::Constant).into_iter().chain(forms);
    let mut given = forms
        .zip(keys.forms())
        .filter(|(_, path)| document.has(path));
    let Some((form, path)) = given.next() else {
        return Ok(None);
    };
    if let Some((_, again)) = given.next() {
        return Err(document.inconsistent(
            again,
            &[path],
            format!("the {} is given twice", keys.word),
            format!("keep one of {path} and {again}"),
        ));
    }
    let mut table = None;
    let schedule = match form {
        Form::Constant(key) => Schedule::constant(document.get(key)?),
        Form::Knots => points(document, &keys.knots, Schedule::through)?,
        Form::Steps => points(document, &keys.steps, Schedule::steps)?,
        Form::Sine => sine(document, keys)?,
        Form::Csv => {
            let knots = csv::knots(document, keys)?;
            let [time, value] = keys.knots.1;
            let si = |&[t, x]: &[f64; 2]| (time.kind.unit.to_si(t), value.kind.unit.to_si(x));
            let schedule = Schedule::through(knots.iter().map(si).collect());
            table = Some(Table { keys, knots });
            schedule.ok_or_else(|| out_of_order(time, document.place_of(&[keys.csv.path])))?
        }
    };
    Ok(Some(Course {
        schedule,
        is_function: !matches!(form, Form::Constant(_)),
        table,
    }))
}

/// Knots or steps.
fn points(
    document: &Document<'_>,
    (list, [time, value]): &(&Key<Tables>, [&'static Key<Number>; 2]),
    schedule: fn(Vec<(f64, f64)>) -> Option<Schedule>,
) -> Result<Schedule, SceneError> {
    let elements = document.list(list)?.unwrap_or_default();
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(elements.len());
    for element in &elements {
        let point = point(document, element, [time, value])?;
        if points.last().is_some_and(|before| point.0 <= before.0) {
            return Err(out_of_order(time, document.place_of_element(element)));
        }
        points.push(point);
    }
    schedule(points).ok_or_else(|| out_of_order(time, document.place_of(&[list.path])))
}

fn point(
    document: &Document<'_>,
    element: &Element<'_>,
    [time, value]: [&Key<Number>; 2],
) -> Result<(f64, f64), SceneError> {
    Ok((
        document.get_in(element, time)?,
        document.get_in(element, value)?,
    ))
}

/// The error of a point that is not later than the one before.
pub(super) fn out_of_order(time: &Key<Number>, place: Place) -> SceneError {
    Fault::Inconsistent {
        key: time.path,
        problem: "this time is not later than the one before".to_owned(),
        remedy: "put the times in order, each once".to_owned(),
    }
    .at(place)
}

/// A sine, all of whose values the quantity can have, and slow enough to be followed.
fn sine(document: &Document<'_>, keys: &ScheduleKeys) -> Result<Schedule, SceneError> {
    let [mean, amplitude, frequency, phase] = keys.sine_numbers;
    let sine = Sine {
        mean: document.get(mean)?,
        amplitude: document.get(amplitude)?,
        frequency: document.get(frequency)?,
        phase: document.get(phase)?,
    };
    // Back in the unit of the file, without what the units rounded.
    let stated = |si: f64| (1e9 * keys.value.unit.of_si(si)).round() / 1e9;
    let ends = [sine.mean - sine.amplitude, sine.mean + sine.amplitude].map(stated);
    if let Some(beyond) = ends.into_iter().find(|&x| !keys.value.range.contains(x)) {
        return Err(document.inconsistent(
            amplitude.path,
            &[mean.path],
            format!("the {} would reach {beyond}", keys.word),
            format!(
                "reduce it: the {} must be {}",
                keys.word,
                crate::scene::kind::Kind::expected(&keys.value)
            ),
        ));
    }
    let rate: f64 = document.get(&keys::SAMPLE_RATE)?;
    let frame = document.get(&keys::FRAME_SAMPLES)? as f64 / rate;
    let fastest = 1.0 / (FRAMES_TO_A_PERIOD * frame);
    // A frequency at the very limit is allowed, however it is rounded.
    if sine.frequency > fastest * (1.0 + 1e-9) {
        return Err(document.inconsistent(
            frequency.path,
            &[keys::SAMPLE_RATE.path, keys::FRAME_SAMPLES.path],
            format!(
                "the {} is looked at once a frame, every {} ms, which is too rare for {} Hz",
                keys.word,
                1e3 * frame,
                sine.frequency
            ),
            format!("make it at most {fastest:.3} Hz, or time.frame_samples smaller"),
        ));
    }
    Schedule::sine(sine).ok_or_else(|| {
        document.inconsistent(keys.sine, &[], "its numbers are not finite", "correct them")
    })
}
