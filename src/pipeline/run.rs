//! The threads: simulate -> analyse -> record, with bounded channels between them.

use std::any::Any;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};

use super::analyse::{Analyser, memory};
use super::health::HealthMeter;
use super::message::{Frame, Record, Summary};
use super::outlet::Outlet;
use super::{PipelineError, Sink, Source, source};
use crate::scene::Scene;

/// Frames that may wait between simulation and analysis.
const FRAMES_WAITING: usize = 8;
/// Records that may wait between analysis and recorder.
const RECORDS_WAITING: usize = 64;
/// How long no record comes before the sink is told.
const IDLE: Duration = Duration::from_millis(100);

/// A run as seen from outside: told how far it is, and able to stop it.
#[derive(Clone, Copy)]
pub struct Monitor<'a> {
    /// Set to stop the run at the next step; the samples until then are recorded.
    pub stop: &'a Arc<AtomicBool>,
    /// Told the time just past each frame (s), from the thread that makes them.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Default for Monitor<'_> {
    /// Nobody watches, nobody stops.
    fn default() -> Self {
        static NEVER: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
        Self {
            stop: &NEVER,
            progress: &|_| (),
        }
    }
}

impl Monitor<'_> {
    fn stopping(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs a scene to its end, or until the monitor says stop, into a sink.
///
/// `command` says how the program was started. Simulation, analysis and recording have a thread each.
/// On success and after a stop the sink is finished; after an error it is abandoned.
///
/// # Errors
/// The first fault on the road, by place: simulation, analysis, sink. A panic in a thread is one.
pub fn run(
    scene: &Scene,
    command: &str,
    sink: &mut dyn Sink,
    monitor: Monitor<'_>,
) -> Result<Summary, PipelineError> {
    drive(source(scene)?, command, sink, monitor)
}

/// As [`run`], with a source that has been set up before: whatever is wrong with its scene or file
/// has been told by then, and no sink had to be opened for it.
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
    source.heed(monitor.stop);
    let header = Arc::new(source.header(command));
    let bytes = memory(source.analysis(), header.sample_rate);
    // Later, where there is no error to pass on, the allocator would end the program.
    if Vec::<u8>::new().try_reserve_exact(bytes as usize).is_err() {
        return Err(PipelineError::Memory {
            megabytes: bytes / 1_000_000,
        });
    }
    let analyser = Analyser::new(source.analysis(), &header);
    let (frame_out, frame_in) = bounded(FRAMES_WAITING);
    let (record_out, record_in) = bounded(RECORDS_WAITING);
    let outcome = std::thread::scope(|scope| {
        let simulating = spawn(scope, "simulate", move || {
            simulate(source, frame_out, monitor)
        })?;
        let outlet = Outlet::new(record_out, sink.delivery());
        let analysing = spawn(scope, "analyse", move || {
            analyse(analyser, &frame_in, outlet)
        })?;
        let sink = &mut *sink;
        let recording = spawn(scope, "record", move || {
            record(sink, Record::Header(header), record_in)
        })?;
        let recorded = join(recording, "record");
        let analysed = join(analysing, "analyse");
        let simulated = join(simulating, "simulate");
        // The cause comes before its effects: a station that lost its neighbour only says so.
        let interrupted = !simulated?;
        recorded?;
        Ok(Summary {
            interrupted,
            ..analysed?
        })
    });
    let finish = outcome.and_then(|mut summary| {
        summary.wall = began.elapsed().as_secs_f64();
        sink.accept(Record::Summary(Arc::new(summary.clone())))
            .map_err(PipelineError::Sink)?;
        sink.finish().map_err(PipelineError::Sink)?;
        Ok(summary)
    });
    if finish.is_err() {
        sink.abandon();
    }
    finish
}

/// Sends frame after frame; returns whether the planned time was reached.
fn simulate(
    mut source: impl Source,
    frames: Sender<Frame>,
    monitor: Monitor<'_>,
) -> Result<bool, PipelineError> {
    while !monitor.stopping() {
        let Some(frame) = source.next_frame()? else {
            break;
        };
        let end = frame.end();
        if frames.send(frame).is_err() {
            // The analysis has stopped; its own error says why.
            break;
        }
        (monitor.progress)(end);
    }
    Ok(source.is_over())
}

fn analyse(
    mut analyser: Analyser,
    frames: &Receiver<Frame>,
    mut outlet: Outlet,
) -> Result<Summary, PipelineError> {
    let mut health = HealthMeter::default();
    for frame in frames {
        let frame = Arc::new(frame);
        analyser.push(&frame, &mut outlet)?;
        let measured = health.measure(&frame, frames.len(), outlet.waiting(), outlet.drops());
        outlet
            .accept(Record::Health(measured))
            .map_err(PipelineError::Sink)?;
    }
    analyser.finish(&mut outlet)?;
    outlet.flush()?;
    let mut summary = analyser.summary();
    health.conclude(&mut summary);
    Ok(summary)
}

fn record(
    sink: &mut dyn Sink,
    header: Record,
    records: Receiver<Record>,
) -> Result<(), PipelineError> {
    let mut taken = sink.accept(header);
    loop {
        taken.map_err(PipelineError::Sink)?;
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

fn join<T>(
    handle: ScopedJoinHandle<'_, Result<T, PipelineError>>,
    name: &'static str,
) -> Result<T, PipelineError> {
    handle.join().unwrap_or_else(|panic| {
        Err(PipelineError::Panic {
            name,
            message: panic_message(&*panic),
        })
    })
}

/// What a panic said.
pub(crate) fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned()
}
