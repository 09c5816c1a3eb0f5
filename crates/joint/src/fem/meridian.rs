//! Natural modes of an arbitrary section.

use std::f64::consts::TAU;

use super::assembly::Pencil;
use super::eigen;
use super::harmonic::DofMap;
use super::{FemError, Harmonic, Material, Section};

/// An elastic mode of a free body of revolution, given at the nodes of its section.
#[derive(Clone, Debug, PartialEq)]
pub struct MeridianMode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitudes `[U, V, W]` at the nodes, 1/sqrt(kg): `u_r = U cos(n theta)`, `u_z = W cos(n theta)`,
    /// and `u_theta = V` for torsion or `-V sin(theta)` for bending. The modal mass of the full body is
    /// 1.
    pub amplitudes: Vec<[f64; 3]>,
}

impl Section {
    /// The lowest elastic modes of one family of the free body, in ascending order, without rigid-body
    /// modes. A bending mode represents a pair of equal frequency.
    ///
    /// # Errors
    /// [`FemError::Input`], [`FemError::Memory`], [`FemError::Modes`].
    pub fn modes(
        &self,
        material: &Material,
        harmonic: Harmonic,
        count: usize,
    ) -> Result<Vec<MeridianMode>, FemError> {
        check_material(material)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let dofs = DofMap::new(self, harmonic);
        check_memory(dofs.len, count)?;
        let pencil = Pencil::assemble(self, material, harmonic, &dofs);
        let rigid: Vec<_> = harmonic
            .rigid_motions(self)
            .iter()
            .map(|motion| dofs.gather(motion))
            .collect();
        // The shift is as far below zero as the lowest eigenvalues are above it: shear waves across the
        // body.
        let shear_speed = (material.shear_modulus() / material.density).sqrt();
        let rate = shear_speed / self.diagonal();
        let pairs = eigen::lowest(&pencil, harmonic, &rigid, count, -rate * rate)?;
        let modes = pairs.into_iter().map(|(lambda, vector)| MeridianMode {
            frequency_hz: lambda.sqrt() / TAU,
            amplitudes: dofs.scatter(&vector),
        });
        Ok(modes.collect())
    }
}

/// Checks that enough memory is available. Otherwise the allocator would abort the program later.
fn check_memory(dofs: usize, modes: usize) -> Result<(), FemError> {
    /// Memory of the matrices and their factor per degree of freedom, bytes; measured at order 4.
    const MATRICES: usize = 4500;
    // Vectors of the Lanczos process, each stored with its product with the mass matrix.
    let vectors = 2 * size_of::<f64>() * (30 + 2 * modes);
    let bytes = dofs.saturating_mul(MATRICES + vectors);
    if Vec::<u8>::new().try_reserve_exact(bytes).is_ok() {
        Ok(())
    } else {
        Err(FemError::Memory {
            megabytes: bytes / 1_000_000,
        })
    }
}

/// Rejects invalid material constants.
fn check_material(material: &Material) -> Result<(), FemError> {
    let &Material {
        young,
        poisson,
        density,
    } = material;
    for (name, value) in [("Young's modulus", young), ("density", density)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(FemError::Input(format!(
                "material: {name} = {value}: must be a positive number"
            )));
        }
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        return Err(FemError::Input(format!(
            "material: Poisson's ratio = {poisson}: must lie between -1 and 0.5"
        )));
    }
    Ok(())
}
