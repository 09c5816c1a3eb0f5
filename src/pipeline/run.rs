//! The three threads of a run, simulate -> analyse -> record, and the bounded channels between them.

use std::any::Any;
use std::mem::discriminant;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded};

use super::analyse::{Analyser, memory};
use super::budget::Budget;
use super::health::HealthMeter;
use super::message::{Frame, Record, Summary};
use super::{PipelineError, Simulation, Sink, SinkError, Source};
use crate::scene::{AnalysisBudget, Scene};

/// Capacity of the channel between simulation and analysis, frames.
const FRAMES_WAITING: usize = 8;
/// Capacity of the channel between analysis and recorder, records.
const RECORDS_WAITING: usize = 64;
/// Time without a record after which [`Sink::idle`] is called.
const IDLE: Duration = Duration::from_millis(100);

/// Progress report and stop flag of a run.
#[derive(Clone, Copy)]
pub struct Monitor<'a> {
    /// Set it to stop the run at the next integrator step. The samples computed until then are recorded.
    pub stop: &'a Arc<AtomicBool>,
    /// Called after each frame, on the simulation thread, with the end time of the frame, s.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Default for Monitor<'_> {
    /// Reports no progress and never stops the run.
    fn default() -> Self {
        static NEVER: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
        Self {
            stop: &NEVER,
            progress: &|_| (),
        }
    }
}

/// Simulates a scene to its end, or until the stop flag is set, and sends the records to a sink.
///
/// `command` is the command line, for the header. Simulation, analysis and recording have one thread each, and the
/// analyses also use the current thread pool.
/// On success and after a stop the sink is finished; after an error it is not.
///
/// # Errors
/// The error that ended the run, of the simulation, the analysis or the sink. A panic counts as an error.
pub fn run(
    scene: &Scene,
    command: &str,
    sink: &mut dyn Sink,
    monitor: Monitor<'_>,
) -> Result<Summary, PipelineError> {
    drive(Simulation::new(scene)?, command, sink, monitor)
}

/// Runs a source that already exists. Errors of its scene or file are known before a sink is opened.
///
/// # Errors
/// As [`run`].
pub fn drive(
    mut source: impl Source,
    command: &str,
    sink: &mut dyn Sink,
    monitor: Monitor<'_>,
) -> Result<Summary, PipelineError> {
    let began = Instant::now();
    source.set_stop_flag(monitor.stop);
    let header = Arc::new(source.header(command));
    let bytes = memory(&header.analysis, header.sample_rate);
    // An allocation that fails later aborts the program; here it is still an error.
    if !crate::memory::can_reserve(bytes as usize) {
        return Err(PipelineError::Memory {
            megabytes: bytes / 1_000_000,
        });
    }
    let analyser = Analyser::new(&header.analysis, &header);
    let is_limited = header.analysis.budget == AnalysisBudget::Realtime;
    let budget = is_limited.then(Budget::default);
    let (frame_out, frame_in) = bounded(FRAMES_WAITING);
    let (record_out, record_in) = bounded(RECORDS_WAITING);
    let outcome: Result<Summary, PipelineError> = std::thread::scope(|scope| {
        let simulating = spawn(scope, "simulate", move || {
            simulate(source, frame_out, monitor)
        })?;
        let record_sender = RecordSender::new(record_out, sink.may_skip_pictures());
        let analysing = spawn(scope, "analyse", move || {
            analyse(analyser, budget, &frame_in, record_sender)
        })?;
        let sink = &mut *sink;
        let recording = spawn(scope, "record", move || {
            record(sink, Record::Header(header), record_in)
        })?;
        let recorded = joined(recording.join(), "record");
        let analysed = joined(analysing.join(), "analyse");
        let simulated = joined(simulating.join(), "simulate");
        // Other threads then report only a closed channel. The error of the cause comes first.
        let interrupted = !simulated?;
        recorded?;
        Ok(Summary {
            interrupted,
            ..analysed?
        })
    });
    let mut summary = outcome?;
    summary.wall_s = began.elapsed().as_secs_f64();
    sink.accept(Record::Summary(Arc::new(summary.clone())))?;
    sink.finish()?;
    Ok(summary)
}

/// Sends the frames of a source. Returns whether the planned time was reached.
fn simulate(
    mut source: impl Source,
    frames: Sender<Frame>,
    monitor: Monitor<'_>,
) -> Result<bool, PipelineError> {
    while !monitor.stop.load(Ordering::Relaxed) {
        let Some(frame) = source.next_frame()? else {
            break;
        };
        let end = frame.end();
        if frames.send(frame).is_err() {
            // The analysis thread has failed; its own error gives the reason.
            break;
        }
        (monitor.progress)(end);
    }
    Ok(source.is_finished())
}

fn analyse(
    mut analyser: Analyser,
    mut budget: Option<Budget>,
    frames: &Receiver<Frame>,
    mut record_sender: RecordSender,
) -> Result<Summary, PipelineError> {
    let mut health = HealthMeter::default();
    for frame in frames {
        let frame = Arc::new(frame);
        let began = Instant::now();
        analyser.push(&frame, &mut record_sender)?;
        if let Some(budget) = &mut budget
            && let Some(warning) = budget.follow(&frame, began.elapsed().as_secs_f64())
        {
            analyser.set_rate_divisor(budget.divisor());
            record_sender.accept(warning)?;
        }
        let measured = health.measure(
            &frame,
            frames.len(),
            record_sender.waiting(),
            record_sender.drops(),
        );
        record_sender.accept(Record::Health(measured))?;
    }
    analyser.finish(&mut record_sender)?;
    record_sender.flush()?;
    let mut summary = analyser.summary();
    health.complete_summary(&mut summary);
    summary.analysis_rate = budget.and_then(|budget| budget.rate());
    Ok(summary)
}

