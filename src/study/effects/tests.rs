use super::*;

fn of(name: &str, text: &str) -> Effects {
    let mut scene = Scene::load(name).unwrap();
    if !text.is_empty() {
        scene = Scene::parse("changed.toml", format!("{}\n{text}", scene.text)).unwrap();
    }
    scene.duration = 0.01;
    let mut recorded = 0;
    let record = &mut |_: &Scene| {
        recorded += 1;
        Ok(())
    };
    let found = effects(&scene, record, &Arc::default(), &mut |_| true)
        .unwrap()
        .unwrap();
    assert_eq!(recorded > 0, scene.joint().is_ok());
    found
}

fn find<'a>(found: &'a Effects, key: &str) -> &'a Effect {
    let mut all = found.effects.iter();
    all.find(|effect| effect.key == key).expect(key)
}

#[test]
fn active_effects_have_a_cost() {
    let found = of("torus-3deg", "");
    for key in ["friction", "friction.radial", "contact.unilateral"] {
        assert!(find(&found, key).on, "{key}");
    }
    for key in [
        "contact_damping",
        "rotation.convection",
        "damping",
        "time.events",
    ] {
        let effect = find(&found, key);
        assert!(!effect.on && effect.setting.is_empty(), "{key}");
    }
    // Friction is the largest part of the right-hand side.
    let cost = |key| find(&found, key).cost.expect("a cost").mean;
    let friction = cost("friction");
    let call = found.rhs_eval * found.rhs_evals;
    assert!(
        friction > 0.2 * call && friction < call,
        "{friction} {call}"
    );
    assert!(cost("rotation.convection") > 0.0);
    // Two bending pairs instead of eleven modes.
    assert!(cost("body.bending_pairs, torsion, axial") < -0.2 * call);
    assert!(
        find(&found, "contact.stiffness_distribution")
            .cost
            .unwrap()
            .half_width
            .is_finite()
    );
    // The run is 10 ms long.
    let reason = find(&found, "analysis.regime").cost.expect_err("no cost");
    assert_eq!(reason, Unavailable::ShorterThanWindow);
    assert!(found.setup > 0.0 && found.setup.is_finite());
    assert!(found.whole > 0.5 * call, "{} {call}", found.whole);
    let damped = of(
        "torus-3deg",
        "[contact_damping]\nlaw = \"hunt-crossley\"\ndissipation_s_per_m = 2\n",
    );
    let damping = find(&damped, "contact_damping");
    assert!(damping.on && damping.setting.contains("2 s/m"));
}

#[test]
fn a_small_system_has_no_contact_node_effects() {
    let found = of("impact-oscillator", "");
    assert!(found.effects.iter().all(|effect| effect.key != "friction"));
    assert!(
        found
            .effects
            .iter()
            .any(|effect| effect.key == "analysis.spectrum")
    );
}

#[test]
fn the_callback_stops_the_measurement() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let mut asked = 0;
    let found = effects(&scene, &mut |_| Ok(()), &Arc::default(), &mut |_| {
        asked += 1;
        asked < 3
    });
    assert_eq!(found.unwrap(), None);
}

/// The flag ends the run in progress, so that the callback is called soon.
#[test]
fn the_stop_flag_ends_a_run_in_progress() {
    let mut scene = Scene::load("periodic-2deg").unwrap();
    scene.integrator.max_step = 1e-11;
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    let raiser = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(300));
        raised.store(true, std::sync::atomic::Ordering::Relaxed);
    });
    let should_continue = |_| !stop.load(std::sync::atomic::Ordering::Relaxed);
    let found = effects(&scene, &mut |_| Ok(()), &stop, &mut { should_continue });
    assert_eq!(found.unwrap(), None);
    raiser.join().unwrap();
}

#[test]
fn a_difference_has_its_95_percent_interval() {
    let rounds = Rounds(vec![vec![5.0, 6.0, 7.0, 8.0], vec![1.0, 2.0, 3.0, 4.0]]);
    let found = rounds.difference(0, 1);
    assert_eq!((found.mean, found.half_width), (4.0, 0.0));
    assert!(found.is_significant());
    // Student's t for three degrees of freedom; standard deviation 1.29.
    let found = Measured::of(&[-1.0, 0.0, 1.0, 2.0]);
    assert!((found.half_width - 3.18 * (5.0_f64 / 3.0).sqrt() / 2.0).abs() < 1e-12);
    assert!(!found.is_significant());
}
