//! Integration of the segments of an orbit.

use nalgebra::{DMatrix, DVector};

use super::shooting::ShootingPoint;
use super::{ContinuationError, ContinuationOptions, Family, FamilyMember, StepLimits};
use crate::stepper::Law;
use crate::{DynamicsError, Integrator, System};

/// Integrates the systems of a family.
pub(super) struct Flow<'a> {
    pub family: &'a dyn Family,
    pub options: ContinuationOptions,
    pub newton_iterations: u64,
    /// The last value of the parameter, and the period of the drive there, s.
    drive: (f64, Option<f64>),
}

/// The ends of the segments.
pub(super) struct SegmentEnds {
    /// States at the ends.
    pub ends: Vec<DVector<f64>>,
    /// `dz/dt` at the ends.
    pub slopes: Vec<DVector<f64>>,
    /// Statuses at the ends, empty without event location.
    pub statuses: Vec<Vec<u8>>,
    /// Derivatives of the segment maps; empty if not requested.
    pub maps: Vec<DMatrix<f64>>,
    /// Guards crossed.
    pub crossings: u64,
}

/// A function that is called with the integrator during a segment.
pub(super) type Observer<'a> =
    &'a mut dyn FnMut(&mut Integrator<'_>, usize) -> Result<(), ContinuationError>;

impl<'a> Flow<'a> {
    pub fn new(
        family: &'a dyn Family,
        options: &ContinuationOptions,
    ) -> Result<Self, ContinuationError> {
        let flow = Self {
            family,
            options: *options,
            newton_iterations: 0,
            drive: (f64::NAN, None),
        };
        let width = flow.width();
        if !(width > 0.0 && width.is_finite()) {
            return Err(ContinuationError::Bounds { width });
        }
        let StepLimits { initial, min, max } = options.steps;
        if !(min > 0.0 && min <= initial && initial <= max && max.is_finite()) {
            return Err(ContinuationError::Steps(options.steps));
        }
        Ok(flow)
    }

    /// The distance of the bounds of the parameter.
    pub fn width(&self) -> f64 {
        self.options.bounds[1] - self.options.bounds[0]
    }

    /// Builds a system, with what is known of it besides.
    pub fn member(&mut self, parameter: f64) -> Result<FamilyMember, ContinuationError> {
        let member = self.family.member(parameter);
        let member = member.map_err(|source| ContinuationError::Family { parameter, source })?;
        self.drive = (parameter, member.drive_period);
        Ok(member)
    }

    /// Builds a system.
    pub fn system(&mut self, parameter: f64) -> Result<Box<dyn System>, ContinuationError> {
        Ok(self.member(parameter)?.system)
    }

    /// The period of the drive at a value of the parameter, s.
    pub fn drive_period(&self, parameter: f64) -> Option<f64> {
        match self.drive {
            (last, period) if last == parameter => period,
            _ => self.family.member(parameter).ok()?.drive_period,
        }
    }

    /// The period of an orbit with unknowns `shot`, s: for a forced system it follows from the parameter.
    pub fn period(&self, shot: &ShootingPoint) -> f64 {
        let forced = |count| Some(f64::from(count) * self.drive_period(shot.parameter)?);
        shot.drive_periods.and_then(forced).unwrap_or(shot.period)
    }

    /// Relative tolerance of the integration.
    pub fn tolerance(&self) -> f64 {
        self.options.method.accuracy.relative
    }

    /// Maximum estimated error of an orbit after the last Newton correction, relative to its size.
    pub fn newton_tolerance(&self) -> f64 {
        100.0 * self.tolerance()
    }

    /// Integrates the segments, with the derivatives of their maps if `with_maps`.
    pub fn segments(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        with_maps: bool,
    ) -> Result<SegmentEnds, ContinuationError> {
        self.observed_segments(sys, shot, with_maps, &mut |_, _| Ok(()))
    }

