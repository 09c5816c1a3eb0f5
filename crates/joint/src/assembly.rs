//! Assembly of the contact model at any tilt from the parameters of a joint.

use std::f64::consts::{PI, TAU};
use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::available_parallelism;

use super::patch::{PatchFrame, PatchPoint, normal_at, patch_points};
use super::published::natural_frequencies;
use super::vector::{cross, dot, scale, unit};
use super::{
    BallOnBeam, BodySpec, ImportedModes, ImportedModesError, Joint, JointSpec, Model, Quadrature,
    StiffnessLaw,
};
use crate::fem::{BodyMode, BodyModes, FemError, SurfaceMesh};

/// Failure to assemble a joint.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// The modes of the body cannot be computed.
    #[error("the modes of ball and beam cannot be computed")]
    Body(#[from] FemError),
    /// The model has the mode of this name, whose frequency the paper does not publish.
    #[error(
        "the paper does not publish the frequency of the mode `{0}`: use at most four bending \
         pairs, two torsion modes and one axial mode, or the finite-element frequencies"
    )]
    Unpublished(String),
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

/// Loading of a joint at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Tilt of the load towards the azimuth of the joint, rad.
    pub tilt: f64,
    /// Frame to which the rotation has moved the patch; `None` for that of the tilt.
    pub patch: Option<PatchFrame>,
    /// Load, N.
    pub load: f64,
    /// Angular velocity vector, rad/s.
    pub rotation: [f64; 3],
    /// Factor that `rotation` contains; 1 if the rotation is constant.
    pub rotation_factor: f64,
}

/// A ball joint with modes and quadrature, from which [`BallJoint::model`] builds the contact model at any
/// tilt. The loading can be changed without solving for the modes again.
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
enum Body {
    Meshed(BallOnBeam, Arc<BodyModes>),
    Imported(Arc<ImportedModes>),
}

/// The modes of a body, latest last.
static SOLVED: Mutex<Vec<(BallOnBeam, Arc<BodyModes>)>> = Mutex::new(Vec::new());

/// The modes of a body, from memory if it is one of the last bodies: most joints have that of an earlier one. A thread may
/// need two, for the ratios of frequencies to those of the published body.
pub(super) fn body_modes(body: &BallOnBeam) -> Result<Arc<BodyModes>, FemError> {
    let solved = || SOLVED.lock().unwrap_or_else(PoisonError::into_inner);
    let known = solved().iter().find(|(known, _)| known == body).cloned();
    let modes = match known {
        Some((_, modes)) => modes,
        None => Arc::new(body.solve_modes()?),
    };
    let mut kept = solved();
    kept.retain(|(known, _)| known != body);
    kept.push((body.clone(), Arc::clone(&modes)));
    let threads = available_parallelism().map_or(1, NonZero::get);
    let surplus = kept.len().saturating_sub(8.max(2 * threads));
    kept.drain(..surplus);
    Ok(modes)
}

impl BallOnBeam {
    /// Computes the modes, whether they are known or not.
    ///
    /// # Errors
    /// As [`BodyModes::solve`].
    pub fn solve_modes(&self) -> Result<BodyModes, FemError> {
        BodyModes::solve(
            &self.geometry,
            &self.material,
            &self.elements,
            &self.families,
        )
    }
}

impl BallJoint {
    /// Computes the modes, unless those of the body are known from a recent joint.
    ///
    /// # Errors
    /// If the modes cannot be computed, or the published frequencies are selected and one is missing.
    pub fn new(spec: &JointSpec) -> Result<Self, AssemblyError> {
        let (frequencies_hz, body) = match &spec.body {
            BodySpec::BallOnBeam(body) => {
                let modes = body_modes(body)?;
                let frequencies_hz = natural_frequencies(body, modes.modes())?;
                (frequencies_hz, Body::Meshed(body.clone(), modes))
            }
            BodySpec::Imported(modes) => {
                let frequencies_hz = modes.omega().iter().map(|omega| omega / TAU).collect();
                (frequencies_hz, Body::Imported(Arc::clone(modes)))
            }
        };
        Ok(Self {
            spec: spec.clone(),
            frequencies_hz,
            body,
            patch: None,
            probe_rotation: None,
        })
    }

