//! A session: one run after another, and what may be asked of it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::command::{Command, KICK, KICKS, PACES, Refused, within};
use super::ear::Ear;
use super::hub::Hub;
use super::panel::{Board, Panel, Scribe};
use super::recorder::{Recorder, SavedFile, Switch};
use super::screen::Screen;
use crate::escape;
use crate::pipeline::message::Summary;
use crate::pipeline::{
    Gait, Helm, Monitor, Order, Pending, PipelineError, Sink, SinkError, Source as _, Steered, Tee,
    drive, steerable,
};
use crate::record::{Output, RerunSink};
use crate::scene::{PRESETS, Scene};
use crate::sound::{Source, WavSink};

/// The tilts that may be asked for, degrees, if the scene itself does not go beyond; fewer where the patch does
/// not stay on the ball.
const REACH: [f64; 2] = [0.0, 10.0];
/// Who watches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Watcher {
    /// Those that come to the page.
    Page,
    /// A viewer of its own.
    Viewer(Output),
}

/// How a session is to go.
#[derive(Debug)]
pub struct Plan {
    /// The first scene.
    pub scene: Scene,
    /// How the program was started.
    pub command: String,
    /// Pace at the start, simulated seconds a second.
    pub pace: f64,
    /// Whether neighbours are followed at the start, see [`Command::Neighbours`].
    pub neighbours: bool,
    /// Who watches.
    pub watcher: Watcher,
    /// Where recordings go that are asked for on the way.
    pub folder: PathBuf,
    /// A file to record into from the start.
    pub save: Option<PathBuf>,
    /// A file for the sound of the first run.
    pub wav: Option<PathBuf>,
    /// What of the motion is heard.
    pub source: Source,
}

/// A session, shared by all who steer it.
pub struct Session {
    first: Scene,
    command: String,
    watcher: Watcher,
    source: Source,
    /// What goes to the page's viewers.
    pub hub: Arc<Hub>,
    /// What goes to the page's listeners.
    pub ear: Arc<Ear>,
    board: Arc<Board>,
    switch: Arc<Switch>,
    current: Mutex<Current>,
    kicks: AtomicU64,
    /// Ends a run in the middle of a frame.
    stop: Arc<AtomicBool>,
}

struct Current {
    scene: Scene,
    pace: f64,
    neighbours: bool,
    /// While a run goes on.
    helm: Option<Helm>,
    /// Degrees; `None` of what has no tilt.
    reach: Option<[f64; 2]>,
    /// What was asked for before there was a run.
    early: Pending,
    /// What comes after this run, if it is to end.
    next: Option<Scene>,
    over: bool,
    wav: Option<PathBuf>,
}

impl Session {
    /// A session that has not begun.
    pub fn new(plan: Plan) -> Self {
        Self {
            hub: Arc::default(),
            ear: Arc::new(Ear::new(plan.source)),
            board: Arc::default(),
            switch: Arc::new(Switch::new(plan.folder, plan.save)),
            current: Mutex::new(Current {
                scene: plan.scene.clone(),
                pace: plan.pace,
                neighbours: plan.neighbours,
                helm: None,
                reach: reach(&plan.scene),
                early: Pending::default(),
                next: None,
                over: false,
                wav: plan.wav,
            }),
            first: plan.scene,
            command: plan.command,
            watcher: plan.watcher,
            source: plan.source,
            kicks: AtomicU64::new(0),
            stop: Arc::default(),
        }
    }

