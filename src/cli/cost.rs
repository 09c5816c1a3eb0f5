//! `squeakscope cost`: what accuracy and effects cost in a scene.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::document::Document;
use super::error::CliError;
use super::figures::{STUDY, draw};
use super::interrupt;
use super::output::Kind;
use super::progress::Progress;
use super::report::{self, HEADING};
use super::resources;
use super::study_args::CostArgs;
use crate::escape;
use crate::number::{error, quantity, short, tolerance, uncertain};
use crate::pipeline::{Monitor, drive, source};
use crate::plot::cost_figure;
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study::cost::{Cost, CostError, Effect, Motion, Origin, Setting, WorkPrecision, cost};
use crate::table::Table;

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the complete part is written.
pub(super) fn execute(args: &CostArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    report::print_study_warnings(&scene);
    let [json] = args.overwrite.check_all(
        args.scene.input(),
        [("--json", Kind::JSON, args.json.as_deref())],
    )?;
    if let Some(directory) = &args.figures {
        let names = args.drawn.names(["cost"], &STUDY);
        args.overwrite
            .check_directory(directory, "--figures", &names)?;
    }
    resources::check_memory()?;
    resources::start_thread_pool()?;
    let study = match measure(&scene, stop) {
        Err(CostError::Stopped) => return Err(CliError::NoResult),
        found => found.map_err(CliError::during("cost study"))?,
    };
    // The report is printed even if a file cannot be written.
    let mut files = Vec::new();
    let drawn = draw(
        args.figures.as_deref(),
        || vec![cost_figure(&scene.name, &study)],
        (&args.drawn, &STUDY),
        &mut files,
    );
    Document::new(&study, &files)
        .with_scene(&scene.name)
        .deliver(&text(&scene.name, &study), json.as_ref())?;
    drawn?;
    if study.stopped {
        return Err(CliError::Interrupted);
    }
    Ok(())
}

/// Runs the study; recordings go to a temporary directory.
fn measure(scene: &Scene, stop: &Arc<AtomicBool>) -> Result<Cost, CostError> {
    let progress = Progress::with_estimate();
    let run_all = &mut |scene: &Scene| {
        let folder = tempfile::tempdir()?;
        let output = Output {
            save: Some(folder.path().join("cost.rrd")),
            ..Output::default()
        };
        let run = source(scene)?;
        let mut sink = RerunSink::new(&output, scene.record)?;
        let monitor = Monitor {
            stop,
            ..Monitor::default()
        };
        drive(run, "", &mut sink, monitor)?;
        Ok(())
    };
    cost(scene, Some(run_all), &mut |(task, share)| {
        progress.update(share, task);
        interrupt::should_continue(stop)
    })
}

/// The report for the terminal.
fn text(scene: &str, study: &Cost) -> String {
    let mut text = format!(
        "{HEADING}{}{HEADING:#}: {}; settles for {}, measured for {}\n",
        escape::line(scene),
        motion(&study.reference),
        quantity(study.settling, 3, "s"),
        quantity(study.measurement, 3, "s"),
    );
    if let Some(held) = study.fixed_at.description() {
        let _ = writeln!(text, "  held at its initial values: {held}");
    }
    if let Some(scatter) = study.scatter {
        let _ = writeln!(
            text,
            "  two measurements of this motion differ by {}: smaller errors cannot be seen",
            error(scatter)
        );
    }
    for setting in Setting::ALL {
        let sets = study.settings.iter().filter(|set| set.setting == setting);
        let sets: Vec<&WorkPrecision> = sets.collect();
        if !sets.is_empty() {
            let (name, time) = (setting.name(), setting.time());
            let _ = writeln!(text, "{HEADING}{name}{HEADING:#}: error, and {time}");
            text += &levels(&sets).text();
        }
    }
    if !study.choices.is_empty() {
        let _ = writeln!(
            text,
            "{HEADING}settings for a total error{HEADING:#}, verified by a run at the next finer level of everything"
        );
        text += &choices(study).text();
    }
    if let Some(run) = study.run_time {
        let _ = writeln!(
            text,
            "{HEADING}effects{HEADING:#}: a complete run takes {} s of CPU time per simulated s",
            short(run)
        );
        text += &effects(&study.effects).text();
    }
    text
}

