//! Hand-written kernels for the derivative and the contact status, one for each setting.

use pulp::{Simd, WithSimd};

use crate::joint::MAX_MODES;
use crate::joint::contact_force::PAPER_MODES;
use crate::joint::node_slopes::KEPT;
use crate::joint::nodes::{Nodes, Rows};
use crate::joint::simd::{LANES, Vector, parts};

/// Arguments of a matrix-free product.
pub(super) struct Sweep<'a> {
    pub nodes: &'a Nodes,
    pub kept: &'a [[f64; LANES]],
    /// Adjacent tangent vectors, `2m x width`; the first three are used.
    pub vectors: &'a [f64],
    pub width: usize,
    /// `m x 3`.
    pub out: &'a mut [f64],
}

/// The change of the force with three tangent vectors: without friction, with tangential friction, with friction in
/// all components.
pub(super) struct SweptSpring<'a>(pub Sweep<'a>);
pub(super) struct SweptTangential<'a>(pub Sweep<'a>);
pub(super) struct SweptWhole<'a>(pub Sweep<'a>);

/// Writes the sums, three per mode.
#[inline(always)]
fn finish<S: Simd>(sums: &[[Vector<S>; 3]; PAPER_MODES], out: &mut [f64]) {
    for (out, sums) in out.chunks_exact_mut(3).zip(sums) {
        out[0] = -sums[0].sum();
        out[1] = -sums[1].sum();
        out[2] = -sums[2].sum();
    }
}

impl WithSimd for SweptSpring<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Sweep {
            nodes,
            kept,
            vectors,
            width,
            out,
        } = self.0;
        let zero = Vector::splat(simd, 0.0);
        let mut sums = [[zero; 3]; PAPER_MODES];
        let dq = &vectors[..width * PAPER_MODES];
        for (block, (_, rows)) in nodes.iter().enumerate() {
            let rows = &rows[..PAPER_MODES];
            for part in 0..parts::<S>() {
                let mut u_r = [zero; 3];
                for (i, row) in rows.iter().enumerate() {
                    let q = &dq[i * width..][..3];
                    let r = row.r.part(simd, part);
                    for l in 0..3 {
                        u_r[l] = r.mul_add(Vector::splat(simd, q[l]), u_r[l]);
                    }
                }
                let stiffness = Vector::load(simd, &kept[block * KEPT], part);
                let normal = [stiffness * u_r[0], stiffness * u_r[1], stiffness * u_r[2]];
                for (sums, row) in sums.iter_mut().zip(rows) {
                    let r = row.r.part(simd, part);
                    for l in 0..3 {
                        sums[l] = r.mul_add(normal[l], sums[l]);
                    }
                }
            }
        }
        finish(&sums, out);
    }
}

impl WithSimd for SweptTangential<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Sweep {
            nodes,
            kept,
            vectors,
            width,
            out,
        } = self.0;
        let zero = Vector::splat(simd, 0.0);
        let mut sums = [[zero; 3]; PAPER_MODES];
        let (dq, dv) = vectors.split_at(width * PAPER_MODES);
        for (block, (_, rows)) in nodes.iter().enumerate() {
            let rows = &rows[..PAPER_MODES];
            for part in 0..parts::<S>() {
                let (mut u_r, mut along, mut across) = ([zero; 3], [zero; 3], [zero; 3]);
                for (i, row) in rows.iter().enumerate() {
                    let (q, v) = (&dq[i * width..][..3], &dv[i * width..][..3]);
                    let [s, t, r] = row.part(simd, part);
                    for l in 0..3 {
                        u_r[l] = r.mul_add(Vector::splat(simd, q[l]), u_r[l]);
                        let v = Vector::splat(simd, v[l]);
                        along[l] = s.mul_add(v, along[l]);
                        across[l] = t.mul_add(v, across[l]);
                    }
                }
                let kept = &kept[block * KEPT..][..KEPT];
                let number = |k: usize| Vector::load(simd, &kept[k], part);
                let (stiffness, coefficient) = (number(0), number(1));
                let (drag, bend) = (number(2), number(3));
                let (h_s, h_t) = (number(4), number(5));
                let mut normal = [zero; 3];
                for l in 0..3 {
                    normal[l] = stiffness * u_r[l];
                    let turned = h_t.mul_add(across[l], h_s * along[l]);
                    let pull = coefficient.mul_add(normal[l], bend * turned);
                    along[l] = drag.mul_add(along[l], pull * h_s);
                    across[l] = drag.mul_add(across[l], pull * h_t);
                }
                for (sums, row) in sums.iter_mut().zip(rows) {
                    let [s, t, r] = row.part(simd, part);
                    for l in 0..3 {
                        let tangential = t.mul_add(across[l], s.mul_add(along[l], sums[l]));
                        sums[l] = r.mul_add(normal[l], tangential);
                    }
                }
            }
        }
        finish(&sums, out);
    }
}

