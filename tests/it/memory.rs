//! Memory: a file takes only the memory of the selected samples, whatever its header announces. Input
//! that exceeds the memory is rejected with one message. The peak is the system's value (`VmHWM`), which
//! does not depend on other load of the machine.

use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use squeakscope::import::MAX_SAMPLES;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

const MB: u64 = 1_000_000;

/// Memory of the program itself and of short signals, bytes.
const BASELINE: u64 = 80 * MB;

/// Number of values, above all limits, of an array that takes an eighth of a megabyte in its file.
const ZEROS: usize = (1 << 27) + (1 << 20);

/// A temporary folder with files.
struct TestDir(tempfile::TempDir);

/// Outcome of a program run.
struct Outcome {
    code: Option<i32>,
    message: String,
    /// Peak memory, bytes.
    peak: u64,
}

impl TestDir {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn create(&self, name: &str) -> BufWriter<File> {
        BufWriter::new(File::create(self.path(name)).expect("created"))
    }

    /// Runs the program, with `limit` kB of address space if given.
    fn run(&self, args: &str, limit: Option<u64>) -> Outcome {
        let limit = limit.map_or_else(|| "unlimited".to_owned(), |kilobytes| kilobytes.to_string());
        let mut child = Command::new("sh")
            .args([
                "-c",
                "ulimit -v \"$1\" && shift && exec \"$@\"",
                "sh",
                &limit,
            ])
            .arg(env!("CARGO_BIN_EXE_squeakscope"))
            .args(args.split(' '))
            // Each thread takes address space.
            .env("RAYON_NUM_THREADS", "2")
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        let ended = loop {
            peak = peak.max(peak_memory(&status).unwrap_or(0));
            if let Some(ended) = child.try_wait().expect("a child") {
                break ended;
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let mut message = String::new();
        let mut stderr = child.stderr.take().expect("piped");
        stderr.read_to_string(&mut message).expect("text");
        Outcome {
            code: ended.code(),
            message,
            peak,
        }
    }

    /// Error message for invalid input, from a run with a peak memory below `max_peak`.
    ///
    /// On a busy machine a short run can end before its memory is read; it is then repeated.
    fn rejection(&self, args: &str, limit: Option<u64>, max_peak: u64) -> String {
        let mut runs = (0..100).map(|_| self.run(args, limit));
        let end = runs
            .find(|end| end.peak > 0)
            .expect("a run with its memory");
        assert_eq!(end.code, Some(2), "{args}: {}", end.message);
        assert!(end.message.starts_with("error: "), "{}", end.message);
        assert_eq!(end.message.trim_end().lines().count(), 1, "{}", end.message);
        assert!(end.peak < max_peak, "{args}: {} bytes", end.peak);
        end.message
    }

    /// A mono WAV file with 8 bits per sample: a 4.1 kHz tone at 48 kHz.
    fn wav(&self, name: &str, samples: usize) {
        let mut file = self.create(name);
        let mut header = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0".to_vec();
        for number in [48_000_u32, 48_000, 0x0008_0001] {
            header.extend(number.to_le_bytes());
        }
        header.extend(b"data");
        header.extend((samples as u32).to_le_bytes());
        file.write_all(&header).expect("written");
        // One second contains a whole number of periods.
        let tone =
            |k: u32| 128.0 + 90.0 * (std::f64::consts::TAU * 4117.0 / 48e3 * f64::from(k)).sin();
        let second: Vec<u8> = (0..48_000).map(|k| tone(k) as u8).collect();
        let mut left = samples;
        while left > 0 {
            let count = left.min(second.len());
            file.write_all(&second[..count]).expect("written");
            left -= count;
        }
    }
}

/// Peak memory from a status file, bytes.
fn peak_memory(status: &str) -> Option<u64> {
    let status = fs::read_to_string(status).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

/// Adds an array of [`ZEROS`] 8-bit zeros to an archive.
fn add_zeros(zip: &mut ZipWriter<File>, name: &str) {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    zip.start_file(format!("{name}.npy"), options)
        .expect("begun");
    let text = format!("{{'descr': '|i1', 'fortran_order': False, 'shape': ({ZEROS},), }}");
    let text = format!("{text:117}\n");
    zip.write_all(b"\x93NUMPY\x01\0\x76\0").expect("written");
    zip.write_all(text.as_bytes()).expect("written");
    let block = vec![0; 1 << 20];
    for _ in 0..ZEROS >> 20 {
        zip.write_all(&block).expect("written");
    }
}

#[test]
fn an_archive_of_zeros_is_rejected_by_its_header() {
    let dir = TestDir::new();
    let mut zip = ZipWriter::new(File::create(dir.path("bomb.npz")).expect("created"));
    add_zeros(&mut zip, "x");
    zip.finish().expect("written");
    assert!(fs::metadata(dir.path("bomb.npz")).expect("there").len() < 2 * MB);
    let args = "analyse bomb.npz --rate 48000";
    let message = dir.rejection(args, None, BASELINE);
    let expected =
        format!("the selection has {ZEROS} samples, more than the limit of {MAX_SAMPLES}");
    assert!(message.contains(&expected), "{message}");
    assert!(
        message.contains("--from and --to") && message.contains("--max-samples"),
        "{message}"
    );
    // With a higher limit, the available memory decides.
    let message = dir.rejection(
        &format!("{args} --max-samples 1e9"),
        Some(1_000_000),
        BASELINE,
    );
    let expected =
        format!("{ZEROS} selected samples do not fit into memory: 1082 MB of memory are needed");
    assert!(
        message.contains(&expected) && message.contains("MB are available"),
        "{message}"
    );
    // Only the selected section is read and stored.
    let message = dir.rejection(&format!("{args} --to 0.001"), None, BASELINE);
    assert!(message.contains("samples are too few"), "{message}");
}

#[test]
fn modes_of_another_program_count_with_their_memory() {
    let dir = TestDir::new();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_modes");
    fs::copy(own.join("hip.toml"), dir.path("hip.toml")).expect("copied");
    let valid = File::open(own.join("hip.npz")).expect("there");
    let mut valid = ZipArchive::new(valid).expect("an archive");
    let mut zip = ZipWriter::new(File::create(dir.path("hip.npz")).expect("created"));
    for index in 0..valid.len() {
        let entry = valid.by_index_raw(index).expect("an array");
        if !entry.name().starts_with("mass") {
            zip.raw_copy_file(entry).expect("copied");
        }
    }
    add_zeros(&mut zip, "mass_data");
    zip.finish().expect("written");
    let message = dir.rejection("stability hip.toml", None, BASELINE);
    let above = format!("{ZEROS} numbers, above the limit of 134217728 per file");
    assert!(
        message.contains("`mass_data`") && message.contains(&above),
        "{message}"
    );
}

#[test]
fn a_header_of_four_gigabytes_is_not_read() {
    let dir = TestDir::new();
    fs::write(
        dir.path("x.npy"),
        b"\x93NUMPY\x02\0\xff\xff\xff\xff{'descr'",
    )
    .expect("written");
    let message = dir.rejection("analyse x.npy --rate 1", None, BASELINE);
    assert!(
        message.contains("its header has 4294967295 bytes, above the limit of 65535"),
        "{message}"
    );
}

#[test]
fn a_line_of_a_hundred_megabytes_is_not_read() {
    let dir = TestDir::new();
    let mut file = dir.create("x.csv");
    file.write_all(b"t,u\n0,1\n").expect("written");
    for _ in 0..100 {
        file.write_all(&b"1,".repeat(500_000)).expect("written");
    }
    drop(file);
    let message = dir.rejection("analyse x.csv", None, BASELINE);
    assert!(
        message.contains("line 3 is longer than 1048576 bytes"),
        "{message}"
    );
    fs::write(dir.path("x.csv"), "1,".repeat(500_000)).expect("written");
    let message = dir.rejection("analyse x.csv", None, BASELINE);
    assert!(
        message.contains("500000 columns; the maximum is 16384"),
        "{message}"
    );
}

#[test]
fn samples_above_the_limit_are_rejected() {
    let dir = TestDir::new();
    dir.wav("tone.wav", 8000);
    let message = dir.rejection("analyse tone.wav --max-samples 7999", None, BASELINE);
    assert!(
        message.contains("the selection has 8000 samples, more than the limit of 7999"),
        "{message}"
    );
    for args in ["--max-samples 8000", "--max-samples 4e3 --to 0.083"] {
        let end = dir.run(&format!("analyse tone.wav {args}"), None);
        assert_eq!(end.code, Some(0), "{args}: {}", end.message);
    }
    for number in ["0", "-1", "1.5", "1e16", "nan", "many"] {
        let end = dir.run(&format!("analyse tone.wav --max-samples {number}"), None);
        assert_eq!(end.code, Some(2), "{}", end.message);
        assert!(end.message.contains("from 1 to 1e15"), "{}", end.message);
    }
}

/// Limit of 300 MB: the samples do not fit. Limit of 600 MB: the spectrum does not fit (the number of
/// samples is prime).
#[test]
fn signals_above_the_memory_limit_are_rejected() {
    let dir = TestDir::new();
    let limit = Some(300_000);
    dir.wav("long.wav", 60_000_000);
    let message = dir.rejection("analyse long.wav", limit, BASELINE);
    assert!(
        message.contains("60000000 selected samples do not fit into memory: 480 MB"),
        "{message}"
    );
    dir.wav("prime.wav", 4_194_301);
    let message = dir.rejection("analyse prime.wav", Some(600_000), BASELINE + 8 * 4_194_301);
    assert!(
        message.contains("the analysis of 4194301 samples does not fit into memory"),
        "{message}"
    );
    assert!(message.contains("MB are available"), "{message}");
    dir.wav("short.wav", 8000);
    let end = dir.run("analyse short.wav", Some(600_000));
    assert_eq!(end.code, Some(0), "{}", end.message);
}

#[test]
#[ignore = "86 million samples take minutes: cargo test --release --test it -- --ignored thirty_minutes"]
fn thirty_minutes_take_less_than_a_gigabyte() {
    let dir = TestDir::new();
    dir.wav("long.wav", 30 * 60 * 48_000);
    let end = dir.run("analyse long.wav", None);
    assert_eq!(end.code, Some(0), "{}", end.message);
    assert!(end.peak < 1000 * MB, "{} MB", end.peak / MB);
}
