//! The mesh of a ball on a beam.
//!
//! ```text
//!        N ___                 N north pole
//!        |    `--. D           C corner where beam and sphere meet: re-entrant, so stresses
//!        |-----/  \              are singular there and the mesh is graded towards it
//!        | core|   |           the ball has four patches: core, below, right of and above the core
//!      A |_____|__/ C
//!        |       |
//!        | beam  |
//!        |_______|
//! ```

use super::section::{Curve, Grading, Section, partition};
use super::surface::Surface;
use super::{Elements, Geometry, LengthReading};

/// The mesh of a ball on a beam, and its nodes on the free surface.
#[derive(Clone, Debug)]
pub(super) struct BallOnBeam {
    pub(super) section: Section,
    /// Centre of the free end of the beam.
    pub(super) end: usize,
    /// Lateral surface of the beam, from the free end to the corner.
    pub(super) side: Surface,
    /// Free surface of the ball, from the north pole to the corner.
    pub(super) ball: Surface,
}

impl BallOnBeam {
    /// Meshes beam and ball. The mesh is graded automatically towards the corner between them.
    pub(super) fn mesh(geometry: &Geometry, elements: &Elements) -> Self {
        let radius = 0.5 * geometry.ball_diameter;
        let beam_radius = 0.5 * geometry.beam_diameter;
        // Heights relative to the centre of the ball, m.
        let corner = -((radius - beam_radius) * (radius + beam_radius)).sqrt();
        let end = match geometry.reading {
            LengthReading::ToSphere => corner - geometry.beam_length,
            LengthReading::ToCentre => -geometry.beam_length,
        };

        let mut section = Section::new(elements.order);
        let c = section.vertex([beam_radius, corner]);
        let polar = beam_radius.atan2(corner);
        // The beam radius and the arc above the core use the same division.
        let widest = beam_radius.max(radius * polar * SHOULDER);
        let radial = partition(widest, elements, Grading::END);
        let along = partition(corner - end, elements, Grading::END);
        let centre = section.vertex([0.0, end]);
        let rim = section.vertex([beam_radius, end]);
        let a = section.vertex([0.0, corner]);
        let base = section.line(a, c, &radial);
        let side = section.line(rim, c, &along);
        let cap = section.line(centre, rim, &radial);
        let axis = section.line(centre, a, &along);
        section.patch([&cap, &side, &base, &axis]);
        let graded = (elements, Grading::START);
        let ball = ball(&mut section, radius, (&base, &radial), graded);
        Self {
            side: Surface::new(&section, side.nodes, false),
            ball: Surface::new(&section, ball, true),
            section,
            end: centre,
        }
    }
}

/// Polar angle of the point D in the sketch, as a fraction of that of the corner.
const SHOULDER: f64 = 1.0 / 3.0;
/// Size of the core as a fraction of the ball.
const CORE: f64 = 0.5;

