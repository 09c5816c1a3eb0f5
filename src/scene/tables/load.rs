//! Keys of the loading: load, tilt and rotation, each a constant or a function of time.

use super::knots::{KnotKeys, MAX_POINTS};
use crate::scene::schema::kind::Range::{Closed, Positive};
use crate::scene::schema::kind::{Choice, Flag, Number, Tables, Text, Vector, choice, number};
use crate::scene::schema::unit::{DEGREE, HERTZ, MILLISECOND, NEWTON, ONE, RADIAN_PER_SECOND};
use crate::scene::schema::{IfAbsent, Key, Schema, keys, split};
use crate::scene::subject::Carry;

/// Keys of a quantity that can be a function of time.
pub struct ScheduleKeys {
    /// Name of the quantity in messages.
    pub word: &'static str,
    /// Table of the quantity, and its knots: time and value.
    pub curve: KnotKeys,
    /// Key of the constant; the factor on the rotation has none.
    pub constant: Option<Key<Number>>,
    pub steps: &'static Key<Tables>,
    /// Time and value of a step.
    pub step: [&'static Key<Number>; 2],
    /// Mean, amplitude, frequency and phase of a sine.
    pub sine: [&'static Key<Number>; 4],
    /// Paths of the alternative forms.
    forms: [(Form, &'static str); 5],
}

/// Alternative forms of a quantity.
#[derive(Clone, Copy, PartialEq)]
pub enum Form {
    Constant,
    Knots,
    Steps,
    Sine,
    Csv,
}

/// Order of the knots and steps, for messages.
pub const TIME_ORDER: [&str; 2] = ["time", "later"];

const fn key<K: Copy>(
    name: &'static str,
    meaning: &'static str,
    kind: K,
    if_absent: IfAbsent,
) -> Key<K> {
    Key {
        name,
        meaning,
        kind,
        if_absent,
    }
}

/// Declares the keys of a quantity. `constant` is the meaning of the constant, if there is one; `given`
/// states how many forms a scene must contain.
macro_rules! schedule_keys {
    (
        $word:literal in $table:literal, $name:literal $suffix:literal, $title:literal: $value:expr;
        constant $constant:expr;
        knots $knots:literal;
        amplitude $amplitude:expr, $bound:literal;
        given $given:literal
    ) => {{
        use IfAbsent::{Default, Described, Required};
        const VALUE: Number = $value;
        const VALUE_NAME: &str = concat!($name, $suffix);
        const MOMENT: Number = number(MILLISECOND, Closed(0.0, 1e6));
        const PHASE: Number = number(DEGREE, Closed(-360.0, 360.0));
        const POINTS: Tables = Tables(MAX_POINTS);
        const FORM: IfAbsent = Described(concat!(
            $given, " `", $name, "`, `", $name, "_steps`, `", $name, "_sine` and `", $name, "_csv`"
        ));
        const CONSTANT: Option<&str> = $constant;
        ScheduleKeys {
            word: $word,
            curve: KnotKeys {
                table: $table,
                knots: &key($name, $knots, POINTS, FORM),
                knot: [
                    &key("time_ms", "Time of the knot; later than that of the previous knot.", MOMENT, Required),
                    &key(VALUE_NAME, concat!($title, " at this time."), VALUE, Required),
                ],
                csv: &key(
                    concat!($name, "_csv"),
                    concat!($title, " as knots from a CSV file, relative to the folder of the scene file: the line `time_ms,", $name, $suffix, "`, then one knot on each line."),
                    Text,
                    FORM,
                ),
                order: TIME_ORDER,
            },
            constant: match CONSTANT {
                Some(meaning) => Some(key(VALUE_NAME, meaning, VALUE, FORM)),
                None => None,
            },
            steps: &key(
                concat!($name, "_steps"),
                concat!($title, " as a step function: each value holds from its time on, the first value also before it. A frame ends exactly at each step."),
                POINTS,
                FORM,
            ),
            step: [
                &key("time_ms", "Time of the step; later than that of the previous step.", MOMENT, Required),
                &key(VALUE_NAME, concat!($title, " from this time on."), VALUE, Required),
            ],
            sine: [
                &key(
                    concat!("mean", $suffix),
                    "Mean of the sine `mean + amplitude sin(2 pi frequency t + phase)`.",
                    VALUE,
                    Required,
                ),
                &key(
                    concat!("amplitude", $suffix),
                    concat!("Amplitude of the sine", $bound, "."),
                    number(VALUE.unit, $amplitude),
                    Required,
                ),
                &key(
                    "frequency_hz",
                    "Frequency of the sine. The value is updated at the start of each frame (every 1.28 ms by default); a period must be at least 20 frames.",
                    number(HERTZ, Positive(1e5)),
                    Required,
                ),
                &key("phase_deg", "Phase of the sine at time 0.", PHASE, Default("0")),
            ],
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
    constant Some("Constant force that presses the ball into the socket.");
    knots "Load as a function of time: knots with linear interpolation, constant before the first and after the last. The value is updated at the start of each frame: every `time.frame_samples` samples, 1.28 ms by default.";
    amplitude Closed(0.0, 1e6), "; less than the mean";
    given "exactly one of `load_n`,"
};

/// Tilt, rad.
pub static TILT: ScheduleKeys = schedule_keys! {
    "tilt" in "load", "tilt" "_deg", "Tilt": number(DEGREE, Closed(-90.0, 90.0));
    constant Some("Constant tilt of the load relative to the axis of the beam.");
    knots "Tilt as a function of time: knots with linear interpolation, constant before the first and after the last. The value is updated at the start of each frame.";
    amplitude Closed(0.0, 90.0), "";
    given "exactly one of `tilt_deg`,"
};

/// Factor on the rotation. At 0 the ball is at rest, and the contact sticks; a negative one reverses the rotation.
pub static FACTOR: ScheduleKeys = schedule_keys! {
    "rotation" in "rotation", "factor" "", "Factor": number(ONE, Closed(-1000.0, 1000.0));
    constant None;
    knots "Factor on the angular velocity as a function of time: knots with linear interpolation, constant before the first and after the last. The value is updated at the start of each frame.";
    amplitude Closed(0.0, 1000.0), "";
    given "1 at all times; at most one of"
};

keys! {
    /// Azimuth of the tilt direction, from +x towards +y.
    static AZIMUTH: Number = "azimuth_deg": number(DEGREE, Closed(-360.0, 360.0)), default 0;

    /// Angular velocity vector of the ball, Omega of Eq. (4); not parallel to the load, where the centre of the patch would not slide. Zero is a joint at rest.
    static ROTATION: Vector = "angular_velocity_rad_per_s": Vector(number(RADIAN_PER_SECOND, Closed(-1e4, 1e4))),
        default [0.7071067811865476, 0.7071067811865476, 0];

    /// Whether the rotation moves the contact patch over the ball: the load has a fixed direction in the socket, so that the tilt, from the constant `load.tilt_deg` at the start, and the azimuth follow from the rotation. Otherwise the patch stays at the tilt whatever the rotation.
    static MOVES_PATCH: Flag = "moves_patch": Flag, default false;

    /// Whether the slip velocity includes the term Omega x u, the rotation of the vibration with the ball (a possible reading of Eq. (4)); its relative size is about 1e-4.
    static CONVECTION: Flag = "convection": Flag, default false;

    /// Part of the motion that a change of tilt, load or rotation carries over to the new equilibrium: the `perturbation` from it, so that a change excites nothing, or the `displacement`, so that a step excites an oscillation about the new equilibrium. The modal velocities are carried over in both cases.
    static CARRY: Choice<Carry> = "carry": choice::<Carry>(), default "perturbation";
}

pub fn declare(schema: &mut Schema) {
    LOAD.declare_forms(schema);
    TILT.declare_forms(schema);
    schema.add("load", &AZIMUTH);
    LOAD.declare_points(schema);
    TILT.declare_points(schema);
    schema.add("rotation", &ROTATION);
    FACTOR.declare_forms(schema);
    schema.add("rotation", &MOVES_PATCH);
    schema.add("rotation", &CONVECTION);
    FACTOR.declare_points(schema);
}

/// Whether a key belongs to a function of time and is not constant during a run.
pub fn is_schedule_key(path: &str) -> bool {
    let all = [&LOAD, &TILT, &FACTOR];
    let mut forms = all.into_iter().flat_map(ScheduleKeys::paths);
    forms.any(|form| form == split(path).0)
}

impl ScheduleKeys {
    fn declare_forms(&'static self, schema: &mut Schema) {
        let curve = &self.curve;
        if let Some(constant) = &self.constant {
            schema.add(curve.table, constant);
        }
        schema.add(curve.table, curve.knots);
        schema.add(curve.table, self.steps);
        schema.add(curve.table, curve.csv);
    }

    /// Declares the keys in the tables of the forms.
    fn declare_points(&'static self, schema: &mut Schema) {
        for (form, path) in self.forms {
            let keys: &[&'static Key<Number>] = match form {
                Form::Knots => &self.curve.knot,
                Form::Steps => &self.step,
                Form::Sine => &self.sine,
                Form::Constant | Form::Csv => &[],
            };
            keys.iter().for_each(|&key| schema.add(path, key));
        }
    }

    /// Alternative forms with their paths, the constant first.
    pub fn forms(&self) -> impl Iterator<Item = (Form, &'static str)> {
        let has_constant = self.constant.is_some();
        let forms = self.forms.into_iter();
        forms.filter(move |(form, _)| has_constant || *form != Form::Constant)
    }

    /// Paths of the alternative forms, the constant first.
    pub fn paths(&self) -> impl Iterator<Item = &'static str> {
        self.forms().map(|(_, path)| path)
    }
}