    /// Changes load, rotation and frame of the patch. The tilt is an argument of [`BallJoint::model`]. The radius of a Hertz
    /// patch changes with the load; an imported patch is fixed.
    pub fn set_loading(&mut self, loading: &Loading) {
        self.spec.load = loading.load;
        self.spec.rotation = loading.rotation;
        self.patch = loading.patch;
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
            Body::Meshed(_, modes) => Ok(modes),
            Body::Imported(own) => Err(AssemblyError::NoMesh {
                file: own.name().to_owned(),
            }),
        }
    }

    /// Short description of the body.
    pub fn body_description(&self) -> String {
        match &self.body {
            Body::Meshed(..) => "Ball and beam".to_owned(),
            Body::Imported(own) => format!("Body of {}", own.name()),
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
            Body::Meshed(_, modes) => modes.modes().iter().map(of).collect(),
            Body::Imported(own) => (1..=own.modes()).map(|k| format!("mode {k}")).collect(),
        }
    }

    /// Surface mesh of the body with mode shapes, for display. [`BodyModes::outline`] describes the
    /// spacing; an imported surface has a fixed mesh. `None` if the file contains no surface.
    pub fn outline(&self, along: usize, round: usize) -> Option<SurfaceMesh> {
        match &self.body {
            Body::Meshed(_, modes) => Some(modes.outline(along, round)),
            Body::Imported(own) => own.surface().cloned(),
        }
    }

    /// Natural frequencies of the model, Hz, in the order of the modal coordinates.
    pub fn frequencies_hz(&self) -> &[f64] {
        &self.frequencies_hz
    }

    /// Radius of the contact patch, m: the Hertz radius times `radius_factor`, that of the table of pressures, or the radius
    /// of a disc with the area of an imported patch.
    pub fn patch_radius(&self) -> f64 {
        match (&self.body, &self.spec.pressure) {
            (Body::Imported(own), _) => own.patch_radius(),
            (Body::Meshed(..), Some(table)) => table.radius(),
            (Body::Meshed(body, _), None) => {
                let hertz = body.hertz(&self.spec.socket, self.spec.load);
                hertz.radius * self.spec.contact.radius_factor
            }
        }
    }

    /// Radius of the ball, m.
    pub fn ball_radius(&self) -> f64 {
        match &self.body {
            Body::Meshed(body, _) => 0.5 * body.geometry.ball_diameter,
            Body::Imported(own) => own.ball_radius(),
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
            Body::Meshed(body, modes) => {
                let contact = &self.spec.contact;
                let points = patch_points(contact.quadrature, contact.nodes);
                self.beam_model((body, modes), &points, tilt)
            }
            Body::Imported(own) => {
                let direction = self.direction(tilt);
                own.check_load(self.spec.load, direction)
                    .map_err(|problem| AssemblyError::OtherLoad {
                        file: own.name().to_owned(),
                        problem,
                    })?;
                let factor = self.spec.contact.stiffness_factor;
                let stiffness = own.stiffness.iter().map(|k| factor * k).collect();
                let probe = own.probe(direction, self.probe_rotation());
                let (omega, shapes) = (own.omega().to_vec(), own.shapes.clone());
                let vectors = [own.positions.clone(), own.normals.clone()];
                let numbers = [own.areas.clone(), own.pre_stress.clone(), stiffness];
                Ok(self.at_nodes(vectors, numbers, omega, shapes, probe))
            }
        }
    }

    /// Builds the contact model with `count` nodes in rings instead of those of the joint; `None` if those are the only ones,
    /// because the patch is imported or friction has states at its nodes.
    ///
    /// # Errors
    /// As [`BallJoint::model`].
    pub fn model_in_rings(&self, count: usize, tilt: f64) -> Result<Option<Model>, AssemblyError> {
        match &self.body {
            Body::Meshed(body, modes) if self.spec.friction.states() == 0 => {
                let points = patch_points(Quadrature::Rings, count);
                self.beam_model((body, modes), &points, tilt).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Builds the contact model of ball and beam with nodes at points of the patch.
    fn beam_model(
        &self,
        (body, modes): (&BallOnBeam, &BodyModes),
        points: &[PatchPoint],
        tilt: f64,
    ) -> Result<Model, AssemblyError> {
        let JointSpec { load, contact, .. } = &self.spec;
        let (ball_radius, radius) = (self.ball_radius(), self.patch_radius());
        let frame = self.frame(tilt);
        let normals: Vec<_> = points
            .iter()
            .map(|point| normal_at(point, &frame, radius, ball_radius))
            .collect();
        let flat = PI * radius * radius;
        let (pre_stress, areas, patch_area, carried) = match &self.spec.pressure {
            Some(table) => {
                let [pre_stress, areas] = table.nodes(points, ball_radius, *load);
                let forces = pre_stress.iter().zip(&areas).map(|(p, area)| p * area);
                let (patch_area, carried) = (areas.iter().sum(), forces.sum());
                (pre_stress, areas, patch_area, carried)
            }
            None => {
                let nodes = points.iter().map(|point| {
                    let area = point.area * flat;
                    (point.load * load / area, area)
                });
                let (pre_stress, areas) = nodes.unzip();
                (pre_stress, areas, flat, *load)
            }
        };
        let m = self.frequencies_hz.len();
        let on_beam = |source| AssemblyError::PatchOnBeam {
            tilt_deg: tilt.to_degrees(),
            half_angle_deg: (radius / ball_radius).min(1.0).asin().to_degrees(),
            source,
        };
        let mut shapes = vec![[0.0; 3]; points.len() * m];
        for (normal, row) in normals.iter().zip(shapes.chunks_exact_mut(m.max(1))) {
            modes.shapes_at_ball(*normal, row).map_err(on_beam)?;
        }
        let hertz = body.hertz(&self.spec.socket, *load);
        let mean = contact.stiffness_factor * hertz.stiffness / patch_area;
        let stiffness = match contact.stiffness {
            StiffnessLaw::Uniform => vec![mean; areas.len()],
            StiffnessLaw::LikePreStress => pre_stress
                .iter()
                .map(|p| mean * p * patch_area / carried)
                .collect(),
        };
        // Eq. (24): row of the central contact point along its sliding direction. At rest the direction of
        // the tilt is used, which rotates with the azimuth like the rest of the model.
        let mut centre = vec![[0.0; 3]; m];
        modes
            .shapes_at_ball(frame.direction, &mut centre)
            .map_err(on_beam)?;
        let along = unit(self.velocity_of(self.probe_rotation(), tilt)).unwrap_or(frame.ahead);
        let probe = centre.iter().map(|shape| dot(*shape, along)).collect();
        let positions = normals.iter().map(|n| scale(*n, ball_radius)).collect();
        let (vectors, numbers) = ([positions, normals], [areas, pre_stress, stiffness]);
        let omega = self.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        Ok(self.at_nodes(vectors, numbers, omega, shapes, probe))
    }

    /// The contact model at given nodes, with the sliding, friction and damping of the joint.
    fn at_nodes(
        &self,
        [positions, normals]: [Vec<[f64; 3]>; 2],
        [areas, pre_stress, stiffness]: [Vec<f64>; 3],
        omega: Vec<f64>,
        shapes: Vec<[f64; 3]>,
        probe: Vec<f64>,
    ) -> Model {
        let spec = &self.spec;
        let slide = |x: &[f64; 3]| cross(spec.rotation, *x);
        Model {
            sliding_velocity: positions.iter().map(slide).collect(),
            positions,
            normals,
            areas,
            pre_stress,
            stiffness,
            shapes,
            omega,
            damping: spec.damping.clone(),
            friction: spec.friction.clone(),
            unilateral: spec.contact.unilateral,
            contact_damping: spec.contact.damping,
            convection: spec.convection.then_some(spec.rotation),
            probe,
        }
    }

    /// Builds the joint at a tilt (rad).
    ///
    /// # Errors
    /// As [`BallJoint::model`].
    pub fn joint(&self, tilt: f64) -> Result<Joint, AssemblyError> {
        Ok(Joint::new(&self.model(tilt)?))
    }
}
