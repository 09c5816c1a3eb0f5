//! Recording a live run into files, from when somebody asks until somebody asks again.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::panel::Board;
use crate::pipeline::message::{Frame, Header, Record};
use crate::pipeline::{Delivery, Sink, SinkError};
use crate::record::{Output, PartFile, RecordError, RerunSink};
use crate::scene::RecordSpec;

/// Asks for recordings, from any thread.
#[derive(Debug)]
pub struct Switch {
    folder: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// The file to write into; nothing is written without one.
    wanted: Option<Wanted>,
    saved: Vec<SavedFile>,
}

#[derive(Debug)]
struct Wanted {
    file: PathBuf,
    /// A name of the folder, until the recorder takes it.
    reserved: Option<PartFile>,
}

/// What has become of a file that was asked for.
#[derive(Debug)]
pub struct SavedFile {
    /// Its path.
    pub path: PathBuf,
    /// Whether it was begun at all.
    pub begun: bool,
    /// Whether all of it is there, and if not, why.
    pub outcome: Result<(), SinkError>,
}

impl SavedFile {
    /// A file that was not even begun.
    pub fn never_begun(path: PathBuf) -> Self {
        let outcome =
            Err("the run ended before it could be begun, so that there is nothing".into());
        Self {
            path,
            begun: false,
            outcome,
        }
    }
}

impl Switch {
    /// Recordings go into a folder, with names of their own; into `first` at once if that is given.
    pub fn new(folder: PathBuf, first: Option<PathBuf>) -> Self {
        let wanted = first.map(|file| Wanted {
            file,
            reserved: None,
        });
        let state = State {
            wanted,
            ..State::default()
        };
        Self {
            folder,
            state: Mutex::new(state),
        }
    }

    /// Begins a recording; returns its file, whose name nobody else is given. One that is under way goes on.
    ///
    /// # Errors
    /// When no file can be made in the folder.
    pub fn on(&self) -> Result<PathBuf, RecordError> {
        let mut state = self.state();
        if let Some(wanted) = &state.wanted {
            return Ok(wanted.file.clone());
        }
        let names = (1..=u32::MAX).map(|k| self.folder.join(format!("live-{k}.rrd")));
        let reserved = PartFile::reserve(names)?;
        let file = reserved.path().to_owned();
        state.wanted = Some(Wanted {
            file: file.clone(),
            reserved: Some(reserved),
        });
        Ok(file)
    }

    /// Ends the recording.
    pub fn off(&self) {
        if let Some(reserved) = self
            .state()
            .wanted
            .take()
            .and_then(|wanted| wanted.reserved)
        {
            reserved.discard();
        }
    }

    /// Notes what has become of a file.
    pub fn note(&self, path: PathBuf, outcome: Result<(), SinkError>) {
        self.state().saved.push(SavedFile {
            path,
            begun: true,
            outcome,
        });
    }

    /// What has become of the files since this was last asked, once there is no run any more.
    pub fn take_saved(&self) -> Vec<SavedFile> {
        let mut state = self.state();
        let mut saved = std::mem::take(&mut state.saved);
        let left = state.wanted.take().map(|wanted| match wanted.reserved {
            Some(reserved) => reserved.discard(),
            None => wanted.file,
        });
        saved.extend(left.map(SavedFile::never_begun));
        saved
    }

    fn wanted(&self) -> Option<PathBuf> {
        self.state()
            .wanted
            .as_ref()
            .map(|wanted| wanted.file.clone())
    }

