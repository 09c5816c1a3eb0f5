//! The sink for recordings: it owns the recording stream, the file and the connection to the viewer.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::encode::Encoder;
use super::error::RecordError;
use super::file::RecordingFile;
use super::part_file::PartFile;
use super::stream::{MessageSink, RecordingStream};
use super::viewer::{self, Feed, LiveConnection};
use super::{blueprint, check_memory};
use crate::escape;
use crate::pipeline::message::{Header, Record, Subject};
use crate::pipeline::{Sink, SinkError};
use crate::scene::RecordSpec;

/// Application id: recordings with the same id share their layout in the viewer.
pub const APPLICATION: &str = "squeakscope";
/// Maximum wall time that rows wait for a larger batch while a viewer is connected: short, so that views
/// agree.
const WATCHED: Duration = Duration::from_millis(30);
/// The same for a file without a viewer. The file must be readable to within a second of its end at any time.
/// Rows of this time share a chunk; each chunk has an entry in the index, which takes about 6 kB of memory
/// until the end of the file.
const UNWATCHED: Duration = Duration::from_millis(800);
/// Wall time between flushes, which detect errors of the disk or the viewer.
const FLUSH_EVERY: Duration = Duration::from_millis(800);

/// Destinations of a recording; a file and a viewer can be combined.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Output {
    /// File to save to, `.rrd`.
    pub save: Option<PathBuf>,
    /// Address of a running viewer, such as `rerun+http://127.0.0.1:9876/proxy`.
    pub connect: Option<String>,
    /// Whether to start a viewer on this machine (`rerun` must be on the `PATH`).
    pub spawn: bool,
}

/// Writes records as a Rerun recording.
///
/// The file appears under its name only after [`Sink::finish`], also after an interrupted run. If a file is
/// saved, the viewer receives its data from the file: the run continues when the viewer disconnects, and a
/// viewer that reconnects receives everything. All threads end with the sink, except the one that waits for a
/// disk or a viewer that does not respond.
#[derive(Debug)]
pub struct RerunSink {
    rec: RecordingStream,
    destination: Destination,
    spec: RecordSpec,
    encoder: Option<Encoder>,
    /// Wall time at which pending rows were last sent.
    sent: Instant,
    flushed: Instant,
    notice: Notice,
    /// Whether the loss of the viewer was reported.
    reported_away: bool,
}

/// The destination of a recording.
#[derive(Debug)]
enum Destination {
    File {
        file: RecordingFile,
        feed: Option<Feed>,
    },
    Viewer(LiveConnection),
}

impl Destination {
    fn feed(&self) -> Option<&Feed> {
        match self {
            Self::File { feed, .. } => feed.as_ref(),
            Self::Viewer(_) => None,
        }
    }

    /// Maximum wall time that rows wait for a larger batch.
    fn lag(&self) -> Duration {
        match self {
            Self::File { feed: None, .. } => UNWATCHED,
            Self::File { .. } | Self::Viewer(_) => WATCHED,
        }
    }
}

/// Callback for notices to the user.
struct Notice(Box<dyn Fn(&str) + Send>);

impl fmt::Debug for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Notice")
    }
}

impl RerunSink {
    /// Path of the part file; `None` without a file.
    pub fn part(&self) -> Option<&Path> {
        match &self.destination {
            Destination::File { file, .. } => Some(file.part.part()),
            Destination::Viewer(_) => None,
        }
    }

    /// Opens the file and connects to the viewer; an existing recording is not changed yet.
    ///
    /// # Errors
    /// [`RecordError::NoOutput`], [`RecordError::Memory`], [`RecordError::Create`], [`RecordError::Address`],
    /// [`RecordError::Spawn`], [`RecordError::Viewer`].
    pub fn new(output: &Output, spec: RecordSpec) -> Result<Self, RecordError> {
        check_memory()?;
        // The viewer first, so that no part file is created if it is missing.
        let address = match &output.connect {
            Some(url) => Some(viewer::reachable(url)?),
            None if output.spawn => Some(viewer::spawn()?),
            None => None,
        };
        let end = match (&output.save, address) {
            (Some(path), address) => {
                let file = RecordingFile::begin(PartFile::create(path)?)?;
                let feed = address.map(|address| Feed::start(file.part.part(), address));
                let feed = feed.transpose()?;
                Destination::File { file, feed }
            }
            (None, Some(address)) => Destination::Viewer(LiveConnection::start(address)?),
            (None, None) => return Err(RecordError::NoOutput),
        };
        Ok(Self::with_destination(end, spec))
    }

    /// Records into a part file.
    ///
    /// # Errors
    /// [`RecordError::Memory`], or [`RecordError::Create`] if the file cannot be written.
    pub fn into_file(part: PartFile, spec: RecordSpec) -> Result<Self, RecordError> {
        if let Err(fault) = check_memory() {
            part.abandon();
            return Err(fault);
        }
        let file = RecordingFile::begin(part)?;
        let destination = Destination::File { file, feed: None };
        Ok(Self::with_destination(destination, spec))
    }

