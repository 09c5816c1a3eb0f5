//! Consistency of values, overrides and warnings.

use super::*;

#[test]
fn inconsistent_values_are_rejected() {
    let cases = [
        (
            "[body]\nbeam_diameter_mm = 40\n",
            ":7: `body.beam_diameter_mm`",
        ),
        (
            "[body]\nball_diameter_mm = 15\n",
            ":7: `body.beam_diameter_mm`",
        ),
        (
            "[body]\nball_diameter_mm = 32\n",
            ":7: `socket.diameter_mm`",
        ),
        (
            "[socket]\ndiameter_mm = 31.75\n",
            ":7: `socket.diameter_mm`",
        ),
        (
            "[body]\nbeam_length_mm = 15\nbeam_length_to = \"centre\"\n",
            ":7: `body.beam_length_mm`",
        ),
        (
            "[body]\nbeam_length_mm = 5000\nelement_size_mm = 0.1\n",
            ":8: `body.element_size_mm`",
        ),
        // This number of elements exceeds the limit for this order only.
        (
            "[body]\nelement_size_mm = 2\nelement_order = 8\n",
            ":8: `body.element_size_mm`: a body of this size requires about 599 elements",
        ),
        (
            "[body]\nbending_pairs = 0\ntorsion_modes = 0\naxial_modes = 0\n",
            ":9: `body.bending_pairs`",
        ),
        ("[body]\ntorsion_modes = 3\n", ":7: `body.frequencies`"),
        (
            "[damping]\nratio = [0.1, 0.1]\n",
            ":7: `damping.ratio`: 2 ratios for 11 modes",
        ),
        ("method = \"rk4\"\n", ":6: `time.max_step_us`"),
        (
            "[analysis.spectrum]\nwindow_ms = 0.1\n[analysis.spectrogram]\nmax_frequency_khz = 101\n",
            ":9: `analysis.spectrogram.max_frequency_khz`",
        ),
        (
            "sample_rate_khz = 100\n[analysis.spectrum]\nwindow_ms = 0.1\n",
            ":8: `analysis.spectrum.window_ms`",
        ),
        (
            "[analysis.recurrence]\nrecurrence_rate = 0.1\nwindow_ms = 1\n",
            ":8: `analysis.recurrence.size`",
        ),
        (
            "[analysis.recurrence]\nrecurrence_rate = 0.1\nlag_us = 4\n",
            ":8: `analysis.recurrence.lag_us`",
        ),
        (
            "[analysis.recurrence]\nrecurrence_rate = 0.1\nthreshold_um = 4\n",
            ":8: `analysis.recurrence.threshold_um`",
        ),
        (
            "[analysis.recurrence]\nrecurrence_rate = 0.1\nneighbours = 9\nthreshold_std = 1\n",
            ":9: `analysis.recurrence.neighbours`",
        ),
        (
            "[analysis.recurrence]\nneighbours = 400\n",
            ":7: `analysis.recurrence.neighbours`: 400 neighbours require more than 400 states",
        ),
        (
            "[analysis.recurrence]\nrecurrence_rate = 0.1\nlag_us = \"auto\"\n",
            ":8: `analysis.recurrence.lag_us`: \"auto\" requires [analysis.delay]",
        ),
        (
            "[analysis.delay]\nwindow_ms = 4\n",
            ":7: `analysis.delay.window_ms`: max_lag_us, max_dimension together span 2.4 ms",
        ),
        (
            "[analysis.quantification]\nrecurrence_rate = 0.1\nstep_us = 2000\n",
            ":8: `analysis.quantification.step_us`",
        ),
        (
            "[analysis.quantification]\nrecurrence_rate = 0.1\ntheiler_us = 12e3\n",
            ":8: `analysis.quantification.window_ms`: theiler_us together span 12 ms",
        ),
        (
            "[analysis.quantification]\nneighbours = 1988\n",
            ":7: `analysis.quantification.neighbours`: 1988 neighbours require more than 1988 states",
        ),
        (
            "[analysis.section]\noffset_um = 1\n",
            ":7: `analysis.section.offset_um`",
        ),
        (
            "[analysis.section]\nplane_q = [1]\nlevel_um = 0\ncoordinates = [\"q1\", \"q2\"]\n",
            ":8: `analysis.section.level_um`",
        ),
        (
            "[analysis.section]\nplane_q = [0, 0]\ncoordinates = [\"q1\", \"q2\"]\n",
            ":7: `analysis.section.plane_q`: the normal of the plane is zero",
        ),
        (
            "[analysis.section]\nplane_qdot_ms = [0,0,0,0,0,0,0,0,0,0,0,1]\ncoordinates = [\"q1\", \"q2\"]\n",
            ":7: `analysis.section.plane_qdot_ms`: the normal has more components than the system has modes (11)",
        ),
        (
            "[analysis.section]\nplane_q = [1]\ncoordinates = [\"q1\", \"qdot12\"]\n",
            ":8: `analysis.section.coordinates`: the system has 11 modes only",
        ),
        (
            "[analysis.section]\nplane_q = [1]\n",
            ":6: `analysis.section.coordinates` is missing",
        ),
        (
            "[analysis.chaos]\nhorizon_ms = 45\n",
            ":7: `analysis.chaos.window_ms`",
        ),
        (
            "[analysis.chaos]\nradius = 0.1\n",
            ":7: `analysis.chaos.radius`: the selected law does not use this parameter; remove it, or choose another analysis.chaos.method",
        ),
        (
            "[analysis.chaos]\nmethod = \"kantz\"\n",
            ":6: `analysis.chaos.radius` is missing",
        ),
        (
            "[record]\nenergy_rate_khz = 201\n",
            ":7: `record.energy_rate_khz`",
        ),
    ];
    for (added, expected) in cases {
        let message = refusal_with(added);
        assert!(
            message.starts_with(&format!("mine.toml{expected}")),
            "{added}: {message}"
        );
    }
}

