//! An interactive run: it continues until it is stopped, follows a playback speed and accepts commands.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, bounded};
use serde::{Deserialize, Serialize};

use super::PipelineError;
use super::message::{DisplayRates, Frame, Header, Kick};
use super::{Simulation, Source};
use crate::dynamics::DynamicsError;
use crate::number::trimmed;
use crate::scene::{Parameter, Scene};

/// Maximum lag behind the playback speed. A run that lags more does not try to catch up.
const MAX_LAG: Duration = Duration::from_millis(150);
/// Wall time over which the playback speed is measured.
const SPEED_WINDOW: Duration = Duration::from_millis(500);

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
    /// [`Simulation::set`].
    Set(Parameter, f64),
    /// Add a random velocity to each mode; see [`Simulation::kick`].
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

/// Pending commands since the last frame, combined, see [`RunHandle::send`]. A single step pauses the
/// run, and a resume cancels it; several steps are one. Kicks follow the changed numbers. An end is final.
#[derive(Clone, Debug, Default, PartialEq)]
struct PendingCommands {
    /// State from which the run starts; its own start by default.
    start: Option<RunState>,
    /// Changed numbers with their values in the unit of a scene file, each number once.
    values: Vec<(Parameter, f64)>,
    /// Size (sqrt(kg) m/s) and seed of each kick.
    kicks: Vec<(f64, u64)>,
    control: Control,
    /// The scene of the run once it has refused a number.
    refusal: Option<Scene>,
}

/// Commands that apply immediately, even while the run is paused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Control {
    pause: Option<bool>,
    step: bool,
    /// Playback speed, simulated seconds per second of wall time.
    speed: Option<f64>,
    end: bool,
}

impl PendingCommands {
    /// Adds a command.
    ///
    /// # Errors
    /// [`TooManyKicks`]; nothing has changed.
    fn add(&mut self, command: RunCommand) -> Result<(), TooManyKicks> {
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

/// Present state of an interactive run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStatus {
    /// Requested playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Measured playback speed, same unit; `None` while paused and before the first measurement.
    pub measured_speed: Option<f64>,
    /// Whether the run is paused.
    pub paused: bool,
}

/// Sends commands to an interactive run. Can be used from any thread and never blocks.
#[derive(Clone, Debug)]
pub struct RunHandle {
    pending: Arc<Mutex<PendingCommands>>,
    /// Wakes up a waiting run. A run that has ended ignores it.
    wake: Sender<()>,
    woken: Receiver<()>,
    status: Arc<Mutex<RunStatus>>,
}

impl RunHandle {
    /// A handle for a run that will start at the playback speed `speed` (simulated seconds per second).
    pub fn new(speed: f64) -> Self {
        let (wake, woken) = bounded(1);
        Self {
            pending: Arc::default(),
            wake,
            woken,
            status: Arc::new(Mutex::new(RunStatus {
                speed,
                measured_speed: None,
                paused: false,
            })),
        }
    }

    /// Sends a command, which takes effect before the next frame. Commands sent between two frames are combined: of several
    /// values of one number, playback speeds, or pause and resume commands, the last one applies; kicks add up to
    /// [`MAX_KICKS_PER_FRAME`].
    ///
    /// # Errors
    /// [`TooManyKicks`].
    pub fn send(&self, command: RunCommand) -> Result<(), TooManyKicks> {
        lock(&self.pending).add(command)?;
        // If the channel is full, a wake-up is already pending.
        let _ = self.wake.try_send(());
        Ok(())
    }

    /// The scene of the run, with its present numbers, if it has refused one since the last call.
    pub fn take_refusal(&self) -> Option<Scene> {
        lock(&self.pending).refusal.take()
    }

    /// Present state of the run.
    pub fn status(&self) -> RunStatus {
        *lock(&self.status)
    }
}

/// Locks a mutex. After a panic in another thread the value may belong to two different instants, which is acceptable.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A simulation that can be controlled while it runs.
pub struct InteractiveSource {
    source: Simulation,
    handle: RunHandle,
    /// A wall time and the corresponding simulated time, s. Frames are due relative to them at the present
    /// speed.
    anchor: (Instant, f64),
    /// Start of the speed measurement: wall time and simulated time, s.
    measured: (Instant, f64),
    /// Whether to compute a single frame although the run is paused.
    step: bool,
    ended: bool,
    /// Descriptions of the commands applied since the last frame.
    done: Vec<String>,
    /// Kicks applied since the last frame.
    kicks: Vec<Kick>,
}

impl InteractiveSource {
    /// Makes a simulation interactive. Commands sent before apply to its first frame. It goes on until
    /// [`RunCommand::End`], even if nobody else has a handle.
    pub fn new(mut source: Simulation, handle: &RunHandle) -> Self {
        source.run_until_stopped();
        let time = source.time();
        let mut run = Self {
            source,
            handle: handle.clone(),
            anchor: (Instant::now(), time),
            measured: (Instant::now(), time),
            step: false,
            ended: false,
            done: Vec::new(),
            kicks: Vec::new(),
        };
        run.set_speed(handle.status().speed);
        run
    }

    fn set_speed(&mut self, speed: f64) {
        self.restart_clock();
        lock(&self.handle.status).speed = speed;
        let (samples, shown) = DisplayRates::at_speed(speed, self.source.scene().sample_rate);
        self.source.set_frame_length(samples, shown);
    }

