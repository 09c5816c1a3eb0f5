//! The numerical settings of a scene, their levels, the error of each level against time, and the settings for a total error:
//! the cheapest ones, and those of `--accuracy`, verified by finer runs.

use schemars::JsonSchema;
use serde::Serialize;

use super::Cost;
use super::motion::{Motion, Runner};
use crate::analysis::regime::Regime;
use crate::chain_of_causes;
use crate::dynamics::MethodName;
use crate::joint::AssemblyError;
use crate::scene::{GAUSS_NODES, Scene, SceneError};
use crate::study::StudyError;

/// Tolerances, two per decade; the last one is the reference of the others.
pub const TOLERANCES: [f64; 12] = [
    1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8,
];

/// Element sizes relative to that of the scene; the last one is the reference of the others.
const SIZES: [f64; 5] = [4.0, 2.0, 1.0, 0.5, 0.25];

/// Most nodes of a patch whose friction has states.
const MOST_WITH_STATES: usize = 400;

/// Tolerance while the other settings are varied.
const FINE: f64 = 1e-7;

/// A numerical setting that a user decides on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Setting {
    /// Relative tolerance of a step, of each adaptive method.
    Tolerance,
    /// Number of contact nodes of a Gauss rule.
    Nodes,
    /// Size of the finite elements of the body, mm.
    ElementSize,
}

impl Setting {
    /// All settings.
    pub const ALL: [Self; 3] = [Self::Tolerance, Self::Nodes, Self::ElementSize];

    /// Name and unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tolerance => "tolerance",
            Self::Nodes => "contact nodes",
            Self::ElementSize => "element size, mm",
        }
    }

    /// What is timed, and its unit.
    pub fn time(self) -> &'static str {
        match self {
            Self::ElementSize => "CPU time of the modes, s",
            Self::Tolerance | Self::Nodes => "CPU time, s per simulated s",
        }
    }
}

/// The numerical settings of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Settings {
    /// Integration method.
    pub method: &'static str,
    /// Relative tolerance of a step.
    pub tolerance: f64,
    /// Number of contact nodes of a Gauss rule; `null` if the scene has none to choose.
    pub nodes: Option<usize>,
    /// Size of the finite elements of the body, mm; `null` if the scene has none.
    pub element_size_mm: Option<f64>,
}

impl Settings {
    /// The settings of a scene.
    pub fn of(scene: &Scene) -> Self {
        let beam = scene.ball_on_beam().ok();
        Self {
            method: scene.integrator.method.name(),
            tolerance: scene.integrator.tolerance,
            nodes: beam
                .and(scene.joint().ok())
                .map(|joint| joint.spec.contact.nodes),
            element_size_mm: beam.map(|beam| 1e3 * beam.elements.size),
        }
    }
}

/// The scene with steps that the tolerance alone determines, and with a Gauss rule of as many contact nodes. A method with
/// a fixed step has no tolerance: `lawson54` takes its place.
pub fn adaptive(scene: &Scene) -> Result<Scene, SceneError> {
    let method = match scene.integrator.method {
        MethodName::Rk4 => MethodName::Lawson54,
        adaptive => adaptive,
    };
    let Settings {
        tolerance, nodes, ..
    } = Settings::of(scene);
    with_method(scene, method)?.with_numerics(tolerance, nodes)
}

fn with_method(scene: &Scene, method: MethodName) -> Result<Scene, SceneError> {
    scene.with_overrides(&[("time.method", method.name())])
}

/// An [`adaptive`] scene with another value of a setting.
pub fn with(scene: &Scene, setting: Setting, value: f64) -> Result<Scene, SceneError> {
    match setting {
        Setting::Tolerance => scene.with_numerics(value, None),
        Setting::Nodes => scene.with_numerics(scene.integrator.tolerance, Some(value as usize)),
        Setting::ElementSize => {
            scene.with_overrides(&[("body.element_size_mm", value.to_string())])
        }
    }
}

/// The settings of the reference of a scene: the finest level of everything.
pub fn finest(scene: &Scene) -> Result<Scene, SceneError> {
    let mut finest = adaptive(scene)?;
    for setting in Setting::ALL {
        if let Some(last) = levels(scene, setting).last() {
            finest = with(&finest, setting, *last)?;
        }
    }
    Ok(finest)
}

