//! A measured friction curve: coefficients of friction at given slip speeds with a smooth curve through them.

use pulp::Simd;

use super::dual::Dual;
use super::friction::{Curve, FrictionLaw, Ratio};
use super::simd::Vector;

/// A friction law from a table of measured coefficients: `mu(V) = (1 - exp(-creep V)) mu_table(V)`.
///
/// The first factor is that of Eq. (5): friction vanishes continuously at zero speed, whatever the table
/// states there, and reaches the table a few `1/creep` above. The first coefficient of the table therefore
/// acts as the static coefficient.
///
/// `mu_table` is the cubic Hermite interpolant with the slopes of Fritsch and Butland: it passes through all
/// points, its slope is continuous, and it is monotone wherever the points are, so that it adds no maximum and
/// no minimum. Below the first speed and above the last one it is constant; its slope is zero there, except at
/// a first speed of zero. F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238; F. N. Fritsch,
/// J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionTable {
    points: Vec<[f64; 2]>,
    /// Slope factor of the creep region, s/m.
    creep: f64,
    /// Speeds at which the pieces begin, m/s: zero, then increasing.
    starts: Vec<f64>,
    /// Coefficients of each piece by powers of the speed above its start.
    pieces: Vec<[f64; 4]>,
}

impl FrictionTable {
    /// A table of `points`, each a slip speed (m/s) and a coefficient of friction, with the slope factor of the
    /// creep region (s/m).
    ///
    /// `None` unless the speeds are non-negative and increase strictly, the coefficients are non-negative, there
    /// is at least one point, all numbers are finite, and `creep` is positive. Speeds so close that the slope
    /// between them overflows are rejected, too.
    pub fn new(points: Vec<[f64; 2]>, creep: f64) -> Option<Self> {
        let is_number = |x: f64| x >= 0.0 && x.is_finite();
        let valid = points.iter().flatten().all(|x| is_number(*x));
        let increases = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let &[first, mu_first] = points.first()?;
        if !(valid && increases && creep > 0.0 && creep.is_finite()) {
            return None;
        }
        let (mut starts, mut pieces) = (Vec::new(), Vec::new());
        if first > 0.0 {
            starts.push(0.0);
            pieces.push([mu_first, 0.0, 0.0, 0.0]);
        }
        let slopes = slopes(&points);
        for (pair, slope) in points.windows(2).zip(slopes.windows(2)) {
            let [[v, mu], [next, mu_next]] = [pair[0], pair[1]];
            let width = next - v;
            let secant = (mu_next - mu) / width;
            starts.push(v);
            pieces.push([
                mu,
                slope[0],
                (3.0 * secant - 2.0 * slope[0] - slope[1]) / width,
                (slope[0] + slope[1] - 2.0 * secant) / (width * width),
            ]);
        }
        let &[last, mu_last] = points.last()?;
        starts.push(last);
        pieces.push([mu_last, 0.0, 0.0, 0.0]);
        let finite = pieces.iter().flatten().all(|x| x.is_finite());
        finite.then_some(Self {
            points,
            creep,
            starts,
            pieces,
        })
    }

    /// The points: slip speed (m/s) and coefficient of friction.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Slope factor of the creep region, s/m.
    pub fn creep(&self) -> f64 {
        self.creep
    }

    /// The coefficient of the table without the creep factor at a slip speed (m/s, non-negative), and its slope
    /// (s/m).
    pub fn sliding(&self, speed: f64) -> [f64; 2] {
        let speed = Vector::splat(pulp::Scalar::new(), speed);
        self.sliding_vector(speed).map(Vector::sum)
    }

    /// Index of the piece at a slip speed. The first piece begins at zero; it also passes on NaN.
    #[inline(always)]
    fn piece(&self, speed: f64) -> usize {
        let after = self.starts.partition_point(|start| *start <= speed);
        after.max(1) - 1
    }

    /// [`FrictionTable::sliding`] at several slip speeds. Neighbouring nodes slide at similar speeds, on few pieces: each
    /// of them is evaluated by the lanes on it and those above.
    #[inline(always)]
    fn sliding_vector<S: Simd>(&self, speed: Vector<S>) -> [Vector<S>; 2] {
        let [low, high] = speed.range();
        let (first, last) = (self.piece(low), self.piece(high));
        let splat = |x: f64| speed.broadcast(x);
        let mut start = splat(self.starts[first]);
        let [a, b, c, d] = self.pieces[first];
        let (mut a, mut b, mut c, mut d) = (splat(a), splat(b), splat(c), splat(d));
        for piece in first + 1..=last {
            let next = splat(self.starts[piece]);
            let [next_a, next_b, next_c, next_d] = self.pieces[piece];
            let replace = |old: Vector<S>, new| old.replaced_where(speed, next, splat(new));
            (a, b) = (replace(a, next_a), replace(b, next_b));
            (c, d) = (replace(c, next_c), replace(d, next_d));
            start = start.replaced_where(speed, next, next);
        }
        let above = speed - start;
        [
            a + above * (b + above * (c + above * d)),
            b + above * (splat(2.0) * c + above * splat(3.0) * d),
        ]
    }
}

