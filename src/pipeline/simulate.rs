//! The simulation of a joint: from a scene to frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::computed;
use super::loading::{LoadingClock, check_reach, set_loading};
use super::message::{
    ContactSample, DisplayRates, EnergySample, Frame, Header, JointInfo, MechanismPrediction,
    ModeInfo, NodeState, PatchGeometry, Subject,
};
use super::patch::ShownPatch;
use super::pending::RunState;
use super::prepare::{initial_state, joint_integrator, kick};
use super::scene_run::SceneRun;
use super::sensitivity::{Reached, SensitivityTracker, with_tangents};
use super::source::ControllableSource;
use super::{PipelineError, Source};
use crate::dynamics::{DynamicsError, Integrator, System};
use crate::joint::{BallJoint, Joint, Model};
use crate::scene::{AnalysisSpec, Carry, Loading, Parameter, Scene};

/// Number of vertices of the body's outline, along the meridian and along the circumference.
const OUTLINE: (usize, usize) = (44, 24);

/// A running simulation of a joint.
#[derive(Debug)]
pub struct Simulation {
    run: SceneRun,
    /// The joint under the present load and rotation.
    ball: BallJoint,
    joint: Joint,
    integrator: Integrator,
    patch: ShownPatch,
    geometry: Arc<PatchGeometry>,
    /// Linear prediction for the scene's mechanism.
    computed: Option<Arc<MechanismPrediction>>,
    /// Tilt, load and rotation over time.
    clock: LoadingClock,
    /// Contact nodes that are separated at the previous sample and at the present one, one bit per node.
    separated: [Vec<u8>; 2],
    /// States of the shown nodes at the last instant at which they were counted; empty before the first one.
    counted: Vec<NodeState>,
    /// State at the present sample.
    z: Vec<f64>,
    audit: Audit,
    /// See [`Frame::unlocated_since`].
    unlocated_since: Option<f64>,
    /// Lyapunov exponents and perturbed trajectory, if the scene requests them.
    sensitivity: SensitivityTracker,
}

/// Reference values of the energy audit, J.
#[derive(Clone, Copy, Debug, Default)]
struct Audit {
    /// Energy stored at the start.
    start: f64,
    /// Work of kicks and of changes of tilt, load and rotation, which change the energy in an instant.
    added: f64,
}

/// Number of samples between two events of the given rate (Hz); `None` if the rate is 0.
fn stride(sample_rate: f64, rate: f64) -> Option<u64> {
    (rate > 0.0).then(|| (sample_rate / rate).round().max(1.0) as u64)
}

/// The joint of a model, with the energy audit if the scene records energies.
fn audited(scene: &Scene, model: &Model) -> Joint {
    let joint = Joint::new(model);
    if scene.record.energy_rate > 0.0 {
        joint.with_audit()
    } else {
        joint
    }
}

/// Number of nodes that have separated or closed since the last sample. `separated` holds the separated nodes
/// of the previous sample, one bit per node; afterwards it holds those at the coordinates `q`.
fn transitions(joint: &Joint, q: &[f64], separated: &mut [Vec<u8>; 2]) -> u64 {
    let [before, now] = separated;
    joint.separated_nodes(q, now);
    let changed = before.iter().zip(&*now).map(|(a, b)| (a ^ b).count_ones());
    let count = changed.map(u64::from).sum();
    std::mem::swap(before, now);
    count
}

impl Simulation {
    /// Computes the modes, assembles the joint under the initial tilt, load and rotation, and applies the
    /// initial kick.
    ///
    /// # Errors
    /// If the scene has no joint, the joint cannot be assembled, or the integrator cannot start.
    pub fn new(scene: &Scene) -> Result<Self, PipelineError> {
        let clock = LoadingClock::new(scene.joint()?.clone(), scene.frame_samples as u64);
        let (tilted, loading) = (&clock.tilted, clock.now);
        let mut ball = BallJoint::new(&tilted.spec)?;
        if let Some(rotation) = &tilted.rotation {
            ball.set_probe_rotation(rotation.rad_s);
        }
        if tilted.varies() {
            check_reach(&ball, tilted, scene.duration)?;
        }
        let model = ball.model(loading.tilt)?;
        let joint = audited(scene, &model);
        let mut z = initial_state(scene, joint.modes());
        z.resize(joint.dim(), 0.0);
        let mut integrator = with_tangents(scene, &joint, joint_integrator(scene, &joint)?)?;
        integrator.start(&joint, 0.0, &z)?;
        let bytes = joint.contact_nodes().div_ceil(8);
        let mut separated = [vec![0; bytes], vec![0; bytes]];
        joint.separated_nodes(&z[..joint.modes()], &mut separated[0]);
        let audit = Audit {
            start: joint.energy(&z).total(),
            added: 0.0,
        };
        let mut patch = ShownPatch::new(scene.record.patch_nodes);
        Ok(Self {
            geometry: Arc::new(patch.set_loading(&ball, loading.tilt)?),
            patch,
            computed: computed::for_joint(scene, tilted, &ball, &joint)?,
            run: SceneRun::new(scene),
            clock,
            ball,
            joint,
            integrator,
            separated,
            counted: Vec::new(),
            z,
            audit,
            unlocated_since: None,
            sensitivity: SensitivityTracker::new(scene),
        })
    }

