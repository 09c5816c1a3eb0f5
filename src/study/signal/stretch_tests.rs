//! The choice of the stretch.

use super::*;
use crate::analysis::events::RidgePoint;
use crate::test_signals::sines;

const RATE: f64 = 44_100.0;

/// An event at 1 kHz whose frequency deviates by `drift` (Hz) at 0.5 Hz.
fn event(start_s: f64, end_s: f64, drift: f64) -> TonalEvent {
    let count = ((end_s - start_s) / 0.01).round() as u32;
    let ridge = (0..=count).map(|k| {
        let time_s = start_s + 0.01 * f64::from(k);
        RidgePoint {
            time_s,
            frequency_hz: 1000.0 + drift * (std::f64::consts::PI * time_s).sin(),
            level_db: -6.0,
        }
    });
    TonalEvent {
        kind: EventKind::Tone,
        probability: 0.99,
        start_s,
        end_s,
        frequency_hz: 1000.0,
        frequency_low_hz: 1000.0 - drift,
        frequency_high_hz: 1000.0 + drift,
        harmonics: 2,
        level_db: -6.0,
        snr_db: 40.0,
        modulation: None,
        vibrato: None,
        ridge: ridge.collect(),
    }
}

fn sound(events: Vec<TonalEvent>) -> MeasuredSound {
    let mut sound = MeasuredSound::default();
    sound.tonal.events = events;
    sound
}

/// Tones of 4 s, from 10 s on.
fn signal(tones: &[(f64, f64, f64)]) -> Signal {
    Signal {
        name: "u".to_owned(),
        unit: "FS".to_owned(),
        rate: RATE,
        start: 10.0,
        samples: sines(RATE, 176_400, tones),
    }
}

const TONE: (f64, f64, f64) = (1000.0, 0.5, 0.0);

#[test]
fn a_steady_event_throughout_is_analysed_as_the_whole_signal() {
    let sound = sound(vec![event(10.02, 13.98, 0.0)]);
    let (stretch, part, obstacle) = select(&signal(&[TONE]), Some(&sound), None).unwrap();
    assert_eq!((stretch.start_s, stretch.end_s), (10.0, 14.0));
    assert_eq!(stretch.event, Some(1));
    assert!(part.is_none() && obstacle.is_none());
}

#[test]
fn a_part_of_the_signal_is_filtered_only_where_needed() {
    let sound = sound(vec![event(11.0, 13.0, 0.0)]);
    for (rumble, band) in [(0.01, None), (0.5, Some([1000.0 / 3.0, 3500.0]))] {
        let signal = signal(&[TONE, (60.0, rumble, 0.0)]);
        let (stretch, part, _) = select(&signal, Some(&sound), Some(1)).unwrap();
        assert_eq!(stretch.band_hz, band);
        assert!(!stretch.demodulated);
        let part = part.unwrap();
        assert_eq!(part.start, stretch.start_s);
        assert!((part.duration() - 2.0).abs() < 0.3, "{}", part.duration());
        // Sample by sample the tone, at the time of the part.
        let first = (part.start - 10.0) * RATE;
        let tone = sines(RATE, 176_400, &[TONE]);
        for (k, sample) in part.samples.iter().enumerate() {
            let expected = tone[first.round() as usize + k];
            assert!((sample - expected).abs() < 0.011, "{sample}, {expected}");
        }
    }
}

