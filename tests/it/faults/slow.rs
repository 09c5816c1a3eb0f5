//! A consumer ten times too slow: only pictures are dropped, and only if nothing is saved.

use std::time::{Duration, Instant};

use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Monitor, Sink, SinkError, run};
use squeakscope::scene::Scene;

/// A sink with a delay per record.
struct Slow {
    pause: Duration,
    may_skip_pictures: bool,
    taken: Vec<Record>,
}

impl Sink for Slow {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        std::thread::sleep(self.pause);
        self.taken.push(record);
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        self.may_skip_pictures
    }
}

fn records(pause: Duration, may_skip_pictures: bool) -> Vec<Record> {
    let scene = Scene::load("doubled-torus-3deg").expect("preset");
    let scene = scene.with_duration(70.0).expect("in range");
    let mut sink = Slow {
        pause,
        may_skip_pictures,
        taken: Vec::new(),
    };
    run(&scene, "test", &mut sink, Monitor::default()).expect("done");
    sink.taken
}

fn pictures(records: &[Record]) -> usize {
    records.iter().filter(|record| record.is_picture()).count()
}

/// Records that must not be dropped: times of samples, texts and numbers.
fn kept(records: &[Record]) -> Vec<String> {
    let kept = records.iter().filter(|record| !record.is_picture());
    kept.filter_map(|record| match record {
        Record::Samples(frame) => Some(format!("{} {:?}", frame.index, frame.displacement)),
        // Health and summary contain wall times.
        Record::Health(_) | Record::Summary(_) => None,
        other => Some(format!("{other:?}")),
    })
    .collect()
}

fn drops(records: &[Record]) -> u64 {
    let health = records.iter().rev().find_map(|record| match record {
        Record::Health(health) => Some(health.drops),
        _ => None,
    });
    health.expect("health")
}

#[test]
fn a_slow_consumer_loses_only_replaced_pictures() {
    let began = Instant::now();
    let all = records(Duration::ZERO, false);
    // Ten times the duration of the whole run.
    let pause = 10 * began.elapsed() / all.len() as u32;

    // On a busy machine a run may take many times as long as the first one.
    let watched = [1, 4, 16].map(|times| times * pause).into_iter();
    let mut watched = watched.map(|pause| records(pause, true));
    let watched = watched.find(|watched| pictures(watched) < pictures(&all));
    let watched = watched.expect("replaced pictures");
    assert_eq!(kept(&watched), kept(&all));
    let replaced = (pictures(&all) - pictures(&watched)) as u64;
    assert_eq!(drops(&watched), replaced);
    // The newest picture of a kind is kept.
    let last = |records: &[Record]| {
        let spectrum = records
            .iter()
            .rev()
            .find(|r| matches!(r, Record::Spectrum { .. }));
        format!("{:?}", spectrum.expect("a spectrum"))
    };
    assert_eq!(last(&watched), last(&all));

    let saved = records(pause, false);
    assert_eq!(kept(&saved), kept(&all));
    assert_eq!((pictures(&saved), drops(&saved)), (pictures(&all), 0));
}
