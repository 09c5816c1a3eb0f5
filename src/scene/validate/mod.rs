//! From a parsed file to a validated [`Scene`]: values by key first, then what must fit together.

mod analysis;
mod csv;
mod exponents;
mod joint;
mod mechanism;
mod record;
mod schedule;
mod small;
mod start;
mod tilt;

use std::sync::Arc;

use super::accuracy::Advised;
use super::error::{Fault, Place, SceneError};
use super::file::{Document, line_of};
use super::keys;
use super::parameter::with_knots;
use super::spec::{Integrator, Method, Scene};
use super::subject::SubjectSpec;
use crate::joint::OwnModes;

pub(super) use mechanism::shown as shown_mechanism;
pub(super) use tilt::{patch_stays, sliding};

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
    let stem = std::path::Path::new(file).file_stem();
    let name = match document.find(&keys::NAME)? {
        Some(name) => name,
        None => stem.unwrap_or_default().to_string_lossy().into_owned(),
    };
    let title = document.find(&keys::TITLE)?;
    let about = document.find(&keys::ABOUT)?;
    let mechanism = document.find(&keys::MECHANISM)?;
    let sample_rate = document.get(&keys::SAMPLE_RATE)?;
    let (subject, tables) = match small::small(document)? {
        Some(small) => (SubjectSpec::Small(small), Vec::new()),
        None => {
            let (joint, tables) = joint::tilted(document, file, known)?;
            (SubjectSpec::Joint(joint), tables)
        }
    };
    let start = start::start(document, &subject)?;
    let scene = Scene {
        title: title.unwrap_or_else(|| name.clone()),
        about: about.unwrap_or_default(),
        mechanism,
        name,
        text: tables.iter().try_fold(text.to_owned(), |text, table| {
            with_knots(
                &text,
                table.keys,
                &table.knots,
                document.place_of(&[table.keys.csv.path]),
            )
        })?,
        start,
        duration: document.get(&keys::DURATION)?,
        sample_rate,
        frame_samples: document.get(&keys::FRAME_SAMPLES)?,
        integrator: integrator(document)?,
        advice: advice(document)?,
        analysis: analysis::analysis(document, sample_rate, subject.modes())?,
        record: record::record(document, sample_rate, &subject)?,
        subject,
    };
    let motion: Vec<&str> = [keys::ROTATION.path, keys::AZIMUTH.path]
        .into_iter()
        .chain(keys::TILT_SCHEDULE.forms())
        .collect();
    let load: Vec<&str> = [keys::MODES.path, keys::AZIMUTH.path]
        .into_iter()
        .chain(keys::LOAD_SCHEDULE.forms())
        .chain(keys::TILT_SCHEDULE.forms())
        .collect();
    if let SubjectSpec::Joint(joint) = &scene.subject {
        patch_stays(joint, || document.place_of(&load))?;
        sliding(&joint.spec, &joint.tilt, || document.place_of(&motion))?;
    }
    Ok(scene)
}

fn advice(document: &Document<'_>) -> Result<Vec<Advised>, SceneError> {
    let mut advice = Vec::new();
    for (error, key) in keys::ADVICE {
        let Some(text) = document.find(key)? else {
            continue;
        };
        let advised = Advised::read(error, &text);
        advice.push(advised.ok_or_else(|| {
            document.inconsistent(
                key.path,
                &[],
                "it is no method with a tolerance from 1e-13 to 1e-2, or a fixed step from 1e-9 to 1e-3 s",
                "write such as \"lawson54 1e-4\", or let `squeakscope cost --write` find it",
            )
        })?);
    }
    Ok(advice)
}

fn integrator(document: &Document<'_>) -> Result<Integrator, SceneError> {
    let method = document.get(&keys::METHOD)?;
    if method == Method::Rk4 && !document.has(keys::MAX_STEP.path) {
        return Err(document.inconsistent(
            keys::MAX_STEP.path,
            &[keys::METHOD.path],
            "rk4 takes fixed steps, and none is given",
            "add time.max_step_us; 0.4 to 1.6 fits the paper's joint",
        ));
    }
    Ok(Integrator {
        method,
        tolerance: document.get(&keys::TOLERANCE)?,
        max_step: document.get(&keys::MAX_STEP)?,
        events: document.get(&keys::EVENTS)?,
    })
}
