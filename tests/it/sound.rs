//! Audio of a run: pitch, duration, level, and the point of the surface.

use std::path::Path;

use assert_cmd::Command;

/// A WAV file: samples relative to full scale, and the value of its peak.
struct Audio(Vec<f64>, f64);

impl Audio {
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

    /// Amplitude at a frequency (Hz) in the last `count` samples without the fade-out.
    fn line(&self, frequency: f64, count: usize) -> f64 {
        let end = self.0.len() - 240;
        let part = &self.0[end - count..end];
        let turn = std::f64::consts::TAU / 48_000.0;
        let (mut c, mut s) = (0.0, 0.0);
        for (k, x) in part.iter().enumerate() {
            // Hann window, mean 1/2.
            let w = 1.0 - (std::f64::consts::TAU * k as f64 / count as f64).cos();
            let (sin, cos) = (turn * frequency * k as f64).sin_cos();
            c += w * x * cos;
            s += w * x * sin;
        }
        2.0 * c.hypot(s) / count as f64
    }

    /// The frequency with the largest amplitude between `from` and `to`, Hz.
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

/// Simulates 80 ms of the pure tone with additional options. Returns the sound and its printed description.
fn simulate(options: &[&str]) -> (Audio, String) {
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
    // No other file was requested.
    assert!(!desk.path().join("squeak.rrd").exists());
    let json = std::fs::read(desk.path().join("run.json")).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let (heard, loudest) = json["audio"]
        .as_str()
        .and_then(|heard| heard.split_once("; peak "))
        .expect("printed");
    let (loudest, unit) = loudest.split_once(' ').expect("a unit");
    let of_pressure = options.contains(&"pressure");
    let factor = match unit {
        "m/s^2" if of_pressure => 1.0,
        "mm/s" if !of_pressure => 1e-3,
        "µm/s" if !of_pressure => 1e-6,
        unit => panic!("{unit}"),
    };
    let loudest = factor * loudest.parse::<f64>().expect("a number");
    let heard = heard.to_owned();
    (Audio::read(&desk.path().join("squeak.wav"), loudest), heard)
}

#[test]
fn the_pitch_is_true_or_lowered_by_the_time_stretch() {
    let (life, words) = simulate(&[]);
    assert_eq!(words, "velocity of the contact centre");
    assert_eq!(life.0.len(), 3840);
    assert!((life.loudest() - 0.891).abs() < 1e-3, "{}", life.loudest());
    let pitch = life.pitch(3900.0, 4300.0, 1920);
    assert!((pitch - 4111.0).abs() < 5.0, "{pitch} Hz");

    let (slow, _) = simulate(&["--time-stretch", "10"]);
    assert!(
        (slow.1 / life.1 - 1.0).abs() < 0.2,
        "same level as in real time"
    );
    assert_eq!(slow.0.len(), 38_400);
    let pitch = slow.pitch(390.0, 430.0, 19_200);
    assert!((pitch - 411.1).abs() < 0.5, "{pitch} Hz");
    // A slow playback contains components that a loudspeaker cannot play in real time: the fifth harmonic, 20
    // kHz.
    let [first, fifth] = [411.1, 5.0 * 411.1].map(|f| slow.line(f, 19_200));
    assert!(fifth > 1e-3 * first, "{first} {fifth}");
}

#[test]
fn runs_with_one_level_can_be_compared() {
    let (normalised, _) = simulate(&[]);
    let (squeak, words) = simulate(&["--wav-level", "50"]);
    assert_eq!(
        words,
        "velocity of the contact centre, full scale 50.0 mm/s"
    );
    let level = squeak.loudest() * 50e-3;
    assert!((level / squeak.1 - 1.0).abs() < 0.01, "{level}");
    assert!((squeak.1 / normalised.1 - 1.0).abs() < 1e-6);
    let (cured, _) = simulate(&["--wav-level", "50", "--set", "mu_s=0.25"]);
    assert!(cured.loudest() < 0.01 * squeak.loudest());
}

#[test]
fn pressure_weights_a_line_by_its_frequency() {
    let ratio = |heard: &Audio| {
        let pitch = heard.pitch(4000.0, 4200.0, 1920);
        heard.line(3.0 * pitch, 1920) / heard.line(pitch, 1920)
    };
    let (velocity, _) = simulate(&[]);
    let (pressure, words) = simulate(&["--sound", "pressure"]);
    assert_eq!(
        words,
        "acceleration of the contact centre, proportional to the far-field sound pressure"
    );
    let gained = ratio(&pressure) / ratio(&velocity);
    assert!((gained - 3.0).abs() < 0.1, "{gained}");
    // Acceleration per unit of time; the harmonics have a larger weight.
    let gained = pressure.1 / velocity.1 / (std::f64::consts::TAU * 4111.0);
    assert!((1.0..3.0).contains(&gained), "{gained}");
}

#[test]
fn a_point_of_the_surface_has_its_own_sound() {
    // A surface point near the pole of the ball: the same tone, normalised.
    let (side, words) = simulate(&["--probe", "8,0,150"]);
    assert!(
        words.starts_with("velocity of the surface at (")
            && words.ends_with(") mm along the outward normal"),
        "{words}"
    );
    let pitch = side.pitch(3900.0, 4300.0, 1920);
    assert!((pitch - 4111.0).abs() < 5.0, "{pitch} Hz");
    // The harmonics have another share than at the contact centre.
    let (centre, _) = simulate(&[]);
    let share = |heard: &Audio| heard.line(3.0 * 4111.0, 1920) / heard.line(4111.0, 1920);
    let [side, centre] = [share(&side), share(&centre)];
    assert!((side / centre - 1.0).abs() > 0.05, "{side} {centre}");
}

#[test]
fn a_surface_point_without_a_surface_is_rejected() {
    let desk = tempfile::tempdir().expect("temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    command.current_dir(desk.path()).args([
        "run",
        "mass-on-belt",
        "--wav",
        "a.wav",
        "--probe",
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
            .args(["run", "--wav", "a.wav", "--probe", wrong])
            .assert();
        assert.code(2);
    }
}
