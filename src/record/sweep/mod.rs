//! A sweep over one parameter as one recording with the parameter as its timeline.
//!
//! Each start has a folder of entities, `sweep/upward/...`, with the steady-state motion at each parameter value:
//! phase portrait, delay embedding, Poincaré section, recurrence plot, spectrum, exponents and text, and the
//! bifurcation diagram with a cursor at the current value. The starts are shown side by side, which makes
//! hysteresis visible. The plots are panels of [`crate::plot`], as in the figures on disk.

mod description;
mod draw;
mod mode_shapes;
mod scales;
mod study;
mod timeline;

#[cfg(test)]
mod tests;

use std::path::Path;

use crate::record::sdk::TimelineName;

use super::{
    blueprint,
    error::RecordError,
    file, paths,
    stream::{Moment, RecordingStream},
    text::{self, Origin},
};
use crate::study::sweep::SweepPoint;
pub(super) use description::title;
use draw::StartWriter;
pub(super) use draw::picture;
pub(super) use scales::SharedScales;
pub use study::{APPLICATION, SweepStudy};
pub(super) use timeline::TimelineTicks;

/// Saves a recording of a sweep. The file appears under its name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; an existing file at `path` is
/// then unchanged.
pub fn save_sweep(path: &Path, sweep: &SweepStudy<'_>) -> Result<(), RecordError> {
    file::save(path, APPLICATION, |rec| draw(rec, sweep))
}

/// Logs a sweep.
fn draw(rec: &RecordingStream, sweep: &SweepStudy<'_>) -> Result<(), RecordError> {
    let scales = SharedScales::new(sweep);
    let scene = &sweep.plan.scene;
    let name = format!("{} over {}", scene.name, description::parameter(sweep));
    blueprint::send_sweep(rec, sweep, &scales)?;
    let origin = Origin {
        name: &name,
        scene: &scene.name,
        scene_text: &scene.text,
        command: sweep.command,
    };
    text::send_properties(rec, origin)?;
    let about = description::about(sweep, &scales.timeline.name);
    rec.log_static(paths::ABOUT, &text::document(about))?;
    if let Some(ball) = sweep.ball {
        mode_shapes::draw(rec, ball)?;
    }
    let mut writers = Vec::new();
    for start in sweep.starts() {
        writers.push(StartWriter::new(rec, sweep, start, &scales)?);
    }
    let timeline = TimelineName::try_new(&scales.timeline.name)
        .map_err(|error| RecordError::Encode(error.to_string()))?;
    for (&value, &tick) in sweep.values().iter().zip(&scales.timeline.ticks) {
        let at_value = |point: &&SweepPoint| point.place.values[0] == value;
        let points: Vec<&SweepPoint> = sweep.points.iter().filter(at_value).collect();
        if points.is_empty() {
            continue;
        }
        let found = points
            .iter()
            .filter_map(|point| point.outcome.as_ref().ok());
        let point_scales = scales.point_scales(&found.collect::<Vec<_>>());
        for draw in &mut writers {
            draw.draw(rec, Moment::tick(timeline, tick), value, &point_scales)?;
        }
    }
    Ok(())
}
