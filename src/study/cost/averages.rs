//! Settings whose error is that of an average: invariants, exponents, recurrence quantification.

use super::baseline::{Baseline, timed};
use super::samples::{DIMENSION, SAMPLES_PER_LAG, displacement, recurrence_rule, samples_for};
use super::{CostError, CostSetting, WorkPrecisionPoint, WorkPrecisionSet};
use crate::analysis::{DelayVectors, RateBase, deviation, quantify};
use crate::chain_of_causes;
use crate::dynamics::{DynamicsError, Exponent};
use crate::pipeline::prepare_reusing_body;
use crate::study::OnProgress;
use crate::study::pool::PollTimer;
use crate::study::response::{
    InitialState, ResponseError, ResponsePlan, SettledResponse, response,
};

/// Tolerances of the invariants, `10^-k`; tolerances of the reference and of a second run that gives its
/// error.
const TOLERANCES: std::ops::RangeInclusive<i32> = 2..=8;
const REFERENCES: [f64; 2] = [1e-10, 1e-9];

/// Time over which invariants are averaged, s.
pub(super) const INVARIANT_TIME: f64 = 0.3;

/// Averaging times of exponents, s; that of the reference; numbers of tangent vectors.
const AVERAGED: [f64; 6] = [0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
const AVERAGED_REFERENCE: f64 = 2.56;
const VECTORS: [usize; 2] = [1, 3];

/// Numbers of states compared for recurrence; the last is the reference.
const STATES: [usize; 7] = [250, 500, 1000, 2000, 4000, 8000, 16_000];
/// Recurrence thresholds, standard deviations of the displacement.
const THRESHOLDS: [f64; 3] = [0.25, 0.5, 1.0];
/// Minimum diagonal line length, in delays.
const MIN_LINE_LAGS: usize = 4;

/// A scalar property of a settled motion.
pub(super) type Invariant = fn(&SettledResponse) -> Option<f64>;

/// Invariants: properties that do not depend on the individual trajectory.
pub(super) const INVARIANTS: [(&str, Invariant); 4] = [
    ("strongest frequency", |found| {
        Some(found.lines.first()?.frequency)
    }),
    ("rms velocity", |found| Some(found.rms_velocity)),
    ("λ1 over 1000 1/s", |found| {
        let spectrum = found.exponents.as_ref()?;
        // A relative error needs an offset, because the exponent may be zero.
        Some(1.0 + 1e-3 * spectrum.exponents.first()?.value)
    }),
    ("determinism", |found| {
        found.recurrence.as_ref()?.determinism
    }),
];

/// Relative error of an invariant; `None` if the invariant does not exist.
pub(super) fn relative(
    of: Invariant,
    found: &SettledResponse,
    best: &SettledResponse,
) -> Option<f64> {
    let error = (of(found)? / of(best)? - 1.0).abs();
    error.is_finite().then_some(error)
}

/// A work-precision point: a setting and the error of an invariant.
pub(super) fn invariant_point(
    value: f64,
    seconds: f64,
    found: &Result<SettledResponse, ResponseError>,
    best: &SettledResponse,
    of: Invariant,
) -> WorkPrecisionPoint {
    WorkPrecisionPoint {
        value,
        seconds,
        rhs_evals: found.as_ref().map_or(0, |found| found.stats.rhs_evals),
        error: match found {
            Ok(found) => {
                relative(of, found, best).ok_or_else(|| "the motion has no such value".to_owned())
            }
            Err(error) => Err(chain_of_causes(error)),
        },
        detail: String::new(),
    }
}

/// The scene's method with different tolerances, by invariants.
pub(super) fn invariant_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let look = ResponsePlan {
        min_transient: 0.0,
        max_transient: 0.0,
        measurement_time: INVARIANT_TIME,
        exponents: 1,
        orbits: false,
        portrait: false,
        max_rhs_evals: None,
    };
    let mut follow = |tolerance: f64, on: &mut dyn FnMut() -> bool| {
        let mut scene = baseline.plan.scene.clone();
        scene.integrator.tolerance = tolerance;
        let from = InitialState::State(&baseline.state);
        timed(1, || {
            response(&scene, from, &look, &mut baseline.ball, &mut |_| on())
        })
    };
    let all = TOLERANCES.count() + REFERENCES.len();
    let mut best = Vec::new();
    for (k, tolerance) in REFERENCES.into_iter().enumerate() {
        let on = &mut || should_continue(k as f64 / all as f64);
        let Some(found) = follow(tolerance, on).0? else {
            return Ok(None);
        };
        best.push(found);
    }
    let mut sets: Vec<WorkPrecisionSet> = INVARIANTS
        .iter()
        .map(|&(name, of)| WorkPrecisionSet {
            setting: CostSetting::Invariants,
            family: name.to_owned(),
            parameter: "tolerance".into(),
            floor: relative(of, &best[1], &best[0]),
            points: Vec::new(),
        })
        .collect();
    for (k, exponent) in TOLERANCES.enumerate() {
        let value = 10f64.powi(-exponent);
        let on = &mut || should_continue((k + REFERENCES.len()) as f64 / all as f64);
        let (found, seconds) = follow(value, on);
        let Some(found) = found.transpose() else {
            return Ok(None);
        };
        for (set, (_, of)) in sets.iter_mut().zip(INVARIANTS) {
            let point = invariant_point(value, seconds, &found, &best[0], of);
            set.points.push(point);
        }
    }
    Ok(Some(sets))
}

