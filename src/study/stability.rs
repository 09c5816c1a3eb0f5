//! Linear stability over a range of tilts: Fig. 4a to 7a of the paper.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::branch::{ModeSensitivities, sensitivities};
use super::{OnProgress, StudyError};
use crate::joint::{BallJoint, CauseOfGrowth, ExplainedMode, MIN_GROWTH, NamedMode};
use crate::number::{degrees, fixed, significant};
use crate::report::{Block, Report, Table, TableOf, Tone};
use crate::scene::Scene;

/// Linear stability at one tilt of the load: the linear modes of steady sliding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StabilityAt {
    /// Tilt of the load, rad.
    #[serde(rename = "tilt_rad")]
    pub tilt: f64,
    /// The modes in ascending order of frequency.
    pub modes: Vec<NamedMode>,
}

impl StabilityAt {
    /// The modes of a joint at a tilt (rad), from its complex eigenvalues.
    ///
    /// # Errors
    /// If the joint cannot be assembled, or its eigenvalues cannot be computed.
    pub fn new(ball: &BallJoint, tilt: f64) -> Result<Self, StudyError> {
        let families = ball.family_labels();
        let modes = ball.joint(tilt)?.linear_modes()?;
        let modes = modes.iter().map(|mode| mode.named(&families)).collect();
        Ok(Self { tilt, modes })
    }

    /// The unstable modes.
    pub fn unstable(&self) -> impl Iterator<Item = &NamedMode> {
        self.modes.iter().filter(|mode| mode.unstable)
    }
}

/// [`StabilityAt`] of a joint at each of `tilts` (rad).
///
/// # Errors
/// As [`StabilityAt::new`].
pub fn stability(ball: &BallJoint, tilts: &[f64]) -> Result<Vec<StabilityAt>, StudyError> {
    let at = |&tilt: &f64| StabilityAt::new(ball, tilt);
    tilts.iter().map(at).collect()
}

/// The modes at each tilt.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct StabilityResult {
    /// Minimum growth rate of an unstable mode, 1/s; a slower growth is not visible in a run.
    pub min_growth_per_s: f64,
    /// Tilts in the requested order.
    pub tilts: Vec<ModesAt>,
    /// Whether the study was interrupted, so that the last tilts are missing.
    pub interrupted: bool,
}

/// The modes at a tilt, with the causes of growth and the sensitivities if requested.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ModesAt {
    /// The modes.
    #[serde(flatten)]
    pub at: StabilityAt,
    /// Oscillating modes, each explained by the causes of its growth; only with `--causes`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub explained: Vec<ExplainedMode>,
    /// Oscillating modes, each with its sensitivities to the numbers of the scene; only with `--sensitivities`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<ModeSensitivities>,
}

