//! What accuracy costs as one recording: error over CPU time and over calls, knob by knob.
//!
//! For each knob there is a folder of entities, `cost/integrator/...`, with the panels of its figure
//! ([`crate::plot::cost_figures`]) and words: what is turned, the cheapest settings, all points as a table.
//! Nothing changes with time: everything is static, and there is no timeline.

mod picture;

#[cfg(test)]
mod tests;

use std::path::Path;

use rerun::{DynamicArchetype, components::Scalar};

use super::{
    blueprint,
    error::RecordError,
    figure::View,
    file_stream,
    paths::{self, Root},
    stream::RecordingStream,
    text::{self, Origin},
};
use crate::{
    plot::{Work, error_panels},
    study::cost::{CostPlan, CostPoint, CostSet, CostStudy, Knob},
    text::cost as words,
};

pub(super) use picture::Picture;

/// The field of a picture beside another, and of one alone, pixels.
const FIELD: [f32; 2] = [520.0, 700.0];
const FIELD_ALONE: [f32; 2] = [1100.0, 700.0];

/// Application name: not that of runs and sweeps, whose screens in the viewer are others.
pub const APPLICATION: &str = "squeakscope-cost";

/// Saves a recording of what accuracy costs by a plan; `command` is how the program was started. The file
/// takes its name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; what was at `path`
/// before is then unchanged.
pub fn save_cost(
    path: &Path,
    plan: &CostPlan,
    study: &CostStudy,
    command: &str,
) -> Result<(), RecordError> {
    file_stream::save(path, APPLICATION, |rec| draw(rec, plan, study, command))
}

/// The knobs that were turned, with their pictures.
fn knobs(study: &CostStudy) -> Vec<(Knob, Vec<Picture>)> {
    let knobs = Knob::ALL
        .into_iter()
        .map(|knob| (knob, pictures(study, knob)));
    knobs.filter(|(_, pictures)| !pictures.is_empty()).collect()
}

fn pictures(study: &CostStudy, knob: Knob) -> Vec<Picture> {
    let root = Root::of_knob(knob.name());
    let panels = error_panels(study, knob);
    let field = if panels.len() > 1 { FIELD } else { FIELD_ALONE };
    let pictures = panels.into_iter().map(|(work, panel)| {
        let (name, path) = match work {
            Work::Time => ("Error over CPU time", paths::COST_TIME),
            Work::Calls => ("Error over calls of the right-hand side", paths::COST_CALLS),
        };
        let view = View::new(root.at(path), field);
        Picture { name, view, panel }
    });
    pictures.collect()
}

/// Logs all knobs.
fn draw(
    rec: &RecordingStream,
    plan: &CostPlan,
    study: &CostStudy,
    command: &str,
) -> Result<(), RecordError> {
    let mut knobs = knobs(study);
    blueprint::send_cost(rec, &knobs)?;
    let origin = Origin {
        name: &format!("cost of {}", study.scene),
        scene: &study.scene,
        scene_text: &plan.scene.text,
        command,
    };
    text::send_properties(rec, origin)?;
    let turned: Vec<Knob> = knobs.iter().map(|(knob, _)| *knob).collect();
    let about = format!(
        "{}{}",
        words::about(study, &turned),
        text::study_about(&plan.scene, command)
    );
    let about = text::document(about);
    rec.log_static(paths::ABOUT, &about)?;
    for (knob, pictures) in &mut knobs {
        let root = Root::of_knob(knob.name());
        let words = text::document(words::knob(study, *knob));
        rec.log_static(root.at(paths::KNOB_WORDS), &words)?;
        for set in study.sets.iter().filter(|set| set.knob == *knob) {
            log_numbers(rec, &root, set)?;
        }
        for Picture { view, panel, .. } in pictures {
            view.draw(rec, None, panel)?;
        }
    }
    Ok(())
}

/// The numbers of a family of settings, for those who read the recording rather than look at it.
fn log_numbers(rec: &RecordingStream, root: &Root, set: &CostSet) -> Result<(), RecordError> {
    let column = |of: fn(&CostPoint) -> f64| {
        let points = set.points.iter();
        points.map(move |point| Scalar::from(of(point)))
    };
    let error = |point: &CostPoint| *point.error.as_ref().unwrap_or(&f64::NAN);
    let numbers = DynamicArchetype::new("squeakscope.Settings")
        .with_component::<Scalar>("setting", column(|point| point.value))
        .with_component::<Scalar>("cpu_ms", column(|point| 1e3 * point.seconds))
        .with_component::<Scalar>("calls", column(|point| point.calls as f64))
        .with_component::<Scalar>("error", column(error));
    rec.log_static(root.at(&paths::cost_numbers(&set.family)), &numbers)
}
