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
    let found = effects(&scene, record, &mut |_| true).unwrap().unwrap();
    assert_eq!(recorded > 0, scene.joint().is_ok());
    found
}

fn find<'a>(found: &'a Effects, key: &str) -> &'a Effect {
    let mut all = found.effects.iter();
    all.find(|effect| effect.key == key).expect(key)
}

#[test]
fn what_a_scene_calls_for_is_on_and_has_a_price() {
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
    // Friction is the better part of a call.
    let friction = find(&found, "friction").seconds.unwrap();
    let call = found.call * found.calls;
    assert!(
        friction > 0.2 * call && friction < call,
        "{friction} {call}"
    );
    assert!(find(&found, "rotation.convection").seconds.unwrap() > 0.0);
    assert!(found.whole > 0.5 * call, "{} {call}", found.whole);
    let damped = of(
        "torus-3deg",
        "[contact_damping]\nlaw = \"hunt-crossley\"\ndissipation_s_per_m = 2\n",
    );
    let damping = find(&damped, "contact_damping");
    assert!(damping.on && damping.setting.contains("2 s/m"));
}

#[test]
fn a_small_system_has_no_effects_of_nodes() {
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
fn it_stops_when_told() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let mut asked = 0;
    let found = effects(&scene, &mut |_| Ok(()), &mut |_| {
        asked += 1;
        asked < 3
    });
    assert_eq!(found.unwrap(), None);
}
