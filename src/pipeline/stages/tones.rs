//! The tones of the probe's velocity: its spectrum with named lines, its spectrogram, and the commentary on its appearance.

use super::appearance::AppearanceClassifier;
use super::stage::{Stage, samples, velocity, windowed};
use crate::analysis::{
    sliding::SlidingWindow,
    stats::range,
    tones::{
        Bases, FREQUENCY_UNCERTAINTY, Line, LineCriterion, LineIdentification, SpectralLine,
        Spectrum, SpectrumAnalyser, Window, follow_lines,
    },
};
use crate::pipeline::message::{Header, JointInfo, Observation, OperatingPoint, Record};
use crate::scene::{SpectrogramSpec, SpectrumSpec};

/// Reference amplitude of the levels of a spectrogram: 0 dB is 1 mm/s.
const REFERENCE: f64 = 1e-3;

/// Lowest reported level, dB; the logarithm of zero is undefined.
const LOWEST_DB: f64 = -160.0;

/// Window of all spectra from which lines are extracted: its side lobes are below -92 dB.
pub const LINE_WINDOW: Window = Window::BlackmanHarris;

/// Number of lines that are named, and numbers of those that are kept: the strongest, and the strongest of a doubling,
/// which are often weaker.
const NAMED: usize = 24;
const STRONGEST: usize = 12;
const DOUBLED: usize = 2;

/// Lines of a spectrum with their names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLines {
    /// Lines, strongest first.
    pub lines: Vec<Line>,
    /// Their names and the base frequencies.
    pub naming: LineIdentification,
    /// Broadband share of the power, see [`Spectrum::broadband_share`].
    pub floor: f64,
}

impl NamedLines {
    /// Extracts and names the lines of a spectrum. The names of an earlier spectrum with the bases `previous` are kept as
    /// far as possible.
    pub fn following(spectrum: &Spectrum, previous: Bases) -> Self {
        let mut lines = spectrum.lines(&LineCriterion {
            max_lines: NAMED,
            ..LineCriterion::default()
        });
        let mut naming = follow_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin, previous);
        let is_doubled = |k: &usize| naming.names[*k].is_some_and(|name| name.divisor > 1);
        let weaker = (STRONGEST..lines.len()).filter(is_doubled).take(DOUBLED);
        let kept: Vec<usize> = (0..lines.len().min(STRONGEST)).chain(weaker).collect();
        naming.names = kept.iter().map(|k| naming.names[*k]).collect();
        lines = kept.iter().map(|k| lines[*k]).collect();
        Self {
            naming,
            floor: spectrum.broadband_share(),
            lines,
        }
    }

    /// Amplitude ratio of the strongest line that involves the second base frequency to the strongest line; 0
    /// if there is none.
    pub fn second_tone(&self) -> f64 {
        let named = self.lines.iter().zip(&self.naming.names);
        let mut second = named.filter(|(_, name)| name.is_some_and(|name| name.m != 0));
        let line = second.next().map(|(line, _)| line);
        line.map_or(0.0, |line| line.amplitude / self.lines[0].amplitude)
    }

    /// The lines with an amplitude of at least `rest`, with their names, for a record.
    pub fn peaks_above(&self, rest: f64) -> Vec<SpectralLine> {
        let mut peaks = self.naming.label(&self.lines);
        peaks.retain(|line| line.amplitude >= rest);
        peaks
    }
}

