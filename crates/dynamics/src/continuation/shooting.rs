//! The unknowns of multiple shooting, differences of them, and their scales.

use nalgebra::{DMatrix, DVector};

use super::{OrbitSegment, PeriodicOrbit};
use crate::System;

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

/// A difference of two sets of unknowns.
#[derive(Clone, Debug)]
pub(super) struct Direction {
    pub parameter: f64,
    pub period: f64,
    pub states: Vec<DVector<f64>>,
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
        moved.parameter += by * direction.parameter;
        moved.period += by * direction.period;
        for (state, change) in moved.states.iter_mut().zip(&direction.states) {
            state.axpy(by, change, 1.0);
        }
        moved
    }

    /// The difference from another set of unknowns with the same phases.
    pub fn minus(&self, other: &Self) -> Direction {
        let states = self.states.iter().zip(&other.states);
        Direction {
            parameter: self.parameter - other.parameter,
            period: self.period - other.period,
            states: states.map(|(a, b)| a - b).collect(),
        }
    }
}

impl Direction {
    /// Multiplies by a number.
    pub fn scaled(mut self, by: f64) -> Self {
        self.parameter *= by;
        self.period *= by;
        self.states.iter_mut().for_each(|state| *state *= by);
        self
    }

    /// Adds a multiple of another direction.
    pub fn plus(mut self, by: f64, other: &Self) -> Self {
        self.parameter += by * other.parameter;
        self.period += by * other.period;
        for (state, change) in self.states.iter_mut().zip(&other.states) {
            state.axpy(by, change, 1.0);
        }
        self
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
    pub period: f64,
    /// Scale of the parameter: the distance of its bounds.
    pub parameter: f64,
}

impl Scale {
    /// The scales for an orbit with the largest norms `sizes` of its vibration and its first-order components.
    pub fn new(sys: &dyn System, sizes: [f64; 2], period: f64, parameter: f64) -> Self {
        let (m, n) = (sys.modes(), sys.tangent_dim());
        let [vibration, first_order] = sizes.map(|size| if size > 0.0 { 1.0 / size } else { 1.0 });
        let state = DVector::from_fn(n, |i, _| match i {
            i if i < m => vibration * unit_of(sys.omega()[i]),
            i if i < 2 * m => vibration,
            _ => first_order,
        });
        Self {
            state,
            modal: 2 * m,
            period,
            parameter,
        }
    }

    /// The inner product of two directions: the mean over the segments for the states.
    pub fn dot(&self, a: &Direction, b: &Direction) -> f64 {
        let states = a.states.iter().zip(&b.states);
        let sum: f64 = states.map(|(a, b)| self.dot_states(a, b)).sum();
        sum / a.states.len() as f64
            + a.period * b.period / self.period.powi(2)
            + a.parameter * b.parameter / self.parameter.powi(2)
    }

    /// The inner product of two states.
    pub fn dot_states(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        let terms = a.iter().zip(b).zip(&self.state);
        terms.map(|((a, b), scale)| a * b * scale * scale).sum()
    }

    /// The norm of a direction.
    pub fn norm(&self, direction: &Direction) -> f64 {
        self.dot(direction, direction).sqrt()
    }

    /// The norm of a state.
    pub fn norm_state(&self, state: &DVector<f64>) -> f64 {
        self.dot_states(state, state).sqrt()
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

    /// A state from its scaled coordinates.
    pub fn unscaled_state(&self, state: &DVector<f64>) -> DVector<f64> {
        state.component_div(&self.state)
    }
}

/// Factor of a modal coordinate with a natural frequency (rad/s).
pub(super) fn unit_of(omega: f64) -> f64 {
    if omega > 0.0 { omega } else { 1.0 }
}

/// Norms of the vibration and of the first-order components of a state without quadratures.
pub(super) fn sizes_of(sys: &dyn System, z: &[f64]) -> [f64; 2] {
    let m = sys.modes();
    let (vibration, first_order) = z[..sys.tangent_dim()].split_at(2 * m);
    let (q, v) = vibration.split_at(m);
    let q = q
        .iter()
        .zip(sys.omega())
        .map(|(q, &omega)| q * unit_of(omega));
    let sum: f64 = q.chain(v.iter().copied()).map(|x| x * x).sum();
    let rest: f64 = first_order.iter().map(|w| w * w).sum();
    [sum.sqrt(), rest.sqrt()]
}
