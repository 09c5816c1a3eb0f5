//! Tests of the tonal events.

use std::f64::consts::TAU;

use super::*;
use crate::condition::recording_condition;
use crate::test_signals::noise;

const RATE: f64 = 44_100.0;

/// A tone with harmonics of amplitudes `partials` from `start` to `end` (s) with ramps of 20 ms: frequency (Hz) and amplitude
/// as functions of time.
fn tone(
    samples: &mut [f64],
    [start, end]: [f64; 2],
    partials: &[f64],
    frequency: impl Fn(f64) -> f64,
    amplitude: impl Fn(f64) -> f64,
) {
    let mut phase = 0.0;
    for (i, x) in samples.iter_mut().enumerate() {
        let t = i as f64 / RATE;
        phase = (phase + frequency(t) / RATE).fract();
        let ramp = ((t - start).min(end - t) / 0.02).clamp(0.0, 1.0);
        for (k, partial) in partials.iter().enumerate() {
            *x += ramp * amplitude(t) * partial * (TAU * (k + 1) as f64 * phase).sin();
        }
    }
}

/// White noise with rumble of a root mean square of 0.01 and about 0.1.
fn background(seed: u64, seconds: f64) -> Vec<f64> {
    let mut low = [0.0; 2];
    let mut samples = noise(seed, (seconds * RATE) as usize, 0.01);
    for x in &mut samples {
        low[0] += 0.01 * (*x - low[0]);
        low[1] += 0.01 * (low[0] - low[1]);
        *x += 100.0 * low[1];
    }
    samples
}

/// The squeak of a joint: 4.1 kHz that drifts by 15 Hz to each side, modulated at 12 Hz, from 3 to 7 s.
fn ordinary() -> Vec<f64> {
    let mut samples = background(1, 10.0);
    let drift = |t: f64| 4100.0 + 15.0 * (TAU * 0.25 * t).sin();
    let modulation = |t: f64| 0.1 * (1.0 + 0.4 * (TAU * 12.0 * t).cos());
    tone(
        &mut samples,
        [3.0, 7.0],
        &[1.0, 0.3, 0.2],
        drift,
        modulation,
    );
    samples
}

fn events(samples: &[f64]) -> TonalEvents {
    tonal_events(samples, RATE, &EventOptions::default()).unwrap()
}

/// Start, end (s), frequency (Hz), signal-to-noise ratio (dB) and number of harmonics of events.
fn summary(events: &[TonalEvent]) -> Vec<[f64; 5]> {
    let numbers = |e: &TonalEvent| {
        let harmonics = e.harmonics as f64;
        [e.start_s, e.end_s, e.frequency_hz, e.snr_db, harmonics]
    };
    events.iter().map(numbers).collect()
}

#[test]
fn an_ordinary_squeak_is_one_event_with_its_ends_harmonics_and_modulation() {
    let found = events(&ordinary()).events;
    let [event] = &found[..] else {
        panic!("{} events", found.len())
    };
    assert!((event.start_s - 3.0).abs() < 0.05, "{}", event.start_s);
    assert!((event.end_s - 7.0).abs() < 0.05, "{}", event.end_s);
    assert!(
        (event.frequency_hz - 4100.0).abs() < 2.0,
        "{}",
        event.frequency_hz
    );
    assert!(
        (event.frequency_low_hz - 4085.0).abs() < 10.0,
        "{}",
        event.frequency_low_hz
    );
    assert!(
        (event.frequency_high_hz - 4115.0).abs() < 10.0,
        "{}",
        event.frequency_high_hz
    );
    assert_eq!(event.harmonics, 3);
    let modulation = event.modulation.expect("a modulation");
    assert!(
        (modulation.modulation_hz - 12.0).abs() < 0.1,
        "{modulation:?}"
    );
    assert!(
        (modulation.modulation_depth - 0.4).abs() < 0.08,
        "{modulation:?}"
    );
    // 0.1 with a mean square of the modulation of 1 + 0.4^2 / 2, and 1 + 0.09 + 0.04 of the partials.
    let level = 20.0 * 0.1f64.log10() + 10.0 * (1.08f64 * 1.13).log10();
    assert!((event.level_db - level).abs() < 0.5, "{}", event.level_db);
}

#[test]
fn a_small_drift_gives_one_event() {
    let mut samples = background(2, 6.0);
    let drift = |t: f64| 4100.0 + 5.0 * (TAU * 0.25 * t).sin();
    tone(&mut samples, [1.0, 5.0], &[1.0], drift, |_| 0.1);
    let found = events(&samples).events;
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].harmonics, found[0].modulation), (1, None));
}

