//! README, changelog and guide: links resolve, every page is in the contents, and every command line is tried.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// The contents page of the guide.
const CONTENTS: &str = "src/guide/mod.rs";

/// The page that documents the module `scene` instead of a module of the guide.
const SCENES: &str = "src/guide/reference/scenes.md";

/// Options of other programs in the text: Cargo and the scripts of examples and benchmarks.
const FOREIGN_OPTIONS: [&str; 4] = ["--release", "--no-default-features", "--body", "--write"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(page: &str) -> String {
    let text = fs::read_to_string(root().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
    if page != CONTENTS {
        return text;
    }
    let lines = text.lines().filter_map(|line| line.strip_prefix("//!"));
    lines
        .map(|line| line.strip_prefix(' ').unwrap_or(line).to_owned() + "\n")
        .collect()
}

/// The pages of the guide, sorted, as paths from the root of the repository.
fn guide() -> Vec<String> {
    let mut pages = Vec::new();
    for part in ["tutorial", "how_to", "explanation", "reference"] {
        for entry in fs::read_dir(root().join("src/guide").join(part)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".md") {
                pages.push(format!("src/guide/{part}/{name}"));
            }
        }
    }
    pages.sort();
    assert!(!pages.is_empty());
    pages
}

/// Prose and code of a page.
#[derive(Default)]
struct Parts {
    /// Lines outside code blocks, without inline code.
    prose: String,
    /// Inline code.
    spans: Vec<String>,
    /// Lines of code blocks in `sh` and `text`; a line that ends with `\` includes the next one.
    shell: Vec<String>,
}

fn parts(text: &str) -> Parts {
    let mut parts = Parts::default();
    let mut fence: Option<&str> = None;
    let mut open = String::new();
    let mut outside = String::new();
    for line in text.lines() {
        let trimmed = line.trim_start();
        match (trimmed.strip_prefix("```"), fence) {
            (Some(language), None) => fence = Some(language.trim()),
            (Some(_), Some(_)) => fence = None,
            (None, None) => outside += &format!("{line}\n"),
            (None, Some("sh" | "text")) => {
                open += trimmed.trim_end_matches('\\');
                if !trimmed.ends_with('\\') {
                    parts.shell.push(std::mem::take(&mut open));
                }
            }
            (None, Some(_)) => {}
        }
    }
    for (k, piece) in outside.split('`').enumerate() {
        match k % 2 {
            0 => parts.prose += piece,
            _ => parts.spans.push(piece.replace('\n', " ")),
        }
    }
    parts
}

/// Targets of the links in the prose of a page.
fn links(page: &str) -> Vec<String> {
    let prose = parts(&read(page)).prose;
    let targets = prose.split("](").skip(1).map(|rest| rest.split(')').next());
    targets.map(|target| target.unwrap().to_owned()).collect()
}

/// Anchors of the headings of a page, as rustdoc and GitHub derive them.
fn anchors(page: &str) -> BTreeSet<String> {
    let text = read(page);
    let mut code = false;
    let mut found = BTreeSet::new();
    for line in text.lines() {
        code ^= line.starts_with("```");
        let title = line.trim_start_matches('#');
        if !code && title.len() < line.len() && title.starts_with(' ') {
            let letters = title.trim().chars().filter_map(|c| match c {
                ' ' => Some('-'),
                c if c.is_alphanumeric() || "-_".contains(c) => Some(c.to_ascii_lowercase()),
                _ => None,
            });
            found.insert(letters.collect());
        }
    }
    found
}

/// The page of a link within the documentation (`crate::guide::reference::faults`), if it is one of the guide.
fn page_of(path: &str) -> Option<String> {
    let path = path.trim_start_matches("mod@");
    if path == "crate::scene" {
        return Some(SCENES.to_owned());
    }
    let inside = path
        .strip_prefix("crate::guide::")
        .or_else(|| {
            let part = path.split("::").next()?;
            ["tutorial", "how_to", "explanation", "reference"]
                .contains(&part)
                .then_some(path)
        })?
        .replace("::", "/");
    match inside.contains('/') {
        true => Some(format!("src/guide/{inside}.md")),
        false => Some(CONTENTS.to_owned()),
    }
}

/// Why a link does not resolve; `None` if it does, or if rustdoc checks it.
fn fault(page: &str, link: &str) -> Option<String> {
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = if path.contains("://") {
        return None;
    } else if path.is_empty() {
        page.to_owned()
    } else if let Some(target) = page_of(path) {
        target
    } else if path.contains("::") || path == "crate" {
        return None;
    } else {
        let folder = Path::new(page).parent().unwrap();
        folder.join(path).to_string_lossy().into_owned()
    };
    if !root().join(&target).exists() {
        return Some(format!("{page}: `{link}`: there is no {target}"));
    }
    let lacks = !anchor.is_empty() && !anchors(&target).contains(anchor);
    lacks.then(|| format!("{page}: `{link}`: {target} has no such heading"))
}

#[test]
fn links_and_anchors_resolve() {
    let mut pages = guide();
    pages.extend([CONTENTS, "README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(str::to_owned));
    let mut count = 0;
    let mut faults = Vec::new();
    for page in &pages {
        for link in links(page) {
            count += 1;
            faults.extend(fault(page, &link));
        }
    }
    assert!(count > 0);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_missing_page_and_a_missing_heading_are_faults() {
    assert_eq!(fault("README.md", "src/guide/reference/faults.md"), None);
    assert_eq!(fault("README.md", "#limits"), None);
    assert_eq!(
        fault(
            SCENES,
            "crate::guide::explanation::equations#the-energy-audit"
        ),
        None
    );
    for link in [
        "#no-such-heading",
        "src/guide/nowhere.md",
        "crate::guide::how_to::nowhere",
        "crate::scene#nowhere",
    ] {
        assert!(fault("README.md", link).is_some(), "{link}");
    }
}

#[test]
fn the_contents_list_every_page_of_the_guide() {
    let listed: BTreeSet<String> = links(CONTENTS)
        .iter()
        .filter_map(|link| page_of(link))
        .collect();
    let source = fs::read_to_string(root().join(CONTENTS)).unwrap();
    for page in guide() {
        assert!(listed.contains(&page), "{CONTENTS} has no link to {page}");
        let name = page
            .trim_start_matches("src/guide/")
            .trim_end_matches(".md");
        let (part, name) = name.split_once('/').unwrap();
        let (_, pages) = source.split_once(&format!("\"{part}\":\n")).unwrap();
        let mut pages = pages
            .lines()
            .map_while(|line| line.trim().strip_suffix(','));
        assert!(
            page == SCENES || pages.any(|page| page.split(' ').next() == Some(name)),
            "{CONTENTS} does not include {page}"
        );
    }
}

/// The help of the commands, read once.
#[derive(Default)]
struct Help(BTreeMap<String, Option<String>>);

impl Help {
    /// The help of a command, or of the program; `None` if there is no such command.
    fn of(&mut self, command: &str) -> Option<&str> {
        let help = self.0.entry(command.to_owned()).or_insert_with(|| {
            let words = [command, "--help"];
            let mut program = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
            let output = program.args(words.iter().filter(|word| !word.is_empty()));
            let output = output.output().unwrap();
            let help = String::from_utf8(output.stdout).unwrap();
            output.status.success().then_some(help)
        });
        help.as_deref()
    }
}

/// Whether a help text has an option, as a whole word.
fn has_option(help: &str, option: &str) -> bool {
    help.split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        .any(|word| word == option)
}

/// Names in the text that stand for others, and what they stand for.
const PLACEHOLDERS: [(&str, &str); 5] = [
    ("FILE", "sweep.json"),
    ("SCENE", "torus-1.75deg"),
    ("NAME", "torus-1.75deg"),
    ("COMMAND", "run"),
    ("SHELL", "bash"),
];

/// Commands that end at once.
const SHORT: [&str; 7] = [
    "",
    "scenes",
    "schema",
    "completions",
    "man",
    "friction",
    "stability",
];

/// A path that no output can have: a command ends there, after it has checked everything else.
const NOWHERE: &str = "nowhere/out.";

/// A folder in which the command lines of the text are tried.
struct Desk(tempfile::TempDir);

impl Desk {
    /// Files that the text has made before: scenes, points of friction, a directory of recordings.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let output = squeakscope(folder.path(), &["scenes", "torus-1.75deg"]);
        for name in [
            "mine.toml",
            "joint.toml",
            "patch.toml",
            "hip.toml",
            "hip-ccx.toml",
            "own.toml",
        ] {
            fs::write(folder.path().join(name), &output.stdout).unwrap();
        }
        fs::create_dir(folder.path().join("recordings")).unwrap();
        // A command that is run in a checkout.
        fs::create_dir_all(folder.path().join("assets/scenes")).unwrap();
        fs::write(folder.path().join("recordings/squeak.wav"), "RIFF").unwrap();
        let law =
            |speed: f64| (1.0 - (-1000.0 * speed).exp()) * (0.25 + 0.3 * (-12.0 * speed).exp());
        let points = (0..20).map(|k| 6e-3 * 1.3_f64.powi(k));
        let rows: String = points.map(|v| format!("{v},{}\n", law(v))).collect();
        fs::write(
            folder.path().join("measured.csv"),
            format!("speed_m_per_s,mu\n{rows}"),
        )
        .unwrap();
        Self(folder)
    }

    /// Why a command line is not valid. Short ones are run; the others are run up to the check of an output that cannot be
    /// written, after scene, keys and values, or up to an input that the text does not have.
    fn fault(&self, line: &str) -> Option<String> {
        let line = line.split([';', '|', '>', '#']).next().unwrap();
        let line = line
            .replace("$SLURM_ARRAY_TASK_COUNT", "2")
            .replace('"', "");
        let mut words: Vec<String> = line
            .split_whitespace()
            .skip(1)
            .map(|word| {
                let known = PLACEHOLDERS.iter().find(|(name, _)| *name == word);
                let word = known.map_or(word, |(_, meaning)| meaning);
                word.replace("$SLURM_ARRAY_TASK_ID", "1")
                    .replace("$SLURM_CPUS_PER_TASK", "1")
            })
            .collect();
        let command = words.first().filter(|word| !word.starts_with('-')).cloned();
        let command = command.unwrap_or_default();
        // The name of a command, not a line.
        if words.len() == 1 {
            words.push("--help".to_owned());
        }
        let is_long = words.iter().any(|word| word == "--sensitivities");
        let is_help = words.iter().any(|word| word == "--help");
        let is_short = is_help || SHORT.contains(&&command[..]) && !is_long;
        let (option, ending) = match &command[..] {
            "live" => ("--save", "rrd"),
            "model" => ("--out", "npz"),
            _ => ("--json", "json"),
        };
        if !is_short && command != "view" {
            if let Some(given) = words.iter().position(|word| word == option) {
                words.drain(given..(given + 2).min(words.len()));
            }
            words.extend([option.to_owned(), format!("{NOWHERE}{ending}")]);
        }
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let output = squeakscope(self.0.path(), &words);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        let is_valid = if is_short {
            output.status.success()
        } else {
            let takes_files = ["view", "merge", "analyse"].contains(&&command[..]);
            let mut inputs = words.iter().skip(1).filter(|word| word.contains('.'));
            let is_missing = takes_files && inputs.any(|word| message.contains(word));
            output.status.code() == Some(2) && (message.contains(NOWHERE) || is_missing)
        };
        (!is_valid).then_some(message)
    }
}

fn squeakscope(folder: &Path, words: &[&str]) -> std::process::Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_squeakscope"));
    program.current_dir(folder).args(words).output().unwrap()
}

#[test]
fn command_lines_are_valid() {
    let desk = Desk::new();
    let mut pages = guide();
    pages.push("README.md".to_owned());
    let mut count = 0;
    let mut faults = Vec::new();
    for page in &pages {
        let parts = parts(&read(page));
        for line in parts.shell.iter().chain(&parts.spans) {
            let line = line.replace("cargo run --release --", "squeakscope");
            if !line.starts_with("squeakscope ") {
                continue;
            }
            count += 1;
            let fault = desk.fault(&line);
            faults.extend(fault.map(|fault| format!("{page}: {line}\n    {fault}")));
        }
    }
    assert!(count > 0);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn faulty_command_lines_are_found() {
    let desk = Desk::new();
    for line in [
        "squeakscope rum torus-1.75deg",
        "squeakscope run torus-2.75deg",
        "squeakscope run mine.toml --set tilt_dge=3",
        "squeakscope run mine.toml --set tilt_deg=300",
        "squeakscope run mine.toml --jsn a.json",
        "squeakscope sweep mine.toml --param lod_n=1:2:1",
        "squeakscope sweep mine.toml --tilt 1:100:1",
        "squeakscope branch mine.toml --param lod_n=1:2",
        "squeakscope lyapunov mine.toml --set lod_n=1",
        "squeakscope live mine.toml --set lod_n=1",
        "squeakscope live mine.toml --speed fast",
        "squeakscope stability mine.toml --tilt 0:8:0",
        "squeakscope analyse squeak.wav --events 2",
        "squeakscope view --prot 3 sweep.rrd",
        "squeakscope schema rum",
    ] {
        assert!(desk.fault(line).is_some(), "{line}");
    }
}

#[test]
fn options_in_the_text_exist() {
    let mut help = Help::default();
    let commands = help.of("").expect("the program has help").to_owned();
    let names = commands
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|word| word.chars().all(|c| c.is_ascii_lowercase()));
    let mut all = String::new();
    for name in names {
        all += help.of(name).unwrap_or_default();
    }
    let mut pages = guide();
    pages.push("README.md".to_owned());
    for page in &pages {
        for span in parts(&read(page)).spans {
            let option = span.split([' ', '=']).next().unwrap();
            if option.starts_with("--") && !FOREIGN_OPTIONS.contains(&option) {
                assert!(
                    has_option(&all, option),
                    "{page}: no command has `{option}`"
                );
            }
        }
    }
}
