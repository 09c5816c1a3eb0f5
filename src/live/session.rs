//! A live session: a sequence of runs that accept commands.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::audio::AudioStream;
use super::command::{Command, DEFAULT_KICK, KICK_RANGE, Rejected, SPEED_RANGE, check_range};
use super::diagram::{BifurcationEvents, DiagramStore};
use super::hub::Hub;
use super::panel::{Panel, StatusSink, StatusStore};
use super::recorder::{Recorder, RecordingControl, SavedFile};
use super::throttled_sink::ThrottledSink;
use super::views::ViewStore;
use crate::escape;
use crate::pipeline::message::Summary;
use crate::pipeline::{
    InteractiveSource, Monitor, PendingCommands, PipelineError, RunCommand, RunHandle, RunStatus,
    Sink, SinkError, Source as _, Tee, controllable_source, drive,
};
use crate::record::{Output, RerunSink};
use crate::scene::{PRESETS, Scene};
use crate::sound::{Source, WavSink};

/// Range of tilts, degrees, if the scene itself does not exceed it. It is smaller if the patch would leave
/// the ball.
const TILT_RANGE_DEG: [f64; 2] = [0.0, 10.0];
/// Target of the view of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ViewTarget {
    /// The web page.
    Page,
    /// The own views of the web page, without a Rerun viewer: for a second run.
    Views,
    /// A Rerun viewer.
    Viewer(Output),
}

/// Options of a session.
#[derive(Debug)]
pub struct SessionOptions {
    /// The first scene.
    pub scene: Scene,
    /// Command line of the program.
    pub command: String,
    /// Initial playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Whether to compute the Lyapunov exponents and the perturbed trajectory, see [`Command::Lyapunov`].
    pub lyapunov: bool,
    /// Display.
    pub watcher: ViewTarget,
    /// Folder for recordings started during the session.
    pub folder: PathBuf,
    /// File of a recording from the start.
    pub save: Option<PathBuf>,
    /// WAV file for the sound of the first run.
    pub wav: Option<PathBuf>,
    /// Quantity and point of the audio signal.
    pub source: Source,
}

/// A session, shared by all clients that control it.
pub struct Session {
    first: Scene,
    command: String,
    watcher: ViewTarget,
    source: Source,
    /// Data for the page's own views.
    pub views: Arc<ViewStore>,
    /// Data for the viewers of the page.
    pub hub: Arc<Hub>,
    /// Audio for the listeners of the page.
    pub audio: Arc<AudioStream>,
    store: Arc<StatusStore>,
    recording: Arc<RecordingControl>,
    diagrams: Arc<DiagramStore>,
    current: Mutex<Current>,
    kicks: AtomicU64,
    /// Stops a run within a frame.
    stop: Arc<AtomicBool>,
}

struct Current {
    scene: Scene,
    speed: f64,
    lyapunov: bool,
    /// Present during a run.
    handle: Option<RunHandle>,
    /// Range of tilts, degrees; `None` for a scene without tilt.
    tilt_range_deg: Option<[f64; 2]>,
    /// Commands sent before the run existed.
    early: PendingCommands,
    /// Scene of the next run, if the present one is to end.
    next: Option<Scene>,
    stopped: bool,
    wav: Option<PathBuf>,
}

