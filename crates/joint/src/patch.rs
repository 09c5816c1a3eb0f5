//! The contact patch: quadrature points on a spherical cap around the load direction, each with an area and a
//! share of the pre-stress.
//!
//! In polar coordinates of the patch (distance `s` from the centre, angle `psi`) the Hertz pressure is
//! `p0 sqrt(1 - s^2/a^2)`. With `x = s^2/a^2` the load is `F = integral of (3/2) F sqrt(1 - x) dx` over
//! `[0, 1]`; equal intervals in `x` are equal areas.

use super::Quadrature;
use super::vector::{add_scaled, cross, dot, norm, scale, unit};
use crate::fem::gauss_rule;

/// A quadrature point in the coordinates of the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    /// Distance from the axis of the patch divided by its radius, 0 to 1.
    pub radius: f64,
    /// Polar angle in the patch, rad.
    pub angle: f64,
    /// Area divided by the area of the patch; the areas of all points sum to 1.
    pub area: f64,
    /// Load divided by the total load; the loads of all points sum to 1.
    pub load: f64,
}

/// A pressure distribution over the distance from the axis of the patch, scaled to carry the load.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureTable(Vec<[f64; 2]>);

impl PressureTable {
    /// A table of points, each a distance from the axis (m, from zero on, increasing) and a pressure (Pa): positive, but at
    /// the last point, where the patch ends, at least zero. `None` for other points.
    pub fn new(points: Vec<[f64; 2]>) -> Option<Self> {
        let (last, inner) = points.split_last()?;
        let is_valid = inner.first()?[0] == 0.0
            && points.windows(2).all(|pair| pair[0][0] < pair[1][0])
            && points.as_flattened().iter().all(|x| x.is_finite())
            && inner.iter().all(|point| point[1] > 0.0)
            && last[1] >= 0.0;
        is_valid.then_some(Self(points))
    }

    /// Radius of the patch, m.
    pub fn radius(&self) -> f64 {
        self.0[self.0.len() - 1][0]
    }

    /// Pressure at a distance (m) within the patch, Pa: linear between the points.
    fn at(&self, distance: f64) -> f64 {
        let next = self.0.partition_point(|point| point[0] <= distance);
        let next = next.clamp(1, self.0.len() - 1);
        let [[from, before], [to, after]] = [self.0[next - 1], self.0[next]];
        before + (after - before) * (distance - from) / (to - from)
    }

    /// Pressures (Pa) and areas (m^2) at points of a patch on a ball of some radius (m) that carries a load (N) along its
    /// axis. The areas are those of the sphere, so that this holds for wide patches, too.
    pub fn nodes(&self, points: &[PatchPoint], ball_radius: f64, load: f64) -> [Vec<f64>; 2] {
        let flat = std::f64::consts::PI * self.radius().powi(2);
        let pressures = points.iter().map(|p| self.at(p.radius * self.radius()));
        let pressures: Vec<f64> = pressures.collect();
        // A pressure on the sphere acts along the axis as on the projected area.
        let carried = points.iter().zip(&pressures);
        let carried: f64 = carried.map(|(point, p)| p * point.area * flat).sum();
        let areas = points.iter().map(|point| {
            let sine = point.radius * self.radius() / ball_radius;
            point.area * flat / (1.0 - sine * sine).sqrt()
        });
        let scaled = pressures.iter().map(|p| p * load / carried);
        [scaled.collect(), areas.collect()]
    }
}

/// Quadrature points for `count >= 1` contact nodes.
pub fn patch_points(quadrature: Quadrature, count: usize) -> Vec<PatchPoint> {
    match quadrature {
        Quadrature::Rings => ring_cells(count),
        Quadrature::Gauss => gauss_rings(count),
    }
}

/// Cells of equal area in rings. Each point carries the exact load of its cell and lies at the radius that
/// halves the area of the cell.
fn ring_cells(count: usize) -> Vec<PatchPoint> {
    let area = 1.0 / count as f64;
    let load_inside = |x: f64| 1.0 - (1.0 - x).max(0.0).powf(1.5);
    let mut points = Vec::with_capacity(count);
    let mut inside = 0;
    for (ring, cells) in ring_counts(count).into_iter().enumerate() {
        let (inner, outer) = (inside as f64 * area, (inside + cells) as f64 * area);
        let load = (load_inside(outer) - load_inside(inner)) / cells as f64;
        // A single cell at the centre is a disc: its point is the centre.
        let radius = if cells == 1 {
            0.0
        } else {
            (0.5 * (inner + outer)).sqrt()
        };
        for angle in ring_angles(ring, cells) {
            points.push(PatchPoint {
                radius,
                angle,
                area,
                load,
            });
        }
        inside += cells;
    }
    points
}