    fn take_reserved(&self) -> Option<PartFile> {
        self.state().wanted.as_mut()?.reserved.take()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes what the switch asks for. A file that cannot be written is told on the board; the run goes on.
pub struct Recorder {
    switch: Arc<Switch>,
    board: Arc<Board>,
    spec: RecordSpec,
    header: Option<Arc<Header>>,
    /// The file being written.
    open: Option<(PathBuf, RerunSink)>,
    /// Simulated time, s.
    time: f64,
}

impl Recorder {
    /// Writes recordings of a run.
    pub fn new(switch: Arc<Switch>, board: Arc<Board>, spec: RecordSpec) -> Self {
        Self {
            switch,
            board,
            spec,
            header: None,
            open: None,
            time: 0.0,
        }
    }

    /// Opens or closes the file, as is wanted now.
    fn follow(&mut self) {
        let wanted = self.switch.wanted();
        if wanted.as_ref() == self.open.as_ref().map(|(file, _)| file) {
            return;
        }
        self.close();
        if let Some(file) = wanted {
            self.begin(file);
        }
    }

    fn begin(&mut self, file: PathBuf) {
        let Some(header) = self.header.clone() else {
            return;
        };
        let opened = match self.switch.take_reserved() {
            Some(reserved) => RerunSink::into_reserved(reserved, self.spec),
            None => {
                let output = Output {
                    save: Some(file.clone()),
                    ..Output::default()
                };
                RerunSink::new(&output, self.spec)
            }
        };
        let opened = opened.map_err(SinkError::from);
        let begun = opened.and_then(|mut sink| {
            sink.accept(Record::Header(header))?;
            Ok(sink)
        });
        match begun {
            Ok(sink) => {
                self.told(&format!("records into {}", file.display()));
                self.board.set_recording(Some(file.display().to_string()));
                self.open = Some((file, sink));
            }
            Err(fault) => self.failed(file, fault),
        }
    }

    fn close(&mut self) {
        if let Some((file, mut sink)) = self.open.take() {
            match sink.finish() {
                Ok(()) => {
                    self.told(&format!("{} is whole", file.display()));
                    self.switch.note(file, Ok(()));
                }
                Err(fault) => self.failed(file, fault),
            }
        }
        self.board.set_recording(None);
    }

    fn failed(&self, file: PathBuf, fault: SinkError) {
        self.switch.off();
        self.board.set_recording(None);
        self.told(&format!("{} cannot be written: {fault}", file.display()));
        self.switch.note(file, Err(fault));
    }

    fn told(&self, words: &str) {
        self.board.tell(self.time, words);
    }
}

/// A file keeps every sample, whatever a screen can show.
fn whole(record: Record) -> Record {
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
            // A run that ends at once has a recording, too.
            Record::Header(header) => {
                self.header = Some(Arc::clone(header));
                self.follow();
                return Ok(());
            }
            Record::Samples(frame) => {
                self.time = frame.t0;
                self.follow();
            }
            _ => {}
        }
        if let Some((file, sink)) = &mut self.open
            && let Err(fault) = sink.accept(whole(record))
        {
            let file = file.clone();
            self.open = None;
            self.failed(file, fault);
        }
        Ok(())
    }

    fn delivery(&self) -> Delivery {
        Delivery::LatestPictures
    }

    /// What is asked for while time stands still is done then.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.follow();
        Ok(())
    }

    /// A recording ends with its run: the next one has another time.
    fn finish(&mut self) -> Result<(), SinkError> {
        self.close();
        self.switch.off();
        Ok(())
    }

    fn abandon(&mut self) {
        if let Some((file, mut sink)) = self.open.take() {
            sink.abandon();
            let part = sink.part().map(Path::to_owned);
            // It gets its index.
            drop(sink);
            let left = match part.filter(|part| part.exists()) {
                Some(part) => format!(
                    "what was recorded until then can be opened: {}",
                    part.display()
                ),
                None => "nothing is left of it".to_owned(),
            };
            self.switch.off();
            self.switch
                .note(file, Err(format!("the run failed; {left}").into()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free_and_given_back() {
        let folder = tempfile::tempdir().unwrap();
        let switch = Switch::new(folder.path().to_owned(), None);
        let first = switch.on().unwrap();
        assert_eq!(first.file_name().unwrap(), "live-1.rrd");
        assert_eq!(switch.on().unwrap(), first, "one at a time");
        // Another server with the same folder.
        let other = Switch::new(folder.path().to_owned(), None);
        assert_eq!(other.on().unwrap().file_name().unwrap(), "live-2.rrd");
        switch.off();
        other.off();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(switch.take_saved().is_empty());
    }

    #[test]
    fn what_was_never_begun_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let save = folder.path().join("run.rrd");
        let switch = Switch::new(folder.path().to_owned(), Some(save.clone()));
        let saved = switch.take_saved();
        assert!(
            saved[0].path == save && saved[0].outcome.is_err(),
            "{saved:?}"
        );
        assert!(switch.take_saved().is_empty());
    }
}
