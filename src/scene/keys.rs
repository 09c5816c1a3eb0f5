//! Every key of a scene file, once: path, meaning, kind, unit, range and default.
//!
//! The reader, the error messages and the tables of the guide all come from this list, so they
//! cannot disagree.

use crate::analysis::{Direction, Norm};
use crate::fem::{Elements, LengthReading};
use crate::joint::{Frequencies, Quadrature, StiffnessLaw};

use super::kind::{
    AllOr, AutoOr, Choice, Coordinates, Count, Flag, Kind, List, Number, OneOrMany, Range, Seed,
    Tables, Text, Vector,
};
use super::mechanism::Mechanism;
use super::spec::{Events, Method};
use super::units::Unit;

/// One key of a scene file.
pub(super) struct Key<K> {
    /// Dotted path from the top of the file.
    pub path: &'static str,
    /// What it is, for the guide.
    pub meaning: &'static str,
    /// What it can be.
    pub kind: K,
    /// What holds if it is not given.
    pub otherwise: Otherwise,
}

impl<K> Key<K> {
    /// The key's own name, the last part of its path.
    pub fn name(&self) -> &'static str {
        split(self.path).1
    }
}

/// The table and the name of a dotted path.
pub(super) fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// What holds if a key is not given.
#[derive(Clone, Copy, Debug)]
pub(super) enum Otherwise {
    /// The scene is refused.
    Required,
    /// A value, written as it would be in the file.
    Default(&'static str),
    /// Something else, said here in words for the guide.
    Else(&'static str),
}

/// What is known of a key whatever its kind.
pub(super) trait Entry: Sync {
    /// Dotted path from the top of the file.
    fn path(&self) -> &'static str;
    /// What it is, in a sentence.
    fn meaning(&self) -> &'static str;
    /// The symbol of the unit in which it is stated; empty for a pure number and what is none.
    fn unit_symbol(&self) -> &'static str;
    /// Whether one number is a value of it.
    fn is_number(&self) -> bool;
    /// The key's row in the guide's table (Markdown).
    fn guide_row(&self) -> String;
}

impl<K: Kind> Entry for Key<K> {
    fn path(&self) -> &'static str {
        self.path
    }

    fn meaning(&self) -> &'static str {
        self.meaning
    }

    fn unit_symbol(&self) -> &'static str {
        self.kind.unit().symbol()
    }

    fn is_number(&self) -> bool {
        K::IS_NUMBER
    }

    fn guide_row(&self) -> String {
        let otherwise = match self.otherwise {
            Otherwise::Required => "required".to_owned(),
            Otherwise::Default(literal) => format!("`{literal}`"),
            Otherwise::Else(words) => words.to_owned(),
        };
        format!(
            "| `{}` | {} | {} | {} | {otherwise} |",
            self.name(),
            self.meaning,
            self.kind.unit().symbol(),
            self.kind.allowed()
        )
    }
}

/// All keys with meaning, unit, allowed values and default: Markdown, a table for each table of
/// a scene file.
pub fn key_reference() -> String {
    let mut reference = String::new();
    let mut table = None;
    for key in ALL {
        let (here, _) = split(key.path());
        if table != Some(here) {
            table = Some(here);
            let heading = match here {
                "" => "Top level".to_owned(),
                // A table that is a key as well is a list of tables.
                here if ALL.iter().any(|key| key.path() == here) => format!("`[[{here}]]`"),
                here => format!("`[{here}]`"),
            };
            reference.push_str(&format!(
                "\n## {heading}\n\n| key | meaning | unit | value | default |\n|---|---|---|---|---|\n"
            ));
        }
        reference.push_str(&key.guide_row());
        reference.push('\n');
    }
    reference
}

