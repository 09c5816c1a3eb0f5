//! Commands that wait for the next frame, combined into bounded memory.

use serde::{Deserialize, Serialize};

use crate::scene::{Parameter, Scene};

/// A state of a run at a sample. A run of the same scene continues from it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunState {
    /// Simulated time, s: schedules of the scene continue there.
    pub time_s: f64,
    /// Modal coordinates, modal velocities and states of friction, as the integrator has them.
    pub values: Vec<f64>,
    /// Phase of the drive of a small system at the time 0, rad: a change of the drive frequency shifts it.
    #[serde(default)]
    pub drive_phase: f64,
}

/// A command to an interactive run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunCommand {
    /// Start at the time of a state and from it. Only before the first frame.
    Continue(RunState),
    /// Change a number of the scene, in the unit of a scene file; see
    /// [`Simulation::set`](super::Simulation::set).
    Set(Parameter, f64),
    /// Add a random velocity to each mode; see [`Simulation::kick`](super::Simulation::kick).
    Kick {
        /// Standard deviation, sqrt(kg) m/s.
        size: f64,
        /// Seed of the random numbers.
        seed: u64,
    },
    /// Pause the simulation.
    Pause,
    /// Resume the simulation.
    Resume,
    /// Compute one frame, then pause.
    Step,
    /// Set the playback speed: simulated seconds per second of wall time, above 0.
    Speed(f64),
    /// End the run.
    End,
}

/// Maximum number of kicks per frame.
pub const MAX_KICKS_PER_FRAME: usize = 4;

/// Too many kicks: the next frame already has the maximum number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a frame accepts at most {MAX_KICKS_PER_FRAME} kicks; kick again after the next frame")]
pub struct TooManyKicks;

/// Pending commands since the last frame, combined, see [`RunHandle::send`](super::RunHandle::send). A single step pauses the
/// run, and a resume cancels it; several steps are one. Kicks follow the changed numbers. An end is final.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PendingCommands {
    /// State from which the run starts; its own start by default.
    pub(super) start: Option<RunState>,
    /// Changed numbers with their values in the unit of a scene file, each number once.
    pub(super) values: Vec<(Parameter, f64)>,
    /// Size (sqrt(kg) m/s) and seed of each kick.
    pub(super) kicks: Vec<(f64, u64)>,
    pub(super) control: Control,
    /// The scene of the run once it has refused a number.
    pub(super) refusal: Option<Scene>,
}

/// Commands that apply immediately, even while the run is paused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Control {
    pub pause: Option<bool>,
    pub step: bool,
    /// Playback speed, simulated seconds per second of wall time.
    pub speed: Option<f64>,
    pub end: bool,
}

impl PendingCommands {
    /// Adds a command.
    ///
    /// # Errors
    /// [`TooManyKicks`]; nothing has changed.
    pub fn add(&mut self, command: RunCommand) -> Result<(), TooManyKicks> {
        let control = &mut self.control;
        match command {
            RunCommand::Continue(state) => self.start = Some(state),
            RunCommand::Set(parameter, value) => {
                self.values.retain(|(known, _)| *known != parameter);
                self.values.push((parameter, value));
            }
            RunCommand::Kick { .. } if self.kicks.len() >= MAX_KICKS_PER_FRAME => {
                return Err(TooManyKicks);
            }
            RunCommand::Kick { size, seed } => self.kicks.push((size, seed)),
            RunCommand::Pause => control.pause = Some(true),
            RunCommand::Resume => (control.pause, control.step) = (Some(false), false),
            RunCommand::Step => (control.pause, control.step) = (Some(true), true),
            RunCommand::Speed(speed) => control.speed = Some(speed),
            RunCommand::End => control.end = true,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_commands_are_combined_into_a_few() {
        let mut pending = PendingCommands::default();
        let mut refused = 0;
        for k in 0..1_000_000_u64 {
            let x = k as f64;
            let kick = RunCommand::Kick { size: x, seed: k };
            for command in [
                RunCommand::Set(Parameter::tilt(), x),
                RunCommand::Pause,
                RunCommand::Speed(1.0 + x),
                kick,
            ] {
                refused += u64::from(pending.add(command).is_err());
            }
        }
        assert_eq!(refused, 1_000_000 - MAX_KICKS_PER_FRAME as u64);
        let expected = PendingCommands {
            start: None,
            refusal: None,
            values: vec![(Parameter::tilt(), 999_999.0)],
            kicks: (0..MAX_KICKS_PER_FRAME as u64)
                .map(|k| (k as f64, k))
                .collect(),
            control: Control {
                pause: Some(true),
                speed: Some(1e6),
                ..Control::default()
            },
        };
        assert_eq!(pending, expected);
    }

    #[test]
    fn the_last_of_pause_step_and_resume_counts() {
        let after = |commands: &[RunCommand]| {
            let mut pending = PendingCommands::default();
            for command in commands {
                pending.add(command.clone()).unwrap();
            }
            (pending.control.pause, pending.control.step)
        };
        assert_eq!(
            after(&[RunCommand::Pause, RunCommand::Resume]),
            (Some(false), false)
        );
        assert_eq!(
            after(&[RunCommand::Step, RunCommand::Resume]),
            (Some(false), false)
        );
        assert_eq!(
            after(&[RunCommand::Resume, RunCommand::Step]),
            (Some(true), true)
        );
        assert_eq!(
            after(&[RunCommand::Step, RunCommand::Pause]),
            (Some(true), true)
        );
    }
}
