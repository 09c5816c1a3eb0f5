//! Orbits to start from: from a settled motion, from a Hopf point, and of twice the period at a period doubling.

use std::f64::consts::TAU;

use nalgebra::DVector;

use super::cyclic::{equations, null_direction, phase_row};
use super::flow::{Flow, slope_in};
use super::newton::Precision;
use super::shooting::{Direction, Scale, ShootingPoint, direction};
use super::{
    Bifurcation, BifurcationKind, ContinuationError, ContinuationOptions, Family, PeriodicOrbit,
};
use crate::equilibrium::{Eigenmode, Linearised};
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
    let (guess, sizes) = find_return(&flow, sys.as_ref(), parameter, state, search)?;
    let scale = Scale::new(sys.as_ref(), sizes, guess.period, flow.width());
    let guess = flow.divide(sys.as_ref(), &guess, &scale)?;
    let scale = flow.scale(&guess)?;
    Ok(flow.point(&guess, &scale, None, Precision::Location)?.orbit)
}

/// Simulates a motion until it returns to its state after the settling time. Returns the orbit in one segment, and the sizes of
/// its vibration and first-order components.
fn find_return(
    flow: &Flow<'_>,
    sys: &dyn System,
    parameter: f64,
    state: &[f64],
    search: &ReturnSearch,
) -> Result<(ShootingPoint, [f64; 2]), ContinuationError> {
    let failed = |source| ContinuationError::Integration { parameter, source };
    let n = sys.tangent_dim();
    let drive = flow.drive_period(parameter);
    let (mut integrator, mut z) =
        Integrator::started(flow.options.method, sys, state).map_err(failed)?;
    // A forced motion is needed at phase zero of its drive.
    let settle = drive.map_or(search.settle_s, |drive| {
        (search.settle_s / drive).ceil() * drive
    });
    integrator.integrate_to(settle).map_err(failed)?;
    let start = DVector::from_column_slice(&integrator.state()[..n]);
    let unit = Scale::new(sys, [1.0; 2], 1.0, 1.0);
    let slope = slope_in(sys, integrator.status(), settle, integrator.state());
    let slope = unit.scaled_state(&slope);
    // The largest distances from the start, and the closest return relative to them.
    let (mut sizes, mut closest) = ([0.0_f64; 2], f64::INFINITY);
    let mut last = DVector::zeros(n);
    let end = settle + search.max_period_s * (1.0 + 1e-9);
    let mut count = 1;
    let mut t = settle;
    while t < end {
        let from = t;
        let due = drive.map(|drive| settle + f64::from(count) * drive);
        t = (t + integrator.step_size()).min(due.unwrap_or(f64::INFINITY));
        integrator.sample(t, &mut z).map_err(failed)?;
        let now = DVector::from_column_slice(&z[..n]) - &start;
        let before = std::mem::replace(&mut last, now.clone());
        let norms = unit.norms(&now);
        sizes = [0, 1].map(|part| sizes[part].max(norms[part]));
        let (time, distance) = match due {
            Some(due) if t >= due => (due, now),
            Some(_) => continue,
            None => {
                // A free motion is back where it crosses the section through the start.
                let [low, high] = [&before, &now].map(|now| slope.dot(&unit.scaled_state(now)));
                if !(low < 0.0 && high >= 0.0) {
                    continue;
                }
                let share = low / (low - high);
                (from + share * (t - from), before.lerp(&now, share))
            }
        };
        let norms = unit.norms(&distance);
        let relative = [0, 1].map(|part| match sizes[part] {
            0.0 => 0.0,
            size => norms[part] / size,
        });
        let distance = relative[0].max(relative[1]);
        closest = closest.min(distance);
        if distance <= search.tolerance {
            let orbit = ShootingPoint {
                parameter,
                period: time - settle,
                drive_periods: drive.map(|_| count),
                phases: vec![0.0],
                states: vec![start],
                statuses: Vec::new(),
            };
            return Ok((orbit, sizes.map(|size| 0.5 * size)));
        }
        count += 1;
    }
    Err(ContinuationError::NoReturn {
        time_s: search.max_period_s,
        distance: closest,
    })
}

