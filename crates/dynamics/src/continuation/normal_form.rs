//! How the motion beyond a Neimark-Sacker point or a period doubling is born: the cubic coefficient of the normal form of
//! the return map.
//!
//! The return map takes a state of a section through the orbit, orthogonal to the flow, to its next return there; for a
//! forced system it is the map over the period of the drive. The coefficient of a Neimark-Sacker point is the real part of
//! that of the pair `exp(+-i phi)` of its derivative, divided by `exp(i phi)`.
//!
//! The derivatives are central differences of the map. The step is chosen for the smallest change of the coefficient under
//! halving, which is the error. Where a kink of the flow is closer than this step, the change is large, and nothing is
//! claimed.

use nalgebra::{Complex, DMatrix};

use super::flow::{Flow, slope_in, with_quadratures};
use super::point::Point;
use super::shooting::{Scale, ShootingPoint};
use super::{ContinuationError, Criticality, MotionBirth, Multiplier};
use crate::normal_form::{ComplexVector, Critical, RealVector};

/// First step of the differences, relative to the size of the orbit.
const STEP: f64 = 0.05;
/// Number of steps, each half of the one before.
const STEPS: i32 = 6;
/// A coefficient is zero within this multiple of its error.
const SIGNIFICANT: f64 = 4.0;
/// Share of the period before the end of which the return to the section is sought.
const MARGIN: f64 = 0.05;
/// Newton iterations for the time of the return.
const RETURNS: usize = 4;

impl Flow<'_> {
    /// How the motion beyond a bifurcation is born; `critical` is the multiplier on the unit circle. `None` if the map cannot
    /// be evaluated around the orbit.
    pub fn birth(&mut self, point: &Point, critical: Multiplier) -> Option<MotionBirth> {
        let mut map = ReturnMap::new(self, point).ok()?;
        let multiplier = Complex::from_polar(1.0, critical.angle);
        let pair = Critical::new(
            eigenvectors(&map.derivative, multiplier)?,
            |i, j| map.derivative[(i, j)],
            [Complex::ONE, multiplier * multiplier],
        );
        let found = (0..STEPS).map(|k| {
            map.step = STEP * 0.5_f64.powi(k);
            if critical.is_real() {
                pair.of_flip(&mut |u| map.along(u))
            } else {
                let (coefficient, _) = pair.of_pair(&mut |u| map.along(u))?;
                Some((multiplier.conj() * coefficient).re)
            }
        });
        let found: Vec<f64> = found.collect::<Option<_>>()?;
        let pairs = found
            .windows(2)
            .map(|pair| [pair[1], (pair[1] - pair[0]).abs()]);
        let [coefficient, coefficient_error] = pairs.min_by(|a, b| a[1].total_cmp(&b[1]))?;
        // A positive coefficient of the period doubling, and a negative one of the torus, belong to attracting motions.
        let attracts = (coefficient > 0.0) == critical.is_real();
        Some(MotionBirth {
            criticality: match (
                coefficient.abs() > SIGNIFICANT * coefficient_error,
                attracts,
            ) {
                (false, _) => Criticality::Undetermined,
                (true, true) => Criticality::Supercritical,
                (true, false) => Criticality::Subcritical,
            },
            coefficient,
            coefficient_error,
        })
    }
}

/// The return map around an orbit, in orthonormal coordinates of the section in the scaled state.
struct ReturnMap<'a, 'f> {
    flow: &'a mut Flow<'f>,
    start: ShootingPoint,
    scale: Scale,
    /// Directions of the section, as columns.
    section: DMatrix<f64>,
    /// `dz/dt` at the start in scaled coordinates; `None` for a forced system.
    normal: Option<RealVector>,
    /// The derivative of the map.
    derivative: DMatrix<f64>,
    /// Length of the steps of the differences.
    step: f64,
}

