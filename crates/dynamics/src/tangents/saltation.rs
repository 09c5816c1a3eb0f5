//! Eq. (15) and (16): the saltation correction of tangent vectors at an event.

use crate::system::add_linear;
use crate::{Switching, System};

/// Workspace of the saltation correction.
///
/// The guards of one event are crossed one after another. Each guard that falls through zero defines its
/// own delays between the reference and the perturbed crossing. A guard that is negative only because
/// another one was crossed is crossed at the same instant on perturbed trajectories, with the delays of
/// that other guard.
///
/// If a guard does not decrease under the law before the event (grazing within rounding), the flow has
/// no derivative there: trajectories on one side cross the guard, those on the other do not. The vectors
/// are then left unchanged, as for a trajectory that does not cross. Such an instant has probability
/// zero and does not contribute to an exponent. Nearly grazing crossings are frequent, stretch the
/// vectors as `1 / rate` of the guard, and are treated as regular crossings.
#[derive(Clone, Debug)]
pub(crate) struct Saltation {
    before: Vec<f64>,
    slope_before: Vec<f64>,
    slope_after: Vec<f64>,
    gradient: Vec<f64>,
    status: Vec<u8>,
    /// Guards of the event that fell through zero and are not yet crossed.
    falling: Vec<usize>,
    /// Delay of the crossing for each tangent vector, s.
    delays: Vec<f64>,
    /// Rate of the guard along the flow, `dh/dz . F + dh/dt`, before the crossing, 1/s.
    guard_rate: f64,
}

/// A guard that falls through zero.
#[derive(Clone, Copy)]
pub struct Crossing<'a> {
    /// The system to which the guard belongs.
    pub switching: &'a dyn Switching,
    /// Index of the guard.
    pub guard: usize,
    /// Time, s.
    pub t: f64,
}

impl Saltation {
    /// Workspace for `width` vectors.
    pub fn new(sys: &dyn System, width: usize) -> Self {
        let zeros = vec![0.0; sys.dim()];
        let (guards, status) = sys.switching().map_or((0, 0), |switching| {
            (switching.guards(), switching.status_len())
        });
        Self {
            before: zeros.clone(),
            slope_before: zeros.clone(),
            slope_after: zeros.clone(),
            gradient: zeros,
            status: Vec::with_capacity(status),
            falling: Vec::with_capacity(guards),
            delays: vec![0.0; width],
            guard_rate: 0.0,
        }
    }

    /// Stores the guards that fell through zero at an event.
    pub fn begin(&mut self, falling: &[usize]) {
        self.falling.clear();
        self.falling.extend_from_slice(falling);
        self.delays.fill(0.0);
    }

    /// Stores the data before a crossing that the correction needs.
    pub fn before(
        &mut self,
        sys: &dyn System,
        Crossing {
            switching,
            guard,
            t,
        }: Crossing<'_>,
        status: &[u8],
        z: &[f64],
    ) {
        self.before.copy_from_slice(z);
        self.status.clear();
        self.status.extend_from_slice(status);
        rhs_in(sys, switching, status, t, z, &mut self.slope_before);
        self.gradient.fill(0.0);
        let rate = switching.guard_gradient(status, guard, t, z, &mut self.gradient);
        let falls = self.gradient.iter().zip(&self.slope_before);
        self.guard_rate = rate + falls.map(|(h, f)| h * f).sum::<f64>();
    }

    /// Eq. (15): delay of the perturbed crossing, `delta t = -(dh/dz . delta z) / (dh/dz . F_before +
    /// dh/dt)`.
    ///
    /// Eq. (16): after the crossing, `delta z+ = dg/dz . delta z- + (dg/dz . F_before + dg/dt - F_after)
    /// delta t`.
    ///
    /// `status` and `z` are those after the crossing; `vectors` holds `width` vectors, stored component
    /// by component.
    pub fn after(
        &mut self,
        sys: &dyn System,
        Crossing {
            switching,
            guard,
            t,
        }: Crossing<'_>,
        status: &[u8],
        z: &[f64],
        (vectors, width): (&mut [f64], usize),
    ) {
        let n = sys.tangent_dim();
        if let Some(place) = self.falling.iter().position(|&g| g == guard) {
            self.falling.swap_remove(place);
            self.delays.fill(0.0);
            if self.guard_rate >= 0.0 {
                return;
            }
            for (gradient, row) in self.gradient[..n].iter().zip(vectors.chunks_exact(width)) {
                for (delay, x) in self.delays.iter_mut().zip(row) {
                    *delay -= gradient * x / self.guard_rate;
                }
            }
        }
        rhs_in(sys, switching, status, t, z, &mut self.slope_after);
        let before = (&self.status, &self.before);
        switching.reset_tangents(before.0, guard, t, before.1, (vectors, width, 0.0));
        let jump = &mut self.slope_before;
        switching.reset_tangents(before.0, guard, t, before.1, (&mut jump[..n], 1, 1.0));
        for (c, row) in vectors.chunks_exact_mut(width).enumerate() {
            let jump = jump[c] - self.slope_after[c];
            for (x, delay) in row.iter_mut().zip(&self.delays) {
                *x += jump * delay;
            }
        }
    }
}

/// `dz/dt` for a frozen status.
fn rhs_in(
    sys: &dyn System,
    switching: &dyn Switching,
    status: &[u8],
    t: f64,
    z: &[f64],
    dz: &mut [f64],
) {
    switching.force_in(status, t, z, &mut dz[sys.modes()..]);
    add_linear(sys.omega(), sys.damping(), z, dz, 1);
}
