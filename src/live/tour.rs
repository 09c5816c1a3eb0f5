//! Guided tours: steps with a sentence, a scene and its settings, views, and the numbers to read in that run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::command::{Promise, Rejected};
use super::session::{check_state, preset_scene, start_commands};
use crate::pipeline::RunState;

/// The tour that ships.
const SHIPPED: &str = include_str!("../../assets/tour/squeak.toml");
/// The bookmarks that ship: steps in any order.
const BOOKMARKS: &str = include_str!("../../assets/tour/bookmarks.toml");

/// A guided tour of live runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tour {
    /// Title.
    pub title: String,
    /// Steps, at least one.
    #[serde(rename(deserialize = "step"))]
    pub steps: Vec<TourStep>,
}

/// A step of a guided tour, or a bookmark: a scene with its settings, and the motion that they lead to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TourStep {
    /// What to say: a large sentence for the audience, or the name of a bookmark.
    #[serde(default)]
    pub say: String,
    /// Name of a preset, or of the first scene of the session, which restarts.
    pub scene: String,
    /// Changed numbers of the scene by their keys, in the units of these: `{ tilt_deg = 1.75 }`.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// Playback speed, ms of simulated time per second; unchanged by default.
    #[serde(default)]
    pub speed_ms_per_s: Option<f64>,
    /// Kick at the start in addition to that of the scene, mm/s; none by default.
    #[serde(default)]
    pub kick_mm_per_s: Option<f64>,
    /// The state to start from; that of the scene by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<RunState>,
    /// The motion that it leads to, if known.
    #[serde(default)]
    pub promise: Option<Promise>,
    /// Views; unchanged by default.
    #[serde(default)]
    pub views: Vec<TourView>,
    /// Quantities to watch: their numbers are read in the run.
    #[serde(default)]
    pub watch: Vec<TourQuantity>,
    /// Notes for the presenter.
    #[serde(default)]
    pub notes: String,
}

/// A view of the page that a tour shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TourView {
    /// Contact patch.
    Patch,
    /// Phase portrait.
    Portrait,
    /// Oscilloscope.
    Scope,
    /// Spectrum.
    Spectrum,
    /// Spectrogram.
    Spectrogram,
    /// Poincaré section.
    Section,
    /// Recurrence plot.
    Recurrence,
    /// Vibrating body.
    Body,
    /// Diagram of the branches.
    Branches,
    /// Pictures of the lesson.
    Lesson,
}

/// A quantity that a tour reads in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TourQuantity {
    /// Type of motion.
    Motion,
    /// Strongest spectral lines.
    Lines,
    /// Spectral lines at halves of the others, after a doubling.
    Halves,
    /// Difference of the two base frequencies.
    Difference,
    /// Peak velocity of the probe.
    PeakVelocity,
    /// Tilt of the load.
    Tilt,
    /// Contact nodes in each state.
    Nodes,
}

/// A tour cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("the tour `{}`: {reason}", path.display())]
pub struct TourError {
    path: PathBuf,
    reason: String,
}

impl Tour {
    /// The tour that ships.
    pub fn shipped() -> Option<Self> {
        toml_edit::de::from_str(SHIPPED).ok()
    }

    /// The bookmarks that ship.
    pub fn bookmarks() -> Option<Self> {
        toml_edit::de::from_str(BOOKMARKS).ok()
    }

    /// Reads a tour from a TOML file.
    ///
    /// # Errors
    /// [`TourError`], with the line or the step.
    pub fn read(path: &Path) -> Result<Self, TourError> {
        let fault = |reason: String| TourError {
            path: path.to_owned(),
            reason,
        };
        let text = std::fs::read_to_string(path).map_err(|e| fault(e.to_string()))?;
        let tour: Self = toml_edit::de::from_str(&text).map_err(|e| {
            // The first line of the error is the place; the others draw it.
            let place = e.to_string();
            fault(format!(
                "{}: {}",
                place.lines().next().unwrap_or_default(),
                e.message()
            ))
        })?;
        if tour.steps.is_empty() {
            let reason = "it has no steps; add a table `[[step]]`";
            return Err(fault(reason.to_owned()));
        }
        for (k, step) in tour.steps.iter().enumerate() {
            let failed = |reason| fault(format!("step {}: {reason}", k + 1));
            step.check().map_err(failed)?;
        }
        Ok(tour)
    }
}

impl TourStep {
    /// A scene as it is.
    pub(super) fn of_scene(name: &str) -> Self {
        Self {
            scene: name.to_owned(),
            ..Self::default()
        }
    }

    /// Checks the values as the command that opens the step does.
    fn check(&self) -> Result<(), Rejected> {
        if self.say.is_empty() {
            return Err(Rejected("`say` is missing".to_owned()));
        }
        let scene = preset_scene(&self.scene)?;
        check_state(&scene, self.state.as_ref())?;
        start_commands(&scene, self).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_tour_and_bookmarks_are_valid() {
        for text in [SHIPPED, BOOKMARKS] {
            let tour: Tour = toml_edit::de::from_str(text).unwrap();
            assert!(!tour.steps.is_empty());
            tour.steps.iter().for_each(|step| step.check().unwrap());
            assert!(tour.steps.iter().all(|step| !step.views.is_empty()));
        }
    }

    #[test]
    fn a_wrong_tour_is_refused_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.toml");
        let refused = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Tour::read(&path).unwrap_err().to_string()
        };
        let scene = "scene = \"doubled-torus-3deg\"";
        let step = |more: &str| refused(&format!("title = \"x\"\n[[step]]\nsay = \"y\"\n{more}"));
        for (said, part) in [
            (refused("title = \"x\"\nstep = []"), "no steps"),
            (refused("title = 3"), "line 1"),
            (step("scene = \"absent\""), "step 1: unknown scene"),
            (
                step(&format!("{scene}\nspeed_ms_per_s = 1e6")),
                "between 0.01 and 1000",
            ),
            (step(&format!("{scene}\nviews = [\"ghost\"]")), "line 5"),
            (step("tilt = 3"), "unknown field `tilt`"),
            (
                step(&format!("{scene}\nset = {{ tilt_deg = 40 }}")),
                "step 1: the tilt must be between 0 and 10 deg",
            ),
        ] {
            assert!(said.contains(part) && said.contains("own.toml"), "{said}");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(Tour::read(&path).is_err());
    }
}
