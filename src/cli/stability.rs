//! `squeakscope stability`: complex eigenvalues at steady sliding.

use std::sync::atomic::AtomicBool;

use super::args::StabilityArgs;
use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use crate::number::degrees;
use crate::plot::{Figure, causes_figure, sensitivities_figure};
use crate::scene::Parameter;
use crate::study::StabilityResult;

/// Stem of a figure at a tilt among several.
fn figure_name(stem: &str, tilt_deg: f64, of: usize) -> String {
    match of {
        1 => stem.to_owned(),
        _ => format!("{stem}-{tilt_deg}deg"),
    }
}

/// The requested figures at each tilt of a result, which has all tilts (`of`) unless it is interrupted.
fn figures(args: &StabilityArgs, scene: &str, result: &StabilityResult, of: usize) -> Vec<Figure> {
    let figures = result.tilts.iter().flat_map(|modes| {
        let tilt_deg = degrees(modes.at.tilt);
        let title = format!("{scene} at {tilt_deg} deg");
        let causes = args
            .causes
            .then(|| causes_figure(&title, &modes.at, &modes.explained));
        let sensitivities = args
            .sensitivities
            .then(|| sensitivities_figure(&title, &modes.sensitive()));
        let named = move |figure: Figure| Figure {
            name: figure_name(&figure.name, tilt_deg, of),
            ..figure
        };
        causes.into_iter().chain(sensitivities).map(named)
    });
    figures.collect()
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure of the analysis; an interrupt, after the finished tilts are written.
pub(super) fn stability(args: &StabilityArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    console::print_warnings(&scene.warnings());
    scene.joint()?;
    console::print_fixed(&scene, [Parameter::tilt()]);
    let tilts_deg: Vec<f64> = match &args.tilt {
        Some(steps) => steps.0.clone(),
        None => scene.joint()?.tilt.degrees(),
    };
    // Refuse invalid tilts before the study starts.
    for tilt_deg in &tilts_deg {
        scene.clone().with_tilt(*tilt_deg)?;
    }
    if args.causes && scene.joint()?.spec.friction.states() > 0 {
        return Err(CliError::Input(
            "the causes of growth (--causes) are computed for friction that depends on the slip velocity alone; omit \
             --causes, or choose another friction.law than \"lugre\" and \"rate-and-state\""
                .to_owned(),
        ));
    }
    let requested = [
        (args.causes, "causes"),
        (args.sensitivities, "sensitivities"),
    ];
    let stems = requested.iter().filter(|(is_drawn, _)| *is_drawn);
    let stems = stems.flat_map(|(_, stem)| {
        let (tilts, of) = (tilts_deg.iter(), tilts_deg.len());
        tilts.map(move |tilt_deg| figure_name(stem, *tilt_deg, of))
    });
    let outputs = Outputs::new(args.scene.input(), &args.output);
    let files = outputs.figures(&args.figures, STUDY, stems)?;
    let watch = Watch::new(stop);
    let requested = [args.causes, args.sensitivities];
    let result = StabilityResult::new(&scene, &tilts_deg, requested, &mut watch.progress());
    let result = result.map_err(CliError::during("stability analysis"))?;
    files.finish(watch, Some(&scene.name), &result, |files| {
        files.draw(|| figures(args, &scene.name, &result, tilts_deg.len()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::tests::parsed;
    use crate::scene::Scene;

    #[test]
    fn modes_are_computed_at_each_tilt() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.json");
        let line = format!("periodic-2deg --tilt 0:7:3.5 --json {}", path.display());
        stability(&parsed(&line), &AtomicBool::new(false)).expect("done");
        let text = std::fs::read(path).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(json["scene"], "periodic-2deg");
        assert_eq!(json["min_growth_per_s"], 0.1);
        let tilts = json["tilts"].as_array().expect("a list");
        assert_eq!(tilts.len(), 3);
        assert_eq!(tilts[1]["tilt_rad"], 3.5_f64.to_radians());
        for tilt in tilts {
            let modes = tilt["modes"].as_array().expect("a list");
            // Each of the 11 modes has a pair of complex eigenvalues, or two real ones.
            let oscillate = modes.iter().filter(|mode| mode["frequency_hz"] != 0.0);
            assert_eq!(modes.len() + oscillate.count(), 22);
            assert!(tilt.get("explained").is_none());
        }
        // The growth rate depends on the tilt.
        let growth = |k: usize| tilts[k]["modes"][0]["growth_per_s"].as_f64();
        assert!(growth(0).is_some() && growth(0) != growth(2));
    }

    #[test]
    fn friction_with_a_state_has_no_causes() {
        let args = parsed("bristles --causes");
        let refused = stability(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(refused.exit_code(), 2);
        assert!(refused.to_string().contains("omit --causes"), "{refused}");
    }

    #[test]
    fn default_tilts_are_the_knots_of_the_scene() {
        let tilts = |name| {
            let scene = Scene::load(name).expect("preset");
            scene.joint().expect("a joint").tilt.degrees()
        };
        assert_eq!(tilts("doubled-torus-3deg"), [3.0]);
        assert_eq!(tilts("tilt-ramp"), [0.0, 3.0, 5.5, 6.0]);
    }
}
