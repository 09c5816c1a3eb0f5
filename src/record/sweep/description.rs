//! The text next to the plots of a sweep.

use minijinja::context;

use super::SweepStudy;
use crate::analysis::regime::Regime;
use crate::dynamics::Motion;
use crate::number::{brief, fixed, short};
use crate::pipeline::message::Classification;
use crate::record::style::capitalize;
use crate::record::text;
use crate::report::{Block, Table, Tone, markdown};
use crate::scene::Parameter;
use crate::study::StabilityAt;
use crate::study::response::{SettledResponse, section_lag};
use crate::study::signal::report::{measures, periods};
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
    let title = capitalize(&parameter(sweep));
    let rest = format!(" {}: {}", with_unit(sweep, value), plot::start_label(start));
    let mut blocks = vec![Block::heading(title, rest)];
    if let Some(point) = point {
        let origin = origin(sweep, point).map(|value| with_unit(sweep, value));
        let initial = origin.map_or("kick of the scene".to_owned(), |origin| {
            format!("steady state at {origin}")
        });
        blocks.push(Block::text(format!("Initial state: {initial}")));
        match &point.outcome {
            Ok(found) => blocks.extend(response(found)),
            Err(reason) => {
                let reason = escape::markdown(reason);
                blocks.push(Block::Warning(format!("no response: {reason}")));
            }
        }
    } else {
        let missing = "not computed yet; continue the sweep with `--resume`";
        blocks.push(Block::Warning(missing.to_owned()));
    }
    markdown(&blocks)
}

/// The characteristics of a response.
fn response(found: &SettledResponse) -> Vec<Block> {
    let confidence = match found.regime {
        Regime::Undetermined => String::new(),
        _ => format!(", confidence {:.0} %", 100.0 * found.confidence),
    };
    let motion = capitalize(&found.motion());
    let transient = brief(found.transient_s, "s");
    let mut blocks = vec![
        Block::Text(vec![Tone::Strong.cell(motion), confidence.into()]),
        if found.settled {
            Block::text(format!("Steady state after {transient}"))
        } else {
            Block::Warning(format!(
                "not in steady state: the motion was still changing when it was measured, after {transient}"
            ))
        },
        Block::text(format!(
            "Amplitude {}, velocity {} rms",
            brief(found.amplitude_m, "m"),
            brief(found.rms_velocity_m_per_s, "m/s")
        )),
        Table::of(found.lines.iter().take(LINES))
            .left("strongest lines", |line| line.label.clone())
            .right("Hz", |line| fixed(line.frequency, 1))
            .right("amplitude", |line| brief(line.amplitude, "m"))
            .into(),
    ];
    if let Some(spectrum) = &found.exponents {
        let classified = Classification::new(spectrum, Motion::Free, f64::INFINITY, None);
        blocks.push(classified.table(&spectrum.exponents));
        blocks.push(Block::text(classified.description));
    }
    blocks.extend(found.linear.as_ref().map(unstable_modes));
    blocks.extend(found.recurrence.iter().flat_map(measures));
    blocks.extend(periods(&found.recurrence_periods));
    blocks
}

/// The unstable modes of steady sliding, one per row.
fn unstable_modes(linear: &StabilityAt) -> Block {
    if linear.unstable().next().is_none() {
        return Block::text("Steady sliding is stable here");
    }
    Table::of(linear.unstable())
        .left("unstable mode", |mode| mode.label.clone())
        .right("Hz", |mode| fixed(mode.frequency_hz, 1))
        .right("growth rate, 1/s", |mode| short(mode.growth))
        .into()
}

/// Description of the whole sweep.
pub fn about(sweep: &SweepStudy<'_>, timeline: &str) -> String {
    let scene = &sweep.plan.subject;
    filled(
        "sweep/about",
        context! {
            report => markdown(sweep.report),
            timeline,
            lag => brief(section_lag(scene), "s"),
            origin => text::study_about(scene, sweep.command),
        },
    )
}
