//! `squeakscope paper`: reproduce the paper's figures and check its claims.

use std::io::Write as _;
use std::sync::atomic::AtomicBool;

use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use super::interrupt;
use super::output::{Kind, check_directory, check_file};
use super::paper_figures::{self, FIGURES};
use super::points::{compute_points, record};
use super::resources;
use super::study_args::{PaperArgs, WorkArgs};
use crate::export::replace_file;
use crate::joint::BallJoint;
use crate::plot::Format;
use crate::report::Report as _;
use crate::scene::{Parameter, Scene};
use crate::study::paper::{Score, add_short_averages, compare, paper_evidence, short_average_plan};
use crate::study::sweep::{Start, SweepPlan, SweepPoint, write_table};
use crate::text::paper::PaperResult;

/// The calibrated scene, which meets most of the paper's claims.
const SCENE: &str = "paper";

/// The first figure that needs a simulation.
const FIRST_SIMULATED: u8 = 4;

/// Name of the page in the output directory.
const PAGE: &str = "README.md";
/// Names of the tables in the output directory, complete and growing: of the sweep, and of the short averages.
const TABLES: [[&str; 2]; 2] = [
    ["sweep.arrow", "sweep.arrows"],
    ["short.arrow", "short.arrows"],
];
/// Name of the recording in the output directory.
const RECORDING: &str = "paper.rrd";

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(
    args: &PaperArgs,
    stop: &AtomicBool,
    plan: impl FnOnce(Scene, Start) -> SweepPlan,
) -> Result<(), CliError> {
    let mut scene = args.accuracy.apply(args.scene.load_or(SCENE)?)?;
    scene.ball_on_beam()?;
    console::print_study_warnings(&scene);
    if let Some(seed) = args.seed {
        scene = scene.with_values(&[(Parameter::named("start.seed")?, seed as f64)])?;
    }
    let plan = plan(scene, args.start);
    let mut files = prepare(args)?;
    let watch = Watch::new(stop);
    let plans = [&plan, &short_average_plan(&plan)];
    let mut points = [Vec::new(), Vec::new()];
    if args.figure.is_none_or(|figure| figure >= FIRST_SIMULATED) {
        for (k, plan) in plans.into_iter().enumerate() {
            points[k] = simulated(args, plan, TABLES[k], (&mut files, &watch))?;
        }
    }
    let spec = &plan.subject.joint()?.spec;
    let evidence = |points| paper_evidence(spec, points).map_err(CliError::during("comparison"));
    let [points, short] = points;
    let [evidence, short] = [evidence(&points)?, evidence(&short)?];
    // Without simulated points there is nothing to compare.
    let mut claims = if points.is_empty() {
        Vec::new()
    } else {
        compare(&evidence)
    };
    let short_average = add_short_averages(&mut claims, &short);
    let figures = paper_figures::figures(&plan, &points, (&evidence, &claims), args.figure)
        .map_err(CliError::during("drawing"))?;
    let captions = figures.iter().filter(|_| args.figure.is_some());
    let result = PaperResult {
        start: args.start,
        score: Score::of(&claims),
        short_average,
        claims,
        captions: captions.map(|figure| figure.caption.clone()).collect(),
    };
    let scene = &plan.subject.name;
    files.finish(watch, Some(scene), &result, |files| {
        let drawn = args.drawn.or_formats(STUDY);
        for path in drawn.write(&args.out, "--out", &figures, None)? {
            files.add(&path)?;
        }
        if args.figure.is_none() {
            let ball = BallJoint::new(spec).map_err(CliError::during("recording"))?;
            if !points.is_empty() {
                let path = args.out.join(RECORDING);
                let report = result.blocks(scene);
                record(&plan, &points, &report, &path, Some(&ball))?;
                files.add(&path)?;
            }
            // Prefer a format that browsers show, and PNG to SVG.
            let mut formats = drawn.format.iter().rev();
            let shown = formats.find(|format| **format != Format::Pdf);
            let ending = shown.unwrap_or(&Format::Pdf).ending();
            let figures = drawn.arrange(&figures);
            let figures: Vec<_> = figures.iter().map(|f| (&*f.name, &*f.caption)).collect();
            let page = result.page(scene, &figures, ending);
            let path = check_file(&args.out.join(PAGE), "--out")?;
            replace_file(&path, |out| out.write_all(page.as_bytes()))?;
            files.add(&path)?;
        }
        files.write("--write", |path| {
            let described = [("about", result.description())];
            let text = plan.subject.with_overrides(&described)?.text;
            Ok::<_, CliError>(replace_file(path, |out| out.write_all(text.as_bytes()))?)
        })
    })
}

