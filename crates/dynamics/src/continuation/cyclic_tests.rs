//! The elimination of multiple shooting against dense solutions.

use nalgebra::{Complex, DMatrix};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cyclic::{Segment, eigenvector, solve};

fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// Largest residual of the equations for a solution, relative to its largest number.
fn residual(segments: &[Segment], corner: &DMatrix<f64>, right: &DMatrix<f64>) -> f64 {
    let solution = solve(segments, corner.clone(), right.clone()).expect("regular");
    let count = segments.len();
    let mut border = corner * &solution.scalars - right;
    let mut worst = 0.0_f64;
    let mut largest = solution.scalars.amax();
    for (k, segment) in segments.iter().enumerate() {
        let row = &segment.map * &solution.states[k] - &solution.states[(k + 1) % count]
            + &segment.columns * &solution.scalars
            - &segment.right;
        worst = worst.max(row.amax() / segment.map.amax().max(1.0));
        largest = largest.max(solution.states[k].amax());
        border += &segment.border * &solution.states[k];
    }
    worst.max(border.amax()) / largest.max(1.0)
}

/// The growth per segment is that of the largest segments by default; over all segments it is up to 1e104.
#[test]
fn the_equations_hold_for_strong_growth_and_contraction() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (count, growth) in [(1, 1.0), (2, 1e2), (5, 1e3), (30, 3e3)] {
        for n in [1, 3, 6] {
            let segments: Vec<_> = (0..count)
                .map(|_| {
                    // One direction grows, the others contract.
                    let (a, b) = (
                        random(&mut rng, n, n).qr().q(),
                        random(&mut rng, n, n).qr().q(),
                    );
                    let sizes = DMatrix::from_fn(n, n, |i, j| match (i == j, i) {
                        (true, 0) => growth,
                        (true, _) => 1.0 / growth,
                        _ => 0.0,
                    });
                    Segment {
                        map: a * sizes * b,
                        columns: random(&mut rng, n, 2),
                        right: random(&mut rng, n, 2),
                        border: random(&mut rng, 2, n),
                    }
                })
                .collect();
            let (corner, right) = (random(&mut rng, 2, 2), random(&mut rng, 2, 2));
            let error = residual(&segments, &corner, &right);
            assert!(error < 1e-11, "{count} {growth} {n}: {error:e}");
        }
    }
}

#[test]
fn the_eigenvector_follows_the_segments() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let maps: Vec<_> = (0..4).map(|_| random(&mut rng, 3, 3)).collect();
    let product = maps
        .iter()
        .fold(DMatrix::identity(3, 3), |product, map| map * product);
    for value in product.complex_eigenvalues().iter() {
        let states = eigenvector(&maps, *value);
        for k in 0..4 {
            let map = maps[k].map(|x| Complex::new(x, 0.0));
            let next = match k {
                3 => &states[0] * *value,
                _ => states[k + 1].clone(),
            };
            assert!((map * &states[k] - next).norm() < 1e-12);
        }
    }
}
