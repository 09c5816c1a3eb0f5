//! A run that somebody steers: it goes on until it is ended, at a pace, and takes orders meanwhile.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};

use super::PipelineError;
use super::message::{Frame, Header, Shown};
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
/// Orders that may wait; whoever gives more waits.
const WAITING: usize = 256;

/// What a steered run can be told.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Tilt the load, rad; see [`Steerable::tilt`].
    Tilt(f64),
    /// Add a random velocity to each mode; see [`Steerable::kick`].
    Kick {
        /// Standard deviation, sqrt(kg) m/s.
        size: f64,
        /// Of the random numbers.
        seed: u64,
    },
    /// Stop the simulated time.
    Pause,
    /// Let it go on.
    Resume,
    /// Make one frame, and stop.
    Step,
    /// Go at a pace from now on: simulated seconds a second, above 0.
    Pace(f64),
    /// End the run.
    End,
}

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

/// Gives orders to a steered run, from any thread.
#[derive(Clone, Debug)]
pub struct Helm {
    orders: Sender<Order>,
    gait: Arc<Mutex<Gait>>,
}

/// The run that was to be steered is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the run is over")]
pub struct RunOver;

impl Helm {
    /// Gives an order; it is carried out before the next frame is begun.
    ///
    /// # Errors
    /// [`RunOver`].
    pub fn order(&self, order: Order) -> Result<(), RunOver> {
        self.orders.send(order).map_err(|_| RunOver)
    }

    /// What the run is doing now.
    pub fn gait(&self) -> Gait {
        *lock(&self.gait)
    }
}

fn lock(gait: &Mutex<Gait>) -> MutexGuard<'_, Gait> {
    // Nothing that holds it can leave it half written.
    gait.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A source at the helm of somebody.
pub struct Steered {
    source: Box<dyn Steerable>,
    rate: f64,
    orders: Receiver<Order>,
    gait: Arc<Mutex<Gait>>,
    /// A wall time and the simulated time (s) that belongs to it at the present pace.
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
        let (orders, to_obey) = bounded(WAITING);
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
            orders: to_obey,
            gait: Arc::clone(&gait),
            anchor: (Instant::now(), time),
            measured: (Instant::now(), time),
            step: false,
            ended: false,
            done: Vec::new(),
        };
        steered.set_pace(pace);
        (steered, Helm { orders, gait })
    }

    fn set_pace(&mut self, pace: f64) {
        let mut gait = lock(&self.gait);
        gait.pace = pace;
        // What was reached at another pace says nothing.
        gait.reached = None;
        drop(gait);
        let samples = (pace * self.rate / FRAMES).round();
        let shown = Shown {
            pictures: (PICTURES / pace).min(self.rate),
            every: (pace * self.rate / ROWS).round().max(1.0) as usize,
            apart: (pace * self.rate / LOOKS).round() as u64,
        };
        self.source
            .cut(samples.clamp(1.0, LONGEST_FRAME) as usize, shown);
        self.begin_anew();
    }

    /// Counts wall time from now on.
    fn begin_anew(&mut self) {
        self.anchor = (Instant::now(), self.source.time());
        self.measured = self.anchor;
    }

    fn set_paused(&mut self, paused: bool) {
        let mut gait = lock(&self.gait);
        gait.paused = paused;
        gait.reached = None;
        drop(gait);
        self.begin_anew();
    }

    fn obey(&mut self, order: Order) -> Result<(), PipelineError> {
        let gait = *lock(&self.gait);
        match order {
            Order::Tilt(tilt) => {
                self.source.tilt(tilt)?;
                // Of a slider that is being dragged only the last place counts.
                self.done.retain(|words| !words.starts_with("tilt"));
                self.done
                    .push(format!("tilt {} degrees", short(tilt.to_degrees())));
            }
            Order::Kick { size, seed } => {
                self.source.kick(size, seed)?;
                self.done
                    .push(format!("kick of {} mm/s, seed {seed}", short(1e3 * size)));
            }
            Order::Pause if !gait.paused => {
                self.set_paused(true);
                self.done.push("paused".to_owned());
            }
            Order::Resume if gait.paused => {
                self.set_paused(false);
                self.done.push("goes on".to_owned());
            }
            Order::Pause | Order::Resume => {}
            Order::Step => {
                if !gait.paused {
                    self.set_paused(true);
                }
                self.step = true;
                self.done.push("single step".to_owned());
            }
            Order::Pace(pace) => {
                self.set_pace(pace);
                self.done
                    .push(format!("pace {} ms a second", short(1e3 * pace)));
            }
            Order::End => self.ended = true,
        }
        Ok(())
    }

    /// Carries out orders until the next frame is due.
    fn wait(&mut self) -> Result<(), PipelineError> {
        loop {
            let gait = *lock(&self.gait);
            let order = match gait.paused && !self.step {
                true => self
                    .orders
                    .recv()
                    .map_err(|_| RecvTimeoutError::Disconnected),
                false => self.orders.recv_deadline(self.due(gait)),
            };
            match order {
                Ok(order) => self.obey(order)?,
                Err(RecvTimeoutError::Timeout) => return Ok(()),
                // Nobody is left who could end it.
                Err(RecvTimeoutError::Disconnected) => self.ended = true,
            }
            if self.ended {
                return Ok(());
            }
        }
    }

    /// When the next frame is to be begun.
    fn due(&self, gait: Gait) -> Instant {
        let (wall, time) = self.anchor;
        match self.step {
            true => wall,
            false => wall + Duration::from_secs_f64((self.source.time() - time) / gait.pace),
        }
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
        match self.wait() {
            // Told to stop while an order was carried out.
            Err(PipelineError::Dynamics(DynamicsError::Stopped { .. })) => return Ok(None),
            waited => waited?,
        }
        if self.ended {
            return Ok(None);
        }
        self.step = false;
        let Some(mut frame) = self.source.next_frame()? else {
            return Ok(None);
        };
        frame.events = std::mem::take(&mut self.done);
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
    use super::*;
    use crate::pipeline::message::Record;
    use crate::pipeline::{Analyser, steerable};
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
