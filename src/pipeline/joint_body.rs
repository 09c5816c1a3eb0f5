//! The joint of a simulation: its loading, its contact, and its energy.

use std::sync::Arc;

use super::PipelineError;
use super::computed::sliding_speed;
use super::loading::{LoadingClock, ball_of, check_reach};
use super::message::{
    ContactSample, EnergySample, Frame, JointInfo, ModeInfo, NodeState, PatchGeometry,
};
use super::patch::ShownPatch;
use super::prepare::{Unstarted, joint_integrator};
use super::simulate::Motion;
use crate::dynamics::System;
use crate::joint::{BallJoint, Joint, Loading, Model};
use crate::scene::{Carry, LoadedJoint, Parameter, Scene};

/// Number of vertices of the body's outline, along the meridian and along the circumference.
const OUTLINE: (usize, usize) = (44, 24);

/// A joint whose tilt, load and rotation change with time.
pub(super) struct JointBody {
    /// The joint under the present load and rotation.
    pub ball: BallJoint,
    /// The joint under the present tilt, load and rotation.
    pub joint: Arc<Joint>,
    /// Tilt, load and rotation over time.
    pub clock: LoadingClock,
    patch: ShownPatch,
    geometry: Arc<PatchGeometry>,
    /// Contact nodes that are separated at the previous sample and at the present one, one bit per node.
    separated: [Vec<u8>; 2],
    /// States of the shown nodes at the last instant at which they were counted; empty before the first one.
    counted: Vec<NodeState>,
    /// Numbers of samples between two counts of nodes and between two energies; `None` if the scene records none.
    count_every: Option<u64>,
    energy_every: Option<u64>,
    audit: Audit,
    /// Whether a step has passed over its events.
    has_unlocated_events: bool,
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

/// The joint of a model, with or without the energy audit.
fn joint_of(model: &Model, audited: bool) -> Joint {
    let joint = Joint::new(model);
    if audited { joint.with_audit() } else { joint }
}

impl JointBody {
    /// Computes the modes and assembles the joint of a scene under the initial tilt, load and rotation; with its integrator,
    /// not started, and its initial state.
    pub fn new(scene: &Scene, tilted: &LoadedJoint) -> Result<(Self, Unstarted), PipelineError> {
        let clock = LoadingClock::new(tilted.clone(), scene.frame_samples as u64);
        let tilt = clock.now.tilt;
        let ball = ball_of(tilted)?;
        if tilted.varies() {
            check_reach(&ball, tilted, scene.duration)?;
        }
        let energy_every = stride(scene.sample_rate, scene.record.energy_rate);
        let joint = Arc::new(joint_of(&ball.model(tilt)?, energy_every.is_some()));
        let (integrator, z) = joint_integrator(scene, &joint)?;
        let bytes = joint.contact_nodes().div_ceil(8);
        let mut patch = ShownPatch::new(scene.record.patch_nodes);
        let mut body = Self {
            geometry: Arc::new(patch.set_loading(&ball, tilt)?),
            patch,
            ball,
            joint,
            clock,
            separated: [vec![0; bytes], vec![0; bytes]],
            counted: Vec::new(),
            count_every: stride(scene.sample_rate, scene.record.patch_rate),
            energy_every,
            audit: Audit::default(),
            has_unlocated_events: false,
        };
        body.begin_at(&z);
        Ok((body, (integrator, z)))
    }

    /// Begins at a state `z`: counts separations and the energy from there.
    pub fn begin_at(&mut self, z: &[f64]) {
        let q = &z[..self.joint.modes()];
        self.joint.separated_nodes(q, &mut self.separated[0]);
        self.audit = Audit {
            start: self.joint.energy(z).total(),
            added: 0.0,
        };
    }

