//! Contributions of each node to the generalised force: the equations that the weights of a cubature rule
//! should satisfy.
//!
//! With the contribution `g_ik` of node `k` to equation `i`, scaled to a sum of about one, the error of the
//! weights `w` is `sum over k of g_ik (w_k - 1)`.

use faer::Mat;

use super::nnls::{Problem, dot, norm, subtract};
use crate::dynamics::System;
use crate::joint::{Joint, LANES};

/// Rank at which the compression of the equations stops.
const MAX_RANK: usize = 160;

/// Relative size of the equations that the compression neglects.
const NEGLIGIBLE: f64 = 1e-11;

/// Displacements (relative to static indentation) and velocities (relative to steady sliding) of the
/// difference quotients for the linearised force.
const STEP: f64 = 1e-4;

/// Equations for the weights, one row per equation and one column per node.
#[derive(Clone, Debug)]
pub(super) struct Snapshots {
    nodes: usize,
    rows: Vec<f64>,
}

impl Snapshots {
    pub fn new(nodes: usize) -> Self {
        let rows = Vec::new();
        Self { nodes, rows }
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn count(&self) -> usize {
        self.rows.len() / self.nodes
    }

    /// Adds equations for the generalised force minus that of steady sliding at some states, each relative
    /// to its norm. The squares of the errors are averaged over the states and multiplied by `weight^2`.
    pub fn add_states(&mut self, joint: &Joint, states: &[Vec<f64>], weight: f64) {
        let steady = contributions(joint, &vec![0.0; 2 * joint.modes()]);
        let weight = weight / (states.len() as f64).sqrt();
        for z in states {
            let mut change = contributions(joint, z);
            subtract(&mut change, 1.0, &steady);
            self.add_scaled(&change, weight);
        }
    }

    /// Adds equations for the total area and the total load.
    pub fn add_area_and_load(&mut self, joint: &Joint, weight: f64) {
        let at = |k: usize| (&joint.nodes.blocks[k / LANES], k % LANES);
        let area = |k: usize| at(k).0.area.0[at(k).1];
        let load = |k: usize| area(k) * at(k).0.pre_stress.0[at(k).1];
        self.add_scaled(&(0..self.nodes).map(area).collect::<Vec<_>>(), weight);
        self.add_scaled(&(0..self.nodes).map(load).collect::<Vec<_>>(), weight);
    }

    /// Adds equations for the steady-sliding force relative to its norm.
    pub fn add_steady(&mut self, joint: &Joint, weight: f64) {
        let steady = contributions(joint, &vec![0.0; 2 * joint.modes()]);
        self.add_scaled(&steady, weight);
    }

    /// Adds equations for the linearised force, each of its stiffness and damping matrix relative to its
    /// Frobenius norm.
    pub fn add_linearised(&mut self, joint: &Joint, weight: f64) {
        let m = joint.modes();
        let [displacement, velocity] = amplitudes(joint);
        for (first, size) in [(0, displacement), (m, velocity)] {
            let mut matrix = vec![0.0; m * m * self.nodes];
            for (j, columns) in matrix.chunks_exact_mut(m * self.nodes).enumerate() {
                for sign in [1.0, -1.0] {
                    let mut z = vec![0.0; 2 * m];
                    z[first + j] = sign * STEP * size;
                    subtract(columns, -sign, &contributions(joint, &z));
                }
            }
            self.add_scaled(&matrix, weight);
        }
    }

    /// Adds rows divided by the norm of their sums over the nodes; rows whose sums vanish are left out.
    fn add_scaled(&mut self, rows: &[f64], weight: f64) {
        let sums = rows.chunks_exact(self.nodes).map(|row| row.iter().sum());
        let size = norm(&sums.collect::<Vec<f64>>());
        if size > 0.0 {
            self.rows.extend(rows.iter().map(|x| x * weight / size));
        }
    }

    /// The equations as rows `[g_i | sum over all nodes k of g_ik]` with the columns of the candidate nodes.
    pub fn with_sums(&self, candidates: &[usize]) -> Vec<f64> {
        let rows = self.rows.chunks_exact(self.nodes);
        rows.flat_map(|row| {
            let columns = candidates.iter().map(|&k| row[k]);
            columns.chain([row.iter().sum()])
        })
        .collect()
    }

    /// Errors of weights (one per node, zero for dropped nodes): the norms of the errors of the states, with
    /// `equations` rows per state.
    pub fn errors<'a>(
        &'a self,
        weights: &[f64],
        equations: usize,
    ) -> impl Iterator<Item = f64> + 'a {
        let change: Vec<f64> = weights.iter().map(|w| w - 1.0).collect();
        let states = self.rows.chunks_exact(equations * self.nodes);
        states.map(move |state| {
            let rows = state.chunks_exact(self.nodes);
            norm(&rows.map(|row| dot(row, &change)).collect::<Vec<_>>())
        })
    }

    /// The least-squares problem of the weights of the candidate nodes, compressed to the numerical rank of the
    /// equations by Gram-Schmidt orthogonalisation with row pivoting.
    pub fn problem(&self, candidates: &[usize]) -> Problem {
        let (n, count) = (self.nodes, self.count());
        let mut rest = self.rows.clone();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut largest_first = 0.0;
        while basis.len() < MAX_RANK.min(n).min(count) {
            let sizes = rest.chunks_exact(n).map(|row| dot(row, row));
            let pivot = sizes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((pivot, square)) = pivot else { break };
            let size = square.sqrt();
            if basis.is_empty() {
                largest_first = size;
            }
            if size <= NEGLIGIBLE * largest_first {
                break;
            }
            let mut next = rest[pivot * n..][..n].to_vec();
            for direction in &basis {
                let along = dot(&next, direction);
                subtract(&mut next, along, direction);
            }
            let length = norm(&next);
            next.iter_mut().for_each(|x| *x /= length);
            for row in rest.chunks_exact_mut(n) {
                let along = dot(row, &next);
                subtract(row, along, &next);
            }
            basis.push(next);
        }
        let rank = basis.len();
        let coefficients =
            Mat::from_fn(count, rank, |i, j| dot(&self.rows[i * n..][..n], &basis[j]));
        let qr = coefficients.qr();
        let factor = qr.thin_R();
        let rows = factor.nrows();
        let row = |i: usize, of: &dyn Fn(&[f64]) -> f64| -> f64 {
            (i..rank).map(|j| factor[(i, j)] * of(&basis[j])).sum()
        };
        let columns = candidates
            .iter()
            .flat_map(|&k| (0..rows).map(move |i| (i, k)));
        let columns = columns
            .map(|(i, k)| row(i, &|direction| direction[k]))
            .collect();
        let target = (0..rows).map(|i| row(i, &|direction| direction.iter().sum()));
        Problem::new(columns, target.collect())
    }
}

