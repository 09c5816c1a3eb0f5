//! Error budget: the cheapest combination of all numerical settings for a total error.
//!
//! The error of each quantity is modelled as the sum of the contributions of all sources. Each contribution is
//! measured by refining one source alone, while the others keep a fine setting: the difference from the finest
//! level, with the extrapolated error of that level. The cost is a product of evaluations of the right-hand side
//! and the time of one. Among all combinations of levels whose modelled errors are within the target, the
//! cheapest is taken, run, and compared with a run in which every source is at its next finer level. The verified
//! error is 1.25 times their difference plus the modelled error of the finer run, for the averaging time that of the
//! choice, because the phase of a window is a matter of chance. If it exceeds the target, the model is
//! corrected by the ratio of verified and modelled error, and the choice is repeated.

mod model;
mod observe;
mod quantity;
mod refinement;
mod result;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::baseline::{Baseline, CostError, timed};
use super::trajectory::integrate;
use crate::dynamics::SolverStats;
use crate::pipeline::prepare_reusing_body;
use crate::scene::{AccuracyBudget, Scene, SceneSetting};
use crate::study::OnProgress;
use model::{Combination, Model, contributions};
use observe::{Observation, Window, observe};
use refinement::{AVERAGING, Refinement, integrator, others};

pub use model::{ErrorSource, LevelCost, SourceLevel};
pub use quantity::{BUDGET_TARGETS, Quantity, QuantityValue};
pub use refinement::Source;
pub(super) use result::budget_sets;
pub use result::{BudgetChoice, ErrorBudget, SourceShare, UnreachedTarget};

/// Time before each measurement, s, and measurement time of the runs that compare levels, s; times the factor of
/// the plan.
const SETTLING: f64 = 0.1;
const COMPARED_TIME: f64 = 0.32;

/// Runs of each averaging time, in successive windows.
const WINDOWS: usize = 3;

/// Safety factor on the difference between two runs, that of the grid convergence index (P. J. Roache, J. Fluids
/// Eng. 116 (1994) 405) for more than two levels.
const SAFETY: f64 = 1.25;

/// Maximum number of combinations verified for a target.
const MAX_TRIES: usize = 3;

/// The runs of a budget.
struct Runs<'a, 'b> {
    baseline: &'a mut Baseline<'b>,
    scene: Scene,
    quantities: Vec<Quantity>,
    /// Settings of all runs that compare levels.
    fine: Vec<SceneSetting>,
    /// Factor on all times.
    factor: f64,
    watch: OnProgress<'a, f64>,
    /// Runs done and expected.
    done: usize,
    expected: usize,
}

/// Measures the sources and chooses the settings for each target; `None` if stopped.
pub(super) fn error_budget(
    baseline: &mut Baseline<'_>,
    watch: OnProgress<'_, f64>,
) -> Result<Option<ErrorBudget>, CostError> {
    let plan = baseline.plan;
    // The plan has no analyses, but the text of the scene has them.
    let scene = plan.scene.with_settings(&[])?;
    let factor = plan.time_factor;
    let settling = baseline.transient + factor * SETTLING;
    let mut refinements = Vec::new();
    if plan.quantities.iter().any(|quantity| !quantity.is_linear()) {
        refinements.push(integrator(&scene));
    }
    refinements.extend(others(&scene, settling, factor, !refinements.is_empty()));
    let fine = fine_settings(&scene);
    let runs: usize = refinements
        .iter()
        .map(|refinement| refinement.levels.len())
        .sum();
    let mut runs = Runs {
        expected: runs + 1 + 2 * plan.targets.len() + (WINDOWS - 1) * AVERAGING.len(),
        baseline,
        scene,
        quantities: plan.quantities.clone(),
        fine,
        factor,
        watch,
        done: 0,
    };
    let Some((base, cost)) = runs.base()? else {
        return Ok(None);
    };
    let mut budget = ErrorBudget {
        quantities: values(&runs.quantities, &base),
        ..ErrorBudget::default()
    };
    runs.quantities = budget.defined().collect();
    if runs.quantities.is_empty() {
        return Ok(Some(budget));
    }
    for refinement in &refinements {
        let Some(source) = runs.source(refinement, &base, cost)? else {
            return Ok(None);
        };
        budget.sources.push(source);
    }
    let model = Model {
        refinements: &refinements,
        sources: &budget.sources,
        base: cost,
        settling: factor * SETTLING,
        averaging: AVERAGING.iter().map(|time| factor * time).collect(),
        quantities: runs.quantities.len(),
    };
    let all = model.combinations();
    budget.trade_off = trade_off(&model, &all);
    let (mut choices, mut unreached) = (Vec::new(), Vec::new());
    for &target in &plan.targets {
        match runs.choose(&model, &all, target, &base)? {
            None => return Ok(None),
            Some(Ok(choice)) => choices.push(choice),
            Some(Err(reason)) => unreached.push(UnreachedTarget { target, reason }),
        }
    }
    (budget.choices, budget.unreached) = (choices, unreached);
    Ok(Some(budget))
}

