//! The words beside the pictures of what accuracy costs.

use std::fmt::Write as _;

use crate::{
    VERSION, escape,
    plot::cost::{error_words, plain, setting},
    record::{
        RERUN_VERSION,
        style::{Quantity, capital, short},
    },
    study::cost::{CostPlan, CostPoint, CostSet, CostStudy, Knob, advice},
};

/// The sets of some knobs.
fn sets<'a>(study: &'a CostStudy, knobs: &'a [Knob]) -> impl Iterator<Item = &'a CostSet> {
    study.sets.iter().filter(|set| knobs.contains(&set.knob))
}

/// How to read the pictures of some knobs: no more than is in them.
fn reading(study: &CostStudy, knobs: &[Knob]) -> String {
    let settings = || sets(study, knobs).flat_map(|set| &set.points);
    let parts = [
        (
            true,
            "A point is a setting, a line joins those of a family. Left is cheap, low is exact. **Hover over \
             a point** for its numbers.",
        ),
        (
            sets(study, knobs).any(|set| set.floor.is_some_and(|floor| floor > 0.0)),
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

/// An error, or that there is none.
fn error(point: &CostPoint) -> String {
    match point.error {
        Ok(error) => error_words(error),
        Err(_) => "failed".to_owned(),
    }
}

/// Milliseconds to three digits.
fn milliseconds(point: &CostPoint) -> String {
    short(1e3 * point.seconds)
}

/// What is turned and what its error is compared with.
fn about_knob(knob: Knob) -> &'static str {
    match knob {
        Knob::Integrator => {
            "Method and tolerance (of `rk4` the step), by the trajectory: the largest deviation of the state \
             from that of a reference with a tolerance of 1e-12, in the norm of the vibration's energy, \
             relative to its size."
        }
        Knob::Invariants => {
            "The tolerance of the scene's own method, by what does not depend on the trajectory and so can \
             be compared beyond its horizon, in chaos, too."
        }
        Knob::Events => {
            "Whether steps of `lawson54` go through events (a node opens or closes) or end exactly there, \
             by the trajectory."
        }
        Knob::Nodes => {
            "Family and number of the contact nodes, by the trajectory, beside a reference with 4000 of them."
        }
        Knob::Modes => {
            "How many natural modes the body has, from the lowest up, by what the vibration settles to, beside \
             that with all modes: eleven of the paper's frequencies, or many of the finite elements' own."
        }
        Knob::Elements => {
            "Size of the finite elements, by the natural frequencies, beside those of a finer mesh."
        }
        Knob::Exponents => {
            "How long the growth of tangent vectors is averaged, by half of the 95 % interval of the \
             largest Lyapunov exponent. The reference is four times as long as the longest."
        }
        Knob::Recurrence => {
            "How many states are compared and what counts as near, by the determinism, beside that of a \
             longer series."
        }
    }
}

/// All about a knob.
pub fn knob(study: &CostStudy, knob: Knob) -> String {
    let mut text = format!(
        "# {name} of `{scene}`\n\n{advice}## What is turned\n\n{about}\n\nThe error: {error}.\n\n\
         ## How to read it\n\n{reading}\n\n## All settings\n\n",
        scene = study.scene,
        name = capital(knob.name()),
        advice = cheapest(study, knob),
        about = about_knob(knob),
        error = knob.error(),
        reading = reading(study, &[knob]),
    );
    for set in sets(study, &[knob]) {
        let _ = write!(text, "**{}**", set.family);
        if let Some(floor) = set.floor {
            let _ = write!(text, " (the reference's own error {floor:.1e})");
        }
        let _ = write!(
            text,
            "\n\n| {} | ms | calls | error |\n|---|---|---|---|\n",
            set.turned
        );
        for point in &set.points {
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
fn cheapest(study: &CostStudy, knob: Knob) -> String {
    let mut rows = String::new();
    if knob != Knob::Integrator {
        return rows;
    }
    for advice in advice(&study.sets) {
        let families = study.sets.iter();
        let families = families.filter(|set| set.knob == knob && set.family == advice.method);
        let mut points = families.flat_map(|set| set.points.iter().map(move |point| (set, point)));
        let Some((set, point)) = points.find(|(_, point)| point.value == advice.value) else {
            continue;
        };
        let _ = writeln!(
            rows,
            "| {:.0e} | {}, {} | {} | {} | {} |",
            advice.target,
            set.family,
            setting(set.turned, point.value),
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
            study.scene
        ))
    )
}

/// The study as a whole.
pub fn about(plan: &CostPlan, study: &CostStudy, knobs: &[Knob], command: &str) -> String {
    let row = |knob: &Knob| {
        let (name, about, error) = (knob.name(), about_knob(*knob), knob.error());
        format!("| **{name}** | {about} | {error} |\n")
    };
    let rows: String = knobs.iter().map(row).collect();
    let advice: String = knobs.iter().map(|knob| cheapest(study, *knob)).collect();
    format!(
        "# What accuracy costs in {scene}\n\n\
         Each knob is turned with all others at their reference, and the error is set against the work: CPU \
         time (the median of repeated runs, all threads together) and calls of the right-hand side, which \
         are free of noise. Trajectories start in the settled motion and are compared over {horizon}: in \
         chaos no longer than an error takes to grow by a factor of e.{held}\n\n\
         {reading}\n\n{advice}## The knobs\n\n| knob | what is turned | error |\n|---|---|---|\n{rows}\n\
         ## Scene {scene}: {title}\n\n{text}\n\n\
         squeakscope {VERSION}, Rerun {RERUN_VERSION}. Started as {command}.\n",
        scene = escape::code(&study.scene),
        horizon = Quantity::Time.words(study.horizon),
        held = study
            .held
            .words()
            .map(|words| format!(" Held at its first values: {words}."))
            .unwrap_or_default(),
        title = escape::markdown(&plan.scene.title),
        reading = reading(study, knobs),
        text = escape::block("toml", &plan.scene.text),
        command = escape::code(command),
    )
}
