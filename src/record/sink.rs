//! The sink at the end of the road: owns the recording stream, its file and its viewer.

use std::{
    mem::ManuallyDrop,
    net::{TcpStream, ToSocketAddrs},
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use rerun::{
    RecordingStream, SpawnOptions,
    external::re_uri::ProxyUri,
    sink::{GrpcSink, LogSink},
};

use super::{
    blueprint,
    encode::Encoder,
    error::RecordError,
    file_stream::{self, FLUSH_PATIENCE},
    outlet::{FileAndViewer, VIEWER_PATIENCE, ViewerLost},
    part_file::PartFile,
};
use crate::{
    pipeline::{
        Delivery, Sink, SinkError,
        message::{Header, Record},
    },
    scene::RecordSpec,
};

/// Application name: recordings of one application share their blueprint in the viewer.
pub const APPLICATION: &str = "squeakscope";
/// Wall time between flushes: faults of disk or viewer are noticed after this long.
const FLUSH_EVERY: Duration = Duration::from_millis(800);
/// How long to wait for a viewer's port.
const CONNECT_PATIENCE: Duration = Duration::from_secs(2);

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
/// too. After a failure the stream is leaked on purpose: dropping it waits for a disk or viewer
/// that may never answer.
#[derive(Debug)]
pub struct RerunSink {
    rec: ManuallyDrop<RecordingStream>,
    file: Option<PartFile>,
    viewer: Option<String>,
    lost: ViewerLost,
    spec: RecordSpec,
    encoder: Option<Encoder>,
    /// When samples were last sent without waiting for more of them.
    sent: Instant,
    flushed: Instant,
}

impl RerunSink {
    /// Opens file and viewer; nothing that exists is changed yet.
    ///
    /// # Errors
    /// [`RecordError::NoOutput`], [`RecordError::Create`], [`RecordError::Address`],
    /// [`RecordError::Spawn`], [`RecordError::Viewer`].
    pub fn new(output: &Output, spec: RecordSpec) -> Result<Self, RecordError> {
        if *output == Output::default() {
            return Err(RecordError::NoOutput);
        }
        // The viewer first: if it is missing, not even a part file is made.
        let address = match &output.connect {
            Some(url) => Some(reachable(url)?),
            None if output.spawn => Some(spawn()?),
            None => None,
        };
        let file = output.save.as_deref().map(PartFile::create).transpose()?;
        let lost = ViewerLost::default();
        let viewer = address.as_ref().map(ToString::to_string);
        let file_sink = file.as_ref().map(file_stream::sink).transpose()?;
        let sink: Box<dyn LogSink> = match (file_sink, address.map(GrpcSink::new)) {
            (Some(file), Some(viewer)) => Box::new(FileAndViewer {
                file,
                viewer,
                lost: lost.clone(),
            }),
            (Some(file), None) => Box::new(file),
            (None, Some(viewer)) => Box::new(viewer),
            (None, None) => return Err(RecordError::NoOutput),
        };
        Ok(Self {
            rec: ManuallyDrop::new(file_stream::open(APPLICATION, sink, viewer.is_some())?),
            file,
            viewer,
            lost,
            spec,
            encoder: None,
            sent: Instant::now(),
            flushed: Instant::now(),
        })
    }

    /// Whether the viewer has gone while the recording is being saved.
    pub fn viewer_lost(&self) -> bool {
        self.lost.get()
    }

    fn start(&mut self, header: &Arc<Header>) -> Result<(), RecordError> {
        blueprint::send(&self.rec, header, self.spec)?;
        self.encoder = Some(Encoder::new(&self.rec, Arc::clone(header), self.spec)?);
        Ok(())
    }

    fn take(&mut self, record: &Record) -> Result<(), RecordError> {
        if let Record::Header(header) = record {
            return self.start(header);
        }
        let patience = file_stream::lag(self.viewer.is_some());
        let encoder = self.encoder.as_mut().ok_or(RecordError::NoHeader)?;
        encoder.accept(&self.rec, record)?;
        if self.sent.elapsed() >= patience {
            encoder.send_waiting(&self.rec)?;
            self.sent = Instant::now();
        }
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flush()?;
        }
        Ok(())
    }

    /// Pushes everything out, and learns of faults: logging itself never reports one.
    fn flush(&mut self) -> Result<(), RecordError> {
        let patience = if self.file.is_some() {
            FLUSH_PATIENCE
        } else {
            VIEWER_PATIENCE
        };
        let result = self.rec.flush_with_timeout(patience);
        self.flushed = Instant::now();
        result.map_err(|error| match &self.file {
            Some(file) => file.write_error(error.to_string()),
            // Rerun's own words for this suspect a fault of its own.
            None => self.viewer_error("it was closed or no longer answers".to_owned()),
        })
    }

    fn viewer_error(&self, reason: String) -> RecordError {
        RecordError::Viewer {
            url: self.viewer.clone().unwrap_or_default(),
            reason,
            saved: self.file.as_ref().map(|file| file.path().to_owned()),
        }
    }

    /// Sends what waits, and closes the file; its index is written then.
    fn end_stream(&mut self) -> Result<(), RecordError> {
        if let Some(mut encoder) = self.encoder.take() {
            encoder.finish(&self.rec)?;
        }
        self.flush()?;
        let Some(file) = &self.file else {
            return Ok(());
        };
        file_stream::seal(&self.rec, file)
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.end_stream()?;
        if let Some(file) = &self.file {
            file.keep()?;
        }
        if self.lost.get() {
            return Err(self.viewer_error("it was closed during the run".to_owned()));
        }
        Ok(())
    }
}

