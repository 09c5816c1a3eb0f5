//! Sweeps with few points.

use super::*;
use crate::dynamics::continuation::BifurcationKind;
use crate::scene::{Parameter, Scene};
use crate::study::Stopped;
use crate::study::response::ResponsePlan;

fn plan() -> SweepPlan {
    let mut scene = Scene::load("doubled-torus-3deg").unwrap();
    scene = scene
        .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
        .unwrap();
    SweepPlan {
        subject: scene,
        axes: vec![Axis::new(Parameter::tilt(), [1.0, 2.0, 3.0])],
        starts: vec![Start::Upward, Start::Fresh],
        response: ResponsePlan {
            min_transient_s: 0.02,
            max_transient_s: 0.04,
            measurement_s: 0.02,
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
    known: Vec<SweepPoint>,
    threads: usize,
) -> Vec<SweepPoint> {
    let is_known = |index: &usize| known.iter().any(|point| point.place.index == *index);
    let mut missing = plan.chains(shard).concat();
    missing.retain(|index| !is_known(index));
    missing.sort_unstable();
    let mut computed = Vec::new();
    let mut progress = |share: f64, _: &str| {
        assert!((0.0..=1.0).contains(&share));
        Ok(())
    };
    let points = sweep(plan, shard, known, threads, &mut progress, |point| {
        computed.push(point.place.index);
        Ok::<_, StudyError>(())
    });
    computed.sort_unstable();
    assert_eq!(computed, missing);
    points.unwrap()
}

#[test]
fn the_points_depend_only_on_the_plan() {
    let plan = plan();
    let one = run(&plan, Shard::WHOLE, Vec::new(), 1);
    assert_eq!(one.len(), 6);
    assert!(one.iter().all(|point| point.outcome.is_ok()), "{one:?}");
    assert_eq!(one, run(&plan, Shard::WHOLE, Vec::new(), 3));
    let mut shards: Vec<SweepPoint> = (1..=3)
        .flat_map(|number| run(&plan, Shard { number, of: 3 }, Vec::new(), 2))
        .collect();
    shards.sort_by_key(|point| point.place.index);
    assert_eq!(one, shards);
    // Resume in the middle of a chain.
    let known = [0, 1, 4].map(|k| one[k].clone()).to_vec();
    assert_eq!(one, run(&plan, Shard::WHOLE, known, 2));
    // With both starts the lowest point starts from the kick; the next one does not.
    assert_eq!(one[0].outcome, one[3].outcome);
    assert_ne!(one[1].outcome, one[4].outcome);
    let result = SweepResult::new(&plan, one, Shard::WHOLE);
    crate::report::agreement::check(&result, &[]);
}

#[test]
fn a_stopped_sweep_keeps_its_points() {
    let count = std::cell::Cell::new(0);
    let mut progress = |_: f64, _: &str| {
        if count.get() < 2 {
            Ok(())
        } else {
            Err(Stopped)
        }
    };
    let (plan, known) = (plan(), Vec::new());
    let points = sweep(&plan, Shard::WHOLE, known, 1, &mut progress, |_| {
        count.set(count.get() + 1);
        Ok::<_, StudyError>(())
    });
    assert_eq!(points.unwrap().len(), count.get());
    assert!((2..6).contains(&count.get()), "{}", count.get());
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
    let points = run(&plan, Shard::WHOLE, Vec::new(), 2);
    let message = points[0].outcome.as_ref().unwrap_err();
    assert!(message.contains("socket.diameter_mm"), "{message}");
    assert!(points[1].outcome.is_ok());
    assert_eq!(points.len(), 2);
}

#[test]
fn an_error_of_the_observer_ends_the_sweep() {
    let full = || StudyError::Threads("no space".to_owned());
    let mut progress = |_: f64, _: &str| Ok(());
    let ended = sweep(&plan(), Shard::WHOLE, Vec::new(), 2, &mut progress, |_| {
        Err(full())
    });
    assert_eq!(ended.unwrap_err().to_string(), full().to_string());
}

/// The period of `damped-contact` doubles at 366.46 Hz. The values of the hysteresis are given here.
#[test]
fn the_result_has_the_bifurcation_that_ends_the_hysteresis() {
    let key = Parameter::named("damped_contact.drive_frequency_hz").unwrap();
    let plan = SweepPlan {
        subject: Scene::load("damped-contact").unwrap(),
        axes: vec![Axis::new(key, [360.0, 380.0])],
        starts: vec![Start::Upward],
        response: ResponsePlan {
            max_transient_s: 1.0,
            measurement_s: 0.1,
            exponents: 0,
            ..plan().response
        },
    };
    let points = run(&plan, Shard::WHOLE, Vec::new(), 2);
    let differing = || SweepResult {
        hysteresis: vec![360.0],
        ..SweepResult::new(&plan, points.clone(), Shard::WHOLE)
    };
    let result = differing().concluded(&plan, &mut |_, _| Ok(()));
    let [end] = &result.hysteresis_ends[..] else {
        panic!("{result:?}");
    };
    assert_eq!(end.kind, BifurcationKind::PeriodDoubling);
    assert!((end.value - 366.46437).abs() < 1e-4, "{end:?}");
    assert!(!result.interrupted && result.warnings.is_empty());
    crate::report::agreement::check(&result, &[]);
    let stopped = differing().concluded(&plan, &mut |_, _| Err(Stopped));
    assert!(stopped.interrupted && stopped.hysteresis_ends.is_empty());
}
