//! Eq. (15) and (16): how tangent vectors pass an event.

use crate::dynamics::system::add_linear;
use crate::dynamics::{Switching, System};

/// Workspace of the correction at an event.
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct Saltation {
    before: Vec<f64>,
    slope_before: Vec<f64>,
    slope_after: Vec<f64>,
    gradient: Vec<f64>,
    status: Vec<u8>,
    /// `h_z . F + h_t` at the event, before it.
    fall: f64,
    rate: f64,
}

impl Saltation {
    pub fn new(dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            before: zeros.clone(),
            slope_before: zeros.clone(),
            slope_after: zeros.clone(),
            gradient: zeros,
            status: Vec::new(),
            fall: 0.0,
            rate: 0.0,
        }
    }

    /// Takes note of what the correction needs from before a guard is crossed.
    pub fn before<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        switching: &dyn Switching,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
    ) {
        self.before.copy_from_slice(z);
        self.status.clear();
        self.status.extend_from_slice(status);
        rhs_in(sys, switching, status, t, z, &mut self.slope_before);
        self.rate = switching.guard_gradient(status, guard, t, z, &mut self.gradient);
        let falls = self.gradient.iter().zip(&self.slope_before);
        self.fall = self.rate + falls.map(|(h, f)| h * f).sum::<f64>();
    }

    /// Eq. (15): the neighbour meets the guard later by
    /// `delta t = -(dh/dz . delta z) / (dh/dz . F_before + dh/dt)`.
    ///
    /// Eq. (16): past it, `delta z+ = dg/dz . delta z- + (dg/dz . F_before + dg/dt - F_after) delta t`.
    ///
    /// `status` and `z` are those after the crossing; `vectors` are `width` side by side.
    pub fn after<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        switching: &dyn Switching,
        (status, z): (&[u8], &[f64]),
        guard: usize,
        t: f64,
        (vectors, width): (&mut [f64], usize),
    ) {
        rhs_in(sys, switching, status, t, z, &mut self.slope_after);
        let n = sys.tangent_dim();
        let mut delays = vec![0.0; width];
        for c in 0..n {
            for l in 0..width {
                delays[l] -= self.gradient[c] * vectors[c * width + l] / self.fall;
            }
        }
        let before = (&self.status, &self.before);
        switching.reset_tangents(before.0, guard, t, before.1, vectors, width);
        let jump = &mut self.slope_before;
        switching.reset_tangents(before.0, guard, t, before.1, &mut jump[..n], 1);
        switching.add_reset_rate(before.0, guard, t, before.1, jump);
        for c in 0..n {
            let jump = jump[c] - self.slope_after[c];
            for l in 0..width {
                vectors[c * width + l] += jump * delays[l];
            }
        }
    }
}

/// `dz/dt` with a status held.
fn rhs_in<Y: System + ?Sized>(
    sys: &Y,
    switching: &dyn Switching,
    status: &[u8],
    t: f64,
    z: &[f64],
    dz: &mut [f64],
) {
    switching.force_in(status, t, z, &mut dz[sys.modes()..]);
    add_linear(sys.omega(), sys.damping(), z, dz, 1);
}
