//! Measures what a lesson reports.

use std::sync::Arc;

use super::tilts::Tilts;
use crate::analysis::LineFit;
use crate::pipeline::message::{
    Computed, Exponents, Frame, Growth, Header, JointInfo, Measurements, NodeShares, NodeState,
    Parting, PatchSnapshot, SpectralLine, StatusKind, StatusShares, Subject, TiltedTone,
};
use crate::scene::{AnalysisSpec, Mechanism};

/// Level over the sliding speed up to which a vibration counts as small: there the linear theory holds.
const SMALL: f64 = 0.05;

/// Accumulates what a lesson reports.
pub struct Measured {
    pub level: Level,
    nodes: NodeCounts,
    statuses: StatusCounts,
    kinds: Vec<StatusKind>,
    leaders: Leaders,
    tilts: Option<Tilts>,
    dt: f64,
    /// Next snapshot and energy of the present frame.
    next: [usize; 2],
    /// The measurements so far; what is counted over 25 ms stands as it was at the last conclusion.
    so_far: Measurements,
}

/// What another stage has found.
pub enum Found {
    /// Lines of a spectrum, the strongest first.
    Lines(Vec<SpectralLine>),
    /// The distance of the perturbed trajectory.
    Parting(Parting),
    /// Exponents so far.
    Exponents(Arc<Exponents>),
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
            level: Level::new(piece, SMALL * computed.sliding_speed),
            nodes: NodeCounts::default(),
            statuses: StatusCounts::default(),
            kinds,
            leaders: Leaders::new(header.joint()),
            tilts: (computed.mechanism == Mechanism::Hysteresis).then(|| Tilts::new(window)),
            dt: 1.0 / header.sample_rate,
            next: [0; 2],
            so_far: Measurements::default(),
        }
    }

    /// Takes what another stage has found up to a time (s); returns the strongest line at its tilt, where
    /// the tilt changes.
    pub fn take(&mut self, time: f64, found: Found) -> Option<TiltedTone> {
        match found {
            Found::Lines(lines) => {
                let strongest = lines.first().map(|line| line.frequency);
                self.so_far.lines = lines;
                self.tilts.as_mut()?.hear(time, strongest?)
            }
            Found::Parting(parting) => {
                let first = self.so_far.separation.map_or(parting, |[first, _]| first);
                self.so_far.separation = Some([first, parting]);
                None
            }
            Found::Exponents(exponents) => {
                self.so_far.exponents = Some(exponents);
                None
            }
        }
    }

    /// Begins a frame, whose samples follow.
    pub fn enter(&mut self, frame: &Frame) {
        self.next = [0; 2];
        self.so_far.tilt = Some(frame.tilt);
        if let Some(tilts) = &mut self.tilts {
            tilts.enter(frame.t0, frame.tilt);
        }
    }

    /// Takes a sample; returns whether it completes a piece of the level.
    pub fn sample(&mut self, frame: &Frame, k: usize) -> bool {
        let time = frame.time(k);
        let until = time + 0.5 * frame.dt;
        while let Some(snapshot) = frame.patch.get(self.next[0]).filter(|p| p.time <= until) {
            self.nodes.push(snapshot);
            self.next[0] += 1;
        }
        while let Some(energy) = frame.energy.get(self.next[1]).filter(|e| e.time <= until) {
            let ended = self.level.ended.is_some();
            self.leaders.push(&energy.modal, ended);
            self.next[1] += 1;
        }
        if let Some(&status) = frame.status.get(k) {
            self.statuses.push(self.kinds[usize::from(status)]);
        }
        self.level.push(time, frame.velocity[k])
    }

    /// Concludes what was counted since the last time.
    pub fn conclude(&mut self) {
        self.so_far.nodes = self.nodes.take();
        self.so_far.statuses = self.statuses.take(self.dt);
        self.so_far.leader = self.leaders.conclude();
    }

    /// The measurements so far.
    pub fn measurements(&self) -> Measurements {
        Measurements {
            growth: self.level.growth(),
            growth_ended: self.level.ended.is_some(),
            first_level: self.level.first,
            level: self.level.last,
            leader_at_end: self.leaders.at_end.clone(),
            tilts: self.tilts.as_ref().map(Tilts::summary),
            ..self.so_far.clone()
        }
    }
}

