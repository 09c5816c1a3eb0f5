//! Location of bifurcations between two points of a branch.

use super::bifurcation::critical_multiplier;
use super::detect::lowest_guard;
use super::flow::Flow;
use super::newton::Precision;
use super::point::Point;
use super::shooting::{ShootingPoint, parameter_of};
use super::{Bifurcation, BifurcationKind, ContinuationError, Multiplier, Resonance};

/// Target for the error of the parameter at a bifurcation, relative to the distance of its bounds.
const ACCURACY: f64 = 1e-9;

/// Maximum number of orbits for the location of one bifurcation.
const MAX_ORBITS: usize = 40;

/// Share of a piece below which a bracket is not divided any more.
const MIN_BRACKET: f64 = 1e-13;

/// Shares of a piece by which orbits stay away from a branch point, one after another.
const OFFSETS: [f64; 12] = [
    0.1, -0.1, 0.04, -0.04, 0.02, -0.02, 0.01, -0.01, 0.005, -0.005, 0.002, -0.002,
];

/// Two successive points with equal phases.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    pub from: &'a Point,
    pub to: &'a Point,
}

impl Piece<'_> {
    /// Second derivative of the parameter with respect to the arclength, from the tangents at both ends.
    fn fold_curvature(self) -> f64 {
        let chord = self.to.shot.minus(&self.from.shot);
        let length = self.from.scale.dot(&self.from.tangent, &chord);
        (parameter_of(&self.to.tangent) - parameter_of(&self.from.tangent)) / length
    }

    /// The cubic through both points with both tangents, at a share of the piece.
    pub fn guess(self, share: f64) -> ShootingPoint {
        let chord = self.to.shot.minus(&self.from.shot);
        let length = self.from.scale.norm(&chord);
        let r = 1.0 - share;
        let bend = (&self.from.tangent * r - &self.to.tangent * share) * (share * r * length);
        self.from
            .shot
            .moved(share * share * (3.0 - 2.0 * share), &chord)
            .moved(1.0, &bend)
    }
}

/// The share and the parameter at the zero of a test function, by inverse interpolation through the triples `[value, share,
/// parameter]` closest to zero, up to four, which come first afterwards.
fn at_zero(known: &mut [[f64; 3]]) -> [f64; 2] {
    known.sort_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
    let nearest = &known[..known.len().min(4)];
    [1, 2].map(|column| {
        // Neville's scheme at zero.
        let mut values: Vec<f64> = nearest.iter().map(|triple| triple[column]).collect();
        for degree in 1..nearest.len() {
            for k in 0..nearest.len() - degree {
                let (x, y) = (nearest[k][0], nearest[k + degree][0]);
                values[k] = (x * values[k + 1] - y * values[k]) / (x - y);
            }
        }
        values[0]
    })
}

