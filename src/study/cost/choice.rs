//! Settings for a total error: the cheapest ones, and those of `--accuracy`, verified by finer runs.

use schemars::JsonSchema;
use serde::Serialize;

use super::motion::Runner;
use super::settings::{Setting, Settings, WorkPrecision};
use super::{Cost, Watch};
use crate::scene::{AccuracySettings, Scene};
use crate::study::StudyError;

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
pub fn choose(
    scene: &Scene,
    runner: &mut Runner,
    study: &mut Cost,
    watch: &mut Watch<'_>,
) -> Result<(), StudyError> {
    let scatter = study.scatter.unwrap_or(0.0);
    for (k, target) in TARGETS.into_iter().enumerate() {
        watch.begin("verification", 0.6 + 0.07 * k as f64);
        // Finer settings do not reduce the scatter of the averages.
        let reachable = target.max(2.0 * scatter);
        let mut settings = cheapest(scene, &study.settings, SHARE * reachable);
        let mut found = loop {
            let choice = verified(scene, runner, target, Origin::Cheapest, &settings, watch)?;
            match settings.finer(scene) {
                Some(finer) if choice.error > reachable && finer.finer(scene).is_some() => {
                    settings = finer;
                }
                _ => break choice,
            }
        };
        let rule = by_rule(scene, target);
        let mut of_rule = verified(scene, runner, target, Origin::Accuracy, &rule, watch)?;
        for choice in [&mut found, &mut of_rule] {
            choice.is_met &= scatter <= target;
        }
        study.choices.extend([found, of_rule]);
    }
    Ok(())
}

/// The settings of `--accuracy`.
pub fn by_rule(scene: &Scene, target: f64) -> Settings {
    let rule = AccuracySettings::for_error(target);
    let mut settings = Settings {
        tolerance: rule.tolerance,
        ..Settings::of(scene)
    };
    settings.nodes = settings.nodes.and(Some(rule.nodes));
    settings
}

/// The coarsest level of each setting whose error is at most `error`, of the fastest method.
fn cheapest(scene: &Scene, sets: &[WorkPrecision], error: f64) -> Settings {
    let mut settings = Settings::of(scene);
    let methods = sets.iter().filter(|set| set.setting == Setting::Tolerance);
    let methods = methods.filter_map(|set| Some((set, set.coarsest(error)?)));
    let fastest = methods.min_by(|(_, a), (_, b)| a.cpu_s.total_cmp(&b.cpu_s));
    let own = sets.iter().find(|set| set.method == settings.method);
    let finest = own.and_then(|set| Some((set, set.points.last()?)));
    if let Some((set, point)) = fastest.or(finest) {
        settings.method.clone_from(&set.method);
        settings.tolerance = point.value;
    }
    for set in sets.iter().filter(|set| set.setting != Setting::Tolerance) {
        if let Some(point) = set.coarsest(error).or(set.points.last()) {
            settings.set(set.setting, point.value);
        }
    }
    settings
}

/// Runs settings, and the next finer level of everything, and compares them.
pub fn verified(
    scene: &Scene,
    runner: &mut Runner,
    target: f64,
    origin: Origin,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Choice, StudyError> {
    let coarse = settings.apply(scene)?;
    let finer = settings.finer(scene).unwrap_or_else(|| settings.clone());
    let motion = runner.motion(&coarse, 1, watch)?;
    let reference = runner.motion(&finer.apply(scene)?, 1, watch)?;
    let [cpu_s_per_s, _] = runner.time(&coarse, watch)?;
    let error = motion.difference(&reference);
    Ok(Choice {
        target,
        origin,
        settings: settings.clone(),
        cpu_s_per_s,
        error,
        is_met: error <= target,
        exponents_agree: motion.exponents_agree(&reference),
    })
}
