//! Branches of periodic orbits as one recording, with the parameter as its timeline.
//!
//! Each branch has a folder of entities, `branch/0/...`: the branch diagram with a cursor at the current orbit, the
//! phase portrait of the orbit, its multipliers in the unit circle, and a text. On a branch that turns at folds, the
//! parameter is not unique, and the timeline counts the orbits. The plots are panels of [`crate::plot`].

mod course;

use std::path::Path;

use super::{
    blueprint,
    error::RecordError,
    file, paths,
    stream::RecordingStream,
    text::{self, Origin},
};
use crate::text::branch as words;

pub use course::BranchStudy;
use course::courses;
pub(super) use course::{Course, picture, root};

/// Application id, different from those of other recordings because the layout differs.
pub const APPLICATION: &str = "squeakscope-branch";

/// Saves a recording of branches. The file appears under its name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; an existing file at `path` is then
/// unchanged.
pub fn save_branch(path: &Path, study: &BranchStudy<'_>) -> Result<(), RecordError> {
    file::save(path, APPLICATION, |rec| draw(rec, study))
}

/// Logs all branches.
fn draw(rec: &RecordingStream, study: &BranchStudy<'_>) -> Result<(), RecordError> {
    let courses = courses(study);
    blueprint::send_branch(rec, study, &courses)?;
    let scene = study.scene;
    let origin = Origin {
        name: &format!("{} over {}", scene.name, study.branch.parameter),
        scene: &scene.name,
        scene_text: &scene.text,
        command: study.command,
    };
    text::send_properties(rec, origin)?;
    let about = words::about(study.branch) + &text::study_about(scene, study.command);
    rec.log_static(paths::ABOUT, &text::document(about))?;
    courses
        .iter()
        .try_for_each(|course| course.draw(rec, study))
}
