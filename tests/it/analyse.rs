//! `squeakscope analyse`: known signals in every format, and one error message for each invalid file.

use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use npyz::WriterBuilder;
use serde_json::Value;
use squeakscope::export::write_npz;
use squeakscope::numpy::Array;

/// A temporary folder with signal files.
struct TestDir(tempfile::TempDir);

impl TestDir {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, args: &str) -> assert_cmd::assert::Assert {
        let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
        let args = ["analyse"].into_iter().chain(args.split(' '));
        command.current_dir(self.0.path()).args(args).assert()
    }

    /// JSON result of a successful analysis.
    fn analyse(&self, args: &str) -> Value {
        self.run(&format!("{args} --json out.json")).success();
        let text = fs::read(self.path("out.json")).expect("written");
        serde_json::from_slice(&text).expect("JSON")
    }

    /// Error message for a rejected file.
    fn rejection(&self, args: &str) -> String {
        let assert = self.run(args).code(2).stdout("");
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
        .unwrap_or_else(|| panic!("{value} is not a number"))
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
    let dir = TestDir::new();
    dir.wav(
        "tone.wav",
        44_100,
        1,
        &tones(44_100.0, 44_100, &[(440.0, 0.5)]),
    );
    let json = dir.analyse("tone.wav");
    assert_eq!(json["verdict"]["regime"], "periodic");
    assert!(number(&json["verdict"]["confidence"]) > 0.5);
    assert_eq!(json["signal"]["unit"], "FS");
    assert_eq!(json["signal"]["sample_rate_hz"], 44_100.0);
    let line = &json["spectrum"]["lines"][0];
    assert!(
        (number(&line["frequency_hz"]) - 440.0).abs() < 1e-3,
        "{line}"
    );
    assert!((number(&line["amplitude"]) - 0.5).abs() < 1e-3, "{line}");
    assert_eq!(line["label"], "f1");
    let period = number(&json["recurrence"]["recurrence_periods"][0]["period_s"]);
    assert!((period * 440.0 - 1.0).abs() < 1e-3, "{period}");
    let returns = number(&json["section"]["mean_return_time_s"]);
    assert!((returns * 440.0 - 1.0).abs() < 1e-5, "{returns}");
    assert_eq!(json["section"]["points"], 1);
    assert!(number(&json["recurrence"]["measures"]["determinism"]) > 0.99);
    assert!(number(&json["zero_one"]["k"]).abs() < 0.1);
    assert_eq!(json["rosenstein"]["region"]["exponent_per_s"], Value::Null);
}

#[test]
fn two_tones_are_a_torus() {
    let dir = TestDir::new();
    let samples = tones(44_100.0, 44_100, &[(440.0, 0.4), (353.515, 0.3)]);
    dir.wav("torus.wav", 44_100, 1, &samples);
    let json = dir.analyse("torus.wav");
    assert_eq!(json["verdict"]["regime"], "quasi-periodic");
    assert_eq!(json["section"]["shape"], "loop");
    let f2 = number(&json["spectrum"]["f2_hz"]);
    assert!((f2 - 353.515).abs() < 0.01, "{f2}");
    assert!(number(&json["zero_one"]["k"]).abs() < 0.1);
}

#[test]
fn lorenz_is_chaotic() {
    let dir = TestDir::new();
    let rows = lorenz(20_000).into_iter().enumerate();
    let rows = rows.map(|(k, x)| format!("{:.2},{x}\n", 0.01 * k as f64));
    let text = format!("t,x\n{}", rows.collect::<String>());
    fs::write(dir.path("lorenz.csv"), text).expect("written");
    let json = dir.analyse("lorenz.csv");
    assert_eq!(json["verdict"]["regime"], "chaotic");
    // The largest exponent is 0.906.
    let exponent = number(&json["rosenstein"]["region"]["exponent_per_s"]);
    assert!((exponent / 0.906 - 1.0).abs() < 0.2, "{exponent}");
    assert!(number(&json["zero_one"]["k"]) > 0.9);
    assert_eq!(json["embedding"]["unfolded"], true);
}

