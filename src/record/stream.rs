//! A recording stream: single rows or batches of rows on the timeline of a recording.
//!
//! Rerun's own stream is not used. When it is dropped, its two threads wait for the sink without a timeout,
//! also for a disk or a viewer that does not respond; a stream into memory, such as that of a blueprint,
//! never ends its threads; and the environment variable `RERUN` disables it. This stream batches rows into
//! chunks of one entity like Rerun's, but on the caller's thread, and holds no resources after it is dropped.
//!
//! Logging does not fail: the first error of an encoding is kept and returned by [`RecordingStream::send_pending`], as the
//! file and the viewer report theirs when they are flushed.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::{Debug, Display};
use std::sync::Arc;

use crate::record::sdk::components::Timestamp;
use crate::record::sdk::external::re_log_types::{
    BlueprintActivationCommand, SetStoreInfo, StoreInfo,
};
use crate::record::sdk::log::{
    Chunk, ChunkBatcherConfig, ChunkError, ChunkId, LogMsg, PendingRow, RowId,
};
use crate::record::sdk::{
    ApplicationId, AsComponents, EntityPath, RecordingInfo, Scalars, SerializationError,
    SerializedComponentColumn, SeriesLines, SizeBytes as _, StoreId, StoreKind, TimeCell,
    TimeColumn, TimePoint, TimelineName, new_store_info,
};

use super::{error::RecordError, paths};
use crate::plot::response::{Curve, SERIES_POINTS};
use crate::plot::{Color, Panel};

/// Rows of time series per batch. A larger batch needs fewer entries in the index of a file.
const BATCH_ROWS: usize = 4000;
/// Rows of time series at the end of a run that figures keep completely.
const RECENT_ROWS: usize = 20_000;
/// Width of a curve, pixels, and points on paper per pixel.
pub const WIDTH: f32 = 1.2;
const ON_PAPER: f64 = 0.75;

