//! The plots of a sweep, for each start.

use crate::record::sdk::{LineStrips3D, Radius};

use super::{SweepStudy, description, scales::SharedScales};
use crate::plot::response::{self, recurrence_caption, samples, section};
use crate::plot::{self, Color, Layer, Panel, ParameterPanels, SectionAxes, Unit};
use crate::record::paths::{self, Root};
use crate::record::portrait;
use crate::record::series::{PointSeries, SeriesTitles};
use crate::record::stream::{Moment, RecordingStream};
use crate::record::style::capitalize;
use crate::study::response::{SettledResponse, section_lag};
use crate::study::sweep::{Start, SweepPoint};

/// Notes of plots without data.
const NOTHING_MOVES: &str = "no vibration";
const NO_RESPONSE: &str = "no response";
const NOT_DONE: &str = "not computed yet";
const NOT_KEPT: &str = "motion not stored";
const TOO_SHORT: &str = "motion too short";

/// Writer of the points of one start.
pub struct StartWriter<'a> {
    sweep: &'a SweepStudy<'a>,
    start: Start,
    scales: &'a SharedScales,
    pub series: PointSeries,
}

impl<'a> StartWriter<'a> {
    /// The writer of a start.
    pub fn new(sweep: &'a SweepStudy<'a>, start: Start, scales: &'a SharedScales) -> Self {
        let panels = ParameterPanels::new(sweep.plan, sweep.points, &[start]);
        let exponents = panels.exponents(usize::MAX);
        let exponents = exponents.map(|panel| ("exponents", panel));
        let diagrams = [("diagram", diagram(sweep, start, panels.maxima()))];
        let diagrams = diagrams.into_iter().chain(exponents).collect();
        let label = plot::start_label(start);
        let titles = SeriesTitles {
            tab: capitalize(label),
            point: capitalize(label),
            ending: format!(": {label}"),
        };
        Self {
            sweep,
            start,
            scales,
            series: PointSeries::new(Root::of_start(&start.to_string()), titles, diagrams),
        }
    }

    /// Draws the point at a parameter value.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: Moment,
        value: f64,
        (reach, axes): &([f64; 2], SectionAxes),
    ) {
        let point = self.sweep.at(self.start, value);
        let found = point.and_then(SweepPoint::found);
        let missing = match (point, found) {
            (None, _) => NOT_DONE,
            (Some(_), None) => NO_RESPONSE,
            _ => "",
        };
        let motion = found.and_then(|found| found.portrait.as_ref());
        let unkept = match found {
            Some(_) if motion.is_none() => NOT_KEPT,
            _ => missing,
        };
        let still = match found {
            Some(found) if found.maxima_m.is_empty() && unkept.is_empty() => NOTHING_MOVES,
            _ => unkept,
        };
        let unmoved = match found {
            Some(found) if found.section_m.is_empty() => NOTHING_MOVES,
            _ => missing,
        };
        let panels = [
            ("portrait", phase(found, *reach).with_note(still)),
            ("section", section(axes, found).with_note(unmoved)),
            ("spectrum", spectrum(self.scales, found).with_note(unkept)),
            ("recurrence-of-point", recurrence(rec, found, still)),
        ];
        let text = description::point(self.sweep, self.start, value, point);
        self.series.draw_point(rec, (at, value), panels, text);
        self.embedding(rec, at, reach[0], found);
    }

    /// The delay embedding in three dimensions, Eq. (25), in a cube.
    fn embedding(
        &self,
        rec: &RecordingStream,
        at: Moment,
        reach: f64,
        found: Option<&SettledResponse>,
    ) {
        let range = format!("±{}", Unit::write(reach, "m"));
        let names = portrait::delay_names(self.sweep.letter(), &range);
        portrait::draw_cube(rec, &self.series.root, at, &names);
        let lag = section_lag(&self.sweep.plan.subject);
        let trail = found.and_then(|found| {
            let motion = found.portrait.as_ref()?;
            let lag = ((lag / motion.dt_s).round() as usize).max(1);
            let unit = |u: f32| u / reach as f32;
            // A delay vector starts with the latest sample.
            let points = motion.u_m.windows(2 * lag + 1);
            let points = points.map(|w| [w[2 * lag], w[lag], w[0]].map(unit));
            Some((points.collect::<Vec<_>>(), Color::Regime(found.regime)))
        });
        let strips = trail.iter().map(|(points, _)| points);
        let lines = LineStrips3D::new(strips)
            .with_colors(trail.iter().map(|(_, color)| *color))
            .with_radii([Radius::new_ui_points(0.7)]);
        rec.log(self.series.root.at(paths::EMBEDDING_TRAIL), at, &lines);
    }
}

/// The bifurcation diagram, with marks for failed runs.
fn diagram(sweep: &SweepStudy<'_>, start: Start, mut panel: Panel) -> Panel {
    let points = sweep.points.iter();
    let of_start = points.filter(|point| point.place.start == start);
    let failed = of_start.filter(|point| point.outcome.is_err());
    let failed = failed.map(|point| [point.place.values[0], panel.y.range[0]]);
    let failed = Layer::points(failed.collect(), 1.5, Color::Faint).with_label("no response");
    let layers = &mut panel.layers;
    layers.extend(Some(failed).filter(Layer::has_points));
    panel
}

/// The phase portrait of a response; a single point without vibration.
fn phase(found: Option<&SettledResponse>, reach: [f64; 2]) -> Panel {
    let motion = found.and_then(|found| found.portrait.as_ref());
    let trail = motion.map_or_else(Vec::new, samples);
    let color = found.map_or(Color::Ink, |found| Color::Regime(found.regime));
    let mut panel = response::phase_portrait(&trail, Some(reach), color);
    let still = found.is_some_and(|found| found.maxima_m.is_empty());
    let last = trail.last().copied().filter(|_| still);
    let last = Layer::points(last.into_iter().collect(), 3.3, Color::Ink);
    panel.layers.push(last.with_id("now"));
    panel
}

/// The spectrum of a response.
fn spectrum(scales: &SharedScales, found: Option<&SettledResponse>) -> Panel {
    let lines = found.map_or(&[][..], |found| &found.lines);
    match found.and_then(|found| found.portrait.as_ref()) {
        Some(motion) => response::motion_spectrum(&scales.spectrum, motion, lines),
        None => response::spectrum(&scales.spectrum, 1.0, [], lines, Color::Faint),
    }
}

/// The recurrence plot of a response, or the reason why there is none.
fn recurrence(rec: &RecordingStream, found: Option<&SettledResponse>, note: &str) -> Panel {
    // The recurrence plot of a constant signal would show rounding errors.
    let moving = found.filter(|_| note.is_empty());
    let moving = moving.and_then(|found| found.portrait.as_ref());
    let plot = moving.and_then(|motion| rec.check(motion.recurrence())?);
    let caption = match &plot {
        Some(plot) => recurrence_caption(plot, "m"),
        None if note.is_empty() => TOO_SHORT.to_owned(),
        None => note.to_owned(),
    };
    response::recurrence(plot.as_ref(), true).with_caption(caption)
}
