//! The Hénon–Heiles system.

use squeakscope_dynamics::{Differentiable, System};

/// The Hénon–Heiles model of a star in a galaxy, `x'' + x = -2 x y`, `y'' + y = y^2 - x^2`; state `[x,
/// y, x', y']`. The energy is conserved, and the exponents form pairs of opposite sign (M. Henon and C.
/// Heiles, Astron. J. 69 (1964) 73-79).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HenonHeiles;

impl System for HenonHeiles {
    fn omega(&self) -> &[f64] {
        &[1.0, 1.0]
    }

    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = -2.0 * z[0] * z[1];
        out[1] = z[1] * z[1] - z[0] * z[0];
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for HenonHeiles {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let (x, y) = (record[1], record[2]);
        for l in 0..width {
            let (dx, dy) = (vectors[l], vectors[width + l]);
            out[l] = -2.0 * (dx * y + x * dy);
            out[width + l] = 2.0 * (y * dy - x * dx);
        }
    }
}
