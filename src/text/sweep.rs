//! Text of a sweep, next to the plots of a recording: one for each point, and one for the whole.

use minijinja::context;
use minijinja::value::{Serde, Value};

use super::or_error_text;
use super::template::fill;
use crate::analysis::regime::Regime;
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::escape;
use crate::number::with_error;
use crate::scene::Scene;
use crate::study::response::{SettledResponse, section_lag};
use crate::study::sweep::SweepPoint;

/// Maximum number of spectral lines listed.
const LINES: usize = 8;

/// The place of a point in its sweep, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPlace<'a> {
    /// Name of the swept parameter.
    pub parameter: &'a str,
    /// Its value with the unit.
    pub value: String,
    /// Name of the start.
    pub start: &'a str,
    /// Value whose steady state is the initial state; `None` for the kick of the scene.
    pub origin: Option<String>,
}

/// The description of a point; `None` if it is not computed yet.
pub fn point(place: &PointPlace<'_>, point: Option<&SweepPoint>) -> String {
    let outcome = point.map(|point| point.outcome.as_ref());
    let found = outcome.and_then(Result::ok);
    let failure = outcome.and_then(Result::err);
    or_error_text(fill(
        "sweep/point",
        context! {
            parameter => place.parameter,
            value => &*place.value,
            start => place.start,
            origin => place.origin.as_deref(),
            failure => failure.map(String::as_str),
            found => found.map(response),
        },
    ))
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
        transient => found.transient,
        amplitude => found.amplitude,
        rms_velocity => found.rms_velocity,
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

/// The description of a sweep over a parameter of a scene, with a table of its points and the text of its
/// origin.
pub(crate) fn about(
    scene: &Scene,
    parameter: &str,
    timeline: &str,
    points: &str,
    origin: &str,
) -> String {
    or_error_text(fill(
        "sweep/about",
        context! {
            scene => escape::code(&scene.name),
            parameter,
            timeline,
            points,
            lag => section_lag(scene),
            origin,
        },
    ))
}