impl Flow<'_> {
    /// Locates the zero of a test function, with its share of the piece. `None` if it is no bifurcation.
    pub fn locate(
        &mut self,
        piece: Piece<'_>,
        kind: BifurcationKind,
    ) -> Result<Option<(f64, Bifurcation)>, ContinuationError> {
        if kind == BifurcationKind::BranchPoint {
            return self.locate_branch_point(piece).map(Some);
        }
        let known = |share: f64, point: &Point| [kind.test(point), share, point.orbit.parameter];
        let mut all = vec![known(0.0, piece.from), known(1.0, piece.to)];
        let is_first_negative = all[0][0] < 0.0;
        let mut bracket = [0.0, 1.0];
        let target = ACCURACY * self.width();
        let mut best: Option<(f64, Point)> = None;
        let mut error = f64::INFINITY;
        for _ in 0..MAX_ORBITS {
            let [low, high] = bracket;
            let [mut share, _] = at_zero(&mut all);
            if !(share > low && share < high) {
                share = 0.5 * (low + high);
            }
            let point = self.point_within(piece, share)?;
            let here = known(share, &point);
            error = best.as_ref().map_or(f64::INFINITY, |(_, before)| {
                (point.orbit.parameter - before.orbit.parameter).abs()
            });
            best = Some((share, point));
            let is_low = (here[0] < 0.0) == is_first_negative;
            bracket[usize::from(!is_low)] = share;
            all.push(here);
            if here[0] == 0.0 || error <= target || bracket[1] - bracket[0] <= MIN_BRACKET {
                break;
            }
        }
        let best = best.filter(|(_, point)| kind.is_at(&point.orbit));
        Ok(best.map(|(share, point)| (share, self.bifurcation(piece, kind, point, error))))
    }

    /// Locates a branch point by interpolation between orbits on both sides: the equations are singular at the point itself.
    fn locate_branch_point(
        &mut self,
        piece: Piece<'_>,
    ) -> Result<(f64, Bifurcation), ContinuationError> {
        let kind = BifurcationKind::BranchPoint;
        let target = ACCURACY * self.width();
        let known = |share: f64, point: &Point| [kind.test(point), share, point.orbit.parameter];
        let mut all = vec![known(0.0, piece.from), known(1.0, piece.to)];
        let [_, mut parameter] = at_zero(&mut all);
        let mut error = f64::INFINITY;
        let mut closest: Option<(f64, Point)> = None;
        for offset in OFFSETS {
            let [share, _] = at_zero(&mut all);
            let share = share.clamp(0.0, 1.0) + offset;
            let point = match self.point_within(piece, share) {
                Ok(point) => point,
                // Too close to the singular point.
                Err(_) if closest.is_some() => break,
                Err(failure) => return Err(failure),
            };
            all.push(known(share, &point));
            let [_, found] = at_zero(&mut all);
            error = (found - parameter).abs();
            parameter = found;
            closest = Some((share, point));
            if error <= target {
                break;
            }
        }
        let (share, point) = closest.unwrap_or_else(|| (0.0, piece.from.clone()));
        let found = self.bifurcation(piece, kind, point, error);
        Ok((share, Bifurcation { parameter, ..found }))
    }

    /// The orbit at a share of a piece.
    pub fn point_within(
        &mut self,
        piece: Piece<'_>,
        share: f64,
    ) -> Result<Point, ContinuationError> {
        let guess = piece.guess(share);
        let Point { scale, tangent, .. } = piece.from;
        let mut point = self.point(&guess, scale, Some(tangent), Precision::Location)?;
        if point.shot.len() == piece.from.shot.len()
            && piece.from.scale.dot(&point.tangent, &piece.from.tangent) < 0.0
        {
            point.tangent.neg_mut();
        }
        Ok(point)
    }

    /// The result for a located bifurcation.
    fn bifurcation(
        &mut self,
        piece: Piece<'_>,
        kind: BifurcationKind,
        point: Point,
        error: f64,
    ) -> Bifurcation {
        let orbit = &point.orbit;
        let critical = critical_multiplier(kind, orbit).filter(|_| {
            matches!(
                kind,
                BifurcationKind::PeriodDoubling | BifurcationKind::NeimarkSacker
            )
        });
        let crossing_rate = critical.and_then(|critical| crossing_rate(piece, &point, critical));
        let rotation_number = critical
            .filter(|_| kind == BifurcationKind::NeimarkSacker)
            .map(Multiplier::rotation_number);
        let resonance = rotation_number.and_then(Resonance::of);
        let birth = critical
            .filter(|_| resonance.is_none())
            .and_then(|critical| self.birth(&point, critical));
        // An error of the multipliers moves the zero.
        let by_multipliers = orbit
            .trivial_multiplier_error
            .zip(crossing_rate)
            .map_or(0.0, |(error, rate)| error / rate.abs());
        let [from, to] =
            [piece.from, piece.to].map(|point| point.orbit.unstable_multipliers as i32);
        Bifurcation {
            kind,
            parameter: orbit.parameter,
            accuracy: error + by_multipliers,
            frequency_hz: orbit.frequency_hz(),
            rotation_number,
            torus_frequency_hz: rotation_number.map(|number| number / orbit.period_s),
            resonance,
            crossing_rate,
            birth,
            fold_curvature: (kind == BifurcationKind::Fold).then(|| piece.fold_curvature()),
            guard: lowest_guard(&point)
                .filter(|_| kind == BifurcationKind::Grazing)
                .map(|(guard, _)| guard),
            unstable_change: to - from,
            orbit: point.orbit,
        }
    }
}

/// `d ln|multiplier| / d parameter` of the critical multiplier: the slope of the parabola through both ends of the piece and
/// the point. `None` if the parameter does not change monotonically.
fn crossing_rate(piece: Piece<'_>, point: &Point, critical: Multiplier) -> Option<f64> {
    let like = |other: &Point| {
        let distance = |m: &Multiplier| {
            (m.ln_magnitude - critical.ln_magnitude).hypot(m.angle - critical.angle)
        };
        other
            .orbit
            .nontrivial_multipliers()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let [a, b] = [piece.from, piece.to].map(|end| {
        let x = end.orbit.parameter - point.orbit.parameter;
        like(end).map(|m| [x, (m.ln_magnitude - critical.ln_magnitude) / x])
    });
    let ([xa, slope_a], [xb, slope_b]) = (a?, b?);
    (xa * xb < 0.0).then(|| (slope_a * xb - slope_b * xa) / (xb - xa))
}
