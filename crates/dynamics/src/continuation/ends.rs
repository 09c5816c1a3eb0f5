//! The ends of a branch.

use std::ops::RangeInclusive;

use nalgebra::DVector;

use super::follow::Course;
use super::locate::Piece;
use super::point::Point;
use super::shape::GuardDistances;
use super::shot::{Direction, Shot};
use super::{Bifurcation, BifurcationKind, BranchEnd, ContinuationError, PeriodicOrbit};

/// Relative minimum of a guard below which a branch that cannot be continued ends at a grazing.
const GRAZING: f64 = 1e-2;

/// Distance of the parameter from a grazing that was passed, relative to the distance of the bounds, within which the end of
/// a branch belongs to it.
const NEAR_GRAZING: f64 = 1e-4;

/// Amplitude relative to the largest one of a branch below which it is extrapolated to zero.
const SMALL_AMPLITUDE: f64 = 0.02;

/// Distance of an orbit from itself half a period later, relative to its size, at which it has half the period: at the
/// point where this happens it grows with the square root of the distance from there.
const HALVED: f64 = 1e-2;

/// Points of a branch before it may close.
const MIN_POINTS: usize = 5;

/// Shares of a step, and distance aside relative to its length, at which it may pass the first point of the branch: a step
/// is a chord of the branch.
const CLOSE: RangeInclusive<f64> = -0.2..=1.2;
const CLOSE_ASIDE: f64 = 0.5;

/// Distance from the first point, relative to the length of the step, at which the branch is closed: the amplitudes are
/// those of samples of the orbits. Maximum number of orbits to find it.
const CLOSED: f64 = 0.1;
const MAX_CLOSING: usize = 5;

impl Course<'_, '_> {
    /// The end of a branch on which no further point was found.
    pub(super) fn end_of_failure(&mut self, message: &str) -> BranchEnd {
        let now = &self.now;
        let is_small = now.orbit.amplitude < 2.0 * SMALL_AMPLITUDE * self.largest_amplitude;
        if let Some(end) = self.hopf().filter(|_| is_small) {
            return end;
        }
        // The orbits beyond a grazing may exist only in its neighbourhood, or not be found.
        if let Some(grazing) = self.found.bifurcations.last()
            && grazing.kind == BifurcationKind::Grazing
            && (grazing.parameter - now.orbit.parameter).abs() <= NEAR_GRAZING * self.flow.width()
        {
            return BranchEnd::Grazing {
                parameter: grazing.parameter,
                guard: grazing.guard,
            };
        }
        match now.shape.guards {
            GuardDistances::ClosestDip(Some((guard, least))) if least < GRAZING => {
                let grazing = self.grazing(now.orbit.parameter);
                let parameter = grazing.parameter;
                self.found.bifurcations.push(grazing);
                BranchEnd::Grazing {
                    parameter,
                    guard: Some(guard),
                }
            }
            _ => BranchEnd::NotConverged {
                message: message.to_owned(),
            },
        }
    }

    /// The grazing after the present point, before an orbit at the parameter `beyond` that has other events, or that cannot
    /// be reached. The distance from the guard is extrapolated to zero.
    pub(super) fn grazing(&self, beyond: f64) -> Bifurcation {
        let now = &self.now;
        let here = now.orbit.parameter;
        let dip = |point: &Point| match point.shape.guards {
            GuardDistances::ClosestDip(dip) => dip,
            GuardDistances::Minima(_) => None,
        };
        let last = self
            .before
            .as_ref()
            .and_then(|before| dip(before).map(|dip| (before.orbit.parameter, dip)))
            .zip(dip(now));
        let extrapolated = last.and_then(|((earlier, (guard_before, a)), (guard, b))| {
            (guard == guard_before && a > b).then(|| here + (here - earlier) * b / (a - b))
        });
        let parameter = extrapolated.unwrap_or(0.5 * (here + beyond));
        Bifurcation {
            kind: BifurcationKind::Grazing,
            parameter,
            accuracy: (parameter - here).abs().max((beyond - here).abs()),
            frequency_hz: now.orbit.frequency_hz(),
            rotation_number: None,
            torus_frequency_hz: None,
            resonance: None,
            crossing_rate: None,
            birth: None,
            fold_curvature: None,
            guard: dip(now).map(|(guard, _)| guard),
            unstable_change: 0,
            orbit: now.orbit.clone(),
        }
    }

    /// The end of the branch at the present point, if it is one.
    pub(super) fn end(&mut self) -> Option<BranchEnd> {
        let orbit = &self.now.orbit;
        if orbit.period_s > self.flow.options.max_period_s {
            return Some(BranchEnd::PeriodTooLong {
                period_s: orbit.period_s,
            });
        }
        let is_small = orbit.amplitude < SMALL_AMPLITUDE * self.largest_amplitude;
        if is_small && orbit.is_autonomous() {
            return self.hopf();
        }
        if self.found.points.len() >= MIN_POINTS && self.is_closed() {
            return Some(BranchEnd::Closed);
        }
        self.halved()
            .map(|parameter| BranchEnd::PeriodHalved { parameter })
    }

