//! The lesson of a scene that demonstrates a mechanism: measurements of the run, for comparison with the
//! linear prediction.
//!
//! The stage observes the records of the other stages: its numbers agree with the displayed ones. It
//! measures the rest itself. The prediction is in [`MechanismPrediction`].

use std::sync::Arc;

use super::level::Level;
use super::second_tone::SecondTone;
use super::tilt_history::TiltHistory;
use super::turning::Turning;
use crate::pipeline::message::{
    ContactSample, Frame, Header, Lesson, LevelSample, Measurements, MechanismPrediction,
    NodeShares, Record, StatusKind, StatusShares, Subject, TiltedTone,
};
use crate::pipeline::stages::samples;
use crate::scene::{AnalysisSpec, Evidence, Parameter};

/// Minimum time between two lessons, s: a text that changes more often is unreadable.
const EVERY: f64 = 25e-3;
/// Ratio of level to sliding speed up to which a vibration is small and the linear theory applies.
const SMALL: f64 = 0.05;

/// Emits [`Record::Lesson`] if a measurement has changed, at most every 25 ms, and [`Record::LevelSample`] twice
/// per natural period.
pub struct LessonStage {
    computed: Arc<MechanismPrediction>,
    level: Level,
    /// Counts of contact nodes since the last evaluation.
    nodes: Vec<ContactSample>,
    /// For each state of a small system, whether it is held in it.
    holds: Vec<bool>,
    /// Whether it was held at the samples since the last evaluation, and at the sample before them.
    held: Vec<bool>,
    /// Name of each mode, the same for both modes of a bending pair, and sum of its energies since the last evaluation.
    families: Vec<(String, f64)>,
    tilts: Option<TiltHistory>,
    turning: Option<Turning>,
    second_tone: Option<SecondTone>,
    dt: f64,
    /// Level below which the vibration is at rest, m/s.
    rest: f64,
    /// Largest magnitude of the velocity since the last evaluation, m/s.
    fastest: f64,
    /// Measurements so far; those averaged over 25 ms have the values of the last interval.
    so_far: Measurements,
    /// Number of samples between two lessons.
    every: u64,
    seen: u64,
    sent: Option<Measurements>,
}

