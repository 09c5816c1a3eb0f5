//! What is heard of a run: its pitch, its length, its level, and the point it is heard at.

use std::path::Path;

use assert_cmd::Command;

/// A WAV file, samples of full scale 1, and what its loudest stands for.
struct Heard(Vec<f64>, f64);

impl Heard {
    fn read(path: &Path, stands_for: f64) -> Self {
        let mut wav = hound::WavReader::open(path).expect("a WAV file");
        let spec = wav.spec();
        assert_eq!(
            (spec.channels, spec.sample_rate, spec.bits_per_sample),
            (1, 48_000, 24)
        );
        let samples = wav.samples::<i32>();
        let full = f64::from(1 << 23);
        Self(
            samples
                .map(|x| f64::from(x.expect("a sample")) / full)
                .collect(),
            stands_for,
        )
    }

    fn loudest(&self) -> f64 {
        self.0.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
    }

    /// Amplitude at a frequency (Hz) in the last `count` samples but those that are faded out.
    fn line(&self, frequency: f64, count: usize) -> f64 {
        let end = self.0.len() - 240;
        let part = &self.0[end - count..end];
        let turn = std::f64::consts::TAU / 48_000.0;
        let (mut c, mut s) = (0.0, 0.0);
        for (k, x) in part.iter().enumerate() {
            // Hann's window, of mean 1/2.
            let w = 1.0 - (std::f64::consts::TAU * k as f64 / count as f64).cos();
            let (sin, cos) = (turn * frequency * k as f64).sin_cos();
            c += w * x * cos;
            s += w * x * sin;
        }
        2.0 * c.hypot(s) / count as f64
    }

    /// The strongest of the frequencies from `from` to `to`, Hz.
    fn pitch(&self, from: f64, to: f64, count: usize) -> f64 {
        let steps = 400;
        let at = |k: usize| from + (to - from) * k as f64 / f64::from(steps);
        let strongest = (0..=steps as usize)
            .max_by(|a, b| {
                let [a, b] = [*a, *b].map(|k| self.line(at(k), count));
                a.total_cmp(&b)
            })
            .expect("some");
        at(strongest)
    }
}

/// Runs 80 ms of the pure tone with some more options, and gives the sound and what was said of it.
fn hear(options: &[&str]) -> (Heard, String) {
    let desk = tempfile::tempdir().expect("temporary folder");
    let run = [
        "run",
        "periodic-2deg",
        "--duration",
        "80",
        "--wav",
        "squeak.wav",
        "--json",
        "run.json",
    ];
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(desk.path()).args(run).args(options);
    command.assert().success();
    // Nothing else was asked for.
    assert!(!desk.path().join("squeak.rrd").exists());
    let json = std::fs::read(desk.path().join("run.json")).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let (heard, loudest) = json["heard"]
        .as_str()
        .and_then(|heard| heard.split_once("; the loudest is "))
        .expect("told");
    let (loudest, unit) = loudest.split_once(' ').expect("a unit");
    let of_pressure = options.contains(&"pressure");
    assert_eq!(unit, if of_pressure { "m/s^2" } else { "mm/s" });
    let loudest: f64 = loudest.parse().expect("a number");
    let loudest = if of_pressure { loudest } else { 1e-3 * loudest };
    let heard = heard.to_owned();
    (Heard::read(&desk.path().join("squeak.wav"), loudest), heard)
}

#[test]
fn a_tone_is_heard_at_its_pitch_or_lower_where_it_is_slower() {
    let (life, words) = hear(&[]);
    assert_eq!(words, "velocity of the contact's centre");
    assert_eq!(life.0.len(), 3840);
    assert!((life.loudest() - 0.891).abs() < 1e-3, "{}", life.loudest());
    let pitch = life.pitch(3900.0, 4300.0, 1920);
    assert!((pitch - 4111.0).abs() < 5.0, "{pitch} Hz");

    let (slow, _) = hear(&["--slower", "10"]);
    assert!((slow.1 / life.1 - 1.0).abs() < 0.2, "as loud as in life");
    assert_eq!(slow.0.len(), 38_400);
    let pitch = slow.pitch(390.0, 430.0, 19_200);
    assert!((pitch - 411.1).abs() < 0.5, "{pitch} Hz");
    // What a loudspeaker cannot play in life is there when it is slow: the fifth harmonic above 20 kHz.
    let [first, fifth] = [411.1, 5.0 * 411.1].map(|f| slow.line(f, 19_200));
    assert!(fifth > 1e-3 * first, "{first} {fifth}");
}

#[test]
fn pressure_weighs_a_line_by_its_frequency() {
    let ratio = |heard: &Heard| {
        let pitch = heard.pitch(4000.0, 4200.0, 1920);
        heard.line(3.0 * pitch, 1920) / heard.line(pitch, 1920)
    };
    let (velocity, _) = hear(&[]);
    let (pressure, words) = hear(&["--sound", "pressure"]);
    assert_eq!(
        words,
        "acceleration of the contact's centre, as the pressure far away follows it"
    );
    let gained = ratio(&pressure) / ratio(&velocity);
    assert!((gained - 3.0).abs() < 0.1, "{gained}");
    // In one unit of time, and with harmonics that weigh more.
    let gained = pressure.1 / velocity.1 / (std::f64::consts::TAU * 4111.0);
    assert!((1.0..3.0).contains(&gained), "{gained}");
}

#[test]
fn a_point_of_the_surface_is_heard_where_it_moves() {
    // The side of the beam's far end, in the plane of the bending: as loud as may be, the same tone.
    let (side, words) = hear(&["--at", "8,0,150"]);
    assert!(
        words.starts_with("velocity of the surface at (") && words.ends_with(") mm, outwards"),
        "{words}"
    );
    let pitch = side.pitch(3900.0, 4300.0, 1920);
    assert!((pitch - 4111.0).abs() < 5.0, "{pitch} Hz");
    // Elsewhere the harmonics have another share.
    let (centre, _) = hear(&[]);
    let share = |heard: &Heard| heard.line(3.0 * 4111.0, 1920) / heard.line(4111.0, 1920);
    let [side, centre] = [share(&side), share(&centre)];
    assert!((side / centre - 1.0).abs() > 0.05, "{side} {centre}");
}

#[test]
fn what_has_no_surface_refuses_to_be_heard_there() {
    let desk = tempfile::tempdir().expect("temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(desk.path()).args([
        "run",
        "mass-on-belt",
        "--wav",
        "a.wav",
        "--at",
        "8,0,60",
        "--save",
        "a.rrd",
    ]);
    let assert = command.assert().code(2).stdout("");
    let said = String::from_utf8(assert.get_output().stderr.clone()).expect("text");
    assert!(
        said.contains("no surface") && said.contains("body_rate_khz"),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(desk.path()).expect("there").count(), 0);

    for wrong in ["1,2", "1,2,x", "1,2,inf"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
        let assert = command
            .args(["run", "--wav", "a.wav", "--at", wrong])
            .assert();
        assert.code(2);
    }
}
