//! The keys of what acts on the joint: load, tilt and rotation, each a constant or a function of time.

use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::schema::kind::Range::{Closed, Positive};
use crate::scene::schema::kind::{Flag, Number, Tables, Text, Vector, number};
use crate::scene::schema::unit::{DEGREE, HERTZ, MILLISECOND, NEWTON, ONE, RADIAN_PER_SECOND};
use crate::scene::schema::{Key, Otherwise, Schema, keys, split};

/// The most knots or steps.
pub const MOST_POINTS: usize = 10_000;

/// The keys of a quantity that can be a function of time.
pub struct ScheduleKeys {
    /// The quantity in a word.
    pub word: &'static str,
    /// The table that has it.
    pub table: &'static str,
    /// Its constant; the factor on the rotation has none.
    pub constant: Option<Key<Number>>,
    pub knots: Key<Tables>,
    /// Time and value of a knot.
    pub knot: [Key<Number>; 2],
    pub steps: Key<Tables>,
    /// Time and value of a step.
    pub step: [Key<Number>; 2],
    /// Mean, amplitude, frequency and phase of a sine.
    pub sine: [Key<Number>; 4],
    /// A file of knots.
    pub csv: Key<Text>,
    /// The forms in which it can be given, by their paths.
    forms: [(Form, &'static str); 5],
}

/// The forms in which a quantity can be given.
#[derive(Clone, Copy, PartialEq)]
pub enum Form {
    Constant,
    Knots,
    Steps,
    Sine,
    Csv,
}

const fn key<K: Copy>(
    name: &'static str,
    meaning: &'static str,
    kind: K,
    otherwise: Otherwise,
) -> Key<K> {
    Key {
        name,
        meaning,
        kind,
        otherwise,
    }
}

/// Declares the keys of a quantity: `constant` is the meaning of a constant, if it has one, and `given` says
/// how many of its forms there must be.
macro_rules! schedule_keys {
    (
        $word:literal in $table:literal, $name:literal $suffix:literal, $title:literal: $value:expr;
        constant $constant:expr;
        knots $knots:literal;
        amplitude $amplitude:expr, $bound:literal;
        given $given:literal
    ) => {{
        use Otherwise::{Default, Else, Required};
        const VALUE: Number = $value;
        const VALUE_NAME: &str = concat!($name, $suffix);
        const MOMENT: Number = number(MILLISECOND, Closed(0.0, 1e6));
        const PHASE: Number = number(DEGREE, Closed(-360.0, 360.0));
        const POINTS: Tables = Tables(MOST_POINTS);
        const FORM: Otherwise = Else(concat!(
            $given, " `", $name, "`, `", $name, "_steps`, `", $name, "_sine` and `", $name, "_csv`"
        ));
        const CONSTANT: Option<&str> = $constant;
        ScheduleKeys {
            word: $word,
            table: $table,
            constant: match CONSTANT {
                Some(meaning) => Some(key(VALUE_NAME, meaning, VALUE, FORM)),
                None => None,
            },
            knots: key($name, $knots, POINTS, FORM),
            knot: [
                key("time_ms", "Time of the knot; later than the one before.", MOMENT, Required),
                key(VALUE_NAME, concat!($title, " at that time."), VALUE, Required),
            ],
            steps: key(
                concat!($name, "_steps"),
                "The same in steps: each value from its time on, the first one before it as well. The joint changes exactly there.",
                POINTS,
                FORM,
            ),
            step: [
                key("time_ms", "Time of the step; later than the one before.", MOMENT, Required),
                key(VALUE_NAME, concat!($title, " from that time on."), VALUE, Required),
            ],
            sine: [
                key(
                    concat!("mean", $suffix),
                    concat!($title, " that it swings about; a sine is `mean + amplitude sin(2 pi frequency t + phase)`."),
                    VALUE,
                    Required,
                ),
                key(
                    concat!("amplitude", $suffix),
                    concat!("How far it goes from there", $bound, "."),
                    number(VALUE.unit, $amplitude),
                    Required,
                ),
                key(
                    "frequency_hz",
                    "Frequency; the sine is looked at where a frame starts (every 1.28 ms by default), and a period is at least 20 frames.",
                    number(HERTZ, Positive(1e5)),
                    Required,
                ),
                key("phase_deg", "Phase at time 0.", PHASE, Default("0")),
            ],
            csv: key(
                concat!($name, "_csv"),
                concat!("The same as knots from a CSV file, named from the scene file's folder: a line `time_ms,", $name, $suffix, "`, then a knot a line."),
                Text,
                FORM,
            ),
            forms: [
                (Form::Constant, concat!($table, ".", $name, $suffix)),
                (Form::Knots, concat!($table, ".", $name)),
                (Form::Steps, concat!($table, ".", $name, "_steps")),
                (Form::Sine, concat!($table, ".", $name, "_sine")),
                (Form::Csv, concat!($table, ".", $name, "_csv")),
            ],
        }
    }};
}

/// Load, N.
pub static LOAD: ScheduleKeys = schedule_keys! {
    "load" in "load", "load" "_n", "Load": number(NEWTON, Positive(1e6));
    constant Some("Force that presses the ball into the socket, constant in time.");
    knots "The same as a function of time instead: knots, straight lines between them, constant outside. Looked at where a frame starts: every `time.frame_samples` samples, 1.28 ms by default.";
    amplitude Closed(0.0, 1e6), "; smaller than the mean";
    given "exactly one of `load_n`,"
};

/// Tilt, rad.
pub static TILT: ScheduleKeys = schedule_keys! {
    "tilt" in "load", "tilt" "_deg", "Tilt": number(DEGREE, Closed(-90.0, 90.0));
    constant Some("Tilt of the load against the beam's axis, constant in time.");
    knots "Tilt as a function of time instead: knots, straight lines between them, constant outside. Looked at where a frame starts, like all such knots.";
    amplitude Closed(0.0, 90.0), "";
    given "exactly one of `tilt_deg`,"
};

/// Factor on the rotation. At 0 the ball stands still, and the contact sticks.
pub static FACTOR: ScheduleKeys = schedule_keys! {
    "rotation" in "rotation", "factor" "", "Factor": number(ONE, Closed(0.0, 1000.0));
    constant None;
    knots "Factor on the rotation vector as a function of time: knots, straight lines between them, constant outside. Looked at where a frame starts, like all such knots.";
    amplitude Closed(0.0, 1000.0), "; at most the mean";
    given "1 at all times; at most one of"
};

keys! {
    /// Direction of the tilt: from +x towards +y.
    static AZIMUTH: Number = "azimuth_deg": number(DEGREE, Closed(-360.0, 360.0)), default 0;

    /// Rotation vector of the ball, Omega of Eq. (4); not along the load, where the middle of the patch would not slide. Zero is a joint at rest.
    static ROTATION: Vector = "rad_s": Vector(number(RADIAN_PER_SECOND, Closed(-1e4, 1e4))),
        default [0.7071067811865476, 0.7071067811865476, 0];

    /// Whether the turning of the vibration with the ball, Omega x u, is part of the slip velocity, as Eq. (4) can be read; about 1e-4 of the rest.
    static CONVECTION: Flag = "convection": Flag, default false;
}

pub fn declare(schema: &mut Schema) {
    LOAD.declare_forms(schema);
    TILT.declare_forms(schema);
    schema.add("load", &AZIMUTH);
    LOAD.declare_points(schema);
    TILT.declare_points(schema);
    schema.add("rotation", &ROTATION);
    FACTOR.declare_forms(schema);
    schema.add("rotation", &CONVECTION);
    FACTOR.declare_points(schema);
}

/// Whether a key is part of a function of time, not a value for a whole run.
pub fn is_of_a_schedule(path: &str) -> bool {
    let all = [&LOAD, &TILT, &FACTOR];
    let mut forms = all.into_iter().flat_map(ScheduleKeys::paths);
    forms.any(|form| form == split(path).0)
}

impl ScheduleKeys {
    fn declare_forms(&'static self, schema: &mut Schema) {
        if let Some(constant) = &self.constant {
            schema.add(self.table, constant);
        }
        schema.add(self.table, &self.knots);
        schema.add(self.table, &self.steps);
        schema.add(self.table, &self.csv);
    }

    /// Declares the keys in the tables of its forms.
    fn declare_points(&'static self, schema: &mut Schema) {
        for (form, path) in self.forms {
            let keys: &[Key<Number>] = match form {
                Form::Knots => &self.knot,
                Form::Steps => &self.step,
                Form::Sine => &self.sine,
                Form::Constant | Form::Csv => &[],
            };
            keys.iter().for_each(|key| schema.add(path, key));
        }
    }

    /// Its forms and their paths, the constant first.
    pub fn forms(&self) -> impl Iterator<Item = (Form, &'static str)> {
        let has_constant = self.constant.is_some();
        let forms = self.forms.into_iter();
        forms.filter(move |(form, _)| has_constant || *form != Form::Constant)
    }

    /// The paths of its forms, the constant first.
    pub fn paths(&self) -> impl Iterator<Item = &'static str> {
        self.forms().map(|(_, path)| path)
    }
}

/// The error of a point that is not later than the one before.
pub fn out_of_order(time: &str, place: Place) -> SceneError {
    let problem = "this time is not later than the one before";
    Fault::inconsistent(time, problem, "put the times in order, each once").at(place)
}
