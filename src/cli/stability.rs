//! `squeakscope stability`: which modes can squeak, by complex eigenvalues at steady sliding.

use std::fmt::Write as _;

use serde::Serialize;

use super::args::StabilityArgs;
use super::document::Document;
use super::error::{Cause, CliError};
use super::output::check_all;
use super::report::{self, BAD, NAME};
use crate::escape;
use crate::joint::{BallJoint, CauseOfGrowth, ExplainedMode};
use crate::number::fixed;
use crate::scene::{Held, Scene, SceneError, Schedule};
use crate::study::{StabilityAt, growth_causes, stability as modes};
use crate::table::Table;

/// What was found, in the order asked for.
#[derive(Serialize)]
struct Found {
    tilts: Vec<FoundAt>,
}

/// The modes at a tilt, and where that was asked for why those that oscillate grow.
#[derive(Serialize)]
struct FoundAt {
    #[serde(flatten)]
    at: StabilityAt,
    /// The oscillating modes with the causes of their growth, with `--causes`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    explained: Vec<ExplainedMode>,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault of the analysis.
pub(super) fn stability(args: &StabilityArgs) -> Result<(), CliError> {
    let scene = args.scene.load()?;
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
    let [json] = check_all(args.scene.input(), [("--json", args.json.as_deref())])?;
    let found = analyse(&scene, &tilts, args.causes).map_err(|source| CliError::Run {
        doing: "stability analysis",
        source,
    })?;
    let texts = tilts_deg.iter().zip(&found.tilts);
    let text: String = texts
        .map(|(tilt_deg, found)| text(&scene.name, *tilt_deg, found))
        .collect();
    let document = Document::new(&found, &[]).of_scene(&scene.name);
    Ok(document.deliver(&text, json.as_ref())?)
}

/// The modes at steady sliding at each of the tilts (rad), by frequency, with their causes if asked for.
fn analyse(scene: &Scene, tilts: &[f64], causes: bool) -> Result<Found, Cause> {
    let ball = BallJoint::new(&scene.joint()?.spec)?;
    let explained = match causes {
        true => growth_causes(&ball, tilts)?,
        false => vec![Vec::new(); tilts.len()],
    };
    let tilts = modes(&ball, tilts)?.into_iter().zip(explained);
    let tilts = tilts.map(|(at, explained)| FoundAt { at, explained });
    Ok(Found {
        tilts: tilts.collect(),
    })
}

/// The tilts that a schedule is made of in degrees, each once, in order.
fn tilts_of(tilt: &Schedule) -> Vec<f64> {
    let mut tilts: Vec<_> = tilt.values().into_iter().map(report::degrees).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.dedup();
    tilts
}

/// The modes at a tilt as a table.
fn text(scene: &str, tilt_deg: f64, FoundAt { at, explained }: &FoundAt) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{NAME}{}{NAME:#} at {tilt_deg} deg: {} of {} modes unstable",
        escape::line(scene),
        at.unstable().count(),
        at.modes.len()
    );
    let causes = explained.first().map_or(&[][..], |mode| &mode.causes);
    let mut table = Table::default().right("frequency Hz").right("growth 1/s");
    for cause in causes {
        table = table.right(cause.cause.name());
    }
    table = table.left("mode").left("");
    // Both lists are by frequency; what does not oscillate has no causes.
    let mut explained = explained.iter();
    for mode in &at.modes {
        let why = (mode.frequency_hz > 0.0)
            .then(|| explained.next())
            .flatten();
        let mut row = vec![fixed(mode.frequency_hz, 1), fixed(mode.growth, 2)];
        row.extend(
            (0..causes.len()).map(|k| why.map_or_else(String::new, |why| share(&why.causes[k]))),
        );
        row.push(mode.label.clone());
        row.push(match mode.unstable {
            true => format!("{BAD}unstable{BAD:#}"),
            false => String::new(),
        });
        table.row(row);
    }
    text += &table.text();
    if !causes.is_empty() {
        text.push_str(
            "  each cause with its share of the growth rate, and in brackets what the rate would be \
             without it\n",
        );
    }
    text.push('\n');
    text
}

/// The share of a cause, and the rate without it. Zero has no sign to a reader.
fn share(cause: &CauseOfGrowth) -> String {
    format!("{:.1} ({:.1})", cause.share + 0.0, cause.without + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::joint::NamedMode;

    #[test]
    fn each_tilt_has_its_modes() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let json = folder.path().join("out.json");
        let args = StabilityArgs {
            scene: SceneArgs {
                scene: Some("periodic-2deg".to_owned()),
            },
            tilt: Some("0:7:3.5".parse().expect("a sweep")),
            causes: false,
            json: Some(json.clone()),
        };
        stability(&args).expect("done");
        let text = std::fs::read(json).expect("written");
        let found: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(found["scene"], "periodic-2deg");
        let tilts = found["tilts"].as_array().expect("a list");
        assert_eq!(tilts.len(), 3);
        assert_eq!(tilts[1]["tilt_rad"], 3.5_f64.to_radians());
        for tilt in tilts {
            let modes = tilt["modes"].as_array().expect("a list");
            // Each of the eleven modes oscillates, or has two rates without oscillating.
            let oscillate = modes.iter().filter(|mode| mode["frequency_hz"] != 0.0);
            assert_eq!(modes.len() + oscillate.count(), 22);
            assert!(tilt.get("explained").is_none());
        }
        // The growth of a mode changes with the tilt.
        let growth = |k: usize| tilts[k]["modes"][0]["growth_per_s"].as_f64();
        assert!(growth(0).is_some() && growth(0) != growth(2));
    }

    #[test]
    fn unstable_modes_are_marked_and_causes_have_columns() {
        let mode = |frequency_hz, growth: f64| NamedMode {
            frequency_hz,
            growth,
            label: "1st bending x".to_owned(),
            unstable: growth > 0.0,
        };
        let mut found = FoundAt {
            at: StabilityAt {
                tilt: 0.1,
                modes: vec![mode(0.0, -9.0), mode(1780.1, 766.6)],
            },
            explained: Vec::new(),
        };
        let plain =
            |found: &FoundAt| anstream::adapter::strip_str(&text("s", 3.5, found)).to_string();
        assert_eq!(
            plain(&found),
            "s at 3.5 deg: 1 of 2 modes unstable\n  frequency Hz  growth 1/s  mode\n           0.0       -9.00  1st \
             bending x\n        1780.1      766.60  1st bending x  unstable\n\n"
        );
        found.explained = vec![ExplainedMode {
            frequency_hz: 1780.1,
            growth: 766.6,
            causes: vec![CauseOfGrowth {
                cause: crate::joint::Cause::Slope,
                share: 700.0,
                without: -0.0,
            }],
        }];
        let text = plain(&found);
        assert!(
            text.contains("766.60     700.0 (0.0)  1st bending x"),
            "{text}"
        );
        assert!(
            text.contains("-9.00                  1st bending x\n"),
            "{text}"
        );
        let json = serde_json::to_value(&found).expect("JSON");
        assert_eq!(json["explained"][0]["causes"][0]["cause"], "negative slope");
        assert_eq!(json["explained"][0]["causes"][0]["share_per_s"], 700.0);
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
