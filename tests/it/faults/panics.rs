//! A panic in any thread of a run is an error of the run; the recording up to it is readable.

use squeakscope::pipeline::message::{Frame, Header, Record};
use squeakscope::pipeline::{Monitor, PipelineError, Simulation, Sink, SinkError, Source, drive};
use squeakscope::record::{Output, RerunSink};
use squeakscope::scene::Scene;

use super::{desk, names, samples};

/// Number of frames before the fault.
const GOOD_FRAMES: u64 = 20;

fn scene() -> Scene {
    let scene = Scene::load("doubled-torus-3deg").expect("preset");
    scene.with_duration(200.0).expect("in range")
}

/// A simulation with a faulty frame.
struct Faulty {
    simulation: Simulation,
    spoil: fn(&mut Frame),
}

impl Source for Faulty {
    fn header(&self, command: &str) -> Header {
        self.simulation.header(command)
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        let mut frame = self.simulation.next_frame()?;
        if let Some(frame) = frame.as_mut().filter(|frame| frame.index >= GOOD_FRAMES) {
            (self.spoil)(frame);
        }
        Ok(frame)
    }

    fn is_finished(&self) -> bool {
        self.simulation.is_finished()
    }
}

/// A recorder that panics at the samples of a frame.
struct FaultyRecorder {
    recorder: RerunSink,
    at: u64,
}

impl Sink for FaultyRecorder {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if matches!(&record, Record::Samples(frame) if frame.index == self.at) {
            panic!("faulty recorder");
        }
        self.recorder.accept(record)
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        self.recorder.finish()
    }
}

/// Provokes a panic. Returns the error, and the number of readable samples.
fn fault(spoil: fn(&mut Frame), recorder_at: u64) -> (PipelineError, usize) {
    let (folder, recording) = desk();
    let scene = scene();
    let source = Faulty {
        simulation: Simulation::new(&scene).expect("assembled"),
        spoil,
    };
    let output = Output {
        save: Some(recording.clone()),
        ..Output::default()
    };
    let mut sink = FaultyRecorder {
        recorder: RerunSink::new(&output, scene.record).expect("opened"),
        at: recorder_at,
    };
    let fault = drive(source, "test", &mut sink, Monitor::default()).expect_err("a panic");
    drop(sink);
    assert_eq!(names(folder.path()), ["run.rrd.part"]);
    let kept = samples(&recording.with_extension("rrd.part"));
    (fault, kept.values.len())
}

#[track_caller]
fn panicked(fault: &PipelineError, thread: &str, word: &str) {
    let said = fault.to_string();
    assert!(
        matches!(fault, PipelineError::Panic { name, .. } if *name == thread),
        "{said}"
    );
    assert!(
        said.contains(&format!("`{thread}` panicked")) && said.contains(word),
        "{said}"
    );
}

/// Number of samples in the good frames.
fn good_samples(scene: &Scene) -> usize {
    GOOD_FRAMES as usize * scene.frame_samples
}

#[test]
fn a_panic_of_the_simulation_keeps_the_samples() {
    let (fault, kept) = fault(|_| panic!("faulty simulation"), u64::MAX);
    panicked(&fault, "simulate", "faulty simulation");
    assert_eq!(kept, good_samples(&scene()));
}

/// The samples are recorded before they are analysed.
#[test]
fn a_panic_of_the_analysis_keeps_the_samples() {
    let (fault, kept) = fault(|frame| frame.velocity.push(0.0), u64::MAX);
    panicked(&fault, "analyse", "");
    assert_eq!(kept, good_samples(&scene()) + scene().frame_samples);
}

#[test]
fn a_panic_of_the_recorder_keeps_the_recorded_samples() {
    let (fault, kept) = fault(|_| {}, GOOD_FRAMES);
    panicked(&fault, "record", "faulty recorder");
    assert_eq!(kept, good_samples(&scene()));
}
