//! Orbits to start from: from a settled motion, from a Hopf point, and on branches that cross at a bifurcation.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use super::cyclic::{Segment, eigenvector, singular_direction};
use super::flow::{Flow, jumps, slope_in};
use super::newton::{Constraint, Precision};
use super::shooting::{Direction, Scale, ShootingPoint, sizes_of};
use super::{
    Bifurcation, BifurcationKind, ContinuationError, ContinuationOptions, Family, PeriodicOrbit,
};
use crate::{Integrator, System};

/// Segments of a small orbit at a Hopf point: enough for the phase condition.
const HOPF_SEGMENTS: usize = 4;

/// An orbit from which a branch is followed.
#[derive(Clone, Debug)]
pub struct BranchStart {
    /// The orbit.
    pub orbit: PeriodicOrbit,
    /// Where the branch comes from: the branch is followed in the direction from there to the orbit. `None` follows it in
    /// both directions.
    pub(super) origin: Option<ShootingPoint>,
}

impl From<PeriodicOrbit> for BranchStart {
    fn from(orbit: PeriodicOrbit) -> Self {
        Self {
            orbit,
            origin: None,
        }
    }
}

/// The search for the period of a settled motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReturnSearch {
    /// Time to simulate first, s.
    pub settle_s: f64,
    /// Maximum period, s.
    pub max_period_s: f64,
    /// Distance from the start below which the motion has returned, relative to its size.
    pub tolerance: f64,
}

/// A Hopf point: an equilibrium with a pair of imaginary eigenvalues.
#[derive(Clone, Debug, PartialEq)]
pub struct HopfPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// The equilibrium, without quadratures.
    pub state: Vec<f64>,
    /// Circular frequency, rad/s.
    pub omega: f64,
    /// Real part of the eigenvector for the eigenvalue `i omega`.
    pub real: Vec<f64>,
    /// Imaginary part of that eigenvector.
    pub imaginary: Vec<f64>,
}

/// The orbit near a settled motion.
///
/// The period of an autonomous system is the time of the first return to the neighbourhood of the start, that of a forced
/// system a multiple of the period of the drive. Newton's method then finds the orbit.
///
/// # Errors
/// [`ContinuationError::NoReturn`] if the motion does not return, for example because it is not periodic, and those of
/// Newton's method.
pub fn settled_orbit(
    family: &dyn Family,
    parameter: f64,
    state: &[f64],
    search: &ReturnSearch,
    options: &ContinuationOptions,
) -> Result<PeriodicOrbit, ContinuationError> {
    let mut flow = Flow::new(family, options)?;
    let sys = flow.system(parameter)?;
    let (guess, sizes) = find_return(family, sys.as_ref(), parameter, state, search, options)?;
    let scale = Scale::new(sys.as_ref(), sizes, guess.period, flow.width());
    let guess = flow.divide(sys.as_ref(), &guess, &scale)?;
    let scale = flow.scale(&guess)?;
    let precision = Precision::Location;
    let point = flow.point(&guess, &scale, Constraint::Parameter, precision)?;
    Ok(point.orbit)
}

