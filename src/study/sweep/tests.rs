//! Sweeps with few points.

use super::*;
use crate::scene::{Parameter, Scene};
use crate::study::response::ResponsePlan;

/// An error of the observer.
#[derive(Debug, PartialEq)]
struct Fault(&'static str);

impl From<ThreadSpawnError> for Fault {
    fn from(_: ThreadSpawnError) -> Self {
        Self("no thread")
    }
}

/// Collects the points, and stops after a number of them.
struct Notes {
    points: Vec<SweepPoint>,
    stop_after: usize,
}

impl SweepObserver for Notes {
    type Error = Fault;

    fn on_point(&mut self, point: SweepPoint) -> Result<(), Fault> {
        self.points.push(point);
        Ok(())
    }

    fn on_progress(&mut self, progress: SweepProgress) -> Result<(), Stopped> {
        assert!(progress.done <= progress.all && (0.0..=1.0).contains(&progress.share));
        if self.points.len() < self.stop_after {
            Ok(())
        } else {
            Err(Stopped)
        }
    }
}

fn plan() -> SweepPlan {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene = scene
        .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
        .unwrap();
    SweepPlan {
        scene,
        axes: vec![Axis::new(Parameter::tilt(), [1.0, 2.0, 3.0])],
        starts: vec![Start::Upward, Start::Fresh],
        response: ResponsePlan {
            min_transient: 0.02,
            max_transient: 0.04,
            measurement_time: 0.02,
            exponents: 1,
            orbits: false,
            portrait: true,
            max_rhs_evals: None,
        },
    }
}

/// The points of a sweep in ascending order of index.
pub(in crate::study) fn run(
    plan: &SweepPlan,
    shard: Shard,
    known: &[SweepPoint],
    threads: usize,
) -> Vec<SweepPoint> {
    let mut notes = Notes {
        points: Vec::new(),
        stop_after: usize::MAX,
    };
    assert_eq!(sweep(plan, shard, known, threads, &mut notes), Ok(true));
    notes.points.sort_by_key(|point| point.place.index);
    notes.points
}

#[test]
fn the_points_depend_only_on_the_plan() {
    let plan = plan();
    let one = run(&plan, Shard::WHOLE, &[], 1);
    assert_eq!(one.len(), 6);
    assert!(one.iter().all(|point| point.outcome.is_ok()), "{one:?}");
    assert_eq!(one, run(&plan, Shard::WHOLE, &[], 3));
    let mut shards: Vec<SweepPoint> = (1..=3)
        .flat_map(|number| run(&plan, Shard { number, of: 3 }, &[], 2))
        .collect();
    shards.sort_by_key(|point| point.place.index);
    assert_eq!(one, shards);
    // Resume in the middle of a chain.
    let known = [one[0].clone(), one[1].clone(), one[4].clone()];
    let rest = run(&plan, Shard::WHOLE, &known, 2);
    assert_eq!(rest, [one[2].clone(), one[3].clone(), one[5].clone()]);
    // With both starts the lowest point starts from the kick; the next one does not.
    assert_eq!(one[0].outcome, one[3].outcome);
    assert_ne!(one[1].outcome, one[4].outcome);
    let result = SweepResult::new(&plan, one, Shard::WHOLE, false);
    crate::report::agreement::check(&result, &[]);
}

#[test]
fn a_stopped_sweep_keeps_its_points() {
    let mut notes = Notes {
        points: Vec::new(),
        stop_after: 2,
    };
    assert_eq!(sweep(&plan(), Shard::WHOLE, &[], 1, &mut notes), Ok(false));
    assert!(
        (2..6).contains(&notes.points.len()),
        "{}",
        notes.points.len()
    );
}

#[test]
fn a_failed_point_is_reported_and_the_sweep_continues() {
    let diameter = Parameter::named("socket.diameter_mm").unwrap();
    let plan = SweepPlan {
        // A socket smaller than the ball.
        axes: vec![Axis::new(diameter, [31.0, 31.95])],
        starts: vec![Start::Downward],
        ..plan()
    };
    let points = run(&plan, Shard::WHOLE, &[], 2);
    let message = points[0].outcome.as_ref().unwrap_err();
    assert!(message.contains("socket.diameter_mm"), "{message}");
    assert!(points[1].outcome.is_ok());
    assert_eq!(points.len(), 2);
}

#[test]
fn an_error_of_the_observer_ends_the_sweep() {
    struct Full;
    impl SweepObserver for Full {
        type Error = Fault;
        fn on_point(&mut self, _: SweepPoint) -> Result<(), Fault> {
            Err(Fault("no space"))
        }
        fn on_progress(&mut self, _: SweepProgress) -> Result<(), Stopped> {
            Ok(())
        }
    }
    let ended = sweep(&plan(), Shard::WHOLE, &[], 2, &mut Full);
    assert_eq!(ended, Err(Fault("no space")));
}
