//! The joint of a simulation: its loading over time, its contact, and its energy.
//!
//! A gradual change of the loading is applied at multiples of a number of samples, counted from the start of the run, and a
//! jump at its time: the motion does not depend on the length of the frames.

use std::sync::Arc;

use super::PipelineError;
use super::lesson::sliding_speed;
use super::message::{
    ContactSample, EnergySample, Frame, JointInfo, ModeInfo, NodeState, PatchGeometry,
    PatchSnapshot,
};
use super::prepare::{Unstarted, ball_of, joint_integrator};
use super::simulate::Motion;
use crate::dynamics::System;
use crate::joint::{AssemblyError, BallJoint, Joint, Loading, Model};
use crate::scene::{Carry, LoadedJoint, Parameter, Scene};

/// Number of vertices of the body's outline, along the meridian and along the circumference.
const OUTLINE: (usize, usize) = (44, 24);

/// A joint whose tilt, load and rotation change with time.
pub(super) struct JointBody {
    /// The joint under the present load and rotation.
    pub ball: BallJoint,
    /// The joint under the present tilt, load and rotation.
    pub joint: Arc<Joint>,
    /// The scene's joint, with tilt, load and rotation over time.
    loaded: LoadedJoint,
    /// Present tilt, load and rotation.
    pub now: Loading,
    /// Times of future jumps of the loading, s, in descending order.
    jumps: Vec<f64>,
    /// Samples between two updates of a loading that changes gradually: a frame of the scene. A frame of a live run may be
    /// shorter or longer.
    update_every: u64,
    patch: ShownPatch,
    geometry: Arc<PatchGeometry>,
    /// Contact nodes that are separated at the previous sample and at the present one, one bit per node.
    separated: [Vec<u8>; 2],
    /// States of the shown nodes at the last instant at which they were counted; empty before the first one.
    counted: Vec<NodeState>,
    /// Numbers of samples between two counts of nodes and between two energies; `None` if the scene records none.
    count_every: Option<u64>,
    energy_every: Option<u64>,
    /// Energy stored at the start, the reference of the audit, J.
    start_energy: f64,
    /// Work of kicks and of changes of tilt, load and rotation, which change the energy in an instant, J.
    added_energy: f64,
    /// Whether a step has passed over its events.
    has_unlocated_events: bool,
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
    pub fn new(scene: &Scene, loaded: &LoadedJoint) -> Result<(Self, Unstarted), PipelineError> {
        let now = loaded.loading(0.0);
        let tilt = now.tilt;
        let ball = ball_of(loaded)?;
        if loaded.varies() {
            check_reach(&ball, loaded, scene.duration)?;
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
            now,
            jumps: jumps_after(loaded, 0.0),
            loaded: loaded.clone(),
            update_every: scene.frame_samples as u64,
            separated: [vec![0; bytes], vec![0; bytes]],
            counted: Vec::new(),
            count_every: stride(scene.sample_rate, scene.record.patch_rate),
            energy_every,
            start_energy: 0.0,
            added_energy: 0.0,
            has_unlocated_events: false,
        };
        body.begin_at(&z);
        Ok((body, (integrator, z)))
    }

    /// Begins at a state `z`: counts separations and the energy from there.
    pub fn begin_at(&mut self, z: &[f64]) {
        let q = &z[..self.joint.modes()];
        self.joint.separated_nodes(q, &mut self.separated[0]);
        self.start_energy = self.joint.energy(z).total();
        self.added_energy = 0.0;
    }

