//! Observations about the vibration, for the commentary of a run.

use std::borrow::Cow;

use super::appearance::AppearanceClassifier;
use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Channels, Windowed};
use crate::analysis::{sliding::SlidingWindow, tones::SpectrumAnalyser};
use crate::pipeline::message::{Frame, Header, JointInfo, Observation, OperatingPoint, Record};

/// Emits [`Record::Narration`] if the samples of `joint`, described by `header`, have a new appearance, checked
/// every `every` seconds.
///
/// The classifier has its own window of [`AppearanceClassifier::MEMORY`], independent of the window of the
/// displayed spectrum.
pub fn narration(every: f64, joint: &JointInfo, header: &Header) -> impl Stage + use<> {
    let rate = header.sample_rate;
    let count = |seconds| samples(seconds, rate, SpectrumAnalyser::MIN_SAMPLES);
    let sliding = SlidingWindow::new(count(AppearanceClassifier::MEMORY), every * rate)
        .with_min_length(count(AppearanceClassifier::FIRST));
    let mut classifier = AppearanceClassifier::new(rate, header.rest_speed);
    let (load_varies, rotation_varies) = (joint.load_varies(), joint.rotation_varies());
    let sliding_speed = joint.sliding_speed;
    let now = move |frame: &Frame| {
        let rotation_factor = rotation_varies.then_some(frame.rotation_factor);
        OperatingPoint {
            tilt: frame.tilt,
            load: load_varies.then_some(frame.load),
            rotation_factor,
            sliding_speed: sliding_speed * rotation_factor.map_or(1.0, f64::abs),
        }
    };
    let appearances = Windowed::new(
        sliding,
        velocity_and_displacement,
        move |window, context| {
            let seen = classifier.classify(&window, now(window.frame), context)?;
            Ok(seen.map(|vibration| Record::Narration {
                time: window.time,
                observation: Observation::Vibration(Box::new(vibration)),
            }))
        },
    );
    appearances.complete()
}

fn velocity_and_displacement(frame: &Frame) -> Channels<'_, 2> {
    [&frame.velocity, &frame.displacement].map(|signal| Cow::Borrowed(&signal[..]))
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