#[test]
fn invalid_lyapunov_and_perturbed_trajectory_are_rejected() {
    let cases = [
        (
            "events = \"exactly\"\n",
            "is not a valid choice (did you mean `exact`?)",
        ),
        ("[analysis.lyapunov]\ncount = 0\n", "out of range"),
        (
            "[analysis.lyapunov]\ncount = 23\n",
            ":7: `analysis.lyapunov.count`: 23 exponents exceed the dimension 22",
        ),
        (
            "[analysis.lyapunov]\ncuont = 2\n",
            "did you mean `analysis.lyapunov.count`?",
        ),
        ("[analysis.lyapunv]\n", "did you mean `analysis.lyapunov`?"),
        (
            "[analysis.perturbed_trajectory]\ninitial_distance = 0.5\n",
            "must be a number from 1e-12 to 0.01",
        ),
        (
            "[analysis.perturbed_trajectory]\nstart = 3\n",
            "did you mean `analysis.perturbed_trajectory.start_ms`?",
        ),
    ];
    for (added, expected) in cases {
        let message = refusal_with(added);
        assert!(message.contains(expected), "{added}: {message}");
    }
}

#[test]
fn an_analysis_that_never_starts_is_reported() {
    let added =
        "[analysis.lyapunov]\ntransient_ms = 5\n[analysis.perturbed_trajectory]\nstart_ms = 20\n";
    let scene = Scene::parse("m", format!("{SMALLEST}{added}")).expect("allowed");
    let scene = scene.with_duration(10.0).expect("valid");
    let warnings = scene.warnings();
    let [message] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    assert!(
        message.contains("at 10 ms, before analysis.perturbed_trajectory.start_ms = 20"),
        "{message}"
    );
}

#[test]
fn knots_increase_and_are_unique() {
    let with = |knots: &str| format!("[load]\nload_n = 1\n{knots}\n[time]\nduration_ms = 10\n");
    let ramp = "tilt = [{ time_ms = 1, tilt_deg = 0 }, { time_ms = 3, tilt_deg = 6 }]";
    let scene = Scene::parse("ramp.toml", with(ramp)).expect("valid");
    assert!((tilt_of(&scene).at(0.002).to_degrees() - 3.0).abs() < 1e-12);
    assert!(refusal(with("tilt = []")).contains(":3: `load.tilt` = [] is out of range"));
    assert!(
        refusal(with(&format!("tilt_deg = 1\n{ramp}")))
            .contains(":4: `load.tilt`: the scene gives the tilt more than once")
    );
    let back = "[[load.tilt]]\ntime_ms = 3\ntilt_deg = 0\n[[load.tilt]]\ntime_ms = 3\ntilt_deg = 6";
    assert!(refusal(with(back)).contains(":6: `load.tilt.time_ms`: this time is not later"));
    let many: Vec<_> = (0..10_001)
        .map(|k| format!("{{ time_ms = {k}, tilt_deg = 0 }}"))
        .collect();
    assert!(
        refusal(with(&format!("tilt = [{}]", many.join(", "))))
            .contains("a list of 1 to 10000 tables")
    );
    let most = with(&format!("tilt = [{}]", many[..10_000].join(", ")));
    assert_eq!(
        tilt_of(&Scene::parse("m", most).expect("valid"))
            .values()
            .len(),
        10_000
    );
}

