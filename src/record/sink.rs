//! The sink at the end of the road: owns the recording stream, its file and its viewer.

use std::{
    fmt,
    mem::{self, ManuallyDrop},
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use rerun::{RecordingStream, sink::LogSink};

use super::{
    audience::{Audience, ToAudience},
    blueprint, check_memory,
    encode::Encoder,
    error::RecordError,
    file_stream,
    part_file::PartFile,
    rrd_file::RrdFile,
    viewer::{self, Feed, Live},
};
use crate::{
    escape,
    pipeline::{
        Delivery, Sink, SinkError,
        message::{Header, Record, Subject},
    },
    scene::RecordSpec,
};

/// Application name: recordings of one application share their blueprint in the viewer.
pub const APPLICATION: &str = "squeakscope";
/// Wall time between flushes: faults of disk or viewer are noticed after this long.
const FLUSH_EVERY: Duration = Duration::from_millis(800);
/// How long a flush to a viewer may take: that it is stuck is told by its own thread, much earlier.
const FOREVER: Duration = Duration::from_secs(24 * 3600);

/// Where a recording goes; file and viewer may be given together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Output {
    /// File to save to, `.rrd`.
    pub save: Option<PathBuf>,
    /// Address of a running viewer, such as `rerun+http://127.0.0.1:9876/proxy`.
    pub connect: Option<String>,
    /// Whether to start a viewer on this machine (it must be on the `PATH`).
    pub spawn: bool,
}

/// Writes records as a Rerun recording.
///
/// The file appears under its name only after [`Sink::finish`], which an interrupted run calls
/// too. A viewer is fed from the file where there is one: if it goes, the run goes on, and if it
/// comes back, it is sent everything. After a failure the stream is leaked on purpose: dropping it
/// waits for a disk or viewer that may never answer.
#[derive(Debug)]
pub struct RerunSink {
    rec: ManuallyDrop<RecordingStream>,
    end: End,
    spec: RecordSpec,
    encoder: Option<Encoder>,
    /// When samples were last sent without waiting for more of them.
    sent: Instant,
    flushed: Instant,
    notice: Notice,
    /// Whether it has been told that the viewer is away.
    told_away: bool,
}

/// Where a recording ends.
#[derive(Debug)]
enum End {
    File {
        part: PartFile,
        rrd: RrdFile,
        feed: Option<Feed>,
    },
    Viewer(Live),
    Audience(ToAudience),
}

impl End {
    fn feed(&self) -> Option<&Feed> {
        match self {
            Self::File { feed, .. } => feed.as_ref(),
            Self::Viewer(_) | Self::Audience(_) => None,
        }
    }

    fn is_watched(&self) -> bool {
        match self {
            Self::File { feed, .. } => feed.is_some(),
            Self::Viewer(_) | Self::Audience(_) => true,
        }
    }
}

/// Takes words for whoever started the run.
struct Notice(Box<dyn Fn(&str) + Send>);

impl fmt::Debug for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Notice")
    }
}

impl RerunSink {
    /// Where the recording is until it is whole; `None` without a file.
    pub fn part(&self) -> Option<&Path> {
        match &self.end {
            End::File { part, .. } => Some(part.part()),
            End::Viewer(_) | End::Audience(_) => None,
        }
    }

    /// Opens file and viewer; nothing that exists is changed yet.
    ///
    /// # Errors
    /// [`RecordError::NoOutput`], [`RecordError::Memory`], [`RecordError::Create`], [`RecordError::Address`],
    /// [`RecordError::Spawn`], [`RecordError::Viewer`].
    pub fn new(output: &Output, spec: RecordSpec) -> Result<Self, RecordError> {
        if *output == Output::default() {
            return Err(RecordError::NoOutput);
        }
        check_memory()?;
        // The viewer first: if it is missing, not even a part file is made.
        let address = match &output.connect {
            Some(url) => Some(viewer::reachable(url)?),
            None if output.spawn => Some(viewer::spawn()?),
            None => None,
        };
        let end = match (&output.save, address) {
            (Some(path), address) => {
                let part = PartFile::create(path)?;
                let rrd = file_stream::sink(&part)?;
                let feed = address.map(|address| Feed::start(part.part(), address));
                let feed = feed.transpose()?;
                End::File { part, rrd, feed }
            }
            (None, Some(address)) => End::Viewer(Live::start(address)?),
            (None, None) => return Err(RecordError::NoOutput),
        };
        Self::ending(end, spec)
    }

    /// Hands the recording to an audience; nothing is kept.
    ///
    /// # Errors
    /// [`RecordError::Memory`]; [`RecordError::Encode`] if no stream can be opened.
    pub fn for_audience(
        audience: Arc<dyn Audience>,
        spec: RecordSpec,
    ) -> Result<Self, RecordError> {
        check_memory()?;
        Self::ending(End::Audience(ToAudience(audience)), spec)
    }

    fn ending(end: End, spec: RecordSpec) -> Result<Self, RecordError> {
        let sink: Box<dyn LogSink> = match &end {
            End::File { rrd, .. } => Box::new(rrd.clone()),
            End::Viewer(live) => Box::new(live.clone()),
            End::Audience(audience) => Box::new(audience.clone()),
        };
        let rec = file_stream::open(APPLICATION, sink, end.is_watched())?;
        Ok(Self {
            rec: ManuallyDrop::new(rec),
            end,
            spec,
            encoder: None,
            sent: Instant::now(),
            flushed: Instant::now(),
            notice: Notice(Box::new(|_| ())),
            told_away: false,
        })
    }

