//! Eq. (15) and (16): how tangent vectors pass an event.

use crate::dynamics::system::add_linear;
use crate::dynamics::{Switching, System};

/// Workspace of the correction at an event.
///
/// Guards of one event are crossed one after another. Those that fell through zero have delays of
/// their own; a guard that is found negative only because another one has been crossed is passed in
/// the same instant by the neighbours, too, with the delays of that other one.
///
/// Where a guard does not fall at all under the law before (it was touched within rounding), the
/// flow has no derivative: neighbours on one side meet the guard, those on the other pass by. The
/// vectors are then left as they are, as for those that pass by. Such an instant has probability
/// zero in a motion, and adds nothing to an exponent; nearly grazing ones are frequent, stretch the
/// vectors as `1 / fall`, and are taken as they are.
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct Saltation {
    before: Vec<f64>,
    slope_before: Vec<f64>,
    slope_after: Vec<f64>,
    gradient: Vec<f64>,
    status: Vec<u8>,
    /// Guards of the event that fell through zero and are yet to be crossed.
    falling: Vec<usize>,
    /// How much later each neighbour meets the guard, s.
    delays: Vec<f64>,
    /// How the guard changes in time, `dh/dz . F + dh/dt`, before it is crossed, 1/s.
    fall: f64,
}

/// A guard that falls through zero at a time, s.
#[derive(Clone, Copy)]
pub struct Crossing<'a> {
    /// The system of the guard.
    pub switching: &'a dyn Switching,
    pub guard: usize,
    pub t: f64,
}

impl Saltation {
    /// For so many vectors, `width`.
    pub fn new<Y: System + ?Sized>(sys: &Y, width: usize) -> Self {
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
            fall: 0.0,
        }
    }

    /// Takes note of the guards that fell through zero at an event.
    pub fn begin(&mut self, falling: &[usize]) {
        self.falling.clear();
        self.falling.extend_from_slice(falling);
        self.delays.fill(0.0);
    }

    /// Takes note of what the correction needs from before a guard is crossed.
    pub fn before<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
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
        self.fall = rate + falls.map(|(h, f)| h * f).sum::<f64>();
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
            if self.fall >= 0.0 {
                return;
            }
            for (gradient, row) in self.gradient[..n].iter().zip(vectors.chunks_exact(width)) {
                for (delay, x) in self.delays.iter_mut().zip(row) {
                    *delay -= gradient * x / self.fall;
                }
            }
        }
        rhs_in(sys, switching, status, t, z, &mut self.slope_after);
        let before = (&self.status, &self.before);
        switching.reset_tangents(before.0, guard, t, before.1, (vectors, width));
        let jump = &mut self.slope_before;
        switching.reset_tangents(before.0, guard, t, before.1, (&mut jump[..n], 1));
        switching.add_reset_rate(before.0, guard, t, before.1, jump);
        for (c, row) in vectors.chunks_exact_mut(width).enumerate() {
            let jump = jump[c] - self.slope_after[c];
            for (x, delay) in row.iter_mut().zip(&self.delays) {
                *x += jump * delay;
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
