//! `squeakscope scenes --effects NAME`: what a scene calls for, and what each of it costs.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::error::{Cause, CliError};
use super::interrupt;
use super::output::OutputFile;
use super::progress::Progress;
use super::report::{self, Report};
use crate::pipeline::{Monitor, drive, source};
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study::Watch;
use crate::study::effects::Effects;
use crate::{VERSION, escape, study};

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
        Some(found) => Ok(report::deliver(&EffectsReport::new(scene, found), json)?),
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

/// Result of `squeakscope scenes --effects`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectsReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// CPU time of a simulated millisecond with all that is on, without a recording, us.
    pub cpu_us_per_ms: f64,
    /// CPU time until the first sample, without a recording, ms.
    pub setup_ms: f64,
    /// Calls of the right-hand side in a simulated millisecond.
    pub calls_per_ms: f64,
    /// CPU time of a call, us; 0 without a joint.
    pub call_us: f64,
    /// The effects.
    pub effects: Vec<EffectReport>,
}

/// An effect in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectReport {
    /// What it is called.
    pub name: &'static str,
    /// The table or key that calls for it.
    pub key: &'static str,
    /// Whether the scene does.
    pub on: bool,
    /// How, in words; empty where it is off.
    pub setting: String,
    /// CPU time that it takes, or would take, of a simulated millisecond, us; `null` where that cannot be
    /// told.
    pub cpu_us_per_ms: Option<f64>,
    /// Half-width of the interval of 95 % of that, us.
    pub scatter_us_per_ms: Option<f64>,
    /// CPU time that it takes, or would take, once, before the first sample, ms; `null` where that is less than
    /// times scatter.
    pub setup_ms: Option<f64>,
    /// Why no cost can be told; `null` where one is.
    pub untold: Option<String>,
}

impl EffectsReport {
    fn new(scene: &Scene, found: Effects) -> Self {
        // Of a second in s, of a millisecond in us: a thousand times.
        let per_ms = |seconds: f64| 1e3 * seconds;
        let effects = found.effects.into_iter().map(|effect| EffectReport {
            name: effect.name,
            key: effect.key,
            on: effect.on,
            setting: effect.setting,
            cpu_us_per_ms: effect.cost.ok().map(|cost| per_ms(cost.mean)),
            scatter_us_per_ms: effect.cost.ok().map(|cost| per_ms(cost.half_width)),
            setup_ms: effect.setup.map(|setup| 1e3 * setup.mean),
            untold: effect.cost.err().map(|why| why.to_string()),
        });
        Self {
            version: VERSION,
            scene: scene.name.clone(),
            cpu_us_per_ms: per_ms(found.whole),
            setup_ms: 1e3 * found.setup,
            calls_per_ms: 1e-3 * found.calls,
            call_us: 1e6 * found.call,
            effects: effects.collect(),
        }
    }
}

impl EffectReport {
    /// The cost in words: `12 +- 5`, or `< 30` where times scatter by more.
    fn cost(&self) -> String {
        let (Some(cost), Some(scatter)) = (self.cpu_us_per_ms, self.scatter_us_per_ms) else {
            return "-".to_owned();
        };
        if cost.abs() > scatter {
            // A digit of the scatter is enough.
            let digits = usize::from(scatter < 1.0);
            return format!("{cost:.digits$} +- {scatter:.digits$}");
        }
        let below = cost.max(0.0) + scatter;
        format!("< {:.*}", usize::from(below < 10.0), below)
    }

    /// How it is called for, or why nothing can be told.
    fn how(&self) -> String {
        let setup = self.setup_ms.map(|ms| format!("{ms:.1} ms once"));
        let untold = self.untold.as_ref().map(|why| format!("-: {why}"));
        let setting = Some(self.setting.clone()).filter(|setting| !setting.is_empty());
        let words: Vec<String> = [setting, setup, untold].into_iter().flatten().collect();
        words.join("; ")
    }
}

impl Report for EffectsReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{NAME}{}{NAME:#}: {:.0} us of CPU a simulated millisecond, without a recording, after a \
             set-up of {:.0} ms",
            escape::line(&self.scene),
            self.cpu_us_per_ms,
            self.setup_ms
        );
        if self.call_us > 0.0 {
            let _ = write!(
                text,
                "; {:.0} calls of the right-hand side, {:.3} us each",
                self.calls_per_ms, self.call_us
            );
        }
        let _ = writeln!(
            text,
            "\n       {:>14}  {:32}  {:38}  how",
            "us a ms", "effect", "called for by"
        );
        for effect in &self.effects {
            let (style, state) = match effect.on {
                true => (ON, "on"),
                false => (OFF, "off"),
            };
            let row = format!(
                "  {style}{state:3}{style:#}  {:>14}  {:32}  {:38}  {}",
                effect.cost(),
                effect.name,
                effect.key,
                effect.how()
            );
            let _ = writeln!(text, "{}", row.trim_end());
        }
        text.push_str(
            "what is off costs nothing: its number is what it would cost with usual values; with +- half of the \
             interval of 95 %, or < what it is below, where times scatter by more than it costs\n",
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_below_its_scatter_is_told_as_a_bound() {
        let effect = |cost: Option<(f64, f64)>, untold: Option<&str>| EffectReport {
            name: "regime",
            key: "analysis.regime",
            on: true,
            setting: "on".to_owned(),
            cpu_us_per_ms: cost.map(|cost| cost.0),
            scatter_us_per_ms: cost.map(|cost| cost.1),
            setup_ms: None,
            untold: untold.map(str::to_owned),
        };
        assert_eq!(effect(Some((12.3, 4.8)), None).cost(), "12 +- 5");
        assert_eq!(effect(Some((-60.0, 0.25)), None).cost(), "-60.0 +- 0.2");
        assert_eq!(effect(Some((-29.0, 30.0)), None).cost(), "< 30");
        assert_eq!(effect(Some((1.0, 2.0)), None).cost(), "< 3.0");
        let short = effect(None, Some("the run is shorter than its window"));
        assert_eq!(short.cost(), "-");
        assert_eq!(short.how(), "on; -: the run is shorter than its window");
    }
}
