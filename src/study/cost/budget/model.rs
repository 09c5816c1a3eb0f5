//! Error and cost of a combination of levels, modelled from one-at-a-time refinement.
//!
//! The error of a quantity is the sum of the contributions of all sources. The cost is a product: evaluations of
//! the right-hand side times the time of one, each relative to the runs that were measured.

use serde::{Deserialize, Serialize};

use super::observe::Observation;
use super::refinement::{Refinement, Source};

/// Largest ratio of successive differences for which the remaining error is extrapolated; a sequence that
/// converges more slowly is not in its asymptotic range.
const MAX_RATIO: f64 = 0.5;

/// A source of error with the measured levels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorSource {
    /// The source.
    pub source: Source,
    /// Its levels.
    pub levels: Vec<SourceLevel>,
}

/// A measured level of a source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceLevel {
    /// The setting, such as `100 nodes in rings`.
    pub setting: String,
    /// Contribution to the relative error of each quantity, in the order of the budget; `None` if the quantity
    /// is not defined at this level.
    pub errors: Vec<Option<f64>>,
    /// Cost of a run with this level.
    #[serde(flatten)]
    pub cost: LevelCost,
}

/// Cost of a level: that of its run; 0 if it failed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LevelCost {
    /// CPU time before the first step, s.
    #[serde(rename = "setup_s")]
    pub setup: f64,
    /// Right-hand-side evaluations per simulated second, 1/s; 0 if nothing was simulated.
    #[serde(rename = "rhs_evals_per_s")]
    pub rhs_evals: f64,
    /// CPU time of one evaluation, s.
    #[serde(rename = "rhs_eval_s")]
    pub rhs_eval: f64,
}

/// Contributions of the levels of a refinement to the relative error of a quantity; `runs` are the observations of
/// each level.
///
/// The error of a level is its largest difference from the reference, but not smaller than that of a finer level
/// of its family, because a difference may vanish by chance; with the error of the reference. That error is
/// extrapolated from the last two differences, as a geometric series; if several runs of the reference exist,
/// their scatter is its error.
pub fn contributions(
    refinement: &Refinement,
    runs: &[Vec<Observation>],
    quantity: usize,
) -> Vec<Option<f64>> {
    let value = |run: &Observation| run.values[quantity].as_ref().ok().copied();
    let mean = |level: usize| -> Option<f64> {
        let values: Option<Vec<f64>> = runs[level].iter().map(value).collect();
        let values = values.filter(|values| !values.is_empty())?;
        Some(values.iter().sum::<f64>() / values.len() as f64)
    };
    let last = refinement.reference();
    let Some(best) = mean(last) else {
        return vec![None; runs.len()];
    };
    let deviation = |level: usize| -> Option<f64> {
        let each = runs[level]
            .iter()
            .map(|run| Some((value(run)? - best).abs() + run.half_widths[quantity]));
        each.reduce(|a, b| Some(a?.max(b?)))?
    };
    let step = |level: usize| Some((mean(level)? - mean(refinement.levels[level].finer)?).abs());
    let scatter = deviation(last).unwrap_or(0.0);
    let extrapolated = || {
        let (before, difference) = (step(last.checked_sub(2)?)?, step(last - 1)?);
        let ratio = if difference > 0.0 {
            (difference / before).min(MAX_RATIO)
        } else {
            0.0
        };
        Some(difference * ratio / (1.0 - ratio))
    };
    let floor = match (refinement.exact, scatter > 0.0) {
        (true, _) => 0.0,
        (false, true) => scatter,
        (false, false) => extrapolated().unwrap_or(0.0),
    };
    let error = |level: usize| -> Option<f64> {
        let mut largest = if level == last {
            0.0
        } else {
            deviation(level)?
        };
        let mut finer = refinement.levels[level].finer;
        while finer != last && level != last {
            // An undefined finer level does not invalidate this one.
            largest = deviation(finer).map_or(largest, |found| largest.max(found));
            finer = refinement.levels[finer].finer;
        }
        Some((largest + floor) / best.abs())
    };
    (0..runs.len())
        .map(|level| error(level).filter(|error| error.is_finite()))
        .collect()
}

/// A combination: one level of each source, in the order of the sources.
pub type Combination = Vec<usize>;

/// The model of error and cost.
pub struct Model<'a> {
    pub refinements: &'a [Refinement],
    pub sources: &'a [ErrorSource],
    /// Cost of the run that the levels were compared with.
    pub base: LevelCost,
    /// Time before the measurement, s.
    pub settling: f64,
    /// Averaging times, s.
    pub averaging: Vec<f64>,
    /// Number of quantities.
    pub quantities: usize,
}

