//! The cost study as one recording: error over CPU time and over right-hand-side evaluations for each
//! setting.
//!
//! Each setting has a folder of entities, `cost/integrator/...`, with the panels of its figure
//! ([`crate::plot::cost_figures`]) and a text: what is varied, the recommended values, all points as a table.
//! All data are static, and there is no timeline.

mod picture;

#[cfg(test)]
mod tests;

use std::path::Path;

use rerun::{DynamicArchetype, components::Scalar};

use super::{
    blueprint,
    error::RecordError,
    file_stream,
    panel_view::PanelView,
    paths::{self, Root},
    stream::RecordingStream,
    text::{self, Origin},
};
use crate::{
    plot::{WorkMeasure, error_panels},
    study::cost::{CostPlan, CostSetting, CostStudy, WorkPrecisionPoint, WorkPrecisionSet},
    text::cost as words,
};

pub(super) use picture::Picture;

/// Size of the plot area next to another one, and alone, pixels.
const FIELD: [f32; 2] = [520.0, 700.0];
const FIELD_ALONE: [f32; 2] = [1100.0, 700.0];

/// Application id, different from that of runs and sweeps because the layout differs.
pub const APPLICATION: &str = "squeakscope-cost";

/// Saves a recording of the cost study of a plan; `command` is the command line. The file appears under its
/// name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; an existing file at `path` is
/// then unchanged.
pub fn save_cost(
    path: &Path,
    plan: &CostPlan,
    study: &CostStudy,
    command: &str,
) -> Result<(), RecordError> {
    file_stream::save(path, APPLICATION, |rec| draw(rec, plan, study, command))
}

/// The settings that were varied, with their panels.
fn settings(study: &CostStudy) -> Vec<(CostSetting, Vec<Picture>)> {
    let settings = CostSetting::ALL
        .into_iter()
        .map(|setting| (setting, pictures(study, setting)));
    settings
        .filter(|(_, pictures)| !pictures.is_empty())
        .collect()
}

fn pictures(study: &CostStudy, setting: CostSetting) -> Vec<Picture> {
    let root = Root::of_setting(setting.name());
    let panels = error_panels(study, setting);
    let field = if panels.len() > 1 { FIELD } else { FIELD_ALONE };
    let pictures = panels.into_iter().map(|(work, panel)| {
        let (name, path) = match work {
            WorkMeasure::CpuTime => ("Error over CPU time", paths::COST_CPU_TIME),
            WorkMeasure::RhsEvals => (
                "Error over right-hand-side evaluations",
                paths::COST_RHS_EVALS,
            ),
        };
        let view = PanelView::new(root.at(path), field);
        Picture { name, view, panel }
    });
    pictures.collect()
}

/// Logs all settings.
fn draw(
    rec: &RecordingStream,
    plan: &CostPlan,
    study: &CostStudy,
    command: &str,
) -> Result<(), RecordError> {
    let mut settings = settings(study);
    blueprint::send_cost(rec, &settings)?;
    let origin = Origin {
        name: &format!("cost of {}", study.scene),
        scene: &study.scene,
        scene_text: &plan.scene.text,
        command,
    };
    text::send_properties(rec, origin)?;
    let used: Vec<CostSetting> = settings.iter().map(|(setting, _)| *setting).collect();
    let about = format!(
        "{}{}",
        words::about(study, &used),
        text::study_about(&plan.scene, command)
    );
    let about = text::document(about);
    rec.log_static(paths::ABOUT, &about)?;
    for (setting, pictures) in &mut settings {
        let root = Root::of_setting(setting.name());
        let words = text::document(words::setting(study, *setting));
        rec.log_static(root.at(paths::SETTING_TEXT), &words)?;
        for set in study.sets.iter().filter(|set| set.setting == *setting) {
            log_numbers(rec, &root, set)?;
        }
        for Picture { view, panel, .. } in pictures {
            view.draw(rec, None, panel)?;
        }
    }
    Ok(())
}

/// Logs the values of a family, for programs that read the recording.
fn log_numbers(
    rec: &RecordingStream,
    root: &Root,
    set: &WorkPrecisionSet,
) -> Result<(), RecordError> {
    let column = |of: fn(&WorkPrecisionPoint) -> f64| {
        let points = set.points.iter();
        points.map(move |point| Scalar::from(of(point)))
    };
    let error = |point: &WorkPrecisionPoint| *point.error.as_ref().unwrap_or(&f64::NAN);
    let numbers = DynamicArchetype::new("squeakscope.Settings")
        .with_component::<Scalar>("setting", column(|point| point.value))
        .with_component::<Scalar>("cpu_ms", column(|point| 1e3 * point.seconds))
        .with_component::<Scalar>("rhs_evals", column(|point| point.rhs_evals as f64))
        .with_component::<Scalar>("error", column(error));
    rec.log_static(root.at(&paths::cost_numbers(&set.family)), &numbers)
}
