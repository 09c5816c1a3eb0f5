//! Interleaved timing: variants alternate, so that disturbances of the machine affect all of them alike.

use cpu_time::{ProcessTime, ThreadTime};
use serde::{Deserialize, Serialize};

use crate::study::OnProgress;

/// Cause of a failed run.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Least and largest number of rounds; each variant runs once per round. One more round comes first to warm up
/// the caches and is not counted. Rounds are added until all differences are measured well enough.
const MIN_ROUNDS: usize = 4;
const MAX_ROUNDS: usize = 10;

/// Half-width of a difference that is small enough: relative to the difference, and to the time itself.
const SMALL: f64 = 0.25;
const SMALL_SHARE: f64 = 0.02;

/// Student's t at 95 % for 2 to 10 values.
const STUDENT: [f64; 9] = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26];

/// Number of stages in the progress.
const STAGES: f64 = 5.0;

/// A measured mean with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The mean, in the unit of the quantity.
    pub mean: f64,
    /// Half-width of the 95 % interval.
    pub half_width: f64,
}

impl Measured {
    /// From repeated measurements, at least two.
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let deviation = (squares / (n - 1.0).max(1.0)).sqrt();
        Self {
            mean,
            half_width: STUDENT[values.len().clamp(2, STUDENT.len() + 1) - 2] * deviation
                / n.sqrt(),
        }
    }

    /// The quantity multiplied by a factor.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            mean: factor * self.mean,
            half_width: factor.abs() * self.half_width,
        }
    }

    /// Whether the 95 % interval excludes zero.
    pub fn is_significant(self) -> bool {
        self.mean.abs() > self.half_width
    }
}

/// Timer of interleaved variants.
pub(super) struct Bench<'w> {
    pub watch: OnProgress<'w, f64>,
    /// Number of completed stages.
    pub stage: f64,
}

impl Bench<'_> {
    /// Reports the fraction done of the current stage; returns whether to continue.
    pub fn should_continue(&mut self, share: f64) -> bool {
        (self.watch)(((self.stage + share) / STAGES).min(1.0))
    }

    /// Runs every variant once per round; `run` returns the time of a variant. The first variant is the one that
    /// others are compared with. `None` if stopped.
    pub fn rounds(
        &mut self,
        variants: usize,
        run: &mut dyn FnMut(usize) -> Result<f64, Cause>,
    ) -> Result<Option<Rounds>, Cause> {
        let mut rounds = Rounds(vec![Vec::with_capacity(MAX_ROUNDS); variants]);
        for round in 0..=MAX_ROUNDS {
            if round > MIN_ROUNDS && rounds.are_enough() {
                break;
            }
            for (variant, taken) in rounds.0.iter_mut().enumerate() {
                let found = run(variant);
                // A stopped run has neither a valid time nor a valid error.
                let done = (round * variants + variant + 1) as f64;
                if !self.should_continue(done / ((MAX_ROUNDS + 1) * variants) as f64) {
                    return Ok(None);
                }
                if round > 0 {
                    taken.push(found?);
                } else {
                    found?;
                }
            }
        }
        self.stage += 1.0;
        Ok(Some(rounds))
    }
}

/// Times of each variant in each round.
pub(super) struct Rounds(pub Vec<Vec<f64>>);

impl Rounds {
    /// Whether the difference of each variant from the first one has a small interval.
    fn are_enough(&self) -> bool {
        let whole = self.of(0).mean;
        (1..self.0.len()).all(|variant| {
            let difference = self.difference(variant, 0);
            let small = (SMALL * difference.mean.abs()).max(SMALL_SHARE * whole);
            difference.half_width <= small
        })
    }

    /// Time of a variant.
    pub fn of(&self, variant: usize) -> Measured {
        Measured::of(&self.0[variant])
    }

    /// Cost of an effect: `own` is the variant as in the scene, `other` the one with the effect switched.
    pub fn effect(&self, on: bool, own: usize, other: usize) -> Measured {
        match on {
            true => self.difference(own, other),
            false => self.difference(other, own),
        }
    }

    /// Additional time of one variant relative to another.
    pub fn difference(&self, with: usize, without: usize) -> Measured {
        let pairs = self.0[with].iter().zip(&self.0[without]);
        Measured::of(
            &pairs
                .map(|(with, without)| with - without)
                .collect::<Vec<_>>(),
        )
    }
}

/// Result of some work on this thread, and its CPU time, s. Other threads do not count.
pub(super) fn thread_timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = ThreadTime::now();
    let result = work();
    (result, began.elapsed().as_secs_f64())
}

/// Result of some work, and the CPU time of all threads, s.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = ProcessTime::now();
    let result = work();
    (result, began.elapsed().as_secs_f64())
}
