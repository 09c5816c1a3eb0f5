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
mod timeline;

#[cfg(test)]
mod tests;

use std::path::Path;

use crate::record::sdk::TimelineName;

use super::error::RecordError;
use super::series::{self, PointSeries};
use super::stream::{Moment, RecordingStream};
use super::{file, paths, text};
use crate::joint::BallJoint;
use crate::report::Block;
use crate::study::sweep::{Start, SweepPlan, SweepPoint};
use draw::StartWriter;
use scales::SharedScales;
pub(super) use timeline::TimelineTicks;

/// Application id, different from that of runs because the layout differs.
pub const APPLICATION: &str = "squeakscope-sweep";

/// The tabs that compare the starts, and that of a start.
const TABS: (&[&str], &str) = (&["starts-in-phase-space", "starts-in-frequency"], "start");
/// Parameter values per second during playback.
const PLAYS: f64 = 1.5;

/// A complete or partial sweep over one parameter.
#[derive(Clone, Copy)]
pub struct SweepStudy<'a> {
    /// Parameter, values and starts.
    pub plan: &'a SweepPlan,
    /// The computed points.
    pub points: &'a [SweepPoint],
    /// The report of the study.
    pub report: &'a [Block],
    /// The command line.
    pub command: &'a str,
    /// Ball and beam, if their natural modes are shown.
    pub ball: Option<&'a BallJoint>,
}

impl<'a> SweepStudy<'a> {
    /// The starts that have points.
    pub fn starts(&self) -> impl Iterator<Item = Start> + 'a {
        let points = self.points;
        let starts = self.plan.starts.iter().copied();
        starts.filter(move |start| points.iter().any(|point| point.place.start == *start))
    }

    /// The values of the parameter, in its unit.
    pub fn values(&self) -> &'a [f64] {
        &self.plan.axes[0].values
    }

    /// The point of a start at a parameter value.
    pub fn at(&self, start: Start, value: f64) -> Option<&'a SweepPoint> {
        let is_there =
            |point: &&SweepPoint| point.place.start == start && point.place.values[0] == value;
        self.points.iter().find(is_there)
    }

    /// Symbol of the displacement.
    pub fn letter(&self) -> &'static str {
        match self.plan.subject.joint() {
            Ok(_) => "u",
            Err(_) => "x",
        }
    }
}

/// Saves a recording of a sweep. The file appears under its name only when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; an existing file at `path` is
/// then unchanged.
pub fn save_sweep(path: &Path, sweep: &SweepStudy<'_>) -> Result<(), RecordError> {
    file::save(path, APPLICATION, |rec| draw(rec, sweep))
}

/// Logs a sweep.
fn draw(rec: &RecordingStream, sweep: &SweepStudy<'_>) {
    let scales = SharedScales::new(sweep);
    let scene = &sweep.plan.subject;
    let name = format!("{} over {}", scene.name, description::parameter(sweep));
    let starts = sweep.starts();
    let writers = starts.map(|start| StartWriter::new(sweep, start, &scales));
    let mut writers: Vec<StartWriter<'_>> = writers.collect();
    let all: Vec<&PointSeries> = writers.iter().map(|writer| &writer.series).collect();
    let shapes = sweep.ball.and_then(mode_shapes::tab);
    let playback = Some((&scales.timeline, PLAYS));
    series::send(rec, &all, TABS, shapes, playback);
    text::send_properties(rec, &name, [&scene.name, &scene.text, sweep.command]);
    let about = description::about(sweep, &scales.timeline.name);
    rec.log_static(paths::ABOUT, &text::document(about));
    if let Some(ball) = sweep.ball {
        mode_shapes::draw(rec, ball);
    }
    for writer in &mut writers {
        writer.series.draw_diagrams(rec);
    }
    let Some(timeline) = rec.check(TimelineName::try_new(&scales.timeline.name)) else {
        return;
    };
    for (&value, &tick) in sweep.values().iter().zip(&scales.timeline.ticks) {
        let at_value = |point: &&SweepPoint| point.place.values[0] == value;
        let points: Vec<&SweepPoint> = sweep.points.iter().filter(at_value).collect();
        if points.is_empty() {
            continue;
        }
        let found = points.iter().filter_map(|point| point.found());
        let point_scales = scales.point_scales(&found.collect::<Vec<_>>());
        for writer in &mut writers {
            writer.draw(rec, Moment::tick(timeline, tick), value, &point_scales);
        }
    }
}
