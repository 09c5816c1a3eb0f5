//! The records of a run of a scene, and what they say.

use std::sync::Arc;

use squeakscope::pipeline::lesson::{Fact, FactValue};
use squeakscope::pipeline::message::{
    DisplayRates, Header, Lesson, LevelSample, Measurements, MechanismPrediction, PatchSnapshot,
    Record, SpectralLine,
};
use squeakscope::pipeline::{Analyser, Monitor, Simulation, Source as _, run};
use squeakscope::scene::{AnalysisSpec, Scene};
use squeakscope::text::{lesson, narration};

/// The records of a run.
pub struct Run {
    pub header: Arc<Header>,
    pub records: Vec<Record>,
    /// The lessons as text with their times, s.
    pub lessons: Vec<(f64, String)>,
}

/// A scene with only the analyses that lessons and commentary use.
fn reduced(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.analysis = AnalysisSpec {
        spectrum: scene.analysis.spectrum,
        regime: scene.analysis.regime,
        exponents: scene.analysis.exponents,
        perturbed_trajectory: scene.analysis.perturbed_trajectory,
        ..AnalysisSpec::default()
    };
    scene
}

impl Run {
    pub fn of(scene: &Scene) -> Self {
        let mut records: Vec<Record> = Vec::new();
        run(&reduced(scene), "", &mut records, Monitor::default()).expect("runs");
        Self::from_records(records)
    }

    /// A run in the frames of a playback speed (simulated seconds per second), without waiting.
    pub fn at_speed(scene: &Scene, speed: f64) -> Self {
        let mut source = Simulation::new(&reduced(scene)).expect("valid");
        let header = source.header("");
        let (samples, shown) = DisplayRates::at_speed(speed, header.sample_rate);
        source.set_frame_length(samples, shown);
        let mut analyser = Analyser::new(&header.analysis, &header);
        let mut records = vec![Record::Header(Arc::new(header))];
        while let Some(frame) = source.next_frame().expect("runs") {
            let frame = Arc::new(frame);
            analyser.push(&frame, &mut records).expect("analysed");
        }
        analyser.finish(&mut records).expect("analysed");
        Self::from_records(records)
    }

    fn from_records(records: Vec<Record>) -> Self {
        let Some(Record::Header(header)) = records.first() else {
            panic!("the first record is the header");
        };
        let lessons = records.iter().filter_map(|record| match record {
            Record::Lesson(now) => Some((now.time, lesson(now))),
            _ => None,
        });
        let mut lessons: Vec<_> = lessons.collect();
        lessons.dedup_by(|(_, later), (_, text)| later == text);
        Self {
            header: Arc::clone(header),
            lessons,
            records,
        }
    }

    pub fn named(name: &str) -> Self {
        Self::of(&Scene::load(name).expect("preset"))
    }

    /// A preset with one line replaced.
    pub fn with(name: &str, from: &str, to: &str) -> Self {
        Self::of(&changed(name, from, to))
    }

    pub fn computed(&self) -> &MechanismPrediction {
        self.header.computed.as_deref().expect("a mechanism")
    }

    pub fn lessons(&self) -> Vec<(f64, &str)> {
        let lessons = self.lessons.iter();
        lessons.map(|(time, text)| (*time, text.as_str())).collect()
    }

    /// The lesson after the last sample, or before the first one.
    fn lesson_record(&self, is_last: bool) -> &Lesson {
        let mut lessons = self.records.iter().filter_map(|record| match record {
            Record::Lesson(lesson) => Some(&**lesson),
            _ => None,
        });
        let found = if is_last {
            lessons.next_back()
        } else {
            lessons.next()
        };
        found.expect("a lesson")
    }

    /// The measurements of the last lesson.
    pub fn measured(&self) -> &Measurements {
        &self.lesson_record(true).measured
    }

    /// The facts of the first lesson.
    pub fn first_facts(&self) -> Vec<Fact> {
        self.lesson_record(false).facts()
    }

    /// The facts of the last lesson.
    pub fn facts(&self) -> Vec<Fact> {
        self.lesson_record(true).facts()
    }

