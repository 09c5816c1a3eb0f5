//! What accuracy and effects cost: the error of each numerical setting against time, the price of each effect of a
//! scene, and the cheapest settings for a total error.
//!
//! Every run starts from one settled state, settles for the same time and is measured in the same window. An error is
//! the largest relative difference of the strongest line's frequency and amplitude and of the rms velocity from those of
//! a reference, which is one level finer than the finest level that is shown. A chaotic motion has neither a line nor an
//! amplitude that converges: its error is that of the rms velocity, and no smaller than the scatter of the average.

mod effects;
mod motion;
mod settings;

#[cfg(test)]
pub(crate) mod tests;

use schemars::JsonSchema;
use serde::Serialize;

use super::{OnProgress, StudyError};
use crate::number::{error, quantity, short, tolerance};
use crate::report::{Block, Measured, Report, Table};
use crate::scene::{FixedAt, LoadedJoint, Scene};

pub use effects::{Effect, RunAll};
pub use motion::Motion;
pub use settings::{Choice, Origin, Setting, Settings, TARGETS, WorkPrecision, WorkPrecisionPoint};

use motion::Runner;

/// Result of a cost study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Cost {
    /// Values at which the scheduled parameters of the scene are fixed while its motion is measured.
    pub fixed_at: FixedAt,
    /// Time for which each run settles before it is measured, s.
    pub settling_s: f64,
    /// Time for which the settled motion is measured, s.
    pub measurement_s: f64,
    /// The settled motion at the finest settings.
    pub reference: Motion,
    /// Relative difference of two successive measurements of the reference; `null` unless the motion is chaotic. Smaller
    /// errors of a chaotic motion cannot be seen.
    pub scatter: Option<f64>,
    /// Error against time of each numerical setting.
    pub settings: Vec<WorkPrecision>,
    /// CPU time of a complete run, s per simulated second, with the analyses and the recording of the scene; `null` if the
    /// study was stopped before.
    pub run_cpu_s_per_s: Option<f64>,
    /// Price of each effect that the scene has on.
    pub effects: Vec<Effect>,
    /// Settings for total errors, each verified by one run at the next finer level of everything.
    pub choices: Vec<Choice>,
    /// Whether the study was stopped early: the rest is missing.
    pub stopped: bool,
}

/// Runs a cost study on the calling thread, so that times are comparable. `run_all` runs a scene with everything that
/// it records, for the price of the recording; without it, there is none. If it is stopped, the result has what
/// is complete.
///
/// # Errors
/// [`StudyError::Stopped`] if nothing is complete; if the scene is at rest, or has no settled motion that can be measured.
pub fn cost(
    scene: &Scene,
    run_all: Option<RunAll<'_>>,
    progress: OnProgress<'_>,
) -> Result<Cost, StudyError> {
    let mut runner = Runner::settle(scene, progress)?;
    runner.begin("reference", 0.05);
    let (reference, again) = runner.twice(&settings::finest(scene)?)?;
    let joint = scene.joint();
    let mut study = Cost {
        fixed_at: joint.map(LoadedJoint::fixed_at_start).unwrap_or_default(),
        settling_s: runner.plan.min_transient_s,
        measurement_s: runner.plan.measurement_s,
        scatter: (!reference.has_lines()).then(|| again.difference(&reference)),
        reference,
        ..Cost::default()
    };
    let done = settings::vary(&mut runner, &mut study)
        .and_then(|()| settings::choose(&mut runner, &mut study))
        .and_then(|()| effects::price(&mut runner, run_all, &mut study));
    match done {
        Err(StudyError::Stopped(_)) if !study.settings.is_empty() => study.stopped = true,
        done => done?,
    }
    Ok(study)
}

