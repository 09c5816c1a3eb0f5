//! `squeakscope stability`: complex eigenvalues at steady sliding.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use schemars::JsonSchema;
use serde::Serialize;

use super::args::StabilityArgs;
use super::document::Document;
use super::error::{Cause, CliError};
use super::figures::{STUDY, draw};
use super::interrupt;
use super::output::Kind;
use super::progress::Progress;
use super::report::{self, BAD, HEADING};
use crate::escape;
use crate::joint::{BallJoint, CauseOfGrowth, ExplainedMode, MIN_GROWTH};
use crate::number::{degrees, fixed, significant};
use crate::plot::{Figure, causes_figure, sensitivities_figure};
use crate::scene::{Parameter, Scene, SceneError, Schedule};
use crate::study::branch::{ModeSensitivities, sensitivities};
use crate::study::{StabilityAt, growth_causes, stability as modes};
use crate::table::Table;

/// Largest number of sensitivities that are printed for a mode.
const MOST_SENSITIVE: usize = 12;

/// The modes at each tilt.
#[derive(Serialize, JsonSchema)]
pub(super) struct StabilityResult {
    /// Minimum growth rate of an unstable mode, 1/s; a slower growth is not visible in a run.
    min_growth_per_s: f64,
    /// Tilts in the requested order.
    tilts: Vec<ModesAt>,
}

/// The modes at a tilt, with the causes of growth and the sensitivities if requested.
#[derive(Serialize, JsonSchema)]
struct ModesAt {
    #[serde(flatten)]
    at: StabilityAt,
    /// Oscillating modes, each explained by the causes of its growth; only with `--causes`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    explained: Vec<ExplainedMode>,
    /// Oscillating modes, each with its sensitivities to the numbers of the scene; only with `--sensitivities`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sensitivities: Vec<ModeSensitivities>,
}

impl ModesAt {
    /// The unstable modes with sensitivities; the one with the largest growth rate if none is unstable.
    fn sensitive(&self) -> Vec<&ModeSensitivities> {
        let all = &self.sensitivities;
        let unstable: Vec<_> = all.iter().filter(|mode| mode.mode.unstable).collect();
        if unstable.is_empty() {
            let largest = all
                .iter()
                .max_by(|a, b| a.mode.growth.total_cmp(&b.mode.growth));
            largest.into_iter().collect()
        } else {
            unstable
        }
    }
}

/// Stem of a figure at a tilt among several.
fn figure_name(stem: &str, tilt_deg: f64, of: usize) -> String {
    match of {
        1 => stem.to_owned(),
        _ => format!("{stem}-{tilt_deg}deg"),
    }
}

