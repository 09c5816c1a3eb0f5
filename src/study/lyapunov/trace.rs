//! The mean trace of the derivative, to which all exponents add up.

use crate::dynamics::{Differentiable, System};

/// Averages the trace of `dF/dz` over states evenly spaced in time: by Liouville's theorem the
/// volume of all tangent vectors grows at this rate.
pub(super) struct MeanTrace {
    record: Vec<f64>,
    force: Vec<f64>,
    vectors: Vec<f64>,
    product: Vec<f64>,
    /// What the linear part adds at any state, 1/s.
    linear: f64,
    sum: f64,
    count: u64,
}

impl MeanTrace {
    /// For a system whose vectors all are followed; `None` where that is not so, or where an event
    /// changes volumes by itself.
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize) -> Option<Self> {
        let n = sys.tangent_dim();
        let smooth = sys.switching().is_none_or(|s| s.is_continuous());
        let derivative = sys.differentiable().filter(|_| width == n && smooth)?;
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

    /// Adds the trace at a state `z` at time `t` (s); the status is empty where none is held.
    pub fn add<Y: System + ?Sized>(&mut self, sys: &Y, status: &[u8], t: f64, z: &[f64]) {
        let Some(derivative) = sys.differentiable() else {
            return;
        };
        let n = sys.tangent_dim();
        let status = Some(status).filter(|status| !status.is_empty());
        let Self {
            record,
            force,
            vectors,
            product,
            ..
        } = self;
        Differentiable::force_recorded(derivative, status, t, z, force, record);
        derivative.product(status, record, vectors, n, product);
        let rows = product.chunks_exact(n).enumerate();
        let trace: f64 = rows.map(|(row, product)| product[sys.modes() + row]).sum();
        self.sum += trace + self.linear;
        self.count += 1;
    }

    /// The mean so far, 1/s.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}
