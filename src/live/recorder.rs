//! Recording of a live run into files, started and stopped by commands.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use super::lock;
use super::panel::StatusStore;
use crate::pipeline::message::{Frame, Header, Record};
use crate::pipeline::{Sink, SinkError};
use crate::record::{PartFile, RecordError, RerunSink};
use crate::scene::RecordSpec;

/// Control of recordings from any thread: starts and stops them.
#[derive(Debug)]
pub struct RecordingControl {
    folder: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Requested file, with its reserved name until the recorder uses it; `None` while nothing is recorded.
    requested: Option<(PathBuf, Option<PartFile>)>,
    saved: Vec<SavedFile>,
}

/// Result for a saved file that was requested.
#[derive(Debug)]
pub struct SavedFile {
    /// Path.
    pub path: PathBuf,
    /// Whether the file is complete, or the reason why not.
    pub outcome: Result<(), SinkError>,
}

impl RecordingControl {
    /// Creates new files in a folder with automatic names; `first` is recorded from the start if given.
    pub fn new(folder: PathBuf, first: Option<PathBuf>) -> Self {
        let state = State {
            requested: first.map(|file| (file, None)),
            ..State::default()
        };
        Self {
            folder,
            state: Mutex::new(state),
        }
    }

    /// Starts a recording and returns its file, whose name is reserved. A running recording continues.
    ///
    /// # Errors
    /// If no file can be created in the folder.
    pub fn start(&self) -> Result<PathBuf, RecordError> {
        let mut state = lock(&self.state);
        if let Some((file, _)) = &state.requested {
            return Ok(file.clone());
        }
        let names = (1..=u32::MAX).map(|k| self.folder.join(format!("live-{k}.rrd")));
        let reserved = PartFile::reserve(names)?;
        let file = reserved.path().to_owned();
        state.requested = Some((file.clone(), Some(reserved)));
        Ok(file)
    }

    /// Stops the recording.
    pub fn stop(&self) {
        let requested = lock(&self.state).requested.take();
        if let Some((_, Some(reserved))) = requested {
            reserved.abandon();
        }
    }

    /// Stores the result for a file.
    pub fn store_result(&self, path: PathBuf, outcome: Result<(), SinkError>) {
        lock(&self.state).saved.push(SavedFile { path, outcome });
    }

    /// Path of a complete recording with this file name.
    pub fn complete(&self, name: &str) -> Option<PathBuf> {
        let state = lock(&self.state);
        let mut complete = state.saved.iter().filter(|file| file.outcome.is_ok());
        let found = complete.find(|file| file.path.file_name().is_some_and(|found| found == name));
        found.map(|file| file.path.clone())
    }

    /// After the end of the run, the results since the last call, and a requested file that was not begun.
    pub fn take_results(&self) -> (Vec<SavedFile>, Option<PathBuf>) {
        let mut state = lock(&self.state);
        let left = state.requested.take();
        let left = left.map(|(file, reserved)| reserved.map_or(file, |part| part.abandon()));
        (std::mem::take(&mut state.saved), left)
    }

    fn requested(&self) -> Option<PathBuf> {
        let state = lock(&self.state);
        state.requested.as_ref().map(|(file, _)| file.clone())
    }

    fn take_reserved(&self) -> Option<PartFile> {
        lock(&self.state).requested.as_mut()?.1.take()
    }
}

/// Sink that writes the requested recordings. A file error is shown on the panel, and the run continues.
pub struct Recorder {
    recording: Arc<RecordingControl>,
    store: Arc<StatusStore>,
    spec: RecordSpec,
    header: Arc<Header>,
    /// File being written.
    open: Option<(PathBuf, RerunSink)>,
    /// Simulated time, s.
    time: f64,
}

impl Recorder {
    /// Creates the recorder of a run described by `header`.
    pub fn new(
        recording: Arc<RecordingControl>,
        store: Arc<StatusStore>,
        spec: RecordSpec,
        header: Arc<Header>,
    ) -> Self {
        Self {
            recording,
            store,
            spec,
            header,
            open: None,
            time: 0.0,
        }
    }