#[test]
fn noise_beside_a_tone_is_background_and_not_in_its_band() {
    let mut rumble = event(10.0, 14.0, 0.0);
    rumble.kind = EventKind::NarrowBandNoise;
    rumble.frequency_low_hz = 60.0;
    let mut knock = event(13.5, 13.8, 0.0);
    knock.kind = EventKind::Bursts;
    let sound = sound(vec![rumble, event(11.0, 12.9, 0.0), knock]);
    let mut signal = signal(&[(60.0, 0.5, 0.0)]);
    // The tone, and a knock that does not sound with it.
    for (start, count, sine) in [
        (44_100, 83_790, TONE),
        (154_350, 13_230, (2000.0, 1.0, 0.0)),
    ] {
        let part = signal.samples[start..].iter_mut();
        part.zip(sines(RATE, count, &[sine]))
            .for_each(|(sample, sine)| *sample += sine);
    }
    let chosen = |number| select(&signal, Some(&sound), number).unwrap().0;
    let background = |stretch| background_power(&signal, &sound.tonal.events, stretch);
    let tone = chosen(Some(2));
    assert_eq!(tone.band_hz, Some([1000.0 / 3.0, 3500.0]));
    // The interval before the tone, where the band leaves out the rumble of power 0.125.
    assert!(background(&tone).unwrap() < 1e-3);
    // The band of the rumble has the tone, too, and the rumble sounds throughout.
    let noise = chosen(Some(1));
    assert_eq!(noise.band_hz, None);
    assert_eq!(background(&noise), None);
    let whole = AnalysedStretch {
        event: None,
        ..noise
    };
    assert_eq!(background(&whole), None);
}

#[test]
fn a_drifting_event_is_demodulated() {
    let drifting = event(11.0, 13.0, 5.0);
    let sound = sound(vec![drifting]);
    let (stretch, part, _) = select(&signal(&[TONE]), Some(&sound), None).unwrap();
    assert!(stretch.demodulated && part.is_some());
}

#[test]
fn the_strongest_event_is_the_default_and_others_can_be_requested() {
    let sound = sound(vec![event(10.1, 10.6, 0.0), event(11.0, 13.0, 0.0)]);
    let signal = signal(&[TONE]);
    let chosen = |number| select(&signal, Some(&sound), number).map(|s| s.0.event);
    assert_eq!(chosen(None), Ok(Some(2)));
    assert_eq!(chosen(Some(1)), Ok(Some(1)));
    for number in [0, 3] {
        let missing = SignalError::NoEvent { number, found: 2 };
        assert_eq!(chosen(Some(number)), Err(missing));
    }
    // More than 40 dB below the recording, an event is analysed only on request.
    let mut loud = sound.clone();
    loud.recording_level_db = 34.1;
    for number in [None, Some(1)] {
        let (stretch, ..) = select(&signal, Some(&loud), number).unwrap();
        assert_eq!(stretch.event, number);
    }
    let no_sound = select(&signal, None, Some(1)).map(|s| s.0.event);
    assert_eq!(no_sound, Err(SignalError::NotSound));
    let (stretch, part, _) = select(&signal, None, None).unwrap();
    assert!(part.is_none() && stretch.event.is_none());
}

#[test]
fn clipped_samples_are_avoided_or_reported() {
    let span = |start_s, end_s| Span { start_s, end_s };
    let mut sound = sound(vec![event(10.5, 13.5, 0.0)]);
    sound.condition.clipped = vec![span(11.0, 11.1)];
    sound.condition.dropouts = vec![span(13.2, 13.21)];
    let (avoided, ..) = select(&signal(&[TONE]), Some(&sound), None).unwrap();
    assert_eq!((avoided.start_s, avoided.end_s), (11.1, 13.2));
    assert!(!avoided.clipped);
    sound.condition.clipped = vec![span(10.5, 13.5)];
    let (stretch, ..) = select(&signal(&[TONE]), Some(&sound), None).unwrap();
    assert!(stretch.clipped);
}

#[test]
fn a_short_event_is_no_stationary_stretch() {
    let mut short = event(11.0, 11.15, 0.0);
    short.frequency_hz = 220.0;
    let sound = sound(vec![short]);
    let (stretch, _, obstacle) = select(&signal(&[TONE]), Some(&sound), None).unwrap();
    assert_eq!(obstacle, Some(SkipReason::NotStationary));
    assert_eq!((stretch.start_s, stretch.end_s), (11.0, 11.15));
}