impl LessonStage {
    /// For the run described by `header`; `None` if its scene has no mechanism.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Option<Self> {
        let computed = header.computed.clone()?;
        let (rate, small) = (header.sample_rate, SMALL * computed.sliding_speed);
        let (mut lowest, mut holds, mut families) = (None, Vec::new(), Vec::new());
        match &header.subject {
            Subject::Joint(joint) => {
                lowest = joint.modes.first().map(|mode| mode.frequency_hz);
                let labels = joint.modes.iter().map(|mode| &mode.label);
                let family = |label: &String| {
                    let label = label.trim_end_matches(" x");
                    label.trim_end_matches(" y").to_owned()
                };
                families = labels.map(|label| (family(label), 0.0)).collect();
            }
            Subject::Small(small) => {
                lowest = Some(small.frequency_hz);
                let kinds = small.statuses.iter().map(|status| status.kind);
                holds = kinds.map(|kind| kind == StatusKind::Held).collect();
            }
            Subject::Signal(_) => {}
        }
        let segment = (0.5 * rate / lowest.unwrap_or(1e3)).round().max(1.0) as usize;
        let window = spec.spectrum.map_or(0.0, |spectrum| spectrum.window);
        let evidence = computed.mechanism.evidence();
        let is_turning = evidence == Evidence::Turning;
        let torus = computed.torus.clone();
        Some(Self {
            level: Level::new(segment, small),
            nodes: Vec::new(),
            holds,
            held: Vec::new(),
            families,
            tilts: (is_turning || evidence == Evidence::Loop).then(|| TiltHistory::new(window)),
            turning: is_turning.then(|| Turning::new(small)),
            second_tone: torus.map(|birth| SecondTone::new(birth, 1.0 / rate)),
            dt: 1.0 / rate,
            rest: header.rest_speed,
            fastest: 0.0,
            so_far: Measurements::default(),
            computed,
            every: samples(EVERY, rate, 1) as u64,
            seen: 0,
            sent: None,
        })
    }

    /// The velocity level at a time (s), or the strongest line at a tilt.
    fn level_sample(&self, time: f64, tone: Option<TiltedTone>) -> Record {
        let predicts = self.computed.mechanism.evidence() == Evidence::Growth;
        let growth = self.computed.fastest().filter(|_| predicts);
        Record::LevelSample(LevelSample {
            time,
            level: self.level.last,
            predicted: growth.and_then(|growth| self.level.predicted(time, growth)),
            tone,
        })
    }

    /// The lesson at a time, s.
    pub fn lesson(&self, time: f64) -> Lesson {
        Lesson {
            time,
            computed: Arc::clone(&self.computed),
            measured: self.measurements(),
        }
    }

    /// Emits the lesson if the measurements have changed.
    fn send(&mut self, time: f64, records: &mut Vec<Record>) {
        let lesson = self.lesson(time);
        if self.sent.as_ref() != Some(&lesson.measured) {
            self.sent = Some(lesson.measured.clone());
            records.push(Record::Lesson(Arc::new(lesson)));
        }
    }

    /// Processes a frame, and adds records to those of the other stages.
    pub fn push(&mut self, frame: &Frame, records: &mut Vec<Record>) {
        let timed = |record: &Record| Some((time_of(record)?, record.clone()));
        let mut found: Vec<(f64, Record)> = records.iter().filter_map(timed).collect();
        // The stages report one after the other, each in time order.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = found.into_iter().peekable();
        let mut contacts = frame.contacts.iter().peekable();
        let mut energies = frame.energy.iter().peekable();
        if self.sent.is_none() {
            self.send(frame.t0, records);
        }
        self.begin_frame(frame);
        for k in 0..frame.len() {
            let time = frame.time(k);
            // Half a sample of tolerance: times are sums of rounded numbers.
            let until = time + 0.5 * frame.dt;
            while let Some((at, record)) = found.next_if(|(at, _)| *at <= until) {
                if let Some(tone) = self.take(at, record) {
                    records.push(self.level_sample(at, Some(tone)));
                }
            }
            while let Some(counts) = contacts.next_if(|counts| counts.time <= until) {
                self.nodes.push(*counts);
            }
            while let Some(energy) = energies.next_if(|energy| energy.time <= until) {
                self.add_energies(&energy.modal);
            }
            if self.sample(time, frame.velocity[k], frame.status.get(k)) {
                records.push(self.level_sample(time, None));
            }
            self.seen += 1;
            if self.seen.is_multiple_of(self.every) {
                self.evaluate();
                self.send(time, records);
            }
        }
    }

    /// The remaining records after the last sample, at a time, s.
    pub fn finish(&mut self, time: f64) -> Vec<Record> {
        let mut records = Vec::new();
        if self.seen > 0 {
            self.send(time, &mut records);
        }
        records
    }

    /// Starts a frame, whose samples follow.
    fn begin_frame(&mut self, frame: &Frame) {
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

    /// Processes a result of another stage at a time (s). Returns the strongest line at its tilt, if the tilt
    /// varies.
    fn take(&mut self, time: f64, found: Record) -> Option<TiltedTone> {
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

    /// Processes the energies of the modes at one instant.
    fn add_energies(&mut self, modal: &[f64]) {
        if self.level.has_ended() && self.so_far.leader_at_end.is_none() {
            let families = self.families.iter().zip(modal);
            let now: Vec<_> = families.map(|((name, _), e)| (name.clone(), *e)).collect();
            self.so_far.leader_at_end = leader(&now);
        }
        for ((_, sum), energy) in self.families.iter_mut().zip(modal) {
            *sum += energy;
        }
    }

    /// Processes the velocity (m/s) and the state of a small system at a sample. Returns whether it completes a segment of
    /// the level.
    fn sample(&mut self, time: f64, velocity: f64, status: Option<&u8>) -> bool {
        if let Some(&status) = status {
            let is_held = self.holds[usize::from(status)];
            if self.held.is_empty() {
                self.held.push(is_held);
            }
            self.held.push(is_held);
        }
        self.fastest = self.fastest.max(velocity.abs());
        if let Some(tone) = &mut self.second_tone {
            tone.push(velocity);
        }
        let completed = self.level.push(time, velocity);
        if let Some(turning) = self.turning.as_mut().filter(|_| completed) {
            turning.push(time, self.level.last);
        }
        completed
    }

    /// Evaluates the counts since the last call.
    fn evaluate(&mut self) {
        self.so_far.nodes = node_shares(&std::mem::take(&mut self.nodes));
        self.so_far.statuses = status_shares(&self.held, self.dt);
        self.held.drain(..self.held.len().saturating_sub(1));
        self.so_far.leader = leader(&self.families);
        for (_, sum) in &mut self.families {
            *sum = 0.0;
        }
        self.so_far.peak_speed = Some(std::mem::take(&mut self.fastest));
    }

    /// The measurements so far.
    fn measurements(&self) -> Measurements {
        let turning = self.turning.as_ref();
        Measurements {
            growth: self.level.growth(),
            growth_ended: self.level.has_ended(),
            small_frequency: self.level.frequency(),
            first_level: self.level.first,
            level: self.level.last,
            at_rest: self.level.segments > 0 && self.level.last < self.rest,
            tilts: self.tilts.as_ref().map(TiltHistory::summary),
            passes: turning.map_or(Vec::new(), |turning| turning.passes.clone()),
            second_tone: self.second_tone.as_ref().and_then(SecondTone::found),
            ..self.so_far.clone()
        }
    }
}

/// Time of a result of another stage that a lesson uses, s.
fn time_of(record: &Record) -> Option<f64> {
    match record {
        Record::Spectrum { time, .. } | Record::Regime { time, .. } => Some(*time),
        Record::TrajectoryDivergence(divergence) => Some(divergence.time_s),
        Record::Exponents(exponents) => Some(exponents.time),
        _ => None,
    }
}

/// The family of modes with the most energy, from the energy of each mode with the name of its family; `None` if all are
/// zero.
fn leader(modes: &[(String, f64)]) -> Option<String> {
    let energy_of = |family: &String| -> f64 {
        let own = modes.iter().filter(|(name, _)| name == family);
        own.map(|(_, energy)| energy).sum()
    };
    let names = modes.iter().map(|(name, _)| name);
    let leader = names.max_by(|a, b| energy_of(a).total_cmp(&energy_of(b)))?;
    (energy_of(leader) > 0.0).then(|| leader.clone())
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

/// Shares of the states of a small system, from whether it was held at samples `dt` (s) apart, of which the first belongs
/// to the interval before; `None` without further samples.
fn status_shares(held: &[bool], dt: f64) -> Option<StatusShares> {
    let (_, samples) = held.split_first()?;
    let changes = held.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let count = samples.len() as f64;
    (count > 0.0).then(|| StatusShares {
        held: samples.iter().filter(|held| **held).count() as f64 / count,
        releases_per_s: 0.5 * (changes as f64 / (count * dt)),
    })
}
