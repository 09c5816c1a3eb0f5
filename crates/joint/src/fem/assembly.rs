//! Stiffness and mass matrices of a section, assembled in sparse symmetric form.
//!
//! The stiffness of an element is computed as `S^T S`, where `S` contains the square root of the
//! elasticity matrix times the strains at all quadrature points. This is symmetric and positive
//! semidefinite by construction, and a single dense product. The mass is computed in the same way.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Accum, Col, Mat, Par};

use super::element::{QuadraturePoint, quadrature};
use super::harmonic::{DofMap, Harmonic, STRAINS, ShapeFunction, StiffnessRoot};
use super::{Material, Section};

/// Stiffness `K` (N/m) and consistent mass `M` (kg) of the full three-dimensional body, including the
/// angular integrals: lower triangles.
#[derive(Clone, Debug)]
pub(super) struct Pencil {
    pub(super) stiffness: SparseColMat<usize, f64>,
    pub(super) mass: SparseColMat<usize, f64>,
}

impl Pencil {
    /// Assembles the matrices of one family. If two degrees of freedom of an element share a number, their rows and columns
    /// are summed, which enforces the constraint between them.
    pub(super) fn assemble(
        section: &Section,
        material: &Material,
        harmonic: Harmonic,
        dofs: &DofMap,
    ) -> Self {
        let amplitudes = harmonic.amplitudes();
        let numbered = |element: &[usize]| -> Vec<(usize, usize)> {
            let slots = element
                .iter()
                .flat_map(|&node| amplitudes.iter().map(move |&a| (node, a)));
            let numbers = slots
                .map(|(node, amplitude)| dofs.of(node, amplitude))
                .enumerate();
            numbers
                .filter_map(|(slot, number)| Some((slot, number?)))
                .collect()
        };
        let numbers: Vec<_> = section.elements().map(numbered).collect();
        let pattern = pattern(&numbers, dofs.len);
        let mut stiffness = vec![0.0; pattern.row_idx().len()];
        let mut mass = stiffness.clone();
        let mut kernel = Kernel::new(material, harmonic, section.order);
        let stride = amplitudes.len();
        for (element, numbers) in section.elements().zip(&numbers) {
            let nodes: Vec<_> = element.iter().map(|&node| section.nodes[node]).collect();
            kernel.integrate(&nodes);
            for &(b, column) in numbers {
                let start = pattern.col_ptr()[column];
                let rows = pattern.row_idx_of_col_raw(column);
                for &(a, row) in numbers.iter().filter(|(_, row)| *row >= column) {
                    let entry = start + rows.partition_point(|&r| r < row);
                    let [low, high] = [a.min(b), a.max(b)];
                    stiffness[entry] += kernel.stiffness[(high, low)];
                    if a % stride == b % stride {
                        mass[entry] += kernel.mass[(high / stride, low / stride)];
                    }
                }
            }
        }
        Self {
            stiffness: SparseColMat::new(pattern.clone(), stiffness),
            mass: SparseColMat::new(pattern, mass),
        }
    }
}

/// The product of a symmetric matrix, given by its lower triangle, and a vector.
pub(super) fn symmetric_product(lower: &SparseColMat<usize, f64>, x: &Col<f64>) -> Col<f64> {
    let mut product = lower * x + lower.transpose() * x;
    for (column, x) in x.iter().enumerate() {
        // The diagonal is the first entry of its column.
        product[column] -= lower.val_of_col(column)[0] * x;
    }
    product
}

/// The pattern of the lower triangle: two of `len` degrees of freedom are coupled if they share an element. Elements are given by the
/// numbers of their degrees of freedom.
fn pattern(elements: &[Vec<(usize, usize)>], len: usize) -> SymbolicSparseColMat<usize> {
    let mut touching = vec![Vec::new(); len];
    for (e, numbers) in elements.iter().enumerate() {
        for &(_, number) in numbers {
            touching[number].push(e);
        }
    }
    let (mut starts, mut rows) = (vec![0], Vec::new());
    let mut seen_in = vec![usize::MAX; len];
    for (column, touching) in touching.iter().enumerate() {
        let start = rows.len();
        for &(_, row) in touching.iter().flat_map(|&e| &elements[e]) {
            if row >= column && seen_in[row] != column {
                seen_in[row] = column;
                rows.push(row);
            }
        }
        rows[start..].sort_unstable();
        starts.push(rows.len());
    }
    SymbolicSparseColMat::new_checked(len, len, starts, None, rows)
}

