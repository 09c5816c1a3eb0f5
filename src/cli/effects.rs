//! `squeakscope scenes --effects NAME`: what a scene calls for, and what each of it costs.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};

use super::document::Document;
use super::error::{Cause, CliError};
use super::interrupt;
use super::output::OutputFile;
use super::progress::Progress;
use crate::escape;
use crate::pipeline::{Monitor, drive, source};
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study;
use crate::study::Watch;
use crate::study::effects::{Effect, Effects};
use crate::table::Table;

const NAME: Style = Style::new().bold();
const ON: Style = AnsiColor::Green.on_default();
const OFF: Style = Style::new().dimmed();

/// Measures, and tells.
///
/// # Errors
/// A fault while running or writing; Ctrl-C.
pub(super) fn effects(
    scene: &Scene,
    json: Option<&OutputFile>,
    stop: &Arc<AtomicBool>,
) -> Result<(), CliError> {
    let progress = Progress::of_estimate();
    let found = measure(scene, stop, &mut |share| {
        progress.tell(share, "effects".to_owned());
        interrupt::goes_on(stop)
    });
    drop(progress);
    let found = found.map_err(|source| CliError::Run {
        doing: "measurement of effects",
        source,
    })?;
    match found {
        None => Err(CliError::NothingYet),
        Some(found) => {
            let document = Document::new(&found, &[]).of_scene(&scene.name);
            Ok(document.deliver(&text(&scene.name, &found), json)?)
        }
    }
}

/// Measures the effects of a scene.
fn measure(
    scene: &Scene,
    stop: &Arc<AtomicBool>,
    watch: Watch<'_, f64>,
) -> Result<Option<Effects>, Cause> {
    // Made when measuring has begun: before that, a signal ends the program as it is.
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

/// The text for the terminal.
fn text(scene: &str, found: &Effects) -> String {
    let mut text = format!(
        "{NAME}{}{NAME:#}: {:.0} us of CPU a simulated millisecond, without a recording, after a set-up of {:.0} ms",
        escape::line(scene),
        1e3 * found.whole,
        1e3 * found.setup
    );
    if found.call > 0.0 {
        let _ = write!(
            text,
            "; {:.0} calls of the right-hand side, {:.3} us each",
            1e-3 * found.calls,
            1e6 * found.call
        );
    }
    text.push('\n');
    let mut table = Table::default().left("").right("us a ms").left("effect");
    table = table.left("called for by").left("how");
    for effect in &found.effects {
        let state = match effect.on {
            true => format!("{ON}on{ON:#}"),
            false => format!("{OFF}off{OFF:#}"),
        };
        table.row([
            state,
            cost(effect),
            effect.name.into(),
            effect.key.into(),
            how(effect),
        ]);
    }
    text += &table.text();
    text.push_str(
        "what is off costs nothing: its number is what it would cost with usual values; with +- half of the \
         interval of 95 %, or < what it is below, where times scatter by more than it costs\n",
    );
    text
}

/// The cost of a simulated millisecond in us: `12 +- 5`, or `< 30` where times scatter by more.
fn cost(effect: &Effect) -> String {
    let Ok(measured) = effect.cost else {
        return "-".to_owned();
    };
    // Of a second in s, of a millisecond in us: a thousand times.
    let [cost, scatter] = [measured.mean, measured.half_width].map(|seconds| 1e3 * seconds);
    if cost.abs() > scatter {
        // A digit of the scatter is enough.
        let digits = usize::from(scatter < 1.0);
        return format!("{cost:.digits$} +- {scatter:.digits$}");
    }
    let below = cost.max(0.0) + scatter;
    format!("< {:.*}", usize::from(below < 10.0), below)
}

/// How it is called for, or why nothing can be told.
fn how(effect: &Effect) -> String {
    let setting = Some(effect.setting.clone()).filter(|setting| !setting.is_empty());
    let setup = effect
        .setup
        .map(|setup| format!("{:.1} ms once", 1e3 * setup.mean));
    let untold = effect.cost.err().map(|why| format!("-: {why}"));
    let words: Vec<String> = [setting, setup, untold].into_iter().flatten().collect();
    words.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::effects::{Measured, Untold};

    #[test]
    fn a_cost_below_its_scatter_is_told_as_a_bound() {
        let effect = |cost: Result<(f64, f64), Untold>| Effect {
            name: "regime",
            key: "analysis.regime",
            on: true,
            setting: "on".to_owned(),
            // Per second, from what is told of a millisecond.
            cost: cost.map(|(mean, half_width)| Measured {
                mean: 1e-3 * mean,
                half_width: 1e-3 * half_width,
            }),
            setup: None,
        };
        assert_eq!(cost(&effect(Ok((12.3, 4.8)))), "12 +- 5");
        assert_eq!(cost(&effect(Ok((-60.0, 0.25)))), "-60.0 +- 0.2");
        assert_eq!(cost(&effect(Ok((-29.0, 30.0)))), "< 30");
        assert_eq!(cost(&effect(Ok((1.0, 2.0)))), "< 3.0");
        let short = effect(Err(Untold::ShorterThanWindow));
        assert_eq!(cost(&short), "-");
        assert_eq!(how(&short), "on; -: the run is shorter than its window");
        let json = serde_json::to_value(effect(Ok((12.0, 4.0)))).unwrap();
        assert_eq!(json["cpu_s_per_s"]["mean"], 1e-3 * 12.0);
        let json = serde_json::to_value(short).unwrap();
        assert_eq!(json["untold"], "the run is shorter than its window");
        assert!(json["cpu_s_per_s"].is_null());
    }
}