/// The requested figures at each tilt.
fn figures(
    args: &StabilityArgs,
    scene: &str,
    tilts_deg: &[f64],
    result: &StabilityResult,
) -> Vec<Figure> {
    let figures = tilts_deg
        .iter()
        .zip(&result.tilts)
        .flat_map(|(tilt_deg, modes)| {
            let title = format!("{scene} at {tilt_deg} deg");
            let causes = args
                .causes
                .then(|| causes_figure(&title, &modes.at, &modes.explained));
            let sensitivities = args
                .sensitivities
                .then(|| sensitivities_figure(&title, &modes.sensitive()));
            let named = move |figure: Figure| Figure {
                name: figure_name(&figure.name, *tilt_deg, tilts_deg.len()),
                ..figure
            };
            causes.into_iter().chain(sensitivities).map(named)
        });
    figures.collect()
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure of the analysis; an interrupt.
pub(super) fn stability(args: &StabilityArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    report::print_warnings(&scene.warnings());
    scene.joint()?;
    report::print_fixed(&scene, [Parameter::tilt()]);
    let tilts_deg: Vec<f64> = match &args.tilt {
        Some(steps) => steps.values().collect(),
        None => tilts_of(&scene.joint()?.tilt),
    };
    let tilts = tilts_deg.iter().map(|&tilt_deg| {
        let tilted = scene.clone().with_tilt(tilt_deg)?;
        Ok(tilted.joint()?.tilt.at(0.0))
    });
    let tilts = tilts.collect::<Result<Vec<_>, SceneError>>()?;
    if args.causes && scene.joint()?.spec.friction.states() > 0 {
        return Err(CliError::NoCauses);
    }
    let json = [("--json", Kind::JSON, args.json.as_deref())];
    let [json] = args.overwrite.check_all(args.scene.input(), json)?;
    if let Some(directory) = &args.figures {
        let requested = [
            (args.causes, "causes"),
            (args.sensitivities, "sensitivities"),
        ];
        let stems = requested.iter().filter(|(is_drawn, _)| *is_drawn);
        let stems = stems.flat_map(|(_, stem)| {
            let tilts_deg = tilts_deg.iter();
            tilts_deg.map(|tilt_deg| figure_name(stem, *tilt_deg, tilts.len()))
        });
        let names = args.drawn.names(stems, &STUDY);
        args.overwrite
            .check_directory(directory, "--figures", &names)?;
    }
    let result = analyse(&scene, &tilts, args.causes);
    let mut result = result.map_err(CliError::during("stability analysis"))?;
    if args.sensitivities {
        add_sensitivities(&scene, &tilts_deg, &mut result, stop)?;
    }
    let mut written = Vec::new();
    // The report is printed even if a file cannot be written.
    let drawn = draw(
        args.figures.as_deref(),
        || figures(args, &scene.name, &tilts_deg, &result),
        (&args.drawn, &STUDY),
        &mut written,
    );
    let texts = tilts_deg.iter().zip(&result.tilts);
    let text: String = texts
        .map(|(tilt_deg, modes)| text(&scene.name, *tilt_deg, modes))
        .collect();
    let document = Document::new(&result, &written).with_scene(&scene.name);
    document.deliver(&text, json.as_ref())?;
    drawn
}

/// Computes the sensitivities at each tilt.
fn add_sensitivities(
    scene: &Scene,
    tilts_deg: &[f64],
    result: &mut StabilityResult,
    stop: &AtomicBool,
) -> Result<(), CliError> {
    let progress = Progress::with_estimate();
    for (k, (tilt_deg, at)) in tilts_deg.iter().zip(&mut result.tilts).enumerate() {
        let tilted = scene.with_values(&[(Parameter::tilt(), *tilt_deg)])?;
        let found = sensitivities(&tilted, &mut |share| {
            progress.update((k as f64 + share) / tilts_deg.len() as f64, "sensitivities");
            interrupt::should_continue(stop)
        });
        let found = found.map_err(CliError::during("study of sensitivities"))?;
        at.sensitivities = found.ok_or(CliError::NoResult)?;
    }
    Ok(())
}

/// Computes the modes at steady sliding at each tilt (rad), by frequency, and the causes of growth if
/// requested.
fn analyse(scene: &Scene, tilts: &[f64], causes: bool) -> Result<StabilityResult, Cause> {
    let ball = BallJoint::new(&scene.joint()?.spec)?;
    let explained = match causes {
        true => growth_causes(&ball, tilts)?,
        false => vec![Vec::new(); tilts.len()],
    };
    let tilts = modes(&ball, tilts)?.into_iter().zip(explained);
    let tilts = tilts.map(|(at, explained)| ModesAt {
        at,
        explained,
        sensitivities: Vec::new(),
    });
    Ok(StabilityResult {
        min_growth_per_s: MIN_GROWTH,
        tilts: tilts.collect(),
    })
}

/// The distinct tilts of the knots of a schedule, degrees, in ascending order.
fn tilts_of(tilt: &Schedule) -> Vec<f64> {
    let mut tilts: Vec<_> = tilt.values().into_iter().map(degrees).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.dedup();
    tilts
}

/// The table of the modes at a tilt.
fn text(scene: &str, tilt_deg: f64, modes: &ModesAt) -> String {
    let ModesAt { at, explained, .. } = modes;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{HEADING}{}{HEADING:#} at {tilt_deg} deg: {} of {} modes unstable (growth rate from {MIN_GROWTH} 1/s)",
        escape::line(scene),
        at.unstable().count(),
        at.modes.len()
    );
    let causes = explained.first().map_or(&[][..], |mode| &mode.causes);
    let mut table = Table::default()
        .right("frequency, Hz")
        .right("growth rate, 1/s");
    for cause in causes {
        table = table.right(cause.cause.name());
    }
    table = table.left("mode").left("");
    // Both lists are sorted by frequency; `explained` has only the oscillating modes.
    let mut explained = explained.iter();
    for mode in &at.modes {
        let causes_of_mode = (mode.frequency_hz > 0.0)
            .then(|| explained.next())
            .flatten();
        let mut row = vec![fixed(mode.frequency_hz, 1), fixed(mode.growth, 2)];
        row.extend(
            (0..causes.len())
                .map(|k| causes_of_mode.map_or_else(String::new, |mode| share(&mode.causes[k]))),
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
            "  share of each term in the growth rate, 1/s; in brackets the growth rate without the term\n",
        );
    }
    for mode in modes.sensitive() {
        text += &sensitivity_text(mode);
    }
    text.push('\n');
    text
}

/// The table of the sensitivities of a mode.
fn sensitivity_text(mode: &ModeSensitivities) -> String {
    let mut text = format!(
        "\n  {HEADING}{} at {:.1} Hz{HEADING:#}: change of growth rate and frequency with the numbers of the scene\n",
        mode.mode.label, mode.mode.frequency_hz
    );
    let mut table = Table::default()
        .left("number")
        .right("value")
        .right("1/s per 1 %")
        .right("1/s per unit")
        .right("Hz per 1 %");
    table = table.right("Hz per unit").left("unit");
    for parameter in mode.parameters.iter().take(MOST_SENSITIVE) {
        table.row([
            parameter.parameter.clone(),
            significant(parameter.value, 5),
            significant(parameter.growth_per_percent, 4),
            significant(parameter.growth_per_unit, 4),
            significant(parameter.frequency_per_percent, 4),
            significant(parameter.frequency_per_unit, 4),
            parameter.unit.clone(),
        ]);
    }
    text += &table.text();
    if mode.parameters.len() > MOST_SENSITIVE {
        let rest = mode.parameters.len() - MOST_SENSITIVE;
        let _ = writeln!(
            text,
            "  and {rest} more with smaller changes: --json has all"
        );
    }
    text
}

/// The share of a cause, and the rate without it. Adding 0.0 turns -0.0 into 0.0.
fn share(cause: &CauseOfGrowth) -> String {
    format!("{:.1} ({:.1})", cause.share + 0.0, cause.without + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::joint::NamedMode;

    #[test]
    fn modes_are_computed_at_each_tilt() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.json");
        let args = StabilityArgs {
            scene: SceneArgs {
                scene: Some("periodic-2deg".to_owned()),
                ..SceneArgs::default()
            },
            tilt: Some("0:7:3.5".parse().expect("a sweep")),
            causes: false,
            sensitivities: false,
            json: Some(path.clone()),
            figures: None,
            overwrite: Default::default(),
            drawn: Default::default(),
        };
        stability(&args, &AtomicBool::new(false)).expect("done");
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
        let args = StabilityArgs {
            scene: SceneArgs {
                scene: Some("bristles".to_owned()),
                ..SceneArgs::default()
            },
            tilt: None,
            causes: true,
            sensitivities: false,
            json: None,
            figures: None,
            overwrite: Default::default(),
            drawn: Default::default(),
        };
        let refused = stability(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(refused.exit_code(), 2);
        assert!(refused.to_string().contains("omit --causes"), "{refused}");
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
                tilt: 0.1,
                modes: vec![mode(0.0, -9.0), mode(1780.1, 766.6)],
            },
            explained: Vec::new(),
            sensitivities: Vec::new(),
        };
        let plain =
            |modes: &ModesAt| anstream::adapter::strip_str(&text("s", 3.5, modes)).to_string();
        assert_eq!(
            plain(&modes),
            [
                "s at 3.5 deg: 1 of 2 modes unstable (growth rate from 0.1 1/s)",
                "  frequency, Hz  growth rate, 1/s  mode",
                "            0.0             -9.00  1st bending x",
                "         1780.1            766.60  1st bending x  unstable",
                "\n",
            ]
            .join("\n")
        );
        modes.explained = vec![ExplainedMode {
            frequency_hz: 1780.1,
            growth: 766.6,
            causes: vec![CauseOfGrowth {
                cause: crate::joint::Cause::Slope,
                share: 700.0,
                without: -0.0,
            }],
        }];
        let text = plain(&modes);
        // A mode without causes has an empty column.
        let blank = " ".repeat(crate::joint::Cause::Slope.name().len() + 4);
        assert!(text.contains("  700.0 (0.0)  1st bending x"), "{text}");
        assert!(
            text.contains(&format!("-9.00{blank}1st bending x\n")),
            "{text}"
        );
        let json = serde_json::to_value(&modes).expect("JSON");
        assert_eq!(
            json["explained"][0]["causes"][0]["cause"],
            crate::joint::Cause::Slope.name()
        );
        assert_eq!(json["explained"][0]["causes"][0]["share_per_s"], 700.0);
    }

    #[test]
    fn default_tilts_are_the_knots_of_the_scene() {
        let tilts = |name| {
            let scene = Scene::load(name).expect("preset");
            tilts_of(&scene.joint().expect("a joint").tilt)
        };
        assert_eq!(tilts("doubled-torus-3deg"), [3.0]);
        assert_eq!(tilts("tilt-ramp"), [0.0, 3.0, 5.5, 6.0]);
    }
}