/// Equal samples give equal results in every file format.
#[test]
fn the_file_format_does_not_change_the_result() {
    let dir = TestDir::new();
    let (rate, count) = (8000.0, 4000);
    let whole = tones(rate, count, &[(210.0, 0.5), (630.0, 0.1)]);
    let samples: Vec<f64> = whole.iter().map(|&x| f64::from(x) / 32768.0).collect();
    let times: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
    dir.wav("a.wav", 8000, 1, &whole);
    dir.npy("a.npy", &samples);
    let arrays = [
        ("t", Array::vector(times.clone())),
        ("u", Array::vector(samples.clone())),
    ];
    write_npz(&dir.path("a.npz"), &arrays).expect("written");
    let rows = times
        .iter()
        .zip(&samples)
        .map(|(t, x)| format!("{t};{x}\n"));
    let text = rows.collect::<String>().replace('.', ",");
    fs::write(dir.path("a.csv"), text).expect("written");
    dir.run("a.wav --save a.rrd").success();
    let numbers = |args: &str| {
        let mut json = dir.analyse(args);
        for name in ["file", "files"] {
            json[name] = Value::Null;
        }
        json["signal"]["name"] = Value::Null;
        json["signal"]["unit"] = Value::Null;
        json
    };
    let expected = numbers("a.wav");
    assert_eq!(expected["verdict"]["regime"], "periodic");
    for args in [
        "a.npy --rate 8000",
        "a.npz",
        "a.csv",
        "a.rrd --column signal",
    ] {
        assert_eq!(numbers(args), expected, "{args}");
    }
}

#[test]
fn outputs_never_overwrite_the_input() {
    let dir = TestDir::new();
    dir.wav("a.wav", 8000, 1, &tones(8000.0, 4000, &[(210.0, 0.5)]));
    let before = fs::read(dir.path("a.wav")).expect("there");
    let json = dir.analyse("a.wav --from 0.1 --to 0.4 --figures figures --save a.rrd --lag 5 --dimension 3 --threshold spread:0.2");
    assert_eq!(json["signal"]["sample_count"], 2400);
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
    for args in ["--json a.wav", "--save ./a.wav", "--figures a.wav"] {
        dir.rejection(&format!("a.wav {args}"));
    }
    dir.rejection("a.wav --save b --json b");
    assert_eq!(fs::read(dir.path("a.wav")).expect("there"), before);
}

#[test]
fn each_invalid_file_has_a_specific_message() {
    let dir = TestDir::new();
    let tone = tones(8000.0, 4000, &[(210.0, 0.5)]);
    dir.wav("stereo.wav", 8000, 2, &tone);
    dir.wav("short.wav", 8000, 1, &tone[..100]);
    dir.wav("constant.wav", 8000, 1, &[7; 4000]);
    dir.npy("a.npy", &[1.0; 600]);
    let whole = fs::read(dir.path("stereo.wav")).expect("there");
    fs::write(dir.path("cut.wav"), &whole[..whole.len() - 1000]).expect("written");
    fs::write(dir.path("bytes.wav"), b"\x00\x01\x02").expect("written");
    fs::write(dir.path("bytes.rrd"), b"RRF2\x00\x01\x02").expect("written");
    fs::write(dir.path("empty.csv"), "").expect("written");
    fs::write(dir.path("ragged.csv"), "t,u\n0,1\n1\n").expect("written");
    fs::write(dir.path("words.csv"), "t,u\n0,1\n1,one\n").expect("written");
    fs::write(dir.path("hole.csv"), "t,u\n0,1\n1,nan\n2,0\n").expect("written");
    fs::write(dir.path("gap.csv"), "t,u\n0,1\n1,2\n2,0\n4,1\n5,1\n").expect("written");
    for (args, expected) in [
        ("absent.wav", "does not exist"),
        (".", "directory"),
        ("empty.csv", "empty"),
        ("bytes.wav", "unknown file format"),
        ("bytes.rrd", "is not a recording"),
        ("cut.wav --column left", "truncated"),
        ("stereo.wav", "--column: left, right"),
        ("stereo.wav --column middle", "no column `middle`"),
        ("short.wav", "100 samples are too few; give at least 500"),
        ("constant.wav", "all samples are equal"),
        ("ragged.csv", "line 3 has 1 fields"),
        ("words.csv", "line 3, column `u`: `one`"),
        ("hole.csv", "sample 1 (at 1 s) of `u` is NaN"),
        ("gap.csv", "not evenly spaced"),
        ("a.npy", "--rate HZ"),
        ("a.npy --rate 0", "the sample rate 0 Hz"),
        ("a.npy --rate nan", "the sample rate NaN Hz"),
        (
            "stereo.wav --column left --rate 8001",
            "a sample rate of 8000 Hz",
        ),
        (
            "stereo.wav --column left --from 0.2 --to 0.1",
            "not before --to",
        ),
        ("stereo.wav --column left --from -1", "outside the file"),
    ] {
        let message = dir.rejection(args);
        assert!(message.contains(expected), "{args}: {message}");
        let file = args.split(' ').next().expect("a file");
        assert!(message.contains(file), "{message}");
    }
    for args in [
        "a.npy --lag 0",
        "a.npy --dimension 0",
        "a.npy --threshold rate:2",
    ] {
        dir.run(args).code(2).stdout("");
    }
}
