//! Assembly of the contact model at any tilt from the parameters of a joint.

use std::sync::Arc;

use super::patch::{PatchFrame, PatchPoint, normal_at, patch_points};
use super::published::natural_frequencies;
use super::vector::{cross, dot, scale, unit};
use super::{
    BallOnBeam, BodySpec, Hertz, ImportedModes, ImportedModesError, Joint, JointSpec, Model,
    Quadrature, StiffnessLaw,
};
use crate::fem::{BodyMode, BodyModes, FemError, SurfaceMesh};

/// Failure to assemble a joint.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// The modes of the body cannot be computed.
    #[error("the modes of ball and beam cannot be computed")]
    Body(#[from] FemError),
    /// The model has a mode whose frequency the paper does not publish.
    #[error(
        "the paper does not publish the frequency of the mode `{label}`: use at most four bending \
         pairs, two torsion modes and one axial mode, or the finite-element frequencies"
    )]
    Unpublished {
        /// Name of the mode.
        label: String,
    },
    /// The patch extends into the junction of ball and beam, where the ball has no free surface.
    #[error(
        "at a tilt of {tilt_deg:.3} deg the contact patch (half-angle {half_angle_deg:.2} deg) \
         reaches the beam; reduce the tilt, the load or the patch radius"
    )]
    PatchOnBeam {
        /// The tilt, degrees.
        tilt_deg: f64,
        /// Half-angle of the patch, degrees.
        half_angle_deg: f64,
        /// Error of the evaluation of the mode shapes.
        source: FemError,
    },
    /// The imported modes are valid for another load.
    #[error("the modes of `{file}` are invalid for this load: {problem}")]
    OtherLoad {
        /// The file.
        file: String,
        /// The difference.
        problem: ImportedModesError,
    },
    /// The operation requires a mesh, and the modes are imported.
    #[error(
        "the mesh of ball and beam is required, but the modes are imported from `{file}`; choose a \
         scene without body.modes"
    )]
    NoMesh {
        /// The file.
        file: String,
    },
}

/// A ball joint with modes and quadrature, from which [`BallJoint::model`] builds the contact model at any
/// tilt. Load and rotation can be changed without solving for the modes again.
#[derive(Clone, Debug)]
pub struct BallJoint {
    spec: JointSpec,
    frequencies_hz: Vec<f64>,
    body: Body,
    /// Frame to which the rotation has moved the patch; `None` for that of the tilt.
    patch: Option<PatchFrame>,
    /// See [`BallJoint::set_probe_rotation`].
    probe_rotation: Option<[f64; 3]>,
}

/// Source of the mode shapes at the contact nodes.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a joint has one body: its size does not matter"
)]
enum Body {
    Meshed(Meshed),
    Own(Arc<ImportedModes>),
}

/// Finite-element modes with a Hertz contact.
#[derive(Clone, Debug)]
struct Meshed {
    modes: BodyModes,
    ball_radius: f64,
    hertz: Hertz,
    points: Vec<PatchPoint>,
}

/// Contact nodes of a patch without mode shapes, one entry per node.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchNodes {
    /// Positions relative to the centre of the ball, m.
    pub positions: Vec<[f64; 3]>,
    /// Outward unit normals of the ball.
    pub normals: Vec<[f64; 3]>,
    /// Areas, m^2.
    pub areas: Vec<f64>,
    /// Pre-stress, Pa.
    pub pre_stress: Vec<f64>,
}

impl BallJoint {
    /// Computes the modes and the quadrature points of the patch.
    ///
    /// # Errors
    /// If the modes cannot be computed, or the published frequencies are selected and one is missing.
    pub fn new(spec: &JointSpec) -> Result<Self, AssemblyError> {
        match &spec.body {
            BodySpec::BallOnBeam(body) => {
                let modes = BodyModes::solve(
                    &body.geometry,
                    &body.material,
                    &body.elements,
                    &body.families,
                )?;
                let frequencies_hz = natural_frequencies(body, modes.modes())?
                    .map_err(|label| AssemblyError::Unpublished { label })?;
                Ok(Self::on_beam(modes, frequencies_hz, body, spec))
            }
            BodySpec::Imported(modes) => Ok(Self {
                spec: spec.clone(),
                frequencies_hz: modes
                    .omega()
                    .iter()
                    .map(|omega| omega / std::f64::consts::TAU)
                    .collect(),
                body: Body::Own(Arc::clone(modes)),
                patch: None,
                probe_rotation: None,
            }),
        }
    }

