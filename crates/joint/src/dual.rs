//! Numbers with partial derivatives (forward differentiation), for several contact nodes at once: every law of the
//! contact is written once in them. Without derivatives (`N = 0`) they are the plain vectors of the hot loop; the
//! operations on the values are the same with and without.
//!
//! `exp(-rate x)` is a quotient. A friction law that contains a division combines it with those of its exponentials,
//! and a quotient requires fewer operations than a series.
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

use std::ops::{Add, Div, Mul, Sub};

use pulp::{Scalar, Simd};

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

/// A number and its derivatives with respect to `N` inputs.
#[derive(Clone, Copy)]
pub(crate) struct Dual<S: Simd, const K: usize, const N: usize> {
    pub value: Vector<S, K>,
    pub slopes: [Vector<S, K>; N],
}

/// `exp(-rate x)` as a quotient `above/below`. The derivatives of `above` and `rest` are for a constant `below`, which is
/// exact in their quotients by it.
pub(crate) struct Exponential<S: Simd, const K: usize, const N: usize> {
    /// The numerator of `exp(-rate x)`.
    pub above: Dual<S, K, N>,
    /// The numerator of `1 - exp(-rate x)`.
    pub rest: Dual<S, K, N>,
    /// The denominator of both quotients, close to one.
    pub below: Vector<S, K>,
}

impl<const N: usize> Dual<Scalar, 1, N> {
    /// The input with this index; no input if there are as few.
    pub fn scalar(value: f64, input: usize) -> Self {
        Self::input(Vector::splat(Scalar::new(), value), input)
    }

    /// A number that does not depend on the inputs.
    pub fn number(value: f64) -> Self {
        Self::scalar(value, N)
    }

    /// The value.
    pub fn value(self) -> f64 {
        self.value.sum()
    }
}

impl<const N: usize> Add<f64> for Dual<Scalar, 1, N> {
    type Output = Self;
    fn add(mut self, term: f64) -> Self {
        self.value = self.value + self.value.broadcast(term);
        self
    }
}

impl<const N: usize> Mul<f64> for Dual<Scalar, 1, N> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.scale(factor)
    }
}

impl<S: Simd, const K: usize, const N: usize> Dual<S, K, N> {
    /// A constant.
    #[inline(always)]
    pub fn constant(value: Vector<S, K>) -> Self {
        let slopes = [value.broadcast(0.0); N];
        Self { value, slopes }
    }

    /// The input with this index.
    #[inline(always)]
    pub fn input(value: Vector<S, K>, index: usize) -> Self {
        let mut input = Self::constant(value);
        for n in 0..N {
            if n == index {
                input.slopes[n] = value.broadcast(1.0);
            }
        }
        input
    }

    /// The number with another value and other derivatives.
    #[inline(always)]
    fn with(
        mut self,
        value: Vector<S, K>,
        slope: impl Fn(usize, Vector<S, K>) -> Vector<S, K>,
    ) -> Self {
        self.value = value;
        for n in 0..N {
            self.slopes[n] = slope(n, self.slopes[n]);
        }
        self
    }

    /// A function with this value and this derivative with respect to the number.
    #[inline(always)]
    pub fn chain(self, value: Vector<S, K>, slope: Vector<S, K>) -> Self {
        self.with(
            value,
            #[inline(always)]
            |_, own| slope * own,
        )
    }

    /// Applies a linear function to the value and the derivatives.
    #[inline(always)]
    pub fn linear(self, f: impl Fn(Vector<S, K>) -> Vector<S, K>) -> Self {
        self.with(
            f(self.value),
            #[inline(always)]
            |_, own| f(own),
        )
    }

    /// `factor self + term` for constants, with a single rounding.
    #[inline(always)]
    pub fn times_plus(self, factor: Vector<S, K>, term: Vector<S, K>) -> Self {
        self.chain(self.value.mul_add(factor, term), factor)
    }

    /// `factor self` for constants.
    #[inline(always)]
    pub fn times(self, factor: Vector<S, K>) -> Self {
        self.chain(self.value * factor, factor)
    }