    /// The joint under the present tilt, load and rotation.
    pub fn joint(&self) -> &Joint {
        &self.joint
    }

    /// The integrator, which is at the last sample or slightly past it.
    pub fn integrator(&self) -> &Integrator {
        &self.integrator
    }

    /// Present tilt, load and rotation.
    pub fn loading(&self) -> Loading {
        self.clock.now
    }

    /// The joint and the integrator, to continue the integration without the pipeline.
    pub fn into_parts(self) -> (Joint, Integrator) {
        (self.joint, self.integrator)
    }

    fn joint_info(&self) -> JointInfo {
        let tilted = &self.clock.tilted;
        let spec = &tilted.spec;
        let [min_tilt, max_tilt] = tilted.tilt_span(self.run.scene.duration);
        let outline = if self.run.scene.record.body_rate > 0.0 {
            self.ball.outline(OUTLINE.0, OUTLINE.1)
        } else {
            None
        };
        let labels = self.ball.mode_labels();
        let rotation = match &tilted.rotation {
            Some(rotation) => rotation.rad_s,
            None => spec.rotation,
        };
        // The rotation at a factor of 1, independent of the present factor.
        let mut turning = self.ball.clone();
        turning.set_rotation(rotation);
        let velocity = turning.sliding_velocity(self.clock.now.tilt);
        let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let [_, largest_load] = tilted.load_span();
        let mut pressed = self.ball.clone();
        pressed.set_load(largest_load);
        JointInfo {
            body: self.ball.body_description(),
            modes: labels
                .into_iter()
                .zip(self.ball.frequencies_hz())
                .map(|(label, &frequency_hz)| ModeInfo {
                    label,
                    frequency_hz,
                })
                .collect(),
            min_tilt,
            max_tilt,
            tilt_range: None,
            azimuth: spec.azimuth,
            outline: outline.unwrap_or_default(),
            rotation,
            rotation_span: tilted.rotation_span(),
            load_span: tilted.load_span(),
            ball_radius: self.ball.ball_radius(),
            patch_radius: pressed.patch_radius(),
            sliding_speed: speed,
        }
    }

    /// Integrates to the end of the run and applies the tilt, load and rotation scheduled there. A frame has
    /// the loading of its start. Call this after the last frame.
    ///
    /// # Errors
    /// If the joint cannot be assembled under this loading, or the integrator cannot restart.
    pub fn apply_final_loading(&mut self) -> Result<(), PipelineError> {
        let time = self.time();
        self.apply_jumps(time)?;
        self.apply_loading(time)
    }

    /// Advances the loading to the next sample at a time (s). Each jump on the way changes the joint exactly at
    /// its time.
    fn advance_loading(&mut self, time: f64) -> Result<(), PipelineError> {
        self.apply_jumps(time)?;
        if self.clock.is_due(self.run.next_sample) {
            self.apply_loading(time)
        } else {
            Ok(())
        }
    }

    fn apply_jumps(&mut self, time: f64) -> Result<(), PipelineError> {
        while let Some(jump) = self.clock.take_jump(time) {
            self.apply_loading(jump)?;
        }
        Ok(())
    }

    /// Rebuilds the joint if its loading has changed. Patch, pre-stress and equilibrium change immediately.
    /// The perturbation or the displacement continues, and so do the tangent vectors and their growth: the
    /// exponents of a ramp are averages since the last change of the motion.
    fn apply_loading(&mut self, time: f64) -> Result<(), PipelineError> {
        let loading = self.clock.tilted.loading(time);
        if loading == self.clock.now {
            return Ok(());
        }
        set_loading(&mut self.ball, &loading);
        self.clock.now = loading;
        let model = self.ball.model(loading.tilt)?;
        self.continue_with(&model, time)
    }

    /// Continues with the joint of another model from a time (s) on.
    fn continue_with(&mut self, model: &Model, time: f64) -> Result<(), PipelineError> {
        if time > 0.0 {
            self.integrator.integrate_to(&self.joint, time)?;
        }
        self.replace_joint(model, self.clock.tilted.carry)?;
        self.integrator.restart(&self.joint)?;
        self.geometry = Arc::new(self.patch.set_loading(&self.ball, self.clock.now.tilt)?);
        self.sensitivity.parameters_changed(time);
        Ok(())
    }

