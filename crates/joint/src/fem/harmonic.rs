//! Fourier harmonics in the circumferential angle: displacement, strain and the conditions on the axis.
//!
//! A mode of a body of revolution has one circumferential order `n`. With the meridian amplitudes `U, V,
//! W (r, z)` the displacement is
//!
//! ```text
//! u_r = U cos(n theta)    u_theta = -V sin(n theta)    u_z = W cos(n theta)
//! ```
//!
//! or the same rotated about the axis. Only orders 0 and 1 are needed here. Order 0 splits into torsion
//! (`u_theta = V` alone) and axial motion (`U`, `W`); order 1 is bending. The sign of `V` is chosen to
//! make a translation along x `U = V = 1`. The displacement on the axis is single-valued if `U = V, W =
//! 0` for order 1, and `U = V = 0` for order 0. The numbering of the degrees of freedom enforces these
//! conditions: a vanishing amplitude has no number, and `U` and `V` of a node on the axis share one.

use std::f64::consts::{PI, TAU};

use faer::Col;

use super::{Material, ModeKind, Section};

/// A family of modes, decoupled from the other families.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum Harmonic {
    /// Order 0, circumferential displacement.
    Torsion,
    /// Order 0, radial and axial displacement.
    Axial,
    /// Order 1; each frequency belongs to a pair of orthogonal modes.
    Bending,
}

/// Number of strain components.
pub(super) const STRAINS: usize = 6;

impl Harmonic {
    /// Indices of the amplitudes `U, V, W` (0, 1, 2) that are non-zero.
    pub(super) fn amplitudes(self) -> &'static [usize] {
        match self {
            Self::Torsion => &[1],
            Self::Axial => &[0, 2],
            Self::Bending => &[0, 1, 2],
        }
    }

    /// Circumferential order `n`.
    fn order(self) -> f64 {
        if self == Self::Bending { 1.0 } else { 0.0 }
    }

    /// Integral over the angle of the squared cosine or sine factor.
    pub(super) fn angular_integral(self) -> f64 {
        if self == Self::Bending { PI } else { TAU }
    }

    /// Strains due to a unit amplitude (0, 1, 2 for `U, V, W`) times a shape function with the given
    /// value (1) and derivatives (1/m) at radius `r` (m).
    ///
    /// The order is `rr, theta theta, zz, rz, r theta, theta z`, with engineering shear strains. The
    /// factors `cos(n theta)` and `sin(n theta)` are omitted.
    pub(super) fn strain(self, amplitude: usize, shape: ShapeFunction, r: f64) -> [f64; STRAINS] {
        let ShapeFunction { value, d_r, d_z } = shape;
        let hoop = value / r;
        let n = self.order();
        match amplitude {
            0 => [d_r, hoop, 0.0, d_z, -n * hoop, 0.0],
            1 => [0.0, -n * hoop, 0.0, 0.0, hoop - d_r, -d_z],
            _ => [0.0, 0.0, d_z, d_r, 0.0, -n * hoop],
        }
    }

    /// The rigid-body motions of this family as amplitudes `[U, V, W]` at the nodes.
    pub(super) fn rigid_motions(self, section: &Section) -> Vec<Vec<[f64; 3]>> {
        let field = |motion: fn(&[f64; 2]) -> [f64; 3]| section.nodes.iter().map(motion).collect();
        match self {
            Self::Torsion => vec![field(|&[r, _]| [0.0, r, 0.0])],
            Self::Axial => vec![field(|_| [0.0, 0.0, 1.0])],
            Self::Bending => vec![field(|_| [1.0, 1.0, 0.0]), field(|&[r, z]| [z, z, -r])],
        }
    }
}

/// Value and gradient of one shape function at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeFunction {
    pub(super) value: f64,
    pub(super) d_r: f64,
    pub(super) d_z: f64,
}

impl ModeKind {
    /// Displacement `[x, y, z]` from the amplitudes `[U, V, W]` at the azimuth with the given cosine and
    /// sine.
    pub(super) fn displacement(self, [u, v, w]: [f64; 3], cos: f64, sin: f64) -> [f64; 3] {
        match self {
            Self::Torsion => [-v * sin, v * cos, 0.0],
            Self::Axial => [u * cos, u * sin, w],
            Self::BendingX => [u * cos * cos + v * sin * sin, (u - v) * cos * sin, w * cos],
            Self::BendingY => [(u - v) * cos * sin, u * sin * sin + v * cos * cos, w * sin],
        }
    }
}

impl Material {
    /// Square root `C` of the elasticity matrix, `D = C^T C` (Pa^(1/2)). The energy density is half the squared norm of `C`
    /// times the strain.
    pub(super) fn stiffness_root(&self) -> StiffnessRoot {
        let shear = self.shear_modulus();
        let bulk = self.young / (3.0 * (1.0 - 2.0 * self.poisson));
        StiffnessRoot {
            shear: shear.sqrt(),
            volume: ((3.0 * bulk).sqrt() - (2.0 * shear).sqrt()) / 3.0,
        }
    }

