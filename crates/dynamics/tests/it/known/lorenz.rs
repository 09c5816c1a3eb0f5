//! The Lorenz system.

use squeakscope_dynamics::{Differentiable, System};

/// The Lorenz system: `x' = sigma (y - x)`, `y' = x (rho - z) - y`, `z' = x y - beta z`; state `[x, y,
/// z]`. The sum of its exponents is `-(sigma + 1 + beta)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lorenz {
    /// Prandtl number.
    pub sigma: f64,
    /// Rayleigh number divided by its value at the onset of convection.
    pub rho: f64,
    /// Geometry parameter of the convection rolls.
    pub beta: f64,
}

impl Lorenz {
    /// Parameters of E. N. Lorenz (J. Atmos. Sci. 20 (1963) 130-141), in the chaotic range.
    pub const CLASSICAL: Self = Self {
        sigma: 10.0,
        rho: 28.0,
        beta: 8.0 / 3.0,
    };
}

impl System for Lorenz {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        3
    }

    fn force(&self, _t: f64, w: &[f64], out: &mut [f64]) {
        out[0] = self.sigma * (w[1] - w[0]);
        out[1] = w[0] * (self.rho - w[2]) - w[1];
        out[2] = w[0] * w[1] - self.beta * w[2];
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for Lorenz {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let [_, x, y, z] = *record else {
            unreachable!("the record is the time and the state")
        };
        for l in 0..width {
            let [dx, dy, dz] = [0, 1, 2].map(|c| vectors[c * width + l]);
            out[l] = self.sigma * (dy - dx);
            out[width + l] = dx * (self.rho - z) - x * dz - dy;
            out[2 * width + l] = dx * y + x * dy - self.beta * dz;
        }
    }
}