/// A small orbit of the branch born at a Hopf point, with about the given amplitude in the unit of the observable. The
/// Hopf point is given by the parameter, the system linearised there, and the mode with the imaginary eigenvalue. The
/// parameter of the orbit follows from the amplitude.
///
/// # Errors
/// Those of Newton's method.
pub fn hopf_orbit(
    family: &dyn Family,
    (parameter, linearised, mode): (f64, &Linearised, &Eigenmode),
    amplitude: f64,
    options: &ContinuationOptions,
) -> Result<BranchStart, ContinuationError> {
    let mut flow = Flow::new(family, options)?;
    let equilibrium = DVector::from_column_slice(&linearised.state);
    let parts = mode.vector.iter().zip(&linearised.scale);
    let vector = DVector::from_iterator(equilibrium.len(), parts.map(|(x, scale)| x / *scale));
    let turn = |phase: f64| {
        let (sin, cos) = (TAU * phase).sin_cos();
        vector.map(|x| x.re * cos - x.im * sin)
    };
    let factors = flow.member(parameter)?.observable;
    let observed = DVector::from_fn(64, |k, _| {
        let z = &equilibrium + turn(k as f64 / 64.0);
        let terms = factors.iter().zip(z.as_slice());
        terms.map(|(a, z)| a * z).sum::<f64>()
    });
    let factor = 2.0 * amplitude / (observed.max() - observed.min());
    let phases: Vec<f64> = (0..HOPF_SEGMENTS)
        .map(|k| k as f64 / HOPF_SEGMENTS as f64)
        .collect();
    let at_rest = ShootingPoint {
        parameter,
        period: TAU / mode.value.im,
        drive_periods: None,
        states: vec![equilibrium.clone(); HOPF_SEGMENTS],
        statuses: Vec::new(),
        phases,
    };
    let states: Vec<_> = at_rest
        .phases
        .iter()
        .map(|&phase| turn(phase) * factor)
        .collect();
    start_along(&mut flow, &at_rest, &direction(&states, 0.0, 0.0))
}

/// An orbit of the branch of twice the period that crosses at a period doubling. `amplitude` is the distance from the branch
/// relative to the size of the orbit, for example 0.01.
///
/// # Errors
/// [`ContinuationError::NoSwitch`] for other bifurcations, and those of Newton's method.
pub fn doubled_orbit(
    family: &dyn Family,
    bifurcation: &Bifurcation,
    amplitude: f64,
    options: &ContinuationOptions,
) -> Result<BranchStart, ContinuationError> {
    let none = |why| ContinuationError::NoSwitch { why };
    if bifurcation.kind != BifurcationKind::PeriodDoubling {
        return Err(none("the bifurcation is not a period doubling"));
    }
    let mut flow = Flow::new(family, options)?;
    let mut shot = ShootingPoint::of(&bifurcation.orbit);
    let scale = flow.scale(&shot)?;
    let sys = flow.system(shot.parameter)?;
    let ends = flow.segments(sys.as_ref(), &shot, true)?;
    let phase = phase_row(&shot, &ends, &scale);
    let mut entries = equations(&shot, &ends, &scale, &phase, true);
    // The period and the parameter stay as they are.
    let size = scale.units(shot.len()).len() - 2;
    entries.retain(|entry| entry.row < size && entry.col < size);
    let critical = null_direction(entries, size).ok_or(none(
        "the direction in which the equations of the orbit are singular is not unique",
    ))?;
    let later: Vec<f64> = shot.phases.iter().map(|phase| phase + 1.0).collect();
    shot.phases.extend(later);
    shot.phases.iter_mut().for_each(|phase| *phase *= 0.5);
    shot.states.extend_from_within(..);
    shot.period *= 2.0;
    shot.drive_periods = shot.drive_periods.map(|count| 2 * count);
    let change = critical.iter().copied().chain(critical.iter().map(|x| -x));
    let change = DVector::from_vec(change.chain([0.0; 2]).collect()).normalize() * amplitude;
    let units = scale.units(shot.len());
    start_along(&mut flow, &shot, &change.component_div(&units))
}

/// Corrects the orbit that lies in a direction from a known one.
fn start_along(
    flow: &mut Flow<'_>,
    origin: &ShootingPoint,
    direction: &Direction,
) -> Result<BranchStart, ContinuationError> {
    let guess = origin.moved(1.0, direction);
    let scale = flow.scale(&guess)?;
    // Close to the bifurcation the equations are nearly singular.
    let point = flow.point(&guess, &scale, Some(direction), Precision::Branch)?;
    Ok(BranchStart {
        orbit: point.orbit,
        origin: Some(origin.clone()),
    })
}
