//! The interface between an integrator and the system that it integrates.

use std::fmt;
use std::ops::Deref;

use super::Switching;

/// Oscillators with a nonlinear force, and additional first-order components:
///
/// ```text
/// q_i'' + 2 zeta_i omega_i q_i' + omega_i^2 q_i = f_i(t, z)      i = 1 .. modes
/// w_j'                                          = g_j(t, z)      j = 1 .. first_order
/// ```
///
/// Eq. (10): the state is `z = [q | q' | w]`, of length [`System::dim`]. The linear modal part is given
/// separately, which lets an exponential method integrate it exactly. A system of first-order equations
/// (for example Lorenz) has no modes. A quadrature (for example work) is a first-order component.
///
/// A system advertises optional capabilities by returning itself from [`System::switching`] and
/// [`System::differentiable`].
pub trait System: Send + Sync {
    /// Natural circular frequencies `omega_i`, rad/s, one per mode.
    fn omega(&self) -> &[f64];

    /// Damping ratios `zeta_i` of the linear part; an empty slice means undamped.
    fn damping(&self) -> &[f64] {
        &[]
    }

    /// Number of first-order components `w`.
    fn first_order(&self) -> usize {
        0
    }

    /// Number of quadratures, which are the last first-order components: no other equation depends on
    /// them. Tangent vectors omit them, because each would add a zero exponent without dynamical
    /// meaning.
    fn quadratures(&self) -> usize {
        0
    }

    /// Writes `[f | g]` (length `modes + first_order`) at time `t` (s) and state `z`.
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]);

    /// The guards and statuses of a non-smooth system; `None` for a smooth one.
    fn switching(&self) -> Option<&dyn Switching> {
        None
    }

    /// The derivative of the force; `None` if tangent vectors and implicit methods are not supported.
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        None
    }

    /// Name of the part of the system, such as `contact node 17`, whose force is not finite at a state.
    /// It is used in the error message. `None` if no such part exists or is known.
    fn non_finite_part(&self, _t: f64, _z: &[f64]) -> Option<String> {
        None
    }

    /// Whether the law is independent of time. The drive phase of a driven system has no exponent, so
    /// the meaning of zero exponents depends on this ([`Motion`](super::Motion)).
    fn is_autonomous(&self) -> bool;

    /// Whether the state or the law jumps at events.
    fn jumps(&self) -> bool {
        let switching = self.switching();
        switching.is_some_and(|switching| !switching.is_continuous())
    }

    /// Number of modes `m`.
    fn modes(&self) -> usize {
        self.omega().len()
    }

    /// Length of the state, `2 m + first_order`.
    fn dim(&self) -> usize {
        2 * self.modes() + self.first_order()
    }

    /// Length of a tangent vector: the state without its quadratures.
    fn tangent_dim(&self) -> usize {
        self.dim() - self.quadratures()
    }

    /// Eq. (9): `dz/dt = F(t, z)`, the full right-hand side (length [`System::dim`]).
    fn rhs(&self, t: f64, z: &[f64], dz: &mut [f64]) {
        self.force(t, z, &mut dz[self.modes()..]);
        add_linear(self.omega(), self.damping(), z, dz, 1);
    }
}

/// A reference to a system, or a pointer that owns one, is a system, too.
impl<P: Deref<Target: System> + Send + Sync> System for P {
    fn omega(&self) -> &[f64] {
        (**self).omega()
    }

    fn damping(&self) -> &[f64] {
        (**self).damping()
    }

    fn first_order(&self) -> usize {
        (**self).first_order()
    }

    fn quadratures(&self) -> usize {
        (**self).quadratures()
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        (**self).force(t, z, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        (**self).switching()
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        (**self).differentiable()
    }

    fn non_finite_part(&self, t: f64, z: &[f64]) -> Option<String> {
        (**self).non_finite_part(t, z)
    }

    fn is_autonomous(&self) -> bool {
        (**self).is_autonomous()
    }
}

impl fmt::Debug for dyn System + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a system with {} components", self.dim())
    }
}

/// A system with a known derivative of the force.
///
/// At each stage of a step the integrator calls [`Differentiable::force_recorded`], which stores a
/// *record* of the data that the derivative needs. After the step is accepted,
/// [`Differentiable::product`] propagates the tangent vectors through the same stages. A rejected step
/// therefore costs no tangent evaluations.
pub trait Differentiable: System {
    /// Length of a record. The default record holds the time and the state.
    fn record_len(&self) -> usize {
        1 + self.dim()
    }

    /// Evaluates the force as [`System::force`] does (or [`Switching::force_in`] for a given status) and
    /// fills the record. The default record is `[t | z]`.
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
        force(self, status, t, z, out);
    }

    /// Eq. (20): the nonlinear part of `d(delta z)/dt = dF/dz . delta z`, for `width` tangent vectors at
    /// once.
    ///
    /// `vectors` holds `tangent_dim x width` numbers, stored component by component: component `c` of
    /// vector `l` is `vectors[c * width + l]`. `out` receives the derivatives of `[f | g]` in the same
    /// order, `(tangent_dim - modes) x width` numbers. The record may be used as scratch space if it
    /// stays valid for further products.
    ///
    /// The default, for the default record, takes central differences of the force. It allocates.
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let mut derivative = vec![0.0; self.dim() - self.modes()];
        for l in 0..width {
            let mut vector: Vec<f64> = vectors.iter().skip(l).step_by(width).copied().collect();
            vector.resize(self.dim(), 0.0);
            let at = (record[0], &record[1..]);
            central_difference(at, (&vector, 0.0), &mut derivative, |t, z, out| {
                force(self, status, t, z, out);
            });
            for (out, x) in out.iter_mut().skip(l).step_by(width).zip(&derivative) {
                *out = *x;
            }
        }
    }

    /// The partial time derivative `d[f | g]/dt` at a fixed state (length `tangent_dim - modes`), for a
    /// given status if there is one. Implicit methods need it for systems that depend on time
    /// ([`System::is_autonomous`]). The default takes central differences.
    fn time_derivative(&self, status: Option<&[u8]>, t: f64, z: &[f64], out: &mut [f64]) {
        let mut slope = vec![0.0; self.dim()];
        self.rhs(t, z, &mut slope);
        let step = difference_step(z, &slope, Some(t));
        let [ahead, behind] = [t + step, t - step].map(|t| {
            let mut values = vec![0.0; self.dim() - self.modes()];
            force(self, status, t, z, &mut values);
            values
        });
        for (out, (ahead, behind)) in out.iter_mut().zip(ahead.iter().zip(&behind)) {
            *out = (ahead - behind) / (2.0 * step);
        }
    }
}

