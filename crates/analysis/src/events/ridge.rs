//! Ridges: paths of one resolution as functions of time, and the choice between resolutions.

use super::spectrogram::{Peak, Peaks};

/// A point of a ridge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub time_s: f64,
    pub frequency_hz: f64,
    /// Power of the tone, square of the signal's unit.
    pub power: f64,
    /// Noise power per hertz.
    pub noise: f64,
}

/// A ridge: the frequency of a partial over time.
#[derive(Clone, Debug)]
pub(super) struct Ridge {
    pub points: Vec<Point>,
    /// Energy over noise power per hertz, less the cost of describing the ridge: the greater, the better.
    pub rank: f64,
    /// Spacing of the bins of the resolution, Hz: its uncertainty of frequency.
    pub bin_hz: f64,
}

/// Cost of each column of a ridge: `ln(1 + s)` for a signal-to-noise ratio `s` of 20.
const COLUMN_COST: f64 = 3.0;

/// Share of a ridge that may coincide with a better one.
const MOST_COVERED: f64 = 0.4;

/// Largest gap between two parts of one ridge, s, and largest step of frequency over it.
const LARGEST_GAP_S: f64 = 0.25;
const LARGEST_STEP: f64 = 0.02;

/// Largest distance of a sideband of modulation from its carrier, Hz, and its least power below it.
const SIDEBAND_HZ: f64 = 45.0;
const SIDEBAND_RATIO: f64 = 0.4;

/// Largest relative step of frequency between points, beyond a bin.
const LARGEST_JUMP: f64 = 0.025;

/// Power relative to a tone that sounds at the same time below which a ridge may be its side lobe or quantisation.
const FAINT_RATIO: f64 = 1e-5;

impl Ridge {
    /// The ridge of a path: its longest part without a jump of frequency, which leads to another tone.
    pub fn new(path: &[(usize, Peak)], peaks: &Peaks) -> Self {
        let point = |(column, peak): &(usize, Peak)| Point {
            time_s: peaks.time(*column),
            frequency_hz: peak.bin * peaks.bin_hz,
            power: peak.power,
            noise: peak.noise,
        };
        let all: Vec<Point> = path.iter().map(point).collect();
        let is_continuous = |a: &Point, b: &Point| {
            let jump = (a.frequency_hz - b.frequency_hz).abs();
            jump < peaks.bin_hz.max(LARGEST_JUMP * a.frequency_hz)
        };
        let parts = all.chunk_by(is_continuous);
        let longest = parts.max_by_key(|part| part.len());
        let points = longest.expect("a path has peaks").to_vec();
        let energy: f64 = points.iter().map(|p| p.power / p.noise).sum();
        Self {
            rank: energy * peaks.step_s - COLUMN_COST * points.len() as f64,
            bin_hz: peaks.bin_hz,
            points,
        }
    }

    pub fn start(&self) -> f64 {
        self.points[0].time_s
    }

    pub fn end(&self) -> f64 {
        self.points[self.points.len() - 1].time_s
    }

    /// Frequency and power at a time, interpolated, constant beyond the ends; whether the time is within.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        let after = self.points.partition_point(|p| p.time_s <= time_s);
        let (Some(b), true) = (self.points.get(after), after > 0) else {
            let edge = &self.points[after.saturating_sub(1)];
            return (edge.frequency_hz, edge.power);
        };
        let a = &self.points[after - 1];
        let share = (time_s - a.time_s) / (b.time_s - a.time_s);
        let mix = |a: f64, b: f64| a + share * (b - a);
        (mix(a.frequency_hz, b.frequency_hz), mix(a.power, b.power))
    }

    /// Mean power.
    pub fn power(&self) -> f64 {
        self.points.iter().map(|p| p.power).sum::<f64>() / self.points.len() as f64
    }

    /// Share of the points of this ridge that satisfy a condition on (frequency, power) of both, its own first,
    /// at times of the other, with its half window to spare.
    pub fn share(&self, other: &Self, is: impl Fn((f64, f64), (f64, f64)) -> bool) -> f64 {
        let spare = 1.0 / other.bin_hz;
        let count = self.points.iter().filter(|p| {
            p.time_s > other.start() - spare
                && p.time_s < other.end() + spare
                && is((p.frequency_hz, p.power), other.at(p.time_s))
        });
        count.count() as f64 / self.points.len() as f64
    }
}

/// One description of each ridge: the best of all resolutions, without sidebands, parts joined.
pub(super) fn select(mut ridges: Vec<Ridge>) -> Vec<Ridge> {
    ridges.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    let mut kept: Vec<Ridge> = Vec::new();
    for ridge in ridges {
        let is_known = |other: &Ridge| {
            let reach = 2.5 * ridge.bin_hz.max(other.bin_hz);
            ridge.share(other, |a, b| (a.0 - b.0).abs() < reach) > MOST_COVERED
        };
        let is_sideband = |other: &Ridge| {
            ridge.share(other, |a, b| {
                (a.0 - b.0).abs() < SIDEBAND_HZ && a.1 < SIDEBAND_RATIO * b.1
            }) > 0.5
        };
        if !kept
            .iter()
            .any(|other| is_known(other) || is_sideband(other))
        {
            kept.push(ridge);
        }
    }
    let is_faint = |ridge: &&Ridge| {
        let below = |other: &Ridge| ridge.share(other, |a, b| a.1 < FAINT_RATIO * b.1) > 0.5;
        kept.iter().any(below)
    };
    joined(kept.iter().filter(|r| !is_faint(r)).cloned().collect())
}

/// Joins ridges that continue each other.
fn joined(mut ridges: Vec<Ridge>) -> Vec<Ridge> {
    ridges.sort_by(|a, b| a.start().total_cmp(&b.start()));
    let mut out: Vec<Ridge> = Vec::new();
    for ridge in ridges {
        let continues = |before: &&mut Ridge| {
            let gap = ridge.start() - before.end();
            let (f, g) = (before.at(ridge.start()).0, ridge.at(before.end()).0);
            let reach = (LARGEST_STEP * f).max(1.5 * ridge.bin_hz.max(before.bin_hz));
            gap > -0.3 && gap < LARGEST_GAP_S && ridge.end() > before.end() && (f - g).abs() < reach
        };
        match out.iter_mut().find(continues) {
            Some(before) => {
                let end = before.end();
                let rest = ridge.points.iter().filter(|p| p.time_s > end);
                before.points.extend(rest);
                before.rank += ridge.rank;
                before.bin_hz = before.bin_hz.max(ridge.bin_hz);
            }
            None => out.push(ridge),
        }
    }
    out
}
