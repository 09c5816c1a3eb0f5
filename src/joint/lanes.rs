//! A block of contact nodes worked on at once.
//!
//! Plain arrays and loops of fixed length: inside a function that `pulp` has compiled for AVX-512,
//! AVX2 or NEON, the compiler turns each operation into one or two vector instructions. Whether a
//! product and a sum are fused is a type, because without the instruction the fused form is a slow
//! library call.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Nodes in a block.
pub const LANES: usize = 8;

/// One number for each node of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

macro_rules! lanewise {
    ($trait:ident, $method:ident) => {
        impl $trait for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $method(self, other: Lanes) -> Lanes {
                Lanes(std::array::from_fn(|l| self.0[l].$method(other.0[l])))
            }
        }
    };
}
lanewise!(Add, add);
lanewise!(Sub, sub);
lanewise!(Mul, mul);
lanewise!(Div, div);

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|x| -x)
    }
}

impl Lanes {
    /// Zero in every lane.
    pub const ZERO: Lanes = Lanes([0.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f64) -> Lanes {
        Lanes([x; LANES])
    }

    /// A function of each lane.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Lanes {
        Lanes(self.0.map(f))
    }

    /// The larger of two, lane by lane; a NaN on the left stays.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Lanes {
        self.map(|x| if x < floor { floor } else { x })
    }

    /// The sum of the lanes, always in the same order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}

/// How a product and a sum are taken.
pub trait Reals {
    /// `a b + c`.
    fn fma(a: f64, b: f64, c: f64) -> f64;

    /// `a b + c`, lane by lane.
    #[inline(always)]
    fn mul_add(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
        Lanes(std::array::from_fn(|l| Self::fma(a.0[l], b.0[l], c.0[l])))
    }

    /// `exp(-x)` for `x >= 0`, to about one unit in the last place; 0 past `x = 708`.
    #[inline(always)]
    fn neg_exp(x: Lanes) -> Lanes {
        let (fraction, power) = Self::neg_exp_parts(x);
        Self::mul_add(fraction, power, power)
    }

    /// `1 - exp(-x)` for `x > 0`, to about two units in the last place, however small `x` is.
    #[inline(always)]
    fn neg_exp_m1(x: Lanes) -> Lanes {
        let (fraction, power) = Self::neg_exp_parts(x);
        Lanes::splat(1.0) - power - fraction * power
    }

    /// `exp(-x) = power (1 + fraction)`: `power` a power of two, `fraction = exp(r) - 1` of the
    /// remainder `|r| <= ln(2)/2`.
    #[inline(always)]
    fn neg_exp_parts(x: Lanes) -> (Lanes, Lanes) {
        // Adding 1.5 * 2^52 rounds to the nearest integer and leaves it in the low bits.
        const ROUND: f64 = 6_755_399_441_055_744.0;
        // ln(2) in two parts, the first with trailing zeros so that its multiples are exact.
        const LN2_HIGH: f64 = 0.693_147_180_369_123_8;
        const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
        // 1/(k+1)!, k = 0..12: the Taylor series of (exp(r) - 1)/r, whose first term left out is
        // below 3e-18 for |r| <= ln(2)/2.
        const C: [f64; 13] = {
            let mut c = [1.0; 13];
            let mut k = 1;
            while k < 13 {
                c[k] = c[k - 1] / (k as f64 + 1.0);
                k += 1;
            }
            c
        };
        let x = x.map(|x| if x > 708.0 { 708.0 } else { x });
        let shifted = Self::mul_add(
            x,
            Lanes::splat(-std::f64::consts::LOG2_E),
            Lanes::splat(ROUND),
        );
        let n = shifted - Lanes::splat(ROUND);
        let r = Self::mul_add(n, Lanes::splat(-LN2_HIGH), -x);
        let r = Self::mul_add(n, Lanes::splat(-LN2_LOW), r);
        // Estrin's scheme: short chains keep the vector units busy.
        let pair = |k: usize| Self::mul_add(Lanes::splat(C[k + 1]), r, Lanes::splat(C[k]));
        let r2 = r * r;
        let quad = |k: usize| Self::mul_add(pair(k + 2), r2, pair(k));
        let r4 = r2 * r2;
        let low = Self::mul_add(quad(4), r4, quad(0));
        let high = Self::mul_add(Lanes::splat(C[12]), r4, quad(8));
        let series = Self::mul_add(high, r4 * r4, low);
        let power = shifted.map(|s| f64::from_bits((s.to_bits() << 52).wrapping_add(1023 << 52)));
        (r * series, power)
    }
}

/// One rounding for product and sum.
#[derive(Clone, Copy, Debug)]
pub struct Fused;

impl Reals for Fused {
    #[inline(always)]
    fn fma(a: f64, b: f64, c: f64) -> f64 {
        a.mul_add(b, c)
    }
}

/// Product and sum rounded one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Reals for Plain {
    #[inline(always)]
    fn fma(a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst<R: Reals>(f: fn(Lanes) -> Lanes, exact: fn(f64) -> f64) -> f64 {
        let mut worst: f64 = 0.0;
        let mut x = 1e-300;
        while x < 700.0 {
            for y in f(Lanes(std::array::from_fn(|l| x * (1.0 + l as f64 / 13.0))))
                .0
                .iter()
                .zip(0..)
            {
                let want = exact(x * (1.0 + f64::from(y.1) / 13.0));
                worst = worst.max((y.0 / want - 1.0).abs() / f64::EPSILON);
            }
            x *= 1.07;
        }
        worst
    }

    /// The stated errors, in units of 2^-52, over the whole range.
    #[test]
    fn exponentials_are_accurate() {
        assert!(worst::<Fused>(Fused::neg_exp, |x| (-x).exp()) < 1.5);
        assert!(worst::<Fused>(Fused::neg_exp_m1, |x| -(-x).exp_m1()) < 2.5);
        assert!(worst::<Plain>(Plain::neg_exp, |x| (-x).exp()) < 2.5);
        assert!(worst::<Plain>(Plain::neg_exp_m1, |x| -(-x).exp_m1()) < 2.5);
    }

    /// Far out the exponential stays finite, and a NaN is not swallowed.
    #[test]
    fn ends_of_the_range() {
        assert_eq!(Fused::neg_exp(Lanes::ZERO).0, [1.0; LANES]);
        assert!(Fused::neg_exp(Lanes::splat(1e300)).0[0] < 1e-300);
        assert_eq!(
            Fused::neg_exp_m1(Lanes::splat(f64::INFINITY)).0,
            [1.0; LANES]
        );
        assert!(Fused::neg_exp(Lanes::splat(f64::NAN)).0[0].is_nan());
    }
}
