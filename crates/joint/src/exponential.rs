//! `exp(-rate x)` of several numbers at once, as a quotient. A friction law that contains a division combines
//! it with those of its exponentials, and a quotient requires fewer operations than a series.
//!
//! `exp(-rate x) = 2^n 2^f` with an integer `n` and `|f| <= 1/2`. Since `2^-f` is the reciprocal of `2^f`,
//!
//! ```text
//! 2^f = (even + odd)/(even - odd),     odd/even = tanh(f ln(2)/2)
//! ```
//!
//! `even` is a polynomial of `f^2`, `odd` is `f` times another. Their coefficients minimise the relative
//! error of `odd/even`, 5e-18; they were computed by the Remez algorithm with 70 digits.
//!
//! Measured relative errors against `exp` and `exp_m1`, in units of 2^-52: at most `2 + 1.25 rate x` for
//! `exp(-rate x)`, and at most 3.5 for `1 - exp(-rate x)`, also for very small results. (The part that
//! increases with `rate x` is the rounding of this product, which a call of `exp` has as well.)

use pulp::Simd;

use super::simd::Vector;

/// Coefficients of `even` by powers of `f^2`.
const EVEN: [f64; 3] = [1.0, 0.053_382_223_242_671_21, 0.000_228_933_658_655_300_34];
/// Coefficients of `odd/f` by powers of `f^2`.
const ODD: [f64; 3] = [
    0.346_573_590_279_972_64,
    0.004_624_841_600_134_503,
    5.287_087_419_037_464e-6,
];

/// Adding this number rounds to the nearest integer and leaves it in the low bits: 1.5 * 2^52.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `exp(-rate x)` as a quotient `above/below`.
#[derive(Clone, Copy)]
pub(crate) struct Exponential<S: Simd, const K: usize> {
    /// `2^n`.
    power: Vector<S, K>,
    even: Vector<S, K>,
    odd: Vector<S, K>,
}

impl<S: Simd, const K: usize> Exponential<S, K> {
    /// Evaluates `exp(-rate x)` for `x >= 0`; results below `exp(-708)` are replaced by `exp(-708)`.
    #[inline(always)]
    pub fn of(x: Vector<S, K>, rate: f64) -> Self {
        let number = |c: f64| x.broadcast(c);
        let x = x.at_most(708.0 / rate);
        let bits = number(-rate * std::f64::consts::LOG2_E);
        let n = x.mul_add(bits, number(ROUND));
        let f = x.mul_add(bits, number(ROUND) - n);
        let f2 = f * f;
        let even = f2.mul_add(number(EVEN[2]), number(EVEN[1]));
        let odd = f2.mul_add(number(ODD[2]), number(ODD[1]));
        Self {
            power: n.power_of_two(),
            even: even.mul_add(f2, number(EVEN[0])),
            odd: odd.mul_add(f2, number(ODD[0])) * f,
        }
    }

    /// The numerator of `exp(-rate x)`.
    #[inline(always)]
    pub fn above(self) -> Vector<S, K> {
        self.power * (self.even + self.odd)
    }

    /// The denominator of both quotients, close to one.
    #[inline(always)]
    pub fn below(self) -> Vector<S, K> {
        self.even - self.odd
    }

    /// The numerator of `1 - exp(-rate x)`. For `n = 0` the first term vanishes, so that small results have
    /// the same relative accuracy as large ones.
    #[inline(always)]
    pub fn rest(self) -> Vector<S, K> {
        let one = self.power.broadcast(1.0);
        (one - self.power).mul_add(self.even, -((one + self.power) * self.odd))
    }
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;
    use crate::tests::machines;

    /// Evaluates `exp(-rate x)` and `1 - exp(-rate x)` of each number.
    struct Both<'a>(&'a [f64], f64);

    impl WithSimd for Both<'_> {
        type Output = Vec<[f64; 2]>;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; 2]> {
            let mut both = Vec::new();
            for &x in self.0 {
                let exponential = Exponential::of(Vector::<S>::splat(simd, x), self.1);
                let first = |v: Vector<S>| v.sum() / S::F64_LANES as f64;
                both.push(
                    [exponential.above(), exponential.rest()]
                        .map(|above| first(above / exponential.below())),
                );
            }
            both
        }
    }

    /// The documented errors, in units of 2^-52, over the whole range with every supported instruction set.
    #[test]
    fn exponentials_are_accurate() {
        let xs: Vec<f64> = (0..200_000)
            .map(|k| 1e-300 * (f64::from(k) * 0.003_495).exp())
            .filter(|x| *x < 700.0)
            .collect();
        assert!(*xs.last().unwrap() > 600.0);
        let rates = [1.0, 10.0, 13.25, 1000.0];
        for (machine, rate) in machines()
            .into_iter()
            .flat_map(|machine| rates.map(|rate| (machine, rate)))
        {
            let xs: Vec<f64> = xs.iter().map(|x| x / rate).collect();
            let mut worst = [0.0_f64; 2];
            for (x, got) in xs.iter().zip(machine.dispatch(Both(&xs, rate))) {
                let x = rate * x;
                let error = |got: f64, want: f64| (got / want - 1.0).abs() / f64::EPSILON;
                worst[0] = worst[0].max(error(got[0], (-x).exp()) - 1.25 * x);
                worst[1] = worst[1].max(error(got[1], -(-x).exp_m1()));
            }
            assert!(worst[0] < 2.0 && worst[1] < 3.5, "{machine:?}: {worst:?}");
        }
    }

    /// Large arguments give finite results, and NaN propagates.
    #[test]
    fn ends_of_the_range() {
        for machine in machines() {
            let got = machine.dispatch(Both(&[0.0, 1e300, f64::INFINITY, f64::NAN], 1.0));
            assert_eq!(got[0], [1.0, 0.0]);
            assert!(got[1][0] < 1e-300 && got[1][1] == 1.0);
            assert_eq!(got[2][1], 1.0);
            assert!(got[3][0].is_nan() && got[3][1].is_nan());
        }
    }
}