    /// Shear modulus, Pa.
    pub(super) fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }
}

/// The symmetric square root of the isotropic elasticity matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct StiffnessRoot {
    /// Square root of the shear modulus.
    shear: f64,
    /// Factor of the change of volume in the three normal components.
    volume: f64,
}

impl StiffnessRoot {
    /// `C` times a strain vector.
    pub(super) fn times(&self, strain: [f64; STRAINS]) -> [f64; STRAINS] {
        let [rr, tt, zz, rz, rt, tz] = strain;
        let volume = self.volume * (rr + tt + zz);
        let normal = [rr, tt, zz].map(|x| std::f64::consts::SQRT_2 * self.shear * x + volume);
        let [rz, rt, tz] = [rz, rt, tz].map(|x| self.shear * x);
        [normal[0], normal[1], normal[2], rz, rt, tz]
    }
}

/// Numbers the degrees of freedom of one family on one mesh.
#[derive(Clone, Debug)]
pub(super) struct DofMap {
    /// The number of each amplitude `U, V, W` at each node, or `None` if the amplitude vanishes.
    index: Vec<[Option<usize>; 3]>,
    /// Number of degrees of freedom.
    pub(super) len: usize,
}

impl DofMap {
    pub(super) fn new(section: &Section, harmonic: Harmonic) -> Self {
        let mut len = 0;
        let mut next = || {
            len += 1;
            Some(len - 1)
        };
        let index = section
            .nodes
            .iter()
            .map(|&[r, _]| match (harmonic, r == 0.0) {
                (Harmonic::Torsion, true) => [None; 3],
                (Harmonic::Torsion, false) => [None, next(), None],
                (Harmonic::Axial, true) => [None, None, next()],
                (Harmonic::Axial, false) => [next(), None, next()],
                (Harmonic::Bending, true) => {
                    let shared = next();
                    [shared, shared, None]
                }
                (Harmonic::Bending, false) => [next(), next(), next()],
            })
            .collect();
        Self { index, len }
    }

    /// Number of an amplitude (0, 1, 2 for `U, V, W`) at a node.
    pub(super) fn of(&self, node: usize, amplitude: usize) -> Option<usize> {
        self.index[node][amplitude]
    }

    /// Converts amplitudes at the nodes to a vector of degrees of freedom.
    pub(super) fn gather(&self, field: &[[f64; 3]]) -> Col<f64> {
        let mut vector = Col::zeros(self.len);
        let numbers = self.index.as_flattened();
        for (number, amplitude) in numbers.iter().zip(field.as_flattened()) {
            if let Some(i) = *number {
                vector[i] = *amplitude;
            }
        }
        vector
    }

    /// Converts a vector of degrees of freedom to amplitudes at the nodes.
    pub(super) fn scatter(&self, vector: &Col<f64>) -> Vec<[f64; 3]> {
        self.index
            .iter()
            .map(|numbers| numbers.map(|number| number.map_or(0.0, |i| vector[i])))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::tests::elements;

    #[test]
    fn the_stiffness_root_reproduces_hookes_law() {
        for poisson in [-0.3, 0.0, 0.3, 0.49] {
            let material = Material {
                young: 207e9,
                poisson,
                density: 7800.0,
            };
            let root = material.stiffness_root();
            let strain = [1.0, -0.4, 0.7, 0.3, -1.2, 0.5];
            let twice_energy: f64 = root.times(strain).iter().map(|x| x * x).sum();
            let shear = 207e9 / (2.0 * (1.0 + poisson));
            let lame = 207e9 * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
            let trace = 1.0 - 0.4 + 0.7;
            let exact = lame * trace * trace
                + 2.0 * shear * (1.0 + 0.16 + 0.49)
                + shear * (0.09 + 1.44 + 0.25);
            assert!((twice_energy / exact - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_sine_mode_is_the_cosine_mode_rotated_by_90_degrees() {
        let amplitudes = [0.3, -1.1, 0.7];
        for azimuth in [0.0, 0.4, 2.0, -1.3_f64] {
            let [x, y, z] =
                ModeKind::BendingX.displacement(amplitudes, azimuth.cos(), azimuth.sin());
            let rotated = azimuth + PI / 2.0;
            let copy = ModeKind::BendingY.displacement(amplitudes, rotated.cos(), rotated.sin());
            for (a, b) in copy.into_iter().zip([-y, x, z]) {
                assert!((a - b).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn scatter_inverts_gather_for_fields_that_satisfy_the_axis_conditions() {
        let section = Section::sphere(0.02, &elements(0.01, 2)).unwrap();
        for harmonic in [Harmonic::Torsion, Harmonic::Axial, Harmonic::Bending] {
            let map = DofMap::new(&section, harmonic);
            for motion in harmonic.rigid_motions(&section) {
                assert_eq!(map.scatter(&map.gather(&motion)), motion);
            }
        }
    }
}
