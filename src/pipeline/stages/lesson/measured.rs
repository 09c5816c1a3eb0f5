//! Measurements for a lesson.

use super::level::Level;
use super::second_tone::SecondTone;
use super::tilt_history::TiltHistory;
use super::turning::Turning;
use crate::pipeline::message::{
    ContactSample, Frame, Header, JointInfo, Measurements, MechanismPrediction, NodeShares, Record,
    StatusKind, StatusShares, Subject, TiltedTone,
};
use crate::scene::{AnalysisSpec, Evidence, Parameter};

/// Ratio of level to sliding speed up to which a vibration is small and the linear theory applies.
const SMALL: f64 = 0.05;

/// Accumulates the measurements of a lesson.
#[derive(Default)]
pub struct LessonMeasurements {
    pub level: Level,
    /// Counts of contact nodes since the last evaluation.
    nodes: Vec<ContactSample>,
    /// For each state of a small system, whether it is held in it.
    holds: Vec<bool>,
    /// Whether it was held at the samples since the last evaluation, and at the sample before them.
    held: Vec<bool>,
    leaders: DominantModes,
    tilts: Option<TiltHistory>,
    turning: Option<Turning>,
    second_tone: Option<SecondTone>,
    dt: f64,
    /// Level below which the vibration is at rest, m/s.
    rest: f64,
    /// Largest magnitude of the velocity since the last evaluation, m/s.
    fastest: f64,
    /// Index of the next counts of contact nodes and of the next energy sample of the present frame.
    next: [usize; 2],
    /// Measurements so far; those averaged over 25 ms have the values of the last interval.
    so_far: Measurements,
}

impl LessonMeasurements {
    /// No measurements yet, for a run described by `header`.
    pub fn new(spec: &AnalysisSpec, header: &Header, computed: &MechanismPrediction) -> Self {
        let (lowest, holds) = match &header.subject {
            Subject::Joint(joint) => (
                joint.modes.first().map_or(1e3, |m| m.frequency_hz),
                Vec::new(),
            ),
            Subject::Small(small) => (
                small.frequency_hz,
                (small.statuses.iter())
                    .map(|status| status.kind == StatusKind::Held)
                    .collect(),
            ),
            Subject::Signal(_) => (1e3, Vec::new()),
        };
        let segment = (0.5 * header.sample_rate / lowest).round().max(1.0) as usize;
        let window = spec.spectrum.map_or(0.0, |spectrum| spectrum.window);
        let evidence = computed.mechanism.evidence();
        let is_turning = evidence == Evidence::Turning;
        Self {
            level: Level::new(segment, SMALL * computed.sliding_speed),
            holds,
            leaders: DominantModes::new(header.joint()),
            tilts: (is_turning || evidence == Evidence::Loop).then(|| TiltHistory::new(window)),
            turning: is_turning.then(|| Turning::new(SMALL * computed.sliding_speed)),
            second_tone: computed
                .torus
                .clone()
                .map(|birth| SecondTone::new(birth, 1.0 / header.sample_rate)),
            dt: 1.0 / header.sample_rate,
            rest: header.rest_speed,
            ..Self::default()
        }
    }

    /// Processes a result of another stage at a time (s). Returns the strongest line at its tilt, if the tilt
    /// varies.
    pub fn take(&mut self, time: f64, found: Record) -> Option<TiltedTone> {
        match found {
            Record::Spectrum { peaks, .. } => {
                let strongest = peaks.first().map(|line| line.frequency);
                self.so_far.lines = peaks;
                // A line of a silent joint is no tone.
                let is_silent = self
                    .turning
                    .as_ref()
                    .is_some_and(|turning| !turning.squeaks());
                if !is_silent {
                    return self.tilts.as_mut()?.add_line(time, strongest?);
                }
            }
            Record::TrajectoryDivergence(divergence) => {
                let [first, _] = self.so_far.separation.unwrap_or([divergence; 2]);
                self.so_far.separation = Some([first, divergence]);
            }
            Record::Regime { verdict, .. } => self.so_far.regime = Some(verdict.regime),
            Record::Exponents(exponents) => self.so_far.exponents = Some(exponents),
            _ => {}
        }
        None
    }

    /// Starts a frame, whose samples follow.
    pub fn begin_frame(&mut self, frame: &Frame) {
        self.next = [0; 2];
        self.so_far.tilt = Some(frame.tilt);
        self.so_far.changed = frame
            .changed
            .iter()
            .filter(|(parameter, _)| *parameter != Parameter::tilt())
            .map(|&(parameter, value)| parameter.with_value(value))
            .collect();
        self.so_far.kicks += frame.kicks.len();
        self.so_far.last_kick = frame.kicks.last().copied().or(self.so_far.last_kick);
        if let Some(tilts) = &mut self.tilts {
            tilts.set_tilt(frame.t0, frame.tilt);
        }
        if let Some(turning) = &mut self.turning {
            turning.set_tilt(frame.tilt);
        }
        if let Some(tone) = &mut self.second_tone {
            tone.set_tilt(frame.tilt);
            if !frame.kicks.is_empty() {
                tone.restart();
            }
        }
    }