#[test]
fn a_load_parallel_to_the_rotation_is_rejected() {
    let axial = format!("{SMALLEST}[rotation]\nangular_velocity_rad_per_s = [0, 0, 1]\n");
    assert!(Scene::parse("m", &axial).is_ok());
    let along = axial.replace("tilt_deg = 2.0", "tilt_deg = 0");
    assert!(
        refusal(along).starts_with(
            "mine.toml:7: `rotation.angular_velocity_rad_per_s`: at a tilt of 0.000 deg"
        )
    );
    let through = axial.replace(
        "tilt_deg = 2.0",
        "tilt = [{ time_ms = 0, tilt_deg = -3 }, { time_ms = 9, tilt_deg = 3 }]",
    );
    assert!(refusal(through).contains("at a tilt of 0.000 deg"));
    // The axis is inclined by 30 degrees towards an azimuth of 45 degrees, and points down.
    let lean = format!(
        "{SMALLEST}[rotation]\nangular_velocity_rad_per_s = [-0.3535533905932738, -0.3535533905932738, -0.8660254037844387]\n"
    );
    let meet = lean.replace("tilt_deg = 2.0", "tilt_deg = -30\nazimuth_deg = 225");
    assert!(refusal(meet).contains("at a tilt of -30.000 deg"));
    let miss = lean.replace("tilt_deg = 2.0", "tilt_deg = 30\nazimuth_deg = 225");
    assert!(Scene::parse("m", miss).is_ok());
    assert!(smallest().with_tilt(90.0).is_ok());
    // A joint without rotation is at rest, which is accepted at any tilt.
    let rest = format!("{SMALLEST}[rotation]\nangular_velocity_rad_per_s = [0, 0, 0]\n");
    assert!(Scene::parse("m", rest.replace("tilt_deg = 2.0", "tilt_deg = 0")).is_ok());
    let axial = Scene::parse("m", axial).expect("valid");
    let message = axial.with_tilt(0.0).expect_err("rejected").to_string();
    assert!(message.starts_with("override of scene m: `rotation.angular_velocity_rad_per_s`"));
}

#[test]
fn lyapunov_analyses_can_be_omitted() {
    let scene = Scene::load("chaos-5deg").unwrap();
    assert!(scene.computes_lyapunov() && scene.mechanism.is_some());
    let scene = scene.without_lyapunov().unwrap();
    assert!(!scene.computes_lyapunov());
    assert!(scene.analysis.regime.is_some(), "other analyses remain");
    assert_eq!(
        scene.mechanism, None,
        "the lesson requires the perturbed trajectory"
    );
    assert_eq!(
        Scene::parse(&scene.name, &scene.text).unwrap().analysis,
        scene.analysis
    );
    let torus = Scene::load("doubled-torus-3deg")
        .unwrap()
        .without_lyapunov();
    assert!(torus.unwrap().mechanism.is_some());
}

#[test]
fn overrides_are_checked_and_recorded() {
    let scene = smallest()
        .with_tilt(-3.5)
        .and_then(|scene| scene.with_duration(20.0))
        .expect("valid");
    assert_eq!(*tilt_of(&scene), Schedule::constant((-3.5f64).to_radians()));
    assert_eq!(scene.duration, 0.02);
    assert_eq!(
        scene.text,
        SMALLEST.replace("2.0", "-3.5").replace("10", "20")
    );
    for tilt in [90.1, -91.0, f64::NAN, f64::INFINITY] {
        let message = smallest()
            .with_tilt(tilt)
            .expect_err("rejected")
            .to_string();
        assert!(message.starts_with("override of scene mine: `load.tilt_deg` = "));
        assert!(message.ends_with("it must be a number from -90 to 90 deg"));
    }
    for duration in [0.0, -1.0, 1e6, f64::NAN] {
        assert!(smallest().with_duration(duration).is_err(), "{duration}");
    }
}

#[test]
fn warnings_name_the_remedy() {
    let friction = "[friction]\nmu_s = 0.25\nmu_d = 0.55\n";
    let scene = Scene::parse("m", format!("{SMALLEST}{friction}")).expect("allowed");
    assert_eq!(
        scene.warnings(),
        [
            "friction.mu_d = 0.55 exceeds friction.mu_s = 0.25: friction increases with speed, and no negative slope \
             excites vibration"
        ]
    );
    let of_body = |lines: &str| {
        let scene = Scene::parse("m", format!("{SMALLEST}[body]\n{lines}\n")).expect("allowed");
        scene.warnings()
    };
    let longer = of_body("beam_length_mm = 240");
    assert_eq!(longer.len(), 1, "{longer:?}");
    assert!(longer[0].contains("set body.frequencies = \"scaled\" or \"fe\""));
    assert_eq!(of_body("density_kg_m3 = 2700"), longer);
    for other in ["scaled", "fe"] {
        let lines = format!("beam_length_mm = 240\nfrequencies = \"{other}\"");
        assert!(of_body(&lines).is_empty());
    }
    assert!(of_body("beam_length_to = \"centre\"").is_empty());
    let ramp = Scene::load("tilt-ramp").expect("preset");
    let cut = ramp.clone().with_duration(50.0).expect("valid");
    assert!(cut.warnings()[0].contains("before the last change of the tilt"));
    assert!(ramp.with_tilt(1.0).expect("valid").warnings().is_empty());
}
