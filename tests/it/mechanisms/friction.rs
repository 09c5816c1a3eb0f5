//! Lessons on friction laws: bristles, contact age, measured curve.

use squeakscope::pipeline::message::{self, FrictionMemory};

use super::run::{Run, assert_close, changed};

/// Growth rates and slopes with and without the state of a friction law, and what the lesson says of its run.
fn memory(run: &Run) -> (&FrictionMemory, f64) {
    let computed = run.computed();
    let memory = computed.memory.as_ref().expect("friction with a state");
    (memory, computed.fastest().expect("a mode"))
}

/// The growth rate of a mode is that of the friction curve times the share of its slope that an oscillation meets; the
/// measured one agrees with it and not with that of the curve.
#[test]
fn bristles_reduce_the_growth_of_a_vibration() {
    let run = Run::named("bristles");
    let (memory, fastest) = memory(&run);
    // sigma_0 V / (2 pi mu), and the slope of the paper's curve.
    let speed = run.computed().sliding_speed;
    let mu = 0.25 + 0.3 * (-10.0 * speed).exp();
    let corner = 2e5 * speed / mu / std::f64::consts::TAU;
    assert_close(memory.follows_up_to_hz, corner, 1e-9);
    assert_close(memory.steady_slope, -3.0 * (-10.0 * speed).exp(), 1e-9);
    let alone = message::fastest(&memory.modes_of_speed_alone).expect("a mode");
    for mode in run.computed().unstable() {
        let x = (mode.frequency_hz / corner).powi(2);
        let share = (1.0 + 0.5 * speed / mu * x) / (1.0 + x);
        let others = memory.modes_of_speed_alone.iter();
        let same = others.filter(|other| other.unstable && other.label == mode.label);
        let growth = same.map(|other| other.growth).fold(0.0, f64::max);
        assert_close(mode.growth, share * growth, 0.15);
    }
    let measured = run.number("growth rate, while small");
    assert_close(measured, fastest, 0.1);
    assert!(measured < 0.5 * alone);
    let frequency = run.number("frequency, while small");
    assert_close(frequency, run.computed().unstable()[0].frequency_hz, 0.01);
    let without = run.fact("growth rate, friction without memory");
    assert_eq!(without.agrees, Some(false), "{without:?}");
}

/// Another seed and another stiffness; and bristles so stiff that they change nothing.
#[test]
fn lessons_on_bristles_hold_for_other_runs() {
    let other = Run::with("bristles", "seed = 11", "seed = 6");
    let (_, fastest) = memory(&other);
    let measured = other.number("growth rate, while small");
    assert_close(measured, fastest, 0.15);
    let stiffer = Run::with("bristles", "per_m = 2e5", "per_m = 6e5");
    let (memory_of, fastest) = memory(&stiffer);
    let measured = stiffer.number("growth rate, while small");
    assert_close(measured, fastest, 0.15);
    assert!(fastest < 0.8 * message::fastest(&memory_of.modes_of_speed_alone).expect("a mode"));
    let stiff = Run::of(
        &changed("bristles", "per_m = 2e5", "per_m = 1e7")
            .with_duration(40.0)
            .expect("valid"),
    );
    let (memory, fastest) = self::memory(&stiff);
    let alone = message::fastest(&memory.modes_of_speed_alone).expect("a mode");
    assert_close(fastest, alone, 0.05);
}

/// Modes grow below the critical frequency `V / (2 pi D_c) sqrt(b / a - 1)` only.
#[test]
fn the_age_of_the_contact_stabilises_high_modes() {
    for (distance, grows) in [("1", true), ("0.6", true), ("5", false)] {
        let run = Run::with(
            "contact-age",
            "slip_distance_um = 1\n",
            &format!("slip_distance_um = {distance}\n"),
        );
        let (memory, fastest) = memory(&run);
        let speed = run.computed().sliding_speed;
        let distance = 1e-6 * distance.parse::<f64>().expect("a number");
        let critical = speed / distance * 2.0 / std::f64::consts::TAU;
        assert_close(memory.damping_above_hz.expect("critical"), critical, 1e-9);
        for mode in run.computed().unstable() {
            assert!(mode.frequency_hz < 1.05 * critical, "{mode:?} {critical}");
        }
        assert_eq!(run.computed().unstable().is_empty(), !grows);
        if grows {
            let measured = run.number("growth rate, while small");
            // The level is that of all unstable modes.
            let rates = run
                .computed()
                .unstable()
                .into_iter()
                .map(|mode| mode.growth);
            let slowest = rates.fold(fastest, f64::min);
            let between = (0.9 * slowest..1.05 * fastest).contains(&measured);
            assert!(between, "{measured} {slowest} {fastest}");
            run.assert_confirmed("frequency of the growth", "below the critical one");
        } else {
            run.assert_confirmed("vibration", "no growth");
            assert_eq!(run.fact("frequency of the growth").measured, None);
        }
    }
}

/// The slope between the points decides: with a curve that rises at the sliding speed nothing grows.
#[test]
fn a_measured_curve_drives_the_vibration_by_its_slope() {
    let run = Run::named("measured-friction");
    let table = run.computed().table.as_ref().expect("a table");
    let [low, high] = table.secants.expect("within the points");
    assert!(low <= table.slope && table.slope <= high && high < 0.0);
    // The secants of the intervals from 6, 10 and 16 mm/s.
    assert_close(low, -0.025 / 0.004, 1e-9);
    assert_close(high, -0.04 / 0.009, 1e-9);
    let fastest = run.computed().fastest().expect("a mode");
    let measured = run.number("growth rate, while small");
    assert_close(measured, fastest, 0.15);
    let above = |run: &Run| run.fact("slip speeds").measured == Some("above the last point".into());
    assert!(!above(&run));
    // The vibration leaves a table that ends at 25 mm/s.
    let short = "    { speed_m_per_s = 0.040, mu = 0.38 },\n    { speed_m_per_s = 0.060, mu = 0.34 },\n    \
                 { speed_m_per_s = 0.100, mu = 0.31 },\n";
    let shorter = Run::with("measured-friction", short, "");
    assert!(above(&shorter));
    let points = |values: [f64; 3]| {
        let points = [0.01, 0.016, 0.025].into_iter().zip(values);
        let points = points.map(|(v, mu)| format!("speed_m_per_s = {v:.3}, mu = {mu:.2} }},"));
        points.collect::<Vec<_>>().join("\n    { ")
    };
    let rising = Run::with(
        "measured-friction",
        &points([0.5, 0.47, 0.43]),
        &points([0.4, 0.47, 0.55]),
    );
    assert!(rising.computed().unstable().is_empty());
    rising.assert_confirmed("vibration", "no growth");
}
