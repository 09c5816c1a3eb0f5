//! Signals in NumPy arrays.

use std::io::Write;

use npyz::WriterBuilder;

use super::tests::{TestFolder, selection, wave};
use super::*;
use crate::numpy::{Array, encode_npz};

pub(super) fn npy<T: npyz::AutoSerialize + Copy>(
    shape: &[u64],
    order: npyz::Order,
    values: &[T],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .order(order)
        .writer(&mut bytes)
        .begin_nd()
        .unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn arrays_of_every_type_are_read() {
    use npyz::Order::{C, Fortran};
    let folder = TestFolder::new();
    let read = |bytes: Vec<u8>, words: &[(&str, &str)]| {
        let words = [&[("rate", "10")][..], words].concat();
        read_signal(&folder.put("array.npy", bytes), &selection(&words)).unwrap()
    };
    let expected = vec![1.0, 2.0, 100.0];
    let files = [
        npy(&[3], C, &[1_i8, 2, 100]),
        npy(&[3], C, &[1_i16, 2, 100]),
        npy(&[3], C, &[1_i32, 2, 100]),
        npy(&[3], C, &[1_i64, 2, 100]),
        npy(&[3], C, &[1_u8, 2, 100]),
        npy(&[3], C, &[1_u16, 2, 100]),
        npy(&[3], C, &[1_u32, 2, 100]),
        npy(&[3], C, &[1_u64, 2, 100]),
        npy(&[3], C, &[1_f32, 2.0, 100.0]),
        npy(&[3], C, &[1_f64, 2.0, 100.0]),
        npy(&[3], C, &[1.0, 2.0, 100.0].map(half::f16::from_f64)),
    ];
    for bytes in files {
        assert_eq!(read(bytes, &[]).samples, expected);
    }
    // Big-endian: set in the header, with swapped bytes.
    let mut bytes = npy(
        &[3],
        C,
        &[1_f64, 2.0, 100.0].map(|x| x.to_bits().swap_bytes()),
    );
    let at = bytes.windows(3).position(|w| w == b"<u8").unwrap();
    bytes[at..at + 3].copy_from_slice(b">f8");
    assert_eq!(read(bytes, &[]).samples, expected);
    // Two axes: the longer one is the time, in either memory order.
    let values = [1.0, -1.0, 2.0, -2.0, 100.0, -100.0];
    for (shape, order, values) in [
        ([3, 2], C, values),
        ([2, 3], Fortran, values),
        ([2, 3], C, [1.0, 2.0, 100.0, -1.0, -2.0, -100.0]),
        ([3, 2], Fortran, [1.0, 2.0, 100.0, -1.0, -2.0, -100.0]),
    ] {
        let bytes = npy(&shape, order, &values);
        assert_eq!(read(bytes.clone(), &[("column", "0")]).samples, expected);
        assert_eq!(
            read(bytes, &[("column", "1")]).samples,
            [-1.0, -2.0, -100.0]
        );
    }
}

#[test]
fn arrays_without_a_signal_are_rejected() {
    let folder = TestFolder::new();
    let refused = |bytes: &[u8]| {
        let words = selection(&[("rate", "10")]);
        let error = read_signal(&folder.put("array.npy", bytes), &words);
        error.unwrap_err().to_string()
    };
    let whole = npy(&[30], npyz::Order::C, &[1.5; 30]);
    assert!(refused(&whole[..whole.len() - 3]).contains("truncated: array `array` has 237 of"));
    assert!(refused(&whole[..50]).contains("damaged"));
    let retyped = |to: &str| {
        let text = String::from_utf8_lossy(&whole[10..128]).replace("<f8", to);
        let mut bytes = whole[..10].to_vec();
        bytes.extend(text.as_bytes().iter().chain(&[b' '; 8]).take(118));
        bytes.extend(&whole[128..]);
        refused(&bytes)
    };
    for kind in ["<c8", "|b1", "|S8", "<M8[ns]"] {
        let message = retyped(kind);
        assert!(message.contains("save real numbers"), "{kind}: {message}");
    }
    assert!(refused(&npy(&[2, 3, 5], npyz::Order::C, &[1.0; 30])).contains("array of 3 axes"));
    assert!(refused(&npy(&[], npyz::Order::C, &[1.0])).contains("no sample"));
    assert!(refused(&npy::<f64>(&[0], npyz::Order::C, &[])).contains("no sample"));
}

#[test]
fn archives_contain_names_and_a_clock() {
    let folder = TestFolder::new();
    let path = folder.0.path().join("run.npz");
    let t = (0..50).map(|k| 2.0 + f64::from(k) / 200_000.0).collect();
    let u: Vec<f64> = (0..50).map(wave).collect();
    let q = u.iter().flat_map(|x| [*x, 2.0 * x]).collect();
    let arrays = [
        ("t", Array::vector(t)),
        ("q", Array::matrix(50, q)),
        ("u", Array::vector(u.clone())),
        ("short", Array::vector(vec![1.0, 2.0])),
    ];
    encode_npz(std::fs::File::create(&path).unwrap(), &arrays).unwrap();
    let asked = |words: &[(&str, &str)]| read_signal(&path, &selection(words));
    let signal = asked(&[("column", "u")]).unwrap();
    assert_eq!(
        (signal.samples, signal.rate, signal.start),
        (u.clone(), 200_000.0, 2.0)
    );
    assert_eq!(
        asked(&[("column", "q[1]")]).unwrap().samples[7],
        2.0 * wave(7)
    );
    let message = asked(&[]).unwrap_err().to_string();
    assert!(message.ends_with("q[0], q[1], u, short"), "{message}");
    let message = asked(&[("column", "short")]).unwrap_err().to_string();
    assert!(
        message.contains("50 times for 2 samples of `short`"),
        "{message}"
    );
    let arrays = [
        ("fs", Array::number(48_000.0)),
        ("x", Array::vector(u.clone())),
    ];
    encode_npz(std::fs::File::create(&path).unwrap(), &arrays).unwrap();
    assert_eq!(asked(&[]).unwrap().rate, 48_000.0);
    let whole = std::fs::read(&path).unwrap();
    folder.put("run.npz", &whole[..whole.len() / 2]);
    assert!(asked(&[]).unwrap_err().to_string().contains("damaged"));
    // As written by numpy.savez_compressed.
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let deflated = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated);
    zip.start_file("x.npy", deflated).unwrap();
    zip.write_all(&npy(&[50], npyz::Order::C, &u)).unwrap();
    zip.finish().unwrap();
    assert_eq!(asked(&[("rate", "10")]).unwrap().samples, u);
}