/// Element integration with reusable matrices.
struct Kernel {
    harmonic: Harmonic,
    root: StiffnessRoot,
    density: f64,
    points: Vec<QuadraturePoint>,
    /// `S`: one row per strain and quadrature point, one column per degree of freedom.
    strain: Mat<f64>,
    /// The same for the mass: one row per quadrature point, one column per node.
    inertia: Mat<f64>,
    /// Lower triangle of the element stiffness.
    stiffness: Mat<f64>,
    /// Lower triangle of the element mass, identical for each amplitude.
    mass: Mat<f64>,
}

impl Kernel {
    fn new(material: &Material, harmonic: Harmonic, order: usize) -> Self {
        let points = quadrature(order);
        let nodes = (order + 1).pow(2);
        let columns = nodes * harmonic.amplitudes().len();
        Self {
            harmonic,
            root: material.stiffness_root(),
            density: material.density,
            strain: Mat::zeros(STRAINS * points.len(), columns),
            inertia: Mat::zeros(points.len(), nodes),
            stiffness: Mat::zeros(columns, columns),
            mass: Mat::zeros(nodes, nodes),
            points,
        }
    }

    /// Integrates the element with nodes at the given `(r, z)`.
    fn integrate(&mut self, nodes: &[[f64; 2]]) {
        let amplitudes = self.harmonic.amplitudes();
        let angular_integral = self.harmonic.angular_integral();
        for (q, point) in self.points.iter().enumerate() {
            let mapped = MappedPoint::of(point, nodes);
            let volume = angular_integral * mapped.radius * mapped.determinant * point.weight;
            let root = volume.sqrt();
            let inertia = (self.density * volume).sqrt();
            for node in 0..nodes.len() {
                let shape = mapped.shape_function(point, node);
                self.inertia[(q, node)] = inertia * shape.value;
                for (slot, &amplitude) in amplitudes.iter().enumerate() {
                    let strain = self.harmonic.strain(amplitude, shape, mapped.radius);
                    let column = self.strain.col_mut(node * amplitudes.len() + slot);
                    let rows = column.subrows_mut(q * STRAINS, STRAINS);
                    for (entry, value) in rows.iter_mut().zip(self.root.times(strain)) {
                        *entry = root * value;
                    }
                }
            }
        }
        lower_gram(&mut self.stiffness, &self.strain);
        lower_gram(&mut self.mass, &self.inertia);
    }
}

