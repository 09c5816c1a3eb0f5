//! What a lesson measures.

use crate::pipeline::message::{
    Computed, Exponents, Frame, Header, JointInfo, NodeState, Parting, PatchSnapshot, Peak, Record,
    StatusKind, Subject, TiltedTone,
};
use crate::pipeline::stages::line::{Fit, Line};
use crate::scene::{AnalysisSpec, Mechanism};

use super::tilts::Tilts;

/// Level over the sliding speed up to which a vibration counts as small: there the linear theory holds.
const SMALL: f64 = 0.05;

/// All that is measured.
pub struct Measured {
    /// How loud it is.
    pub envelope: Envelope,
    /// The lines of the last spectrum, the strongest first; empty before the first one.
    pub peaks: Vec<Peak>,
    /// Contact nodes over the last 25 ms, of a joint with snapshots.
    pub nodes: Option<NodeShares>,
    nodes_now: NodeShares,
    /// Statuses of a small system over the last 25 ms.
    pub statuses: Option<StatusShares>,
    statuses_now: StatusShares,
    kinds: Vec<StatusKind>,
    /// Which mode of the body has the most energy.
    pub leaders: Leaders,
    /// What is heard at which tilt, where that is the matter.
    pub tilts: Option<Tilts>,
    /// How far two copies have parted: at first and last.
    pub parting: Option<[Parting; 2]>,
    /// The last exponents.
    pub exponents: Option<Exponents>,
    /// The tilt now, rad.
    pub tilt: Option<f64>,
    dt: f64,
    /// Next snapshot and energy of the present frame.
    next: [usize; 2],
}

impl Measured {
    /// Nothing yet, of a run announced by `header`.
    pub fn new(spec: &AnalysisSpec, header: &Header, computed: &Computed) -> Self {
        let (lowest, kinds) = match &header.subject {
            Subject::Joint(joint) => (
                joint.modes.first().map_or(1e3, |m| m.frequency_hz),
                Vec::new(),
            ),
            Subject::Small(small) => (
                small.frequency_hz,
                small.statuses.iter().map(|status| status.kind).collect(),
            ),
            Subject::Signal(_) => (1e3, Vec::new()),
        };
        let piece = (0.5 * header.sample_rate / lowest).round().max(1.0) as usize;
        let window = spec
            .spectrum
            .map_or(0.0, |spectrum| spectrum.sliding.window);
        Self {
            envelope: Envelope::new(piece, SMALL * computed.sliding_speed),
            peaks: Vec::new(),
            nodes: None,
            nodes_now: NodeShares::default(),
            statuses: None,
            statuses_now: StatusShares::default(),
            kinds,
            leaders: Leaders::new(header.joint()),
            tilts: (computed.mechanism == Mechanism::Hysteresis).then(|| Tilts::new(window)),
            parting: None,
            exponents: None,
            tilt: None,
            dt: 1.0 / header.sample_rate,
            next: [0; 2],
        }
    }

    /// Takes what another stage has said; returns what is heard at a tilt, where that is the matter.
    pub fn hear(&mut self, record: Record) -> Option<TiltedTone> {
        match record {
            Record::Spectrum { time, peaks, .. } => {
                let strongest = peaks.first().map(|peak| peak.frequency);
                self.peaks = peaks;
                self.tilts.as_mut()?.hear(time, strongest?)
            }
            Record::Parting(parting) => {
                let first = self.parting.map_or(parting, |[first, _]| first);
                self.parting = Some([first, parting]);
                None
            }
            Record::Exponents(exponents) => {
                self.exponents = Some((*exponents).clone());
                None
            }
            _ => None,
        }
    }

    /// Begins a frame, whose samples follow.
    pub fn enter(&mut self, frame: &Frame) {
        self.next = [0; 2];
        self.tilt = Some(frame.tilt);
        if let Some(tilts) = &mut self.tilts {
            tilts.enter(frame.t0, frame.tilt);
        }
    }

    /// Takes a sample; returns whether it completes a piece of the envelope.
    pub fn sample(&mut self, frame: &Frame, k: usize) -> bool {
        let time = frame.time(k);
        let until = time + 0.5 * frame.dt;
        while let Some(snapshot) = frame.patch.get(self.next[0]).filter(|p| p.time <= until) {
            self.nodes_now.push(snapshot);
            self.next[0] += 1;
        }
        while let Some(energy) = frame.energy.get(self.next[1]).filter(|e| e.time <= until) {
            self.leaders
                .push(&energy.modal, self.envelope.ended.is_some());
            self.next[1] += 1;
        }
        if let Some(&status) = frame.status.get(k) {
            self.statuses_now.push(self.kinds[usize::from(status)]);
        }
        self.envelope.push(time, frame.velocity[k])
    }

