//! The simulation of a scene: from its start to frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::endpoints::Source;
use super::interactive::RunState;
use super::joint_body::JointBody;
use super::lesson;
use super::message::{DisplayRates, Frame, Header, MechanismPrediction, SmallInfo, Subject};
use super::prepare::{boxed, kick, small_integrator, small_probe};
use super::sensitivity::{SensitivityTracker, with_tangents};
use super::{PipelineError, small_body};
use crate::dynamics::{DynamicsError, Integrator, System};
use crate::joint::Loading;
use crate::scene::{Parameter, Scene, SystemSpec};

/// A running simulation of a scene. Its numbers can be changed on the way.
pub struct Simulation {
    /// The scene, with the numbers that commands have changed.
    scene: Scene,
    body: Body,
    motion: Motion,
    /// Linear prediction for the scene's mechanism.
    computed: Option<Arc<MechanismPrediction>>,
    /// Index of the next sample, counted from the start of the run.
    next_sample: u64,
    /// Whether the run continues after the planned time.
    is_endless: bool,
    /// Display rates of a live run.
    shown: Option<DisplayRates>,
    frames: u64,
    busy_seconds: f64,
    /// Numbers that commands have changed.
    changed: Arc<Vec<(Parameter, f64)>>,
}

/// What moves: a joint, or a small system. The small system itself is in the scene; this is its description at the start.
enum Body {
    Joint(Box<JointBody>),
    Small(SmallInfo),
}

/// The motion of a body.
pub(super) struct Motion {
    /// The integrator, which is at the last sample or slightly past it.
    pub integrator: Integrator<'static>,
    /// State at the last sample.
    pub z: Vec<f64>,
    /// Row that maps modal coordinates to the displacement of the probe.
    pub probe: Vec<f64>,
    /// Number of events of a small system up to the last sample.
    crossings: u64,
    /// Lyapunov exponents and perturbed trajectory, if the scene requests them.
    pub sensitivity: SensitivityTracker,
}

/// Displacement (m) and velocity (m/s) of a probe at a state.
pub(super) fn observe(probe: &[f64], z: &[f64]) -> [f64; 2] {
    let (q, rest) = z.split_at(probe.len());
    [q, rest].map(|part| probe.iter().zip(part).map(|(p, x)| p * x).sum())
}

impl Simulation {
    /// Assembles the system of a scene, the joint under the initial tilt, load and rotation, and applies the initial kick.
    ///
    /// # Errors
    /// If the joint cannot be assembled, or the integrator does not fit the system or cannot start.
    pub fn new(scene: &Scene) -> Result<Self, PipelineError> {
        let (body, probe, (integrator, z), computed) = match &scene.subject {
            SystemSpec::Joint(tilted) => {
                let (body, unstarted) = JointBody::new(scene, tilted)?;
                let computed = lesson::for_joint(scene, tilted, &body.ball, &body.joint)?;
                let probe = body.joint.probe().to_vec();
                (Body::Joint(Box::new(body)), probe, unstarted, computed)
            }
            SystemSpec::Small(small) => {
                let body = Body::Small(small_body::info(small, scene.sample_rate));
                let unstarted = small_integrator(scene, small)?;
                let computed = lesson::for_small(scene, small);
                (body, small_probe(small), unstarted, computed)
            }
        };
        let mut integrator = with_tangents(scene, integrator)?;
        integrator.start(0.0, &z)?;
        Ok(Self {
            body,
            motion: Motion {
                integrator,
                z,
                probe,
                crossings: 0,
                sensitivity: SensitivityTracker::new(scene),
            },
            computed,
            scene: scene.clone(),
            next_sample: 0,
            is_endless: false,
            shown: None,
            frames: 0,
            busy_seconds: 0.0,
            changed: Arc::default(),
        })
    }

    /// The system under the present numbers.
    pub fn system(&self) -> &dyn System {
        self.motion.integrator.system()
    }

