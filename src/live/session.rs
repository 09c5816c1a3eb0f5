//! A live session: a sequence of runs that accept commands.

mod commands;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use tokio::sync::broadcast;

pub(super) use self::commands::{check_state, preset_scene, start_commands};
use super::audio::{self, AudioSink, Sound};
use super::command::Promise;
use super::diagram::{BifurcationEvents, DiagramStore};
use super::lock;
use super::panel::{Panel, StatusSink, StatusStore};
use super::recorder::{Recorder, RecordingControl, SavedFile};
use super::tour::{Tour, TourStep};
use super::views::ViewStore;
use crate::escape;
use crate::pipeline::message::Summary;
use crate::pipeline::{
    InteractiveSource, Monitor, PipelineError, RunCommand, RunHandle, Simulation, Sink, SinkError,
    Source as _, Tee, drive, joined,
};
use crate::record::{Output, RerunSink};
use crate::scene::{PRESETS, Scene, preset};
use crate::sound::{Source, WavSink};

/// Options of a session.
#[derive(Clone, Debug)]
pub struct SessionOptions {
    /// The first scene.
    pub scene: Scene,
    /// Command line of the program.
    pub command: String,
    /// Initial playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Whether to compute the Lyapunov exponents and the perturbed trajectory, see [`Command::Lyapunov`](super::Command::Lyapunov).
    pub lyapunov: bool,
    /// Rerun viewer that also shows the runs.
    pub viewer: Option<Output>,
    /// Whether to compute the branch diagram of a scene that has no stored one.
    pub computes_diagram: bool,
    /// Folder for recordings started during the session.
    pub folder: PathBuf,
    /// File of a recording from the start.
    pub save: Option<PathBuf>,
    /// WAV file for the sound of the first run.
    pub wav: Option<PathBuf>,
    /// Quantity and point of the audio signal.
    pub source: Source,
    /// The guided tour.
    pub tour: Option<Tour>,
}

impl SessionOptions {
    /// Those of the second run of the page: without files, viewer, tour and what is expensive.
    #[must_use]
    pub fn second(&self) -> Self {
        Self {
            lyapunov: false,
            viewer: None,
            computes_diagram: false,
            save: None,
            wav: None,
            tour: None,
            ..self.clone()
        }
    }
}

/// A session, shared by all clients that control it.
pub struct Session {
    pub(super) options: SessionOptions,
    /// Data for the views of the page.
    pub views: Arc<ViewStore>,
    /// Audio for the listeners of the page.
    pub(super) audio: broadcast::Sender<Sound>,
    store: Arc<StatusStore>,
    /// Recordings of the runs.
    pub(super) recording: Arc<RecordingControl>,
    /// The branch diagram of the present scene.
    pub(super) diagrams: Arc<DiagramStore>,
    current: Mutex<Current>,
    /// Stops a run within a frame.
    stop: Arc<AtomicBool>,
    thread: Mutex<Option<JoinHandle<RunEnd>>>,
}

/// The summary of the last run, or `None` if there was none; or the first error of a run.
type RunEnd = Result<Option<Summary>, PipelineError>;

/// Name of the thread of a session.
const THREAD: &str = "session";

struct Current {
    scene: Scene,
    speed: f64,
    lyapunov: bool,
    /// The run, or the next one.
    handle: RunHandle,
    /// Number of runs opened so far.
    opened: u64,
    /// The run of which the panel is, if it runs: the number of runs that had been opened.
    running: Option<u64>,
    /// The scene with the numbers that commands have changed.
    present: Scene,
    /// Number of kicks in the run.
    kicks: u64,
    /// Step of the tour, from 0, while it is shown.
    step: Option<usize>,
    /// Whether all pages are black.
    blank: bool,
    /// What the run was started with, without the playback speed: a restart repeats it.
    opening: TourStep,
    /// The motion that the run was started for, until it is changed by hand.
    promise: Option<Promise>,
    wav: Option<PathBuf>,
}

impl Session {
    /// Creates a session that has not started.
    pub fn new(options: SessionOptions) -> Self {
        Self {
            views: Arc::default(),
            audio: broadcast::channel(audio::QUEUE).0,
            store: Arc::default(),
            recording: Arc::new(RecordingControl::new(
                options.folder.clone(),
                options.save.clone(),
            )),
            diagrams: Arc::default(),
            current: Mutex::new(Current {
                scene: options.scene.clone(),
                speed: options.speed,
                lyapunov: options.lyapunov,
                handle: RunHandle::new(options.speed),
                opened: 0,
                running: None,
                present: options.scene.clone(),
                kicks: 0,
                step: None,
                blank: false,
                opening: TourStep::of_scene(&options.scene.name),
                promise: None,
                wav: options.wav.clone(),
            }),
            options,
            stop: Arc::default(),
            thread: Mutex::default(),
        }
    }

