//! Modes and contact patch of an arbitrary body, imported from another finite-element program.
//!
//! Required arrays, as `squeakscope model` writes them:
//!
//! | array | shape | meaning |
//! |---|---|---|
//! | `positions` | (n, 3) | positions of the contact nodes relative to the centre of the ball, m |
//! | `normals` | (n, 3) | outward unit normals of the ball |
//! | `areas` | (n) | area of each node, m^2 |
//! | `pre_stress` | (n) | contact pressure in steady sliding, Pa |
//! | `stiffness` | (n) | contact stiffness per area `k_c`, N/m^3 |
//! | `shapes` | (n, 3, m) | mass-normalised mode shapes, 1/sqrt(kg) |
//! | `omega` or `frequencies_hz` | (m) | natural frequencies, rad/s or Hz, ascending |
//!
//! Optional arrays:
//!
//! | array | shape | meaning |
//! |---|---|---|
//! | `probe` | (m) | row that gives the probe displacement, Eq. (24), 1/sqrt(kg); default: the row of the node nearest to the load, along its sliding velocity |
//! | `surface_vertices` | (v, 3) | surface of the body for display, m |
//! | `surface_triangles` | (t, 3) | its triangles, counter-clockwise from outside, vertices from 0 |
//! | `surface_shapes` | (v, 3, m) | mode shapes at its vertices, 1/sqrt(kg) |
//! | `mass` | (d, d) | mass matrix, kg; or `mass_data`, `mass_indices`, `mass_indptr`: the same in compressed sparse row format |
//! | `dof_shapes` | (d, m) | mode shapes at all degrees of freedom; required with a mass matrix, to check `Phi^T M Phi = I` |
//! | `version` | () | 1 |
//!
//! Rotation, friction, damping and initial state are those of the scene; the corresponding arrays of a file
//! written by `squeakscope model` are ignored.
//!
//! Limitations: contact nodes are fixed on the body, so that the load cannot tilt. `shapes` are not compared
//! with `dof_shapes`, since the degrees of freedom of a contact node are unknown.

mod arrays;
mod mass;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use self::ImportedModesError::Content;
pub use self::arrays::{ArrayError, NamedArrays};
use self::arrays::{Arrays, Named};
use super::MAX_MODES;
use super::vector::{add_scaled, any_normal, cross, dot, norm, unit};
use crate::fem::SurfaceMesh;

/// A fault in a file of modes. The message contains the array, the fault and the remedy; the caller adds
/// the name of the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportedModesError {
    /// The file or one of its arrays cannot be read.
    #[error(transparent)]
    File(#[from] ArrayError),
    /// An array is missing, or its content is invalid.
    #[error("{0}")]
    Content(String),
}

/// Maximum number of contact nodes.
pub const MAX_NODES: usize = 10_000;

/// Maximum deviation of the length of a normal from 1: rounding of single precision.
const UNIT_TOLERANCE: f64 = 1e-5;
/// Maximum relative deviation of a node's distance from the centre of the ball, and maximum angle (rad)
/// between normal and radial direction: the facets of a coarse mesh.
const SPHERE_TOLERANCE: f64 = 0.05;
/// Maximum relative deviation of the pre-stress's sum from the load, and maximum angle (rad) between the two.
const LOAD_TOLERANCE: f64 = 0.01;
const DIRECTION_TOLERANCE: f64 = 0.1 / 180.0 * PI;
/// Frequency below which a mode of a body of this size is a rigid-body mode, Hz.
const RIGID_BELOW: f64 = 1.0;
/// Maximum frequency of a mode, free or on the contact springs, Hz. The step size follows the highest
/// frequency with tens of steps per period, which is about 1e9 steps per second of simulated time at this
/// limit. Squeak frequencies are more than two decades lower.
const TOO_FAST: f64 = 1e7;
/// Maximum distance of the surface from the centre of the ball, m; maximum of its minimum distance, in
/// radii of the ball, which is a part of the body.
const FARTHEST: f64 = 10.0;
const NEAREST: f64 = 10.0;
/// Permitted diameters of the ball, m.
const BALL_DIAMETERS: std::ops::RangeInclusive<f64> = 1e-3..=0.5;

