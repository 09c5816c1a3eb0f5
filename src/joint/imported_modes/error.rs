//! Errors of imported modes.

use crate::numpy::NpzError;

/// A fault in a file of modes. The message contains the array, the fault and the remedy; the caller adds
/// the name of the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportedModesError {
    /// The file or one of its arrays cannot be read.
    #[error(transparent)]
    File(#[from] NpzError),
    /// The version of the file format is not supported.
    #[error(
        "`version` is {found}, but this program supports only 1; write the arrays in format version 1"
    )]
    Version {
        /// The version in the file.
        found: f64,
    },
    /// A required array is missing.
    #[error("the array `{array}` is missing; add {what}")]
    Missing {
        /// Name of the array.
        array: &'static str,
        /// Content, with shape and unit.
        what: &'static str,
    },
    /// The natural frequencies are given in two units.
    #[error("the file contains both `omega` and `frequencies_hz`; remove one of them")]
    TwoFrequencies,
    /// The shape of an array is inconsistent with that of other arrays.
    #[error("`{array}` has the shape {found:?} instead of {expected:?}; it must contain {what}")]
    Shape {
        /// Name of the array.
        array: &'static str,
        /// Shape in the file.
        found: Vec<usize>,
        /// Shape consistent with the other arrays.
        expected: Vec<usize>,
        /// Content, with shape and unit.
        what: &'static str,
    },
    /// The length of the array is out of range.
    #[error(
        "`{array}` has the shape {found:?}; it must have one axis with a length of 1 to {most}"
    )]
    Count {
        /// Name of the array.
        array: &'static str,
        /// Shape in the file.
        found: Vec<usize>,
        /// Maximum length.
        most: usize,
    },
    /// A value is not finite.
    #[error("`{array}`{at:?} is {value}; correct the file, or repeat the modal analysis")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Index along each axis, from 0.
        at: Vec<usize>,
        /// `NaN`, `inf` or `-inf`.
        value: f64,
    },
    /// A value is not positive.
    #[error("`{array}`[{at}] is {value}; it must be above 0: {what}")]
    NotPositive {
        /// Name of the array.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The value.
        value: f64,
        /// Content, with shape and unit.
        what: &'static str,
    },
    /// A natural frequency is so low that the mode is a rigid-body motion.
    #[error(
        "`{array}`[{at}] is {hz:.3e} Hz, a rigid-body mode; remove rigid-body modes, so that the \
         first mode is elastic"
    )]
    RigidBody {
        /// Name of the array.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The frequency, Hz.
        hz: f64,
    },
    /// A natural frequency is too high for the integration.
    #[error(
        "`{array}`[{at}] is {hz:.3e} Hz, above the limit of {limit:.0e} Hz: the step size follows the highest \
         frequency; check the unit, and remove modes that are not excited"
    )]
    TooFast {
        /// Name of the array.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The frequency, Hz.
        hz: f64,
        /// Limit, Hz.
        limit: f64,
    },
    /// The contact stiffness makes the frequency of a mode too high for the integration.
    #[error(
        "`stiffness` times `areas` times the square of `shapes` gives mode {mode} (from 1) a frequency of \
         {hz:.1e} Hz on the contact, above {limit:.0e} Hz; check the units N/m^3 and m^2 and the mass \
         normalisation of the shapes, in 1/sqrt(kg)"
    )]
    ContactTooFast {
        /// Number of the mode, from 1.
        mode: usize,
        /// Frequency of the mode on the contact springs alone, Hz.
        hz: f64,
        /// Limit, Hz.
        limit: f64,
    },
    /// All values of an array are zero.
    #[error("`{array}` contains zeros only: {effect}; it must contain {what}")]
    AllZero {
        /// Name of the array.
        array: &'static str,
        /// Consequence.
        effect: &'static str,
        /// Content, with shape and unit.
        what: &'static str,
    },
    /// The surface is not that of a body with this ball.
    #[error(
        "`surface_vertices` have distances from {nearest:.3e} to {farthest:.3e} m from the origin, but the radius \
         of the ball is {radius:.3e} m; give them in m with the origin at the centre of the ball, like `positions`"
    )]
    Surface {
        /// Minimum distance from the origin, m.
        nearest: f64,
        /// Maximum distance from the origin, m.
        farthest: f64,
        /// Radius of the ball, m.
        radius: f64,
    },
    /// The mass matrix is given in two forms.
    #[error(
        "the file contains both `mass` and `{sparse}`; remove the dense or the sparse mass matrix"
    )]
    TwoMasses {
        /// An array of the sparse matrix.
        sparse: &'static str,
    },
    /// The frequencies are not in ascending order.
    #[error(
        "`{array}`[{at}] is below the previous value; sort the modes by frequency, including their shapes"
    )]
    Unsorted {
        /// Name of the array.
        array: &'static str,
        /// Index, from 0.
        at: usize,
    },
    /// A normal is not of unit length.
    #[error("`normals`[{node}] has the length {length:.6}; divide each normal by its length")]
    NotUnit {
        /// The contact node, from 0.
        node: usize,
        /// Length of its normal.
        length: f64,
    },
    /// The radius of the ball is out of range.
    #[error(
        "`positions` have a mean distance of {radius:.3e} m from the origin; give them in m with the \
         origin at the centre of the ball (diameters of balls are 1 to 500 mm)"
    )]
    Radius {
        /// Mean distance from the origin, m.
        radius: f64,
    },
    /// A node is not on the sphere of the other nodes.
    #[error(
        "`positions`[{node}] has a distance of {distance:.6} m from the origin, but the mean of all \
         contact nodes is {radius:.6} m; place the origin at the centre of the ball"
    )]
    OffSphere {
        /// The contact node, from 0.
        node: usize,
        /// Distance of the node from the origin, m.
        distance: f64,
        /// Mean distance of all nodes, m.
        radius: f64,
    },
    /// A normal does not point away from the centre of the ball.
    #[error(
        "`normals`[{node}] deviates by {angle_deg:.1} deg from the radial direction; normals must point \
         out of the ball"
    )]
    Turned {
        /// The contact node, from 0.
        node: usize,
        /// Angle between normal and position, degrees.
        angle_deg: f64,
    },
    /// The areas exceed the surface of the ball.
    #[error(
        "the sum of `areas`, {total:.3e} m^2, exceeds the surface of the ball, {ball:.3e} m^2; give \
         them in m^2"
    )]
    Areas {
        /// Sum of the areas, m^2.
        total: f64,
        /// Surface of the ball, m^2.
        ball: f64,
    },
    /// The pre-stress does not balance the load.
    #[error(
        "the sum of `pre_stress` times `areas` is {carried:.6} N, but the load of the scene is {load} N; \
         give Pa and m^2, and set the load for which the pre-stress was computed"
    )]
    Load {
        /// Sum over the nodes, N.
        carried: f64,
        /// The load, N.
        load: f64,
    },
    /// The direction of the pre-stress differs from that of the load.
    #[error(
        "the contact patch is valid for a tilt of {tilt_deg:.3} deg towards the azimuth \
         {azimuth_deg:.3} deg, which differs by {angle_deg:.3} deg from the load of the scene; set this \
         tilt, or create a file for each tilt"
    )]
    Direction {
        /// Tilt of the pre-stress, degrees.
        tilt_deg: f64,
        /// Azimuth of the pre-stress, degrees.
        azimuth_deg: f64,
        /// Angle between pre-stress and load, degrees.
        angle_deg: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error(
        "`surface_triangles`[{triangle}] refers to a vertex outside the {vertices} of \
         `surface_vertices`; count vertices from 0"
    )]
    Triangle {
        /// The triangle, from 0.
        triangle: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// An array of a group is missing.
    #[error("`{array}` is missing, which `{given}` requires; add {what}, or remove both arrays")]
    Incomplete {
        /// The missing array.
        array: &'static str,
        /// The array that requires it.
        given: &'static str,
        /// Content of the missing array, with shape and unit.
        what: &'static str,
    },
    /// The sparse mass matrix is invalid.
    #[error("{problem}; save the mass matrix in the format of scipy.sparse.csr_array")]
    Mass {
        /// The fault.
        problem: String,
    },
    /// The mode shapes are not orthonormal with respect to the mass matrix.
    #[error(
        "`dof_shapes` are not mass-normalised: shape {first}, `mass`, shape {second} (from 1) gives \
         {product:.6} instead of {due}, the largest deviation; divide each shape by the root of its \
         modal mass, also in `shapes`, and orthogonalise shapes of equal frequencies"
    )]
    NotOrthonormal {
        /// Number of one mode, from 1.
        first: usize,
        /// Number of the other mode, from 1; equal to `first` if the normalisation is wrong.
        second: usize,
        /// `Phi_first^T M Phi_second`.
        product: f64,
        /// Required value: 1 or 0.
        due: f64,
    },
}
