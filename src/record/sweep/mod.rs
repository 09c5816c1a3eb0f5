//! A sweep over one parameter as one recording, with the parameter as the timeline to scrub.
//!
//! For each way of starting there is a folder of entities, `sweep/up/...`, with the settled motion
//! at each value of the parameter: portrait, delay vectors, section, recurrence plot, spectrum, exponents,
//! words; and the bifurcation diagram of all values with a cursor at the present one. Ways of starting
//! stand side by side, so that hysteresis is seen. The pictures are panels of [`crate::plot`], the same that
//! figures on disk are made of.

mod draw;
mod ladder;
mod scope;
mod shapes;
mod study;
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
use crate::study::sweep::SweepPoint;
use draw::Draw;
pub(super) use draw::{Picture, pictures};
pub(super) use ladder::Ladder;
pub(super) use scope::Scope;
pub use study::{APPLICATION, SweepStudy};
pub(super) use words::title;

/// Saves a recording of a sweep. The file takes its name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; what was at `path`
/// before is then unchanged.
pub fn save_sweep(path: &Path, sweep: &SweepStudy<'_>) -> Result<(), RecordError> {
    file_stream::save(path, APPLICATION, |rec| draw(rec, sweep))
}

/// Logs all of a sweep.
fn draw(rec: &RecordingStream, sweep: &SweepStudy<'_>) -> Result<(), RecordError> {
    let scope = Scope::new(sweep);
    let scene = &sweep.plan.scene;
    let name = format!("{} over {}", scene.name, words::parameter(sweep));
    blueprint::send_sweep(rec, sweep, &scope)?;
    let origin = Origin {
        name: &name,
        scene: &scene.name,
        scene_text: &scene.text,
        command: sweep.command,
    };
    text::send_properties(rec, origin)?;
    let about = words::about(sweep, &scope.ladder.name);
    rec.log_static(paths::ABOUT, &text::document(about))?;
    if let Some(ball) = sweep.ball {
        shapes::draw(rec, ball)?;
    }
    let mut draws = Vec::new();
    for start in sweep.starts() {
        draws.push(Draw::new(rec, sweep, start, &scope)?);
    }
    let timeline = TimelineName::try_new(&scope.ladder.name)
        .map_err(|error| RecordError::Encode(error.to_string()))?;
    for (&value, &tick) in sweep.values().iter().zip(&scope.ladder.ticks) {
        let at_value = |point: &&SweepPoint| point.place.values[0] == value;
        let points: Vec<&SweepPoint> = sweep.points.iter().filter(at_value).collect();
        if points.is_empty() {
            continue;
        }
        let found = points
            .iter()
            .filter_map(|point| point.outcome.as_ref().ok());
        let planes = scope.planes(&found.collect::<Vec<_>>());
        for draw in &mut draws {
            draw.draw(rec, Moment::tick(timeline, tick), value, &planes)?;
        }
    }
    Ok(())
}
