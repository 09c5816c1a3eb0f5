//! The continuation of a branch.

use super::detect::{changed, explains};
use super::ends::halved;
use super::flow::Flow;
use super::locate::Piece;
use super::newton::Precision;
use super::point::Point;
use super::shape::GuardDistances;
use super::shooting::{Direction, Scale, ShootingPoint, parameter_of};
use super::start::BranchStart;
use super::{
    BifurcationKind, BranchEnd, ContinuationError, ContinuationOptions, Family, OrbitBranch,
    PeriodicOrbit,
};
use crate::Stopped;

/// Receives the orbits of a branch as they are found, and stops it with an error.
pub type OnOrbit<'a> = &'a mut dyn FnMut(&PeriodicOrbit) -> Result<(), Stopped>;

/// Maximum number of points in each direction.
const MAX_POINTS: usize = 500;

/// Share of the largest size of the orbits of a branch below which the scale of the state does not decrease.
const MIN_SCALE: f64 = 0.3;

/// Follows a branch of periodic orbits from an orbit: in both directions, or away from the origin of the orbit. It ends at
/// the bounds of the parameter or for another reason, which is part of the result ([`BranchEnd`]).
///
/// # Errors
/// If no orbit is found at the start. Later failures end the branch.
pub fn continue_orbits(
    family: &dyn Family,
    start: &BranchStart,
    options: &ContinuationOptions,
    watch: OnOrbit<'_>,
) -> Result<OrbitBranch, ContinuationError> {
    let mut flow = Flow::new(family, options)?;
    let shot = ShootingPoint::of(&start.orbit);
    let scale = flow.scale(&shot)?;
    let away = start
        .origin
        .as_ref()
        .filter(|origin| origin.len() == shot.len())
        .map(|origin| shot.minus(origin));
    let mut first = flow.point(&shot, &scale, away.as_ref(), Precision::Location)?;
    let is_forward = match &away {
        Some(away) if away.len() == first.tangent.len() => {
            first.scale.dot(&first.tangent, away) > 0.0
        }
        _ => parameter_of(&first.tangent) > 0.0,
    };
    if !is_forward {
        first.tangent.neg_mut();
    }
    let mut branch = OrbitBranch::default();
    if watch(&first.orbit).is_err() {
        branch.ends[1] = Some(BranchEnd::Stopped);
    } else if away.is_none() {
        let mut back = first.clone();
        back.tangent.neg_mut();
        branch = BranchState::new(&mut flow, back).run(watch);
        branch.points.reverse();
        branch.bifurcations.reverse();
        branch.unresolved.reverse();
        for bifurcation in &mut branch.bifurcations {
            bifurcation.unstable_change *= -1;
        }
        branch.ends.swap(0, 1);
    }
    branch.points.push(first.orbit.clone());
    let is_complete = |end| matches!(end, &Some(BranchEnd::Closed | BranchEnd::Stopped));
    if !branch.ends.iter().any(is_complete) {
        let mut found = BranchState::new(&mut flow, first).run(watch);
        branch.points.append(&mut found.points);
        branch.bifurcations.append(&mut found.bifurcations);
        branch.unresolved.append(&mut found.unresolved);
        branch.ends[1] = found.ends[1].take();
    }
    branch.newton_iterations = flow.newton_iterations;
    Ok(branch)
}

/// One direction of a branch.
pub(super) struct BranchState<'a, 'f> {
    pub flow: &'a mut Flow<'f>,
    pub first: Point,
    pub now: Point,
    /// The point before the present one.
    pub before: Option<Point>,
    /// Change of the tangent per arclength over the last step.
    bend: Option<Direction>,
    /// Length of the next step.
    pub step: f64,
    /// Times that the present step was shortened to separate bifurcations.
    pub resolutions: u32,
    pub largest_amplitude: f64,
    largest_sizes: [f64; 2],
    /// The points after the first, and what was found with them.
    pub found: OrbitBranch,
}

/// Why a step should be shorter.
enum Objection {
    /// It may have jumped to another branch.
    Jump,
    /// The number of events changed: the orbit grazes a guard in between.
    Events,
    /// Multipliers crossed the unit circle without an identified bifurcation.
    Unexplained,
}

/// The guess for the next point.
struct Prediction {
    shot: ShootingPoint,
    /// Length of the step.
    step: f64,
    /// The bound on which the parameter is fixed, if the step reaches it.
    ends_at_bound: bool,
}

impl<'a, 'f> BranchState<'a, 'f> {
    fn new(flow: &'a mut Flow<'f>, first: Point) -> Self {
        Self {
            step: flow.options.steps.initial,
            resolutions: 0,
            flow,
            now: first.clone(),
            before: None,
            bend: None,
            largest_amplitude: first.orbit.amplitude,
            largest_sizes: first.sizes,
            first,
            found: OrbitBranch::default(),
        }
    }

    fn run(mut self, watch: OnOrbit<'_>) -> OrbitBranch {
        let end = loop {
            if self.found.points.len() >= MAX_POINTS {
                break BranchEnd::MaxPoints;
            }
            let Some(prediction) = self.predict() else {
                break BranchEnd::ParameterBound;
            };
            let next = match self.attempt(&prediction) {
                Ok(next) => next,
                Err(error) => {
                    if self.shorten() {
                        continue;
                    }
                    break self.end_of_failure(&error.to_string());
                }
            };
            if let Some(objection) = self.objection(&prediction, &next) {
                if self.shorten() {
                    continue;
                }
                match objection {
                    Objection::Jump => {
                        break self.end_of_failure("the branch turns within the minimum step");
                    }
                    Objection::Events => {
                        let grazing = self.grazing(next.orbit.parameter);
                        self.found.bifurcations.push(grazing);
                    }
                    Objection::Unexplained => {}
                }
            }
            let known = self.found.bifurcations.len();
            if let Some(end) = self.accept(&prediction, next, watch) {
                break end;
            }
            if let Some(end) = self.end(known) {
                break end;
            }
        };
        self.found.ends[1] = Some(end);
        self.found
    }