    /// Replaces the joint by that of another model. The change of energy is work of the loading, not of
    /// friction.
    fn replace_joint(&mut self, model: &Model, carry: Carry) -> Result<(), PipelineError> {
        let joint = audited(&self.run.scene, model);
        let mut z = self.integrator.state().to_vec();
        let before = self.joint.energy(&z).total();
        if carry == Carry::Displacement {
            let [old, new] = [&self.joint, &joint].map(|joint| &joint.equilibrium().q);
            let shift: Vec<f64> = old.iter().zip(new).map(|(old, new)| old - new).collect();
            self.integrator.translate(&shift)?;
        }
        if joint.friction_states() > 0 {
            let start = z.clone();
            self.joint.carry_friction(&joint, &mut z);
            let shift: Vec<f64> = z.iter().zip(start).map(|(new, old)| new - old).collect();
            self.integrator.translate(&shift)?;
        }
        self.audit.added += joint.energy(self.integrator.state()).total() - before;
        self.joint = joint;
        Ok(())
    }

    /// Number of samples of the next frame. A frame ends where the loading changes: all its samples belong to
    /// one joint, and the motion does not depend on the length of the frames.
    fn frame_length(&self) -> u64 {
        let scene = &self.run.scene;
        let constant = self
            .clock
            .samples_until_change(self.run.next_sample, scene.sample_rate);
        let left = self.run.samples_left();
        left.min(scene.frame_samples as u64).min(constant)
    }

    /// The next frame, with space for `count` samples.
    fn empty_frame(&self, count: usize) -> Frame {
        let modes = self.joint.modes();
        Frame {
            q: Vec::with_capacity(count * modes),
            qdot: Vec::with_capacity(count * modes),
            tilt: self.clock.now.tilt,
            load: self.clock.now.load,
            rotation_factor: self.clock.now.rotation_factor,
            geometry: Arc::clone(&self.geometry),
            ..self.run.begin_frame(modes)
        }
    }

    /// Adds the present sample to a frame, and the nodes that have separated or closed since the previous one.
    fn take_sample(&mut self, frame: &mut Frame) {
        let [q, v, _] = self.joint.parts(&self.z);
        frame.q.extend_from_slice(q);
        frame.qdot.extend_from_slice(v);
        frame.displacement.push(self.joint.probe_value(q));
        frame.velocity.push(self.joint.probe_value(v));
        frame.transitions += transitions(&self.joint, q, &mut self.separated);
    }

    /// Counts the contact nodes at the present sample, and takes a snapshot of them, if these are due.
    fn follow_contacts(
        &mut self,
        time: f64,
        [counts, pictures]: [bool; 2],
        frame: &mut Frame,
    ) -> Result<(), PipelineError> {
        if !counts && !pictures {
            return Ok(());
        }
        let tilt = self.clock.now.tilt;
        let snapshot = self
            .patch
            .snapshot(&self.ball, tilt, &self.joint, time, &self.z)?;
        if counts {
            let sample = ContactSample::of(&snapshot, &self.counted);
            frame.contacts.push(sample);
            self.counted.clone_from(&snapshot.states);
        }
        if pictures {
            frame.patch.push(snapshot);
        }
        Ok(())
    }

    fn energy_sample(&self, time: f64) -> EnergySample {
        let energy = self.joint.energy(&self.z);
        let total = energy.total();
        let work = self.z[self.joint.tangent_dim()];
        EnergySample {
            time,
            total,
            friction_work: work,
            residual: total - self.audit.start - self.audit.added - work,
            modal: energy.modal,
        }
    }
}

impl Source for Simulation {
    fn header(&self, command: &str) -> Header {
        let subject = Subject::Joint(self.joint_info());
        self.run.header(command, subject, self.computed.clone())
    }

