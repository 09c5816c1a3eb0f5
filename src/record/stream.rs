//! A recording stream: single rows or batches of rows on the timeline of a recording.
//!
//! Rerun's own stream is not used. When it is dropped, its two threads wait for the sink without a timeout,
//! also for a disk or a viewer that does not respond; a stream into memory, such as that of a blueprint,
//! never ends its threads; and the environment variable `RERUN` disables it. This stream batches rows into
//! chunks of one entity like Rerun's, but on the caller's thread, and holds no resources after it is dropped.

use std::{cell::RefCell, collections::BTreeMap, fmt, sync::Arc};

use crate::record::sdk::{
    ApplicationId, AsComponents, EntityPath, RecordingInfo, SerializationError,
    SerializedComponentColumn, SizeBytes as _, StoreId, StoreKind, TimeCell, TimeColumn, TimePoint,
    TimelineName,
    external::re_log_types::{BlueprintActivationCommand, SetStoreInfo, StoreInfo},
    log::{Chunk, ChunkBatcherConfig, ChunkId, LogMsg, PendingRow, RowId},
};

use super::{error::RecordError, paths};

/// A simulated time (s) in nanoseconds on the timeline.
pub fn nanos(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// A moment: a position on a timeline. An `f64` converts to a simulated time in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    timeline: TimelineName,
    cell: TimeCell,
}

impl Moment {
    /// A tick of a timeline of sequence numbers.
    pub fn tick(timeline: TimelineName, tick: i64) -> Self {
        Self {
            timeline,
            cell: TimeCell::from_sequence(tick),
        }
    }
}

impl From<f64> for Moment {
    fn from(time: f64) -> Self {
        Self {
            timeline: paths::TIMELINE.into(),
            cell: TimeCell::from_duration_nanos(nanos(time)),
        }
    }
}

/// Receives the messages of a recording in order.
pub trait MessageSink: Send + Sync {
    /// Receives a message. The owner of the sink reports errors.
    fn send(&self, message: LogMsg);
}

/// Stream of a recording: batches rows into chunks and sends them to a sink. Pending rows are lost when the
/// stream is dropped; call [`RecordingStream::send_pending`] first.
pub struct RecordingStream {
    store: StoreId,
    sink: Arc<dyn MessageSink>,
    waiting: RefCell<BTreeMap<EntityPath, PendingRows>>,
}

/// Rows of an entity that wait for a larger batch.
#[derive(Default)]
struct PendingRows {
    rows: Vec<PendingRow>,
    bytes: u64,
}

impl RecordingStream {
    /// Starts a new recording of an application.
    ///
    /// # Errors
    /// [`RecordError::Encode`] if its properties cannot be encoded.
    pub fn new(application: &'static str, sink: Arc<dyn MessageSink>) -> Result<Self, RecordError> {
        let rec = Self::with_kind(StoreKind::Recording, application.into(), sink);
        let began = crate::record::sdk::components::Timestamp::now();
        let info = RecordingInfo::new().with_start_time(began);
        rec.log_static(EntityPath::properties(), &info)?;
        Ok(rec)
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
        let made_by = crate::record::sdk::new_store_info(application.clone()).store_source;
        let store = StoreId::random(kind, application);
        let info = StoreInfo::new(store.clone(), made_by);
        sink.send(LogMsg::SetStoreInfo(SetStoreInfo {
            row_id: *RowId::new(),
            info,
        }));
        Self {
            store,
            sink,
            waiting: RefCell::default(),
        }
    }

    /// Logs static data.
    ///
    /// # Errors
    /// [`RecordError::Encode`] if they cannot be encoded.
    pub fn log_static(
        &self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), RecordError> {
        self.push(path.into(), TimePoint::STATIC, what)
    }

    /// Sends a batch of rows.
    ///
    /// # Errors
    /// [`RecordError::Encode`] if it cannot be encoded.
    pub fn send_columns(
        &self,
        path: impl Into<EntityPath>,
        index: TimeColumn,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Result<(), RecordError> {
        let columns = columns.into_iter();
        let columns = columns.map(|column| (column.descriptor, column.list_array));
        let index = [(*index.timeline().name(), index)].into_iter().collect();
        let id = ChunkId::new();
        let chunk = Chunk::from_auto_row_ids(id, path.into(), index, columns.collect())?;
        self.send_chunk(&chunk)
    }

    /// Sends all pending rows.
    ///
    /// # Errors
    /// [`RecordError::Encode`] if they cannot be encoded.
    pub fn send_pending(&self) -> Result<(), RecordError> {
        let waiting = self.waiting.take();
        waiting
            .into_iter()
            .try_for_each(|(path, waiting)| self.send_chunks(path, waiting.rows))
    }

    /// Adds a row, and sends the batch if it is full.
    fn push(
        &self,
        path: EntityPath,
        timepoint: TimePoint,
        what: &dyn AsComponents,
    ) -> Result<(), RecordError> {
        let row = PendingRow::from_iter(timepoint, what.as_serialized_batches());
        if row.components.is_empty() {
            return Ok(());
        }
        let mut entities = self.waiting.borrow_mut();
        let waiting = entities.entry(path.clone()).or_default();
        waiting.bytes += row.total_size_bytes();
        waiting.rows.push(row);
        if waiting.bytes < ChunkBatcherConfig::DEFAULT.flush_num_bytes {
            return Ok(());
        }
        let full = std::mem::take(waiting);
        self.send_chunks(path, full.rows)
    }

    fn send_chunks(&self, path: EntityPath, rows: Vec<PendingRow>) -> Result<(), RecordError> {
        let unsorted = ChunkBatcherConfig::DEFAULT.chunk_max_rows_if_unsorted;
        PendingRow::many_into_chunks(path, unsorted, rows)
            .try_for_each(|chunk| self.send_chunk(&chunk?))
    }

    fn send_chunk(&self, chunk: &Chunk) -> Result<(), RecordError> {
        let message = LogMsg::ArrowMsg(self.store.clone(), chunk.to_arrow_msg()?);
        self.sink.send(message);
        Ok(())
    }
}

impl fmt::Debug for RecordingStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RecordingStream")
            .field("store", &self.store)
            .finish_non_exhaustive()
    }
}

/// Logs a row at a simulated time (s) or another position on a timeline.
pub fn log_at(
    rec: &RecordingStream,
    path: impl Into<EntityPath>,
    at: impl Into<Moment>,
    what: &dyn AsComponents,
) -> Result<(), RecordError> {
    let Moment { timeline, cell } = at.into();
    let timepoint = TimePoint::default().with_index(timeline, cell);
    rec.push(path.into(), timepoint, what)
}

/// Logs a row from a moment on, or static.
pub fn log_from(
    rec: &RecordingStream,
    path: impl Into<EntityPath>,
    from: Option<Moment>,
    what: &dyn AsComponents,
) -> Result<(), RecordError> {
    match from {
        Some(from) => log_at(rec, path, from, what),
        None => rec.log_static(path, what),
    }
}

/// Sends a batch of rows; `times` in ns, one per row.
pub fn send_rows<I>(
    rec: &RecordingStream,
    path: &str,
    times: &[i64],
    columns: Result<I, SerializationError>,
) -> Result<(), RecordError>
where
    I: Iterator<Item = SerializedComponentColumn>,
{
    let index = TimeColumn::new_duration_nanos(paths::TIMELINE, times.iter().copied());
    rec.send_columns(path, index, columns?)
}
