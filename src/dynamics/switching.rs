//! Systems whose law changes: guards, statuses and reset maps.

/// A system made of pieces that are smooth, each with a *status*: which nodes touch, whether a
/// mass sticks. While a status lasts, its own smooth law holds; it ends where one of its *guards*
/// falls through zero. There the status changes, and the state may jump.
///
/// The status is a few bytes whose meaning is the system's own. A guard belongs to the present
/// status: it is positive (or zero) as long as the status may last, so that a guard usually changes
/// its sign with the status. After [`Switching::cross`] the guard should be zero or positive again;
/// while one is not, it is crossed anew (and a system that never gets clear of its guards is ended
/// as chatter).
pub trait Switching {
    /// Bytes of the status.
    fn status_len(&self) -> usize;

    /// Writes the status in which a state `z` at time `t` (s) starts.
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]);

    /// Eq. (11): the smooth law that holds while a status lasts, `[f | g]` as in
    /// [`System::force`](super::System::force), defined also a little beyond the guards.
    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]);

    /// The number of guards.
    fn guards(&self) -> usize;

    /// Eq. (12): the guards `h_k(t, z)`, of which one falls through zero where the status ends; all
    /// of them into `values`, in any unit.
    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]);

    /// Eq. (13): `z+ = g(z-)`, what happens as a guard falls through zero: the new status, and the
    /// jump of the state. `z` comes in just past the guard, by a rounding error of the time; a reset
    /// map puts it back onto the guard where that matters (an impact sets the distance to zero).
    ///
    /// Eq. (14): from there on the law of the new status holds.
    fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]);

    /// Puts a state back onto what its status holds fixed (the velocity of a mass that sticks),
    /// against the drift by the errors of the steps. Nothing to do where a status holds nothing.
    fn settle(&self, _status: &[u8], _t: f64, _z: &mut [f64]) {}

    /// The derivative of [`Switching::settle`], applied in place to `width` tangent vectors (see
    /// [`Differentiable::product`](super::Differentiable::product) for their order): what a status
    /// holds fixed, it holds fixed for neighbours, too. Nothing to do where a status holds nothing.
    fn settle_tangents(&self, _status: &[u8], _vectors: &mut [f64], _width: usize) {}

    /// Whether nothing jumps at any guard: the state goes on, and the laws before and after agree on
    /// the guard. Then the tangent flow passes unchanged (the correction of Eq. (16) vanishes), and
    /// a step may run over the guards. `false` where not proven.
    fn is_continuous(&self) -> bool {
        false
    }

    /// Eq. (19): the gradient `dh/dz` of one guard into `gradient` (as long as the state); returns
    /// `dh/dt`, the change of the guard by itself.
    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        gradient: &mut [f64],
    ) -> f64;

    /// `dg/dz` of the reset map at a guard, applied in place to tangent vectors and their number (see
    /// [`Differentiable::product`](super::Differentiable::product) for their order). `status` and
    /// `z` are those before the reset. Nothing to do where the state goes on.
    fn reset_tangents(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        _tangents: (&mut [f64], usize),
    ) {
    }

    /// Adds `dg/dt` of the reset map (as long as the state): how the jump changes by itself, where a
    /// wall moves, say.
    fn add_reset_rate(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        _rate: &mut [f64],
    ) {
    }
}
