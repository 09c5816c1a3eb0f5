//! `squeakscope scenes NAME --effects`: measure the CPU time of each effect and analysis of a scene.

use std::cmp::Ordering;
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};

use super::document::Document;
use super::error::{Cause, CliError};
use super::interrupt;
use super::output::OutputFile;
use super::progress::Progress;
use super::report::HEADING;
use crate::escape;
use crate::pipeline::{Monitor, drive, source};
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study;
use crate::study::OnProgress;
use crate::study::effects::{Effect, Effects};
use crate::table::Table;

const ON: Style = AnsiColor::Green.on_default();
const OFF: Style = Style::new().dimmed();

/// Measures the effects and prints the report.
///
/// # Errors
/// Failure while running or writing; an interrupt.
pub(super) fn effects(
    scene: &Scene,
    json: Option<&OutputFile>,
    stop: &Arc<AtomicBool>,
) -> Result<(), CliError> {
    let progress = Progress::with_estimate();
    let effects = measure(scene, stop, &mut |share| {
        progress.update(share, "effects");
        interrupt::should_continue(stop)
    });
    drop(progress);
    let effects = effects.map_err(|source| CliError::Run {
        task: "measurement of effects",
        source,
    })?;
    match effects {
        None => Err(CliError::NoResult),
        Some(effects) => {
            let document = Document::new(&effects, &[]).with_scene(&scene.name);
            Ok(document.deliver(&text(&scene.name, &effects), json)?)
        }
    }
}

/// Measures the effects of a scene; `None` after an interrupt.
fn measure(
    scene: &Scene,
    stop: &Arc<AtomicBool>,
    watch: OnProgress<'_, f64>,
) -> Result<Option<Effects>, Cause> {
    // Created on first use: an interrupt before that ends the program without removing the directory.
    let mut folder = None;
    let record = &mut |scene: &Scene| {
        let folder: &tempfile::TempDir = match &folder {
            Some(folder) => folder,
            None => folder.insert(tempfile::tempdir()?),
        };
        let output = Output {
            save: Some(folder.path().join("effects.rrd")),
            ..Output::default()
        };
        let header = source(scene)?;
        let mut sink = RerunSink::new(&output, scene.record)?;
        let monitor = Monitor {
            stop,
            ..Monitor::default()
        };
        drive(header, "", &mut sink, monitor)?;
        Ok(())
    };
    study::effects::effects(scene, record, stop, watch)
}

/// The report for the terminal.
fn text(scene: &str, effects: &Effects) -> String {
    let mut text = format!(
        "{HEADING}{}{HEADING:#}: {:.0} us of CPU time per simulated ms without a recording; set-up {:.0} ms",
        escape::line(scene),
        1e3 * effects.whole,
        1e3 * effects.setup
    );
    if effects.rhs_eval > 0.0 {
        let _ = write!(
            text,
            "; {:.0} right-hand-side evaluations per simulated ms, {:.3} us each",
            1e-3 * effects.rhs_evals,
            1e6 * effects.rhs_eval
        );
    }
    text.push('\n');
    let mut table = Table::default().left("").right("us per ms").left("effect");
    table = table.left("key").left("setting");
    let mut sorted: Vec<&Effect> = effects.effects.iter().collect();
    // Active effects first, each group by cost; without a cost last.
    let key = |effect: &Effect| (effect.on, effect.cost.map_or(f64::NEG_INFINITY, |c| c.mean));
    sorted.sort_by(|a, b| key(b).partial_cmp(&key(a)).unwrap_or(Ordering::Equal));
    for effect in sorted {
        let state = match effect.on {
            true => format!("{ON}on{ON:#}"),
            false => format!("{OFF}off{OFF:#}"),
        };
        table.row([
            state,
            cost(effect),
            effect.name.to_string(),
            effect.key.to_string(),
            setting(effect),
        ]);
    }
    text += &table.text();
    text.push_str(
        "An effect that is off is not computed; its row shows what it would cost with typical values. +- is the \
         half-width of the 95 % interval.\n",
    );
    text + &advice(effects)
}

