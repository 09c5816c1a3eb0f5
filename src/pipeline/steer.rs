//! A run that somebody steers: it goes on until it is ended, at a pace, and takes orders meanwhile.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded};

use super::PipelineError;
use super::message::{Frame, Header, Shown};
use super::pending::{Order, Pending, TooManyKicks};
use super::source::{Source, Steerable};
use crate::dynamics::DynamicsError;
use crate::scene::AnalysisSpec;

/// Frames a second of wall time. An order is carried out at the next frame's border.
const FRAMES: f64 = 60.0;
/// Pictures of body and patch a second of wall time: what a screen shows.
const PICTURES: f64 = 20.0;
/// Rows of series a second of wall time, about: what a viewer takes in with ease.
const ROWS: f64 = 20e3;
/// Windows that an analysis looks at in a second of wall time, at most: a few more than are shown of it.
const LOOKS: f64 = 8.0;
/// Samples of a frame, at most.
const LONGEST_FRAME: f64 = 8192.0;
/// How far behind its pace a run may fall before it gives up catching up.
const BEHIND: Duration = Duration::from_millis(150);
/// Wall time over which the pace that is reached is told.
const MEASURED_OVER: Duration = Duration::from_millis(500);

/// What a steered run is doing now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gait {
    /// The pace that is asked for: simulated seconds a second.
    pub pace: f64,
    /// The pace that is reached; `None` before it is known, and while the time stands still.
    pub reached: Option<f64>,
    /// Whether the time stands still.
    pub paused: bool,
    /// Simulated time up to which there are frames, s.
    pub time: f64,
}

/// Gives orders to a steered run, from any thread, and never waits.
#[derive(Clone, Debug)]
pub struct Helm {
    pending: Arc<Mutex<Pending>>,
    /// Wakes a run that waits. One that is over needs no order.
    wake: Sender<()>,
    gait: Arc<Mutex<Gait>>,
}

impl Helm {
    /// Gives an order; it is carried out before the next frame is begun. Orders given between two frames are
    /// combined, see [`Pending`].
    ///
    /// # Errors
    /// [`TooManyKicks`].
    pub fn order(&self, order: Order) -> Result<(), TooManyKicks> {
        let waits_for_frame = matches!(order, Order::Tilt(_) | Order::Kick { .. });
        lock(&self.pending).add(order)?;
        if !waits_for_frame {
            // If it is full, the run is about to look anyway.
            let _ = self.wake.try_send(());
        }
        Ok(())
    }

    /// Gives the orders that came before there was a run.
    pub fn begin_with(&self, early: Pending) {
        *lock(&self.pending) = early;
        let _ = self.wake.try_send(());
    }