/// Writes the lower triangle of `S^T S`.
fn lower_gram(out: &mut Mat<f64>, factor: &Mat<f64>) {
    triangular::matmul(
        out.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        factor.transpose(),
        BlockStructure::Rectangular,
        factor.as_ref(),
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}

/// The isoparametric map at one quadrature point.
struct MappedPoint {
    radius: f64,
    /// Rows: derivatives of `(r, z)` with respect to the first and the second local coordinate.
    jacobian: [[f64; 2]; 2],
    determinant: f64,
}

impl MappedPoint {
    fn of(point: &QuadraturePoint, nodes: &[[f64; 2]]) -> Self {
        let mut radius = 0.0;
        let mut jacobian = [[0.0; 2]; 2];
        for (k, node) in nodes.iter().enumerate() {
            radius += point.value[k] * node[0];
            for axis in 0..2 {
                jacobian[0][axis] += point.d_xi[k] * node[axis];
                jacobian[1][axis] += point.d_eta[k] * node[axis];
            }
        }
        let [[r_xi, z_xi], [r_eta, z_eta]] = jacobian;
        Self {
            radius,
            jacobian,
            determinant: r_xi * z_eta - z_xi * r_eta,
        }
    }

    fn shape_function(&self, point: &QuadraturePoint, node: usize) -> ShapeFunction {
        let [[r_xi, z_xi], [r_eta, z_eta]] = self.jacobian;
        let [d_xi, d_eta] = [point.d_xi[node], point.d_eta[node]];
        ShapeFunction {
            value: point.value[node],
            d_r: (z_eta * d_xi - z_xi * d_eta) / self.determinant,
            d_z: (r_xi * d_eta - r_eta * d_xi) / self.determinant,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Elements;
    use crate::fem::tests::elements;
    use std::f64::consts::PI;

    const STEEL: Material = Material {
        young: 207e9,
        poisson: 0.3,
        density: 7800.0,
    };

    fn pencil(section: &Section, harmonic: Harmonic) -> (Pencil, DofMap) {
        let dofs = DofMap::new(section, harmonic);
        let pencil = Pencil::assemble(section, &STEEL, harmonic, &dofs);
        (pencil, dofs)
    }

    /// Bodies of straight and of curved elements, of every order.
    fn sections() -> impl Iterator<Item = Section> {
        Elements::ORDERS.flat_map(|order| {
            let elements = elements(0.01, order);
            [
                Section::rod(0.02, 0.1, &elements).unwrap(),
                Section::sphere(0.03, &elements).unwrap(),
            ]
        })
    }

    #[test]
    fn rigid_motions_have_no_stiffness() {
        for section in sections() {
            for harmonic in [Harmonic::Torsion, Harmonic::Axial, Harmonic::Bending] {
                let (pencil, dofs) = pencil(&section, harmonic);
                let scale = pencil
                    .stiffness
                    .val()
                    .iter()
                    .fold(0.0_f64, |a, b| a.max(b.abs()));
                for motion in harmonic.rigid_motions(&section) {
                    let x = dofs.gather(&motion);
                    let size = x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                    for force in symmetric_product(&pencil.stiffness, &x).iter() {
                        let order = section.order;
                        assert!(
                            force.abs() < 1e-12 * scale * size,
                            "{harmonic}, order {order}: {force:e}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn rigid_motions_have_the_mass_properties_of_the_body() {
        let [diameter, length] = [0.02, 0.2];
        let mass = 7800.0 * PI * 1e-4 * length;
        let polar_inertia = mass * 1e-4 / 2.0;
        // About the end of the rod, the origin: m (R^2 / 4 + L^2 / 3).
        let transverse_inertia = mass * (1e-4 / 4.0 + length * length / 3.0);
        let inertia = [
            (Harmonic::Torsion, vec![polar_inertia]),
            (Harmonic::Axial, vec![mass]),
            (Harmonic::Bending, vec![mass, transverse_inertia]),
        ];
        for order in Elements::ORDERS {
            let section = Section::rod(diameter, length, &elements(0.01, order)).unwrap();
            for (harmonic, exact) in &inertia {
                let (pencil, dofs) = pencil(&section, *harmonic);
                for (motion, exact) in harmonic.rigid_motions(&section).iter().zip(exact) {
                    let x = dofs.gather(motion);
                    let energy = x.transpose() * symmetric_product(&pencil.mass, &x);
                    assert!(
                        (energy / exact - 1.0).abs() < 1e-13,
                        "{harmonic}, order {order}: {energy}"
                    );
                }
            }
        }
    }

    #[test]
    fn constant_strain_satisfies_the_patch_test() {
        // The patch test. Extension: u_z = z, u_r = -nu r is uniaxial stress, energy E V / 2. Shear: u_x
        // = z, energy G V / 2.
        let extension: fn([f64; 2]) -> [f64; 3] = |[r, z]| [-0.3 * r, 0.0, z];
        let shear: fn([f64; 2]) -> [f64; 3] = |[_, z]| [z, z, 0.0];
        for section in sections() {
            for (harmonic, field, modulus) in [
                (Harmonic::Axial, extension, STEEL.young),
                (Harmonic::Bending, shear, STEEL.shear_modulus()),
            ] {
                let (pencil, dofs) = pencil(&section, harmonic);
                let field: Vec<[f64; 3]> = section.nodes.iter().copied().map(field).collect();
                let x = dofs.gather(&field);
                let twice = x.transpose() * symmetric_product(&pencil.stiffness, &x);
                // The volume of the mesh: coarse elements do not fill a sphere.
                let along = dofs.gather(&harmonic.rigid_motions(&section)[0]);
                let volume =
                    along.transpose() * symmetric_product(&pencil.mass, &along) / STEEL.density;
                let error = (twice / (modulus * volume) - 1.0).abs();
                let order = section.order;
                assert!(error < 1e-11, "{harmonic}, order {order}: {error:e}");
            }
        }
    }
}
