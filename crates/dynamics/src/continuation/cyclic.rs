//! The linear systems of multiple shooting, by orthogonal elimination segment by segment.
//!
//! With the segment maps `G_k`, the columns `C_k` of the scalar unknowns `w` (period, parameter) and as many border rows:
//!
//! ```text
//! G_k y_k - y_(k+1) + C_k w = d_k        k = 0 .. N - 1,   y_N = y_0
//! sum_k B_k y_k + E w = e
//! ```
//!
//! A QR factorisation of the column of `y_k`, `[Z; G_k]`, removes the states one after another (S. J. Wright, SIAM J. Sci.
//! Stat. Comput. 13 (1992) 742-764). Its triangle is at least as well conditioned as `Z`, which starts as `-I`: no growth of
//! the flow over more than one segment enters.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{gevd_real, gevd_scratch};
use faer::{Mat, Par};
use nalgebra::{Complex, DMatrix, DVector};

use super::Multiplier;

/// One segment of the system.
pub struct Segment {
    /// `G`, `n x n`.
    pub map: DMatrix<f64>,
    /// `C`, `n x b`.
    pub columns: DMatrix<f64>,
    /// `d`, `n x r` for `r` right sides.
    pub right: DMatrix<f64>,
    /// `B`, `b x n`.
    pub border: DMatrix<f64>,
}

/// The solution for each right side.
pub struct Solution {
    /// The states `y_k`, `n x r` each.
    pub states: Vec<DMatrix<f64>>,
    /// The scalar unknowns `w`, `b x r`.
    pub scalars: DMatrix<f64>,
}

/// A removed state: `R y_k = g - A y_0 - Z y_(k+1) - F w`.
struct Removed {
    r: DMatrix<f64>,
    a: DMatrix<f64>,
    z: DMatrix<f64>,
    f: DMatrix<f64>,
    g: DMatrix<f64>,
}

/// The system without the states after the first: `A y_0 + Z y_N + F w = g`.
struct Reduced {
    removed: Vec<Removed>,
    a: DMatrix<f64>,
    z: DMatrix<f64>,
    f: DMatrix<f64>,
    g: DMatrix<f64>,
}

/// Removes the states after the first one.
fn reduce(segments: &[Segment]) -> Reduced {
    let n = segments[0].map.nrows();
    let minus_identity = -DMatrix::<f64>::identity(n, n);
    let mut reduced = Reduced {
        removed: Vec::with_capacity(segments.len() - 1),
        a: segments[0].map.clone(),
        z: minus_identity.clone(),
        f: segments[0].columns.clone(),
        g: segments[0].right.clone(),
    };
    let (b, r) = (reduced.f.ncols(), reduced.g.ncols());
    for segment in &segments[1..] {
        let mut stacked = DMatrix::zeros(2 * n, n);
        stacked.rows_mut(0, n).copy_from(&reduced.z);
        stacked.rows_mut(n, n).copy_from(&segment.map);
        // The columns of y_0, y_(k+1), w and the right sides.
        let mut rest = DMatrix::zeros(2 * n, 2 * n + b + r);
        rest.view_mut((0, 0), (n, n)).copy_from(&reduced.a);
        rest.view_mut((n, n), (n, n)).copy_from(&minus_identity);
        rest.view_mut((0, 2 * n), (n, b)).copy_from(&reduced.f);
        rest.view_mut((n, 2 * n), (n, b))
            .copy_from(&segment.columns);
        rest.view_mut((0, 2 * n + b), (n, r)).copy_from(&reduced.g);
        rest.view_mut((n, 2 * n + b), (n, r))
            .copy_from(&segment.right);
        let qr = stacked.qr();
        qr.q_tr_mul(&mut rest);
        let part = |row: usize, column: usize, width: usize| {
            rest.view((row, column), (n, width)).into_owned()
        };
        reduced.removed.push(Removed {
            r: qr.r(),
            a: part(0, 0, n),
            z: part(0, n, n),
            f: part(0, 2 * n, b),
            g: part(0, 2 * n + b, r),
        });
        reduced.a = part(n, 0, n);
        reduced.z = part(n, n, n);
        reduced.f = part(n, 2 * n, b);
        reduced.g = part(n, 2 * n + b, r);
    }
    reduced
}

/// The dense system for the first state and the scalar unknowns.
struct Dense {
    reduced: Reduced,
    matrix: DMatrix<f64>,
    right: DMatrix<f64>,
}