/// Numbers of cells in the rings, from the centre outwards: 1, 6, 12, ... scaled to the total count, which
/// gives cells of about equal width and height.
fn ring_counts(count: usize) -> Vec<usize> {
    // k complete rings contain 1 + 3 k (k + 1) cells.
    let rings = ((((12 * count - 3) as f64).sqrt() - 3.0) / 6.0).round() as usize;
    if rings == 0 {
        // Up to three cells: a single ring of sectors.
        return vec![count];
    }
    let whole = (3 * rings * (rings + 1)) as f64;
    let mut counts = vec![1];
    let (mut share, mut given) = (0, 0);
    for ring in 1..=rings {
        share += 6 * ring;
        // Rounding the cumulative sum distributes the remainder over the rings.
        let upto = ((count - 1) as f64 * share as f64 / whole).round() as usize;
        counts.push(upto - given);
        given = upto;
    }
    counts
}

/// Angles of `n` points of a ring. Successive rings are rotated by the golden angle, so that the layout has
/// no preferred direction.
fn ring_angles(ring: usize, n: usize) -> impl Iterator<Item = f64> {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    let step = std::f64::consts::TAU / n as f64;
    let offset = (ring as f64 * GOLDEN).rem_euclid(step);
    (0..n).map(move |k| offset + step * k as f64)
}

/// Gauss points along the radius, with equal angles in each ring.
fn gauss_rings(count: usize) -> Vec<PatchPoint> {
    if count < 3 {
        // Too few points for a ring with points in all directions.
        return ring_cells(count);
    }
    // About pi times as many points in a ring as rings gives an even spacing; at least 3 in a ring.
    let rings =
        ((count as f64 / std::f64::consts::TAU).sqrt().round() as usize).clamp(1, count / 3);
    let rule = rim_rule(rings);
    let radius = |pressure: f64| (1.0 - pressure.powi(2)).sqrt();
    let total: f64 = rule.iter().map(|[pressure, _]| radius(*pressure)).sum();
    let spare = count - 3 * rings;
    let mut points = Vec::with_capacity(count);
    let (mut share, mut given) = (0.0, 0);
    for (ring, [pressure, area]) in rule.into_iter().enumerate() {
        share += radius(pressure) / total;
        let upto = if ring + 1 == rings {
            spare
        } else {
            (spare as f64 * share).round() as usize
        };
        let n = 3 + upto - given;
        given = upto;
        let area = area / n as f64;
        for angle in ring_angles(ring, n) {
            points.push(PatchPoint {
                radius: radius(pressure),
                angle,
                area,
                load: 1.5 * pressure * area,
            });
        }
    }
    points
}

/// The `n`-point Gauss rule in `y = sqrt(1 - x)`, the Hertz pressure relative to that at the centre, from the centre
/// outwards: `y` and the share of the area of the patch.
///
/// The contact force has two parts, the pre-stress `(3/2) y` and the stiffness, which is 1 for a uniform
/// one. Both are integrated over `dx = -2 y dy`. The Gauss rule for the weight `2 y` on `[0, 1]` is exact
/// for polynomials in `y` up to degree `2n - 1`: for polynomials in `x` up to degree `n - 1` times either
/// part. A Gauss rule in `x` for one of them converges slowly for the other, whose ratio to it has a
/// singularity at the rim.
///
/// In `t = 2 y - 1` this is the Jacobi weight `1 + t`.
fn rim_rule(n: usize) -> Vec<[f64; 2]> {
    let diagonal = |k: f64| 1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0));
    let coupling = |k: f64| (k * (k + 1.0)).sqrt() / (2.0 * k + 1.0);
    let rule = gauss_rule(n, diagonal, coupling).into_iter().rev();
    rule.map(|[t, area]| [0.5 * (1.0 + t), area]).collect()
}

