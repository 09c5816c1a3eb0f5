//! Mode coupling of two modes by friction.

use super::{Motion, Number, Piecewise, derivatives};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// A mass with two modes that is pressed onto a belt: the minimal model of mode-coupling instability.
///
/// The coefficient of friction is constant. The friction force follows the normal force, which depends
/// on the displacement normal to the belt. A displacement in one mode changes the normal force, and
/// friction turns this into a force along the belt that acts on the other mode. The stiffness matrix is
/// therefore not symmetric. Above a critical coefficient of friction ([`TwoModesOnBelt::critical_mu`])
/// the two frequencies coincide and the vibration grows.
///
/// ```text
/// q'' + W^2 q = -(N - n) e + (mu(V) N - mu(belt) n) t
/// N = max(0, n + k e.q)        V = belt - t.q'        mu(V) = mu sign(V) (1 - exp(-creep |V|))
/// t = (cos a, -sin a)          e = (sin a, cos a)
/// ```
///
/// The two modes are orthogonal. `t` and `e` are their components along the belt and into it, for an
/// angle `a` between the first mode and the belt. The state is the perturbation from steady sliding,
/// which is `q = 0`. The two statuses are *touching* and *separated*; the force is continuous between
/// them. The coefficient of friction is regularised at zero sliding speed: the mass creeps instead of
/// sticking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoModesOnBelt {
    /// Natural circular frequencies `W` without contact, rad/s, positive.
    pub omega: [f64; 2],
    /// Angle `a` from the belt direction to the first mode, positive into the belt, rad.
    pub angle: f64,
    /// Contact stiffness `k` per unit mass, 1/s^2, positive.
    pub contact_stiffness: f64,
    /// Normal force `n` in steady sliding per unit mass, N/kg, positive.
    pub load: f64,
    /// Coefficient of friction, 0 or more.
    pub mu: f64,
    /// Rate constant of the regularisation at zero sliding speed, s/m, positive.
    pub creep: f64,
    /// Speed of the belt, m/s, positive.
    pub belt: f64,
}

/// A mode of the linearised system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledMode {
    /// Circular frequency, rad/s.
    pub omega: f64,
    /// Growth rate, 1/s.
    pub growth: f64,
}

impl TwoModesOnBelt {
    /// Status: in contact with the belt.
    pub const TOUCHING: u8 = 0;
    /// Status: separated from the belt.
    pub const SEPARATED: u8 = 1;

    /// Components of the two modes along the belt.
    pub fn along(&self) -> [f64; 2] {
        [self.angle.cos(), -self.angle.sin()]
    }

    /// Components of the two modes into the belt.
    pub fn inwards(&self) -> [f64; 2] {
        [self.angle.sin(), self.angle.cos()]
    }

    /// Stiffness matrix of steady sliding per unit mass, in the directions along and into the belt,
    /// 1/s^2, for a given coefficient of friction.
    pub fn stiffness(&self, mu: f64) -> [[f64; 2]; 2] {
        let (along, into) = (self.along(), self.inwards());
        let squares = self.omega.map(|omega| omega * omega);
        let of = |a: [f64; 2], b: [f64; 2]| (0..2).map(|i| a[i] * squares[i] * b[i]).sum::<f64>();
        let k = self.contact_stiffness;
        [
            [of(along, along), of(along, into) - mu * k],
            [of(into, along), of(into, into) + k],
        ]
    }

    /// The modes of steady sliding, the lower frequency first, for a given coefficient of friction: from
    /// `lambda^2 + kappa = 0` with the two eigenvalues `kappa` of [`TwoModesOnBelt::stiffness`].
    pub fn modes_at(&self, mu: f64) -> [CoupledMode; 2] {
        let [[a, b], [c, d]] = self.stiffness(mu);
        let (mean, discriminant) = (0.5 * (a + d), 0.25 * (a - d).powi(2) + b * c);
        // Square root of a complex number: real part, imaginary part.
        let root = |re: f64, im: f64| {
            let size = re.hypot(im);
            [size + re, size - re].map(|x| (0.5 * x).max(0.0).sqrt())
        };
        if discriminant < 0.0 {
            let [omega, growth] = root(mean, (-discriminant).sqrt());
            return [-growth, growth].map(|growth| CoupledMode { omega, growth });
        }
        [-discriminant.sqrt(), discriminant.sqrt()].map(|by| {
            let [omega, growth] = root(mean + by, 0.0);
            CoupledMode { omega, growth }
        })
    }

    /// The critical coefficient of friction for flutter; `None` if no coefficient causes it, because the
    /// coupling has the opposite sign.
    ///
    /// At the critical coefficient the two eigenvalues of the stiffness matrix coincide: `(a - d)^2 / 4
    /// + c (b0 - mu k) = 0`.
    pub fn critical_mu(&self) -> Option<f64> {
        let [[a, b], [c, d]] = self.stiffness(0.0);
        let critical = (b + 0.25 * (a - d).powi(2) / c) / self.contact_stiffness;
        (c > 0.0).then_some(critical)
    }

    /// Normal force per unit mass as if the contact could pull, N/kg.
    fn normal<const N: usize>(&self, at: &Motion<2, N>) -> Number<N> {
        combined(self.inwards(), at.z[0]) * self.contact_stiffness + self.load
    }

    /// Signed coefficient of friction at a sliding velocity, m/s.
    fn coefficient<const N: usize>(&self, speed: Number<N>) -> Number<N> {
        speed.compose_scalar(|speed| {
            let rise = (-self.creep * speed.abs()).exp();
            [
                self.mu * speed.signum() * (1.0 - rise),
                self.mu * self.creep * rise,
            ]
        })
    }
}

