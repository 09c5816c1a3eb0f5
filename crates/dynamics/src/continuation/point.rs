//! Points of a branch while it is computed.

use super::cyclic;
use super::flow::Flow;
use super::newton::{Constraint, Corrected, Precision};
use super::shape::{GuardDistances, Shape};
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
    pub shape: Shape,
    pub scale: Scale,
    /// The first Newton correction.
    pub first_correction: f64,
}

impl Point {
    /// Whether the start of a segment passes an event of a system with jumps on the way to another point: the flow has a corner
    /// there, and so has the state at this phase along the branch.
    pub fn has_corner_before(&self, other: &Self) -> bool {
        let has_jumps = matches!(self.shape.guards, GuardDistances::ClosestDip(_));
        has_jumps && self.shot.statuses != other.shot.statuses
    }
}

impl Flow<'_> {
    /// Corrects a guess, refines its segments if necessary, and measures the orbit.
    pub fn point(
        &mut self,
        guess: &ShootingPoint,
        scale: &Scale,
        constraint: Constraint<'_>,
        precision: Precision,
    ) -> Result<Point, ContinuationError> {
        let mut corrected = self.correct(guess, scale, constraint, precision)?;
        let first_correction = corrected.corrections[0];
        let mut iterations = corrected.corrections.len();
        for _ in 0..MAX_REFINEMENTS {
            let Some(refined) = self.refine(&corrected.shot, &corrected.maps, scale)? else {
                break;
            };
            corrected = self.correct(&refined, scale, Constraint::Parameter, precision)?;
            iterations += corrected.corrections.len();
        }
        let shape = self.shape(&corrected.shot, scale)?;
        let sys = self.system(corrected.shot.parameter)?;
        let scale = Scale::new(
            sys.as_ref(),
            shape.sizes,
            corrected.shot.period,
            self.width(),
        );
        self.stats.orbits += 1;
        let orbit = self.orbit(&corrected, iterations, &shape, &scale)?;
        Ok(Point {
            orbit,
            shot: corrected.shot,
            tangent: &corrected.tangent / scale.norm(&corrected.tangent),
            shape,
            scale,
            first_correction,
        })
    }

    /// The result for a corrected orbit.
    fn orbit(
        &self,
        corrected: &Corrected,
        iterations: usize,
        shape: &Shape,
        scale: &Scale,
    ) -> Result<PeriodicOrbit, ContinuationError> {
        let shot = &corrected.shot;
        let maps = shape.maps.iter().map(|map| scale.scaled_map(map));
        let parameter = shot.parameter;
        let multipliers = cyclic::multipliers(&maps.collect::<Vec<_>>())
            .ok_or(ContinuationError::Multipliers { parameter })?;
        let segments = shot.phases.iter().zip(&shot.states);
        let mut orbit = PeriodicOrbit {
            parameter,
            period_s: shot.period,
            drive_periods: shot.drive_periods,
            state: shot.states[0].as_slice().to_vec(),
            multipliers,
            stable: false,
            unstable_multipliers: 0,
            trivial_multiplier_error: None,
            amplitude: shape.amplitude,
            component_amplitudes: shape.component_amplitudes.clone(),
            component_deviations: shape.component_deviations.clone(),
            residual: shape.residual,
            correction: corrected.corrections[corrected.corrections.len() - 1],
            iterations: iterations as u32,
            events: shape.crossings,
            open_guards: shape.open_guards(),
            segments: segments
                .map(|(&phase, state)| OrbitSegment {
                    phase,
                    state: state.as_slice().to_vec(),
                })
                .collect(),
        };
        orbit.trivial_multiplier_error = orbit
            .trivial_multiplier()
            .map(|k| orbit.multipliers[k].distance_from(1.0));
        let width = orbit.circle_width();
        orbit.unstable_multipliers = orbit
            .nontrivial_multipliers()
            .filter(|multiplier| multiplier.ln_magnitude > width)
            .count();
        orbit.stable = orbit.unstable_multipliers == 0;
        Ok(orbit)
    }
}