const VERSION: Named = Named("version", "the version of the layout, a single number");
const POSITIONS: Named = Named(
    "positions",
    "the nodes from the ball's centre, (nodes, 3), m",
);
const NORMALS: Named = Named(
    "normals",
    "the outward unit normals of the ball, (nodes, 3)",
);
const AREAS: Named = Named("areas", "the area of each contact node, (nodes), m^2");
const PRE_STRESS: Named = Named("pre_stress", "the pressure at each node, (nodes), Pa");
const STIFFNESS: Named = Named("stiffness", "the stiffness per area, (nodes), N/m^3");
const SHAPES: Named = Named("shapes", "the mode shapes, (nodes, 3, modes), 1/sqrt(kg)");
const OMEGA: Named = Named(
    "omega",
    "frequencies, (modes), rad/s (or `frequencies_hz`, Hz)",
);
const FREQUENCIES: Named = Named("frequencies_hz", "the natural frequencies, (modes), Hz");
const PROBE: Named = Named("probe", "the row of the probe, (modes), 1/sqrt(kg)");
const VERTICES: Named = Named("surface_vertices", "the surface, (vertices, 3), m");
const TRIANGLES: Named = Named("surface_triangles", "vertices from 0, (triangles, 3)");
const SURFACE_SHAPES: Named = Named(
    "surface_shapes",
    "the mode shapes at the surface, (vertices, 3, modes), 1/sqrt(kg)",
);

/// Imported and validated modes and contact patch of a body at one tilt: `n` contact nodes, `m` modes.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedModes {
    name: String,
    pub(crate) positions: Vec<[f64; 3]>,
    pub(crate) normals: Vec<[f64; 3]>,
    pub(crate) areas: Vec<f64>,
    pub(crate) pre_stress: Vec<f64>,
    pub(crate) stiffness: Vec<f64>,
    /// `n x m` row-major, 1/sqrt(kg).
    pub(crate) shapes: Vec<[f64; 3]>,
    /// Natural angular frequencies, rad/s.
    omega: Vec<f64>,
    probe: Option<Vec<f64>>,
    surface: Option<SurfaceMesh>,
}

impl ImportedModes {
    /// Reads and validates the arrays of a file; `name` is its name in messages.
    ///
    /// # Errors
    /// The first fault found: an array that is missing, has a wrong shape or type, is not finite, out of
    /// range or inconsistent with others; mode shapes that are not orthonormal with respect to a mass
    /// matrix in the file.
    pub fn read(file: &mut dyn NamedArrays, name: &str) -> Result<Self, ImportedModesError> {
        let mut arrays = Arrays(file);
        let version = arrays
            .optional(&VERSION, &[])?
            .map_or(1.0, |version| version[0]);
        if version != 1.0 {
            return Err(Content(format!(
                "`version` is {version}, but this program supports only 1; write the arrays in format version 1"
            )));
        }
        let omega = frequencies(&mut arrays)?;
        let areas = arrays.counted(&AREAS, MAX_NODES)?;
        let (n, m) = (areas.len(), omega.len());
        let positions = arrays.need(&POSITIONS, &[n, 3])?;
        let normals = arrays.need(&NORMALS, &[n, 3])?;
        let modes = Self {
            name: name.to_owned(),
            positions: positions.as_chunks().0.to_vec(),
            normals: normals.as_chunks().0.to_vec(),
            areas,
            pre_stress: arrays.positive(&PRE_STRESS, n)?,
            stiffness: arrays.positive(&STIFFNESS, n)?,
            shapes: vectors(&arrays.need(&SHAPES, &[n, 3, m])?, m),
            omega,
            probe: arrays.optional(&PROBE, &[m])?,
            surface: surface(&mut arrays, m)?,
        };
        SHAPES.check_motion(modes.shapes.as_flattened(), "the contact would not move")?;
        if let Some(probe) = &modes.probe {
            PROBE.check_motion(probe, "the probe signal would be zero")?;
        }
        modes.check_sphere()?;
        modes.check_contact()?;
        modes.check_surface()?;
        mass::check(&mut arrays, m)?;
        Ok(modes)
    }