/// A motion in words.
fn motion(motion: &Motion) -> String {
    let mut words = motion.regime.to_string();
    if let (Some(frequency), Some(amplitude)) = (motion.frequency_hz, motion.amplitude_m) {
        let amplitude = quantity(amplitude, 4, "m");
        let _ = write!(words, ", {frequency:.1} Hz with {amplitude}");
    }
    let rms = quantity(motion.rms_velocity_m_per_s, 4, "m/s");
    let _ = write!(words, ", rms velocity {rms}");
    if let Some(exponent) = motion.exponent_per_s {
        let value = uncertain(exponent.value, exponent.half_width);
        let _ = write!(words, ", largest exponent {value} 1/s");
    }
    words
}

/// The levels of one setting: a column for each method.
fn levels(sets: &[&WorkPrecision]) -> Table {
    let mut table = Table::default().right("");
    for set in sets {
        table = table.right(&set.method).right("");
    }
    for (row, level) in sets[0].points.iter().enumerate() {
        let cells = sets.iter().filter_map(|set| set.points.get(row));
        let cells = cells.flat_map(|point| match point.error {
            Some(found) => [error(found), short(point.cpu_s)],
            None => ["failed".to_owned(), String::new()],
        });
        table.row([tolerance(level.value)].into_iter().chain(cells));
    }
    table
}

fn choices(study: &Cost) -> Table {
    let mut table = Table::default().right("error").left("").left("method");
    for title in ["tolerance", "nodes", "elements, mm", "s per s", "verified"] {
        table = table.right(title);
    }
    table = table.left("");
    for choice in &study.choices {
        let settings = &choice.settings;
        let remark = match (choice.is_met, choice.exponents_agree) {
            (false, _) => "not met",
            (true, Some(false)) => "exponents differ",
            (true, _) => "",
        };
        table.row([
            error(choice.target),
            match choice.origin {
                Origin::Cheapest => "cheapest".to_owned(),
                Origin::Accuracy => "--accuracy".to_owned(),
            },
            settings.method.clone(),
            tolerance(settings.tolerance),
            settings.nodes.map(|n| n.to_string()).unwrap_or_default(),
            settings.element_size_mm.map(short).unwrap_or_default(),
            short(choice.cpu_s_per_s),
            error(choice.error),
            remark.to_owned(),
        ]);
    }
    table
}

fn effects(effects: &[Effect]) -> Table {
    let mut table = Table::default().left("effect").left("key");
    table = table.right("s per s").right("ratio").left("without it");
    for effect in effects {
        let price = match effect.price_s_per_s {
            Some(price) if price.abs() < effect.noise_s_per_s => {
                format!("< {}", short(effect.noise_s_per_s))
            }
            Some(price) => short(price),
            None => String::new(),
        };
        let without = match (&effect.unavailable, &effect.without, effect.change) {
            (Some(reason), ..) => format!("cannot be switched off alone: {}", escape::line(reason)),
            (None, Some(other), Some(change)) => {
                format!("{} ({} different)", motion(other), error(change))
            }
            _ => String::new(),
        };
        table.row([
            effect.name.clone(),
            effect.key.clone(),
            price,
            effect.ratio.map(short).unwrap_or_default(),
            without,
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_has_the_numbers_of_the_result() {
        let scene = Scene::load("mass-on-belt").unwrap();
        let study = cost(&scene, None, &mut |_| true).unwrap();
        let text = text(&scene.name, &study);
        for choice in &study.choices {
            assert!(text.contains(&error(choice.error)), "{text}");
        }
        for effect in &study.effects {
            assert!(text.contains(&effect.key), "{text}");
        }
        let points = study.settings.iter().flat_map(|set| &set.points);
        for found in points.filter_map(|point| point.error) {
            assert!(text.contains(&error(found)), "{text}");
        }
        let json = serde_json::to_value(&study).unwrap();
        assert_eq!(json["choices"][0]["error"], study.choices[0].error);
    }
}
