//! Damaged recordings and tables are read up to the damage or rejected with a one-line message. Nothing
//! panics, aborts, or allocates the memory that a header claims.
//!
//! A longer search:
//!
//! ```sh
//! SQUEAKSCOPE_MUTANTS=20000 cargo test --release --test it damage::a_damaged
//! ```

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;

use re_log_encoding::{DecoderApp, Encoder, EncodingOptions};
use squeakscope::record::{ReadError, Series, paths, read_series};
use squeakscope::study::sweep::{SweepTable, TableError, read_table};

use crate::mutants::{count, mutants};

/// Number of damaged copies of each file that are read in this process.
const READ: usize = 400;
/// Number of damaged copies of each file that are passed to the program.
const GIVEN: usize = 12;

/// A folder with a recording and a table, and the program.
pub struct Desk(tempfile::TempDir);

impl Desk {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program with no more memory than a small file needs.
    fn run(&self, words: &[&str]) -> Output {
        let mut command = std::process::Command::new("sh");
        let script = if cfg!(target_os = "linux") {
            "exec prlimit --as=4000000000 \"$@\""
        } else {
            "exec \"$@\""
        };
        command
            .args(["-c", script, "sh", env!("CARGO_BIN_EXE_squeakscope")])
            .args(words)
            .current_dir(self.0.path());
        command.output().expect("started")
    }

    /// The file that a command writes, once for all tests.
    fn made(&self, name: &str, command: &str, once: &OnceLock<Vec<u8>>) -> Vec<u8> {
        let bytes = once.get_or_init(|| {
            let made = self.run(&command.split(' ').collect::<Vec<_>>());
            assert!(made.status.success(), "{made:?}");
            fs::read(self.path(name)).expect("written")
        });
        self.write(name, bytes);
        bytes.clone()
    }

    /// A recording of 4 ms.
    pub fn recording(&self) -> Vec<u8> {
        static RECORDING: OnceLock<Vec<u8>> = OnceLock::new();
        let command = "run doubled-torus-3deg --duration 4 --save run.rrd";
        self.made("run.rrd", command, &RECORDING)
    }

    /// A recording of another program: a tone of 4000 samples, 100 per message.
    pub fn tone(&self) -> Vec<u8> {
        let path = self.path("tone.rrd");
        let builder = rerun::RecordingStreamBuilder::new("another_program");
        let recording = builder.save(&path).expect("created");
        recording.set_log_time_enabled(false);
        for k in 0..4000_i32 {
            let time = rerun::TimeCell::from_duration_nanos(1_000_000 * i64::from(k));
            recording.set_time("clock", time);
            let value = (0.4 * f64::from(k)).sin();
            let row = re_sdk_types::archetypes::Scalars::single(value);
            recording.log("volts", &row).expect("logged");
            if k % 100 == 99 {
                recording.flush_blocking().expect("written");
            }
        }
        drop(recording);
        fs::read(path).expect("written")
    }

    /// The table of a sweep over four tilts.
    pub fn table(&self) -> Vec<u8> {
        static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
        let command = "sweep doubled-torus-3deg --tilt 1:4:1 --start fresh --min-transient 5 --max-transient 20 --measure 10 --out s.arrow";
        self.made("s.arrow", command, &TABLE)
    }

    /// The same table as Parquet.
    pub fn parquet(&self) -> Vec<u8> {
        static PARQUET: OnceLock<Vec<u8>> = OnceLock::new();
        self.table();
        self.made("s.parquet", "merge s.arrow --out s.parquet", &PARQUET)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("written");
        path
    }
}

/// Checks the output of a program that reads a damaged file: a result, a warning, or one error.
#[track_caller]
fn ends_well(output: &Output, damage: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    let lines = stderr.lines();
    let errors = lines.filter(|line| line.starts_with("error: ")).count();
    match output.status.code() {
        Some(0) => assert_eq!(errors, 0, "{damage}: {stderr}"),
        Some(2) => assert_eq!(errors, 1, "{damage}: {stderr}"),
        _ => panic!("{damage}: {:?}: {stderr}", output.status),
    }
    for word in ["panicked", "memory allocation", "capacity overflow"] {
        assert!(!stderr.contains(word), "{damage}: {stderr}");
    }
}

fn displacement(path: &Path) -> Result<Series, ReadError> {
    read_series(path, Some(paths::DISPLACEMENT))
}

