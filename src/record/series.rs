//! A series of points of a study over a parameter: those of one start of a sweep, or the orbits of one branch. It has a
//! folder of entities and a tab of its own.

use re_sdk_types::blueprint::archetypes::TimePanelBlueprint;
use re_sdk_types::blueprint::components::{LoopMode, PlayState};

use super::blueprint::layout::{Row, screen_of};
use super::blueprint::tree::{self, Part, View};
use super::panel_view::{PanelView, PanelViews};
use super::paths::{self, Root};
use super::stream::{Moment, RecordingStream, STATIC};
use super::sweep::TimelineTicks;
use super::text;
use crate::plot::Panel;

/// Distance of the eye from the delay embedding.
const EYE: f64 = 4.6;

/// The titles of a series.
pub struct SeriesTitles {
    /// Of its tab.
    pub tab: String,
    /// Of the text about a point.
    pub point: String,
    /// The end of the titles of the pictures.
    pub ending: String,
}

/// A series of points.
pub struct PointSeries {
    /// The folder of its entities.
    pub root: Root,
    titles: SeriesTitles,
    /// The diagrams over the parameter, by their names in the layout.
    diagrams: Vec<(&'static str, Panel)>,
    views: PanelViews,
}

impl PointSeries {
    /// A series with its titles and its diagrams over the parameter.
    pub fn new(root: Root, titles: SeriesTitles, diagrams: Vec<(&'static str, Panel)>) -> Self {
        Self {
            views: PanelViews::new(root.clone()),
            root,
            titles,
            diagrams,
        }
    }

    /// A view by its name in the layout; `None` for a diagram without data.
    pub fn view(&self, name: &str) -> Option<View> {
        let row = Row::of(name)?;
        let values = [
            ("{velocity}", ""),
            ("{displacement}", ""),
            ("{frequency}", "kHz"),
        ];
        let title = row.title_with(&values) + &self.titles.ending;
        let path = self.root.at(row.paths[0]);
        let mut diagrams = self.diagrams.iter();
        if let Some((_, panel)) = diagrams.find(|(diagram, _)| *diagram == name) {
            let panel = panel.clone().with_title(title);
            return Some(PanelView::of(name, &self.root).view(&panel));
        }
        match (row.kind[0], row.needs) {
            ("text", _) => Some(View::of("TextDocument", &*self.titles.point, &path)),
            ("cube", _) => Some(View::cube(title, &path, EYE)),
            (_, "diagram") => None,
            _ => row.picture(title, &self.root),
        }
    }

    /// Draws the diagrams.
    pub fn draw_diagrams(&mut self, rec: &RecordingStream) {
        for (name, panel) in &self.diagrams {
            self.views.of(name).draw(rec, STATIC, panel);
        }
    }

    /// Draws the point at a value of the parameter: its pictures, its text, and the cursor in the diagrams.
    pub fn draw_point(
        &mut self,
        rec: &RecordingStream,
        (at, value): (Moment, f64),
        panels: impl IntoIterator<Item = (&'static str, Panel)>,
        text: String,
    ) {
        for (name, panel) in &self.diagrams {
            self.views.of(name).draw_cursor(rec, at, panel, value);
        }
        for (name, panel) in panels {
            self.views.of(name).draw(rec, at, &panel);
        }
        let path = self.root.at("text");
        rec.log(path, at, &text::document(text));
    }
}

/// Sends the layout: the `compared` tabs, which have several series below each other; a tab for each series; one more tab;
/// and the text about the recording. `playback` has the timeline and the number of points per second during playback; `None`
/// for a recording without points.
pub fn send(
    rec: &RecordingStream,
    all: &[&PointSeries],
    (compared, single): (&[&str], &str),
    more: Option<Part>,
    playback: Option<(&TimelineTicks, f64)>,
) {
    let screen = |key: &str, series: &PointSeries| screen_of(key, &mut |name| series.view(name));
    let mut tabs = Vec::new();
    for key in compared.iter().filter(|_| all.len() > 1) {
        let screens = all.iter().filter_map(|series| screen(key, series));
        let (titles, screens): (Vec<&str>, Vec<Part>) = screens.unzip();
        tabs.extend(titles.first().map(|title| Part::tab(title, screens)));
    }
    for series in all {
        let screen = screen(single, series).map(|(_, screen)| screen);
        tabs.extend(screen.map(|screen| Part::tab(&series.titles.tab, vec![screen])));
    }
    tabs.extend(more);
    let about = View::of("TextDocument", "About this recording", paths::ABOUT);
    tabs.push(Part::tab("About", vec![Part::View(about)]));
    let mut time_panel = TimePanelBlueprint::new()
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    if let Some((timeline, plays)) = playback {
        time_panel = time_panel
            .with_timeline(timeline.name.as_str())
            .with_fps(plays * timeline.gap().abs());
    }
    tree::send(rec, tabs, time_panel);
}