/// The level of the velocity, piece by piece, and how it grows as long as it is small.
///
/// What of a kick does not grow must have died away before growth can be read: it counts from where
/// the level has risen by [`Level::RISEN`], or from [`Level::WAITED`] pieces on.
pub struct Level {
    /// Samples of a piece: half the lowest natural period, after which the square of a sine repeats.
    piece: usize,
    /// Level up to which it is small, m/s.
    limit: f64,
    squares: f64,
    count: usize,
    pieces: u64,
    /// Root mean square over the last piece, m/s.
    pub last: f64,
    /// That of the first piece that is not silent.
    first: Option<f64>,
    /// Time (s) and level (m/s) of the piece from which growth counts.
    anchor: Option<[f64; 2]>,
    line: LineFit,
    /// When it had become too large for the linear theory, s.
    ended: Option<f64>,
}

impl Level {
    /// See [`Level`].
    const RISEN: f64 = 3.0;
    const WAITED: u64 = 40;

    fn new(piece: usize, limit: f64) -> Self {
        Self {
            piece,
            limit,
            squares: 0.0,
            count: 0,
            pieces: 0,
            last: 0.0,
            first: None,
            anchor: None,
            line: LineFit::default(),
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
        self.last = (self.squares / self.count as f64).sqrt();
        (self.squares, self.count) = (0.0, 0);
        self.pieces += 1;
        if self.last == 0.0 {
            return true;
        }
        let first = *self.first.get_or_insert(self.last);
        if self.last > Self::RISEN * first || self.pieces >= Self::WAITED {
            self.anchor.get_or_insert([time, self.last]);
        }
        if self.last > self.limit {
            self.ended.get_or_insert(time);
        }
        if self.anchor.is_some() && self.ended.is_none() {
            self.line.push(time, self.last.ln());
        }
        true
    }

    /// The slope of the straight line through the logarithm of the level over time, as long as it was small.
    fn growth(&self) -> Option<Growth> {
        let fit = self.line.fit()?;
        Some(Growth {
            rate: fit.slope,
            half_width: fit.half_width,
        })
    }

    /// Where the level would be at a time (s) if it had grown at a rate (1/s) since growth counts;
    /// `None` before, and once the vibration is no longer small.
    pub fn predicted(&self, time: f64, rate: f64) -> Option<f64> {
        let [since, level] = self.anchor.filter(|_| self.ended.is_none())?;
        Some(level * (rate * (time - since)).exp())
    }
}

/// Counts of contact nodes that stick and that have separated.
#[derive(Clone, Debug, Default)]
struct NodeCounts {
    /// Snapshots counted, and nodes in each.
    snapshots: u64,
    nodes: usize,
    /// Time of the first and of the last of them, s.
    span: [f64; 2],
    /// Nodes that stick, in all snapshots, and the most in one.
    stuck: [usize; 2],
    /// Nodes that are separated, in all snapshots, and the most in one.
    separated: [usize; 2],
    /// Snapshots in which half of the nodes stick, and in which all are separated.
    half_stuck: u64,
    all_separated: u64,
    /// Changes from closed to separated.
    separations: u64,
    before: Vec<NodeState>,
}

impl NodeCounts {
    fn push(&mut self, snapshot: &PatchSnapshot) {
        let stuck = snapshot.count(NodeState::Stick);
        let separated = snapshot.count(NodeState::Separated);
        self.nodes = snapshot.states.len();
        if self.snapshots == 0 {
            self.span[0] = snapshot.time;
        }
        self.span[1] = snapshot.time;
        self.snapshots += 1;
        for (of, count) in [(&mut self.stuck, stuck), (&mut self.separated, separated)] {
            of[0] += count;
            of[1] = of[1].max(count);
        }
        self.half_stuck += u64::from(2 * stuck >= self.nodes);
        self.all_separated += u64::from(separated == self.nodes);
        let pairs = self.before.iter().zip(&snapshot.states);
        let lifted = pairs.filter(|(before, now)| {
            **before != NodeState::Separated && **now == NodeState::Separated
        });
        self.separations += lifted.count() as u64;
        self.before.clone_from(&snapshot.states);
    }

