//! Tests of interactive runs.

use std::sync::atomic::Ordering;

use super::*;
use crate::pipeline::control_tests::wide_patch;
use crate::pipeline::message::Record;
use crate::pipeline::{Analyser, Simulation};
use crate::scene::AnalysisSpec;

fn interactive(scene: &str, speed: f64) -> (InteractiveSource, RunHandle) {
    let scene = Scene::load(scene).unwrap().without_analyses();
    let handle = RunHandle::new(speed);
    let run = InteractiveSource::new(Simulation::new(&scene).unwrap(), &handle);
    (run, handle)
}

fn next(run: &mut InteractiveSource) -> Frame {
    run.next_frame().unwrap().expect("the run continues")
}

/// So fast that no frame waits for wall time.
const FAST: f64 = 1e3;

#[test]
fn a_run_continues_after_its_planned_time() {
    let (mut run, handle) = interactive("periodic-2deg", FAST);
    let planned = run.header("").duration;
    assert!(run.header("").endless);
    let mut end = 0.0;
    while end < 1.2 * planned {
        let frame = next(&mut run);
        assert!((frame.t0 - end).abs() < 1e-12);
        end = frame.end();
    }
    handle.send(RunCommand::End).unwrap();
    assert!(run.next_frame().unwrap().is_none() && run.is_finished());
}

#[test]
fn a_tilt_applies_to_the_next_frame_and_is_an_event() {
    let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
    next(&mut run);
    for degrees in [1.0, 2.0, 4.5_f64] {
        handle
            .send(RunCommand::Set(Parameter::tilt(), degrees))
            .unwrap();
    }
    let frame = next(&mut run);
    assert_eq!(frame.tilt, 4.5_f64.to_radians());
    assert_eq!(frame.events, ["tilt 4.5 deg"], "only the last tilt applies");
    assert_eq!(next(&mut run).events, [""; 0]);
}

#[test]
fn a_run_continues_from_the_state_of_another() {
    for scene in [
        "doubled-torus-3deg",
        "bristles",
        "articulation",
        "impact-oscillator",
        "mass-on-belt",
    ] {
        let (mut first, handle) = interactive(scene, FAST);
        let mut before = next(&mut first);
        let change = (scene == "impact-oscillator").then(|| {
            let frequency = Parameter::named("impact_oscillator.drive_frequency_hz").unwrap();
            RunCommand::Set(frequency, 500.0)
        });
        if let Some(change) = &change {
            handle.send(change.clone()).unwrap();
            before = next(&mut first);
        }
        let (mut second, handle) = interactive(scene, FAST);
        let state = before.state.expect("a live run");
        handle.send(RunCommand::Continue(state)).unwrap();
        if let Some(change) = change {
            handle.send(change).unwrap();
        }
        let velocities = |run: &mut InteractiveSource, count| {
            let mut velocity = Vec::new();
            while velocity.len() < count {
                velocity.extend(next(run).velocity);
            }
            velocity
        };
        // The second run begins with the sample of the state.
        let expected = velocities(&mut first, 400);
        let found = velocities(&mut second, 401);
        let size = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let expected = before.velocity.last().into_iter().chain(&expected);
        for (a, b) in expected.zip(&found).take(401) {
            assert!((a - b).abs() < 1e-3 * size, "{scene}: {a} {b} of {size}");
        }
    }
}

/// Commands that do not act on the load leave the motion bit-identical.
#[test]
fn playback_commands_do_not_change_the_motion() {
    let scene = Scene::load("doubled-torus-3deg")
        .unwrap()
        .without_analyses();
    let mut planned = Simulation::new(&scene).unwrap();
    let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
    let mut seen = Vec::new();
    for commands in [
        vec![RunCommand::Speed(2.0 * FAST)],
        vec![RunCommand::Pause, RunCommand::Resume],
        vec![RunCommand::Step, RunCommand::Resume],
    ] {
        seen.extend(next(&mut run).velocity);
        for command in commands {
            handle.send(command).unwrap();
        }
    }
    seen.extend(next(&mut run).velocity);
    let mut expected = Vec::new();
    while expected.len() < seen.len() {
        expected.extend(planned.next_frame().unwrap().unwrap().velocity);
    }
    assert_eq!(seen, expected[..seen.len()]);
}