#[test]
fn a_tone_through_the_whole_recording_without_noise_is_one_event() {
    let mut samples = vec![0.0; 44_100];
    tone(&mut samples, [-1.0, 2.0], &[0.5], |_| 440.0, |_| 1.0);
    for x in &mut samples {
        *x = (*x * 32_768.0).round() / 32_768.0;
    }
    let found = events(&samples).events;
    assert_eq!(
        found.len(),
        1,
        "{:?}",
        found.iter().map(|e| e.frequency_hz).collect::<Vec<_>>()
    );
    assert!((found[0].frequency_hz - 440.0).abs() < 0.5);
    assert!(found[0].start_s < 0.05 && found[0].end_s > 0.95);
}

#[test]
fn two_squeaks_that_overlap_are_two_events() {
    let mut samples = background(3, 5.0);
    tone(&mut samples, [1.0, 3.0], &[1.0, 0.5], |_| 2000.0, |_| 0.1);
    tone(
        &mut samples,
        [2.0, 4.0],
        &[1.0],
        |t| 3300.0 + 20.0 * t,
        |_| 0.05,
    );
    let found = events(&samples).events;
    let starts: Vec<f64> = found.iter().map(|event| event.start_s.round()).collect();
    assert_eq!(starts, [1.0, 2.0]);
}

#[test]
fn noise_and_knocks_are_no_events() {
    for seed in 0..20 {
        let mut samples = background(seed, 3.0);
        for (i, x) in samples.iter_mut().enumerate().skip(44_100) {
            let t = i as f64 / RATE - 1.0;
            *x += 0.5 * (-t / 0.02).exp() * (TAU * 1500.0 * t).sin();
        }
        assert_eq!(events(&samples).events, [], "{seed}");
    }
}

/// White noise of a root mean square of 0.001 with a squeak of an amplitude of 0.5 between two times (s).
fn loud_squeak(seconds: f64, ends: [f64; 2]) -> Vec<f64> {
    let mut samples = noise(23, (seconds * RATE) as usize, 0.001);
    let drift = |t: f64| 2400.0 + 10.0 * (TAU * 0.3 * t).sin();
    tone(&mut samples, ends, &[1.0, 0.4, 0.2], drift, |_| 0.5);
    samples
}

#[test]
fn the_signal_to_noise_ratio_does_not_depend_on_what_part_of_a_recording_a_squeak_fills() {
    // Over the third octave of 2400 Hz.
    let noise = 0.001f64.powi(2) / (0.5 * RATE) * 2400.0 * 0.2316;
    let right = 10.0 * (0.5f64.powi(3) / noise).log10();
    let short = loud_squeak(10.0, [3.0, 6.0]);
    let long = loud_squeak(3.3, [0.1, 3.1]);
    // Half of the recording muted, with an offset.
    let muted = [vec![0.0; long.len()], long.clone()].concat();
    let muted: Vec<f64> = muted.iter().map(|x| x + 0.01).collect();
    let ratios = [short, long, muted].map(|samples| {
        let found = events(&samples).events;
        assert_eq!(found.len(), 1, "{:?}", summary(&found));
        found[0].snr_db
    });
    // The side lobes of the squeak itself raise the floor beside it.
    let near = |snr_db: &f64| (right - 8.0..right + 1.0).contains(snr_db);
    assert!(ratios.iter().all(near), "{ratios:?} for {right}");
    let [least, most] = crate::stats::range(ratios);
    assert!(most - least < 3.0, "{ratios:?}");
}

/// Knocks at the given times (s): resonances of 20 ms at 1500 Hz.
fn knocks(samples: &mut [f64], times: &[f64]) {
    for time in times {
        for (i, x) in samples.iter_mut().enumerate() {
            let t = i as f64 / RATE - time;
            if t >= 0.0 {
                *x += 0.5 * (-t / 0.02).exp() * (TAU * 1500.0 * t).sin();
            }
        }
    }
}

#[test]
fn a_short_loud_squeak_among_knocks_is_an_event() {
    let mut samples = background(11, 5.0);
    knocks(&mut samples, &[0.4, 0.9, 1.3, 2.6, 3.1, 3.7, 4.4]);
    tone(&mut samples, [1.8, 2.2], &[1.0, 0.3], |_| 2300.0, |_| 0.1);
    let found = events(&samples).events;
    let [event] = &found[..] else {
        panic!("{} events", found.len())
    };
    assert!((event.frequency_hz - 2300.0).abs() < 3.0);
    assert!((event.start_s - 1.8).abs() < 0.05 && (event.end_s - 2.2).abs() < 0.05);
}