impl<'a, 'f> ReturnMap<'a, 'f> {
    fn new(flow: &'a mut Flow<'f>, point: &Point) -> Result<Self, ContinuationError> {
        let shot = &point.shot;
        let sys = flow.system(shot.parameter)?;
        let n = shot.states[0].len();
        let scale = point.scale.clone();
        let full = with_quadratures(sys.as_ref(), &shot.states[0]);
        let status = shot.status(0).unwrap_or_default();
        let normal = shot
            .drive_periods
            .is_none()
            .then(|| scale.scaled_state(&slope_in(sys.as_ref(), status, 0.0, &full)));
        let section = match &normal {
            None => DMatrix::identity(n, n),
            Some(normal) => complement(normal),
        };
        let mut monodromy = DMatrix::identity(n, n);
        for map in &point.maps {
            monodromy = map * monodromy;
        }
        Ok(Self {
            derivative: section.transpose() * monodromy * &section,
            start: shot.with_segments(vec![0.0], vec![shot.states[0].clone()]),
            flow,
            scale,
            section,
            normal,
            step: STEP,
        })
    }

    /// The distance from the orbit after one return, from a distance from it.
    fn image(&mut self, from: &RealVector) -> Result<RealVector, ContinuationError> {
        let sys = self.flow.system(self.start.parameter)?;
        let origin = self.start.states[0].clone();
        let mut shot = self.start.clone();
        shot.states[0] += (&self.section * from).component_div(&self.scale.state);
        let distance = |scale: &Scale, end: &RealVector| scale.scaled_state(&(end - &origin));
        let Some(normal) = self.normal.clone() else {
            let ends = self.flow.segments(sys.as_ref(), &shot, false)?;
            return Ok(self.section.transpose() * distance(&self.scale, &ends.ends[0]));
        };
        let rest = MARGIN * shot.period;
        shot.period -= rest;
        shot.states = self.flow.segments(sys.as_ref(), &shot, false)?.ends;
        shot.period = rest;
        let mut end = origin.clone();
        for _ in 0..RETURNS {
            let ends = self.flow.segments(sys.as_ref(), &shot, false)?;
            let slope = self.scale.scaled_state(&ends.slopes[0]);
            let change = -normal.dot(&distance(&self.scale, &ends.ends[0])) / normal.dot(&slope);
            end = &ends.ends[0] + &ends.slopes[0] * change;
            shot.period += change;
        }
        Ok(self.section.transpose() * distance(&self.scale, &end))
    }

    /// The second and third derivatives of the map along a direction.
    fn along(&mut self, direction: &RealVector) -> Option<[RealVector; 2]> {
        let size = direction.norm();
        if size == 0.0 {
            return Some([direction.clone(), direction.clone()]);
        }
        // The step has a fixed length.
        let step = self.step / size;
        let mut at = |k: f64| self.image(&(direction * (k * step))).ok();
        let (a, b, c, d) = (at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?);
        // The orbit itself returns to distance zero.
        let second = ((&b + &c) * 16.0 - (&a + &d)) / (12.0 * step * step);
        let third = (d - a - (c - b) * 2.0) / (2.0 * step.powi(3));
        Some([second, third])
    }
}

/// An orthonormal basis of the directions orthogonal to a vector, as columns.
fn complement(normal: &RealVector) -> DMatrix<f64> {
    let n = normal.len();
    // The reflection that takes the normal to a multiple of the first axis takes the other axes to the complement.
    let unit = normal.normalize();
    let sign = if unit[0] < 0.0 { -1.0 } else { 1.0 };
    let mut mirror = unit;
    mirror[0] += sign;
    let factor = 2.0 / mirror.norm_squared();
    DMatrix::from_fn(n, n - 1, |i, j| {
        let same = if i == j + 1 { 1.0 } else { 0.0 };
        same - factor * mirror[i] * mirror[j + 1]
    })
}

/// Right and left eigenvector for an eigenvalue on the unit circle: `q` of norm 1, and `p` with `p* q = 1`.
fn eigenvectors(matrix: &DMatrix<f64>, value: Complex<f64>) -> Option<[ComplexVector; 2]> {
    let n = matrix.nrows();
    let shifted = DMatrix::from_diagonal_element(n, n, value) - matrix.map(Complex::from);
    let svd = shifted.svd(true, true);
    let least =
        (0..n).min_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]))?;
    let q: ComplexVector = svd.v_t?.row(least).adjoint();
    let p: ComplexVector = svd.u?.column(least).into_owned();
    let product = p.dotc(&q);
    Some([q, p / product.conj()])
}
