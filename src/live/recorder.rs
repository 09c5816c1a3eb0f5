//! Recording a live run into files, from when somebody asks until somebody asks again.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::panel::Board;
use crate::pipeline::message::{Frame, Header, Record};
use crate::pipeline::{Delivery, Sink, SinkError};
use crate::record::{Output, RerunSink};
use crate::scene::RecordSpec;

/// Asks for recordings, from any thread.
#[derive(Debug)]
pub struct Switch {
    folder: PathBuf,
    wanted: Mutex<Wanted>,
}

/// What is wanted of the recorder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
enum Wanted {
    /// To write nothing.
    #[default]
    Nothing,
    /// To write into a file.
    File(PathBuf),
}

impl Switch {
    /// Recordings go into a folder, with names of their own; into `first` at once if that is given.
    pub fn new(folder: PathBuf, first: Option<PathBuf>) -> Self {
        Self {
            folder,
            wanted: Mutex::new(first.map_or(Wanted::Nothing, Wanted::File)),
        }
    }

    /// Begins a recording; returns its file. One that is under way goes on.
    pub fn on(&self) -> PathBuf {
        let mut wanted = self.wanted();
        if let Wanted::File(file) = &*wanted {
            return file.clone();
        }
        let file = free_name(&self.folder);
        *wanted = Wanted::File(file.clone());
        file
    }

    /// Ends the recording.
    pub fn off(&self) {
        *self.wanted() = Wanted::Nothing;
    }

    fn wanted(&self) -> MutexGuard<'_, Wanted> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The first of `live-1.rrd`, `live-2.rrd`, ... that is not there, neither whole nor begun.
fn free_name(folder: &Path) -> PathBuf {
    let name = |k: u32| folder.join(format!("live-{k}.rrd"));
    let taken = |file: &PathBuf| file.exists() || file.with_extension("rrd.part").exists();
    (1..)
        .map(name)
        .find(|file| !taken(file))
        .unwrap_or_else(|| name(0))
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
        let wanted = self.switch.wanted().clone();
        let open = self.open.as_ref().map(|(file, _)| file);
        match wanted {
            Wanted::File(file) if open != Some(&file) => {
                self.close();
                self.begin(file);
            }
            Wanted::Nothing if open.is_some() => self.close(),
            Wanted::Nothing | Wanted::File(_) => {}
        }
    }

    fn begin(&mut self, file: PathBuf) {
        let Some(header) = self.header.clone() else {
            return;
        };
        let output = Output {
            save: Some(file.clone()),
            ..Output::default()
        };
        let opened = RerunSink::new(&output, self.spec).map_err(SinkError::from);
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
            Err(fault) => self.failed(&file, &fault),
        }
    }

    fn close(&mut self) {
        if let Some((file, mut sink)) = self.open.take() {
            match sink.finish() {
                Ok(()) => self.told(&format!("{} is whole", file.display())),
                Err(fault) => self.failed(&file, &fault),
            }
        }
        self.board.set_recording(None);
    }

    fn failed(&self, file: &Path, fault: &SinkError) {
        self.switch.off();
        self.board.set_recording(None);
        self.told(&format!("{} cannot be written: {fault}", file.display()));
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
            Record::Header(header) => self.header = Some(Arc::clone(header)),
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
            self.failed(&file, &fault);
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
        if let Some((_, mut sink)) = self.open.take() {
            sink.abandon();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free() {
        let folder = tempfile::tempdir().unwrap();
        let switch = Switch::new(folder.path().to_owned(), None);
        let first = switch.on();
        assert_eq!(first.file_name().unwrap(), "live-1.rrd");
        assert_eq!(switch.on(), first, "one at a time");
        switch.off();
        std::fs::write(&first, "").unwrap();
        std::fs::write(folder.path().join("live-2.rrd.part"), "").unwrap();
        assert_eq!(switch.on().file_name().unwrap(), "live-3.rrd");
    }
}
