//! A consumer ten times too slow: pictures give way where nothing is saved, else everything waits.

use std::time::{Duration, Instant};

use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Delivery, Monitor, Sink, SinkError, run};
use squeakscope::scene::Scene;

/// Takes its time over each record.
struct Slow {
    pause: Duration,
    delivery: Delivery,
    taken: Vec<Record>,
}

impl Sink for Slow {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        std::thread::sleep(self.pause);
        self.taken.push(record);
        Ok(())
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }
}

fn records(pause: Duration, delivery: Delivery) -> Vec<Record> {
    let scene = Scene::load("torus-3deg").expect("preset");
    let scene = scene.with_duration(70.0).expect("in range");
    let mut sink = Slow {
        pause,
        delivery,
        taken: Vec::new(),
    };
    run(&scene, "test", &mut sink, Monitor::default()).expect("done");
    sink.taken
}

fn pictures(records: &[Record]) -> usize {
    records.iter().filter(|record| record.is_picture()).count()
}

/// What must come whatever happens: times of samples, words and numbers.
fn kept(records: &[Record]) -> Vec<String> {
    let kept = records.iter().filter(|record| !record.is_picture());
    kept.filter_map(|record| match record {
        Record::Samples(frame) => Some(format!("{} {:?}", frame.index, frame.displacement)),
        // They tell the time of day.
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
fn a_consumer_ten_times_too_slow_loses_nothing_but_old_pictures() {
    let began = Instant::now();
    let all = records(Duration::ZERO, Delivery::Everything);
    // Ten times what the whole run takes.
    let pause = 10 * began.elapsed() / all.len() as u32;

    let watched = records(pause, Delivery::LatestPictures);
    assert_eq!(kept(&watched), kept(&all));
    let replaced = (pictures(&all) - pictures(&watched)) as u64;
    println!("{replaced} of {} pictures replaced", pictures(&all));
    assert!(replaced > 0);
    assert_eq!(drops(&watched), replaced);
    // The newest of a kind is there.
    let last = |records: &[Record]| {
        let spectrum = records
            .iter()
            .rev()
            .find(|r| matches!(r, Record::Spectrum { .. }));
        format!("{:?}", spectrum.expect("a spectrum"))
    };
    assert_eq!(last(&watched), last(&all));

    let saved = records(pause, Delivery::Everything);
    assert_eq!(kept(&saved), kept(&all));
    assert_eq!((pictures(&saved), drops(&saved)), (pictures(&all), 0));
}
