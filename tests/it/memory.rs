//! Memory: a file takes as much as the samples selected, whatever it claims, and what does not fit is refused
//! in one message. A peak is what the system says (`VmHWM`), which no load of the machine changes.

use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use squeakscope::import::MAX_SAMPLES;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

const MB: u64 = 1_000_000;

/// What the program takes for itself and for the shortest signals.
const OWN: u64 = 80 * MB;

/// Numbers of an array that its file has in a quarter of a megabyte.
const ZEROS: usize = 1 << 28;

/// A folder with files.
struct Desk(tempfile::TempDir);

/// How a program ended.
struct End {
    code: Option<i32>,
    message: String,
    /// The most memory that it held, bytes.
    peak: u64,
}

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn create(&self, name: &str) -> BufWriter<File> {
        BufWriter::new(File::create(self.path(name)).expect("created"))
    }

    /// Runs the program, with at most so many kB of address space if a limit is given.
    fn run(&self, words: &str, limit: Option<u64>) -> End {
        let limit = limit.map_or_else(|| "unlimited".to_owned(), |kilobytes| kilobytes.to_string());
        let mut child = Command::new("sh")
            .args([
                "-c",
                "ulimit -v \"$1\" && shift && exec \"$@\"",
                "sh",
                &limit,
            ])
            .arg(env!("CARGO_BIN_EXE_squeakscope"))
            .args(words.split(' '))
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
            peak = peak.max(held(&status).unwrap_or(0));
            if let Some(ended) = child.try_wait().expect("a child") {
                break ended;
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let mut message = String::new();
        let mut stderr = child.stderr.take().expect("piped");
        stderr.read_to_string(&mut message).expect("text");
        End {
            code: ended.code(),
            message,
            peak,
        }
    }

    /// The message with which bad input is refused, by a program that held no more than this.
    fn refused(&self, words: &str, limit: Option<u64>, most: u64) -> String {
        let end = self.run(words, limit);
        assert_eq!(end.code, Some(2), "{words}: {}", end.message);
        assert!(end.message.starts_with("error: "), "{}", end.message);
        assert_eq!(end.message.trim_end().lines().count(), 1, "{}", end.message);
        assert!(
            end.peak > 0 && end.peak < most,
            "{words}: {} bytes",
            end.peak
        );
        end.message
    }

    /// A mono WAV of 8 bits a sample: a tone of 4.1 kHz at 48 kHz.
    fn wav(&self, name: &str, samples: usize) {
        let mut file = self.create(name);
        let mut header = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0".to_vec();
        for number in [48_000_u32, 48_000, 0x0008_0001] {
            header.extend(number.to_le_bytes());
        }
        header.extend(b"data");
        header.extend((samples as u32).to_le_bytes());
        file.write_all(&header).expect("written");
        // A second holds a whole number of periods.
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

/// Peak memory by a status file, bytes.
fn held(status: &str) -> Option<u64> {
    let status = fs::read_to_string(status).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

/// Adds an array of [`ZEROS`] zeros of 8 bits to an archive.
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
fn an_archive_of_zeros_is_refused_by_its_header() {
    let desk = Desk::new();
    let mut zip = ZipWriter::new(File::create(desk.path("bomb.npz")).expect("created"));
    add_zeros(&mut zip, "x");
    zip.finish().expect("written");
    assert!(fs::metadata(desk.path("bomb.npz")).expect("there").len() < 2 * MB);
    let words = "analyse bomb.npz --rate 48000";
    let message = desk.refused(words, None, OWN);
    let said = format!("{ZEROS} samples are selected, above the limit of {MAX_SAMPLES}");
    assert!(message.contains(&said), "{message}");
    assert!(
        message.contains("--from and --to") && message.contains("--max-samples"),
        "{message}"
    );
    // With the limit raised, the memory decides.
    let message = desk.refused(&format!("{words} --max-samples 1e9"), Some(1_000_000), OWN);
    let said =
        format!("{ZEROS} samples selected do not fit into memory: 2147 MB of memory are needed");
    assert!(
        message.contains(&said) && message.contains("MB are available"),
        "{message}"
    );
    // A stretch is read, and nothing else held.
    let message = desk.refused(&format!("{words} --to 1"), None, OWN);
    assert!(message.contains("all samples are the same"), "{message}");
}

#[test]
fn modes_of_another_program_are_counted_as_they_are_held() {
    let desk = Desk::new();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_modes");
    fs::copy(own.join("hip.toml"), desk.path("hip.toml")).expect("copied");
    let sound = File::open(own.join("hip.npz")).expect("there");
    let mut sound = ZipArchive::new(sound).expect("an archive");
    let mut zip = ZipWriter::new(File::create(desk.path("hip.npz")).expect("created"));
    for index in 0..sound.len() {
        let entry = sound.by_index_raw(index).expect("an array");
        if !entry.name().expect("text").starts_with("mass") {
            zip.raw_copy_file(entry).expect("copied");
        }
    }
    add_zeros(&mut zip, "mass_data");
    zip.finish().expect("written");
    let message = desk.refused("stability hip.toml", None, OWN);
    assert!(
        message.contains("`mass_data`")
            && message.contains("268435456 numbers, and 134217728 are read"),
        "{message}"
    );
}

#[test]
fn a_header_of_four_gigabytes_is_not_read() {
    let desk = Desk::new();
    fs::write(
        desk.path("x.npy"),
        b"\x93NUMPY\x02\0\xff\xff\xff\xff{'descr'",
    )
    .expect("written");
    let message = desk.refused("analyse x.npy --rate 1", None, OWN);
    assert!(
        message.contains("its header has 4294967295 bytes, above 65535"),
        "{message}"
    );
}

#[test]
fn a_line_of_a_hundred_megabytes_is_not_read() {
    let desk = Desk::new();
    let mut file = desk.create("x.csv");
    file.write_all(b"t,u\n0,1\n").expect("written");
    for _ in 0..100 {
        file.write_all(&b"1,".repeat(500_000)).expect("written");
    }
    drop(file);
    let message = desk.refused("analyse x.csv", None, OWN);
    assert!(
        message.contains("line 3 is longer than 1048576 bytes"),
        "{message}"
    );
    fs::write(desk.path("x.csv"), "1,".repeat(500_000)).expect("written");
    let message = desk.refused("analyse x.csv", None, OWN);
    assert!(
        message.contains("500000 columns, and 16384 are read"),
        "{message}"
    );
}

#[test]
fn more_samples_than_asked_for_are_refused() {
    let desk = Desk::new();
    desk.wav("tone.wav", 48_000);
    let message = desk.refused("analyse tone.wav --max-samples 47999", None, OWN);
    assert!(
        message.contains("48000 samples are selected, above the limit of 47999"),
        "{message}"
    );
    for words in ["--max-samples 48000", "--max-samples 24e3 --to 0.5"] {
        let end = desk.run(&format!("analyse tone.wav {words}"), None);
        assert_eq!(end.code, Some(0), "{words}: {}", end.message);
    }
    for number in ["0", "-1", "1.5", "1e16", "nan", "many"] {
        let end = desk.run(&format!("analyse tone.wav --max-samples {number}"), None);
        assert_eq!(end.code, Some(2), "{}", end.message);
        assert!(end.message.contains("from 1 to 1e15"), "{}", end.message);
    }
}

/// Under a limit of 300 MB: samples that do not fit. Under one of 600 MB: samples whose spectrum does not (their
/// number is prime).
#[test]
fn what_a_limit_of_memory_leaves_no_room_for_is_refused() {
    let desk = Desk::new();
    let limit = Some(300_000);
    desk.wav("long.wav", 60_000_000);
    let message = desk.refused("analyse long.wav", limit, OWN);
    assert!(
        message.contains("60000000 samples selected do not fit into memory: 480 MB"),
        "{message}"
    );
    desk.wav("prime.wav", 4_194_301);
    let message = desk.refused("analyse prime.wav", Some(600_000), OWN + 8 * 4_194_301);
    assert!(
        message.contains("the analysis of 4194301 samples does not fit into memory"),
        "{message}"
    );
    assert!(message.contains("MB are available"), "{message}");
    desk.wav("short.wav", 48_000);
    let end = desk.run("analyse short.wav", Some(600_000));
    assert_eq!(end.code, Some(0), "{}", end.message);
}

/// Peak of an analysis of so many samples.
fn peak(samples: usize) -> u64 {
    let desk = Desk::new();
    desk.wav("long.wav", samples);
    let end = desk.run("analyse long.wav", None);
    assert_eq!(end.code, Some(0), "{}", end.message);
    end.peak
}

#[test]
fn a_long_signal_takes_its_samples_and_no_copy_of_them() {
    let samples = 16_000_000;
    let peak = peak(samples);
    assert!(peak < 8 * samples as u64 + 300 * MB, "{} MB", peak / MB);
}

#[test]
#[ignore = "86 million samples take half a minute: cargo test --release --test it -- --ignored thirty_minutes"]
fn thirty_minutes_take_less_than_a_gigabyte() {
    let peak = peak(30 * 60 * 48_000);
    assert!(peak < 1000 * MB, "{} MB", peak / MB);
}
