//! Load, tilt and rotation, each a constant or a function of time in one of its forms.

use std::sync::LazyLock;

use super::Frames;
use super::knots::{Curve, MAX_POINTS};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schedule::{Schedule, Sine};
use crate::scene::schema::IfAbsent::{self, Described, Required};
use crate::scene::schema::kind::Range::{Closed, Positive};
use crate::scene::schema::kind::{Kind, choice, flag, number, tables, text, vector};
use crate::scene::schema::unit::*;
use crate::scene::schema::{Key, Schema, join, keys, split};
use crate::scene::subject::Carry;

/// Minimum number of frames in a period of a sine. The joint is constant within a frame; in a twentieth of a
/// period a sine changes by at most a third of its amplitude.
const MIN_FRAMES_PER_PERIOD: f64 = 20.0;

/// Keys of a quantity that can be a function of time.
pub struct ScheduleKeys {
    /// Name of the quantity in messages.
    pub word: &'static str,
    /// Path and key of the constant; the factor on the rotation has none.
    constant: Option<(&'static str, &'static Key<f64>)>,
    /// Knots: time and value.
    pub knots: Curve,
    /// Steps: time and value.
    steps: Curve,
    /// Mean, amplitude, frequency and phase of a sine.
    sine: [&'static Key<f64>; 4],
    /// Name of a CSV file with knots.
    pub csv: &'static Key<String>,
    /// Paths of the functions of time: knots, steps, sine, file.
    functions: [&'static str; 4],
}

/// A key whose texts are composed; it lives as long as the program, like all keys.
fn key<T>(name: &str, meaning: &str, kind: Kind<T>, if_absent: IfAbsent) -> &'static Key<T> {
    Box::leak(Box::new(Key {
        name: name.to_owned().leak(),
        meaning: meaning.to_owned().leak(),
        kind,
        if_absent,
        laws: &[],
    }))
}

impl ScheduleKeys {
    /// The keys `name`, `name_steps` and so on of a table, and of the constant with the given meaning.
    fn new(
        word: &'static str,
        [table, name, suffix]: [&'static str; 3],
        value: Kind<f64>,
        constant: Option<&str>,
    ) -> Self {
        let functions =
            ["", "_steps", "_sine", "_csv"].map(|form| &*format!("{table}.{name}{form}").leak());
        let [_, steps, sine, csv] = functions.map(|path| split(path).1);
        let value_name = format!("{name}{suffix}");
        let forms = format!("`{name}`, `{steps}`, `{sine}` and `{csv}`");
        let given = match constant {
            Some(_) => format!("exactly one of `{value_name}`, {forms}"),
            None => format!("1 at all times; at most one of {forms}"),
        };
        let form = Described(given.leak());
        let number_of = |name: &str, meaning: &str, kind: Kind<f64>| {
            key(&format!("{name}{suffix}"), meaning, kind, Required)
        };
        let curve = |list: &str, meaning: &str, at: &str| {
            let meaning = format!("The {word} as {meaning}");
            let value = number_of(name, &format!("The {word} {at} this time."), value);
            Curve {
                table,
                list: key(list, &meaning, tables(MAX_POINTS), form),
                point: [&TIME, value],
                order: ["time", "later"],
            }
        };
        let knots = "a function of time: knots with linear interpolation, constant before the first and after the last. \
             It is updated at the start of each frame: every `time.frame_samples` samples, 1.28 ms by default.";
        let file = format!(
            "The {word} as knots from a CSV file, relative to the folder of the scene file: the line \
             `time_ms,{value_name}`, then one knot on each line."
        );
        let jumps = "a step function: each value holds from its time on, the first value also before it. A frame ends exactly \
             at each step.";
        let mean = "Mean of the sine `mean + amplitude sin(2 pi frequency t + phase)`.";
        let amplitude = "Amplitude of the sine, all of whose values must be permitted.";
        let swing = number(value.limits.unit, Closed(0.0, 1e6));
        let constant = constant.map(|meaning| {
            let path = &*join(table, &value_name).leak();
            (path, key(&value_name, meaning, value, form))
        });
        Self {
            word,
            constant,
            knots: curve(name, knots, "at"),
            steps: curve(steps, jumps, "from"),
            sine: [
                number_of("mean", mean, value),
                number_of("amplitude", amplitude, swing),
                &FREQUENCY,
                &PHASE,
            ],
            csv: key(csv, &file, text(), form),
            functions,
        }
    }

    fn declare(&'static self, schema: &mut Schema) {
        let table = self.knots.table;
        if let Some((_, constant)) = self.constant {
            schema.add(table, constant);
        }
        self.knots.declare(schema);
        self.steps.declare(schema);
        schema.add(table, self.csv);
        for key in self.sine {
            schema.add(self.functions[2], key);
        }
    }

    /// Paths of the alternative forms, the constant first.
    pub fn paths(&self) -> Vec<&'static str> {
        let constant = self.constant.map(|(path, _)| path);
        constant.into_iter().chain(self.functions).collect()
    }

