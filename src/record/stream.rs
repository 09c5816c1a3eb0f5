//! A recording stream: rows, one or many at a time, on the one timeline that a recording has.
//!
//! Rerun has a stream of its own, which is not used here. It starts two threads that wait for its sink when it
//! is dropped, without end if that is a disk or a viewer that does not answer; it keeps both for good if it
//! records into memory, as its blueprints do; and the environment variable `RERUN` turns it off. This one
//! gathers rows as that does, in chunks of one entity each, but on the thread of its caller, and holds
//! nothing that outlives it.

use std::{cell::RefCell, collections::BTreeMap, fmt, sync::Arc};

use rerun::{
    ApplicationId, AsComponents, EntityPath, RecordingInfo, SerializationError,
    SerializedComponentColumn, SizeBytes as _, StoreId, StoreKind, TimeCell, TimeColumn, TimePoint,
    TimelineName,
    external::re_log_types::{BlueprintActivationCommand, SetStoreInfo, StoreInfo},
    log::{Chunk, ChunkBatcherConfig, ChunkId, LogMsg, PendingRow, RowId},
};

use super::{error::RecordError, paths};

/// Nanoseconds on the timeline of a simulated time in s.
pub fn nanos(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// A place on a timeline. A time in s is one on that of simulated time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    timeline: TimelineName,
    cell: TimeCell,
}

impl Moment {
    /// A tick of a timeline that counts.
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

/// Takes the messages of a recording, in order.
pub trait MessageSink: Send + Sync {
    /// Takes a message. What goes wrong is told by whoever owns the sink.
    fn send(&self, message: LogMsg);
}

/// Gathers rows into chunks, and sends these to a sink. What still waits when it is dropped is lost:
/// [`RecordingStream::send_waiting`] comes first.
pub struct RecordingStream {
    store: StoreId,
    sink: Arc<dyn MessageSink>,
    waiting: RefCell<BTreeMap<EntityPath, Waiting>>,
}

/// Rows of an entity that wait for more of them.
#[derive(Default)]
struct Waiting {
    rows: Vec<PendingRow>,
    bytes: u64,
}

impl RecordingStream {
    /// A new recording of an application; it begins at once.
    ///
    /// # Errors
    /// [`RecordError::Encode`].
    pub fn new(application: &'static str, sink: Arc<dyn MessageSink>) -> Result<Self, RecordError> {
        let rec = Self::of_kind(StoreKind::Recording, application.into(), sink);
        let began = rerun::components::Timestamp::now();
        let info = RecordingInfo::new().with_start_time(began);
        rec.log_static(EntityPath::properties(), &info)?;
        Ok(rec)
    }

    /// A new blueprint for the recording's application, into the same sink.
    pub fn blueprint(&self) -> Self {
        let application = self.store.application_id().clone();
        Self::of_kind(StoreKind::Blueprint, application, Arc::clone(&self.sink))
    }

    /// Has a blueprint shown that has been sent.
    pub fn show(&self, blueprint: &Self) {
        let shown = BlueprintActivationCommand::make_active(blueprint.store.clone());
        self.sink.send(LogMsg::BlueprintActivationCommand(shown));
    }

    fn of_kind(kind: StoreKind, application: ApplicationId, sink: Arc<dyn MessageSink>) -> Self {
        let made_by = rerun::new_store_info(application.clone()).store_source;
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

    /// Logs what holds at all times.
    ///
    /// # Errors
    /// [`RecordError::Encode`].
    pub fn log_static(
        &self,
        path: impl Into<EntityPath>,
        what: &dyn AsComponents,
    ) -> Result<(), RecordError> {
        self.push(path.into(), TimePoint::STATIC, what)
    }

    /// Sends many rows at once.
    ///
    /// # Errors
    /// [`RecordError::Encode`].
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

    /// Sends the rows that wait for more of their entity.
    ///
    /// # Errors
    /// [`RecordError::Encode`].
    pub fn send_waiting(&self) -> Result<(), RecordError> {
        let waiting = self.waiting.take();
        waiting
            .into_iter()
            .try_for_each(|(path, waiting)| self.send_chunks(path, waiting.rows))
    }

    /// Adds a row.
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

/// Logs one row at a simulated time (s), or at another place on a timeline.
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

/// Sends many rows at once; `times` in ns, one a row.
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

#[cfg(test)]
type Messages = Arc<std::sync::Mutex<Vec<LogMsg>>>;

/// A recording whose messages are kept.
#[cfg(test)]
pub fn in_memory() -> (RecordingStream, Messages) {
    struct Kept(Messages);
    impl MessageSink for Kept {
        fn send(&self, message: LogMsg) {
            self.0.lock().unwrap().push(message);
        }
    }
    let kept = Messages::default();
    let rec = RecordingStream::new("test", Arc::new(Kept(Arc::clone(&kept)))).unwrap();
    (rec, kept)
}
