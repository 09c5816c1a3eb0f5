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
use super::{Elements, FemError, Geometry, LengthReading};

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
    ///
    /// # Errors
    /// [`FemError::Input`].
    pub(super) fn mesh(geometry: &Geometry, elements: &Elements) -> Result<Self, FemError> {
        let (end, corner) = heights(geometry)?;
        let radius = 0.5 * geometry.ball_diameter;
        let beam_radius = 0.5 * geometry.beam_diameter;
        check_elements(
            beam_radius * (corner - end) + std::f64::consts::FRAC_PI_2 * radius * radius,
            elements,
        )?;

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
        Ok(Self {
            side: Surface::new(&section, side.nodes, false),
            ball: Surface::new(&section, ball, true),
            section,
            end: centre,
        })
    }
}

/// Heights of the free end and of the corner between beam and sphere, relative to the centre of the ball
/// (m).
fn heights(geometry: &Geometry) -> Result<(f64, f64), FemError> {
    let Geometry {
        ball_diameter,
        beam_diameter,
        beam_length,
        reading,
    } = *geometry;
    check_positive("ball diameter", ball_diameter)?;
    check_positive("beam diameter", beam_diameter)?;
    check_positive("beam length", beam_length)?;
    if beam_diameter >= ball_diameter {
        return Err(FemError::Input(format!(
            "beam diameter = {beam_diameter} m: must be smaller than the ball's diameter"
        )));
    }
    let [ball, beam] = [0.5 * ball_diameter, 0.5 * beam_diameter];
    let corner = -((ball - beam) * (ball + beam)).sqrt();
    let end = match reading {
        LengthReading::ToSphere => corner - beam_length,
        LengthReading::ToCentre => -beam_length,
    };
    if end >= corner {
        return Err(FemError::Input(format!(
            "beam length = {beam_length} m: must exceed the distance from the centre to the corner if it is \
             measured to the centre"
        )));
    }
    Ok((end, corner))
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

/// Rejects a dimension that is not a positive number.
pub(super) fn check_positive(name: &'static str, value: f64) -> Result<(), FemError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(FemError::Input(format!(
        "{name} = {value} m: must be a positive number"
    )))
}

/// Rejects an unavailable element order, an element size that is not a positive number, and too many
/// elements.
pub(super) fn check_elements(area: f64, elements: &Elements) -> Result<(), FemError> {
    let &Elements { size, order } = elements;
    if !Elements::ORDERS.contains(&order) {
        return Err(FemError::Input(format!(
            "element order = {order}: must be a whole number from {} to {}",
            Elements::ORDERS.start(),
            Elements::ORDERS.end()
        )));
    }
    check_positive("element size", size)?;
    let count = area / (size * size);
    let limit = elements.limit();
    if count <= limit as f64 {
        return Ok(());
    }
    let smallest = (area / limit as f64).sqrt();
    Err(FemError::Input(format!(
        "element size {size} m would give about {count:.0} elements, the limit at order {order} is {limit}: use a size \
         above {smallest:.2e} m"
    )))
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
            let rod = Section::rod(0.02, 0.2, &elements(0.01, order)).unwrap();
            assert_close(volume(&rod), PI * 1e-4 * 0.2, 1e-13);
            let sphere = Section::sphere(0.03, &elements(0.005, order)).unwrap();
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
            let mesh = BallOnBeam::mesh(&geometry(reading), &elements(0.005, 4)).unwrap();
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
                volume(
                    &BallOnBeam::mesh(&slim, &elements(5e-3, order))
                        .unwrap()
                        .section,
                );
            }
        }
    }

    #[test]
    fn surface_nodes_lie_on_the_surface() {
        let mesh =
            BallOnBeam::mesh(&geometry(LengthReading::ToCentre), &elements(6e-3, 4)).unwrap();
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
    fn invalid_dimensions_are_rejected_by_name() {
        let good = geometry(LengthReading::ToCentre);
        let bad = [
            (
                "ball diameter",
                Geometry {
                    ball_diameter: -1.0,
                    ..good
                },
            ),
            (
                "beam diameter",
                Geometry {
                    beam_diameter: f64::NAN,
                    ..good
                },
            ),
            (
                "beam diameter",
                Geometry {
                    beam_diameter: 0.04,
                    ..good
                },
            ),
            (
                "beam length",
                Geometry {
                    beam_length: 0.0,
                    ..good
                },
            ),
            (
                "beam length",
                Geometry {
                    beam_length: 0.01,
                    ..good
                },
            ),
        ];
        for (name, geometry) in bad {
            let message = BallOnBeam::mesh(&geometry, &elements(0.01, 4))
                .unwrap_err()
                .to_string();
            assert!(message.contains(name), "{message}");
        }
        for size in [0.0, -1e-3, f64::INFINITY] {
            let error = BallOnBeam::mesh(&good, &elements(size, 4)).unwrap_err();
            assert!(error.to_string().contains("element size"));
        }
        let error = BallOnBeam::mesh(&good, &elements(1e-5, 4)).unwrap_err();
        assert!(
            error.to_string().contains("the limit at order 4"),
            "{error}"
        );
    }

    #[test]
    fn unavailable_orders_are_rejected_and_the_limit_decreases_with_order() {
        for order in [0, 9] {
            let error = Section::rod(0.02, 0.2, &elements(0.01, order)).unwrap_err();
            assert!(error.to_string().contains("from 1 to 8"), "{error}");
        }
        for (order, limit) in [(1, 32_000), (2, 8_000), (4, 2_000), (8, 500)] {
            // A rod with slightly more elements than the limit.
            let size = (0.01 * 0.2 / limit as f64).sqrt();
            let mesh = |size| Section::rod(0.02, 0.2, &elements(size, order));
            assert!(mesh(1.01 * size).is_ok());
            let error = mesh(0.99 * size).unwrap_err().to_string();
            assert!(
                error.contains(&format!("order {order} is {limit}")),
                "{error}"
            );
        }
    }
}