/// Settings at which the levels of a source are compared: a fine tolerance.
fn fine_settings(scene: &Scene) -> Vec<SceneSetting> {
    let integrator = integrator(scene);
    integrator.levels[integrator.reference() - 2]
        .settings
        .clone()
}

/// The quantities with their values.
fn values(quantities: &[Quantity], base: &Observation) -> Vec<QuantityValue> {
    let pairs = quantities.iter().zip(&base.values);
    let value = |(&quantity, value): (&Quantity, &Result<f64, String>)| QuantityValue {
        quantity,
        value: value.as_ref().ok().copied(),
        undefined: value.as_ref().err().cloned(),
    };
    pairs.map(value).collect()
}

impl Runs<'_, '_> {
    /// Observes a scene from a state; `None` if stopped.
    fn observe(
        &mut self,
        settings: &[SceneSetting],
        start: &[f64],
        settling: f64,
        time: f64,
    ) -> Result<Option<Observation>, CostError> {
        let share = (self.done as f64 / self.expected as f64).min(1.0);
        self.done += 1;
        let scene = self.scene.with_settings(settings)?;
        let window = Window {
            start,
            settling: self.factor * settling,
            time: self.factor * time,
        };
        let ball = &mut self.baseline.ball;
        let watch = &mut self.watch;
        if !watch(share) {
            return Ok(None);
        }
        observe(&scene, &self.quantities, &window, ball, &mut || {
            watch(share)
        })
    }

    /// The run that the levels are compared with, and its cost.
    fn base(&mut self) -> Result<Option<(Observation, LevelCost)>, CostError> {
        let (fine, start) = (self.fine.clone(), self.baseline.state.clone());
        let Some(base) = self.observe(&fine, &start, SETTLING, COMPARED_TIME)? else {
            return Ok(None);
        };
        let cost = self.cost(&fine, &base)?;
        Ok(Some((base, cost)))
    }

    /// Cost of a run with some settings that was observed.
    fn cost(
        &mut self,
        settings: &[SceneSetting],
        run: &Observation,
    ) -> Result<LevelCost, CostError> {
        let scene = self.scene.with_settings(settings)?;
        let mut ball = None;
        let (prepared, setup) = timed(1, || prepare_reusing_body(&scene, &mut ball));
        prepared?;
        if run.state.is_empty() {
            // Linear modes need no simulation.
            return Ok(LevelCost {
                setup,
                rhs_evals: 0.0,
                rhs_eval: 0.0,
            });
        }
        let mut stats = SolverStats::default();
        let (repeats, horizon) = (self.baseline.plan.repeats, self.baseline.plan.horizon);
        let (path, seconds) = timed(repeats, || {
            let go = &mut || true;
            let path = integrate(&scene, &run.state, horizon, &mut ball, &mut stats, go);
            path.map_err(|error| CostError::NoReference(error.to_string()))
        });
        path?;
        Ok(LevelCost {
            setup,
            rhs_evals: run.rhs_evals,
            rhs_eval: seconds / stats.rhs_evals as f64,
        })
    }