impl WithSimd for SweptWhole<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Sweep {
            nodes,
            kept,
            vectors,
            width,
            out,
        } = self.0;
        let zero = Vector::splat(simd, 0.0);
        let mut sums = [[zero; 3]; PAPER_MODES];
        let (dq, dv) = vectors.split_at(width * PAPER_MODES);
        for (block, (_, rows)) in nodes.iter().enumerate() {
            let rows = &rows[..PAPER_MODES];
            for part in 0..parts::<S>() {
                let (mut u_r, mut outward) = ([zero; 3], [zero; 3]);
                let (mut along, mut across) = ([zero; 3], [zero; 3]);
                for (i, row) in rows.iter().enumerate() {
                    let (q, v) = (&dq[i * width..][..3], &dv[i * width..][..3]);
                    let [s, t, r] = row.part(simd, part);
                    for l in 0..3 {
                        u_r[l] = r.mul_add(Vector::splat(simd, q[l]), u_r[l]);
                        let v = Vector::splat(simd, v[l]);
                        along[l] = s.mul_add(v, along[l]);
                        across[l] = t.mul_add(v, across[l]);
                        outward[l] = r.mul_add(v, outward[l]);
                    }
                }
                let kept = &kept[block * KEPT..][..KEPT];
                let number = |k: usize| Vector::load(simd, &kept[k], part);
                let (stiffness, coefficient) = (number(0), number(1));
                let (drag, bend) = (number(2), number(3));
                let (h_s, h_t, h_r) = (number(4), number(5), number(6));
                for l in 0..3 {
                    let normal = stiffness * u_r[l];
                    let turned = h_t.mul_add(across[l], h_s * along[l]);
                    let turned = h_r.mul_add(outward[l], turned);
                    let pull = coefficient.mul_add(normal, bend * turned);
                    along[l] = drag.mul_add(along[l], pull * h_s);
                    across[l] = drag.mul_add(across[l], pull * h_t);
                    outward[l] = drag.mul_add(outward[l], pull.mul_add(h_r, normal));
                }
                for (sums, row) in sums.iter_mut().zip(rows) {
                    let [s, t, r] = row.part(simd, part);
                    for l in 0..3 {
                        let tangential = t.mul_add(across[l], s.mul_add(along[l], sums[l]));
                        sums[l] = r.mul_add(outward[l], tangential);
                    }
                }
            }
        }
        finish(&sums, out);
    }
}

/// Arguments of an assembly.
pub(super) struct Matrix<'a> {
    pub nodes: &'a Nodes,
    pub kept: &'a [[f64; LANES]],
    /// Scratch, `2 m^2`.
    pub sums: &'a mut [[f64; LANES]],
    /// `m x 2m`, row-major.
    pub matrix: &'a mut [f64],
}

/// Number of rows and columns of a tile whose sums are held in registers.
const TILE: usize = 4;

