//! Each scene shows what it promises: the regimes of the project's physics notes, dominant lines
//! within 1 %.

use squeakscope::analysis::{LineCriterion, SpectrumAnalyser, Window};
use squeakscope::pipeline::message::{Record, Summary};
use squeakscope::pipeline::{Monitor, run};
use squeakscope::scene::Scene;

struct Seen {
    summary: Summary,
    /// Velocity of the probe, m/s, at 200 kHz from t = 0.
    velocity: Vec<f64>,
}

const RATE: f64 = 200e3;

fn watch(name: &str) -> Seen {
    let scene = Scene::load(name).unwrap();
    assert_eq!(scene.sample_rate, RATE);
    let mut records = Vec::new();
    let summary = run(&scene, "test", &mut records, Monitor::default()).unwrap();
    let mut velocity = Vec::new();
    for record in &records {
        if let Record::Samples(frame) = record {
            velocity.extend(&frame.velocity);
        }
    }
    Seen { summary, velocity }
}

impl Seen {
    /// The spectrum of `length` seconds that end at `end`.
    fn spectrum(&self, end: f64, length: f64) -> Lines {
        let end = (end * RATE).round() as usize;
        let window = &self.velocity[end - (length * RATE).round() as usize..end];
        let mut analyser = SpectrumAnalyser::new(Window::Hann, RATE);
        let spectrum = analyser.analyse(window).unwrap();
        let found = spectrum.lines(&LineCriterion {
            most: 40,
            ..LineCriterion::default()
        });
        let mut band: Vec<f64> = spectrum
            .amplitude
            .iter()
            .enumerate()
            .filter(|(k, _)| (3400.0..5000.0).contains(&(*k as f64 * spectrum.bin)))
            .map(|(_, a)| *a)
            .collect();
        band.sort_by(f64::total_cmp);
        Lines {
            lines: found
                .iter()
                .map(|line| (line.frequency, line.amplitude))
                .collect(),
            floor: band[band.len() / 4],
        }
    }

    /// The spectrum of the last tenth of a second, or half of the run.
    fn settled(&self) -> Lines {
        let end = self.velocity.len() as f64 / RATE;
        self.spectrum(end, (0.5 * end).min(0.1))
    }
}

struct Lines {
    /// Frequency (Hz) and amplitude (m/s), strongest first.
    lines: Vec<(f64, f64)>,
    /// Lower quartile of the amplitudes from 3.4 to 5 kHz, m/s: low between the lines of a torus
    /// (0.24 kHz apart), filled by chaos.
    floor: f64,
}

impl Lines {
    /// The amplitude of the line within 1 % of `frequency`.
    fn line(&self, frequency: f64) -> f64 {
        let close = self
            .lines
            .iter()
            .filter(|(f, _)| (f / frequency - 1.0).abs() < 0.01);
        close.map(|(_, a)| *a).fold(0.0, f64::max)
    }

    fn dominant(&self) -> f64 {
        self.lines[0].0
    }

    /// 4.11 kHz, with 3.87 and 12.33 kHz beside it.
    fn has_the_peaks_of_the_torus(&self) {
        close(self.dominant(), 4110.0);
        for line in [3870.0, 12_330.0] {
            let share = self.line(line) / self.line(4110.0);
            assert!(share > 0.05, "{line}: {:?}", self.lines);
        }
    }
}

fn close(got: f64, want: f64) {
    assert!((got / want - 1.0).abs() < 0.01, "{got} is not {want}");
}

/// Azimuth 0, factor 1, 2 degrees: 4.117 kHz with harmonics (12.33 kHz at about 0.13 and 8.22 at
/// about 0.05 of it in displacement), 0.69 um, peak velocity 17.8 mm/s.
#[test]
fn periodic_2deg() {
    let seen = watch("periodic-2deg");
    let settled = seen.settled();
    close(settled.dominant(), 4117.0);
    for (harmonic, share) in [(8222.0, 0.05), (12_333.0, 0.13)] {
        let displacement = settled.line(harmonic) / harmonic / (settled.line(4117.0) / 4117.0);
        assert!(
            (displacement - share).abs() < 0.01,
            "{harmonic}: {displacement}"
        );
    }
    close(seen.summary.amplitude, 0.69e-6);
    close(seen.summary.peak_velocity, 17.8e-3);
    assert!(settled.floor < 1e-7, "{:e}", settled.floor);
}

/// Azimuth 135 degrees: the fourth bending mode has taken over at 3.5 degrees.
#[test]
fn mode_shift() {
    let settled = watch("mode-shift-3.5deg").settled();
    close(settled.dominant(), 12_440.0);
    assert!(
        settled.lines[1].1 < 0.1 * settled.lines[0].1,
        "{:?}",
        settled.lines
    );
}

/// The natural set at 3 degrees: a torus of 4.11 and 3.87 kHz, whose lines are sharp.
#[test]
fn torus_3deg() {
    let settled = watch("torus-3deg").settled();
    settled.has_the_peaks_of_the_torus();
    assert!(settled.floor < 2e-6, "{:e}", settled.floor);
}

/// The natural set at 5 degrees: the same peaks over a broad floor.
#[test]
fn chaos_5deg() {
    let settled = watch("chaos-5deg").settled();
    settled.has_the_peaks_of_the_torus();
    assert!(settled.floor > 1e-5, "{:e}", settled.floor);
}

/// The friction curve as printed stays silent: the kick does not grow.
#[test]
fn printed_friction_is_silent() {
    let seen = watch("printed-friction");
    let loudest = |part: &[f64]| part.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let (first, last) = seen.velocity.split_at(seen.velocity.len() / 2);
    assert!(loudest(last) < loudest(first) && loudest(first) < 1e-4);
}

/// The default scene changes its face twice: tone (0 degrees), torus (3), chaos (5.5).
#[test]
fn tilt_ramp() {
    let seen = watch("tilt-ramp");
    let tone = seen.spectrum(0.050, 0.025);
    close(tone.dominant(), 4104.0);
    assert!(
        tone.line(3870.0) < 0.02 * tone.line(4104.0),
        "{:?}",
        tone.lines
    );
    let torus = seen.spectrum(0.150, 0.050);
    close(torus.dominant(), 4110.0);
    assert!(
        torus.line(3870.0) > 0.05 * torus.line(4110.0),
        "{:?}",
        torus.lines
    );
    let chaos = seen.spectrum(0.285, 0.080);
    close(chaos.dominant(), 4120.0);
    let torus = seen.spectrum(0.150, 0.050).floor;
    assert!(
        chaos.floor > 3.0 * torus,
        "{:e} against {torus:e}",
        chaos.floor
    );
}