    /// Description of the joint for the header of a run.
    pub fn info(&self, scene: &Scene) -> JointInfo {
        let loaded = &self.loaded;
        let [min_tilt, max_tilt] = loaded.tilt_span(scene.duration);
        let is_drawn = scene.record.body_rate > 0.0;
        let outline = is_drawn.then(|| self.ball.outline(OUTLINE.0, OUTLINE.1));
        let labels = self.ball.mode_labels().into_iter();
        let mode = |(label, &frequency_hz)| ModeInfo {
            label,
            frequency_hz,
        };
        // The rotation at a factor of 1, independent of the present factor, and the largest load.
        let (rotation, load_span) = (loaded.full_rotation, loaded.load_span());
        let mut extreme = self.ball.clone();
        extreme.set_loading(&Loading {
            load: load_span[1],
            rotation,
            ..self.now
        });
        JointInfo {
            body: self.ball.body_description(),
            modes: labels.zip(self.ball.frequencies_hz()).map(mode).collect(),
            min_tilt,
            max_tilt,
            tilt_range: None,
            azimuth: loaded.spec.azimuth,
            outline: outline.flatten().unwrap_or_default(),
            rotation,
            rotation_span: loaded.rotation_span(),
            load_span,
            ball_radius: self.ball.ball_radius(),
            patch_radius: extreme.patch_radius(),
            sliding_speed: sliding_speed(&extreme, self.now.tilt),
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
        while let Some(jump) = self.jumps.pop_if(|jump| *jump <= time) {
            self.apply_loading(jump, motion)?;
        }
        if sample.is_none_or(|sample| sample.is_multiple_of(self.update_every)) {
            self.apply_loading(time, motion)?;
        }
        Ok(())
    }

    /// Rebuilds the joint if its loading has changed. Patch, pre-stress and equilibrium change immediately.
    /// The perturbation or the displacement continues, and so do the tangent vectors and their growth: the
    /// exponents of a ramp are averages since the last change of the motion.
    fn apply_loading(&mut self, time: f64, motion: &mut Motion) -> Result<(), PipelineError> {
        let loading = self.loaded.loading(time);
        if loading == self.now {
            return Ok(());
        }
        self.ball.set_loading(&loading);
        self.now = loading;
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
        if self.loaded.carry == Carry::Displacement {
            let [old, new] = [&*self.joint, &joint].map(|joint| &joint.equilibrium().q);
            integrator.translate(&difference(new, old))?;
        }
        if joint.friction_states() > 0 {
            let start = z.clone();
            self.joint.carry_friction(&joint, &mut z);
            integrator.translate(&difference(&start, &z))?;
        }
        self.added_energy += joint.energy(integrator.state()).total() - before;
        self.joint = Arc::new(joint);
        motion.probe = self.joint.probe().to_vec();
        integrator.restart(self.joint.clone())?;
        self.geometry = Arc::new(self.patch.set_loading(&self.ball, self.now.tilt)?);
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
        let mut changed = (sample - sample % self.update_every) as f64 / rate;
        while let Some(jump) = self.jumps.pop_if(|jump| *jump <= time) {
            changed = changed.max(jump);
        }
        motion.integrator.start(changed, &motion.z)?;
        self.apply_loading(changed, motion)
    }

    /// Continues as another joint, of which a parameter differs, from a time (s) on.
    pub fn set(
        &mut self,
        mut loaded: LoadedJoint,
        parameter: Parameter,
        time: f64,
        motion: &mut Motion,
    ) -> Result<(), PipelineError> {
        // If the rotation moves the patch, it moves it from this tilt on.
        loaded.patch_moves_from = self.loaded.patch_moves_from;
        if parameter == Parameter::tilt() {
            loaded.patch_moves_from = loaded.patch_moves_from.map(|_| time);
        }
        let loading = loaded.loading(time);
        let mut ball = ball_of(&loaded)?;
        ball.set_loading(&loading);
        let model = ball.model(loading.tilt)?;
        self.jumps = jumps_after(&loaded, time);
        (self.ball, self.loaded, self.now) = (ball, loaded, loading);
        self.continue_with(&model, time, motion)
    }

    /// Number of samples at `rate` (Hz) from a sample on that belong to one joint.
    pub fn samples_until_change(&self, sample: u64, rate: f64) -> u64 {
        let until_update = if self.loaded.varies() {
            self.update_every - sample % self.update_every
        } else {
            u64::MAX
        };
        let next_jump = self.jumps.last();
        next_jump.map_or(until_update, |&jump| {
            until_update.min(first_sample_from(jump, rate) - sample)
        })
    }

    /// Adds the energy of a kick from one state to another to the work of the loading.
    pub fn add_kick(&mut self, before: &[f64], after: &[f64]) {
        let [before, after] = [before, after].map(|z| self.joint.energy(z).total());
        self.added_energy += after - before;
    }

    /// Adds the present loading to a frame.
    pub fn begin_frame(&self, frame: &mut Frame) {
        frame.tilt = self.now.tilt;
        frame.load = self.now.load;
        frame.rotation_factor = self.now.rotation_factor;
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
            residual: total - self.start_energy - self.added_energy - work,
            modal: energy.modal,
        }
    }
}