    /// A fact of the last lesson.
    pub fn fact(&self, name: &str) -> Fact {
        let mut facts = self.facts().into_iter();
        let found = facts.find(|fact| fact.name == name);
        found.unwrap_or_else(|| panic!("no fact `{name}` in\n{}", self.last_lesson()))
    }

    /// Asserts that what the last lesson says of its mechanism is observed.
    #[track_caller]
    pub fn assert_confirmed(&self, name: &str, text: &str) {
        let fact = self.fact(name);
        assert_eq!(fact.measured, Some(text.into()), "{fact:?}");
        assert_eq!(fact.agrees, Some(true), "{fact:?}");
    }

    pub fn last_lesson(&self) -> &str {
        &self.lessons.last().expect("a lesson").1
    }

    /// The measured text of a fact, or the predicted one.
    pub fn text(&self, name: &str) -> String {
        let fact = self.fact(name);
        match fact.measured.or(fact.predicted) {
            Some(FactValue::Text(text)) => text,
            other => panic!("`{name}` is {other:?}"),
        }
    }

    /// The measured number of a fact.
    pub fn number(&self, name: &str) -> f64 {
        match self.fact(name).measured {
            Some(FactValue::Number(number)) => number,
            other => panic!("`{name}` is {other:?}"),
        }
    }

    /// Samples of the velocity, m/s.
    pub fn velocity(&self) -> Vec<f64> {
        let frames = self.records.iter().filter_map(|record| match record {
            Record::Samples(frame) => Some(&frame.velocity),
            _ => None,
        });
        frames.flatten().copied().collect()
    }

    /// The commentary as text, with its times, s.
    pub fn narrations(&self) -> Vec<(f64, String)> {
        let narrations = self.records.iter().filter_map(|record| match record {
            Record::Narration { time, observation } => Some((*time, narration(observation))),
            _ => None,
        });
        narrations.collect()
    }

    /// The types of motion with their times, s, and confidences.
    pub fn regimes(&self) -> Vec<(f64, String)> {
        let regimes = self.records.iter().filter_map(|record| match record {
            Record::Regime { time, verdict, .. } => {
                Some((*time, format!("{} {}", verdict.regime, verdict.confidence)))
            }
            _ => None,
        });
        regimes.collect()
    }

    pub fn courses(&self) -> Vec<LevelSample> {
        let courses = self.records.iter().filter_map(|record| match record {
            Record::LevelSample(course) => Some(*course),
            _ => None,
        });
        courses.collect()
    }

    pub fn snapshots(&self) -> Vec<PatchSnapshot> {
        let frames = self.records.iter().filter_map(|record| match record {
            Record::Samples(frame) => Some(frame.patch.clone()),
            _ => None,
        });
        frames.flatten().collect()
    }

    pub fn peaks(&self) -> &[SpectralLine] {
        let peaks = self.records.iter().rev().find_map(|record| match record {
            Record::Spectrum { peaks, .. } => Some(peaks),
            _ => None,
        });
        peaks.expect("a spectrum")
    }

    /// Frequency of the strongest line at the end, Hz.
    pub fn dominant_hz(&self) -> f64 {
        self.peaks()[0].frequency
    }

    /// Growth rate (1/s) of the root mean square between the two halves of an interval (s).
    pub fn growth(&self, [from, to]: [f64; 2]) -> f64 {
        let rate = self.header.sample_rate;
        let part = &self.velocity()[(from * rate) as usize..(to * rate) as usize];
        let (first, second) = part.split_at(part.len() / 2);
        let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        (power(second) / power(first)).ln() / (to - from)
    }
}

pub fn changed(name: &str, from: &str, to: &str) -> Scene {
    let text = Scene::load(name).expect("preset").text;
    assert!(text.contains(from), "{name} has no `{from}`");
    Scene::parse(&format!("{name}.toml"), text.replacen(from, to, 1)).expect("valid")
}

pub fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(
        error < tolerance,
        "{found} differs from {expected} by more than {tolerance}"
    );
}
