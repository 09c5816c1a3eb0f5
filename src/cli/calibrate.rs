//! `squeakscope calibrate`: which set of what the paper leaves open meets most of its claims?

use std::collections::HashSet;
use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::interrupt;
use super::output::{OutputError, OutputFile, check_all};
use super::progress::Progress;
use super::resources;
use super::study_args::CalibrateArgs;
use crate::escape;
use crate::foreign::open_file;
use crate::scene::Scene;
use crate::study::calibrate::{CalibrationPlan, Trial, Witness, calibrate, ranked};
use crate::study::paper::claims;
use crate::study::threads;

/// The scene that has all that the paper states.
const BASE: &str = "periodic-2deg";

/// The best so many are shown.
const SHOWN: usize = 5;

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn run(args: &CalibrateArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &CalibrateArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let base = Scene::load(args.scene.as_deref().unwrap_or(BASE))?;
    base.ball_on_beam()?;
    let plan = CalibrationPlan {
        base,
        seed: args.seed,
        generations: args.generations as usize,
        population: args.population as usize,
    };
    let [out, scene, json] = check_all(
        args.scene.as_deref().map(std::ffi::OsStr::new),
        [
            ("--out", Some(&*args.out)),
            ("--best", args.best.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    let Some(out) = out else {
        unreachable!("it was asked for");
    };
    let known = known(&out, args.resume, &plan.identity())?;
    interrupt::work_begins();
    let mut notes = Notes {
        log: Log::new(&out, &plan.identity(), &known)?,
        progress: Progress::of_estimate(),
        all: plan.len(),
        stop,
    };
    resources::start_pool()?;
    let threads = threads(args.threads);
    let (trials, done) = calibrate(&plan, &known, threads, &mut notes)?;
    // The bar goes before anything else is printed.
    drop(notes);
    // Trials come in any order. In the end they stand by their numbers, so that neither threads nor a stop in
    // between change the log.
    Log::new(&out, &plan.identity(), &by_number(&trials, &known))?;
    let mut written = vec![WrittenFile::of(&out)?];
    if let (Some(file), Some(best)) = (&scene, ranked(&trials).first()) {
        let text = best.candidate.scene(&plan.base)?.text;
        file.write(|out| out.write_all(text.as_bytes()))?;
        written.push(WrittenFile::of(file)?);
    }
    let found = Found::new(&plan, &trials, !done);
    Document::new(&found, &written).deliver(&text(&found), json.as_ref())?;
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// The longest line of a log that is read, bytes: the first has a scene's text, the others a few
/// numbers.
const MAX_LINE: u64 = 16 << 20;

/// The first line of the log.
#[derive(Serialize, Deserialize)]
struct Head {
    squeakscope_calibration: String,
}

/// The trials on disk: a line each, JSON.
struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// Starts a log in place of the file of that name, with what is known already.
    fn new(out: &OutputFile, identity: &str, known: &[Trial]) -> Result<Self, CliError> {
        out.write(|out| {
            let head = Head {
                squeakscope_calibration: identity.to_owned(),
            };
            writeln!(out, "{}", serde_json::to_string(&head)?)?;
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
        // One write a line: what breaks off is at most the last one.
        let written = serde_json::to_string(trial)
            .map_err(io::Error::from)
            .and_then(|line| self.file.write_all(format!("{line}\n").as_bytes()))
            // A file whose name is gone takes everything and keeps nothing.
            .and_then(|()| self.path.symlink_metadata().map(drop));
        written.map_err(|source| {
            CliError::Output(OutputError::Failed {
                path: self.path.clone(),
                source,
            })
        })
    }
}

/// Trials by their numbers: those of this search, and the known ones beyond its last generation.
fn by_number(trials: &[Trial], known: &[Trial]) -> Vec<Trial> {
    let beyond = known.iter().filter(|trial| trial.number >= trials.len());
    let mut all: Vec<Trial> = trials.iter().chain(beyond).cloned().collect();
    all.sort_by_key(|trial| trial.number);
    all.dedup_by_key(|trial| trial.number);
    all
}

/// The trials that are known already. A file that is there is only touched by `--resume`.
fn known(out: &OutputFile, resume: bool, identity: &str) -> Result<Vec<Trial>, CliError> {
    let path = out.path();
    if !path.exists() {
        return Ok(Vec::new());
    }
    if !resume {
        return Err(CliError::WouldReplace {
            path: path.to_owned(),
        });
    }
    let foreign = |reason: &str| CliError::ForeignLog {
        path: path.to_owned(),
        reason: reason.to_owned(),
    };
    let (file, _) = open_file(path).map_err(|error| foreign(&error.to_string()))?;
    // A line that is too long or no text ends what is known, as one that broke off does.
    let mut file = BufReader::new(file);
    let mut lines = std::iter::from_fn(|| {
        let mut line = String::new();
        let read = (&mut file).take(MAX_LINE).read_line(&mut line);
        read.is_ok_and(|count| count > 0).then_some(line)
    });
    let head: Option<Head> = lines
        .next()
        .and_then(|line| serde_json::from_str(&line).ok());
    match head {
        None => Err(foreign("it is no log of a calibration")),
        Some(head) if head.squeakscope_calibration != identity => Err(foreign(
            "it is of another scene, seed, population or version",
        )),
        // The last line may have broken off.
        Some(_) => Ok(lines
            .map_while(|line| serde_json::from_str(&line).ok())
            .collect()),
    }
}

struct Notes<'a> {
    log: Log,
    progress: Progress,
    all: usize,
    stop: &'a AtomicBool,
}

impl Witness for Notes<'_> {
    type Error = CliError;

    fn trial(&mut self, trial: &Trial) -> Result<(), CliError> {
        self.log.add(trial)
    }

    fn progress(&mut self, done: usize, best: Option<&Trial>) -> bool {
        let words = best.map(|best| format!(", the best holds {:.0} %", 100.0 * best.score));
        let share = done as f64 / self.all.max(1) as f64;
        self.progress.tell(
            share,
            format!("{done} of {} sets{}", self.all, words.unwrap_or_default()),
        );
        !self.stop.load(Ordering::Relaxed)
    }
}

/// What was found, as JSON has it.
#[derive(Serialize)]
struct Found<'a> {
    /// Sets tried, and sets in all.
    tried: usize,
    in_all: usize,
    interrupted: bool,
    /// The best sets, the best first.
    best: Vec<BestSet<'a>>,
    /// Claims with a weight that no set tried meets, by their names.
    never_met: Vec<String>,
}

/// A set with its numbers and choices by their paths, in the units of a scene file.
#[derive(Serialize)]
struct BestSet<'a> {
    #[serde(flatten)]
    trial: &'a Trial,
    numbers: Vec<(&'static str, f64)>,
    words: Vec<(&'static str, &'static str)>,
}

impl<'a> Found<'a> {
    fn new(plan: &CalibrationPlan, trials: &'a [Trial], interrupted: bool) -> Self {
        let best = ranked(trials).into_iter().take(SHOWN);
        let best = best.map(|trial| BestSet {
            trial,
            numbers: trial.candidate.numbers(),
            words: trial.candidate.words(),
        });
        let held = trials.iter().flat_map(|trial| &trial.held);
        let met: HashSet<&str> = held.map(|(id, _)| &**id).collect();
        let weighty = claims().into_iter().filter(|claim| claim.weight > 0.0);
        let never_met = weighty.map(|claim| claim.id);
        Self {
            tried: trials.len(),
            in_all: plan.len(),
            interrupted,
            best: best.collect(),
            never_met: never_met.filter(|id| !met.contains(&**id)).collect(),
        }
    }
}

/// The text for the terminal.
fn text(found: &Found<'_>) -> String {
    let mut text = format!("{} of {} sets tried\n", found.tried, found.in_all);
    for set in &found.best {
        let trial = set.trial;
        let _ = writeln!(
            text,
            "\n  set {}: {:.0} % of the claims hold, by their weights{}",
            trial.number,
            100.0 * trial.score,
            match trial.candidate.continued {
                true => ", continued up",
                false => ", each tilt started cold",
            }
        );
        for (path, value) in &set.numbers {
            let _ = writeln!(text, "    {path} = {value}");
        }
        for (path, word) in &set.words {
            let _ = writeln!(text, "    {path} = \"{word}\"");
        }
        // From the log, which may be anybody's.
        let held = trial.held.iter().map(|(id, share)| match escape::line(id) {
            id if *share >= 1.0 => id.into_owned(),
            id => format!("{id} ({:.0} %)", 100.0 * share),
        });
        let _ = writeln!(text, "    holds: {}", held.collect::<Vec<_>>().join(", "));
    }
    if !found.never_met.is_empty() {
        let _ = writeln!(
            text,
            "\n  no set tried meets {}",
            found.never_met.join(", ")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use std::num::NonZero;

    use super::*;
    use crate::scene::Parameter;

    #[test]
    fn a_search_is_kept_gone_on_with_and_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let values = [
            (Parameter::named("nodes").unwrap(), 16.0),
            (Parameter::named("time.tolerance").unwrap(), 1e-3),
        ];
        let base = Scene::load(BASE).unwrap().with_values(&values).unwrap();
        std::fs::write(path("base.toml"), base.text).unwrap();
        let mut args = CalibrateArgs {
            scene: Some(path("base.toml").to_string_lossy().into_owned()),
            seed: 2,
            generations: 1,
            population: 2,
            threads: NonZero::new(2),
            resume: false,
            out: path("log.jsonl"),
            best: Some(path("best.toml")),
            json: Some(path("report.json")),
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
        assert_eq!(report["best"].as_array().unwrap().len(), 2);
        let best = Scene::load(&path("best.toml").to_string_lossy()).unwrap();
        let factor = best.joint().unwrap().spec.contact.stiffness_factor;
        let numbers = report["best"][0]["numbers"].as_array().unwrap();
        assert!(
            numbers
                .iter()
                .any(|n| n[0] == "contact.stiffness_factor" && n[1] == factor)
        );
        // A line that broke off is done again; a log of another search is refused.
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
