//! Sweeps over few points.

use super::*;
use crate::scene::{Parameter, Scene};
use crate::study::response::ResponsePlan;

/// Why an audience has had enough.
#[derive(Debug, PartialEq)]
struct Fault(&'static str);

impl std::convert::From<NoThread> for Fault {
    fn from(_: NoThread) -> Self {
        Self("no thread")
    }
}

/// Keeps the points; stops after so many.
struct Notes {
    points: Vec<SweepPoint>,
    stop_after: usize,
}

impl Audience for Notes {
    type Error = Fault;

    fn point(&mut self, point: SweepPoint) -> Result<(), Fault> {
        self.points.push(point);
        Ok(())
    }

    fn progress(&mut self, progress: SweepProgress) -> bool {
        assert!(progress.done <= progress.all && (0.0..=1.0).contains(&progress.share));
        self.points.len() < self.stop_after
    }
}

fn plan() -> SweepPlan {
    let mut scene = Scene::load("torus-3deg").unwrap();
    scene = scene
        .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
        .unwrap();
    SweepPlan {
        scene,
        axes: vec![Axis::new(Parameter::tilt(), [1.0, 2.0, 3.0])],
        starts: vec![Start::Up, Start::Cold],
        response: ResponsePlan {
            least: 0.02,
            most: 0.04,
            measure: 0.02,
            exponents: 1,
            portrait: true,
            most_calls: None,
        },
    }
}

/// The points of a sweep in their order.
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
fn the_points_depend_on_nothing_but_the_plan() {
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
    // Going on in the middle of a chain.
    let known = [one[0].clone(), one[1].clone(), one[4].clone()];
    let rest = run(&plan, Shard::WHOLE, &known, 2);
    assert_eq!(rest, [one[2].clone(), one[3].clone(), one[5].clone()]);
    // The lowest is started by the kick in both; the next one up is not.
    assert_eq!(one[0].outcome, one[3].outcome);
    assert_ne!(one[1].outcome, one[4].outcome);
}

#[test]
fn a_sweep_that_is_stopped_keeps_what_it_has() {
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
fn a_point_that_cannot_be_is_told_and_the_rest_goes_on() {
    let diameter = Parameter::named("socket.diameter_mm").unwrap();
    let plan = SweepPlan {
        // A socket that the ball does not go into.
        axes: vec![Axis::new(diameter, [31.0, 31.95])],
        starts: vec![Start::Down],
        ..plan()
    };
    let points = run(&plan, Shard::WHOLE, &[], 2);
    let told = points[0].outcome.as_ref().unwrap_err();
    assert!(told.contains("socket.diameter_mm"), "{told}");
    assert!(points[1].outcome.is_ok());
    assert_eq!(points.len(), 2);
}

#[test]
fn an_audience_that_fails_ends_it() {
    struct Full;
    impl Audience for Full {
        type Error = Fault;
        fn point(&mut self, _: SweepPoint) -> Result<(), Fault> {
            Err(Fault("no space"))
        }
        fn progress(&mut self, _: SweepProgress) -> bool {
            true
        }
    }
    let ended = sweep(&plan(), Shard::WHOLE, &[], 2, &mut Full);
    assert_eq!(ended, Err(Fault("no space")));
}