    /// The integrator, which is at the last sample or slightly past it.
    pub fn integrator(&self) -> &Integrator<'static> {
        &self.motion.integrator
    }

    /// Present tilt, load and rotation; `None` for a small system.
    pub fn loading(&self) -> Option<Loading> {
        match &self.body {
            Body::Joint(body) => Some(body.now),
            Body::Small(_) => None,
        }
    }

    /// The integrator, to continue the integration without the pipeline.
    pub fn into_integrator(self) -> Integrator<'static> {
        self.motion.integrator
    }

    /// Advances tilt, load and rotation to a sample, which is the next one, or, after the last frame, to the end of the run:
    /// a frame has the loading of its start.
    ///
    /// # Errors
    /// If the joint cannot be assembled under this loading, or the integrator cannot restart.
    pub fn advance_loading(&mut self, sample: Option<u64>) -> Result<(), PipelineError> {
        let time = self.time();
        match &mut self.body {
            Body::Joint(body) => body.advance(sample, time, &mut self.motion),
            Body::Small(_) => Ok(()),
        }
    }

    /// Lets the run continue after the planned time.
    pub fn run_until_stopped(&mut self) {
        self.is_endless = true;
    }

    /// Time of the next sample, s.
    pub fn time(&self) -> f64 {
        self.next_sample as f64 / self.scene.sample_rate
    }

    /// The scene, with the numbers that commands have changed.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Sets the time of the first sample, s, at which the schedules of the scene continue. [`Self::set_state`] follows.
    ///
    /// # Errors
    /// If the loading of this time is not possible.
    pub fn seek(&mut self, time: f64) -> Result<(), PipelineError> {
        let rate = self.scene.sample_rate;
        self.next_sample = (time * rate).round() as u64;
        let now = self.time();
        match &mut self.body {
            Body::Joint(body) => body.seek(self.next_sample, [now, rate], &mut self.motion),
            Body::Small(_) => Ok(self.motion.integrator.start(now, &self.motion.z)?),
        }
    }

    /// Sets the state at the next sample, relative to the steady sliding under the present numbers; its time is not used.
    ///
    /// # Errors
    /// If their number is wrong, or the integrator cannot start.
    pub fn set_state(&mut self, state: &RunState) -> Result<(), PipelineError> {
        let mut z = state.values.clone();
        z.resize(z.len() + self.system().quadratures(), 0.0);
        if let SystemSpec::Small(small) = &mut self.scene.subject {
            if let Some((_, phase)) = small.drive() {
                *phase = state.drive_phase;
            }
            self.motion.integrator.restart(boxed(small).into())?;
        }
        let time = self.time();
        self.motion.integrator.start(time, &z)?;
        if let Body::Joint(body) = &mut self.body {
            body.begin_at(&z);
        }
        Ok(())
    }

    /// Changes a number of the scene from the next sample on, in the unit of a scene file; see [`Scene::set`]. The
    /// motion continues from its present state. A tilt replaces the tilt schedule of the scene.
    ///
    /// # Errors
    /// If the scene does not permit the value, or the system cannot be assembled with it: the run continues unchanged.
    pub fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), PipelineError> {
        self.advance_loading(Some(self.next_sample))?;
        let time = self.time();
        let mut scene = self.scene.clone();
        scene.set(parameter, value)?;
        match (&mut self.body, &mut self.scene.subject, &mut scene.subject) {
            (Body::Joint(body), _, SystemSpec::Joint(tilted)) => {
                body.set(tilted.clone(), parameter, time, &mut self.motion)?;
            }
            (_, SystemSpec::Small(before), SystemSpec::Small(small)) => {
                small_body::set(before, small, time, &mut self.motion)?;
            }
            _ => {}
        }
        self.scene = scene;
        let changed = Arc::make_mut(&mut self.changed);
        changed.retain(|(known, _)| *known != parameter);
        changed.push((parameter, value));
        Ok(())
    }

    /// Adds a Gaussian random velocity of standard deviation `size` (sqrt(kg) m/s) to each mode at the next
    /// sample. Tangent vectors and the perturbed trajectory restart there.
    ///
    /// # Errors
    /// If the integrator cannot restart.
    pub fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError> {
        self.advance_loading(Some(self.next_sample))?;
        let time = self.time();
        let integrator = &mut self.motion.integrator;
        integrator.integrate_to(time)?;
        let mut z = integrator.state().to_vec();
        let modes = integrator.system().modes();
        kick(&mut z[modes..2 * modes], size, seed);
        if let Body::Joint(body) = &mut self.body {
            body.add_kick(integrator.state(), &z);
        }
        Ok(integrator.start(time, &z)?)
    }

    /// Sets the number of samples per frame and the display rates from the next frame on.
    pub fn set_frame_length(&mut self, samples: usize, shown: DisplayRates) {
        self.shown = Some(shown);
        self.scene.frame_samples = samples;
    }

    /// Number of samples up to the end of the run.
    fn samples_left(&self) -> u64 {
        if self.is_endless {
            u64::MAX
        } else {
            self.scene.samples().saturating_sub(self.next_sample)
        }
    }

    /// Number of samples of the next frame. A frame ends where the loading changes: all its samples belong to
    /// one joint, and the motion does not depend on the length of the frames.
    fn frame_length(&self) -> u64 {
        let count = self.samples_left().min(self.scene.frame_samples as u64);
        let Body::Joint(body) = &self.body else {
            return count;
        };
        let rate = self.scene.sample_rate;
        count.min(body.samples_until_change(self.next_sample, rate))
    }

    /// An empty frame that starts with the next sample.
    fn empty_frame(&self) -> Frame {
        let mut frame = Frame {
            index: self.frames,
            t0: self.time(),
            dt: 1.0 / self.scene.sample_rate,
            modes: self.system().modes(),
            shown: self.shown,
            changed: Arc::clone(&self.changed),
            ..Frame::default()
        };
        if let Body::Joint(body) = &self.body {
            body.begin_frame(&mut frame);
        }
        frame
    }

    /// A state from which a run can continue, at a sample at a time, s.
    fn state(&mut self, time_s: f64) -> RunState {
        RunState {
            time_s,
            values: self.motion.z[..self.system().tangent_dim()].to_vec(),
            drive_phase: match &mut self.scene.subject {
                SystemSpec::Small(small) => small.drive().map_or(0.0, |(_, phase)| *phase),
                SystemSpec::Joint(_) => 0.0,
            },
        }
    }
}