/// The sum of numbers of both modes, each with its component of a direction.
fn combined<const N: usize>(direction: [f64; 2], x: [Number<N>; 2]) -> Number<N> {
    x[0] * direction[0] + x[1] * direction[1]
}

implement!(TwoModesOnBelt, 2);

impl Piecewise<2> for TwoModesOnBelt {
    const IS_CONTINUOUS: bool = true;

    fn linear(&self) -> [&[f64]; 2] {
        [&self.omega, &[]]
    }

    fn status(&self, at: &Motion<2, 0>) -> u8 {
        if self.normal(at).value() < 0.0 {
            Self::SEPARATED
        } else {
            Self::TOUCHING
        }
    }

    fn law<const N: usize>(&self, status: u8, at: &Motion<2, N>) -> [Number<N>; 2] {
        let normal = match status {
            Self::TOUCHING => self.normal(at),
            _ => Number::number(0.0),
        };
        let belt = Number::number(self.belt);
        let mu = self.coefficient(belt - combined(self.along(), at.z[1]));
        let press = normal + -self.load;
        let drag = mu * normal - self.coefficient(belt) * self.load;
        let (along, into) = (self.along(), self.inwards());
        [0, 1].map(|i| drag * along[i] - press * into[i])
    }

    fn guard<const N: usize>(&self, status: u8, _guard: usize, at: &Motion<2, N>) -> Number<N> {
        match status {
            Self::TOUCHING => self.normal(at),
            _ => self.normal(at) * -1.0,
        }
    }

    fn reset<const N: usize>(&self, status: &mut u8, _guard: usize, _at: &mut Motion<2, N>) {
        // The other one of the two statuses, 0 and 1.
        *status = 1 - *status;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const SYSTEM: TwoModesOnBelt = TwoModesOnBelt {
        omega: [TAU * 500.0, TAU * 400.0],
        angle: 0.26,
        contact_stiffness: (TAU * 290.0) * (TAU * 290.0),
        load: 10.0,
        mu: 0.4,
        creep: 1000.0,
        belt: 0.05,
    };

    #[test]
    fn modes_satisfy_the_characteristic_equation() {
        for mu in [0.0, 0.1, 0.25, 0.3, 0.6] {
            let [[a, b], [c, d]] = SYSTEM.stiffness(mu);
            for mode in SYSTEM.modes_at(mu) {
                // kappa = -(growth + i omega)^2 in det(K - kappa) = 0.
                let re = mode.omega.powi(2) - mode.growth.powi(2);
                let im = -2.0 * mode.omega * mode.growth;
                let real = (a - re) * (d - re) - im * im - b * c;
                let imaginary = -im * (a - re) - im * (d - re);
                assert!(real.abs() < 1e-9 * a * d, "{mu}: {real:e}");
                assert!(imaginary.abs() < 1e-9 * a * d, "{mu}: {imaginary:e}");
            }
        }
    }

    #[test]
    fn the_critical_coefficient_agrees_with_bisection_of_the_growth_rate() {
        let flutters = |mu| SYSTEM.modes_at(mu)[1].growth > 0.0;
        let (mut low, mut high) = (0.0, 1.0);
        assert!(!flutters(low) && flutters(high));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if flutters(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let critical = SYSTEM.critical_mu().unwrap();
        assert!((critical - high).abs() < 1e-9, "{critical} {high}");
        let mirrored = TwoModesOnBelt {
            angle: -SYSTEM.angle,
            ..SYSTEM
        };
        assert_eq!(mirrored.critical_mu(), None);
        assert!((0..100).all(|k| mirrored.modes_at(0.05 * f64::from(k))[1].growth == 0.0));
    }

    /// The linearised force about steady sliding equals the stiffness matrix in the directions along and
    /// into the belt.
    #[test]
    fn the_linearised_force_equals_the_stiffness_matrix() {
        let h = 1e-9;
        let stiffness = SYSTEM.stiffness(SYSTEM.mu);
        let (along, into) = (SYSTEM.along(), SYSTEM.inwards());
        for (column, direction) in [along, into].into_iter().enumerate() {
            let z = [h * direction[0], h * direction[1], 0.0, 0.0];
            let mut dz = [0.0; 4];
            SYSTEM.rhs(0.0, &z, &mut dz);
            for (row, direction) in [along, into].into_iter().enumerate() {
                let found = -(direction[0] * dz[2] + direction[1] * dz[3]) / h;
                let expected = stiffness[row][column];
                assert!(
                    (found - expected).abs() < 1e-6 * stiffness[0][0],
                    "{row}{column}"
                );
            }
        }
    }

    #[test]
    fn the_jacobian_product_agrees_with_finite_differences() {
        let z = [3e-6, -2e-6, 0.04, 0.03];
        for status in [TwoModesOnBelt::TOUCHING, TwoModesOnBelt::SEPARATED] {
            let force = |z: &[f64]| {
                let mut out = [0.0; 2];
                SYSTEM.force_in(&[status], 0.0, z, &mut out);
                out
            };
            for c in 0..4 {
                let h = 1e-9;
                let [mut up, mut down, mut unit] = [z, z, [0.0; 4]];
                up[c] += h;
                down[c] -= h;
                unit[c] = 1.0;
                let mut record = [0.0; 5];
                record[1..].copy_from_slice(&z);
                let mut out = [0.0; 2];
                SYSTEM.product(Some(&[status]), &mut record, &unit, 1, &mut out);
                let (up, down) = (force(&up), force(&down));
                for i in 0..2 {
                    let expected = (up[i] - down[i]) / (2.0 * h);
                    let size = expected.abs().max(1.0);
                    assert!(
                        (out[i] - expected).abs() < 1e-4 * size,
                        "{c} {i}: {}",
                        out[i]
                    );
                }
            }
        }
    }
}
