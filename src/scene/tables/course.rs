//! What acts on the joint, as a scene gives it: a constant, or a function of time in one of its forms.

use super::load::{Form, ScheduleKeys, out_of_order};
use super::{Frames, csv};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schedule::{Schedule, Sine};
use crate::scene::schema::Key;
use crate::scene::schema::kind::{Kind, Number};

/// The fewest frames to a period of a sine. The joint stays as it is for a frame: in a twentieth of a
/// period a sine goes on by at most a third of its amplitude.
const FRAMES_TO_A_PERIOD: f64 = 20.0;

/// A quantity as it was read.
pub struct Course {
    pub schedule: Schedule,
    /// Whether it was given as a function of time, be it one that does not change.
    pub is_function: bool,
    /// The knots as their file states them, where they came from one.
    pub from_file: Option<FileKnots>,
}

/// Knots from a file, as stated there.
pub struct FileKnots {
    pub keys: &'static ScheduleKeys,
    /// Time in ms, and value.
    pub knots: Vec<[f64; 2]>,
}

impl Course {
    /// Reads a quantity; `None` where nothing is said of it.
    ///
    /// # Errors
    /// When it is given twice, or what is given is not valid.
    pub fn find(
        document: &Document<'_>,
        keys: &'static ScheduleKeys,
    ) -> Result<Option<Self>, SceneError> {
        let mut given = keys.forms().filter(|(_, path)| document.has(path));
        let Some((form, path)) = given.next() else {
            return Ok(None);
        };
        if let Some((_, again)) = given.next() {
            let problem = format!("the {} is given twice", keys.word);
            let remedy = format!("keep one of {path} and {again}");
            return Err(document.inconsistent(again, &[path], problem, remedy));
        }
        let table = document.table(keys.table);
        let mut knots_from_file = None;
        let schedule = match form {
            Form::Constant => {
                let constant = keys
                    .constant
                    .as_ref()
                    .expect("its path is one of the forms");
                Some(Schedule::constant(table.get(constant)?))
            }
            Form::Knots => Schedule::through(points(table.list(&keys.knots)?, &keys.knot)?),
            Form::Steps => Schedule::steps(points(table.list(&keys.steps)?, &keys.step)?),
            Form::Sine => Some(sine(document.table(path), keys)?),
            Form::Csv => {
                let knots = csv::knots(document, keys)?;
                let [time, value] = keys.knot.each_ref().map(|key| key.kind.unit);
                let si = |&[t, x]: &[f64; 2]| (time.to_si(t), value.to_si(x));
                let schedule = Schedule::through(knots.iter().map(si).collect());
                knots_from_file = Some(FileKnots { keys, knots });
                schedule
            }
        };
        let place = || document.place_of([path]);
        Ok(Some(Self {
            schedule: schedule.ok_or_else(|| out_of_order(path, place()))?,
            is_function: form != Form::Constant,
            from_file: knots_from_file,
        }))
    }
}

/// Knots or steps.
fn points(
    tables: Vec<Table<'_>>,
    [time, value]: &[Key<Number>; 2],
) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(tables.len());
    for table in tables {
        let point = (table.get(time)?, table.get(value)?);
        if points.last().is_some_and(|before| point.0 <= before.0) {
            return Err(out_of_order(&table.path_of(time.name), table.place()));
        }
        points.push(point);
    }
    Ok(points)
}

/// A sine, all of whose values the quantity can have, and slow enough to be followed.
fn sine(table: Table<'_>, keys: &ScheduleKeys) -> Result<Schedule, SceneError> {
    let (word, value) = (keys.word, keys.knot[1].kind);
    let [mean, amplitude, frequency, phase] = &keys.sine;
    let sine = Sine {
        mean: table.get(mean)?,
        amplitude: table.get(amplitude)?,
        frequency: table.get(frequency)?,
        phase: table.get(phase)?,
    };
    // Back in the unit of the file, without what the units rounded.
    let stated = |si: f64| (1e9 * value.unit.of_si(si)).round() / 1e9;
    for end in [sine.mean - sine.amplitude, sine.mean + sine.amplitude].map(stated) {
        ensure!(table, value.range.contains(end) => amplitude.name, &[mean.name];
            "the {word} would reach {end}";
            "reduce it: the {word} must be {}", value.expected());
    }
    let frame = Frames::read(table.document.table("time"))?.length();
    let fastest = 1.0 / (FRAMES_TO_A_PERIOD * frame);
    // A frequency at the very limit is allowed, however it is rounded.
    ensure!(table,
        sine.frequency <= fastest * (1.0 + 1e-9) => frequency.name, &["time.sample_rate_khz", "time.frame_samples"];
        "the {word} is looked at once a frame, every {} ms, which is too rare for {} Hz", 1e3 * frame, sine.frequency;
        "make it at most {fastest:.3} Hz, or time.frame_samples smaller");
    Schedule::sine(sine).ok_or_else(|| {
        table.inconsistent(mean.name, &[], "its numbers are not finite", "correct them")
    })
}
