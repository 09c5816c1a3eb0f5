//! The commands of a session: what they may ask for, and what they do.

use std::f64::consts::TAU;

use super::{Current, Session, end};
use crate::live::command::{
    Command, DEFAULT_KICK, KICK_RANGE, Rejected, SPEED_RANGE, check_range, rejected,
};
use crate::live::lock;
use crate::live::tour::TourStep;
use crate::pipeline::{RunCommand, RunHandle, RunState, prepare};
use crate::scene::{PRESETS, Scene};

/// Range of the values of a state: far beyond any motion of a joint.
const STATE_RANGE: [f64; 2] = [-1e3, 1e3];

impl Session {
    /// Applies a command. Its effect starts with the next frame.
    ///
    /// # Errors
    /// [`Rejected`]; nothing has changed.
    pub fn apply(&self, command: &Command) -> Result<(), Rejected> {
        if let Command::Open(step) = command {
            // Before the lock: it takes a moment.
            check_state(&self.named(&step.scene)?, step.state.as_ref())?;
        }
        let mut current = lock(&self.current);
        let current = &mut *current;
        let run = current.handle.clone();
        let send = |command| run.send(command).map_err(rejected);
        match command {
            Command::Set { key, value } => {
                if let Some(scene) = run.take_refusal() {
                    current.present = scene;
                }
                let set = change(&current.scene, &mut current.present, key, *value)?;
                current.promise = None;
                send(set)?;
            }
            Command::Pause {} => send(RunCommand::Pause)?,
            Command::Resume {} => send(RunCommand::Resume)?,
            Command::Step {} => send(RunCommand::Step)?,
            Command::Speed { ms_per_s } => {
                current.speed = playback_speed(*ms_per_s)?;
                send(RunCommand::Speed(current.speed))?;
            }
            Command::Kick { mm_per_s } => {
                current.kicks += 1;
                let size = mm_per_s.unwrap_or(DEFAULT_KICK);
                let kick = kick(&current.scene, size, current.kicks)?;
                current.promise = None;
                send(kick)?;
            }
            Command::Reset {} => self.restart(current)?,
            Command::Lyapunov { enabled } => {
                let has_them = current.scene.computes_lyapunov();
                if std::mem::replace(&mut current.lyapunov, *enabled) != *enabled && has_them {
                    self.restart(current)?;
                }
            }
            Command::Scene { name } => self.open(current, &TourStep::of_scene(name))?,
            Command::Open(step) => self.open(current, step)?,
            Command::Tour { step: None } => current.step = None,
            Command::Tour { step: Some(number) } => self.show_step(current, *number)?,
            Command::Blank { on } => current.blank = *on,
            Command::Record {} => {
                self.recording.start().map_err(rejected)?;
            }
            Command::StopRecording {} => self.recording.stop(),
        }
        Ok(())
    }

    /// Starts a run of a scene with the settings of a step.
    fn open(&self, current: &mut Current, step: &TourStep) -> Result<(), Rejected> {
        let scene = self.named(&step.scene)?;
        let (present, commands) = start_commands(&scene, step)?;
        if let Some(ms_per_s) = step.speed_ms_per_s {
            current.speed = playback_speed(ms_per_s)?;
        }
        // The present run ends, and the next one has these commands and those that follow.
        end(&current.handle);
        current.handle = RunHandle::new(current.speed);
        for command in commands {
            current.handle.send(command).map_err(rejected)?;
        }
        current.opened += 1;
        (current.scene, current.present) = (scene, present);
        current.promise.clone_from(&step.promise);
        current.opening = TourStep {
            speed_ms_per_s: None,
            ..step.clone()
        };
        current.kicks = 0;
        Ok(())
    }

    /// Starts the run again as it was started.
    fn restart(&self, current: &mut Current) -> Result<(), Rejected> {
        let opening = current.opening.clone();
        self.open(current, &opening)
    }

