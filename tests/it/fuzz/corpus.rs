//! Small undamaged files in many variants.

use std::fmt::Write as _;
use std::fs;
use std::io::{Cursor, Read, Write};
use std::path::Path;

use hound::{SampleFormat, WavSpec, WavWriter};
use squeakscope::numpy::{Array, encode_npz};
use squeakscope::scene::PRESETS;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::MUTANT;
use crate::damage::{Desk, unpacked};
use crate::mutants::{Mutant, mutants};

/// The scene next to a file of modes.
pub const SCENE_OF_MODES: &str = "modes.toml";

/// Number of samples of each signal.
const SAMPLES: u32 = 200;

fn sample(k: u32) -> f64 {
    (0.3 * f64::from(k)).sin()
}

/// Integers of 8, 16 and 24 bits, and floats; one and two channels; mu-law and ADPCM of the IMA.
pub fn wav(_: &Desk) -> Vec<Vec<u8>> {
    let forms = [(1, 8), (2, 16), (1, 24), (2, 32)];
    let mut files = forms
        .map(|(channels, bits)| one_wav(channels, bits))
        .to_vec();
    for (tag, frame, bits, extra) in [(7, 1, 8, &[0, 0][..]), (17, 36, 4, &[2, 0, 65, 0])] {
        let mut bytes = b"RIFF\0\0\0\0WAVEfmt ".to_vec();
        bytes.extend((16 + extra.len() as u32).to_le_bytes());
        bytes.extend([
            tag, 0, 1, 0, 0x40, 0x1F, 0, 0, 0, 0, 0, 0, frame, 0, bits, 0,
        ]);
        bytes.extend(extra);
        bytes.extend(b"data\x68\x01\0\0");
        // Blocks of ADPCM begin with a sample and an index below 89.
        bytes.extend((0..360).map(|k: u32| if k % 36 < 4 { 0 } else { (37 * k) as u8 }));
        files.push(bytes);
    }
    files
}

/// Universal files with a time history as text and in binary.
pub fn universal(_: &Desk) -> Vec<Vec<u8>> {
    let head = |kind: &str| {
        let form = format!(
            "{:10}{SAMPLES:10}{:10}{:13.5E}{:13.5E}{:13.5E}",
            2, 1, 0.0, 1e-3, 0.0
        );
        let axes =
            "        17    0    0    0                 Time                    s\n".repeat(4);
        format!(
            "    -1\n{kind}\nrig\nNONE\nNONE\nNONE\nNONE\n    1         0    0         0       NONE         1   3\n{form}\n{axes}"
        )
    };
    let mut text = head("    58");
    for k in 0..SAMPLES {
        writeln!(text, "{:13.5E}", sample(k)).expect("a string");
    }
    text += "    -1\n";
    let mut binary =
        head(&format!("    58b{:6}{:6}{:12}{:12}", 1, 2, 11, 4 * SAMPLES)).into_bytes();
    binary.extend((0..SAMPLES).flat_map(|k| (sample(k) as f32).to_le_bytes()));
    binary.extend(b"\n    -1\n");
    vec![text.into_bytes(), binary]
}

fn one_wav(channels: u16, bits_per_sample: u16) -> Vec<u8> {
    let is_float = bits_per_sample == 32;
    let spec = WavSpec {
        channels,
        sample_rate: 48_000,
        bits_per_sample,
        sample_format: match is_float {
            true => SampleFormat::Float,
            false => SampleFormat::Int,
        },
    };
    let mut out = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut out, spec).expect("created");
    for k in 0..SAMPLES * u32::from(channels) {
        match is_float {
            true => writer.write_sample(sample(k) as f32),
            false => writer.write_sample((100.0 * sample(k)) as i32),
        }
        .expect("written");
    }
    writer.finalize().expect("written");
    out.into_inner()
}

/// Commas with a header and a comment, semicolons with decimal commas, and blanks without a header.
pub fn csv(_: &Desk) -> Vec<Vec<u8>> {
    let mut texts = [
        "# a tone\nt (s),u (m/s),v\n".to_owned(),
        "zeit;u\n".to_owned(),
        String::new(),
    ];
    for k in 0..SAMPLES {
        let (t, u) = (f64::from(k) / 1000.0, sample(k));
        let [commas, semicolons, blanks] = &mut texts;
        let decimal = format!("{t:.3};{u:.6}").replace('.', ",");
        writeln!(commas, "{t:.3},{u:.6},{u:e}").expect("a string");
        writeln!(semicolons, "{decimal}").expect("a string");
        writeln!(blanks, "{t:.3} {u:.6} {k}").expect("a string");
    }
    texts.map(String::into_bytes).to_vec()
}

