//! The regime of each scene, with dominant frequencies within 1 %.

use squeakscope::analysis::tones::{LineCriterion, SpectrumAnalyser, Window};
use squeakscope::pipeline::message::{Record, Summary};
use squeakscope::pipeline::{Monitor, run};
use squeakscope::scene::Scene;

struct Response {
    summary: Summary,
    /// Velocity of the probe, m/s, at 200 kHz from t = 0.
    velocity: Vec<f64>,
}

const RATE: f64 = 200e3;

fn response_of(name: &str) -> Response {
    response(Scene::load(name).unwrap())
}

fn response(scene: Scene) -> Response {
    assert_eq!(scene.sample_rate, RATE);
    let mut records = Vec::new();
    let scene = scene.without_analyses();
    let summary = run(&scene, "test", &mut records, Monitor::default()).unwrap();
    let mut velocity = Vec::new();
    for record in &records {
        if let Record::Samples(frame) = record {
            velocity.extend(&frame.velocity);
        }
    }
    Response { summary, velocity }
}

impl Response {
    /// The spectrum of an interval of `length` (s) that ends at `end` (s).
    fn spectrum(&self, end: f64, length: f64) -> Lines {
        let end = (end * RATE).round() as usize;
        let window = &self.velocity[end - (length * RATE).round() as usize..end];
        let mut analyser = SpectrumAnalyser::new(Window::Hann, RATE);
        let spectrum = analyser.analyse(window).unwrap();
        let found = spectrum.lines(&LineCriterion {
            max_lines: 40,
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
            broadband_level: band[band.len() / 4],
        }
    }

    /// The spectrum of the last 0.1 s, but at most of half the run.
    fn settled(&self) -> Lines {
        let end = self.velocity.len() as f64 / RATE;
        self.spectrum(end, (0.5 * end).min(0.1))
    }
}

struct Lines {
    /// Frequency (Hz) and amplitude (m/s), strongest first.
    lines: Vec<(f64, f64)>,
    /// Lower quartile of the amplitudes from 3.4 to 5 kHz, m/s: the broadband level, low between the lines of a torus
    /// (0.24 kHz apart) and high for chaos.
    broadband_level: f64,
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

    /// Dominant line at 4.11 kHz, further lines at 3.87 and 12.33 kHz.
    fn assert_lines_of_the_torus(&self) {
        close(self.dominant(), 4110.0);
        for line in [3870.0, 12_330.0] {
            let share = self.line(line) / self.line(4110.0);
            assert!(share > 0.05, "{line}: {:?}", self.lines);
        }
    }
}

fn close(got: f64, want: f64) {
    assert!((got / want - 1.0).abs() < 0.01, "{got} differs from {want}");
}

/// Azimuth 0, stiffness factor 1, 2 degrees: 4.117 kHz with harmonics (relative displacements about 0.13 at 12.33 kHz
/// and 0.05 at 8.22 kHz), 0.69 um, peak velocity 17.8 mm/s.
#[test]
fn periodic_2deg() {
    // The bound of the broadband level is 1 % above the leakage of the lines: steps of 1e-5 would show.
    let scene = Scene::load("periodic-2deg").unwrap();
    let response = response(scene.with_tolerance(1e-6).unwrap());
    let settled = response.settled();
    close(settled.dominant(), 4117.0);
    for (harmonic, share) in [(8222.0, 0.05), (12_333.0, 0.13)] {
        let displacement = settled.line(harmonic) / harmonic / (settled.line(4117.0) / 4117.0);
        assert!(
            (displacement - share).abs() < 0.01,
            "{harmonic}: {displacement}"
        );
    }
    close(response.summary.amplitude_m, 0.69e-6);
    close(response.summary.peak_velocity_m_per_s, 17.8e-3);
    assert!(
        settled.broadband_level < 1e-7,
        "{:e}",
        settled.broadband_level
    );
}

/// Azimuth 135 degrees: the fourth bending mode dominates at 3.5 degrees.
#[test]
fn mode_shift() {
    let settled = response_of("mode-shift-3.5deg").settled();
    close(settled.dominant(), 12_440.0);
    assert!(
        settled.lines[1].1 < 0.1 * settled.lines[0].1,
        "{:?}",
        settled.lines
    );
}

/// 3 degrees: a torus with sharp lines at 4.11 and 3.87 kHz.
#[test]
fn torus_3deg() {
    let settled = response_of("doubled-torus-3deg").settled();
    settled.assert_lines_of_the_torus();
    assert!(
        settled.broadband_level < 2e-6,
        "{:e}",
        settled.broadband_level
    );
}

/// 5 degrees: the same lines with a broadband level.
#[test]
fn chaos_5deg() {
    let settled = response_of("chaos-5deg").settled();
    settled.assert_lines_of_the_torus();
    assert!(
        settled.broadband_level > 1e-5,
        "{:e}",
        settled.broadband_level
    );
}

/// With the friction curve as printed the kick does not grow.
#[test]
fn printed_friction_is_stable() {
    let response = response_of("printed-friction");
    let peak = |part: &[f64]| part.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let (first, last) = response.velocity.split_at(response.velocity.len() / 2);
    assert!(peak(last) < peak(first) && peak(first) < 1e-4);
}

/// The regimes of the default scene: periodic (0 degrees), torus (3), chaos (5.5).
#[test]
fn tilt_ramp() {
    let response = response_of("tilt-ramp");
    let periodic = response.spectrum(0.100, 0.050);
    close(periodic.dominant(), 4104.0);
    assert!(
        periodic.line(3870.0) < 0.02 * periodic.line(4104.0),
        "{:?}",
        periodic.lines
    );
    let torus = response.spectrum(0.240, 0.050);
    close(torus.dominant(), 4110.0);
    assert!(
        torus.line(3870.0) > 0.05 * torus.line(4110.0),
        "{:?}",
        torus.lines
    );
    let chaos = response.spectrum(0.375, 0.080);
    close(chaos.dominant(), 4120.0);
    let torus = response.spectrum(0.240, 0.050).broadband_level;
    assert!(
        chaos.broadband_level > 3.0 * torus,
        "{:e} compared with {torus:e}",
        chaos.broadband_level
    );
}