/// The recording without compression: damage reaches the inner layers.
pub fn unpacked(recording: &[u8]) -> Vec<u8> {
    let mut unpacked = Vec::new();
    let version = rerun::build_info().version;
    let options = EncodingOptions::PROTOBUF_UNCOMPRESSED;
    let mut encoder = Encoder::new_eager(version, options, &mut unpacked).expect("created");
    for message in DecoderApp::decode_lazy(recording) {
        encoder.append(&message.expect("read")).expect("written");
    }
    encoder.finish().expect("written");
    drop(encoder);
    unpacked
}

#[test]
fn a_damaged_recording_is_read_up_to_the_damage_or_refused() {
    let desk = Desk::new();
    let recording = desk.recording();
    let whole = displacement(&desk.path("run.rrd")).expect("read");
    assert_eq!(whole.damage, None);
    let unpacked = unpacked(&recording);
    let path = desk.write("unpacked.rrd", &unpacked);
    assert_eq!(displacement(&path).expect("read"), whole);
    for (seed, original) in [(1, &recording), (2, &unpacked)] {
        let mut read = 0;
        for mutant in mutants(original, seed).take(count(READ)) {
            let path = desk.write("mutant.rrd", &mutant.bytes);
            match displacement(&path) {
                Ok(_) => read += 1,
                Err(error) => {
                    let message = error.to_string();
                    let known = ["is not a recording", "has no column", "is damaged at"];
                    let is_known = known.iter().any(|known| message.contains(known));
                    assert!(is_known, "{}: {error}", mutant.damage);
                }
            }
        }
        let all = count(READ);
        assert!((all / 10..all).contains(&read), "{read}");
    }
}

#[test]
fn the_program_reports_the_damage_of_a_recording() {
    let desk = Desk::new();
    let recording = desk.recording();
    let unpacked = unpacked(&recording);
    for (seed, original) in [(3, &recording), (4, &unpacked)] {
        for mutant in mutants(original, seed).take(GIVEN) {
            desk.write("mutant.rrd", &mutant.bytes);
            let words = ["analyse", "mutant.rrd", "--column", paths::DISPLACEMENT];
            ends_well(&desk.run(&words), &mutant.damage);
        }
    }
}

/// The length of the first message: a single bit may claim up to 18 PB.
#[test]
fn a_length_beyond_the_end_of_a_recording_is_rejected() {
    let desk = Desk::new();
    let recording = desk.recording();
    for byte in 20..28 {
        for bit in 0..8 {
            let mut bytes = recording.clone();
            bytes[byte] ^= 1 << bit;
            let path = desk.write("mutant.rrd", &bytes);
            let error = displacement(&path).expect_err("refused").to_string();
            // A shorter length can lead to another message.
            let length = u64::from_le_bytes(bytes[20..28].try_into().expect("eight bytes"));
            let is_beyond = length > bytes.len() as u64;
            assert!(!is_beyond || error.contains("damaged at byte"), "{error}");
        }
    }
    let mut bytes = recording;
    bytes[26] ^= 1;
    desk.write("mutant.rrd", &bytes);
    let output = desk.run(&["analyse", "mutant.rrd"]);
    assert_eq!(output.status.code(), Some(2));
    ends_well(&output, "bit 0 of byte 26 flipped");
}

#[test]
fn data_before_a_damaged_tail_are_read() {
    let desk = Desk::new();
    let recording = desk.tone();
    let whole = read_series(&desk.path("tone.rrd"), None).expect("read");
    assert_eq!((whole.values.len(), &whole.damage), (4000, &None));
    let half = recording.len() / 2;
    let mut zeroed = recording.clone();
    zeroed[half..].fill(0);
    for bytes in [&recording[..half], &zeroed] {
        desk.write("torn.rrd", bytes);
        let read = read_series(&desk.path("torn.rrd"), None).expect("read");
        let count = read.values.len();
        assert!((1500..2500).contains(&count), "{count}");
        assert_eq!(read.values, whole.values[..count]);
        let damage = read.damage.expect("reported");
        assert!(damage.at <= half as u64, "{damage}");

        let output = desk.run(&["analyse", "torn.rrd"]);
        ends_well(&output, "torn");
        let stderr = String::from_utf8_lossy(&output.stderr);
        let seconds = 1e-3 * (count - 1) as f64;
        let words = [
            "warning: ".to_owned(),
            damage.to_string(),
            format!("{count} samples of `volts` before the damage are used, {seconds:.6} s"),
        ];
        for word in words {
            assert!(stderr.contains(&word), "`{word}` is missing in {stderr}");
        }
        assert_eq!(output.status.code(), Some(0), "{stderr}");
    }
    // Only the end is damaged: no number is lost, but the damage is reported.
    let tail = recording.len() - 16;
    zeroed.copy_from_slice(&recording);
    zeroed[tail..].fill(0);
    for bytes in [&recording[..tail], &zeroed] {
        let read = read_series(&desk.write("torn.rrd", bytes), None).expect("read");
        assert_eq!(read.values, whole.values);
        assert!(read.damage.is_some());
    }
}