    /// The shares so far, if there is a snapshot; counting begins anew, from the last snapshot on.
    fn take(&mut self) -> Option<NodeShares> {
        let taken = std::mem::take(self);
        self.before.clone_from(&taken.before);
        let (snapshots, nodes) = (taken.snapshots as f64, taken.nodes as f64);
        let span = taken.span[1] - taken.span[0];
        (taken.snapshots > 0).then(|| NodeShares {
            stuck: taken.stuck[0] as f64 / (snapshots * nodes),
            most_stuck: taken.stuck[1] as f64 / nodes,
            half_stuck: taken.half_stuck as f64 / snapshots,
            separated: taken.separated[0] as f64 / (snapshots * nodes),
            most_separated: taken.separated[1] as f64 / nodes,
            all_separated: taken.all_separated as f64 / snapshots,
            separations_per_s: match span > 0.0 {
                true => taken.separations as f64 / (span * nodes),
                false => 0.0,
            },
        })
    }
}

/// Counts of what a small system has been doing.
#[derive(Clone, Debug, Default)]
struct StatusCounts {
    samples: u64,
    held: u64,
    /// Changes into and out of being held.
    changes: u64,
    before: Option<bool>,
}

impl StatusCounts {
    fn push(&mut self, kind: StatusKind) {
        let held = kind == StatusKind::Held;
        self.samples += 1;
        self.held += u64::from(held);
        let before = self.before.replace(held);
        self.changes += u64::from(before.is_some_and(|before| before != held));
    }

    /// The shares of samples `dt` (s) apart so far, if there is one; counting begins anew.
    fn take(&mut self, dt: f64) -> Option<StatusShares> {
        let taken = std::mem::take(self);
        self.before = taken.before;
        (taken.samples > 0).then(|| StatusShares {
            held: taken.held as f64 / taken.samples as f64,
            releases_per_s: 0.5 * (taken.changes as f64 / (taken.samples as f64 * dt)),
        })
    }
}

/// Which family of modes of the body has the most energy: as growth ended, and since the last conclusion.
#[derive(Clone, Debug, Default)]
struct Leaders {
    /// Name of each mode's family: both modes of a bending pair have one.
    families: Vec<String>,
    sums: Vec<f64>,
    at_end: Option<String>,
}

impl Leaders {
    fn new(joint: Option<&JointInfo>) -> Self {
        let modes = joint.map_or(&[][..], |joint| &joint.modes);
        let family = |label: &str| {
            let label = label.trim_end_matches(" x");
            label.trim_end_matches(" y").to_owned()
        };
        Self {
            families: modes.iter().map(|mode| family(&mode.label)).collect(),
            sums: vec![0.0; modes.len()],
            at_end: None,
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
        let energy_of = |family: &String| -> f64 {
            let pairs = self.families.iter().zip(modal);
            let own = pairs.filter(|(of, _)| *of == family);
            own.map(|(_, energy)| energy).sum()
        };
        let families = self.families.iter();
        let leader = families.max_by(|a, b| energy_of(a).total_cmp(&energy_of(b)))?;
        (energy_of(leader) > 0.0).then(|| leader.clone())
    }

    /// The one with the most energy since the last call.
    fn conclude(&mut self) -> Option<String> {
        let leader = self.leader(&self.sums);
        self.sums.fill(0.0);
        leader
    }
}
