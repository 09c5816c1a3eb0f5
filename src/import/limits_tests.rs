//! Memory limits of reading.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;

use super::array_tests::npy;
use super::table::MAX_COLUMNS;
use super::tests::{TestFolder, wav};
use super::*;
use crate::numpy::{Array, encode_npz};

fn read(bytes: &[u8], selection: &Selection) -> Result<Signal, Problem> {
    let folder = TestFolder::new();
    let path = folder.put("file", bytes);
    read_signal(&path, selection).map_err(|error| error.problem)
}

fn refused(bytes: &[u8], selection: &Selection) -> String {
    read(bytes, selection).unwrap_err().to_string()
}

/// Files of every format with a column sampled at 10 Hz.
fn files() -> Vec<(&'static str, Vec<u8>, Selection)> {
    let sample = |k: usize| (k as f64).sqrt().fract();
    let column = |name: &str, rate| Selection {
        column: Some(name.to_owned()),
        rate,
        ..Selection::default()
    };
    let both = |order| {
        let values: Vec<f64> = match order {
            npyz::Order::C => (0..400).map(sample).collect(),
            npyz::Order::Fortran => (0..400).map(|k| -sample(k)).collect(),
        };
        npy(&[200, 2], order, &values)
    };
    let mut npz = Cursor::new(Vec::new());
    let times = (0..200).map(|k| 0.1 * f64::from(k)).collect();
    let values = (0..400).map(sample).collect();
    let arrays = [
        ("t", Array::vector(times)),
        ("q", Array::matrix(200, values)),
    ];
    encode_npz(&mut npz, &arrays).unwrap();
    let rows = (0..200).map(|k| format!("{:.1};{:.6};{k}\n", 0.1 * k as f64, sample(k)));
    let rows: String = rows.collect();
    // The WAV file has a sample rate of 8 kHz instead of 10 Hz.
    let mut sound = wav(16, false, 2, 200);
    sound[24..28].copy_from_slice(&10_u32.to_le_bytes());
    vec![
        ("wav", sound, column("right", None)),
        ("C order", both(npyz::Order::C), column("1", Some(10.0))),
        (
            "Fortran order",
            both(npyz::Order::Fortran),
            column("1", Some(10.0)),
        ),
        ("npz", npz.into_inner(), column("q[1]", None)),
        (
            "text, time by name",
            format!("t;u;v\n{rows}").into(),
            column("u", None),
        ),
        ("text, time by its values", rows.into(), column("0", None)),
    ]
}

#[test]
fn a_time_range_selects_a_part_of_the_samples() {
    for (name, bytes, selection) in files() {
        let all = read(&bytes, &selection).unwrap();
        assert_eq!((all.samples.len(), all.rate), (200, 10.0), "{name}");
        for (from, to) in [(0, 1), (0, 200), (17, 18), (3, 150), (199, 200)] {
            let part = Selection {
                from: Some(0.1 * from as f64),
                to: Some(0.1 * to as f64),
                max_samples: Some(to - from),
                ..selection.clone()
            };
            let signal = read(&bytes, &part).unwrap();
            assert_eq!(
                signal.samples,
                all.samples[from..to],
                "{name}, {from} to {to}"
            );
            assert!((signal.start - 0.1 * from as f64).abs() < 1e-12, "{name}");
            if to - from > 1 {
                let fewer = Selection {
                    max_samples: Some(to - from - 1),
                    ..part
                };
                let said = format!(
                    "the selection has {} samples, more than the limit of",
                    to - from
                );
                assert!(refused(&bytes, &fewer).contains(&said), "{name}");
            }
        }
    }
}

/// Bit depths that do not fit into the number of bytes.
#[test]
fn an_invalid_bit_depth_is_reported_as_damage() {
    let with = |mut bytes: Vec<u8>, bits: u16| {
        let at = bytes.windows(4).position(|w| w == b"fmt ").unwrap() + 22;
        bytes[at..at + 2].copy_from_slice(&bits.to_le_bytes());
        bytes
    };
    let any = Selection::default();
    for (depth, float, bits) in [
        (16, false, 32),
        (16, false, 17),
        (8, false, 16),
        (32, true, 64),
    ] {
        let bytes = with(wav(depth, float, 1, 50), bits);
        let said = format!(
            "1 x {bits} bits per sample, but a block size of {} x 8 bits",
            depth / 8
        );
        let message = refused(&bytes, &any);
        assert!(
            message.contains("damaged") && message.contains(&said),
            "{message}"
        );
    }
    // Integers that do not use their lowest bits.
    let bytes = with(wav(16, false, 1, 50), 12);
    assert_eq!(
        read(&bytes, &any).unwrap(),
        read(&wav(16, false, 1, 50), &any).unwrap()
    );
}

