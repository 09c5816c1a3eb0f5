//! From the text of a scene to a validated [`Scene`]: values by key first, then what must fit together.

use std::sync::Arc;

use super::document::{Document, FromTable, line_of};
use super::edit::with_knots;
use super::error::{Fault, Place, SceneError};
use super::spec::Scene;
use super::subject::SubjectSpec;
use super::tables::{
    Frames, Header, SCHEMA, accuracy, analysis, joint, load, mechanism, patch_stays, run, sliding,
    small,
};
use crate::joint::OwnModes;

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
        let document = Document::parse(file, text, &SCHEMA)?;
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
        let mut scene = build(&Document::parse(file, text, &SCHEMA)?, file, text, known)?;
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
    let start = run::start(document, &subject)?;
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
        integrator: run::integrator(document)?,
        advice: accuracy::advice(document)?,
        analysis: analysis::read(document, frames.sample_rate, subject.modes())?,
        record: run::record(document, frames.sample_rate, &subject)?,
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
