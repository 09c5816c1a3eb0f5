//! The pipeline: order, back-pressure, repeatability, stops and errors.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Monitor, PipelineError, Sink, SinkError, run};
use squeakscope::scene::Scene;

fn short() -> Scene {
    Scene::load("doubled-torus-3deg")
        .unwrap()
        .with_duration(12.0)
        .unwrap()
}

fn records(scene: &Scene) -> Vec<Record> {
    let mut sink = Vec::new();
    run(scene, "test", &mut sink, Monitor::default()).unwrap();
    sink
}

/// The numbers of a run, without wall times.
fn numbers(records: &[Record]) -> String {
    let lasting = records
        .iter()
        .filter(|r| !matches!(r, Record::Health(_) | Record::Summary(_)));
    lasting
        .map(|record| match record {
            Record::Samples(frame) => {
                format!("{:?} {:?} {:?}\n", frame.q, frame.patch, frame.energy)
            }
            other => format!("{other:?}\n"),
        })
        .collect()
}

#[test]
fn header_first_summary_last_samples_without_gap() {
    let records = records(&short());
    assert!(matches!(records.first(), Some(Record::Header(_))));
    let Some(Record::Summary(summary)) = records.last() else {
        panic!("no summary")
    };
    let mut next = 0.0;
    let mut samples = 0;
    for record in &records {
        if let Record::Samples(frame) = record {
            assert!((frame.t0 - next).abs() < 1e-12);
            next = frame.end();
            samples += frame.len();
        }
    }
    assert_eq!(samples, 2400);
    assert!((summary.simulated_s - 12e-3).abs() < 1e-12);
    assert!(summary.stats.steps > 0 && !summary.interrupted && summary.wall_s > 0.0);
}

/// The same scene gives bit-identical numbers.
#[test]
fn runs_repeat() {
    assert_eq!(numbers(&records(&short())), numbers(&records(&short())));
}

/// The stored energy equals the supplied energy.
#[test]
fn energy_is_audited() {
    let mut scene = Scene::load("tilt-ramp")
        .unwrap()
        .with_duration(140.0)
        .unwrap();
    scene.integrator.tolerance = 1e-8;
    let mut worst: f64 = 0.0;
    let mut largest_energy: f64 = 0.0;
    for record in records(&scene) {
        if let Record::Samples(frame) = record {
            for energy in &frame.energy {
                largest_energy = largest_energy.max(energy.total);
                worst = worst.max(energy.residual.abs());
            }
        }
    }
    assert!(
        largest_energy > 1e-9,
        "the joint does not squeak: {largest_energy} J"
    );
    assert!(
        worst < 1e-5 * largest_energy,
        "{worst:e} J of {largest_energy:e} J"
    );
}

/// A stopped run ends at a frame boundary, keeps its samples and is marked as interrupted.
#[test]
fn a_stop_is_clean() {
    struct StopAt<'a>(usize, &'a AtomicBool, Vec<Record>);
    impl Sink for StopAt<'_> {
        fn accept(&mut self, record: Record) -> Result<(), SinkError> {
            self.2.push(record);
            if self.2.len() == self.0 {
                self.1.store(true, Ordering::Relaxed);
            }
            Ok(())
        }
    }
    let stop = Arc::new(AtomicBool::new(false));
    let mut sink = StopAt(5, &stop, vec![]);
    let monitor = Monitor {
        stop: &stop,
        ..Monitor::default()
    };
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let summary = run(&scene, "test", &mut sink, monitor).unwrap();
    assert!(summary.interrupted && summary.simulated_s < 0.1 * scene.duration);
    assert!(matches!(sink.2.last(), Some(Record::Summary(_))));
}

/// A sink error ends the run; the sink is not finished.
#[test]
fn a_failing_sink_is_the_run_s_error() {
    #[derive(Default)]
    struct Full {
        taken: usize,
        finished: bool,
    }
    impl Sink for Full {
        fn accept(&mut self, _: Record) -> Result<(), SinkError> {
            self.taken += 1;
            if self.taken > 20 {
                Err("the disk is full".into())
            } else {
                Ok(())
            }
        }
        fn finish(&mut self) -> Result<(), SinkError> {
            self.finished = true;
            Ok(())
        }
    }
    let mut sink = Full::default();
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let fault = run(&scene, "test", &mut sink, Monitor::default()).unwrap_err();
    let PipelineError::Sink(source) = fault else {
        panic!("{fault:?}")
    };
    assert_eq!(source.to_string(), "the disk is full");
    assert!(!sink.finished);
}

/// Analyses that the scene does not request send nothing.
#[test]
fn absent_analyses_send_nothing() {
    let scene = short().without_analyses();
    for record in records(&scene) {
        assert!(
            matches!(
                record,
                Record::Header(_) | Record::Samples(_) | Record::Health(_) | Record::Summary(_)
            ),
            "{record:?}"
        );
    }
}

/// A duration that is not a multiple of the sample spacing is complete, not interrupted.
#[test]
fn odd_durations_are_complete() {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene.duration = 1.2324e-3;
    let summary = run(&scene, "test", &mut Vec::new(), Monitor::default()).unwrap();
    assert!(!summary.interrupted);
    assert!((summary.simulated_s - 246.0 / 200e3).abs() < 1e-15);
}

/// A panic on the recorder's thread is an error of the run, like one on any other thread.
#[test]
fn a_panicking_sink_is_the_run_s_error() {
    struct Broken;
    impl Sink for Broken {
        fn accept(&mut self, _: Record) -> Result<(), SinkError> {
            panic!("faulty sink");
        }
    }
    let fault = run(&short(), "test", &mut Broken, Monitor::default()).unwrap_err();
    let said = fault.to_string();
    assert!(
        said.contains("`record`") && said.contains("faulty sink"),
        "{said}"
    );
}

/// An unstable fixed step is rejected before the run.
#[test]
fn unstable_steps_are_rejected() {
    let mut scene = short();
    scene.integrator.method = squeakscope::dynamics::MethodName::Rk4;
    scene.integrator.max_step = 1e-3;
    let fault = run(&scene, "test", &mut Vec::new(), Monitor::default()).unwrap_err();
    assert!(matches!(fault, PipelineError::Step { .. }), "{fault:?}");
    assert!(fault.to_string().contains("below 36.1"), "{fault}");
}
