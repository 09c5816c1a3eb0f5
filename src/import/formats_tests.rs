//! Compressed sound and MATLAB files, written by libsndfile and SciPy.

use std::f64::consts::TAU;

use super::tests::{TestFolder, selection};
use super::*;

const LEFT: f64 = 0.0625;
const RIGHT: f64 = 0.03125;

/// Amplitude at a frequency (cycles per sample) of 1024 samples, a whole number of periods.
fn amplitude(samples: &[f64], frequency: f64) -> f64 {
    let mut sums = [0.0; 2];
    for (k, x) in samples[256..1280].iter().enumerate() {
        let (sin, cos) = (TAU * frequency * k as f64).sin_cos();
        sums = [sums[0] + x * cos, sums[1] + x * sin];
    }
    sums[0].hypot(sums[1]) / 512.0
}

#[test]
fn sound_without_loss_is_exact() {
    let desk = TestFolder::new();
    for (name, bytes) in [
        (
            "tone.flac",
            &include_bytes!("../../tests/data/tone.flac")[..],
        ),
        ("tone.aiff", include_bytes!("../../tests/data/tone.aiff")),
    ] {
        let path = desk.put(name, bytes);
        let read = |words: &[(&str, &str)]| read_signal(&path, &selection(words)).unwrap();
        let left = read(&[("column", "left")]);
        assert_eq!((left.rate, left.samples.len()), (8000.0, 1600), "{name}");
        assert_eq!(left.unit, "FS");
        let expected = |k: usize| 0.5 * (TAU * LEFT * k as f64 + 0.3).sin();
        for (k, x) in left.samples.iter().enumerate() {
            assert!(
                (x - expected(k)).abs() < 1.0 / 32768.0,
                "{name}, sample {k}"
            );
        }
        let part = read(&[("column", "left"), ("from", "0.05"), ("to", "0.1")]);
        assert_eq!(part.samples, left.samples[400..800], "{name}");
        assert!(amplitude(&read(&[("column", "1")]).samples, RIGHT) > 0.249);
        let refused = read_signal(&path, &Selection::default()).unwrap_err();
        assert!(refused.to_string().contains("choose one with --column"));
    }
}

#[test]
fn sound_with_loss_has_its_tone_at_its_level() {
    let desk = TestFolder::new();
    for (name, bytes) in [
        ("tone.mp3", &include_bytes!("../../tests/data/tone.mp3")[..]),
        ("tone.ogg", include_bytes!("../../tests/data/tone.ogg")),
    ] {
        let path = desk.put(name, bytes);
        for (column, frequency, level) in [("left", LEFT, 0.5), ("right", RIGHT, 0.25)] {
            let signal = read_signal(&path, &selection(&[("column", column)])).unwrap();
            assert_eq!(signal.rate, 8000.0, "{name}");
            assert!(
                signal.samples.len() >= 1600,
                "{name}: {}",
                signal.samples.len()
            );
            let found = amplitude(&signal.samples, frequency);
            assert!(
                (found / level - 1.0).abs() < 0.02,
                "{name}, {column}: {found}"
            );
        }
    }
}

#[test]
fn damaged_sound_is_refused() {
    let desk = TestFolder::new();
    let flac = include_bytes!("../../tests/data/tone.flac");
    for end in [4, 30, 60] {
        let path = desk.put("cut.flac", &flac[..end]);
        let refused = read_signal(&path, &selection(&[("column", "0")])).unwrap_err();
        let known = matches!(refused.problem, Problem::Content(_));
        assert!(known, "{end}: {refused}");
    }
}

#[test]
fn arrays_of_matlab_are_columns() {
    let desk = TestFolder::new();
    let plain = desk.put("plain.mat", include_bytes!("../../tests/data/plain.mat"));
    let x = read_signal(&plain, &selection(&[("column", "x")])).unwrap();
    assert_eq!((x.rate, x.samples.len()), (8000.0, 200));
    let expected = |k: usize| 0.5 * (TAU * LEFT * k as f64 + 0.3).sin();
    assert!((0..200).all(|k| (x.samples[k] - expected(k)).abs() < 1e-15));
    let first = read_signal(&plain, &selection(&[("column", "pair[0]")])).unwrap();
    assert_eq!(first.samples, x.samples);
    let packed = desk.put(
        "compressed.mat",
        include_bytes!("../../tests/data/compressed.mat"),
    );
    let single = read_signal(&packed, &selection(&[("column", "x")])).unwrap();
    assert!((single.rate - 8000.0).abs() < 1e-6);
    assert!((0..200).all(|k| (single.samples[k] - expected(k)).abs() < 1e-7));
    let counts = read_signal(&packed, &selection(&[("column", "counts")])).unwrap();
    assert!((0..200).all(|k| (counts.samples[k] - 1000.0 * expected(k)).abs() <= 0.5));
    // Text and complex numbers are no columns.
    let refused = read_signal(&plain, &selection(&[("column", "z")])).unwrap_err();
    assert!(
        refused.to_string().contains("x, pair[0], pair[1]"),
        "{refused}"
    );
    let cut = desk.put(
        "cut.mat",
        &include_bytes!("../../tests/data/plain.mat")[..900],
    );
    let refused = read_signal(&cut, &selection(&[("column", "x")])).unwrap_err();
    assert!(refused.to_string().contains("array 1 has"), "{refused}");
}

#[test]
fn files_of_other_libraries_are_named_with_the_remedy() {
    let desk = TestFolder::new();
    for (head, words) in [
        (
            &b"MATLAB 7.3 MAT-file, Platform: GLNXA64"[..],
            ["HDF5", "-v7"],
        ),
        (b"\x89HDF\r\n\x1a\n", ["HDF5", "h5py"]),
        (b"TDSm\x0e\x00\x00\x00", ["TDMS", "nptdms"]),
    ] {
        let path = desk.put("signal.bin", head);
        let refused = read_signal(&path, &Selection::default()).unwrap_err();
        let message = refused.to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}
