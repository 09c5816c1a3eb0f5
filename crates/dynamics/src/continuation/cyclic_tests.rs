//! The linear equations of multiple shooting.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cyclic::{Entry, equations, null_direction, phase_row, solve};
use super::flow::SegmentEnds;
use super::shooting::{Scale, ShootingPoint};
use crate::System;

/// First-order components without a law.
struct Components(usize);

impl System for Components {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        self.0
    }

    fn force(&self, _t: f64, _z: &[f64], out: &mut [f64]) {
        out.fill(0.0);
    }

    fn is_autonomous(&self) -> bool {
        true
    }
}

fn random(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

fn vectors(rng: &mut ChaCha8Rng, n: usize, count: usize) -> Vec<DVector<f64>> {
    let vector = |_| random(rng, n, 1).column(0).into_owned();
    (0..count).map(vector).collect()
}

/// Segments with these maps, and random states and slopes.
fn segments(rng: &mut ChaCha8Rng, maps: Vec<DMatrix<f64>>) -> (ShootingPoint, SegmentEnds, Scale) {
    let (n, count) = (maps[0].nrows(), maps.len());
    let shot = ShootingPoint {
        parameter: 0.0,
        period: 2.0,
        drive_periods: None,
        phases: (0..count).map(|k| k as f64 / count as f64).collect(),
        states: vectors(rng, n, count),
        statuses: Vec::new(),
    };
    let ends = SegmentEnds {
        ends: vectors(rng, n, count),
        slopes: vectors(rng, n, count),
        statuses: Vec::new(),
        maps,
        crossings: 0,
    };
    (shot, ends, Scale::new(&Components(n), [0.0, 3.0], 2.0, 1.0))
}

/// The growth per segment is that of the largest segments by default; over all segments it is up to 1e104.
#[test]
fn the_equations_hold_for_strong_growth_and_contraction() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (count, growth) in [(1, 1.0), (2, 1e2), (5, 1e3), (30, 3e3)] {
        for n in [1, 3, 6] {
            let maps = (0..count).map(|_| {
                // One direction grows, the others contract.
                let [a, b] = [(); 2].map(|()| random(&mut rng, n, n).qr().q());
                let sizes = DMatrix::from_fn(n, n, |i, j| match (i == j, i) {
                    (true, 0) => growth,
                    (true, _) => 1.0 / growth,
                    _ => 0.0,
                });
                a * sizes * b
            });
            let maps: Vec<_> = maps.collect();
            let (shot, ends, scale) = segments(&mut rng, maps.clone());
            let phase = phase_row(&shot, &ends, &scale);
            let right = random(&mut rng, n * count + 1, 2);
            let entries = equations(&shot, &ends, &scale, &phase, false);
            let solution = solve(&entries, &right).unwrap();
            let units = scale.units(count);
            for column in 0..2 {
                let scaled = solution.column(column);
                let x = scaled.component_div(&units.rows(0, n * count + 1));
                let mut worst =
                    (phase.rows(0, n * count + 1).dot(&scaled) - right[(n * count, column)]).abs();
                for (k, map) in maps.iter().enumerate() {
                    let next = (k + 1) % count * n;
                    let [from, to] = shot.span(k);
                    let distance = map * x.rows(k * n, n) - x.rows(next, n)
                        + &ends.slopes[k] * ((to - from) * x[n * count]);
                    let error = distance * units[0] - right.view((k * n, column), (n, 1));
                    worst = worst.max(error.amax() / map.amax().max(1.0));
                }
                let error = worst / scaled.amax().max(1.0);
                assert!(error < 1e-11, "{count} {growth} {n}: {error:e}");
            }
        }
    }
}

#[test]
fn the_null_direction_is_that_of_a_singular_matrix() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let direction = random(&mut rng, 5, 1).normalize();
    let mut matrix = random(&mut rng, 5, 5);
    let image = &matrix * &direction;
    matrix -= image * direction.transpose();
    let places = (0..25).map(|k| Entry::new(k / 5, k % 5, matrix[(k / 5, k % 5)]));
    let found = null_direction(places.collect(), 5).unwrap().normalize();
    assert!((found.dot(&direction).abs() - 1.0).abs() < 1e-13);
}