/// The points of a plan; those of an earlier or interrupted run are reused.
fn simulated(
    args: &PaperArgs,
    plan: &SweepPlan,
    names: [&str; 2],
    (files, watch): (&mut Outputs<'_>, &Watch<'_>),
) -> Result<Vec<SweepPoint>, CliError> {
    let work = WorkArgs {
        resume: true,
        shard: None,
        threads: args.threads,
    };
    let [table, growing] = names.map(|name| args.out.join(name));
    let paths = [table.clone(), growing.clone()];
    let points = compute_points(plan, &work, paths, watch)?;
    if points.len() < plan.size() {
        return Err(CliError::Interrupted);
    }
    write_table(&table, plan, &points)?;
    // A table that was complete had none.
    let _ = std::fs::remove_file(growing);
    files.add(&table)?;
    Ok(points)
}

/// Checks all outputs and creates the directory.
fn prepare(args: &PaperArgs) -> Result<Outputs<'_>, CliError> {
    let numbers = match args.figure {
        Some(number) => number..=number,
        None => 1..=FIGURES,
    };
    let stems: Vec<_> = numbers.map(|number| format!("figure-{number}")).collect();
    let mut names = args.drawn.or_formats(STUDY).names(&stems);
    if args.figure.is_none() {
        names.extend([PAGE, RECORDING].map(str::to_owned));
        resources::check_memory()?;
    }
    check_directory(&args.out, "--out", &names, args.output.overwrite.force)?;
    // The tables of an earlier or interrupted run are continued.
    check_directory(&args.out, "--out", &TABLES.concat(), true)?;
    let create = || {
        interrupt::start_work();
        std::fs::create_dir_all(&args.out).map_err(CliError::during("creation of the directory"))
    };
    let json = args.output.json.as_ref();
    // A path inside the new directory is checked after the directory exists.
    if json.is_some_and(|path| path.starts_with(&args.out)) {
        create()?;
    }
    // A scene file may be described itself.
    let files = Outputs::new(None, &args.output)
        .file("--write", Kind::SCENE, args.write.as_ref())?
        .check()?;
    create()?;
    Ok(files)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::cli::tests::parsed;
    use crate::study::paper::claims;
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::Axis;

    /// A short sweep over two tilts.
    fn short_plan(scene: Scene, start: Start) -> SweepPlan {
        SweepPlan {
            subject: scene,
            axes: vec![Axis::new(Parameter::tilt(), [2.0, 5.0])],
            starts: vec![start],
            response: ResponsePlan {
                min_transient_s: 0.02,
                max_transient_s: 0.02,
                measurement_s: 0.01,
                exponents: 1,
                orbits: false,
                portrait: false,
                max_rhs_evals: None,
            },
        }
    }

    #[test]
    fn figures_captions_and_claims_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("paper");
        let line = |line: &str| -> PaperArgs {
            let folder = folder.path().display().to_string();
            parsed(&format!("--out @/paper --json @/paper.json {line}").replace('@', &folder))
        };
        let stop = AtomicBool::new(false);
        execute(
            &line("--seed 4 --write @/described.toml"),
            &stop,
            short_plan,
        )
        .unwrap();
        let page = std::fs::read_to_string(out.join("README.md")).unwrap();
        assert!(
            page.contains("![figure-4](figure-4.png)\n\n**Fig. 4**, 2°. (a) Growth"),
            "{page}"
        );
        assert!(
            page.contains(
                "| Fig. 4a | Four unstable modes at a tilt of 2.0 deg | 4 | 4 | met | same | 1 |"
            ),
            "{page}"
        );
        assert!(page.contains(
            "| Fig. 6a | Five unstable modes at a tilt of 3.5 deg | 5 | not found | not comparable | same | 1 |"
        ));
        let json = std::fs::read(folder.path().join("paper.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(report["claims"].as_array().unwrap().len(), claims().len());
        let [strict, partial] = ["strict_score", "partial_score"].map(|name| report[name].as_f64());
        assert!(strict <= partial && strict < Some(0.6), "{report}");
        let claim = &report["claims"][0];
        for field in [
            "id",
            "place",
            "statement",
            "quote",
            "expected",
            "measured",
            "verdict",
        ] {
            assert!(claim[field].is_string(), "{field} of {claim}");
        }
        assert!(claim["weight"].is_number());
        let described = std::fs::read_to_string(folder.path().join("described.toml")).unwrap();
        let about = Scene::parse("described.toml", described).unwrap().about;
        let counts = "Unstable modes at 2.0, 3.0, 3.5 and 5.0 deg: 4, not found (paper: 4), ";
        assert!(about.replace('\n', " ").contains(counts), "{about}");
        // A second run reuses the sweep and draws only the selected figure.
        let again = "--seed 4 --figure 9";
        let refused = execute(&line(again), &stop, short_plan).unwrap_err();
        assert!(refused.to_string().contains("--force"), "{refused}");
        let again = format!("{again} --force");
        let before = std::fs::read(out.join("sweep.arrow")).unwrap();
        execute(&line(&again), &stop, short_plan).unwrap();
        assert_eq!(std::fs::read(out.join("sweep.arrow")).unwrap(), before);
        let drawn = std::fs::read_to_string(out.join("figure-9.svg")).unwrap();
        assert!(drawn.contains("</svg>"), "{drawn}");
        // A different sweep does not replace the table.
        let other = again.replace("--seed 4", "--seed 5");
        let refused = execute(&line(&other), &stop, short_plan).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }

    /// The table of claims of the scene `paper`; the guide (`reproduce_paper`) has the command that writes it and the
    /// text of the scene.
    fn table() -> PaperResult {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/paper/table.json");
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    }

    /// The text of the scene is that of its table, and the table has the present claims.
    #[test]
    fn the_text_of_the_scene_is_generated_from_its_table() {
        let table = table();
        assert_eq!(
            Scene::load(SCENE).unwrap().about,
            table.description().trim_end()
        );
        assert_eq!(Score::of(&table.claims), table.score);
        assert_eq!(table.claims.len(), claims().len());
        for (found, claimed) in table.claims.iter().zip(claims()) {
            assert_eq!(found.claim, claimed.claim);
        }
    }

    /// The whole sweep again: verdicts and values of the table.
    #[test]
    #[ignore = "takes minutes; cargo test --release --lib the_table_of_the_scene -- --ignored"]
    fn the_table_of_the_scene_is_reproduced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let [out, json] = [path("paper"), path("paper.json")];
        let line = format!(
            "--out {} --json {} --start {}",
            out.display(),
            json.display(),
            table().start
        );
        let args = parsed(&line);
        execute(
            &args,
            &AtomicBool::new(false),
            crate::study::paper::paper_plan,
        )
        .unwrap();
        let again: PaperResult =
            serde_json::from_slice(&std::fs::read(path("paper.json")).unwrap()).unwrap();
        for (again, stored) in again.claims.iter().zip(table().claims) {
            assert_eq!(*again, stored);
        }
    }
}
