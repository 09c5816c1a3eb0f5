//! Modes and contact patch of any body, from a file that another finite-element program filled.
//!
//! The file has the layout of [`crate::export::ModelArrays`], of which this much is read:
//!
//! | array | shape | meaning |
//! |---|---|---|
//! | `positions` | (n, 3) | contact nodes from the ball's centre, m |
//! | `normals` | (n, 3) | unit normals out of the ball |
//! | `areas` | (n) | area of each node, m^2 |
//! | `pre_stress` | (n) | contact pressure in steady sliding, Pa |
//! | `stiffness` | (n) | contact stiffness per area `k_c`, N/m^3 |
//! | `shapes` | (n, 3, m) | mass-normalised mode shapes, 1/sqrt(kg) |
//! | `omega` or `frequencies_hz` | (m) | natural frequencies, rad/s or Hz, ascending |
//!
//! and, where they are there,
//!
//! | array | shape | meaning |
//! |---|---|---|
//! | `probe` | (m) | row that gives what is heard, Eq. (24), 1/sqrt(kg); else that of the node nearest to the load, along its sliding velocity |
//! | `surface_vertices` | (v, 3) | the body's surface for pictures, m |
//! | `surface_triangles` | (t, 3) | its triangles, counter-clockwise from outside, vertices from 0 |
//! | `surface_shapes` | (v, 3, m) | mode shapes at its vertices, 1/sqrt(kg) |
//! | `mass` | (d, d) | mass matrix, kg; or `mass_data`, `mass_indices`, `mass_indptr`: the same in compressed sparse rows |
//! | `dof_shapes` | (d, m) | with it: the shapes at all degrees of freedom, so that `Phi^T M Phi = I` is checked |
//! | `version` | () | 1 |
//!
//! Rotation, friction, damping and start are the scene's; what a file of `squeakscope model` says
//! of them is not looked at.
//!
//! Limits: a contact node stays where it is on the body, so that the load cannot tilt. `shapes` are
//! not compared with `dof_shapes`: which degrees of freedom a contact node has is not known here.

mod arrays;
mod error;
mod mass;
mod model;
#[cfg(test)]
mod tests;

use std::path::Path;

pub use error::OwnModesError;

use self::arrays::{Arrays, Named};
use super::MOST_MODES;
use super::vector::{add_scaled, cross, dot, norm};
use crate::fem::SurfaceMesh;

/// The largest number of contact nodes.
pub const MOST_NODES: usize = 10_000;

/// Deviation of a normal's length from 1 that is rounding of single precision.
const UNIT_TOLERANCE: f64 = 1e-5;
/// Relative deviation of a node's distance from the ball's centre, and angle (rad) of its normal
/// against the line from there: as wide as the facets of a coarse mesh.
const SPHERE_TOLERANCE: f64 = 0.05;
/// Relative deviation of the pre-stress's sum from the load, and angle (rad) between the two.
const LOAD_TOLERANCE: f64 = 0.01;
const DIRECTION_TOLERANCE: f64 = 0.1 / 180.0 * std::f64::consts::PI;
/// What no elastic mode of a body that fits the hand is below, Hz.
const RIGID_BELOW: f64 = 1.0;
/// The highest frequency of a mode, by itself or pressed upon by the contact, Hz. Steps follow the fastest
/// one, tens to a period: already at this frequency a simulated second takes a billion of them, and nothing of a
/// squeak is within two decades of it.
const TOO_FAST: f64 = 1e7;
/// The farthest that the surface of a body reaches from the ball's centre, m; and how near it comes, in radii
/// of the ball, which is a part of it.
const FARTHEST: f64 = 10.0;
const NEAREST: f64 = 10.0;
/// Diameters that a ball can have, m.
const BALL_DIAMETERS: std::ops::RangeInclusive<f64> = 1e-3..=0.5;