/// Defines a function that adds the listed products of row weights (by index) and column components to a tile.
macro_rules! tile {
    ($name:ident, $w:literal: $($weight:literal * $component:ident)*) => {
        #[inline(always)]
        fn $name<S: Simd, const I: usize, const J: usize>(
            simd: S,
            nodes: &Nodes,
            units: std::ops::Range<usize>,
            weights: &[[Vector<S>; $w]],
            [i, j]: [usize; 2],
            sums: &mut [[f64; LANES]],
        ) {
            let m = nodes.modes;
            let mut tile: [[Vector<S>; J]; I] = std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    Vector::load(simd, &sums[(i + row) * m + j + column], 0)
                })
            });
            for (unit, weights) in units.zip(weights.chunks_exact(m)) {
                let (block, part) = (unit / parts::<S>(), unit % parts::<S>());
                let rows: &[Rows; J] = nodes.rows[block * m + j..].first_chunk().unwrap();
                let weights: &[[Vector<S>; $w]; I] = weights[i..].first_chunk().unwrap();
                $(
                    let columns: [Vector<S>; J] =
                        std::array::from_fn(|j| rows[j].$component.part(simd, part));
                    for i in 0..I {
                        for j in 0..J {
                            tile[i][j] = weights[i][$weight].mul_add(columns[j], tile[i][j]);
                        }
                    }
                )*
            }
            for (row, tile) in tile.iter().enumerate() {
                for (column, sum) in tile.iter().enumerate() {
                    sum.store(&mut sums[(i + row) * m + j + column], 0);
                }
            }
        }
    };
}
tile!(normal, 1: 0 * r);
tile!(tangential_by_q, 3: 2 * r);
tile!(tangential_by_v, 3: 0 * s 1 * t);
tile!(whole_by_q, 4: 3 * r);
tile!(whole_by_v, 4: 0 * s 1 * t 2 * r);

/// Calls the function of a tile with its size.
macro_rules! sized {
    ($tile:ident, $m:ident, $i:ident, $j:ident, ($($argument:expr),*)) => {
        sized!(@ $tile, (TILE.min($m - $i), TILE.min($m - $j)), ($($argument),*),
            1 1, 1 2, 1 3, 1 4, 2 1, 2 2, 2 3, 2 4, 3 1, 3 2, 3 3, 3 4, 4 1, 4 2, 4 3, 4 4)
    };
    (@ $tile:ident, $size:expr, $arguments:tt, $($rows:literal $columns:literal),*) => {
        match $size {
            $(($rows, $columns) => sized!(@@ $tile, $rows, $columns, $arguments),)*
            _ => unreachable!("a tile has no more rows and columns than four"),
        }
    };
    (@@ $tile:ident, $rows:literal, $columns:literal, ($($argument:expr),*)) => {
        $tile::<S, $rows, $columns>($($argument),*)
    };
}

/// Sum over the lanes.
#[inline(always)]
fn total<S: Simd>(simd: S, lanes: &[f64; LANES]) -> f64 {
    Vector::load(simd, lanes, 0).sum()
}

/// The Jacobian of the force in the same three settings. Without friction it contains only the derivative with
/// respect to `q`, which is symmetric.
pub(super) struct AssembledSpring<'a>(pub Matrix<'a>);
pub(super) struct AssembledTangential<'a>(pub Matrix<'a>);
pub(super) struct AssembledWhole<'a>(pub Matrix<'a>);

impl WithSimd for AssembledSpring<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Matrix {
            nodes,
            kept,
            sums,
            matrix,
        } = self.0;
        let m = nodes.modes;
        let sums = &mut sums[..m * m];
        let mut weights = [[Vector::splat(simd, 0.0); 1]; MAX_MODES];
        let count = nodes.blocks.len() * parts::<S>();
        let capacity = MAX_MODES / m;
        sums.fill([0.0; LANES]);
        for first in (0..count).step_by(capacity) {
            let units = first..count.min(first + capacity);
            let weights = &mut weights[..units.len() * m];
            for (unit, weights) in units.clone().zip(weights.chunks_exact_mut(m)) {
                let (block, part) = (unit / parts::<S>(), unit % parts::<S>());
                let stiffness = Vector::load(simd, &kept[block * KEPT], part);
                for (weights, row) in weights.iter_mut().zip(&nodes.rows[block * m..][..m]) {
                    *weights = [stiffness * row.r.part(simd, part)];
                }
            }
            for i in (0..m).step_by(TILE) {
                for j in (0..=i).step_by(TILE) {
                    sized!(
                        normal,
                        m,
                        i,
                        j,
                        (simd, nodes, units.clone(), weights, [i, j], sums)
                    );
                }
            }
        }
        for i in 0..m {
            for j in 0..=i {
                let by_q = -total(simd, &sums[i * m + j]);
                matrix[i * 2 * m + j] = by_q;
                matrix[j * 2 * m + i] = by_q;
                matrix[i * 2 * m + m + j] = 0.0;
                matrix[j * 2 * m + m + i] = 0.0;
            }
        }
    }
}

