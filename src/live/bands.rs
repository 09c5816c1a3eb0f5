//! Type of motion versus tilt, drawn below the slider.

use std::path::Path;

use serde::Serialize;

use crate::escape;
use crate::joint::BallJoint;
use crate::scene::Scene;
use crate::study::stability;
use crate::study::sweep::{SweepPlan, TableError, read_table};

/// Swept parameter.
const TILT: &str = "load.tilt_deg";
/// Number of tilts at which stability is computed.
const TILTS: usize = 101;

/// Type of motion versus tilt.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RegimeBands {
    /// Description of the origin.
    pub source: String,
    /// Tilt (degrees) at which each type of motion was found, in ascending order; each applies half-way to
    /// the adjacent tilts.
    pub at: Vec<(f64, String)>,
}

impl RegimeBands {
    /// Reads the result table of a sweep over the tilt and takes the results of its first start. `None` if
    /// another parameter was swept.
    ///
    /// # Errors
    /// If the table cannot be read.
    pub fn from_sweep(table: &Path) -> Result<Option<Self>, TableError> {
        let swept = read_table(table)?;
        let Ok(plan) = SweepPlan::from_identity(&swept.identity) else {
            return Ok(None);
        };
        let ([axis], [first, ..]) = (plan.axes.as_slice(), plan.starts.as_slice()) else {
            return Ok(None);
        };
        if axis.parameter().path() != TILT {
            return Ok(None);
        }
        let mut at: Vec<(f64, String)> = swept
            .points
            .iter()
            .filter(|point| point.place.start == *first)
            .filter_map(|point| {
                let found = point.outcome.as_ref().ok()?;
                Some((*point.place.values.first()?, found.regime.to_string()))
            })
            .collect();
        at.sort_by(|a, b| a.0.total_cmp(&b.0));
        let source = format!(
            "sweep of {} in {}, started {first}",
            escape::code(&plan.scene.name),
            escape::line(&table.to_string_lossy())
        );
        Ok(Some(Self { source, at }))
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
        let at = match &ball {
            Some(ball) => tilts.filter_map(|deg| kind(ball, deg)).collect(),
            None => Vec::new(),
        };
        let source = match at.is_empty() {
            true => String::new(),
            false => "linear stability of steady sliding; the settled motion may differ. Run \
             `squeakscope sweep` for results of the simulation"
                .to_owned(),
        };
        Self { source, at }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unstable_modes_are_counted() {
        let scene = Scene::load("torus-3deg").unwrap();
        let bands = RegimeBands::from_stability(&scene, [0.0, 10.0]);
        assert_eq!(bands.at.len(), TILTS);
        assert_eq!((bands.at[0].0, bands.at[TILTS - 1].0), (0.0, 10.0));
        // Four bending modes without tilt; steady sliding is always unstable.
        assert_eq!(bands.at[0].1, "4 unstable modes");
        assert!(
            bands.at.iter().all(|(_, kind)| kind.contains("unstable")),
            "{bands:?}"
        );
        let still = Scene::load("printed-friction").unwrap();
        let bands = RegimeBands::from_stability(&still, [0.0, 4.0]);
        assert!(
            bands.at.iter().all(|(_, kind)| kind == "stable"),
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
