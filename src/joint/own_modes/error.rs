//! What can be wrong with modes from a file.

use crate::numpy::NpzError;

/// Why the arrays of a file are no modes of a joint. The message names the array, what is wrong
/// with it and the remedy; whoever passes it on names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OwnModesError {
    /// The file or one of its arrays cannot be read.
    #[error(transparent)]
    File(#[from] NpzError),
    /// The layout is not the one that is read here.
    #[error("`version` is {found}, but this program reads 1; write the arrays in the layout of 1")]
    Version {
        /// The version stated.
        found: f64,
    },
    /// An array that must be there is not.
    #[error("the array `{array}` is missing; add {what}")]
    Missing {
        /// Its name.
        array: &'static str,
        /// What it holds, with shape and unit.
        what: &'static str,
    },
    /// Natural frequencies in two units.
    #[error("`omega` and `frequencies_hz` are both there; keep one of them")]
    TwoFrequencies,
    /// An array of another shape than the others ask for.
    #[error("`{array}` has the shape {found:?}, not {expected:?}; it is to hold {what}")]
    Shape {
        /// Its name.
        array: &'static str,
        /// Its shape.
        found: Vec<usize>,
        /// The shape that fits the other arrays.
        expected: Vec<usize>,
        /// What it holds, with shape and unit.
        what: &'static str,
    },
    /// Too few or too many along the axis that says how many there are.
    #[error("`{array}` has the shape {found:?}; give one axis, of 1 to {most}")]
    Count {
        /// Its name.
        array: &'static str,
        /// Its shape.
        found: Vec<usize>,
        /// The largest number.
        most: usize,
    },
    /// A value that is no number.
    #[error("`{array}`{at:?} is {value}; repair it, or solve again")]
    NotFinite {
        /// Its name.
        array: &'static str,
        /// Index along each axis, from 0.
        at: Vec<usize>,
        /// `NaN`, `inf` or `-inf`.
        value: f64,
    },
    /// A value that must be above zero.
    #[error("`{array}`[{at}] is {value}; it must be above 0: {what}")]
    NotPositive {
        /// Its name.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The value.
        value: f64,
        /// What it holds, with shape and unit.
        what: &'static str,
    },
    /// A frequency so low that it belongs to a motion of the body as a whole.
    #[error(
        "`{array}`[{at}] is {hz:.3e} Hz, a rigid-body motion; leave these out: the first elastic \
         mode comes first"
    )]
    RigidBody {
        /// Its name.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The frequency, Hz.
        hz: f64,
    },
    /// A frequency that nobody can follow.
    #[error(
        "`{array}`[{at}] is {hz:.3e} Hz, and steps follow the fastest mode: more than {limit:.0e} Hz is not \
         integrated in reasonable time; check its unit, and leave out modes that nothing excites"
    )]
    TooFast {
        /// Its name.
        array: &'static str,
        /// Index, from 0.
        at: usize,
        /// The frequency, Hz.
        hz: f64,
        /// The highest allowed, Hz.
        limit: f64,
    },
    /// A contact that makes a mode too fast to be followed.
    #[error(
        "`stiffness` times `areas` times the square of `shapes` makes mode {mode} (from 1) vibrate on the \
         contact at {hz:.1e} Hz, above {limit:.0e} Hz; give N/m^3 and m^2, and shapes that are mass-normalised, \
         in 1/sqrt(kg)"
    )]
    ContactTooFast {
        /// The mode, from 1.
        mode: usize,
        /// Frequency of this mode on the springs of the contact alone, Hz.
        hz: f64,
        /// The highest allowed, Hz.
        limit: f64,
    },
    /// Nothing but zeros.
    #[error("`{array}` is 0 throughout: {effect}; it is to hold {what}")]
    AllZero {
        /// Its name.
        array: &'static str,
        /// What that comes to.
        effect: &'static str,
        /// What it holds, with shape and unit.
        what: &'static str,
    },
    /// A surface that cannot be that of a body with this ball.
    #[error(
        "`surface_vertices` lie {nearest:.3e} to {farthest:.3e} m from the origin, and the ball has a radius of \
         {radius:.3e} m; give them in m from the ball's centre, as `positions`"
    )]
    Surface {
        /// Smallest distance from the origin, m.
        nearest: f64,
        /// Largest distance from the origin, m.
        farthest: f64,
        /// Radius of the ball, m.
        radius: f64,
    },
    /// Mass matrices in two forms.
    #[error("`mass` and `{sparse}` are both there; keep the dense or the sparse mass matrix")]
    TwoMasses {
        /// An array of the sparse one.
        sparse: &'static str,
    },
    /// Frequencies that fall.
    #[error(
        "`{array}`[{at}] is below the one before; sort the modes by frequency, shapes included"
    )]
    Unsorted {
        /// Its name.
        array: &'static str,
        /// Index, from 0.
        at: usize,
    },
    /// A normal that is not of unit length.
    #[error("`normals`[{node}] has the length {length:.6}; divide each normal by its length")]
    NotUnit {
        /// The contact node, from 0.
        node: usize,
        /// Length of its normal.
        length: f64,
    },
    /// A ball as small or large as no scene has one.
    #[error(
        "`positions` lie {radius:.3e} m from the origin; give them in m from the ball's centre \
         (balls have diameters of 1 to 500 mm)"
    )]
    Radius {
        /// Mean distance from the origin, m.
        radius: f64,
    },
    /// A node off the sphere that the others are on.
    #[error(
        "`positions`[{node}] lies {distance:.6} m from the origin, and the contact nodes on the \
         average {radius:.6} m; put the origin into the ball's centre"
    )]
    OffSphere {
        /// The contact node, from 0.
        node: usize,
        /// Its distance from the origin, m.
        distance: f64,
        /// Mean distance of all nodes, m.
        radius: f64,
    },
    /// A normal that does not point away from the ball's centre.
    #[error(
        "`normals`[{node}] is turned by {angle_deg:.1} deg against the line from the ball's centre; \
         normals point out of the ball"
    )]
    Turned {
        /// The contact node, from 0.
        node: usize,
        /// Angle between normal and position, degrees.
        angle_deg: f64,
    },
    /// Areas larger together than the ball.
    #[error(
        "`areas` add up to {total:.3e} m^2, more than the ball's surface of {ball:.3e} m^2; give \
         them in m^2"
    )]
    Areas {
        /// Their sum, m^2.
        total: f64,
        /// Surface of the ball, m^2.
        ball: f64,
    },
    /// Pre-stress that does not carry the load.
    #[error(
        "`pre_stress` times `areas` adds up to {carried:.6} N, and the load is {load} N; give Pa \
         and m^2, and in the scene the load that they were computed for"
    )]
    Load {
        /// Sum over the nodes, N.
        carried: f64,
        /// The load, N.
        load: f64,
    },
    /// Pre-stress that pushes elsewhere than the load.
    #[error(
        "its contact patch is that of a load at a tilt of {tilt_deg:.3} deg towards the azimuth \
         {azimuth_deg:.3} deg, {angle_deg:.3} deg from the load asked for, and mode shapes at other \
         places are not known; keep that tilt, or make a file for each"
    )]
    Direction {
        /// Tilt of the pre-stress, degrees.
        tilt_deg: f64,
        /// Its azimuth, degrees.
        azimuth_deg: f64,
        /// Angle between it and the load asked for, degrees.
        angle_deg: f64,
    },
    /// A triangle of the surface with a corner that there is not.
    #[error(
        "`surface_triangles`[{triangle}] has a corner that is none of the {vertices} of \
         `surface_vertices`; count vertices from 0"
    )]
    Triangle {
        /// The triangle, from 0.
        triangle: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// Not all arrays of a group that belongs together.
    #[error("`{array}` is missing, which belongs to `{given}`; add {what}, or leave both out")]
    Incomplete {
        /// The array that is missing.
        array: &'static str,
        /// One that is there.
        given: &'static str,
        /// What the missing one holds, with shape and unit.
        what: &'static str,
    },
    /// A mass matrix that is none.
    #[error("{problem}; save the mass matrix as scipy.sparse.csr_array has it")]
    Mass {
        /// What does not fit.
        problem: String,
    },
    /// Mode shapes that are not orthonormal with respect to the mass matrix.
    #[error(
        "`dof_shapes` are not mass-normalised: shape {first}, `mass`, shape {second} (from 1) gives \
         {product:.6}, where {due} is due, the largest deviation of all; scale each shape by the \
         root of its modal mass, `shapes` likewise, and orthogonalise those of equal frequencies"
    )]
    NotOrthonormal {
        /// One mode, from 1.
        first: usize,
        /// The other mode, from 1; the same one where the scale is wrong.
        second: usize,
        /// `Phi_first^T M Phi_second`.
        product: f64,
        /// What it ought to be: 1 or 0.
        due: f64,
    },
}