    /// Name of the file in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of contact nodes.
    pub fn nodes(&self) -> usize {
        self.areas.len()
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.omega.len()
    }

    /// Natural angular frequencies, rad/s.
    pub fn omega(&self) -> &[f64] {
        &self.omega
    }

    /// Radius of the ball, m: the mean distance of the contact nodes from its centre.
    pub fn ball_radius(&self) -> f64 {
        let total: f64 = self.positions.iter().map(|x| norm(*x)).sum();
        total / self.nodes() as f64
    }

    /// Radius of a disc with the total area of the contact nodes, m.
    pub fn patch_radius(&self) -> f64 {
        (self.areas.iter().sum::<f64>() / PI).sqrt()
    }

    /// Surface of the body for display, if the file contains one.
    pub fn surface(&self) -> Option<&SurfaceMesh> {
        self.surface.as_ref()
    }

    /// The row that gives the probe displacement from the modal coordinates, 1/sqrt(kg). Without one in the file it is that
    /// of the node nearest to a load along `direction`, in its sliding direction under a `rotation` (rad/s).
    pub(crate) fn probe(&self, direction: [f64; 3], rotation: [f64; 3]) -> Vec<f64> {
        if let Some(probe) = &self.probe {
            return probe.clone();
        }
        let normals = &self.normals;
        let alignment = |node: &usize| dot(normals[*node], direction);
        let centre = (0..self.nodes()).max_by(|a, b| alignment(a).total_cmp(&alignment(b)));
        let centre = centre.unwrap_or_default();
        let along = unit(cross(rotation, self.positions[centre]));
        let along = along.unwrap_or_else(|| any_normal(normals[centre]));
        let rows = &self.shapes[centre * self.modes()..][..self.modes()];
        rows.iter().map(|shape| dot(*shape, along)).collect()
    }

    /// Checks that a load (N) along a unit vector is the resultant of the pre-stress.
    ///
    /// On a curved patch the vector sum of the pressures is less than the sum of their magnitudes; the load
    /// may be either of them or between them.
    ///
    /// # Errors
    /// If the sum of the pressures or their direction differs.
    pub fn check_load(&self, load: f64, direction: [f64; 3]) -> Result<(), ImportedModesError> {
        let (sum, total) = self.load();
        let along = norm(sum);
        if load < along * (1.0 - LOAD_TOLERANCE) || load > total * (1.0 + LOAD_TOLERANCE) {
            return Err(Content(format!(
                "the sum of `pre_stress` times `areas` is {total:.6} N, but the load of the scene is {load} N; give Pa \
                 and m^2, and set the load for which the pre-stress was computed"
            )));
        }
        let angle = norm(cross(sum, direction)).atan2(dot(sum, direction));
        if angle > DIRECTION_TOLERANCE {
            let [x, y, _] = sum;
            // Rounding first avoids the output of minus zero.
            let rounded = |deg: f64| (1e3 * deg).round() / 1e3 + 0.0;
            return Err(Content(format!(
                "the contact patch is valid for a tilt of {:.3} deg towards the azimuth {:.3} deg, which differs by \
                 {:.3} deg from the load of the scene; set this tilt, or create a file for each tilt",
                rounded(self.tilt().to_degrees()),
                rounded(y.atan2(x).to_degrees()),
                angle.to_degrees()
            )));
        }
        Ok(())
    }

    /// Vector sum of the pressures and sum of their magnitudes, N.
    fn load(&self) -> ([f64; 3], f64) {
        let pairs = self.areas.iter().zip(&self.pre_stress);
        let nodes = pairs.map(|(area, stress)| area * stress).zip(&self.normals);
        nodes.fold(([0.0; 3], 0.0), |(sum, total), (force, normal)| {
            (add_scaled(sum, force, *normal), total + force)
        })
    }

