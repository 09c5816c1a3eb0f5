//! Small test systems.

use squeakscope_dynamics::{Differentiable, System};

/// Implements [`Differentiable`] by finite differences of the force.
macro_rules! by_differences {
    ($sys:ty $(, $generic:ident)?) => {
        impl$(<$generic: Fn(f64, f64, f64) -> f64 + Send + Sync>)? squeakscope_dynamics::Differentiable for $sys {
            fn product(
                &self,
                status: Option<&[u8]>,
                record: &mut [f64],
                vectors: &[f64],
                width: usize,
                out: &mut [f64],
            ) {
                $crate::systems::differences(
                    self, status, record, vectors, width, out,
                );
            }
        }
    };
}
pub(crate) use by_differences;

/// [`Differentiable::product`] by central differences, for a system without quadratures.
pub fn differences<Y: System>(
    sys: &Y,
    status: Option<&[u8]>,
    record: &[f64],
    vectors: &[f64],
    width: usize,
    out: &mut [f64],
) {
    let (t, z) = (record[0], &record[1..]);
    let size = z.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    let step = if size > 0.0 { 1e-5 * size } else { 1e-5 };
    let (mut moved, mut ahead) = (z.to_vec(), vec![0.0; out.len() / width]);
    let mut behind = ahead.clone();
    for l in 0..width {
        for (sign, force_there) in [(1.0, &mut ahead), (-1.0, &mut behind)] {
            for (c, moved) in moved.iter_mut().enumerate() {
                *moved = z[c] + sign * step * vectors[c * width + l];
            }
            match status {
                None => sys.force(t, &moved, force_there),
                Some(status) => {
                    let switching = sys.switching().expect("a status without switching");
                    switching.force_in(status, t, &moved, force_there);
                }
            }
        }
        for (i, (ahead, behind)) in ahead.iter().zip(&behind).enumerate() {
            out[i * width + l] = (ahead - behind) / (2.0 * step);
        }
    }
}

/// Oscillators in free vibration.
pub struct Free {
    pub omega: Vec<f64>,
    pub damping: Vec<f64>,
}

impl Free {
    /// The exact state at time `t` from `z0` at time zero, for each mode.
    pub fn exact(&self, z0: &[f64], t: f64) -> Vec<f64> {
        let m = self.omega.len();
        let mut z = vec![0.0; 2 * m];
        for i in 0..m {
            let (w, zeta) = (self.omega[i], self.damping.get(i).copied().unwrap_or(0.0));
            let (q, v) = (z0[i], z0[m + i]);
            if w == 0.0 {
                (z[i], z[m + i]) = (q + v * t, v);
                continue;
            }
            // q = exp(-sigma t) (a cos(w_d t) + b sin(w_d t))
            let (sigma, wd) = (zeta * w, w * (1.0 - zeta * zeta).sqrt());
            let (a, b) = (q, (v + sigma * q) / wd);
            let (s, c) = (wd * t).sin_cos();
            let attenuation = (-sigma * t).exp();
            z[i] = attenuation * (a * c + b * s);
            z[m + i] = attenuation * ((b * wd - sigma * a) * c - (a * wd + sigma * b) * s);
        }
        z
    }
}

impl System for Free {
    fn omega(&self) -> &[f64] {
        &self.omega
    }
    fn damping(&self) -> &[f64] {
        &self.damping
    }
    fn force(&self, _t: f64, _z: &[f64], out: &mut [f64]) {
        out.fill(0.0);
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

/// Three driven oscillators, one damped, one with zero frequency, coupled by cubic springs. The work of
/// the force is a first-order component.
pub struct Duffing;

impl Duffing {
    pub const START: [f64; 7] = [0.6, -0.3, 0.2, 0.1, 0.8, -0.4, 0.0];
}

impl System for Duffing {
    fn omega(&self) -> &[f64] {
        &[1.0, 2.3, 0.0]
    }
    fn damping(&self) -> &[f64] {
        &[0.0, 0.03, 0.0]
    }
    fn first_order(&self) -> usize {
        1
    }
    fn quadratures(&self) -> usize {
        1
    }
    fn is_autonomous(&self) -> bool {
        false
    }
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        let spring = |x: f64| x + x.powi(3);
        let (a, b) = (spring(z[0] - z[1]), spring(z[1] - z[2]));
        out[0] = -0.3 * a + 0.2 * (1.7 * t).cos();
        out[1] = 0.3 * (a - b);
        out[2] = 0.3 * b - 0.4 * spring(z[2]);
        out[3] = (0..3).map(|i| out[i] * z[3 + i]).sum();
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
}

impl Differentiable for Duffing {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let slope = |x: f64| 1.0 + 3.0 * x * x;
        let z = &record[1..];
        let slopes = [slope(z[0] - z[1]), slope(z[1] - z[2]), slope(z[2])];
        for l in 0..width {
            let q = [0, 1, 2].map(|i| vectors[i * width + l]);
            let (a, b) = (slopes[0] * (q[0] - q[1]), slopes[1] * (q[1] - q[2]));
            out[l] = -0.3 * a;
            out[width + l] = 0.3 * (a - b);
            out[2 * width + l] = 0.3 * b - 0.4 * slopes[2] * q[2];
        }
    }
    fn time_derivative(&self, _status: Option<&[u8]>, t: f64, _z: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&[-0.2 * 1.7 * (1.7 * t).sin(), 0.0, 0.0]);
    }
}