/// Simulates a motion until it returns to its state after the settling time. Returns the orbit in one segment, and the sizes of
/// its vibration and first-order components.
fn find_return(
    family: &dyn Family,
    sys: &dyn System,
    parameter: f64,
    state: &[f64],
    search: &ReturnSearch,
    options: &ContinuationOptions,
) -> Result<(ShootingPoint, [f64; 2]), ContinuationError> {
    let failed = |source| ContinuationError::Integration { parameter, source };
    let n = sys.tangent_dim();
    let drive = family.drive_period(parameter);
    let mut integrator = Integrator::new(options.method, sys).map_err(failed)?;
    if jumps(sys) {
        integrator = integrator.with_events().map_err(failed)?;
    }
    let mut full = state.to_vec();
    full.resize(sys.dim(), 0.0);
    integrator.start(0.0, &full).map_err(failed)?;
    // A forced motion is needed at phase zero of its drive.
    let settle = drive.map_or(search.settle_s, |drive| {
        (search.settle_s / drive).ceil() * drive
    });
    integrator.integrate_to(settle).map_err(failed)?;
    let start = DVector::from_column_slice(&integrator.state()[..n]);
    let slope = slope_in(sys, integrator.status(), settle, integrator.state());
    let mut returns = ReturnTest {
        sys,
        start: start.clone(),
        slope,
        sizes: [0.0; 2],
        best: f64::INFINITY,
        tolerance: search.tolerance,
    };
    let mut z = vec![0.0; sys.dim()];
    let mut previous: Option<(f64, Vec<f64>)> = None;
    let end = settle + search.max_period_s * (1.0 + 1e-9);
    let mut count = 1;
    let mut t = settle;
    while t < end {
        let next = t + integrator.step_size();
        let due = drive.map(|drive| settle + f64::from(count) * drive);
        t = due.map_or(next, |due| next.min(due));
        integrator.sample(t, &mut z).map_err(failed)?;
        returns.widen(&z);
        let sizes = returns.sizes.map(|size| 0.5 * size);
        let found = |period, drive_periods| {
            let orbit = ShootingPoint {
                parameter,
                period,
                drive_periods,
                phases: vec![0.0],
                states: vec![start.clone()],
                statuses: Vec::new(),
            };
            (orbit, sizes)
        };
        match due {
            Some(due) if t >= due => {
                if returns.is_back(&z[..n]) {
                    return Ok(found(due - settle, Some(count)));
                }
                count += 1;
            }
            Some(_) => {}
            None => {
                let crossing = previous
                    .as_ref()
                    .and_then(|(before, state)| returns.crossing([*before, t], [state, &z]));
                if let Some(time) = crossing {
                    return Ok(found(time - settle, None));
                }
            }
        }
        previous = Some((t, z.clone()));
    }
    Err(ContinuationError::NoReturn {
        time_s: search.max_period_s,
        distance: returns.best,
    })
}

/// A motion that may return to its start.
struct ReturnTest<'a> {
    sys: &'a dyn System,
    start: DVector<f64>,
    /// `dz/dt` at the start.
    slope: DVector<f64>,
    /// Largest distances of vibration and first-order components from the start.
    sizes: [f64; 2],
    /// Distance of the closest return, relative to the size.
    best: f64,
    tolerance: f64,
}

impl ReturnTest<'_> {
    /// Takes a state into account for the size of the motion.
    fn widen(&mut self, z: &[f64]) {
        let sizes = self.distances(z);
        self.sizes = [0, 1].map(|part| self.sizes[part].max(sizes[part]));
    }

    /// Distances of vibration and first-order components from the start.
    fn distances(&self, z: &[f64]) -> [f64; 2] {
        let pairs = z.iter().zip(self.start.iter());
        let difference: Vec<f64> = pairs.map(|(z, start)| z - start).collect();
        sizes_of(self.sys, &difference)
    }

    /// Whether a state is close to the start.
    fn is_back(&mut self, z: &[f64]) -> bool {
        let distances = self.distances(z);
        let relative = [0, 1].map(|part| match self.sizes[part] {
            0.0 => 0.0,
            size => distances[part] / size,
        });
        let distance = relative[0].max(relative[1]);
        self.best = self.best.min(distance);
        distance <= self.tolerance
    }

    /// The time at which the motion crosses the section through the start between two samples, if it is back there.
    fn crossing(&mut self, [from, to]: [f64; 2], [before, after]: [&[f64]; 2]) -> Option<f64> {
        let m = self.sys.modes();
        let height = |z: &[f64]| -> f64 {
            let terms = (0..self.start.len()).map(|i| {
                let unit = if i < m {
                    super::shooting::unit_of(self.sys.omega()[i])
                } else {
                    1.0
                };
                unit * unit * self.slope[i] * (z[i] - self.start[i])
            });
            terms.sum()
        };
        let [low, high] = [height(before), height(after)];
        if !(low < 0.0 && high >= 0.0) {
            return None;
        }
        let share = low / (low - high);
        let between: Vec<f64> = before
            .iter()
            .zip(after)
            .map(|(a, b)| a + share * (b - a))
            .take(self.start.len())
            .collect();
        self.is_back(&between).then_some(from + share * (to - from))
    }
}