    /// Tilt of the load of the patch, rad.
    pub fn tilt(&self) -> f64 {
        let ([x, y, z], _) = self.load();
        x.hypot(y).atan2(z)
    }

    /// Hash (FNV-1a) of all numbers that affect the motion.
    pub fn fingerprint(&self) -> u64 {
        let vectors = [&self.positions, &self.normals, &self.shapes];
        let vectors = vectors.into_iter().flat_map(|v| v.as_flattened());
        let numbers = [&self.areas, &self.pre_stress, &self.stiffness, &self.omega];
        let numbers = numbers.into_iter().chain(&self.probe).flatten();
        let bytes = vectors
            .chain(numbers)
            .flat_map(|x| x.to_bits().to_le_bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        })
    }

    /// Checks that the contact nodes lie on a sphere about the origin with outward normals.
    fn check_sphere(&self) -> Result<(), ImportedModesError> {
        let radius = self.ball_radius();
        if !BALL_DIAMETERS.contains(&(2.0 * radius)) {
            return Err(Content(format!(
                "`positions` have a mean distance of {radius:.3e} m from the origin; give them in m with the origin at \
                 the centre of the ball (diameters of balls are 1 to 500 mm)"
            )));
        }
        let nodes = self.positions.iter().zip(&self.normals);
        for (node, (x, normal)) in nodes.enumerate() {
            let (length, distance) = (norm(*normal), norm(*x));
            let angle = norm(cross(*x, *normal)).atan2(dot(*x, *normal));
            let fault = if (length - 1.0).abs() > UNIT_TOLERANCE {
                format!(
                    "`normals`[{node}] has the length {length:.6}; divide each normal by its length"
                )
            } else if (distance / radius - 1.0).abs() > SPHERE_TOLERANCE {
                format!(
                    "`positions`[{node}] has a distance of {distance:.6} m from the origin, but the mean of all \
                     contact nodes is {radius:.6} m; place the origin at the centre of the ball"
                )
            } else if angle > SPHERE_TOLERANCE {
                format!(
                    "`normals`[{node}] deviates by {:.1} deg from the radial direction; normals must point out of the \
                     ball",
                    angle.to_degrees()
                )
            } else {
                continue;
            };
            return Err(Content(fault));
        }
        let total: f64 = self.areas.iter().sum();
        let ball = 4.0 * PI * radius * radius;
        if total > ball {
            return Err(Content(format!(
                "the sum of `areas`, {total:.3e} m^2, exceeds the surface of the ball, {ball:.3e} m^2; give them in m^2"
            )));
        }
        Ok(())
    }

    /// Checks the frequency of each mode on the contact springs: they add `sum(stiffness * area *
    /// |shape|^2)` to the square of the angular frequency of a single mode.
    fn check_contact(&self) -> Result<(), ImportedModesError> {
        let nodes = self.stiffness.iter().zip(&self.areas);
        let mut added = vec![0.0; self.modes()];
        for ((stiffness, area), shapes) in nodes.zip(self.shapes.chunks(self.modes())) {
            for (added, shape) in added.iter_mut().zip(shapes) {
                *added += stiffness * area * dot(*shape, *shape);
            }
        }
        let hz = added.iter().map(|square: &f64| square.sqrt() / TAU);
        // Also rejects an overflow.
        let too_fast = hz.enumerate().find(|(_, hz)| hz.is_nan() || *hz > TOO_FAST);
        let Some((mode, hz)) = too_fast else {
            return Ok(());
        };
        Err(Content(format!(
            "`stiffness` times `areas` times the square of `shapes` gives mode {} (from 1) a frequency of {hz:.1e} Hz on \
             the contact, above {TOO_FAST:.0e} Hz; check the units N/m^3 and m^2 and the mass normalisation of the \
             shapes, in 1/sqrt(kg)",
            mode + 1
        )))
    }

    /// Checks that the surface is that of a body with this ball.
    fn check_surface(&self) -> Result<(), ImportedModesError> {
        let Some(surface) = &self.surface else {
            return Ok(());
        };
        let distances = || surface.vertices.iter().map(|x| norm(*x));
        let nearest = distances().fold(f64::INFINITY, f64::min);
        let farthest = distances().fold(0.0, f64::max);
        let radius = self.ball_radius();
        if nearest <= NEAREST * radius && (0.5 * radius..=FARTHEST).contains(&farthest) {
            return Ok(());
        }
        Err(Content(format!(
            "`surface_vertices` have distances from {nearest:.3e} to {farthest:.3e} m from the origin, but the radius \
             of the ball is {radius:.3e} m; give them in m with the origin at the centre of the ball, like `positions`"
        )))
    }
}