impl Model<'_> {
    fn level(&self, source: usize, level: usize) -> &SourceLevel {
        &self.sources[source].levels[level]
    }

    fn index(&self, source: Source) -> Option<usize> {
        self.refinements
            .iter()
            .position(|refinement| refinement.source == source)
    }

    /// Predicted relative errors of the quantities; `None` if one is not defined.
    pub fn errors(&self, combination: &[usize]) -> Option<Vec<f64>> {
        let of = |quantity: usize| {
            let levels = combination.iter().enumerate();
            levels
                .map(|(source, &level)| self.level(source, level).errors[quantity])
                .sum()
        };
        (0..self.quantities).map(of).collect()
    }

    /// Averaging time, s; 0 if nothing is simulated.
    pub fn averaging_time(&self, combination: &[usize]) -> f64 {
        let index = self.index(Source::Averaging);
        index.map_or(0.0, |index| self.averaging[combination[index]])
    }

    /// Right-hand-side evaluations of a run.
    pub fn rhs_evals(&self, combination: &[usize]) -> f64 {
        let time = self.averaging_time(combination);
        if time == 0.0 || self.base.rhs_evals == 0.0 {
            return 0.0;
        }
        let factors = combination.iter().enumerate();
        let factors = factors.map(|(k, &l)| self.level(k, l).cost.rhs_evals / self.base.rhs_evals);
        (self.settling + time) * self.base.rhs_evals * factors.product::<f64>()
    }

    /// CPU time of a run, s: setup, settling and measurement.
    pub fn seconds(&self, combination: &[usize]) -> f64 {
        let costs = || {
            let costs = combination.iter().enumerate();
            costs.map(|(k, &level)| (self.refinements[k].source, self.level(k, level).cost))
        };
        let setup = costs().map(|(_, cost)| cost.setup - self.base.setup);
        let setup = (self.base.setup + setup.sum::<f64>()).max(0.0);
        let factors = costs();
        let factors = factors.map(|(_, cost)| cost.rhs_eval / self.base.rhs_eval);
        if self.base.rhs_evals == 0.0 {
            return setup;
        }
        setup + self.rhs_evals(combination) * self.base.rhs_eval * factors.product::<f64>()
    }

    /// All combinations whose errors are known, and those of the finer combination that verifies them.
    pub fn combinations(&self) -> Vec<Combination> {
        let mut all: Vec<Combination> = vec![Vec::new()];
        for refinement in self.refinements {
            let levels = 0..refinement.levels.len();
            let selectable: Vec<usize> = levels
                .filter(|level| refinement.is_selectable(*level))
                .collect();
            let longer = |combination: &Combination| {
                let next = selectable
                    .iter()
                    .map(|level| [&combination[..], &[*level]].concat());
                next.collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        let is_known = |combination: &[usize]| self.errors(combination).is_some();
        all.retain(|combination| is_known(combination) && is_known(&self.finer(combination)));
        all
    }

    /// The combination at the next finer level of every source.
    pub fn finer(&self, combination: &[usize]) -> Combination {
        let pairs = combination.iter().zip(self.refinements);
        pairs
            .map(|(&level, refinement)| refinement.levels[level].finer)
            .collect()
    }

    /// Errors that remain undetected when a combination is compared with the finer one: those of the finer one,
    /// but with the averaging time of the combination, because the phases of the two windows differ by chance.
    pub fn remaining(&self, combination: &[usize]) -> Option<Vec<f64>> {
        let mut finer = self.finer(combination);
        if let Some(index) = self.index(Source::Averaging) {
            finer[index] = combination[index];
        }
        self.errors(&finer)
    }

    /// The source whose refinement reduces the error of a quantity most per added time; `None` if none reduces it.
    pub fn next(&self, combination: &[usize], quantity: usize) -> Option<Source> {
        let error = |combination: &[usize]| Some(self.errors(combination)?[quantity]);
        let (before, seconds) = (error(combination)?, self.seconds(combination));
        let gains = self
            .refinements
            .iter()
            .enumerate()
            .filter_map(|(k, refinement)| {
                let mut refined = combination.to_vec();
                refined[k] = refinement.levels[refined[k]].finer;
                let gain = before - error(&refined)?;
                let added = (self.seconds(&refined) - seconds).max(1e-3 * seconds);
                (gain > 0.0).then_some((refinement.source, gain / added))
            });
        gains
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(source, _)| source)
    }
}