fn record(
    sink: &mut dyn Sink,
    header: Record,
    records: Receiver<Record>,
) -> Result<(), PipelineError> {
    let mut taken = sink.accept(header);
    loop {
        taken?;
        taken = match records.recv_timeout(IDLE) {
            Ok(record) => sink.accept(record),
            Err(RecvTimeoutError::Timeout) => sink.idle(),
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        };
    }
}

fn spawn<'scope, 'env, T: Send + 'scope>(
    scope: &'scope Scope<'scope, 'env>,
    name: &'static str,
    body: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>, PipelineError> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn_scoped(scope, body)
        .map_err(|source| PipelineError::Thread { name, source })
}

/// The result of a thread of a run; a panic is an error.
pub(crate) fn joined<T>(
    ended: std::thread::Result<Result<T, PipelineError>>,
    name: &'static str,
) -> Result<T, PipelineError> {
    ended.unwrap_or_else(|panic| {
        let message = panic_message(&*panic);
        Err(PipelineError::Panic { name, message })
    })
}

/// The message of a panic.
pub(crate) fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned()
}

/// Error of a channel that is closed; the recorder has the reason.
const STOPPED: &str = "the recorder has stopped";

/// Sends records to the recorder. If the sink permits it, a picture that cannot be sent at once may be
/// replaced by the next one of its kind. Samples, texts and numbers always wait.
#[derive(Debug)]
struct RecordSender {
    sender: Sender<Record>,
    /// See [`Sink::may_skip_pictures`].
    may_skip_pictures: bool,
    /// Pictures that could not be sent yet, at most one of each kind.
    buffered: Vec<Record>,
    drops: u64,
}

impl RecordSender {
    fn new(sender: Sender<Record>, may_skip_pictures: bool) -> Self {
        Self {
            sender,
            may_skip_pictures,
            buffered: Vec::new(),
            drops: 0,
        }
    }

    /// Number of pictures replaced so far.
    fn drops(&self) -> u64 {
        self.drops
    }

    /// Number of records that wait for the recorder.
    fn waiting(&self) -> usize {
        self.sender.len() + self.buffered.len()
    }

    /// Sends all buffered pictures and waits until they are accepted.
    fn flush(&mut self) -> Result<(), SinkError> {
        for record in self.buffered.drain(..) {
            self.sender.send(record).map_err(|_| STOPPED)?;
        }
        Ok(())
    }

    fn send_or_buffer(&mut self, record: Record) -> Result<(), SinkError> {
        match self.sender.try_send(record) {
            Ok(()) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(STOPPED.into()),
            Err(TrySendError::Full(record)) => {
                let waiting = self.buffered.len();
                self.buffered
                    .retain(|known| discriminant(known) != discriminant(&record));
                self.drops += (waiting - self.buffered.len()) as u64;
                self.buffered.push(record);
                Ok(())
            }
        }
    }
}

impl Sink for RecordSender {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if self.may_skip_pictures {
            for buffered in std::mem::take(&mut self.buffered) {
                self.send_or_buffer(buffered)?;
            }
            if record.is_picture() {
                return self.send_or_buffer(record);
            }
        }
        Ok(self.sender.send(record).map_err(|_| STOPPED)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record that a newer one replaces.
    fn picture(time: f64) -> Record {
        Record::Embedding {
            time,
            points: vec![],
        }
    }

    /// A record that is never dropped.
    fn text(time: f64) -> Record {
        let text = String::new();
        Record::Warning { time, text }
    }

    /// While the recorder is blocked, the newest picture of a kind is kept and no text is lost.
    #[test]
    fn the_newest_picture_replaces_older_ones() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut record_sender = RecordSender::new(sender, true);
        record_sender.accept(text(0.0)).unwrap();
        for k in 1..=5 {
            record_sender.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!((record_sender.drops(), record_sender.waiting()), (4, 2));
        let reader = std::thread::spawn(move || receiver.iter().collect::<Vec<_>>());
        record_sender.flush().unwrap();
        record_sender.accept(text(6.0)).unwrap();
        drop(record_sender);
        let got = reader.join().unwrap();
        assert!(matches!(got[0], Record::Warning { time: 0.0, .. }));
        assert!(matches!(got[1], Record::Embedding { time: 5.0, .. }));
        assert!(matches!(got[2], Record::Warning { time: 6.0, .. }));
        assert_eq!(got.len(), 3);
    }

    #[test]
    fn every_picture_waits_when_saving() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let mut record_sender = RecordSender::new(sender, false);
        let reader = std::thread::spawn(move || receiver.iter().count());
        for k in 0..50 {
            record_sender.accept(picture(f64::from(k))).unwrap();
        }
        assert_eq!(record_sender.drops(), 0);
        drop(record_sender);
        assert_eq!(reader.join().unwrap(), 50);
    }

    #[test]
    fn a_stopped_recorder_is_an_error() {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        drop(receiver);
        let mut record_sender = RecordSender::new(sender, true);
        assert!(
            record_sender.accept(text(0.0)).is_err() && record_sender.accept(picture(0.0)).is_err()
        );
    }
}