/// Keys that change what is observed, or the numerics, but not the physics of a scene.
const OPTIONAL: [&str; 3] = ["analysis.", "record.", "time.events"];

/// Smallest share of the CPU time that is worth advice.
const WORTH: f64 = 0.05;

/// The change of an optional effect that saves most, if it saves enough.
fn advice(effects: &Effects) -> String {
    let saving = |effect: &&Effect| -> Option<f64> {
        let cost = effect.cost.ok().filter(|cost| cost.is_significant())?;
        let optional = OPTIONAL.iter().any(|key| effect.key.starts_with(key));
        let saved = if effect.on { cost.mean } else { -cost.mean };
        (optional && saved > WORTH * effects.whole).then_some(saved)
    };
    let savings = effects
        .effects
        .iter()
        .filter_map(|effect| Some((effect, saving(&effect)?)));
    let Some((effect, saved)) = savings.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return String::new();
    };
    let change = if effect.on { "Without" } else { "With" };
    format!(
        "{change} {} ({}) the scene needs {:.0} % less CPU time.\n",
        effect.name,
        effect.key,
        100.0 * saved / effects.whole
    )
}

/// CPU time in us per simulated ms: `12 +- 5`, or `within noise (< 30)` if the scatter exceeds the mean.
fn cost(effect: &Effect) -> String {
    let Ok(measured) = effect.cost else {
        return "-".to_owned();
    };
    // s per s to us per ms.
    let [cost, scatter] = [measured.mean, measured.half_width].map(|seconds| 1e3 * seconds);
    if cost.abs() > scatter {
        // One significant digit of the scatter.
        let digits = usize::from(scatter < 1.0);
        return format!("{cost:.digits$} +- {scatter:.digits$}");
    }
    let below = cost.max(0.0) + scatter;
    format!("within noise (< {:.*})", usize::from(below < 10.0), below)
}

/// The setting, the set-up time, and the reason for a missing cost.
fn setting(effect: &Effect) -> String {
    let setting = Some(effect.setting.clone()).filter(|setting| !setting.is_empty());
    let setup = effect
        .setup
        .map(|setup| format!("{:.1} ms once", 1e3 * setup.mean));
    let unavailable = effect.cost.err().map(|why| format!("-: {why}"));
    let parts: Vec<String> = [setting, setup, unavailable]
        .into_iter()
        .flatten()
        .collect();
    parts.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::effects::{Measured, Unavailable};

    #[test]
    fn a_cost_below_its_scatter_is_shown_as_a_bound() {
        let effect = |cost: Result<(f64, f64), Unavailable>| Effect {
            name: "regime".into(),
            key: "analysis.regime".into(),
            on: true,
            setting: "on".to_owned(),
            // us per ms to s per s.
            cost: cost.map(|(mean, half_width)| Measured {
                mean: 1e-3 * mean,
                half_width: 1e-3 * half_width,
            }),
            setup: None,
        };
        assert_eq!(cost(&effect(Ok((12.3, 4.8)))), "12 +- 5");
        assert_eq!(cost(&effect(Ok((-60.0, 0.25)))), "-60.0 +- 0.2");
        assert_eq!(cost(&effect(Ok((-29.0, 30.0)))), "within noise (< 30)");
        assert_eq!(cost(&effect(Ok((1.0, 2.0)))), "within noise (< 3.0)");
        let short = effect(Err(Unavailable::ShorterThanWindow));
        assert_eq!(cost(&short), "-");
        let reason = Unavailable::ShorterThanWindow;
        assert_eq!(setting(&short), format!("on; -: {reason}"));
        let json = serde_json::to_value(effect(Ok((12.0, 4.0)))).unwrap();
        assert_eq!(json["cpu_s_per_s"]["mean"], 1e-3 * 12.0);
        let json = serde_json::to_value(short).unwrap();
        assert!(json["cpu_s_per_s"].is_null());
    }
}
