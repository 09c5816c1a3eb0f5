//! Type of motion versus tilt, drawn below the slider.

use std::path::Path;

use serde::Serialize;

use crate::escape;
use crate::joint::BallJoint;
use crate::scene::Scene;
use crate::study::stability;
use crate::study::sweep::{Start, SweepPlan, TableError, read_table};

/// Swept parameter.
const TILT: &str = "load.tilt_deg";
/// Number of tilts at which stability is computed.
const TILTS: usize = 101;

/// Type of motion versus tilt.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RegimeBands {
    /// Description of the origin.
    pub source: String,
    /// Name of the scene.
    pub scene: String,
    /// The rows of the strip.
    pub rows: Vec<RegimeRow>,
}

/// A row of the strip.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RegimeRow {
    /// Start of the responses of a sweep; `None` for linear stability.
    pub start: Option<Start>,
    /// Tilt (degrees) at which each type of motion was found, in ascending order; each applies half-way to
    /// the adjacent tilts.
    pub at: Vec<(f64, String)>,
}

impl RegimeBands {
    /// Reads the result table of a sweep over the tilt: one row for each start. `None` if another parameter was swept.
    ///
    /// # Errors
    /// If the table cannot be read.
    pub fn from_sweep(table: &Path) -> Result<Option<Self>, TableError> {
        let swept = read_table(table)?;
        let Ok(plan) = SweepPlan::from_identity(&swept.identity) else {
            return Ok(None);
        };
        let [axis] = plan.axes.as_slice() else {
            return Ok(None);
        };
        if axis.parameter().path() != TILT {
            return Ok(None);
        }
        let row = |start: &Start| {
            let points = swept.points.iter();
            let points = points.filter(|point| point.place.start == *start);
            let mut at: Vec<(f64, String)> = points
                .filter_map(|point| {
                    let found = point.outcome.as_ref().ok()?;
                    Some((*point.place.values.first()?, found.regime.to_string()))
                })
                .collect();
            at.sort_by(|a, b| a.0.total_cmp(&b.0));
            let start = Some(*start);
            RegimeRow { start, at }
        };
        let source = format!(
            "sweep of {} in {}",
            escape::code(&plan.scene.name),
            escape::line(&table.to_string_lossy())
        );
        Ok(Some(Self {
            source,
            rows: plan.starts.iter().map(row).collect(),
            scene: plan.scene.name,
        }))
    }

    /// Linear stability of steady sliding for tilts in a range (degrees); used without a sweep.
    pub fn from_stability(scene: &Scene, [low, high]: [f64; 2]) -> Self {
        let spec = scene.joint().ok().map(|joint| &joint.spec);
        let ball = spec.and_then(|spec| BallJoint::new(spec).ok());
        let step = (high - low) / (TILTS - 1) as f64;
        let tilts = (0..TILTS).map(|k| low + step * k as f64);
        let kind = |ball: &BallJoint, deg: f64| {
            let found = stability(ball, &[f64::to_radians(deg)]).ok()?;
            let unstable = found[0].unstable().count();
            let words = match unstable {
                0 => "stable".to_owned(),
                1 => "1 unstable mode".to_owned(),
                more => format!("{more} unstable modes"),
            };
            Some((deg, words))
        };
        let Some(ball) = &ball else {
            return Self::default();
        };
        Self {
            source: "linear stability of steady sliding; the settled motion may differ. Run \
             `squeakscope sweep` for results of the simulation"
                .to_owned(),
            scene: scene.name.clone(),
            rows: vec![RegimeRow {
                start: None,
                at: tilts.filter_map(|deg| kind(ball, deg)).collect(),
            }],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unstable_modes_are_counted() {
        let scene = Scene::load("torus-3deg").unwrap();
        let bands = RegimeBands::from_stability(&scene, [0.0, 10.0]);
        let at = &bands.rows[0].at;
        assert_eq!(at.len(), TILTS);
        assert_eq!((at[0].0, at[TILTS - 1].0), (0.0, 10.0));
        // Four bending modes without tilt; steady sliding is always unstable.
        assert_eq!(at[0].1, "4 unstable modes");
        assert!(
            at.iter().all(|(_, kind)| kind.contains("unstable")),
            "{bands:?}"
        );
        let still = Scene::load("printed-friction").unwrap();
        let bands = RegimeBands::from_stability(&still, [0.0, 4.0]);
        assert!(
            bands.rows[0].at.iter().all(|(_, kind)| kind == "stable"),
            "{bands:?}"
        );
    }

    #[test]
    fn a_scene_without_tilt_has_no_bands() {
        let scene = Scene::load("mass-on-belt").unwrap();
        assert_eq!(
            RegimeBands::from_stability(&scene, [0.0, 1.0]),
            RegimeBands::default()
        );
    }
}