    /// Changes the parameters. The modes are computed again only if the body changes.
    ///
    /// # Errors
    /// As [`BallJoint::new`].
    pub fn with_spec(self, spec: &JointSpec) -> Result<Self, AssemblyError> {
        match (self.body, &spec.body) {
            (Body::Meshed(before), BodySpec::BallOnBeam(body)) if self.spec.body == spec.body => {
                Ok(Self::on_beam(before.modes, self.frequencies_hz, body, spec))
            }
            _ => Self::new(spec),
        }
    }

    /// Builds the joint from computed modes.
    fn on_beam(
        modes: BodyModes,
        frequencies_hz: Vec<f64>,
        body: &BallOnBeam,
        spec: &JointSpec,
    ) -> Self {
        let hertz = hertz_of(body, spec);
        let points = patch_points(spec.contact.quadrature, spec.contact.nodes);
        Self {
            spec: spec.clone(),
            frequencies_hz,
            body: Body::Meshed(Meshed {
                modes,
                ball_radius: 0.5 * body.geometry.ball_diameter,
                hertz,
                points,
            }),
            patch: None,
            probe_rotation: None,
        }
    }

    /// Changes the load (N, positive). The radius of a Hertz patch changes with it; an imported patch is
    /// fixed.
    pub fn set_load(&mut self, load: f64) {
        self.spec.load = load;
        if let (Body::Meshed(meshed), BodySpec::BallOnBeam(body)) =
            (&mut self.body, &self.spec.body)
        {
            meshed.hertz = hertz_of(body, &self.spec);
        }
    }

    /// Changes the angular velocity vector, rad/s.
    pub fn set_rotation(&mut self, rotation: [f64; 3]) {
        self.spec.rotation = rotation;
    }

    /// Moves a Hertz patch to a frame, whatever the tilt; `None` moves it back to that of the tilt.
    pub fn set_patch(&mut self, patch: Option<PatchFrame>) {
        self.patch = patch;
    }

    /// Sets the angular velocity (rad/s) whose sliding direction is that of Eq. (24), for a rotation that stops or
    /// reverses. By default it is the present one.
    pub fn set_probe_rotation(&mut self, rotation: [f64; 3]) {
        self.probe_rotation = Some(rotation);
    }

    /// Parameters of the joint.
    pub fn spec(&self) -> &JointSpec {
        &self.spec
    }

    /// Returns the finite-element modes of ball and beam.
    ///
    /// # Errors
    /// [`AssemblyError::NoMesh`] if the modes are imported.
    pub fn body(&self) -> Result<&BodyModes, AssemblyError> {
        match &self.body {
            Body::Meshed(meshed) => Ok(&meshed.modes),
            Body::Own(own) => Err(AssemblyError::NoMesh {
                file: own.name().to_owned(),
            }),
        }
    }

    /// Short description of the body.
    pub fn body_description(&self) -> String {
        match &self.body {
            Body::Meshed(_) => "Ball and beam".to_owned(),
            Body::Own(own) => format!("Body of {}", own.name()),
        }
    }

    /// Names of the modes in the order of the modal coordinates: `2nd bending x`, or `mode 2` for imported
    /// modes.
    pub fn mode_labels(&self) -> Vec<String> {
        self.labels(BodyMode::label)
    }

    /// As [`BallJoint::mode_labels`], with one name for both modes of a bending pair: `2nd bending`.
    pub fn family_labels(&self) -> Vec<String> {
        self.labels(BodyMode::family_label)
    }

    fn labels(&self, of: impl Fn(&BodyMode) -> String) -> Vec<String> {
        match &self.body {
            Body::Meshed(meshed) => meshed.modes.modes().iter().map(of).collect(),
            Body::Own(own) => (1..=own.modes()).map(|k| format!("mode {k}")).collect(),
        }
    }