    /// `factor self`.
    #[inline(always)]
    pub fn scale(self, factor: f64) -> Self {
        self.times(self.value.broadcast(factor))
    }

    /// `self b + c`, with a single rounding.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        self.with(
            self.value.mul_add(b.value, c.value),
            #[inline(always)]
            |n, own| own.mul_add(b.value, self.value.mul_add(b.slopes[n], c.slopes[n])),
        )
    }

    /// Square root of a positive number.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, root.broadcast(0.5) / root)
    }

    /// Maximum with `floor`, constant from there downwards; NaN propagates.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Self {
        let above = self.value - self.value.broadcast(floor);
        self.with(
            self.value.at_least(floor),
            #[inline(always)]
            |_, own| own.where_positive(above),
        )
    }

    /// A function given by its value and its derivative.
    #[inline(always)]
    pub fn compose(self, f: impl Fn(Vector<S>) -> [Vector<S>; 2]) -> Self {
        let (mut value, mut slope) = (self.value, self.value);
        for k in 0..K {
            let [of_value, of_slope] = f(self.value.one(k));
            value.set(k, of_value);
            slope.set(k, of_slope);
        }
        self.chain(value, slope)
    }

    /// A function of scalars given by its value and its derivative.
    #[inline(always)]
    pub fn compose_scalar(self, f: impl Fn(f64) -> [f64; 2]) -> Self {
        self.compose(
            #[inline(always)]
            |x| x.map(&f),
        )
    }

    /// Evaluates `exp(-rate x)` for `x >= 0` and a finite, non-negative rate; results below `exp(-708)` are replaced by
    /// `exp(-708)`.
    #[inline(always)]
    pub fn exponential(self, rate: f64) -> Exponential<S, K, N> {
        let number = |c: f64| self.value.broadcast(c);
        let x = self.value.at_most(708.0 / rate);
        let bits = number(-rate * std::f64::consts::LOG2_E);
        let n = x.mul_add(bits, number(ROUND));
        let f = x.mul_add(bits, number(ROUND) - n);
        let f2 = f * f;
        let even = f2.mul_add(number(EVEN[2]), number(EVEN[1]));
        let odd = f2.mul_add(number(ODD[2]), number(ODD[1]));
        let even = even.mul_add(f2, number(EVEN[0]));
        let odd = odd.mul_add(f2, number(ODD[0])) * f;
        let power = n.power_of_two();
        let above = power * (even + odd);
        // For `n = 0` the first term vanishes, so that small results have the same relative accuracy as large ones.
        let rest = (number(1.0) - power).mul_add(even, -((number(1.0) + power) * odd));
        let rise = above * number(rate);
        Exponential {
            above: self.chain(above, -rise),
            rest: self.chain(rest, rise),
            below: even - odd,
        }
    }
}

impl<S: Simd, const K: usize, const N: usize> Add for Dual<S, K, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(
            self.value + other.value,
            #[inline(always)]
            |n, own| own + other.slopes[n],
        )
    }
}

impl<S: Simd, const K: usize, const N: usize> Sub for Dual<S, K, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(
            self.value - other.value,
            #[inline(always)]
            |n, own| own - other.slopes[n],
        )
    }
}

impl<S: Simd, const K: usize, const N: usize> Mul for Dual<S, K, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(
            self.value * other.value,
            #[inline(always)]
            |n, own| own.mul_add(other.value, self.value * other.slopes[n]),
        )
    }
}

impl<S: Simd, const K: usize, const N: usize> Div for Dual<S, K, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = quotient.broadcast(1.0) / other.value;
        self.with(
            quotient,
            #[inline(always)]
            |n, own| (own - quotient * other.slopes[n]) * inverse,
        )
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
                let x = Dual::<S, 1, 0>::constant(Vector::splat(simd, x));
                let exponential = x.exponential(self.1);
                let first = |v: Vector<S>| v.sum() / S::F64_LANES as f64;
                both.push(
                    [exponential.above, exponential.rest]
                        .map(|above| first(above.value / exponential.below)),
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
