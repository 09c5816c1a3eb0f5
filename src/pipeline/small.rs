//! The simulation of a small system: from a scene to frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::computed;
use super::message::{DisplayRates, Frame, Header, SmallInfo, StatusInfo, StatusKind, Subject};
use super::prepare::{boxed, kick, small_probe};
use super::sensitivity::{Reached, SensitivityTracker, with_tangents};
use super::source::{ControllableSource, header, record_change};
use super::{PipelineError, Prepared, Source, prepare};
use crate::dynamics::DynamicsError;
use crate::scene::{AnalysisSpec, Control, Parameter, Scene, SceneError, SmallSystem, SystemSpec};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// Upper limit of frequency axes as a multiple of the largest natural or driving frequency: discontinuities
/// have many harmonics.
const HARMONICS: f64 = 8.0;

/// A running simulation of a small system. It stops at every event and reports the discrete state at each
/// sample.
pub struct SmallSimulation {
    scene: Scene,
    info: SmallInfo,
    prepared: Prepared,
    /// Lyapunov exponents and perturbed trajectory, if the scene requests them.
    sensitivity: SensitivityTracker,
    /// Index of the next sample, counted from the start of the run.
    next_sample: u64,
    frames: u64,
    /// Number of events up to the end of the last frame.
    crossings: u64,
    busy_seconds: f64,
    /// Numbers that commands can change in an interactive run; `None` if the run ends at the planned time.
    controls: Option<Vec<Control>>,
    /// Display rates of a live run.
    shown: Option<DisplayRates>,
    /// Numbers that commands have changed.
    changed: Arc<Vec<(Parameter, f64)>>,
}

impl SmallSimulation {
    /// Builds the system of a scene and starts its integrator.
    ///
    /// # Errors
    /// If the subject of the scene is a joint, or the integrator cannot start.
    pub fn new(scene: &Scene) -> Result<Self, PipelineError> {
        let SystemSpec::Small(small) = &scene.subject else {
            return Err(SceneError::NoSmallSystem {
                scene: scene.name.clone(),
            }
            .into());
        };
        let mut prepared = prepare(scene)?;
        let Prepared {
            system,
            integrator,
            state,
            ..
        } = &mut prepared;
        *integrator = with_tangents(scene, system.as_ref(), integrator.clone())?;
        integrator.start(system.as_ref(), 0.0, state)?;
        Ok(Self {
            sensitivity: SensitivityTracker::new(scene),
            scene: scene.clone(),
            info: info(small, scene.sample_rate),
            prepared,
            next_sample: 0,
            frames: 0,
            crossings: 0,
            busy_seconds: 0.0,
            controls: None,
            shown: None,
            changed: Arc::default(),
        })
    }
}

impl Source for SmallSimulation {
    fn header(&self, command: &str) -> Header {
        let subject = Subject::Small(self.info.clone());
        let computed = computed::for_small(&self.scene);
        Header {
            endless: self.controls.is_some(),
            controls: self.controls.clone().unwrap_or_default(),
            ..header(&self.scene, command, subject, computed)
        }
    }

    fn analysis(&self) -> &AnalysisSpec {
        &self.scene.analysis
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.prepared.integrator.set_stop_flag(Arc::clone(stop));
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        if self.is_finished() {
            return Ok(None);
        }
        let left = match self.controls {
            Some(_) => u64::MAX,
            None => self.scene.samples() - self.next_sample,
        };
        let began = Instant::now();
        let rate = self.scene.sample_rate;
        let count = left.min(self.scene.frame_samples as u64);
        let Prepared {
            system,
            probe,
            integrator,
            state: z,
        } = &mut self.prepared;
        let modes = system.modes();
        // Displacement and velocity of the observed mass.
        let observe = |z: &[f64]| {
            let row = |part: &[f64]| probe.iter().zip(part).map(|(p, x)| p * x).sum::<f64>();
            [row(&z[..modes]), row(&z[modes..])]
        };
        let mut frame = Frame {
            index: self.frames,
            t0: self.next_sample as f64 / rate,
            dt: 1.0 / rate,
            modes,
            shown: self.shown,
            changed: Arc::clone(&self.changed),
            ..Frame::default()
        };
        for index in self.next_sample..self.next_sample + count {
            let time = index as f64 / rate;
            match integrator.sample(system.as_ref(), time, z) {
                Err(DynamicsError::Stopped { .. }) => break,
                other => other?,
            }
            frame.q.extend_from_slice(&z[..modes]);
            frame.qdot.extend_from_slice(&z[modes..]);
            let [displacement, velocity] = observe(z);
            frame.displacement.push(displacement);
            frame.velocity.push(velocity);
            // Of a stopped run, without the events after its last sample.
            frame.transitions = integrator.stats().crossings - self.crossings;
            // Discrete state during the step that contains the sample.
            frame.status.extend(integrator.status());
            let reached = Reached { index, time, z };
            self.sensitivity
                .follow(system.as_ref(), integrator, reached, observe, &mut frame)?;
        }
        // A stopped run yields fewer samples than planned.
        if frame.is_empty() {
            return Ok(None);
        }
        if self.shown.is_some() {
            frame.state.clone_from(z);
        }
        frame.stats = integrator.stats();
        frame.error = integrator.take_error_estimate();
        self.crossings += frame.transitions;
        self.next_sample += frame.len() as u64;
        self.frames += 1;
        self.busy_seconds += began.elapsed().as_secs_f64();
        frame.busy_seconds = self.busy_seconds;
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.controls.is_none() && self.next_sample >= self.scene.samples()
    }
}

