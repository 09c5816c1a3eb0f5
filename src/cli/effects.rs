//! `squeakscope scenes --effects NAME`: what a scene calls for, and what each of it costs.

use std::fmt::Write as _;
use std::sync::atomic::Ordering;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::error::{Cause, CliError};
use super::interrupt;
use super::output::OutputFile;
use super::progress::Progress;
use super::report::{self, Report};
use crate::VERSION;
use crate::scene::Scene;
use crate::study::effects::{Effects, Watch};

const NAME: Style = Style::new().bold();
const ON: Style = AnsiColor::Green.on_default();
const OFF: Style = Style::new().dimmed();

/// Measures the effects of a scene.
pub(super) type Measure = fn(&Scene, Watch<'_>) -> Result<Option<Effects>, Cause>;

/// Measures, and tells.
///
/// # Errors
/// A fault while running or writing; Ctrl-C.
pub(super) fn effects(
    scene: &Scene,
    json: Option<&OutputFile>,
    measure: Measure,
) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    let progress = Progress::of_estimate();
    let found = measure(scene, &mut |share| {
        progress.tell(share, "effects".to_owned());
        !stop.load(Ordering::Relaxed)
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

/// Result of `squeakscope scenes --effects`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectsReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// CPU time of a simulated millisecond with all that is on, without a recording, us.
    pub cpu_us_per_ms: f64,
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
            cpu_us_per_ms: effect.seconds.map(per_ms),
        });
        Self {
            version: VERSION,
            scene: scene.name.clone(),
            cpu_us_per_ms: per_ms(found.whole),
            calls_per_ms: 1e-3 * found.calls,
            call_us: 1e6 * found.call,
            effects: effects.collect(),
        }
    }
}

impl Report for EffectsReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{NAME}{}{NAME:#}: {:.0} us of CPU a simulated millisecond, without a recording",
            self.scene, self.cpu_us_per_ms
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
            "\n       {:>9}  {:32}  {:26}  how",
            "us a ms", "effect", "called for by"
        );
        for effect in &self.effects {
            let (style, state) = match effect.on {
                true => (ON, "on"),
                false => (OFF, "off"),
            };
            let cost = match effect.cpu_us_per_ms {
                Some(cost) => format!("{:+.1}", cost + 0.0),
                None => "–".to_owned(),
            };
            let row = format!(
                "  {style}{state:3}{style:#}  {cost:>9}  {:32}  {:26}  {}",
                effect.name, effect.key, effect.setting
            );
            let _ = writeln!(text, "{}", row.trim_end());
        }
        text.push_str(
            "what is off costs nothing: its number is what it would cost with usual values; about zero, of \
             either sign, is less than times scatter\n",
        );
        text
    }
}
