//! Kinds of motion over the tilt, to be drawn under the slider.

use std::path::Path;

use serde::Serialize;

use crate::escape;
use crate::joint::BallJoint;
use crate::scene::Scene;
use crate::study::stability;
use crate::study::sweep::{SweepPlan, TableError, read_table};

/// The parameter that is swept.
const TILT: &str = "load.tilt_deg";
/// Tilts at which stability is asked for.
const TILTS: usize = 101;

/// Kinds of motion over the tilt.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bands {
    /// Where they are from, in words.
    pub source: String,
    /// Tilt (degrees) and kind of motion there, by tilt; each holds half-way to its neighbours.
    pub at: Vec<(f64, String)>,
}

impl Bands {
    /// Those of a sweep over the tilt, from the table that it has written: the first start's. `None` where the
    /// sweep is over something else.
    ///
    /// # Errors
    /// When the table cannot be read.
    pub fn of_sweep(table: &Path) -> Result<Option<Self>, TableError> {
        let swept = read_table(table)?;
        let Ok(plan) = SweepPlan::of_identity(&swept.identity) else {
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
            "by the sweep of {} in {}, started {first}",
            escape::code(&plan.scene.name),
            escape::line(&table.to_string_lossy())
        );
        Ok(Some(Self { source, at }))
    }

    /// Those of linear stability of steady sliding within a reach (degrees): what no sweep has told.
    pub fn by_stability(scene: &Scene, [low, high]: [f64; 2]) -> Self {
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
            false => "computed: linear stability of steady sliding; what is heard may differ. For what was \
                      found by simulation, run `squeakscope sweep` first"
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
        let bands = Bands::by_stability(&scene, [0.0, 10.0]);
        assert_eq!(bands.at.len(), TILTS);
        assert_eq!((bands.at[0].0, bands.at[TILTS - 1].0), (0.0, 10.0));
        // Four bending modes at no tilt, and never rest.
        assert_eq!(bands.at[0].1, "4 unstable modes");
        assert!(
            bands.at.iter().all(|(_, kind)| kind.contains("unstable")),
            "{bands:?}"
        );
        let still = Scene::load("printed-friction").unwrap();
        let bands = Bands::by_stability(&still, [0.0, 4.0]);
        assert!(
            bands.at.iter().all(|(_, kind)| kind == "stable"),
            "{bands:?}"
        );
    }

    #[test]
    fn what_has_no_tilt_has_no_bands() {
        let scene = Scene::load("mass-on-belt").unwrap();
        assert_eq!(Bands::by_stability(&scene, [0.0, 1.0]), Bands::default());
    }
}
