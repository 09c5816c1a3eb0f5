//! Contact nodes worked on several at once, with the vector instructions that the machine has.
//!
//! [`Eight`] is how eight nodes are stored; [`Vector`] is what one instruction works on: eight
//! numbers with AVX-512, four with AVX2, two with NEON, one without any. Operations that wait for
//! each other leave the machine idle, so a vector can be several, which go side by side.
//!
//! Functions that stand between the hot loops and the instructions must be inlined for the machine
//! that the loop is compiled for: closures that use vectors are marked, and arrays of vectors are
//! filled by plain loops, as `from_fn` and `map` are not.

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
            x: [S::as_simd_f64s(&self.0).0[part]],
        }
    }
}

/// How many vectors make up eight numbers.
#[inline(always)]
pub(crate) const fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// Where the nodes of a vector are stored.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub block: usize,
    /// Which of the vectors that make up the block's eight.
    pub part: usize,
}

impl Place {
    /// Of the vectors of all blocks, counted through.
    #[inline(always)]
    pub fn of<S: Simd>(vector: usize) -> Self {
        Self {
            block: vector / parts::<S>(),
            part: vector % parts::<S>(),
        }
    }
}

/// As many numbers as `K` instructions work on, side by side.
#[derive(Clone, Copy)]
pub(crate) struct Vector<S: Simd, const K: usize = 1> {
    simd: S,
    x: [S::f64s; K],
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl<S: Simd, const K: usize> $trait for Vector<S, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.each(
                    #[inline(always)]
                    |k, x| self.simd.$instruction(x, other.x[k]),
                )
            }
        }
    };
}
lanewise!(Add, add, add_f64s);
lanewise!(Sub, sub, sub_f64s);
lanewise!(Mul, mul, mul_f64s);
lanewise!(Div, div, div_f64s);

impl<S: Simd, const K: usize> Neg for Vector<S, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(
            #[inline(always)]
            |_, x| self.simd.neg_f64s(x),
        )
    }
}

impl<S: Simd, const K: usize> Vector<S, K> {
    /// Every instruction's numbers changed by a function.
    #[inline(always)]
    fn each(mut self, f: impl Fn(usize, S::f64s) -> S::f64s) -> Self {
        for k in 0..K {
            self.x[k] = f(k, self.x[k]);
        }
        self
    }

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self {
            simd,
            x: [simd.splat_f64s(x); K],
        }
    }

    /// The same number in every lane, on the same machine.
    #[inline(always)]
    pub fn same(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    /// Vectors side by side, made one after another.
    #[inline(always)]
    pub fn beside(simd: S, vector: impl Fn(usize) -> Vector<S>) -> Self {
        let mut all = Self::splat(simd, 0.0);
        for k in 0..K {
            all.x[k] = vector(k).x[0];
        }
        all
    }

    /// One of the vectors side by side.
    #[inline(always)]
    pub fn one(self, k: usize) -> Vector<S> {
        Vector {
            simd: self.simd,
            x: [self.x[k]],
        }
    }

    /// `self * b + c`, rounded once where the machine can.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        self.each(
            #[inline(always)]
            |k, x| self.simd.mul_add_e_f64s(x, b.x[k], c.x[k]),
        )
    }

    /// Raised to `floor` where it is below; a NaN stays one.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Self {
        let (simd, floor) = (self.simd, self.simd.splat_f64s(floor));
        self.each(
            #[inline(always)]
            |_, x| {
                if S::F64_LANES > 1 {
                    // The instruction gives its second operand where one is NaN.
                    return simd.max_f64s(floor, x);
                }
                simd.select_f64s(simd.less_than_f64s(x, floor), floor, x)
            },
        )
    }

    /// Lowered to `ceiling` where it is above; a NaN stays one.
    #[inline(always)]
    pub fn at_most(self, ceiling: f64) -> Self {
        let (simd, ceiling) = (self.simd, self.simd.splat_f64s(ceiling));
        self.each(
            #[inline(always)]
            |_, x| {
                if S::F64_LANES > 1 {
                    return simd.min_f64s(ceiling, x);
                }
                simd.select_f64s(simd.greater_than_f64s(x, ceiling), ceiling, x)
            },
        )
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.each(
            #[inline(always)]
            |_, x| self.simd.sqrt_f64s(x),
        )
    }

    /// Changed by a function that sees plain numbers, a vector of them at a time.
    #[inline(always)]
    pub fn through(self, f: impl Fn(&mut [f64])) -> Self {
        self.each(
            #[inline(always)]
            |_, x| {
                let mut values = [0.0; LANES];
                let values = &mut values[..S::F64_LANES];
                self.simd.partial_store_f64s(values, x);
                f(values);
                self.simd.partial_load_f64s(values)
            },
        )
    }

    /// As [`Vector::through`], with a second vector made on the way.
    #[inline(always)]
    pub fn through_both(self, f: impl Fn(&mut [f64], &mut [f64])) -> (Self, Self) {
        let (mut first, mut second) = (self, self);
        for k in 0..K {
            let (mut values, mut others) = ([0.0; LANES], [0.0; LANES]);
            let values = &mut values[..S::F64_LANES];
            let others = &mut others[..S::F64_LANES];
            self.simd.partial_store_f64s(values, self.x[k]);
            f(values, others);
            first.x[k] = self.simd.partial_load_f64s(values);
            second.x[k] = self.simd.partial_load_f64s(others);
        }
        (first, second)
    }

    /// `2^n` where the vector is `n + 1.5 * 2^52`, which has the whole number `n` in its low bits;
    /// `n` from -1022 to 1023.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        let simd = self.simd;
        self.each(
            #[inline(always)]
            |_, x| {
                // The whole number moved into the exponent's place, on top of 1.0's bits.
                let n = simd.transmute_u64s_f64s(x);
                let exponent = simd.mul_u64s(n, simd.splat_u64s(1 << 52));
                let bits = simd.add_u64s(exponent, simd.splat_u64s(1.0_f64.to_bits()));
                simd.transmute_f64s_u64s(bits)
            },
        )
    }

    /// The vectors side by side, each changed by a function.
    #[inline(always)]
    pub fn each_vector(self, f: impl Fn(usize, Vector<S>) -> Vector<S>) -> Self {
        Self::beside(
            self.simd,
            #[inline(always)]
            |k| f(k, self.one(k)),
        )
    }

    /// The vector in the lanes where another is positive, zero in the others.
    #[inline(always)]
    pub fn where_positive(self, other: Self) -> Self {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        self.each(
            #[inline(always)]
            |k, x| simd.select_f64s(simd.greater_than_f64s(other.x[k], zero), x, zero),
        )
    }
}