/// A variant of a scene at the next finer level of everything; `None` beyond the last level of all.
fn finer(scene: &Scene, variant: &Scene) -> Result<Option<Scene>, SceneError> {
    let settings = Settings::of(variant);
    let size = settings.element_size_mm;
    // A level that differs by rounding alone is the same.
    let below = 1.0 - 1e-6;
    let mut finer = None;
    for setting in Setting::ALL {
        let is_finer = |level: &f64| match setting {
            Setting::Tolerance => *level < below * settings.tolerance,
            Setting::Nodes => settings.nodes.is_some_and(|nodes| *level > nodes as f64),
            Setting::ElementSize => size.is_some_and(|size| *level < below * size),
        };
        if let Some(level) = levels(scene, setting).into_iter().find(is_finer) {
            finer = Some(with(finer.as_ref().unwrap_or(variant), setting, level)?);
        }
    }
    Ok(finer)
}

/// Levels of a setting from coarse to fine; none if the scene does not have it.
pub fn levels(scene: &Scene, setting: Setting) -> Vec<f64> {
    let has_states = scene
        .joint()
        .is_ok_and(|joint| joint.spec.friction.states() > 0);
    match (setting, scene.ball_on_beam()) {
        (Setting::Tolerance, _) => TOLERANCES.to_vec(),
        (_, Err(_)) => Vec::new(),
        (Setting::Nodes, Ok(_)) => {
            let fits = |nodes: &usize| !has_states || *nodes <= MOST_WITH_STATES;
            let nodes = GAUSS_NODES.into_iter().filter(fits);
            nodes.map(|nodes| nodes as f64).collect()
        }
        (Setting::ElementSize, Ok(beam)) => SIZES
            .map(|factor| 1e3 * beam.elements.size * factor)
            .to_vec(),
    }
}

/// Error against time of one setting, with all others fixed.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WorkPrecision {
    /// The setting that is varied.
    pub setting: Setting,
    /// Integration method.
    pub method: &'static str,
    /// Level of the reference, in the unit of the key: one finer than the finest point.
    pub reference: f64,
    /// The points from coarse to fine.
    pub points: Vec<WorkPrecisionPoint>,
}

impl WorkPrecision {
    /// The coarsest level at which this and all finer ones have at most this error.
    pub fn coarsest(&self, error: f64) -> Option<&WorkPrecisionPoint> {
        let fine = |point: &&WorkPrecisionPoint| point.error.is_some_and(|found| found <= error);
        self.points.iter().rev().take_while(fine).last()
    }
}

/// A point of a work-precision picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct WorkPrecisionPoint {
    /// Level of the setting, in the unit of the key.
    pub value: f64,
    /// CPU time, s per simulated second; of element sizes that of the modes of the body, s.
    pub cpu_s: f64,
    /// Right-hand-side evaluations per simulated second.
    pub rhs_evals_per_s: f64,
    /// Relative error; `null` if the run failed.
    pub error: Option<f64>,
    /// Type of the motion; `null` if the run failed.
    pub regime: Option<Regime>,
    /// Error message of a failed run; `null` otherwise.
    pub failed: Option<String>,
}

/// Varies each setting of a scene.
pub fn vary(runner: &mut Runner<'_>, study: &mut Cost) -> Result<(), StudyError> {
    let scene = runner.scene;
    let own = adaptive(scene)?;
    let all = MethodName::ALL.iter().copied();
    let all: Vec<_> = all.filter(|method| !method.has_fixed_step()).collect();
    let only = [own.integrator.method];
    let fine = with(&own, Setting::Tolerance, FINE)?;
    for setting in Setting::ALL {
        let values = levels(scene, setting);
        let Some((&last, shown)) = values.split_last() else {
            continue;
        };
        let (methods, base) = match setting {
            Setting::Tolerance => (&all[..], &own),
            Setting::Nodes | Setting::ElementSize => (&only[..], &fine),
        };
        let share = |done: usize| 0.1 + 0.5 * done as f64 / (all.len() + 2) as f64;
        runner.begin(setting.name(), share(study.settings.len()));
        // All methods converge to one motion, of which the scene's own method gives the reference.
        let reference = runner.motion(&with(base, setting, last)?, 0)?;
        for &method in methods {
            runner.begin(setting.name(), share(study.settings.len()));
            let base = with_method(base, method)?;
            let mut points = Vec::new();
            for &value in shown {
                let varied = with(&base, setting, value)?;
                points.push(point(setting, value, &varied, &reference, runner)?);
            }
            study.settings.push(WorkPrecision {
                setting,
                method: method.name(),
                reference: last,
                points,
            });
        }
    }
    Ok(())
}

