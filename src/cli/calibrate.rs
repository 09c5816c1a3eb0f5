//! `squeakscope calibrate`: fit the parameters that the paper does not state to its claims.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};
use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{Kind, OutputError, OutputFile};
use super::progress::Progress;
use super::study_args::CalibrateArgs;
use super::{report, resources};
use crate::escape;
use crate::foreign::open_file;
use crate::plot::calibration_figure;

use crate::study::calibrate::{
    Calibration, CalibrationObserver, CalibrationPlan, MetClaims, ParetoFront, RESPONSE, Screening,
    Trial, calibrate, never_together, pareto_fronts, ranked,
};
use crate::study::threads;

/// The scene with the parameters that the paper states.
const BASE: &str = "periodic-2deg";

/// Number of sets in the report.
const MAX_SETS: usize = 5;

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(args: &CalibrateArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let base = args.scene.load_or(BASE)?;
    base.ball_on_beam()?;
    report::print_study_warnings(&base);
    let plan = CalibrationPlan {
        base,
        seed: args.seed,
        screened: args.screened as usize,
        starts: args.starts as usize,
        generations: args.generations as usize,
        population: args.population as usize,
        response: RESPONSE,
    };
    let overwrite = args.overwrite.or(args.resume);
    let [out, scene, json] = overwrite.check_all(
        args.scene.input(),
        [
            ("--out", Kind::LOG, Some(&*args.out)),
            ("--best", Kind::SCENE, args.best.as_deref()),
            ("--json", Kind::JSON, args.json.as_deref()),
        ],
    )?;
    let Some(out) = out else {
        unreachable!("--out has a default");
    };
    if let Some(directory) = &args.figures {
        let names = args.drawn.names(["pareto"], &STUDY);
        overwrite.check_directory(directory, "--figures", &names)?;
    }
    let known = known(&out, args.resume, &plan.identity())?;
    interrupt::start_work();
    let mut recorder = Recorder {
        log: Log::new(&out, &plan.identity(), &known)?,
        progress: Progress::with_estimate(),
        screened: plan.screened,
        all: plan.len(),
        stop,
    };
    resources::start_thread_pool()?;
    let threads = threads(args.threads);
    let found = calibrate(&plan, &known, threads, &mut recorder)?;
    // Clears the bar before the report is printed.
    drop(recorder);
    // Threads complete trials in any order. Sorting makes the log independent of threads and interrupts.
    Log::new(&out, &plan.identity(), &sorted(&found.trials, &known))?;
    let mut written = vec![WrittenFile::of(&out)?];
    if let (Some(file), Some(best)) = (&scene, ranked(&found.trials).first()) {
        let text = best.candidate.scene(&plan.base, best.start)?.text;
        file.write(|out| out.write_all(text.as_bytes()))?;
        written.push(WrittenFile::of(file)?);
    }
    let met = MetClaims::of(&found.trials);
    let result = CalibrationResult::new(&plan, &found, &met);
    if let Some(directory) = &args.figures {
        let figure = calibration_figure(&met, &found.trials, &result.pareto_fronts);
        let drawn = (&args.drawn, &STUDY[..]);
        written.extend(write_figures(directory, "--figures", &[figure], drawn)?);
    }
    Document::new(&result, &written).deliver(&text(&result), json.as_ref())?;
    if found.complete {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// Length limit of a line of the log, bytes. The first line has the text of a scene, the others a few
/// numbers.
const MAX_LINE: u64 = 16 << 20;

/// The first line of the log: the identity of the search.
#[derive(Serialize, Deserialize)]
struct Header {
    /// Identity of this calibration with squeakscope: the scene, the seed and the sizes of the search.
    squeakscope_calibration: String,
}

/// The trials on disk: one line of JSON per trial.
struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// Writes a log with the known trials, which replaces an existing file.
    fn new(out: &OutputFile, identity: &str, known: &[Trial]) -> Result<Self, CliError> {
        out.write(|out| {
            let header = Header {
                squeakscope_calibration: identity.to_owned(),
            };
            writeln!(out, "{}", serde_json::to_string(&header)?)?;
            for trial in known {
                writeln!(out, "{}", serde_json::to_string(trial)?)?;
            }
            Ok(())
        })?;
        let file = OpenOptions::new().append(true).open(out.path());
        let file = file.map_err(|source| OutputError::Failed {
            path: out.path().to_owned(),
            source,
        })?;
        Ok(Self {
            path: out.path().to_owned(),
            file,
        })
    }

    fn add(&mut self, trial: &Trial) -> Result<(), CliError> {
        // One write per line: an interruption truncates at most the last line.
        let written = serde_json::to_string(trial)
            .map_err(io::Error::from)
            .and_then(|line| self.file.write_all(format!("{line}\n").as_bytes()))
            // Writes to a deleted file succeed, but are lost.
            .and_then(|()| self.path.symlink_metadata().map(drop));
        written.map_err(|source| {
            CliError::Output(OutputError::Failed {
                path: self.path.clone(),
                source,
            })
        })
    }
}

/// The trials of this search and the known trials of later generations, by number.
fn sorted(trials: &[Trial], known: &[Trial]) -> Vec<Trial> {
    let later = known.iter().filter(|trial| trial.number >= trials.len());
    let mut all: Vec<Trial> = trials.iter().chain(later).cloned().collect();
    all.sort_by_key(|trial| trial.number);
    all.dedup_by_key(|trial| trial.number);
    all
}

/// The trials of an existing log that is resumed.
fn known(out: &OutputFile, resume: bool, identity: &str) -> Result<Vec<Trial>, CliError> {
    let path = out.path();
    if !resume || !path.exists() {
        return Ok(Vec::new());
    }
    let refused = |reason: &str| CliError::CannotResume {
        path: path.to_owned(),
        reason: reason.to_owned(),
    };
    let (file, _) = open_file(path).map_err(|error| refused(&error.to_string()))?;
    // A line that is truncated, too long or not UTF-8 ends the known trials.
    let mut file = BufReader::new(file);
    let mut lines = std::iter::from_fn(|| {
        let mut line = String::new();
        let read = (&mut file).take(MAX_LINE).read_line(&mut line);
        read.is_ok_and(|count| count > 0).then_some(line)
    });
    let header: Option<Header> = lines
        .next()
        .and_then(|line| serde_json::from_str(&line).ok());
    match header {
        None => Err(refused("it is not the log of a calibration")),
        Some(header) if header.squeakscope_calibration != identity => Err(refused(
            "its scene, seed, sizes of the search or version differ",
        )),
        Some(_) => Ok(lines
            .map_while(|line| serde_json::from_str(&line).ok())
            .collect()),
    }
}

/// Logs each trial and shows the progress.
struct Recorder<'a> {
    log: Log,
    progress: Progress,
    screened: usize,
    all: usize,
    stop: &'a AtomicBool,
}