/// Unit vector from the centre of the ball to the centre of the patch: the +z pole opposite the beam,
/// tilted by `tilt` (rad) towards the azimuth (rad, from +x towards +y).
pub fn patch_direction(tilt: f64, azimuth: f64) -> [f64; 3] {
    [
        tilt.sin() * azimuth.cos(),
        tilt.sin() * azimuth.sin(),
        tilt.cos(),
    ]
}

/// Orthonormal frame of the contact patch in the axes of the body, in which the quadrature points are fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFrame {
    /// Unit vector from the centre of the ball to the centre of the patch.
    pub direction: [f64; 3],
    /// Tangent unit vector in which the centre of the patch moves with increasing tilt.
    pub ahead: [f64; 3],
    /// Unit vector normal to the plane in which the load tilts.
    pub aside: [f64; 3],
}

impl PatchFrame {
    /// The frame at a tilt (rad) towards an azimuth (rad). It rotates with the azimuth: a common rotation of tilt
    /// and angular velocity rotates the model.
    pub fn tilted(tilt: f64, azimuth: f64) -> Self {
        let direction = patch_direction(tilt, azimuth);
        let aside = [-azimuth.sin(), azimuth.cos(), 0.0];
        Self {
            direction,
            ahead: cross(aside, direction),
            aside,
        }
    }

    /// The frame turned by a rotation vector (rad), by the formula of Rodrigues.
    #[must_use]
    pub fn turned(self, by: [f64; 3]) -> Self {
        let Some(axis) = unit(by) else {
            return self;
        };
        let (sin, cos) = norm(by).sin_cos();
        let turn = |v| {
            let turned = add_scaled(scale(v, cos), sin, cross(axis, v));
            add_scaled(turned, (1.0 - cos) * dot(axis, v), axis)
        };
        Self {
            direction: turn(self.direction),
            ahead: turn(self.ahead),
            aside: turn(self.aside),
        }
    }

    /// Tilt towards an azimuth (rad), -pi to pi: the angle between the axis of the beam and the projection of the
    /// direction on the plane of the azimuth. It changes smoothly where the direction passes through the axis.
    pub fn tilt(&self, azimuth: f64) -> f64 {
        let [x, y, z] = self.direction;
        (x * azimuth.cos() + y * azimuth.sin()).atan2(z)
    }
}

