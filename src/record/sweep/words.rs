//! The words beside the pictures of a sweep.

use std::fmt::Write as _;

use super::SweepStudy;
use crate::{
    escape,
    number::{fixed, short},
    plot,
    record::{
        exponents,
        style::{Quantity, capital},
        text,
    },
    study::{
        response::{Response, section_lag},
        sweep::{Shard, Start, SweepPoint},
    },
    table::Table,
};

/// Lines of a spectrum that are told.
const LINES: usize = 8;

/// The last part of the path of the swept parameter without its unit, as words: `load.tilt_deg` is `tilt`.
pub fn parameter(sweep: &SweepStudy<'_>) -> String {
    let parameter = sweep.plan.axes.first().map(|axis| axis.parameter());
    let path = parameter.map_or("", |parameter| parameter.path());
    let key = path.rsplit('.').next().unwrap_or(path);
    let unit = unit(sweep).to_lowercase().replace('/', "_per_");
    let bare = key.strip_suffix(&unit).filter(|_| !unit.is_empty());
    let bare = bare.and_then(|bare| bare.strip_suffix('_'));
    bare.unwrap_or(key).replace('_', " ")
}

/// The unit of the swept parameter; empty for a number.
pub fn unit(sweep: &SweepStudy<'_>) -> &'static str {
    let parameter = sweep.plan.axes.first().map(|axis| axis.parameter());
    parameter.map_or("", |parameter| parameter.unit())
}

/// The value from whose settled state a point was started; `None` if from the scene's own kick.
fn origin(sweep: &SweepStudy<'_>, point: &SweepPoint) -> Option<f64> {
    let chains = sweep.plan.chains(Shard::WHOLE);
    let mut pairs = chains.iter().flat_map(|chain| chain.windows(2));
    let before = pairs.find(|pair| pair[1] == point.place.index)?[0];
    // Where there was no response there was no state to go on from.
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
    // All digits: a value is what was asked for.
    format!("{value} {unit}").trim_end().to_owned()
}

/// What the way of starting is called where it is a title.
pub fn title(start: Start) -> String {
    capital(plot::words(start))
}

/// All about the point at a value.
pub fn point(
    sweep: &SweepStudy<'_>,
    start: Start,
    value: f64,
    point: Option<&SweepPoint>,
) -> String {
    let head = format!(
        "## {name} {value}\n\n*{words}*\n\n",
        name = capital(&parameter(sweep)),
        value = with_unit(sweep, value),
        words = title(start),
    );
    let Some(point) = point else {
        return format!("{head}**Not computed yet.** The sweep goes on with `--resume`.\n");
    };
    let from = match origin(sweep, point) {
        Some(from) => format!(
            "Started from the settled state at {}.",
            with_unit(sweep, from)
        ),
        None => "Started from the scene's own kick.".to_owned(),
    };
    match &point.outcome {
        Ok(found) => format!("{head}{}", response(found, &from)),
        Err(reason) => format!(
            "{head}### No response\n\n{from}\n\n{}\n",
            escape::markdown(reason)
        ),
    }
}

fn response(found: &Response, from: &str) -> String {
    let settled = match found.settled {
        true => format!("Settled after {}.", Quantity::Time.words(found.transient)),
        false => format!(
            "**Not settled**: it still changed when it was measured, after {}.",
            Quantity::Time.words(found.transient)
        ),
    };
    let mut text = format!(
        "### {regime}\n\n**{sure:.0} % sure.** {from} {settled}\n\n\
         Amplitude {amplitude}, velocity {velocity} rms.\n\n",
        regime = capital(&found.regime.to_string()),
        sure = 1e2 * found.confidence,
        amplitude = Quantity::Length.words(found.amplitude),
        velocity = Quantity::Speed.words(found.rms_velocity),
    );
    lines(&mut text, found);
    lyapunov(&mut text, found);
    modes(&mut text, found);
    if let Some(measures) = &found.recurrence {
        let share = |share: Option<f64>| share.map_or("–".to_owned(), |s| format!("{s:.3}"));
        let _ = write!(
            text,
            "Recurrence: RR {:.3}, DET {}, LAM {}.\n\n",
            measures.recurrence_rate,
            share(measures.determinism),
            share(measures.laminarity),
        );
    }
    text
}

/// The lines of the spectrum. Writing to a string cannot fail.
fn lines(text: &mut String, found: &Response) {
    if found.lines.is_empty() {
        text.push_str("No line in the spectrum.\n\n");
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
            Quantity::Length.words(line.amplitude),
        ]);
    }
    text.push_str(&table.markdown());
    let more = found.lines.len().saturating_sub(LINES);
    if more > 0 {
        let _ = write!(text, "\nand {more} weaker ones.");
    }
    text.push_str("\n\n");
}