impl Curve for FrictionTable {
    #[inline(always)]
    fn over_speed<S: Simd, const K: usize, const N: usize>(
        &self,
        speed: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        let creep = speed.exponential(self.creep);
        let sliding = speed.compose(
            #[inline(always)]
            |speed| self.sliding_vector(speed),
        );
        creep.rest * sliding / speed.times(creep.below)
    }
}

impl FrictionLaw for FrictionTable {
    fn ratio(&self, speed: f64) -> Ratio {
        self.ratio_at(speed)
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

/// Slopes of the interpolant at the points, s/m.
fn slopes(points: &[[f64; 2]]) -> Vec<f64> {
    let widths = points.windows(2).map(|pair| pair[1][0] - pair[0][0]);
    let rises = points.windows(2).map(|pair| pair[1][1] - pair[0][1]);
    let (h, d): (Vec<f64>, Vec<f64>) = widths.zip(rises).map(|(h, rise)| (h, rise / h)).unzip();
    let mut slopes = vec![0.0; points.len()];
    for k in 1..d.len() {
        // Zero at an extremum and at the ends of a level section.
        if d[k - 1] * d[k] > 0.0 {
            let (left, right) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
            slopes[k] = (left + right) / (left / d[k - 1] + right / d[k]);
        }
    }
    if points[0][0] == 0.0 && !d.is_empty() {
        slopes[0] = first_slope(&h, &d);
    }
    slopes
}

/// Slope at the first point: that of the parabola through three points, limited so that the interpolant remains
/// monotone.
fn first_slope(h: &[f64], d: &[f64]) -> f64 {
    if d.len() == 1 {
        return d[0];
    }
    let parabola = ((2.0 * h[0] + h[1]) * d[0] - h[0] * d[1]) / (h[0] + h[1]);
    if parabola * d[0] <= 0.0 {
        0.0
    } else if parabola.abs() > 3.0 * d[0].abs() {
        3.0 * d[0]
    } else {
        parabola
    }
}

#[cfg(test)]
mod tests {
    use super::super::Stribeck;
    use super::super::simd::{LANES, parts};
    use super::*;
    use crate::tests::machines;

    const STRIBECK: Stribeck = Stribeck {
        mu_s: 0.55,
        mu_d: 0.25,
        creep: 1000.0,
        stribeck: 10.0,
    };

    /// The sliding factor of [`STRIBECK`] at equidistant speeds up to 1.5 m/s.
    fn tabulated(intervals: u32) -> FrictionTable {
        let sliding = |v: f64| 0.25 + 0.3 * (-10.0 * v).exp();
        let points = (0..=intervals).map(|k| 1.5 * f64::from(k) / f64::from(intervals));
        FrictionTable::new(points.map(|v| [v, sliding(v)]).collect(), 1000.0).unwrap()
    }

    fn speeds() -> impl Iterator<Item = f64> {
        (0..20_000).map(|k| 1e-4 * f64::from(k))
    }

    /// A table of Eq. (5) reproduces value and slope of Eq. (5); the errors decrease with the third and the second
    /// power of the distance of the points.
    #[test]
    fn tables_reproduce_the_stribeck_curve() {
        let errors = [50, 100, 200, 400].map(|intervals| {
            let table = tabulated(intervals);
            let (mut value, mut slope) = (0.0_f64, 0.0_f64);
            for v in speeds() {
                let (got, want) = (table.ratio(v), STRIBECK.ratio(v));
                value = value.max((got.value - want.value).abs() * v);
                let exact = want.value + v * want.slope;
                slope = slope.max((got.value + v * got.slope - exact).abs());
            }
            [value, slope]
        });
        for pair in errors.windows(2) {
            assert!(pair[1][0] < pair[0][0] / 6.0, "{errors:?}");
            assert!(pair[1][1] < pair[0][1] / 3.0, "{errors:?}");
        }
        assert!(errors[3][0] < 1e-6 && errors[3][1] < 1e-3, "{errors:?}");
    }

    /// Falling points give a falling curve, between the points and beyond the last one.
    #[test]
    fn monotone_points_give_a_monotone_curve() {
        let falling = vec![
            [0.0, 0.6],
            [0.01, 0.59],
            [0.011, 0.41],
            [0.2, 0.4],
            [0.3, 0.4],
            [0.31, 0.1],
            [1.0, 0.099],
        ];
        let table = FrictionTable::new(falling.clone(), 1000.0).unwrap();
        let mut before = f64::INFINITY;
        for v in speeds() {
            let [mu, slope] = table.sliding(v);
            assert!(mu <= before && slope <= 1e-15, "{v}");
            before = mu;
        }
        for [v, mu] in falling {
            assert!((table.sliding(v)[0] - mu).abs() < 1e-15);
        }
        assert_eq!(table.sliding(5.0), [0.099, 0.0]);
        // An extremum of the points is one of the curve.
        let peak = FrictionTable::new(vec![[0.0, 0.1], [0.1, 0.5], [0.4, 0.2]], 1e3).unwrap();
        let highest = speeds().map(|v| peak.sliding(v)[0]).fold(0.0, f64::max);
        assert!((highest - 0.5).abs() < 1e-12);
    }

    /// The slope is the derivative, also across the points; value and slope are continuous there.
    #[test]
    fn slopes_are_the_derivative() {
        let points = vec![
            [0.002, 0.3],
            [0.01, 0.45],
            [0.02, 0.4],
            [0.1, 0.2],
            [0.5, 0.35],
        ];
        let table = FrictionTable::new(points.clone(), 300.0).unwrap();
        for k in 1..6000 {
            let (v, step) = (1e-4 * f64::from(k) + 3e-5, 1e-7);
            let [below, above] = [v - step, v + step].map(|v| table.ratio(v).value);
            let slope = (above - below) / (2.0 * step);
            let got = table.ratio(v).slope;
            assert!(
                (got - slope).abs() < 1e-5 * (got.abs() + 100.0),
                "{v}: {got} {slope}"
            );
        }
        for [v, _] in points {
            let [before, after] = [v * (1.0 - 1e-12), v * (1.0 + 1e-12)].map(|v| table.sliding(v));
            assert!((before[0] - after[0]).abs() < 1e-10 && (before[1] - after[1]).abs() < 1e-8);
        }
    }

    /// At zero speed the coefficient vanishes with a finite slope, the first coefficient times the creep factor.
    #[test]
    fn friction_vanishes_at_rest() {
        for first in [0.0, 0.01] {
            let table = FrictionTable::new(vec![[first, 0.5], [0.1, 0.3]], 2000.0).unwrap();
            assert!((table.ratio(0.0).value - 1000.0).abs() < 1e-9);
            assert!((table.ratio(1e-300).value - 1000.0).abs() < 1e-9);
        }
        let constant = FrictionTable::new(vec![[0.3, 0.4]], 1000.0).unwrap();
        for v in [0.0, 0.1, 0.3, 7.0] {
            assert_eq!(constant.sliding(v), [0.4, 0.0]);
        }
    }

    #[test]
    fn invalid_tables_are_rejected() {
        let rejected = |points: &[[f64; 2]], creep| FrictionTable::new(points.to_vec(), creep);
        for points in [
            &[][..],
            &[[-0.1, 0.3]],
            &[[0.1, -0.3]],
            &[[0.1, 0.3], [0.1, 0.2]],
            &[[0.2, 0.3], [0.1, 0.2]],
            &[[0.1, f64::NAN]],
            &[[0.1, 0.3], [f64::INFINITY, 0.2]],
            &[[0.0, 0.3], [1e-300, 0.2]],
        ] {
            assert_eq!(rejected(points, 1000.0), None, "{points:?}");
        }
        for creep in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(rejected(&[[0.1, 0.3]], creep), None);
        }
    }

    /// Vector and scalar forms agree, at different speeds in the lanes, too, and NaN propagates.
    #[test]
    fn vectors_agree_with_scalars() {
        struct Ratios<'a>(&'a FrictionTable, [f64; LANES]);
        impl pulp::WithSimd for Ratios<'_> {
            type Output = [[f64; LANES]; 2];
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
                let Self(table, speeds) = self;
                let mut out = [[0.0; LANES]; 2];
                for part in 0..parts::<S>() {
                    let speed = Vector::load(simd, &speeds, part);
                    let ratio = table.over_speed(Dual::<S, 1, 1>::input(speed, 0));
                    let again = table.over_speed(Dual::<S, 1, 0>::constant(speed)).value;
                    assert!((ratio.value - again).sum() == 0.0 || again.sum().is_nan());
                    ratio.value.store(&mut out[0], part);
                    (ratio.slopes[0] * speed).store(&mut out[1], part);
                }
                out
            }
        }
        let table = tabulated(30);
        let sets = speeds().skip(1).flat_map(|v| {
            [0.0, 1e-4, 0.3].map(|step| std::array::from_fn(|k| v + step * (5 * k % LANES) as f64))
        });
        let sets: Vec<[f64; LANES]> = sets.collect();
        for machine in machines() {
            for &speeds in &sets {
                let [values, slopes] = machine.dispatch(Ratios(&table, speeds));
                for ((v, value), slope) in speeds.into_iter().zip(values).zip(slopes) {
                    let exact = table.ratio(v);
                    assert!((value / exact.value - 1.0).abs() < 1e-14, "{v}");
                    assert!((slope - v * exact.slope).abs() < 1e-13 * exact.value, "{v}");
                }
            }
            let [values, _] = machine.dispatch(Ratios(&table, [f64::NAN; LANES]));
            assert!(values.iter().all(|x| x.is_nan()));
            let mut one = [0.2; LANES];
            one[3] = f64::NAN;
            assert!(machine.dispatch(Ratios(&table, one))[0][3].is_nan());
        }
    }
}