/// A small orbit of the branch born at a Hopf point, with about the given amplitude in the unit of
/// [`Family::observable`]. The parameter follows from the amplitude.
///
/// # Errors
/// Those of Newton's method.
pub fn hopf_orbit(
    family: &dyn Family,
    hopf: &HopfPoint,
    amplitude: f64,
    options: &ContinuationOptions,
) -> Result<BranchStart, ContinuationError> {
    let mut flow = Flow::new(family, options)?;
    let column = |values: &[f64]| DVector::from_column_slice(values);
    let (equilibrium, real, imaginary) = (
        column(&hopf.state),
        column(&hopf.real),
        column(&hopf.imaginary),
    );
    let turn = |phase: f64| {
        let (sin, cos) = (TAU * phase).sin_cos();
        &real * cos - &imaginary * sin
    };
    // The observable is linear for small displacements.
    let range = (0..64).map(|k| {
        let z = &equilibrium + turn(f64::from(k) / 64.0);
        family.observable(hopf.parameter, z.as_slice())
    });
    let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    let factor = 2.0 * amplitude / (high - low);
    let phases: Vec<f64> = (0..HOPF_SEGMENTS)
        .map(|k| k as f64 / HOPF_SEGMENTS as f64)
        .collect();
    let at_rest = ShootingPoint {
        parameter: hopf.parameter,
        period: TAU / hopf.omega,
        drive_periods: None,
        states: vec![equilibrium.clone(); HOPF_SEGMENTS],
        statuses: Vec::new(),
        phases,
    };
    let direction = Direction {
        parameter: 0.0,
        period: 0.0,
        states: at_rest
            .phases
            .iter()
            .map(|&phase| turn(phase) * factor)
            .collect(),
    };
    start_along(&mut flow, &at_rest, &direction)
}

/// An orbit of the branch that crosses at a bifurcation: that of twice the period at a period doubling, or the other
/// branch at a branch point. `amplitude` is the distance from the branch relative to the size of the orbit, for example
/// 0.01.
///
/// # Errors
/// [`ContinuationError::NoSwitch`] for bifurcations without such a branch, and those of Newton's method.
pub fn switched_orbit(
    family: &dyn Family,
    bifurcation: &Bifurcation,
    amplitude: f64,
    options: &ContinuationOptions,
) -> Result<BranchStart, ContinuationError> {
    let doubles = match bifurcation.kind {
        BifurcationKind::PeriodDoubling => true,
        BifurcationKind::BranchPoint | BifurcationKind::SymmetryBreaking => false,
        BifurcationKind::Fold => {
            return Err(ContinuationError::NoSwitch {
                why: "a branch turns at a fold; continue it",
            });
        }
        BifurcationKind::NeimarkSacker => {
            return Err(ContinuationError::NoSwitch {
                why: "a torus is born at a Neimark-Sacker point; simulate it from beyond the point",
            });
        }
        BifurcationKind::Grazing => {
            return Err(ContinuationError::NoSwitch {
                why: "the flow is not differentiable at a grazing; start from a simulation beyond it",
            });
        }
    };
    let mut flow = Flow::new(family, options)?;
    let mut shot = ShootingPoint::of(&bifurcation.orbit);
    let scale = flow.scale(&shot)?;
    let mut direction = if doubles {
        flip_direction(&mut flow, &shot, &scale)?
    } else {
        crossing_direction(&mut flow, &shot, &scale)?
    };
    if doubles {
        let (phases, starts) = (shot.phases.clone(), shot.states.clone());
        shot.phases = phases.iter().map(|phase| 0.5 * phase).collect();
        shot.phases
            .extend(phases.iter().map(|phase| 0.5 + 0.5 * phase));
        shot.states.extend(starts);
        shot.period *= 2.0;
        shot.drive_periods = shot.drive_periods.map(|count| 2 * count);
        let reversed: Vec<_> = direction.states.iter().map(|state| -state).collect();
        direction.states.extend(reversed);
    }
    let norm = scale.norm(&direction);
    start_along(&mut flow, &shot, &direction.scaled(amplitude / norm))
}

