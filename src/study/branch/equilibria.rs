//! A branch of equilibria: steady sliding over a parameter, its modes, and where they become unstable.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::family::{SteadyState, SubjectFamily};
use super::result::{At, Branch, BranchBifurcation, name_of};
use crate::chain_of_causes;
use crate::dynamics::RootBracket;
use crate::dynamics::continuation::Criticality;
use crate::dynamics::equilibrium::{
    Eigenmode, FirstLyapunov, ModeTracks, TrackedMode, eigenvalue_derivative,
};
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
const TASK: &str = "steady sliding";

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
    let mut tracks = ModeTracks::default();
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
                    let reason = chain_of_causes(&error);
                    ended = Some(format!("the equilibria end at {name} = {next}: {reason}"));
                    break 'branch;
                }
            };
            if trial.worst_correlation < MIN_CORRELATION && halvings < MAX_HALVINGS {
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
fn is_undamped_after(before: &[TrackedMode], here: &[TrackedMode]) -> bool {
    here.iter().any(|tracked| {
        let old = before.iter().find(|old| old.number == tracked.number);
        sign(&tracked.mode) == 0 && old.is_some_and(|old| sign(&old.mode) != 0)
    })
}

/// Solves for the equilibrium at a value and continues the tracks of its modes.
fn solve(
    family: &SubjectFamily,
    tracks: &mut ModeTracks,
    at: At,
    before: &[TrackedMode],
) -> Result<(EquilibriumPoint, Vec<TrackedMode>), StudyError> {
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

/// Relative width of the last bracket.
const WIDTH: f64 = 1e-13;
/// Rounding errors of a growth rate relative to the size of the eigenvalue.
const ROUNDING: f64 = 1e-9;
/// A first Lyapunov coefficient is zero within this multiple of its error.
const SIGNIFICANT: f64 = 10.0;

/// Kinds of bifurcations of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum SteadyBifurcationKind {
    /// A pair of complex eigenvalues crosses the imaginary axis.
    #[strum(serialize = "Hopf")]
    Hopf,
    /// Two undamped modes with different frequencies meet, and one of them grows beyond (mode coupling without
    /// damping). The growth rate has a vertical tangent there.
    Flutter,
    /// A real eigenvalue crosses zero: a fold or a branch point of equilibria.
    #[strum(serialize = "zero eigenvalue")]
    ZeroEigenvalue,
}

/// The method that determined the criticality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
pub enum CriticalityMethod {
    /// The cubic term of the normal form.
    #[strum(serialize = "normal form")]
    NormalForm,
    /// The parameter as a function of the amplitude along the branch of cycles born there.
    #[strum(serialize = "fitted branch")]
    FittedBranch,
}

/// The birth of a cycle at a Hopf point: the first Lyapunov coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CycleBirth {
    /// How the cycle is born.
    pub criticality: Criticality,
    /// The method that determined the criticality.
    pub method: CriticalityMethod,
    /// First Lyapunov coefficient `Re c / omega` (Kuznetsov), for an eigenvector of length 1 in `[omega q | dq/dt]`, in
    /// the unit of the state's velocity to the power -2.
    pub first_lyapunov: f64,
    /// Error estimate of the first Lyapunov coefficient.
    pub first_lyapunov_error: f64,
    /// Amplitude of the displacement at the probe at which the first contact node separates, or another kink of the law
    /// is reached, m; `None` for a smooth system. Beyond it the normal form does not hold.
    pub smooth_amplitude_m: Option<f64>,
    /// Range of the parameter from the Hopf point on in which the law is smooth over the cycle of the normal form, in
    /// the unit of the scene file.
    pub smooth_range: Option<f64>,
}

/// A point at which a mode of an equilibrium changes its stability.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SteadyBifurcation {
    /// Kind of bifurcation.
    pub kind: SteadyBifurcationKind,
    /// Number of the mode, as in the points of the branch.
    pub number: usize,
    /// Dominant mode of the body.
    pub label: String,
    /// Frequency of the mode, Hz.
    pub frequency_hz: f64,
    /// Derivative of the growth rate with the parameter, 1/s per unit of the scene file; positive if the mode becomes
    /// unstable with an increasing parameter.
    /// `None` where the tangent is vertical.
    pub crossing_speed: Option<f64>,
    /// Derivative of the frequency with the parameter, Hz per unit of the scene file. `None` where the tangent is
    /// vertical.
    pub frequency_slope: Option<f64>,
    /// Error estimate of the location, in the unit of the scene file.
    pub location_error: f64,
    /// The cycle that is born at a Hopf point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<CycleBirth>,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// An interval in which the growth rate of a mode changes its sign.
struct Bracket {
    number: usize,
    /// Value of the parameter and mode at each end.
    ends: [(f64, Eigenmode); 2],
    /// The growth rate that is crossed, 1/s: zero, or rounding errors if the mode is undamped at one end.
    level: f64,
}

impl Bracket {
    /// The brackets of all modes between two points.
    fn between<'a>(
        low: (f64, &'a [TrackedMode]),
        high: (f64, &'a [TrackedMode]),
    ) -> impl Iterator<Item = Self> + 'a {
        low.1.iter().filter_map(move |one| {
            let other = high.1.iter().find(|other| other.number == one.number)?;
            let signs = [&one.mode, &other.mode].map(sign);
            let level = match signs {
                [-1, 1] | [1, -1] => 0.0,
                [0, 1] => ROUNDING * one.mode.value.norm(),
                [1, 0] => ROUNDING * other.mode.value.norm(),
                _ => return None,
            };
            Some(Self {
                number: one.number,
                ends: [(low.0, one.mode.clone()), (high.0, other.mode.clone())],
                level,
            })
        })
    }
}