/// Whether a table contains only points of the undamaged one.
fn is_part(table: &SweepTable, whole: &SweepTable) -> bool {
    let mut points = table.points.iter();
    points.all(|point| whole.points.contains(point))
}

#[test]
fn a_damaged_table_is_read_up_to_the_damage_or_refused() {
    let desk = Desk::new();
    let original = desk.table();
    let whole = read_table(&desk.path("s.arrow")).expect("read");
    assert_eq!(whole.points.len(), 4);
    let (mut read, mut torn) = (0, 0);
    for mutant in mutants(&original, 5).take(count(READ)) {
        match read_table(&desk.write("mutant.arrow", &mutant.bytes)) {
            Ok(table) => {
                read += 1;
                torn += usize::from(table.truncated && is_part(&table, &whole));
            }
            Err(error) => {
                let is_known = matches!(error, TableError::Invalid(..));
                assert!(is_known, "{}: {error:?}", mutant.damage);
            }
        }
    }
    assert!(
        0 < torn && torn < read && read < count(READ),
        "{read}, {torn}"
    );
    for mutant in mutants(&original, 6).take(GIVEN) {
        desk.write("mutant.arrow", &mutant.bytes);
        let _ = fs::remove_file(desk.path("merged.arrow"));
        let merge = desk.run(&["merge", "mutant.arrow", "--out", "merged.arrow"]);
        ends_well(&merge, &mutant.damage);
    }
}

/// A single bit of a length claims 34 GB.
#[test]
fn a_length_beyond_the_end_of_a_table_ends_it() {
    let desk = Desk::new();
    let original = desk.table();
    let whole = read_table(&desk.path("s.arrow")).expect("read");
    // The first message is the schema: its length and that of its body are in the first bytes.
    for byte in 4..64 {
        for bit in 0..8 {
            let mut bytes = original.clone();
            bytes[byte] ^= 1 << bit;
            if let Ok(table) = read_table(&desk.write("mutant.arrow", &bytes)) {
                assert!(is_part(&table, &whole), "bit {bit} of byte {byte}");
            }
        }
    }
    // The body of a batch: all bytes up to the next message.
    let lengths: Vec<usize> = (0..original.len() - 8)
        .step_by(8)
        .filter(|&at| {
            let field = original[at..at + 8].try_into().expect("eight bytes");
            (10_000..original.len() as u64).contains(&u64::from_le_bytes(field))
        })
        .collect();
    assert!(!lengths.is_empty());
    for at in lengths {
        let mut bytes = original.clone();
        bytes[at + 4] ^= 8;
        desk.write("mutant.arrow", &bytes);
        let _ = fs::remove_file(desk.path("merged.arrow"));
        let merge = desk.run(&["merge", "mutant.arrow", "--out", "merged.arrow"]);
        ends_well(&merge, &format!("34 GB at byte {at}"));
    }
}

#[cfg(unix)]
#[test]
fn other_file_types_are_rejected_before_reading() {
    let desk = Desk::new();
    let made = std::process::Command::new("mkfifo")
        .arg(desk.path("pipe"))
        .status();
    assert!(made.expect("mkfifo").success());
    for path in ["/dev/zero", "/dev/null", "pipe", "."] {
        for words in [
            vec!["merge", path, "--out", "merged.arrow"],
            vec!["view", path],
        ] {
            let output = desk.run(&words);
            ends_well(&output, &format!("{words:?}"));
            assert_eq!(output.status.code(), Some(2), "{words:?}: {output:?}");
        }
        let error = displacement(&desk.path(path)).expect_err("refused");
        let message = error.to_string();
        assert!(message.starts_with("cannot open"), "{error}");
    }
}