/// The Lorenz equations (10, 28, 8/3): first-order components only.
pub struct Lorenz;

impl Lorenz {
    pub const START: [f64; 3] = [1.0, -2.0, 17.0];
}

impl System for Lorenz {
    fn omega(&self) -> &[f64] {
        &[]
    }
    fn first_order(&self) -> usize {
        3
    }
    fn force(&self, _t: f64, w: &[f64], out: &mut [f64]) {
        out[0] = 10.0 * (w[1] - w[0]);
        out[1] = w[0] * (28.0 - w[2]) - w[1];
        out[2] = w[0] * w[1] - 8.0 / 3.0 * w[2];
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

/// Three oscillators preloaded against three unilateral springs, `N_n = max(0, p + k phi_n . q)`; `q` is
/// the displacement from equilibrium. The work of the springs is a first-order component.
pub struct Unilateral;

impl Unilateral {
    pub const OMEGA: [f64; 3] = [1.0, 2.7, 4.4];
    pub const START: [f64; 7] = [0.5, -0.2, 0.1, 0.3, 0.9, -0.6, 0.0];
    pub const PRESS: f64 = 0.2;
    pub const STIFFNESS: f64 = 3.0;
    pub const SHAPES: [[f64; 3]; 3] = [[0.9, 0.4, -0.3], [0.6, -0.7, 0.5], [0.3, 0.8, 0.7]];

    /// `p + k phi_n . q`: the normal force of spring `n` if positive.
    pub fn gap(n: usize, q: &[f64]) -> f64 {
        Self::PRESS + Self::STIFFNESS * (0..3).map(|i| Self::SHAPES[n][i] * q[i]).sum::<f64>()
    }
}

impl System for Unilateral {
    fn omega(&self) -> &[f64] {
        &Self::OMEGA
    }
    fn first_order(&self) -> usize {
        1
    }
    fn quadratures(&self) -> usize {
        1
    }
    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for n in 0..3 {
            let change = Self::gap(n, z).max(0.0) - Self::PRESS;
            for (out, shape) in out.iter_mut().zip(&Self::SHAPES[n]) {
                *out -= shape * change;
            }
        }
        out[3] = (0..3).map(|i| out[i] * z[3 + i]).sum();
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

impl Differentiable for Unilateral {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        for n in (0..3).filter(|&n| Self::gap(n, &record[1..]) > 0.0) {
            let shape = &Self::SHAPES[n];
            for l in 0..width {
                let moved: f64 = (0..3).map(|i| shape[i] * vectors[i * width + l]).sum();
                for i in 0..3 {
                    out[i * width + l] -= Self::STIFFNESS * shape[i] * moved;
                }
            }
        }
    }
}

/// One oscillator with an arbitrary force `f(t, q, v)`.
pub struct Forced<F> {
    pub omega: [f64; 1],
    pub force: F,
}

impl<F: Fn(f64, f64, f64) -> f64 + Send + Sync> System for Forced<F> {
    fn omega(&self) -> &[f64] {
        &self.omega
    }
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = (self.force)(t, z[0], z[1]);
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        false
    }
}

by_differences!(Free);
by_differences!(Lorenz);
by_differences!(Forced<F>, F);

/// A system of first-order equations with its Jacobian as closures: `w' = g(t, w)`.
pub struct Equations<G, J> {
    pub dimension: usize,
    pub rates: G,
    /// Writes the Jacobian, row-major.
    pub jacobian: J,
    pub autonomous: bool,
}

impl<G, J> System for Equations<G, J>
where
    G: Fn(f64, &[f64], &mut [f64]) + Send + Sync,
    J: Fn(f64, &[f64], &mut [f64]) + Send + Sync,
{
    fn omega(&self) -> &[f64] {
        &[]
    }
    fn first_order(&self) -> usize {
        self.dimension
    }
    fn force(&self, t: f64, w: &[f64], out: &mut [f64]) {
        (self.rates)(t, w, out);
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
}

impl<G, J> Differentiable for Equations<G, J>
where
    G: Fn(f64, &[f64], &mut [f64]) + Send + Sync,
    J: Fn(f64, &[f64], &mut [f64]) + Send + Sync,
{
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let n = self.dimension;
        let mut jacobian = vec![0.0; n * n];
        (self.jacobian)(record[0], &record[1..], &mut jacobian);
        for i in 0..n {
            for l in 0..width {
                let terms = (0..n).map(|j| jacobian[i * n + j] * vectors[j * width + l]);
                out[i * width + l] = terms.sum();
            }
        }
    }
}
