//! SIMD arithmetic on several contact nodes at once.
//!
//! [`Eight`] stores a number for eight nodes; [`Vector`] holds the operands of one instruction: eight
//! numbers with AVX-512, four with AVX2, two with NEON, one without SIMD. Several independent vectors side
//! by side hide the latency of dependent operations.
//!
//! Functions between the hot loops and the instructions must be inlined to use the instruction set of the
//! loop. Closures with vectors are therefore marked `#[inline(always)]`, and arrays of vectors are filled by
//! plain loops, since `from_fn` and `map` are not always inlined.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

/// Number of nodes in a block.
pub(crate) const LANES: usize = 8;

/// A number for each of eight nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Eight(pub [f64; LANES]);

impl Eight {
    /// Zero for every node.
    pub const ZERO: Eight = Eight([0.0; LANES]);

    /// Loads one of the vectors that make up the eight numbers.
    #[inline(always)]
    pub fn part<S: Simd>(&self, simd: S, part: usize) -> Vector<S> {
        Vector {
            simd,
            x: [S::as_simd_f64s(&self.0).0[part]],
        }
    }
}

/// Number of vectors in eight numbers.
#[inline(always)]
pub(crate) const fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// Storage position of a vector of nodes.
#[derive(Clone, Copy)]
pub(crate) struct LanePosition {
    pub block: usize,
    /// Index of the vector in the block.
    pub part: usize,
}

impl LanePosition {
    /// Position of the vector with a global index.
    #[inline(always)]
    pub fn of<S: Simd>(vector: usize) -> Self {
        Self {
            block: vector / parts::<S>(),
            part: vector % parts::<S>(),
        }
    }
}

/// `K` SIMD vectors side by side.
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
    /// Applies a function to each SIMD vector.
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

    /// The same number in every lane, with the instruction set of `self`.
    #[inline(always)]
    pub fn broadcast(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    /// Builds adjacent vectors from single ones.
    #[inline(always)]
    pub fn from_parts(simd: S, vector: impl Fn(usize) -> Vector<S>) -> Self {
        let mut all = Self::splat(simd, 0.0);
        for k in 0..K {
            all.x[k] = vector(k).x[0];
        }
        all
    }

    /// One of the adjacent vectors.
    #[inline(always)]
    pub fn one(self, k: usize) -> Vector<S> {
        Vector {
            simd: self.simd,
            x: [self.x[k]],
        }
    }

    /// `self * b + c`, with a single rounding if the machine has fused multiply-add.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        self.each(
            #[inline(always)]
            |k, x| self.simd.mul_add_e_f64s(x, b.x[k], c.x[k]),
        )
    }

    /// Maximum with `floor`; NaN propagates.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Self {
        let (simd, floor) = (self.simd, self.simd.splat_f64s(floor));
        self.each(
            #[inline(always)]
            |_, x| {
                if S::F64_LANES > 1 {
                    // The instruction returns its second operand if one is NaN.
                    return simd.max_f64s(floor, x);
                }
                simd.select_f64s(simd.less_than_f64s(x, floor), floor, x)
            },
        )
    }

    /// Minimum with `ceiling`; NaN propagates.
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

    /// `2^n` for a vector equal to `n + 1.5 * 2^52`, whose low bits contain the integer `n` from -1022 to
    /// 1023.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        let simd = self.simd;
        self.each(
            #[inline(always)]
            |_, x| {
                // Shifts the integer to the exponent field, on top of the bits of 1.0.
                let n = simd.transmute_u64s_f64s(x);
                let exponent = simd.mul_u64s(n, simd.splat_u64s(1 << 52));
                let bits = simd.add_u64s(exponent, simd.splat_u64s(1.0_f64.to_bits()));
                simd.transmute_f64s_u64s(bits)
            },
        )
    }

    /// Replaces one of the adjacent vectors.
    #[inline(always)]
    pub fn set(&mut self, k: usize, vector: Vector<S>) {
        self.x[k] = vector.x[0];
    }

    /// The vector in lanes where `other` is positive, zero in the other lanes.
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
    /// Loads a vector of a block.
    #[inline(always)]
    pub fn load(simd: S, eight: &[f64; LANES], part: usize) -> Self {
        let x = [S::as_simd_f64s(eight).0[part]];
        Self { simd, x }
    }

    /// Stores a vector of a block.
    #[inline(always)]
    pub fn store(self, eight: &mut [f64; LANES], part: usize) {
        S::as_mut_simd_f64s(eight).0[part] = self.x[0];
    }

    /// The numbers of the lanes in ascending order.
    #[inline(always)]
    pub fn from_lanes(simd: S, number: impl Fn(usize) -> f64) -> Self {
        let mut lanes = [0.0; LANES];
        for (lane, x) in lanes[..S::F64_LANES].iter_mut().enumerate() {
            *x = number(lane);
        }
        Self::load(simd, &lanes, 0)
    }

    /// The numbers of the lanes; those beyond them are zero.
    #[inline(always)]
    pub fn lanes(self) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        self.store(&mut lanes, 0);
        lanes
    }

    /// Applies a function of scalars with two results to the lanes.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> [f64; 2]) -> [Self; 2] {
        let mut both = [[0.0; LANES]; 2];
        for (lane, x) in self.lanes()[..S::F64_LANES].iter().enumerate() {
            [both[0][lane], both[1][lane]] = f(*x);
        }
        [
            Self::load(self.simd, &both[0], 0),
            Self::load(self.simd, &both[1], 0),
        ]
    }

    /// The vector with `new` in the lanes where `x` is at least `least`.
    #[inline(always)]
    pub fn replaced_where(self, x: Self, least: Self, new: Self) -> Self {
        let simd = self.simd;
        let is_above = simd.greater_than_or_equal_f64s(x.x[0], least.x[0]);
        Self {
            simd,
            x: [simd.select_f64s(is_above, new.x[0], self.x[0])],
        }
    }

    /// Minimum and maximum over the lanes; arbitrary if one is NaN.
    #[inline(always)]
    pub fn range(self) -> [f64; 2] {
        let [x] = self.x;
        [self.simd.reduce_min_f64s(x), self.simd.reduce_max_f64s(x)]
    }

    /// The vector in lanes with a clear status bit, zero in the other lanes.
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

    /// Sum over the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.x[0])
    }
}
