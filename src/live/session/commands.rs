//! The commands of a session: what they may ask for, and what they do.

use std::sync::atomic::Ordering;

use super::{Current, Session, end};
use crate::live::command::{Command, DEFAULT_KICK, KICK_RANGE, Rejected, SPEED_RANGE, check_range};
use crate::pipeline::RunCommand;
use crate::scene::{PRESETS, Scene};

impl Session {
    /// Applies a command. Its effect starts with the next frame.
    ///
    /// # Errors
    /// [`Rejected`]; nothing has changed.
    pub fn apply(&self, command: &Command) -> Result<(), Rejected> {
        let mut current = self.current();
        let run_command = match command {
            Command::Tilt { deg } => RunCommand::Tilt(self.tilt(&current, *deg)?),
            Command::Pause {} => RunCommand::Pause,
            Command::Resume {} => RunCommand::Resume,
            Command::Step {} => RunCommand::Step,
            Command::Speed { ms_per_s } => {
                let speed =
                    1e-3 * check_range("the playback speed", *ms_per_s, SPEED_RANGE, "ms/s")?;
                current.speed = speed;
                RunCommand::Speed(speed)
            }
            Command::Kick { mm_per_s } => {
                let size = mm_per_s.unwrap_or(DEFAULT_KICK);
                let size = 1e-3 * check_range("a kick", size, KICK_RANGE, "mm/s")?;
                // Each kick has another direction; the first one differs from the initial kick.
                let kicks = self.kicks.fetch_add(1, Ordering::Relaxed) + 1;
                let seed = current.scene.start.seed.wrapping_add(kicks);
                RunCommand::Kick { size, seed }
            }
            Command::Reset {} => {
                current.next = Some(current.scene.clone());
                RunCommand::End
            }
            Command::Lyapunov { enabled } => {
                let has_them = current.scene.computes_lyapunov();
                if std::mem::replace(&mut current.lyapunov, *enabled) == *enabled || !has_them {
                    return Ok(());
                }
                current.next = Some(current.scene.clone());
                RunCommand::End
            }
            Command::Scene { name } => {
                current.next = Some(self.named(name)?);
                RunCommand::End
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
        if run_command == RunCommand::End {
            // Later commands apply to the next run.
            if let Some(handle) = current.handle.take() {
                end(&handle);
            }
            return Ok(());
        }
        match &current.handle {
            Some(handle) => handle.send(run_command)?,
            // The run that is being set up receives it.
            None => current.early.add(run_command)?,
        }
        Ok(())
    }

    /// Checks a requested tilt and converts it to rad.
    fn tilt(&self, current: &Current, deg: f64) -> Result<f64, Rejected> {
        if current.next.is_some() {
            return Err(Rejected(
                "another run is about to start; try again".to_owned(),
            ));
        }
        let Some(range) = current.tilt_range_deg else {
            let scene = &current.scene.name;
            return Err(Rejected(format!("the scene `{scene}` has no tilt")));
        };
        let deg = check_range("the tilt", deg, range, "degrees")?;
        let tilted = current.scene.clone().with_tilt(deg);
        tilted.map_err(|fault| Rejected(fault.to_string()))?;
        Ok(deg.to_radians())
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
