//! Integration of the segments of an orbit.

use nalgebra::{DMatrix, DVector};

use super::shooting::ShootingPoint;
use super::{BranchStats, ContinuationError, ContinuationOptions, Family};
use crate::system::add_linear;
use crate::{Integrator, System};

/// A system of the family.
pub(super) type Member = Box<dyn System + Send>;

/// Integrates the systems of a family and counts the work.
pub(super) struct Flow<'a> {
    pub family: &'a dyn Family,
    pub options: ContinuationOptions,
    pub stats: BranchStats,
    /// Whether the state or the law of the systems jumps at events.
    has_jumps: bool,
    /// Integrators without and with tangent vectors, created when first needed.
    integrators: [Option<Integrator>; 2],
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
    &'a mut dyn FnMut(&mut Integrator, &dyn System, usize) -> Result<(), ContinuationError>;

impl<'a> Flow<'a> {
    pub fn new(
        family: &'a dyn Family,
        options: &ContinuationOptions,
    ) -> Result<Self, ContinuationError> {
        options.check()?;
        Ok(Self {
            family,
            options: *options,
            stats: BranchStats::default(),
            has_jumps: false,
            integrators: [None, None],
        })
    }

    /// The distance of the bounds of the parameter.
    pub fn width(&self) -> f64 {
        self.options.bounds[1] - self.options.bounds[0]
    }

    /// Builds a system.
    pub fn system(&mut self, parameter: f64) -> Result<Member, ContinuationError> {
        self.stats.systems += 1;
        self.family
            .system(parameter)
            .map_err(|source| ContinuationError::Family { parameter, source })
    }

    /// The period of an orbit with unknowns `shot`, s: for a forced system it follows from the parameter.
    pub fn period(&self, shot: &ShootingPoint) -> f64 {
        let drive = shot
            .drive_periods
            .zip(self.family.drive_period(shot.parameter));
        drive.map_or(shot.period, |(count, period)| f64::from(count) * period)
    }

    /// Relative tolerance of the integration.
    pub fn tolerance(&self) -> f64 {
        let relative = |integrator: &Integrator| integrator.tolerance();
        self.integrators
            .iter()
            .flatten()
            .find_map(relative)
            .unwrap_or(1e-9)
    }

    /// Integrates the segments, with the derivatives of their maps if `with_maps`.
    pub fn segments(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        with_maps: bool,
    ) -> Result<SegmentEnds, ContinuationError> {
        self.observed_segments(sys, shot, with_maps, &mut |_, _, _| Ok(()))
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
        let mut integrator = self.take_integrator(sys, with_maps).map_err(failed)?;
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
            integrator.start(sys, from, &state).map_err(failed)?;
            if with_maps {
                integrator
                    .set_tangent_vectors(directions.as_slice())
                    .map_err(failed)?;
            }
            observer(&mut integrator, sys, k)?;
            integrator.integrate_to(sys, to).map_err(failed)?;
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
        let stats = integrator.take_stats();
        found.crossings = stats.crossings;
        self.stats.solver += stats;
        self.integrators[usize::from(with_maps)] = Some(integrator);
        Ok(found)
    }

    /// An integrator, with tangent vectors for all directions or without.
    fn take_integrator(
        &mut self,
        sys: &dyn System,
        with_maps: bool,
    ) -> Result<Integrator, crate::DynamicsError> {
        if let Some(integrator) = self.integrators[usize::from(with_maps)].take() {
            return Ok(integrator);
        }
        let mut integrator = Integrator::new(self.options.method, sys)?;
        if let Some(switching) = sys.switching() {
            self.has_jumps = !switching.is_continuous();
            if self.has_jumps || switching.guards() > 0 {
                integrator = integrator.with_events(sys)?;
            }
        }
        if with_maps {
            integrator.with_tangents(sys, sys.tangent_dim(), 0)
        } else {
            Ok(integrator)
        }
    }

    /// The derivatives of the segment ends with respect to the parameter, by central differences of the flow, or by a
    /// one-sided difference where the family has no system on one side. The drive period of a forced system changes with
    /// the parameter, too.
    pub fn parameter_slopes(
        &mut self,
        shot: &ShootingPoint,
        ends: &SegmentEnds,
    ) -> Result<Vec<DVector<f64>>, ContinuationError> {
        // Balances the error of the difference, of second order, with that of the integration.
        let step = self.width() * self.tolerance().powf(0.4);
        let has_jumps = self.has_jumps;
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
                .is_ok_and(|side| !has_jumps || side.crossings == ends.crossings)
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
fn with_quadratures(sys: &dyn System, state: &DVector<f64>) -> Vec<f64> {
    let mut full = state.as_slice().to_vec();
    full.resize(sys.dim(), 0.0);
    full
}

/// `dz/dt` without quadratures, for a status if there is one.
pub(super) fn slope_in(sys: &dyn System, status: &[u8], t: f64, z: &[f64]) -> DVector<f64> {
    let mut slope = vec![0.0; sys.dim()];
    match sys.switching() {
        Some(switching) if !status.is_empty() => {
            switching.force_in(status, t, z, &mut slope[sys.modes()..]);
            add_linear(sys.omega(), sys.damping(), z, &mut slope, 1);
        }
        _ => sys.rhs(t, z, &mut slope),
    }
    slope.truncate(sys.tangent_dim());
    DVector::from_vec(slope)
}