const VERSION: Named = Named {
    name: "version",
    what: "the version of the layout, a single number",
};
const POSITIONS: Named = Named {
    name: "positions",
    what: "the contact nodes from the ball's centre, (nodes, 3), m",
};
const NORMALS: Named = Named {
    name: "normals",
    what: "the unit normals out of the ball, (nodes, 3)",
};
const AREAS: Named = Named {
    name: "areas",
    what: "the area of each contact node, (nodes), m^2",
};
const PRE_STRESS: Named = Named {
    name: "pre_stress",
    what: "the contact pressure at each node in steady sliding, (nodes), Pa",
};
const STIFFNESS: Named = Named {
    name: "stiffness",
    what: "the contact stiffness per area at each node, (nodes), N/m^3",
};
const SHAPES: Named = Named {
    name: "shapes",
    what: "the mass-normalised mode shapes at the contact nodes, (nodes, 3, modes), 1/sqrt(kg)",
};
const OMEGA: Named = Named {
    name: "omega",
    what: "the natural frequencies, (modes), rad/s (or `frequencies_hz`, Hz)",
};
const FREQUENCIES: Named = Named {
    name: "frequencies_hz",
    what: "the natural frequencies, (modes), Hz",
};
const PROBE: Named = Named {
    name: "probe",
    what: "the row that gives what is heard from the modal coordinates, (modes), 1/sqrt(kg)",
};
const VERTICES: Named = Named {
    name: "surface_vertices",
    what: "the vertices of the body's surface, (vertices, 3), m",
};
const TRIANGLES: Named = Named {
    name: "surface_triangles",
    what: "the corners of the surface's triangles, (triangles, 3)",
};
const SURFACE_SHAPES: Named = Named {
    name: "surface_shapes",
    what: "the mode shapes at the surface's vertices, (vertices, 3, modes), 1/sqrt(kg)",
};

/// Modes and contact patch of a body at one tilt, checked: `n` contact nodes, `m` modes.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnModes {
    name: String,
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    areas: Vec<f64>,
    pre_stress: Vec<f64>,
    stiffness: Vec<f64>,
    /// `n x m` row-major, 1/sqrt(kg).
    shapes: Vec<[f64; 3]>,
    /// rad/s.
    omega: Vec<f64>,
    probe: Option<Vec<f64>>,
    surface: Option<SurfaceMesh>,
}

impl OwnModes {
    /// Reads and checks a file; `name` is what it goes by in messages.
    ///
    /// # Errors
    /// The first fault found: an array that is missing, of another shape or type, not finite, out
    /// of its range, or not fitting the others; mode shapes that are not orthonormal, if there is a
    /// mass matrix to tell by.
    pub fn read(path: &Path, name: &str) -> Result<Self, OwnModesError> {
        let mut arrays = Arrays::open(path)?;
        if let Some(version) = arrays.optional(&VERSION, &[])?
            && version != [1.0]
        {
            return Err(OwnModesError::Version { found: version[0] });
        }
        let omega = frequencies(&mut arrays)?;
        let areas = arrays.counted(&AREAS, MOST_NODES)?;
        let (n, m) = (areas.len(), omega.len());
        let positions = arrays.need(&POSITIONS, &[n, 3])?;
        let normals = arrays.need(&NORMALS, &[n, 3])?;
        let pre_stress = arrays.need(&PRE_STRESS, &[n])?;
        let stiffness = arrays.need(&STIFFNESS, &[n])?;
        for (named, values) in [
            (&AREAS, &areas),
            (&PRE_STRESS, &pre_stress),
            (&STIFFNESS, &stiffness),
        ] {
            named.positive(values)?;
        }
        let shapes = vectors(&arrays.need(&SHAPES, &[n, 3, m])?, m);
        let probe = arrays.optional(&PROBE, &[m])?;
        if shapes.as_flattened().iter().all(|x| *x == 0.0) {
            return Err(SHAPES.zero("nothing at the contact would move"));
        }
        if probe.iter().any(|row| row.iter().all(|x| *x == 0.0)) {
            return Err(PROBE.zero("nothing would be heard"));
        }
        let modes = Self {
            name: name.to_owned(),
            positions: positions.as_chunks().0.to_vec(),
            normals: normals.as_chunks().0.to_vec(),
            areas,
            pre_stress,
            stiffness,
            shapes,
            omega,
            probe,
            surface: surface(&mut arrays, m)?,
        };
        modes.check_sphere()?;
        modes.check_contact()?;
        modes.check_surface()?;
        mass::check(&mut arrays, m)?;
        Ok(modes)
    }

    /// What the file goes by.
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

    /// Natural circular frequencies, rad/s.
    pub fn omega(&self) -> &[f64] {
        &self.omega
    }

    /// Radius of the ball, m: the mean distance of the contact nodes from its centre.
    pub fn ball_radius(&self) -> f64 {
        let total: f64 = self.positions.iter().map(|x| norm(*x)).sum();
        total / self.nodes() as f64
    }

