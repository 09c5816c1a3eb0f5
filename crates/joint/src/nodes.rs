//! Contact nodes in the layout of the hot loops: blocks of eight, each node in its sliding frame.
//!
//! The axes `(e_s, e_t, e_r)` of the frame are the steady sliding direction, the tangent normal to it, and
//! the outward normal. The slip velocity is `V = (V_0 + du_s/dt, du_t/dt, du_r/dt)`.

use pulp::Simd;

use super::Model;
use super::simd::{Eight, LANES, Vector};
use super::vector::{add_scaled, any_normal, cross, dot, norm, unit};

/// Eq. (7): the displacement is `u = sum over modes of Phi_i q_i`; these are the rows `Phi_i` of one
/// mode at eight nodes, along `e_s`, `e_t`, `e_r`, 1/sqrt(kg).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    pub s: Eight,
    pub t: Eight,
    pub r: Eight,
}

impl Rows {
    /// Loads one vector of each row.
    #[inline(always)]
    pub fn part<S: Simd>(&self, simd: S, part: usize) -> [Vector<S>; 3] {
        [
            self.s.part(simd, part),
            self.t.part(simd, part),
            self.r.part(simd, part),
        ]
    }
}

/// Eight nodes. Padding nodes beyond the end of the model have zero area and full pre-stress, so that they
/// contribute nothing and cause no division by zero. They slide like the last node, so that a friction law is
/// evaluated at valid speeds only; zero times NaN would be NaN.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Eq. (4): the slip velocity is `V = Omega x x + du/dt`; this is the speed of its steady part,
    /// `V_0 = |Omega x x|` along `e_s`, m/s.
    pub speed: Eight,
    /// Pre-stress `p_n`, Pa.
    pub pre_stress: Eight,
    /// Contact stiffness per area `k_c`, N/m^3.
    pub stiffness: Eight,
    /// Area `Delta A`, m^2.
    pub area: Eight,
    /// Friction force along `e_s` in steady sliding, N.
    pub steady_friction: Eight,
}

impl Block {
    /// Gap function `p_n + k_c u_r` (Pa) at the nodes of one vector.
    #[inline(always)]
    pub fn gap<S: Simd>(&self, simd: S, rows: &[Rows], part: usize, q: &[f64]) -> Vector<S> {
        let u_r = radial_part(simd, rows, part, q);
        let pre_stress = self.pre_stress.part(simd, part);
        self.stiffness.part(simd, part).mul_add(u_r, pre_stress)
    }
}

/// Radial displacement `u_r` (m) at the nodes of one vector for modal coordinates, or `du_r/dt` (m/s) for modal
/// velocities.
#[inline(always)]
pub(crate) fn radial_part<S: Simd>(simd: S, rows: &[Rows], part: usize, q: &[f64]) -> Vector<S> {
    let mut u_r = Vector::splat(simd, 0.0);
    for (row, &q) in rows.iter().zip(q) {
        u_r = row.r.part(simd, part).mul_add(Vector::splat(simd, q), u_r);
    }
    u_r
}

/// All contact nodes of a model.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Number of nodes, without the padding.
    pub count: usize,
    /// Number of modes.
    pub modes: usize,
    pub blocks: Vec<Block>,
    /// `blocks x modes`, row-major.
    pub rows: Vec<Rows>,
    /// Rows of `Omega x Phi_i`, 1/(sqrt(kg) s); empty if the slip velocity excludes this term.
    pub convected: Vec<Rows>,
    /// Sliding frames `[e_s, e_t, e_r]`, one per node.
    pub frames: Vec<[[f64; 3]; 3]>,
}

impl Nodes {
    pub fn new(model: &Model) -> Self {
        let (count, modes) = (model.nodes(), model.modes());
        let frames: Vec<_> = (0..count)
            .map(|k| sliding_frame(model.normals[k], model.sliding_velocity[k]))
            .collect();
        let mut blocks = Vec::new();
        let (mut rows, mut convected) = (Vec::new(), Vec::new());
        for first in (0..count).step_by(LANES) {
            let gather = |value: &dyn Fn(usize) -> f64, padding: f64| {
                Eight(std::array::from_fn(|l| {
                    if first + l < count {
                        value(first + l)
                    } else {
                        padding
                    }
                }))
            };
            let last_speed = norm(model.sliding_velocity[count - 1]);
            blocks.push(Block {
                speed: gather(&|k| norm(model.sliding_velocity[k]), last_speed),
                pre_stress: gather(&|k| model.pre_stress[k], 1.0),
                stiffness: gather(&|k| model.stiffness[k], 0.0),
                area: gather(&|k| model.areas[k], 0.0),
                steady_friction: Eight::ZERO,
            });
            let in_frames = |vector: &dyn Fn(usize) -> [f64; 3]| {
                let along = |axis: usize| gather(&|k| dot(vector(k), frames[k][axis]), 0.0);
                Rows {
                    s: along(0),
                    t: along(1),
                    r: along(2),
                }
            };
            for i in 0..modes {
                rows.push(in_frames(&|k| model.shapes_at(k)[i]));
                if let Some(omega) = model.convection {
                    convected.push(in_frames(&|k| cross(omega, model.shapes_at(k)[i])));
                }
            }
        }
        Self {
            count,
            modes,
            blocks,
            rows,
            convected,
            frames,
        }
    }

    /// The rows of `Omega x Phi_i` of a block; empty if the slip velocity excludes this term.
    #[inline(always)]
    pub fn convected_rows(&self, block: usize) -> &[Rows] {
        if self.convected.is_empty() {
            &[]
        } else {
            &self.convected[block * self.modes..][..self.modes]
        }
    }

    /// Blocks with the rows of their modes.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (&Block, &[Rows])> {
        self.blocks.iter().zip(self.rows.chunks_exact(self.modes))
    }
}

/// Radial displacements `u_r` (m) of the nodes of a block with these rows.
pub(crate) fn radial(rows: &[Rows], q: &[f64]) -> [f64; LANES] {
    let mut sums = [0.0; LANES];
    for (row, q) in rows.iter().zip(q) {
        for (sum, r) in sums.iter_mut().zip(&row.r.0) {
            *sum += r * q;
        }
    }
    sums
}

/// Sliding frame `[e_s, e_t, e_r]` of a node: `e_s` along the tangential part of the sliding velocity (a
/// rotation has no other part), or any tangent for a node at rest.
fn sliding_frame(normal: [f64; 3], velocity: [f64; 3]) -> [[f64; 3]; 3] {
    let tangent = add_scaled(velocity, -dot(velocity, normal), normal);
    let along = unit(tangent).unwrap_or_else(|| any_normal(normal));
    [along, cross(normal, along), normal]
}