    /// Measures all levels of a source; `None` if stopped. `base` and `cost` are those of the run with the fine
    /// settings.
    fn source(
        &mut self,
        refinement: &Refinement,
        base: &Observation,
        cost: LevelCost,
    ) -> Result<Option<ErrorSource>, CostError> {
        let mut observed = Vec::new();
        let mut costs = Vec::new();
        let mut state = base.state.clone();
        for (k, level) in refinement.levels.iter().enumerate() {
            let settings = [&self.fine[..], &refinement.with, &level.settings].concat();
            let mut runs = Vec::new();
            if refinement.source == Source::Averaging {
                // Successive windows of one motion.
                for _ in 0..WINDOWS {
                    let fine = self.fine.clone();
                    let Some(run) = self.observe(&fine, &state, 0.0, AVERAGING[k])? else {
                        return Ok(None);
                    };
                    state.clone_from(&run.state);
                    runs.push(run);
                }
            } else {
                let Some(run) = self.observe(&settings, &base.state, SETTLING, COMPARED_TIME)?
                else {
                    return Ok(None);
                };
                runs.push(run);
            }
            costs.push(match refinement.source {
                _ if runs[0].has_failed() => LevelCost::default(),
                // The same system: only the number of evaluations differs.
                Source::Integrator => LevelCost {
                    rhs_evals: runs[0].rhs_evals,
                    ..cost
                },
                Source::Averaging => cost,
                _ => self.cost(&settings, &runs[0])?,
            });
            observed.push(runs);
        }
        let quantities = 0..self.quantities.len();
        let errors: Vec<_> = quantities
            .map(|q| contributions(refinement, &observed, q))
            .collect();
        let levels = refinement.levels.iter().zip(costs).enumerate();
        let levels = levels.map(|(k, (level, cost))| SourceLevel {
            setting: level.label.clone(),
            errors: errors.iter().map(|errors| errors[k]).collect(),
            cost,
        });
        Ok(Some(ErrorSource {
            source: refinement.source,
            levels: levels.collect(),
        }))
    }

    /// The cheapest verified combination for a target, or the reason why there is none; `None` if stopped.
    fn choose(
        &mut self,
        model: &Model<'_>,
        all: &[Combination],
        target: f64,
        base: &Observation,
    ) -> Result<Option<Result<BudgetChoice, String>>, CostError> {
        let mut corrections = vec![1.0; self.quantities.len()];
        let mut choice = None;
        for tries in 1..=MAX_TRIES {
            let corrected = |combination: &Combination| -> Vec<f64> {
                let errors = model.errors(combination).unwrap_or_default();
                errors
                    .iter()
                    .zip(&corrections)
                    .map(|(error, factor)| error * factor)
                    .collect()
            };
            let fits =
                |combination: &&Combination| corrected(combination).iter().all(|e| *e <= target);
            let cheaper =
                |a: &&Combination, b: &&Combination| model.seconds(a).total_cmp(&model.seconds(b));
            let Some(combination) = all.iter().filter(fits).min_by(cheaper) else {
                return Ok(Some(choice.ok_or_else(|| self.shortfall(model, all))));
            };
            let Some(found) = self.verify(model, combination, target, base)? else {
                return Ok(None);
            };
            let found = BudgetChoice { tries, ..found };
            if found.verified {
                return Ok(Some(Ok(found)));
            }
            let verified = self.quantities.iter().map(|quantity| {
                let error = found.budget.errors.get(quantity.name());
                error.copied().unwrap_or(f64::INFINITY)
            });
            for ((correction, error), predicted) in
                corrections.iter_mut().zip(verified).zip(&found.predicted)
            {
                if error > target {
                    *correction = (error / predicted).max(*correction);
                }
            }
            choice = Some(found);
        }
        Ok(choice.map(Ok))
    }

    /// Why no combination reaches a target.
    fn shortfall(&self, model: &Model<'_>, all: &[Combination]) -> String {
        let smallest = |quantity: usize| {
            let errors = all
                .iter()
                .filter_map(|combination| Some(model.errors(combination)?[quantity]));
            errors.fold(f64::INFINITY, f64::min)
        };
        let parts = self.quantities.iter().enumerate();
        let parts = parts.map(|(k, quantity)| format!("{} {:.1e}", quantity.name(), smallest(k)));
        let parts: Vec<String> = parts.collect();
        format!(
            "smallest error of the available levels: {}",
            parts.join(", ")
        )
    }

