//! The text next to the plots of a sweep.

use std::fmt::Write as _;

use super::SweepStudy;
use crate::{
    analysis::Regime,
    escape,
    number::{fixed, short},
    plot,
    record::{
        exponents,
        style::{Quantity, capitalize},
        text,
    },
    study::{
        response::{SettledResponse, section_lag},
        sweep::{Shard, Start, SweepPoint},
    },
    table::Table,
};

/// Maximum number of spectral lines listed.
const LINES: usize = 8;

/// Name of the swept parameter: the last part of its path without the unit, so `load.tilt_deg` is `tilt`.
pub fn parameter(sweep: &SweepStudy<'_>) -> String {
    let parameter = sweep.plan.axes.first().map(|axis| axis.parameter());
    let path = parameter.map_or("", |parameter| parameter.path());
    let key = path.rsplit('.').next().unwrap_or(path);
    let unit = unit(sweep).to_lowercase().replace('/', "_per_");
    let bare = key.strip_suffix(&unit).filter(|_| !unit.is_empty());
    let bare = bare.and_then(|bare| bare.strip_suffix('_'));
    bare.unwrap_or(key).replace('_', " ")
}

/// The unit of the swept parameter; empty for a dimensionless number.
pub fn unit(sweep: &SweepStudy<'_>) -> &'static str {
    let parameter = sweep.plan.axes.first().map(|axis| axis.parameter());
    parameter.map_or("", |parameter| parameter.unit())
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
    let head = format!(
        "## {name} {value}\n\n*{words}*\n\n",
        name = capitalize(&parameter(sweep)),
        value = with_unit(sweep, value),
        words = title(start),
    );
    let Some(point) = point else {
        return format!("{head}**Not computed yet.** Continue the sweep with `--resume`.\n");
    };
    let from = match origin(sweep, point) {
        Some(from) => format!("Initial state: steady state at {}.", with_unit(sweep, from)),
        None => "Initial state: kick of the scene.".to_owned(),
    };
    match &point.outcome {
        Ok(found) => format!("{head}{}", response(found, &from)),
        Err(reason) => format!(
            "{head}### No response\n\n{from}\n\n{}\n",
            escape::markdown(reason)
        ),
    }
}

fn response(found: &SettledResponse, from: &str) -> String {
    let settled = match found.settled {
        true => format!(
            "Steady state after {}.",
            Quantity::Time.format(found.transient)
        ),
        false => format!(
            "**Not in steady state**: the motion was still changing when it was measured, after {}.",
            Quantity::Time.format(found.transient)
        ),
    };
    let mut text = format!(
        "### {regime}\n\n{confidence}{from} {settled}\n\n\
         Amplitude {amplitude}, velocity {velocity} rms.\n\n",
        regime = capitalize(&found.motion()),
        confidence = match found.regime {
            Regime::Undetermined => String::new(),
            _ => format!("**Confidence {:.0} %.** ", 1e2 * found.confidence),
        },
        amplitude = Quantity::Length.format(found.amplitude),
        velocity = Quantity::Speed.format(found.rms_velocity),
    );
    lines(&mut text, found);
    lyapunov(&mut text, found);
    modes(&mut text, found);
    if let Some(measures) = &found.recurrence {
        let share = |share: Option<f64>| share.map_or("–".to_owned(), |s| format!("{s:.3}"));
        let _ = write!(
            text,
            "Recurrence quantification at a threshold of half a standard deviation (the plot has a fixed RR): \
             RR {:.1} %, DET {}, LAM {}.\n\n",
            1e2 * measures.recurrence_rate,
            share(measures.determinism),
            share(measures.laminarity),
        );
    }
    for period in found.recurrence_periods.iter() {
        let _ = writeln!(
            text,
            "Recurrence period, {}: {}.\n",
            period.kind,
            Quantity::Time.format(period.period)
        );
    }
    text
}

/// The spectral lines. Writing to a string cannot fail.
fn lines(text: &mut String, found: &SettledResponse) {
    if found.lines.is_empty() {
        text.push_str("The spectrum has no line.\n\n");
        return;
    }
    let mut table = Table::default().left("line").right("Hz").right("amplitude");
    for line in found.lines.iter().take(LINES) {
        let name = match &*line.label {
            "" => "–",
            name => name,
        };
        table.row([
            name.to_owned(),
            fixed(line.frequency, 1),
            Quantity::Length.format(line.amplitude),
        ]);
    }
    text.push_str(&table.markdown());
    let more = found.lines.len().saturating_sub(LINES);
    if more > 0 {
        let _ = write!(text, "\nand {more} weaker lines.");
    }
    text.push_str("\n\n");
}

/// The Lyapunov exponents with their intervals, and the attractor.
fn lyapunov(text: &mut String, found: &SettledResponse) {
    let Some(spectrum) = &found.exponents else {
        return;
    };
    let mut table = Table::default().left("λ").right("1/s (95 %)").left("sign");
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        table.row([
            format!("λ{}", k + 1),
            exponents::with_error(exponent, 1.0),
            exponents::sign_words(spectrum.sign(k)).to_string(),
        ]);
    }
    let _ = write!(
        text,
        "{}\nAttractor from the exponents: **{}**.\n\n",
        table.markdown(),
        spectrum.attractor()
    );
}