fn tone() -> Vec<f64> {
    (0..SAMPLES).map(sample).collect()
}

/// The archives of [`npz`], unpacked.
pub fn npy(desk: &Desk) -> Vec<Vec<u8>> {
    let archives = npz(desk);
    let entries = archives.iter().flat_map(|archive| entries(archive));
    let signals = entries.filter(|(name, _)| name.starts_with('u'));
    signals.map(|(_, bytes)| bytes).collect()
}

/// With a rate and with times; arrays with one and two axes; the second archive is compressed.
pub fn npz(_: &Desk) -> Vec<Vec<u8>> {
    let times = (0..SAMPLES).map(|k| f64::from(k) / 1000.0).collect();
    let with_rate = [("rate", Array::number(48e3)), ("u", Array::vector(tone()))];
    let with_times = [
        ("t", Array::vector(times)),
        (
            "u",
            Array::matrix(SAMPLES as usize, [tone(), tone()].concat()),
        ),
    ];
    let [with_rate, with_times] = [with_rate, with_times].map(|arrays| {
        let mut out = Cursor::new(Vec::new());
        encode_npz(&mut out, &arrays).expect("written");
        out.into_inner()
    });
    let packed = archive(&entries(&with_times), CompressionMethod::Deflated);
    vec![with_rate, packed]
}

/// Recordings of this program, compressed and uncompressed, and of another program.
pub fn recordings(desk: &Desk) -> Vec<Vec<u8>> {
    let own = desk.recording();
    let unpacked = unpacked(&own);
    vec![own, unpacked, desk.tone()]
}

/// Files of other programs.
macro_rules! stored {
    ($($name:ident: $($file:literal),+;)+) => {
        $(pub fn $name(_: &Desk) -> Vec<Vec<u8>> {
            vec![$(include_bytes!(concat!("../../data/", $file)).to_vec()),+]
        })+
    };
}

stored! {
    flac: "tone.flac";
    mp3: "tone.mp3";
    ogg: "tone.ogg", "tone.opus";
    mp4: "tone.m4a", "tone.aac";
    aiff: "tone.aiff";
    matlab: "plain.mat", "compressed.mat";
}

/// Text of oscilloscopes and loggers: Keysight, Rigol, Tektronix (two generations), LeCroy, LabVIEW, PicoScope.
pub fn oscilloscopes(_: &Desk) -> Vec<Vec<u8>> {
    let heads = [
        "x-axis,1,2\nsecond,Volt,Volt\n",
        "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-6e-04,1e-03\n",
        "CH1V,CH2V,CH3V,t0 = -6e-04, tInc = 1e-03,\n",
        "Rig 3\nsep;12\nTime,a,b\ns,m/s,Pa\n",
        "Model,MDO3024\n\nSample Interval,1e-03,\nVertical Units,V,\nLabel,,\nTIME,CH1,CH2\n",
        "LECROYWS424,52341,Waveform\nSegments,1,SegmentSize,200\nTime,Ampl,More\n",
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nY_Unit_Label\tVolts\n\
         Delta_X\t1E-3\n***End_of_Header***\t\nX_Value\tOne\tTwo\n",
        "Time,Channel A,Channel B\n(ms),(V),(V)\n\n",
    ];
    let one = |head: &str| {
        let mut text = head.to_owned();
        let separator = if head.contains('\t') { '\t' } else { ',' };
        for k in 0..SAMPLES {
            let time = match head.starts_with('X') {
                true => k.to_string(),
                false => format!("{:.3}", 1e-3 * f64::from(k)),
            };
            let u = sample(k);
            writeln!(text, "{time}{separator}{u:.6}{separator}{u:.3}").expect("a string");
        }
        text.into_bytes()
    };
    let beside = (0..SAMPLES).map(|k| {
        let setting = match k {
            0 => "Record Length,200,",
            1 => "Sample Interval,1e-03,",
            2 => "Source,CH1,",
            _ => ",,",
        };
        format!("{setting},{:.3},{:.6},\n", 1e-3 * f64::from(k), sample(k))
    });
    let beside = beside.collect::<String>().into_bytes();
    heads.map(one).into_iter().chain([beside]).collect()
}

