//! Events of a sound: times, full scale, long signals.

use super::*;
use crate::test_signals::{noise, sines};

const RATE: f64 = 8000.0;

/// A tone of 1013 Hz in noise, between two times of a signal that starts at 5 s.
fn tone(seconds: f64, [from, to]: [f64; 2], amplitude: f64) -> Signal {
    let count = (seconds * RATE) as usize;
    let sines = sines(RATE, count, &[(1013.0, amplitude, 0.0)]);
    let noise = noise(4, count, 0.01 * amplitude);
    let sounds = |k: usize| (from..to).contains(&(5.0 + k as f64 / RATE));
    let samples = sines.iter().zip(noise).enumerate();
    Signal {
        name: "u".to_owned(),
        unit: "FS".to_owned(),
        rate: RATE,
        start: 5.0,
        samples: samples
            .map(|(k, (sine, noise))| if sounds(k) { sine + noise } else { noise })
            .collect(),
    }
}

#[test]
fn times_are_those_of_the_file() {
    let sound = MeasuredSound::of(&tone(4.0, [6.0, 8.0], 0.5), false)
        .unwrap()
        .unwrap();
    let [event] = &sound.tonal.events[..] else {
        panic!("{:?}", sound.tonal.events);
    };
    assert!((event.start_s - 6.0).abs() < 0.1, "{}", event.start_s);
    assert!((event.end_s - 8.0).abs() < 0.1, "{}", event.end_s);
    assert!((event.ridge[0].time_s - 6.0).abs() < 0.2);
    assert_eq!(sound.strongest(), Some(0));
}

#[test]
fn levels_are_relative_to_full_scale_or_to_20_micropascal() {
    let level = |unit: &str, amplitude: f64| {
        let signal = Signal {
            unit: unit.to_owned(),
            ..tone(3.0, [6.0, 7.5], amplitude)
        };
        MeasuredSound::of(&signal, false)
            .unwrap()
            .unwrap()
            .tonal
            .events[0]
            .level_db
    };
    let half = level("FS", 0.5);
    assert!((half - 20.0 * 0.5_f64.log10()).abs() < 1.0, "{half}");
    assert!((level("", 0.5) - half).abs() < 1e-9);
    // In another unit, the largest sample is full scale.
    for amplitude in [0.002, 20.0] {
        assert!(level("m/s^2", amplitude).abs() < 1.0);
    }
    // A sine with an amplitude of 1 Pa has 90.97 dB.
    assert!((level("Pa", 1.0) - level("FS", 1.0) - 90.969).abs() < 1e-3);
}

#[test]
fn other_sample_rates_and_short_signals_are_no_sound() {
    let mut signal = tone(0.15, [5.0, 5.1], 0.5);
    assert_eq!(MeasuredSound::of(&signal, false), Ok(None));
    for rate in [1.0, 7999.0, 200_000.0] {
        signal.rate = rate;
        assert_eq!(MeasuredSound::of(&signal, false), Ok(None));
    }
}

#[test]
fn an_event_across_the_border_of_two_blocks_is_joined() {
    let event = |start_s: f64, end_s: f64, frequency_hz: f64| {
        let mut event = MeasuredSound::of(&tone(3.0, [6.0, 7.0], 0.5), false)
            .unwrap()
            .unwrap()
            .tonal
            .events
            .remove(0);
        let shift = frequency_hz - event.frequency_hz;
        event.ridge.iter_mut().for_each(|point| {
            point.frequency_hz += shift;
            point.time_s += start_s - 6.0;
        });
        TonalEvent {
            kind: crate::analysis::events::EventKind::Tone,
            probability: 0.99,
            start_s,
            end_s,
            frequency_hz,
            ..event
        }
    };
    let first = event(10.0, 19.98, 1000.0);
    assert!(continues(&first, &event(20.02, 22.0, 1004.0), 20.0));
    assert!(continues(&first, &event(19.97, 22.0, 1004.0), 19.975));
    assert!(!continues(&first, &event(20.02, 22.0, 1100.0), 20.0));
    assert!(!continues(&first, &event(20.2, 22.0, 1004.0), 20.0));
    let (mut joined, next) = (first.clone(), event(20.02, 22.0, 1004.0));
    join(&mut joined, next);
    assert_eq!((joined.start_s, joined.end_s), (10.0, 22.0));
    assert!((joined.level_db - first.level_db).abs() < 1e-9);
    // Of 12 s, 1.98 s at the higher frequency.
    assert!((joined.frequency_hz - 1000.0 - 4.0 * 1.98 / 11.96).abs() < 1e-6);
    assert_eq!(joined.ridge.len(), 2 * first.ridge.len());
    // Of parts that overlap, the ridge stays in the order of time.
    let mut joined = first.clone();
    join(&mut joined, event(10.5, 22.0, 1004.0));
    assert!(joined.ridge.is_sorted_by(|a, b| a.time_s < b.time_s));
}
