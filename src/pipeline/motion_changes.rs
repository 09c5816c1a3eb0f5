//! Changes of the motion while exponents are averaged: where the local exponents or the energies change for
//! good, another motion begins, and with it another average.

use std::f64::consts::{LN_10, TAU};

use super::message::MotionSegment;
use crate::analysis::{
    change_point::{Channel, MAX_CHANNELS, change_points},
    stats::BlockMeans,
};
use crate::dynamics::{Integrator, LyapunovSpectrum};

/// Maximum number of exponents that are tested; the largest ones determine the attractor.
const EXPONENTS: usize = 3;

/// Duration of an entry, periods of the slowest mode, and its minimum number of samples.
const ENTRY_PERIODS: f64 = 5.0;
const ENTRY_SAMPLES: u64 = 16;

/// Time for the tangent vectors to align with the directions of a new motion, periods of the slowest mode.
const ALIGN_PERIODS: f64 = 40.0;

/// Growth by which the two sides of a change must differ: each may hold a neutral factor of ten.
const MIN_GROWTH: f64 = 2.0 * LN_10;

/// Minimum change of the logarithm of an energy.
const MIN_ENERGY_CHANGE: f64 = 0.2;

/// Minimum share of a mode in the total energy of any block for a test of its energy.
const MIN_SHARE: f64 = 0.01;

/// Share of the total energy that replaces smaller energies, whose logarithm may be infinite.
const NEGLIGIBLE_SHARE: f64 = 1e-12;

/// Detector of changes of the motion: local exponents and energies since the last reset of the growth, in 64 to 128 blocks.
#[derive(Clone, Debug)]
pub struct ChangeDetector {
    /// Start time, s.
    start: f64,
    /// Samples per entry, and the duration of an entry, s.
    samples: u64,
    duration: f64,
    /// Alignment time after a change, s.
    align: f64,
    /// Tested exponents.
    exponents: usize,
    modes: usize,
    /// Samples in the incomplete entry, and sums of the energies of the modes and of the squares of the other
    /// components.
    count: u64,
    sums: Vec<f64>,
    /// Growth of the tested exponents up to the last entry.
    growth: Vec<f64>,
    /// Exponents; logarithms of the total energy, of the modal energies and of the mean squares of the other
    /// components.
    blocks: BlockMeans,
    /// Blocks before each change, and the number and length of the blocks in which these changes were found.
    changes: Vec<usize>,
    searched: [usize; 2],
}

impl ChangeDetector {
    /// Starts when the growth of the tangent vectors of an integrator has just been reset, at time `start`
    /// (s). Samples follow at intervals of `interval` (s).
    pub fn new(integrator: &Integrator<'_>, start: f64, interval: f64) -> Self {
        let sys = integrator.system();
        let known = integrator.exponents().map_or(0, |s| s.exponents.len());
        let exponents = known.min(EXPONENTS);
        let modes = sys.modes();
        let components = sys.tangent_dim() - modes;
        let slowest = sys.omega().iter().copied().filter(|omega| *omega > 0.0);
        let period = slowest.map(|omega| TAU / omega).fold(0.0, f64::max);
        let samples = ((ENTRY_PERIODS * period / interval).ceil() as u64).max(ENTRY_SAMPLES);
        Self {
            start,
            samples,
            duration: samples as f64 * interval,
            align: ALIGN_PERIODS * period,
            exponents,
            modes,
            count: 0,
            sums: vec![0.0; components],
            growth: vec![0.0; exponents],
            blocks: BlockMeans::new(exponents + 1 + components),
            changes: Vec::new(),
            searched: [0; 2],
        }
    }

    /// Adds the state `z` at a sample.
    pub fn push(&mut self, integrator: &Integrator<'_>, z: &[f64]) {
        let sys = integrator.system();
        let (q, rest) = z.split_at(self.modes);
        let (modal, other) = self.sums.split_at_mut(self.modes);
        for (sum, ((q, v), omega)) in modal.iter_mut().zip(q.iter().zip(rest).zip(sys.omega())) {
            *sum += v * v + (omega * q).powi(2);
        }
        for (sum, w) in other.iter_mut().zip(&rest[self.modes..]) {
            *sum += w * w;
        }
        self.count += 1;
        if self.count == self.samples {
            let found = integrator.exponents();
            self.finish_entry(&found.unwrap_or_default());
        }
    }