/// Defines an assembly with friction: the weights of its rows, and its tiles.
macro_rules! assembled {
    (
        $name:ident, $w:literal, $by_q:ident, $by_v:ident,
        |[$($row:ident),* $(,)?], [$($kept:ident),* $(,)?]| $compute_weights:expr
    ) => {
        impl WithSimd for $name<'_> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                let Matrix { nodes, kept, sums, matrix } = self.0;
                let m = nodes.modes;
                let mut weights = [[Vector::splat(simd, 0.0); $w]; MAX_MODES];
                let count = nodes.blocks.len() * parts::<S>();
                let capacity = MAX_MODES / m;
                sums.fill([0.0; LANES]);
                let (by_q, by_v) = sums.split_at_mut(m * m);
                for first in (0..count).step_by(capacity) {
                    let units = first..count.min(first + capacity);
                    let weights = &mut weights[..units.len() * m];
                    for (unit, weights) in units.clone().zip(weights.chunks_exact_mut(m)) {
                        let (block, part) = (unit / parts::<S>(), unit % parts::<S>());
                        let mut kept = kept[block * KEPT..][..KEPT].iter();
                        $(let $kept = Vector::load(simd, kept.next().unwrap(), part);)*
                        for (weights, row) in weights.iter_mut().zip(&nodes.rows[block * m..][..m])
                        {
                            let [$($row),*] = row.part(simd, part);
                            *weights = $compute_weights;
                        }
                    }
                    for i in (0..m).step_by(TILE) {
                        for j in (0..m).step_by(TILE) {
                            sized!($by_q, m, i, j, (simd, nodes, units.clone(), weights, [i, j], by_q));
                            if j <= i {
                                sized!($by_v, m, i, j, (simd, nodes, units.clone(), weights, [i, j], by_v));
                            }
                        }
                    }
                }
                for i in 0..m {
                    for j in 0..=i {
                        matrix[i * 2 * m + j] = -total(simd, &by_q[i * m + j]);
                        matrix[j * 2 * m + i] = -total(simd, &by_q[j * m + i]);
                        let by_v = -total(simd, &by_v[i * m + j]);
                        matrix[i * 2 * m + m + j] = by_v;
                        matrix[j * 2 * m + m + i] = by_v;
                    }
                }
            }
        }
    };
}

assembled!(
    AssembledTangential,
    3,
    tangential_by_q,
    tangential_by_v,
    |[s, t, r], [stiffness, coefficient, drag, bend, h_s, h_t]| {
        let turned = h_t.mul_add(t, h_s * s);
        let bend = bend * turned;
        [
            drag.mul_add(s, bend * h_s),
            drag.mul_add(t, bend * h_t),
            stiffness * coefficient.mul_add(turned, r),
        ]
    }
);

assembled!(AssembledWhole, 4, whole_by_q, whole_by_v, |[s, t, r],
                                                       [
    stiffness,
    coefficient,
    drag,
    bend,
    h_s,
    h_t,
    h_r,
]| {
    let turned = h_r.mul_add(r, h_t.mul_add(t, h_s * s));
    let bend = bend * turned;
    [
        drag.mul_add(s, bend * h_s),
        drag.mul_add(t, bend * h_t),
        drag.mul_add(r, bend * h_r),
        stiffness * coefficient.mul_add(turned, r),
    ]
});

/// The contact status, one bit per node.
pub(super) struct Status<'a> {
    pub nodes: &'a Nodes,
    pub q: &'a [f64],
    pub status: &'a mut [u8],
}

impl WithSimd for Status<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for ((block, rows), bits) in self.nodes.iter().zip(self.status) {
            *bits = 0;
            for part in 0..parts::<S>() {
                let mut u_r = Vector::splat(simd, 0.0);
                for (row, &q) in rows.iter().zip(self.q) {
                    u_r = row.r.part(simd, part).mul_add(Vector::splat(simd, q), u_r);
                }
                let stiffness = block.stiffness.part(simd, part);
                let gap = stiffness.mul_add(u_r, block.pre_stress.part(simd, part));
                *bits |= gap.negative_bits() << (part * S::F64_LANES);
            }
        }
    }
}
