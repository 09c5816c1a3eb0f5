//! Time average of the trace of the Jacobian, which equals the sum of all exponents.

use crate::dynamics::{Differentiable, Integrator, System};

/// Average of the trace of `dF/dz` over states at constant time intervals. By Liouville's theorem,
/// phase-space volume grows at this rate.
pub(super) struct MeanTrace {
    record: Vec<f64>,
    force: Vec<f64>,
    vectors: Vec<f64>,
    product: Vec<f64>,
    /// Contribution of the linear part at any state, 1/s.
    linear: f64,
    sum: f64,
    count: u64,
}

impl MeanTrace {
    /// Creates an average for a system; `None` if not all tangent vectors are computed, or if events make
    /// volumes jump.
    pub fn new(sys: &dyn System, width: usize) -> Option<Self> {
        let n = sys.tangent_dim();
        let is_exact = width == n && !sys.jumps();
        let derivative = sys.differentiable().filter(|_| is_exact)?;
        let damped = sys.damping().iter().zip(sys.omega());
        Some(Self {
            record: vec![0.0; derivative.record_len()],
            force: vec![0.0; sys.dim() - sys.modes()],
            vectors: (0..n * n)
                .map(|k| f64::from(u8::from(k % (n + 1) == 0)))
                .collect(),
            product: vec![0.0; (n - sys.modes()) * n],
            linear: damped.map(|(ratio, omega)| -2.0 * ratio * omega).sum(),
            sum: 0.0,
            count: 0,
        })
    }

    /// Adds the trace at a state `z` at time `t` (s) within the last step.
    pub fn add(&mut self, integrator: &Integrator<'_>, t: f64, z: &[f64]) {
        let (sys, status) = (integrator.system(), integrator.status());
        let Some(derivative) = sys.differentiable() else {
            return;
        };
        let n = sys.tangent_dim();
        let status = Some(status).filter(|status| !status.is_empty());
        let (force, record) = (&mut self.force, &mut self.record);
        Differentiable::force_recorded(derivative, status, t, z, force, record);
        derivative.product(status, record, &self.vectors, n, &mut self.product);
        let rows = self.product.chunks_exact(n).enumerate();
        let trace: f64 = rows.map(|(row, product)| product[sys.modes() + row]).sum();
        self.sum += trace + self.linear;
        self.count += 1;
    }

    /// The average so far, 1/s.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}