    fn finish_entry(&mut self, spectrum: &LyapunovSpectrum) {
        let mut entry = Vec::with_capacity(self.exponents + 1 + self.sums.len());
        for (before, exponent) in self.growth.iter_mut().zip(&spectrum.exponents) {
            let growth = exponent.value * spectrum.time;
            entry.push((growth - *before) / self.duration);
            *before = growth;
        }
        let samples = self.count as f64;
        let total: f64 = self.sums[..self.modes].iter().sum();
        let least = (NEGLIGIBLE_SHARE * total).max(f64::MIN_POSITIVE);
        entry.push(total.max(least).ln());
        let energies = self.sums.iter();
        entry.extend(energies.map(|sum| (sum.max(least) / samples).max(f64::MIN_POSITIVE).ln()));
        self.blocks.push(&entry);
        self.sums.fill(0.0);
        self.count = 0;
    }

    /// Duration of a block, s.
    fn block(&self) -> f64 {
        self.blocks.length() as f64 * self.duration
    }

    /// The quantities to test: the largest exponents, and the energies of a significant share.
    fn channels(&self) -> Vec<Channel> {
        let rate = |k: usize| Channel {
            values: self.blocks.channel(k),
            min_change: 0.0,
            min_sum: MIN_GROWTH / self.block(),
        };
        let energy = |k: usize| Channel {
            values: self.blocks.channel(self.exponents + k),
            min_change: MIN_ENERGY_CHANGE,
            min_sum: 0.0,
        };
        let mut channels: Vec<Channel> = (0..self.exponents).map(rate).collect();
        let total = energy(0);
        let share = |mode: &Channel| {
            let both = mode.values.iter().zip(&total.values);
            both.map(|(mode, total)| mode - total)
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let modes = (1..=self.modes).map(energy);
        let modes = modes.map(|mode| (share(&mode), mode));
        let mut modes: Vec<_> = modes.filter(|(share, _)| *share > MIN_SHARE.ln()).collect();
        modes.sort_by(|a, b| b.0.total_cmp(&a.0));
        if self.modes > 0 {
            channels.push(total);
        }
        channels.extend(modes.into_iter().map(|(_, mode)| mode));
        channels.extend((1 + self.modes..=self.sums.len()).map(energy));
        channels.truncate(MAX_CHANNELS);
        channels
    }

    /// The motions since the start, each with the exponents averaged within it; at least one. The averages
    /// leave out a block on each side of a change, and then the time in which the vectors align.
    pub fn segments(&mut self, integrator: &Integrator<'_>) -> Vec<MotionSegment> {
        let now = integrator.time();
        let motion = integrator.motion();
        let block = self.block();
        // Results are requested more often than blocks are completed.
        let blocks = [self.blocks.count(), self.blocks.length()];
        if std::mem::replace(&mut self.searched, blocks) != blocks {
            self.changes = change_points(&self.channels());
        }
        let changes = self.changes.iter();
        let changes: Vec<f64> = changes.map(|at| self.start + *at as f64 * block).collect();
        let starts = [self.start].into_iter().chain(changes.iter().copied());
        let ends = changes.iter().copied().chain([now]);
        let segment = |(start, end): (f64, f64)| {
            let from = if start == self.start {
                f64::NEG_INFINITY
            } else {
                start + block + self.align
            };
            let to = if end == now {
                f64::INFINITY
            } else {
                end - block
            };
            let spectrum = integrator.exponents_between(from, to).unwrap_or_default();
            MotionSegment {
                start_s: start,
                end_s: end,
                attractor: spectrum.attractor_of(motion),
                spectrum,
            }
        };
        starts.zip(ends).map(segment).collect()
    }
}