impl ControllableSource for SmallSimulation {
    fn run_until_stopped(&mut self) {
        self.controls = Some(self.scene.live_controls());
    }

    fn seek(&mut self, time: f64) -> Result<(), PipelineError> {
        self.next_sample = (time * self.scene.sample_rate).round() as u64;
        let state = self.prepared.state.clone();
        self.set_state(&state)
    }

    fn set_state(&mut self, values: &[f64]) -> Result<(), PipelineError> {
        let time = self.time();
        let Prepared {
            system, integrator, ..
        } = &mut self.prepared;
        Ok(integrator.start(system.as_ref(), time, values)?)
    }

    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), PipelineError> {
        let time = self.time();
        self.scene.set(parameter, value)?;
        let SystemSpec::Small(small) = &self.scene.subject else {
            return Ok(());
        };
        let Prepared {
            system,
            probe,
            integrator,
            ..
        } = &mut self.prepared;
        integrator.integrate_to(system.as_ref(), time)?;
        (*system, *probe) = (boxed(small), small_probe(small));
        if let SmallSystem::ImpactOscillator(oscillator) = small {
            // A wall that moves takes a mass that it reaches along.
            let position = integrator.state()[0];
            integrator.translate(&[(oscillator.wall - position).max(0.0)])?;
        }
        integrator.restart(system.as_ref())?;
        self.sensitivity.parameters_changed(time);
        record_change(&mut self.changed, parameter, value);
        Ok(())
    }

    fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError> {
        let time = self.time();
        let Prepared {
            system, integrator, ..
        } = &mut self.prepared;
        integrator.integrate_to(system.as_ref(), time)?;
        let mut z = integrator.state().to_vec();
        let modes = system.modes();
        kick(&mut z[modes..2 * modes], size, seed);
        integrator.start(system.as_ref(), time, &z)?;
        Ok(())
    }

    fn set_frame_length(&mut self, samples: usize, shown: DisplayRates) {
        self.shown = Some(shown);
        self.scene.frame_samples = samples;
    }

    fn time(&self) -> f64 {
        self.next_sample as f64 / self.scene.sample_rate
    }
}

/// Description of a small system sampled at `rate` (Hz).
fn info(small: &SmallSystem, rate: f64) -> SmallInfo {
    let (omegas, statuses, transition) = match small {
        SmallSystem::ImpactOscillator(system) => (
            vec![system.omega, system.drive_omega],
            names([
                (ImpactOscillator::FLYING, "flying", StatusKind::Free),
                (
                    ImpactOscillator::RESTING,
                    "resting on the wall",
                    StatusKind::Held,
                ),
            ]),
            "impacts",
        ),
        SmallSystem::MassOnBelt(system) => (
            vec![system.omega],
            names([
                (MassOnBelt::SLOWER, "slower than the belt", StatusKind::Free),
                (MassOnBelt::STICKING, "sticks", StatusKind::Held),
                (
                    MassOnBelt::FASTER,
                    "faster than the belt",
                    StatusKind::Other,
                ),
            ]),
            "changes between sticking and sliding",
        ),
        SmallSystem::TwoModesOnBelt(system) => (
            system.omega.to_vec(),
            names([
                (TwoModesOnBelt::TOUCHING, "in contact", StatusKind::Held),
                (TwoModesOnBelt::SEPARATED, "separated", StatusKind::Free),
            ]),
            "contacts and separations",
        ),
        SmallSystem::DampedContact(system) => (
            vec![
                system.omega,
                system.drive_omega,
                system.contact_stiffness.sqrt(),
            ],
            names([
                (DampedContact::FREE, "separated", StatusKind::Free),
                (DampedContact::TOUCHING, "in contact", StatusKind::Held),
            ]),
            "contacts and separations",
        ),
    };
    let highest = omegas.iter().copied().fold(0.0, f64::max) / std::f64::consts::TAU;
    SmallInfo {
        words: small.description().to_owned(),
        frequency_hz: omegas[0] / std::f64::consts::TAU,
        highest_frequency: (HARMONICS * highest).min(0.5 * rate),
        statuses,
        transition: transition.to_owned(),
    }
}

/// The statuses in the order of their numbers.
fn names<const N: usize>(statuses: [(u8, &str, StatusKind); N]) -> Vec<StatusInfo> {
    let mut statuses = statuses.to_vec();
    statuses.sort_by_key(|(number, ..)| *number);
    let info = |(_, label, kind): (u8, &str, StatusKind)| StatusInfo {
        label: label.to_owned(),
        kind,
    };
    statuses.into_iter().map(info).collect()
}
