//! Eq. (15) and (16): the saltation correction of tangent vectors at an event.

use super::TangentBlock;
use crate::stepper::Law;
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
    /// Slope before the crossing, changed by the derivative of the reset map.
    slope_before: Vec<f64>,
    slope_after: Vec<f64>,
    gradient: Vec<f64>,
    /// Guards of the event that fell through zero and are not yet crossed.
    falling: Vec<usize>,
    /// Delay of the crossing for each tangent vector, s.
    delays: Vec<f64>,
    /// Whether the guard only touches zero.
    is_grazing: bool,
}

impl Saltation {
    /// Workspace for `width` vectors.
    pub fn new(sys: &dyn System, width: usize) -> Self {
        let zeros = vec![0.0; sys.dim()];
        let guards = sys.switching().map_or(0, Switching::guards);
        Self {
            slope_before: zeros.clone(),
            slope_after: zeros.clone(),
            gradient: zeros,
            falling: Vec::with_capacity(guards),
            delays: vec![0.0; width],
            is_grazing: false,
        }
    }

    /// Stores the guards that fell through zero at an event.
    pub fn begin(&mut self, falling: &[usize]) {
        self.falling.clear();
        self.falling.extend_from_slice(falling);
        self.delays.fill(0.0);
    }

    /// Before the crossing of a guard at time `t` (s), in the given status and state.
    ///
    /// Eq. (15): delay of the perturbed crossing, `delta t = -(dh/dz . delta z) / (dh/dz . F_before +
    /// dh/dt)`, of the vectors at the end of the step, and the derivative of the reset map.
    pub fn before(
        &mut self,
        switching: &dyn Switching,
        (guard, t): (usize, f64),
        (status, z): (&[u8], &[f64]),
        block: &mut TangentBlock,
    ) {
        let (vectors, width) = (block.end.as_mut_slice(), block.width);
        let n = vectors.len() / width;
        rhs_in(switching, status, t, z, &mut self.slope_before);
        self.is_grazing = false;
        if let Some(place) = self.falling.iter().position(|&g| g == guard) {
            self.falling.swap_remove(place);
            self.delays.fill(0.0);
            self.gradient.fill(0.0);
            let rate = switching.guard_gradient(status, guard, t, z, &mut self.gradient);
            let falls = self.gradient.iter().zip(&self.slope_before);
            // Rate of the guard along the flow, 1/s.
            let rate = rate + falls.map(|(h, f)| h * f).sum::<f64>();
            self.is_grazing = rate >= 0.0;
            if self.is_grazing {
                return;
            }
            for (gradient, row) in self.gradient[..n].iter().zip(vectors.chunks_exact(width)) {
                for (delay, x) in self.delays.iter_mut().zip(row) {
                    *delay -= gradient * x / rate;
                }
            }
        }
        switching.reset_tangents(status, guard, t, z, (vectors, width, 0.0));
        let jump = &mut self.slope_before[..n];
        switching.reset_tangents(status, guard, t, z, (jump, 1, 1.0));
    }

    /// Eq. (16): after the crossing, `delta z+ = dg/dz . delta z- + (dg/dz . F_before + dg/dt - F_after)
    /// delta t`.
    pub fn after(
        &mut self,
        switching: &dyn Switching,
        t: f64,
        (status, z): (&[u8], &[f64]),
        block: &mut TangentBlock,
    ) {
        if self.is_grazing {
            return;
        }
        rhs_in(switching, status, t, z, &mut self.slope_after);
        let jumps = self.slope_before.iter().zip(&self.slope_after);
        for (row, (before, after)) in block.end.chunks_exact_mut(block.width).zip(jumps) {
            for (x, delay) in row.iter_mut().zip(&self.delays) {
                *x += (before - after) * delay;
            }
        }
    }
}

/// `dz/dt` for a frozen status.
fn rhs_in(sys: &dyn Switching, status: &[u8], t: f64, z: &[f64], dz: &mut [f64]) {
    let status = Some(status);
    Law { sys, status }.rhs(t, z, dz, None);
}