    /// Radius of a round patch as large as that of the contact nodes, m.
    pub fn patch_radius(&self) -> f64 {
        (self.areas.iter().sum::<f64>() / std::f64::consts::PI).sqrt()
    }

    /// The body's surface for pictures, if the file has it.
    pub fn surface(&self) -> Option<&SurfaceMesh> {
        self.surface.as_ref()
    }

    /// Whether a load (N) that presses the ball along a unit vector is the one that the pre-stress
    /// carries.
    ///
    /// On a curved patch the pressures add up to less as vectors than as numbers; the load may be
    /// either sum or between them.
    ///
    /// # Errors
    /// [`OwnModesError::Load`] and [`OwnModesError::Direction`].
    pub fn check_load(&self, load: f64, direction: [f64; 3]) -> Result<(), OwnModesError> {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for ((area, stress), normal) in self.areas.iter().zip(&self.pre_stress).zip(&self.normals) {
            total += area * stress;
            sum = add_scaled(sum, area * stress, *normal);
        }
        let along = norm(sum);
        if load < along * (1.0 - LOAD_TOLERANCE) || load > total * (1.0 + LOAD_TOLERANCE) {
            return Err(OwnModesError::Load {
                carried: total,
                load,
            });
        }
        let angle = norm(cross(sum, direction)).atan2(dot(sum, direction));
        if angle > DIRECTION_TOLERANCE {
            let [x, y, z] = sum;
            // Rounded first, so that no rounding error is told as minus zero.
            let rounded = |deg: f64| (1e3 * deg).round() / 1e3 + 0.0;
            return Err(OwnModesError::Direction {
                tilt_deg: rounded(x.hypot(y).atan2(z).to_degrees()),
                azimuth_deg: rounded(y.atan2(x).to_degrees()),
                angle_deg: angle.to_degrees(),
            });
        }
        Ok(())
    }

    /// A number that changes with any number that the motion depends on (FNV-1a).
    pub fn fingerprint(&self) -> u64 {
        let vectors = [&self.positions, &self.normals, &self.shapes];
        let vectors = vectors.into_iter().flat_map(|v| v.as_flattened());
        let numbers = [&self.areas, &self.pre_stress, &self.stiffness, &self.omega];
        let numbers = numbers.into_iter().flatten();
        vectors
            .chain(numbers)
            .chain(self.probe.iter().flatten())
            .flat_map(|x| x.to_bits().to_le_bytes())
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
            })
    }

    /// The contact nodes must lie on a ball about the origin, and their normals point out of it.
    fn check_sphere(&self) -> Result<(), OwnModesError> {
        let radius = self.ball_radius();
        if !BALL_DIAMETERS.contains(&(2.0 * radius)) {
            return Err(OwnModesError::Radius { radius });
        }
        for (node, (x, normal)) in self.positions.iter().zip(&self.normals).enumerate() {
            let length = norm(*normal);
            if (length - 1.0).abs() > UNIT_TOLERANCE {
                return Err(OwnModesError::NotUnit { node, length });
            }
            let distance = norm(*x);
            if (distance / radius - 1.0).abs() > SPHERE_TOLERANCE {
                return Err(OwnModesError::OffSphere {
                    node,
                    distance,
                    radius,
                });
            }
            let angle = norm(cross(*x, *normal)).atan2(dot(*x, *normal));
            if angle > SPHERE_TOLERANCE {
                return Err(OwnModesError::Turned {
                    node,
                    angle_deg: angle.to_degrees(),
                });
            }
        }
        let total = self.areas.iter().sum();
        let ball = 4.0 * std::f64::consts::PI * radius * radius;
        if total > ball {
            return Err(OwnModesError::Areas { total, ball });
        }
        Ok(())
    }
}

impl OwnModes {
    /// The contact must not make any mode too fast: with a mode alone, its springs add
    /// `sum(stiffness * area * |shape|^2)` to the square of its circular frequency.
    fn check_contact(&self) -> Result<(), OwnModesError> {
        let springs: Vec<f64> = (self.stiffness.iter().zip(&self.areas))
            .map(|(stiffness, area)| stiffness * area)
            .collect();
        for mode in 0..self.modes() {
            let shapes = self.shapes[mode..].iter().step_by(self.modes());
            let added = springs.iter().zip(shapes).map(|(k, x)| k * dot(*x, *x));
            let hz = added.sum::<f64>().sqrt() / std::f64::consts::TAU;
            // Too large for a number, too.
            if hz.is_nan() || hz > TOO_FAST {
                return Err(OwnModesError::ContactTooFast {
                    mode: mode + 1,
                    hz,
                    limit: TOO_FAST,
                });
            }
        }
        Ok(())
    }