/// The contact patch as it is shown, under the present loading: its nodes need not be those that are simulated.
///
/// Displacement and velocity are known everywhere on the patch, because they are sums of modes. Pictures and counts
/// are evaluated at `record.patch_nodes` nodes in rings, however few the simulation integrates over. Where only the
/// simulated nodes have a state of friction, or a file fixes them, they are shown.
#[derive(Debug)]
struct ShownPatch {
    /// Number of nodes in rings.
    count: usize,
    /// The joint with these nodes; `None` if the simulated nodes are shown.
    joint: Option<Joint>,
}

impl ShownPatch {
    /// A patch that shows `count` nodes.
    fn new(count: usize) -> Self {
        Self { count, joint: None }
    }

    /// Returns the shown nodes of a joint at a tilt (rad), after a change of its loading.
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    fn set_loading(&mut self, ball: &BallJoint, tilt: f64) -> Result<PatchGeometry, PipelineError> {
        let in_rings = ball.model_in_rings(self.count, tilt)?;
        self.joint = in_rings.as_ref().map(Joint::new);
        let model = in_rings.map_or_else(|| ball.model(tilt), Ok)?;
        Ok(PatchGeometry {
            positions: model.positions,
            areas: model.areas,
            pre_stress: model.pre_stress,
            direction: ball.direction(tilt),
            radius: ball.patch_radius(),
        })
    }

    /// Status and forces of the shown nodes at a state `z` of the simulated joint.
    fn snapshot(&self, simulated: &Joint, time: f64, z: &[f64]) -> PatchSnapshot {
        let joint = self.joint.as_ref().unwrap_or(simulated);
        let forces = joint.node_forces(z);
        let pairs = forces.normal.iter().zip(&forces.speed).enumerate();
        let states = pairs.map(|(k, (&normal, &speed))| {
            if normal <= 0.0 {
                NodeState::Separated
            } else if speed < joint.stick_speed(k) {
                NodeState::Stick
            } else {
                NodeState::Slip
            }
        });
        PatchSnapshot {
            time,
            states: states.collect(),
            normal_force: forces.normal,
            friction: forces.friction,
        }
    }
}

/// Times of the jumps of the loading after a time, s, in descending order.
fn jumps_after(loaded: &LoadedJoint, time: f64) -> Vec<f64> {
    let mut jumps = loaded.jumps();
    jumps.retain(|jump| *jump > time);
    jumps.reverse();
    jumps
}

/// Reports an unreachable loading of a run of a duration (s) before the run: the patch is closest to the beam where
/// it is farthest from the pole, under the largest load.
///
/// # Errors
/// If the patch extends into the beam.
fn check_reach(ball: &BallJoint, loaded: &LoadedJoint, duration: f64) -> Result<(), AssemblyError> {
    let mut ball = ball.clone();
    let [_, load] = loaded.load_span();
    let moved = loaded
        .loadings(duration)
        .filter_map(|now| Some((now.patch?.direction[2], now)));
    let farthest = moved.min_by(|a, b| a.0.total_cmp(&b.0));
    let start = Loading {
        patch: None,
        ..loaded.loading(0.0)
    };
    let ends = [loaded.tilt.min(), loaded.tilt.max()].map(|tilt| Loading { tilt, ..start });
    for at in farthest.map(|(_, at)| at).into_iter().chain(ends) {
        ball.set_loading(&Loading { load, ..at });
        ball.model(at.tilt)?;
    }
    Ok(())
}

/// Index of the first sample at or after a time (s).
fn first_sample_from(time: f64, rate: f64) -> u64 {
    let near = (time * rate).ceil() as u64;
    // Rounding of the product may shift the index by one.
    let is_from = |index: u64| index as f64 / rate >= time;
    match near {
        1.. if is_from(near - 1) => near - 1,
        _ if is_from(near) => near,
        _ => near + 1,
    }
}
