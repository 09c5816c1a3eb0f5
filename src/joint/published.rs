//! The body of the paper and its natural frequencies.

use super::{BallOnBeam, Frequencies};
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
const GEOMETRY: Geometry = Geometry {
    ball_diameter: 31.75e-3,
    beam_diameter: 20e-3,
    beam_length: 200e-3,
    reading: LengthReading::ToSphere,
};

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
        let reading = self.geometry.reading;
        let published = Geometry {
            reading,
            ..GEOMETRY
        };
        self.geometry == published && self.material == MATERIAL
    }
}

/// Natural frequencies (Hz) of the modes of a body, from the source that it selects. The error is the first mode
/// whose frequency is not published.
///
/// # Errors
/// [`FemError`] if the modes of the published body cannot be computed.
pub(super) fn natural_frequencies(
    body: &BallOnBeam,
    modes: &[BodyMode],
) -> Result<Result<Vec<f64>, String>, FemError> {
    let reference = match body.frequencies {
        Frequencies::Scaled if !body.is_published() => Some(published_body(body)?),
        _ => None,
    };
    let reference = reference.as_ref().map_or(&[][..], BodyModes::modes);
    let frequency = |mode: &BodyMode| {
        if body.frequencies == Frequencies::FiniteElement {
            return Ok(mode.frequency_hz);
        }
        let published = published_hz(mode).ok_or_else(|| mode.label())?;
        let same = |other: &&BodyMode| (other.kind, other.order) == (mode.kind, mode.order);
        let ratio = reference.iter().find(same);
        Ok(ratio.map_or(published, |other| {
            published * mode.frequency_hz / other.frequency_hz
        }))
    };
    Ok(modes.iter().map(frequency).collect())
}

/// The published frequency of a mode, Hz; `None` if the paper has none.
fn published_hz(mode: &BodyMode) -> Option<f64> {
    let family = match mode.kind {
        ModeKind::BendingX | ModeKind::BendingY => &BENDING[..],
        ModeKind::Torsion => &TORSION,
        ModeKind::Axial => &AXIAL,
    };
    family.get(mode.order - 1).copied()
}

/// The finite-element modes of the published body, with the same end of the beam length. The default elements
/// resolve it, whatever those of the other body are.
fn published_body(body: &BallOnBeam) -> Result<BodyModes, FemError> {
    let geometry = Geometry {
        reading: body.geometry.reading,
        ..GEOMETRY
    };
    BodyModes::solve(&geometry, &MATERIAL, &Elements::default(), &body.families)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use crate::joint::BallJoint;
    use crate::scene::Scene;

    /// Natural frequencies of a body with the given lines by the names of the modes, from a source. The order of the
    /// modes depends on the body.
    fn frequencies(lines: &str, source: &str) -> BTreeMap<String, f64> {
        let text = format!(
            "{lines}\nbody.frequencies = \"{source}\"\nload = {{ load_n = 150, tilt_deg = 2 }}\n\
             time.duration_ms = 10\n"
        );
        let scene = Scene::parse("mine.toml", text).unwrap_or_else(|error| panic!("{error}"));
        let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
        let labels = ball.mode_labels().into_iter();
        labels.zip(ball.frequencies_hz().iter().copied()).collect()
    }

    #[test]
    fn scaled_frequencies_of_the_published_body_are_the_published_ones() {
        for lines in [
            "",
            "body.beam_length_to = \"centre\"",
            "body.element_size_mm = 5",
        ] {
            assert_eq!(
                frequencies(lines, "scaled"),
                frequencies(lines, "published"),
                "{lines}"
            );
        }
    }

    /// The ratio of scaled to published frequencies is that of the finite-element frequencies of the two bodies. A
    /// softer material scales all of them with the root of Young's modulus.
    #[test]
    fn scaled_frequencies_follow_the_finite_element_model() {
        let published = frequencies("", "published");
        let of_published_body = frequencies("", "fe");
        for lines in ["body.beam_length_mm = 240", "body.youngs_modulus_gpa = 70"] {
            let [scaled, own] = ["scaled", "fe"].map(|source| frequencies(lines, source));
            for (mode, &hz) in &published {
                let [ratio, expected] = [scaled[mode] / hz, own[mode] / of_published_body[mode]];
                assert!((ratio / expected - 1.0).abs() < 1e-12, "{lines}, {mode}");
                assert!(ratio < 0.95, "{lines}, {mode}: {ratio}");
                if lines.contains("young") {
                    let root = (70.0_f64 / 207.0).sqrt();
                    assert!((ratio / root - 1.0).abs() < 1e-8, "{mode}: {ratio}");
                }
            }
        }
    }
}