/// A simulated time (s) in nanoseconds on the timeline.
pub fn nanos(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// A position on a timeline, or [`STATIC`]. An `f64` converts to a simulated time in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment(Option<(TimelineName, TimeCell)>);

/// Always: static data.
pub const STATIC: Moment = Moment(None);

impl Moment {
    /// A tick of a timeline of sequence numbers.
    pub fn tick(timeline: TimelineName, tick: i64) -> Self {
        Self(Some((timeline, TimeCell::from_sequence(tick))))
    }
}

impl From<f64> for Moment {
    fn from(time: f64) -> Self {
        let time = TimeCell::from_duration_nanos(nanos(time));
        Self(Some((paths::TIMELINE.into(), time)))
    }
}

/// Receives the messages of a recording in order.
pub trait MessageSink: Debug + Send + Sync {
    /// Receives a message. The owner of the sink reports errors.
    fn send(&self, message: LogMsg);
}

/// Discards all messages.
impl MessageSink for () {
    fn send(&self, _message: LogMsg) {}
}

/// Stream of a recording: batches rows into chunks and sends them to a sink. Pending rows are lost when the
/// stream is dropped; call [`RecordingStream::send_pending`] first.
#[derive(Debug)]
pub struct RecordingStream {
    store: StoreId,
    sink: Arc<dyn MessageSink>,
    waiting: RefCell<BTreeMap<EntityPath, PendingRows>>,
    /// Pending rows of the entities with time series, sent in the order in which the entities were named.
    series: RefCell<Vec<(String, PendingSeries)>>,
    /// The first encoding that failed.
    fault: RefCell<Option<RecordError>>,
    /// `None` unless the stream is one for figures.
    figures: Option<Kept>,
}

/// What a stream for figures keeps.
#[derive(Debug)]
struct Kept {
    /// The last panel at each path.
    panels: RefCell<BTreeMap<String, Panel>>,
    /// Smallest interval of old rows of time series, ns.
    interval: i64,
}

/// Rows of an entity that wait for a larger batch.
#[derive(Debug, Default)]
struct PendingRows {
    rows: Vec<PendingRow>,
    bytes: u64,
}

/// Rows of time series that wait for a larger batch, all of the same width.
#[derive(Debug, Default)]
struct PendingSeries {
    /// Name, colour and width of each curve.
    curves: Vec<(String, Color, f32)>,
    times: Vec<i64>,
    values: Vec<f64>,
}

impl PendingSeries {
    /// Omits old rows, all but the last [`RECENT_ROWS`], that follow the previous one by less than an interval (ns).
    fn thin(&mut self, interval: i64) {
        let (count, width) = (self.times.len(), self.curves.len());
        let (mut kept, mut last) = (0, i64::MIN);
        for row in 0..count {
            let time = self.times[row];
            if row + RECENT_ROWS >= count || time.saturating_sub(last) >= interval {
                self.times[kept] = time;
                let values = row * width..(row + 1) * width;
                self.values.copy_within(values, kept * width);
                (kept, last) = (kept + 1, time);
            }
        }
        self.times.truncate(kept);
        self.values.truncate(kept * width);
    }
}

impl RecordingStream {
    /// Starts a new recording of an application.
    pub fn new(application: &'static str, sink: Arc<dyn MessageSink>) -> Self {
        let rec = Self::with_kind(StoreKind::Recording, application.into(), sink);
        let info = RecordingInfo::new().with_start_time(Timestamp::now());
        rec.log_static(EntityPath::properties(), &info);
        rec
    }

    /// A stream for the figures of a run of a duration (s): it records nothing, but keeps time series and the last panels.
    pub fn for_figures(duration: f64) -> Self {
        let stream = Self::with_kind(StoreKind::Recording, "figures".into(), Arc::new(()));
        let figures = Some(Kept {
            panels: RefCell::default(),
            interval: nanos(duration / SERIES_POINTS as f64),
        });
        Self { figures, ..stream }
    }

    /// Keeps a panel for figures. Returns whether the stream is one for figures.
    pub fn keep(&self, path: &str, panel: impl FnOnce() -> Panel) -> bool {
        if let Some(kept) = &self.figures {
            let mut panels = kept.panels.borrow_mut();
            panels.insert(path.to_owned(), panel());
        }
        self.figures.is_some()
    }

    /// The last panel at a path, in a stream for figures.
    pub fn panel(&self, path: &str) -> Option<Panel> {
        self.figures.as_ref()?.panels.borrow().get(path).cloned()
    }

    /// The curves of an entity of time series over the last `window` (s), in a stream for figures.
    pub fn curves(&self, path: &str, window: f64) -> Vec<Curve> {
        let all = self.series.borrow();
        let Some((_, series)) = all.iter().find(|(known, _)| known == path) else {
            return Vec::new();
        };
        let times = || series.times.iter().map(|time| 1e-9 * *time as f64);
        let end = times().next_back().unwrap_or(0.0);
        let curves = series.curves.iter().enumerate();
        let curves = curves.map(|(k, (label, color, width))| {
            let values = series.values.iter().skip(k).step_by(series.curves.len());
            let points = times().zip(values).map(|(time, value)| [time, *value]);
            let points = points.filter(|[time, _]| end - time <= window);
            let width = ON_PAPER * f64::from(*width);
            (label.clone(), *color, width, points.collect())
        });
        curves.collect()
    }

    /// A new blueprint for the application of this recording, with the same sink.
    pub fn blueprint(&self) -> Self {
        let application = self.store.application_id().clone();
        Self::with_kind(StoreKind::Blueprint, application, Arc::clone(&self.sink))
    }

    /// Activates a blueprint that has been sent.
    pub fn activate_blueprint(&self, blueprint: &Self) {
        let shown = BlueprintActivationCommand::make_active(blueprint.store.clone());
        self.sink.send(LogMsg::BlueprintActivationCommand(shown));
    }

    fn with_kind(kind: StoreKind, application: ApplicationId, sink: Arc<dyn MessageSink>) -> Self {
        let made_by = new_store_info(application.clone()).store_source;
        let store = StoreId::random(kind, application);
        let info = StoreInfo::new(store.clone(), made_by);
        let row_id = *RowId::new();
        sink.send(LogMsg::SetStoreInfo(SetStoreInfo { row_id, info }));
        Self {
            store,
            sink,
            waiting: RefCell::default(),
            series: RefCell::default(),
            fault: RefCell::default(),
            figures: None,
        }
    }

    /// The value of a result; keeps the first error.
    pub fn check<T, E: Display>(&self, result: Result<T, E>) -> Option<T> {
        let fault = |error: &E| self.fail(RecordError::Encode(error.to_string()));
        result.inspect_err(fault).ok()
    }

    /// Keeps an error unless there is one.
    pub fn fail(&self, error: RecordError) {
        self.fault.borrow_mut().get_or_insert(error);
    }

    /// Logs static data.
    pub fn log_static(&self, path: impl Into<EntityPath>, what: &dyn AsComponents) {
        self.log(path, STATIC, what);
    }

    /// Logs a row; a full batch is sent.
    pub fn log(&self, path: impl Into<EntityPath>, at: impl Into<Moment>, what: &dyn AsComponents) {
        if self.figures.is_some() {
            return;
        }
        let Moment(at) = at.into();
        let at = at.map_or(TimePoint::STATIC, |(timeline, time)| {
            TimePoint::default().with_index(timeline, time)
        });
        let row = PendingRow::from_iter(at, what.as_serialized_batches());
        if row.components.is_empty() {
            return;
        }
        let path = path.into();
        let mut entities = self.waiting.borrow_mut();
        let waiting = entities.entry(path.clone()).or_default();
        waiting.bytes += row.total_size_bytes();
        waiting.rows.push(row);
        if waiting.bytes >= ChunkBatcherConfig::DEFAULT.flush_num_bytes {
            let full = std::mem::take(waiting);
            self.send_chunks(path, full.rows);
        }
    }

    /// Sends a batch of rows; `times` in ns, one per row.
    pub fn send_rows(
        &self,
        path: &str,
        times: &[i64],
        columns: Result<impl Iterator<Item = SerializedComponentColumn>, SerializationError>,
    ) {
        let Some(columns) = self.check(columns).filter(|_| self.figures.is_none()) else {
            return;
        };
        let columns = columns.map(|column| (column.descriptor, column.list_array));
        let times = TimeColumn::new_duration_nanos(paths::TIMELINE, times.iter().copied());
        let times = [(*times.timeline().name(), times)].into_iter().collect();
        let id = ChunkId::new();
        let chunk = Chunk::from_auto_row_ids(id, path.into(), times, columns.collect());
        self.send_chunk(chunk);
    }

    /// Starts an entity of time series with names and colours; one that is started remains as it is.
    pub fn name<N: Into<String>>(&self, path: &str, series: impl IntoIterator<Item = (N, Color)>) {
        let curve = |(name, color): (N, Color)| (name.into(), color, WIDTH);
        self.start(path, series.into_iter().map(curve).collect(), true);
    }

    /// As [`RecordingStream::name`], with line widths, pixels. Colours that change over time must not be static: without
    /// `has_colors` the recording has no colours yet.
    pub fn start(&self, path: &str, curves: Vec<(String, Color, f32)>, has_colors: bool) {
        let mut started = self.series.borrow_mut();
        if started.iter().any(|(known, _)| known == path) {
            return;
        }
        let mut style = SeriesLines::new()
            .with_names(curves.iter().map(|(name, ..)| name.as_str()))
            .with_widths(curves.iter().map(|(.., width)| *width));
        if has_colors {
            style = style.with_colors(curves.iter().map(|(_, color, _)| *color));
        }
        self.log_static(path, &style);
        let series = PendingSeries {
            curves,
            ..PendingSeries::default()
        };
        started.push((path.to_owned(), series));
    }

    /// Adds a row of time series at a time (s), as [`RecordingStream::rows`].
    pub fn row(&self, path: &str, time: f64, row: impl IntoIterator<Item = f64>) {
        self.rows(path, [(time, row)]);
    }

    /// Adds rows of time series, each with its time (s) and a value for each series. Rows of an entity that was not
    /// started are ignored: the run has no such series. A full batch is sent.
    pub fn rows<R: IntoIterator<Item = f64>>(
        &self,
        path: &str,
        rows: impl IntoIterator<Item = (f64, R)>,
    ) {
        let mut all = self.series.borrow_mut();
        let Some((_, pending)) = all.iter_mut().find(|(known, _)| known == path) else {
            return;
        };
        for (time, row) in rows {
            pending.times.push(nanos(time));
            pending.values.extend(row);
        }
        match &self.figures {
            None if pending.times.len() >= BATCH_ROWS => self.send_series(path, pending),
            Some(kept) if pending.times.len() >= 2 * RECENT_ROWS => pending.thin(kept.interval),
            _ => {}
        }
    }

    fn send_series(&self, path: &str, pending: &mut PendingSeries) {
        let times = std::mem::take(&mut pending.times);
        let values = std::mem::take(&mut pending.values);
        if !times.is_empty() {
            let width = values.len() / times.len();
            debug_assert_eq!(values.len(), width * times.len(), "{path}");
            let lengths = std::iter::repeat_n(width, times.len());
            self.send_rows(path, &times, Scalars::new(values).columns(lengths));
        }
    }

    /// Sends all pending rows.
    ///
    /// # Errors
    /// [`RecordError::Encode`] if anything logged so far could not be encoded.
    pub fn send_pending(&self) -> Result<(), RecordError> {
        for (path, pending) in &mut *self.series.borrow_mut() {
            self.send_series(path, pending);
        }
        for (path, waiting) in self.waiting.take() {
            self.send_chunks(path, waiting.rows);
        }
        self.fault.take().map_or(Ok(()), Err)
    }

    fn send_chunks(&self, path: EntityPath, rows: Vec<PendingRow>) {
        let unsorted = ChunkBatcherConfig::DEFAULT.chunk_max_rows_if_unsorted;
        PendingRow::many_into_chunks(path, unsorted, rows).for_each(|chunk| self.send_chunk(chunk));
    }

    fn send_chunk(&self, chunk: Result<Chunk, ChunkError>) {
        let message = chunk.and_then(|chunk| chunk.to_arrow_msg());
        if let Some(message) = self.check(message) {
            let message = LogMsg::ArrowMsg(self.store.clone(), message);
            self.sink.send(message);
        }
    }
}
