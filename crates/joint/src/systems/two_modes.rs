//! Mode coupling of two modes by friction.

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
        let ([along, into], squares) = (
            [self.along(), self.inwards()],
            self.omega.map(|omega| omega * omega),
        );
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
            [
                (0.5 * (size + re)).max(0.0).sqrt(),
                (0.5 * (size - re)).max(0.0).sqrt(),
            ]
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

    /// Status of a state.
    fn status(&self, _t: f64, q: &[f64]) -> u8 {
        if self.normal(q) < 0.0 {
            Self::SEPARATED
        } else {
            Self::TOUCHING
        }
    }

    /// Normal force per unit mass as if the contact could pull, N/kg.
    fn normal(&self, q: &[f64]) -> f64 {
        self.load + self.contact_stiffness * dot(self.inwards(), q)
    }

    /// Signed coefficient of friction at a sliding velocity (m/s) and its derivative, s/m.
    fn coefficient(&self, speed: f64) -> [f64; 2] {
        let rise = (-self.creep * speed.abs()).exp();
        [
            self.mu * speed.signum() * (1.0 - rise),
            self.mu * self.creep * rise,
        ]
    }

    fn speed(&self, v: &[f64]) -> f64 {
        self.belt - dot(self.along(), v)
    }
}

fn dot(a: [f64; 2], b: &[f64]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

system_of_status!(TwoModesOnBelt, |self| &self.omega, &[], autonomous: true);

impl Switching for TwoModesOnBelt {
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        status[0] = self.status(t, z);
    }

    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        let (q, v) = z.split_at(2);
        let normal = match status[0] {
            Self::TOUCHING => self.normal(q),
            _ => 0.0,
        };
        let [mu, _] = self.coefficient(self.speed(v));
        let [mu_steady, _] = self.coefficient(self.belt);
        let press = normal - self.load;
        let drag = mu * normal - mu_steady * self.load;
        let (along, into) = (self.along(), self.inwards());
        for i in 0..2 {
            out[i] = drag * along[i] - press * into[i];
        }
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        let normal = self.normal(z);
        values[0] = match status[0] {
            Self::TOUCHING => normal,
            _ => -normal,
        };
    }

    fn cross(&self, _guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        status[0] = match status[0] {
            Self::TOUCHING => Self::SEPARATED,
            _ => Self::TOUCHING,
        };
    }

    fn is_continuous(&self) -> bool {
        true
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let sign = match status[0] {
            Self::TOUCHING => 1.0,
            _ => -1.0,
        };
        let [first, second] = self.inwards().map(|e| sign * self.contact_stiffness * e);
        gradient.copy_from_slice(&[first, second, 0.0, 0.0]);
        0.0
    }
}

impl Differentiable for TwoModesOnBelt {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let z = &record[1..];
        let status = status.map_or_else(|| self.status(record[0], z), |status| status[0]);
        if status != Self::TOUCHING {
            return out.fill(0.0);
        }
        let (along, into) = (self.along(), self.inwards());
        let normal = self.normal(z);
        let [mu, slope] = self.coefficient(self.speed(&z[2..]));
        for k in 0..width {
            let component = |c: usize| vectors[c * width + k];
            let press = self.contact_stiffness * dot(into, &[component(0), component(1)]);
            let speed = -dot(along, &[component(2), component(3)]);
            let drag = mu * press + slope * normal * speed;
            for i in 0..2 {
                out[i * width + k] = drag * along[i] - press * into[i];
            }
        }
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
                let found = -dot(direction, &dz[2..]) / h;
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
