//! An interactive run: it continues until it is stopped, follows a playback speed and accepts commands.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded};

use super::PipelineError;
use super::message::{DisplayRates, Frame, Header, Kick};
use super::pending::{PendingCommands, RunCommand, TooManyKicks};
use super::source::{ControllableSource, Source};
use crate::dynamics::DynamicsError;
use crate::scene::AnalysisSpec;

/// Maximum lag behind the playback speed. A run that lags more does not try to catch up.
const MAX_LAG: Duration = Duration::from_millis(150);
/// Wall time over which the playback speed is measured.
const SPEED_WINDOW: Duration = Duration::from_millis(500);

/// Present state of an interactive run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStatus {
    /// Requested playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Measured playback speed, same unit; `None` while paused and before the first measurement.
    pub measured_speed: Option<f64>,
    /// Whether the run is paused.
    pub paused: bool,
    /// End time of the last frame, s of simulated time.
    pub time: f64,
}

/// Sends commands to an interactive run. Can be used from any thread and never blocks.
#[derive(Clone, Debug)]
pub struct RunHandle {
    pending: Arc<Mutex<PendingCommands>>,
    /// Wakes up a waiting run. A run that has ended ignores it.
    wake: Sender<()>,
    status: Arc<Mutex<RunStatus>>,
}

impl RunHandle {
    /// Sends a command, which takes effect before the next frame. Commands sent between two frames are
    /// combined, see [`PendingCommands`].
    ///
    /// # Errors
    /// [`TooManyKicks`].
    pub fn send(&self, command: RunCommand) -> Result<(), TooManyKicks> {
        let waits_for_frame = matches!(command, RunCommand::Set(..) | RunCommand::Kick { .. });
        lock(&self.pending).add(command)?;
        if !waits_for_frame {
            // If the channel is full, a wake-up is already pending.
            let _ = self.wake.try_send(());
        }
        Ok(())
    }

    /// Sets the commands that were sent before the run existed.
    pub fn set_pending(&self, early: PendingCommands) {
        *lock(&self.pending) = early;
        let _ = self.wake.try_send(());
    }

