//! The words beside the pictures of what accuracy costs.

use std::fmt::Write as _;

use super::{
    scope::floors,
    view::{CostView, FamilyView, KnobView, SettingView},
};
use crate::{
    VERSION, escape,
    record::{
        RERUN_VERSION,
        style::{Quantity, capital, short},
    },
};

/// How to read the pictures of some knobs: no more than is in them.
fn reading(knobs: &[KnobView]) -> String {
    let settings = || knobs.iter().flat_map(KnobView::settings);
    let parts = [
        (
            true,
            "A point is a setting, a line joins those of a family. Left is cheap, low is exact. **Hover over \
             a point** for its numbers.",
        ),
        (
            knobs.iter().any(|knob| floors(knob).next().is_some()),
            "The dashed line is the error of the reference itself: near it and below it an error is not told.",
        ),
        (
            settings().any(|setting| setting.error.is_err()),
            "A **cross** at the top is a setting that failed.",
        ),
        (
            settings().any(|setting| setting.error == Ok(0.0)),
            "A setting without any error stands at the lower edge.",
        ),
    ];
    let there = parts.iter().filter(|(there, _)| *there);
    let sentences: Vec<&str> = there.map(|(_, sentence)| *sentence).collect();
    sentences.join(" ")
}

/// A number as people write tolerances: `1e-5`, `0.25`, `100`.
fn plain(value: f64) -> String {
    if (1e-2..1e6).contains(&value.abs()) || value == 0.0 {
        return short(value);
    }
    let text = format!("{value:.1e}");
    text.replace(".0e", "e")
}

/// A setting with its name and unit: `tolerance 1e-5`, `step 1.6e-6 s`.
fn setting(turned: &str, value: f64) -> String {
    let (name, unit) = turned.split_once(", ").unwrap_or((turned, ""));
    format!("{name} {} {unit}", plain(value))
        .trim_end()
        .to_owned()
}

/// An error to two digits or three.
fn digits(error: f64) -> String {
    match error {
        error if (1e-2..1e4).contains(&error) || error == 0.0 => short(error),
        error => format!("{error:.1e}"),
    }
}

/// An error, or that there is none.
fn error(setting: &SettingView) -> String {
    match setting.error {
        Ok(error) => digits(error),
        Err(_) => "failed".to_owned(),
    }
}

/// Milliseconds to three digits.
fn milliseconds(setting: &SettingView) -> String {
    short(1e3 * setting.seconds)
}

/// A setting, its error and what it costs, in one line: what is asked for first comes first, since a
/// narrow tooltip cuts the end off. The family stands above it there.
pub fn point(family: &FamilyView, point: &SettingView) -> String {
    let mut text = setting(family.turned, point.value);
    if let Ok(error) = point.error {
        let _ = write!(text, ": error {}", digits(error));
    } else {
        text.push_str(": failed");
    }
    let _ = write!(text, ", {} ms of CPU", milliseconds(point));
    if point.calls > 0 {
        let _ = write!(text, ", {} calls", point.calls);
    }
    if let Err(why) = &point.error {
        let _ = write!(text, "; {why}");
    }
    if !point.detail.is_empty() {
        let _ = write!(text, "; {}", point.detail);
    }
    text
}

/// What the dashed line is.
pub fn floor(common: Option<f64>) -> String {
    match common {
        Some(floor) => format!("the reference's own error, {floor:.1e}"),
        None => "the references' own errors".to_owned(),
    }
}

/// All about a knob.
pub fn knob(cost: &CostView, knob: &KnobView) -> String {
    let mut text = format!(
        "# {name} of `{scene}`\n\n{advice}## What is turned\n\n{about}\n\nThe error: {error}.\n\n\
         ## How to read it\n\n{reading}\n\n## All settings\n\n",
        scene = cost.scene,
        name = capital(knob.name),
        advice = advice(cost, knob),
        about = knob.about,
        error = knob.error,
        reading = reading(std::slice::from_ref(knob)),
    );
    for family in &knob.families {
        let _ = write!(text, "**{}**", family.name);
        if let Some(floor) = family.floor {
            let _ = write!(text, " (the reference's own error {floor:.1e})");
        }
        let _ = write!(
            text,
            "\n\n| {} | ms | calls | error |\n|---|---|---|---|\n",
            family.turned
        );
        for point in &family.settings {
            let calls = match point.calls {
                0 => "–".to_owned(),
                calls => calls.to_string(),
            };
            let comma = if point.detail.is_empty() { "" } else { ", " };
            let _ = writeln!(
                text,
                "| {} | {} | {calls} | {}{comma}{} |",
                plain(point.value),
                milliseconds(point),
                error(point),
                point.detail
            );
        }
        text.push('\n');
    }
    text
}

/// The cheapest setting for each error; nothing for a knob without advice.
fn advice(cost: &CostView, knob: &KnobView) -> String {
    let mut rows = String::new();
    for advice in &knob.advice {
        let Some((family, point)) = knob.advised(advice) else {
            continue;
        };
        let _ = writeln!(
            rows,
            "| {:.0e} | {}, {} | {} | {} | {} |",
            advice.target,
            family.name,
            setting(family.turned, point.value),
            milliseconds(point),
            point.calls,
            error(point),
        );
    }
    if rows.is_empty() {
        return rows;
    }
    format!(
        "## The cheapest setting\n\n| for an error of | setting | ms | calls | its error |\n\
         |---|---|---|---|---|\n{rows}\n\
         White rims in the pictures. {} puts this into the scene, and `--accuracy 1e-4` takes it.\n\n",
        escape::code(&format!(
            "squeakscope cost {} --write FILE.toml",
            cost.scene
        ))
    )
}

/// The study as a whole.
pub fn about(cost: &CostView) -> String {
    let knobs: String = cost
        .knobs
        .iter()
        .map(|knob| format!("| **{}** | {} | {} |\n", knob.name, knob.about, knob.error))
        .collect();
    let advice: String = cost.knobs.iter().map(|knob| advice(cost, knob)).collect();
    format!(
        "# What accuracy costs in {scene}\n\n\
         Each knob is turned with all others at their reference, and the error is set against the work: CPU \
         time (the median of repeated runs, all threads together) and calls of the right-hand side, which \
         are free of noise. Trajectories start in the settled motion and are compared over {horizon}: in \
         chaos no longer than an error takes to grow by a factor of e.{held}\n\n\
         {reading}\n\n{advice}## The knobs\n\n| knob | what is turned | error |\n|---|---|---|\n{knobs}\n\
         ## Scene {scene}: {title}\n\n{text}\n\n\
         squeakscope {VERSION}, Rerun {RERUN_VERSION}. Started as {command}.\n",
        scene = escape::code(&cost.scene),
        horizon = Quantity::Time.words(cost.horizon),
        held = cost
            .held
            .words()
            .map(|words| format!(" Held at its first values: {words}."))
            .unwrap_or_default(),
        title = escape::markdown(&cost.title),
        reading = reading(&cost.knobs),
        text = escape::block("toml", &cost.scene_text),
        command = escape::code(&cost.command),
    )
}
