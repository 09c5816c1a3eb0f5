//! A panic in each thread of a run is the run's error; what was recorded so far can be opened.

use squeakscope::pipeline::message::{Frame, Header, Record};
use squeakscope::pipeline::{Monitor, PipelineError, Simulation, Sink, SinkError, Source, drive};
use squeakscope::record::{Output, RerunSink};
use squeakscope::scene::{AnalysisSpec, Scene};

use super::{desk, names, samples};

/// Frames before something goes wrong.
const SOUND: u64 = 20;

fn scene() -> Scene {
    let scene = Scene::load("torus-3deg").expect("preset");
    scene.with_duration(200.0).expect("in range")
}

/// A simulation that goes wrong at a frame.
struct Faulty {
    simulation: Simulation,
    spoil: fn(&mut Frame),
}

impl Source for Faulty {
    fn header(&self, command: &str) -> Header {
        self.simulation.header(command)
    }

    fn analysis(&self) -> &AnalysisSpec {
        self.simulation.analysis()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        let mut frame = self.simulation.next_frame()?;
        if let Some(frame) = frame.as_mut().filter(|frame| frame.index >= SOUND) {
            (self.spoil)(frame);
        }
        Ok(frame)
    }

    fn is_over(&self) -> bool {
        self.simulation.is_over()
    }
}

/// A recorder that panics at the samples of a frame.
struct Clumsy {
    recorder: RerunSink,
    at: u64,
}

impl Sink for Clumsy {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if matches!(&record, Record::Samples(frame) if frame.index == self.at) {
            panic!("dropped the pen");
        }
        self.recorder.accept(record)
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        self.recorder.finish()
    }
}

/// Runs into a panic; the fault, and how many samples can be read after it.
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
    let mut sink = Clumsy {
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

/// Samples of the sound frames.
fn sound(scene: &Scene) -> usize {
    SOUND as usize * scene.frame_samples
}

#[test]
fn a_panic_of_the_simulation_keeps_what_was_simulated() {
    let (fault, kept) = fault(|_| panic!("lost the ball"), u64::MAX);
    panicked(&fault, "simulate", "lost the ball");
    assert_eq!(kept, sound(&scene()));
}

/// The samples go to the recorder before they are analysed.
#[test]
fn a_panic_of_the_analysis_keeps_what_was_simulated() {
    let (fault, kept) = fault(|frame| frame.velocity.push(0.0), u64::MAX);
    panicked(&fault, "analyse", "");
    assert_eq!(kept, sound(&scene()) + scene().frame_samples);
}

#[test]
fn a_panic_of_the_recorder_keeps_what_was_recorded() {
    let (fault, kept) = fault(|_| {}, SOUND);
    panicked(&fault, "record", "dropped the pen");
    assert_eq!(kept, sound(&scene()));
}
