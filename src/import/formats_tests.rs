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
    for (name, bytes, rate) in [
        (
            "tone.mp3",
            &include_bytes!("../../tests/data/tone.mp3")[..],
            8000.0,
        ),
        (
            "tone.ogg",
            include_bytes!("../../tests/data/tone.ogg"),
            8000.0,
        ),
        (
            "tone.m4a",
            include_bytes!("../../tests/data/tone.m4a"),
            8000.0,
        ),
        (
            "tone.aac",
            include_bytes!("../../tests/data/tone.aac"),
            8000.0,
        ),
        (
            "tone.opus",
            include_bytes!("../../tests/data/tone.opus"),
            48_000.0,
        ),
    ] {
        let path = desk.put(name, bytes);
        for (column, frequency, level) in [("left", LEFT, 0.5), ("right", RIGHT, 0.25)] {
            let signal = read_signal(&path, &selection(&[("column", column)])).unwrap();
            assert_eq!(signal.rate, rate, "{name}");
            assert!(signal.duration() >= 0.2, "{name}: {}", signal.duration());
            let skipped = (rate / 8000.0) as usize;
            let samples: Vec<f64> = signal.samples.iter().step_by(skipped).copied().collect();
            // The delay of the AAC encoder is not removed.
            let is_aac = ["tone.m4a", "tone.aac"].contains(&name);
            let delay = if is_aac { 1024 } else { 0 };
            let found = amplitude(&samples[delay..], frequency);
            assert!(
                (found / level - 1.0).abs() < 0.02,
                "{name}, {column}: {found}"
            );
        }
    }
    // Opus has its own delay, which its header states.
    let path = desk.put("tone.opus", include_bytes!("../../tests/data/tone.opus"));
    let signal = read_signal(&path, &selection(&[("column", "left")])).unwrap();
    assert_eq!(signal.samples.len(), 9600);
    let expected = |k: usize| 0.5 * (TAU * LEFT / 6.0 * k as f64 + 0.3).sin();
    let errors = (2000..8000).map(|k| (signal.samples[k] - expected(k)).abs());
    assert!(errors.fold(0.0, f64::max) < 0.02);
}