    /// As [`Flow::segments`]; the observer may advance the integrator within each segment, up to its end.
    pub fn observed_segments(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        with_maps: bool,
        observer: Observer<'_>,
    ) -> Result<SegmentEnds, ContinuationError> {
        let parameter = shot.parameter;
        let failed = |source| ContinuationError::Integration { parameter, source };
        let (n, period) = (sys.tangent_dim(), self.period(shot));
        let mut integrator = self.integrator(sys, with_maps).map_err(failed)?;
        let mut found = SegmentEnds {
            ends: Vec::with_capacity(shot.len()),
            slopes: Vec::with_capacity(shot.len()),
            statuses: Vec::with_capacity(shot.len()),
            maps: Vec::new(),
            crossings: 0,
        };
        for k in 0..shot.len() {
            let [from, to] = shot.span(k).map(|phase| phase * period);
            let mut state = with_quadratures(sys, &shot.states[k]);
            let mut directions = DMatrix::<f64>::identity(n, n);
            if let Some((switching, status)) = sys.switching().zip(shot.status(k)) {
                let tangents = (directions.as_mut_slice(), n);
                switching.settle(status, from, &mut state, tangents);
            }
            integrator.start(from, &state).map_err(failed)?;
            if with_maps {
                integrator
                    .set_tangent_vectors(directions.as_slice())
                    .map_err(failed)?;
            }
            observer(&mut integrator, k)?;
            integrator.integrate_to(to).map_err(failed)?;
            let state = integrator.state();
            found
                .slopes
                .push(slope_in(sys, integrator.status(), to, state));
            found.ends.push(DVector::from_column_slice(&state[..n]));
            found.statuses.push(integrator.status().to_vec());
            if let Some(vectors) = integrator.tangent_vectors().filter(|_| with_maps) {
                found.maps.push(DMatrix::from_row_slice(n, n, vectors));
            }
        }
        found.crossings = integrator.stats().crossings;
        Ok(found)
    }

    /// An integrator, with tangent vectors for all directions or without.
    fn integrator<'s>(
        &self,
        sys: &'s dyn System,
        with_maps: bool,
    ) -> Result<Integrator<'s>, DynamicsError> {
        let mut integrator = Integrator::new(self.options.method, sys)?;
        if sys.switching().is_some_and(|s| s.guards() > 0) {
            integrator = integrator.with_events()?;
        }
        if with_maps {
            integrator.with_tangents(sys.tangent_dim(), 0)
        } else {
            Ok(integrator)
        }
    }

    /// The derivatives of the segment ends with respect to the parameter, by central differences of the flow, or by a
    /// one-sided difference where the family has no system on one side. The drive period of a forced system changes with
    /// the parameter, too.
    pub fn parameter_slopes(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        ends: &SegmentEnds,
    ) -> Result<Vec<DVector<f64>>, ContinuationError> {
        // Balances the error of the difference, of second order, with that of the integration.
        let step = self.width() * self.tolerance().powf(0.4);
        let mut ends_at = |parameter: f64| {
            let sys = self.system(parameter)?;
            let shifted = ShootingPoint {
                parameter,
                ..shot.clone()
            };
            self.segments(sys.as_ref(), &shifted, false)
        };
        // Beyond a grazing the flow has other events, and another derivative.
        let is_like = |side: &Result<SegmentEnds, _>| {
            side.as_ref()
                .is_ok_and(|side| !sys.jumps() || side.crossings == ends.crossings)
        };
        let ahead = ends_at(shot.parameter + step);
        let behind = ends_at(shot.parameter - step);
        let alike = [is_like(&ahead), is_like(&behind)];
        let here = || ends.ends.clone();
        let (ahead, behind, distance) = match (alike, ahead, behind) {
            ([true, false], Ok(ahead), _) => (ahead.ends, here(), step),
            ([false, true], _, Ok(behind)) => (here(), behind.ends, step),
            (_, Ok(ahead), Ok(behind)) => (ahead.ends, behind.ends, 2.0 * step),
            (_, Err(error), _) | (_, _, Err(error)) => return Err(error),
        };
        let pairs = ahead.into_iter().zip(behind);
        Ok(pairs.map(|(a, b)| (a - b) / distance).collect())
    }
}

/// The full state, with quadratures that start at zero.
pub(super) fn with_quadratures(sys: &dyn System, state: &DVector<f64>) -> Vec<f64> {
    let mut full = state.as_slice().to_vec();
    full.resize(sys.dim(), 0.0);
    full
}

/// `dz/dt` without quadratures, for a status if there is one.
pub(super) fn slope_in(sys: &dyn System, status: &[u8], t: f64, z: &[f64]) -> DVector<f64> {
    let mut slope = vec![0.0; sys.dim()];
    let status = (!status.is_empty()).then_some(status);
    Law { sys, status }.rhs(t, z, &mut slope, None);
    slope.truncate(sys.tangent_dim());
    DVector::from_vec(slope)
}
