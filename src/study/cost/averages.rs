//! Knobs whose error is that of an average: invariants, exponents, recurrence quantification.

use super::{CostError, CostPoint, CostSet, Ground, Knob, timed};
use crate::analysis::{
    DelayVectors, Measures, Norm, RateBase, RecurrenceRule, Threshold, deviation, quantify,
};
use crate::dynamics::Exponent;
use crate::pipeline::prepare_on;
use crate::study::response::{From, Response, ResponsePlan, response, section_lag};
use crate::study::sweep::chain_of_causes;

type GoesOn<'a> = &'a mut dyn FnMut(f64) -> bool;

/// Tolerances tried beyond the horizon: `10^-k`; and those of the reference and of the other one that
/// tells its own error.
const TOLERANCES: std::ops::RangeInclusive<i32> = 2..=8;
const REFERENCES: [f64; 2] = [1e-10, 1e-9];

/// Time over which invariants are taken, s.
const LONG: f64 = 0.3;

/// Times averaged for exponents, s, and numbers of tangent vectors.
const AVERAGED: [f64; 6] = [0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
const VECTORS: [usize; 2] = [1, 3];

/// States compared for recurrence; the last is the reference.
const STATES: [usize; 7] = [250, 500, 1000, 2000, 4000, 8000, 16_000];
/// Thresholds, in deviations of the displacement.
const THRESHOLDS: [f64; 3] = [0.25, 0.5, 1.0];
/// Samples a delay; dimension; the shortest line that counts, in delays.
const SAMPLES_A_LAG: usize = 6;
const DIMENSION: usize = 5;
const LEAST_LINE: usize = 4;

/// A number of a settled motion.
type Invariant = fn(&Response) -> Option<f64>;

/// What does not depend on the trajectory.
const INVARIANTS: [(&str, Invariant); 4] = [
    ("strongest frequency", |found| {
        Some(found.lines.first()?.frequency)
    }),
    ("rms velocity", |found| Some(found.rms_velocity)),
    ("λ1 over 1000 1/s", |found| {
        let spectrum = found.exponents.as_ref()?;
        // Of an exponent that is zero there is no relative error.
        Some(1.0 + 1e-3 * spectrum.exponents.first()?.value)
    }),
    ("determinism", |found| {
        found.recurrence.as_ref()?.determinism
    }),
];

/// The scene's own method with other tolerances, by invariants.
pub(super) fn invariant_sets(
    ground: &mut Ground<'_>,
    goes_on: GoesOn<'_>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let look = ResponsePlan {
        least: 0.0,
        most: 0.0,
        measure: LONG,
        exponents: 1,
        portrait: false,
        most_calls: None,
    };
    let mut follow = |tolerance: f64, on: &mut dyn FnMut() -> bool| {
        let mut scene = ground.plan.scene.clone();
        scene.integrator.tolerance = tolerance;
        let from = From::State(&ground.state);
        timed(1, || {
            response(&scene, from, &look, &mut ground.ball, &mut |_| on())
        })
    };
    let all = TOLERANCES.count() + REFERENCES.len();
    let mut best = Vec::new();
    for (k, tolerance) in REFERENCES.into_iter().enumerate() {
        let on = &mut || goes_on(k as f64 / all as f64);
        let Some(found) = follow(tolerance, on).0? else {
            return Ok(None);
        };
        best.push(found);
    }
    let relative = |of: Invariant, found: &Response| {
        let (ours, best) = (of(found)?, of(&best[0])?);
        Some((ours / best - 1.0).abs()).filter(|error| error.is_finite())
    };
    let mut sets: Vec<CostSet> = INVARIANTS
        .iter()
        .map(|&(name, of)| CostSet {
            knob: Knob::Invariants,
            family: name.to_owned(),
            turned: "tolerance",
            floor: relative(of, &best[1]),
            points: Vec::new(),
        })
        .collect();
    for (k, exponent) in TOLERANCES.enumerate() {
        let value = 10f64.powi(-exponent);
        let on = &mut || goes_on((k + REFERENCES.len()) as f64 / all as f64);
        let (found, seconds) = follow(value, on);
        let found = match found {
            Ok(None) => return Ok(None),
            Ok(Some(found)) => Ok(found),
            Err(error) => Err(chain_of_causes(&error)),
        };
        for (set, (_, of)) in sets.iter_mut().zip(INVARIANTS) {
            let error = match &found {
                Ok(found) => relative(of, found).ok_or_else(|| "there is none".to_owned()),
                Err(why) => Err(why.clone()),
            };
            set.points.push(CostPoint {
                value,
                seconds,
                calls: found.as_ref().map_or(0, |found| found.tally.calls),
                error,
            });
        }
    }
    Ok(Some(sets))
}

