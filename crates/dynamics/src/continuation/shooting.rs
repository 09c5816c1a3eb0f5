//! The unknowns of multiple shooting, differences of them, and their scales.

use nalgebra::{DMatrix, DVector};

use super::{ContinuationError, OrbitSegment, PeriodicOrbit};
use crate::System;
use crate::system::energy_units;

/// The states at the starts of the segments, one after another, the period and the parameter: a difference of two sets of
/// unknowns, for example a direction.
pub(super) type Direction = DVector<f64>;

/// A guess of an orbit, or an orbit: the unknowns of multiple shooting.
#[derive(Clone, Debug)]
pub(super) struct ShootingPoint {
    pub parameter: f64,
    /// Period, s.
    pub period: f64,
    /// Number of periods of the drive; `None` for an autonomous system.
    pub drive_periods: Option<u32>,
    /// Phases of the starts of the segments; the first is zero.
    pub phases: Vec<f64>,
    /// States at the starts of the segments, without quadratures.
    pub states: Vec<DVector<f64>>,
    /// Statuses at the starts of the segments, if they are known: a state is moved onto the constraint of its status, such
    /// as the velocity of a sticking mass, before it is integrated.
    pub statuses: Vec<Vec<u8>>,
}

/// A direction from its parts.
pub(super) fn direction<'a>(
    states: impl IntoIterator<Item = &'a DVector<f64>>,
    period: f64,
    parameter: f64,
) -> Direction {
    let states = states.into_iter().flat_map(|state| state.iter().copied());
    DVector::from_vec(states.chain([period, parameter]).collect())
}

/// The change of the parameter in a direction.
pub(super) fn parameter_of(direction: &Direction) -> f64 {
    direction[direction.len() - 1]
}

impl ShootingPoint {
    /// The unknowns of an orbit.
    pub fn of(orbit: &PeriodicOrbit) -> Self {
        let state = |segment: &OrbitSegment| DVector::from_column_slice(&segment.state);
        Self {
            parameter: orbit.parameter,
            period: orbit.period_s,
            drive_periods: orbit.drive_periods,
            phases: orbit.segments.iter().map(|segment| segment.phase).collect(),
            states: orbit.segments.iter().map(state).collect(),
            statuses: Vec::new(),
        }
    }

    /// The same period and parameter with other segments, whose statuses are not known.
    pub fn with_segments(&self, phases: Vec<f64>, states: Vec<DVector<f64>>) -> Self {
        Self {
            phases,
            states,
            statuses: Vec::new(),
            ..*self
        }
    }

    /// The error that Newton's method did not converge.
    pub fn not_converged(&self, correction: f64, iterations: usize) -> ContinuationError {
        ContinuationError::NotConverged {
            parameter: self.parameter,
            correction,
            iterations,
        }
    }

    /// Number of segments.
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Phases of the start and the end of a segment.
    pub fn span(&self, segment: usize) -> [f64; 2] {
        let end = self.phases.get(segment + 1).copied().unwrap_or(1.0);
        [self.phases[segment], end]
    }

    /// The status at the start of a segment, if it is known.
    pub fn status(&self, segment: usize) -> Option<&[u8]> {
        let status = self.statuses.get(segment)?;
        (!status.is_empty()).then_some(status.as_slice())
    }

    /// Adds a multiple of a direction.
    pub fn moved(&self, by: f64, direction: &Direction) -> Self {
        let mut moved = self.clone();
        let mut changes = direction.iter().map(|change| by * change);
        let states = moved.states.iter_mut().flat_map(|state| state.iter_mut());
        let others = [&mut moved.period, &mut moved.parameter];
        for (x, change) in states.chain(others).zip(&mut changes) {
            *x += change;
        }
        moved
    }

    /// The difference from another set of unknowns with the same phases.
    pub fn minus(&self, other: &Self) -> Direction {
        let unknowns = |point: &Self| direction(&point.states, point.period, point.parameter);
        unknowns(self) - unknowns(other)
    }
}

/// The scales of the unknowns.
///
/// A modal coordinate is multiplied by its natural frequency, so that both parts of the vibration have the unit of a
/// velocity. The vibration, and the first-order components, are divided by their largest norm over the orbit.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    /// Factor of each component of the state.
    pub state: DVector<f64>,
    /// Number of components that belong to the vibration; they come first.
    pub modal: usize,
    /// Scale of the period, s.
    period: f64,
    /// Scale of the parameter: the distance of its bounds.
    pub parameter: f64,
}

impl Scale {
    /// The scales for an orbit with the largest norms `sizes` of its vibration and its first-order components.
    pub fn new(sys: &dyn System, sizes: [f64; 2], period: f64, parameter: f64) -> Self {
        let modal = 2 * sys.modes();
        let factors = sizes.map(|size| if size > 0.0 { 1.0 / size } else { 1.0 });
        let mut state = DVector::from_vec(energy_units(sys));
        for (i, unit) in state.iter_mut().enumerate() {
            *unit *= factors[usize::from(i >= modal)];
        }
        Self {
            state,
            modal,
            period,
            parameter,
        }
    }

    /// The factors of the unknowns of a number of segments. The norm of a direction is that of its products with them: the
    /// mean over the segments for the states.
    pub fn units(&self, segments: usize) -> Direction {
        let states = vec![&self.state / (segments as f64).sqrt(); segments];
        direction(&states, 1.0 / self.period, 1.0 / self.parameter)
    }

    /// A direction in scaled unknowns.
    pub fn scaled(&self, direction: &Direction) -> Direction {
        direction.component_mul(&self.units((direction.len() - 2) / self.state.len()))
    }

    /// The inner product of two directions.
    pub fn dot(&self, a: &Direction, b: &Direction) -> f64 {
        self.scaled(a).dot(&self.scaled(b))
    }

    /// The norm of a direction.
    pub fn norm(&self, direction: &Direction) -> f64 {
        self.scaled(direction).norm()
    }

    /// The norms of the vibration and of the first-order components of a state.
    pub fn norms(&self, state: &DVector<f64>) -> [f64; 2] {
        let state = self.scaled_state(state);
        let rest = state.len() - self.modal;
        [state.rows(0, self.modal), state.rows(self.modal, rest)].map(|part| part.norm())
    }

    /// A linear map of states in scaled coordinates.
    pub fn scaled_map(&self, map: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(map.nrows(), map.ncols(), |i, j| {
            map[(i, j)] * self.state[i] / self.state[j]
        })
    }

    /// A state in scaled coordinates.
    pub fn scaled_state(&self, state: &DVector<f64>) -> DVector<f64> {
        state.component_mul(&self.state)
    }
}