impl Report for Cost {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let rest = format!(
            ": {}; settles for {}, measured for {}",
            motion(&self.reference),
            quantity(self.settling_s, 3, "s"),
            quantity(self.measurement_s, 3, "s"),
        );
        let mut blocks = vec![Block::heading(scene, rest)];
        let held = self.fixed_at.description();
        blocks.extend(held.map(|it| Block::text(format!("held at its initial values: {it}"))));
        if let Some(scatter) = self.scatter {
            blocks.push(Block::text(format!(
                "two measurements of this motion differ by {}: smaller errors cannot be seen",
                error(scatter)
            )));
        }
        for setting in Setting::ALL {
            let sets = self.settings.iter().filter(|set| set.setting == setting);
            let sets: Vec<&WorkPrecision> = sets.collect();
            if !sets.is_empty() {
                let rest = format!(": error, and {}", setting.time());
                blocks.push(Block::heading(setting.name(), rest));
                blocks.push(levels(&sets));
            }
        }
        if !self.choices.is_empty() {
            let rest = ", verified by a run at the next finer level of everything";
            blocks.push(Block::heading("settings for a total error", rest));
            blocks.push(choices(self));
        }
        if let Some(run) = self.run_cpu_s_per_s {
            let run = short(run);
            let rest = format!(": a complete run takes {run} s of CPU time per simulated s");
            blocks.push(Block::heading("effects", rest));
            blocks.push(effects(&self.effects));
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.stopped
    }
}

/// The type of a motion, its frequency, amplitude, velocity and largest exponent.
fn motion(motion: &Motion) -> String {
    let mut text = motion.regime.to_string();
    if let (Some(frequency), Some(amplitude)) = (motion.frequency_hz, motion.amplitude_m) {
        let amplitude = quantity(amplitude, 4, "m");
        text += &format!(", {frequency:.1} Hz with {amplitude}");
    }
    let rms = quantity(motion.rms_velocity_m_per_s, 4, "m/s");
    text += &format!(", rms velocity {rms}");
    if let Some(exponent) = motion.exponent_per_s {
        let exponent = Measured::from(&exponent).unit("1/s");
        text += &format!(", largest exponent {exponent}");
    }
    text
}

/// The levels of one setting: a column for each method.
fn levels(sets: &[&WorkPrecision]) -> Block {
    let table = Table::of(sets[0].points.iter().enumerate());
    let table = table.right("", |(_, level)| tolerance(level.value));
    let table = sets.iter().fold(table, |table, set| {
        table
            .right(set.method, |(row, _)| match set.points.get(*row)?.error {
                Some(found) => Some(error(found)),
                None => Some("failed".to_owned()),
            })
            .right("", |(row, _)| {
                let point = set.points.get(*row)?;
                point.error.map(|_| short(point.cpu_s))
            })
    });
    table.into()
}

fn choices(study: &Cost) -> Block {
    Table::of(&study.choices)
        .right("error", |choice| error(choice.target))
        .left("", |choice| match choice.origin {
            Origin::Cheapest => "cheapest",
            Origin::Accuracy => "--accuracy",
        })
        .left("method", |choice| choice.settings.method)
        .right("tolerance", |choice| tolerance(choice.settings.tolerance))
        .right("nodes", |choice| {
            choice.settings.nodes.map(|nodes| nodes.to_string())
        })
        .right("elements, mm", |choice| {
            choice.settings.element_size_mm.map(short)
        })
        .right("s per s", |choice| short(choice.cpu_s_per_s))
        .right("verified", |choice| error(choice.error))
        .left("", |choice| match (choice.is_met, choice.exponents_agree) {
            (false, _) => "not met",
            (true, Some(false)) => "exponents differ",
            (true, _) => "",
        })
        .into()
}

fn effects(effects: &[Effect]) -> Block {
    Table::of(effects)
        .left("effect", |effect| effect.name.clone())
        .left("key", |effect| effect.key.clone())
        .right("s per s", |effect| {
            let price = effect.price_s_per_s?;
            Some(if price.abs() < effect.noise_s_per_s {
                format!("< {}", short(effect.noise_s_per_s))
            } else {
                short(price)
            })
        })
        .right("ratio", |effect| effect.ratio.map(short))
        .left("without it", |effect| {
            if let Some(reason) = &effect.unavailable {
                return Some(format!("cannot be switched off alone: {reason}"));
            }
            let (other, change) = effect.without.as_ref().zip(effect.change)?;
            Some(format!("{} ({} different)", motion(other), error(change)))
        })
        .into()
}