/// The unstable linear modes.
fn modes(text: &mut String, found: &SettledResponse) {
    let Some(linear) = &found.linear else {
        return;
    };
    if linear.unstable().next().is_none() {
        return text.push_str("Steady sliding is stable here.\n\n");
    }
    let mut table = Table::default().left("unstable mode").right("Hz");
    table = table.right("growth rate, 1/s");
    for mode in linear.unstable() {
        let (frequency, growth) = (fixed(mode.frequency_hz, 1), short(mode.growth));
        table.row([mode.label.clone(), frequency, growth]);
    }
    let _ = writeln!(text, "{}", table.markdown());
}

/// Description of the views.
const READING: &str = "\
| view | what it shows |
|---|---|
| **Bifurcation diagram** | local maxima of the displacement in the steady state at every parameter value, in the colour of the type of motion: a single point is periodic, a band quasi-periodic or chaotic. The white line is the current value |
| **Phase portrait** | velocity over displacement, last 10 ms: a closed loop is periodic, a band quasi-periodic, an irregular trajectory chaotic |
| **Recurrence plot** | bright where a state recurs, last 5 ms: long unbroken diagonals mean periodic motion, short broken ones chaos |
| **Spectrum** | amplitude of the displacement over frequency, from the whole measurement; lines are labelled as combinations of the base frequencies |
| **Poincaré section** | displacement one delay before and one delay after each upward zero crossing: a few points are periodic, a closed curve quasi-periodic, a scattered set chaotic |
| **Lyapunov exponents** | the rates at which nearby trajectories separate (positive) or converge (negative); thin lines are the limits of the 95 % intervals |

Phase portraits and sections at one value have the same scale for all starts; diagrams, spectra and exponents \
have one scale for all values.
";

/// Description of the whole sweep.
pub fn about(sweep: &SweepStudy<'_>, timeline: &str) -> String {
    let scene = &sweep.plan.scene;
    let axis = sweep.plan.axes.first();
    let label = axis.map_or_else(String::new, |axis| axis.label());
    let mut table = Table::default().right(label);
    for start in sweep.starts() {
        table = table.left(start.to_string());
    }
    for value in sweep.values() {
        let kinds = sweep.starts().map(|start| kind(sweep.at(start, *value)));
        table.row(std::iter::once(value.to_string()).chain(kinds));
    }
    format!(
        "# {scene_name} over {name}\n\n\
         The steady-state motion at each value of a parameter of the scene, for each start. \
         Drag the time cursor (timeline `{timeline}`), or press play.\n\n\
         {READING}\n## All points\n\n{points}\n\
         \\*: not in steady state. The delay of the sections is τ = {lag}.\n\n{origin}",
        origin = text::study_about(scene, sweep.command),
        name = parameter(sweep),
        points = table.markdown(),
        lag = Quantity::Time.format(section_lag(scene)),
        scene_name = escape::code(&scene.name),
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