    /// Concludes what was counted since the last look.
    pub fn conclude(&mut self) {
        let nodes = self.nodes_now.take();
        self.nodes = (nodes.snapshots > 0).then_some(nodes);
        let statuses = self.statuses_now.take();
        self.statuses = (statuses.samples > 0).then_some(statuses);
        self.leaders.conclude();
    }

    /// The strongest line, Hz.
    pub fn tone(&self) -> Option<f64> {
        self.peaks.first().map(|peak| peak.frequency)
    }

    /// A count of the last look as a rate over its time, 1/s.
    pub fn rate(&self, count: u64, samples: u64) -> f64 {
        count as f64 / (samples as f64 * self.dt)
    }
}

/// The loudness of the velocity, piece by piece, and how it grows as long as it is small.
///
/// What of a kick does not grow must have died away before growth can be read: it counts from where
/// the level is three times that of the start, or else twenty natural periods after it.
pub struct Envelope {
    /// Samples of a piece: half the lowest natural period, after which the square of a sine repeats.
    piece: usize,
    /// Level up to which it is small, m/s.
    limit: f64,
    squares: f64,
    count: usize,
    pieces: u64,
    level: f64,
    /// Time (s) and level (m/s) of the first piece that is not silent.
    pub first: Option<[f64; 2]>,
    /// The same of the piece from which growth counts.
    anchor: Option<[f64; 2]>,
    line: Line,
    /// When it had become too large for the linear theory, s.
    pub ended: Option<f64>,
}

impl Envelope {
    /// See [`Envelope`].
    const RISEN: f64 = 3.0;
    const WAITED: u64 = 40;

    fn new(piece: usize, limit: f64) -> Self {
        Self {
            piece,
            limit,
            squares: 0.0,
            count: 0,
            pieces: 0,
            level: 0.0,
            first: None,
            anchor: None,
            line: Line::default(),
            ended: None,
        }
    }

    /// Takes a velocity (m/s); returns whether it completes a piece.
    fn push(&mut self, time: f64, velocity: f64) -> bool {
        self.squares += velocity * velocity;
        self.count += 1;
        if self.count < self.piece {
            return false;
        }
        self.level = (self.squares / self.count as f64).sqrt();
        (self.squares, self.count) = (0.0, 0);
        self.pieces += 1;
        if self.level == 0.0 {
            return true;
        }
        let [_, first] = *self.first.get_or_insert([time, self.level]);
        if self.level > Self::RISEN * first || self.pieces >= Self::WAITED {
            self.anchor.get_or_insert([time, self.level]);
        }
        if self.level > self.limit {
            self.ended.get_or_insert(time);
        }
        if self.anchor.is_some() && self.ended.is_none() {
            self.line.push(time, self.level.ln());
        }
        true
    }

    /// The last level, m/s.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// The straight line through the logarithm of the level over time, as long as it was small.
    pub fn growth(&self) -> Option<Fit> {
        self.line.fit()
    }

    /// Where the level would be at a time (s) if it had grown at a rate (1/s) since growth counts;
    /// `None` before, and once the vibration is no longer small.
    pub fn foretold(&self, time: f64, rate: f64) -> Option<f64> {
        let [since, level] = self.anchor.filter(|_| self.ended.is_none())?;
        Some(level * (rate * (time - since)).exp())
    }
}

/// How many contact nodes stick and are open.
#[derive(Clone, Debug, Default)]
pub struct NodeShares {
    /// Snapshots counted, and nodes in each.
    pub snapshots: u64,
    nodes: usize,
    /// Time between the first and the last of them, s.
    span: [f64; 2],
    /// Nodes that stick, in all snapshots, and the most in one.
    stuck: [usize; 2],
    /// Nodes that are open, in all snapshots, and the most in one.
    open: [usize; 2],
    /// Snapshots in which half of the nodes stick, and in which all are open.
    half_stuck: u64,
    all_open: u64,
    /// Changes from closed to open.
    lift_offs: u64,
    before: Vec<NodeState>,
}

impl NodeShares {
    fn push(&mut self, snapshot: &PatchSnapshot) {
        let (stuck, open) = (
            snapshot.count(NodeState::Stick),
            snapshot.count(NodeState::Separated),
        );
        self.nodes = snapshot.states.len();
        if self.snapshots == 0 {
            self.span[0] = snapshot.time;
        }
        self.span[1] = snapshot.time;
        self.snapshots += 1;
        for (of, count) in [(&mut self.stuck, stuck), (&mut self.open, open)] {
            of[0] += count;
            of[1] = of[1].max(count);
        }
        self.half_stuck += u64::from(2 * stuck >= self.nodes);
        self.all_open += u64::from(open == self.nodes);
        let lifted = self.before.iter().zip(&snapshot.states);
        let lifted = lifted.filter(|(before, now)| {
            **before != NodeState::Separated && **now == NodeState::Separated
        });
        self.lift_offs += lifted.count() as u64;
        self.before.clone_from(&snapshot.states);
    }

