//! Hertz contact of the ball in its socket: patch radius and pre-stress (Fig. 1b).

use super::{BallOnBeam, BodySpec, JointSpec, Socket, patch_points};

/// Hertz contact of a ball in a spherical socket.
///
/// `1/R_eff = 1/R_ball - 1/R_socket`, `a = (3 F R_eff / 4 E*)^(1/3)`, `p(s) = p0 sqrt(1 - s^2/a^2)`;
/// Johnson, Contact Mechanics, 1985, chapter 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Radius of the contact patch, m.
    pub radius: f64,
    /// Stiffness of the contact with respect to the approach of the two bodies, `dF/d(approach) = 2 E* a`, N/m.
    pub stiffness: f64,
}

impl BallOnBeam {
    /// Contact of the ball in a larger socket under a load (N, positive).
    pub fn hertz(&self, socket: &Socket, load: f64) -> Hertz {
        let ball = &self.material;
        let compliance = (1.0 - ball.poisson.powi(2)) / ball.young
            + (1.0 - socket.poisson.powi(2)) / socket.young;
        let modulus = 1.0 / compliance;
        let effective_radius = 0.5 / (1.0 / self.geometry.ball_diameter - 1.0 / socket.diameter);
        let radius = (0.75 * load * effective_radius / modulus).cbrt();
        Hertz {
            radius,
            stiffness: 2.0 * modulus * radius,
        }
    }
}

impl JointSpec {
    /// Half-angle of the Hertz patch under a load (N), rad: the theory holds for small ones. `None` for a patch with another
    /// pressure.
    pub fn hertz_half_angle(&self, load: f64) -> Option<f64> {
        match &self.body {
            BodySpec::BallOnBeam(body) if self.pressure.is_none() => {
                let radius = self.contact.radius_factor * body.hertz(&self.socket, load).radius;
                let sine = radius / (0.5 * body.geometry.ball_diameter);
                Some(sine.min(1.0).asin())
            }
            _ => None,
        }
    }

    /// Share of the load that the normal forces of a Hertz patch with a half-angle (rad) do not carry: the theory lets them
    /// act along the load, and on the ball they act along its normals.
    pub fn lost_load(&self, half_angle: f64) -> f64 {
        let points = patch_points(self.contact.quadrature, self.contact.nodes);
        let carried = points.iter().map(|point| {
            let sine = point.radius * half_angle.sin();
            point.load * (1.0 - sine * sine).sqrt()
        });
        1.0 - carried.sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frequencies;
    use crate::fem::{Elements, Geometry, LengthReading, Material};
    use crate::published::PUBLISHED;

    /// Ball and socket of the paper under a load (N).
    fn paper(load: f64) -> Hertz {
        let body = BallOnBeam {
            geometry: Geometry {
                ball_diameter: 31.75e-3,
                beam_diameter: 20e-3,
                beam_length: 0.2,
                reading: LengthReading::ToSphere,
            },
            material: Material {
                young: 207e9,
                poisson: 0.30,
                density: 7800.0,
            },
            elements: Elements::default(),
            families: PUBLISHED,
            frequencies: Frequencies::Published,
        };
        let socket = Socket {
            diameter: 31.95e-3,
            young: 70e9,
            poisson: 0.33,
        };
        body.hertz(&socket, load)
    }

    /// Approach of ball and socket, m: the square of the radius over the effective radius.
    fn approach(load: f64) -> f64 {
        paper(load).radius.powi(2) * 2.0 * (1.0 / 31.75e-3 - 1.0 / 31.95e-3)
    }

    /// Values of the paper's joint to five digits.
    #[test]
    fn paper_values() {
        let hertz = paper(150.0);
        let close = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 5e-6, "{got} {want}");
        close(hertz.radius, 1.69690e-3);
        close(approach(150.0), 1.13542e-6);
        close(hertz.stiffness, 1.98165e8);
        let per_area = hertz.stiffness / (std::f64::consts::PI * hertz.radius.powi(2));
        close(per_area, 2.19061e13);
        let half_angle = (hertz.radius / (0.5 * 31.75e-3)).asin().to_degrees();
        assert!((half_angle - 6.1361).abs() < 0.5e-4, "{half_angle}");
    }

    /// The stiffness is the derivative of the load with respect to the approach.
    #[test]
    fn consistent() {
        let slope = 2e-3 / (approach(150.001) - approach(149.999));
        assert!((slope / paper(150.0).stiffness - 1.0).abs() < 1e-6);
    }
}
