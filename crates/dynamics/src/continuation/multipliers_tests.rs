//! Multipliers of products with known eigenvalues.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cyclic::multipliers;
use super::*;

fn random(rng: &mut ChaCha8Rng, n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0))
}

/// A random matrix with singular values between 1 and 3.
fn well_conditioned(rng: &mut ChaCha8Rng, n: usize) -> DMatrix<f64> {
    let (a, b) = (random(rng, n).qr().q(), random(rng, n).qr().q());
    let values = DVector::from_fn(n, |_, _| rng.random_range(1.0..3.0));
    a * DMatrix::from_diagonal(&values) * b
}

/// Factors `S_(k+1) D_k S_k^-1` of a product similar to the product of the blocks `D_k`.
fn factors(rng: &mut ChaCha8Rng, blocks: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
    let n = blocks[0].nrows();
    let frames: Vec<_> = blocks.iter().map(|_| well_conditioned(rng, n)).collect();
    let all = blocks.iter().enumerate();
    all.map(|(k, block)| {
        let inverse = frames[k].clone().try_inverse().expect("well conditioned");
        &frames[(k + 1) % frames.len()] * block * inverse
    })
    .collect()
}

/// Diagonal factors whose logarithms sum to those given, plus noise that cancels in the sum.
fn diagonals(rng: &mut ChaCha8Rng, logarithms: &[f64], count: usize) -> Vec<DMatrix<f64>> {
    let n = logarithms.len();
    let mut noise = vec![0.0; n];
    (0..count)
        .map(|k| {
            let diagonal = DVector::from_fn(n, |i, _| {
                let more = if k + 1 == count {
                    -noise[i]
                } else {
                    rng.random_range(-0.5..0.5)
                };
                noise[i] += more;
                (logarithms[i] / count as f64 + more).exp()
            });
            DMatrix::from_diagonal(&diagonal)
        })
        .collect()
}

/// The error of a multiplier is that of a backward error of the largest one.
#[test]
fn multipliers_are_accurate_relative_to_the_largest() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for n in [2, 3, 6, 12] {
        // From 1e5 to 1e-55, in 20 factors whose condition is up to 1e4.
        let logarithms: Vec<f64> = (0..n)
            .map(|i| (5.0 - 60.0 * i as f64 / (n - 1) as f64) * 10.0_f64.ln())
            .collect();
        let blocks = diagonals(&mut rng, &logarithms, 20);
        let found = multipliers(&factors(&mut rng, &blocks)).unwrap();
        assert_eq!(found.len(), n);
        let largest = logarithms[0].exp();
        for (multiplier, logarithm) in found.iter().zip(&logarithms) {
            let error = multiplier.distance_from(logarithm.exp()) / largest;
            assert!(error < 1e-10, "{n}: {multiplier:?} {logarithm} {error:e}");
        }
    }
}

#[test]
fn singular_factors_give_exact_zeros_and_leave_the_other_eigenvalues() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (n, zeros, count) in [
        (2, 1, 1),
        (2, 1, 4),
        (5, 1, 3),
        (5, 3, 4),
        (7, 2, 3),
        (4, 4, 2),
    ] {
        let mut logarithms = vec![f64::NEG_INFINITY; n];
        for (i, logarithm) in logarithms.iter_mut().enumerate().take(n - zeros) {
            *logarithm = 1.0 - 2.0 * i as f64;
        }
        let finite: Vec<f64> = logarithms
            .iter()
            .map(|&x| if x.is_finite() { x } else { -1.0 })
            .collect();
        let mut blocks = diagonals(&mut rng, &finite, count);
        for i in n - zeros..n {
            // In different factors.
            blocks[i % count][(i, i)] = 0.0;
        }
        let found = multipliers(&factors(&mut rng, &blocks)).unwrap();
        for (multiplier, logarithm) in found.iter().zip(&logarithms) {
            if logarithm.is_finite() {
                let error = (multiplier.ln_magnitude - logarithm).abs();
                assert!(
                    error < 1e-9,
                    "{n} {zeros} {count}: {multiplier:?} {logarithm}"
                );
            } else {
                assert_eq!(*multiplier, Multiplier::ZERO, "{n} {zeros} {count}");
            }
        }
    }
}

#[test]
fn a_defective_eigenvalue_is_found_to_the_root_of_the_rounding() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let jordan = DMatrix::from_row_slice(3, 3, &[0.5, 1.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, -0.5]);
    let one = DMatrix::identity(3, 3);
    let found = multipliers(&factors(&mut rng, &[jordan, one.clone(), one])).unwrap();
    assert_eq!(found.len(), 3);
    // The mean of the two perturbed values is well conditioned.
    let double: Vec<_> = found.iter().filter(|m| m.re() > 0.0).collect();
    assert_eq!(double.len(), 2, "{found:?}");
    assert!(
        double.iter().all(|m| m.distance_from(0.5) < 1e-6),
        "{found:?}"
    );
    assert!((double[0].re() + double[1].re() - 1.0).abs() < 1e-13);
    let single = found.iter().find(|m| m.re() < 0.0).unwrap();
    assert_eq!(single.angle, PI);
    assert!((single.re() + 0.5).abs() < 1e-13);
}

#[test]
fn random_products_agree_with_their_eigenvalues() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for case in 0..200 {
        let n = 1 + case % 8;
        let count = 1 + case % 3;
        let all: Vec<_> = (0..count).map(|_| random(&mut rng, n)).collect();
        let product = all
            .iter()
            .fold(DMatrix::identity(n, n), |product, factor| factor * product);
        let found = multipliers(&all).unwrap();
        let size = product.norm();
        let mut expected: Vec<_> = product.complex_eigenvalues().iter().copied().collect();
        for multiplier in &found {
            let distance =
                |z: &nalgebra::Complex<f64>| (z.re - multiplier.re()).hypot(z.im - multiplier.im());
            let nearest = (0..expected.len())
                .min_by(|&a, &b| distance(&expected[a]).total_cmp(&distance(&expected[b])))
                .unwrap();
            let error = distance(&expected[nearest]);
            assert!(error < 1e-6 * size, "{case}: {multiplier:?} {error:e}");
            expected.swap_remove(nearest);
        }
        // Conjugates are exact.
        for multiplier in found.iter().filter(|m| !m.is_real()) {
            let conjugate = Multiplier {
                angle: -multiplier.angle,
                ..*multiplier
            };
            assert!(found.contains(&conjugate), "{found:?}");
        }
        let ln_product: f64 = found.iter().map(|m| m.ln_magnitude).sum();
        let ln_factors: f64 = all.iter().map(|f| f.determinant().abs().ln()).sum();
        assert!((ln_product - ln_factors).abs() < 1e-9 * (1.0 + ln_factors.abs()));
    }
}

#[test]
fn values_that_are_not_finite_are_an_error() {
    assert_eq!(multipliers(&[DMatrix::from_element(1, 1, f64::NAN)]), None);
}

#[test]
fn multipliers_are_written_as_pairs() {
    let multiplier = Multiplier {
        ln_magnitude: 0.25_f64.ln(),
        angle: PI,
    };
    assert_eq!(serde_json::to_string(&multiplier).unwrap(), "[-0.25,0.0]");
    let zero = serde_json::to_string(&Multiplier::ZERO).unwrap();
    assert_eq!(zero, "[0.0,0.0]");
}
