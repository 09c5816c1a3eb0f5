//! Measurements in turns: what a machine does meanwhile troubles all of them alike.

use cpu_time::{ProcessTime, ThreadTime};
use serde::Serialize;

use crate::study::Watch;

/// Why something failed.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Rounds in which each variant has its turn. One more comes first, which finds the caches cold and is not
/// counted.
const ROUNDS: usize = 4;

/// Student's t of so many rounds for 95 %.
const STUDENT: f64 = 3.18;

/// Stages whose progress is told.
const STAGES: f64 = 5.0;

/// A number with its scatter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// The mean.
    pub mean: f64,
    /// Half-width of its interval of 95 %.
    pub half_width: f64,
}

impl Measured {
    /// By repeated measurements, two at least.
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let deviation = (squares / (n - 1.0).max(1.0)).sqrt();
        Self {
            mean,
            half_width: STUDENT * deviation / n.sqrt(),
        }
    }

    /// Times a factor.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            mean: factor * self.mean,
            half_width: factor.abs() * self.half_width,
        }
    }

    /// Whether it is not just scatter.
    pub fn is_told(self) -> bool {
        self.mean.abs() > self.half_width
    }
}

/// Takes measurements in turns.
pub(super) struct Bench<'w> {
    pub watch: Watch<'w, f64>,
    /// Stages that are done.
    pub stage: f64,
}

impl Bench<'_> {
    /// Tells the share of the present stage that is done; whether to go on.
    pub fn goes_on(&mut self, share: f64) -> bool {
        (self.watch)(((self.stage + share) / STAGES).min(1.0))
    }

    /// Lets each variant have its turn in each round; `run` gives what it takes. `None` if it was told to stop.
    pub fn rounds(
        &mut self,
        variants: usize,
        run: &mut dyn FnMut(usize) -> Result<f64, Cause>,
    ) -> Result<Option<Rounds>, Cause> {
        let mut taken = vec![Vec::with_capacity(ROUNDS); variants];
        for round in 0..=ROUNDS {
            for (variant, taken) in taken.iter_mut().enumerate() {
                let found = run(variant);
                // Cut short, it says nothing, and a fault of it is none.
                let done = (round * variants + variant + 1) as f64;
                if !self.goes_on(done / ((ROUNDS + 1) * variants) as f64) {
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
        Ok(Some(Rounds(taken)))
    }
}

/// What each variant has taken in each round.
pub(super) struct Rounds(pub Vec<Vec<f64>>);

impl Rounds {
    /// What a variant takes.
    pub fn of(&self, variant: usize) -> Measured {
        Measured::of(&self.0[variant])
    }

    /// What an effect takes that tells one variant, where it is as in the scene, from another, where it is not.
    pub fn effect(&self, on: bool, own: usize, other: usize) -> Measured {
        match on {
            true => self.difference(own, other),
            false => self.difference(other, own),
        }
    }

    /// How much more one variant takes than another.
    pub fn difference(&self, with: usize, without: usize) -> Measured {
        let pairs = self.0[with].iter().zip(&self.0[without]);
        Measured::of(
            &pairs
                .map(|(with, without)| with - without)
                .collect::<Vec<_>>(),
        )
    }
}

/// Result of some work of this thread alone, and the CPU time that it took, s: whatever others do meanwhile.
pub(super) fn timed_here<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = ThreadTime::now();
    let result = work();
    (result, began.elapsed().as_secs_f64())
}

/// Result of some work, and the CPU time of all threads that it took, s.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = ProcessTime::now();
    let result = work();
    (result, began.elapsed().as_secs_f64())
}
