//! Sine and cosine of many angles at once.
//!
//! An exponential method evaluates sine and cosine of one angle per mode at every sample and at every
//! change of the step. The standard library processes one angle at a time. The branch-free form below
//! processes a vector of them at the same accuracy: the angle is reduced to `[-pi/4, pi/4]` with a two-part value
//! of pi/2 (W. J. Cody and W. Waite, Software Manual for the Elementary Functions, 1980), where the
//! Taylor series are short.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use pulp::Simd;

use super::combination::MAX_LANES;

/// The leading 33 bits of pi/2: a product with an integer below 2^20 is exact.
const HALF_PI_HIGH: f64 = f64::from_bits(FRAC_PI_2.to_bits() & !((1 << 20) - 1));
/// The low-order part of pi/2: the remaining bits of the rounded value and its rounding error.
const HALF_PI_LOW: f64 = (FRAC_PI_2 - HALF_PI_HIGH) + 6.123_233_995_736_766e-17;
/// Adding this to a small number rounds it to an integer in the lowest bits.
const ROUNDING_OFFSET: f64 = 1.5 * (1_u64 << 52) as f64;
/// Angles below this are reduced exactly (fewer than 2^20 multiples of pi/2), rad.
pub(super) const MAX_REDUCED_ANGLE: f64 = 1e6;

/// Sine and cosine of each angle (rad). `are_small` states that all are below [`MAX_REDUCED_ANGLE`].
#[inline(always)]
pub(super) fn sin_cos<S: Simd>(simd: S, angles: S::f64s, are_small: bool) -> [S::f64s; 2] {
    if are_small {
        return reduced(simd, angles);
    }
    let (mut sin, mut cos) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
    let (sin, cos) = (&mut sin[..S::F64_LANES], &mut cos[..S::F64_LANES]);
    simd.partial_store_f64s(sin, angles);
    each_sin_cos(sin, cos);
    [sin, cos].map(|numbers| simd.partial_load_f64s(numbers))
}

/// Replaces angles by their sines and writes their cosines, by the standard library.
#[inline(never)]
fn each_sin_cos(angles: &mut [f64], cos: &mut [f64]) {
    for (x, cos) in angles.iter_mut().zip(cos) {
        (*x, *cos) = x.sin_cos();
    }
}

/// Sine and cosine of angles below [`MAX_REDUCED_ANGLE`].
#[inline(always)]
fn reduced<S: Simd>(simd: S, x: S::f64s) -> [S::f64s; 2] {
    let offset = simd.splat_f64s(ROUNDING_OFFSET);
    let rounded = multiply_add(simd, x, simd.splat_f64s(FRAC_2_PI), offset);
    let turns = simd.sub_f64s(rounded, offset);
    let high = multiply_add(simd, turns, simd.splat_f64s(-HALF_PI_HIGH), x);
    let r = multiply_add(simd, turns, simd.splat_f64s(-HALF_PI_LOW), high);
    let r2 = simd.mul_f64s(r, r);
    let s = multiply_add(simd, simd.mul_f64s(r, r2), series(simd, r2, &SINE), r);
    let c = multiply_add(simd, r2, series(simd, r2, &COSINE), simd.splat_f64s(1.0));
    // Multiples of pi/2: sin -> cos -> -sin -> -cos. Bit 0 exchanges the two, bit 1 changes the sign.
    let quadrant = simd.transmute_u64s_f64s(rounded);
    let is_odd = has_bit(simd, quadrant, 1);
    let sin = simd.select_f64s(is_odd, c, s);
    let cos = simd.select_f64s(is_odd, s, c);
    let next = simd.add_u64s(quadrant, simd.splat_u64s(1));
    [
        simd.select_f64s(has_bit(simd, quadrant, 2), simd.neg_f64s(sin), sin),
        simd.select_f64s(has_bit(simd, next, 2), simd.neg_f64s(cos), cos),
    ]
}

/// `a b + c`, with two roundings on every machine.
#[inline(always)]
fn multiply_add<S: Simd>(simd: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    simd.add_f64s(simd.mul_f64s(a, b), c)
}

/// Whether the integers have the given bit.
#[inline(always)]
fn has_bit<S: Simd>(simd: S, integers: S::u64s, bit: u64) -> S::m64s {
    let bit = simd.splat_u64s(bit);
    simd.equal_u64s(simd.and_u64s(integers, bit), bit)
}

/// `sum_k coefficients[k] x^k` by Horner's rule.
#[inline(always)]
fn series<S: Simd>(simd: S, x: S::f64s, coefficients: &[f64; 8]) -> S::f64s {
    let mut sum = simd.splat_f64s(0.0);
    for &c in coefficients.iter().rev() {
        sum = multiply_add(simd, sum, x, simd.splat_f64s(c));
    }
    sum
}

/// Coefficients of `(sin r - r) / r^3` in powers of `r^2`: `-1/3!, 1/5!, ..`.
const SINE: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];
/// Coefficients of `(cos r - 1) / r^2` in powers of `r^2`: `-1/2!, 1/4!, ..`.
const COSINE: [f64; 8] = [
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::*;

    /// Sines and cosines of angles.
    struct Both<'a>(&'a [f64]);

    impl WithSimd for Both<'_> {
        type Output = [Vec<f64>; 2];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> [Vec<f64>; 2] {
            let (mut sin, mut cos) = (Vec::new(), Vec::new());
            for angles in self.0.chunks(S::F64_LANES) {
                let are_small = angles.iter().all(|x| x.abs() < MAX_REDUCED_ANGLE);
                let found = sin_cos(simd, simd.partial_load_f64s(angles), are_small);
                for (out, vector) in [&mut sin, &mut cos].into_iter().zip(found) {
                    let mut numbers = vec![0.0; angles.len()];
                    simd.partial_store_f64s(&mut numbers, vector);
                    out.extend(numbers);
                }
            }
            [sin, cos]
        }
    }

    #[test]
    fn agrees_with_the_standard_library_to_two_units_in_the_last_place() {
        let mut angles: Vec<f64> = (-4000..=4000).map(|k| f64::from(k) * 0.007_853).collect();
        angles.extend((0..400).map(|k| 1.7e3 * f64::from(k) * 1.47));
        angles.extend([
            0.0,
            1e-300,
            -5e-324,
            FRAC_PI_2,
            -FRAC_PI_2,
            2.0 * FRAC_PI_2,
            999_999.0,
        ]);
        let [sin, cos] = Arch::new().dispatch(Both(&angles));
        for (i, x) in angles.iter().enumerate() {
            assert!(
                (sin[i] - x.sin()).abs() <= 2.3e-16,
                "sin {x}: {} {}",
                sin[i],
                x.sin()
            );
            assert!(
                (cos[i] - x.cos()).abs() <= 2.3e-16,
                "cos {x}: {} {}",
                cos[i],
                x.cos()
            );
        }
        assert_eq!((sin[8401], cos[8401]), (0.0, 1.0));
        assert_eq!(sin[8402], 1e-300);
    }

    #[test]
    fn large_angles_use_the_standard_library() {
        let [sin, cos] = Arch::new().dispatch(Both(&[1e9, 0.5, f64::NAN]));
        assert_eq!((sin[0], cos[0]), 1e9_f64.sin_cos());
        assert_eq!((sin[1], cos[1]), 0.5_f64.sin_cos());
        assert!(sin[2].is_nan() && cos[2].is_nan());
    }
}
