//! The ends of a branch.

use std::ops::RangeInclusive;

use nalgebra::DVector;

use super::follow::BranchState;
use super::locate::Piece;
use super::point::Point;
use super::shape::GuardDistances;
use super::shooting::{Direction, direction};
use super::{Bifurcation, BifurcationKind, BranchEnd, PeriodicOrbit};

/// Relative minimum of a guard below which a branch that cannot be continued ends at a grazing.
const GRAZING: f64 = 1e-2;

/// Distance of the parameter from a grazing that was passed, relative to the distance of the bounds, within which the end of
/// a branch belongs to it.
const NEAR_GRAZING: f64 = 1e-4;

/// Amplitude relative to the largest one of a branch below which it is extrapolated to zero.
const SMALL_AMPLITUDE: f64 = 0.02;

/// Points of a branch before it may close.
const MIN_POINTS: usize = 5;

/// Shares of a step, and distance aside relative to its length, at which it may pass the first point of the branch: a step
/// is a chord of the branch.
const CLOSE: RangeInclusive<f64> = -0.2..=1.2;
const CLOSE_ASIDE: f64 = 0.5;

/// Distance from the first point, relative to the length of the step, at which the branch is closed. Maximum number of orbits
/// to find it.
const CLOSED: f64 = 0.1;
const MAX_CLOSING: usize = 5;

impl BranchState<'_, '_> {
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
        match now.guards {
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
        let dip = |point: &Point| match point.guards {
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

    /// The end of the branch at the present point, if it is one. The bifurcations from index `known` on are those of the last
    /// step.
    pub(super) fn end(&mut self, known: usize) -> Option<BranchEnd> {
        let orbit = &self.now.orbit;
        let is_small = orbit.amplitude < SMALL_AMPLITUDE * self.largest_amplitude;
        if is_small && orbit.is_autonomous() {
            return self.hopf();
        }
        let is_closed = self.found.points.len() >= MIN_POINTS && self.is_closed(known);
        is_closed.then_some(BranchEnd::Closed)
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

    /// Whether the last step passed the first point of the branch. Only the parameter, the period and the deviations are
    /// compared: the phases of the segments change along the branch. Where the first point is close to the chord of the step,
    /// the orbit beside it is computed. Bifurcations of the last step beyond the first point are forgotten: the branch has
    /// passed them before.
    fn is_closed(&mut self, known: usize) -> bool {
        let (Some(before), Some(next)) = (&self.before, self.found.points.first()) else {
            return false;
        };
        let place = |orbit: &PeriodicOrbit| {
            let deviations = DVector::from_column_slice(&orbit.component_deviations);
            direction([&deviations], orbit.period_s, orbit.parameter)
        };
        let scale = &self.now.scale;
        let [start, next, from, to] =
            [&self.first.orbit, next, &before.orbit, &self.now.orbit].map(place);
        let step = &to - &from;
        let length = scale.norm(&step);
        let share_of = |way: &Direction| scale.dot(&step, way) / length.powi(2);
        let passed = &start - &from;
        let mut share = share_of(&passed);
        let aside = scale.norm(&(passed - &step * share));
        let heads_back = scale.dot(&(next - &start), &step) > 0.0;
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
            let missing = &start - place(&point.orbit);
            if scale.norm(&missing) < CLOSED * length {
                let last = self.found.bifurcations.split_off(known);
                let is_new = |found: &Bifurcation| share_of(&(place(&found.orbit) - &from)) < share;
                self.found
                    .bifurcations
                    .extend(last.into_iter().filter(is_new));
                return true;
            }
            share += share_of(&missing);
        }
        false
    }
}

/// The parameter at which both halves of an orbit become equal within a piece: beyond, the branch consists of the same
/// orbits, half a period later, and the change of the state over half a period is reversed.
pub(super) fn halved(piece: Piece<'_>) -> Option<f64> {
    let ends = [piece.from, piece.to];
    // The drive of an odd number of periods does not repeat itself after half of the time.
    let is_odd = |point: &Point| point.shot.drive_periods.is_some_and(|count| count % 2 == 1);
    if ends.into_iter().any(is_odd) {
        return None;
    }
    let scale = &piece.to.scale;
    let halves = ends.map(|point| scale.scaled_state(&point.half));
    let [from, to] = halves.each_ref().map(|half| half.norm());
    let cosine = halves[0].dot(&halves[1]) / (from * to);
    // Not a number for orbits whose halves are equal everywhere.
    (cosine < -0.5).then(|| piece.guess(from / (from + to)).parameter)
}
