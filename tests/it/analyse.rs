//! `squeakscope analyse`: known signals in every format, and one error message for each invalid file.

use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use npyz::WriterBuilder;
use serde_json::Value;
use squeakscope::numpy::{Array, encode_npz};

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

    /// JSON result, standard output and standard error of a successful analysis.
    fn analyse_and_print(&self, args: &str) -> (Value, [String; 2]) {
        let run = self.run(&format!("{args} --force --json out.json"));
        let run = run.success();
        let printed = [&run.get_output().stdout, &run.get_output().stderr];
        let printed = printed.map(|text| String::from_utf8_lossy(text).into_owned());
        let json = fs::read(self.path("out.json")).expect("written");
        (serde_json::from_slice(&json).expect("JSON"), printed)
    }

    fn analyse(&self, args: &str) -> Value {
        self.analyse_and_print(args).0
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

/// Random numbers from -1 to 1: a linear congruential generator (Knuth's MMIX).
fn noise(seed: u64) -> impl Iterator<Item = f64> {
    let next = |state: &u64| {
        let next = state.wrapping_mul(6_364_136_223_846_793_005);
        Some(next.wrapping_add(1_442_695_040_888_963_407))
    };
    let states = std::iter::successors(Some(seed), next).skip(10);
    states.map(|state| (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
}

/// 6 s at 44.1 kHz with an ordinary squeak from 1.5 to 4.5 s: 4.1 kHz that drifts by +-15 Hz, with an amplitude modulation
/// of 12 Hz, in rumble and a little noise.
fn squeak(amplitude: f64) -> Vec<f64> {
    let rate = 44_100.0;
    let (mut phase, mut rumble) = (0.0, [0.0; 2]);
    let sample = |(k, noise): (usize, f64)| {
        let t = k as f64 / rate;
        phase += TAU * (4100.0 + 15.0 * (TAU / 3.0 * t).sin()) / rate;
        // Two first-order low-pass filters of 40 Hz.
        let share = TAU * 40.0 / rate;
        rumble[0] += share * (noise - rumble[0]);
        rumble[1] += share * (rumble[0] - rumble[1]);
        let sounding = ((t - 1.5) / 0.02).clamp(0.0, 1.0) * ((4.5 - t) / 0.02).clamp(0.0, 1.0);
        let modulated = 1.0 + 0.4 * (TAU * 12.0 * t).sin();
        amplitude * sounding * modulated * phase.sin() + 2.0 * rumble[1] + 0.005 * noise
    };
    (0..264_600).zip(noise(7)).map(sample).collect()
}

/// 16-bit samples; what exceeds full scale is clipped.
fn quantised(samples: &[f64]) -> Vec<i16> {
    let whole = samples.iter().map(|x| (x * 32768.0).round());
    whole.map(|x| x.clamp(-32768.0, 32767.0) as i16).collect()
}

#[test]
fn an_ordinary_squeak_is_an_event() {
    let dir = TestDir::new();
    dir.wav("squeak.wav", 44_100, 1, &quantised(&squeak(0.2)));
    let (json, [text, _]) = dir.analyse_and_print("squeak.wav --figures figures");
    assert!(text.starts_with("events\n"), "{text}");
    assert!(text.contains("in event 1, demodulated"), "{text}");
    let events = json["events"].as_array().expect("a list");
    assert_eq!(events.len(), 1, "{events:?}");
    let value = |name: &str| number(&events[0][name]);
    assert!((value("start_s") - 1.5).abs() < 0.1);
    assert!((value("end_s") - 4.5).abs() < 0.1);
    assert!((value("frequency_hz") / 4100.0 - 1.0).abs() < 1e-3);
    assert!((value("frequency_low_hz") - 4085.0).abs() < 4.0);
    assert!((value("frequency_high_hz") - 4115.0).abs() < 4.0);
    assert_eq!(events[0]["harmonics"], 1);
    // Mean power of 0.2 (1 + 0.4 sin), relative to a sine of amplitude 1.
    let level = 10.0 * (0.04 * (1.0 + 0.08_f64)).log10();
    assert!((value("level_db") - level).abs() < 1.0);
    assert!(value("snr_db") > 20.0);
    assert!((value("modulation_hz") - 12.0).abs() < 0.5);
    assert!((value("modulation_depth") - 0.4).abs() < 0.08);
    assert_eq!(json["condition"]["clipped"], Value::Array(Vec::new()));
    assert_eq!(json["level_reference"], "full-scale");

    // The same in Pa, of which a sine of amplitude 1 has 90.97 dB.
    let calibrated = dir.analyse("squeak.wav --event 1 --calibration 2Pa --labels squeak.txt");
    assert_eq!(calibrated["stretch"], json["stretch"]);
    assert_eq!(calibrated["verdict"], json["verdict"]);
    let more = number(&calibrated["events"][0]["level_db"]) - value("level_db");
    assert!(
        (more - 20.0 * 2_f64.log10() - 90.969).abs() < 1e-2,
        "{more}"
    );
    assert_eq!(calibrated["level_reference"], "sound-pressure");
    assert_eq!(calibrated["signal"]["unit"], "Pa");
    let labels = fs::read_to_string(dir.path("squeak.txt")).expect("written");
    assert!(labels.contains(" dB re 20 uPa"), "{labels}");

    let stretch = &json["stretch"];
    assert_eq!(stretch["event"], 1);
    assert_eq!(stretch["demodulated"], true);
    assert!(number(&stretch["start_s"]) > 1.4 && number(&stretch["end_s"]) < 4.6);
    assert!(number(&stretch["end_s"]) - number(&stretch["start_s"]) > 2.25);
    // Rumble is filtered out; demodulated, the tone is one line.
    assert!(number(&stretch["band_hz"][0]) > 1000.0);
    let line = number(&json["spectrum"]["lines"][0]["frequency_hz"]);
    assert!((line - value("frequency_hz")).abs() < 0.5, "{line}");
    assert_ne!(json["verdict"]["regime"], "noise");
    let figure = json["files"][0]["path"].as_str().expect("text");
    assert!(figure.ends_with("events.png"), "{figure}");

    let message = dir.rejection("squeak.wav --event 9");
    assert!(
        message.contains("one tonal event was found; give 1"),
        "{message}"
    );
    dir.run("squeak.wav --event 0").code(2).stdout("");
}

#[test]
fn times_of_events_are_those_of_the_file() {
    let dir = TestDir::new();
    dir.wav("squeak.wav", 44_100, 1, &quantised(&squeak(0.2)));
    let json = dir.analyse("squeak.wav --from 1 --to 5");
    let event = &json["events"][0];
    assert!((number(&event["start_s"]) - 1.5).abs() < 0.1, "{event}");
    assert!((number(&event["end_s"]) - 4.5).abs() < 0.1, "{event}");
    assert!((number(&event["ridge"][0]["time_s"]) - 1.5).abs() < 0.2);
    let stretch = &json["stretch"];
    assert!(number(&stretch["start_s"]) > 1.4 && number(&stretch["end_s"]) < 4.6);
}

#[test]
fn clipping_is_no_dynamics() {
    let dir = TestDir::new();
    dir.wav("clipped.wav", 44_100, 1, &quantised(&squeak(1.5)));
    let (json, [text, _]) = dir.analyse_and_print("clipped.wav");
    assert!(text.contains("harmonics may be artefacts"), "{text}");
    let event = &json["events"][0];
    assert!(
        (number(&event["frequency_hz"]) / 4100.0 - 1.0).abs() < 1e-3,
        "{event}"
    );
    assert!(number(&json["condition"]["clipped_share"]) > 0.01);
    let clipped = &json["condition"]["clipped"][0];
    assert!((number(&clipped["start_s"]) - 1.5).abs() < 0.1, "{clipped}");
    assert_eq!(json["stretch"]["clipped"], true);
    for method in ["rosenstein", "kantz", "zero_one"] {
        assert_eq!(json[method]["skipped"], "clipped", "{method}");
    }
}

/// Noise has no event, and one cannot be requested.
#[test]
fn a_recording_without_an_event_is_analysed_as_a_whole() {
    let dir = TestDir::new();
    let hiss: Vec<f64> = noise(3).take(32_000).map(|x| 0.1 * x).collect();
    dir.wav("hiss.wav", 16_000, 1, &quantised(&hiss));
    let json = dir.analyse("hiss.wav");
    assert_eq!(json["events"], Value::Array(Vec::new()));
    assert_eq!(json["stretch"]["event"], Value::Null);
    assert_eq!(json["verdict"]["regime"], "noise");
    let message = dir.rejection("hiss.wav --event 1");
    assert!(message.contains("no tonal event was found"), "{message}");
    // Half of it silent.
    let quiet = [&hiss[..16_000], &[0.0; 16_000]].concat();
    dir.wav("quiet.wav", 16_000, 1, &quantised(&quiet));
    let silence = &dir.analyse("quiet.wav")["condition"]["silence"];
    assert_eq!(silence.as_array().map(Vec::len), Some(1), "{silence}");
    assert!(
        (number(&silence[0]["start_s"]) - 1.0).abs() < 0.01,
        "{silence}"
    );
    assert!(
        (number(&silence[0]["end_s"]) - 2.0).abs() < 0.01,
        "{silence}"
    );
}

/// Simulated samples and slow data are no sound.
#[test]
fn events_are_searched_only_in_sound() {
    let dir = TestDir::new();
    let samples: Vec<f64> = (0..3000).map(|k| (0.1 * f64::from(k)).sin()).collect();
    dir.npy("a.npy", &samples);
    for rate in ["1", "200000"] {
        let json = dir.analyse(&format!("a.npy --rate {rate}"));
        assert!(json.get("events").is_none() && json.get("condition").is_none());
        assert_eq!(json["verdict"]["regime"], "periodic");
        let message = dir.rejection(&format!("a.npy --rate {rate} --event 1"));
        assert!(message.contains("8000 to 192000 Hz"), "{message}");
    }
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
    let (rate, count) = (8000.0, 2000);
    let whole = tones(rate, count, &[(210.0, 0.5), (630.0, 0.1)]);
    let samples: Vec<f64> = whole.iter().map(|&x| f64::from(x) / 32768.0).collect();
    let times: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
    dir.wav("a.wav", 8000, 1, &whole);
    dir.npy("a.npy", &samples);
    let arrays = [
        ("t", Array::vector(times.clone())),
        ("u", Array::vector(samples.clone())),
    ];
    let npz = std::fs::File::create(dir.path("a.npz")).expect("created");
    encode_npz(npz, &arrays).expect("written");
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
    assert_eq!(json["signal"]["start_s"], 0.1);
    assert_eq!(json["signal"]["duration_s"], 0.3);
    assert_eq!(json["embedding"]["lag_samples"], 5);
    assert_eq!(json["embedding"]["dimension"], 3);
    assert_eq!(json["recurrence"]["threshold"], "spread");
    let files = json["files"].as_array().expect("a list");
    // Thirteen figures and the recording.
    assert_eq!(files.len(), 14);
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
fn a_truncated_recording_is_read_with_a_warning() {
    let dir = TestDir::new();
    dir.wav("whole.wav", 8000, 1, &tones(8000.0, 4000, &[(210.0, 0.5)]));
    let whole = fs::read(dir.path("whole.wav")).expect("there");
    fs::write(dir.path("cut.wav"), &whole[..whole.len() - 1000]).expect("written");
    let (json, [_, message]) = dir.analyse_and_print("cut.wav");
    assert_eq!(json["signal"]["sample_count"], 3500);
    assert!(
        message.contains("warning: cut.wav: its header states 8000 bytes"),
        "{message}"
    );
    let json = dir.analyse("whole.wav --rate 16000");
    assert_eq!(json["signal"]["sample_rate_hz"], 16_000.0);
}

#[test]
fn silence_is_a_result() {
    let dir = TestDir::new();
    dir.wav("silent.wav", 8000, 1, &[0; 8000]);
    dir.wav("constant.wav", 8000, 1, &[7; 8000]);
    // Dither of one step on either side.
    let mut state = 1_u32;
    let mut dither = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        7 + ((state >> 16) % 3) as i16
    };
    let dithered: Vec<i16> = (0..8000).map(|_| dither()).collect();
    dir.wav("dithered.wav", 8000, 1, &dithered);
    // A switch has two levels, too.
    let switched: Vec<i16> = (0..8000).map(|k| 20_000 * (k / 20 % 2)).collect();
    dir.wav("switched.wav", 8000, 1, &switched);
    assert_eq!(dir.analyse("switched.wav")["verdict"]["regime"], "periodic");
    for name in ["silent.wav", "constant.wav", "dithered.wav"] {
        let json = dir.analyse(&format!("{name} --figures figures"));
        assert_eq!(json["verdict"]["regime"], "silent");
        assert_eq!(json["events"], Value::Array(Vec::new()));
        assert_eq!(json["embedding"]["skipped"], "silent");
        assert_eq!(json["zero_one"]["skipped"], "silent");
    }
}

#[test]
fn each_invalid_file_has_a_specific_message() {
    let dir = TestDir::new();
    let tone = tones(8000.0, 4000, &[(210.0, 0.5)]);
    dir.wav("stereo.wav", 8000, 2, &tone);
    dir.wav("short.wav", 8000, 1, &tone[..100]);
    dir.npy("a.npy", &[1.0; 600]);
    fs::write(dir.path("bytes.wav"), b"\x00\x01\x02").expect("written");
    fs::write(dir.path("bytes.rrd"), b"RRF2\x00\x01\x02").expect("written");
    fs::write(dir.path("empty.csv"), "").expect("written");
    fs::write(dir.path("ragged.csv"), "t,u\n0,1\n1\n").expect("written");
    fs::write(dir.path("words.csv"), "t,u\n0,1\n1,one\n").expect("written");
    fs::write(dir.path("hole.csv"), "t,u\n0,1\n1,nan\n2,0\n").expect("written");
    fs::write(dir.path("gap.csv"), "t,u\n0,1\n1,2\n2,0\n4,1\n5,1\n").expect("written");
    for (args, expected) in [
        ("absent.wav", "cannot read the file (No such file"),
        ("empty.csv", "empty"),
        ("bytes.wav", "unknown file format"),
        ("bytes.rrd", "is not a recording"),
        ("stereo.wav", "--column: left, right"),
        ("stereo.wav --column middle", "no column `middle`"),
        ("short.wav", "100 samples are too few; give at least 500"),
        ("ragged.csv", "line 3 has 1 fields"),
        ("words.csv", "line 3, column `u`: `one`"),
        ("hole.csv", "sample 1 (at 1 s) of `u` is NaN"),
        ("gap.csv", "the time has a gap"),
        ("a.npy", "--rate HZ"),
        ("a.npy --rate 0", "the sample rate 0 Hz"),
        ("a.npy --rate nan", "the sample rate NaN Hz"),
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
