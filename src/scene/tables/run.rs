//! What a scene says of itself, how its run starts, how long it is, how it is integrated, and what is recorded.

use crate::dynamics::MethodName;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::mechanism::Mechanism;
use crate::scene::schema::kind::Range::Closed;
use crate::scene::schema::kind::{Count, Number, Seed, Text, choice, number};
use crate::scene::schema::unit::{
    KILOHERTZ, MICROMETRE, MICROSECOND, MILLIMETRE_PER_SECOND, MILLISECOND, ONE,
};
use crate::scene::schema::{Key, Otherwise, Schema, keys};
use crate::scene::subject::SubjectSpec;

/// What a place on the line must be.
pub const PLACE: Number = number(MICROMETRE, Closed(-1e6, 1e6));

keys! {
    /// What a scene says of itself.
    pub struct Header {
        /// Name of the scene.
        name: Option<String> = "name": Text, else "the file's name";
        /// One line that says what the scene shows.
        title: Option<String> = "title": Text, else "the name";
        /// A few sentences (Markdown) on what to look for.
        about: Option<String> = "about": Text, else "empty";
        /// The mechanism that the scene shows: a lesson explains it, with numbers measured in the run, beside the picture that proves it (guide `mechanisms`).
        mechanism: Option<Mechanism> = "mechanism": choice::<Mechanism>(), else "no lesson";
    }

    /// The initial state: at the steady-sliding equilibrium (of a small system: at a given place and
    /// velocity), with a random kick of the modal velocities. SI units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Start {
        /// Position of a small system at the start.
        position: f64 = "position_um": PLACE, default 0;
        /// Velocity of a small system at the start, before the kick.
        velocity: f64 = "velocity_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(-1e5, 1e5)), default 0;
        /// Standard deviation of each modal velocity at the start, in sqrt(kg) mm/s; 0 is exactly at rest.
        kick: f64 = "kick_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(0.0, 1000.0)), default 0.01;
        /// Seed of the random kick.
        seed: u64 = "seed": Seed, default 1;
    }

    /// How long a run is, and how it is sampled.
    pub struct Frames {
        /// Simulated time.
        duration: f64 = "duration_ms": number(MILLISECOND, Closed(0.1, 1e5));
        /// Samples a millisecond.
        sample_rate: f64 = "sample_rate_khz": number(KILOHERTZ, Closed(10.0, 2000.0)), default 200;
        /// Samples that travel together from simulation to analysis.
        frame_samples: usize = "frame_samples": Count(1, 65_536), default 256;
    }

    /// Integrator and its accuracy. SI units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Integrator {
        /// Integrator: exponential pair of order 5(4) or 8(5, 3), the plain pairs `tsit54` and `dop853`, the linearly implicit `rodas5p`, `auto` for the first that turns implicit while nodes stick, or classical fixed-step Runge-Kutta.
        method: MethodName = "method": choice::<MethodName>(), default "lawson54";
        /// Relative tolerance of the adaptive integrators.
        tolerance: f64 = "tolerance": number(ONE, Closed(1e-13, 1e-2)), default 1e-5;
        /// Largest step of the adaptive integrators; the step of `rk4`, which has no default.
        max_step: f64 = "max_step_us": number(MICROSECOND, Closed(0.001, 1000.0)), default 20;
        /// Contact nodes that open or close: steps go through these events, or end exactly there.
        events: Events = "events": choice::<Events>(), default "through";
    }
}

/// What a step does where a contact node opens or closes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Events {
    /// It goes through; the control of its error shortens it where that matters.
    #[default]
    Through,
    /// It ends exactly there.
    Exact,
}

keys! {
    /// What is recorded and how often; a rate of 0 is never. SI units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RecordSpec {
        /// Snapshots of the contact nodes a millisecond; at most the sample rate, like all rates here; 0 for none.
        patch_rate: f64 = "patch_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 2;
        /// Pictures of the deforming body in three dimensions a millisecond; 0 for none.
        body_rate: f64 = "body_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 2;
        /// Energy samples a millisecond; 0 for none, and then the work of friction is not followed and not audited.
        energy_rate: f64 = "energy_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 10;
        /// Factor by which the body's deformation is shown larger than it is.
        exaggeration: f64 = "exaggeration": number(ONE, Closed(1.0, 1e9)), default 2000;
    }
}

impl Frames {
    /// Length of a frame, s.
    pub fn length(&self) -> f64 {
        self.frame_samples as f64 / self.sample_rate
    }
}

impl RecordSpec {
    /// Of a subject with neither a patch nor a body to take snapshots of: its samples.
    pub const SAMPLES_ONLY: Self = Self {
        patch_rate: 0.0,
        body_rate: 0.0,
        energy_rate: 0.0,
        exaggeration: 1.0,
    };
}

pub fn start(document: &Document<'_>, subject: &SubjectSpec) -> Result<Start, SceneError> {
    let table = document.table("start");
    if let SubjectSpec::Joint(_) = subject {
        table.refuse(
            &["position_um", "velocity_mm_per_s"],
            &[],
            "a ball joint starts from steady sliding",
            "leave it out; start.kick_mm_per_s sets the joint in motion",
        )?;
    }
    Start::read(table)
}

pub fn integrator(document: &Document<'_>) -> Result<Integrator, SceneError> {
    let table = document.table("time");
    let integrator = Integrator::read(table)?;
    ensure!(table,
        !integrator.method.has_fixed_step() || table.has("max_step_us") => "max_step_us", &["method"];
        "rk4 takes fixed steps, and none is given";
        "add time.max_step_us; 0.4 to 1.6 fits the paper's joint");
    Ok(integrator)
}

pub fn record(
    document: &Document<'_>,
    sample_rate: f64,
    subject: &SubjectSpec,
) -> Result<RecordSpec, SceneError> {
    if let SubjectSpec::Small(_) = subject {
        ensure!(document, !document.has("record") => "record", &[];
            "a small system has neither a contact patch nor a body to take snapshots of";
            "leave the table out; all samples are recorded");
        return Ok(RecordSpec::SAMPLES_ONLY);
    }
    let record = RecordSpec::read(document.table("record"))?;
    for (rate, key) in [
        (record.patch_rate, "record.patch_rate_khz"),
        (record.body_rate, "record.body_rate_khz"),
        (record.energy_rate, "record.energy_rate_khz"),
    ] {
        ensure!(document, rate <= sample_rate => key, &["time.sample_rate_khz"];
            "more often than samples are taken ({} kHz)", sample_rate / 1e3;
            "make it at most time.sample_rate_khz");
    }
    Ok(record)
}