/// Half-width of the largest exponent against averaging time. The reference continues the run with one
/// tangent vector.
pub(super) fn exponent_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let scene = &baseline.plan.scene;
    let last = AVERAGED[AVERAGED.len() - 1];
    let all = AVERAGED_REFERENCE + last * (VECTORS.len() - 1) as f64;
    let (mut before, mut floor, mut timer) = (0.0, None, PollTimer::default());
    let mut sets = Vec::new();
    for vectors in VECTORS {
        let prepared =
            prepare_reusing_body(scene, &mut baseline.ball)?.starting_from(&baseline.state);
        let (system, mut z) = (&*prepared.system, prepared.state);
        let vectors = vectors.min(system.tangent_dim());
        let mut integrator =
            prepared
                .integrator
                .with_tangents(system, vectors, scene.start.seed)?;
        integrator.start(system, 0.0, &z)?;
        // Continues up to a time; `None` if stopped.
        let mut average = |time: f64| {
            let first = (integrator.time() * scene.sample_rate).round() as u64;
            let done = (|| {
                for sample in first + 1..=(time * scene.sample_rate).round() as u64 {
                    integrator.sample(system, sample as f64 / scene.sample_rate, &mut z)?;
                    if timer.is_due() && !should_continue((before + integrator.time()) / all) {
                        return Ok(false);
                    }
                }
                Ok::<_, DynamicsError>(true)
            })();
            let known = integrator.exponents();
            let first: Option<Exponent> = known.and_then(|s| s.exponents.first().copied());
            let found = match (done, first) {
                (Ok(false), _) => return None,
                (Err(error), _) => Err(chain_of_causes(&error)),
                (_, Some(e)) if e.half_width.is_finite() => Ok(e),
                _ => Err("averaging time too short for an interval".to_owned()),
            };
            Some((found, integrator.stats().rhs_evals))
        };
        let (mut points, mut spent) = (Vec::new(), 0.0);
        for time in AVERAGED {
            let (found, seconds) = timed(1, || average(time));
            let Some((found, rhs_evals)) = found else {
                return Ok(None);
            };
            spent += seconds;
            points.push(WorkPrecisionPoint {
                value: time,
                seconds: spent,
                rhs_evals,
                detail: found
                    .as_ref()
                    .map_or_else(|_| String::new(), |e| format!("λ1 {:.1} 1/s", e.value)),
                error: found.map(|e| e.half_width),
            });
        }
        if floor.is_none() {
            let Some((found, _)) = average(AVERAGED_REFERENCE) else {
                return Ok(None);
            };
            floor = found.ok().map(|e| e.half_width);
            before = AVERAGED_REFERENCE;
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Exponents,
            family: match vectors {
                1 => "one tangent vector".to_owned(),
                count => format!("{count} tangent vectors"),
            },
            parameter: "averaging time, s".into(),
            floor,
            points,
        });
    }
    Ok(Some(sets))
}

/// Number of states and threshold of recurrence quantification, by the determinism of the longest signal. The
/// difference from the next window of equal length is the error of the reference.
pub(super) fn recurrence_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let scene = &baseline.plan.scene;
    let most = STATES[STATES.len() - 1];
    let window = samples_for(most);
    let prepared = prepare_reusing_body(scene, &mut baseline.ball)?.starting_from(&baseline.state);
    let on = &mut |share| should_continue(0.3 * share);
    let Some(samples) = displacement(scene, prepared, 2 * window, on)? else {
        return Ok(None);
    };
    let (samples, next) = samples.split_at(window);
    let spread = deviation(samples);
    let determinism = |samples: &[f64], states: usize, threshold: f64| {
        let samples = &samples[..samples_for(states)];
        let vectors = DelayVectors::new(samples, SAMPLES_PER_LAG, DIMENSION)?;
        let counts = quantify(&vectors, &recurrence_rule(threshold * spread))?;
        let measures = counts.measures(MIN_LINE_LAGS * SAMPLES_PER_LAG, 2, RateBase::Counted);
        Ok::<_, CostError>(measures.determinism)
    };
    let mut sets = Vec::new();
    for (k, threshold) in THRESHOLDS.into_iter().enumerate() {
        let best = determinism(samples, most, threshold)?;
        let other = determinism(next, most, threshold)?;
        let floor = best.zip(other).map(|(best, other)| (other - best).abs());
        let mut points = Vec::new();
        for states in &STATES[..STATES.len() - 1] {
            if !should_continue(0.3 + 0.7 * k as f64 / THRESHOLDS.len() as f64) {
                return Ok(None);
            }
            let (found, seconds) = timed(baseline.plan.repeats, || {
                determinism(samples, *states, threshold)
            });
            let error = match (found, best) {
                (Err(error), _) => Err(chain_of_causes(&error)),
                (Ok(Some(found)), Some(best)) => Ok((found - best).abs()),
                _ => Err("nothing recurs".to_owned()),
            };
            points.push(WorkPrecisionPoint {
                value: *states as f64,
                seconds,
                rhs_evals: 0,
                error,
                detail: String::new(),
            });
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Recurrence,
            family: format!("threshold {threshold} standard deviations"),
            parameter: "states".into(),
            floor,
            points,
        });
    }
    Ok(Some(sets))
}
