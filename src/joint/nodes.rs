//! The contact nodes as the hot loops want them: blocks of eight, each node in its own sliding
//! frame.
//!
//! The frame of a node is `(e_s, e_t, e_r)`: along the steady sliding velocity, across it, and
//! outwards. The slip velocity is then `V = (V_0 + du_s/dt, du_t/dt, du_r/dt)`.

use pulp::Simd;

use super::Model;
use super::lanes::{Eight, LANES, Vector};
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
    /// One vector of each.
    #[inline(always)]
    pub fn part<S: Simd>(&self, simd: S, part: usize) -> [Vector<S>; 3] {
        [
            self.s.part(simd, part),
            self.t.part(simd, part),
            self.r.part(simd, part),
        ]
    }
}

/// Eight nodes; those past the end of the model have no area and full pre-stress, so that they do
/// nothing and never divide by zero. They slide as the last node does in steady sliding: a law of
/// friction is only asked for speeds that are there, since nothing times what is no number is none.
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
    /// The gap function `p_n + k_c u_r` (Pa) at the nodes of one vector.
    #[inline(always)]
    pub fn gap<S: Simd>(&self, simd: S, rows: &[Rows], part: usize, q: &[f64]) -> Vector<S> {
        let mut u_r = Vector::splat(simd, 0.0);
        for (row, &q) in rows.iter().zip(q) {
            u_r = row.r.part(simd, part).mul_add(Vector::splat(simd, q), u_r);
        }
        let pre_stress = self.pre_stress.part(simd, part);
        self.stiffness.part(simd, part).mul_add(u_r, pre_stress)
    }
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
    /// The same of `Omega x Phi_i`, 1/(sqrt(kg) s); empty where the slip velocity has no such part.
    pub convected: Vec<Rows>,
    /// Sliding frames `[e_s, e_t, e_r]`, one a node.
    pub frames: Vec<[[f64; 3]; 3]>,
}

/// The nodes for a pass: where they are, at hand, so that nothing that the pass writes can make it look
/// again.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub blocks: &'a [Block],
    pub rows: &'a [Rows],
    pub modes: usize,
}

impl Nodes {
    /// All nodes.
    pub fn view(&self) -> View<'_> {
        View {
            blocks: &self.blocks,
            rows: &self.rows,
            modes: self.modes,
        }
    }

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

    /// Each block with the rows of its modes.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (&Block, &[Rows])> {
        self.blocks.iter().zip(self.rows.chunks_exact(self.modes))
    }
}

/// Radial displacement `u_r` (m) of the node in a lane of a block with these rows.
pub(crate) fn radial(rows: &[Rows], lane: usize, q: &[f64]) -> f64 {
    rows.iter().zip(q).map(|(row, q)| row.r.0[lane] * q).sum()
}

/// `[e_s, e_t, e_r]` at a node: `e_s` along the sliding velocity made tangent (it is tangent by
/// itself for a rotation), any tangent where nothing slides.
fn sliding_frame(normal: [f64; 3], velocity: [f64; 3]) -> [[f64; 3]; 3] {
    let tangent = add_scaled(velocity, -dot(velocity, normal), normal);
    let along = unit(tangent).unwrap_or_else(|| any_normal(normal));
    [along, cross(normal, along), normal]
}
