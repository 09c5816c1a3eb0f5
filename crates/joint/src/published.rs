//! The body of the paper and its natural frequencies.

use std::sync::Arc;

use super::assembly::body_modes;
use super::{AssemblyError, BallOnBeam, Frequencies};
use crate::fem::{
    BodyMode, BodyModes, Elements, Families, FemError, Geometry, LengthReading, Material, ModeKind,
};

/// Natural frequencies from Fig. 2 of the paper, Hz.
const BENDING: [f64; 4] = [1698.0, 4093.0, 7545.0, 12448.0];
const TORSION: [f64; 2] = [4501.0, 9917.0];
const AXIAL: [f64; 1] = [9737.0];

/// Numbers of modes with natural frequencies in the paper.
pub const PUBLISHED: Families = Families {
    bending_pairs: BENDING.len(),
    torsion: TORSION.len(),
    axial: AXIAL.len(),
};

/// The dimensions in the paper, which does not state where the length of the beam ends.
fn geometry(reading: LengthReading) -> Geometry {
    Geometry {
        ball_diameter: 31.75e-3,
        beam_diameter: 20e-3,
        beam_length: 200e-3,
        reading,
    }
}

/// The steel of ball and beam.
const MATERIAL: Material = Material {
    young: 207e9,
    poisson: 0.30,
    density: 7800.0,
};

impl BallOnBeam {
    /// Whether dimensions and material are those of the body whose natural frequencies are published, with either
    /// end of the beam length.
    pub fn is_published(&self) -> bool {
        self.geometry == geometry(self.geometry.reading) && self.material == MATERIAL
    }
}

/// Natural frequencies (Hz) of the modes of a body, from the source that it selects.
///
/// # Errors
/// If the modes of the published body cannot be computed, or the frequency of a mode is not published.
pub(super) fn natural_frequencies(
    body: &BallOnBeam,
    modes: &[BodyMode],
) -> Result<Vec<f64>, AssemblyError> {
    let reference = match body.frequencies {
        Frequencies::Scaled if !body.is_published() => Some(published_body(body)?),
        _ => None,
    };
    let reference = reference.as_deref().map_or(&[][..], BodyModes::modes);
    let frequency = |mode: &BodyMode| {
        if body.frequencies == Frequencies::FiniteElement {
            return Ok(mode.frequency_hz);
        }
        let family = match mode.kind {
            ModeKind::BendingX | ModeKind::BendingY => &BENDING[..],
            ModeKind::Torsion => &TORSION,
            ModeKind::Axial => &AXIAL,
        };
        let published = family.get(mode.order - 1);
        let published = published.ok_or_else(|| AssemblyError::Unpublished(mode.label()))?;
        let same = |other: &&BodyMode| (other.kind, other.order) == (mode.kind, mode.order);
        let ratio = reference.iter().find(same);
        Ok(ratio.map_or(*published, |other| {
            published * mode.frequency_hz / other.frequency_hz
        }))
    };
    modes.iter().map(frequency).collect()
}

/// The finite-element modes of the published body, with the same end of the beam length. The default elements
/// resolve it, whatever those of the other body are.
fn published_body(body: &BallOnBeam) -> Result<Arc<BodyModes>, FemError> {
    body_modes(&BallOnBeam {
        geometry: geometry(body.geometry.reading),
        material: MATERIAL,
        elements: Elements::default(),
        ..body.clone()
    })
}