    /// All so far; counting begins anew, from the last snapshot on.
    fn take(&mut self) -> Self {
        let taken = std::mem::take(self);
        self.before.clone_from(&taken.before);
        taken
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / (self.snapshots as f64 * self.nodes as f64)
    }

    /// Share of the nodes that stick, on average, and at most.
    pub fn stuck(&self) -> [f64; 2] {
        [
            self.share(self.stuck[0]),
            self.stuck[1] as f64 / self.nodes as f64,
        ]
    }

    /// Share of the nodes that are open, on average, and at most.
    pub fn open(&self) -> [f64; 2] {
        [
            self.share(self.open[0]),
            self.open[1] as f64 / self.nodes as f64,
        ]
    }

    /// Share of the time in which half of the nodes stick.
    pub fn half_stuck(&self) -> f64 {
        self.half_stuck as f64 / self.snapshots as f64
    }

    /// Share of the time in which all are open.
    pub fn all_open(&self) -> f64 {
        self.all_open as f64 / self.snapshots as f64
    }

    /// How often a node lifts off, 1/s.
    pub fn lift_offs(&self) -> f64 {
        let span = self.span[1] - self.span[0];
        if span > 0.0 {
            self.lift_offs as f64 / (span * self.nodes as f64)
        } else {
            0.0
        }
    }
}

/// What a small system has been doing.
#[derive(Clone, Debug, Default)]
pub struct StatusShares {
    /// Samples counted.
    pub samples: u64,
    held: u64,
    /// Changes into and out of being held.
    pub changes: u64,
    before: Option<bool>,
}

impl StatusShares {
    fn push(&mut self, kind: StatusKind) {
        let held = kind == StatusKind::Held;
        self.samples += 1;
        self.held += u64::from(held);
        let changed = self
            .before
            .replace(held)
            .is_some_and(|before| before != held);
        self.changes += u64::from(changed);
    }

    fn take(&mut self) -> Self {
        let taken = std::mem::take(self);
        self.before = taken.before;
        taken
    }

    /// Share of the time in which it is held: it sticks, or touches.
    pub fn held(&self) -> f64 {
        self.held as f64 / self.samples as f64
    }
}

/// Which family of modes of the body has the most energy: as growth ended, and over the last 25 ms.
#[derive(Clone, Debug, Default)]
pub struct Leaders {
    /// Name of each mode's family: both modes of a bending pair have one.
    families: Vec<String>,
    sums: Vec<f64>,
    at_end: Option<String>,
    now: Option<String>,
}

impl Leaders {
    fn new(joint: Option<&JointInfo>) -> Self {
        let modes = joint.map_or(&[][..], |joint| &joint.modes);
        let family = |label: &str| {
            label
                .trim_end_matches(" x")
                .trim_end_matches(" y")
                .to_owned()
        };
        Self {
            families: modes.iter().map(|mode| family(&mode.label)).collect(),
            sums: vec![0.0; modes.len()],
            ..Self::default()
        }
    }

    fn push(&mut self, modal: &[f64], ended: bool) {
        if ended && self.at_end.is_none() {
            self.at_end = self.leader(modal);
        }
        for (sum, energy) in self.sums.iter_mut().zip(modal) {
            *sum += energy;
        }
    }

    /// The family with the most of some energies; `None` where there are none.
    fn leader(&self, modal: &[f64]) -> Option<String> {
        let of = |family: &String| -> f64 {
            let own = self
                .families
                .iter()
                .zip(modal)
                .filter(|(f, _)| *f == family);
            own.map(|(_, energy)| energy).sum()
        };
        let leader = self
            .families
            .iter()
            .max_by(|a, b| of(a).total_cmp(&of(b)))?;
        (of(leader) > 0.0).then(|| leader.clone())
    }

    fn conclude(&mut self) {
        self.now = self.leader(&self.sums);
        self.sums.fill(0.0);
    }

    /// The one with the most energy as the vibration became too large for the linear theory.
    pub fn at_end(&self) -> Option<&str> {
        self.at_end.as_deref()
    }

    /// The one with the most energy over the last 25 ms.
    pub fn now(&self) -> Option<&str> {
        self.now.as_deref()
    }
}
