//! A sweep over one parameter as one recording, with the parameter as the timeline to scrub.
//!
//! For each way of starting there is a folder of entities, `sweep/up/...`, with the settled motion
//! at each value of the parameter: portrait, delay vectors, section, recurrence plot, spectrum, exponents,
//! words; and the bifurcation diagram of all values with a cursor at the present one. Ways of starting
//! stand side by side, so that hysteresis is seen.

mod draw;
mod ladder;
mod scope;
mod shapes;
mod view;
mod words;

#[cfg(test)]
mod tests;

use std::path::Path;

use rerun::TimelineName;

use super::{
    blueprint,
    error::RecordError,
    file_stream, paths,
    stream::{Moment, RecordingStream},
    text::{self, Origin},
};
use draw::{Draw, Frame};
pub(super) use ladder::Ladder;
pub(super) use scope::{Scope, square};
pub use view::{
    BodyView, MotionView, ParameterView, PointView, ResponseView, ShapeView, StartView, SweepView,
    UnstableMode,
};
pub(super) use words::title;

/// Application name: not that of runs, whose screen in the viewer is another.
pub const APPLICATION: &str = "squeakscope-sweep";

/// Saves a recording of a sweep. The file takes its name only when it is whole.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; what was at `path`
/// before is then unchanged.
pub fn save_sweep(path: &Path, sweep: &SweepView) -> Result<(), RecordError> {
    file_stream::save(path, APPLICATION, |rec| draw(rec, sweep))
}

/// Logs all of a sweep.
fn draw(rec: &RecordingStream, sweep: &SweepView) -> Result<(), RecordError> {
    let scope = Scope::new(sweep);
    let name = format!("{} over {}", sweep.scene, sweep.parameter.name);
    blueprint::send_sweep(rec, sweep, &scope)?;
    let origin = Origin {
        name: &name,
        scene: &sweep.scene,
        scene_text: &sweep.scene_text,
        command: &sweep.command,
    };
    text::send_properties(rec, origin)?;
    let about = words::about(sweep, &scope.ladder.name);
    rec.log_static(paths::ABOUT, &text::document(about))?;
    if let Some(body) = &sweep.body {
        shapes::draw(rec, body)?;
    }
    let mut starts = Vec::new();
    for start in &sweep.starts {
        starts.push(Draw::new(rec, sweep, start, &scope)?);
    }
    let timeline = TimelineName::try_new(&scope.ladder.name)
        .map_err(|error| RecordError::Encode(error.to_string()))?;
    for (&value, &tick) in sweep.values.iter().zip(&scope.ladder.ticks) {
        let points = sweep.starts.iter().filter_map(|start| start.at(value));
        let points: Vec<&PointView> = points.collect();
        if points.is_empty() {
            continue;
        }
        let found = points
            .iter()
            .filter_map(|point| point.outcome.as_ref().ok());
        let frame = Frame::new(&scope, &found.collect::<Vec<_>>());
        for start in &mut starts {
            start.draw(rec, Moment::tick(timeline, tick), value, &frame)?;
        }
    }
    Ok(())
}
