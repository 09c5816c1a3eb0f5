//! Systems whose tangent flow can be followed.

use super::System;

/// A system that knows the derivative of its force.
///
/// The integrator evaluates the force at each stage of a step through
/// [`Differentiable::force_recorded`], which leaves a *record* of what the derivative there needs.
/// Only when the step has been accepted are the tangent vectors taken through the same stages, by
/// [`Differentiable::product`]: a rejected step costs them nothing.
pub trait Differentiable: System {
    /// Numbers in a record. By default the time and the state.
    fn record_len(&self) -> usize {
        1 + self.dim()
    }

    /// As [`System::force`] (or, given a status,
    /// [`Switching::force_in`](super::Switching::force_in)), and fills the record. By default the
    /// record is `[t | z]`.
    fn force_recorded(
        &self,
        status: Option<&[u8]>,
        t: f64,
        z: &[f64],
        out: &mut [f64],
        record: &mut [f64],
    ) {
        record[0] = t;
        record[1..].copy_from_slice(z);
        match (status, self.switching()) {
            (Some(status), Some(switching)) => switching.force_in(status, t, z, out),
            _ => self.force(t, z, out),
        }
    }

    /// Eq. (20): the nonlinear part of `d(delta z)/dt = dF/dz . delta z`, for `width` tangent
    /// vectors at once.
    ///
    /// `vectors` holds `tangent_dim x width` numbers, component after component, the vectors of one
    /// component side by side: component `c` of vector `l` is `vectors[c * width + l]`. `out` gets
    /// the derivatives of `[f | g]` in the same order, `(tangent_dim - modes) x width` numbers. The
    /// record may be used as scratch, as long as another product can be formed with it.
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    );

    /// How `[f | g]` changes by itself at a fixed state, `d[f | g]/dt` (length
    /// `tangent_dim - modes`), under a status where one is given. Implicit methods need it. Zero by
    /// default: a system whose law changes with time ([`System::is_autonomous`]) has to give it,
    /// else those methods lose their order.
    fn time_derivative(&self, _status: Option<&[u8]>, _t: f64, _z: &[f64], out: &mut [f64]) {
        out.fill(0.0);
    }
}