#[test]
fn telephone_codings_of_wav_are_read() {
    let desk = TestFolder::new();
    let wav = |tag: u8, frame: u8, bits: u8, extra: &[u8], data: &[u8]| {
        let mut bytes = b"RIFF\0\0\0\0WAVEfmt ".to_vec();
        bytes.extend((16 + extra.len() as u32).to_le_bytes());
        bytes.extend([
            tag, 0, 1, 0, 0x40, 0x1F, 0, 0, 0x40, 0x1F, 0, 0, frame, 0, bits, 0,
        ]);
        bytes.extend(extra);
        bytes.extend(b"data");
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(data);
        bytes
    };
    // Codes of known samples (ITU-T G.711): the largest ones and the smallest ones.
    let mu_law = wav(7, 1, 8, &[0, 0], &[0x80, 0x00, 0xFF, 0x7F]);
    let a_law = wav(6, 1, 8, &[0, 0], &[0xAA, 0x2A, 0xD5, 0x55]);
    for (bytes, expected) in [
        (mu_law, [32_124.0, -32_124.0, 0.0, 0.0]),
        (a_law, [32_256.0, -32_256.0, 8.0, -8.0]),
    ] {
        let signal = read_signal(&desk.put("a.wav", bytes), &selection(&[])).unwrap();
        assert_eq!(signal.samples, expected.map(|x| x / 32_768.0));
    }
    // ADPCM of the IMA: a block with its first sample (1000), step index 0 and the differences of eight samples. With
    // steps of 7, 7, 7, 7 the code 0 adds an eighth of the step: nothing in integers.
    let block = [0xE8, 0x03, 0, 0, 0, 0, 0, 0];
    let adpcm = wav(17, 8, 4, &[2, 0, 9, 0], &block);
    let signal = read_signal(&desk.put("a.wav", adpcm), &selection(&[])).unwrap();
    assert_eq!(signal.samples, [1000.0 / 32_768.0; 9]);
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
fn incomplete_sound_is_called_damaged() {
    let desk = TestFolder::new();
    let damage = |name: &str, bytes: &[u8]| {
        let mut damage = String::new();
        let path = desk.put(name, bytes);
        let read = read_signal_with(&path, &selection(&[("column", "left")]), &mut |found| {
            damage = found.to_owned();
        });
        read.err()
            .map_or(damage, |refused| refused.problem.to_string())
    };
    let mp3 = include_bytes!("../../tests/data/tone.mp3");
    assert_eq!(damage("whole.mp3", mp3), "");
    let half = damage("half.mp3", &mp3[..1500]);
    assert!(half.contains("header states"), "{half}");
    let m4a = include_bytes!("../../tests/data/tone.m4a");
    let index = m4a.windows(4).position(|name| name == b"moov").unwrap();
    let media = m4a.windows(4).position(|name| name == b"mdat").unwrap();
    assert!(media < index);
    let half = damage("half.m4a", &m4a[..index - 100]);
    assert!(
        half.contains("the index of the samples is missing"),
        "{half}"
    );
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

/// A dataset 58 with 14 samples of a node; the last lines are those of the samples.
fn history(node: u32, form: [u32; 3], step: f64, samples: &str) -> String {
    let [ordinate, pairs, even] = form;
    let texts = "rig 3\nNONE\n19-Aug-26\nNONE\nNONE\n";
    let node =
        format!("    1         0    0         0       NONE{node:10}   3       NONE         0   0");
    let axis = |kind: u32, label: &str, unit: &str| {
        format!("{kind:10}    0    0    0 {label:>20} {unit:>20}\n")
    };
    let axes = [
        axis(17, "Time", "s"),
        axis(12, "Acceleration", "m/s^2"),
        axis(0, "NONE", "NONE"),
    ];
    let axes = axes.concat() + &axis(0, "NONE", "NONE");
    let form = format!(
        "{ordinate:10}{pairs:10}{even:10}{:13.5e}{step:13.5e}{:13.5e}",
        0.5, 0.0
    );
    format!("{texts}{node}\n{form}\n{axes}{samples}")
}

#[test]
fn time_histories_of_universal_files_are_columns() {
    let desk = TestFolder::new();
    let samples: Vec<f64> = (0..14).map(|k| f64::from(k * k) / 8.0).collect();
    let text = |numbers: &mut dyn Iterator<Item = f64>| -> String {
        numbers.map(|x| format!("{x:20.12E}\n")).collect()
    };
    let even = history(
        12,
        [4, 14, 1],
        3.90625e-5,
        &text(&mut samples.iter().copied()),
    );
    let pairs = samples
        .iter()
        .enumerate()
        .flat_map(|(k, x)| [0.5 + 1e-3 * k as f64, *x]);
    let uneven = history(13, [2, 14, 0], 0.0, &text(&mut pairs.into_iter()));
    let other = even
        .replacen("    1         0", "    4         0", 1)
        .replacen("        17", "        18", 1);
    let sets = [&even, &uneven, &other].map(|set| format!("    -1\n    58\n{set}    -1\n"));
    let file = "    -1\n   151\nmodel\n    -1\n".to_owned() + &sets.concat();
    let path = desk.put("run.uff", &file);
    let read = |column: &str| read_signal(&path, &selection(&[("column", column)]));
    for (column, rate) in [("12:+Z", 25_600.0), ("13:+Z", 1000.0)] {
        let signal = read(column).unwrap();
        assert_eq!((&signal.samples, &*signal.unit), (&samples, "m/s^2"));
        assert_eq!((signal.rate, signal.start), (rate, 0.5), "{column}");
    }
    let refused = read("14:+Z").unwrap_err().to_string();
    assert!(
        refused.ends_with("choose one of: 12:+Z, 13:+Z"),
        "{refused}"
    );
    // Binary, of both byte orders.
    for (order, bytes) in [
        (1, f32::to_le_bytes as fn(f32) -> [u8; 4]),
        (2, f32::to_be_bytes),
    ] {
        let head = format!("    -1\n    58b{order:6}{:6}{:12}{:12}\n", 2, 11, 56);
        let mut file = (head + &history(5, [2, 14, 1], 1e-3, "")).into_bytes();
        file.extend(samples.iter().flat_map(|x| bytes(*x as f32)));
        let cut = desk.put("cut.uff", &file[..file.len() - 1]);
        file.extend(b"\n    -1\n");
        let signal = read_signal(&desk.put("run.uff", file), &selection(&[])).unwrap();
        assert_eq!((signal.samples, signal.rate), (samples.clone(), 1000.0));
        let refused = read_signal(&cut, &selection(&[])).unwrap_err().to_string();
        assert!(refused.contains("55 of 56 bytes"), "{refused}");
    }
    let cut = desk.put("cut.uff", &file[..file.len() - 900]);
    let mut warnings = Vec::new();
    let mut warn = |damage: &str| warnings.push(damage.to_owned());
    let signal = read_signal_with(&cut, &selection(&[]), &mut warn).unwrap();
    assert_eq!(signal.samples, samples);
    assert!(
        warnings.len() == 1 && warnings[0].contains("of 14 samples"),
        "{warnings:?}"
    );
    let shapes = desk.put("shapes.uff", "    -1\n    55\nNONE\n    -1\n");
    let refused = read_signal(&shapes, &selection(&[]))
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("only 1 datasets of other kinds"),
        "{refused}"
    );
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
        (b"#!AMR\n", ["sound", "ffmpeg -i"]),
        (b"\x1a\x45\xdf\xa3", ["sound", "ffmpeg -i"]),
    ] {
        let path = desk.put("signal.bin", head);
        let refused = read_signal(&path, &Selection::default()).unwrap_err();
        let message = refused.to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}
