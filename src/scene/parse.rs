//! Parsing of a scene's text to a validated [`Scene`]: first single values, then their consistency.

use std::sync::Arc;

use super::controls;
use super::document::{Document, FromTable, place_in};
use super::edit::put;
use super::error::SceneError;
use super::spec::Scene;
use super::subject::SystemSpec;
use super::tables::{
    Frames, Header, analysis, check_imported_patch, check_sliding, csv, joint, run, small,
};
use crate::joint::ImportedModes;

impl Scene {
    /// Parses and validates the content of a scene file. `file` names it in messages; its stem is the
    /// default name of the scene, and paths in the scene are relative to its folder. In [`Scene::text`] the
    /// content of CSV files replaces their names.
    ///
    /// # Errors
    /// The first fault found, in this order: not text, not TOML, an unknown key, a value that is missing, of
    /// the wrong type or out of range, inconsistent values or files.
    pub fn parse(file: &str, content: impl AsRef<[u8]>) -> Result<Self, SceneError> {
        let text = decoded(file, content.as_ref())?;
        let text = csv::expanded(file, text)?;
        let document = Document::parse(file, &text)?;
        let scene = build(&document, &text)?;
        if let Some(mechanism) = scene.mechanism
            && let Some((problem, remedy)) = mechanism.missing_in(&scene)
        {
            let problem = format!("\"{}\" {problem}", mechanism.name());
            return Err(document.inconsistent("mechanism", &[], problem, remedy));
        }
        controls::check(&document, &scene)?;
        Ok(scene)
    }

    /// As [`Scene::parse`] for a modified text, without reading a known file of modes again. A mechanism that
    /// the modified scene cannot demonstrate is removed.
    pub(super) fn parse_changed(
        file: &str,
        text: &str,
        known: Option<&Arc<ImportedModes>>,
    ) -> Result<Self, SceneError> {
        let text = csv::expanded(file, text)?;
        let mut document = Document::parse(file, &text)?;
        document.known_modes = known;
        let mut scene = build(&document, &text)?;
        let named = scene.mechanism;
        scene.mechanism = named.filter(|mechanism| mechanism.missing_in(&scene).is_none());
        if scene.mechanism != named {
            let mut text = scene.document()?;
            put(&mut text, "mechanism", None);
            scene.text = text.to_string();
        }
        Ok(scene)
    }
}

/// Decodes the content of a file as text.
fn decoded<'a>(file: &str, content: &'a [u8]) -> Result<&'a str, SceneError> {
    let text = std::str::from_utf8(content).map_err(|error| {
        let valid = String::from_utf8_lossy(&content[..error.valid_up_to()]);
        let place = place_in(file, &valid, valid.len());
        let problem = "the scene file is not UTF-8 text";
        SceneError::new(place, problem, "save it as UTF-8")
    })?;
    // Some editors write a byte-order mark, which is not part of the text.
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

fn build(document: &Document<'_>, text: &str) -> Result<Scene, SceneError> {
    let header = Header::read(document.table(""))?;
    let stem = document.path().file_stem().unwrap_or_default();
    let name = header
        .name
        .unwrap_or_else(|| stem.to_string_lossy().into_owned());
    let subject = match small::small(document)? {
        Some(small) => SystemSpec::Small(small),
        None => SystemSpec::Joint(joint::read_joint(document)?),
    };
    let start = run::start(document, &subject)?;
    let frames = Frames::read(document.table("time"))?;
    let scene = Scene {
        title: header.title.unwrap_or_else(|| name.clone()),
        about: header.about.unwrap_or_default(),
        mechanism: header.mechanism,
        controls: controls::read(document)?,
        name,
        text: text.to_owned(),
        start,
        duration: frames.duration,
        sample_rate: frames.sample_rate,
        frame_samples: frames.frame_samples,
        integrator: run::integrator(document)?,
        analysis: analysis::read(document, frames.sample_rate, subject.modes())?,
        record: run::record(document, frames.sample_rate, &subject)?,
        subject,
    };
    if let SystemSpec::Joint(joint) = &scene.subject {
        check_imported_patch(document, joint)?;
        check_sliding(document, joint)?;
    }
    Ok(scene)
}