impl StabilityResult {
    /// The modes of a scene at some tilts (degrees), with the causes of growth and the sensitivities if requested. If
    /// `progress` stops the study, the last tilts are missing.
    ///
    /// # Errors
    /// [`StudyError::Stopped`] before the first tilt is done; if the scene has no joint, or it cannot be assembled or
    /// analysed at a tilt.
    pub fn new(
        scene: &Scene,
        tilts_deg: &[f64],
        requested: [bool; 2],
        progress: OnProgress<'_>,
    ) -> Result<Self, StudyError> {
        let ball = BallJoint::new(&scene.joint()?.spec)?;
        let mut result = Self {
            min_growth_per_s: MIN_GROWTH,
            tilts: Vec::new(),
            interrupted: false,
        };
        for (done, tilt_deg) in tilts_deg.iter().enumerate() {
            let scene = scene.clone().with_tilt(*tilt_deg)?;
            let modes = ModesAt::new(&scene, &ball, requested, &mut |share, task| {
                progress((done as f64 + share) / tilts_deg.len() as f64, task)
            });
            match modes {
                Ok(modes) => result.tilts.push(modes),
                Err(StudyError::Stopped(_)) if done > 0 => {
                    result.interrupted = true;
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(result)
    }
}

impl ModesAt {
    /// The modes at the initial tilt of a scene with a joint.
    fn new(
        scene: &Scene,
        ball: &BallJoint,
        [causes, sensitive]: [bool; 2],
        progress: OnProgress<'_>,
    ) -> Result<Self, StudyError> {
        let tilt = scene.joint()?.tilt.at(0.0);
        let mut modes = Self {
            at: StabilityAt::new(ball, tilt)?,
            explained: Vec::new(),
            sensitivities: Vec::new(),
        };
        if causes {
            modes.explained = ball.model(tilt)?.explained_modes()?;
        }
        if sensitive {
            modes.sensitivities = sensitivities(scene, progress)?;
        }
        Ok(modes)
    }

    /// The unstable modes with sensitivities; the one with the largest growth rate if none is unstable.
    pub fn sensitive(&self) -> Vec<&ModeSensitivities> {
        let all = || self.sensitivities.iter();
        let unstable: Vec<_> = all().filter(|mode| mode.mode.unstable).collect();
        if unstable.is_empty() {
            let largest = all().max_by(|a, b| a.mode.growth.total_cmp(&b.mode.growth));
            largest.into_iter().collect()
        } else {
            unstable
        }
    }

    /// The modes, one per row, with the share of each cause.
    fn table(&self) -> TableOf<(&NamedMode, Option<&ExplainedMode>)> {
        let causes = self.explained.first().map_or(&[][..], |mode| &mode.causes);
        // Both lists are sorted by frequency; `explained` has only the oscillating modes.
        let mut explained = self.explained.iter();
        let modes = self.at.modes.iter().map(|mode| {
            let oscillates = mode.frequency_hz > 0.0;
            (mode, oscillates.then(|| explained.next()).flatten())
        });
        let table = Table::of(modes)
            .right("frequency, Hz", |(mode, _)| fixed(mode.frequency_hz, 1))
            .right("growth rate, 1/s", |(mode, _)| fixed(mode.growth, 2));
        let table = causes.iter().enumerate().fold(table, |table, (k, cause)| {
            table.right(cause.cause.name(), |(_, explained)| {
                explained.map(|mode| share(&mode.causes[k]))
            })
        });
        table
            .left("mode", |(mode, _)| mode.label.clone())
            .left("", |(mode, _)| {
                mode.unstable.then(|| Tone::Bad.cell("unstable"))
            })
    }
}

/// The share of a cause, and the rate without it. Adding 0.0 turns -0.0 into 0.0.
fn share(cause: &CauseOfGrowth) -> String {
    let (share, without) = (cause.share_per_s + 0.0, cause.without_per_s + 0.0);
    format!("{share:.1} ({without:.1})")
}

/// Largest number of sensitivities of a mode that are printed. JSON has all of them.
const MOST_SENSITIVE: usize = 12;

impl Report for StabilityResult {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let mut blocks = Vec::new();
        for modes in &self.tilts {
            let at = &modes.at;
            let title = format!("{scene} at {} deg", degrees(at.tilt));
            let (unstable, all) = (at.unstable().count(), at.modes.len());
            let rest =
                format!(": {unstable} of {all} modes unstable (growth rate from {MIN_GROWTH} 1/s)");
            blocks.push(Block::heading(title, rest));
            blocks.push(modes.table().into());
            if !modes.explained.is_empty() {
                blocks.push(Block::text(
                    "share of each term in the growth rate, 1/s; in brackets the growth rate without the term",
                ));
            }
            for mode in modes.sensitive() {
                blocks.extend(sensitivity_blocks(mode));
            }
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted
    }
}

/// The sensitivities of a mode.
fn sensitivity_blocks(mode: &ModeSensitivities) -> Vec<Block> {
    let title = format!("{} at {:.1} Hz", mode.mode.label, mode.mode.frequency_hz);
    let rest = ": change of growth rate and frequency with the numbers of the scene";
    let table = Table::of(mode.parameters.iter().take(MOST_SENSITIVE))
        .left("number", |it| it.parameter.clone())
        .right("value", |it| significant(it.value, 5))
        .right("1/s per 1 %", |it| significant(it.growth_per_percent, 4))
        .right("1/s per unit", |it| significant(it.growth_per_unit, 4))
        .right("Hz per 1 %", |it| significant(it.frequency_per_percent, 4))
        .right("Hz per unit", |it| significant(it.frequency_per_unit, 4))
        .left("unit", |it| it.unit.clone());
    let mut blocks = vec![Block::heading(title, rest), table.into()];
    if mode.parameters.len() > MOST_SENSITIVE {
        let rest = mode.parameters.len() - MOST_SENSITIVE;
        blocks.push(Block::text(format!(
            "and {rest} more with smaller changes: --json has all"
        )));
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::markdown;
    use crate::scene::Parameter;
    use crate::study::Stopped;

    #[test]
    fn an_interrupted_study_keeps_the_tilts_that_are_done() {
        let scene = Scene::load("periodic-2deg").unwrap();
        let order = Parameter::named("body.element_order").unwrap();
        let scene = scene.with_values(&[(order, 2.0)]).unwrap();
        let stop_at = |limit: f64| {
            let progress = &mut |share: f64, _: &str| {
                if share < limit { Ok(()) } else { Err(Stopped) }
            };
            StabilityResult::new(&scene, &[2.0, 3.0], [false, true], progress)
        };
        let part = stop_at(0.6).unwrap();
        assert!(part.interrupted && part.is_interrupted());
        let tilts: Vec<f64> = part
            .tilts
            .iter()
            .map(|modes| degrees(modes.at.tilt))
            .collect();
        assert_eq!(tilts, [2.0]);
        assert!(!part.tilts[0].sensitivities.is_empty());
        assert!(matches!(stop_at(0.1), Err(StudyError::Stopped(_))));
    }

    #[test]
    fn unstable_modes_are_marked_and_causes_have_columns() {
        let mode = |frequency_hz, growth: f64| NamedMode {
            frequency_hz,
            growth,
            label: "1st bending x".to_owned(),
            unstable: growth > 0.0,
        };
        let mut modes = ModesAt {
            at: StabilityAt {
                tilt: 3.5_f64.to_radians(),
                modes: vec![mode(0.0, -9.0), mode(1780.1, 766.6)],
            },
            explained: Vec::new(),
            sensitivities: Vec::new(),
        };
        let text = |modes: &ModesAt| {
            let result = StabilityResult {
                min_growth_per_s: MIN_GROWTH,
                tilts: vec![modes.clone()],
                interrupted: false,
            };
            crate::report::agreement::check(&result, &[]);
            markdown(&result.blocks("s"))
        };
        let plain = text(&modes);
        assert!(
            plain.starts_with("## s at 3.5 deg: 1 of 2 modes unstable"),
            "{plain}"
        );
        assert!(
            plain.contains("| 1780.1 | 766.60 | 1st bending x | **unstable** |"),
            "{plain}"
        );
        modes.explained = vec![ExplainedMode {
            frequency_hz: 1780.1,
            growth_per_s: 766.6,
            causes: vec![CauseOfGrowth {
                cause: crate::joint::Cause::Slope,
                share_per_s: 700.0,
                without_per_s: -0.0,
            }],
        }];
        let text = text(&modes);
        // A mode without causes has an empty column.
        assert!(text.contains("| 700.0 (0.0) | 1st bending x |"), "{text}");
        assert!(text.contains("| -9.00 |  | 1st bending x |"), "{text}");
        let json = serde_json::to_value(&modes).expect("JSON");
        assert_eq!(
            json["explained"][0]["causes"][0]["cause"],
            crate::joint::Cause::Slope.name()
        );
        assert_eq!(json["explained"][0]["causes"][0]["share_per_s"], 700.0);
    }
}
