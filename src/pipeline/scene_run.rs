//! What the simulations of joints and of small systems share: the scene, its samples and the commands so far.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::message::{DisplayRates, Frame, Header, MechanismPrediction, Subject};
use super::source::{kinds, section_coordinates};
use crate::scene::{Control, Parameter, Scene, SystemSpec};

/// A simulated run of a scene.
#[derive(Debug)]
pub(super) struct SceneRun {
    /// The scene, with the numbers that commands have changed.
    pub scene: Scene,
    /// Index of the next sample, counted from the start of the run.
    pub next_sample: u64,
    /// Whether the run continues after the planned time.
    pub is_endless: bool,
    /// Display rates of a live run.
    pub shown: Option<DisplayRates>,
    frames: u64,
    busy_seconds: f64,
    /// Numbers that commands can change, computed for the first header.
    controls: OnceLock<Vec<Control>>,
    /// Numbers that commands have changed.
    changed: Arc<Vec<(Parameter, f64)>>,
}

impl SceneRun {
    pub fn new(scene: &Scene) -> Self {
        Self {
            scene: scene.clone(),
            next_sample: 0,
            is_endless: false,
            shown: None,
            frames: 0,
            busy_seconds: 0.0,
            controls: OnceLock::new(),
            changed: Arc::default(),
        }
    }

    /// Time of the next sample, s.
    pub fn time(&self) -> f64 {
        self.next_sample as f64 / self.scene.sample_rate
    }

    /// Moves the next sample to a time, s.
    pub fn seek(&mut self, time: f64) {
        self.next_sample = (time * self.scene.sample_rate).round() as u64;
    }

    /// Number of samples up to the end of the run, in frames of the present length.
    pub fn samples_left(&self) -> u64 {
        if self.is_endless {
            u64::MAX
        } else {
            self.scene.samples().saturating_sub(self.next_sample)
        }
    }

    /// The header of the run. `command` is the command line, `computed` the linear prediction for the scene's
    /// mechanism.
    pub fn header(
        &self,
        command: &str,
        subject: Subject,
        computed: Option<Arc<MechanismPrediction>>,
    ) -> Header {
        let scene = &self.scene;
        let controls = self.is_endless.then(|| {
            let controls = self.controls.get_or_init(|| scene.live_controls());
            controls.clone()
        });
        let mut header = Header {
            scene: scene.name.clone(),
            title: scene.title.clone(),
            about: scene.about.clone(),
            scene_text: scene.text.clone(),
            command: command.to_owned(),
            sample_rate: scene.sample_rate,
            duration: scene.duration,
            endless: self.is_endless,
            controls: controls.unwrap_or_default(),
            analyses: kinds(&scene.analysis),
            section: section_coordinates(&scene.analysis),
            rest_speed: rest_speed(scene, &subject),
            subject,
            computed,
        };
        let slider = header.tilt_slider();
        if let (Subject::Joint(joint), Some(range)) = (&mut header.subject, slider) {
            let [low, high] = range.map(f64::to_radians);
            joint.tilt_range = Some([joint.min_tilt.min(low), joint.max_tilt.max(high)]);
        }
        header
    }

    /// An empty frame that starts with the next sample.
    pub fn begin_frame(&self, modes: usize) -> Frame {
        Frame {
            index: self.frames,
            t0: self.time(),
            dt: 1.0 / self.scene.sample_rate,
            modes,
            shown: self.shown,
            changed: Arc::clone(&self.changed),
            ..Frame::default()
        }
    }

    /// Moves past a frame whose computation began at an instant.
    pub fn end_frame(&mut self, frame: &mut Frame, began: Instant) {
        self.next_sample += frame.len() as u64;
        self.frames += 1;
        self.busy_seconds += began.elapsed().as_secs_f64();
        frame.busy_seconds = self.busy_seconds;
    }

    /// Notes the present value of a number that a command has changed.
    pub fn record_change(&mut self, parameter: Parameter, value: f64) {
        let changed = Arc::make_mut(&mut self.changed);
        changed.retain(|(known, _)| *known != parameter);
        changed.push((parameter, value));
    }

    pub fn set_frame_length(&mut self, samples: usize, shown: DisplayRates) {
        self.shown = Some(shown);
        self.scene.frame_samples = samples;
    }
}

/// Ratio of peak velocity to sliding speed below which a vibration is at rest if the scene gives no limit.
const REST: f64 = 1e-6;

/// Peak velocity below which a vibration is at rest, m/s.
fn rest_speed(scene: &Scene, subject: &Subject) -> f64 {
    let given = scene.analysis.spectrum.and_then(|spectrum| spectrum.rest);
    let sliding_speed = || match (subject, &scene.subject) {
        (Subject::Joint(joint), _) => joint.largest_sliding_speed(),
        (_, SystemSpec::Small(system)) => system.belt_speed().unwrap_or(0.0),
        _ => 0.0,
    };
    given.unwrap_or_else(|| REST * sliding_speed())
}
