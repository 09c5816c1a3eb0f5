//! The text next to the plots of a sweep.

use super::SweepStudy;
use crate::{
    plot,
    record::{style::capitalize, text},
    report::Table,
    scene::Parameter,
    study::sweep::{Shard, Start, SweepPoint},
    text::sweep as words,
};

/// Name of the swept parameter without the unit, so `load.tilt_deg` is `tilt`.
pub fn parameter(sweep: &SweepStudy<'_>) -> String {
    let parameter = sweep.plan.axes[0].parameter();
    parameter.map_or_else(|_| String::new(), Parameter::label)
}

/// The unit of the swept parameter; empty for a dimensionless number.
pub fn unit(sweep: &SweepStudy<'_>) -> &'static str {
    sweep.plan.axes[0].unit()
}

/// The parameter value whose steady state is the initial state of a point; `None` for the scene's kick.
fn origin(sweep: &SweepStudy<'_>, point: &SweepPoint) -> Option<f64> {
    let chains = sweep.plan.chains(Shard::WHOLE);
    let mut pairs = chains.iter().flat_map(|chain| chain.windows(2));
    let before = pairs.find(|pair| pair[1] == point.place.index)?[0];
    // A failed run has no state to continue from.
    let known = sweep.points.iter().filter(|point| point.outcome.is_ok());
    let mut known = known.filter(|point| point.place.index == before);
    known.next().map(|point| point.place.values[0])
}

/// A value with its unit.
fn with_unit(sweep: &SweepStudy<'_>, value: f64) -> String {
    let unit = match unit(sweep) {
        "um" => "µm",
        "us" => "µs",
        unit => unit,
    };
    // All digits, as specified by the user.
    format!("{value} {unit}").trim_end().to_owned()
}

/// Name of a start as a title.
pub fn title(start: Start) -> String {
    capitalize(plot::start_label(start))
}

/// Description of the point at a parameter value.
pub fn point(
    sweep: &SweepStudy<'_>,
    start: Start,
    value: f64,
    point: Option<&SweepPoint>,
) -> String {
    let origin = point.and_then(|point| origin(sweep, point));
    let place = words::PointPlace {
        parameter: &parameter(sweep),
        value: with_unit(sweep, value),
        start: plot::start_label(start),
        origin: origin.map(|value| with_unit(sweep, value)),
    };
    words::point(&place, point)
}

/// Description of the whole sweep.
pub fn about(sweep: &SweepStudy<'_>, timeline: &str) -> String {
    let scene = &sweep.plan.scene;
    let axis = sweep.plan.axes.first();
    let label = axis.map_or_else(String::new, |axis| axis.label());
    let points = Table::of(sweep.values()).right(label, |value| value.to_string());
    let points = sweep.starts().fold(points, |points, start| {
        points.left(start.to_string(), |value| kind(sweep.at(start, **value)))
    });
    let origin = text::study_about(scene, sweep.command);
    words::about(
        scene,
        &parameter(sweep),
        timeline,
        &points.markdown(),
        &origin,
    )
}

/// The type of motion of a point in one word.
fn kind(point: Option<&SweepPoint>) -> String {
    let Some(point) = point else {
        return "–".to_owned();
    };
    let mark = if point.is_unsettled() { "\\*" } else { "" };
    format!("{}{mark}", point.regime_name())
}