/// Outward unit normal of the ball at a quadrature point, for a patch of radius `radius` (m) with a frame on a
/// ball of radius `ball_radius` (m). A patch wider than the ball is limited to its equator.
pub fn normal_at(
    point: &PatchPoint,
    frame: &PatchFrame,
    radius: f64,
    ball_radius: f64,
) -> [f64; 3] {
    let sine = (point.radius * radius / ball_radius).min(1.0);
    let cosine = (1.0 - sine * sine).sqrt();
    let outward = scale(frame.direction, cosine);
    let outward = add_scaled(outward, sine * point.angle.cos(), frame.ahead);
    add_scaled(outward, sine * point.angle.sin(), frame.aside)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [usize; 14] = [1, 2, 3, 4, 5, 7, 8, 28, 50, 91, 100, 201, 452, 10_000];

    #[test]
    fn any_count_carries_the_whole_load() {
        for quadrature in [Quadrature::Rings, Quadrature::Gauss] {
            for count in COUNTS {
                let points = patch_points(quadrature, count);
                assert_eq!(points.len(), count);
                let load: f64 = points.iter().map(|p| p.load).sum();
                assert!((load - 1.0).abs() < 1e-12, "{quadrature:?} {count}: {load}");
                assert!(points.iter().all(|p| p.load > 0.0 && p.area > 0.0));
                assert!(points.iter().all(|p| (0.0..1.0).contains(&p.radius)));
            }
        }
    }

    #[test]
    fn areas_cover_the_patch() {
        for quadrature in [Quadrature::Rings, Quadrature::Gauss] {
            for count in COUNTS {
                let points = patch_points(quadrature, count);
                let area: f64 = points.iter().map(|p| p.area).sum();
                assert!((area - 1.0).abs() < 1e-12, "{quadrature:?} {count}: {area}");
            }
        }
    }

    /// Moments of the pressure: the integral of p s^2 is (2/5) F a^2, exactly for Gauss points, with
    /// second-order convergence in the cell size (first order in the count) for rings; odd moments vanish.
    #[test]
    fn moments() {
        for count in [28, 100, 452] {
            let points = patch_points(Quadrature::Gauss, count);
            let second: f64 = points.iter().map(|p| p.load * p.radius.powi(2)).sum();
            assert!((second - 0.4).abs() < 1e-13, "{second}");
        }
        let error = |count| {
            let points = patch_points(Quadrature::Rings, count);
            let second: f64 = points.iter().map(|p| p.load * p.radius.powi(2)).sum();
            (second - 0.4).abs()
        };
        let (coarse, fine) = (error(100), error(1600));
        assert!(
            coarse < 1.0 / 100.0 && fine < coarse / 14.0,
            "{coarse} {fine}"
        );
        for quadrature in [Quadrature::Rings, Quadrature::Gauss] {
            let points = patch_points(quadrature, 100);
            let first: f64 = points
                .iter()
                .map(|p| p.load * p.radius * p.angle.cos())
                .sum();
            assert!(first.abs() < 1e-13);
        }
    }

    /// The integrals of x^j and of (3/2) sqrt(1 - x) x^j, which is (3/2) B(j + 1, 3/2).
    #[test]
    fn gauss_rule_is_exact_for_uniform_and_hertz_weights() {
        let rule = rim_rule(6);
        let mut loaded = 1.0;
        for j in 0..6 {
            let sum = |weight: &dyn Fn(&[f64; 2]) -> f64| -> f64 {
                let terms = rule
                    .iter()
                    .map(|point| weight(point) * (1.0 - point[0].powi(2)).powi(j));
                terms.sum()
            };
            let (uniform, hertz) = (
                sum(&|[_, area]| *area),
                sum(&|[pressure, area]| 1.5 * pressure * area),
            );
            assert!(
                (uniform - 1.0 / f64::from(j + 1)).abs() < 1e-14,
                "degree {j}"
            );
            assert!((hertz - loaded).abs() < 1e-14, "degree {j}");
            loaded *= f64::from(j + 1) / (f64::from(j) + 2.5);
        }
    }

    #[test]
    fn normals_lie_on_the_cap() {
        let frame = PatchFrame::tilted(0.1, 2.0);
        let direction = frame.direction;
        for point in patch_points(Quadrature::Rings, 100) {
            let normal = normal_at(&point, &frame, 1.7e-3, 15.875e-3);
            assert!((norm(normal) - 1.0).abs() < 1e-14);
            let sine = norm(cross(normal, direction));
            assert!((sine * 15.875 - point.radius * 1.7).abs() < 1e-12);
            assert!(dot(normal, direction) > 0.99);
        }
        let far = PatchPoint {
            radius: 0.9,
            angle: 0.3,
            area: 1.0,
            load: 1.0,
        };
        let equator = normal_at(&far, &frame, 1.0, 15.875e-3);
        assert!(dot(equator, direction).abs() < 1e-15);
    }

    /// A turn about the normal of the plane of the load changes the tilt by its angle, through the axis of the
    /// beam: a tilt of -8 degrees is one of 8 degrees towards the opposite azimuth. The frame moves continuously.
    #[test]
    fn a_turn_about_the_normal_of_the_tilt_plane_changes_the_tilt() {
        let azimuth = 135_f64.to_radians();
        let start = PatchFrame::tilted(-0.14, azimuth);
        for k in 0..=28 {
            let by = 0.01 * f64::from(k);
            let turned = start.turned(scale(start.aside, by));
            let expected = PatchFrame::tilted(-0.14 + by, azimuth);
            for (found, expected) in [
                (turned.direction, expected.direction),
                (turned.ahead, expected.ahead),
                (turned.aside, expected.aside),
            ] {
                let error = norm(add_scaled(found, -1.0, expected));
                assert!(error < 1e-15, "{by}: {error:e}");
            }
            assert!((turned.tilt(azimuth) - (by - 0.14)).abs() < 1e-15);
        }
        let opposite = patch_direction(0.14, azimuth + std::f64::consts::PI);
        assert!(norm(add_scaled(start.direction, -1.0, opposite)) < 1e-15);
        assert_eq!(start.turned([0.0; 3]), start);
    }
}
