//! Knobs whose error is that of an average: invariants, exponents, recurrence quantification.

use super::ground::{Ground, timed};
use super::samples::{DIMENSION, SAMPLES_A_LAG, displacement, recurrence_rule, samples_for};
use super::{CostError, CostPoint, CostSet, Knob};
use crate::analysis::{DelayVectors, RateBase, deviation, quantify};
use crate::dynamics::{DynamicsError, Exponent};
use crate::pipeline::prepare_on;
use crate::study::Watch;
use crate::study::pool::Heed;
use crate::study::response::{From, Response, ResponseError, ResponsePlan, response};
use crate::study::sweep::chain_of_causes;

/// Tolerances tried beyond the horizon: `10^-k`; and those of the reference and of the other one that
/// tells its own error.
const TOLERANCES: std::ops::RangeInclusive<i32> = 2..=8;
const REFERENCES: [f64; 2] = [1e-10, 1e-9];

/// Time over which invariants are taken, s.
pub(super) const LONG: f64 = 0.3;

/// Times averaged for exponents, s, that of the reference, and numbers of tangent vectors.
const AVERAGED: [f64; 6] = [0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
const AVERAGED_REFERENCE: f64 = 2.56;
const VECTORS: [usize; 2] = [1, 3];

/// States compared for recurrence; the last is the reference.
const STATES: [usize; 7] = [250, 500, 1000, 2000, 4000, 8000, 16_000];
/// Thresholds, in deviations of the displacement.
const THRESHOLDS: [f64; 3] = [0.25, 0.5, 1.0];
/// The shortest line that counts, in delays.
const LEAST_LINE: usize = 4;

/// A number of a settled motion.
pub(super) type Invariant = fn(&Response) -> Option<f64>;

/// What does not depend on the trajectory.
pub(super) const INVARIANTS: [(&str, Invariant); 4] = [
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

/// How far an invariant is from the best, relative to it; `None` where there is no such number.
pub(super) fn relative(of: Invariant, found: &Response, best: &Response) -> Option<f64> {
    let error = (of(found)? / of(best)? - 1.0).abs();
    error.is_finite().then_some(error)
}

/// A setting by an invariant of its response.
pub(super) fn invariant_point(
    value: f64,
    seconds: f64,
    found: &Result<Response, ResponseError>,
    best: &Response,
    of: Invariant,
) -> CostPoint {
    CostPoint {
        value,
        seconds,
        calls: found.as_ref().map_or(0, |found| found.tally.calls),
        error: match found {
            Ok(found) => relative(of, found, best).ok_or_else(|| "there is none".to_owned()),
            Err(error) => Err(chain_of_causes(error)),
        },
        detail: String::new(),
    }
}

/// The scene's own method with other tolerances, by invariants.
pub(super) fn invariant_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
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
    let mut sets: Vec<CostSet> = INVARIANTS
        .iter()
        .map(|&(name, of)| CostSet {
            knob: Knob::Invariants,
            family: name.to_owned(),
            turned: "tolerance",
            floor: relative(of, &best[1], &best[0]),
            points: Vec::new(),
        })
        .collect();
    for (k, exponent) in TOLERANCES.enumerate() {
        let value = 10f64.powi(-exponent);
        let on = &mut || goes_on((k + REFERENCES.len()) as f64 / all as f64);
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

/// How well the largest exponent is known after so much averaging. The reference is the run with one
/// vector, carried on.
pub(super) fn exponent_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = &ground.plan.scene;
    let last = AVERAGED[AVERAGED.len() - 1];
    let all = AVERAGED_REFERENCE + last * (VECTORS.len() - 1) as f64;
    let (mut before, mut floor, mut heed) = (0.0, None, Heed::default());
    let mut sets = Vec::new();
    for vectors in VECTORS {
        let prepared = prepare_on(scene, &mut ground.ball)?.starting_from(&ground.state);
        let (system, mut z) = (&*prepared.system, prepared.state);
        let vectors = vectors.min(system.tangent_dim());
        let mut integrator =
            prepared
                .integrator
                .with_tangents(system, vectors, scene.start.seed)?;
        integrator.start(system, 0.0, &z)?;
        // Goes on from where it is. `None` if it was told to stop.
        let mut average = |time: f64| {
            let first = (integrator.time() * scene.sample_rate).round() as u64;
            let done = (|| {
                for sample in first + 1..=(time * scene.sample_rate).round() as u64 {
                    integrator.sample(system, sample as f64 / scene.sample_rate, &mut z)?;
                    if heed.is_due() && !goes_on((before + integrator.time()) / all) {
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
                _ => Err("too short to tell".to_owned()),
            };
            Some((found, integrator.tally().calls))
        };
        let (mut points, mut spent) = (Vec::new(), 0.0);
        for time in AVERAGED {
            let (found, seconds) = timed(1, || average(time));
            let Some((found, calls)) = found else {
                return Ok(None);
            };
            spent += seconds;
            points.push(CostPoint {
                value: time,
                seconds: spent,
                calls,
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
        sets.push(CostSet {
            knob: Knob::Exponents,
            family: match vectors {
                1 => "one vector".to_owned(),
                count => format!("{count} vectors"),
            },
            turned: "time, s",
            floor,
            points,
        });
    }
    Ok(Some(sets))
}

/// Length and threshold of recurrence quantification, by the determinism of the longest; of the next
/// stretch of that length it differs by the reference's own error.
pub(super) fn recurrence_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = &ground.plan.scene;
    let most = STATES[STATES.len() - 1];
    let stretch = samples_for(most);
    let prepared = prepare_on(scene, &mut ground.ball)?.starting_from(&ground.state);
    let on = &mut |share| goes_on(0.3 * share);
    let Some(samples) = displacement(scene, prepared, 2 * stretch, on)? else {
        return Ok(None);
    };
    let (samples, next) = samples.split_at(stretch);
    let spread = deviation(samples);
    let determinism = |samples: &[f64], states: usize, threshold: f64| {
        let samples = &samples[..samples_for(states)];
        let vectors = DelayVectors::new(samples, SAMPLES_A_LAG, DIMENSION)?;
        let counts = quantify(&vectors, &recurrence_rule(threshold * spread))?;
        let measures = counts.measures(LEAST_LINE * SAMPLES_A_LAG, 2, RateBase::Counted);
        Ok::<_, CostError>(measures.determinism)
    };
    let mut sets = Vec::new();
    for (k, threshold) in THRESHOLDS.into_iter().enumerate() {
        let best = determinism(samples, most, threshold)?;
        let other = determinism(next, most, threshold)?;
        let floor = best.zip(other).map(|(best, other)| (other - best).abs());
        let mut points = Vec::new();
        for states in &STATES[..STATES.len() - 1] {
            if !goes_on(0.3 + 0.7 * k as f64 / THRESHOLDS.len() as f64) {
                return Ok(None);
            }
            let (found, seconds) = timed(ground.plan.repeats, || {
                determinism(samples, *states, threshold)
            });
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
                detail: String::new(),
            });
        }
        sets.push(CostSet {
            knob: Knob::Recurrence,
            family: format!("within {threshold} deviations"),
            turned: "states",
            floor,
            points,
        });
    }
    Ok(Some(sets))
}
