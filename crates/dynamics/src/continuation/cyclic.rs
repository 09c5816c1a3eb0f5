//! The linear systems of multiple shooting: orthogonal transformations of the equations of all segments at once, which need no
//! product of the segments.

use std::f64::consts::{GOLDEN_RATIO, SQRT_2};

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{gevd_real, gevd_scratch};
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatRef, Par};
use nalgebra::{Complex, DMatrix, DVector};

use super::Multiplier;
use super::flow::SegmentEnds;
use super::shooting::{Direction, Scale, ShootingPoint, direction};

/// The row of the phase condition in scaled unknowns, of norm 1: the flow at the starts of the segments. An orbit at rest has no
/// phase; its row is zero. The period of a forced system does not change.
pub(super) fn phase_row(shot: &ShootingPoint, ends: &SegmentEnds, scale: &Scale) -> Direction {
    if shot.drive_periods.is_some() {
        let still: Vec<_> = shot.states.iter().map(|state| state * 0.0).collect();
        return direction(&still, 1.0, 0.0);
    }
    let (last, others) = ends.slopes.split_last().expect("segments");
    let row = scale.scaled(&direction([last].into_iter().chain(others), 0.0, 0.0));
    let norm = row.norm();
    if norm > 0.0 { row / norm } else { row }
}

/// An entry of a sparse matrix.
pub(super) type Entry = Triplet<usize, usize, f64>;

/// The derivatives of the distances of the segment ends from the next starts, and of the phase, with respect to the states and
/// the period, in scaled unknowns: the entries of a square matrix. With `reversed`, the last segment ends at the first start
/// with the opposite sign.
pub(super) fn equations(
    shot: &ShootingPoint,
    ends: &SegmentEnds,
    scale: &Scale,
    phase: &Direction,
    reversed: bool,
) -> Vec<Entry> {
    let (n, count) = (scale.state.len(), shot.len());
    let period = n * count;
    let units = scale.units(count);
    let mut entries = Vec::new();
    for (k, map) in ends.maps.iter().enumerate() {
        let next = (k + 1) % count;
        let sign = if reversed && next == 0 { 1.0 } else { -1.0 };
        let [from, to] = shot.span(k);
        for i in 0..n {
            let row = k * n + i;
            entries.push(Entry::new(row, next * n + i, sign));
            for j in 0..n {
                let entry = map[(i, j)] * scale.state[i] / scale.state[j];
                entries.push(Entry::new(row, k * n + j, entry));
            }
            if shot.drive_periods.is_none() {
                let slope = ends.slopes[k][i] * (to - from) * units[row] / units[period];
                entries.push(Entry::new(row, period, slope));
            }
        }
    }
    entries.extend((0..=period).map(|j| Entry::new(period, j, phase[j])));
    entries
}

/// Solves a system of equations with as many unknowns for each column of right sides. Entries at the same place are added.
/// `None` if it is singular.
pub(super) fn solve(entries: &[Entry], right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = right.nrows();
    let matrix = SparseColMat::try_new_from_triplets(size, size, entries).ok()?;
    let solution = matrix.sp_qr().ok()?.solve(view(right));
    let solution = DMatrix::from_fn(size, right.ncols(), |i, j| solution[(i, j)]);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// The direction in which a square matrix is singular, by a border of a row and a column with which it is not.
pub(super) fn null_direction(mut entries: Vec<Entry>, size: usize) -> Option<DVector<f64>> {
    // Any numbers.
    let border = |i: usize, by: f64| (i as f64 * by).fract() - 0.5;
    for i in 0..size {
        entries.push(Entry::new(i, size, border(i, GOLDEN_RATIO)));
        entries.push(Entry::new(size, i, border(i, SQRT_2)));
    }
    let mut right = DMatrix::zeros(size + 1, 1);
    right[size] = 1.0;
    let solution = solve(&entries, &right)?;
    Some(solution.rows(0, size).column(0).into_owned())
}

fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// The two matrices `A` and `Z` that are left of the segments, `A y_0 + Z y_N = 0`, when all states between are removed. A QR
/// factorisation of the column of each of them, `[Z; G_k]`, removes one after another (S. J. Wright, SIAM J. Sci. Stat. Comput.
/// 13 (1992) 742-764): no growth of the flow over more than one segment enters.
fn condensed(maps: &[DMatrix<f64>]) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = maps[0].nrows();
    let minus_identity = -DMatrix::<f64>::identity(n, n);
    let (mut a, mut z) = (maps[0].clone(), minus_identity.clone());
    for map in &maps[1..] {
        let mut column = DMatrix::zeros(2 * n, n);
        column.rows_mut(0, n).copy_from(&z);
        column.rows_mut(n, n).copy_from(map);
        let mut rest = DMatrix::zeros(2 * n, 2 * n);
        rest.view_mut((0, 0), (n, n)).copy_from(&a);
        rest.view_mut((n, n), (n, n)).copy_from(&minus_identity);
        column.qr().q_tr_mul(&mut rest);
        a.copy_from(&rest.view((n, 0), (n, n)));
        z.copy_from(&rest.view((n, n), (n, n)));
    }
    (a, z)
}

/// The eigenvalues of the product of the segment maps: the generalized eigenvalues of `A` and `-Z`. The largest comes first,
/// of a pair that with the positive angle. Those that are lost in rounding errors, below about 1e-15 of the largest or of
/// 1, are zero. `None` if the maps are not finite, or without convergence.
pub fn multipliers(maps: &[DMatrix<f64>]) -> Option<Vec<Multiplier>> {
    if !maps.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let (a, z) = condensed(maps);
    let n = a.nrows();
    // The errors of the maps and of the elimination.
    let rounding = 2.0 * n as f64 * f64::EPSILON * a.norm().max(z.norm());
    let [mut a, mut minus_z] = [a, -z].map(|matrix| Mat::from_fn(n, n, |i, j| matrix[(i, j)]));
    let [mut real, mut imaginary, mut below] = [(); 3].map(|()| Diag::<f64>::zeros(n));
    let (par, none) = (Par::Seq, ComputeEigenvectors::No);
    // For small matrices the library requests less scratch than it takes.
    let more = StackReq::new_aligned::<f64>(2 * n.next_multiple_of(64), 64);
    let scratch = gevd_scratch::<f64>(n, none, none, par, Default::default()).and(more);
    gevd_real(
        a.as_mut(),
        minus_z.as_mut(),
        real.as_mut(),
        imaginary.as_mut(),
        below.as_mut(),
        None,
        None,
        par,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .ok()?;
    let [real, imaginary, below] = [real, imaginary, below].map(Diag::into_column_vector);
    let mut all = Vec::with_capacity(n);
    // Of each pair the other one is the exact conjugate.
    for k in (0..n).filter(|&k| imaginary[k] >= 0.0) {
        let (above, below) = (Complex::new(real[k], imaginary[k]), below[k]);
        let multiplier = match above.norm() {
            size if size <= rounding => Multiplier::ZERO,
            size => Multiplier {
                ln_magnitude: (size / below).abs().ln(),
                // Without a negative zero.
                angle: f64::atan2(above.im / below + 0.0, above.re / below),
            },
        };
        all.push(multiplier);
        if above.im > 0.0 {
            let angle = -multiplier.angle + 0.0;
            all.push(Multiplier {
                angle,
                ..multiplier
            });
        }
    }
    all.sort_by(Multiplier::order);
    Some(all)
}