#[test]
fn struck_notes_are_no_events_and_a_squeak_among_them_is_one() {
    let mut samples = background(12, 6.0);
    for (k, pitch) in [440.0, 554.4, 659.3, 880.0, 554.4, 440.0, 493.9, 587.3]
        .into_iter()
        .enumerate()
    {
        let start = 0.3 + 0.6 * k as f64;
        let fall = |t: f64| 0.1 * (-(t - start) / 0.25).exp();
        tone(
            &mut samples,
            [start, start + 0.6],
            &[1.0, 0.5, 0.3],
            |_| pitch,
            fall,
        );
    }
    assert_eq!(events(&samples).events, []);
    tone(&mut samples, [2.0, 4.0], &[1.0], |_| 3700.0, |_| 0.05);
    let found = events(&samples).events;
    assert_eq!(found.len(), 1);
    assert!((found[0].frequency_hz - 3700.0).abs() < 3.0);
}

#[test]
fn notes_that_die_out_are_no_events_whatever_their_pitch_decay_and_harmonics() {
    for (seed, decay_s) in (20..).zip([0.1, 0.15, 0.25, 0.4, 0.6]) {
        for (octaves, partials) in [(0.0, &[1.0][..]), (1.3, &[1.0, 0.4, 0.3, 0.2, 0.1])] {
            let mut samples = background(seed, 6.0);
            for (k, semitones) in [0, 7, 4, 9, 2, 11, 5].into_iter().enumerate() {
                let start = 0.2 + 0.8 * k as f64;
                let pitch = 300.0 * (octaves + f64::from(semitones) / 12.0).exp2();
                let fall = |t: f64| 0.1 * (-(t - start) / decay_s).exp();
                tone(
                    &mut samples,
                    [start, start + 0.8],
                    partials,
                    |_| pitch,
                    fall,
                );
            }
            let found = summary(&events(&samples).events);
            assert!(found.is_empty(), "{decay_s} s, {octaves}: {found:?}");
        }
    }
}

#[test]
fn a_steady_tone_at_a_multiple_of_the_mains_is_an_event_and_no_hum() {
    let mut samples = noise(13, 3 * 44_100, 0.01);
    tone(&mut samples, [1.0, 2.5], &[0.5], |_| 1000.0, |_| 1.0);
    let found = events(&samples);
    assert_eq!(found.hum, None);
    assert_eq!(found.events.len(), 1);
    assert!((found.events[0].frequency_hz - 1000.0).abs() < 0.5);
}

#[test]
fn a_clean_tone_through_the_whole_recording_is_no_hum() {
    for frequency in [1000.0, 2000.0] {
        let mut samples = vec![0.0; 6 * 44_100];
        tone(&mut samples, [0.0, 6.0], &[0.5], |_| frequency, |_| 1.0);
        let coded = samples.iter().map(|x| (x * 32_768.0).round() / 32_768.0);
        let found = events(&coded.collect::<Vec<f64>>());
        assert_eq!(found.hum, None);
        assert_eq!(found.events.len(), 1);
        assert!((found.events[0].frequency_hz - frequency).abs() < 0.5);
    }
}

#[test]
fn silence_for_most_of_the_recording_is_no_hum() {
    let mut samples = vec![0.0; 12 * 44_100];
    tone(&mut samples, [1.0, 2.0], &[0.5], |_| 3000.0, |_| 1.0);
    assert_eq!(events(&samples).hum, None);
}

#[test]
fn above_a_low_pass_there_is_no_event() {
    let mut samples = background(16, 4.0);
    tone(
        &mut samples,
        [1.0, 3.0],
        &[1.0, 0.3, 0.2, 0.1],
        |_| 2000.0,
        |_| 0.1,
    );
    let low = crate::filter::band_pass(&samples, RATE, [30.0, 5000.0]);
    let coded: Vec<f64> = low
        .samples
        .iter()
        .map(|x| (x * 32_768.0).round() / 32_768.0)
        .collect();
    let found = events(&coded).events;
    assert_eq!(found.len(), 1, "{:?}", summary(&found));
    assert!((found[0].frequency_hz - 2000.0).abs() < 2.0);
}

