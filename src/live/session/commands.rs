//! The commands of a session: what they may ask for, and what they do.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

use super::{Current, Session, end};
use crate::live::command::{
    Command, DEFAULT_KICK, KICK_RANGE, Opening, Rejected, SPEED_RANGE, check_range,
};
use crate::pipeline::{PendingCommands, RunCommand};
use crate::scene::{PRESETS, Parameter, Scene, SceneError};

impl Session {
    /// Applies a command. Its effect starts with the next frame.
    ///
    /// # Errors
    /// [`Rejected`]; nothing has changed.
    pub fn apply(&self, command: &Command) -> Result<(), Rejected> {
        let mut current = self.current();
        let current = &mut *current;
        let run_command = match command {
            Command::Set { key, value } => {
                change(&current.scene, &mut current.present, key, *value)?
            }
            Command::Pause {} => RunCommand::Pause,
            Command::Resume {} => RunCommand::Resume,
            Command::Step {} => RunCommand::Step,
            Command::Speed { ms_per_s } => {
                let speed = playback_speed(*ms_per_s)?;
                current.speed = speed;
                RunCommand::Speed(speed)
            }
            Command::Kick { mm_per_s } => {
                let kicks = self.kicks.fetch_add(1, Ordering::Relaxed);
                kick(&current.scene, mm_per_s.unwrap_or(DEFAULT_KICK), kicks)?
            }
            Command::Reset {} => {
                let scene = current.scene.clone();
                self.start(current, scene, PendingCommands::default());
                return Ok(());
            }
            Command::Lyapunov { enabled } => {
                let has_them = current.scene.computes_lyapunov();
                if std::mem::replace(&mut current.lyapunov, *enabled) != *enabled && has_them {
                    let scene = current.scene.clone();
                    self.start(current, scene, PendingCommands::default());
                }
                return Ok(());
            }
            Command::Scene { name } => {
                self.start(current, self.named(name)?, PendingCommands::default());
                return Ok(());
            }
            Command::Open(opening) => return self.open(current, opening),
            Command::Tour { step: None } => {
                current.step = None;
                return Ok(());
            }
            Command::Tour { step: Some(number) } => return self.show_step(current, *number),
            Command::Blank { on } => {
                current.blank = *on;
                return Ok(());
            }
            Command::Record {} => {
                let begun = self.recording.start();
                begun.map_err(|fault| Rejected(fault.to_string()))?;
                return Ok(());
            }
            Command::StopRecording {} => {
                self.recording.stop();
                return Ok(());
            }
        };
        if matches!(run_command, RunCommand::Set(..) | RunCommand::Kick { .. }) {
            current.promise = None;
        }
        match &current.handle {
            Some(handle) => handle.send(run_command)?,
            // The run that is being set up receives it.
            None => current.early.add(run_command)?,
        }
        Ok(())
    }

    /// Starts a run of a scene, with commands that act from its first instant.
    fn start(&self, current: &mut Current, scene: Scene, commands: PendingCommands) {
        current.present = scene.clone();
        current.scene = scene;
        current.restarts = true;
        current.early = commands;
        current.promise = None;
        self.kicks.store(0, Ordering::Relaxed);
        if let Some(handle) = current.handle.take() {
            end(&handle);
        }
    }

    fn open(&self, current: &mut Current, opening: &Opening) -> Result<(), Rejected> {
        let scene = self.named(&opening.scene)?;
        let mut commands = PendingCommands::default();
        let (present, changes) = change_all(&scene, &opening.set)?;
        for change in changes {
            commands.add(change)?;
        }
        if let Some(size) = opening.kick_mm_per_s {
            commands.add(kick(&scene, size, 0)?)?;
        }
        if let Some(ms_per_s) = opening.speed_ms_per_s {
            current.speed = playback_speed(ms_per_s)?;
        }
        self.start(current, scene, commands);
        current.present = present;
        current.promise.clone_from(&opening.promise);
        Ok(())
    }

    /// Shows a step of the tour.
    fn show_step(&self, current: &mut Current, number: usize) -> Result<(), Rejected> {
        let steps = self.tour.as_ref().map_or(&[][..], |tour| &tour.steps);
        let step = steps.get(number).ok_or_else(|| {
            Rejected(format!(
                "the tour has {} steps, no step {}",
                steps.len(),
                number + 1
            ))
        })?;
        self.open(current, &step.opening())?;
        current.step = Some(number);
        Ok(())
    }

    fn named(&self, name: &str) -> Result<Scene, Rejected> {
        if name == self.first.name {
            return Ok(self.first.clone());
        }
        let preset = crate::scene::preset(name).ok_or_else(|| {
            let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            Rejected(format!(
                "unknown scene `{name}`; choose one of: {}",
                known.join(", ")
            ))
        })?;
        preset.scene().map_err(|fault| Rejected(fault.to_string()))
    }
}

/// Changes a number of the present scene of a run, if it is a control of the scene at its start and within its range.
fn change(
    scene: &Scene,
    present: &mut Scene,
    key: &str,
    value: f64,
) -> Result<RunCommand, Rejected> {
    let refused = |fault: SceneError| Rejected(fault.to_string());
    let parameter = Parameter::named(key).map_err(refused)?;
    let control = scene.control(parameter).ok_or_else(|| {
        Rejected(format!(
            "a run of the scene `{}` cannot change `{}`",
            scene.name,
            parameter.path()
        ))
    })?;
    let what = format!("the {}", parameter.label());
    check_range(&what, value, control.range, parameter.unit())?;
    present.set(parameter, value).map_err(refused)?;
    Ok(RunCommand::Set(parameter, value))
}

/// A scene with changed numbers, and the commands that change them in a run of it.
///
/// # Errors
/// [`Rejected`], as [`Session::apply`].
pub(in crate::live) fn change_all(
    scene: &Scene,
    values: &BTreeMap<String, f64>,
) -> Result<(Scene, Vec<RunCommand>), Rejected> {
    let mut present = scene.clone();
    let changes = values
        .iter()
        .map(|(key, value)| change(scene, &mut present, key, *value))
        .collect::<Result<_, _>>()?;
    Ok((present, changes))
}

/// Checks a playback speed and converts it to simulated seconds per second.
fn playback_speed(ms_per_s: f64) -> Result<f64, Rejected> {
    Ok(1e-3 * check_range("the playback speed", ms_per_s, SPEED_RANGE, "ms/s")?)
}

/// The kick with this number in a run, mm/s. Each has another direction, and differs from the initial kick.
fn kick(scene: &Scene, mm_per_s: f64, number: u64) -> Result<RunCommand, Rejected> {
    let size = 1e-3 * check_range("a kick", mm_per_s, KICK_RANGE, "mm/s")?;
    let seed = scene.start.seed.wrapping_add(1 + number);
    Ok(RunCommand::Kick { size, seed })
}