impl Source for Simulation {
    fn header(&self, command: &str) -> Header {
        let scene = &self.scene;
        let subject = match &self.body {
            Body::Joint(body) => Subject::Joint(body.info(scene)),
            Body::Small(info) => Subject::Small(info.clone()),
        };
        let controls = self.is_endless.then(|| scene.live_controls());
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
            analysis: scene.analysis.clone(),
            rest_speed: rest_speed(scene, &subject),
            subject,
            computed: self.computed.clone(),
        };
        let slider = header.tilt_slider();
        if let (Subject::Joint(joint), Some(range)) = (&mut header.subject, slider) {
            let [low, high] = range.map(f64::to_radians);
            joint.tilt_range = Some([joint.min_tilt.min(low), joint.max_tilt.max(high)]);
        }
        header
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.motion.integrator.set_stop_flag(Arc::clone(stop));
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        if self.is_finished() {
            return Ok(None);
        }
        let began = Instant::now();
        match self.advance_loading(Some(self.next_sample)) {
            Err(PipelineError::Dynamics(DynamicsError::Stopped(_))) => return Ok(None),
            other => other?,
        }
        let (first, count, rate) = (
            self.next_sample,
            self.frame_length(),
            self.scene.sample_rate,
        );
        let mut frame = self.empty_frame();
        let modes = frame.modes;
        let (body, motion) = (&mut self.body, &mut self.motion);
        for index in first..first + count {
            let time = index as f64 / rate;
            match motion.integrator.sample(time, &mut motion.z) {
                Err(DynamicsError::Stopped(_)) => break,
                other => other?,
            }
            let [displacement, velocity] = observe(&motion.probe, &motion.z);
            frame.q.extend_from_slice(&motion.z[..modes]);
            frame.qdot.extend_from_slice(&motion.z[modes..2 * modes]);
            frame.displacement.push(displacement);
            frame.velocity.push(velocity);
            match body {
                Body::Joint(body) => {
                    let is_shown = |_| DisplayRates::is_snapshot(index - first, count, rate);
                    body.sample((index, time), self.shown.map(is_shown), motion, &mut frame);
                }
                Body::Small(_) => {
                    let crossings = motion.integrator.stats().crossings;
                    frame.transitions += crossings - motion.crossings;
                    motion.crossings = crossings;
                    frame.status.extend(motion.integrator.status());
                }
            }
            motion.sensitivity.follow(
                &mut motion.integrator,
                (index, time),
                &motion.z,
                &motion.probe,
                &mut frame,
            )?;
        }
        // A stopped run yields fewer samples than planned.
        if frame.is_empty() {
            return Ok(None);
        }
        frame.state = self.shown.map(|_| self.state(frame.end() - frame.dt));
        frame.stats = self.motion.integrator.stats();
        frame.error = self.motion.integrator.take_error_estimate();
        self.next_sample += frame.len() as u64;
        self.frames += 1;
        self.busy_seconds += began.elapsed().as_secs_f64();
        frame.busy_seconds = self.busy_seconds;
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.samples_left() == 0
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

#[cfg(test)]
#[path = "simulate_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "carry_tests.rs"]
mod carry_tests;

#[cfg(test)]
#[path = "moving_patch_tests.rs"]
mod moving_patch_tests;
