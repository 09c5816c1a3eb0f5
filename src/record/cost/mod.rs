//! What accuracy costs as one recording: error over CPU time and over calls, knob by knob.
//!
//! For each knob there is a folder of entities, `cost/integrator/...`, with two pictures on logarithmic
//! axes and words: what is turned, the cheapest settings, all points as a table. Nothing changes with
//! time: everything is static, and there is no timeline.

mod draw;
mod scope;
mod view;
mod words;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::{
    blueprint,
    error::RecordError,
    file_stream,
    paths::{self, Root},
    stream::RecordingStream,
    text::{self, Origin},
};
pub(super) use draw::default_looks;
use draw::{draw_picture, log_numbers};
pub(super) use scope::Scope;
pub use view::{AdviceView, CostView, FamilyView, KnobView, SettingView};

/// Application name: not that of runs and sweeps, whose screens in the viewer are others.
pub const APPLICATION: &str = "squeakscope-cost";

/// Saves a recording of what accuracy costs. The file takes its name only when it is whole.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; what was at `path`
/// before is then unchanged.
pub fn save_cost(path: &Path, cost: &CostView) -> Result<(), RecordError> {
    file_stream::save(path, APPLICATION, |rec| draw(rec, cost))
}

/// Logs all knobs.
fn draw(rec: &RecordingStream, cost: &CostView) -> Result<(), RecordError> {
    let scopes: Vec<Scope> = cost.knobs.iter().map(Scope::new).collect();
    blueprint::send_cost(rec, cost, &scopes)?;
    let name = format!("cost of {}", cost.scene);
    let origin = Origin {
        name: &name,
        scene: &cost.scene,
        scene_text: &cost.scene_text,
        command: &cost.command,
    };
    text::send_properties(rec, origin)?;
    let about = text::document(words::about(cost));
    rec.log_static(paths::ABOUT, &about)?;
    for (knob, scope) in cost.knobs.iter().zip(&scopes) {
        let root = Root::of_knob(knob.name);
        let words = text::document(words::knob(cost, knob));
        rec.log_static(root.at(paths::KNOB_WORDS), &words)?;
        log_numbers(rec, &root, knob)?;
        for picture in &scope.pictures {
            draw_picture(rec, &root, knob, picture)?;
        }
    }
    Ok(())
}