    /// Runs the session on its own thread, see [`Session::run`], unless it was started before.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(self: &Arc<Self>) -> Result<(), PipelineError> {
        let mut thread = lock(&self.thread);
        if thread.is_none() {
            let session = Arc::clone(self);
            let started = std::thread::Builder::new()
                .name(THREAD.to_owned())
                .spawn(move || session.run())
                .map_err(|source| PipelineError::Thread {
                    name: THREAD,
                    source,
                })?;
            *thread = Some(started);
        }
        Ok(())
    }

    /// Whether the thread of the session has ended.
    pub fn is_finished(&self) -> bool {
        let thread = lock(&self.thread);
        thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Waits for the end of the thread of the session. Returns the summary of the last run, or `None` if there was none.
    ///
    /// # Errors
    /// Errors of [`Session::run`]. A panic counts as an error.
    pub fn join(&self) -> RunEnd {
        let thread = lock(&self.thread).take();
        thread.map_or(Ok(None), |thread| joined(thread.join(), THREAD))
    }

    /// Runs one scene after another until the session is stopped.
    ///
    /// # Errors
    /// The first error of a run.
    pub fn run(&self) -> RunEnd {
        let ended = self.run_all();
        self.diagrams.cancel();
        ended
    }

    fn run_all(&self) -> RunEnd {
        let mut viewer = self.options.viewer.clone();
        let mut last = None;
        loop {
            let (scene, handle, opened, wav, lyapunov) = {
                let mut current = lock(&self.current);
                if self.stop.load(Ordering::Relaxed) {
                    return Ok(last);
                }
                let followed = current.scene.computes_lyapunov();
                let lyapunov = followed.then_some(current.lyapunov);
                let scene = match lyapunov {
                    Some(false) => current.scene.without_lyapunov()?,
                    Some(true) | None => current.scene.clone(),
                };
                let handle = current.handle.clone();
                let opened = current.opened;
                (scene, handle, opened, current.wav.take(), lyapunov)
            };
            let run = InteractiveSource::new(Simulation::new(&scene)?, &handle);
            let header = Arc::new(run.header(&self.options.command));
            if self.options.computes_diagram {
                let interval = header.tilt_slider();
                self.diagrams.show(&scene, interval, &self.store);
            }
            self.store.begin_run(&header, lyapunov);
            self.store.log(0.0, format!("{} starts", scene.name));
            // The views of the page come first: they answer at once.
            let views = self.views.sink(scene.record.deformation_scale);
            let audio = AudioSink::new(self.options.source, &header, handle, self.audio.clone());
            let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(views), Box::new(audio)];
            if let Some(output) = &mut viewer {
                sinks.push(Box::new(
                    RerunSink::new(output, scene.record).map_err(sink)?,
                ));
                // The whole session uses one viewer.
                if output.spawn {
                    *output = Output {
                        connect: Some("rerun+http://127.0.0.1:9876/proxy".to_owned()),
                        ..Output::default()
                    };
                }
            }
            let (recording, store) = (Arc::clone(&self.recording), Arc::clone(&self.store));
            let recorder = Recorder::new(recording, store, scene.record, Arc::clone(&header));
            sinks.push(Box::new(recorder));
            if let Some(wav) = wav.clone() {
                let wav_sink = WavSink::new(wav, self.options.source, &header, 1.0);
                sinks.push(Box::new(wav_sink.map_err(sink)?));
            }
            // The last sink: a file then contains every record that the panel has shown.
            sinks.push(Box::new(StatusSink(Arc::clone(&self.store))));
            lock(&self.current).running = Some(opened);
            let mut events = BifurcationEvents::new(Arc::clone(&self.diagrams));
            let mut tee = Tee::new(sinks).deriving(move |record| events.after(record));
            let monitor = Monitor {
                stop: &self.stop,
                ..Monitor::default()
            };
            let ran = drive(run, &self.options.command, &mut tee, monitor);
            // The recorder of a failed run reports its file.
            drop(tee);
            lock(&self.current).running = None;
            if let Some(wav) = wav {
                let outcome = ran.as_ref().map(|_| ());
                let outcome =
                    outcome.map_err(|_| "the run failed; the file was not written".into());
                self.recording.store_result(wav, outcome);
            }
            last = Some(ran?);
        }
    }

    /// Stops the session.
    pub fn end(&self) {
        let current = lock(&self.current);
        self.stop.store(true, Ordering::Relaxed);
        end(&current.handle);
    }

    /// Results for the requested files, after the end of the session; with `unstarted`, also for those that were not begun.
    pub fn saved(&self, unstarted: bool) -> Vec<SavedFile> {
        let (mut saved, left) = self.recording.take_results();
        let left = left.into_iter().chain(lock(&self.current).wav.take());
        saved.extend(left.filter(|_| unstarted).map(|path| SavedFile {
            path,
            outcome: Err("the run ended before the file was created; nothing was written".into()),
        }));
        saved
    }

    /// Present values of the control panel.
    pub fn panel(&self) -> Panel {
        let (status, tour_step, blank, promise) = {
            let current = lock(&self.current);
            // Between two runs the panel is still that of the former one.
            let is_running = current.running == Some(current.opened);
            let promise = current.promise.clone().filter(|_| is_running);
            let status = current.handle.status();
            (status, current.step, current.blank, promise)
        };
        let mut panel = Panel {
            speed: status.speed,
            measured_speed: status.measured_speed,
            paused: status.paused,
            watching: self.views.watching(),
            diagram: self.diagrams.number(),
            diagram_note: self.diagrams.note(),
            tour_step,
            blank,
            ..self.store.read()
        };
        panel.departure = promise.and_then(|promise| panel.departure_from(&promise));
        panel
    }

    /// A bookmark of the present motion, without a name and views.
    pub fn bookmark(&self) -> TourStep {
        TourStep {
            speed_ms_per_s: Some(1e3 * lock(&self.current).speed),
            ..self.store.bookmark()
        }
    }

    /// The available scenes: name and title.
    pub fn scenes(&self) -> Vec<[String; 2]> {
        let mut scenes: Vec<[String; 2]> = Vec::new();
        let first = &self.options.scene;
        if preset(&first.name).is_none() {
            scenes.push([first.name.clone(), escape::line(&first.title)]);
        }
        scenes.extend(PRESETS.iter().map(|preset| {
            let title = preset.scene().map(|scene| scene.title);
            [preset.name.to_owned(), title.unwrap_or_default()]
        }));
        scenes
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