    /// Runs a combination and the next finer one; `None` if stopped.
    fn verify(
        &mut self,
        model: &Model<'_>,
        combination: &Combination,
        target: f64,
        base: &Observation,
    ) -> Result<Option<BudgetChoice>, CostError> {
        let finer = model.finer(combination);
        let mut observed = Vec::new();
        for levels in [combination, &finer] {
            let settings = settings(model.refinements, levels);
            let time = model.averaging_time(levels) / self.factor;
            let Some(run) = self.observe(&settings, &base.state, SETTLING, time)? else {
                return Ok(None);
            };
            observed.push(run);
        }
        let remaining = model
            .remaining(combination)
            .unwrap_or_else(|| vec![f64::INFINITY; self.quantities.len()]);
        let error = |k: usize| match (&observed[0].values[k], &observed[1].values[k]) {
            (Ok(found), Ok(fine)) => SAFETY * ((found - fine) / fine).abs() + remaining[k],
            _ => f64::INFINITY,
        };
        let errors = self.quantities.iter().enumerate();
        let errors = errors.map(|(k, quantity)| (quantity.name().to_owned(), error(k)));
        // A quantity that one of the runs does not have is omitted.
        let errors: BTreeMap<String, f64> = errors.filter(|(_, e)| e.is_finite()).collect();
        let settings = settings(model.refinements, combination);
        let predicted = model.errors(combination).unwrap_or_default();
        let limiting = (0..predicted.len()).max_by(|&a, &b| error(a).total_cmp(&error(b)));
        Ok(Some(BudgetChoice {
            verified: (0..self.quantities.len()).all(|k| error(k) <= target),
            tries: 1,
            shares: shares(model, combination),
            next: limiting.and_then(|quantity| model.next(combination, quantity)),
            seconds: model.seconds(combination),
            rhs_evals: model.rhs_evals(combination).round() as u64,
            predicted,
            budget: AccuracyBudget {
                target,
                averaging_time: model.averaging_time(combination),
                errors,
                fingerprint: self.scene.with_settings(&settings)?.fingerprint(),
                settings,
            },
        }))
    }
}

/// The keys of a combination.
fn settings(refinements: &[Refinement], combination: &[usize]) -> Vec<SceneSetting> {
    let levels = refinements.iter().zip(combination);
    levels
        .flat_map(|(refinement, &level)| refinement.levels[level].settings.clone())
        .collect()
}

/// Shares of the sources in the errors and the time of a combination.
fn shares(model: &Model<'_>, combination: &Combination) -> Vec<SourceShare> {
    let seconds = model.seconds(combination);
    let share = |(k, source): (usize, &ErrorSource)| {
        let level = &source.levels[combination[k]];
        let known = (0..source.levels.len()).filter(|other| {
            let errors = &source.levels[*other].errors;
            errors.iter().all(Option::is_some)
        });
        let without = known.map(|other| {
            let mut changed = combination.clone();
            changed[k] = other;
            model.seconds(&changed)
        });
        SourceShare {
            source: source.source,
            setting: level.setting.clone(),
            errors: level
                .errors
                .iter()
                .map(|error| error.unwrap_or(f64::NAN))
                .collect(),
            seconds: seconds - without.fold(seconds, f64::min),
        }
    };
    model.sources.iter().enumerate().map(share).collect()
}

/// Time and largest error of the combinations that no other one surpasses in both.
fn trade_off(model: &Model<'_>, all: &[Combination]) -> Vec<[f64; 2]> {
    let largest = |errors: Vec<f64>| errors.into_iter().fold(0.0, f64::max);
    let points = all
        .iter()
        .filter_map(|c| Some([model.seconds(c), largest(model.errors(c)?)]));
    let mut points: Vec<[f64; 2]> = points.collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut smallest = f64::INFINITY;
    points.retain(|point| {
        let better = point[1] < smallest;
        smallest = smallest.min(point[1]);
        better
    });
    points
}
