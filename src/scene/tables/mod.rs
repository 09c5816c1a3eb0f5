//! The tables of a scene file: their keys, what these make, and what must fit together.
//!
//! [`Scene::parse`] goes from a parsed file to a validated [`Scene`]: values by key first, then what must
//! fit together.

pub mod analysis;
mod axis;
mod csv;
mod joint;
pub mod load;
mod mechanism;
mod small;

use std::sync::Arc;

use super::accuracy::{ADVICE, Advised};
use super::document::{Document, Table, line_of};
use super::error::{Fault, Place, SceneError, ensure};
use super::mechanism::Mechanism;
use super::parameter::with_knots;
use super::schema::kind::Range::Closed;
use super::schema::kind::{Count, Seed, Text, choice, number};
use super::schema::unit::{KILOHERTZ, MICROSECOND, MILLIMETRE_PER_SECOND, MILLISECOND, ONE};
use super::schema::{FromTable, Key, Otherwise, Schema, keys};
use super::spec::Scene;
use super::subject::SubjectSpec;
use crate::dynamics::MethodName;
use crate::joint::OwnModes;

use analysis::AnalysisSpec;
pub use axis::{patch_stays, sliding};
pub use mechanism::shown as shown_mechanism;

/// Adds the keys of all tables, in the order of the guide.
pub fn declare(schema: &mut Schema) {
    Header::declare(schema, "");
    joint::declare(schema);
    small::declare(schema);
    Start::declare(schema, "start");
    Frames::declare(schema, "time");
    Integrator::declare(schema, "time");
    for (_, key) in &ADVICE {
        schema.add("accuracy", key);
    }
    AnalysisSpec::declare(schema, "analysis");
    RecordSpec::declare(schema, "record");
}

keys! {
    /// What a scene says of itself.
    struct Header {
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
        position: f64 = "position_um": small::PLACE, default 0;
        /// Velocity of a small system at the start, before the kick.
        velocity: f64 = "velocity_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(-1e5, 1e5)), default 0;
        /// Standard deviation of each modal velocity at the start, in sqrt(kg) mm/s; 0 is exactly at rest.
        kick: f64 = "kick_mm_per_s": number(MILLIMETRE_PER_SECOND, Closed(0.0, 1000.0)), default 0.01;
        /// Seed of the random kick.
        seed: u64 = "seed": Seed, default 1;
    }

    /// How long a run is, and how it is sampled.
    struct Frames {
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
    fn length(&self) -> f64 {
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

impl Scene {
    /// Parses and validates a scene file's content. `file` is the name it goes by in messages;
    /// its stem names the scene if the text does not, and files that the scene names are looked for
    /// in its folder. What tables of such a file hold takes their place in [`Scene::text`].
    ///
    /// # Errors
    /// The first fault found, in the order: not text, not TOML, an unknown key, a value that is
    /// missing, mistyped or out of range, values or files that do not fit together.
    pub fn parse(file: &str, content: impl AsRef<[u8]>) -> Result<Self, SceneError> {
        let text = decoded(file, content.as_ref())?;
        let document = Document::parse(file, text)?;
        let scene = build(&document, file, text, None)?;
        mechanism::check(&document, &scene)?;
        Ok(scene)
    }

    /// [`Scene::parse`] of the text of a scene that was changed, without reading a file of modes that is
    /// known already. A mechanism that it can no longer show it no longer has: a study that changes it
    /// is after other things.
    pub(super) fn parse_changed(
        file: &str,
        text: &str,
        known: Option<&Arc<OwnModes>>,
    ) -> Result<Self, SceneError> {
        let mut scene = build(&Document::parse(file, text)?, file, text, known)?;
        scene.mechanism = mechanism::shown(&scene);
        Ok(scene)
    }
}

/// A file's content as text.
fn decoded<'a>(file: &str, content: &'a [u8]) -> Result<&'a str, SceneError> {
    let text = std::str::from_utf8(content).map_err(|error| {
        let valid = String::from_utf8_lossy(&content[..error.valid_up_to()]);
        Fault::NotText.at(Place {
            file: file.to_owned(),
            line: Some(line_of(&valid, valid.len())),
        })
    })?;
    // Some editors put a byte-order mark first; it is no part of the text.
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

fn build(
    document: &Document<'_>,
    file: &str,
    text: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<Scene, SceneError> {
    let header = Header::read(document.table(""))?;
    let stem = std::path::Path::new(file).file_stem().unwrap_or_default();
    let name = header
        .name
        .unwrap_or_else(|| stem.to_string_lossy().into_owned());
    let (subject, tables) = match small::small(document)? {
        Some(small) => (SubjectSpec::Small(small), Vec::new()),
        None => {
            let (joint, tables) = joint::tilted(document, file, known)?;
            (SubjectSpec::Joint(joint), tables)
        }
    };
    let start = start(document, &subject)?;
    let frames = Frames::read(document.table("time"))?;
    let scene = Scene {
        title: header.title.unwrap_or_else(|| name.clone()),
        about: header.about.unwrap_or_default(),
        mechanism: header.mechanism,
        name,
        text: tables.iter().try_fold(text.to_owned(), |text, table| {
            with_knots(&text, table, || document.place_of(table.keys.paths()))
        })?,
        start,
        duration: frames.duration,
        sample_rate: frames.sample_rate,
        frame_samples: frames.frame_samples,
        integrator: integrator(document)?,
        advice: advice(document)?,
        analysis: analysis::read(document, frames.sample_rate, subject.modes())?,
        record: record(document, frames.sample_rate, &subject)?,
        subject,
    };
    if let SubjectSpec::Joint(joint) = &scene.subject {
        let tilt = || ["load.azimuth_deg"].into_iter().chain(load::TILT.paths());
        let loading = || tilt().chain(load::LOAD.paths()).chain(["body.modes"]);
        patch_stays(joint, || document.place_of(loading()))?;
        let motion = || document.place_of(tilt().chain(["rotation.rad_s"]));
        sliding(&joint.spec, &joint.tilt, motion)?;
    }
    Ok(scene)
}

fn start(document: &Document<'_>, subject: &SubjectSpec) -> Result<Start, SceneError> {
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

fn integrator(document: &Document<'_>) -> Result<Integrator, SceneError> {
    let table = document.table("time");
    let integrator = Integrator::read(table)?;
    ensure!(table,
        !integrator.method.has_fixed_step() || table.has("max_step_us") => "max_step_us", &["method"];
        "rk4 takes fixed steps, and none is given";
        "add time.max_step_us; 0.4 to 1.6 fits the paper's joint");
    Ok(integrator)
}

fn advice(document: &Document<'_>) -> Result<Vec<Advised>, SceneError> {
    let table = document.table("accuracy");
    let mut advice = Vec::new();
    for (error, key) in &ADVICE {
        let Some(text) = table.find(key)? else {
            continue;
        };
        advice.push(Advised::read(*error, &text).ok_or_else(|| {
            table.inconsistent(
                key.name,
                &[],
                "it is no method with a tolerance from 1e-13 to 1e-2, or a fixed step from 1e-9 to 1e-3 s",
                "write such as \"lawson54 1e-4\", or let `squeakscope cost --write` find it",
            )
        })?);
    }
    Ok(advice)
}

fn record(
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
