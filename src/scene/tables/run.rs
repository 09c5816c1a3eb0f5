//! Name and description of a scene, initial state, duration, integrator and recording.

use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::dynamics::MethodName;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::mechanism::Mechanism;
use crate::scene::schema::kind::Range::Closed;
use crate::scene::schema::kind::{Kind, choice, count, number, seed, text};
use crate::scene::schema::unit::*;
use crate::scene::schema::{IfAbsent, Key, Schema, keys};
use crate::scene::subject::SystemSpec;

/// Range of positions.
pub const PLACE: Kind<f64> = number(MICROMETRE, Closed(-1e6, 1e6));

keys! {
    /// Name and description of a scene.
    pub struct Header {
        /// Name of the scene.
        name: Option<String> = "name": text(), else "the file's name";
        /// One line that states the content of the scene.
        title: Option<String> = "title": text(), else "the name";
        /// A few sentences (Markdown) on what to observe.
        about: Option<String> = "about": text(), else "empty";
        /// Mechanism that the scene demonstrates. A lesson explains it next to the view that shows it, with numbers measured in the run (guide `mechanisms`).
        mechanism: Option<Mechanism> = "mechanism": choice::<Mechanism>(), else "no lesson";
    }

    /// The initial state: the steady-sliding equilibrium (for a small system the given position and velocity)
    /// with a random kick of the modal velocities. SI units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Start {
        /// Initial position of a small system.
        position: f64 = "position_um": PLACE, default 0;
        /// Initial velocity of a small system, before the kick.
        velocity: f64 = "velocity_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(-1e5, 1e5)), default 0;
        /// Standard deviation of the random initial modal velocities (the kick), in sqrt(kg) mm/s; 0 starts exactly at the equilibrium.
        kick: f64 = "kick_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(0.0, 1000.0)), default 0.01;
        /// Seed of the random kick.
        seed: u64 = "seed": seed(), default 1;
    }

    /// Duration and sampling of a run.
    pub struct Frames {
        /// Simulated time.
        duration: f64 = "duration_ms": number(MILLISECOND, Closed(0.1, 1e5));
        /// Sampling rate.
        sample_rate: f64 = "sample_rate_khz": number(KILOHERTZ, Closed(10.0, 2000.0)), default 200;
        /// Samples in a frame, the unit that the simulation passes to the analyses.
        frame_samples: usize = "frame_samples": count(1, 65_536), default 256;
    }

    /// Integrator and its accuracy. SI units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Integrator {
        /// Integration method: the exponential pairs of order 5(4) or 8(5, 3), the pairs `tsit5` and `dop853` in plain form, the linearly implicit `rodas5p`, `auto` (the 5(4) pair, with the implicit method while nodes stick), or the classical Runge-Kutta method `rk4` with fixed steps.
        method: MethodName = "method": choice::<MethodName>(), default "lawson54";
        /// Relative tolerance of the adaptive integrators.
        tolerance: f64 = "tolerance": number(ONE, Closed(1e-13, 1e-2)), default 1e-5;
        /// Maximum step of the adaptive methods; the fixed step of `rk4`, for which it is required.
        max_step: f64 = "max_step_us": number(MICROSECOND, Closed(0.001, 1000.0)), default 20;
        /// Separation and closure of contact nodes: steps pass `through` these events, or end at the `exact` event time.
        events: Events = "events": choice::<Events>(), default "through";
    }
}

/// Treatment of separation and closure of contact nodes within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
pub enum Events {
    /// The step passes through the event; error control shortens it if necessary.
    #[default]
    Through,
    /// The step ends at the event.
    Exact,
}

keys! {
    /// Contents and rates of the recording; a rate of 0 records nothing. SI units. The default is that of a system without
    /// contact patch and body: samples only.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct RecordSpec {
        /// Rate at which contact nodes are counted, and of their snapshots; 0 for none. All rates are at most the sampling rate.
        patch_rate: f64 = "patch_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 2;
        /// Number of contact nodes in rings that are shown and counted, whatever the number of simulated nodes; with a friction law that has a state at each node, and with imported modes, the simulated nodes are shown.
        patch_nodes: usize = "patch_nodes": count(1, 10_000), default 100;
        /// Rate of three-dimensional views of the deformed body; 0 for none.
        body_rate: f64 = "body_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 2;
        /// Rate of energy samples; 0 for none, which also omits the work of friction and the energy audit.
        energy_rate: f64 = "energy_rate_khz": number(KILOHERTZ, Closed(0.0, 2000.0)), default 10;
        /// Scale factor of the displayed deformation.
        deformation_scale: f64 = "deformation_scale": number(ONE, Closed(1.0, 1e9)), default 2000;
    }
}

pub fn start(document: &Document<'_>, subject: &SystemSpec) -> Result<Start, SceneError> {
    let table = document.table("start");
    let is_joint = matches!(subject, SystemSpec::Joint(_));
    for name in ["position_um", "velocity_mm_per_s"] {
        ensure!(table, !(is_joint && table.has(name)) => name, &[];
            "a ball joint starts at steady sliding";
            "remove it; start.kick_mm_per_s sets the initial perturbation");
    }
    Start::read(table)
}

pub fn integrator(document: &Document<'_>) -> Result<Integrator, SceneError> {
    let table = document.table("time");
    let integrator = Integrator::read(table)?;
    ensure!(table,
        !integrator.method.has_fixed_step() || table.has("max_step_us") => "max_step_us", &["method"];
        "rk4 requires a fixed step";
        "set time.max_step_us; 0.4 to 1.6 is suitable for the joint of the paper");
    Ok(integrator)
}

pub fn record(
    document: &Document<'_>,
    sample_rate: f64,
    subject: &SystemSpec,
) -> Result<RecordSpec, SceneError> {
    if let SystemSpec::Small(_) = subject {
        ensure!(document, !document.has("record") => "record", &[];
            "a small system has neither a contact patch nor a body to record";
            "remove the table; all samples are recorded");
        return Ok(RecordSpec::default());
    }
    let record = RecordSpec::read(document.table("record"))?;
    for (rate, key) in [
        (record.patch_rate, "record.patch_rate_khz"),
        (record.body_rate, "record.body_rate_khz"),
        (record.energy_rate, "record.energy_rate_khz"),
    ] {
        ensure!(document, rate <= sample_rate => key, &["time.sample_rate_khz"];
            "it exceeds the sampling rate of {} kHz", sample_rate / 1e3;
            "reduce it to at most time.sample_rate_khz");
    }
    Ok(record)
}