    fn with_destination(destination: Destination, spec: RecordSpec) -> Self {
        let sink: Arc<dyn MessageSink> = match &destination {
            Destination::File { file, .. } => Arc::new(file.writer()),
            Destination::Viewer(live) => Arc::new(live.clone()),
        };
        Self {
            rec: RecordingStream::new(APPLICATION, sink),
            destination,
            spec,
            encoder: None,
            sent: Instant::now(),
            flushed: Instant::now(),
            notice: Notice(Box::new(|_| ())),
            reported_away: false,
        }
    }

    /// Sets a callback for one-line notices that are not errors: loss and return of the viewer.
    #[must_use]
    pub fn with_notice(mut self, notice: impl Fn(&str) + Send + 'static) -> Self {
        self.notice = Notice(Box::new(notice));
        self
    }

    /// Reports the loss and the return of the viewer.
    fn report_viewer_status(&mut self) {
        let Some(feed) = self.destination.feed() else {
            return;
        };
        let (url, away) = (feed.url(), feed.is_away());
        if away == self.reported_away {
            return;
        }
        (self.notice.0)(&if away {
            format!(
                "the viewer at {url} disconnected; the run continues to save the file, and a viewer that \
                 reconnects there receives everything"
            )
        } else {
            format!("the viewer at {url} has reconnected")
        });
        self.reported_away = away;
    }

    /// Drops the encoder after an error, so that the failed stream is not used again.
    fn stop_after_error(&mut self, result: Result<(), RecordError>) -> Result<(), SinkError> {
        if result.is_err() {
            self.encoder = None;
        }
        Ok(result?)
    }

    fn start(&mut self, header: &Arc<Header>) {
        let header = Arc::new(shown(header));
        blueprint::send(&self.rec, &header, self.spec, 0);
        self.encoder = Some(Encoder::new(&self.rec, header, self.spec));
    }

    fn take(&mut self, record: &Record) -> Result<(), RecordError> {
        if let Record::Header(header) = record {
            self.start(header);
        }
        let encoder = self.encoder.as_mut().ok_or(RecordError::NoHeader)?;
        encoder.accept(&self.rec, record);
        self.send_due()
    }

    /// Sends rows that have waited long enough, and flushes regularly.
    fn send_due(&mut self) -> Result<(), RecordError> {
        if let Some(encoder) = &mut self.encoder
            && self.sent.elapsed() >= self.destination.lag()
        {
            encoder.send_pending(&self.rec);
            self.rec.send_pending()?;
            self.sent = Instant::now();
            self.report_viewer_status();
        }
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes all pending data and returns write errors, which logging does not report.
    fn flush(&mut self) -> Result<(), RecordError> {
        let result = match &self.destination {
            Destination::File { file, .. } => file.flush(&self.rec),
            Destination::Viewer(live) => self.rec.send_pending().and_then(|()| live.flush()),
        };
        self.flushed = Instant::now();
        result
    }

    /// Sends pending rows and closes the file with its index.
    fn close_stream(&mut self) -> Result<(), RecordError> {
        if let Some(mut encoder) = self.encoder.take() {
            encoder.finish(&self.rec);
        }
        match &mut self.destination {
            Destination::File { file, .. } => file.seal(&self.rec),
            Destination::Viewer(_) => self.flush(),
        }
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.close_stream()?;
        match &self.destination {
            Destination::File { file, feed } => {
                // Before the viewer is served, because that can take time and the user can interrupt it.
                file.part.commit()?;
                let Some(feed) = feed else {
                    return Ok(());
                };
                let (report, url) = (&self.notice.0, feed.url());
                let waiting = || {
                    report(&format!(
                        "the file is complete; the viewer at {url} is still receiving data; press \
                         Ctrl-C twice to stop waiting"
                    ));
                };
                let served = feed.drain(waiting);
                if !served && !self.reported_away {
                    report(&format!(
                        "the viewer at {url} was closed or does not respond; the file is complete"
                    ));
                    self.reported_away = true;
                }
            }
            Destination::Viewer(live) => live.close()?,
        }
        self.report_viewer_status();
        Ok(())
    }
}

/// The header with control characters in its names escaped. The text of the scene is unchanged.
fn shown(header: &Header) -> Header {
    let mut header = header.clone();
    let mut names = vec![&mut header.scene, &mut header.title];
    match &mut header.subject {
        Subject::Joint(joint) => names.push(&mut joint.body),
        Subject::Small(_) => {}
        Subject::Signal(signal) => {
            names.extend([&mut signal.source, &mut signal.column, &mut signal.unit]);
        }
    }
    for name in names {
        *name = escape::line(name);
    }
    header
}

impl Drop for RerunSink {
    /// A run that failed elsewhere does not call `finish`; its part file still receives all pending data.
    fn drop(&mut self) {
        if self.encoder.is_some() {
            // The error that caused the drop is reported instead.
            let _ = self.close_stream();
        }
        if let Some(feed) = self.destination.feed() {
            feed.end();
        }
    }
}

impl Sink for RerunSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let taken = self.take(&record);
        self.stop_after_error(taken)
    }

    /// Sends pending rows when no further records arrive.
    fn idle(&mut self) -> Result<(), SinkError> {
        let sent = self.send_due();
        self.stop_after_error(sent)
    }

    fn may_skip_pictures(&self) -> bool {
        matches!(self.destination, Destination::Viewer(_))
    }

    /// Sends pending rows, closes the file and renames it.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(self.close()?)
    }
}