#[test]
fn hum_is_recognised_and_is_no_event() {
    let mut samples = background(5, 6.0);
    tone(
        &mut samples,
        [-1.0, 9.0],
        &[0.1, 0.02, 0.05, 0.01, 0.03, 0.01, 0.03],
        |_| 49.98,
        |_| 1.0,
    );
    let found = events(&samples);
    assert_eq!(found.events, []);
    let hum = found.hum.expect("hum");
    assert!((hum.fundamental_hz - 49.98).abs() < 0.05, "{hum:?}");
    assert!(hum.harmonics >= 5, "{hum:?}");
}

#[test]
fn gain_and_a_shift_of_time_change_nothing_else() {
    let samples = ordinary();
    let reference = &events(&samples).events[0];
    for gain in [8.0, 1e130] {
        let louder: Vec<f64> = samples.iter().map(|x| gain * x).collect();
        let event = &events(&louder).events[0];
        assert!((event.frequency_hz / reference.frequency_hz - 1.0).abs() < 1e-9);
        assert!((event.level_db - reference.level_db - 20.0 * f64::log10(gain)).abs() < 1e-6);
        assert!((event.probability - reference.probability).abs() < 1e-9);
    }
    let shifted = [background(9, 0.4), samples].concat();
    let event = &events(&shifted).events[0];
    let shift = (0.4 * RATE).floor() / RATE;
    assert!((event.start_s - reference.start_s - shift).abs() < 0.02);
    assert!((event.end_s - reference.end_s - shift).abs() < 0.02);
    assert!((event.frequency_hz / reference.frequency_hz - 1.0).abs() < 1e-4);
}

#[test]
fn demodulation_makes_a_drifting_tone_steady() {
    let mut samples = vec![0.0; 3 * 44_100];
    tone(
        &mut samples,
        [-1.0, 4.0],
        &[1.0],
        |t| 1000.0 + 30.0 * t,
        |_| 0.5,
    );
    let ridge = (0..=300).map(|i| RidgePoint {
        time_s: 0.01 * f64::from(i),
        frequency_hz: 1000.0 + 0.3 * f64::from(i),
        level_db: -6.0,
    });
    let event = TonalEvent {
        kind: EventKind::Tone,
        probability: 0.99,
        start_s: 0.0,
        end_s: 3.0,
        frequency_hz: 1045.0,
        frequency_low_hz: 1000.0,
        frequency_high_hz: 1090.0,
        harmonics: 1,
        level_db: -6.0,
        snr_db: 60.0,
        modulation: None,
        vibrato: None,
        ridge: ridge.collect(),
    };
    let span = Span {
        start_s: 0.5,
        end_s: 2.5,
    };
    let steady = demodulate(&samples, RATE, &event, span).unwrap();
    // x[i-1] + x[i+1] = 2 cos(2 pi f / rate) x[i] for a steady sine.
    let factor = 2.0 * (TAU * 1045.0 / RATE).cos();
    let error = steady
        .windows(3)
        .map(|w| (w[0] + w[2] - factor * w[1]).abs());
    assert!(error.fold(0.0, f64::max) < 2e-3);
    assert_eq!(stationary_stretch(&event).start_s, 0.0);
}

#[test]
fn the_condition_of_a_recording_is_recognised() {
    let mut samples = background(7, 3.0);
    let clean = recording_condition(&samples, RATE);
    assert!(clean.clipped.is_empty() && clean.dropouts.is_empty() && clean.silence.is_empty());
    tone(&mut samples, [1.0, 1.5], &[3.0], |_| 700.0, |_| 1.0);
    for (i, x) in samples.iter_mut().enumerate() {
        *x = x.clamp(-1.0, 1.0);
        if (4000..4400).contains(&i) || i > 110_000 {
            *x = 0.0;
        }
        *x += 0.05;
    }
    let condition = recording_condition(&samples, RATE);
    assert_eq!(condition.clipped.len(), 1);
    assert!((condition.clipped[0].start_s - 1.0).abs() < 0.02);
    assert!((condition.offset - 0.05).abs() < 0.02);
    assert_eq!((condition.dropouts.len(), condition.silence.len()), (1, 1));
    let few: Vec<f64> = noise(1, 44_100, 0.5)
        .iter()
        .map(|x| x.round().clamp(-1.0, 1.0))
        .collect();
    assert!(recording_condition(&few, RATE).clipped.is_empty());
}