    fn analysis(&self) -> &AnalysisSpec {
        &self.run.scene.analysis
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.integrator.set_stop_flag(Arc::clone(stop));
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        if self.is_finished() {
            return Ok(None);
        }
        let began = Instant::now();
        let rate = self.run.scene.sample_rate;
        match self.advance_loading(self.time()) {
            Err(PipelineError::Dynamics(DynamicsError::Stopped { .. })) => return Ok(None),
            other => other?,
        }
        let count = self.frame_length();
        let mut frame = self.empty_frame(count as usize);
        let record = &self.run.scene.record;
        let count_every = stride(rate, record.patch_rate);
        let energy_every = stride(rate, record.energy_rate);
        let is_due =
            |every: Option<u64>, index: u64| every.is_some_and(|every| index.is_multiple_of(every));
        let first = self.run.next_sample;
        // Data that the scene does not record stay off.
        let is_live = self.run.shown.is_some() && record.patch_rate > 0.0;
        let is_picture = |index: u64| {
            if is_live {
                DisplayRates::is_snapshot(index - first, count, rate)
            } else {
                is_due(count_every, index)
            }
        };
        for index in first..first + count {
            let time = index as f64 / rate;
            match self.integrator.sample(&self.joint, time, &mut self.z) {
                Err(DynamicsError::Stopped { .. }) => break,
                other => other?,
            }
            if self.unlocated_since.is_none() {
                let located = self.integrator.stats().steps_without_event_location == 0;
                self.unlocated_since = (!located).then_some(time);
            }
            self.take_sample(&mut frame);
            let due = [is_due(count_every, index), is_picture(index)];
            self.follow_contacts(time, due, &mut frame)?;
            if is_due(energy_every, index) {
                frame.energy.push(self.energy_sample(time));
            }
            let reached = Reached {
                index,
                time,
                z: &self.z,
            };
            let probe = |z: &[f64]| {
                let [q, v, _] = self.joint.parts(z);
                [self.joint.probe_value(q), self.joint.probe_value(v)]
            };
            self.sensitivity.follow(
                &self.joint,
                &mut self.integrator,
                reached,
                probe,
                &mut frame,
            )?;
        }
        // A stopped run yields fewer samples than planned.
        if frame.is_empty() {
            return Ok(None);
        }
        if self.run.shown.is_some() {
            frame.state = Some(RunState {
                time_s: frame.end() - frame.dt,
                values: self.z[..self.joint.tangent_dim()].to_vec(),
                drive_phase: 0.0,
            });
        }
        frame.stats = self.integrator.stats();
        frame.unlocated_since = self.unlocated_since;
        frame.error = self.integrator.take_error_estimate();
        self.run.end_frame(&mut frame, began);
        Ok(Some(frame))
    }

    fn is_finished(&self) -> bool {
        self.run.samples_left() == 0
    }
}

impl ControllableSource for Simulation {
    fn run_until_stopped(&mut self) {
        self.run.is_endless = true;
    }

    fn seek(&mut self, time: f64) -> Result<(), PipelineError> {
        self.run.seek(time);
        let update = self.clock.last_update(self.run.next_sample);
        let mut loaded = update as f64 / self.run.scene.sample_rate;
        while let Some(jump) = self.clock.take_jump(self.time()) {
            loaded = loaded.max(jump);
        }
        self.integrator.start(&self.joint, loaded, &self.z)?;
        self.apply_loading(loaded)
    }

    fn set_state(&mut self, state: &RunState) -> Result<(), PipelineError> {
        let mut z = state.values.clone();
        z.resize(z.len() + self.joint.quadratures(), 0.0);
        self.integrator.start(&self.joint, self.time(), &z)?;
        let q = &z[..self.joint.modes()];
        self.joint.separated_nodes(q, &mut self.separated[0]);
        self.audit = Audit {
            start: self.joint.energy(&z).total(),
            added: 0.0,
        };
        Ok(())
    }

    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), PipelineError> {
        let time = self.time();
        self.advance_loading(time)?;
        let mut scene = self.run.scene.clone();
        scene.set(parameter, value)?;
        let mut tilted = scene.joint()?.clone();
        // If the rotation moves the patch, it moves it from this tilt on.
        tilted.patch_moves_from = self.clock.tilted.patch_moves_from;
        if parameter == Parameter::tilt() {
            tilted.patch_moves_from = tilted.patch_moves_from.map(|_| time);
        }
        let loading = tilted.loading(time);
        let mut ball = self.ball.clone().with_spec(&tilted.spec)?;
        if let Some(rotation) = &tilted.rotation {
            ball.set_probe_rotation(rotation.rad_s);
        }
        set_loading(&mut ball, &loading);
        let model = ball.model(loading.tilt)?;
        (self.ball, self.run.scene) = (ball, scene);
        self.clock.replace(tilted, time);
        self.run.record_change(parameter, value);
        self.continue_with(&model, time)
    }

    fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError> {
        let time = self.time();
        self.advance_loading(time)?;
        self.integrator.integrate_to(&self.joint, time)?;
        let mut z = self.integrator.state().to_vec();
        let before = self.joint.energy(&z).total();
        let modes = self.joint.modes();
        kick(&mut z[modes..2 * modes], size, seed);
        self.audit.added += self.joint.energy(&z).total() - before;
        self.integrator.start(&self.joint, time, &z)?;
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

#[cfg(test)]
#[path = "simulate_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "carry_tests.rs"]
mod carry_tests;

#[cfg(test)]
#[path = "moving_patch_tests.rs"]
mod moving_patch_tests;
