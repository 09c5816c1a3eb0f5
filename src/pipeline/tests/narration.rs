//! Commentary on known signals.

use super::*;

#[test]
fn commentary_follows_growth_tone_torus_and_noise() {
    let growing = Motion::tones(0.0125, &CYCLE[..1]).with_growth(750.0);
    let mut chaos = Motion::tones(0.1, &TORUS);
    for (v, x) in chaos.velocity.iter_mut().zip(noise(5, 20_000, 5e-3)) {
        *v += x;
    }
    let motion = growing
        .then(&Motion::tones(0.1, &CYCLE))
        .fading_into(&Motion::tones(0.1, &TORUS))
        .fading_into(&chaos);
    let records = run(analyses(), &motion, 256);
    // While the window contains two motions the appearance may vary, but the order of the reported
    // appearances may not, and none may recur.
    let mut reported = headings(&records);
    // At a transition the envelope may dip and settle again.
    assert_eq!(reported[1], "## The vibration settles");
    reported.retain(|heading| !heading.contains("settles"));
    reported.dedup();
    let place = |heading: &str| {
        let places: Vec<usize> = (0..reported.len())
            .filter(|&i| reported[i].contains(heading))
            .collect();
        assert_eq!(places.len(), 1, "{heading}: {reported:?}");
        places[0]
    };
    let order = [
        place("growing"),
        place("one tone"),
        place("two tones"),
        place("broadband floor"),
    ];
    assert!(order.is_sorted(), "{reported:?}");
    assert_eq!(
        (order[0], order[3]),
        (0, reported.len() - 1),
        "{reported:?}"
    );

    let texts = narrations(&records);
    let heads = |t: &str, heading: &str| t.lines().next().is_some_and(|h| h.contains(heading));
    let last = |heading: &str| texts.iter().rfind(|t| heads(t, heading)).unwrap();
    let tone = last("one tone");
    assert!(
        tone.contains("4.12 kHz") && tone.contains("3 f1 (12.4 kHz)"),
        "{tone}"
    );
    assert!(tone.contains("Tilt 2.9°"), "{tone}");
    // The last text on the torus may include part of the noise.
    let torus =
        |t: &str| heads(t, "two tones") && t.contains("3.87 kHz") && t.contains("beat at 240 Hz");
    assert!(texts.iter().any(|t| torus(t)), "{texts:?}");
    let growing = last("growing");
    assert!(
        growing.contains("doubles about every") && growing.contains("4.12 kHz"),
        "{growing}"
    );
}

#[test]
fn a_torus_with_many_combinations_is_two_tones() {
    // Two tones through a strong odd nonlinearity: dozens of lines, all n f1 + m f2.
    let mut motion = Motion::tones(0.1, &[(4110.0, 1.0, 0.0), (3870.0, 0.5, 0.3)]);
    motion
        .velocity
        .iter_mut()
        .for_each(|v| *v = 16e-3 * (1.5 * *v).tanh());
    let records = run(analyses(), &motion, 256);
    assert_eq!(
        headings(&records).last().unwrap(),
        "## Looks like two tones"
    );
    let Some(Record::Spectrum { peaks, .. }) = records
        .iter()
        .rfind(|r| matches!(r, Record::Spectrum { .. }))
    else {
        panic!("no spectrum");
    };
    assert_eq!(peaks.len(), 12);
    assert!(peaks.iter().all(|p| !p.label.is_empty()), "{peaks:?}");
}

#[test]
fn the_lorenz_system_has_lines_over_a_broadband_floor() {
    // Lorenz system 10, 28, 8/3 with a time unit of 0.3 ms; x is used as the velocity.
    let flow = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let along = |s: [f64; 3], d: [f64; 3], h: f64| std::array::from_fn(|i| s[i] + h * d[i]);
    let h = 1.0 / (0.3e-3 * RATE);
    let mut state = [1.0, 1.0, 20.0];
    let mut motion = Motion::default();
    for _ in 0..20_000 {
        // The midpoint rule is accurate enough for a spectrum.
        state = along(state, flow(along(state, flow(state), 0.5 * h)), h);
        motion.velocity.push(1e-3 * state[0]);
        motion.displacement.push(1e-7 * state[1]);
    }
    let records = run(analyses(), &motion, 256);
    let last = headings(&records).pop().unwrap();
    assert_eq!(last, "## Spectral lines over a broadband floor");
}

#[test]
fn commentary_does_not_flicker_and_is_refreshed() {
    // 0.2 s of one tone: the first report after 20 ms, then every 50 ms.
    let records = run(analyses(), &Motion::tones(0.2, &CYCLE), 256);
    let times = instants(&records, |r| match r {
        Record::Narration { time, .. } => Some(*time),
        _ => None,
    });
    assert_eq!(times, [3999.0, 13_999.0, 23_999.0, 33_999.0]);
    assert_eq!(
        headings(&records),
        ["## Looks like one tone with harmonics"]
    );
}

#[test]
fn slip_reversal_is_detected_from_the_velocity() {
    for (factor, words) in [(0.9, "never reverses"), (1.1, "slip reverses")] {
        let tone = [(4100.0, factor * SLIDING_SPEED, 0.0)];
        let records = run(analyses(), &Motion::tones(0.02, &tone), 256);
        assert!(
            narrations(&records)[0].contains(words),
            "{:?}",
            narrations(&records)[0]
        );
    }
}
