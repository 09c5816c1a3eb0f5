//! What an integrator needs to know of a system.

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

    /// Writes `[f | g]` (length `modes + first_order`) at time `t` (s) and state `z`.
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]);

    /// The number of modes `m`.
    fn modes(&self) -> usize {
        self.omega().len()
    }

    /// The length of the state, `2 m + first_order`.
    fn dim(&self) -> usize {
        2 * self.modes() + self.first_order()
    }

    /// Writes the whole right-hand side `dz/dt` (length [`System::dim`]).
    fn rhs(&self, t: f64, z: &[f64], dz: &mut [f64]) {
        let m = self.modes();
        self.force(t, z, &mut dz[m..]);
        let (q, v) = z[..2 * m].split_at(m);
        let zeta = self.damping();
        for (i, &w) in self.omega().iter().enumerate() {
            dz[i] = v[i];
            dz[m + i] -= w * w * q[i];
            if let Some(ratio) = zeta.get(i) {
                dz[m + i] -= 2.0 * ratio * w * v[i];
            }
        }
    }
}
