//! Rotations that move the contact patch.

use crate::scene::*;

/// A joint under a rotation, with the given lines.
fn parsed(lines: &str) -> Result<Scene, SceneError> {
    Scene::parse(
        "mine.toml",
        format!(
            "{lines}\nrotation.moves_patch = true\nload.load_n = 150\ntime.duration_ms = 100\n"
        ),
    )
}

fn joint(lines: &str) -> LoadedJoint {
    let scene = parsed(lines).unwrap_or_else(|error| panic!("{error}"));
    scene.joint().expect("a joint").clone()
}

/// Direction of the load in the axes of the body at a time (s).
fn direction(joint: &LoadedJoint, time: f64) -> [f64; 3] {
    let loading = joint.loading(time);
    let patch = loading.patch.expect("a patch that has moved");
    patch.direction
}

/// The paper's rotation of 1 rad/s tilts the beam by 57 degrees per second towards the azimuth of 135 degrees,
/// smoothly through zero.
#[test]
fn the_rotation_of_the_paper_changes_the_tilt() {
    let joint = joint("load.tilt_deg = -8\nload.azimuth_deg = 135");
    assert_eq!(joint.loading(0.0).tilt, -8_f64.to_radians());
    assert_eq!(joint.loading(0.0).patch, None);
    for k in 1..=300 {
        let time = 1e-3 * f64::from(k);
        let loading = joint.loading(time);
        let expected = -8_f64.to_radians() + time;
        assert!((loading.tilt - expected).abs() < 1e-14, "{time}");
    }
    assert!(joint.varies() && joint.fixed_at_start().tilt_rad == Some(-8_f64.to_radians()));
    let [low, high] = joint.tilt_span(0.25);
    assert!((low + 8_f64.to_radians()).abs() < 1e-14 && (high - low - 0.25).abs() < 1e-14);
}

/// `dd/dt = -Omega x d`, integrated numerically for a rotation about an oblique axis whose speed reverses.
#[test]
fn the_direction_of_the_load_follows_from_the_rotation() {
    let joint = joint(
        "load.tilt_deg = 5\nload.azimuth_deg = 20\n\
         rotation.angular_velocity_rad_per_s = [0.3, -0.9, 0.6]\n\
         rotation.factor_sine = { mean = 0.4, amplitude = 2, frequency_hz = 3, phase_deg = 30 }",
    );
    let rate = |t: f64, d: [f64; 3]| {
        let [x, y, z] = joint.loading(t).rotation;
        [
            d[1] * z - d[2] * y,
            d[2] * x - d[0] * z,
            d[0] * y - d[1] * x,
        ]
    };
    let plus =
        |d: [f64; 3], h: f64, k: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| d[i] + h * k[i]) };
    let mut d = crate::joint::patch_direction(5_f64.to_radians(), 20_f64.to_radians());
    let h = 1e-3;
    for step in 0..500 {
        let t = h * f64::from(step);
        let k1 = rate(t, d);
        let k2 = rate(t + 0.5 * h, plus(d, 0.5 * h, k1));
        let k3 = rate(t + 0.5 * h, plus(d, 0.5 * h, k2));
        let k4 = rate(t + h, plus(d, h, k3));
        let slope = std::array::from_fn(|i| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);
        d = plus(d, h, slope);
        let found = direction(&joint, t + h);
        for (found, expected) in found.iter().zip(d) {
            assert!((found - expected).abs() < 1e-9, "{t}: {found} {expected}");
        }
        let length: f64 = found.iter().map(|c| c * c).sum();
        assert!((length - 1.0).abs() < 1e-14);
    }
}

#[test]
fn without_rotation_or_without_the_key_the_patch_stays() {
    let still = joint("load.tilt_deg = 3\nrotation.angular_velocity_rad_per_s = [0, 0, 0]");
    assert!(!still.varies() && still.loading(1.0).patch.is_none());
    let text = "load = { load_n = 150, tilt_deg = 3 }\ntime.duration_ms = 10\n";
    let fixed = Scene::parse("mine.toml", text).expect("valid");
    let fixed = fixed.joint().expect("a joint");
    assert!(!fixed.varies() && fixed.loading(1.0).patch.is_none());
    let scene = parsed("load.tilt_deg = 3").expect("valid");
    assert!(
        scene
            .with_tilt(1.0)
            .expect("valid")
            .joint()
            .expect("a joint")
            .patch_moves()
    );
}

#[test]
fn a_tilt_as_a_function_of_time_is_rejected() {
    let message =
        parsed("load.tilt = [{ time_ms = 0, tilt_deg = 2 }, { time_ms = 9, tilt_deg = 3 }]")
            .expect_err("two tilts")
            .to_string();
    assert_eq!(
        message,
        "mine.toml:2: `rotation.moves_patch`: the tilt is also a function of time; give the tilt at the start as \
         load.tilt_deg, or remove rotation.moves_patch"
    );
}