/// How well the largest exponent is known after so much averaging.
pub(super) fn exponent_sets(
    ground: &mut Ground<'_>,
    goes_on: GoesOn<'_>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let mut sets = Vec::new();
    for (k, vectors) in VECTORS.into_iter().enumerate() {
        let mut points = Vec::new();
        let scene = &ground.plan.scene;
        let prepared = prepare_on(scene, &mut ground.ball)?;
        let system = &*prepared.system;
        let vectors = vectors.min(system.tangent_dim());
        let mut z = prepared.state;
        z.fill(0.0);
        z[..ground.state.len()].copy_from_slice(&ground.state);
        let mut integrator =
            prepared
                .integrator
                .with_tangents(system, vectors, scene.start.seed)?;
        integrator.start(system, 0.0, &z)?;
        let mut spent = 0.0;
        for time in AVERAGED {
            let mut stopped = false;
            // Each goes on from the one before.
            let (done, seconds) = timed(1, || {
                let first = (integrator.time() * scene.sample_rate).round() as u64;
                for sample in first + 1..=(time * scene.sample_rate).round() as u64 {
                    integrator.sample(system, sample as f64 / scene.sample_rate, &mut z)?;
                    if sample % 1024 == 0 && !goes_on((k as f64 + time / 0.64) / 2.0) {
                        stopped = true;
                        break;
                    }
                }
                Ok::<(), crate::dynamics::DynamicsError>(())
            });
            if stopped {
                return Ok(None);
            }
            spent += seconds;
            let known = integrator.exponents();
            let first: Option<Exponent> = known.and_then(|s| s.exponents.first().copied());
            let error = match (done, first) {
                (Err(error), _) => Err(chain_of_causes(&error)),
                (_, Some(e)) if e.half_width.is_finite() => Ok(e.half_width),
                _ => Err("too short to tell".to_owned()),
            };
            points.push(CostPoint {
                value: time,
                seconds: spent,
                calls: integrator.tally().calls,
                error,
            });
        }
        sets.push(CostSet {
            knob: Knob::Exponents,
            family: match vectors {
                1 => "one vector".to_owned(),
                count => format!("{count} vectors"),
            },
            turned: "time, s",
            floor: None,
            points,
        });
    }
    Ok(Some(sets))
}

/// Length and threshold of recurrence quantification, by the determinism of the longest.
pub(super) fn recurrence_sets(
    ground: &mut Ground<'_>,
    goes_on: GoesOn<'_>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = &ground.plan.scene;
    let lag = section_lag(scene);
    let step = lag / SAMPLES_A_LAG as f64;
    let most = STATES[STATES.len() - 1];
    let needed = DelayVectors::samples_for(most, SAMPLES_A_LAG, DIMENSION);
    let mut prepared = prepare_on(scene, &mut ground.ball)?;
    let system = &*prepared.system;
    let mut z = prepared.state;
    z.fill(0.0);
    z[..ground.state.len()].copy_from_slice(&ground.state);
    prepared.integrator.start(system, 0.0, &z)?;
    let mut samples = Vec::with_capacity(needed);
    for k in 1..=needed {
        prepared
            .integrator
            .sample(system, step * k as f64, &mut z)?;
        samples.push(
            prepared
                .probe
                .iter()
                .zip(&z)
                .map(|(p, q)| p * q)
                .sum::<f64>(),
        );
        if k % 1024 == 0 && !goes_on(0.3 * k as f64 / needed as f64) {
            return Ok(None);
        }
    }
    let spread = deviation(&samples);
    let determinism = |states: usize, threshold: f64| -> Result<Option<f64>, CostError> {
        let count = DelayVectors::samples_for(states, SAMPLES_A_LAG, DIMENSION);
        let vectors = DelayVectors::new(&samples[..count], SAMPLES_A_LAG, DIMENSION)?;
        let rule = RecurrenceRule {
            norm: Norm::Euclidean,
            threshold: Threshold::Distance(threshold * spread),
            theiler: SAMPLES_A_LAG,
        };
        let counts = quantify(&vectors, &rule)?;
        let least = LEAST_LINE * SAMPLES_A_LAG;
        let measures: Measures = counts.measures(least, 2, RateBase::Counted);
        Ok(measures.determinism)
    };
    let mut sets = Vec::new();
    for (k, threshold) in THRESHOLDS.into_iter().enumerate() {
        let best = determinism(most, threshold)?;
        let mut points = Vec::new();
        for states in &STATES[..STATES.len() - 1] {
            if !goes_on(0.3 + 0.7 * k as f64 / THRESHOLDS.len() as f64) {
                return Ok(None);
            }
            let (found, seconds) = timed(ground.plan.repeats, || determinism(*states, threshold));
            let error = match (found, best) {
                (Err(error), _) => Err(chain_of_causes(&error)),
                (Ok(Some(found)), Some(best)) => Ok((found - best).abs()),
                _ => Err("nothing recurs".to_owned()),
            };
            points.push(CostPoint {
                value: *states as f64,
                seconds,
                calls: 0,
                error,
            });
        }
        sets.push(CostSet {
            knob: Knob::Recurrence,
            family: format!("within {threshold} deviations"),
            turned: "states",
            floor: None,
            points,
        });
    }
    Ok(Some(sets))
}