    /// Runs one scene after another until the session is ended; `notice` is told of a viewer that goes.
    ///
    /// # Errors
    /// The first fault of a run.
    pub fn run(
        &self,
        notice: &Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Option<Summary>, PipelineError> {
        let mut output = match &self.watcher {
            Watcher::Page => None,
            Watcher::Viewer(output) => Some(output.clone()),
        };
        let mut last = None;
        loop {
            let (scene, pace, wav, neighbours) = {
                let mut current = self.current();
                if current.over {
                    return Ok(last);
                }
                if let Some(next) = current.next.take() {
                    current.reach = reach(&next);
                    current.scene = next;
                }
                let followed = current.scene.follows_neighbours();
                let neighbours = followed.then_some(current.neighbours);
                let scene = match neighbours {
                    Some(false) => current.scene.clone().without_neighbours(),
                    Some(true) | None => current.scene.clone(),
                };
                (scene, current.pace, current.wav.take(), neighbours)
            };
            let reach_deg = self.current().reach;
            let reach = reach_deg.unwrap_or_default().map(f64::to_radians);
            let (run, helm) = Steered::new(steerable(&scene)?, pace, reach);
            self.board.begin(reach_deg, neighbours);
            self.board.tell(0.0, format!("{} begins", scene.name));
            let mut sinks = self.watched(&scene, &helm, output.as_mut(), notice)?;
            let (switch, board) = (Arc::clone(&self.switch), Arc::clone(&self.board));
            sinks.push(Box::new(Recorder::new(switch, board, scene.record)));
            if let Some(wav) = wav.clone() {
                let header = run.header(&self.command);
                let heard = WavSink::new(wav, self.source, &header, 1.0);
                sinks.push(Box::new(heard.map_err(sink)?));
            }
            // Last: what the panel tells is then in every file.
            sinks.push(Box::new(Scribe(Arc::clone(&self.board))));
            {
                let mut current = self.current();
                // What was asked for meanwhile is not lost.
                helm.begin_with(std::mem::take(&mut current.early));
                if current.next.is_some() || current.over {
                    end(&helm);
                }
                current.helm = Some(helm);
            }
            let mut tee = Tee::new(sinks);
            let monitor = Monitor {
                stop: &self.stop,
                ..Monitor::default()
            };
            let ran = drive(run, &self.command, &mut tee, monitor);
            self.current().helm = None;
            if let Some(wav) = wav {
                let outcome = ran.as_ref().map(|_| ());
                let outcome =
                    outcome.map_err(|_| "the run failed, so that there is nothing".into());
                self.switch.note(wav, outcome);
            }
            last = Some(ran?);
        }
    }

    /// What shows a run to those who watch: the page, or the viewer that one output is.
    fn watched(
        &self,
        scene: &Scene,
        helm: &Helm,
        output: Option<&mut Output>,
        notice: &Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Vec<Box<dyn Sink>>, PipelineError> {
        let Some(output) = output else {
            self.hub.begin();
            let audience = Arc::clone(&self.hub) as _;
            let viewer = RerunSink::for_audience(audience, scene.record).map_err(sink)?;
            self.ear.follow(helm.clone());
            let tap = self.ear.tap();
            return Ok(vec![Box::new(Screen::new(viewer)), Box::new(tap)]);
        };
        let notice = Arc::clone(notice);
        let viewer = RerunSink::new(output, scene.record).map_err(sink)?;
        let viewer = viewer.with_notice(move |words| notice(words));
        // One viewer is enough for the whole session.
        if output.spawn {
            *output = Output {
                connect: Some("rerun+http://127.0.0.1:9876/proxy".to_owned()),
                ..Output::default()
            };
        }
        Ok(vec![Box::new(Screen::new(viewer))])
    }

    /// Ends the session.
    pub fn end(&self) {
        let mut current = self.current();
        current.over = true;
        self.stop.store(true, Ordering::Relaxed);
        if let Some(helm) = &current.helm {
            end(helm);
        }
    }

    /// What has become of the files that were asked for, once the session has ended.
    pub fn saved(&self) -> Vec<SavedFile> {
        let mut saved = self.switch.take_saved();
        let wav = self.current().wav.take();
        saved.extend(wav.map(SavedFile::never_begun));
        saved
    }

    /// Tells everybody something.
    pub fn tell(&self, words: &str) {
        self.board.tell(self.time(), words);
    }

    /// What is known now.
    pub fn panel(&self) -> Panel {
        self.board.read(self.gait(), self.hub.watching())
    }

    /// Simulated time of the run, s; 0 between two runs.
    pub fn time(&self) -> f64 {
        self.gait().map_or(0.0, |gait| gait.time)
    }

    /// What the run is doing, if there is one.
    pub fn gait(&self) -> Option<Gait> {
        self.current().helm.as_ref().map(Helm::gait)
    }

    /// The scenes that may be asked for: name and title.
    pub fn scenes(&self) -> Vec<[String; 2]> {
        let mut scenes: Vec<[String; 2]> = Vec::new();
        if PRESETS.iter().all(|preset| preset.name != self.first.name) {
            let title = escape::line(&self.first.title).into_owned();
            scenes.push([self.first.name.clone(), title]);
        }
        scenes.extend(PRESETS.iter().map(|preset| {
            let title = preset.scene().map(|scene| scene.title);
            [preset.name.to_owned(), title.unwrap_or_default()]
        }));
        scenes
    }

    /// The scene that runs.
    pub fn scene(&self) -> Scene {
        self.current().scene.clone()
    }

    /// Carries out a command; what it does can be seen from the next frame on.
    ///
    /// # Errors
    /// [`Refused`], and nothing has changed.
    pub fn obey(&self, command: &Command) -> Result<(), Refused> {
        let mut current = self.current();
        let order = match command {
            Command::Tilt { deg } => Order::Tilt(self.tilt(&current, *deg)?),
            Command::Pause {} => Order::Pause,
            Command::Resume {} => Order::Resume,
            Command::Step {} => Order::Step,
            Command::Pace { ms_per_s } => {
                let pace = 1e-3 * within("the pace", *ms_per_s, PACES, "ms a second")?;
                current.pace = pace;
                Order::Pace(pace)
            }
            Command::Kick { mm_per_s } => {
                let size = mm_per_s.unwrap_or(KICK);
                let size = 1e-3 * within("a kick", size, KICKS, "mm/s")?;
                // Another direction each time; the first is not that of the start.
                let kicks = self.kicks.fetch_add(1, Ordering::Relaxed) + 1;
                let seed = current.scene.start.seed.wrapping_add(kicks);
                Order::Kick { size, seed }
            }
            Command::Reset {} => {
                current.next = Some(current.scene.clone());
                Order::End
            }
            Command::Neighbours { follow } => {
                let has_them = current.scene.follows_neighbours();
                if std::mem::replace(&mut current.neighbours, *follow) == *follow || !has_them {
                    return Ok(());
                }
                current.next = Some(current.scene.clone());
                Order::End
            }
            Command::Scene { name } => {
                current.next = Some(self.named(name)?);
                Order::End
            }
            Command::Record {} => {
                let begun = self.switch.on();
                begun.map_err(|fault| Refused(fault.to_string()))?;
                return Ok(());
            }
            Command::StopRecording {} => {
                self.switch.off();
                return Ok(());
            }
        };
        if order == Order::End {
            // What is asked for from now on is for the run that comes.
            if let Some(helm) = current.helm.take() {
                end(&helm);
            }
            return Ok(());
        }
        match &current.helm {
            Some(helm) => helm.order(order)?,
            // The run that is being made ready takes it.
            None => current.early.add(order)?,
        }
        Ok(())
    }

    /// The tilt asked for, rad, if it may be.
    fn tilt(&self, current: &Current, deg: f64) -> Result<f64, Refused> {
        if current.next.is_some() {
            return Err(Refused("another run is about to begin".to_owned()));
        }
        let Some(reach) = current.reach else {
            let scene = &current.scene.name;
            return Err(Refused(format!("the scene `{scene}` has nothing to tilt")));
        };
        let deg = within("the tilt", deg, reach, "degrees")?;
        let tilted = current.scene.clone().with_tilt(deg);
        tilted.map_err(|fault| Refused(fault.to_string()))?;
        Ok(deg.to_radians())
    }

    fn named(&self, name: &str) -> Result<Scene, Refused> {
        if name == self.first.name {
            return Ok(self.first.clone());
        }
        let preset = crate::scene::preset(name).ok_or_else(|| {
            let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            Refused(format!("no scene `{name}`; there are {}", known.join(", ")))
        })?;
        preset.scene().map_err(|fault| Refused(fault.to_string()))
    }

    fn current(&self) -> MutexGuard<'_, Current> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends a run.
fn end(helm: &Helm) {
    // An end is never one too many.
    let _ = helm.order(Order::End);
}

fn sink(fault: impl Into<SinkError>) -> PipelineError {
    PipelineError::Sink(fault.into())
}

/// The tilts that may be asked for, degrees: those of the scene and [`REACH`], as far as the patch stays on the
/// ball.
fn reach(scene: &Scene) -> Option<[f64; 2]> {
    let tilt = &scene.joint().ok()?.tilt;
    let own = [tilt.min(), tilt.max()].map(f64::to_degrees);
    let fits = |deg: f64| scene.clone().with_tilt(deg).is_ok();
    // In half degrees from what the scene has by itself, which fits.
    let reach_to = |own: f64, end: f64| {
        let steps = ((end - own).abs() / 0.5).ceil() as u32;
        let at = |k: u32| match k == steps {
            true => end,
            false => own + 0.5 * f64::from(k) * (end - own).signum(),
        };
        (0..=steps)
            .map(at)
            .take_while(|deg| fits(*deg))
            .last()
            .unwrap_or(own)
    };
    Some([
        reach_to(own[0], own[0].min(REACH[0])),
        reach_to(own[1], own[1].max(REACH[1])),
    ])
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    fn session(scene: &str) -> Arc<Session> {
        let plan = Plan {
            scene: Scene::load(scene).unwrap(),
            command: "squeakscope live".to_owned(),
            pace: 0.02,
            neighbours: true,
            watcher: Watcher::Page,
            folder: std::env::temp_dir(),
            save: None,
            wav: None,
            source: Source::default(),
        };
        Arc::new(Session::new(plan))
    }

    /// A session that goes on while `steer` does its work.
    fn steered(scene: &str, steer: impl FnOnce(&Session)) {
        let session = session(scene);
        let runner = {
            let session = Arc::clone(&session);
            std::thread::spawn(move || {
                let notice: Arc<dyn Fn(&str) + Send + Sync> = Arc::new(|_| ());
                session.run(&notice).map(|_| ())
            })
        };
        until(&session, |panel| panel.time_s > 0.0);
        steer(&session);
        session.end();
        runner.join().unwrap().unwrap();
    }

    fn until(session: &Session, holds: impl Fn(&Panel) -> bool) -> Panel {
        let began = Instant::now();
        loop {
            let panel = session.panel();
            if holds(&panel) {
                return panel;
            }
            assert!(began.elapsed() < Duration::from_secs(30), "{panel:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn what_is_asked_for_is_seen() {
        steered("torus-3deg", |session| {
            let obey = |command| session.obey(&command).unwrap();
            obey(Command::Tilt { deg: 4.25 });
            let panel = until(session, |panel| panel.tilt_deg == Some(4.25));
            assert!(panel.events.iter().any(|e| e.text == "tilt 4.25 degrees"));
            obey(Command::Pause {});
            let at = until(session, |panel| panel.paused);
            obey(Command::Step {});
            until(session, |panel| panel.time_s > at.time_s && panel.paused);
            obey(Command::Pace { ms_per_s: 5.0 });
            obey(Command::Resume {});
            until(session, |panel| !panel.paused && panel.pace == 5e-3);
            obey(Command::Kick { mm_per_s: None });
            obey(Command::Kick {
                mm_per_s: Some(2.0),
            });
            let panel = until(session, |panel| {
                panel
                    .events
                    .iter()
                    .any(|e| e.text.starts_with("kick of 2 mm/s"))
            });
            let kicks = panel.events.iter().filter(|e| e.text.starts_with("kick"));
            assert_eq!(kicks.count(), 2);
        });
    }

    #[test]
    fn another_scene_and_a_reset_are_runs_of_their_own() {
        steered("torus-3deg", |session| {
            let obey = |command| session.obey(&command).unwrap();
            let name = "mass-on-belt".to_owned();
            obey(Command::Scene { name });
            let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
            assert_eq!(
                (panel.scene.as_str(), panel.tilt_deg),
                ("mass-on-belt", None)
            );
            assert!(session.obey(&Command::Tilt { deg: 2.0 }).is_err());
            obey(Command::Reset {});
            until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
        });
    }

    #[test]
    fn what_is_asked_for_while_another_run_begins_is_for_that_run() {
        steered("torus-3deg", |session| {
            let obey = |command| session.obey(&command).unwrap();
            obey(Command::Reset {});
            obey(Command::Pause {});
            let panel = until(session, |panel| panel.run == 2 && panel.paused);
            assert!(panel.events.iter().any(|e| e.text == "torus-3deg begins"));
            // Done although time stands still.
            obey(Command::Record {});
            until(session, |panel| panel.recording.is_some());
            obey(Command::StopRecording {});
            until(session, |panel| panel.recording.is_none());
            obey(Command::Resume {});
            until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        });
    }

    #[test]
    fn neighbours_are_left_out_when_asked_for() {
        steered("chaos-5deg", |session| {
            assert_eq!(session.panel().neighbours, Some(true));
            let obey = |command| session.obey(&command).unwrap();
            obey(Command::Neighbours { follow: false });
            let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
            assert_eq!(panel.neighbours, Some(false));
            // Asked again, nothing is begun anew.
            obey(Command::Neighbours { follow: false });
            // What has none has none.
            let name = "mass-on-belt".to_owned();
            obey(Command::Scene { name });
            let panel = until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
            assert_eq!(panel.neighbours, None);
        });
    }

    #[test]
    fn what_is_out_of_range_is_refused_by_name() {
        steered("torus-3deg", |session| {
            for (command, part) in [
                (Command::Tilt { deg: 10.1 }, "the tilt must be from 0 to 10"),
                (Command::Tilt { deg: f64::NAN }, "the tilt must be"),
                (Command::Pace { ms_per_s: 0.0 }, "the pace must be"),
                (
                    Command::Kick {
                        mm_per_s: Some(-1.0),
                    },
                    "a kick must be",
                ),
                (
                    Command::Scene {
                        name: "../etc/passwd".to_owned(),
                    },
                    "no scene `../etc/passwd`",
                ),
            ] {
                let refused = session.obey(&command).unwrap_err().to_string();
                assert!(refused.contains(part), "{refused}");
            }
            let panel = session.panel();
            let tilt = panel.tilt_deg.unwrap();
            assert!((tilt - 3.0).abs() < 1e-9 && panel.run == 1, "{panel:?}");
        });
    }

    #[test]
    fn a_scene_reaches_beyond_ten_degrees_if_it_does_so_by_itself() {
        let scene = Scene::load("torus-3deg").unwrap();
        assert_eq!(reach(&scene), Some([0.0, 10.0]));
        let steep = scene.with_tilt(14.0).unwrap();
        assert_eq!(reach(&steep), Some([0.0, 14.0]));
        assert_eq!(reach(&Scene::load("mass-on-belt").unwrap()), None);
    }
}