impl Session {
    /// Creates a session that has not started.
    pub fn new(plan: SessionOptions) -> Self {
        Self {
            views: Arc::default(),
            hub: Arc::default(),
            audio: Arc::new(AudioStream::new(plan.source)),
            store: Arc::default(),
            recording: Arc::new(RecordingControl::new(plan.folder, plan.save)),
            diagrams: Arc::default(),
            current: Mutex::new(Current {
                scene: plan.scene.clone(),
                speed: plan.speed,
                lyapunov: plan.lyapunov,
                handle: None,
                tilt_range_deg: tilt_range_deg(&plan.scene),
                early: PendingCommands::default(),
                next: None,
                stopped: false,
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

    /// Runs one scene after another until the session is stopped. `notice` receives messages about a lost
    /// viewer.
    ///
    /// # Errors
    /// The first error of a run.
    pub fn run(
        &self,
        notice: &Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Option<Summary>, PipelineError> {
        let ended = self.run_all(notice);
        self.diagrams.cancel();
        ended
    }

    fn run_all(
        &self,
        notice: &Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Option<Summary>, PipelineError> {
        let mut output = match &self.watcher {
            ViewTarget::Page | ViewTarget::Views => None,
            ViewTarget::Viewer(output) => Some(output.clone()),
        };
        let mut last = None;
        loop {
            let (scene, speed, wav, lyapunov) = {
                let mut current = self.current();
                if current.stopped {
                    return Ok(last);
                }
                if let Some(next) = current.next.take() {
                    current.tilt_range_deg = tilt_range_deg(&next);
                    current.scene = next;
                }
                let followed = current.scene.computes_lyapunov();
                let lyapunov = followed.then_some(current.lyapunov);
                let scene = match lyapunov {
                    Some(false) => current.scene.clone().without_lyapunov(),
                    Some(true) | None => current.scene.clone(),
                };
                (scene, current.speed, current.wav.take(), lyapunov)
            };
            let tilt_range_deg = self.current().tilt_range_deg;
            let tilt_range = tilt_range_deg.unwrap_or_default().map(f64::to_radians);
            let (run, handle) =
                InteractiveSource::new(controllable_source(&scene)?, speed, tilt_range);
            self.store.begin_run(tilt_range_deg, lyapunov);
            self.store.log(0.0, format!("{} starts", scene.name));
            if self.watcher == ViewTarget::Page {
                self.diagrams.show(&scene, tilt_range_deg, &self.store);
            }
            let mut sinks = self.display_sinks(&scene, &handle, output.as_mut(), notice)?;
            let (recording, store) = (Arc::clone(&self.recording), Arc::clone(&self.store));
            sinks.push(Box::new(Recorder::new(recording, store, scene.record)));
            if let Some(wav) = wav.clone() {
                let header = run.header(&self.command);
                let wav_sink = WavSink::new(wav, self.source, &header, 1.0);
                sinks.push(Box::new(wav_sink.map_err(sink)?));
            }
            // The last sink: a file then contains every record that the panel has shown.
            sinks.push(Box::new(StatusSink(Arc::clone(&self.store))));
            {
                let mut current = self.current();
                // Commands sent in the meantime are kept.
                handle.set_pending(std::mem::take(&mut current.early));
                if current.next.is_some() || current.stopped {
                    end(&handle);
                }
                current.handle = Some(handle);
            }
            let mut tee = BifurcationEvents::new(Tee::new(sinks), Arc::clone(&self.diagrams));
            let monitor = Monitor {
                stop: &self.stop,
                ..Monitor::default()
            };
            let ran = drive(run, &self.command, &mut tee, monitor);
            self.current().handle = None;
            if let Some(wav) = wav {
                let outcome = ran.as_ref().map(|_| ());
                let outcome =
                    outcome.map_err(|_| "the run failed; the file was not written".into());
                self.recording.store_result(wav, outcome);
            }
            last = Some(ran?);
        }
    }

    /// The sinks that display a run: on the page, or in a viewer.
    fn display_sinks(
        &self,
        scene: &Scene,
        handle: &RunHandle,
        output: Option<&mut Output>,
        notice: &Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Result<Vec<Box<dyn Sink>>, PipelineError> {
        let Some(output) = output else {
            self.audio.set_run(handle.clone());
            // The page's own views come first: they answer at once.
            let views = self.views.sink(scene.record.deformation_scale);
            let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(views), Box::new(self.audio.sink())];
            if self.watcher == ViewTarget::Page {
                self.hub.begin();
                let audience = Arc::clone(&self.hub) as _;
                let viewer = RerunSink::for_receiver(audience, scene.record).map_err(sink)?;
                sinks.push(Box::new(ThrottledSink::new(viewer)));
            }
            return Ok(sinks);
        };
        let notice = Arc::clone(notice);
        let viewer = RerunSink::new(output, scene.record).map_err(sink)?;
        let viewer = viewer.with_notice(move |words| notice(words));
        // The whole session uses one viewer.
        if output.spawn {
            *output = Output {
                connect: Some("rerun+http://127.0.0.1:9876/proxy".to_owned()),
                ..Output::default()
            };
        }
        Ok(vec![Box::new(ThrottledSink::new(viewer))])
    }

    /// Stops the session.
    pub fn end(&self) {
        let mut current = self.current();
        current.stopped = true;
        self.stop.store(true, Ordering::Relaxed);
        if let Some(handle) = &current.handle {
            end(handle);
        }
    }

    /// Results for the requested files, after the end of the session.
    pub fn saved(&self) -> Vec<SavedFile> {
        let mut saved = self.recording.take_results();
        let wav = self.current().wav.take();
        saved.extend(wav.map(SavedFile::never_started));
        saved
    }

    /// Path of a complete recording with this file name.
    pub fn complete_recording(&self, name: &str) -> Option<PathBuf> {
        self.recording.complete(name)
    }

    /// Shows a message on all panels.
    pub fn log(&self, words: &str) {
        self.store.log(self.time(), words);
    }

    /// Present values of the control panel.
    pub fn panel(&self) -> Panel {
        self.store.read(self.status(), self.hub.watching())
    }

    /// The branch diagram of the present scene as JSON; `None` if it has none, or none yet.
    pub fn diagram(&self) -> Option<Arc<str>> {
        self.diagrams.text()
    }

    /// Whether the branch diagram of the present scene is being computed.
    pub fn is_computing_diagram(&self) -> bool {
        self.diagrams.is_computing()
    }

    /// Simulated time of the run, s; 0 between two runs.
    pub fn time(&self) -> f64 {
        self.status().map_or(0.0, |status| status.time)
    }

    /// Present state of the run, if there is one.
    pub fn status(&self) -> Option<RunStatus> {
        self.current().handle.as_ref().map(RunHandle::status)
    }

    /// The available scenes: name and title.
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

    /// The present scene.
    pub fn scene(&self) -> Scene {
        self.current().scene.clone()
    }

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

    fn current(&self) -> MutexGuard<'_, Current> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops a run.
fn end(handle: &RunHandle) {
    // A run always accepts an end command.
    let _ = handle.send(RunCommand::End);
}

fn sink(fault: impl Into<SinkError>) -> PipelineError {
    PipelineError::Sink(fault.into())
}

/// Range of tilts, degrees: the union of the range of the scene and [`TILT_RANGE_DEG`], as far as the patch
/// stays on the ball.
fn tilt_range_deg(scene: &Scene) -> Option<[f64; 2]> {
    let tilt = &scene.joint().ok()?.tilt;
    let own = [tilt.min(), tilt.max()].map(f64::to_degrees);
    let fits = |deg: f64| scene.clone().with_tilt(deg).is_ok();
    // In steps of 0.5 degrees from the range of the scene, which is valid.
    let extend = |own: f64, end: f64| {
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
        extend(own[0], own[0].min(TILT_RANGE_DEG[0])),
        extend(own[1], own[1].max(TILT_RANGE_DEG[1])),
    ])
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    fn session(scene: &str) -> Arc<Session> {
        let plan = SessionOptions {
            scene: Scene::load(scene).unwrap(),
            command: "squeakscope live".to_owned(),
            speed: 0.02,
            lyapunov: true,
            watcher: ViewTarget::Page,
            folder: std::env::temp_dir(),
            save: None,
            wav: None,
            source: Source::default(),
        };
        Arc::new(Session::new(plan))
    }

    /// Runs a session while `control` sends commands.
    fn with_session(scene: &str, control: impl FnOnce(&Session)) {
        let session = session(scene);
        let runner = {
            let session = Arc::clone(&session);
            std::thread::spawn(move || {
                let notice: Arc<dyn Fn(&str) + Send + Sync> = Arc::new(|_| ());
                session.run(&notice).map(|_| ())
            })
        };
        until(&session, |panel| panel.time_s > 0.0);
        control(&session);
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
    fn commands_take_effect() {
        with_session("torus-3deg", |session| {
            let apply = |command| session.apply(&command).unwrap();
            apply(Command::Tilt { deg: 4.25 });
            let panel = until(session, |panel| panel.tilt_deg == Some(4.25));
            assert!(panel.events.iter().any(|e| e.text == "tilt 4.25 degrees"));
            apply(Command::Pause {});
            let at = until(session, |panel| panel.paused);
            apply(Command::Step {});
            until(session, |panel| panel.time_s > at.time_s && panel.paused);
            apply(Command::Speed { ms_per_s: 5.0 });
            apply(Command::Resume {});
            until(session, |panel| !panel.paused && panel.speed == 5e-3);
            apply(Command::Kick { mm_per_s: None });
            apply(Command::Kick {
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
    fn another_scene_and_a_reset_start_new_runs() {
        with_session("torus-3deg", |session| {
            let apply = |command| session.apply(&command).unwrap();
            let name = "mass-on-belt".to_owned();
            apply(Command::Scene { name });
            let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
            assert_eq!(
                (panel.scene.as_str(), panel.tilt_deg),
                ("mass-on-belt", None)
            );
            assert!(session.apply(&Command::Tilt { deg: 2.0 }).is_err());
            apply(Command::Reset {});
            until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
        });
    }

    #[test]
    fn commands_during_a_restart_apply_to_the_new_run() {
        with_session("torus-3deg", |session| {
            let apply = |command| session.apply(&command).unwrap();
            apply(Command::Reset {});
            apply(Command::Pause {});
            let panel = until(session, |panel| panel.run == 2 && panel.paused);
            assert!(panel.events.iter().any(|e| e.text == "torus-3deg starts"));
            // Recording works while the run is paused.
            apply(Command::Record {});
            until(session, |panel| panel.recording.is_some());
            apply(Command::StopRecording {});
            until(session, |panel| panel.recording.is_none());
            apply(Command::Resume {});
            until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        });
    }

    #[test]
    fn lyapunov_analyses_can_be_switched_off() {
        with_session("chaos-5deg", |session| {
            assert_eq!(session.panel().lyapunov, Some(true));
            let apply = |command| session.apply(&command).unwrap();
            apply(Command::Lyapunov { enabled: false });
            let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
            assert_eq!(panel.lyapunov, Some(false));
            // A repeated command does not restart the scene.
            apply(Command::Lyapunov { enabled: false });
            // A scene without these analyses does not have the option.
            let name = "mass-on-belt".to_owned();
            apply(Command::Scene { name });
            let panel = until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
            assert_eq!(panel.lyapunov, None);
        });
    }

    #[test]
    fn values_out_of_range_are_rejected_with_their_names() {
        with_session("torus-3deg", |session| {
            for (command, part) in [
                (
                    Command::Tilt { deg: 10.1 },
                    "the tilt must be between 0 and 10",
                ),
                (Command::Tilt { deg: f64::NAN }, "the tilt must be"),
                (
                    Command::Speed { ms_per_s: 0.0 },
                    "the playback speed must be",
                ),
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
                    "unknown scene `../etc/passwd`",
                ),
            ] {
                let refused = session.apply(&command).unwrap_err().to_string();
                assert!(refused.contains(part), "{refused}");
            }
            let panel = session.panel();
            let tilt = panel.tilt_deg.unwrap();
            assert!((tilt - 3.0).abs() < 1e-9 && panel.run == 1, "{panel:?}");
        });
    }

    #[test]
    fn the_tilt_range_includes_that_of_the_scene() {
        let scene = Scene::load("torus-3deg").unwrap();
        assert_eq!(tilt_range_deg(&scene), Some([0.0, 10.0]));
        let steep = scene.with_tilt(14.0).unwrap();
        assert_eq!(tilt_range_deg(&steep), Some([0.0, 14.0]));
        assert_eq!(tilt_range_deg(&Scene::load("mass-on-belt").unwrap()), None);
    }
}
