//! Any number of unilateral springs, with guards.

use std::sync::atomic::{AtomicU64, Ordering};

use squeakscope_dynamics::{Differentiable, Switching, System};

/// Oscillators preloaded against unilateral springs, `N_n = max(0, p_n + k phi_n . q)`; `q` is the
/// displacement from equilibrium.
pub struct Springs {
    pub omega: Vec<f64>,
    /// Shapes `phi_n`, spring by spring.
    pub shapes: Vec<f64>,
    pub press: Vec<f64>,
    pub stiffness: f64,
    /// Number of force evaluations, with and without a frozen status.
    pub calls: AtomicU64,
}

impl Springs {
    pub fn new(omega: &[f64], shapes: &[f64], press: &[f64], stiffness: f64) -> Self {
        assert_eq!(shapes.len(), omega.len() * press.len());
        Self {
            omega: omega.to_vec(),
            shapes: shapes.to_vec(),
            press: press.to_vec(),
            stiffness,
            calls: AtomicU64::new(0),
        }
    }

    /// Normal force of a spring if positive.
    fn gap(&self, n: usize, z: &[f64]) -> f64 {
        let m = self.omega.len();
        let shape = &self.shapes[n * m..][..m];
        self.press[n] + self.stiffness * shape.iter().zip(z).map(|(a, b)| a * b).sum::<f64>()
    }

    fn add_spring(&self, n: usize, normal: f64, out: &mut [f64]) {
        let m = self.omega.len();
        for (out, shape) in out.iter_mut().zip(&self.shapes[n * m..][..m]) {
            *out -= shape * (normal - self.press[n]);
        }
    }
}

impl System for Springs {
    fn omega(&self) -> &[f64] {
        &self.omega
    }
    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        out.fill(0.0);
        for n in 0..self.press.len() {
            self.add_spring(n, self.gap(n, z).max(0.0), out);
        }
    }
    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for Springs {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let m = self.omega.len();
        for (n, shape) in self.shapes.chunks_exact(m).enumerate() {
            let in_contact = match status {
                Some(status) => status[n] == 1,
                None => self.gap(n, &record[1..]) > 0.0,
            };
            for l in (0..width).filter(|_| in_contact) {
                let moved: f64 = (0..m).map(|i| shape[i] * vectors[i * width + l]).sum();
                for i in 0..m {
                    out[i * width + l] -= self.stiffness * shape[i] * moved;
                }
            }
        }
    }
}

impl Switching for Springs {
    fn status_len(&self) -> usize {
        self.press.len()
    }
    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        for (n, status) in status.iter_mut().enumerate() {
            *status = u8::from(self.gap(n, z) > 0.0);
        }
    }
    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        out.fill(0.0);
        for (n, in_contact) in status.iter().enumerate() {
            let normal = if *in_contact == 1 {
                self.gap(n, z)
            } else {
                0.0
            };
            self.add_spring(n, normal, out);
        }
    }
    fn guards(&self) -> usize {
        self.press.len()
    }
    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        for (n, value) in values.iter_mut().enumerate() {
            let gap = self.gap(n, z);
            *value = if status[n] == 1 { gap } else { -gap };
        }
    }
    fn cross(&self, guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        status[guard] ^= 1;
    }
    fn is_continuous(&self) -> bool {
        true
    }
    fn guard_gradient(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        _gradient: &mut [f64],
    ) -> f64 {
        unreachable!("these tests propagate no tangent vectors")
    }
}