/// Adds a ball about the origin on top of `base`, which runs from the axis to the corner and is divided
/// as `radial`. The elements are graded towards the corner, along the surface and in depth. Returns the nodes of its surface
/// from the north pole to the corner.
pub(super) fn ball(
    section: &mut Section,
    radius: f64,
    (base, radial): (&Curve, &[f64]),
    (elements, grading): (&Elements, Grading),
) -> Vec<usize> {
    let [south, corner] = [base.first(), base.last()];
    let [r, z] = section.nodes[corner];
    let polar = r.atan2(z);
    let north = section.vertex([0.0, radius]);
    let angle = polar * SHOULDER;
    let shoulder = section.vertex([radius * angle.sin(), radius * angle.cos()]);

    // The core is the outer contour scaled towards the middle of the axis.
    let middle = 0.5 * (section.nodes[south][1] + radius);
    let outer = [south, corner, shoulder, north];
    let core = outer.map(|node| {
        let [r, z] = section.nodes[node];
        section.vertex([CORE * r, middle + CORE * (z - middle)])
    });
    let depth = (1.0 - CORE) * r.hypot(z - middle);
    let layers = partition(depth, elements, grading);
    let along = partition(radius * (polar - angle), elements, grading);
    let [spoke_south, spoke_corner, spoke_shoulder, spoke_north] =
        std::array::from_fn(|k| section.line(outer[k], core[k], &layers));

    let flank = section.arc(corner, shoulder, &along);
    let crown = section.arc(north, shoulder, radial);
    let core_bottom = section.line(core[0], core[1], radial);
    let core_right = section.line(core[1], core[2], &along);
    let core_top = section.line(core[3], core[2], radial);
    let core_left = section.line(core[0], core[3], &along);

    section.patch([&core_bottom, &core_right, &core_top, &core_left]);
    section.patch([base, &spoke_corner, &core_bottom, &spoke_south]);
    section.patch([&flank, &spoke_shoulder, &core_right, &spoke_corner]);
    section.patch([
        &core_top,
        &spoke_shoulder.reversed(),
        &crown,
        &spoke_north.reversed(),
    ]);

    let mut surface = crown.nodes;
    surface.extend(flank.nodes.iter().rev().skip(1));
    surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::element::quadrature;
    use crate::fem::tests::elements;
    use std::f64::consts::PI;

    fn geometry(reading: LengthReading) -> Geometry {
        Geometry {
            ball_diameter: 31.75e-3,
            beam_diameter: 20e-3,
            beam_length: 0.2,
            reading,
        }
    }

    /// Volume of the body of revolution; panics if an element is inverted.
    fn volume(section: &Section) -> f64 {
        let mut volume = 0.0;
        for element in section.elements() {
            for point in quadrature(section.order) {
                let mut r = 0.0;
                let mut jacobian = [[0.0; 2]; 2];
                for (k, &node) in element.iter().enumerate() {
                    let position = section.nodes[node];
                    r += point.value[k] * position[0];
                    for x in 0..2 {
                        jacobian[0][x] += point.d_xi[k] * position[x];
                        jacobian[1][x] += point.d_eta[k] * position[x];
                    }
                }
                let det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
                assert!(det > 0.0, "inverted element at r = {r}");
                volume += 2.0 * PI * r * det * point.weight;
            }
        }
        volume
    }

    fn assert_close(value: f64, exact: f64, tolerance: f64) {
        let error = (value / exact - 1.0).abs();
        assert!(error < tolerance, "{value} against {exact}: {error:e}");
    }

    #[test]
    fn mesh_volumes_agree_with_the_bodies() {
        for order in Elements::ORDERS {
            let rod = Section::rod(0.02, 0.2, &elements(0.01, order));
            assert_close(volume(&rod), PI * 1e-4 * 0.2, 1e-13);
            let sphere = Section::sphere(0.03, &elements(0.005, order));
            // The volume error of the polynomial approximation of the arc.
            let gap = [6e-2, 2e-4, 3e-6, 1e-9].get(order - 1).unwrap_or(&1e-11);
            assert_close(volume(&sphere), PI / 6.0 * 0.03_f64.powi(3), *gap);
        }
        // Cylinder plus the ball without the cap inside the beam.
        let [ball, beam, length] = [15.875e-3_f64, 10e-3_f64, 0.2];
        let height = (ball * ball - beam * beam).sqrt();
        let cap = ball - height;
        let head = 4.0 / 3.0 * PI * ball.powi(3) - PI * cap * cap * (ball - cap / 3.0);
        for (reading, free) in [
            (LengthReading::ToSphere, length),
            (LengthReading::ToCentre, length - height),
        ] {
            let mesh = BallOnBeam::mesh(&geometry(reading), &elements(0.005, 4));
            let mesh = mesh.section;
            assert_close(volume(&mesh), PI * beam * beam * free + head, 1e-9);
        }
    }

    #[test]
    fn slender_and_thick_beams_can_be_meshed() {
        for beam_diameter in [1e-3, 31e-3] {
            let slim = Geometry {
                beam_diameter,
                ..geometry(LengthReading::ToSphere)
            };
            for order in Elements::ORDERS {
                volume(&BallOnBeam::mesh(&slim, &elements(5e-3, order)).section);
            }
        }
    }

    #[test]
    fn surface_nodes_lie_on_the_surface() {
        let mesh = BallOnBeam::mesh(&geometry(LengthReading::ToCentre), &elements(6e-3, 4));
        for &node in &mesh.ball.nodes {
            let [r, z] = mesh.section.nodes[node];
            assert!((r.hypot(z) - 15.875e-3).abs() < 1e-16);
        }
        for &node in &mesh.side.nodes {
            assert_eq!(mesh.section.nodes[node][0], 10e-3);
        }
        assert_eq!(mesh.section.nodes[mesh.end], [0.0, -0.2]);
        assert_eq!(mesh.section.nodes[mesh.ball.nodes[0]], [0.0, 15.875e-3]);
        assert_eq!(mesh.ball.nodes.last(), mesh.side.nodes.last());
    }

    #[test]
    fn the_limit_decreases_with_order() {
        for (order, limit) in [(1, 32_000), (2, 8_000), (4, 2_000), (8, 500)] {
            assert_eq!(elements(0.01, order).limit(), limit);
        }
    }
}
