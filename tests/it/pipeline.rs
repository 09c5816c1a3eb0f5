//! The road: order, back-pressure, repeatability, stops and faults.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Monitor, PipelineError, Sink, SinkError, run};
use squeakscope::scene::Scene;

fn short() -> Scene {
    Scene::load("torus-3deg")
        .unwrap()
        .with_duration(12.0)
        .unwrap()
}

fn records(scene: &Scene) -> Vec<Record> {
    let mut sink = Vec::new();
    run(scene, "test", &mut sink, Monitor::default()).unwrap();
    sink
}

/// The numbers of a run, without those that tell the time of day.
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
    assert!((summary.simulated - 12e-3).abs() < 1e-12);
    assert!(summary.tally.steps > 0 && !summary.interrupted && summary.wall > 0.0);
}

/// The same scene gives the same numbers, to the last bit.
#[test]
fn runs_repeat() {
    assert_eq!(numbers(&records(&short())), numbers(&records(&short())));
}

/// The energy that is there is the energy that came in.
#[test]
fn energy_is_audited() {
    let mut scene = Scene::load("tilt-ramp")
        .unwrap()
        .with_duration(90.0)
        .unwrap();
    scene.integrator.tolerance = 1e-8;
    let mut worst: f64 = 0.0;
    let mut turnover: f64 = 0.0;
    for record in records(&scene) {
        if let Record::Samples(frame) = record {
            for energy in &frame.energy {
                turnover = turnover.max(energy.total);
                worst = worst.max(energy.residual.abs());
            }
        }
    }
    assert!(turnover > 1e-9, "the joint must squeak: {turnover} J");
    assert!(worst < 1e-5 * turnover, "{worst:e} J of {turnover:e} J");
}

/// Stops at a frame's border, keeps what was there, and says so.
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
    let scene = Scene::load("torus-3deg").unwrap();
    let summary = run(&scene, "test", &mut sink, monitor).unwrap();
    assert!(summary.interrupted && summary.simulated < 0.1 * scene.duration);
    assert!(matches!(sink.2.last(), Some(Record::Summary(_))));
}

/// A sink that fails ends the run with its own error, and is abandoned, not finished.
#[test]
fn a_failing_sink_is_the_run_s_error() {
    #[derive(Default)]
    struct Full {
        taken: usize,
        finished: bool,
        abandoned: bool,
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
        fn abandon(&mut self) {
            self.abandoned = true;
        }
    }
    let mut sink = Full::default();
    let scene = Scene::load("torus-3deg").unwrap();
    let fault = run(&scene, "test", &mut sink, Monitor::default()).unwrap_err();
    let PipelineError::Sink(source) = fault else {
        panic!("{fault:?}")
    };
    assert_eq!(source.to_string(), "the disk is full");
    assert!(sink.abandoned && !sink.finished);
}

/// What a scene does not ask for is not there.
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

/// A run whose duration is no whole number of samples is complete, not interrupted.
#[test]
fn odd_durations_are_complete() {
    let mut scene = Scene::load("torus-3deg").unwrap();
    scene.duration = 1.2324e-3;
    let summary = run(&scene, "test", &mut Vec::new(), Monitor::default()).unwrap();
    assert!(!summary.interrupted);
    assert!((summary.simulated - 246.0 / 200e3).abs() < 1e-15);
}

/// A panic on the recorder's thread is the run's error, like one on any other.
#[test]
fn a_panicking_sink_is_the_run_s_error() {
    struct Broken;
    impl Sink for Broken {
        fn accept(&mut self, _: Record) -> Result<(), SinkError> {
            panic!("out of ink");
        }
    }
    let fault = run(&short(), "test", &mut Broken, Monitor::default()).unwrap_err();
    let said = fault.to_string();
    assert!(
        said.contains("`record`") && said.contains("out of ink"),
        "{said}"
    );
}

/// A fixed step that cannot be stable is refused before anything runs.
#[test]
fn hopeless_steps_are_refused() {
    let mut scene = short();
    scene.integrator.method = squeakscope::dynamics::MethodName::Rk4;
    scene.integrator.max_step = 1e-3;
    let fault = run(&scene, "test", &mut Vec::new(), Monitor::default()).unwrap_err();
    assert!(matches!(fault, PipelineError::Step { .. }), "{fault:?}");
    assert!(fault.to_string().contains("below 36.1"), "{fault}");
}
