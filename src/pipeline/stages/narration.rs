//! The words on what is being seen, as samples arrive.

use super::narrator::{Circumstances, Heard, Narrator};
use super::{Context, Emit, Stage, samples};
use crate::analysis::{SlidingWindow, SpectrumAnalyser};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, JointInfo, Record};

/// Emits [`Record::Narration`] when there is something new to say.
///
/// The narrator listens through a window of its own, [`Narrator::MEMORY`] long, whatever the
/// window of the spectrum that is shown.
pub struct NarrationStage {
    /// Velocity and displacement, side by side.
    sliding: SlidingWindow<2>,
    narrator: Narrator,
    joint: Varying,
}

/// What is told of a joint besides its tilt, where it varies.
struct Varying {
    load: bool,
    rotation: bool,
    /// Slip speed in steady sliding where the factor on the rotation is 1, m/s.
    sliding_speed: f64,
}

impl Varying {
    fn now(&self, frame: &Frame) -> Circumstances {
        Circumstances {
            tilt: frame.tilt,
            load: self.load.then_some(frame.load),
            rotation_factor: self.rotation.then_some(frame.rotation_factor),
            sliding_speed: match self.rotation {
                true => self.sliding_speed * frame.rotation_factor,
                false => self.sliding_speed,
            },
        }
    }
}

impl NarrationStage {
    /// Listens `every` so many seconds to samples of `joint` at `rate` (Hz).
    pub fn new(every: f64, rate: f64, joint: &JointInfo) -> Self {
        let count = |seconds| samples(seconds, rate, SpectrumAnalyser::FEWEST_SAMPLES);
        Self {
            sliding: SlidingWindow::new(count(Narrator::MEMORY), every * rate)
                .starting_with(count(Narrator::FIRST)),
            narrator: Narrator::new(rate),
            joint: Varying {
                load: joint.load_varies(),
                rotation: joint.rotation_varies(),
                sliding_speed: joint.sliding_speed,
            },
        }
    }
}

impl Stage for NarrationStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            narrator,
            joint,
        } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.velocity, &frame.displacement], |view| {
            let [velocity, displacement] = view.channels;
            let time = context.time(view.seen as f64 - 1.0);
            let said = narrator.listen(&Heard {
                time,
                now: joint.now(frame),
                velocity,
                displacement,
            })?;
            match said {
                Some(text) => emit(Record::Narration { time, text }),
                None => Ok(()),
            }
        })
    }
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
                Record::Narration { text, .. } => text.lines().next().map(str::to_owned),
                _ => None,
            })
            .collect();
        headings.dedup();
        headings
    }

    const GROWING: &str = "## A vibration is growing";
    const SETTLES: &str = "## The vibration settles";
    const TONE: &str = "## Looks like a pure tone";
    const TWO_TONES: &str = "## Looks like two tones";
    const PARTED: &str = "## The butterfly has beaten its wings";
    const CHAOS: &str = "## By its exponents: chaos";
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