    /// Surface mesh of the body with mode shapes, for display. [`BodyModes::outline`] describes the
    /// spacing; an imported surface has a fixed mesh. `None` if the file contains no surface.
    pub fn outline(&self, along: usize, round: usize) -> Option<SurfaceMesh> {
        match &self.body {
            Body::Meshed(meshed) => Some(meshed.modes.outline(along, round)),
            Body::Own(own) => own.surface().cloned(),
        }
    }

    /// Natural frequencies of the model, Hz, in the order of the modal coordinates.
    pub fn frequencies_hz(&self) -> &[f64] {
        &self.frequencies_hz
    }

    /// Radius of the contact patch, m: the Hertz radius times `radius_factor`, that of the table of pressures, or the radius
    /// of a disc with the area of an imported patch.
    pub fn patch_radius(&self) -> f64 {
        match &self.body {
            Body::Meshed(meshed) => self.spec.pressure.as_ref().map_or_else(
                || meshed.hertz.radius * self.spec.contact.radius_factor,
                |table| table.radius(),
            ),
            Body::Own(own) => own.patch_radius(),
        }
    }

    /// Radius of the ball, m.
    pub fn ball_radius(&self) -> f64 {
        match &self.body {
            Body::Meshed(meshed) => meshed.ball_radius,
            Body::Own(own) => own.ball_radius(),
        }
    }

    /// Unit vector from the centre of the ball to the centre of the patch at a tilt (rad).
    pub fn direction(&self, tilt: f64) -> [f64; 3] {
        self.frame(tilt).direction
    }

    /// Frame of the patch at a tilt (rad), or to which it was moved.
    fn frame(&self, tilt: f64) -> PatchFrame {
        let of_tilt = || PatchFrame::tilted(tilt, self.spec.azimuth);
        self.patch.unwrap_or_else(of_tilt)
    }

    /// Steady sliding velocity at the centre of the patch, m/s.
    pub fn sliding_velocity(&self, tilt: f64) -> [f64; 3] {
        self.velocity_of(self.spec.rotation, tilt)
    }

    /// Velocity `Omega x x` (m/s) of the centre of the patch under a rotation (rad/s).
    fn velocity_of(&self, rotation: [f64; 3], tilt: f64) -> [f64; 3] {
        cross(rotation, scale(self.direction(tilt), self.ball_radius()))
    }

    /// Angular velocity whose sliding direction is that of Eq. (24), rad/s.
    fn probe_rotation(&self) -> [f64; 3] {
        self.probe_rotation.unwrap_or(self.spec.rotation)
    }

    /// Builds the contact model at a tilt (rad).
    ///
    /// # Errors
    /// If the patch extends into the beam, or an imported patch is for another load or tilt.
    pub fn model(&self, tilt: f64) -> Result<Model, AssemblyError> {
        match &self.body {
            Body::Meshed(meshed) => self.beam_model(meshed, &meshed.points, tilt),
            Body::Own(own) => {
                let direction = self.direction(tilt);
                own.check_load(self.spec.load, direction)
                    .map_err(|problem| AssemblyError::OtherLoad {
                        file: own.name().to_owned(),
                        problem,
                    })?;
                Ok(own.model(&self.spec, direction, self.probe_rotation()))
            }
        }
    }

    /// Quadrature points of [`BallJoint::nodes_in_rings`].
    fn points_in_rings(&self, count: usize) -> Option<(&Meshed, Vec<PatchPoint>)> {
        match &self.body {
            Body::Meshed(meshed) if self.spec.friction.states() == 0 => {
                Some((meshed, patch_points(Quadrature::Rings, count)))
            }
            _ => None,
        }
    }

    /// Nodes of a patch of `count` nodes in rings at a tilt (rad); `None` if the nodes of the model are the only
    /// ones, because the patch is imported or friction has states at its nodes.
    pub fn nodes_in_rings(&self, count: usize, tilt: f64) -> Option<PatchNodes> {
        let (_, points) = self.points_in_rings(count)?;
        Some(self.patch_nodes(&points, tilt))
    }

    /// Builds the contact model with the nodes of [`BallJoint::nodes_in_rings`].
    ///
    /// # Errors
    /// As [`BallJoint::model`].
    pub fn model_in_rings(&self, count: usize, tilt: f64) -> Result<Option<Model>, AssemblyError> {
        self.points_in_rings(count)
            .map(|(meshed, points)| self.beam_model(meshed, &points, tilt))
            .transpose()
    }