    /// Tells `notice` in a line what happens that is no error: that the viewer has gone or is back.
    #[must_use]
    pub fn with_notice(mut self, notice: impl Fn(&str) + Send + 'static) -> Self {
        self.notice = Notice(Box::new(notice));
        self
    }

    /// Whether the viewer has gone while the recording is being saved.
    pub fn viewer_lost(&self) -> bool {
        self.end.feed().is_some_and(Feed::is_away)
    }

    /// Tells when the viewer goes and when it is back.
    fn look_after_viewer(&mut self) {
        let Some(feed) = self.end.feed() else {
            return;
        };
        let (url, away) = (feed.url(), feed.is_away());
        if away == self.told_away {
            return;
        }
        (self.notice.0)(&match away {
            true => format!(
                "the viewer at {url} has gone; the run goes on into the file, and a viewer that is \
                 back there is sent everything"
            ),
            false => format!("the viewer at {url} is back"),
        });
        self.told_away = away;
    }

    fn start(&mut self, header: &Header) -> Result<(), RecordError> {
        let header = Arc::new(shown(header));
        blueprint::send(&self.rec, &header, self.spec)?;
        self.encoder = Some(Encoder::new(&self.rec, header, self.spec)?);
        Ok(())
    }

    fn take(&mut self, record: &Record) -> Result<(), RecordError> {
        if let Record::Header(header) = record {
            return self.start(header);
        }
        let patience = file_stream::lag(self.end.is_watched());
        let encoder = self.encoder.as_mut().ok_or(RecordError::NoHeader)?;
        encoder.accept(&self.rec, record)?;
        if self.sent.elapsed() >= patience {
            encoder.send_waiting(&self.rec)?;
            self.sent = Instant::now();
            self.look_after_viewer();
        }
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flush()?;
        }
        Ok(())
    }

    /// Pushes everything out, and learns of faults: logging itself never reports one.
    fn flush(&mut self) -> Result<(), RecordError> {
        let result = match &self.end {
            End::File { part, .. } => file_stream::flush(&self.rec, part),
            End::Audience(_) => Ok(()),
            End::Viewer(live) => {
                let flushed = self.rec.flush_with_timeout(FOREVER);
                match live.fault() {
                    Some(fault) => Err(fault),
                    None => flushed.map_err(|error| RecordError::Encode(error.to_string())),
                }
            }
        };
        self.flushed = Instant::now();
        result
    }

    /// Sends what waits, and closes the file; its index is written then.
    fn end_stream(&mut self) -> Result<(), RecordError> {
        if let Some(mut encoder) = self.encoder.take() {
            encoder.finish(&self.rec)?;
        }
        match &self.end {
            End::File { part, rrd, .. } => file_stream::seal(&self.rec, rrd, part),
            End::Viewer(_) => self.flush(),
            // Nobody waits, but what the stream holds back is to be heard.
            End::Audience(_) => {
                let flushed = self.rec.flush_with_timeout(FOREVER);
                flushed.map_err(|error| RecordError::Encode(error.to_string()))
            }
        }
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.end_stream()?;
        match &self.end {
            End::File { part, feed, .. } => {
                // First of all: a viewer may take its time, and whoever waits for it may lose patience.
                part.keep()?;
                let Some(feed) = feed else {
                    return Ok(());
                };
                let (tell, url) = (&self.notice.0, feed.url());
                let waiting = || {
                    tell(&format!(
                        "all is in the file; the viewer at {url} is still taking it in; Ctrl-C, twice, \
                         ends the wait"
                    ));
                };
                let served = feed.drain(waiting);
                if !served && !self.told_away {
                    tell(&format!(
                        "the viewer at {url} was closed or takes nothing any more; all is in the file"
                    ));
                    self.told_away = true;
                }
            }
            End::Viewer(live) => live.close()?,
            End::Audience(_) => {}
        }
        self.look_after_viewer();
        Ok(())
    }
}

/// A header whose names are safe as names of series, views and columns. The scene's text stays as it is.
fn shown(header: &Header) -> Header {
    let mut header = header.clone();
    let names = match &mut header.subject {
        Subject::Joint(joint) => vec![&mut joint.body],
        Subject::Small(_) => Vec::new(),
        Subject::Signal(signal) => {
            vec![&mut signal.source, &mut signal.column, &mut signal.unit]
        }
    };
    for name in names
        .into_iter()
        .chain([&mut header.scene, &mut header.title])
    {
        *name = escape::line(name).into_owned();
    }
    header
}

impl Drop for RerunSink {
    /// A run that failed elsewhere never calls `finish`: its part file still gets all there is.
    fn drop(&mut self) {
        if self.encoder.is_some() {
            // The run already has an error to report, and this one could tell nothing more.
            let _ = self.end_stream();
        }
        if let Some(feed) = self.end.feed() {
            feed.end();
        }
        // An audience never holds up anything, so that the stream's threads can be waited for.
        if matches!(self.end, End::Audience(_)) {
            let rec = ManuallyDrop::new(RecordingStream::disabled());
            drop(ManuallyDrop::into_inner(mem::replace(&mut self.rec, rec)));
        }
    }
}

impl Sink for RerunSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let result = self.take(&record);
        if result.is_err() {
            // A broken stream is never touched again, not even to flush it.
            self.encoder = None;
        }
        Ok(result?)
    }

    fn delivery(&self) -> Delivery {
        match self.end {
            End::File { .. } => Delivery::Everything,
            End::Viewer(_) | End::Audience(_) => Delivery::LatestPictures,
        }
    }

    /// Sends what waits, closes the file and gives it its name.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(self.close()?)
    }
}