fn point(
    setting: Setting,
    value: f64,
    scene: &Scene,
    reference: &Motion,
    runner: &mut Runner<'_>,
) -> Result<WorkPrecisionPoint, StudyError> {
    let mut point = WorkPrecisionPoint {
        value,
        ..WorkPrecisionPoint::default()
    };
    match runner.motion(scene, 0) {
        Err(StudyError::Stopped(stopped)) => return Err(stopped.into()),
        // A tolerance that is too loose for the method, or too few elements for the modes.
        Err(error) => {
            point.failed = Some(chain_of_causes(&error));
            return Ok(point);
        }
        Ok(motion) => {
            point.error = Some(motion.difference(reference));
            point.regime = Some(motion.regime);
        }
    }
    [point.cpu_s, point.rhs_evals_per_s] = runner.time(scene)?;
    if setting == Setting::ElementSize {
        // A system with these modes is then built in no time.
        let body = scene.ball_on_beam()?;
        let solve = || Ok(body.solve_modes().map(drop).map_err(AssemblyError::from)?);
        point.cpu_s = runner.shortest(solve)?;
    }
    Ok(point)
}

/// Total errors for which settings are chosen.
pub const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Share of the total error that one setting may take at first.
const SHARE: f64 = 0.5;

/// How settings were chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The cheapest ones that this study found.
    Cheapest,
    /// The rule of `--accuracy`.
    Accuracy,
}

/// Settings for a total error.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Choice {
    /// Required relative error.
    pub target: f64,
    /// How the settings were chosen.
    pub origin: Origin,
    /// The settings.
    #[serde(flatten)]
    pub settings: Settings,
    /// CPU time, s per simulated second.
    pub cpu_s_per_s: f64,
    /// Verified relative error: the difference from a run at the next finer level of everything.
    pub error: f64,
    /// Whether the verified error, and the scatter of a chaotic motion, are at most the required one.
    pub is_met: bool,
    /// Whether the largest Lyapunov exponents of both runs agree within their 95 % intervals; `null` if they are not
    /// known.
    pub exponents_agree: Option<bool>,
}

/// Chooses settings for each target.
pub fn choose(runner: &mut Runner<'_>, study: &mut Cost) -> Result<(), StudyError> {
    let scene = runner.scene;
    let scatter = study.scatter.unwrap_or(0.0);
    for (k, target) in TARGETS.into_iter().enumerate() {
        runner.begin("verification", 0.6 + 0.07 * k as f64);
        // Finer settings do not reduce the scatter of the averages.
        let reachable = target.max(2.0 * scatter);
        let mut variant = cheapest(scene, &study.settings, SHARE * reachable)?;
        let found = loop {
            let choice = verified(runner, [target, scatter], Origin::Cheapest, &variant)?;
            match finer(scene, &variant)? {
                Some(next) if choice.error > reachable && finer(scene, &next)?.is_some() => {
                    variant = next;
                }
                _ => break choice,
            }
        };
        let rule = adaptive(scene)?.with_accuracy(target)?;
        let of_rule = verified(runner, [target, scatter], Origin::Accuracy, &rule)?;
        study.choices.extend([found, of_rule]);
    }
    Ok(())
}

/// A scene at the coarsest level of each setting whose error is at most `error`, of the fastest method.
fn cheapest(scene: &Scene, sets: &[WorkPrecision], error: f64) -> Result<Scene, SceneError> {
    let own = adaptive(scene)?;
    let methods = sets.iter().filter(|set| set.setting == Setting::Tolerance);
    let methods = methods.filter_map(|set| Some((set, set.coarsest(error)?)));
    let fastest = methods.min_by(|(_, a), (_, b)| a.cpu_s.total_cmp(&b.cpu_s));
    let fastest = fastest.map_or(own.integrator.method.name(), |(set, _)| set.method);
    let mut variant = own.with_overrides(&[("time.method", fastest)])?;
    let is_chosen =
        |set: &&WorkPrecision| set.setting != Setting::Tolerance || set.method == fastest;
    for set in sets.iter().filter(is_chosen) {
        if let Some(point) = set.coarsest(error).or(set.points.last()) {
            variant = with(&variant, set.setting, point.value)?;
        }
    }
    Ok(variant)
}

/// Runs a variant of the scene, and the next finer level of everything, and compares them. `scatter` is that of the
/// averages of a chaotic motion, 0 for others; no setting reduces it.
pub fn verified(
    runner: &mut Runner<'_>,
    [target, scatter]: [f64; 2],
    origin: Origin,
    variant: &Scene,
) -> Result<Choice, StudyError> {
    let finer = finer(runner.scene, variant)?;
    let motion = runner.motion(variant, 1)?;
    let reference = runner.motion(finer.as_ref().unwrap_or(variant), 1)?;
    let [cpu_s_per_s, _] = runner.time(variant)?;
    let error = motion.difference(&reference);
    Ok(Choice {
        target,
        origin,
        settings: Settings::of(variant),
        cpu_s_per_s,
        error,
        is_met: error <= target && scatter <= target,
        exponents_agree: motion.exponents_agree(&reference),
    })
}
