//! The sink at the end of the road: owns the recording stream, its file and its viewer.

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use super::{
    audience::{Audience, ToAudience},
    blueprint, check_memory,
    encode::Encoder,
    error::RecordError,
    file_stream,
    part_file::PartFile,
    rrd_file::RrdFile,
    stream::{MessageSink, RecordingStream},
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
/// comes back, it is sent everything. Whatever becomes of it, its threads end with it; only a disk or a
/// viewer that does not answer keeps the one that waits for it.
#[derive(Debug)]
pub struct RerunSink {
    rec: RecordingStream,
    end: End,
    spec: RecordSpec,
    encoder: Option<Encoder>,
    /// When what waits for more of its kind was last sent.
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
                let rrd = file_stream::begin(&part)?;
                let feed = address.map(|address| Feed::start(part.part(), address));
                let feed = feed.transpose()?;
                End::File { part, rrd, feed }
            }
            (None, Some(address)) => End::Viewer(Live::start(address)?),
            (None, None) => return Err(RecordError::NoOutput),
        };
        Self::ending(end, spec)
    }

    /// Records into a file whose name is reserved.
    ///
    /// # Errors
    /// [`RecordError::Create`].
    pub fn into_reserved(part: PartFile, spec: RecordSpec) -> Result<Self, RecordError> {
        let rrd = file_stream::begin(&part)?;
        let feed = None;
        Self::ending(End::File { part, rrd, feed }, spec)
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
        let sink: Arc<dyn MessageSink> = match &end {
            End::File { rrd, .. } => Arc::new(rrd.writer()),
            End::Viewer(live) => Arc::new(live.clone()),
            End::Audience(audience) => Arc::new(audience.clone()),
        };
        Ok(Self {
            rec: RecordingStream::new(APPLICATION, sink)?,
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

    /// A broken stream is never touched again, not even to flush it.
    fn or_broken(&mut self, result: Result<(), RecordError>) -> Result<(), SinkError> {
        if result.is_err() {
            self.encoder = None;
        }
        Ok(result?)
    }

    fn start(&mut self, header: &Arc<Header>) -> Result<(), RecordError> {
        let header = Arc::new(shown(header));
        blueprint::send(&self.rec, &header, self.spec)?;
        self.encoder = Some(Encoder::new(&self.rec, header, self.spec)?);
        Ok(())
    }

    fn take(&mut self, record: &Record) -> Result<(), RecordError> {
        if let Record::Header(header) = record {
            return self.start(header);
        }
        let encoder = self.encoder.as_mut().ok_or(RecordError::NoHeader)?;
        encoder.accept(&self.rec, record)?;
        self.send_due()
    }

    /// Sends what has waited long enough, and looks now and then whether it arrives.
    fn send_due(&mut self) -> Result<(), RecordError> {
        if let Some(encoder) = &mut self.encoder
            && self.sent.elapsed() >= file_stream::lag(self.end.is_watched())
        {
            encoder.send_waiting(&self.rec)?;
            self.rec.send_waiting()?;
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
            End::File { part, rrd, .. } => file_stream::flush(&self.rec, rrd, part),
            End::Audience(_) => self.rec.send_waiting(),
            End::Viewer(live) => self.rec.send_waiting().and_then(|()| live.flush()),
        };
        self.flushed = Instant::now();
        result
    }

    /// Sends what waits, and closes the file; its index is written then.
    fn end_stream(&mut self) -> Result<(), RecordError> {
        if let Some(mut encoder) = self.encoder.take() {
            encoder.finish(&self.rec)?;
        }
        match &mut self.end {
            End::File { part, rrd, .. } => file_stream::seal(&self.rec, rrd, part),
            End::Viewer(_) | End::Audience(_) => self.flush(),
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
    }
}

impl Sink for RerunSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let taken = self.take(&record);
        self.or_broken(taken)
    }

    /// What waits for more of its kind is seen although none comes.
    fn idle(&mut self) -> Result<(), SinkError> {
        let sent = self.send_due();
        self.or_broken(sent)
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
