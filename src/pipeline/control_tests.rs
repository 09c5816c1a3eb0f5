//! Numbers of a scene that commands change.

use crate::joint::Friction;
use crate::pipeline::message::{DisplayRates, Frame};
use crate::pipeline::{Simulation, Source};
use crate::scene::{Control, PRESETS, Parameter, Scene};

/// Samples of a frame.
const SAMPLES: usize = 128;

fn interactive(scene: &Scene) -> Simulation {
    let mut source = Simulation::new(&scene.clone().without_analyses()).unwrap();
    source.run_until_stopped();
    let (_, shown) = DisplayRates::at_speed(0.02, scene.sample_rate);
    source.set_frame_length(SAMPLES, shown);
    source
}

fn next(source: &mut Simulation) -> Frame {
    source.next_frame().unwrap().expect("the run continues")
}

/// Largest difference of the velocities of two frames, relative to the largest velocity.
fn difference(a: &Frame, b: &Frame) -> f64 {
    let size = b
        .velocity
        .iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    let pairs = a.velocity.iter().zip(&b.velocity);
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / size
}

/// A number that is set before the first sample gives the motion of the scene with that number, for every named number
/// of every scene.
#[test]
fn a_number_set_at_the_start_is_the_number_of_the_scene() {
    for preset in PRESETS {
        // With `carry = "displacement"` a change is a step, which excites the joint.
        let overrides = [("time.tolerance", "1e-8"), ("time.carry", "absent")];
        let scene = preset.scene().unwrap().with_overrides(&overrides).unwrap();
        let friction = scene.joint().map(|joint| &joint.spec.friction);
        if matches!(friction, Ok(Friction::Dynamic { .. })) {
            // Bristles and contacts keep their state, which is not that of the new equilibrium.
            continue;
        }
        for Control {
            parameter,
            range,
            is_named,
            ..
        } in scene.live_controls()
        {
            if !is_named {
                continue;
            }
            let value = range[0] + 0.7 * (range[1] - range[0]);
            let mut changed = interactive(&scene);
            changed.set(parameter, value).unwrap();
            let mut expected = scene.clone();
            expected.set(parameter, value).unwrap();
            let [changed, expected] =
                [changed, interactive(&expected)].map(|mut run| next(&mut run));
            let off = difference(&changed, &expected);
            assert!(
                off < 1e-3,
                "{}: {} = {value}: {off:e}",
                preset.name,
                parameter.path()
            );
            assert_eq!(*changed.changed, [(parameter, value)]);
        }
    }
}

/// The motion goes on from its present state: the first sample after a change is the one without it, up to the step of the
/// equilibrium, and a change and its reverse leave the system as it was.
#[test]
fn the_motion_goes_on_and_a_change_can_be_taken_back() {
    for (scene, name, value, start) in [
        (
            "periodic-2deg",
            "friction.stribeck_slope_s_per_m",
            12.0,
            10.0,
        ),
        ("periodic-2deg", "load_n", 200.0, 150.0),
        (
            "negative-slope",
            "mass_on_belt.belt_speed_mm_per_s",
            30.0,
            20.0,
        ),
        (
            "damped-contact",
            "damped_contact.drive_amplitude_m_per_s2",
            80.0,
            60.0,
        ),
    ] {
        let scene = Scene::load(scene).unwrap();
        let parameter = Parameter::named(name).unwrap();
        let [mut plain, mut changed] = [interactive(&scene), interactive(&scene)];
        for source in [&mut plain, &mut changed] {
            next(source);
        }
        changed.set(parameter, value).unwrap();
        changed.set(parameter, start).unwrap();
        let off = difference(&next(&mut changed), &next(&mut plain));
        assert!(off < 1e-3, "{name} changed and back: {off:e}");
        changed.set(parameter, value).unwrap();
        let [after, without] = [changed, plain].map(|mut run| next(&mut run));
        assert!((after.velocity[0] - without.velocity[0]).abs() < 1e-3 * without.velocity[0].abs());
        assert!(difference(&after, &without) > 1e-6, "{name} has no effect");
    }
}

/// The scene with a patch up to 76 degrees from its axis.
pub(super) fn wide_patch(scene: &Scene) -> Scene {
    let wide =
        "[{ radius_mm = 0.0, pressure_mpa = 1.0 }, { radius_mm = 15.4, pressure_mpa = 0.0 }]";
    scene.with_overrides(&[("contact.pressure", wide)]).unwrap()
}

#[test]
fn a_refused_number_leaves_the_run_as_it_was() {
    let scene = wide_patch(&Scene::load("lift-off").unwrap());
    let [mut source, mut plain] = [interactive(&scene), interactive(&scene)];
    let load = Parameter::named("load.load_n").unwrap();
    // There this wide patch reaches the beam; and no scene has a negative load.
    assert!(source.set(Parameter::tilt(), 89.0).is_err());
    assert!(source.set(load, -1.0).is_err());
    assert_eq!(next(&mut source).velocity, next(&mut plain).velocity);
}

#[test]
fn a_drive_keeps_its_phase_when_its_frequency_changes() {
    for (name, key) in [
        ("impact-oscillator", "impact_oscillator.drive_frequency_hz"),
        ("damped-contact", "damped_contact.drive_frequency_hz"),
    ] {
        let scene = Scene::load(name).unwrap();
        let frequency = Parameter::named(key).unwrap();
        let [mut plain, mut changed] = [interactive(&scene), interactive(&scene)];
        for source in [&mut plain, &mut changed] {
            // Two thirds of a radian of the new frequency earlier or later.
            source.seek(10.0).unwrap();
        }
        let before = scene.value_of(frequency).unwrap();
        changed.set(frequency, before + 0.01).unwrap();
        let off = difference(&next(&mut changed), &next(&mut plain));
        assert!(off > 0.0 && off < 1e-2, "{name}: {off:e}");
    }
}
