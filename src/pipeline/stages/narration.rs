//! What the run shows now, as samples arrive.

use std::borrow::Cow;

use super::clock::samples;
use super::narrator::{Heard, Narrator};
use super::stage::Stage;
use super::windowed::{Channels, Windowed};
use crate::analysis::{SlidingWindow, SpectrumAnalyser};
use crate::pipeline::message::{Circumstances, Frame, JointInfo, Observation, Record};

/// Emits [`Record::Narration`] when the samples of `joint` at `rate` (Hz) show something new; looks `every`
/// so many seconds.
///
/// The narrator has a window of its own, [`Narrator::MEMORY`] long, whatever the window of the spectrum
/// that is shown.
pub fn narration(every: f64, rate: f64, joint: &JointInfo) -> impl Stage + use<> {
    let count = |seconds| samples(seconds, rate, SpectrumAnalyser::FEWEST_SAMPLES);
    let sliding = SlidingWindow::new(count(Narrator::MEMORY), every * rate)
        .starting_with(count(Narrator::FIRST));
    let mut narrator = Narrator::new(rate);
    let (load_varies, rotation_varies) = (joint.load_varies(), joint.rotation_varies());
    let sliding_speed = joint.sliding_speed;
    let now = move |frame: &Frame| {
        let rotation_factor = rotation_varies.then_some(frame.rotation_factor);
        Circumstances {
            tilt: frame.tilt,
            load: load_varies.then_some(frame.load),
            rotation_factor,
            sliding_speed: sliding_speed * rotation_factor.unwrap_or(1.0),
        }
    };
    Windowed::new(
        sliding,
        velocity_and_displacement,
        move |window, _, emit| {
            let [velocity, displacement] = window.channels;
            let time = window.time;
            let seen = narrator.listen(&Heard {
                time,
                now: now(window.frame),
                velocity,
                displacement,
            })?;
            match seen.map(|vibration| Observation::Vibration(Box::new(vibration))) {
                Some(observation) => emit(Record::Narration { time, observation }),
                None => Ok(()),
            }
        },
    )
}

fn velocity_and_displacement(frame: &Frame) -> Channels<'_, 2> {
    [&frame.velocity, &frame.displacement].map(|signal| Cow::Borrowed(&signal[..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Monitor, run};
    use crate::scene::Scene;

    /// What is said of a scene that comes with the program: its headings, repetitions left out.
    fn headings(scene: &str) -> Vec<String> {
        let mut records: Vec<Record> = Vec::new();
        let scene = Scene::load(scene).unwrap();
        run(&scene, "", &mut records, Monitor::default()).unwrap();
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
    const TONE: &str = "## Looks like a pure tone";
    const TWO_TONES: &str = "## Looks like two tones";
    const PARTED: &str = "## The perturbed trajectory has separated";
    const CHAOS: &str = "## Lyapunov exponents: chaos";
    const BROAD: &str = "## Lines over a broad floor: looks like chaos";

    #[test]
    fn every_scene_is_told_as_what_it_is() {
        assert_eq!(headings("printed-friction"), ["## Silent"]);
        assert_eq!(headings("periodic-2deg"), [GROWING, SETTLES, TONE]);
        assert_eq!(headings("mode-shift-3.5deg"), [GROWING, SETTLES, TONE]);
        assert_eq!(headings("torus-3deg"), [GROWING, SETTLES, TWO_TONES]);
        let mut told = headings("chaos-5deg");
        let before = told.len();
        told.retain(|heading| heading != PARTED);
        // Whether the copies have parted before the exponents are sure hangs on the last bit.
        assert!(before - told.len() <= 1, "{before}");
        told.dedup();
        assert_eq!(told, [GROWING, SETTLES, BROAD, CHAOS]);
    }

    #[test]
    fn the_ramp_shows_its_three_faces_once_each() {
        let expected = [GROWING, SETTLES, TONE, TWO_TONES, BROAD];
        assert_eq!(headings("tilt-ramp"), expected);
    }
}