#[test]
fn a_kick_changes_the_velocities_and_is_audited() {
    let (mut run, handle) = interactive("periodic-2deg", 0.01);
    let mut residual = 0.0_f64;
    let mut largest = 0.0_f64;
    for k in 0..20 {
        if k == 10 {
            handle
                .send(RunCommand::Kick {
                    size: 1e-3,
                    seed: 7,
                })
                .unwrap();
        }
        let frame = next(&mut run);
        let of = |rows: &[f64]| rows.iter().map(|v| v * v).sum::<f64>().sqrt();
        let first = of(&frame.qdot[..frame.modes]);
        if k == 10 {
            assert!(first > 1e-3 && first < 1e-2, "{first}");
            assert_eq!(frame.events, ["kick of 1 mm/s, seed 7"]);
            let kick = Kick {
                time_s: frame.t0,
                size: 1e-3,
                seed: 7,
            };
            assert_eq!(frame.kicks, [kick]);
        } else if k < 10 {
            assert!(first < 3e-4, "{first}");
        }
        for sample in &frame.energy {
            residual = residual.max(sample.residual.abs());
            largest = largest.max(sample.total.abs());
        }
    }
    assert!(residual < 1e-2 * largest, "{residual} of {largest}");
}

#[test]
fn a_paused_run_advances_by_single_frames_only() {
    let (mut run, handle) = interactive("mass-on-belt", FAST);
    let first = next(&mut run);
    for order in [RunCommand::Pause, RunCommand::Step] {
        handle.send(order).unwrap();
    }
    let second = next(&mut run);
    assert_eq!(second.t0, first.end());
    assert_eq!(second.events, ["paused", "single step"]);
    assert!(handle.status().paused);
    let waiting = std::thread::spawn(move || next(&mut run));
    std::thread::sleep(Duration::from_millis(50));
    handle.send(RunCommand::Resume).unwrap();
    assert_eq!(waiting.join().unwrap().t0, second.end());
}

#[test]
fn frames_follow_the_playback_speed() {
    let speed = 0.02;
    let (mut run, handle) = interactive("mass-on-belt", speed);
    let began = Instant::now();
    let mut end = 0.0;
    while end < 0.6 * speed {
        end = next(&mut run).end();
    }
    // A busy machine may be late, but never early.
    assert!(began.elapsed().as_secs_f64() > 0.5);
    let reached = handle.status().measured_speed.expect("measured");
    assert!(reached < 1.2 * speed, "{reached}");
}

#[test]
fn many_commands_between_two_frames_are_combined() {
    let (mut run, handle) = interactive("periodic-2deg", FAST);
    handle.send(RunCommand::Pause).unwrap();
    let mut refused = 0;
    for seed in 0..100_000 {
        let size = 1e-6;
        refused += usize::from(handle.send(RunCommand::Kick { size, seed }).is_err());
        handle
            .send(RunCommand::Set(Parameter::tilt(), 0.03_f64.to_degrees()))
            .unwrap();
        handle.send(RunCommand::Speed(FAST + seed as f64)).unwrap();
    }
    assert_eq!(refused, 100_000 - MAX_KICKS_PER_FRAME);
    handle.send(RunCommand::Step).unwrap();
    let events = next(&mut run).events;
    let kicks = events.iter().filter(|words| words.starts_with("kick"));
    assert_eq!(kicks.count(), MAX_KICKS_PER_FRAME);
    let others = ["playback speed", "paused", "single step", "tilt"].len();
    assert_eq!(events.len(), MAX_KICKS_PER_FRAME + others, "{events:?}");
    handle
        .send(RunCommand::Kick {
            size: 1e-6,
            seed: 0,
        })
        .expect("the next frame accepts kicks again");
}

/// The list of descriptions does not grow while a run is paused.
#[test]
fn repeated_commands_are_described_once() {
    let (mut run, _handle) = interactive("mass-on-belt", FAST);
    for k in 0..1000 {
        for pause in [Some(true), Some(false)] {
            let mut pending = lock(&run.handle.pending);
            pending.control.speed = Some(FAST + f64::from(k));
            pending.control.pause = pause;
            drop(pending);
            run.apply_controls();
        }
    }
    assert_eq!(
        run.done,
        ["playback speed 1.999e6 ms/s", "paused", "resumed"]
    );
}

#[test]
fn repeated_speed_changes_do_not_accelerate_the_run() {
    let speed = 0.02;
    let (mut run, handle) = interactive("mass-on-belt", speed);
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                for speed in [0.9 * speed, speed] {
                    handle.send(RunCommand::Speed(speed)).unwrap();
                }
            }
        });
        let began = Instant::now();
        while next(&mut run).end() < 0.3 * speed {}
        over.store(true, Ordering::Relaxed);
        assert!(began.elapsed().as_secs_f64() > 0.25);
    });
}

