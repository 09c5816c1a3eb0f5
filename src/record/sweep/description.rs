//! The text next to the plots of a sweep.

use minijinja::context;
use minijinja::value::{Serde, Value};

use super::SweepStudy;
use crate::analysis::regime::Regime;
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::number::with_error;
use crate::record::text;
use crate::report::Table;
use crate::scene::Parameter;
use crate::study::response::{SettledResponse, section_lag};
use crate::study::sweep::{Shard, Start, SweepPoint};
use crate::text::filled;
use crate::{escape, plot};

/// Maximum number of spectral lines listed.
const LINES: usize = 8;

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
    let unit = unit(sweep).replace('u', "µ");
    // All digits, as specified by the user.
    format!("{value} {unit}").trim_end().to_owned()
}

/// Description of the point at a parameter value.
pub fn point(
    sweep: &SweepStudy<'_>,
    start: Start,
    value: f64,
    point: Option<&SweepPoint>,
) -> String {
    let origin = point.and_then(|point| origin(sweep, point));
    filled(
        "sweep/point",
        context! {
            parameter => parameter(sweep),
            value => with_unit(sweep, value),
            start => plot::start_label(start),
            origin => origin.map(|value| with_unit(sweep, value)),
            failure => point.and_then(|point| point.outcome.as_ref().err()),
            found => point.and_then(SweepPoint::found).map(response),
        },
    )
}

/// Template variables of a response.
fn response(found: &SettledResponse) -> Value {
    let shown = &found.lines[..found.lines.len().min(LINES)];
    let linear = found.linear.as_ref();
    let unstable = linear.map(|linear| linear.unstable().collect::<Vec<_>>());
    let periods = found.recurrence_periods.0.iter();
    let period = |kind: String, period_s: f64| context! { kind, period_s };
    context! {
        motion => found.motion(),
        confidence => (found.regime != Regime::Undetermined).then_some(100.0 * found.confidence),
        settled => found.settled,
        transient => found.transient_s,
        amplitude => found.amplitude_m,
        rms_velocity => found.rms_velocity_m_per_s,
        lines => Serde(shown),
        weaker_lines => found.lines.len() - shown.len(),
        exponents => found.exponents.as_ref().map(exponents),
        attractor => found.exponents.as_ref().map(|spectrum| spectrum.attractor().to_string()),
        unstable => Serde(unstable),
        recurrence => Serde(&found.recurrence),
        periods => periods.map(|p| period(p.kind.to_string(), p.period)).collect::<Vec<_>>(),
    }
}

/// Template variables of the exponents: values with their intervals, and signs.
fn exponents(spectrum: &LyapunovSpectrum) -> Vec<Value> {
    let value = |k: usize| {
        let Exponent { value, half_width } = spectrum.exponents[k];
        let value = with_error(value, half_width);
        context! { value, sign => spectrum.sign(k).to_string() }
    };
    (0..spectrum.exponents.len()).map(value).collect()
}

/// Description of the whole sweep.
pub fn about(sweep: &SweepStudy<'_>, timeline: &str) -> String {
    let scene = &sweep.plan.subject;
    let label = sweep.plan.axes[0].label();
    let points = Table::of(sweep.values()).right(label, |value| value.to_string());
    let points = sweep.starts().fold(points, |points, start| {
        points.left(start.to_string(), |value| kind(sweep.at(start, **value)))
    });
    filled(
        "sweep/about",
        context! {
            scene => escape::code(&scene.name),
            parameter => parameter(sweep),
            timeline,
            points => points.markdown(),
            lag => section_lag(scene),
            origin => text::study_about(scene, sweep.command),
        },
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
