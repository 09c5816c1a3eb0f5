//! A live session: a sequence of runs that accept commands.

mod commands;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

pub(super) use self::commands::{check_state, preset_scene, start_commands};
use super::audio::AudioStream;
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
    InteractiveSource, Monitor, PendingCommands, PipelineError, RunCommand, RunHandle, Simulation,
    Sink, SinkError, Source as _, Tee, drive,
};
use crate::record::{Output, RerunSink};
use crate::scene::{PRESETS, Scene, preset};
use crate::sound::{Source, WavSink};

/// Options of a session.
#[derive(Debug)]
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

/// A session, shared by all clients that control it.
pub struct Session {
    pub(super) options: SessionOptions,
    /// Data for the views of the page.
    pub views: Arc<ViewStore>,
    /// Audio for the listeners of the page.
    pub audio: Arc<AudioStream>,
    store: Arc<StatusStore>,
    /// Recordings of the runs.
    pub(super) recording: Arc<RecordingControl>,
    /// The branch diagram of the present scene.
    pub(super) diagrams: Arc<DiagramStore>,
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
    /// The scene with the numbers that commands have changed.
    present: Scene,
    /// Commands sent before the run existed.
    early: PendingCommands,
    /// Whether another run starts, with `scene`.
    restarts: bool,
    stopped: bool,
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
            audio: Arc::new(AudioStream::new(options.source)),
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
                handle: None,
                present: options.scene.clone(),
                early: PendingCommands::default(),
                restarts: false,
                stopped: false,
                step: None,
                blank: false,
                opening: TourStep::of_scene(&options.scene.name),
                promise: None,
                wav: options.wav.clone(),
            }),
            options,
            kicks: AtomicU64::new(0),
            stop: Arc::default(),
        }
    }

    /// Runs one scene after another until the session is stopped.
    ///
    /// # Errors
    /// The first error of a run.
    pub fn run(&self) -> Result<Option<Summary>, PipelineError> {
        let ended = self.run_all();
        self.diagrams.cancel();
        ended
    }

    fn run_all(&self) -> Result<Option<Summary>, PipelineError> {
        let mut viewer = self.options.viewer.clone();
        let mut last = None;
        loop {
            let (scene, speed, wav, lyapunov) = {
                let mut current = lock(&self.current);
                if current.stopped {
                    return Ok(last);
                }
                current.restarts = false;
                let followed = current.scene.computes_lyapunov();
                let lyapunov = followed.then_some(current.lyapunov);
                let scene = match lyapunov {
                    Some(false) => current.scene.without_lyapunov()?,
                    Some(true) | None => current.scene.clone(),
                };
                (scene, current.speed, current.wav.take(), lyapunov)
            };
            let (run, handle) = InteractiveSource::new(Simulation::new(&scene)?, speed);
            let header = run.header(&self.options.command);
            if self.options.computes_diagram {
                let interval = header.tilt_slider();
                self.diagrams.show(&scene, interval, &self.store);
            }
            self.store.begin_run(&header, lyapunov);
            self.store.log(0.0, format!("{} starts", scene.name));
            let mut sinks = self.display_sinks(&scene, &handle, viewer.as_mut())?;
            let (recording, store) = (Arc::clone(&self.recording), Arc::clone(&self.store));
            sinks.push(Box::new(Recorder::new(recording, store, scene.record)));
            if let Some(wav) = wav.clone() {
                let wav_sink = WavSink::new(wav, self.options.source, &header, 1.0);
                sinks.push(Box::new(wav_sink.map_err(sink)?));
            }
            // The last sink: a file then contains every record that the panel has shown.
            sinks.push(Box::new(StatusSink(Arc::clone(&self.store))));
            {
                let mut current = lock(&self.current);
                if current.restarts || current.stopped {
                    end(&handle);
                } else {
                    // Commands sent in the meantime are kept.
                    handle.set_pending(std::mem::take(&mut current.early));
                    current.handle = Some(handle);
                }
            }
            let mut events = BifurcationEvents::new(Arc::clone(&self.diagrams));
            let mut tee = Tee::new(sinks).with_events(move |record| events.of(record));
            let monitor = Monitor {
                stop: &self.stop,
                ..Monitor::default()
            };
            let ran = drive(run, &self.options.command, &mut tee, monitor);
            lock(&self.current).handle = None;
            if let Some(wav) = wav {
                let outcome = ran.as_ref().map(|_| ());
                let outcome =
                    outcome.map_err(|_| "the run failed; the file was not written".into());
                self.recording.store_result(wav, outcome);
            }
            last = Some(ran?);
        }
    }

    /// The sinks that display a run: on the page, and in a viewer.
    fn display_sinks(
        &self,
        scene: &Scene,
        handle: &RunHandle,
        output: Option<&mut Output>,
    ) -> Result<Vec<Box<dyn Sink>>, PipelineError> {
        self.audio.set_run(handle.clone());
        // The views of the page come first: they answer at once.
        let views = self.views.sink(scene.record.deformation_scale);
        let mut sinks: Vec<Box<dyn Sink>> = vec![Box::new(views), Box::new(self.audio.sink())];
        if let Some(output) = output {
            let viewer = RerunSink::new(output, scene.record).map_err(sink)?;
            sinks.push(Box::new(viewer));
            // The whole session uses one viewer.
            if output.spawn {
                *output = Output {
                    connect: Some("rerun+http://127.0.0.1:9876/proxy".to_owned()),
                    ..Output::default()
                };
            }
        }
        Ok(sinks)
    }

    /// Stops the session.
    pub fn end(&self) {
        let mut current = lock(&self.current);
        current.stopped = true;
        self.stop.store(true, Ordering::Relaxed);
        if let Some(handle) = &current.handle {
            end(handle);
        }
    }

    /// Results for the requested files, after the end of the session.
    pub fn saved(&self) -> Vec<SavedFile> {
        let mut saved = self.recording.take_results();
        let wav = lock(&self.current).wav.take();
        saved.extend(wav.map(SavedFile::never_started));
        saved
    }

    /// Present values of the control panel.
    pub fn panel(&self) -> Panel {
        let (status, tour_step, blank, promise) = {
            let current = lock(&self.current);
            let status = current.handle.as_ref().map(RunHandle::status);
            // Between two runs the panel is still that of the former one.
            let promise = status.and(current.promise.clone());
            (status, current.step, current.blank, promise)
        };
        let mut panel = Panel {
            diagram: self.diagrams.number(),
            diagram_note: self.diagrams.note(),
            tour_step,
            blank,
            ..self.store.read(status, self.views.watching())
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
            scenes.push([first.name.clone(), escape::line(&first.title).into_owned()]);
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
