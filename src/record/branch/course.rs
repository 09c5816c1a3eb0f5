//! A branch in a recording: its timeline and its plots.

use crate::record::sdk::TimelineName;

use crate::{
    plot::{Color, Layer, Panel, branch_figure, multipliers_panel, response},
    record::{
        blueprint::tree::View,
        error::RecordError,
        panel_view::PanelView,
        paths::{self, Root},
        stream::{self, Moment, RecordingStream},
        sweep::TimelineTicks,
        text,
    },
    scene::Scene,
    study::branch::{Branch, OrbitPoint},
    text::branch as words,
};

/// Number of ticks over the interval of the parameter, at least.
const TICKS: f64 = 1e3;

/// A study of branches to record.
#[derive(Clone, Copy, Debug)]
pub struct BranchStudy<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The result.
    pub branch: &'a Branch,
    /// Displacement (m) and velocity (m/s) at the probe over a period of each orbit of the result.
    pub portraits: &'a [Vec<[f64; 2]>],
    /// The command line.
    pub command: &'a str,
}

/// A branch with the ticks of its orbits.
pub struct Course<'a> {
    /// Number of the branch.
    pub number: usize,
    orbits: Vec<(&'a OrbitPoint, &'a [[f64; 2]])>,
    /// Timeline and ticks.
    pub timeline: TimelineTicks,
}

/// The branches with their timelines.
pub fn courses<'a>(study: &BranchStudy<'a>) -> Vec<Course<'a>> {
    let branch = study.branch;
    let count = branch.orbit_branches();
    let [from, to] = branch.interval;
    let unit = 10f64.powf(((to - from) / TICKS).log10().floor());
    let courses = (0..count).map(|number| {
        let orbits = branch.points.iter().zip(study.portraits);
        let mut orbits: Vec<_> = orbits
            .filter(|(point, _)| point.branch == number)
            .map(|(point, portrait)| (point, &portrait[..]))
            .collect();
        let value = |k: usize| (orbits[k].0.at.value / unit).round() * unit;
        let values: Vec<f64> = (0..orbits.len()).map(value).collect();
        let rises = values.windows(2).all(|pair| pair[0] <= pair[1]);
        let falls = values.windows(2).all(|pair| pair[0] >= pair[1]);
        if !rises && falls {
            orbits.reverse();
        }
        let mut values: Vec<f64> = (0..orbits.len())
            .map(|k| (orbits[k].0.at.value / unit).round() * unit)
            .collect();
        let timeline = if rises || falls {
            let ticks = values.clone();
            values.dedup();
            let distinct = TimelineTicks::new(branch.name(), &branch.unit, &values);
            let tick = |value: &f64| {
                let place = values.iter().position(|own| own == value).unwrap_or(0);
                distinct.ticks[place]
            };
            TimelineTicks {
                ticks: ticks.iter().map(tick).collect(),
                name: distinct.name,
            }
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

/// The view of a plot of a branch.
pub fn picture(study: &BranchStudy<'_>, course: &Course<'_>, name: &str) -> View {
    let views = Views::new(course.number);
    let (view, panel, title) = match name {
        "diagram" => (views.diagram, diagram(study), "Branch diagram"),
        "portrait" => (views.portrait, portrait(course, None), "Phase portrait"),
        _ => (
            views.multipliers,
            multipliers_panel(study.branch, None),
            "Multipliers",
        ),
    };
    view.view(&panel.with_title(title))
}

/// Root of a branch.
pub fn root(number: usize) -> Root {
    Root::of_branch(number)
}

/// The plots of a branch.
struct Views {
    diagram: PanelView,
    portrait: PanelView,
    multipliers: PanelView,
}

impl Views {
    fn new(number: usize) -> Self {
        let view = |name| PanelView::of(name, &root(number));
        Self {
            diagram: view("branch-diagram"),
            portrait: view("portrait"),
            multipliers: view("multipliers"),
        }
    }
}

impl Course<'_> {
    /// Draws the orbits of the branch.
    pub fn draw(&self, rec: &RecordingStream, study: &BranchStudy<'_>) -> Result<(), RecordError> {
        let mut views = Views::new(self.number);
        let diagram = diagram(study);
        views.diagram.draw(rec, None, &diagram)?;
        let plot = views.diagram.plot(&diagram);
        let timeline = TimelineName::try_new(&self.timeline.name)
            .map_err(|error| RecordError::Encode(error.to_string()))?;
        for (&(point, trail), &tick) in self.orbits.iter().zip(&self.timeline.ticks) {
            let at = Moment::tick(timeline, tick);
            let cursor = Layer::vertical_line(point.at.value, Color::Ink).with_id(paths::CURSOR);
            views.diagram.draw_layers(rec, Some(at), &plot, &[cursor])?;
            let panel = portrait(self, Some((point, trail)));
            views.portrait.draw(rec, Some(at), &panel)?;
            let panel = multipliers_panel(study.branch, Some(point));
            views.multipliers.draw(rec, Some(at), &panel)?;
            let document = text::document(words::orbit(study.branch, point));
            stream::log_at(rec, root(self.number).at(paths::POINT_TEXT), at, &document)?;
        }
        Ok(())
    }
}

/// The branch diagram: the first panel of its figure.
fn diagram(study: &BranchStudy<'_>) -> Panel {
    let figure = branch_figure(&study.scene.name, study.branch, &[]);
    let panels = figure.rows.into_iter().flatten();
    panels.take(1).next().expect("the figure has panels")
}

/// The phase portrait of an orbit, on axes that hold all orbits of the branch.
fn portrait(course: &Course<'_>, chosen: Option<(&OrbitPoint, &[[f64; 2]])>) -> Panel {
    let all = || course.orbits.iter().flat_map(|(_, trail)| trail.iter());
    let reach = [0, 1].map(|k| {
        1.05 * all()
            .map(|at| at[k].abs())
            .fold(f64::MIN_POSITIVE, f64::max)
    });
    let (trail, color) = match chosen {
        Some((point, trail)) => (
            trail,
            if point.orbit.stable {
                Color::Series(0)
            } else {
                Color::Accent
            },
        ),
        None => (&[][..], Color::Ink),
    };
    response::phase_portrait(trail, Some(reach), color)
}