/// Contributions of the nodes to the generalised force at a state, `m x n` row-major, N/sqrt(kg).
fn contributions(joint: &Joint, z: &[f64]) -> Vec<f64> {
    let (m, n) = (joint.modes(), joint.contact_nodes());
    let (q, v) = z[..2 * m].split_at(m);
    let mut out = vec![0.0; m * n];
    for k in 0..n {
        let action = joint.node_action(k, q, v, &[]);
        let rows = &joint.nodes.rows[k / LANES * m..][..m];
        for (i, row) in rows.iter().enumerate() {
            let [s, t, r] = action.friction;
            let lane = k % LANES;
            out[i * n + k] =
                row.s.0[lane] * s + row.t.0[lane] * t + row.r.0[lane] * (r - action.normal);
        }
    }
    out
}

/// Modal displacement and modal velocity that bring a node, by one mode, to separation and to a velocity as
/// large as that of steady sliding (10 mm/s for a ball at rest): sqrt(kg) m and sqrt(kg) m/s.
pub(super) fn amplitudes(joint: &Joint) -> [f64; 2] {
    let (mut stress, mut slip) = (0.0_f64, 0.0_f64);
    let mut speed = 0.0_f64;
    for (block, rows) in joint.nodes.iter() {
        for lane in 0..LANES {
            if block.area.0[lane] == 0.0 {
                continue;
            }
            speed = speed.max(block.speed.0[lane]);
            let relative = block.stiffness.0[lane] / block.pre_stress.0[lane];
            for row in rows {
                stress = stress.max(relative * row.r.0[lane].abs());
                slip = slip.max(row.s.0[lane].hypot(row.t.0[lane]));
            }
        }
    }
    let speed = if speed > 0.0 { speed } else { 0.01 };
    [1.0 / stress.max(1e-300), speed / slip.max(1e-300)]
}
