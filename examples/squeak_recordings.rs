//! Writes the recordings of the test bench for tonal events as WAV files.
//!
//! ```text
//! cargo run --release --example squeak_recordings -- FOLDER [COUNT] [judging]
//! ```
//!
//! COUNT (default: 5) recordings of each set: squeaks at signal-to-noise ratios of -10, 0, 10, 20 and 30 dB, and noise,
//! speech, music, noise of a resonance and bursts without squeaks. Seeds are for tuning, unless `judging` is given. `truth.csv` has one row for
//! each squeak, and one for each recording without; `found.csv` has the tones that the library finds.
//! `tests/it/squeaks/generator` says what the recordings are and how the truth is defined.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use hound::{SampleFormat, WavSpec, WavWriter};
use squeakscope::analysis::events::{EventKind, EventOptions, tonal_events};

use generator::{JUDGING_SEEDS, Kind, Recording, TUNING_SEEDS, recording};

#[allow(dead_code, reason = "the generator has more than the example needs")]
#[path = "../tests/it/squeaks/generator/mod.rs"]
mod generator;

/// Sets of recordings: name, kind and signal-to-noise ratio in dB.
const SETS: [(&str, Kind, f64); 10] = [
    ("-10 dB", Kind::Squeaks, -10.0),
    ("0 dB", Kind::Squeaks, 0.0),
    ("10 dB", Kind::Squeaks, 10.0),
    ("20 dB", Kind::Squeaks, 20.0),
    ("30 dB", Kind::Squeaks, 30.0),
    ("noise", Kind::Noise, 0.0),
    ("speech", Kind::Speech, 0.0),
    ("music", Kind::Music, 0.0),
    ("resonance", Kind::Resonance, 0.0),
    ("bursts", Kind::Bursts, 0.0),
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("give a folder")?);
    let count: u64 = arguments.next().map_or(Ok(5), |count| count.parse())?;
    // Seeds that the tests do not use.
    let first = 500_000
        + match arguments.next().as_deref() {
            None => TUNING_SEEDS.start,
            Some("judging") => JUDGING_SEEDS.start,
            Some(other) => return Err(format!("`{other}` is not `judging`").into()),
        };
    fs::create_dir_all(&folder)?;
    let mut truth = "file,set,with,start_s,end_s,frequency_hz,snr_db,harmonics,modulation_hz,modulation_depth\n".to_owned();
    let mut found = "file,start_s,end_s,frequency_hz\n".to_owned();
    for ((set, kind, snr_db), from) in SETS.into_iter().zip((first..).step_by(count as usize)) {
        for seed in from..from + count {
            let recording = recording(kind, snr_db..=snr_db, seed);
            let file = format!("{}-{seed}.wav", set.replace(' ', "-"));
            write_wav(&folder.join(&file), &recording)?;
            truth += &truth_rows(
                &format!("{file},{set},{}", recording.parts.join(" + ")),
                &recording,
            );
            let options = EventOptions::default();
            let events = tonal_events(&recording.samples, recording.rate_hz, &options)?.events;
            let tones = events.iter().filter(|event| event.kind == EventKind::Tone);
            for event in tones {
                let (start_s, end_s) = (event.start_s, event.end_s);
                writeln!(
                    found,
                    "{file},{start_s:.4},{end_s:.4},{:.3}",
                    event.frequency_hz
                )?;
            }
        }
    }
    fs::write(folder.join("truth.csv"), truth)?;
    fs::write(folder.join("found.csv"), found)?;
    Ok(())
}

/// The squeaks of a recording, one per row; a row with empty cells if there is none.
fn truth_rows(name: &str, recording: &Recording) -> String {
    if recording.squeaks.is_empty() {
        return format!("{name},,,,,,,\n");
    }
    let rows = recording.squeaks.iter().map(|squeak| {
        let modulation = squeak
            .modulation
            .map(|(rate, depth)| format!("{rate:.3},{depth:.3}"));
        format!(
            "{name},{:.4},{:.4},{:.3},{:.2},{},{}\n",
            squeak.start_s,
            squeak.end_s,
            squeak.frequency_hz,
            squeak.snr_db,
            squeak.harmonics,
            modulation.unwrap_or_else(|| ",".to_owned())
        )
    });
    rows.collect()
}

fn write_wav(path: &Path, recording: &Recording) -> Result<(), hound::Error> {
    let spec = WavSpec {
        channels: 1,
        sample_rate: recording.rate_hz as u32,
        bits_per_sample: 16,
        sample_format: SampleFormat::Int,
    };
    let mut writer = WavWriter::create(path, spec)?;
    for sample in &recording.samples {
        writer.write_sample((sample * 32_768.0) as i16)?;
    }
    writer.finalize()
}
