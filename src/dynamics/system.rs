//! What an integrator needs to know of a system, and of one whose tangent flow can be followed.

use super::Switching;

/// Oscillators with a nonlinear force, and first-order components beside them:
///
/// ```text
/// q_i'' + 2 zeta_i omega_i q_i' + omega_i^2 q_i = f_i(t, z)      i = 1 .. modes
/// w_j'                                          = g_j(t, z)      j = 1 .. first_order
/// ```
///
/// Eq. (10): the state is `z = [q | q' | w]`, of length [`System::dim`]. The linear modal part is known
/// apart, so that an exponential method can take it exactly. A plain system of first-order
/// equations (Lorenz, say) has no modes; a quadrature (work, say) is a first-order component.
///
/// What else an integrator can make use of is told by [`System::switching`] and
/// [`System::differentiable`]: a system that has it returns itself there.
pub trait System {
    /// Natural circular frequencies `omega_i`, rad/s; their number is the number of modes.
    fn omega(&self) -> &[f64];

    /// Damping ratios `zeta_i` of the linear part; empty means undamped.
    fn damping(&self) -> &[f64] {
        &[]
    }

    /// The number of first-order components `w`.
    fn first_order(&self) -> usize {
        0
    }

    /// How many of the first-order components, the last ones, are quadratures: nothing depends on
    /// them. Tangent vectors leave them out, since each would add an exponent of zero that says
    /// nothing of the motion.
    fn quadratures(&self) -> usize {
        0
    }

    /// Writes `[f | g]` (length `modes + first_order`) at time `t` (s) and state `z`.
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]);

    /// Where its law changes, for a system that is not smooth and that can hold one law while a
    /// step lasts.
    fn switching(&self) -> Option<&dyn Switching> {
        None
    }

    /// How its force changes with the state, for a system whose tangent flow can be followed.
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        None
    }

    /// The part of the system, such as `contact node 17`, whose force on the modes is not finite at a
    /// state, for the message of a run that ends there; `None` where there is none, or it is not known.
    fn part_at_fault(&self, _t: f64, _z: &[f64]) -> Option<String> {
        None
    }

    /// Whether the law itself does not change with time. The phase of a drive has no exponent, so
    /// that what exponents of zero mean depends on this ([`Motion`](super::Motion)).
    fn is_autonomous(&self) -> bool {
        true
    }

    /// The number of modes `m`.
    fn modes(&self) -> usize {
        self.omega().len()
    }

    /// The length of the state, `2 m + first_order`.
    fn dim(&self) -> usize {
        2 * self.modes() + self.first_order()
    }

    /// The length of a tangent vector: that of the state without its quadratures.
    fn tangent_dim(&self) -> usize {
        self.dim() - self.quadratures()
    }

    /// Eq. (9): `dz/dt = F(t, z)`, the whole right-hand side (length [`System::dim`]).
    fn rhs(&self, t: f64, z: &[f64], dz: &mut [f64]) {
        self.force(t, z, &mut dz[self.modes()..]);
        add_linear(self.omega(), self.damping(), z, dz, 1);
    }
}

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

    /// As [`System::force`] (or, given a status, [`Switching::force_in`]), and fills the record. By
    /// default the record is `[t | z]`.
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

/// Completes `dz = [. | f | g]` by the linear part: `dz/dt` of the state `z`, or of `width` tangent
/// vectors side by side (component after component, the vectors of one component together).
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
