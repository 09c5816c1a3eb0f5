//! Contact nodes worked on several at once, with the vector instructions that the machine has.
//!
//! [`Eight`] is how eight nodes are stored; [`Vector`] is what one instruction works on: eight
//! numbers with AVX-512, four with AVX2, two with NEON, one without any.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

/// Nodes stored together.
pub const LANES: usize = 8;

/// One number for each of eight nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Eight(pub [f64; LANES]);

impl Eight {
    /// Zero for every node.
    pub const ZERO: Eight = Eight([0.0; LANES]);

    /// The vectors that make up the eight.
    #[inline(always)]
    pub fn part<S: Simd>(&self, simd: S, part: usize) -> Vector<S> {
        Vector {
            simd,
            x: S::as_simd_f64s(&self.0).0[part],
        }
    }
}

/// How many vectors make up eight numbers.
#[inline(always)]
pub(crate) const fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// As many numbers as one instruction works on.
#[derive(Clone, Copy)]
pub(crate) struct Vector<S: Simd> {
    simd: S,
    x: S::f64s,
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl<S: Simd> $trait for Vector<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self {
                    simd: self.simd,
                    x: self.simd.$instruction(self.x, other.x),
                }
            }
        }
    };
}
lanewise!(Add, add, add_f64s);
lanewise!(Sub, sub, sub_f64s);
lanewise!(Mul, mul, mul_f64s);
lanewise!(Div, div, div_f64s);

impl<S: Simd> Neg for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            simd: self.simd,
            x: self.simd.neg_f64s(self.x),
        }
    }
}

impl<S: Simd> Vector<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self {
            simd,
            x: simd.splat_f64s(x),
        }
    }

    /// The same number in every lane, on the same machine.
    #[inline(always)]
    fn same(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    /// `self * b + c`, rounded once where the machine can.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Self {
            simd: self.simd,
            x: self.simd.mul_add_e_f64s(self.x, b.x, c.x),
        }
    }

    /// Eight numbers' vectors, one after another, as they are kept in a slice.
    #[inline(always)]
    pub fn load(simd: S, eight: &[f64; LANES], part: usize) -> Self {
        let x = S::as_simd_f64s(eight).0[part];
        Self { simd, x }
    }

    /// Puts the vector back where [`Vector::load`] takes it from.
    #[inline(always)]
    pub fn store(self, eight: &mut [f64; LANES], part: usize) {
        S::as_mut_simd_f64s(eight).0[part] = self.x;
    }

    /// As many numbers as there are in a slice, at most a vector's; the other lanes are zero.
    #[inline(always)]
    pub fn load_some(simd: S, numbers: &[f64]) -> Self {
        let x = simd.partial_load_f64s(numbers);
        Self { simd, x }
    }

    /// Writes as many numbers as a slice has room for, at most a vector's.
    #[inline(always)]
    pub fn store_some(self, numbers: &mut [f64]) {
        self.simd.partial_store_f64s(numbers, self.x);
    }

    /// The vector in the lanes where another is positive, zero in the others.
    #[inline(always)]
    pub fn where_positive(self, other: Self) -> Self {
        let zero = self.simd.splat_f64s(0.0);
        let positive = self.simd.greater_than_f64s(other.x, zero);
        Self {
            simd: self.simd,
            x: self.simd.select_f64s(positive, self.x, zero),
        }
    }

    /// The vector in the lanes whose bit of the eight is clear, zero in the others.
    #[inline(always)]
    pub fn where_clear(self, bits: u8, part: usize) -> Self {
        const OWN_BIT: [u64; LANES] = [1, 2, 4, 8, 16, 32, 64, 128];
        let simd = self.simd;
        let own = S::as_simd_u64s(&OWN_BIT).0[part];
        let set = simd.and_u64s(own, simd.splat_u64s(u64::from(bits)));
        let clear = simd.equal_u64s(set, simd.splat_u64s(0));
        Self {
            simd,
            x: simd.select_f64s(clear, self.x, simd.splat_f64s(0.0)),
        }
    }

    /// Negated in the lanes whose bit of the eight is set.
    #[inline(always)]
    pub fn negated_where_set(self, bits: u8, part: usize) -> Self {
        self.where_clear(bits, part) - self.where_clear(!bits, part)
    }

    /// Raised to `floor` where it is below; a NaN stays one.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Self {
        let floor = self.simd.splat_f64s(floor);
        let below = self.simd.less_than_f64s(self.x, floor);
        Self {
            simd: self.simd,
            x: self.simd.select_f64s(below, floor, self.x),
        }
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self {
            simd: self.simd,
            x: self.simd.sqrt_f64s(self.x),
        }
    }

    /// The sum of the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.x)
    }

    /// One bit a lane, set where the number is negative.
    #[inline(always)]
    pub fn negative_bits(self) -> u8 {
        let mut values = [0.0; LANES];
        self.simd
            .partial_store_f64s(&mut values[..S::F64_LANES], self.x);
        let negative = |l: usize| u8::from(values[l] < 0.0);
        (0..S::F64_LANES).fold(0, |bits, l| bits | negative(l) << l)
    }

    /// Changed by a function that sees plain numbers.
    #[inline(always)]
    pub fn through(self, f: impl FnOnce(&mut [f64])) -> Self {
        let mut values = [0.0; LANES];
        let values = &mut values[..S::F64_LANES];
        self.simd.partial_store_f64s(values, self.x);
        f(values);
        Self {
            simd: self.simd,
            x: self.simd.partial_load_f64s(values),
        }
    }

    /// As [`Vector::through`], with a second vector made on the way.
    #[inline(always)]
    pub fn through_both(self, f: impl FnOnce(&mut [f64], &mut [f64])) -> (Self, Self) {
        let (mut values, mut others) = ([0.0; LANES], [0.0; LANES]);
        let values = &mut values[..S::F64_LANES];
        let others = &mut others[..S::F64_LANES];
        self.store_some(values);
        f(values, others);
        let simd = self.simd;
        (Self::load_some(simd, values), Self::load_some(simd, others))
    }

    /// `exp(-x)` for `x >= 0`, to about one unit in the last place; below `exp(-708)` it stays there.
    #[inline(always)]
    pub fn neg_exp(self) -> Self {
        let parts = self.neg_exp_parts();
        parts.fraction.mul_add(parts.power, parts.power)
    }

    /// `1 - exp(-x)` for `x > 0`, to about two units in the last place, however small `x` is.
    #[inline(always)]
    pub fn one_minus_neg_exp(self) -> Self {
        let parts = self.neg_exp_parts();
        self.same(1.0) - parts.power - parts.fraction * parts.power
    }

    /// [`Vector::neg_exp`] and [`Vector::one_minus_neg_exp`], to the same bits, for the price of one.
    #[inline(always)]
    pub fn neg_exp_and_rest(self) -> (Self, Self) {
        let parts = self.neg_exp_parts();
        (
            parts.fraction.mul_add(parts.power, parts.power),
            self.same(1.0) - parts.power - parts.fraction * parts.power,
        )
    }

    #[inline(always)]
    fn neg_exp_parts(self) -> Exponential<S> {
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
        let simd = self.simd;
        let most = simd.splat_f64s(708.0);
        let beyond = simd.greater_than_f64s(self.x, most);
        let x = Self {
            simd,
            x: simd.select_f64s(beyond, most, self.x),
        };
        let shifted = x.mul_add(x.same(-std::f64::consts::LOG2_E), x.same(ROUND));
        let n = shifted - x.same(ROUND);
        let r = n.mul_add(x.same(-LN2_HIGH), -x);
        let r = n.mul_add(x.same(-LN2_LOW), r);
        // Estrin's scheme: short chains keep the vector units busy.
        let pair = |k: usize| r.same(C[k + 1]).mul_add(r, r.same(C[k]));
        let r2 = r * r;
        let quad = |k: usize| pair(k + 2).mul_add(r2, pair(k));
        let r4 = r2 * r2;
        let low = quad(4).mul_add(r4, quad(0));
        let high = r.same(C[12]).mul_add(r4, quad(8));
        let series = high.mul_add(r4 * r4, low);
        // 2^n: the integer moved into the exponent's place (times 2^52) on top of 1.0's bits.
        let n_bits = simd.transmute_u64s_f64s(shifted.x);
        let exponent = simd.mul_u64s(n_bits, simd.splat_u64s(1 << 52));
        let bits = simd.add_u64s(exponent, simd.splat_u64s(1.0_f64.to_bits()));
        let power = Self {
            simd,
            x: simd.transmute_f64s_u64s(bits),
        };
        Exponential {
            power,
            fraction: r * series,
        }
    }
}