impl CalibrationObserver for Recorder<'_> {
    type Error = CliError;

    fn on_trial(&mut self, trial: &Trial) -> Result<(), CliError> {
        self.log.add(trial)
    }

    fn on_screening(&mut self, done: usize) -> bool {
        let fraction = done as f64 / self.screened.max(1) as f64;
        let text = format!("linear stability of {done} of {} sets", self.screened);
        self.progress.update(fraction, text);
        !self.stop.load(Ordering::Relaxed)
    }

    fn on_progress(&mut self, done: usize, best: Option<&Trial>) -> bool {
        let score = best.map(|best| format!(", best score {:.0} %", 100.0 * best.score));
        let fraction = done as f64 / self.all.max(1) as f64;
        self.progress.update(
            fraction,
            format!("{done} of {} sets{}", self.all, score.unwrap_or_default()),
        );
        !self.stop.load(Ordering::Relaxed)
    }
}

/// The result of a calibration.
#[derive(Serialize, Deserialize)]
pub(super) struct CalibrationResult<'a> {
    /// Result of the screening.
    screening: Screening,
    /// Number of simulated (tried) sets.
    tried: usize,
    /// Number of sets in all generations together.
    in_all: usize,
    /// Whether the search was interrupted.
    interrupted: bool,
    /// The sets with the highest scores, in descending order.
    best: Vec<BestSet<'a>>,
    /// Names of the claims that no simulated set meets, not even at some of their tilts. The search computes neither
    /// exponents nor embeddings: claims about them cannot be compared, and are not named.
    never_met: Vec<String>,
    /// Pareto fronts of the claims on two subjects, for all pairs of subjects.
    pareto_fronts: Vec<ParetoFront>,
    /// Pairs of claims that are met, but never together by the same set.
    never_together: Vec<[String; 2]>,
}

/// A set of parameters.
#[derive(Serialize, Deserialize)]
struct BestSet<'a> {
    #[serde(flatten)]
    trial: Cow<'a, Trial>,
    /// Numbers: paths and values of numeric keys, in the units of the scene file.
    numbers: Vec<(Cow<'static, str>, f64)>,
    /// Words: paths and values of the keys that are not numbers.
    words: Vec<(Cow<'static, str>, Cow<'static, str>)>,
}

impl<'a> CalibrationResult<'a> {
    fn new(plan: &CalibrationPlan, found: &'a Calibration, met: &MetClaims) -> Self {
        let trials = &found.trials;
        let best = ranked(trials).into_iter().take(MAX_SETS);
        let best = best.map(|trial| {
            let numbers = trial.candidate.numbers().into_iter();
            let words = trial.candidate.words().into_iter();
            BestSet {
                trial: Cow::Borrowed(trial),
                numbers: numbers.map(|(path, value)| (path.into(), value)).collect(),
                words: words
                    .map(|(path, word)| (path.into(), word.into()))
                    .collect(),
            }
        });
        let held = trials.iter().flat_map(|trial| &trial.claims_held);
        let held: HashSet<&str> = held.map(|(id, _)| &**id).collect();
        let missed = trials.iter().flat_map(|trial| &trial.claims_missed);
        let never_met: BTreeSet<&String> = missed.filter(|id| !held.contains(&***id)).collect();
        Self {
            screening: found.screening,
            tried: trials.len(),
            in_all: plan.len(),
            interrupted: !found.complete,
            best: best.collect(),
            never_met: never_met.into_iter().cloned().collect(),
            pareto_fronts: pareto_fronts(met, trials),
            never_together: never_together(met, trials),
        }
    }
}