    /// Processes a sample. Returns whether it completes a segment of the level.
    pub fn sample(&mut self, frame: &Frame, k: usize) -> bool {
        let time = frame.time(k);
        let until = time + 0.5 * frame.dt;
        while let Some(counts) = frame.contacts.get(self.next[0]).filter(|c| c.time <= until) {
            self.nodes.push(*counts);
            self.next[0] += 1;
        }
        while let Some(energy) = frame.energy.get(self.next[1]).filter(|e| e.time <= until) {
            let ended = self.level.has_ended();
            self.leaders.push(&energy.modal, ended);
            self.next[1] += 1;
        }
        if let Some(&status) = frame.status.get(k) {
            let is_held = self.holds[usize::from(status)];
            if self.held.is_empty() {
                self.held.push(is_held);
            }
            self.held.push(is_held);
        }
        let speed = frame.velocity[k].abs();
        self.fastest = self.fastest.max(speed);
        if let Some(tone) = &mut self.second_tone {
            tone.push(frame.velocity[k]);
        }
        let completed = self.level.push(time, frame.velocity[k]);
        if let Some(turning) = self.turning.as_mut().filter(|_| completed) {
            turning.push(time, self.level.last);
        }
        completed
    }

    /// Evaluates the counts since the last call.
    pub fn evaluate(&mut self) {
        self.so_far.nodes = node_shares(&std::mem::take(&mut self.nodes));
        self.so_far.statuses = status_shares(&self.held, self.dt);
        self.held.drain(..self.held.len().saturating_sub(1));
        self.so_far.leader = self.leaders.evaluate();
        self.so_far.peak_speed = Some(std::mem::take(&mut self.fastest));
    }

    /// The measurements so far.
    pub fn measurements(&self) -> Measurements {
        let turning = self.turning.as_ref();
        Measurements {
            growth: self.level.growth(),
            growth_ended: self.level.has_ended(),
            small_frequency: self.level.frequency(),
            first_level: self.level.first,
            level: self.level.last,
            at_rest: self.level.segments > 0 && self.level.last < self.rest,
            leader_at_end: self.leaders.at_growth_end.clone(),
            tilts: self.tilts.as_ref().map(TiltHistory::summary),
            passes: turning.map_or(Vec::new(), |turning| turning.passes.clone()),
            second_tone: self.second_tone.as_ref().and_then(SecondTone::found),
            ..self.so_far.clone()
        }
    }
}

/// Shares of the contact nodes that stick or are separated; `None` without an instant.
fn node_shares(counts: &[ContactSample]) -> Option<NodeShares> {
    let (first, last) = (counts.first()?, counts.last()?);
    let (instants, nodes) = (counts.len() as f64, last.nodes as f64);
    let sum = |of: fn(&ContactSample) -> usize| counts.iter().map(of).sum::<usize>() as f64;
    let most =
        |of: fn(&ContactSample) -> usize| counts.iter().map(of).max().unwrap_or(0) as f64 / nodes;
    let time =
        |holds: fn(&&ContactSample) -> bool| counts.iter().filter(holds).count() as f64 / instants;
    let span = last.time - first.time;
    Some(NodeShares {
        stuck: sum(|at| at.stuck) / (instants * nodes),
        most_stuck: most(|at| at.stuck),
        half_stuck: time(|at| 2 * at.stuck >= at.nodes),
        separated: sum(|at| at.separated) / (instants * nodes),
        most_separated: most(|at| at.separated),
        all_separated: time(|at| at.separated == at.nodes),
        separations_per_s: if span > 0.0 {
            sum(|at| at.separations) / (span * nodes)
        } else {
            0.0
        },
    })
}

/// Shares of the states of a small system, from whether it was held at samples `dt` (s) apart, of which the first belongs to
/// the interval before; `None` without further samples.
fn status_shares(held: &[bool], dt: f64) -> Option<StatusShares> {
    let (_, samples) = held.split_first()?;
    let changes = held.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let count = samples.len() as f64;
    (count > 0.0).then(|| StatusShares {
        held: samples.iter().filter(|held| **held).count() as f64 / count,
        releases_per_s: 0.5 * (changes as f64 / (count * dt)),
    })
}

/// Family of modes with the most energy: at the end of the growth, and since the last evaluation.
#[derive(Clone, Debug, Default)]
struct DominantModes {
    /// Family name of each mode; both modes of a bending pair have the same name.
    families: Vec<String>,
    sums: Vec<f64>,
    at_growth_end: Option<String>,
}

impl DominantModes {
    fn new(joint: Option<&JointInfo>) -> Self {
        let modes = joint.map_or(&[][..], |joint| &joint.modes);
        let family = |label: &str| {
            let label = label.trim_end_matches(" x");
            label.trim_end_matches(" y").to_owned()
        };
        Self {
            families: modes.iter().map(|mode| family(&mode.label)).collect(),
            sums: vec![0.0; modes.len()],
            at_growth_end: None,
        }
    }

    fn push(&mut self, modal: &[f64], ended: bool) {
        if ended && self.at_growth_end.is_none() {
            self.at_growth_end = self.leader(modal);
        }
        for (sum, energy) in self.sums.iter_mut().zip(modal) {
            *sum += energy;
        }
    }

    /// The family with the most energy; `None` if all energies are zero.
    fn leader(&self, modal: &[f64]) -> Option<String> {
        let energy_of = |family: &String| -> f64 {
            let pairs = self.families.iter().zip(modal);
            let own = pairs.filter(|(of, _)| *of == family);
            own.map(|(_, energy)| energy).sum()
        };
        let families = self.families.iter();
        let leader = families.max_by(|a, b| energy_of(a).total_cmp(&energy_of(b)))?;
        (energy_of(leader) > 0.0).then(|| leader.clone())
    }

    /// The family with the most energy since the last call.
    fn evaluate(&mut self) -> Option<String> {
        let leader = self.leader(&self.sums);
        self.sums.fill(0.0);
        leader
    }
}