#[test]
fn the_drawn_share_depends_on_the_speed() {
    let (mut run, handle) = interactive("doubled-torus-3deg", 1e-3);
    let slow = next(&mut run).shown.unwrap();
    assert_eq!((slow.every, slow.pictures), (1, 20e3));
    handle.send(RunCommand::Speed(1.0)).unwrap();
    let frame = next(&mut run);
    let fast = frame.shown.unwrap();
    assert_eq!((fast.every, fast.pictures), (10, 20.0));
    assert_eq!(frame.len(), 3333);
}

#[test]
fn events_precede_the_samples_they_change() {
    let (mut run, handle) = interactive("doubled-torus-3deg", FAST);
    handle
        .send(RunCommand::Set(Parameter::tilt(), 0.05_f64.to_degrees()))
        .unwrap();
    let mut records: Vec<Record> = Vec::new();
    let mut analyser = Analyser::new(&AnalysisSpec::default(), &run.header(""));
    analyser
        .push(&Arc::new(next(&mut run)), &mut records)
        .unwrap();
    assert!(matches!(&records[0], Record::Event { time: 0.0, text } if text == "tilt 2.86479 deg"));
    assert!(matches!(records[1], Record::Samples(_)));
}

/// The run continues as it was: also with a wide patch that would reach the beam.
#[test]
fn a_number_that_a_run_cannot_take_is_refused() {
    let load = Parameter::named("load.load_n").unwrap();
    let small = Scene::load("mass-on-belt").unwrap();
    let wide = wide_patch(&Scene::load("lift-off").unwrap());
    for (scene, tilt) in [(small, 3.0), (wide, 89.0)] {
        let scene = scene.without_analyses();
        let handle = RunHandle::new(FAST);
        let mut run = InteractiveSource::new(Simulation::new(&scene).unwrap(), &handle);
        // A small system has no load either.
        handle.send(RunCommand::Set(load, 200.0)).unwrap();
        next(&mut run);
        handle.take_refusal();
        let before = run.source.scene().clone();
        handle
            .send(RunCommand::Set(Parameter::tilt(), tilt))
            .unwrap();
        let frame = next(&mut run);
        let refused = format!("tilt {tilt} deg refused: ");
        assert!(frame.events[0].starts_with(&refused), "{:?}", frame.events);
        assert!(!frame.changed.iter().any(|(p, _)| *p == Parameter::tilt()));
        assert_eq!(handle.take_refusal(), Some(before));
    }
}

#[test]
fn a_million_commands_are_combined_into_a_few() {
    let mut pending = PendingCommands::default();
    let mut refused = 0;
    for k in 0..1_000_000_u64 {
        let x = k as f64;
        let kick = RunCommand::Kick { size: x, seed: k };
        for command in [
            RunCommand::Set(Parameter::tilt(), x),
            RunCommand::Pause,
            RunCommand::Speed(1.0 + x),
            kick,
        ] {
            refused += u64::from(pending.add(command).is_err());
        }
    }
    assert_eq!(refused, 1_000_000 - MAX_KICKS_PER_FRAME as u64);
    let expected = PendingCommands {
        start: None,
        refusal: None,
        values: vec![(Parameter::tilt(), 999_999.0)],
        kicks: (0..MAX_KICKS_PER_FRAME as u64)
            .map(|k| (k as f64, k))
            .collect(),
        control: Control {
            pause: Some(true),
            speed: Some(1e6),
            ..Control::default()
        },
    };
    assert_eq!(pending, expected);
}

#[test]
fn the_last_of_pause_step_and_resume_counts() {
    let after = |commands: &[RunCommand]| {
        let mut pending = PendingCommands::default();
        for command in commands {
            pending.add(command.clone()).unwrap();
        }
        (pending.control.pause, pending.control.step)
    };
    assert_eq!(
        after(&[RunCommand::Pause, RunCommand::Resume]),
        (Some(false), false)
    );
    assert_eq!(
        after(&[RunCommand::Step, RunCommand::Resume]),
        (Some(false), false)
    );
    assert_eq!(
        after(&[RunCommand::Resume, RunCommand::Step]),
        (Some(true), true)
    );
    assert_eq!(
        after(&[RunCommand::Step, RunCommand::Pause]),
        (Some(true), true)
    );
}