/// The report for the terminal.
fn text(result: &CalibrationResult<'_>) -> String {
    let Screening { sets, agreeing } = &result.screening;
    let all_counts = agreeing.last().copied().unwrap_or_default();
    let mut text = format!(
        "{sets} sets screened: {all_counts} have the paper's numbers of unstable modes\n\
         {} of {} sets simulated\n",
        result.tried, result.in_all
    );
    for set in &result.best {
        let trial = &set.trial;
        let _ = writeln!(
            text,
            "\n  set {}: meets {:.0} % of the comparable claims by weight, {} of {} mm/s",
            trial.number,
            100.0 * trial.score,
            match trial.start.continued {
                true => "tilts by upward continuation from a kick",
                false => "each tilt from a kick",
            },
            trial.start.kick_mm_per_s
        );
        for (path, value) in &set.numbers {
            let _ = writeln!(text, "    {path} = {value}");
        }
        for (path, word) in &set.words {
            let _ = writeln!(text, "    {path} = \"{word}\"");
        }
        // The log may come from another source.
        let held = trial
            .claims_held
            .iter()
            .map(|(id, share)| match escape::line(id) {
                id if *share >= 1.0 => id.into_owned(),
                id => format!("{id} ({:.0} %)", 100.0 * share),
            });
        let _ = writeln!(text, "    meets: {}", held.collect::<Vec<_>>().join(", "));
    }
    if !result.never_met.is_empty() {
        let _ = writeln!(
            text,
            "\n  no parameter set satisfies {}",
            result.never_met.join(", ")
        );
    }
    if !result.never_together.is_empty() {
        let pairs = result.never_together.iter().map(|pair| pair.join(" and "));
        let pairs: Vec<_> = pairs.collect();
        let _ = writeln!(
            text,
            "\n  no parameter set satisfies both {}",
            pairs.join("; ")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use std::num::NonZero;

    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::cli::figures::FigureArgs;
    use crate::cli::output::Overwrite;
    use crate::scene::{Parameter, Scene};

    #[test]
    fn a_search_is_logged_resumed_and_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let values = [
            (Parameter::named("nodes").unwrap(), 16.0),
            (Parameter::named("time.tolerance").unwrap(), 1e-3),
        ];
        let base = Scene::load(BASE).unwrap().with_values(&values).unwrap();
        std::fs::write(path("base.toml"), base.text).unwrap();
        let mut args = CalibrateArgs {
            scene: SceneArgs {
                scene: Some(path("base.toml").to_string_lossy().into_owned()),
                ..SceneArgs::default()
            },
            seed: 2,
            screened: 20,
            starts: 2,
            generations: 0,
            population: 4,
            threads: NonZero::new(2),
            resume: false,
            out: path("log.jsonl"),
            best: Some(path("best.toml")),
            json: Some(path("report.json")),
            figures: Some(path("figures")),
            overwrite: Overwrite::default(),
            drawn: FigureArgs::default(),
        };
        let ended = execute(&args, &AtomicBool::new(true)).unwrap_err();
        assert_eq!(ended.exit_code(), 130);
        let refused = execute(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(refused.exit_code(), 2);
        args.resume = true;
        execute(&args, &AtomicBool::new(false)).unwrap();
        let report: serde_json::Value =
            serde_json::from_slice(&std::fs::read(path("report.json")).unwrap()).unwrap();
        assert_eq!(report["tried"], 2);
        assert_eq!(report["pareto_fronts"].as_array().unwrap().len(), 3);
        assert!(path("figures").join("pareto.svg").exists());
        assert_eq!(report["best"].as_array().unwrap().len(), 2);
        let best = Scene::load(&path("best.toml").to_string_lossy()).unwrap();
        let factor = best.joint().unwrap().spec.contact.stiffness_factor;
        let numbers = report["best"][0]["numbers"].as_array().unwrap();
        assert!(
            numbers
                .iter()
                .any(|n| n[0] == "contact.stiffness_factor" && n[1] == factor)
        );
        // A truncated line is computed again; the log of another search is refused.
        let log = std::fs::read_to_string(path("log.jsonl")).unwrap();
        assert_eq!(log.lines().count(), 3);
        std::fs::write(path("log.jsonl"), &log[..log.len() - 20]).unwrap();
        execute(&args, &AtomicBool::new(false)).unwrap();
        let again = std::fs::read_to_string(path("log.jsonl")).unwrap();
        let sorted = |text: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines.sort_unstable();
            lines
        };
        assert_eq!(sorted(&again), sorted(&log));
        args.seed = 3;
        let refused = execute(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }
}