/// Writes `[f | g]` of a system, for a frozen status if there is one.
pub(super) fn force<S: System + ?Sized>(
    sys: &S,
    status: Option<&[u8]>,
    t: f64,
    z: &[f64],
    out: &mut [f64],
) {
    match (status, sys.switching()) {
        (Some(status), Some(switching)) => switching.force_in(status, t, z, out),
        _ => sys.force(t, z, out),
    }
}

/// Writes the central difference of a function of time (s) and state along a vector, and along the time at a rate of 0
/// or 1, to `out`. It is zero along a zero vector.
pub fn central_difference(
    (t, z): (f64, &[f64]),
    (vector, rate): (&[f64], f64),
    out: &mut [f64],
    mut at: impl FnMut(f64, &[f64], &mut [f64]),
) {
    let step = difference_step(z, vector, (rate != 0.0).then_some(t));
    if !step.is_finite() {
        return out.fill(0.0);
    }
    let moved = |by: f64| -> Vec<f64> { z.iter().zip(vector).map(|(z, v)| z + by * v).collect() };
    let mut behind = vec![0.0; out.len()];
    at(t + rate * step, &moved(step), out);
    at(t - rate * step, &moved(-step), &mut behind);
    for (out, behind) in out.iter_mut().zip(behind) {
        *out = (*out - behind) / (2.0 * step);
    }
}

/// Replaces each of `width` vectors by the central difference of a change of the state along it, and along the time at a
/// rate of 0 or 1. It is exact for components that do not change.
pub(super) fn difference_of_change(
    (t, z): (f64, &[f64]),
    (vectors, width, rate): (&mut [f64], usize, f64),
    mut change: impl FnMut(f64, &mut [f64]),
) {
    for l in 0..width {
        let mut vector: Vec<f64> = vectors.iter().skip(l).step_by(width).copied().collect();
        vector.resize(z.len(), 0.0);
        let step = difference_step(z, &vector, (rate != 0.0).then_some(t));
        if !step.is_finite() {
            // A collapsed vector stays zero.
            continue;
        }
        let [ahead, behind] = [step, -step].map(|step| {
            let moved = z.iter().zip(&vector).map(|(z, v)| z + step * v);
            let before: Vec<f64> = moved.collect();
            let mut after = before.clone();
            change(t + rate * step, &mut after);
            (before, after)
        });
        for (c, x) in vectors.iter_mut().skip(l).step_by(width).enumerate() {
            if ahead.0[c] != ahead.1[c] || behind.0[c] != behind.1[c] {
                *x = (ahead.1[c] - behind.1[c]) / (2.0 * step);
            }
        }
    }
}

/// Step of a central difference at a state along a vector, and in time with it if a time (s) is given: a small
/// part of the largest component, or of the time in which the vector, a slope, passes it.
fn difference_step(z: &[f64], vector: &[f64], t: Option<f64>) -> f64 {
    /// The cube root of the rounding error.
    const RELATIVE: f64 = 6e-6;
    /// Least part of the time, which is rounded.
    const LEAST: f64 = 1e-10;
    let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let state = size(z);
    let length = if state > 0.0 { state } else { 1.0 } / size(vector);
    match t.map(f64::abs) {
        None => RELATIVE * length,
        Some(t) => (RELATIVE * length.min(t.max(1.0))).max(LEAST * t),
    }
}

/// Factors of the components of a tangent vector that make their squares those of an energy: the natural frequency of a modal
/// coordinate, 1 for the others and at zero frequency.
pub(super) fn energy_units(sys: &dyn System) -> Vec<f64> {
    let omega = sys.omega().iter();
    let mut units: Vec<f64> = omega.map(|&w| if w > 0.0 { w } else { 1.0 }).collect();
    units.resize(sys.tangent_dim(), 1.0);
    units
}

/// Adds the linear part to `dz = [. | f | g]`. `z` is one state, or `width` tangent vectors stored
/// component by component.
pub(super) fn add_linear(omega: &[f64], damping: &[f64], z: &[f64], dz: &mut [f64], width: usize) {
    let half = omega.len() * width;
    let (q, v) = z[..2 * half].split_at(half);
    let (dq, dv) = dz[..2 * half].split_at_mut(half);
    dq.copy_from_slice(v);
    for (i, &w) in omega.iter().enumerate() {
        let row = i * width..(i + 1) * width;
        for (dv, q) in dv[row.clone()].iter_mut().zip(&q[row.clone()]) {
            *dv -= w * w * q;
        }
        if let Some(ratio) = damping.get(i) {
            for (dv, v) in dv[row.clone()].iter_mut().zip(&v[row]) {
                *dv -= 2.0 * ratio * w * v;
            }
        }
    }
}
