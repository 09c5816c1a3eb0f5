//! From the parameters of a joint to its contact model at any tilt.

use super::patch::{PatchPoint, normal_at, patch_direction, patch_points};
use super::vector::{any_normal, cross, dot, scale, unit};
use super::{Frequencies, Hertz, Joint, JointSpec, Model, StiffnessLaw};
use crate::fem::{BodyModes, Families, FemError, ModeKind};

/// Fig. 2 of the paper: natural frequencies, Hz.
const PUBLISHED_BENDING: [f64; 4] = [1698.0, 4093.0, 7545.0, 12448.0];
const PUBLISHED_TORSION: [f64; 2] = [4501.0, 9917.0];
const PUBLISHED_AXIAL: [f64; 1] = [9737.0];

/// The modes whose natural frequencies the paper publishes.
pub const PUBLISHED: Families = Families {
    bending_pairs: PUBLISHED_BENDING.len(),
    torsion: PUBLISHED_TORSION.len(),
    axial: PUBLISHED_AXIAL.len(),
};

/// Why a joint cannot be assembled.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// The body's modes could not be found.
    #[error("the modes of ball and beam cannot be computed")]
    Body(#[from] FemError),
    /// A mode was asked for that the paper gives no frequency for.
    #[error(
        "the paper publishes no frequency for the mode `{label}`: ask for at most four bending \
         pairs, two torsion modes and one axial mode, or use the finite-element frequencies"
    )]
    Unpublished {
        /// The mode.
        label: String,
    },
    /// The patch reaches into the beam's footprint on the ball, where there is no surface.
    #[error(
        "at a tilt of {tilt_deg:.3} deg the contact patch (half-angle {half_angle_deg:.2} deg) \
         reaches the beam; reduce the tilt, the load or the patch radius"
    )]
    PatchOnBeam {
        /// The tilt, degrees.
        tilt_deg: f64,
        /// Half-angle of the patch, degrees.
        half_angle_deg: f64,
        /// What the shape evaluation said.
        source: FemError,
    },
}

/// A ball joint whose tilt is still open: modes and quadrature are fixed. Another load or rotation costs
/// next to nothing, since neither reaches into the body.
#[derive(Clone, Debug)]
pub struct BallJoint {
    spec: JointSpec,
    body: BodyModes,
    frequencies_hz: Vec<f64>,
    hertz: Hertz,
    points: Vec<PatchPoint>,
}

impl BallJoint {
    /// Computes the modes and lays out the patch.
    ///
    /// # Errors
    /// If the modes cannot be found, or have no published frequency though these are asked for.
    pub fn new(spec: &JointSpec) -> Result<Self, AssemblyError> {
        let body = &spec.body;
        let modes = BodyModes::solve(
            &body.geometry,
            &body.material,
            &body.elements,
            &body.families,
        )?;
        Self::on_body(modes, spec)
    }

    /// A joint with other parameters. The modes are computed anew only where the body differs.
    ///
    /// # Errors
    /// As [`BallJoint::new`].
    pub fn with_spec(self, spec: &JointSpec) -> Result<Self, AssemblyError> {
        if self.spec.body == spec.body {
            Self::on_body(self.body, spec)
        } else {
            Self::new(spec)
        }
    }

    /// Lays out the patch on a body whose modes are known.
    fn on_body(modes: BodyModes, spec: &JointSpec) -> Result<Self, AssemblyError> {
        let body = &spec.body;
        let frequencies_hz = modes
            .modes()
            .iter()
            .map(|mode| {
                let published = match mode.kind {
                    ModeKind::BendingX | ModeKind::BendingY => {
                        PUBLISHED_BENDING.get(mode.order - 1)
                    }
                    ModeKind::Torsion => PUBLISHED_TORSION.get(mode.order - 1),
                    ModeKind::Axial => PUBLISHED_AXIAL.get(mode.order - 1),
                };
                match (&body.frequencies, published) {
                    (Frequencies::FiniteElement, _) => Ok(mode.frequency_hz),
                    (Frequencies::Published, Some(&hz)) => Ok(hz),
                    (Frequencies::Published, None) => Err(AssemblyError::Unpublished {
                        label: mode.label(),
                    }),
                }
            })
            .collect::<Result<Vec<_>, _>>()?;
        let hertz = hertz_of(spec);
        let points = patch_points(spec.contact.quadrature, spec.contact.nodes);
        Ok(Self {
            spec: spec.clone(),
            body: modes,
            frequencies_hz,
            hertz,
            points,
        })
    }

    /// Presses the ball with another load (N, positive): the patch grows and shrinks with it.
    pub fn set_load(&mut self, load: f64) {
        self.spec.load = load;
        self.hertz = hertz_of(&self.spec);
    }