impl Dense {
    /// Removes the other states. `corner` is `E` (`b x b`) and `right` is `e` (`b x r`).
    fn new(
        segments: &[Segment],
        mut corner: DMatrix<f64>,
        mut right: DMatrix<f64>,
    ) -> Option<Self> {
        let (n, b, r) = (segments[0].map.nrows(), corner.nrows(), right.ncols());
        let reduced = reduce(segments);
        // The border rows without the removed states.
        let mut first = segments[0].border.clone();
        let mut border = segments.get(1).map(|segment| segment.border.clone());
        for (k, removed) in reduced.removed.iter().enumerate() {
            let row = border.take()?;
            // X R = B, by the transposed triangle.
            let x = removed
                .r
                .transpose()
                .solve_lower_triangular(&row.transpose())?
                .transpose();
            first -= &x * &removed.a;
            corner -= &x * &removed.f;
            right -= &x * &removed.g;
            let next = -&x * &removed.z;
            match segments.get(k + 2) {
                Some(segment) => border = Some(&segment.border + next),
                None => first += next,
            }
        }
        let mut matrix = DMatrix::zeros(n + b, n + b);
        matrix
            .view_mut((0, 0), (n, n))
            .copy_from(&(&reduced.a + &reduced.z));
        matrix.view_mut((0, n), (n, b)).copy_from(&reduced.f);
        matrix.view_mut((n, 0), (b, n)).copy_from(&first);
        matrix.view_mut((n, n), (b, b)).copy_from(&corner);
        let mut all = DMatrix::zeros(n + b, r);
        all.rows_mut(0, n).copy_from(&reduced.g);
        all.rows_mut(n, b).copy_from(&right);
        Some(Self {
            reduced,
            matrix,
            right: all,
        })
    }

    /// All unknowns from the first state and the scalars, for the right sides or, if `homogeneous`, for zero.
    fn complete(&self, solution: &DMatrix<f64>, homogeneous: bool) -> Option<Solution> {
        let n = self.reduced.a.nrows();
        let b = solution.nrows() - n;
        let scalars = solution.rows(n, b).into_owned();
        let first = solution.rows(0, n).into_owned();
        let mut states = vec![first.clone(); self.reduced.removed.len() + 1];
        let mut next = first.clone();
        for (k, removed) in self.reduced.removed.iter().enumerate().rev() {
            let mut right = -(&removed.a * &first) - &removed.z * &next - &removed.f * &scalars;
            if !homogeneous {
                right += &removed.g;
            }
            next = removed.r.solve_upper_triangular(&right)?;
            states[k + 1] = next.clone();
        }
        Some(Solution { states, scalars })
    }
}

/// Solves the bordered system. `corner` is `E` (`b x b`) and `right` is `e` (`b x r`). `None` if it is singular.
pub fn solve(segments: &[Segment], corner: DMatrix<f64>, right: DMatrix<f64>) -> Option<Solution> {
    let dense = Dense::new(segments, corner, right)?;
    let solution = dense.matrix.clone().full_piv_lu().solve(&dense.right)?;
    if solution.iter().any(|x| !x.is_finite()) {
        return None;
    }
    dense.complete(&solution, false)
}

/// The direction in which the bordered system is closest to singular: the states, and the scalar unknowns.
pub fn singular_direction(segments: &[Segment], corner: DMatrix<f64>) -> Option<Solution> {
    let b = corner.nrows();
    let dense = Dense::new(segments, corner, DMatrix::zeros(b, 0))?;
    let svd = dense.matrix.clone().svd(false, true);
    let least = (0..svd.singular_values.len())
        .min_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]))?;
    let row = svd.v_t?.row(least).transpose();
    let column = DMatrix::from_column_slice(row.len(), 1, row.as_slice());
    dense.complete(&column, true)
}

/// A system of segment maps without other unknowns.
fn homogeneous(maps: &[DMatrix<f64>]) -> Reduced {
    let n = maps[0].nrows();
    let segments: Vec<_> = maps
        .iter()
        .map(|map| Segment {
            map: map.clone(),
            columns: DMatrix::zeros(n, 0),
            right: DMatrix::zeros(n, 0),
            border: DMatrix::zeros(0, n),
        })
        .collect();
    reduce(&segments)
}

/// The eigenvalues of the product of the segment maps: the generalized eigenvalues of `A` and `-Z`. The largest comes first,
/// of a pair that with the positive angle. Those that are lost in rounding errors, below about 1e-15 of the largest or of
/// 1, are zero. `None` if the maps are not finite, or without convergence.
pub fn multipliers(maps: &[DMatrix<f64>]) -> Option<Vec<Multiplier>> {
    if !maps.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let Reduced { a, z, .. } = homogeneous(maps);
    let n = a.nrows();
    let rounding = n as f64 * f64::EPSILON * a.norm().max(z.norm());
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

/// The eigenvector of the product of the segment maps for the eigenvalue that is closest to `multiplier`, which is near the
/// unit circle, carried along the segments: `y_(k+1) = G_k y_k`, `y_N = multiplier y_0`. The first state has norm 1.
pub fn eigenvector(maps: &[DMatrix<f64>], multiplier: Complex<f64>) -> Vec<DVector<Complex<f64>>> {
    let reduced = homogeneous(maps);
    let n = reduced.a.nrows();
    let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
    let svd = (complex(&reduced.a) + complex(&reduced.z) * multiplier).svd(false, true);
    let least = (0..n)
        .min_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]))
        .unwrap_or(0);
    let first: DVector<Complex<f64>> = svd
        .v_t
        .map(|v| v.row(least).adjoint())
        .unwrap_or_else(|| DVector::zeros(n));
    let mut states = vec![first.clone(); maps.len()];
    let mut next = first.clone() * multiplier;
    for (k, removed) in reduced.removed.iter().enumerate().rev() {
        let right = -(complex(&removed.a) * &first + complex(&removed.z) * &next);
        if let Some(state) = complex(&removed.r).solve_upper_triangular(&right) {
            next = state;
        }
        states[k + 1] = next.clone();
    }
    states
}