#[test]
fn chunks_are_not_stored() {
    // A chunk that claims 4 GB but is missing, before and after the samples.
    let mut bytes = wav(16, false, 1, 50);
    let remark = b"LIST\xfe\xff\xff\xff";
    bytes.splice(12..12, remark.iter().copied());
    let message = refused(&bytes, &Selection::default());
    assert!(message.contains("the `data` chunk is missing"), "{message}");
    let mut bytes = wav(16, false, 1, 50);
    bytes.extend(remark);
    assert_eq!(
        read(&bytes, &Selection::default()).unwrap().samples.len(),
        50
    );
}

#[test]
fn lines_and_columns_are_limited() {
    let any = Selection::default();
    let long = |length: usize| format!("t,u\n0,1\n# {}\n1,2\n", "x".repeat(length - 2));
    assert_eq!(
        read(long(1 << 20).as_bytes(), &any).unwrap().samples,
        [1.0, 2.0]
    );
    let message = refused(long((1 << 20) + 1).as_bytes(), &any);
    assert!(
        message.contains("line 3 is longer than 1048576 bytes"),
        "{message}"
    );
    let wide = |columns: usize| format!("{}1\n", "0;".repeat(columns - 1)).repeat(2);
    let last = Selection {
        column: Some((MAX_COLUMNS - 1).to_string()),
        rate: Some(1.0),
        ..Selection::default()
    };
    let signal = read(wide(MAX_COLUMNS).as_bytes(), &last).unwrap();
    assert_eq!(signal.samples, [1.0, 1.0]);
    let message = refused(wide(MAX_COLUMNS + 1).as_bytes(), &last);
    assert!(
        message.contains("16385 columns; the maximum is 16384"),
        "{message}"
    );
}

/// A compressed archive with one array.
fn archive(name: &str, bytes: &[u8]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut zip = zip::ZipWriter::new(&mut out);
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    zip.start_file(name, options).unwrap();
    zip.write_all(bytes).unwrap();
    zip.finish().unwrap();
    out.into_inner()
}

/// An archive that claims another size of its array.
fn lying(mut archive: Vec<u8>, length: u32) -> Vec<u8> {
    let directory = archive
        .windows(4)
        .rposition(|w| w == b"PK\x01\x02")
        .unwrap();
    archive[directory + 24..directory + 28].copy_from_slice(&length.to_le_bytes());
    archive
}

#[test]
fn an_array_with_another_size_than_its_header_is_rejected() {
    let rate = Selection {
        rate: Some(1.0),
        ..Selection::default()
    };
    let whole = npy(&[1000], npyz::Order::C, &[1_i8; 1000]);
    let mut grown = whole.clone();
    let shape = whole.windows(4).position(|w| w == b"1000").unwrap();
    grown[shape..shape + 4].copy_from_slice(b"9999");
    let message = refused(&archive("x.npy", &grown), &rate);
    assert!(
        message.contains("array `x` has 1000 of 9999 bytes"),
        "{message}"
    );
    // The archive claims more bytes than it contains.
    let message = refused(&lying(archive("x.npy", &grown), 1 << 30), &rate);
    assert!(
        message.contains("array `x` has 1000 of 9999 bytes"),
        "{message}"
    );
    // Too many columns, according to the header alone.
    let mut wide = whole;
    let shape = wide.windows(5).position(|w| w == b"(1000").unwrap();
    wide.truncate(shape);
    wide.extend(b"(20000, 20000)}");
    wide.resize(127, b' ');
    wide.push(b'\n');
    let message = refused(&lying(archive("x.npy", &wide), u32::MAX - 1), &rate);
    assert!(
        message.contains("20000 columns; the maximum is 16384"),
        "{message}"
    );
}

#[test]
fn damage_outside_the_selection_is_found_by_the_checksum() {
    let values: Vec<f64> = (0..1000).map(f64::from).collect();
    let mut bytes = Cursor::new(Vec::new());
    encode_npz(&mut bytes, &[("x", Array::vector(values))]).unwrap();
    let mut bytes = bytes.into_inner();
    let start = Selection {
        rate: Some(1.0),
        to: Some(10.0),
        ..Selection::default()
    };
    assert_eq!(read(&bytes, &start).unwrap().samples.len(), 10);
    let last = bytes
        .windows(8)
        .rposition(|w| w == 999_f64.to_le_bytes())
        .unwrap();
    bytes[last] ^= 1;
    let message = refused(&bytes, &start);
    assert!(
        message.contains("damaged") && message.contains("checksum"),
        "{message}"
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_is_rejected_without_blocking() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo")
        .arg(&path)
        .status()
        .unwrap();
    assert!(made.success());
    let message = read_signal(&path, &Selection::default())
        .unwrap_err()
        .to_string();
    assert!(message.contains("a pipe or a device"), "{message}");
}