    /// Present state of the run.
    pub fn status(&self) -> RunStatus {
        *lock(&self.status)
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // No holder of the lock leaves the value inconsistent.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A simulation that can be controlled while it runs.
pub struct InteractiveSource {
    source: Box<dyn ControllableSource>,
    rate: f64,
    pending: Arc<Mutex<PendingCommands>>,
    wake: Receiver<()>,
    status: Arc<Mutex<RunStatus>>,
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
    /// Makes a simulation interactive. It starts at the playback speed `speed` (simulated seconds per second).
    pub fn new(mut source: Box<dyn ControllableSource>, speed: f64) -> (Self, RunHandle) {
        source.run_until_stopped();
        let rate = source.header("").sample_rate;
        let (wake, woken) = bounded(1);
        let pending = Arc::<Mutex<PendingCommands>>::default();
        let time = source.time();
        let status = Arc::new(Mutex::new(RunStatus {
            speed,
            measured_speed: None,
            paused: false,
            time,
        }));
        let mut run = Self {
            source,
            rate,
            pending: Arc::clone(&pending),
            wake: woken,
            status: Arc::clone(&status),
            anchor: (Instant::now(), time),
            measured: (Instant::now(), time),
            step: false,
            ended: false,
            done: Vec::new(),
            kicks: Vec::new(),
        };
        run.set_speed(speed);
        let handle = RunHandle {
            pending,
            wake,
            status,
        };
        (run, handle)
    }

    fn set_speed(&mut self, speed: f64) {
        self.restart_clock();
        lock(&self.status).speed = speed;
        let (samples, shown) = DisplayRates::at_speed(speed, self.rate);
        self.source.set_frame_length(samples, shown);
    }

    fn set_paused(&mut self, paused: bool) {
        self.restart_clock();
        lock(&self.status).paused = paused;
    }

    /// Restarts the clock at the present wall time and the simulated time that is due now. Repeated changes
    /// of the speed therefore do not accelerate the run.
    fn restart_clock(&mut self) {
        let now = Instant::now();
        let mut status = lock(&self.status);
        // The speed measured so far no longer applies.
        status.measured_speed = None;
        let (wall, from) = self.anchor;
        let elapsed = match status.paused {
            true => 0.0,
            false => status.speed * (now - wall).as_secs_f64(),
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
        let control = std::mem::take(&mut lock(&self.pending).control);
        let status = *lock(&self.status);
        if let Some(speed) = control.speed.filter(|speed| *speed != status.speed) {
            self.set_speed(speed);
            self.describe(format!("playback speed {} ms/s", format_short(1e3 * speed)));
        }
        if let Some(pause) = control.pause.filter(|pause| *pause != status.paused) {
            self.set_paused(pause);
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
            let mut pending = lock(&self.pending);
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
            self.done.push(match self.source.set(parameter, value) {
                // The run continues as it was.
                Err(PipelineError::Scene(error)) => format!("{change} refused: {error}"),
                Err(PipelineError::Assembly(error)) => format!("{change} refused: {error}"),
                applied => applied.map(|()| change)?,
            });
        }
        if let Some(start) = &start {
            self.source.set_state(&start.values)?;
        }
        for (size, seed) in kicks {
            self.source.kick(size, seed)?;
            let time = self.source.time();
            self.kicks.push(Kick { time, size, seed });
            self.done.push(format!(
                "kick of {} mm/s, seed {seed}",
                format_short(1e3 * size)
            ));
        }
        Ok(())
    }

    /// Waits until the next frame is due, or the run is stopped.
    fn wait(&mut self) {
        loop {
            // All handles are dropped: the run cannot be stopped in any other way.
            self.ended |= self.wake.try_recv() == Err(TryRecvError::Disconnected);
            self.apply_controls();
            let status = *lock(&self.status);
            let due = self.due(status);
            if self.ended || self.step || (!status.paused && Instant::now() >= due) {
                return;
            }
            // The loop checks the reason for the wake-up.
            let _ = match status.paused {
                true => self.wake.recv().ok(),
                false => self.wake.recv_deadline(due).ok(),
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
        let mut status = lock(&self.status);
        status.time = time;
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

    fn analysis(&self) -> &AnalysisSpec {
        self.source.analysis()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        self.wait();
        if self.ended {
            return Ok(None);
        }
        match self.apply_changes() {
            // Stopped while a command was applied.
            Err(PipelineError::Dynamics(DynamicsError::Stopped { .. })) => return Ok(None),
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

/// Formats a number with at most four decimals.
fn format_short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" => "0".to_owned(),
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::*;
    use crate::pipeline::message::Record;
    use crate::pipeline::{Analyser, MAX_KICKS_PER_FRAME, RunState, controllable_source};
    use crate::scene::{Parameter, Scene};

    fn interactive(scene: &str, speed: f64) -> (InteractiveSource, RunHandle) {
        let scene = Scene::load(scene).unwrap().without_analyses();
        InteractiveSource::new(controllable_source(&scene).unwrap(), speed)
    }

    fn next(run: &mut InteractiveSource) -> Frame {
        run.next_frame().unwrap().expect("the run continues")
    }

    /// So fast that no frame waits for wall time.
    const FAST: f64 = 1e3;

    #[test]
    fn a_run_continues_after_its_planned_time() {
        let (mut run, handle) = interactive("periodic-2deg", FAST);
        let planned = run.header("").duration;
        assert!(run.header("").endless);
        let mut end = 0.0;
        while end < 1.2 * planned {
            let frame = next(&mut run);
            assert!((frame.t0 - end).abs() < 1e-12);
            end = frame.end();
        }
        handle.send(RunCommand::End).unwrap();
        assert!(run.next_frame().unwrap().is_none() && run.is_finished());
    }

    #[test]
    fn a_tilt_applies_to_the_next_frame_and_is_an_event() {
        let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
        next(&mut run);
        for degrees in [1.0, 2.0, 4.5_f64] {
            handle
                .send(RunCommand::Set(Parameter::tilt(), degrees))
                .unwrap();
        }
        let frame = next(&mut run);
        assert_eq!(frame.tilt, 4.5_f64.to_radians());
        assert_eq!(frame.events, ["tilt 4.5 deg"], "only the last tilt applies");
        assert_eq!(next(&mut run).events, [""; 0]);
    }

    #[test]
    fn a_run_continues_from_the_state_of_another() {
        for scene in [
            "doubled-torus-3deg",
            "bristles",
            "articulation",
            "impact-oscillator",
            "mass-on-belt",
        ] {
            let (mut first, _kept) = interactive(scene, FAST);
            let before = next(&mut first);
            let state = RunState {
                time_s: before.end() - before.dt,
                values: before.state,
            };
            let (mut second, handle) = interactive(scene, FAST);
            handle.send(RunCommand::Continue(state)).unwrap();
            let velocities = |run: &mut InteractiveSource, count| {
                let mut velocity = Vec::new();
                while velocity.len() < count {
                    velocity.extend(next(run).velocity);
                }
                velocity
            };
            // The second run begins with the sample of the state.
            let expected = velocities(&mut first, 400);
            let found = velocities(&mut second, 401);
            let size = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let expected = before.velocity.last().into_iter().chain(&expected);
            for (a, b) in expected.zip(&found).take(401) {
                assert!((a - b).abs() < 1e-3 * size, "{scene}: {a} {b} of {size}");
            }
        }
    }

    /// Commands that do not act on the load leave the motion bit-identical.
    #[test]
    fn playback_commands_do_not_change_the_motion() {
        let scene = Scene::load("doubled-torus-3deg")
            .unwrap()
            .without_analyses();
        let mut planned = controllable_source(&scene).unwrap();
        let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
        let mut seen = Vec::new();
        for commands in [
            vec![RunCommand::Speed(2.0 * FAST)],
            vec![RunCommand::Pause, RunCommand::Resume],
            vec![RunCommand::Step, RunCommand::Resume],
        ] {
            seen.extend(next(&mut run).velocity);
            for command in commands {
                handle.send(command).unwrap();
            }
        }
        seen.extend(next(&mut run).velocity);
        let mut expected = Vec::new();
        while expected.len() < seen.len() {
            expected.extend(planned.next_frame().unwrap().unwrap().velocity);
        }
        assert_eq!(seen, expected[..seen.len()]);
    }

    #[test]
    fn a_kick_changes_the_velocities_and_is_audited() {
        let (mut run, handle) = interactive("periodic-2deg", 0.01);
        let mut residual = 0.0_f64;
        let mut largest = 0.0_f64;
        for k in 0..20 {
            if k == 10 {
                handle
                    .send(RunCommand::Kick {
                        size: 1e-3,
                        seed: 7,
                    })
                    .unwrap();
            }
            let frame = next(&mut run);
            let of = |rows: &[f64]| rows.iter().map(|v| v * v).sum::<f64>().sqrt();
            let first = of(&frame.qdot[..frame.modes]);
            if k == 10 {
                assert!(first > 1e-3 && first < 1e-2, "{first}");
                assert_eq!(frame.events, ["kick of 1 mm/s, seed 7"]);
                let kick = Kick {
                    time: frame.t0,
                    size: 1e-3,
                    seed: 7,
                };
                assert_eq!(frame.kicks, [kick]);
            } else if k < 10 {
                assert!(first < 3e-4, "{first}");
            }
            for sample in &frame.energy {
                residual = residual.max(sample.residual.abs());
                largest = largest.max(sample.total.abs());
            }
        }
        assert!(residual < 1e-2 * largest, "{residual} of {largest}");
    }

    #[test]
    fn a_paused_run_advances_by_single_frames_only() {
        let (mut run, handle) = interactive("mass-on-belt", FAST);
        let first = next(&mut run);
        for order in [RunCommand::Pause, RunCommand::Step] {
            handle.send(order).unwrap();
        }
        let second = next(&mut run);
        assert_eq!(second.t0, first.end());
        assert_eq!(second.events, ["paused", "single step"]);
        assert!(handle.status().paused);
        let waiting = std::thread::spawn(move || next(&mut run));
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(handle.status().time, second.end());
        handle.send(RunCommand::Resume).unwrap();
        assert_eq!(waiting.join().unwrap().t0, second.end());
    }

    #[test]
    fn frames_follow_the_playback_speed() {
        let speed = 0.02;
        let (mut run, handle) = interactive("mass-on-belt", speed);
        let began = Instant::now();
        let mut end = 0.0;
        while end < 0.6 * speed {
            end = next(&mut run).end();
        }
        // A busy machine may be late, but never early.
        assert!(began.elapsed().as_secs_f64() > 0.5);
        let reached = handle.status().measured_speed.expect("measured");
        assert!(reached < 1.2 * speed, "{reached}");
    }

    #[test]
    fn many_commands_between_two_frames_are_combined() {
        let (mut run, handle) = interactive("periodic-2deg", FAST);
        handle.send(RunCommand::Pause).unwrap();
        let mut refused = 0;
        for seed in 0..100_000 {
            let size = 1e-6;
            refused += usize::from(handle.send(RunCommand::Kick { size, seed }).is_err());
            handle
                .send(RunCommand::Set(Parameter::tilt(), 0.03_f64.to_degrees()))
                .unwrap();
            handle.send(RunCommand::Speed(FAST + seed as f64)).unwrap();
        }
        assert_eq!(refused, 100_000 - MAX_KICKS_PER_FRAME);
        handle.send(RunCommand::Step).unwrap();
        let events = next(&mut run).events;
        let kicks = events.iter().filter(|words| words.starts_with("kick"));
        assert_eq!(kicks.count(), MAX_KICKS_PER_FRAME);
        let others = ["playback speed", "paused", "single step", "tilt"].len();
        assert_eq!(events.len(), MAX_KICKS_PER_FRAME + others, "{events:?}");
        handle
            .send(RunCommand::Kick {
                size: 1e-6,
                seed: 0,
            })
            .expect("the next frame accepts kicks again");
    }

    /// The list of descriptions does not grow while a run is paused.
    #[test]
    fn repeated_commands_are_described_once() {
        let (mut run, _handle) = interactive("mass-on-belt", FAST);
        for k in 0..1000 {
            for pause in [Some(true), Some(false)] {
                let mut pending = lock(&run.pending);
                pending.control.speed = Some(FAST + f64::from(k));
                pending.control.pause = pause;
                drop(pending);
                run.apply_controls();
            }
        }
        assert_eq!(
            run.done,
            ["playback speed 1999000 ms/s", "paused", "resumed"]
        );
    }

    #[test]
    fn repeated_speed_changes_do_not_accelerate_the_run() {
        let speed = 0.02;
        let (mut run, handle) = interactive("mass-on-belt", speed);
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    for speed in [0.9 * speed, speed] {
                        handle.send(RunCommand::Speed(speed)).unwrap();
                    }
                }
            });
            let began = Instant::now();
            while next(&mut run).end() < 0.3 * speed {}
            over.store(true, Ordering::Relaxed);
            assert!(began.elapsed().as_secs_f64() > 0.25);
        });
    }

    #[test]
    fn the_drawn_share_depends_on_the_speed() {
        let (mut run, handle) = interactive("doubled-torus-3deg", 1e-3);
        let slow = next(&mut run).shown.unwrap();
        assert_eq!((slow.every, slow.pictures), (1, 20e3));
        handle.send(RunCommand::Speed(1.0)).unwrap();
        let frame = next(&mut run);
        let fast = frame.shown.unwrap();
        assert_eq!((fast.every, fast.pictures), (10, 20.0));
        assert_eq!(frame.len(), 3333);
    }

    #[test]
    fn events_precede_the_samples_they_change() {
        let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
        handle
            .send(RunCommand::Set(Parameter::tilt(), 0.05_f64.to_degrees()))
            .unwrap();
        let mut records: Vec<Record> = Vec::new();
        let mut analyser = Analyser::new(&AnalysisSpec::default(), &run.header(""));
        analyser
            .push(&Arc::new(next(&mut run)), &mut records)
            .unwrap();
        assert!(
            matches!(&records[0], Record::Event { time: 0.0, text } if text == "tilt 2.86479 deg")
        );
        assert!(matches!(records[1], Record::Samples(_)));
    }

    /// The run continues as it was.
    #[test]
    fn a_number_that_the_scene_does_not_have_is_refused() {
        let (mut run, handle) = interactive("mass-on-belt", FAST);
        handle
            .send(RunCommand::Set(Parameter::tilt(), 3.0))
            .unwrap();
        let frame = next(&mut run);
        assert!(frame.events[0].starts_with("tilt 3 deg refused: "));
        assert!(frame.changed.is_empty());
    }
}