    /// What the run is doing now.
    pub fn gait(&self) -> Gait {
        *lock(&self.gait)
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // Nothing that holds it can leave it half written.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A source at the helm of somebody.
pub struct Steered {
    source: Box<dyn Steerable>,
    rate: f64,
    pending: Arc<Mutex<Pending>>,
    wake: Receiver<()>,
    gait: Arc<Mutex<Gait>>,
    /// A wall time and the simulated time (s) that belongs to it; from there on it goes at the present pace.
    anchor: (Instant, f64),
    /// Where the measuring of the pace began.
    measured: (Instant, f64),
    /// One frame is to be made although the time stands still.
    step: bool,
    ended: bool,
    /// What has been done since the last frame.
    done: Vec<String>,
}

impl Steered {
    /// Puts somebody at the helm of a source, which begins at a pace (simulated seconds a second) and may be
    /// told tilts (rad) within `reach`.
    pub fn new(mut source: Box<dyn Steerable>, pace: f64, reach: [f64; 2]) -> (Self, Helm) {
        source.go_on(reach);
        let rate = source.header("").sample_rate;
        let (wake, woken) = bounded(1);
        let pending = Arc::<Mutex<Pending>>::default();
        let time = source.time();
        let gait = Arc::new(Mutex::new(Gait {
            pace,
            reached: None,
            paused: false,
            time,
        }));
        let mut steered = Self {
            source,
            rate,
            pending: Arc::clone(&pending),
            wake: woken,
            gait: Arc::clone(&gait),
            anchor: (Instant::now(), time),
            measured: (Instant::now(), time),
            step: false,
            ended: false,
            done: Vec::new(),
        };
        steered.set_pace(pace);
        let helm = Helm {
            pending,
            wake,
            gait,
        };
        (steered, helm)
    }

    fn set_pace(&mut self, pace: f64) {
        self.begin_anew();
        lock(&self.gait).pace = pace;
        let samples = (pace * self.rate / FRAMES).round();
        let shown = Shown {
            pictures: (PICTURES / pace).min(self.rate),
            every: (pace * self.rate / ROWS).round().max(1.0) as usize,
            apart: (pace * self.rate / LOOKS).round() as u64,
        };
        self.source
            .cut(samples.clamp(1.0, LONGEST_FRAME) as usize, shown);
    }

    fn set_paused(&mut self, paused: bool) {
        self.begin_anew();
        lock(&self.gait).paused = paused;
    }

    /// Counts wall time from now on, from the simulated time that is due now: whoever changes the pace all the
    /// time does not change how fast it goes.
    fn begin_anew(&mut self) {
        let now = Instant::now();
        let mut gait = lock(&self.gait);
        // What was reached until now says nothing.
        gait.reached = None;
        let (wall, from) = self.anchor;
        let gone = match gait.paused {
            true => 0.0,
            false => gait.pace * (now - wall).as_secs_f64(),
        };
        let time = self.source.time();
        self.anchor = (now, time.min(from + gone));
        self.measured = (now, time);
    }

    /// Takes note of what was done; of things of a kind, told by the first word, only the last counts.
    fn note(&mut self, words: String) {
        let kind = words.split(' ').next();
        self.done.retain(|known| known.split(' ').next() != kind);
        self.done.push(words);
    }

    /// Obeys what need not wait for a frame.
    fn take_control(&mut self) {
        let control = std::mem::take(&mut lock(&self.pending).control);
        let gait = *lock(&self.gait);
        if let Some(pace) = control.pace.filter(|pace| *pace != gait.pace) {
            self.set_pace(pace);
            self.note(format!("pace {} ms a second", short(1e3 * pace)));
        }
        if let Some(pause) = control.pause.filter(|pause| *pause != gait.paused) {
            self.set_paused(pause);
            self.note(if pause { "paused" } else { "goes on" }.to_owned());
        }
        if control.step {
            self.step = true;
            self.note("single step".to_owned());
        }
        self.ended |= control.end;
    }

    /// Takes the tilt and the kicks that the next frame begins with.
    fn take_changes(&mut self) -> Result<(), PipelineError> {
        let (tilt, kicks) = {
            let mut pending = lock(&self.pending);
            (pending.tilt.take(), std::mem::take(&mut pending.kicks))
        };
        if let Some(tilt) = tilt {
            self.source.tilt(tilt)?;
            self.note(format!("tilt {} degrees", short(tilt.to_degrees())));
        }
        for (size, seed) in kicks {
            self.source.kick(size, seed)?;
            self.done
                .push(format!("kick of {} mm/s, seed {seed}", short(1e3 * size)));
        }
        Ok(())
    }

    /// Waits until the next frame is due, or the run is ended.
    fn wait(&mut self) {
        loop {
            // Nobody is left who could end it.
            self.ended |= self.wake.try_recv() == Err(TryRecvError::Disconnected);
            self.take_control();
            let gait = *lock(&self.gait);
            let due = self.due(gait);
            if self.ended || self.step || (!gait.paused && Instant::now() >= due) {
                return;
            }
            // Whatever ends the waiting is looked at above.
            let _ = match gait.paused {
                true => self.wake.recv().ok(),
                false => self.wake.recv_deadline(due).ok(),
            };
        }
    }

    /// When the next frame is to be begun.
    fn due(&self, gait: Gait) -> Instant {
        let (wall, time) = self.anchor;
        wall + Duration::from_secs_f64((self.source.time() - time) / gait.pace)
    }

    /// Tells how fast it goes, now that there is a frame more.
    fn measure(&mut self) {
        let now = Instant::now();
        let time = self.source.time();
        let mut gait = lock(&self.gait);
        gait.time = time;
        let (since, from) = self.measured;
        let wall = now - since;
        if !gait.paused && wall >= MEASURED_OVER {
            gait.reached = Some((time - from) / wall.as_secs_f64());
            self.measured = (now, time);
        }
        let (wall, from) = self.anchor;
        if now > wall + Duration::from_secs_f64((time - from) / gait.pace) + BEHIND {
            self.anchor = (now, time);
        }
    }
}

impl Source for Steered {
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
        match self.take_changes() {
            // Told to stop while an order was carried out.
            Err(PipelineError::Dynamics(DynamicsError::Stopped { .. })) => return Ok(None),
            taken => taken?,
        }
        let Some(mut frame) = self.source.next_frame()? else {
            return Ok(None);
        };
        frame.events = std::mem::take(&mut self.done);
        if std::mem::take(&mut self.step) {
            // What it stepped over need not be waited for.
            self.anchor = (Instant::now(), self.source.time());
        }
        self.measure();
        Ok(Some(frame))
    }

    fn is_over(&self) -> bool {
        self.ended
    }

    fn heed(&mut self, stop: &Arc<AtomicBool>) {
        self.source.heed(stop);
    }
}

/// A number in a few digits.
fn short(x: f64) -> String {
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
    use crate::pipeline::{Analyser, KICKS_A_FRAME, steerable};
    use crate::scene::Scene;

    const REACH: [f64; 2] = [0.0, 0.15];

    fn steered(scene: &str, pace: f64) -> (Steered, Helm) {
        let scene = Scene::load(scene).unwrap().without_analyses();
        Steered::new(steerable(&scene).unwrap(), pace, REACH)
    }

    fn next(steered: &mut Steered) -> Frame {
        steered.next_frame().unwrap().expect("it goes on")
    }

    /// So fast that no frame waits for wall time.
    const HURRY: f64 = 1e3;

    #[test]
    fn a_run_goes_on_after_its_planned_time() {
        let (mut run, helm) = steered("periodic-2deg", HURRY);
        let planned = run.header("").duration;
        assert!(run.header("").endless);
        let mut end = 0.0;
        while end < 1.2 * planned {
            let frame = next(&mut run);
            assert!((frame.t0 - end).abs() < 1e-12);
            end = frame.end();
        }
        helm.order(Order::End).unwrap();
        assert!(run.next_frame().unwrap().is_none() && run.is_over());
    }

    #[test]
    fn a_tilt_is_that_of_the_next_frame_and_an_event() {
        let (mut run, helm) = steered("torus-3deg", HURRY);
        next(&mut run);
        for degrees in [1.0, 2.0, 4.5_f64] {
            helm.order(Order::Tilt(degrees.to_radians())).unwrap();
        }
        let frame = next(&mut run);
        assert_eq!(frame.tilt, 4.5_f64.to_radians());
        assert_eq!(
            frame.events,
            ["tilt 4.5 degrees"],
            "only the last place counts"
        );
        assert_eq!(next(&mut run).events, [""; 0]);
    }

    /// A run that is steered as its scene plans is the scene's run, to the last bit.
    #[test]
    fn orders_do_not_disturb_what_they_do_not_concern() {
        let scene = Scene::load("torus-3deg").unwrap().without_analyses();
        let mut planned = steerable(&scene).unwrap();
        let (mut run, helm) = steered("torus-3deg", HURRY);
        let mut seen = Vec::new();
        for orders in [
            vec![Order::Pace(2.0 * HURRY)],
            vec![Order::Pause, Order::Resume],
            vec![Order::Step, Order::Resume],
        ] {
            seen.extend(next(&mut run).velocity);
            for order in orders {
                helm.order(order).unwrap();
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
    fn a_kick_is_one_of_the_velocities_and_audited() {
        let (mut run, helm) = steered("periodic-2deg", 0.01);
        let mut residual = 0.0_f64;
        let mut largest = 0.0_f64;
        for k in 0..20 {
            if k == 10 {
                helm.order(Order::Kick {
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
    fn time_stands_still_while_paused_and_steps_one_frame() {
        let (mut run, helm) = steered("mass-on-belt", HURRY);
        let first = next(&mut run);
        for order in [Order::Pause, Order::Step] {
            helm.order(order).unwrap();
        }
        let second = next(&mut run);
        assert_eq!(second.t0, first.end());
        assert_eq!(second.events, ["paused", "single step"]);
        assert!(helm.gait().paused);
        let waiting = std::thread::spawn(move || next(&mut run));
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(helm.gait().time, second.end());
        helm.order(Order::Resume).unwrap();
        assert_eq!(waiting.join().unwrap().t0, second.end());
    }

    #[test]
    fn frames_keep_the_pace() {
        let pace = 0.02;
        let (mut run, helm) = steered("mass-on-belt", pace);
        let began = Instant::now();
        let mut end = 0.0;
        while end < 0.6 * pace {
            end = next(&mut run).end();
        }
        // A busy machine may be late, but nothing makes it early.
        assert!(began.elapsed().as_secs_f64() > 0.5);
        let reached = helm.gait().reached.expect("measured");
        assert!(reached < 1.2 * pace, "{reached}");
    }

    #[test]
    fn a_flood_of_orders_is_what_a_frame_takes() {
        let (mut run, helm) = steered("periodic-2deg", HURRY);
        helm.order(Order::Pause).unwrap();
        let mut refused = 0;
        for seed in 0..100_000 {
            let size = 1e-6;
            refused += usize::from(helm.order(Order::Kick { size, seed }).is_err());
            helm.order(Order::Tilt(0.03)).unwrap();
            helm.order(Order::Pace(HURRY + seed as f64)).unwrap();
        }
        assert_eq!(refused, 100_000 - KICKS_A_FRAME);
        helm.order(Order::Step).unwrap();
        let events = next(&mut run).events;
        let kicks = events.iter().filter(|words| words.starts_with("kick"));
        assert_eq!(kicks.count(), KICKS_A_FRAME);
        let others = ["pace", "paused", "single step", "tilt"].len();
        assert_eq!(events.len(), KICKS_A_FRAME + others, "{events:?}");
        helm.order(Order::Kick {
            size: 1e-6,
            seed: 0,
        })
        .expect("the next frame takes more");
    }

    /// A run that stands still keeps no list of all that is changed meanwhile.
    #[test]
    fn what_was_done_is_noted_once() {
        let (mut run, _helm) = steered("mass-on-belt", HURRY);
        for k in 0..1000 {
            for pause in [Some(true), Some(false)] {
                let mut pending = lock(&run.pending);
                pending.control.pace = Some(HURRY + f64::from(k));
                pending.control.pause = pause;
                drop(pending);
                run.take_control();
            }
        }
        assert_eq!(run.done, ["pace 1999000 ms a second", "paused", "goes on"]);
    }

    #[test]
    fn who_changes_the_pace_all_the_time_does_not_hurry_the_run() {
        let pace = 0.02;
        let (mut run, helm) = steered("mass-on-belt", pace);
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    for pace in [0.9 * pace, pace] {
                        helm.order(Order::Pace(pace)).unwrap();
                    }
                }
            });
            let began = Instant::now();
            while next(&mut run).end() < 0.3 * pace {}
            over.store(true, Ordering::Relaxed);
            assert!(began.elapsed().as_secs_f64() > 0.25);
        });
    }

    #[test]
    fn what_is_drawn_follows_the_pace() {
        let (mut run, helm) = steered("torus-3deg", 1e-3);
        let slow = next(&mut run).shown.unwrap();
        assert_eq!((slow.every, slow.pictures), (1, 20e3));
        helm.order(Order::Pace(1.0)).unwrap();
        let frame = next(&mut run);
        let fast = frame.shown.unwrap();
        assert_eq!((fast.every, fast.pictures), (10, 20.0));
        assert_eq!(frame.len(), 3333);
    }

    #[test]
    fn events_come_before_the_samples_they_change() {
        let (mut run, helm) = steered("torus-3deg", HURRY);
        helm.order(Order::Tilt(0.05)).unwrap();
        let mut records: Vec<Record> = Vec::new();
        let mut analyser = Analyser::new(&AnalysisSpec::default(), &run.header(""));
        analyser
            .push(&Arc::new(next(&mut run)), &mut records)
            .unwrap();
        assert!(
            matches!(&records[0], Record::Event { time: 0.0, text } if text == "tilt 2.8648 degrees")
        );
        assert!(matches!(records[1], Record::Samples(_)));
    }

    #[test]
    fn a_small_system_has_no_tilt() {
        let (mut run, helm) = steered("mass-on-belt", HURRY);
        helm.order(Order::Tilt(0.05)).unwrap();
        assert!(run.next_frame().is_err());
    }
}
