//! `squeakscope analyse` keeps its promises: known signals in every format, and one message for
//! each file that is none.

use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use npyz::WriterBuilder;
use serde_json::Value;
use squeakscope::export::write_npz;
use squeakscope::numpy::Array;

/// A folder with files of signals.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, words: &str) -> assert_cmd::assert::Assert {
        let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
        let words = ["analyse"].into_iter().chain(words.split(' '));
        command.current_dir(self.0.path()).args(words).assert()
    }

    /// The JSON of an analysis that goes well.
    fn analyse(&self, words: &str) -> Value {
        self.run(&format!("{words} --json out.json")).success();
        let text = fs::read(self.path("out.json")).expect("written");
        serde_json::from_slice(&text).expect("JSON")
    }

    /// The message with which a file is refused.
    fn refused(&self, words: &str) -> String {
        let assert = self.run(words).code(2).stdout("");
        let message = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
        assert!(message.starts_with("error: "), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        message
    }

    fn wav(&self, name: &str, rate: u32, channels: u16, samples: &[i16]) {
        let spec = hound::WavSpec {
            channels,
            sample_rate: rate,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(self.path(name), spec).expect("created");
        for &sample in samples {
            writer.write_sample(sample).expect("written");
        }
        writer.finalize().expect("written");
    }

    fn npy(&self, name: &str, samples: &[f64]) {
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype();
        let shaped = options.shape(&[samples.len() as u64]);
        let mut writer = shaped.writer(&mut bytes).begin_nd().expect("begun");
        writer.extend(samples).expect("written");
        writer.finish().expect("written");
        fs::write(self.path(name), bytes).expect("written");
    }
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// Sum of sines, each (frequency in Hz, amplitude), as 16-bit samples.
fn tones(rate: f64, count: usize, tones: &[(f64, f64)]) -> Vec<i16> {
    let at = |k: usize| {
        let t = k as f64 / rate;
        let sum: f64 = tones.iter().map(|(f, a)| a * (TAU * f * t).sin()).sum();
        (sum * 32768.0).round() as i16
    };
    (0..count).map(at).collect()
}

/// `x` of the Lorenz system (10, 28, 8/3), every 0.01, on the attractor.
fn lorenz(count: usize) -> Vec<f64> {
    let rate = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let along = |s: [f64; 3], k: [f64; 3], h: f64| [0, 1, 2].map(|i| s[i] + h * k[i]);
    let step = |s: [f64; 3]| {
        let h = 0.01;
        let k1 = rate(s);
        let k2 = rate(along(s, k1, h / 2.0));
        let k3 = rate(along(s, k2, h / 2.0));
        let k4 = rate(along(s, k3, h));
        [0, 1, 2].map(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    };
    let states = std::iter::successors(Some([1.0, 1.0, 20.0]), |s| Some(step(*s)));
    states.skip(2000).take(count).map(|s| s[0]).collect()
}

#[test]
fn a_tone_is_periodic() {
    let desk = Desk::new();
    desk.wav(
        "tone.wav",
        44_100,
        1,
        &tones(44_100.0, 44_100, &[(440.0, 0.5)]),
    );
    let json = desk.analyse("tone.wav");
    assert_eq!(json["verdict"]["regime"], "periodic");
    assert!(number(&json["verdict"]["confidence"]) > 0.5);
    assert_eq!(json["signal"]["unit"], "FS");
    assert_eq!(json["signal"]["rate_hz"], 44_100.0);
    let line = &json["spectrum"]["lines"][0];
    assert!(
        (number(&line["frequency_hz"]) - 440.0).abs() < 1e-3,
        "{line}"
    );
    assert!((number(&line["amplitude"]) - 0.5).abs() < 1e-3, "{line}");
    assert_eq!(line["label"], "f1");
    let period = number(&json["recurrence"]["period_s"]);
    assert!((period * 440.0 - 1.0).abs() < 1e-3, "{period}");
    let returns = number(&json["section"]["mean_return_s"]);
    assert!((returns * 440.0 - 1.0).abs() < 1e-5, "{returns}");
    assert_eq!(json["section"]["points"], 1);
    assert!(number(&json["recurrence"]["whole"]["determinism"]) > 0.99);
    assert!(number(&json["zero_one"]["k"]).abs() < 0.1);
    assert_eq!(json["rosenstein"]["region"]["exponent_per_s"], Value::Null);
}

#[test]
fn two_tones_are_a_torus() {
    let desk = Desk::new();
    let samples = tones(44_100.0, 44_100, &[(440.0, 0.4), (353.515, 0.3)]);
    desk.wav("torus.wav", 44_100, 1, &samples);
    let json = desk.analyse("torus.wav");
    assert_eq!(json["verdict"]["regime"], "quasi-periodic");
    assert_eq!(json["section"]["shape"], "loop");
    let f2 = number(&json["spectrum"]["f2_hz"]);
    assert!((f2 - 353.515).abs() < 0.01, "{f2}");
    assert!(number(&json["zero_one"]["k"]).abs() < 0.1);
}

#[test]
fn lorenz_is_chaotic() {
    let desk = Desk::new();
    let rows = lorenz(20_000).into_iter().enumerate();
    let rows = rows.map(|(k, x)| format!("{:.2},{x}\n", 0.01 * k as f64));
    let text = format!("t,x\n{}", rows.collect::<String>());
    fs::write(desk.path("lorenz.csv"), text).expect("written");
    let json = desk.analyse("lorenz.csv");
    assert_eq!(json["verdict"]["regime"], "chaotic");
    // The largest exponent is 0.906.
    let exponent = number(&json["rosenstein"]["region"]["exponent_per_s"]);
    assert!((exponent / 0.906 - 1.0).abs() < 0.2, "{exponent}");
    assert!(number(&json["zero_one"]["k"]) > 0.9);
    assert_eq!(json["embedding"]["unfolded"], true);
}

/// The same samples give the same numbers, whatever file they come from.
#[test]
fn the_format_does_not_matter() {
    let desk = Desk::new();
    let (rate, count) = (8000.0, 4000);
    let whole = tones(rate, count, &[(210.0, 0.5), (630.0, 0.1)]);
    let samples: Vec<f64> = whole.iter().map(|&x| f64::from(x) / 32768.0).collect();
    let times: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
    desk.wav("a.wav", 8000, 1, &whole);
    desk.npy("a.npy", &samples);
    let arrays = [
        ("t", Array::vector(times.clone())),
        ("u", Array::vector(samples.clone())),
    ];
    write_npz(&desk.path("a.npz"), &arrays).expect("written");
    let rows = times
        .iter()
        .zip(&samples)
        .map(|(t, x)| format!("{t};{x}\n"));
    let text = rows.collect::<String>().replace('.', ",");
    fs::write(desk.path("a.csv"), text).expect("written");
    desk.run("a.wav --save a.rrd").success();
    let numbers = |words: &str| {
        let mut json = desk.analyse(words);
        for name in ["file", "files"] {
            json[name] = Value::Null;
        }
        json["signal"]["name"] = Value::Null;
        json["signal"]["unit"] = Value::Null;
        json
    };
    let expected = numbers("a.wav");
    assert_eq!(expected["verdict"]["regime"], "periodic");
    for words in [
        "a.npy --rate 8000",
        "a.npz",
        "a.csv",
        "a.rrd --column signal",
    ] {
        assert_eq!(numbers(words), expected, "{words}");
    }
}

#[test]
fn outputs_are_written_and_the_input_is_not() {
    let desk = Desk::new();
    desk.wav("a.wav", 8000, 1, &tones(8000.0, 4000, &[(210.0, 0.5)]));
    let before = fs::read(desk.path("a.wav")).expect("there");
    let json = desk.analyse("a.wav --from 0.1 --to 0.4 --png figures --save a.rrd --lag 5 --dimension 3 --threshold spread:0.2");
    assert_eq!(json["signal"]["samples"], 2400);
    assert_eq!(json["embedding"]["lag_samples"], 5);
    assert_eq!(json["embedding"]["dimension"], 3);
    assert_eq!(json["recurrence"]["threshold"], "spread");
    let files = json["files"].as_array().expect("a list");
    assert!(files.len() > 5);
    for file in files {
        let path = file["path"].as_str().expect("text");
        let bytes = fs::read(path).expect("written");
        assert_eq!(file["bytes"], bytes.len());
        assert!(
            bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"RRF"),
            "{path}"
        );
    }
    for words in ["--json a.wav", "--save ./a.wav", "--png a.wav"] {
        desk.refused(&format!("a.wav {words}"));
    }
    desk.refused("a.wav --save b --json b");
    assert_eq!(fs::read(desk.path("a.wav")).expect("there"), before);
}

#[test]
fn each_bad_file_has_its_word() {
    let desk = Desk::new();
    let tone = tones(8000.0, 4000, &[(210.0, 0.5)]);
    desk.wav("stereo.wav", 8000, 2, &tone);
    desk.wav("short.wav", 8000, 1, &tone[..100]);
    desk.wav("still.wav", 8000, 1, &[7; 4000]);
    desk.npy("a.npy", &[1.0; 600]);
    let whole = fs::read(desk.path("stereo.wav")).expect("there");
    fs::write(desk.path("cut.wav"), &whole[..whole.len() - 1000]).expect("written");
    fs::write(desk.path("bytes.wav"), b"\x00\x01\x02").expect("written");
    fs::write(desk.path("bytes.rrd"), b"RRF2\x00\x01\x02").expect("written");
    fs::write(desk.path("empty.csv"), "").expect("written");
    fs::write(desk.path("ragged.csv"), "t,u\n0,1\n1\n").expect("written");
    fs::write(desk.path("words.csv"), "t,u\n0,1\n1,one\n").expect("written");
    fs::write(desk.path("hole.csv"), "t,u\n0,1\n1,nan\n2,0\n").expect("written");
    fs::write(desk.path("gap.csv"), "t,u\n0,1\n1,2\n2,0\n4,1\n5,1\n").expect("written");
    for (words, said) in [
        ("absent.wav", "no such file"),
        (".", "directory"),
        ("empty.csv", "empty"),
        ("bytes.wav", "format is unknown"),
        ("bytes.rrd", "no recording"),
        ("cut.wav --column left", "cut short"),
        ("stereo.wav", "--column: left, right"),
        ("stereo.wav --column middle", "no column `middle`"),
        ("short.wav", "100 samples are too few; give at least 500"),
        ("still.wav", "all samples are the same"),
        ("ragged.csv", "line 3 has 1 fields"),
        ("words.csv", "line 3, column `u`: `one`"),
        ("hole.csv", "sample 1 (at 1 s) of `u` is NaN"),
        ("gap.csv", "not evenly spaced"),
        ("a.npy", "--rate HZ"),
        ("a.npy --rate 0", "a rate of 0 Hz"),
        ("a.npy --rate nan", "a rate of NaN Hz"),
        (
            "stereo.wav --column left --rate 8001",
            "own clock gives 8000 Hz",
        ),
        (
            "stereo.wav --column left --from 0.2 --to 0.1",
            "not before --to",
        ),
        ("stereo.wav --column left --from -1", "outside the file"),
    ] {
        let message = desk.refused(words);
        assert!(message.contains(said), "{words}: {message}");
        let file = words.split(' ').next().expect("a file");
        assert!(message.contains(file), "{message}");
    }
    for words in [
        "a.npy --lag 0",
        "a.npy --dimension 0",
        "a.npy --threshold rate:2",
    ] {
        desk.run(words).code(2).stdout("");
    }
}