    /// Shows a step of the tour.
    fn show_step(&self, current: &mut Current, number: usize) -> Result<(), Rejected> {
        let tour = self.options.tour.as_ref();
        let steps = tour.map_or(&[][..], |tour| &tour.steps);
        let step = steps.get(number).ok_or_else(|| {
            Rejected(format!(
                "the tour has {} steps, no step {}",
                steps.len(),
                number + 1
            ))
        })?;
        self.open(current, step)?;
        current.step = Some(number);
        Ok(())
    }

    fn named(&self, name: &str) -> Result<Scene, Rejected> {
        if name == self.options.scene.name {
            return Ok(self.options.scene.clone());
        }
        preset_scene(name)
    }
}

/// The preset with a name.
pub(in crate::live) fn preset_scene(name: &str) -> Result<Scene, Rejected> {
    let preset = crate::scene::preset(name).ok_or_else(|| {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        let known = known.join(", ");
        Rejected(format!("unknown scene `{name}`; choose one of: {known}"))
    })?;
    preset.scene().map_err(rejected)
}

/// A scene with the numbers of a step, and the commands with which a run of it starts, all of them checked.
///
/// # Errors
/// [`Rejected`], as [`Session::apply`].
pub(in crate::live) fn start_commands(
    scene: &Scene,
    step: &TourStep,
) -> Result<(Scene, Vec<RunCommand>), Rejected> {
    let mut present = scene.clone();
    let state = step.state.clone().map(RunCommand::Continue);
    let mut commands = Vec::from_iter(state);
    for (key, value) in &step.set {
        commands.push(change(scene, &mut present, key, *value)?);
    }
    if let Some(size) = step.kick_mm_per_s {
        commands.push(kick(scene, size, 1)?);
    }
    step.speed_ms_per_s.map(playback_speed).transpose()?;
    Ok((present, commands))
}

/// Checks that a run of a scene can start from a state.
pub(in crate::live) fn check_state(
    scene: &Scene,
    state: Option<&RunState>,
) -> Result<(), Rejected> {
    let Some(RunState {
        time_s,
        values,
        drive_phase,
    }) = state
    else {
        return Ok(());
    };
    let fits = prepare(scene).map_err(rejected)?;
    let (name, found, expected) = (&scene.name, values.len(), fits.state.len());
    if found != expected {
        return Err(Rejected(format!(
            "the bookmark is of another version of `{name}`: its state has {found} values, that of the scene {expected}"
        )));
    }
    check_range("the time of a state", *time_s, [0.0, 1e6], "s")?;
    check_range("the phase of a drive", *drive_phase, [0.0, TAU], "rad")?;
    for value in values {
        check_range("a value of a state", *value, STATE_RANGE, "in SI units")?;
    }
    Ok(())
}

/// Changes a number of the present scene of a run, if it is a control of the scene at its start and within its range.
fn change(
    scene: &Scene,
    present: &mut Scene,
    key: &str,
    value: f64,
) -> Result<RunCommand, Rejected> {
    let parameter = scene.parameter(key).map_err(rejected)?;
    let control = scene.control(parameter).ok_or_else(|| {
        Rejected(format!(
            "a run of the scene `{}` cannot change `{}`",
            scene.name,
            parameter.path()
        ))
    })?;
    let what = format!("the {}", parameter.label());
    check_range(&what, value, control.range, parameter.unit())?;
    present.set(parameter, value).map_err(rejected)?;
    Ok(RunCommand::Set(parameter, value))
}

/// Checks a playback speed and converts it to simulated seconds per second.
fn playback_speed(ms_per_s: f64) -> Result<f64, Rejected> {
    Ok(1e-3 * check_range("the playback speed", ms_per_s, SPEED_RANGE, "ms/s")?)
}

/// The kick with this number in a run, from 1, mm/s. Each has another direction, and differs from the initial kick.
fn kick(scene: &Scene, mm_per_s: f64, number: u64) -> Result<RunCommand, Rejected> {
    let size = 1e-3 * check_range("a kick", mm_per_s, KICK_RANGE, "mm/s")?;
    let seed = scene.start.seed.wrapping_add(number);
    Ok(RunCommand::Kick { size, seed })
}
