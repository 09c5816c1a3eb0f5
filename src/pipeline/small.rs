//! The simulation of a small system: from a scene to frames.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::computed;
use super::message::{DisplayRates, Frame, Header, SmallInfo, StatusInfo, StatusKind, Subject};
use super::pending::RunState;
use super::prepare::{boxed, kick, small_probe};
use super::scene_run::SceneRun;
use super::sensitivity::{Reached, SensitivityTracker, with_tangents};
use super::source::ControllableSource;
use super::{PipelineError, Prepared, Source, prepare};
use crate::dynamics::DynamicsError;
use crate::scene::{AnalysisSpec, Parameter, Scene, SceneError, SmallSystem, SystemSpec};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// Upper limit of frequency axes as a multiple of the largest natural or driving frequency: discontinuities
/// have many harmonics.
const HARMONICS: f64 = 8.0;

/// A running simulation of a small system. It stops at every event and reports the discrete state at each
/// sample.
pub struct SmallSimulation {
    run: SceneRun,
    info: SmallInfo,
    prepared: Prepared,
    /// Lyapunov exponents and perturbed trajectory, if the scene requests them.
    sensitivity: SensitivityTracker,
    /// Number of events up to the end of the last frame.
    crossings: u64,
}

impl SmallSimulation {
    /// Builds the system of a scene and starts its integrator.
    ///
    /// # Errors
    /// If the subject of the scene is a joint, or the integrator cannot start.
    pub fn new(scene: &Scene) -> Result<Self, PipelineError> {
        let SystemSpec::Small(small) = &scene.subject else {
            let (required, defines) = ("a small system is", "defines a ball joint");
            let remedy = "with a table such as [impact_oscillator]";
            return Err(SceneError::wrong_system(&scene.name, required, defines, remedy).into());
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
            run: SceneRun::new(scene),
            info: info(small, scene.sample_rate),
            prepared,
            crossings: 0,
        })
    }
}

impl Source for SmallSimulation {
    fn header(&self, command: &str) -> Header {
        let subject = Subject::Small(self.info.clone());
        let computed = computed::for_small(&self.run.scene);
        self.run.header(command, subject, computed)
    }

    fn analysis(&self) -> &AnalysisSpec {
        &self.run.scene.analysis
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.prepared.integrator.set_stop_flag(Arc::clone(stop));
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        if self.is_finished() {
            return Ok(None);
        }
        let began = Instant::now();
        let scene = &self.run.scene;
        let rate = scene.sample_rate;
        let count = self.run.samples_left().min(scene.frame_samples as u64);
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
        let mut frame = self.run.begin_frame(modes);
        let first = self.run.next_sample;
        for index in first..first + count {
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
        if self.run.shown.is_some() {
            let drive_phase = match &mut self.run.scene.subject {
                SystemSpec::Small(small) => small.drive().map_or(0.0, |(_, phase)| *phase),
                SystemSpec::Joint(_) => 0.0,
            };
            frame.state = Some(RunState {
                time_s: frame.end() - frame.dt,
                values: z.clone(),
                drive_phase,
            });
        }
        frame.stats = integrator.stats();
        frame.error = integrator.take_error_estimate();
        self.crossings += frame.transitions;
        self.run.end_frame(&mut frame, began);
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.run.samples_left() == 0
    }
}

impl ControllableSource for SmallSimulation {
    fn run_until_stopped(&mut self) {
        self.run.is_endless = true;
    }

    fn seek(&mut self, time: f64) -> Result<(), PipelineError> {
        self.run.seek(time);
        let Prepared {
            system,
            integrator,
            state,
            ..
        } = &mut self.prepared;
        Ok(integrator.start(system.as_ref(), self.run.time(), state)?)
    }

    fn set_state(&mut self, state: &RunState) -> Result<(), PipelineError> {
        let Prepared {
            system, integrator, ..
        } = &mut self.prepared;
        if let SystemSpec::Small(small) = &mut self.run.scene.subject {
            if let Some((_, phase)) = small.drive() {
                *phase = state.drive_phase;
            }
            *system = boxed(small);
        }
        Ok(integrator.start(system.as_ref(), self.run.time(), &state.values)?)
    }

    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), PipelineError> {
        let time = self.time();
        let mut scene = self.run.scene.clone();
        scene.set(parameter, value)?;
        let before = std::mem::replace(&mut self.run.scene, scene).subject;
        let (SystemSpec::Small(mut before), SystemSpec::Small(small)) =
            (before, &mut self.run.scene.subject)
        else {
            return Ok(());
        };
        // The angle of the drive goes on.
        if let (Some((old, phase)), Some((new, shifted))) = (before.drive(), small.drive()) {
            *shifted = (*phase + (old - new) * time).rem_euclid(TAU);
        }
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
        self.run.record_change(parameter, value);
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
        self.run.set_frame_length(samples, shown);
    }

    fn time(&self) -> f64 {
        self.run.time()
    }

    fn scene(&self) -> &Scene {
        &self.run.scene
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
    let highest = omegas.iter().copied().fold(0.0, f64::max) / TAU;
    SmallInfo {
        words: small.description().to_owned(),
        frequency_hz: omegas[0] / TAU,
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