/// The direction at the starts of the segments that returns reversed after a period.
fn flip_direction(
    flow: &mut Flow<'_>,
    shot: &ShootingPoint,
    scale: &Scale,
) -> Result<Direction, ContinuationError> {
    let sys = flow.system(shot.parameter)?;
    let ends = flow.segments(sys.as_ref(), shot, true)?;
    let maps: Vec<_> = ends.maps.iter().map(|map| scale.scaled_map(map)).collect();
    let vectors = eigenvector(&maps, Complex::new(-1.0, 0.0));
    // A complex factor is arbitrary; the largest component becomes real.
    let largest = vectors[0]
        .iter()
        .fold(Complex::new(0.0, 0.0), |max: Complex<f64>, x| {
            if x.norm() > max.norm() { *x } else { max }
        });
    let turn = largest.conj() / largest.norm();
    let states = vectors
        .iter()
        .map(|vector| scale.unscaled_state(&vector.map(|x| (x * turn).re)));
    Ok(Direction {
        parameter: 0.0,
        period: 0.0,
        states: states.collect(),
    })
}

/// The direction of another branch at a branch point: states and period at the same parameter, orthogonal to the flow at
/// phase zero.
fn crossing_direction(
    flow: &mut Flow<'_>,
    shot: &ShootingPoint,
    scale: &Scale,
) -> Result<Direction, ContinuationError> {
    let sys = flow.system(shot.parameter)?;
    let ends = flow.segments(sys.as_ref(), shot, true)?;
    let n = shot.states[0].len();
    let b = usize::from(shot.drive_periods.is_none());
    let count = shot.len();
    let segments: Vec<_> = (0..count)
        .map(|k| {
            let mut columns = DMatrix::zeros(n, b);
            let mut border = DMatrix::zeros(b, n);
            if b == 1 {
                let [from, to] = shot.span(k);
                let slope = &ends.slopes[k] * ((to - from) * scale.period);
                columns.set_column(0, &scale.scaled_state(&slope));
                let flow = scale.scaled_state(&ends.slopes[(k + count - 1) % count]);
                border.set_row(0, &flow.normalize().transpose());
            }
            Segment {
                map: scale.scaled_map(&ends.maps[k]),
                columns,
                right: DMatrix::zeros(n, 0),
                border,
            }
        })
        .collect();
    let found = singular_direction(&segments, DMatrix::zeros(b, b));
    let found = found.ok_or(ContinuationError::NoSwitch {
        why: "the equations of the orbit are not singular",
    })?;
    Ok(Direction {
        parameter: 0.0,
        period: found.scalars.iter().map(|w| w * scale.period).sum(),
        states: found
            .states
            .iter()
            .map(|state| scale.unscaled_state(&state.column(0).into_owned()))
            .collect(),
    })
}

/// Corrects the orbit that lies in a direction from a known one.
fn start_along(
    flow: &mut Flow<'_>,
    origin: &ShootingPoint,
    direction: &Direction,
) -> Result<BranchStart, ContinuationError> {
    let guess = origin.moved(1.0, direction);
    let scale = flow.scale(&guess)?;
    let constraint = Constraint::Arclength {
        tangent: direction,
        target: &guess,
    };
    // Close to the bifurcation the equations are nearly singular.
    let precision = Precision::Branch;
    let point = flow.point(&guess, &scale, constraint, precision)?;
    Ok(BranchStart {
        orbit: point.orbit,
        origin: Some(origin.clone()),
    })
}