    /// The nodes of a patch of ball and beam.
    fn patch_nodes(&self, points: &[PatchPoint], tilt: f64) -> PatchNodes {
        let (ball_radius, radius) = (self.ball_radius(), self.patch_radius());
        let frame = self.frame(tilt);
        let patch_area = std::f64::consts::PI * radius * radius;
        let normals: Vec<_> = points
            .iter()
            .map(|point| normal_at(point, &frame, radius, ball_radius))
            .collect();
        let [pre_stress, areas] = match &self.spec.pressure {
            Some(table) => table.nodes(points, ball_radius, self.spec.load),
            None => {
                let areas: Vec<f64> = points.iter().map(|point| point.area * patch_area).collect();
                let loads = points.iter().zip(&areas);
                let stress = loads.map(|(point, area)| point.load * self.spec.load / area);
                [stress.collect(), areas]
            }
        };
        PatchNodes {
            positions: normals.iter().map(|n| scale(*n, ball_radius)).collect(),
            normals,
            pre_stress,
            areas,
        }
    }

    /// Builds the contact model of ball and beam.
    fn beam_model(
        &self,
        meshed: &Meshed,
        points: &[PatchPoint],
        tilt: f64,
    ) -> Result<Model, AssemblyError> {
        let (body, hertz) = (&meshed.modes, &meshed.hertz);
        let (ball_radius, radius) = (self.ball_radius(), self.patch_radius());
        let frame = self.frame(tilt);
        let m = self.frequencies_hz.len();
        let PatchNodes {
            positions,
            normals,
            areas,
            pre_stress,
        } = self.patch_nodes(points, tilt);
        let on_beam = |source| AssemblyError::PatchOnBeam {
            tilt_deg: tilt.to_degrees(),
            half_angle_deg: (radius / ball_radius).min(1.0).asin().to_degrees(),
            source,
        };
        let (patch_area, carried) = if self.spec.pressure.is_some() {
            let forces = pre_stress.iter().zip(&areas).map(|(p, area)| p * area);
            (areas.iter().sum(), forces.sum())
        } else {
            (std::f64::consts::PI * radius * radius, self.spec.load)
        };
        let mut shapes = vec![[0.0; 3]; points.len() * m];
        for (normal, row) in normals.iter().zip(shapes.chunks_exact_mut(m.max(1))) {
            body.shapes_at_ball(*normal, row).map_err(on_beam)?;
        }
        let mean = self.spec.contact.stiffness_factor * hertz.stiffness() / patch_area;
        let stiffness = match self.spec.contact.stiffness {
            StiffnessLaw::Uniform => vec![mean; areas.len()],
            StiffnessLaw::LikePreStress => pre_stress
                .iter()
                .map(|p| mean * p * patch_area / carried)
                .collect(),
        };
        let sliding_velocity = positions
            .iter()
            .map(|x| cross(self.spec.rotation, *x))
            .collect();
        // Eq. (24): row of the central contact point along its sliding direction. At rest the direction of
        // the tilt is used, which rotates with the azimuth like the rest of the model.
        let mut centre = vec![[0.0; 3]; m];
        body.shapes_at_ball(frame.direction, &mut centre)
            .map_err(on_beam)?;
        let along = unit(self.velocity_of(self.probe_rotation(), tilt)).unwrap_or(frame.ahead);
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
            friction: self.spec.friction.clone(),
            unilateral: self.spec.contact.unilateral,
            contact_damping: self.spec.contact.damping,
            convection: self.spec.convection.then_some(self.spec.rotation),
            probe,
        })
    }

    /// Builds the joint at a tilt (rad).
    ///
    /// # Errors
    /// As [`BallJoint::model`].
    pub fn joint(&self, tilt: f64) -> Result<Joint, AssemblyError> {
        Ok(Joint::new(&self.model(tilt)?))
    }
}

/// Hertz contact for the load of a joint.
fn hertz_of(body: &BallOnBeam, spec: &JointSpec) -> Hertz {
    let ball_diameter = body.geometry.ball_diameter;
    Hertz::new(ball_diameter, &body.material, &spec.socket, spec.load)
}
