//! Load, tilt and rotation factor as given in a scene: a constant, or a function of time in one of its forms.

use super::Frames;
use super::knots::{out_of_order, points};
use super::load::{Form, ScheduleKeys, TIME_ORDER};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schedule::{Schedule, Sine};
use crate::scene::schema::kind::Kind;

/// Minimum number of frames in a period of a sine. The joint is constant within a frame; in a twentieth of a
/// period a sine changes by at most a third of its amplitude.
const MIN_FRAMES_PER_PERIOD: f64 = 20.0;

/// A quantity as read from the scene.
pub struct Quantity {
    pub schedule: Schedule,
    /// Whether the scene gives a function of time, even if its value is constant.
    pub is_function: bool,
}

impl Quantity {
    /// Reads a quantity; `None` if the scene does not contain it.
    ///
    /// # Errors
    /// If it is given more than once, or its values are invalid.
    pub fn find(
        document: &Document<'_>,
        keys: &'static ScheduleKeys,
    ) -> Result<Option<Self>, SceneError> {
        let mut given = keys.forms().filter(|(_, path)| document.has(path));
        let Some((form, path)) = given.next() else {
            return Ok(None);
        };
        if let Some((_, again)) = given.next() {
            let problem = format!("the scene gives the {} more than once", keys.word);
            let remedy = format!("keep one of {path} and {again}");
            return Err(document.inconsistent(again, &[path], problem, remedy));
        }
        let curve = &keys.curve;
        let table = document.table(curve.table);
        let schedule = match form {
            Form::Constant => {
                let constant = keys
                    .constant
                    .as_ref()
                    .expect("its path is one of the forms");
                Some(Schedule::constant(table.get(constant)?))
            }
            // A file has been replaced by its knots.
            Form::Knots | Form::Csv => {
                let knots = points(table.list(curve.knots)?, curve.knot, TIME_ORDER)?;
                Schedule::piecewise_linear(knots.into_iter().map(Into::into).collect())
            }
            Form::Steps => {
                let steps = points(table.list(keys.steps)?, keys.step, TIME_ORDER)?;
                Schedule::steps(steps.into_iter().map(Into::into).collect())
            }
            Form::Sine => Some(sine(document.table(path), keys)?),
        };
        let place = || document.place_of([path]);
        Ok(Some(Self {
            schedule: schedule.ok_or_else(|| out_of_order(path, TIME_ORDER, place()))?,
            is_function: form != Form::Constant,
        }))
    }
}

/// Reads a sine. All its values must be in range, and it must be slow compared with the frames.
fn sine(table: Table<'_>, keys: &ScheduleKeys) -> Result<Schedule, SceneError> {
    let (word, value) = (keys.word, keys.curve.knot[1].kind);
    let [mean, amplitude, frequency, phase] = keys.sine;
    let sine = Sine {
        mean: table.get(mean)?,
        amplitude: table.get(amplitude)?,
        frequency: table.get(frequency)?,
        phase: table.get(phase)?,
    };
    // Rounded in the unit of the file, which removes conversion errors.
    let stated = |si: f64| (1e9 * value.unit.of_si(si)).round() / 1e9;
    for end in [sine.mean - sine.amplitude, sine.mean + sine.amplitude].map(stated) {
        ensure!(table, value.range.contains(end) => amplitude.name, &[mean.name];
            "the {word} reaches {end}";
            "reduce it; the {word} must be {}", value.expected());
    }
    let frame = Frames::read(table.document.table("time"))?.length();
    let fastest = 1.0 / (MIN_FRAMES_PER_PERIOD * frame);
    // A frequency at the limit is accepted in spite of rounding.
    ensure!(table,
        sine.frequency <= fastest * (1.0 + 1e-9) => frequency.name, &["time.sample_rate_khz", "time.frame_samples"];
        "the {word} is updated once per frame, every {} ms, which is too coarse for {} Hz", 1e3 * frame, sine.frequency;
        "reduce it to at most {fastest:.3} Hz, or reduce time.frame_samples");
    Schedule::sine(sine).ok_or_else(|| {
        table.inconsistent(
            mean.name,
            &[],
            "a parameter of the sine is not finite",
            "correct it",
        )
    })
}