    /// Restarts the clock at the present wall time and the simulated time that is due now. Repeated changes
    /// of the speed therefore do not accelerate the run.
    fn restart_clock(&mut self) {
        let now = Instant::now();
        let mut status = lock(&self.handle.status);
        // The speed measured so far no longer applies.
        status.measured_speed = None;
        let (wall, from) = self.anchor;
        let elapsed = if status.paused {
            0.0
        } else {
            status.speed * (now - wall).as_secs_f64()
        };
        let time = self.source.time();
        self.anchor = (now, time.min(from + elapsed));
        self.measured = (now, time);
    }

    /// Records the description of an applied command. It replaces an earlier one that starts with the same
    /// word.
    fn describe(&mut self, text: String) {
        let kind = text.split(' ').next();
        self.done.retain(|known| known.split(' ').next() != kind);
        self.done.push(text);
    }

    /// Applies the commands that need not wait for the next frame.
    fn apply_controls(&mut self) {
        let control = std::mem::take(&mut lock(&self.handle.pending).control);
        let status = self.handle.status();
        if let Some(speed) = control.speed.filter(|speed| *speed != status.speed) {
            self.set_speed(speed);
            self.describe(format!("playback speed {} ms/s", trimmed(1e3 * speed, 4)));
        }
        if let Some(pause) = control.pause.filter(|pause| *pause != status.paused) {
            self.restart_clock();
            lock(&self.handle.status).paused = pause;
            self.describe(if pause { "paused" } else { "resumed" }.to_owned());
        }
        if control.step {
            self.step = true;
            self.describe("single step".to_owned());
        }
        self.ended |= control.end;
    }

    /// Applies the changed numbers and the kicks with which the next frame starts.
    fn apply_changes(&mut self) -> Result<(), PipelineError> {
        let (start, values, kicks) = {
            let mut pending = lock(&self.handle.pending);
            let values = std::mem::take(&mut pending.values);
            let kicks = std::mem::take(&mut pending.kicks);
            (pending.start.take(), values, kicks)
        };
        if let Some(start) = &start {
            self.source.seek(start.time_s)?;
            self.anchor = (Instant::now(), self.source.time());
            self.measured = self.anchor;
        }
        for (parameter, value) in values {
            let change = parameter.with_value(value);
            let refusal = match self.source.set(parameter, value) {
                Err(PipelineError::Scene(error)) => error.to_string(),
                Err(PipelineError::Assembly(error)) => error.to_string(),
                applied => {
                    self.done.push(applied.map(|()| change)?);
                    continue;
                }
            };
            // The run continues as it was.
            self.done.push(format!("{change} refused: {refusal}"));
            lock(&self.handle.pending).refusal = Some(self.source.scene().clone());
        }
        if let Some(start) = &start {
            self.source.set_state(start)?;
        }
        for (size, seed) in kicks {
            self.source.kick(size, seed)?;
            let time = self.source.time();
            self.kicks.push(Kick {
                time_s: time,
                size,
                seed,
            });
            self.done.push(format!(
                "kick of {} mm/s, seed {seed}",
                trimmed(1e3 * size, 4)
            ));
        }
        Ok(())
    }

    /// Waits until the next frame is due, or the run is stopped.
    fn wait(&mut self) {
        loop {
            self.apply_controls();
            let status = self.handle.status();
            let due = self.due(status);
            if self.ended || self.step || (!status.paused && Instant::now() >= due) {
                return;
            }
            // The loop checks the reason for the wake-up.
            let _ = if status.paused {
                self.handle.woken.recv().ok()
            } else {
                self.handle.woken.recv_deadline(due).ok()
            };
        }
    }

    /// Wall time at which the next frame is due.
    fn due(&self, status: RunStatus) -> Instant {
        let (wall, time) = self.anchor;
        wall + Duration::from_secs_f64((self.source.time() - time) / status.speed)
    }

    /// Updates the time and the measured speed after a frame.
    fn measure_speed(&mut self) {
        let now = Instant::now();
        let time = self.source.time();
        let mut status = lock(&self.handle.status);
        let (since, from) = self.measured;
        let wall = now - since;
        if !status.paused && wall >= SPEED_WINDOW {
            status.measured_speed = Some((time - from) / wall.as_secs_f64());
            self.measured = (now, time);
        }
        let (wall, from) = self.anchor;
        if now > wall + Duration::from_secs_f64((time - from) / status.speed) + MAX_LAG {
            self.anchor = (now, time);
        }
    }
}

impl Source for InteractiveSource {
    fn header(&self, command: &str) -> Header {
        self.source.header(command)
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        self.wait();
        if self.ended {
            return Ok(None);
        }
        match self.apply_changes() {
            // Stopped while a command was applied.
            Err(PipelineError::Dynamics(DynamicsError::Stopped(_))) => return Ok(None),
            taken => taken?,
        }
        let Some(mut frame) = self.source.next_frame()? else {
            return Ok(None);
        };
        frame.events = std::mem::take(&mut self.done);
        frame.kicks = std::mem::take(&mut self.kicks);
        if std::mem::take(&mut self.step) {
            // The playback clock does not wait for the time that the step has covered.
            self.anchor = (Instant::now(), self.source.time());
        }
        self.measure_speed();
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.ended
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.source.set_stop_flag(stop);
    }
}

#[cfg(test)]
#[path = "interactive_tests.rs"]
mod tests;
