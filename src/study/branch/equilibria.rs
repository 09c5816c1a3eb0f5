//! A branch of equilibria: steady sliding over a parameter, its modes, and where they become unstable.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::family::SubjectFamily;
use super::hopf::{Bracket, SteadyBifurcation, locate, sign};
use super::result::{At, Branch, BranchBifurcation, name_of};
use crate::chain_of_causes;
use crate::dynamics::equilibrium::Eigenmode;
use crate::joint::NamedMode;
use crate::scene::{Parameter, Scene, SceneError};
use crate::study::subject::Subject;
use crate::study::{OnProgress, StudyError};

/// Smallest correlation of a mode with itself at the next point; below it, a point is inserted between.
const MIN_CORRELATION: f64 = 0.8;
/// Largest number of times that an interval is halved.
const MAX_HALVINGS: usize = 6;

/// Distance to which a point is moved from a bifurcation, relative to the interval.
const OFF: f64 = 1e-6;

/// Name of the work.
pub(super) const TASK: &str = "steady sliding";

/// Reason for the end of a branch that the caller stopped.
const INTERRUPTED: &str = "interrupted";

/// A mode at a point of a branch of equilibria.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct BranchMode {
    /// Number of the mode, which is followed along the branch by the correlation of its shape.
    pub number: usize,
    /// The mode.
    #[serde(flatten)]
    pub mode: NamedMode,
}

/// An equilibrium and its modes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct EquilibriumPoint {
    /// Number of unstable modes.
    pub unstable_modes: usize,
    /// All modes, by number. A pair of complex eigenvalues is one mode.
    pub modes: Vec<BranchMode>,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// A plan of a branch: systems over an interval of a parameter.
#[derive(Clone)]
pub struct BranchPlan {
    /// The systems.
    pub subject: Arc<dyn Subject>,
    /// Path of the parameter, such as `load.tilt_deg`.
    pub parameter: String,
    /// Unit of the parameter; empty for a number without one.
    pub unit: String,
    /// Value at which a settled motion is tried first.
    pub own: Option<f64>,
    /// The ends of the interval, ascending, in the unit of the scene file.
    pub interval: [f64; 2],
    /// Number of equally spaced points of the branch of equilibria, at least 2; more are inserted where modes change
    /// quickly.
    pub points: usize,
}

impl BranchPlan {
    /// The systems that are studied.
    pub fn family(&self) -> SubjectFamily {
        SubjectFamily::new(Arc::clone(&self.subject), vec![self.parameter.clone()])
    }

    /// The plan of a scene over one of its keys.
    pub fn new(scene: Scene, parameter: Parameter, interval: [f64; 2], points: usize) -> Self {
        Self {
            parameter: parameter.path().to_owned(),
            unit: parameter.unit().to_owned(),
            own: scene.value_of(parameter),
            subject: Arc::new(scene),
            interval,
            points,
        }
    }

    /// Name of the key without its table, such as `tilt_deg`.
    pub fn name(&self) -> &str {
        name_of(&self.parameter)
    }

    /// Checks a value of the parameter at which periodic orbits should start.
    ///
    /// # Errors
    /// If it is outside the interval: branches end at its ends.
    pub fn check_start(&self, value: f64) -> Result<(), SceneError> {
        let [from, to] = self.interval;
        if (from..=to).contains(&value) {
            return Ok(());
        }
        Err(SceneError::whole(format!(
            "the start at {} = {value} is outside the interval from {from} to {to}; choose a start within it, or widen \
             the interval",
            self.name()
        )))
    }
}

/// Adds the equilibria of a plan to a result, with their bifurcations. If `progress` stops the study, the branch ends at the
/// last point.
///
/// # Errors
/// If the system has no equilibrium at the start of the interval, or cannot be built there.
pub fn add_equilibria(
    plan: &BranchPlan,
    result: &mut Branch,
    progress: OnProgress<'_>,
) -> Result<(), StudyError> {
    let [from, to] = plan.interval;
    let name = plan.name();
    let family = plan.family();
    let mut tracks = Tracks::default();
    let (first, mut tracked) = solve(&family, &mut tracks, At::new(name, from), &[])?;
    let (mut points, mut last) = (vec![first], from);
    let mut brackets = Vec::new();
    let mut ended = None;
    let intervals = plan.points.max(2) - 1;
    'branch: for k in 1..=intervals {
        let target = from + (to - from) * k as f64 / intervals as f64;
        let mut next = target;
        let mut halvings = 0;
        while last < target {
            if progress((last - from) / (to - from), TASK).is_err() {
                ended = Some(INTERRUPTED.to_owned());
                break 'branch;
            }
            let mut trial = tracks.clone();
            let solved = solve(&family, &mut trial, At::new(name, next), &tracked);
            let (point, followed) = match solved {
                Ok(solved) => solved,
                Err(error) => {
                    ended = Some(format!("at {name} = {next}: {}", chain_of_causes(&error)));
                    break 'branch;
                }
            };
            if trial.worst < MIN_CORRELATION && halvings < MAX_HALVINGS {
                halvings += 1;
                next = 0.5 * (last + next);
                continue;
            }
            // A point exactly at a bifurcation has no side.
            if next == target && target < to && is_undamped_after(&tracked, &followed) {
                next = target + OFF * (to - from);
                continue;
            }
            tracks = trial;
            brackets.extend(Bracket::between((last, &tracked), (next, &followed)));
            points.push(point);
            (tracked, last) = (followed, next);
            (next, halvings) = (target, 0);
        }
    }
    let mut bifurcations: Vec<SteadyBifurcation> = Vec::new();
    for bracket in &brackets {
        if progress(1.0, TASK).is_err() {
            ended = Some(INTERRUPTED.to_owned());
            break;
        }
        bifurcations.extend(locate(&family, bracket, plan)?);
    }
    bifurcations.sort_by(|a, b| a.at.value.total_cmp(&b.at.value));
    result.equilibria = points;
    let bifurcations = bifurcations.into_iter().map(BranchBifurcation::Steady);
    result.bifurcations.extend(bifurcations);
    result.ended.extend(ended);
    Ok(())
}

