//! Branches of periodic orbits as one recording, with the parameter as its timeline.
//!
//! Each branch has a folder of entities, `branch/0/...`: the branch diagram with a cursor at the current orbit, the
//! phase portrait of the orbit, its multipliers in the unit circle, and a text. On a branch that turns at folds, the
//! parameter is not unique, and the timeline counts the orbits. The plots are panels of [`crate::plot`].

use std::f64::consts::TAU;
use std::path::Path;

use super::error::RecordError;
use super::paths::{self, Root};
use super::sdk::TimelineName;
use super::series::{self, PointSeries, SeriesTitles};
use super::stream::{Moment, RecordingStream};
use super::style::{capitalize, short};
use super::sweep::TimelineTicks;
use super::{file, text};
use crate::number::{counted, fixed, quantity};
use crate::plot::{Color, Panel, branch_figure, multipliers_panel, response};
use crate::report::{Block, Report as _, Table, markdown};
use crate::scene::{Parameter, Scene};
use crate::study::branch::{Branch, OrbitPoint};

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
    let name = format!("{} over {}", scene.name, parameter(branch));
    text::send_properties(rec, &name, [&scene.name, &scene.text, command]);
    let report = markdown(&branch.blocks(&scene.name));
    let about = format!(
        "{report}\n{STABILITY}\n\n{}",
        text::study_about(scene, command)
    );
    rec.log_static(paths::ABOUT, &text::document(about));
    for (course, series) in courses.iter().zip(&mut series) {
        course.draw(rec, branch, series);
    }
}

/// What the multipliers in the views say.
const STABILITY: &str = "An orbit attracts if all its multipliers, except the one at 1, are inside the unit circle. Where \
    one leaves, the motion changes: through 1 at a fold, through -1 at a period doubling, as a complex pair at a \
    Neimark-Sacker point, where a torus is born.";
/// Largest number of multipliers listed.
const MULTIPLIERS: usize = 8;
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
            TimelineTicks::new(&parameter(branch), &branch.unit, &values)
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
            let text = markdown(&orbit(branch, point));
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

/// Name of the parameter without its unit, such as `tilt`, as in a sweep.
fn parameter(branch: &Branch) -> String {
    let parameter = Parameter::named(&branch.parameter);
    parameter.map_or_else(|_| branch.name().to_owned(), Parameter::label)
}

/// The description of an orbit.
fn orbit(branch: &Branch, point: &OrbitPoint) -> Vec<Block> {
    let (orbit, value) = (&point.orbit, short(point.at.value));
    let stability = if orbit.stable {
        "attracting orbit".to_owned()
    } else {
        let outside = counted(orbit.unstable_multipliers, "multiplier");
        format!("repelling orbit, {outside} outside the unit circle")
    };
    let rest = format!(" {value} {}: {stability}", branch.unit);
    let mut blocks = vec![
        Block::heading(capitalize(&parameter(branch)), rest),
        Block::text(format!(
            "{}, amplitude {}",
            quantity(orbit.frequency_hz(), 5, "Hz"),
            quantity(orbit.amplitude, 4, "m"),
        )),
    ];
    blocks.extend(orbit.torus_frequencies_hz().map(|[_, second]| {
        Block::text(format!(
            "The motion beside the orbit turns around it at {}: a second tone grows",
            quantity(second, 4, "Hz")
        ))
    }));
    let table = Table::of(orbit.multipliers.iter().take(MULTIPLIERS))
        .right("magnitude", |it| fixed(it.magnitude(), 6))
        .right("turns per period", |it| fixed(it.angle.abs() / TAU, 5))
        .right("growth, 1/s", |it| {
            fixed(it.growth_per_s(orbit.period_s), 2)
        });
    blocks.push(table.into());
    let error = orbit.trivial_multiplier_error;
    blocks.extend(error.map(|error| Block::text(format!("Error of the multipliers: {error:.0e}"))));
    blocks
}