/// `exp(-x) = power (1 + fraction)`: `power` a power of two, `fraction = exp(r) - 1` of the
/// remainder `|r| <= ln(2)/2`.
struct Exponential<S: Simd> {
    power: Vector<S>,
    fraction: Vector<S>,
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, Scalar, WithSimd};

    use super::*;

    /// `exp(-x)` and `1 - exp(-x)` of each number.
    struct Both<'a>(&'a [f64], &'a mut Vec<[f64; 2]>);

    impl WithSimd for Both<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for &x in self.0 {
                let x = Vector::splat(simd, x);
                let first = |v: Vector<S>| v.sum() / S::F64_LANES as f64;
                self.1
                    .push([first(x.neg_exp()), first(x.one_minus_neg_exp())]);
            }
        }
    }

    fn both(xs: &[f64]) -> [Vec<[f64; 2]>; 2] {
        let (mut best, mut scalar) = (Vec::new(), Vec::new());
        Arch::new().dispatch(Both(xs, &mut best));
        Both(xs, &mut scalar).with_simd(Scalar::new());
        [best, scalar]
    }

    /// The stated errors, in units of 2^-52, over the whole range, with and without vectors.
    #[test]
    fn exponentials_are_accurate() {
        let xs: Vec<f64> = (0..200_000)
            .map(|k| 1e-300 * (f64::from(k) * 0.003_495).exp())
            .filter(|x| *x < 700.0)
            .collect();
        assert!(*xs.last().unwrap() > 600.0);
        for got in both(&xs) {
            let mut worst = [0.0_f64; 2];
            for (x, got) in xs.iter().zip(&got) {
                let want = [(-x).exp(), -(-x).exp_m1()];
                for i in 0..2 {
                    worst[i] = worst[i].max((got[i] / want[i] - 1.0).abs() / f64::EPSILON);
                }
            }
            assert!(worst[0] < 1.5 && worst[1] < 2.5, "{worst:?}");
        }
    }

    /// Far out the exponential stays finite, and a NaN is not swallowed.
    #[test]
    fn ends_of_the_range() {
        for got in both(&[0.0, 1e300, f64::INFINITY, f64::NAN]) {
            assert_eq!(got[0], [1.0, 0.0]);
            assert!(got[1][0] < 1e-300 && got[1][1] == 1.0);
            assert_eq!(got[2][1], 1.0);
            assert!(got[3][0].is_nan() && got[3][1].is_nan());
        }
    }
}