/// Whether a mode is undamped that was not at the point before.
fn is_undamped_after(before: &[Tracked], here: &[Tracked]) -> bool {
    here.iter().any(|tracked| {
        let old = before.iter().find(|old| old.number == tracked.number);
        sign(&tracked.mode) == 0 && old.is_some_and(|old| sign(&old.mode) != 0)
    })
}

/// Solves for the equilibrium at a value and continues the tracks of its modes.
fn solve(
    family: &SubjectFamily,
    tracks: &mut Tracks,
    at: At,
    before: &[Tracked],
) -> Result<(EquilibriumPoint, Vec<Tracked>), StudyError> {
    let state = family.at(&[at.value])?;
    let tracked = tracks.follow(before, state.linearised.modes()?);
    let modes = tracked.iter().map(|tracked| BranchMode {
        number: tracked.number,
        mode: state.named(&tracked.mode),
    });
    let modes: Vec<BranchMode> = modes.collect();
    let point = EquilibriumPoint {
        unstable_modes: modes.iter().filter(|mode| mode.mode.unstable).count(),
        modes,
        at,
    };
    Ok((point, tracked))
}

/// Correlation from which on two shapes are similar.
const SIMILAR: f64 = 0.3;

/// A mode with the number under which it is followed.
#[derive(Clone, Debug)]
pub(super) struct Tracked {
    /// Number of the mode.
    pub number: usize,
    /// The mode.
    pub mode: Eigenmode,
}

/// The numbers given so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    next: usize,
    /// Smallest correlation of an oscillating mode with itself in the last step.
    pub worst: f64,
}

impl Tracks {
    /// Gives each mode the number of the mode before it with the most similar shape. Modes without one get new
    /// numbers: at the start by ascending frequency, later where a pair of complex eigenvalues becomes two real ones
    /// or the reverse.
    pub fn follow(&mut self, before: &[Tracked], mut modes: Vec<Eigenmode>) -> Vec<Tracked> {
        modes.sort_by(|a, b| {
            let by_frequency = a.value.im.total_cmp(&b.value.im);
            by_frequency.then(a.value.re.total_cmp(&b.value.re))
        });
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, old) in before.iter().enumerate() {
            for (j, new) in modes.iter().enumerate() {
                if old.mode.oscillates() == new.oscillates() {
                    pairs.push((likeness(&old.mode, new), i, j));
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut numbers: Vec<Option<usize>> = vec![None; modes.len()];
        let mut is_taken = vec![false; before.len()];
        self.worst = 1.0;
        for (_, i, j) in pairs {
            if !is_taken[i] && numbers[j].is_none() {
                is_taken[i] = true;
                numbers[j] = Some(before[i].number);
                if modes[j].oscillates() {
                    let correlation = before[i].mode.correlation(&modes[j]);
                    self.worst = self.worst.min(correlation);
                }
            }
        }
        let tracked = modes
            .into_iter()
            .zip(numbers)
            .map(|(mode, number)| Tracked {
                number: number.unwrap_or_else(|| {
                    self.next += 1;
                    self.next - 1
                }),
                mode,
            });
        let mut tracked: Vec<Tracked> = tracked.collect();
        tracked.sort_by_key(|tracked| tracked.number);
        tracked
    }
}

/// Similarity of two modes: the correlation of their shapes, less the relative distance of their eigenvalues, which
/// decides between modes of similar shape.
fn likeness(one: &Eigenmode, other: &Eigenmode) -> f64 {
    let size = one.value.norm().max(other.value.norm()).max(1e-300);
    one.correlation(other) - (one.value - other.value).norm() / size
}

/// The mode most similar to another.
pub(super) fn most_alike(modes: Vec<Eigenmode>, to: &Eigenmode) -> Option<Eigenmode> {
    let alike = modes
        .into_iter()
        .filter(|mode| mode.oscillates() == to.oscillates());
    alike.max_by(|a, b| likeness(a, to).total_cmp(&likeness(b, to)))
}

/// The mode with the largest growth rate among those with a similar shape.
pub(super) fn fastest_alike(modes: Vec<Eigenmode>, to: &Eigenmode) -> Option<Eigenmode> {
    let alike = modes
        .into_iter()
        .filter(|mode| mode.oscillates() && mode.correlation(to) > SIMILAR);
    alike.max_by(|a, b| a.value.re.total_cmp(&b.value.re))
}
