//! `squeakscope friction`: fit the Stribeck law to measured coefficients of friction.

use std::path::PathBuf;

use clap::Args as Arguments;

use super::common_args::positive;
use super::error::CliError;
use super::harness::{OutputArgs, Outputs};
use crate::foreign::csv_rows;
use crate::study::friction_fit::{FrictionPoint, LARGEST_COEFFICIENT, fit_friction};

/// Highest plausible slip speed, m/s; a higher one is in other units.
const FASTEST: f64 = 50.0;

/// Arguments of `squeakscope friction`.
#[derive(Debug, Arguments)]
pub struct FrictionArgs {
    /// CSV file with the columns speed_m_per_s, mu and, if it is known, mu_deviation: the standard deviation of mu. Speeds
    /// may repeat and come in any order; text after # is a comment.
    pub file: PathBuf,
    /// Slope factor of the creep region, which points above a few mm/s do not show.
    #[arg(long, value_name = "S_PER_M", default_value_t = 1000.0, value_parser = positive)]
    pub creep: f64,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Runs the command.
///
/// # Errors
/// If the file cannot be read, its points do not determine the law, or an output cannot be written.
pub(super) fn execute(args: &FrictionArgs) -> Result<(), CliError> {
    let files = Outputs::new(Some(args.file.as_os_str()), &args.output).check()?;
    let refused = |reason| CliError::Input(format!("`{}`: {reason}", args.file.display()));
    let text = std::fs::read_to_string(&args.file);
    let text =
        text.map_err(|error| refused(format!("it cannot be read ({error}); check the path")))?;
    let points = points(&text).map_err(refused)?;
    let fit = fit_friction(&points, args.creep).map_err(|error| refused(error.to_string()))?;
    files.deliver(None, &fit)
}

/// The points of a CSV text, or the line that has none, and the remedy.
fn points(text: &str) -> Result<Vec<FrictionPoint>, String> {
    const COLUMNS: [&str; 3] = ["speed_m_per_s", "mu", "mu_deviation"];
    let mut rows = csv_rows(text);
    let head = rows.next().map_or_else(Vec::new, |(_, head)| head);
    if head != COLUMNS[..2] && head != COLUMNS {
        let is_in_mm = |name: &&str| name.contains("mm/s") || name.contains("mm_per_s");
        if head.first().is_some_and(is_in_mm) {
            return Err(
                "its speeds are in mm/s; divide them by 1000, and begin with `speed_m_per_s,mu`"
                    .to_owned(),
            );
        }
        return Err("its first line does not name the columns; begin with `speed_m_per_s,mu` or `speed_m_per_s,mu,mu_deviation`".to_owned());
    }
    let mut points = Vec::new();
    for (line, fields) in rows {
        let wrong = |reason: &str| format!("line {line}: {reason}");
        let numbers: Option<Vec<f64>> = fields.iter().map(|field| field.parse().ok()).collect();
        let numbers = numbers
            .filter(|numbers| numbers.len() == head.len() && numbers.iter().all(|x| x.is_finite()));
        let numbers = numbers.ok_or_else(|| wrong("give one finite number for each column"))?;
        let point = FrictionPoint {
            speed: numbers[0],
            coefficient: numbers[1],
            deviation: numbers.get(2).copied(),
        };
        if point.speed <= 0.0 || point.deviation.is_some_and(|deviation| deviation <= 0.0) {
            return Err(wrong(
                "give a speed, and a standard deviation, above 0; remove points at rest",
            ));
        }
        if point.speed > FASTEST {
            return Err(wrong(&format!(
                "a slip speed of {} m/s is not one of a joint; give m/s, not mm/s",
                point.speed
            )));
        }
        if !(0.0..=LARGEST_COEFFICIENT).contains(&point.coefficient) {
            return Err(wrong(&format!(
                "{} is no coefficient of friction, which is from 0 to {LARGEST_COEFFICIENT}; give friction force over normal \
                 force, without sign and not in percent",
                point.coefficient
            )));
        }
        points.push(point);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::Friction;
    use crate::report::{Block, Report as _};
    use crate::scene::Scene;

    /// A measured file whose points lie on the law of Fig. 3.
    fn file(head: &str, rows: impl Fn(f64) -> String) -> String {
        let rows = (0..20).map(|k| rows(2e-3 * 1.3_f64.powi(k)) + "\n");
        format!("{head}\n{}", rows.collect::<String>())
    }

    #[test]
    fn the_lines_of_the_report_are_a_friction_table_of_a_scene() {
        let law =
            |speed: f64| (1.0 - (-1000.0 * speed).exp()) * (0.25 + 0.3 * (-12.0 * speed).exp());
        let measured = file("speed_m_per_s,mu", |speed| {
            format!("{speed},{}", law(speed))
        });
        let fit = fit_friction(&points(&measured).unwrap(), 1000.0).unwrap();
        let Some(Block::Code(lines)) = fit.blocks("").pop() else {
            panic!("the lines are last");
        };
        let scene = format!("[load]\nload_n = 100\ntilt_deg = 2\n{lines}[time]\nduration_ms = 1\n");
        let scene = Scene::parse("fitted.toml", scene).unwrap();
        let Friction::Stribeck { law, .. } = &scene.joint().unwrap().spec.friction else {
            panic!("a Stribeck law");
        };
        assert!(
            (law.mu_s - 0.55).abs() < 1e-5 && (law.mu_d - 0.25).abs() < 1e-5,
            "{law:?}"
        );
        assert!((law.stribeck - 12.0).abs() < 1e-3);
    }

    #[test]
    fn bad_points_are_named_with_their_line() {
        for (text, expected) in [
            ("", "first line"),
            ("speed,mu\n", "first line"),
            ("speed_mm_per_s,mu\n100,0.3\n", "in mm/s"),
            ("speed_m_per_s,mu\n0.1,x\n", "line 2"),
            ("speed_m_per_s,mu\n# a remark\n0.1,0.3\n0.1\n", "line 4"),
            ("speed_m_per_s,mu\n0,0.3\n", "line 2"),
            ("speed_m_per_s,mu,mu_deviation\n0.1,0.3,0\n", "line 2"),
            ("speed_m_per_s,mu\n0.1,-0.3\n", "without sign"),
            ("speed_m_per_s,mu\n0.1,34\n", "not in percent"),
            ("speed_m_per_s,mu\n350,0.3\n", "not mm/s"),
        ] {
            let refused = points(text).unwrap_err();
            assert!(refused.contains(expected), "{refused}");
        }
        let remarks = "# rig 2\nspeed_m_per_s,mu # dry\n0.1,0.3 # first\n";
        assert_eq!(points(remarks).unwrap()[0].coefficient, 0.3);
        let three = points("\u{feff}speed_m_per_s, mu, mu_deviation\n0.1, 0.3, 0.01\n").unwrap();
        assert_eq!(three[0].deviation, Some(0.01));
    }
}
