//! `squeakscope stability`: which modes can squeak, by complex eigenvalues at steady sliding.

use std::ffi::OsStr;

use super::args::StabilityArgs;
use super::error::{Cause, CliError};
use super::output::check_all;
use super::report::{self, ModeReport, StabilityReport, TiltReport};
use crate::VERSION;
use crate::scene::{DEFAULT_SCENE, Held, Scene, SceneError, Schedule};

/// Runs the command; `analyse` gives the modes of a scene's joint at each of the tilts (rad), with their
/// causes or without.
///
/// # Errors
/// Bad input before any work; a fault of the analysis.
pub(super) fn stability(
    args: &StabilityArgs,
    analyse: impl FnOnce(&Scene, &[f64], bool) -> Result<Vec<Vec<ModeReport>>, Cause>,
) -> Result<(), CliError> {
    let scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    report::print_warnings(&scene.warnings());
    report::print_held(Held {
        tilt: None,
        ..scene.joint()?.held_at_first()
    });
    let tilts_deg = match &args.tilt {
        Some(sweep) => sweep.values().collect(),
        None => tilts_of(&scene.joint()?.tilt),
    };
    let tilts = tilts_deg.iter().map(|&tilt_deg| {
        let there = scene.clone().with_tilt(tilt_deg)?;
        Ok(there.joint()?.tilt.at(0.0))
    });
    let tilts = tilts.collect::<Result<Vec<_>, SceneError>>()?;
    let [json] = check_all(
        args.scene.as_deref().map(OsStr::new),
        [("--json", args.json.as_deref())],
    )?;
    let modes = analyse(&scene, &tilts, args.causes).map_err(|source| CliError::Run {
        doing: "stability analysis",
        source,
    })?;
    let report = StabilityReport {
        version: VERSION,
        scene: scene.name,
        tilts: tilts_deg
            .into_iter()
            .zip(modes)
            .map(|(tilt_deg, modes)| TiltReport { tilt_deg, modes })
            .collect(),
    };
    Ok(report::deliver(&report, json.as_ref())?)
}

/// The tilts that a schedule is made of in degrees, each once, in order.
fn tilts_of(tilt: &Schedule) -> Vec<f64> {
    let mut tilts: Vec<_> = tilt.values().into_iter().map(report::degrees).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.dedup();
    tilts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tilt_has_its_modes() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let json = folder.path().join("out.json");
        let args = StabilityArgs {
            scene: Some("periodic-2deg".to_owned()),
            tilt: Some("0:7:3.5".parse().expect("a sweep")),
            causes: false,
            json: Some(json.clone()),
        };
        let frequency_tells_tilt = |_: &Scene, tilts: &[f64], _: bool| -> Result<_, Cause> {
            let modes = tilts.iter().map(|tilt| {
                vec![ModeReport {
                    frequency_hz: tilt.to_degrees().round(),
                    growth_per_s: 1.0,
                    label: "1st bending x".to_owned(),
                    unstable: true,
                    causes: Vec::new(),
                }]
            });
            Ok(modes.collect())
        };
        stability(&args, frequency_tells_tilt).expect("done");
        let text = std::fs::read(json).expect("written");
        let report: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        let tilts = report["tilts"].as_array().expect("a list");
        assert_eq!(tilts.len(), 3);
        assert_eq!(tilts[1]["tilt_deg"], 3.5);
        assert_eq!(tilts[2]["modes"][0]["frequency_hz"], 7.0);
    }

    #[test]
    fn without_a_sweep_the_knots_are_taken() {
        let tilts = |name| {
            let scene = Scene::load(name).expect("preset");
            tilts_of(&scene.joint().expect("a joint").tilt)
        };
        assert_eq!(tilts("torus-3deg"), [3.0]);
        assert_eq!(tilts("tilt-ramp"), [0.0, 3.0, 5.5, 6.0]);
    }
}