/// The largest magnitude of a slice.
pub fn peak_magnitude(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

/// Half the peak-to-peak value of a slice; 0 if it is empty.
pub fn half_range(x: &[f64]) -> f64 {
    let [low, high] = range(x.iter().copied());
    if high > low { 0.5 * (high - low) } else { 0.0 }
}

/// Emits [`Record::Spectrum`] of samples at `rate` (Hz).
///
/// Until the window is full, the spectrum uses the samples so far, from a quarter of the window on, with
/// wider bins. Lines below the velocity `rest` (m/s) are not reported.
pub fn spectrum(spec: &SpectrumSpec, rate: f64, rest: f64) -> Stage {
    let least = SpectrumAnalyser::MIN_SAMPLES;
    let length = samples(spec.window, rate, least);
    let sliding =
        SlidingWindow::new(length, spec.every * rate).with_min_length((length / 4).max(least));
    let mut analyser = SpectrumAnalyser::new(LINE_WINDOW, rate);
    let long = length as f64 > AppearanceClassifier::MEMORY * rate;
    // Complete: lessons and panels name the lines.
    windowed(velocity, sliding, false, move |window, context| {
        let spectrum = analyser.analyse(window.signal)?;
        let named = NamedLines::following(&spectrum, context.bases);
        context.bases = named.naming.bases;
        context.floor = if long && window.signal.len() == length {
            named.floor
        } else {
            1.0
        };
        // A vibration at rest has no lines.
        let peaks = if peak_magnitude(window.signal) < rest {
            Vec::new()
        } else {
            named.peaks_above(rest)
        };
        context.records.push(Record::Spectrum {
            time: window.time,
            bin: spectrum.bin,
            peaks,
            amplitude: spectrum.amplitude,
        });
        Ok(())
    })
}

/// Emits [`Record::SpectrogramColumn`] of samples at `rate` (Hz) as soon as the window is full. The Hann
/// window suits short windows: a narrow main lobe matters more than low side lobes.
pub fn spectrogram(spec: &SpectrogramSpec, rate: f64) -> Stage {
    let length = samples(spec.window, rate, SpectrumAnalyser::MIN_SAMPLES);
    let max_frequency = spec.max_frequency;
    let mut analyser = SpectrumAnalyser::new(Window::Hann, rate);
    let sliding = SlidingWindow::new(length, spec.every * rate);
    windowed(velocity, sliding, false, move |window, context| {
        let column = analyser.analyse(window.signal)?;
        // Rounding must not drop a last bin that lies exactly at the limit.
        let bins = (max_frequency / column.bin + 1e-9) as usize + 1;
        let level = |a: &f64| (20.0 * (a / REFERENCE).log10()).max(LOWEST_DB) as f32;
        context.records.push(Record::SpectrogramColumn {
            time: context.clock.time(window.seen as f64 - 0.5 * length as f64),
            bin: column.bin,
            level_db: column.amplitude.iter().take(bins).map(level).collect(),
        });
        Ok(())
    })
}

/// Emits [`Record::Narration`] if the samples of `joint`, described by `header`, have a new appearance, checked
/// every `every` seconds.
///
/// The classifier has its own window of [`AppearanceClassifier::MEMORY`], independent of the window of the
/// displayed spectrum.
pub fn narration(every: f64, joint: &JointInfo, header: &Header) -> Stage {
    let rate = header.sample_rate;
    let count = |seconds| samples(seconds, rate, SpectrumAnalyser::MIN_SAMPLES);
    let mut sliding = SlidingWindow::new(count(AppearanceClassifier::MEMORY), every * rate)
        .with_min_length(count(AppearanceClassifier::FIRST));
    let mut classifier = AppearanceClassifier::new(rate, header.rest_speed);
    let (load_varies, rotation_varies) = (joint.load_varies(), joint.rotation_varies());
    let sliding_speed = joint.sliding_speed;
    Box::new(move |frame, context| {
        let rotation_factor = rotation_varies.then_some(frame.rotation_factor);
        let now = OperatingPoint {
            tilt: frame.tilt,
            load: load_varies.then_some(frame.load),
            rotation_factor,
            sliding_speed: sliding_speed * rotation_factor.map_or(1.0, f64::abs),
        };
        sliding.push([&frame.velocity, &frame.displacement], |view| {
            let time = context.clock.time(view.seen as f64 - 1.0);
            let seen = classifier.classify(view.channels, time, now, context)?;
            let observation = seen.map(|seen| Observation::Vibration(Box::new(seen)));
            let narration = observation.map(|observation| Record::Narration { time, observation });
            context.records.extend(narration);
            Ok(())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Monitor, run};
    use crate::scene::{AnalysisSpec, Scene};

    /// The narration names the tones as the spectrum does: `f2`, and not `f1 + f2` as a tone of its own.
    #[test]
    fn the_second_tone_is_that_of_the_spectrum() {
        let records = records("doubled-torus-3deg");
        let (mut in_spectrum, mut compared) = (None, 0);
        for record in &records {
            match record {
                Record::Spectrum { peaks, .. } => {
                    let line = peaks.iter().find(|line| line.label == "f2");
                    in_spectrum = line.map(|line| line.frequency);
                }
                Record::Narration {
                    observation: Observation::Vibration(vibration),
                    ..
                } => {
                    if let (Some(f2), Some(expected)) = (vibration.f2, in_spectrum) {
                        assert!((f2 / expected - 1.0).abs() < 0.01, "{f2} {expected}");
                        compared += 1;
                    }
                }
                _ => {}
            }
        }
        assert!(compared > 0);
    }

    /// The records of a preset scene with only the analyses that the commentary uses.
    fn records(scene: &str) -> Vec<Record> {
        let mut records: Vec<Record> = Vec::new();
        let mut scene = Scene::load(scene).unwrap();
        scene.analysis = AnalysisSpec {
            spectrum: scene.analysis.spectrum,
            exponents: scene.analysis.exponents,
            perturbed_trajectory: scene.analysis.perturbed_trajectory,
            ..AnalysisSpec::default()
        };
        run(&scene, "", &mut records, Monitor::default()).unwrap();
        records
    }

    /// The headings for a preset scene, without repetitions.
    fn headings(scene: &str) -> Vec<String> {
        let records = records(scene);
        let mut headings: Vec<String> = records
            .iter()
            .filter_map(|record| match record {
                Record::Narration { observation, .. } => Some(heading(observation)),
                _ => None,
            })
            .collect();
        headings.dedup();
        headings
    }

    fn heading(observation: &Observation) -> String {
        let text = crate::text::narration(observation);
        text.lines().next().unwrap_or_default().to_owned()
    }

    const GROWING: &str = "## A vibration is growing";
    const SETTLES: &str = "## The vibration settles";
    const TONE: &str = "## Looks like one tone with harmonics";
    const TWO_TONES: &str = "## Looks like two tones";
    const PARTED: &str = "## The perturbed trajectory has separated";
    const CHAOS: &str = "## Lyapunov exponents: chaos";
    const BROAD: &str = "## Spectral lines over a broadband floor";

    #[test]
    fn every_scene_has_its_appearance() {
        assert_eq!(headings("printed-friction"), ["## Silent"]);
        assert_eq!(headings("periodic-2deg"), [GROWING, SETTLES, TONE]);
        assert_eq!(headings("mode-shift-3.5deg"), [GROWING, SETTLES, TONE]);
        assert_eq!(
            headings("doubled-torus-3deg"),
            [GROWING, SETTLES, TWO_TONES]
        );
        let mut seen = headings("chaos-5deg");
        let before = seen.len();
        seen.retain(|heading| heading != PARTED);
        // Whether the trajectories separate before the exponents are decided depends on the last bit.
        assert!(before - seen.len() <= 1, "{before}");
        seen.dedup();
        assert_eq!(seen, [GROWING, SETTLES, BROAD, CHAOS]);
    }

    #[test]
    fn the_tilt_ramp_passes_three_appearances_once_each() {
        let expected = [GROWING, SETTLES, TONE, TWO_TONES, BROAD];
        assert_eq!(headings("tilt-ramp"), expected);
    }
}