    /// Reads the quantity, and whether it is given as a function of time; `None` if the scene does not contain it.
    ///
    /// # Errors
    /// If it is given more than once, or its values are invalid.
    pub fn read(&self, document: &Document<'_>) -> Result<Option<(Schedule, bool)>, SceneError> {
        let mut given = self.paths().into_iter().filter(|path| document.has(path));
        let Some(path) = given.next() else {
            return Ok(None);
        };
        if let Some(again) = given.next() {
            let problem = format!("the scene gives the {} more than once", self.word);
            let remedy = format!("keep one of {path} and {again}");
            return Err(document.inconsistent(again, &[path], problem, remedy));
        }
        let [_, steps, sine, _] = self.functions;
        let constant = self.constant.filter(|(constant, _)| *constant == path);
        let schedule = if let Some((_, key)) = constant {
            Some(Schedule::constant(
                document.table(self.knots.table).get(key)?,
            ))
        } else if path == steps {
            Schedule::steps(self.steps.points(document)?)
        } else if path == sine {
            Schedule::sine(self.read_sine(document.table(path))?)
        } else {
            // A file has been replaced by its knots.
            Schedule::piecewise_linear(self.knots.points(document)?)
        };
        let schedule = schedule.expect("finite numbers, and times in order");
        Ok(Some((schedule, constant.is_none())))
    }