    /// Description of the joint for the header of a run.
    pub fn info(&self, scene: &Scene) -> JointInfo {
        let tilted = &self.clock.tilted;
        let spec = &tilted.spec;
        let [min_tilt, max_tilt] = tilted.tilt_span(scene.duration);
        let outline = if scene.record.body_rate > 0.0 {
            self.ball.outline(OUTLINE.0, OUTLINE.1)
        } else {
            None
        };
        let labels = self.ball.mode_labels();
        // The rotation at a factor of 1, independent of the present factor, and the largest load.
        let (rotation, load_span) = (tilted.full_rotation, tilted.load_span());
        let mut extreme = self.ball.clone();
        extreme.set_loading(&Loading {
            load: load_span[1],
            rotation,
            ..self.clock.now
        });
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
            load_span,
            ball_radius: self.ball.ball_radius(),
            patch_radius: extreme.patch_radius(),
            sliding_speed: sliding_speed(&extreme, self.clock.now.tilt),
        }
    }

    /// Advances the loading to a time (s): at a sample, where gradual changes may wait for a later one, or at the end of a run.
    /// Each jump on the way changes the joint exactly at its time.
    pub fn advance(
        &mut self,
        sample: Option<u64>,
        time: f64,
        motion: &mut Motion,
    ) -> Result<(), PipelineError> {
        while let Some(jump) = self.clock.take_jump(time) {
            self.apply_loading(jump, motion)?;
        }
        if sample.is_none_or(|sample| self.clock.last_update(sample) == sample) {
            self.apply_loading(time, motion)?;
        }
        Ok(())
    }

    /// Rebuilds the joint if its loading has changed. Patch, pre-stress and equilibrium change immediately.
    /// The perturbation or the displacement continues, and so do the tangent vectors and their growth: the
    /// exponents of a ramp are averages since the last change of the motion.
    fn apply_loading(&mut self, time: f64, motion: &mut Motion) -> Result<(), PipelineError> {
        let loading = self.clock.tilted.loading(time);
        if loading == self.clock.now {
            return Ok(());
        }
        self.ball.set_loading(&loading);
        self.clock.now = loading;
        let model = self.ball.model(loading.tilt)?;
        self.continue_with(&model, time, motion)
    }

    /// Continues with the joint of another model from a time (s) on. The change of energy is work of the loading, not of
    /// friction.
    fn continue_with(
        &mut self,
        model: &Model,
        time: f64,
        motion: &mut Motion,
    ) -> Result<(), PipelineError> {
        let integrator = &mut motion.integrator;
        if time > 0.0 {
            integrator.integrate_to(time)?;
        }
        let joint = joint_of(model, self.energy_every.is_some());
        let mut z = integrator.state().to_vec();
        let before = self.joint.energy(&z).total();
        let difference = |old: &[f64], new: &[f64]| -> Vec<f64> {
            new.iter().zip(old).map(|(new, old)| new - old).collect()
        };
        if self.clock.tilted.carry == Carry::Displacement {
            let [old, new] = [&*self.joint, &joint].map(|joint| &joint.equilibrium().q);
            integrator.translate(&difference(new, old))?;
        }
        if joint.friction_states() > 0 {
            let start = z.clone();
            self.joint.carry_friction(&joint, &mut z);
            integrator.translate(&difference(&start, &z))?;
        }
        self.audit.added += joint.energy(integrator.state()).total() - before;
        self.joint = Arc::new(joint);
        motion.probe = self.joint.probe().to_vec();
        integrator.restart(self.joint.clone())?;
        self.geometry = Arc::new(self.patch.set_loading(&self.ball, self.clock.now.tilt)?);
        motion.sensitivity.parameters_changed(time);
        Ok(())
    }

    /// Starts at a sample at a time (s) of samples at `rate` (Hz).
    pub fn seek(
        &mut self,
        sample: u64,
        [time, rate]: [f64; 2],
        motion: &mut Motion,
    ) -> Result<(), PipelineError> {
        let mut loaded = self.clock.last_update(sample) as f64 / rate;
        while let Some(jump) = self.clock.take_jump(time) {
            loaded = loaded.max(jump);
        }
        motion.integrator.start(loaded, &motion.z)?;
        self.apply_loading(loaded, motion)
    }