/// The exponents with their intervals, and what they say.
fn lyapunov(text: &mut String, found: &Response) {
    let Some(spectrum) = &found.exponents else {
        return;
    };
    let mut table = Table::default().left("λ").right("1/s, 95 %").left("sign");
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        table.row([
            format!("λ{}", k + 1),
            exponents::with_error(exponent, 1.0),
            exponents::sign_words(spectrum.sign(k)).to_string(),
        ]);
    }
    let _ = write!(
        text,
        "{}\nBy its exponents: **{}**.\n\n",
        table.markdown(),
        spectrum.attractor()
    );
}

/// The unstable modes.
fn modes(text: &mut String, found: &Response) {
    let Some(linear) = &found.linear else {
        return;
    };
    if linear.unstable().next().is_none() {
        return text.push_str("Steady sliding is stable here.\n\n");
    }
    let mut table = Table::default().left("unstable mode").right("Hz");
    table = table.right("growth, 1/s");
    for mode in linear.unstable() {
        let (frequency, growth) = (fixed(mode.frequency_hz, 1), short(mode.growth));
        table.row([mode.label.clone(), frequency, growth]);
    }
    let _ = writeln!(text, "{}", table.markdown());
}

/// How to read the views.
const READING: &str = "\
| view | what it shows |
|---|---|
| **Maxima** | the bifurcation diagram: the settled maxima of the displacement at every value, in the colour of the kind of motion; one point is a tone, a band a torus or chaos. The white line is the present value |
| **Phase portrait** | velocity against displacement, the last 10 ms: a closed loop is a pure tone, a woven band a torus, a tangle chaos |
| **Recurrence plot** | bright where the motion comes back, the last 5 ms: unbroken diagonals mean a tone, broken ones chaos |
| **Spectrum** | how strong each frequency of the displacement is, over the whole measurement; lines are named by the tones they are sums of |
| **Poincaré section** | where the motion passes upwards through zero, a delay before and after: a few points are a tone, a closed curve a torus, a cloud chaos |
| **Lyapunov exponents** | how fast neighbouring motions part (above zero) or meet (below); thin lines are the ends of the 95 % intervals |

Portraits and sections at one value have the same scale for all starts; diagrams, spectra and exponents \
have one for all values.
";

/// The sweep as a whole.
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
         The settled motion at each value of one number of the scene, for each way of starting. \
         Drag the cursor at the bottom (timeline `{timeline}`), or press play.\n\n\
         {READING}\n## All points\n\n{points}\n\
         An asterisk: not settled. τ = {lag} in sections.\n\n{origin}",
        origin = text::study_about(scene, sweep.command),
        name = parameter(sweep),
        points = table.markdown(),
        lag = Quantity::Time.words(section_lag(scene)),
        scene_name = escape::code(&scene.name),
    )
}

/// The kind of motion of a point in a word.
fn kind(point: Option<&SweepPoint>) -> String {
    let Some(point) = point else {
        return "–".to_owned();
    };
    let mark = if point.is_unsettled() { "\\*" } else { "" };
    format!("{}{mark}", point.kind())
}