impl Drop for RerunSink {
    /// A run that failed elsewhere never calls `finish`: its part file still gets all there is.
    fn drop(&mut self) {
        if self.encoder.is_some() {
            // The run already has an error to report, and this one could tell nothing more.
            let _ = self.end_stream();
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
        if self.file.is_some() {
            Delivery::Everything
        } else {
            Delivery::LatestPictures
        }
    }

    /// Sends what waits, closes the file and gives it its name.
    fn finish(&mut self) -> Result<(), SinkError> {
        Ok(self.close()?)
    }
}

/// Reads a viewer's address and makes sure that something listens there.
fn reachable(url: &str) -> Result<ProxyUri, RecordError> {
    let address: ProxyUri = url.parse().map_err(|error| RecordError::Address {
        url: url.to_owned(),
        reason: format!("{error}"),
    })?;
    let host = address.origin.host.to_string();
    let found = (host.trim_matches(['[', ']']), address.origin.port).to_socket_addrs();
    let fault = |error: std::io::Error| RecordError::Viewer {
        url: url.to_owned(),
        reason: error.to_string(),
        saved: None,
    };
    let mut result = Err(fault(std::io::ErrorKind::AddrNotAvailable.into()));
    for socket in found.map_err(fault)? {
        match TcpStream::connect_timeout(&socket, CONNECT_PATIENCE) {
            Ok(_) => return Ok(address),
            Err(error) => result = Err(fault(error)),
        }
    }
    result
}

/// Starts a viewer and gives its address.
fn spawn() -> Result<ProxyUri, RecordError> {
    let fault = |reason: String| RecordError::Spawn { reason };
    let options = SpawnOptions {
        wait_for_bind: true,
        hide_welcome_screen: true,
        // Left alone, the viewer would listen to the whole network.
        extra_args: vec!["--bind".to_owned(), "127.0.0.1".to_owned()],
        ..SpawnOptions::default()
    };
    let info = rerun::spawn(&options).map_err(|error| {
        // The full text of the error is a page on installing; its first line is the reason.
        let text = error.to_string();
        fault(
            text.lines()
                .next()
                .unwrap_or_default()
                .trim_end_matches('.')
                .to_owned(),
        )
    })?;
    let url = format!("rerun+http://127.0.0.1:{}/proxy", info.port);
    url.parse::<ProxyUri>()
        .map_err(|error| fault(error.to_string()))
}