/// Defines the keys, and [`ALL`] of them in one list.
macro_rules! keys {
    ($( #[doc = $meaning:literal] $name:ident: $kind:ty = $path:literal, $otherwise:expr, $spec:expr; )*) => {
        $(
            #[doc = $meaning]
            pub(super) static $name: Key<$kind> = Key {
                path: $path,
                meaning: $meaning.trim_ascii(),
                kind: $spec,
                otherwise: $otherwise,
            };
        )*
        /// All keys, in the order of the guide.
        pub(super) static ALL: &[&dyn Entry] = &[$( &$name ),*];
    };
}

const fn number(unit: Unit, range: Range) -> Number {
    Number { unit, range }
}

/// What every delay must be.
const LAG: Number = number(Microsecond, Range::Closed(0.5, 1e6));

/// What every embedding dimension must be.
const DIMENSION: Count = Count { min: 1, max: 20 };

/// What a natural frequency of a small system must be.
const FREQUENCY: Number = number(Hertz, Range::Positive(1e5));

/// What a damping ratio must be.
const RATIO: Number = number(One, Range::HalfOpen(0.0, 1.0));

/// What the drive of a small system must be.
const DRIVE: Number = number(MetrePerSecondSquared, Range::Closed(0.0, 1e6));

/// What the frequency of that drive must be.
const DRIVE_FREQUENCY: Number = number(Hertz, Range::Closed(0.0, 1e5));

/// What a place on the line of a small system must be.
const PLACE: Number = number(Micrometre, Range::Closed(-1e6, 1e6));

/// What a time in a function of time must be.
const MOMENT: Number = number(Millisecond, Range::Closed(0.0, 1e6));

/// How many knots or steps a function of time has.
const POINTS: Tables = Tables { max: MOST_POINTS };

/// The most knots or steps.
pub(super) const MOST_POINTS: usize = 10_000;

/// What a load must be.
const FORCE: Number = number(Newton, Range::Positive(1e6));

/// What a tilt must be.
const ANGLE: Number = number(Degree, Range::Closed(-90.0, 90.0));

/// What a factor on the rotation must be. At 0 the ball stands still, and the contact sticks.
const FACTOR: Number = number(One, Range::Closed(0.0, 1000.0));

/// What the frequency of a sine must be, whatever the frames.
const SINE_FREQUENCY: Number = number(Hertz, Range::Positive(1e5));

/// What the phase of a sine must be.
const PHASE: Number = number(Degree, Range::Closed(-360.0, 360.0));

/// The forms of the load exclude one another.
const ONE_LOAD: Otherwise =
    Else("exactly one of `load_n`, `load`, `load_steps`, `load_sine` and `load_csv`");

/// The forms of the tilt exclude one another.
const ONE_TILT: Otherwise =
    Else("exactly one of `tilt_deg`, `tilt`, `tilt_steps`, `tilt_sine` and `tilt_csv`");

/// The forms of the factor on the rotation exclude one another.
const ONE_FACTOR: Otherwise =
    Else("1 at all times; at most one of `factor`, `factor_steps`, `factor_sine` and `factor_csv`");

/// The norms by name.
const NORM: Choice<Norm> = Choice {
    options: &[
        ("euclidean", Norm::Euclidean),
        ("maximum", Norm::Maximum),
        ("manhattan", Norm::Manhattan),
    ],
};

/// The mechanisms by name.
static MECHANISMS: [(&str, Mechanism); Mechanism::ALL.len()] = {
    let mut named = [("", Mechanism::NegativeSlope); Mechanism::ALL.len()];
    let mut k = 0;
    while k < named.len() {
        named[k] = (Mechanism::ALL[k].name(), Mechanism::ALL[k]);
        k += 1;
    }
    named
};

/// The four thresholds of one table exclude one another.
const ONE_THRESHOLD: Otherwise =
    Else("exactly one of `threshold_rate`, `threshold_um`, `threshold_spread` and `neighbours`");

use Otherwise::{Default, Else, Required};
use Unit::{
    Degree, Gigapascal, Hertz, KilogramPerCubicMetre, Kilohertz, MetrePerSecondSquared, Micrometre,
    Microsecond, Millimetre, MillimetrePerSecond, Millisecond, Newton, NewtonPerKilogram, One,
    RadianPerSecond, SecondPerMetre,
};

keys! {
    /// Name of the scene.
    NAME: Text = "name", Else("the file's name"), Text;
    /// One line that says what the scene shows.
    TITLE: Text = "title", Else("the name"), Text;
    /// A few sentences (Markdown) on what to look for.
    ABOUT: Text = "about", Else("empty"), Text;
    /// The mechanism that the scene shows: a lesson explains it, with numbers measured in the run, beside the picture that proves it (guide `mechanisms`).
    MECHANISM: Choice<Mechanism> = "mechanism", Else("no lesson"), Choice { options: &MECHANISMS };

    /// File (.npz) of modes and contact patch from another finite-element program, from the folder of the scene file; excludes every other key of `[body]`, `[socket]` and what lays out the patch.
    MODES: Text = "body.modes", Else("ball and beam as below"), Text;
    /// Diameter of the ball; smaller than the socket's.
    BALL_DIAMETER: Number = "body.ball_diameter_mm", Default("31.75"),
        number(Millimetre, Range::Closed(1.0, 500.0));
    /// Diameter of the beam; smaller than the ball's.
    BEAM_DIAMETER: Number = "body.beam_diameter_mm", Default("20"),
        number(Millimetre, Range::Closed(0.5, 500.0));
    /// Length of the beam.
    BEAM_LENGTH: Number = "body.beam_length_mm", Default("200"),
        number(Millimetre, Range::Closed(1.0, 5000.0));
    /// Where that length ends: where beam and sphere meet, or at the ball's centre.
    BEAM_REACHES: Choice<LengthReading> = "body.beam_reaches", Default("\"sphere\""),
        Choice { options: &[("sphere", LengthReading::ToSphere), ("centre", LengthReading::ToCentre)] };
    /// Young's modulus of ball and beam.
    BODY_YOUNG: Number = "body.young_gpa", Default("207"),
        number(Gigapascal, Range::Closed(0.001, 2000.0));
    /// Poisson's ratio of ball and beam.
    BODY_POISSON: Number = "body.poisson", Default("0.30"), number(One, Range::Open(-1.0, 0.5));
    /// Density of ball and beam.
    DENSITY: Number = "body.density_kg_m3", Default("7800"),
        number(KilogramPerCubicMetre, Range::Closed(10.0, 30_000.0));
    /// Longest edge of the finite elements.
    ELEMENT_SIZE: Number = "body.element_size_mm", Default("16.0"),
        number(Millimetre, Range::Closed(0.1, 100.0));
    /// Polynomial order of the finite elements: 1 linear (these lock in bending), 2 quadratic, 3 cubic and so on.
    ELEMENT_ORDER: Count = "body.element_order", Default("4"),
        Count { min: *Elements::ORDERS.start() as u32, max: *Elements::ORDERS.end() as u32 };
    /// Natural frequencies: the seven of Fig. 2 of the paper, or the finite-element model's own.
    FREQUENCIES: Choice<Frequencies> = "body.frequencies", Default("\"published\""),
        Choice { options: &[("published", Frequencies::Published), ("fe", Frequencies::FiniteElement)] };
    /// Bending pairs that take part, from the lowest up; each gives two modes.
    BENDING_PAIRS: Count = "body.bending_pairs", Default("4"), Count { min: 0, max: 50 };
    /// Torsion modes that take part, from the lowest up.
    TORSION: Count = "body.torsion", Default("2"), Count { min: 0, max: 50 };
    /// Axial modes that take part, from the lowest up.
    AXIAL: Count = "body.axial", Default("1"), Count { min: 0, max: 50 };

    /// Diameter of the socket; larger than the ball's.
    SOCKET_DIAMETER: Number = "socket.diameter_mm", Default("31.95"),
        number(Millimetre, Range::Closed(1.0, 1000.0));
    /// Young's modulus of the socket.
    SOCKET_YOUNG: Number = "socket.young_gpa", Default("70"),
        number(Gigapascal, Range::Closed(0.001, 2000.0));
    /// Poisson's ratio of the socket.
    SOCKET_POISSON: Number = "socket.poisson", Default("0.33"), number(One, Range::Open(-1.0, 0.5));

    /// Force that presses the ball into the socket, constant in time.
    LOAD: Number = "load.load_n", ONE_LOAD, FORCE;
    /// The same as a function of time instead: knots, straight lines between them, constant outside. Looked at where a frame starts: every `time.frame_samples` samples, 1.28 ms by default.
    LOAD_KNOTS: Tables = "load.load", ONE_LOAD, POINTS;
    /// The same in steps: each value from its time on, the first one before it as well. The joint changes exactly there.
    LOAD_STEPS: Tables = "load.load_steps", ONE_LOAD, POINTS;
    /// The same as knots from a CSV file, named from the scene file's folder: a line `time_ms,load_n`, then a knot a line.
    LOAD_CSV: Text = "load.load_csv", ONE_LOAD, Text;
    /// Tilt of the load against the beam's axis, constant in time.
    TILT: Number = "load.tilt_deg", ONE_TILT, ANGLE;
    /// Tilt as a function of time instead: knots, straight lines between them, constant outside. Looked at where a frame starts, like all such knots.
    TILT_KNOTS: Tables = "load.tilt", ONE_TILT, POINTS;
    /// The same in steps: each value from its time on, the first one before it as well. The joint changes exactly there.
    TILT_STEPS: Tables = "load.tilt_steps", ONE_TILT, POINTS;
    /// The same as knots from a CSV file, named from the scene file's folder: a line `time_ms,tilt_deg`, then a knot a line.
    TILT_CSV: Text = "load.tilt_csv", ONE_TILT, Text;
    /// Direction of the tilt: from +x towards +y.
    AZIMUTH: Number = "load.azimuth_deg", Default("0"),
        number(Degree, Range::Closed(-360.0, 360.0));

    /// Time of the knot; later than the one before.
    LOAD_KNOT_TIME: Number = "load.load.time_ms", Required, MOMENT;
    /// Load at that time.
    LOAD_KNOT: Number = "load.load.load_n", Required, FORCE;

    /// Time of the step; later than the one before.
    LOAD_STEP_TIME: Number = "load.load_steps.time_ms", Required, MOMENT;
    /// Load from that time on.
    LOAD_STEP: Number = "load.load_steps.load_n", Required, FORCE;

    /// Load that it swings about; a sine is `mean + amplitude sin(2 pi frequency t + phase)`.
    LOAD_MEAN: Number = "load.load_sine.mean_n", Required, FORCE;
    /// How far it goes from there; smaller than the mean.
    LOAD_AMPLITUDE: Number = "load.load_sine.amplitude_n", Required, number(Newton, Range::Closed(0.0, 1e6));
    /// Frequency; the sine is looked at where a frame starts (every 1.28 ms by default), and a period is at least 20 frames.
    LOAD_FREQUENCY: Number = "load.load_sine.frequency_hz", Required, SINE_FREQUENCY;
    /// Phase at time 0.
    LOAD_PHASE: Number = "load.load_sine.phase_deg", Default("0"), PHASE;

    /// Time of the knot; later than the one before.
    TILT_KNOT_TIME: Number = "load.tilt.time_ms", Required, MOMENT;
    /// Tilt at that time.
    TILT_KNOT: Number = "load.tilt.tilt_deg", Required, ANGLE;

    /// Time of the step; later than the one before.
    TILT_STEP_TIME: Number = "load.tilt_steps.time_ms", Required, MOMENT;
    /// Tilt from that time on.
    TILT_STEP: Number = "load.tilt_steps.tilt_deg", Required, ANGLE;

    /// Tilt that it swings about; a sine is `mean + amplitude sin(2 pi frequency t + phase)`.
    TILT_MEAN: Number = "load.tilt_sine.mean_deg", Required, ANGLE;
    /// How far it goes from there.
    TILT_AMPLITUDE: Number = "load.tilt_sine.amplitude_deg", Required, number(Degree, Range::Closed(0.0, 90.0));
    /// Frequency; the sine is looked at where a frame starts (every 1.28 ms by default), and a period is at least 20 frames.
    TILT_FREQUENCY: Number = "load.tilt_sine.frequency_hz", Required, SINE_FREQUENCY;
    /// Phase at time 0.
    TILT_PHASE: Number = "load.tilt_sine.phase_deg", Default("0"), PHASE;

    /// Rotation vector of the ball, Omega of Eq. (4); not along the load, where the middle of the patch would not slide. Zero is a joint at rest.
    ROTATION: Vector = "rotation.rad_s", Default("[0.7071067811865476, 0.7071067811865476, 0]"),
        Vector { component: number(RadianPerSecond, Range::Closed(-1e4, 1e4)) };
    /// Factor on the rotation vector as a function of time: knots, straight lines between them, constant outside. Looked at where a frame starts, like all such knots.
    FACTOR_KNOTS: Tables = "rotation.factor", ONE_FACTOR, POINTS;
    /// The same in steps: each value from its time on, the first one before it as well. The joint changes exactly there.
    FACTOR_STEPS: Tables = "rotation.factor_steps", ONE_FACTOR, POINTS;
    /// The same as knots from a CSV file, named from the scene file's folder: a line `time_ms,factor`, then a knot a line.
    FACTOR_CSV: Text = "rotation.factor_csv", ONE_FACTOR, Text;
    /// Whether the turning of the vibration with the ball, Omega x u, is part of the slip velocity, as Eq. (4) can be read; about 1e-4 of the rest.
    CONVECTION: Flag = "rotation.convection", Default("false"), Flag;

    /// Time of the knot; later than the one before.
    FACTOR_KNOT_TIME: Number = "rotation.factor.time_ms", Required, MOMENT;
    /// Factor at that time.
    FACTOR_KNOT: Number = "rotation.factor.factor", Required, FACTOR;

    /// Time of the step; later than the one before.
    FACTOR_STEP_TIME: Number = "rotation.factor_steps.time_ms", Required, MOMENT;
    /// Factor from that time on.
    FACTOR_STEP: Number = "rotation.factor_steps.factor", Required, FACTOR;

    /// Factor that it swings about; a sine is `mean + amplitude sin(2 pi frequency t + phase)`.
    FACTOR_MEAN: Number = "rotation.factor_sine.mean", Required, FACTOR;
    /// How far it goes from there; at most the mean.
    FACTOR_AMPLITUDE: Number = "rotation.factor_sine.amplitude", Required, number(One, Range::Closed(0.0, 1000.0));
    /// Frequency; the sine is looked at where a frame starts (every 1.28 ms by default), and a period is at least 20 frames.
    FACTOR_FREQUENCY: Number = "rotation.factor_sine.frequency_hz", Required, SINE_FREQUENCY;
    /// Phase at time 0.
    FACTOR_PHASE: Number = "rotation.factor_sine.phase_deg", Default("0"), PHASE;

    /// Number of contact nodes.
    NODES: Count = "contact.nodes", Default("100"), Count { min: 1, max: 10_000 };
    /// Where the nodes are: rings of cells, or a Gauss rule in the weight of the Hertz pressure.
    QUADRATURE: Choice<Quadrature> = "contact.quadrature", Default("\"rings\""),
        Choice { options: &[("rings", Quadrature::Rings), ("gauss", Quadrature::Gauss)] };
    /// Factor on the Hertz contact stiffness 2 E\* a / (pi a^2).
    STIFFNESS_FACTOR: Number = "contact.stiffness_factor", Default("1.0"),
        number(One, Range::Positive(1e4));
    /// How the stiffness is spread over the patch: evenly, or like the pre-stress.
    STIFFNESS: Choice<StiffnessLaw> = "contact.stiffness", Default("\"uniform\""),
        Choice { options: &[("uniform", StiffnessLaw::Uniform), ("pre-stress", StiffnessLaw::LikePreStress)] };
    /// Factor on the Hertz radius of the patch; load and total stiffness are kept.
    RADIUS_FACTOR: Number = "contact.radius_factor", Default("1.0"),
        number(One, Range::Closed(0.1, 5.0));
    /// Whether contact nodes can lift off, Eq. (2).
    UNILATERAL: Flag = "contact.unilateral", Default("true"), Flag;

    /// Damping of the contact: a dashpot beside each node's spring, whose force jumps at lift-off, where steps then end whatever `time.events` says; or one in proportion to the spring's stress, which lets go smoothly.
    DAMPING_LAW: Choice<DampingLaw> = "contact_damping.law", Required,
        Choice { options: &[("kelvin-voigt", DampingLaw::KelvinVoigt), ("hunt-crossley", DampingLaw::HuntCrossley)] };
    /// Retardation time of the dashpot, its viscosity by the contact stiffness.
    RETARDATION: Number = "contact_damping.retardation_time_us", Else("required with `kelvin-voigt`"),
        number(Microsecond, Range::Positive(1e4));
    /// Dissipation `chi`: the stress is that of the spring times 1 + chi du_r/dt.
    DISSIPATION: Number = "contact_damping.dissipation_s_per_m", Else("required with `hunt-crossley`"),
        number(SecondPerMetre, Range::Positive(100.0));

    /// The law of friction: Eq. (5), or without its fall, or none, which is the same as no table.
    LAW: Choice<Law> = "friction.law", Default("\"stribeck\""),
        Choice { options: &[("stribeck", Law::Stribeck), ("constant", Law::Constant), ("none", Law::None)] };
    /// Coefficient of friction.
    MU: Number = "friction.mu", Else("required with `constant`"), number(One, Range::Closed(0.0, 10.0));
    /// Static coefficient of friction.
    MU_S: Number = "friction.mu_s", Else("required with `stribeck`"), number(One, Range::Closed(0.0, 10.0));
    /// Kinetic coefficient of friction; usually at most the static one.
    MU_D: Number = "friction.mu_d", Else("required with `stribeck`"), number(One, Range::Closed(0.0, 10.0));
    /// Slope factor of the creep region, `d` of Eq. (5); the larger, the sharper the rise at rest.
    CREEP_SLOPE: Number = "friction.creep_slope_s_per_m", Default("1000"),
        number(SecondPerMetre, Range::Positive(1e8));
    /// Slope factor of the sliding region, `f` of Eq. (5); the larger, the steeper the fall.
    STRIBECK_SLOPE: Number = "friction.stribeck_slope_s_per_m", Default("10"),
        number(SecondPerMetre, Range::Closed(0.0, 1e6));
    /// Whether the radial part of the friction force in Eq. (8) is kept.
    RADIAL: Flag = "friction.radial", Default("true"), Flag;

    /// Damping ratio of all modes, or of each mode in the order of frequency.
    DAMPING: OneOrMany = "damping.ratio", Required,
        OneOrMany { item: number(One, Range::HalfOpen(0.0, 1.0)) };

    /// Natural frequency.
    IMPACT_FREQUENCY: Number = "impact_oscillator.frequency_hz", Required, FREQUENCY;
    /// Damping ratio.
    IMPACT_DAMPING: Number = "impact_oscillator.damping_ratio", Default("0"), RATIO;
    /// Amplitude of the drive, as the acceleration that it gives the mass.
    IMPACT_DRIVE: Number = "impact_oscillator.drive_m_per_s2", Required, DRIVE;
    /// Frequency of the drive, a cosine; 0 is a constant push.
    IMPACT_DRIVE_FREQUENCY: Number = "impact_oscillator.drive_frequency_hz", Required, DRIVE_FREQUENCY;
    /// Where the wall is: the mass moves at or above it.
    WALL: Number = "impact_oscillator.wall_um", Default("0"), PLACE;
    /// Coefficient of restitution: speed after an impact over that before it.
    RESTITUTION: Number = "impact_oscillator.restitution", Required, number(One, Range::Closed(0.0, 1.0));

    /// Natural frequency.
    BELT_FREQUENCY: Number = "mass_on_belt.frequency_hz", Required, FREQUENCY;
    /// Damping ratio.
    BELT_DAMPING: Number = "mass_on_belt.damping_ratio", Default("0"), RATIO;
    /// Force that presses the mass onto the belt, by the mass.
    BELT_LOAD: Number = "mass_on_belt.load_n_per_kg", Required, number(NewtonPerKilogram, Range::Positive(1e6));
    /// Static coefficient of friction: holds while sticking.
    BELT_MU_S: Number = "mass_on_belt.mu_s", Required, number(One, Range::Closed(0.0, 10.0));
    /// Kinetic coefficient of friction: holds while sliding; at most the static one.
    BELT_MU_D: Number = "mass_on_belt.mu_d", Required, number(One, Range::Closed(0.0, 10.0));
    /// Speed of the belt.
    BELT_SPEED: Number = "mass_on_belt.belt_mm_per_s", Required, number(MillimetrePerSecond, Range::Positive(1e5));
    /// Slope factor of the fall from the static to the kinetic coefficient with the sliding speed; the larger, the steeper.
    BELT_STRIBECK: Number = "mass_on_belt.stribeck_slope_s_per_m", Else("the coefficient falls at once"),
        number(SecondPerMetre, Range::Positive(1e6));

    /// Natural frequency of the first mode out of contact.
    COUPLED_FIRST: Number = "two_modes_on_belt.first_frequency_hz", Required, FREQUENCY;
    /// Natural frequency of the second mode out of contact; it moves across the first one.
    COUPLED_SECOND: Number = "two_modes_on_belt.second_frequency_hz", Required, FREQUENCY;
    /// Direction in which the first mode moves: from along the belt towards into it.
    COUPLED_ANGLE: Number = "two_modes_on_belt.angle_deg", Required, number(Degree, Range::Closed(-90.0, 90.0));
    /// Stiffness of the contact, as the frequency of the mass on it alone.
    COUPLED_CONTACT: Number = "two_modes_on_belt.contact_frequency_hz", Required, FREQUENCY;
    /// Force that presses the mass onto the belt, by the mass.
    COUPLED_LOAD: Number = "two_modes_on_belt.load_n_per_kg", Required, number(NewtonPerKilogram, Range::Positive(1e6));
    /// Coefficient of friction, the same at all speeds but next to rest.
    COUPLED_MU: Number = "two_modes_on_belt.mu", Required, number(One, Range::Closed(0.0, 10.0));
    /// Slope factor by which it rises from zero at rest; at least 20 over the speed of the belt.
    COUPLED_CREEP: Number = "two_modes_on_belt.creep_slope_s_per_m", Default("1000"), number(SecondPerMetre, Range::Positive(1e8));
    /// Speed of the belt.
    COUPLED_SPEED: Number = "two_modes_on_belt.belt_mm_per_s", Required, number(MillimetrePerSecond, Range::Positive(1e5));

    /// Natural frequency out of contact.
    DAMPED_FREQUENCY: Number = "damped_contact.frequency_hz", Required, FREQUENCY;
    /// Damping ratio out of contact.
    DAMPED_DAMPING: Number = "damped_contact.damping_ratio", Default("0"), RATIO;
    /// Amplitude of the drive, as the acceleration that it gives the mass.
    DAMPED_DRIVE: Number = "damped_contact.drive_m_per_s2", Required, DRIVE;
    /// Frequency of the drive, a cosine; 0 is a constant push.
    DAMPED_DRIVE_FREQUENCY: Number = "damped_contact.drive_frequency_hz", Required, DRIVE_FREQUENCY;
    /// Stiffness of the contact below 0: the natural frequency of the mass on its spring alone.
    CONTACT_FREQUENCY: Number = "damped_contact.contact_frequency_hz", Required, FREQUENCY;
    /// Damping of the contact: the damping ratio of the mass on it alone.
    CONTACT_DAMPING: Number = "damped_contact.contact_damping_ratio", Required, number(One, Range::Closed(0.0, 10.0));

    /// Position of a small system at the start.
    START_POSITION: Number = "start.position_um", Default("0"), PLACE;
    /// Velocity of a small system at the start, before the kick.
    START_VELOCITY: Number = "start.velocity_mm_per_s", Default("0"), number(MillimetrePerSecond, Range::Closed(-1e5, 1e5));
    /// Standard deviation of each modal velocity at the start, in sqrt(kg) mm/s; 0 is exactly at rest.
    KICK: Number = "start.kick_mm_per_s", Default("0.01"),
        number(MillimetrePerSecond, Range::Closed(0.0, 1000.0));
    /// Seed of the random kick.
    SEED: Seed = "start.seed", Default("1"), Seed;

    /// Simulated time.
    DURATION: Number = "time.duration_ms", Required, number(Millisecond, Range::Closed(0.1, 1e5));
    /// Samples a millisecond.
    SAMPLE_RATE: Number = "time.sample_rate_khz", Default("200"),
        number(Kilohertz, Range::Closed(10.0, 2000.0));
    /// Samples that travel together from simulation to analysis.
    FRAME_SAMPLES: Count = "time.frame_samples", Default("256"), Count { min: 1, max: 65_536 };
    /// Integrator: exponential pair of order 5(4) or 8(5, 3), the plain pairs `tsit54` and `dop853`, the linearly implicit `rodas5p`, `auto` for the first that turns implicit while nodes stick, or classical fixed-step Runge-Kutta.
    METHOD: Choice<Method> = "time.method", Default("\"lawson54\""),
        Choice { options: &[(Method::Lawson54.name(), Method::Lawson54), (Method::Lawson853.name(), Method::Lawson853),
            (Method::Tsit54.name(), Method::Tsit54), (Method::Dop853.name(), Method::Dop853), (Method::Rodas5p.name(), Method::Rodas5p),
            (Method::Auto.name(), Method::Auto), (Method::Rk4.name(), Method::Rk4)] };
    /// Relative tolerance of the adaptive integrators.
    TOLERANCE: Number = "time.tolerance", Default("1e-5"), number(One, Range::Closed(1e-13, 1e-2));
    /// Largest step of the adaptive integrators; the step of `rk4`, which has no default.
    MAX_STEP: Number = "time.max_step_us", Default("20"),
        number(Microsecond, Range::Closed(0.001, 1000.0));
    /// Contact nodes that open or close: steps go through these events, or end exactly there.
    EVENTS: Choice<Events> = "time.events", Default("\"through\""),
        Choice { options: &[("through", Events::Through), ("exact", Events::Exact)] };

    /// The cheapest integrator for an error of 1e-2 of the state, such as `lawson54 1e-3`: its name and tolerance (of `rk4` its step in s), which `--accuracy 1e-2` takes. `squeakscope cost --write` finds it.
    ADVICE_2: Text = "accuracy.error_1e-2", Else("no advice"), Text;
    /// For 1e-3.
    ADVICE_3: Text = "accuracy.error_1e-3", Else("no advice"), Text;
    /// For 1e-4.
    ADVICE_4: Text = "accuracy.error_1e-4", Else("no advice"), Text;
    /// For 1e-6.
    ADVICE_6: Text = "accuracy.error_1e-6", Else("no advice"), Text;

    /// Length of the sliding window.
    SPECTRUM_WINDOW: Number = "analysis.spectrum.window_ms", Default("20"),
        number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between spectra.
    SPECTRUM_EVERY: Number = "analysis.spectrum.every_ms", Default("5"),
        number(Millisecond, Range::Closed(0.01, 10_000.0));

    /// Length of the window of one column.
    SPECTROGRAM_WINDOW: Number = "analysis.spectrogram.window_ms", Default("5"),
        number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between columns.
    SPECTROGRAM_EVERY: Number = "analysis.spectrogram.every_ms", Default("0.5"),
        number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Highest frequency kept; at most half the sample rate.
    MAX_FREQUENCY: Number = "analysis.spectrogram.max_frequency_khz", Default("20"),
        number(Kilohertz, Range::Closed(0.1, 1000.0));

    /// Length of the sliding window.
    DELAY_WINDOW: Number = "analysis.delay.window_ms", Default("20"), number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between choices.
    DELAY_EVERY: Number = "analysis.delay.every_ms", Default("20"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Largest delay tried.
    LARGEST_LAG: Number = "analysis.delay.largest_lag_us", Default("300"), LAG;
    /// Largest embedding dimension tried.
    LARGEST_DIMENSION: Count = "analysis.delay.largest_dimension", Default("8"), DIMENSION;
    /// Bins along an axis of the joint histogram behind the mutual information.
    BINS: Count = "analysis.delay.bins", Default("32"), Count { min: 2, max: 256 };
    /// Share of false neighbours that counts as none: the first dimension with no more is chosen.
    FALSE_SHARE: Number = "analysis.delay.false_share", Default("0.01"), number(One, Range::HalfOpen(0.0, 1.0));

    /// Length of the sliding window.
    RECURRENCE_WINDOW: Number = "analysis.recurrence.window_ms", Default("5"), number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Points along a side of the plot.
    RECURRENCE_SIZE: Count = "analysis.recurrence.size", Default("400"), Count { min: 16, max: 2048 };
    /// Time between plots.
    RECURRENCE_EVERY: Number = "analysis.recurrence.every_ms", Default("2.5"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Delay tau of Eq. (25); a quarter of the leading period unfolds the orbit best.
    RECURRENCE_LAG: AutoOr<Number> = "analysis.recurrence.lag_us", Default("60"), AutoOr(LAG);
    /// Embedding dimension m of Eq. (25).
    RECURRENCE_DIMENSION: AutoOr<Count> = "analysis.recurrence.dimension", Default("5"), AutoOr(DIMENSION);
    /// How distances between states are measured.
    RECURRENCE_NORM: Choice<Norm> = "analysis.recurrence.norm", Default("\"euclidean\""), NORM;
    /// Threshold of Eq. (26): the share of pairs of states that shall be recurrent.
    RECURRENCE_RATE: Number = "analysis.recurrence.threshold_rate", ONE_THRESHOLD, number(One, Range::Open(0.0, 1.0));
    /// Threshold of Eq. (26) as a distance between delay vectors instead.
    RECURRENCE_DISTANCE: Number = "analysis.recurrence.threshold_um", ONE_THRESHOLD, number(Micrometre, Range::Positive(1e6));
    /// Threshold of Eq. (26) as a multiple of the displacement's standard deviation in the window instead.
    RECURRENCE_SPREAD: Number = "analysis.recurrence.threshold_spread", ONE_THRESHOLD, number(One, Range::Positive(100.0));
    /// Neighbours that each state shall have instead: a threshold of its own for each.
    RECURRENCE_NEIGHBOURS: Count = "analysis.recurrence.neighbours", ONE_THRESHOLD, Count { min: 1, max: 10_000 };

    /// Length of the sliding window.
    QUANTIFICATION_WINDOW: Number = "analysis.quantification.window_ms", Default("20"), number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between measures.
    QUANTIFICATION_EVERY: Number = "analysis.quantification.every_ms", Default("5"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Spacing of the states, at least one sample; the delay is rounded to whole steps.
    STEP: Number = "analysis.quantification.step_us", Default("10"), number(Microsecond, Range::Closed(0.5, 1e6));
    /// Delay tau of Eq. (25); a quarter of the leading period unfolds the orbit best.
    QUANTIFICATION_LAG: AutoOr<Number> = "analysis.quantification.lag_us", Default("60"), AutoOr(LAG);
    /// Embedding dimension m of Eq. (25).
    QUANTIFICATION_DIMENSION: AutoOr<Count> = "analysis.quantification.dimension", Default("5"), AutoOr(DIMENSION);
    /// How distances between states are measured.
    QUANTIFICATION_NORM: Choice<Norm> = "analysis.quantification.norm", Default("\"euclidean\""), NORM;
    /// Threshold of Eq. (26): the share of pairs of states that shall be recurrent.
    QUANTIFICATION_RATE: Number = "analysis.quantification.threshold_rate", ONE_THRESHOLD, number(One, Range::Open(0.0, 1.0));
    /// Threshold of Eq. (26) as a distance between delay vectors instead.
    QUANTIFICATION_DISTANCE: Number = "analysis.quantification.threshold_um", ONE_THRESHOLD, number(Micrometre, Range::Positive(1e6));
    /// Threshold of Eq. (26) as a multiple of the displacement's standard deviation in the window instead.
    QUANTIFICATION_SPREAD: Number = "analysis.quantification.threshold_spread", ONE_THRESHOLD, number(One, Range::Positive(100.0));
    /// Neighbours that each state shall have instead: a threshold of its own for each.
    QUANTIFICATION_NEIGHBOURS: Count = "analysis.quantification.neighbours", ONE_THRESHOLD, Count { min: 1, max: 10_000 };
    /// Theiler window: states nearer in time are not compared; at least one step, so that no state is compared with itself.
    QUANTIFICATION_THEILER: Number = "analysis.quantification.theiler_us", Default("60"), number(Microsecond, Range::Closed(0.0, 1e6));
    /// Shortest diagonal line, in states; about a period tells repetition from mere smoothness.
    LEAST_DIAGONAL: Count = "analysis.quantification.least_diagonal", Default("24"), Count { min: 2, max: 10_000 };
    /// Shortest vertical line, in states.
    LEAST_VERTICAL: Count = "analysis.quantification.least_vertical", Default("2"), Count { min: 2, max: 10_000 };

    /// Time between reports of the passages.
    SECTION_EVERY: Number = "analysis.section.every_ms", Default("1"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Which way through the surface counts.
    DIRECTION: Choice<Direction> = "analysis.section.direction", Default("\"rising\""),
        Choice { options: &[("rising", Direction::Rising), ("falling", Direction::Falling), ("both", Direction::Both)] };
    /// Delay tau of the surface y(t + tau) = level (Fig. 10); shown are y(t) and y(t + 2 tau).
    SECTION_LAG: AutoOr<Number> = "analysis.section.lag_us", Default("60"), AutoOr(LAG);
    /// Level of that surface.
    LEVEL: Number = "analysis.section.level_um", Default("0"), number(Micrometre, Range::Closed(-1e6, 1e6));
    /// A plane of the modal state as the surface instead: its normal along the modal coordinates, a number for each mode, by frequency.
    PLANE_Q: List = "analysis.section.plane_q", Else("none; or `plane_qdot_ms`"), List { item: number(One, Range::Closed(-1e6, 1e6)) };
    /// The normal along the modal velocities: in ms, which makes sqrt(kg) um of sqrt(kg) mm/s.
    PLANE_QDOT: List = "analysis.section.plane_qdot_ms", Else("none; or `plane_q`"), List { item: number(Millisecond, Range::Closed(-1e6, 1e6)) };
    /// Offset of the plane, in sqrt(kg) um: normal times state is this on it.
    OFFSET: Number = "analysis.section.offset_um", Else("0, with a plane"), number(Micrometre, Range::Closed(-1e6, 1e6));
    /// The two coordinates of the modal state that are shown, such as `["q1", "qdot1"]`: modes counted from 1, by frequency.
    SHOWN: Coordinates = "analysis.section.shown", Else("required with a plane"), Coordinates;

    /// Length of the sliding window.
    CHAOS_WINDOW: Number = "analysis.chaos.window_ms", Default("90"), number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between results.
    CHAOS_EVERY: Number = "analysis.chaos.every_ms", Default("20"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Delay tau of Eq. (25); a quarter of the leading period unfolds the orbit best.
    CHAOS_LAG: AutoOr<Number> = "analysis.chaos.lag_us", Default("60"), AutoOr(LAG);
    /// Embedding dimension m of Eq. (25).
    CHAOS_DIMENSION: AutoOr<Count> = "analysis.chaos.dimension", Default("5"), AutoOr(DIMENSION);
    /// Theiler window: states nearer in time are no neighbours; the leading period or more.
    CHAOS_THEILER: Number = "analysis.chaos.theiler_us", Default("500"), number(Microsecond, Range::Closed(0.0, 1e6));
    /// How long neighbours are followed.
    HORIZON: Number = "analysis.chaos.horizon_ms", Default("30"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Whose distance is followed: the nearest neighbour's of each state, or that of all within a radius.
    DIVERGENCE: Choice<Divergence> = "analysis.chaos.method", Default("\"rosenstein\""),
        Choice { options: &[("rosenstein", Divergence::Rosenstein), ("kantz", Divergence::Kantz)] };
    /// That radius, over the displacement's standard deviation in the window.
    RADIUS: Number = "analysis.chaos.radius", Else("required with `kantz`"), number(One, Range::Positive(10.0));

    /// Length of the sliding window; of a long one the newest 10,000 samples are judged, or as many means of a few each.
    REGIME_WINDOW: Number = "analysis.regime.window_ms", Default("40"), number(Millisecond, Range::Closed(0.1, 10_000.0));
    /// Time between verdicts.
    REGIME_EVERY: Number = "analysis.regime.every_ms", Default("10"), number(Millisecond, Range::Closed(0.01, 10_000.0));
    /// Amplitude of the displacement below which the joint is silent.
    SILENCE: Number = "analysis.regime.silence_um", Default("0.0003"), number(Micrometre, Range::Closed(0.0, 1e6));

    /// How many Lyapunov exponents, the largest first; all are twice as many as there are modes.
    EXPONENT_COUNT: AllOr<Count> = "analysis.exponents.count", Default("3"), AllOr(Count { min: 1, max: 1000 });
    /// Time from the start whose growth is forgotten: until the motion has found its attractor.
    SETTLE: Number = "analysis.exponents.settle_ms", Default("50"), number(Millisecond, Range::Closed(0.0, 1e5));
    /// Time between results.
    EXPONENTS_EVERY: Number = "analysis.exponents.every_ms", Default("1"), number(Millisecond, Range::Closed(0.01, 10_000.0));

    /// When the second copy of the joint starts, almost in the state of the first.
    BUTTERFLY_START: Number = "analysis.butterfly.start_ms", Default("50"), number(Millisecond, Range::Closed(0.0, 1e5));
    /// How far apart the two start, in the norm of the vibration's energy: a share of the size that the motion has had by then.
    DISTANCE: Number = "analysis.butterfly.distance", Default("1e-9"), number(One, Range::Closed(1e-12, 0.01));
    /// Time between results.
    BUTTERFLY_EVERY: Number = "analysis.butterfly.every_ms", Default("1"), number(Millisecond, Range::Closed(0.01, 10_000.0));

    /// Snapshots of the contact nodes a millisecond; at most the sample rate, like all rates here; 0 for none.
    PATCH_RATE: Number = "record.patch_rate_khz", Default("2"), number(Kilohertz, Range::Closed(0.0, 2000.0));
    /// Pictures of the deforming body in three dimensions a millisecond; 0 for none.
    BODY_RATE: Number = "record.body_rate_khz", Default("2"), number(Kilohertz, Range::Closed(0.0, 2000.0));
    /// Energy samples a millisecond; 0 for none, and then the work of friction is not followed and not audited.
    ENERGY_RATE: Number = "record.energy_rate_khz", Default("10"), number(Kilohertz, Range::Closed(0.0, 2000.0));
    /// Factor by which the body's deformation is shown larger than it is.
    EXAGGERATION: Number = "record.exaggeration", Default("2000"), number(One, Range::Closed(1.0, 1e9));
}

/// Keys of advice on the integrator, by the error.
pub(super) static ADVICE: [(f64, &Key<Text>); 4] = [
    (1e-2, &ADVICE_2),
    (1e-3, &ADVICE_3),
    (1e-4, &ADVICE_4),
    (1e-6, &ADVICE_6),
];

/// The friction laws by name; their parameters are keys of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Law {
    /// No friction.
    None,
    /// A constant coefficient, smoothed at rest.
    Constant,
    /// Eq. (5).
    Stribeck,
}

/// The laws of contact damping by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DampingLaw {
    /// A dashpot beside the spring.
    KelvinVoigt,
    /// In proportion to the spring's stress.
    HuntCrossley,
}

/// The ways to follow neighbours by name; the radius is a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Divergence {
    /// Nearest neighbours.
    Rosenstein,
    /// All within a radius.
    Kantz,
}

/// The keys of a quantity that can be a function of time.
pub(super) struct ScheduleKeys {
    /// The quantity in a word.
    pub word: &'static str,
    /// Its constant; the factor on the rotation has none.
    pub constant: Option<&'static Key<Number>>,
    /// What each of its values must be.
    pub value: Number,
    /// Knots, then time and value of each.
    pub knots: (&'static Key<Tables>, [&'static Key<Number>; 2]),
    /// Steps, then time and value of each.
    pub steps: (&'static Key<Tables>, [&'static Key<Number>; 2]),
    /// The table of a sine.
    pub sine: &'static str,
    /// Mean, amplitude, frequency and phase of the sine.
    pub sine_numbers: [&'static Key<Number>; 4],
    /// The file of knots.
    pub csv: &'static Key<Text>,
}

impl ScheduleKeys {
    /// The paths of its forms, the constant first.
    pub fn forms(&self) -> impl Iterator<Item = &'static str> {
        let constant = self.constant.map(|key| key.path);
        let others = [
            self.knots.0.path,
            self.steps.0.path,
            self.sine,
            self.csv.path,
        ];
        constant.into_iter().chain(others)
    }

    /// Whether a key is part of a function of time, not a value for a whole run.
    fn holds_in_part(&self, path: &str) -> bool {
        let table = split(path).0;
        self.forms().any(|form| form == table)
    }
}

/// Whether a key is part of a function of time, not a value for a whole run.
pub(super) fn is_of_a_schedule(path: &str) -> bool {
    let all = [&LOAD_SCHEDULE, &TILT_SCHEDULE, &FACTOR_SCHEDULE];
    all.into_iter().any(|keys| keys.holds_in_part(path))
}

/// Those of the load.
pub(super) static LOAD_SCHEDULE: ScheduleKeys = ScheduleKeys {
    word: "load",
    constant: Some(&LOAD),
    value: FORCE,
    knots: (&LOAD_KNOTS, [&LOAD_KNOT_TIME, &LOAD_KNOT]),
    steps: (&LOAD_STEPS, [&LOAD_STEP_TIME, &LOAD_STEP]),
    sine: "load.load_sine",
    sine_numbers: [&LOAD_MEAN, &LOAD_AMPLITUDE, &LOAD_FREQUENCY, &LOAD_PHASE],
    csv: &LOAD_CSV,
};

/// Those of the tilt.
pub(super) static TILT_SCHEDULE: ScheduleKeys = ScheduleKeys {
    word: "tilt",
    constant: Some(&TILT),
    value: ANGLE,
    knots: (&TILT_KNOTS, [&TILT_KNOT_TIME, &TILT_KNOT]),
    steps: (&TILT_STEPS, [&TILT_STEP_TIME, &TILT_STEP]),
    sine: "load.tilt_sine",
    sine_numbers: [&TILT_MEAN, &TILT_AMPLITUDE, &TILT_FREQUENCY, &TILT_PHASE],
    csv: &TILT_CSV,
};

/// Those of the factor on the rotation.
pub(super) static FACTOR_SCHEDULE: ScheduleKeys = ScheduleKeys {
    word: "rotation",
    constant: None,
    value: FACTOR,
    knots: (&FACTOR_KNOTS, [&FACTOR_KNOT_TIME, &FACTOR_KNOT]),
    steps: (&FACTOR_STEPS, [&FACTOR_STEP_TIME, &FACTOR_STEP]),
    sine: "rotation.factor_sine",
    sine_numbers: [
        &FACTOR_MEAN,
        &FACTOR_AMPLITUDE,
        &FACTOR_FREQUENCY,
        &FACTOR_PHASE,
    ],
    csv: &FACTOR_CSV,
};

/// The keys of a norm and the four thresholds in one table.
pub(super) struct NearnessKeys {
    pub norm: &'static Key<Choice<Norm>>,
    pub rate: &'static Key<Number>,
    pub distance: &'static Key<Number>,
    pub spread: &'static Key<Number>,
    pub neighbours: &'static Key<Count>,
}

/// Those of `[analysis.recurrence]`.
pub(super) static RECURRENCE_NEARNESS: NearnessKeys = NearnessKeys {
    norm: &RECURRENCE_NORM,
    rate: &RECURRENCE_RATE,
    distance: &RECURRENCE_DISTANCE,
    spread: &RECURRENCE_SPREAD,
    neighbours: &RECURRENCE_NEIGHBOURS,
};

/// Those of `[analysis.quantification]`.
pub(super) static QUANTIFICATION_NEARNESS: NearnessKeys = NearnessKeys {
    norm: &QUANTIFICATION_NORM,
    rate: &QUANTIFICATION_RATE,
    distance: &QUANTIFICATION_DISTANCE,
    spread: &QUANTIFICATION_SPREAD,
    neighbours: &QUANTIFICATION_NEIGHBOURS,
};