    /// Opens or closes the file as requested.
    fn update(&mut self) {
        let requested = self.recording.requested();
        if requested.as_ref() == self.open.as_ref().map(|(file, _)| file) {
            return;
        }
        self.close();
        if let Some(file) = requested {
            self.begin(file);
        }
    }

    fn begin(&mut self, file: PathBuf) {
        let reserved = self.recording.take_reserved();
        let part = reserved.map_or_else(|| PartFile::create(&file), Ok);
        let opened = part.and_then(|part| RerunSink::into_file(part, self.spec));
        let begun = opened.map_err(SinkError::from).and_then(|mut sink| {
            sink.accept(Record::Header(Arc::clone(&self.header)))?;
            Ok(sink)
        });
        match begun {
            Ok(sink) => {
                self.log(&format!("recording into {}", file.display()));
                self.store.set_recording(Some(file.display().to_string()));
                self.open = Some((file, sink));
            }
            Err(fault) => self.failed(file, fault),
        }
    }

    fn close(&mut self) {
        if let Some((file, mut sink)) = self.open.take() {
            match sink.finish() {
                Ok(()) => {
                    self.log(&format!("{} is complete", file.display()));
                    self.store.add_recording(&file);
                    self.recording.store_result(file, Ok(()));
                }
                Err(fault) => self.failed(file, fault),
            }
        }
        self.store.set_recording(None);
    }

    fn failed(&self, file: PathBuf, fault: SinkError) {
        self.recording.stop();
        self.store.set_recording(None);
        self.log(&format!("cannot write {}: {fault}", file.display()));
        self.recording.store_result(file, Err(fault));
    }

    fn log(&self, text: &str) {
        self.store.log(self.time, text);
    }
}

/// Removes the display limits: a file contains every sample.
fn undecimated(record: Record) -> Record {
    match record {
        Record::Samples(frame) => Record::Samples(Arc::new(Frame {
            shown: None,
            ..Frame::clone(&frame)
        })),
        other => other,
    }
}

impl Sink for Recorder {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        match &record {
            // Even a run that ends immediately has a recording.
            Record::Header(_) => {
                self.update();
                return Ok(());
            }
            Record::Samples(frame) => {
                self.time = frame.t0;
                self.update();
            }
            _ => {}
        }
        if let Some((file, sink)) = &mut self.open
            && let Err(fault) = sink.accept(undecimated(record))
        {
            let file = file.clone();
            self.open = None;
            self.failed(file, fault);
        }
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        true
    }

    /// Applies requests while the run is paused.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.update();
        Ok(())
    }

    /// A recording ends with its run, because the next run restarts the time.
    fn finish(&mut self) -> Result<(), SinkError> {
        self.close();
        self.recording.stop();
        Ok(())
    }
}

impl Drop for Recorder {
    /// The recording of a run that has failed.
    fn drop(&mut self) {
        if let Some((file, sink)) = self.open.take() {
            let part = sink.part().map(Path::to_owned);
            // Dropping the sink writes the index.
            drop(sink);
            let left = match part.filter(|part| part.exists()) {
                Some(part) => format!("the partial recording is readable: {}", part.display()),
                None => "nothing was saved".to_owned(),
            };
            self.recording.stop();
            self.recording
                .store_result(file, Err(format!("the run failed; {left}").into()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_unique_and_released() {
        let folder = tempfile::tempdir().unwrap();
        let recording = RecordingControl::new(folder.path().to_owned(), None);
        let first = recording.start().unwrap();
        assert_eq!(first.file_name().unwrap(), "live-1.rrd");
        assert_eq!(recording.start().unwrap(), first, "one at a time");
        // Another server with the same folder.
        let other = RecordingControl::new(folder.path().to_owned(), None);
        assert_eq!(other.start().unwrap().file_name().unwrap(), "live-2.rrd");
        recording.stop();
        other.stop();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let (saved, left) = recording.take_results();
        assert!(saved.is_empty() && left.is_none());
    }

    #[test]
    fn a_file_that_was_never_started_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let save = folder.path().join("run.rrd");
        let recording = RecordingControl::new(folder.path().to_owned(), Some(save.clone()));
        assert_eq!(recording.take_results().1, Some(save));
        assert_eq!(recording.take_results().1, None);
    }
}