    /// Predicts the next point; `None` if the branch leaves the bounds here.
    fn predict(&self) -> Option<Prediction> {
        let [low, high] = self.flow.options.bounds;
        let (now, tangent) = (&self.now, &self.now.tangent);
        let here = now.orbit.parameter;
        let bound = if parameter_of(tangent) > 0.0 {
            high
        } else {
            low
        };
        let is_at_bound = (here - bound).abs() <= 1e-12 * (high - low);
        if is_at_bound || !(low..=high).contains(&here) {
            return None;
        }
        let mut step = self.step;
        let guess_at = |step: f64| {
            let guess = now.shot.moved(step, tangent);
            match &self.bend {
                Some(bend) => guess.moved(0.5 * step * step, bend),
                None => guess,
            }
        };
        let mut shot = guess_at(step);
        let ends_at_bound = !(low..=high).contains(&shot.parameter);
        if ends_at_bound {
            let bound = if shot.parameter > high { high } else { low };
            let share = (bound - here) / (shot.parameter - here);
            step *= share;
            shot = guess_at(step);
            shot.parameter = bound;
        }
        if shot.period.is_nan() || shot.period <= 0.0 {
            shot.period = now.shot.period;
        }
        Some(Prediction {
            shot,
            step,
            ends_at_bound,
        })
    }

    /// The scale for the next point: that of the present one, but not below a share of the largest one.
    fn scale(&self) -> Scale {
        let mut scale = self.now.scale.clone();
        for (i, unit) in scale.state.iter_mut().enumerate() {
            let part = usize::from(i >= scale.modal);
            let size = self.now.sizes[part];
            if size > 0.0 {
                *unit *= (size / (MIN_SCALE * self.largest_sizes[part]).max(size)).min(1.0);
            }
        }
        scale
    }

    /// Corrects a prediction.
    fn attempt(&mut self, prediction: &Prediction) -> Result<Point, ContinuationError> {
        let scale = self.scale();
        let along = (!prediction.ends_at_bound).then_some(&self.now.tangent);
        let guess = &prediction.shot;
        let mut next = self.flow.point(guess, &scale, along, Precision::Branch)?;
        if next.shot.phases != self.now.shot.phases {
            self.now = self.flow.with_phases(&self.now, &next.shot.phases)?;
            self.bend = None;
            if self.now.shot.len() != next.shot.len() {
                return Err(next.shot.not_converged(next.orbit.correction, 0));
            }
        }
        if self.now.scale.dot(&next.tangent, &self.now.tangent) < 0.0 {
            next.tangent.neg_mut();
        }
        Ok(next)
    }

    /// Why a step should be shorter; `None` if it is accepted.
    fn objection(&mut self, prediction: &Prediction, next: &Point) -> Option<Objection> {
        let now = &self.now;
        let has_jumps = matches!(next.guards, GuardDistances::ClosestDip(_));
        if has_jumps && next.orbit.events != now.orbit.events {
            return Some(Objection::Events);
        }
        if self.is_jump(next, prediction.step) {
            return Some(Objection::Jump);
        }
        let tests = changed(now, next);
        let is_unexplained = !explains(&tests, now, next) && self.may_resolve();
        is_unexplained.then_some(Objection::Unexplained)
    }

    /// Takes the next point: locates bifurcations before it and prepares the next step. Returns why the branch ends here,
    /// if it does.
    fn accept(
        &mut self,
        prediction: &Prediction,
        next: Point,
        watch: OnOrbit<'_>,
    ) -> Option<BranchEnd> {
        let tests = changed(&self.now, &next);
        let piece = Piece {
            from: &self.now,
            to: &next,
        };
        let parameters = [self.now.orbit.parameter, next.orbit.parameter];
        let mut located = Vec::new();
        let mut is_explained = explains(&tests, &self.now, &next);
        for test in tests {
            match self.flow.locate(piece, test) {
                Ok(bifurcation) => located.extend(bifurcation),
                Err(_) => is_explained = false,
            }
        }
        if let Some(parameter) = halved(piece) {
            let mut located = located.into_iter().map(|(_, bifurcation)| bifurcation);
            let turn = located.find(|found| found.kind == BifurcationKind::Fold);
            let parameter = turn.map_or(parameter, |turn| turn.parameter);
            return Some(BranchEnd::PeriodHalved { parameter });
        }
        if !is_explained {
            self.found.unresolved.push(parameters);
        }
        located.sort_by(|(a, _), (b, _)| f64::total_cmp(a, b));
        let located = located.into_iter().map(|(_, bifurcation)| bifurcation);
        self.found.bifurcations.extend(located);
        self.largest_amplitude = self.largest_amplitude.max(next.orbit.amplitude);
        self.largest_sizes = [0, 1].map(|part| self.largest_sizes[part].max(next.sizes[part]));
        let watched = watch(&next.orbit);
        self.found.points.push(next.orbit.clone());
        let bend = (&next.tangent - &self.now.tangent) / prediction.step;
        self.bend = (!self.now.has_corner_before(&next)).then_some(bend);
        self.adapt(&next, prediction.step);
        self.before = Some(std::mem::replace(&mut self.now, next));
        watched.is_err().then_some(BranchEnd::Stopped)
    }
}