    /// Turns the ball with another rotation vector, rad/s.
    pub fn set_rotation(&mut self, rotation: [f64; 3]) {
        self.spec.rotation = rotation;
    }

    /// The parameters.
    pub fn spec(&self) -> &JointSpec {
        &self.spec
    }

    /// The modes of ball and beam.
    pub fn body(&self) -> &BodyModes {
        &self.body
    }

    /// The natural frequencies in use, Hz, in the order of the modal coordinates.
    pub fn frequencies_hz(&self) -> &[f64] {
        &self.frequencies_hz
    }

    /// The Hertz contact.
    pub fn hertz(&self) -> &Hertz {
        &self.hertz
    }

    /// Radius of the contact patch, m: Hertz times the scene's factor.
    pub fn patch_radius(&self) -> f64 {
        self.hertz.radius * self.spec.contact.radius_factor
    }

    /// Radius of the ball, m.
    pub fn ball_radius(&self) -> f64 {
        0.5 * self.spec.body.geometry.ball_diameter
    }

    /// Unit vector from the ball's centre to the centre of the patch at a tilt (rad).
    pub fn direction(&self, tilt: f64) -> [f64; 3] {
        patch_direction(tilt, self.spec.azimuth)
    }

    /// Velocity of steady sliding at the centre of the patch, m/s.
    pub fn sliding_velocity(&self, tilt: f64) -> [f64; 3] {
        cross(
            self.spec.rotation,
            scale(self.direction(tilt), self.ball_radius()),
        )
    }

    /// The contact model with the load tilted by `tilt` (rad).
    ///
    /// # Errors
    /// If the patch reaches into the beam.
    pub fn model(&self, tilt: f64) -> Result<Model, AssemblyError> {
        let (ball_radius, radius) = (self.ball_radius(), self.patch_radius());
        let direction = self.direction(tilt);
        let m = self.frequencies_hz.len();
        let on_beam = |source| AssemblyError::PatchOnBeam {
            tilt_deg: tilt.to_degrees(),
            half_angle_deg: (radius / ball_radius).min(1.0).asin().to_degrees(),
            source,
        };
        let patch_area = std::f64::consts::PI * radius * radius;
        let normals: Vec<_> = self
            .points
            .iter()
            .map(|point| normal_at(point, direction, self.spec.azimuth, radius, ball_radius))
            .collect();
        let mut shapes = vec![[0.0; 3]; self.points.len() * m];
        for (normal, row) in normals.iter().zip(shapes.chunks_exact_mut(m.max(1))) {
            self.body.shapes_at_ball(*normal, row).map_err(on_beam)?;
        }
        let areas: Vec<f64> = self
            .points
            .iter()
            .map(|point| point.area * patch_area)
            .collect();
        let pre_stress: Vec<f64> = self
            .points
            .iter()
            .zip(&areas)
            .map(|(point, area)| point.load * self.spec.load / area)
            .collect();
        let mean = self.spec.contact.stiffness_factor * self.hertz.stiffness() / patch_area;
        let stiffness = match self.spec.contact.stiffness {
            StiffnessLaw::Uniform => vec![mean; areas.len()],
            StiffnessLaw::LikePreStress => pre_stress
                .iter()
                .map(|p| mean * p * patch_area / self.spec.load)
                .collect(),
        };
        let positions: Vec<_> = normals.iter().map(|n| scale(*n, ball_radius)).collect();
        let sliding_velocity = positions
            .iter()
            .map(|x| cross(self.spec.rotation, *x))
            .collect();
        // Eq. (24): the row of the central contact point along its sliding direction.
        let mut centre = vec![[0.0; 3]; m];
        self.body
            .shapes_at_ball(direction, &mut centre)
            .map_err(on_beam)?;
        let along = unit(self.sliding_velocity(tilt)).unwrap_or_else(|| any_normal(direction));
        let probe = centre.iter().map(|shape| dot(*shape, along)).collect();
        Ok(Model {
            positions,
            normals,
            areas,
            pre_stress,
            stiffness,
            shapes,
            omega: self
                .frequencies_hz
                .iter()
                .map(|hz| std::f64::consts::TAU * hz)
                .collect(),
            damping: self.spec.damping.clone(),
            sliding_velocity,
            friction: self.spec.friction,
            unilateral: self.spec.contact.unilateral,
            probe,
        })
    }

    /// The joint with the load tilted by `tilt` (rad).
    ///
    /// # Errors
    /// As [`BallJoint::model`].
    pub fn joint(&self, tilt: f64) -> Result<Joint, AssemblyError> {
        Ok(Joint::new(&self.model(tilt)?))
    }
}

/// The Hertz contact of a joint.
fn hertz_of(spec: &JointSpec) -> Hertz {
    let body = &spec.body;
    let ball_diameter = body.geometry.ball_diameter;
    Hertz::new(ball_diameter, &body.material, &spec.socket, spec.load)
}