    /// The surface must be that of a body with this ball.
    fn check_surface(&self) -> Result<(), OwnModesError> {
        let Some(surface) = &self.surface else {
            return Ok(());
        };
        let distances = || surface.vertices.iter().map(|x| norm(*x));
        let nearest = distances().fold(f64::INFINITY, f64::min);
        let farthest = distances().fold(0.0, f64::max);
        let radius = self.ball_radius();
        let near = nearest <= NEAREST * radius;
        if near && (0.5 * radius..=FARTHEST).contains(&farthest) {
            return Ok(());
        }
        Err(OwnModesError::Surface {
            nearest,
            farthest,
            radius,
        })
    }
}

/// Natural frequencies, rad/s, in ascending order and those of elastic modes.
fn frequencies(arrays: &mut Arrays) -> Result<Vec<f64>, OwnModesError> {
    let in_hertz = arrays.shape(&FREQUENCIES)?.is_some();
    if in_hertz && arrays.shape(&OMEGA)?.is_some() {
        return Err(OwnModesError::TwoFrequencies);
    }
    let (named, per_hertz) = match in_hertz {
        true => (&FREQUENCIES, 1.0),
        false => (&OMEGA, std::f64::consts::TAU),
    };
    let stated = arrays.counted(named, MOST_MODES)?;
    named.positive(&stated)?;
    let array = named.name;
    if let Some(before) = stated.windows(2).position(|pair| pair[1] < pair[0]) {
        return Err(OwnModesError::Unsorted {
            array,
            at: before + 1,
        });
    }
    let hz = stated[0] / per_hertz;
    if hz < RIGID_BELOW {
        return Err(OwnModesError::RigidBody { array, at: 0, hz });
    }
    if let Some(at) = stated.iter().position(|x| x / per_hertz > TOO_FAST) {
        return Err(OwnModesError::TooFast {
            array,
            at,
            hz: stated[at] / per_hertz,
            limit: TOO_FAST,
        });
    }
    let omega = match in_hertz {
        true => stated.iter().map(|hz| std::f64::consts::TAU * hz).collect(),
        false => stated,
    };
    Ok(omega)
}

/// From `(points, 3, modes)` in the file to `points x modes` vectors.
fn vectors(rows: &[f64], modes: usize) -> Vec<[f64; 3]> {
    let points = rows.chunks_exact(3 * modes);
    points
        .flat_map(|point| {
            (0..modes).map(move |i| std::array::from_fn(|axis| point[axis * modes + i]))
        })
        .collect()
}

/// The surface for pictures, if there is one.
fn surface(arrays: &mut Arrays, modes: usize) -> Result<Option<SurfaceMesh>, OwnModesError> {
    let Some(shape) = arrays.shape(&VERTICES)? else {
        return Ok(None);
    };
    let count = shape.first().copied().unwrap_or(0);
    let vertices = arrays.need(&VERTICES, &[count, 3])?;
    let shape = arrays.shape(&TRIANGLES)?;
    let shape = shape.ok_or_else(|| TRIANGLES.incomplete(VERTICES.name))?;
    let triangles = shape.first().copied().unwrap_or(0);
    let corners = arrays.need(&TRIANGLES, &[triangles, 3])?;
    let is_vertex = |x: &f64| x.fract() == 0.0 && (0.0..count as f64).contains(x);
    if let Some(wrong) = corners.iter().position(|corner| !is_vertex(corner)) {
        return Err(OwnModesError::Triangle {
            triangle: wrong / 3,
            vertices: count,
        });
    }
    let shapes = arrays.belonging(&SURFACE_SHAPES, VERTICES.name, &[count, 3, modes])?;
    let corners: Vec<u32> = corners.iter().map(|corner| *corner as u32).collect();
    Ok(Some(SurfaceMesh {
        vertices: vertices.as_chunks().0.to_vec(),
        triangles: corners.as_chunks().0.to_vec(),
        shapes: vectors(&shapes, modes),
        modes,
    }))
}
