//! Piecewise smooth systems: guards, statuses and reset maps.

use super::system::{System, add_linear, central_difference, difference_of_change};

/// A piecewise smooth system. Its discrete *status* describes, for example, which nodes are in contact
/// or whether a mass sticks. A smooth law holds for each status. A status ends where one of its *guards*
/// falls through zero: the status changes, and the state may jump.
///
/// The status is a few bytes that the system defines. The guards belong to the present status: they are
/// positive or zero while the status is valid, so a guard usually changes its sign with the status.
/// After [`Switching::cross`] the guard should be zero or positive again. A guard that is still negative
/// is crossed again.
///
/// # Limits
///
/// * Events that accumulate at a point in time (a ball that comes to rest) or a motion that slides along a guard
///   (chattering) are not continued: sticking needs a status of its own. More events than
///   [`Integrator::with_crossing_limit`](super::Integrator::with_crossing_limit) permits are
///   [`DynamicsError::Chatter`](super::DynamicsError::Chatter), or, of a system that
///   [is continuous](Switching::is_continuous), end event location for a while.
/// * A guard that is not a number is never crossed. Return numbers wherever the state is finite; a force that is not
///   finite is [`DynamicsError::NonFinite`](super::DynamicsError::NonFinite).
/// * Two crossings of a guard within a step that its five samples and their parabolas do not show are missed.
/// * Half a million steps with a mean length below 1e-5 of the maximum step are
///   [`DynamicsError::Stalled`](super::DynamicsError::Stalled). For a motion that needs such steps, give a maximum step of
///   its time scale.
pub trait Switching: System {
    /// Length of the status, bytes: one, unless a system has more.
    fn status_len(&self) -> usize {
        1
    }

    /// Writes the initial status for a state `z` at time `t` (s).
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]);

    /// Eq. (11): the smooth law of a status, `[f | g]` as in [`System::force`](super::System::force). It
    /// must also be defined slightly beyond the guards.
    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]);

    /// Number of guards.
    fn guards(&self) -> usize;

    /// Eq. (12): writes all guards `h_k(t, z)` to `values`, in any unit. A status ends where one of them
    /// falls through zero.
    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]);

    /// Eq. (13): `z+ = g(z-)`, the reset at a guard that falls through zero: sets the new status and the
    /// jump of the state. On input `z` is beyond the guard by a rounding error of the time. If this
    /// matters, the reset map moves the state back onto the guard (an impact sets the distance to zero).
    ///
    /// Eq. (14): the law of the new status holds from there on.
    fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]);

    /// Projects a state onto the constraint of its status (the velocity of a sticking mass) to prevent
    /// drift by integration errors, and in place with it, by the derivative of the projection, the given
    /// number of tangent vectors (order as in [`Differentiable::product`](super::Differentiable::product)).
    /// The default, without constraints, does nothing.
    fn settle(&self, _status: &[u8], _t: f64, _z: &mut [f64], _tangents: (&mut [f64], usize)) {}

    /// Whether the state and the law are continuous at all guards. Tangent vectors then pass an event
    /// unchanged (the correction of Eq. (16) vanishes), and a step may cross guards without locating
    /// them. `false` unless proven.
    fn is_continuous(&self) -> bool {
        false
    }

    /// Eq. (19): writes the gradient `dh/dz` of one guard to `gradient` (length of the state) and
    /// returns the partial time derivative `dh/dt`. The default takes central differences of
    /// [`Switching::guard_values`]; that for the time is taken along the motion, whose speed sets its scale.
    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let mut values = vec![0.0; self.guards()];
        let mut slope = |vector: &[f64], rate: f64| {
            central_difference((t, z), (vector, rate), &mut values, |t, z, out| {
                self.guard_values(status, t, z, out);
            });
            values[guard]
        };
        let mut vector = vec![0.0; z.len()];
        for (c, gradient) in gradient.iter_mut().enumerate() {
            vector[c] = 1.0;
            *gradient = slope(&vector, 0.0);
            vector[c] = 0.0;
        }
        self.force_in(status, t, z, &mut vector[self.modes()..]);
        add_linear(self.omega(), self.damping(), z, &mut vector, 1);
        slope(&vector, 1.0)
            - gradient
                .iter()
                .zip(&vector)
                .map(|(h, f)| h * f)
                .sum::<f64>()
    }

    /// The derivative of the reset map `g(t, z)` at a guard, applied in place: `dg/dz . v + rate dg/dt` of
    /// each tangent vector `v`. They are given with their number (order as in
    /// [`Differentiable::product`](super::Differentiable::product)) and the rate, which is 1 for the slope of
    /// the motion and 0 for a perturbation. `status` and `z` are those before the reset.
    ///
    /// The default takes central differences of [`Switching::cross`], which must permit states beside the
    /// guard. It is exact for components that the reset does not change.
    fn reset_tangents(
        &self,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        tangents: (&mut [f64], usize, f64),
    ) {
        difference_of_change((t, z), tangents, |t, z| {
            self.cross(guard, t, z, &mut status.to_vec());
        });
    }
}
