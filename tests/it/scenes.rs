//! Each scene shows what it promises: the regimes of the project's physics notes, dominant lines
//! within 1 %.

use squeakscope::pipeline::message::{Record, Summary};
use squeakscope::pipeline::{Monitor, run};
use squeakscope::scene::Scene;

struct Seen {
    summary: Summary,
    /// Time (s), share of the lines' power, strongest frequencies, of each spectrum.
    spectra: Vec<Spectrum>,
}

struct Spectrum {
    time: f64,
    peaks: Vec<(f64, f64)>,
    /// Power outside 60 Hz of the peaks, over all power.
    floor: f64,
}

fn watch(scene: &Scene) -> Seen {
    let mut records = Vec::new();
    let summary = run(scene, "test", &mut records, Monitor::default()).unwrap();
    let spectra = records
        .iter()
        .filter_map(|record| match record {
            Record::Spectrum { time, bin, amplitude, peaks } => {
                let near = |k: usize| {
                    peaks.iter().any(|p| (p.frequency - k as f64 * bin).abs() < 3.0 * bin)
                };
                let power = |outside: bool| -> f64 {
                    let chosen = amplitude.iter().enumerate().filter(|(k, _)| !outside || !near(*k));
                    chosen.map(|(_, a)| a * a).sum()
                };
                let peaks = peaks.iter().map(|p| (p.frequency, p.amplitude)).collect();
                Some(Spectrum { time: *time, peaks, floor: power(true) / power(false) })
            }
            _ => None,
        })
        .collect();
    Seen { summary, spectra }
}

impl Spectrum {
    /// The amplitude of the line within 1 % of `frequency`.
    fn line(&self, frequency: f64) -> f64 {
        let close = self.peaks.iter().filter(|(f, _)| (f / frequency - 1.0).abs() < 0.01);
        close.map(|(_, a)| *a).fold(0.0, f64::max)
    }

    fn dominant(&self) -> f64 {
        self.peaks.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |p| p.0)
    }
}

fn settled(name: &str) -> Seen {
    watch(&Scene::load(name).unwrap())
}

fn close(got: f64, want: f64) {
    assert!((got / want - 1.0).abs() < 0.01, "{got} is not {want}");
}

/// Azimuth 0, factor 1, 2 degrees: 4.117 kHz with harmonics, 0.69 um, slip just reversed.
#[test]
fn periodic_2deg() {
    let seen = settled("periodic-2deg");
    let last = seen.spectra.last().unwrap();
    close(last.dominant(), 4117.0);
    for harmonic in [8222.0, 12_333.0] {
        assert!(last.line(harmonic) > 0.05 * last.line(4117.0), "{harmonic}");
    }
    close(seen.summary.amplitude, 0.69e-6);
    close(seen.summary.peak_velocity, 17.8e-3);
    assert!(last.floor < 1e-4, "{}", last.floor);
}

/// Azimuth 135 degrees: the fourth bending mode has taken over at 3.5 degrees; at 2 degrees the
/// second one sings.
#[test]
fn mode_shift() {
    close(settled("mode-shift-3.5deg").spectra.last().unwrap().dominant(), 12_440.0);
}

/// The natural set at 3 degrees: lines at 4.11, 3.87 and 12.33 kHz, and no broad floor.
#[test]
fn torus_3deg() {
    let seen = settled("torus-3deg");
    let last = seen.spectra.last().unwrap();
    close(last.dominant(), 4110.0);
    for line in [3870.0, 12_330.0] {
        assert!(last.line(line) > 0.05 * last.line(4110.0), "{line}: {:?}", last.peaks);
    }
}

/// The natural set at 5 degrees: the same peaks over a broad floor.
#[test]
fn chaos_5deg() {
    let (torus, chaos) = (settled("torus-3deg"), settled("chaos-5deg"));
    let (torus, chaos) = (torus.spectra.last().unwrap(), chaos.spectra.last().unwrap());
    close(chaos.dominant(), 4110.0);
    assert!(chaos.line(12_330.0) > 0.05 * chaos.line(4110.0));
    assert!(chaos.floor > 5.0 * torus.floor, "{} against {}", chaos.floor, torus.floor);
}

/// The friction curve as printed stays silent: the kick dies away.
#[test]
fn printed_friction_is_silent() {
    let seen = settled("printed-friction");
    assert!(seen.summary.peak_velocity < 1e-5, "{}", seen.summary.peak_velocity);
}

/// The default scene changes its face twice: tone, torus, chaos.
#[test]
fn tilt_ramp() {
    let scene = Scene::load("tilt-ramp").unwrap();
    let seen = watch(&scene);
    let at_tilt = |deg: f64| {
        let reached = |s: &&Spectrum| scene.tilt.at(s.time - 10e-3).to_degrees() >= deg;
        seen.spectra.iter().find(reached).unwrap()
    };
    let before_ramp = seen.spectra.iter().rfind(|s| scene.tilt.at(s.time) == 0.0).unwrap();
    close(before_ramp.dominant(), 4104.0);
    assert!(before_ramp.floor < 1e-3, "tone: {}", before_ramp.floor);
    assert!(before_ramp.line(3870.0) < 0.02 * before_ramp.line(4104.0));
    let torus = at_tilt(3.0);
    assert!(torus.line(3870.0) > 0.05 * torus.line(4110.0), "{:?}", torus.peaks);
    let chaos = seen.spectra.last().unwrap();
    assert!(chaos.floor > 3.0 * torus.floor, "{} against {}", chaos.floor, torus.floor);
}
