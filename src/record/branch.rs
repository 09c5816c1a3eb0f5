//! Branches of periodic orbits as one recording, with the parameter as its timeline.
//!
//! Each branch has a folder of entities, `branch/0/...`: the branch diagram with a cursor at the current orbit, the
//! phase portrait of the orbit, its multipliers in the unit circle, and a text. On a branch that turns at folds, the
//! parameter is not unique, and the timeline counts the orbits. The plots are panels of [`crate::plot`].

use std::path::Path;

use super::error::RecordError;
use super::paths::{self, Root};
use super::sdk::TimelineName;
use super::series::{self, PointSeries, SeriesTitles};
use super::stream::{Moment, RecordingStream};
use super::sweep::TimelineTicks;
use super::{file, text};
use crate::plot::{Color, Panel, branch_figure, multipliers_panel, response};
use crate::scene::Scene;
use crate::study::branch::{Branch, OrbitPoint};
use crate::text::branch as words;

/// Application id, different from those of other recordings because the layout differs.
pub const APPLICATION: &str = "squeakscope-branch";

/// Saves a recording of the branches of a scene, with the command line that made them. The file appears under its name only
/// when it is complete.
///
/// # Errors
/// [`RecordError::Create`], [`RecordError::Write`], [`RecordError::Rename`]; an existing file at `path` is then
/// unchanged.
pub fn save_branch(
    path: &Path,
    scene: &Scene,
    branch: &Branch,
    command: &str,
) -> Result<(), RecordError> {
    file::save(path, APPLICATION, |rec| draw(rec, scene, branch, command))
}

/// Logs all branches.
fn draw(rec: &RecordingStream, scene: &Scene, branch: &Branch, command: &str) {
    let courses = courses(branch);
    let diagram = courses
        .first()
        .map(|_| ("branch-diagram", diagram(&scene.name, branch)));
    let series = courses.iter().map(|course| {
        let titles = SeriesTitles {
            tab: format!("Branch {}", course.number),
            point: "Orbit".to_owned(),
            ending: String::new(),
        };
        let diagrams = diagram.clone().into_iter().collect();
        PointSeries::new(Root::of_branch(course.number), titles, diagrams)
    });
    let mut series: Vec<PointSeries> = series.collect();
    let tabs = (&[][..], "branch");
    let all: Vec<&PointSeries> = series.iter().collect();
    let playback = courses.first().map(|first| (&first.timeline, PLAYS));
    series::send(rec, &all, tabs, None, playback);
    let name = format!("{} over {}", scene.name, words::parameter(branch));
    text::send_properties(rec, &name, [&scene.name, &scene.text, command]);
    let about = words::about(branch) + &text::study_about(scene, command);
    rec.log_static(paths::ABOUT, &text::document(about));
    for (course, series) in courses.iter().zip(&mut series) {
        course.draw(rec, branch, series);
    }
}

/// Orbits per second during playback.
const PLAYS: f64 = 8.0;
/// Number of ticks over the interval of the parameter, at least.
const TICKS: f64 = 1e3;

/// A branch with the ticks of its orbits.
struct Course<'a> {
    number: usize,
    orbits: Vec<&'a OrbitPoint>,
    timeline: TimelineTicks,
}

/// The branches with their timelines.
fn courses(branch: &Branch) -> Vec<Course<'_>> {
    let [from, to] = branch.interval;
    let unit = 10f64.powf(((to - from) / TICKS).log10().floor());
    let courses = (0..branch.orbit_branches()).map(|number| {
        let orbits = branch.points.iter();
        let mut orbits: Vec<_> = orbits.filter(|point| point.branch == number).collect();
        let values = orbits.iter().map(|point| point.at.value);
        let mut values: Vec<f64> = values.map(|value| (value / unit).round() * unit).collect();
        if !values.is_sorted() && values.is_sorted_by(|a, b| a >= b) {
            orbits.reverse();
            values.reverse();
        }
        let timeline = if values.is_sorted() {
            TimelineTicks::new(&words::parameter(branch), &branch.unit, &values)
        } else {
            TimelineTicks {
                name: format!("branch {number}, orbit"),
                ticks: (1..).take(orbits.len()).collect(),
            }
        };
        Course {
            number,
            orbits,
            timeline,
        }
    });
    courses.filter(|course| !course.orbits.is_empty()).collect()
}

impl Course<'_> {
    /// Draws the orbits of the branch.
    fn draw(&self, rec: &RecordingStream, branch: &Branch, series: &mut PointSeries) {
        series.draw_diagrams(rec);
        let reach = self.reach();
        let Some(timeline) = rec.check(TimelineName::try_new(&self.timeline.name)) else {
            return;
        };
        for (&point, &tick) in self.orbits.iter().zip(&self.timeline.ticks) {
            let color = if point.orbit.stable {
                Color::Series(0)
            } else {
                Color::Accent
            };
            let panels = [
                (
                    "portrait",
                    response::phase_portrait(&point.orbit.portrait, Some(reach), color),
                ),
                ("multipliers", multipliers_panel(branch, Some(point))),
            ];
            let at = Moment::tick(timeline, tick);
            let text = words::orbit(branch, point);
            series.draw_point(rec, (at, point.at.value), panels, text);
        }
    }

    /// Largest displacement (m) and speed (m/s) of all orbits of the branch, with a margin.
    fn reach(&self) -> [f64; 2] {
        let all = || self.orbits.iter().flat_map(|point| &point.orbit.portrait);
        [0, 1].map(|k| {
            let sizes = all().map(|at| at[k].abs());
            1.05 * sizes.fold(f64::MIN_POSITIVE, f64::max)
        })
    }
}

/// The branch diagram: the first panel of its figure.
fn diagram(scene: &str, branch: &Branch) -> Panel {
    let mut panels = branch_figure(scene, branch).rows.into_iter().flatten();
    panels.next().expect("the figure has panels")
}