    /// Continues as another joint, of which a parameter differs, from a time (s) on.
    pub fn set(
        &mut self,
        mut tilted: LoadedJoint,
        parameter: Parameter,
        time: f64,
        motion: &mut Motion,
    ) -> Result<(), PipelineError> {
        // If the rotation moves the patch, it moves it from this tilt on.
        tilted.patch_moves_from = self.clock.tilted.patch_moves_from;
        if parameter == Parameter::tilt() {
            tilted.patch_moves_from = tilted.patch_moves_from.map(|_| time);
        }
        let loading = tilted.loading(time);
        let mut ball = ball_of(&tilted)?;
        ball.set_loading(&loading);
        let model = ball.model(loading.tilt)?;
        self.ball = ball;
        self.clock.replace(tilted, time);
        self.continue_with(&model, time, motion)
    }

    /// Adds the energy of a kick from one state to another to the work of the loading.
    pub fn add_kick(&mut self, before: &[f64], after: &[f64]) {
        let [before, after] = [before, after].map(|z| self.joint.energy(z).total());
        self.audit.added += after - before;
    }

    /// Adds the present loading to a frame.
    pub fn begin_frame(&self, frame: &mut Frame) {
        frame.tilt = self.clock.now.tilt;
        frame.load = self.clock.now.load;
        frame.rotation_factor = self.clock.now.rotation_factor;
        frame.geometry = Arc::clone(&self.geometry);
    }

    /// Adds what the scene records at a sample with an index at a time (s): the nodes that have separated or closed since the
    /// previous sample, counts and a snapshot of the contact nodes, and the energy. `live` says whether a live run shows a
    /// snapshot.
    pub fn sample(
        &mut self,
        (index, time): (u64, f64),
        live: Option<bool>,
        motion: &Motion,
        frame: &mut Frame,
    ) {
        let Motion { integrator, z, .. } = motion;
        if integrator.stats().steps_without_event_location > 0 && !self.has_unlocated_events {
            self.has_unlocated_events = true;
            frame.unlocated_since = Some(time);
        }
        frame.transitions += self.transitions(&z[..self.joint.modes()]);
        let is_due = |every: Option<u64>| every.is_some_and(|every| index.is_multiple_of(every));
        let counts = is_due(self.count_every);
        // Data that the scene does not record stay off.
        let shows = live.map_or(counts, |live| live && self.count_every.is_some());
        if counts || shows {
            let snapshot = self.patch.snapshot(&self.joint, time, z);
            if counts {
                let sample = ContactSample::of(&snapshot, &self.counted);
                frame.contacts.push(sample);
                self.counted.clone_from(&snapshot.states);
            }
            if shows {
                frame.patch.push(snapshot);
            }
        }
        if is_due(self.energy_every) {
            frame.energy.push(self.energy_sample(time, z));
        }
    }

    /// Number of nodes that have separated or closed since the last sample, at the coordinates `q`.
    fn transitions(&mut self, q: &[f64]) -> u64 {
        let [before, now] = &mut self.separated;
        self.joint.separated_nodes(q, now);
        let changed = before.iter().zip(&*now).map(|(a, b)| (a ^ b).count_ones());
        let count = changed.map(u64::from).sum();
        std::mem::swap(before, now);
        count
    }

    fn energy_sample(&self, time: f64, z: &[f64]) -> EnergySample {
        let energy = self.joint.energy(z);
        let total = energy.total();
        let work = z[self.joint.tangent_dim()];
        EnergySample {
            time,
            total,
            friction_work: work,
            residual: total - self.audit.start - self.audit.added - work,
            modal: energy.modal,
        }
    }
}