impl<S: Simd> Vector<S> {
    /// Eight numbers' vectors, one after another, as they are kept in a slice.
    #[inline(always)]
    pub fn load(simd: S, eight: &[f64; LANES], part: usize) -> Self {
        let x = [S::as_simd_f64s(eight).0[part]];
        Self { simd, x }
    }

    /// Puts the vector back where [`Vector::load`] takes it from.
    #[inline(always)]
    pub fn store(self, eight: &mut [f64; LANES], part: usize) {
        S::as_mut_simd_f64s(eight).0[part] = self.x[0];
    }

    /// As many numbers as there are in a slice, at most a vector's; the other lanes are zero.
    #[inline(always)]
    pub fn load_some(simd: S, numbers: &[f64]) -> Self {
        let x = [simd.partial_load_f64s(numbers)];
        Self { simd, x }
    }

    /// Writes as many numbers as a slice has room for, at most a vector's.
    #[inline(always)]
    pub fn store_some(self, numbers: &mut [f64]) {
        self.simd.partial_store_f64s(numbers, self.x[0]);
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
            x: [simd.select_f64s(clear, self.x[0], simd.splat_f64s(0.0))],
        }
    }

    /// Negated in the lanes whose bit of the eight is set.
    #[inline(always)]
    pub fn negated_where_set(self, bits: u8, part: usize) -> Self {
        self.where_clear(bits, part) - self.where_clear(!bits, part)
    }

    /// The sum of the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.x[0])
    }

    /// One bit a lane, set where the number is negative.
    #[inline(always)]
    pub fn negative_bits(self) -> u8 {
        let mut values = [0.0; LANES];
        self.simd
            .partial_store_f64s(&mut values[..S::F64_LANES], self.x[0]);
        let negative = |l: usize| u8::from(values[l] < 0.0);
        (0..S::F64_LANES).fold(0, |bits, l| bits | negative(l) << l)
    }
}

/// The machines that this one can be, from the plainest.
#[cfg(test)]
pub(crate) fn machines() -> Vec<pulp::Arch> {
    let mut machines = vec![pulp::Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        machines.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        machines.extend(pulp::x86::V4::try_new().map(pulp::Arch::V4));
    }
    machines
}
