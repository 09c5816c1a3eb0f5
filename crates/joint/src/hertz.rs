//! Hertz contact of the ball in its socket: patch radius and pre-stress (Fig. 1b).

use super::{BallOnBeam, BodySpec, JointSpec, Socket, patch_points};
use crate::fem::Material;

/// Hertz contact of a ball in a spherical socket.
///
/// `1/R_eff = 1/R_ball - 1/R_socket`, `a = (3 F R_eff / 4 E*)^(1/3)`, `p(s) = p0 sqrt(1 - s^2/a^2)`;
/// Johnson, Contact Mechanics, 1985, chapter 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Effective modulus `E*`, Pa.
    pub modulus: f64,
    /// Effective radius, m.
    pub effective_radius: f64,
    /// Radius of the contact patch, m.
    pub radius: f64,
    /// Maximum pressure, Pa.
    pub peak_pressure: f64,
    /// Approach of the two bodies, m.
    pub approach: f64,
}

impl Hertz {
    /// Contact of a ball of diameter `ball_diameter` (m) and material `ball` in `socket` under
    /// `load` (N). The socket must be larger than the ball, the load positive.
    pub fn new(ball_diameter: f64, ball: &Material, socket: &Socket, load: f64) -> Self {
        let compliance = (1.0 - ball.poisson.powi(2)) / ball.young
            + (1.0 - socket.poisson.powi(2)) / socket.young;
        let modulus = 1.0 / compliance;
        let effective_radius = 0.5 / (1.0 / ball_diameter - 1.0 / socket.diameter);
        let radius = (0.75 * load * effective_radius / modulus).cbrt();
        Self {
            modulus,
            effective_radius,
            radius,
            peak_pressure: 1.5 * load / (std::f64::consts::PI * radius * radius),
            approach: radius * radius / effective_radius,
        }
    }

    /// Stiffness of the contact with respect to the approach, `dF/d(approach) = 2 E* a`, N/m.
    pub fn stiffness(&self) -> f64 {
        2.0 * self.modulus * self.radius
    }
}

impl BallOnBeam {
    /// Contact of the ball in a socket under a load (N, positive).
    pub(crate) fn hertz(&self, socket: &Socket, load: f64) -> Hertz {
        Hertz::new(self.geometry.ball_diameter, &self.material, socket, load)
    }
}

impl JointSpec {
    /// Half-angle of the Hertz patch under a load (N), rad: the theory holds for small ones. `None` for a patch with another
    /// pressure.
    pub fn hertz_half_angle(&self, load: f64) -> Option<f64> {
        match &self.body {
            BodySpec::BallOnBeam(body) if self.pressure.is_none() => {
                let radius = self.contact.radius_factor * body.hertz(&self.socket, load).radius;
                Some(
                    (radius / (0.5 * body.geometry.ball_diameter))
                        .min(1.0)
                        .asin(),
                )
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

    /// Ball and socket of the paper under a load (N).
    fn paper(load: f64) -> Hertz {
        let steel = Material {
            young: 207e9,
            poisson: 0.30,
            density: 7800.0,
        };
        let socket = Socket {
            diameter: 31.95e-3,
            young: 70e9,
            poisson: 0.33,
        };
        Hertz::new(31.75e-3, &steel, &socket, load)
    }

    /// Values of the paper's joint to five digits.
    #[test]
    fn paper_values() {
        let hertz = paper(150.0);
        let close = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 5e-6, "{got} {want}");
        close(hertz.radius, 1.69690e-3);
        close(hertz.peak_pressure, 24.8726e6);
        close(hertz.approach, 1.13542e-6);
        close(hertz.stiffness(), 1.98165e8);
        let per_area = hertz.stiffness() / (std::f64::consts::PI * hertz.radius.powi(2));
        close(per_area, 2.19061e13);
        let half_angle = (hertz.radius / (0.5 * 31.75e-3)).asin().to_degrees();
        assert!((half_angle - 6.1361).abs() < 0.5e-4, "{half_angle}");
    }

    /// The pressure integrates to the load, and the stiffness is the derivative of load with respect to
    /// approach.
    #[test]
    fn consistent() {
        let hertz = paper(150.0);
        let volume = 2.0 / 3.0 * std::f64::consts::PI * hertz.radius.powi(2) * hertz.peak_pressure;
        assert!((volume / 150.0 - 1.0).abs() < 1e-14);
        let slope = 2e-3 / (paper(150.001).approach - paper(149.999).approach);
        assert!((slope / hertz.stiffness() - 1.0).abs() < 1e-6);
    }
}