    /// The Hopf point at which the amplitude vanishes. The parameter and the period change with the square of the amplitude.
    fn hopf(&self) -> Option<BranchEnd> {
        let before = &self.before.as_ref()?.orbit;
        let now = &self.now.orbit;
        let [a, b] = [before, now].map(|orbit| orbit.amplitude.powi(2));
        if b >= a {
            return None;
        }
        let at_zero = |before: f64, now: f64| (now * a - before * b) / (a - b);
        Some(BranchEnd::Hopf {
            parameter: at_zero(before.parameter, now.parameter),
            frequency_hz: 1.0 / at_zero(before.period_s, now.period_s),
        })
    }

    /// Whether the last step passed the first point of the branch. Only the parameter, the period and the amplitudes are
    /// compared: the phases of the segments change along the branch. Where the first point is close to the chord of the step,
    /// the orbit beside it is computed.
    fn is_closed(&mut self) -> bool {
        let (Some(before), Some(next)) = (&self.before, self.found.points.first()) else {
            return false;
        };
        let place = |orbit: &PeriodicOrbit| Direction {
            parameter: orbit.parameter,
            period: orbit.period_s,
            states: vec![DVector::from_column_slice(&orbit.component_amplitudes)],
        };
        let scale = &self.now.scale;
        let from_to = |a: &Direction, b: &Direction| b.clone().plus(-1.0, a);
        let [start, next, from, to] =
            [&self.first.orbit, next, &before.orbit, &self.now.orbit].map(place);
        let step = from_to(&from, &to);
        let length = scale.norm(&step);
        let share_of = |way: &Direction| scale.dot(&step, way) / length.powi(2);
        let passed = from_to(&from, &start);
        let mut share = share_of(&passed);
        let aside = scale.norm(&passed.plus(-share, &step));
        let heads_back = scale.dot(&from_to(&start, &next), &step) > 0.0;
        if !heads_back || !CLOSE.contains(&share) || aside > CLOSE_ASIDE * length {
            return false;
        }
        let piece = Piece {
            from: before,
            to: &self.now,
        };
        for _ in 0..MAX_CLOSING {
            let Ok(point) = self.flow.point_within(piece, share) else {
                return false;
            };
            let missing = from_to(&place(&point.orbit), &start);
            if scale.norm(&missing) < CLOSED * length {
                return true;
            }
            share += share_of(&missing);
        }
        false
    }

    /// The parameter at which the orbit and the same orbit half a period later change places in the last step: both halves
    /// are equal there.
    fn halved(&self) -> Option<f64> {
        let before = self.before.as_ref()?;
        let now = &self.now;
        let [a, b] = [halves(&before.shot)?, halves(&now.shot)?];
        if a.len() != b.len() {
            return None;
        }
        let scale = &now.scale;
        let dot = |a: &[DVector<f64>], b: &[DVector<f64>]| -> f64 {
            let terms = a.iter().zip(b);
            terms.map(|(a, b)| scale.dot_states(a, b)).sum()
        };
        let cosine = dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt();
        // Not a number if both halves are equal everywhere.
        if cosine.is_nan() || cosine > -0.5 {
            return None;
        }
        let [from, to] = [dot(&a, &a), dot(&b, &b)].map(f64::sqrt);
        let share = from / (from + to);
        let piece = Piece {
            from: before,
            to: now,
        };
        Some(piece.guess(share).parameter)
    }

    /// Whether the orbit at which the branch turns repeats itself after half its period: beyond, the branch consists of the
    /// same orbits, half a period later. This holds whatever the phases of the segments are.
    pub(super) fn joins_half(&mut self, turn: &Bifurcation) -> Result<bool, ContinuationError> {
        let is_half = |distance: f64| distance < HALVED;
        let [turn, first] = [Shot::of(&turn.orbit), self.first.shot.clone()];
        Ok(is_half(self.half_distance(&turn)?) && !is_half(self.half_distance(&first)?))
    }

    /// Distance of an orbit from itself half a period later, relative to its size; infinite if the drive does not repeat
    /// itself then.
    fn half_distance(&mut self, shot: &Shot) -> Result<f64, ContinuationError> {
        if shot.drive_periods.is_some_and(|count| count % 2 == 1) {
            return Ok(f64::INFINITY);
        }
        let [start, half] = self.flow.halves(shot)?;
        Ok(self.now.scale.norm_state(&(half - start)))
    }
}

/// The differences of the states of the first and the second half of an orbit with equal phases in both.
fn halves(shot: &Shot) -> Option<Vec<DVector<f64>>> {
    let half = shot.len() / 2;
    let is_double = shot.len().is_multiple_of(2)
        && (0..half).all(|k| (shot.phases[k] + 0.5 - shot.phases[half + k]).abs() < 1e-12);
    is_double.then(|| {
        (0..half)
            .map(|k| &shot.states[k] - &shot.states[half + k])
            .collect()
    })
}
