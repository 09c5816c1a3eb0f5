//! The linear systems of an implicit step: `(s - J) x = r`.
//!
//! Because `q' = v`, the equations of the displacements are eliminated analytically, `x_q = (r_q + x_v)
//! / s`. The remaining system has one equation per mode and first-order component, half the size of the
//! state. It is solved by its LU factors.

use std::mem::MaybeUninit;

use faer::dyn_stack::MemStack;
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::lu::partial_pivoting::solve::{solve_in_place, solve_in_place_scratch};
use faer::perm::PermRef;
use faer::{Mat, MatMut, Par};

use crate::System;
use crate::stepper::Law;

/// The Jacobian at a state and the LU factors of the reduced `s - J`.
#[derive(Clone, Debug)]
pub(super) struct Resolvent {
    modes: usize,
    /// Size of the reduced matrix: modes and first-order components without quadratures.
    rows: usize,
    /// `d[f | g]/dz`, `rows x (modes + rows)`, row-major.
    force: Vec<f64>,
    /// `omega_i^2`, 1/s^2, and `2 zeta_i omega_i`, 1/s: the linear part.
    linear: Vec<[f64; 2]>,
    identity: Vec<f64>,
    /// `s`, 1/s.
    shift: f64,
    /// LU factors, `rows x rows`; the unit diagonal of the lower factor is not stored.
    factors: Mat<f64>,
    /// Permutation of the rows by the pivots, and its inverse.
    order: [Vec<usize>; 2],
    scratch: Vec<MaybeUninit<u8>>,
    /// Power-iteration estimate of the dominant eigenvector of the derivative of the force.
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl Resolvent {
    pub fn new(sys: &dyn System) -> Self {
        let (modes, n) = (sys.modes(), sys.tangent_dim());
        let rows = n - modes;
        let mut identity = vec![0.0; n * n];
        identity.iter_mut().step_by(n + 1).for_each(|x| *x = 1.0);
        // At most as many right-hand sides as there are tangent vectors.
        let scratch = lu_in_place_scratch::<usize, f64>(rows, rows, Par::Seq, Default::default())
            .or(solve_in_place_scratch::<usize, f64>(rows, n, Par::Seq));
        let mut resolvent = Self {
            modes,
            rows,
            force: vec![0.0; rows * n],
            linear: vec![[0.0; 2]; modes],
            identity,
            shift: 1.0,
            factors: Mat::zeros(rows, rows),
            order: [vec![0; rows], vec![0; rows]],
            scratch: vec![MaybeUninit::uninit(); scratch.unaligned_bytes_required()],
            // Any direction that is not orthogonal to the dominant eigenvector.
            direction: (0..rows).map(|i| 1.0 / (1.0 + i as f64)).collect(),
            image: vec![0.0; rows],
        };
        // The library allocates its buffers in the first factorisation of a thread.
        resolvent.factor(1.0);
        resolvent.solve(&mut vec![0.0; n], 1);
        resolvent
    }

    /// Computes the Jacobian from a record.
    pub fn update_jacobian(&mut self, law: Law<'_>, record: &mut [f64]) {
        let n = self.modes + self.rows;
        law.product(record, &self.identity, n, &mut self.force);
        let sys = law.sys;
        for (i, linear) in self.linear.iter_mut().enumerate() {
            let omega = sys.omega()[i];
            let ratio = sys.damping().get(i).copied().unwrap_or(0.0);
            *linear = [omega * omega, 2.0 * ratio * omega];
        }
    }

    /// Factorises `s - J`. If it is singular, the solutions are not finite.
    pub fn factor(&mut self, shift: f64) {
        self.shift = shift;
        let (m, rows) = (self.modes, self.rows);
        for (i, force) in self.force.chunks_exact(m + rows).enumerate() {
            let (by_q, by_v) = force.split_at(m);
            for (out, force) in self.factors.row_mut(i).iter_mut().zip(by_v) {
                *out = -force;
            }
            for (out, force) in self.factors.row_mut(i).iter_mut().zip(by_q) {
                *out -= force / shift;
            }
            self.factors[(i, i)] += shift;
            if let Some([stiffness, decay]) = self.linear.get(i) {
                self.factors[(i, i)] += decay + stiffness / shift;
            }
        }
        let [order, inverse] = &mut self.order;
        lu_in_place(
            self.factors.as_mut(),
            order,
            inverse,
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
    }

    /// Replaces `width` right-hand sides, stored component by component, by the solutions.
    pub fn solve(&mut self, x: &mut [f64], width: usize) {
        let (m, rows, shift) = (self.modes, self.rows, self.shift);
        let (q, rest) = x.split_at_mut(m * width);
        for (i, force) in self.force.chunks_exact(m + rows).enumerate() {
            let out = &mut rest[i * width..][..width];
            for (j, force) in force[..m].iter().enumerate() {
                add(out, force / shift, &q[j * width..][..width]);
            }
            if let Some([stiffness, _]) = self.linear.get(i) {
                add(out, -stiffness / shift, &q[i * width..][..width]);
            }
        }
        let [order, inverse] = &self.order;
        solve_in_place(
            self.factors.as_ref(),
            self.factors.as_ref(),
            PermRef::new_checked(order, inverse, rows),
            MatMut::from_row_major_slice_mut(rest, rows, width),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        for (q, v) in q.iter_mut().zip(&*rest) {
            *q = (*q + v) / shift;
        }
    }

    /// Estimate of the fastest rate (1/s) at which the force drives velocities and first-order
    /// components: two power iterations, continued from the previous estimate.
    pub fn fastest_rate(&mut self) -> f64 {
        let (m, rows) = (self.modes, self.rows);
        let mut rate = 0.0;
        for _ in 0..2 {
            let lines = self.force.chunks_exact(m + rows);
            for (out, force) in self.image.iter_mut().zip(lines) {
                let terms = force[m..].iter().zip(&self.direction);
                *out = terms.map(|(a, b)| a * b).sum();
            }
            let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let (before, after) = (length(&self.direction), length(&self.image));
            rate = after / before;
            if after > 0.0 && after.is_finite() {
                // A fraction of the old direction ensures that it never becomes orthogonal to a new
                // dominant one.
                for (x, y) in self.direction.iter_mut().zip(&self.image) {
                    *x = 0.03 * *x / before + y / after;
                }
            }
        }
        rate
    }
}

/// Adds `factor` times `other` to `line`.
fn add(line: &mut [f64], factor: f64, other: &[f64]) {
    for (x, y) in line.iter_mut().zip(other) {
        *x += factor * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Differentiable;

    /// Two damped modes and a first-order component with a linear force.
    struct Coupled;

    const LAW: Law<'_> = Law {
        sys: &Coupled,
        status: None,
    };

    const FORCE: [[f64; 5]; 3] = [
        [0.3, -1.0, 0.0, 2.0, 0.7],
        [0.1, 0.4, -3.0, -0.2, 0.0],
        [1.0, 0.0, 0.5, -0.6, -4.0],
    ];

    impl System for Coupled {
        fn omega(&self) -> &[f64] {
            &[1.5, 4.0]
        }
        fn damping(&self) -> &[f64] {
            &[0.1, 0.0]
        }
        fn first_order(&self) -> usize {
            1
        }
        fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
            self.product(None, &mut [], z, 1, out);
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
        fn is_autonomous(&self) -> bool {
            true
        }
    }

    impl Differentiable for Coupled {
        fn product(
            &self,
            _status: Option<&[u8]>,
            _record: &mut [f64],
            vectors: &[f64],
            width: usize,
            out: &mut [f64],
        ) {
            for (i, row) in FORCE.iter().enumerate() {
                for l in 0..width {
                    let vector = vectors.iter().skip(l).step_by(width);
                    out[i * width + l] = row.iter().zip(vector).map(|(a, b)| a * b).sum();
                }
            }
        }
    }

    #[test]
    fn solutions_satisfy_the_full_system() {
        let mut resolvent = Resolvent::new(&Coupled);
        resolvent.update_jacobian(LAW, &mut [0.0; 6]);
        // The second shift makes the reduced matrix need row exchanges.
        for shift in [20.0, 0.05, -3.0] {
            resolvent.factor(shift);
            let right: Vec<f64> = (0..10).map(|k| f64::from(k * k % 7) - 2.5).collect();
            let mut x = right.clone();
            resolvent.solve(&mut x, 2);
            for l in 0..2 {
                let z: Vec<f64> = x.iter().skip(l).step_by(2).copied().collect();
                let mut slope = [0.0; 5];
                Coupled.rhs(0.0, &z, &mut slope);
                for c in 0..5 {
                    let left = shift * z[c] - slope[c];
                    assert!((left - right[2 * c + l]).abs() < 1e-12, "{shift}: {left}");
                }
            }
        }
    }

    #[test]
    fn power_iteration_finds_the_fastest_rate() {
        let mut resolvent = Resolvent::new(&Coupled);
        resolvent.update_jacobian(LAW, &mut [0.0; 6]);
        let rates: Vec<f64> = (0..30).map(|_| resolvent.fastest_rate()).collect();
        // Spectral radius of the block of the velocities and the first-order component.
        assert!((rates[29] - 4.07).abs() < 0.1, "{rates:?}");
    }
}