    /// Reads a sine. All its values must be in range, and it must be slow compared with the frames.
    fn read_sine(&self, table: Table<'_>) -> Result<Sine, SceneError> {
        let (word, value) = (self.word, self.knots.point[1].kind.limits);
        let [mean, amplitude, frequency, phase] = self.sine;
        let sine = Sine {
            mean: table.get(mean)?,
            amplitude: table.get(amplitude)?,
            frequency: table.get(frequency)?,
            phase: table.get(phase)?,
        };
        // Rounded in the unit of the file, which removes conversion errors.
        let stated = |si: f64| (1e9 * (si / value.unit.to_si(1.0))).round() / 1e9;
        for end in [sine.mean - sine.amplitude, sine.mean + sine.amplitude].map(stated) {
            ensure!(table, value.range.contains(end) => amplitude.name, &[mean.name];
                "the {word} reaches {end}";
                "reduce it; the {word} must be {}", value.expected());
        }
        let frames = Frames::read(table.document.table("time"))?;
        let frame = frames.frame_samples as f64 / frames.sample_rate;
        let fastest = 1.0 / (MIN_FRAMES_PER_PERIOD * frame);
        // A frequency at the limit is accepted in spite of rounding.
        ensure!(table,
            sine.frequency <= fastest * (1.0 + 1e-9) => frequency.name, &["time.sample_rate_khz", "time.frame_samples"];
            "the {word} is updated once per frame, every {} ms, which is too coarse for {} Hz", 1e3 * frame, sine.frequency;
            "reduce it to at most {fastest:.3} Hz, or reduce time.frame_samples");
        Ok(sine)
    }
}

/// Load, N.
pub static LOAD: LazyLock<ScheduleKeys> = LazyLock::new(|| {
    let meaning = "Constant force that presses the ball into the socket.";
    let value = number(NEWTON, Positive(1e6));
    ScheduleKeys::new("load", ["load", "load", "_n"], value, Some(meaning))
});

/// Tilt, rad.
pub static TILT: LazyLock<ScheduleKeys> = LazyLock::new(|| {
    let meaning = "Constant tilt of the load relative to the axis of the beam.";
    let value = number(DEGREE, Closed(-90.0, 90.0));
    ScheduleKeys::new("tilt", ["load", "tilt", "_deg"], value, Some(meaning))
});

/// Factor on the rotation. At 0 the ball is at rest, and the contact sticks; a negative one reverses the rotation.
pub static FACTOR: LazyLock<ScheduleKeys> = LazyLock::new(|| {
    let value = number(ONE, Closed(-1000.0, 1000.0));
    ScheduleKeys::new("rotation", ["rotation", "factor", ""], value, None)
});

/// The quantities that can be functions of time.
pub fn schedules() -> [&'static ScheduleKeys; 3] {
    [&LOAD, &TILT, &FACTOR]
}

/// Range of components of an angular velocity.
pub const SPIN: Kind<f64> = number(RADIAN_PER_SECOND, Closed(-1e4, 1e4));

keys! {
    /// Time of the point; later than that of the previous one.
    static TIME: f64 = "time_ms": number(MILLISECOND, Closed(0.0, 1e6));
    /// Frequency of the sine. The value is updated at the start of each frame; a period must be at least 20 frames.
    static FREQUENCY: f64 = "frequency_hz": number(HERTZ, Positive(1e5));
    /// Phase of the sine at time 0.
    static PHASE: f64 = "phase_deg": number(DEGREE, Closed(-360.0, 360.0)), default 0;

    /// Azimuth of the tilt direction, from +x towards +y.
    static AZIMUTH: f64 = "azimuth_deg": number(DEGREE, Closed(-360.0, 360.0)), default 0;

    /// Angular velocity vector of the ball, Omega of Eq. (4); not parallel to the load, where the centre of the patch would not slide. Zero is a joint at rest.
    static ROTATION: [f64; 3] = "angular_velocity_rad_per_s": vector(SPIN),
        default [0.7071067811865476, 0.7071067811865476, 0];

    /// Whether the rotation moves the contact patch over the ball: the load has a fixed direction in the socket, so that the tilt, from the constant `load.tilt_deg` at the start, and the azimuth follow from the rotation. Otherwise the patch stays at the tilt whatever the rotation.
    static MOVES_PATCH: bool = "moves_patch": flag(), default false;

    /// Whether the slip velocity includes the term Omega x u, the rotation of the vibration with the ball (a possible reading of Eq. (4)); its relative size is about 1e-4.
    static CONVECTION: bool = "convection": flag(), default false;

    /// Part of the motion that a change of tilt, load or rotation carries over to the new equilibrium: the `perturbation` from it, so that a change excites nothing, or the `displacement`, so that a step excites an oscillation about the new equilibrium. The modal velocities are carried over in both cases.
    static CARRY: Carry = "carry": choice::<Carry>(), default "perturbation";
}

pub fn declare(schema: &mut Schema) {
    LOAD.declare(schema);
    TILT.declare(schema);
    schema.add("load", &AZIMUTH);
    schema.add("rotation", &ROTATION);
    FACTOR.declare(schema);
    schema.add("rotation", &MOVES_PATCH);
    schema.add("rotation", &CONVECTION);
}

/// The path of the constant that a list of knots replaces: `load.tilt_deg` for `load.tilt`.
pub fn constant_of(knots: &str) -> Option<&'static str> {
    let mut all = schedules().into_iter();
    let (path, _) = all.find(|keys| keys.functions[0] == knots)?.constant?;
    Some(path)
}

/// Whether a key belongs to a function of time and is not constant during a run.
pub fn is_schedule_key(path: &str) -> bool {
    let mut forms = schedules().into_iter().flat_map(ScheduleKeys::paths);
    forms.any(|form| form == split(path).0)
}