/// Reads the natural frequencies, rad/s, in ascending order; all modes are elastic.
fn frequencies(arrays: &mut Arrays<'_>) -> Result<Vec<f64>, ImportedModesError> {
    let in_hertz = arrays.len(&FREQUENCIES)?.is_some();
    if in_hertz && arrays.len(&OMEGA)?.is_some() {
        let text = "the file contains both `omega` and `frequencies_hz`; remove one of them";
        return Err(Content(text.to_owned()));
    }
    let (named, per_hertz) = if in_hertz {
        (&FREQUENCIES, 1.0)
    } else {
        (&OMEGA, TAU)
    };
    let stated = arrays.counted(named, MAX_MODES)?;
    let fault = |at: usize, problem: &str| {
        let hz = stated[at] / per_hertz;
        Err(Content(format!(
            "`{}`[{at}] is {hz:.3e} Hz, {problem}",
            named.0
        )))
    };
    if let Some(before) = stated.windows(2).position(|pair| pair[1] < pair[0]) {
        return fault(
            before + 1,
            "below the previous value; sort the modes by frequency, including their shapes",
        );
    }
    if stated[0] < RIGID_BELOW * per_hertz {
        return fault(
            0,
            "a rigid-body mode; remove rigid-body modes, so that the first mode is elastic",
        );
    }
    if let Some(at) = stated.iter().position(|x| *x > TOO_FAST * per_hertz) {
        return fault(
            at,
            "above the limit of 1e7 Hz: the step size follows the highest frequency; check the unit, and remove modes \
             that are not excited",
        );
    }
    Ok(stated.iter().map(|x| TAU / per_hertz * x).collect())
}

/// Converts `(points, 3, modes)` in the file to `points x modes` vectors.
fn vectors(rows: &[f64], modes: usize) -> Vec<[f64; 3]> {
    let points = rows.chunks_exact(3 * modes);
    let shape = |point: &[f64], i| [0, 1, 2].map(|axis| point[axis * modes + i]);
    points
        .flat_map(|point| (0..modes).map(move |i| shape(point, i)))
        .collect()
}

/// Reads the optional surface.
fn surface(
    arrays: &mut Arrays<'_>,
    modes: usize,
) -> Result<Option<SurfaceMesh>, ImportedModesError> {
    let Some(count) = arrays.len(&VERTICES)? else {
        return Ok(None);
    };
    let vertices = arrays.need(&VERTICES, &[count, 3])?;
    let triangles = arrays.len(&TRIANGLES)?.unwrap_or(0);
    let corners = arrays.indices(&TRIANGLES, &[triangles, 3], count)?;
    let shapes = arrays.need(&SURFACE_SHAPES, &[count, 3, modes])?;
    let corners: Vec<u32> = corners.iter().map(|corner| *corner as u32).collect();
    Ok(Some(SurfaceMesh {
        vertices: vertices.as_chunks().0.to_vec(),
        triangles: corners.as_chunks().0.to_vec(),
        shapes: vectors(&shapes, modes),
        modes,
    }))
}
