//! Points of a branch while it is computed.

use nalgebra::{DMatrix, DVector};

use super::cyclic;
use super::flow::Flow;
use super::newton::{Corrected, Precision, residual};
use super::shape::{GuardDistances, SAMPLES, portrait, sizes};
use super::shooting::{Direction, Scale, ShootingPoint};
use super::{ContinuationError, OrbitSegment, PeriodicOrbit};

/// Maximum number of times that segments are divided. A jump may have a large growth ratio over no time.
const MAX_REFINEMENTS: usize = 4;

/// An orbit with what continuation needs of it.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub orbit: PeriodicOrbit,
    pub shot: ShootingPoint,
    /// The tangent of the branch.
    pub tangent: Direction,
    pub scale: Scale,
    /// Largest distance of the vibration, and of the first-order components, from their means.
    pub sizes: [f64; 2],
    /// The change of the state over the first half of the period.
    pub half: DVector<f64>,
    pub guards: GuardDistances,
    /// Derivatives of the segment maps in scaled coordinates.
    pub maps: Vec<DMatrix<f64>>,
    /// The first Newton correction.
    pub first_correction: f64,
}

impl Point {
    /// Whether the start of a segment passes an event of a system with jumps on the way to another point: the flow has a corner
    /// there, and so has the state at this phase along the branch.
    pub fn has_corner_before(&self, other: &Self) -> bool {
        let has_jumps = matches!(self.guards, GuardDistances::ClosestDip(_));
        has_jumps && self.shot.statuses != other.shot.statuses
    }
}

impl Flow<'_> {
    /// Corrects a guess, refines its segments if necessary, and measures the orbit.
    pub fn point(
        &mut self,
        guess: &ShootingPoint,
        scale: &Scale,
        along: Option<&Direction>,
        precision: Precision,
    ) -> Result<Point, ContinuationError> {
        let mut corrected = self.correct(guess, scale, along, precision)?;
        let first_correction = corrected.corrections[0];
        let mut iterations = corrected.corrections.len();
        for _ in 0..MAX_REFINEMENTS {
            let Some(refined) = self.refine(&corrected.shot, &corrected.maps, scale)? else {
                break;
            };
            corrected = self.correct(&refined, scale, None, precision)?;
            iterations += corrected.corrections.len();
        }
        let Corrected {
            shot,
            tangent,
            corrections,
            ..
        } = corrected;
        let parameter = shot.parameter;
        let member = self.member(parameter)?;
        let sys = member.system.as_ref();
        let (samples, ends) = self.samples(sys, &shot, true)?;
        let states = DMatrix::from_fn(SAMPLES, sys.tangent_dim(), |k, i| samples[k].z[i]);
        let portrait = portrait(sys, &member.observable, &samples);
        let observed = DVector::from_iterator(portrait.len(), portrait.iter().map(|at| at[0]));
        let half_range = |max: f64, min: f64| 0.5 * (max - min);
        let residual = residual(&shot, &ends, scale);
        let sizes = sizes(sys, &samples);
        let scale = Scale::new(sys, sizes, shot.period, self.width());
        let maps: Vec<_> = ends.maps.iter().map(|map| scale.scaled_map(map)).collect();
        let guards = GuardDistances::of(sys, &samples);
        let segments = shot.phases.iter().zip(&shot.states);
        let orbit = PeriodicOrbit {
            parameter,
            period_s: shot.period,
            drive_periods: shot.drive_periods,
            state: shot.states[0].as_slice().to_vec(),
            multipliers: cyclic::multipliers(&maps)
                .ok_or(ContinuationError::Multipliers { parameter })?,
            stable: false,
            unstable_multipliers: 0,
            trivial_multiplier_error: None,
            amplitude: half_range(observed.max(), observed.min()),
            portrait,
            component_amplitudes: states
                .column_iter()
                .map(|component| half_range(component.max(), component.min()))
                .collect(),
            component_deviations: states.row_variance_tr().map(f64::sqrt).as_slice().to_vec(),
            residual,
            correction: corrections[corrections.len() - 1],
            iterations: iterations as u32,
            events: ends.crossings,
            open_guards: guards.open(),
            segments: segments
                .map(|(&phase, state)| OrbitSegment {
                    phase,
                    state: state.as_slice().to_vec(),
                })
                .collect(),
        };
        Ok(Point {
            orbit: orbit.with_stability(),
            tangent: &tangent / scale.norm(&tangent),
            half: (states.row(SAMPLES / 2) - states.row(0)).transpose(),
            shot,
            scale,
            sizes,
            guards,
            maps,
            first_correction,
        })
    }
}