#[test]
fn quantised_quiet_parts_are_no_dropouts() {
    let step = 1.0 / 32_768.0;
    let mut samples = noise(15, 2 * 44_100, 0.7 * step);
    tone(&mut samples, [0.5, 1.5], &[0.5], |_| 1000.0, |_| 1.0);
    for x in &mut samples {
        *x = (*x / step).round() * step;
    }
    assert!(recording_condition(&samples, RATE).dropouts.is_empty());
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    samples.iter_mut().for_each(|x| *x -= mean + 1e-17);
    assert!(recording_condition(&samples, RATE).dropouts.is_empty());
    samples[44_000..44_100].fill(0.0);
    assert_eq!(recording_condition(&samples, RATE).dropouts.len(), 1);
}

#[test]
fn a_modulated_tone_is_one_event_whatever_its_sidebands() {
    for (frequency, modulation) in [(300.0, 20.0), (500.0, 40.0), (900.0, 30.0), (1500.0, 60.0)] {
        let mut samples = noise(17, 6 * 44_100, 0.01);
        let amplitude = |t: f64| 0.1 * (1.0 + 0.9 * (TAU * modulation * t).cos());
        tone(&mut samples, [1.5, 4.5], &[1.0], |_| frequency, amplitude);
        let found = events(&samples).events;
        assert_eq!(found.len(), 1, "{frequency} Hz: {:?}", summary(&found));
        assert!((found[0].frequency_hz - frequency).abs() < 1.0);
    }
}

#[test]
fn a_squeak_louder_than_a_line_of_hum_beside_it_is_an_event() {
    let mut samples = noise(18, 10 * 44_100, 0.003);
    let hum: Vec<f64> = (1..=24).map(|k| 0.2 / f64::from(k)).collect();
    tone(&mut samples, [0.0, 10.0], &hum, |_| 50.0, |_| 1.0);
    tone(&mut samples, [4.0, 4.5], &[0.03], |_| 1025.0, |_| 1.0);
    let found = events(&samples);
    assert!(found.hum.is_some());
    assert_eq!(found.events.len(), 1);
    assert!((found.events[0].frequency_hz - 1025.0).abs() < 3.0);
    assert!((found.events[0].start_s - 4.0).abs() < 0.1);
}

#[test]
fn sidebands_of_a_modulated_tone_belong_to_it() {
    let mut samples = background(2, 5.0);
    let modulation = |t: f64| 0.1 * (1.0 + 0.5 * (TAU * 200.0 * t).cos());
    let partials = [1.0, 0.5, 0.3];
    tone(&mut samples, [1.0, 4.0], &partials, |_| 2000.0, modulation);
    let found = events(&samples).events;
    let [event] = &found[..] else {
        panic!("{:?}", summary(&found))
    };
    assert!((event.frequency_hz - 2000.0).abs() < 1.0);
    assert_eq!(event.harmonics, 3);
    let level = 10.0 * (0.01 * (1.0 + 0.25 + 0.09) * (1.0 + 0.125_f64)).log10();
    assert!((event.level_db - level).abs() < 0.3, "{}", event.level_db);

    // Tones at other distances are tones of their own.
    let mut samples = background(3, 5.0);
    for (frequency, amplitude) in [(2000.0, 0.1), (1700.0, 0.05), (2230.0, 0.05)] {
        tone(
            &mut samples,
            [1.0, 4.0],
            &[1.0],
            |_| frequency,
            |_| amplitude,
        );
    }
    assert_eq!(events(&samples).events.len(), 3);
}

#[test]
fn tones_of_a_chord_are_no_sidebands_and_those_of_a_deep_modulation_are() {
    for (loudest, seed) in (0..3).zip(30..) {
        let mut samples = background(seed, 5.0);
        for (k, frequency) in [800.0, 1000.0, 1200.0].into_iter().enumerate() {
            let amplitude = if k == loudest { 0.1 } else { 0.08 };
            tone(
                &mut samples,
                [1.0, 4.0],
                &[1.0],
                |_| frequency,
                |_| amplitude,
            );
        }
        let found = events(&samples).events;
        assert_eq!(found.len(), 3, "{:?}", summary(&found));
    }
    let mut samples = background(33, 5.0);
    let modulation = |t: f64| 0.1 * (1.0 + 0.95 * (TAU * 200.0 * t).cos());
    tone(&mut samples, [1.0, 4.0], &[1.0], |_| 1000.0, modulation);
    let found = events(&samples).events;
    assert_eq!(found.len(), 1, "{:?}", summary(&found));
}
