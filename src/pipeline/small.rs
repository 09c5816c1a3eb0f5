//! The first station of a small system: from a scene to frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::along::{Along, Reached, with_tangents};
use super::computed;
use super::message::{Frame, Header, Shown, SmallInfo, StatusInfo, StatusKind, Subject};
use super::prepare::kick;
use super::source::{Steerable, header};
use super::{PipelineError, Prepared, Source, prepare};
use crate::dynamics::DynamicsError;
use crate::scene::{AnalysisSpec, Scene, SceneError, SmallSystem, SubjectSpec};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// Natural and driving frequencies shown in spectra, times this: jumps have many harmonics.
const HARMONICS: f64 = 8.0;

/// A running simulation of a small system. It stops at every event, and tells the status at each
/// sample.
pub struct SmallSimulation {
    scene: Scene,
    info: SmallInfo,
    prepared: Prepared,
    /// What the scene asks for besides.
    along: Along,
    /// Index of the next sample, from the start.
    next_sample: u64,
    frames: u64,
    /// Guards crossed until the last frame's end.
    crossings: u64,
    busy_seconds: f64,
    /// Whether the run goes on until it is ended.
    endless: bool,
    /// How much of it is to be drawn, if not all.
    shown: Option<Shown>,
}

impl SmallSimulation {
    /// Starts the system of a scene.
    ///
    /// # Errors
    /// If the scene runs a joint, or the integrator cannot start.
    pub fn new(scene: &Scene) -> Result<Self, PipelineError> {
        let SubjectSpec::Small(small) = &scene.subject else {
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
            along: Along::new(scene),
            scene: scene.clone(),
            info: info(small, scene.sample_rate),
            prepared,
            next_sample: 0,
            frames: 0,
            crossings: 0,
            busy_seconds: 0.0,
            endless: false,
            shown: None,
        })
    }
}

impl Source for SmallSimulation {
    fn header(&self, command: &str) -> Header {
        let subject = Subject::Small(self.info.clone());
        let computed = computed::of_small(&self.scene);
        Header {
            endless: self.endless,
            ..header(&self.scene, command, subject, computed)
        }
    }

    fn analysis(&self) -> &AnalysisSpec {
        &self.scene.analysis
    }

    fn heed(&mut self, stop: &Arc<AtomicBool>) {
        self.prepared.integrator.heed(Arc::clone(stop));
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        if self.is_over() {
            return Ok(None);
        }
        let left = match self.endless {
            true => u64::MAX,
            false => self.scene.samples() - self.next_sample,
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
        // Displacement and velocity of what is observed.
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
            // The status of the step that the sample lies in.
            frame.status.extend(integrator.status());
            let reached = Reached { index, time, z };
            self.along
                .follow(system.as_ref(), integrator, reached, observe, &mut frame)?;
        }
        // Fewer samples than planned where it was told to stop.
        if frame.is_empty() {
            return Ok(None);
        }
        frame.tally = integrator.tally();
        frame.error = integrator.take_error_estimate();
        frame.transitions = frame.tally.crossings - self.crossings;
        self.crossings = frame.tally.crossings;
        self.next_sample += frame.len() as u64;
        self.frames += 1;
        self.busy_seconds += began.elapsed().as_secs_f64();
        frame.busy_seconds = self.busy_seconds;
        Ok(Some(frame))
    }

    fn is_over(&self) -> bool {
        !self.endless && self.next_sample >= self.scene.samples()
    }
}

impl Steerable for SmallSimulation {
    fn go_on(&mut self, _reach: [f64; 2]) {
        self.endless = true;
    }

    fn tilt(&mut self, _tilt: f64) -> Result<(), PipelineError> {
        self.scene.joint()?;
        Ok(())
    }

    fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError> {
        let time = self.time();
        let Prepared {
            system, integrator, ..
        } = &mut self.prepared;
        integrator.land(system.as_ref(), time)?;
        let mut z = integrator.state().to_vec();
        let modes = system.modes();
        kick(&mut z[modes..2 * modes], size, seed);
        integrator.start(system.as_ref(), time, &z)?;
        Ok(())
    }

    fn cut(&mut self, samples: usize, shown: Shown) {
        self.shown = Some(shown);
        self.scene.frame_samples = samples;
    }

    fn time(&self) -> f64 {
        self.next_sample as f64 / self.scene.sample_rate
    }
}

/// What is to be said of a small system sampled at `rate` (Hz).
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
                (MassOnBelt::BACK, "slides back", StatusKind::Free),
                (MassOnBelt::STICKS, "sticks", StatusKind::Held),
                (MassOnBelt::AHEAD, "slides ahead", StatusKind::Other),
            ]),
            "changes between sticking and sliding",
        ),
        SmallSystem::TwoModesOnBelt(system) => (
            system.omega.to_vec(),
            names([
                (TwoModesOnBelt::TOUCHING, "touches", StatusKind::Held),
                (TwoModesOnBelt::APART, "lifted off", StatusKind::Free),
            ]),
            "touches and lift-offs",
        ),
        SmallSystem::DampedContact(system) => (
            vec![
                system.omega,
                system.drive_omega,
                system.contact_stiffness.sqrt(),
            ],
            names([
                (DampedContact::FREE, "apart", StatusKind::Free),
                (DampedContact::TOUCHING, "touching", StatusKind::Held),
            ]),
            "touches and lift-offs",
        ),
    };
    let highest = omegas.iter().copied().fold(0.0, f64::max) / std::f64::consts::TAU;
    SmallInfo {
        words: small.words().to_owned(),
        frequency_hz: omegas[0] / std::f64::consts::TAU,
        highest_frequency: (HARMONICS * highest).min(0.5 * rate),
        statuses,
        transition: transition.to_owned(),
    }
}

/// The statuses by their number.
fn names<const N: usize>(statuses: [(u8, &str, StatusKind); N]) -> Vec<StatusInfo> {
    let mut statuses = statuses.to_vec();
    statuses.sort_by_key(|(number, ..)| *number);
    let info = |(_, label, kind): (u8, &str, StatusKind)| StatusInfo {
        label: label.to_owned(),
        kind,
    };
    statuses.into_iter().map(info).collect()
}