/// Sign of the growth rate of a mode; zero within rounding errors.
fn sign(mode: &Eigenmode) -> i32 {
    match mode.value.re / (ROUNDING * mode.value.norm()) {
        1.0.. => 1,
        share if share <= -1.0 => -1,
        _ => 0,
    }
}

/// Locates the bifurcation in a bracket. `None` if the mode cannot be followed into it.
fn locate(
    family: &SubjectFamily,
    bracket: &Bracket,
    plan: &BranchPlan,
) -> Result<Option<SteadyBifurcation>, StudyError> {
    let Some((value, error)) = root(family, bracket)? else {
        return Ok(None);
    };
    let (state, mode) = followed(family, bracket, value)?;
    let Some(mode) = mode else {
        return Ok(None);
    };
    let kind = match (mode.oscillates(), bracket.level > 0.0) {
        (true, false) => SteadyBifurcationKind::Hopf,
        (true, true) => SteadyBifurcationKind::Flutter,
        (false, _) => SteadyBifurcationKind::ZeroEigenvalue,
    };
    let named = state.named(&mode);
    let speed = match kind {
        SteadyBifurcationKind::Flutter => None,
        _ => {
            let slope = family.slope(value, plan.interval[1] - plan.interval[0])?;
            let left = state.linearised.left(&mode);
            Some(eigenvalue_derivative(&left, &slope, &mode.vector))
        }
    };
    let cycle = match (kind, speed) {
        (SteadyBifurcationKind::Hopf, Some(speed)) => Some(birth(&state, &mode, speed.re)?),
        _ => None,
    };
    let residual = speed.map_or(0.0, |speed| (mode.value.re / speed.re).abs());
    Ok(Some(SteadyBifurcation {
        kind,
        number: bracket.number,
        label: named.label,
        frequency_hz: named.frequency_hz,
        crossing_speed: speed.map(|speed| speed.re),
        frequency_slope: speed.map(|speed| speed.im / std::f64::consts::TAU),
        location_error: error + residual,
        cycle,
        at: At::new(plan.name(), value),
    }))
}

/// The zero of the growth rate and the width of the last bracket.
fn root(family: &SubjectFamily, bracket: &Bracket) -> Result<Option<(f64, f64)>, StudyError> {
    let growth = |mode: &Eigenmode| mode.value.re - bracket.level;
    let [low, high] = &bracket.ends;
    let mut growths = [growth(&low.1), growth(&high.1)];
    let mut search = RootBracket::new([low.0, high.0], WIDTH * low.0.abs().max(high.0.abs()));
    while let Some(value) = search.guess(growths[0] / (growths[0] - growths[1])) {
        let (_, Some(mode)) = followed(family, bracket, value)? else {
            return Ok(None);
        };
        let end = usize::from((growth(&mode) > 0.0) == (growths[1] > 0.0));
        (search.ends[end], growths[end]) = (value, growth(&mode));
    }
    let best = usize::from(growths[1].abs() < growths[0].abs());
    Ok(Some((search.ends[best], search.ends[1] - search.ends[0])))
}

/// The steady state at a value within a bracket, and its mode most similar to those at the ends.
fn followed(
    family: &SubjectFamily,
    bracket: &Bracket,
    value: f64,
) -> Result<(SteadyState, Option<Eigenmode>), StudyError> {
    let state = family.at(&[value])?;
    let [(low, _), (high, _)] = bracket.ends;
    let nearest = usize::from((value - low).abs() > (high - value).abs());
    let near = &bracket.ends[nearest].1;
    let modes = state.linearised.modes()?;
    // Next to the point where two modes meet, their shapes are equal: the growing one counts.
    let mode = if bracket.level > 0.0 {
        near.fastest_alike(&modes)
    } else {
        near.most_alike(&modes)
    };
    let mode = mode.cloned();
    Ok((state, mode))
}

/// The first Lyapunov coefficient and what it says.
fn birth(state: &SteadyState, mode: &Eigenmode, speed: f64) -> Result<CycleBirth, StudyError> {
    let found = FirstLyapunov::new(state.system.as_ref(), &state.linearised, mode)?;
    let is_significant = found.growth.abs() > SIGNIFICANT * found.error;
    let has_kinks = found.smooth_amplitude.is_finite();
    let amplitude = found.smooth_amplitude * state.probe_amplitude(mode);
    let range = (found.growth / speed).abs() * found.smooth_amplitude.powi(2);
    Ok(CycleBirth {
        criticality: match (is_significant, found.growth > 0.0) {
            (false, _) => Criticality::Undetermined,
            (true, true) => Criticality::Subcritical,
            (true, false) => Criticality::Supercritical,
        },
        method: CriticalityMethod::NormalForm,
        first_lyapunov: found.coefficient(mode),
        first_lyapunov_error: found.error / mode.value.im,
        smooth_amplitude_m: has_kinks.then_some(amplitude),
        smooth_range: has_kinks.then_some(range),
    })
}
