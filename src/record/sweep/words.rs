//! The words beside the pictures of a sweep.

use std::fmt::Write as _;

use super::view::{ParameterView, PointView, ResponseView, StartView, SweepView};
use crate::{
    VERSION, escape,
    record::{
        RERUN_VERSION, exponents,
        style::{Quantity, capital, short},
    },
};

/// Lines of a spectrum that are told.
const LINES: usize = 8;

/// A value with its unit.
fn with_unit(parameter: &ParameterView, value: f64) -> String {
    let unit = match &*parameter.unit {
        "um" => "µm",
        "us" => "µs",
        unit => unit,
    };
    // All digits: a value is what was asked for.
    format!("{value} {unit}").trim_end().to_owned()
}

/// What the way of starting is called where it is a title.
pub fn title(start: &StartView) -> String {
    capital(&start.words)
}

/// All about the point at a value.
pub fn point(
    sweep: &SweepView,
    start: &StartView,
    value: f64,
    point: Option<&PointView>,
) -> String {
    let parameter = &sweep.parameter;
    let head = format!(
        "## {name} {value}\n\n*{words}*\n\n",
        name = capital(&parameter.name),
        value = with_unit(parameter, value),
        words = capital(&start.words),
    );
    let Some(point) = point else {
        return format!("{head}**Not computed yet.** The sweep goes on with `--resume`.\n");
    };
    let from = match point.from {
        Some(from) => format!(
            "Started from the settled state at {}.",
            with_unit(parameter, from)
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

fn response(found: &ResponseView, from: &str) -> String {
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
    if let Some(measures) = &found.measures {
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
fn lines(text: &mut String, found: &ResponseView) {
    if found.lines.is_empty() {
        text.push_str("No line in the spectrum.\n\n");
        return;
    }
    text.push_str("| line | Hz | amplitude |\n|---|---|---|\n");
    for line in found.lines.iter().take(LINES) {
        let _ = writeln!(
            text,
            "| {} | {:.1} | {} |",
            match &*line.label {
                "" => "–",
                name => name,
            },
            line.frequency,
            Quantity::Length.words(line.amplitude),
        );
    }
    let more = found.lines.len().saturating_sub(LINES);
    if more > 0 {
        let _ = write!(text, "\nand {more} weaker ones.");
    }
    text.push_str("\n\n");
}

/// The exponents with their intervals, and what they say.
fn lyapunov(text: &mut String, found: &ResponseView) {
    let Some(spectrum) = &found.exponents else {
        return;
    };
    text.push_str("| λ | 1/s, 95 % | sign |\n|---|---|---|\n");
    for (k, exponent) in spectrum.exponents.iter().enumerate() {
        let _ = writeln!(
            text,
            "| λ{} | {} | {} |",
            k + 1,
            exponents::with_error(exponent, 1.0),
            exponents::sign_words(spectrum.sign(k)),
        );
    }
    let _ = write!(
        text,
        "\nBy its exponents: **{}**.\n\n",
        spectrum.attractor()
    );
}

/// The unstable modes.
fn modes(text: &mut String, found: &ResponseView) {
    match found.unstable.as_deref() {
        None => {}
        Some([]) => text.push_str("Steady sliding is stable here.\n\n"),
        Some(modes) => {
            text.push_str("| unstable mode | Hz | growth, 1/s |\n|---|---|---|\n");
            for mode in modes {
                let _ = writeln!(
                    text,
                    "| {} | {:.1} | {} |",
                    mode.label,
                    mode.frequency,
                    short(mode.growth)
                );
            }
            text.push('\n');
        }
    }
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
pub fn about(sweep: &SweepView, timeline: &str) -> String {
    let starts: String = sweep
        .starts
        .iter()
        .map(|start| format!(" {} |", start.key))
        .collect();
    let rule = "---|".repeat(sweep.starts.len() + 1);
    let rows: String = sweep
        .values
        .iter()
        .map(|&value| {
            let kinds: String = sweep
                .starts
                .iter()
                .map(|start| format!(" {} |", kind(start.at(value))))
                .collect();
            format!("| {value} |{kinds}\n")
        })
        .collect();
    format!(
        "# {scene} over {name}\n\n\
         The settled motion at each value of one number of the scene, for each way of starting. \
         Drag the cursor at the bottom (timeline `{timeline}`), or press play.\n\n\
         {READING}\n## All points\n\n| {label} |{starts}\n|{rule}\n{rows}\n\
         An asterisk: not settled. τ = {lag} in sections.\n\n\
         ## Scene {scene}: {title}\n\n{about}\n\n{text}\n\n\
         squeakscope {VERSION}, Rerun {RERUN_VERSION}. Started as {command}.\n",
        title = escape::markdown(&sweep.title),
        about = sweep.about,
        name = sweep.parameter.name,
        label = sweep.parameter.label,
        lag = Quantity::Time.words(sweep.lag),
        scene = escape::code(&sweep.scene),
        text = escape::block("toml", &sweep.scene_text),
        command = escape::code(&sweep.command),
    )
}

/// The kind of motion of a point in a word.
fn kind(point: Option<&PointView>) -> String {
    match point.map(|point| &point.outcome) {
        None => "–".to_owned(),
        Some(Err(_)) => "no response".to_owned(),
        Some(Ok(found)) => {
            let mark = if found.settled { "" } else { "\\*" };
            format!("{}{mark}", found.regime)
        }
    }
}
