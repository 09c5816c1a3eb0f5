//! The Rössler system.

use squeakscope_dynamics::{Differentiable, System};

/// The Rössler system: `x' = -y - z`, `y' = x + a y`, `z' = b + z (x - c)`; state `[x, y, z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roessler {
    /// Twice the growth rate of the spiral in the x-y plane.
    pub a: f64,
    /// Constant term of the z equation.
    pub b: f64,
    /// Threshold of `x` above which `z` grows.
    pub c: f64,
}

impl Roessler {
    /// Parameters of O. E. Roessler (Phys. Lett. A 57 (1976) 397-398), in the chaotic range.
    pub const CLASSICAL: Self = Self {
        a: 0.2,
        b: 0.2,
        c: 5.7,
    };
}

impl System for Roessler {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        3
    }

    fn force(&self, _t: f64, w: &[f64], out: &mut [f64]) {
        out[0] = -w[1] - w[2];
        out[1] = w[0] + self.a * w[1];
        out[2] = self.b + w[2] * (w[0] - self.c);
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for Roessler {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let [_, x, _, z] = *record else {
            unreachable!("the record is the time and the state")
        };
        for l in 0..width {
            let [dx, dy, dz] = [0, 1, 2].map(|c| vectors[c * width + l]);
            out[l] = -dy - dz;
            out[width + l] = dx + self.a * dy;
            out[2 * width + l] = dz * (x - self.c) + z * dx;
        }
    }
}