/// A table as an Arrow file, and as the stream within it.
pub fn table(desk: &Desk) -> Vec<Vec<u8>> {
    let file = desk.table();
    let start = file[8..].iter().position(|byte| *byte != 0);
    let stream = file[8 + start.expect("a stream")..].to_vec();
    vec![file, stream]
}

pub fn parquet(desk: &Desk) -> Vec<Vec<u8>> {
    vec![desk.parquet()]
}

pub fn scenes(_: &Desk) -> Vec<Vec<u8>> {
    let texts = PRESETS.iter().map(|preset| preset.text.as_bytes());
    texts.map(<[u8]>::to_vec).collect()
}

/// The modes of the example, and a scene that reads them from the mutant.
pub fn modes(desk: &Desk) -> Vec<Vec<u8>> {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_modes");
    let scene = fs::read_to_string(example.join("hip.toml")).expect("exists");
    let scene = scene.replace("hip.npz", &format!("{MUTANT}.npz"));
    desk.write(SCENE_OF_MODES, scene.as_bytes());
    vec![fs::read(example.join("hip.npz")).expect("exists")]
}

pub fn commands(_: &Desk) -> Vec<Vec<u8>> {
    let texts = [
        r#"{"do": "set", "key": "tilt_deg", "value": 3.5}"#,
        r#"{"do": "pause"}"#,
        r#"{"do": "speed", "ms_per_s": 20}"#,
        r#"{"do": "kick", "mm_per_s": 1e-3}"#,
        r#"{"do": "kick", "mm_per_s": null}"#,
        r#"{"do": "lyapunov", "enabled": false}"#,
        r#"{"do": "scene", "name": "doubled-torus-3deg"}"#,
        r#"{"do": "stop-recording"}"#,
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

/// The files of an archive by name.
fn entries(archive: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut zip = ZipArchive::new(Cursor::new(archive)).expect("an archive");
    let mut entries = Vec::new();
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).expect("a file");
        let name = entry.name().to_string();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).expect("read");
        entries.push((name, bytes));
    }
    entries
}

fn archive(entries: &[(String, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        let options = SimpleFileOptions::default().compression_method(method);
        zip.start_file(name.clone(), options).expect("created");
        zip.write_all(bytes).expect("written");
    }
    zip.finish().expect("written").into_inner()
}

/// Ogg files whose pages have correct checksums, so that damage reaches the decoder.
pub fn mended(original: &[u8], seed: u64) -> impl Iterator<Item = Mutant> {
    mutants(original, seed).map(|mut mutant| {
        mend_pages(&mut mutant.bytes);
        mutant
    })
}

/// Corrects the checksum of each complete page of an Ogg file (RFC 3533).
fn mend_pages(bytes: &mut [u8]) {
    let mut at = 0;
    while let Some(next) = bytes[at..].windows(4).position(|word| word == b"OggS") {
        let start = at + next;
        at = start + 4;
        let Some(&segments) = bytes.get(start + 26) else {
            return;
        };
        let body = start + 27 + usize::from(segments);
        let Some(lengths) = bytes.get(start + 27..body) else {
            return;
        };
        let length: usize = lengths.iter().map(|length| usize::from(*length)).sum();
        if let Some(page) = bytes.get_mut(start..body + length) {
            page[22..26].fill(0);
            let sum = page.iter().fold(0_u32, |sum, byte| {
                let shift = |sum: u32, _| (sum << 1) ^ (0x04c1_1db7 * (sum >> 31));
                (0..8).fold(sum ^ (u32::from(*byte) << 24), shift)
            });
            page[22..26].copy_from_slice(&sum.to_le_bytes());
        }
    }
}

/// Archives with one damaged file, each in turn, and correct checksums.
pub fn repacked(original: &[u8], seed: u64) -> impl Iterator<Item = Mutant> {
    let entries = entries(original);
    let count = entries.len();
    (0..).map(move |turn: u64| {
        let index = turn as usize % count;
        let mut entries = entries.clone();
        let (name, bytes) = &mut entries[index];
        let seed = seed.wrapping_add(turn);
        let mutant = mutants(bytes, seed)
            .next()
            .expect("the iterator is infinite");
        let damage = format!("{name}: {}", mutant.damage);
        *bytes = mutant.bytes;
        Mutant {
            bytes: archive(&entries, CompressionMethod::Stored),
            damage,
        }
    })
}
