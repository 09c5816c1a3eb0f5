//! Friction laws that are nearly discontinuous, absent or very strong.

use squeakscope::dynamics::System;

use super::{Case, assert_stable, distance, joint, run_scene, scene};

/// Creep slopes over six decades, from a viscous joint to nearly dry friction.
#[test]
fn creep_slopes_from_1e2_to_1e8() {
    let mut amplitudes = Vec::new();
    for slope in ["1e2", "1e3", "1e4", "1e5", "1e6", "1e7", "1e8"] {
        let name = format!("creep slope {slope} s/m");
        let result = assert_stable(&Case {
            name: &name,
            changes: &[
                ("friction.creep_slope_s_per_m", slope),
                ("start.kick_mm_per_s", "1"),
                ("time.method", "\"auto\""),
                ("time.duration_ms", "10"),
            ],
            ..Case::default()
        });
        amplitudes.push(result.summary.amplitude_m);
    }
    // Towards dry friction the slope has no influence.
    for pair in amplitudes[4..].windows(2) {
        assert!((pair[0] / pair[1] - 1.0).abs() < 1e-2, "{amplitudes:?}");
    }
    assert!(
        (amplitudes[0] / amplitudes[6] - 1.0).abs() > 0.1,
        "{amplitudes:?}"
    );
}

/// A nearly dry joint that hardly rotates. Explicit steps alternate across the creep region, and their
/// stiffness estimate does not detect it; `auto` must recognise that they make no progress.
#[test]
fn nearly_dry_friction_at_rest() {
    for rotation in ["[1e-6, 0, 0]", "[0, 0, 0]"] {
        let changes = [
            ("friction.creep_slope_s_per_m", "1e8"),
            ("rotation.angular_velocity_rad_per_s", rotation),
            ("start.kick_mm_per_s", "10"),
        ];
        let implicit = run_scene(&scene(
            &[&changes[..], &[("time.method", "\"rodas5p\"")]].concat(),
        ));
        let name = format!("nearly dry, rotation {rotation}");
        let auto = assert_stable(&Case {
            name: &name,
            changes: &[&changes[..], &[("time.method", "\"auto\"")]].concat(),
            ..Case::default()
        });
        // At looser tolerances, rounding decides when a node leaves the creep region, and with it the number of steps.
        let steps = |method| {
            let finer = [("time.method", method), ("time.tolerance", "1e-6")];
            let run = run_scene(&scene(&[&changes[..], &finer].concat()));
            run.summary.stats.steps
        };
        // Measured: 1.2 to 1.3 times as many, half of them cheaper. The explicit method takes 18 million.
        let [auto_steps, implicit_steps] = ["\"auto\"", "\"rodas5p\""].map(steps);
        assert!(
            auto_steps < 2 * implicit_steps,
            "{name}: {auto_steps} {implicit_steps}"
        );
        let omega = joint(&scene(&changes)).omega().to_vec();
        let error = distance(&omega, &auto.final_state(), &implicit.final_state());
        // Measured: 4.8e-4.
        assert!(error < 2e-3, "{name}: {error:e}");
    }
}

/// Without friction nothing dissipates: the energy at each sample of a second equals the initial energy.
#[test]
fn without_friction() {
    let result = run_scene(&scene(&[
        ("friction.mu_s", "0"),
        ("friction.mu_d", "0"),
        ("time.method", "\"lawson853\""),
        ("time.tolerance", "1e-13"),
        ("time.duration_ms", "1000"),
        ("record.energy_rate_khz", "10"),
    ]));
    result.is_sound("without friction");
    let start = result.energies().next().unwrap()[0];
    let error = result
        .energies()
        .map(|[total, ..]| (total / start - 1.0).abs());
    let worst = error.fold(0.0, f64::max);
    println!("| without friction, 1 s | {worst:.1e} |");
    assert!(worst < 1e-9, "{worst:e}");
    assert!(result.energies().all(|[_, work, _]| work == 0.0));
    // Also with nodes that separate, where kinks reduce the order.
    assert_stable(&Case {
        name: "without friction, with separation",
        changes: &[
            ("friction.mu_s", "0"),
            ("friction.mu_d", "0"),
            ("start.kick_mm_per_s", "30"),
            ("time.duration_ms", "5"),
        ],
        // Nothing damps the errors, and the shift of each contact change in time amplifies them.
        // Measured: 1.03.
        amplification: 2.0,
        ..Case::default()
    });
}

/// Ten times the friction of the paper: the joint separates and closes again.
#[test]
fn friction_coefficient_of_five() {
    // The stiff case has tens of thousands of contact changes, each with an error: 1.4e-3 measured; its
    // 12,000 steps permit 0.12.
    for (name, mu_d, stiffness, audit) in [
        ("mu = 5", "2.25", "2.75", 1e-3),
        ("mu = 5 = mu_d", "5", "2.75", 1e-3),
        ("mu = 5, stiff", "5", "1000", 3e-3),
    ] {
        let result = assert_stable(&Case {
            name,
            changes: &[
                ("friction.mu_s", "5"),
                ("friction.mu_d", mu_d),
                ("contact.stiffness_factor", stiffness),
                ("time.method", "\"auto\""),
                ("time.duration_ms", "8"),
            ],
            audit,
            kicks: &["0.0097", "0.0098", "0.0099", "0.0101", "0.0102", "0.0103"],
            ..Case::default()
        });
        assert!(result.max_speed(0.0) > 1e-4, "{name}");
    }
}
