//! Every reader of untrusted files gets damaged ones: it reads them, or rejects them with a one-line message.
//! It never panics, aborts, hangs, or needs more memory than [`MEMORY`].
//!
//! Readers run in a child process, whose crash is detected. Each mutant is written to a file before it is
//! read; a mutant that causes a failure is kept and named. The standard tests use a few hundred or thousand
//! mutants of each kind. A long search takes the given number of seconds per target:
//!
//! ```sh
//! SQUEAKSCOPE_FUZZ_SECONDS=600 cargo test --release --test it fuzz::a_long_search -- --ignored --nocapture
//! ```
//!
//! `SQUEAKSCOPE_FUZZ_SEED` selects other mutants, and `SQUEAKSCOPE_FUZZ_TARGET` a single target.

mod corpus;
mod http;
mod targets;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

use self::targets::{Kind, TARGETS, Target};
use crate::damage::Desk;
use crate::mutants::{Mutant, mutants, text_mutants};

/// Address space of a reading process, bytes; the program itself takes most of it.
const MEMORY: u64 = 2_000_000_000;

/// Timeout for one file, on a busy machine too.
const HANGING: Duration = Duration::from_secs(300);

/// Name of the file that is read.
const MUTANT: &str = "mutant";
/// Name of the file with the counts of a reading process.
const COUNTS: &str = "counts";

const SEED: &str = "SQUEAKSCOPE_FUZZ_SEED";
const SECONDS: &str = "SQUEAKSCOPE_FUZZ_SECONDS";
const TARGET: &str = "SQUEAKSCOPE_FUZZ_TARGET";
/// Environment variable with the folder of a reading process.
const FOLDER: &str = "SQUEAKSCOPE_FUZZ_FOLDER";

/// Extent and start of a search.
#[derive(Clone, Copy)]
struct Search {
    seed: u64,
    /// Duration; `None` for the standard number of mutants.
    seconds: Option<f64>,
}

impl Search {
    const USUAL: Self = Self {
        seed: 1,
        seconds: None,
    };

    fn from_environment() -> Self {
        Self {
            seed: number(SEED).unwrap_or(1),
            seconds: number(SECONDS),
        }
    }

    fn is_finished(self, began: Instant, tried: u64, usual: u64) -> bool {
        match self.seconds {
            Some(seconds) => began.elapsed().as_secs_f64() >= seconds,
            None => tried >= usual,
        }
    }
}

/// A number from an environment variable.
fn number<T: std::str::FromStr>(name: &str) -> Option<T> {
    let text = std::env::var(name).ok()?;
    match text.parse() {
        Ok(number) => Some(number),
        Err(_) => panic!("{name}={text} is not a number"),
    }
}

/// Results for the mutants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counts {
    read: u64,
    refused: u64,
}

impl Counts {
    fn all(self) -> u64 {
        self.read + self.refused
    }

    fn print(self, name: &str) {
        let (all, Self { read, refused }) = (self.all(), self);
        println!("{name}: {all} mutants, {read} read, {refused} refused");
    }
}

/// Infinite sequence of mutants of all originals in turn.
fn in_turn(originals: &[Vec<u8>], kind: Kind, seed: u64) -> impl Iterator<Item = Mutant> {
    type Source<'a> = Box<dyn Iterator<Item = Mutant> + 'a>;
    let mut sources: Vec<Source<'_>> = Vec::new();
    for (original, k) in originals.iter().zip(0..) {
        let seed = seed.wrapping_mul(1000).wrapping_add(k);
        match kind {
            Kind::Binary => sources.push(Box::new(mutants(original, seed))),
            Kind::Text => sources.push(Box::new(text_mutants(original, seed))),
            Kind::Ogg => {
                sources.push(Box::new(mutants(original, seed)));
                sources.push(Box::new(corpus::mended(original, seed)));
            }
            Kind::Archive => {
                sources.push(Box::new(mutants(original, seed)));
                sources.push(Box::new(corpus::repacked(original, seed)));
            }
        }
    }
    let count = sources.len();
    (0..).map(move |turn: usize| {
        sources[turn % count]
            .next()
            .expect("the iterator is infinite")
    })
}

/// Whether a message is one line without control characters, except those of names and values of the file,
/// which are escaped wherever they are displayed.
fn is_clear(message: &str, file: &[u8], kind: Kind) -> bool {
    let is_text = kind == Kind::Text;
    // An escape sequence of JSON or TOML may encode any character.
    if is_text && file.contains(&b'\\') {
        return true;
    }
    let has = |pair: &[char]| {
        let pair: String = pair.iter().collect();
        file.windows(pair.len())
            .any(|bytes| bytes == pair.as_bytes())
    };
    let characters: Vec<char> = [' ']
        .into_iter()
        .chain(message.chars())
        .chain([' '])
        .collect();
    characters.windows(3).all(|near| {
        let [before, c, after] = [near[0], near[1], near[2]];
        // A control character from the file has the same neighbour in the file, or is enclosed in quotes or
        // commas of a list, or occurs with letters that the program's own messages do not contain.
        let is_alone = " `'\"".contains(before) && ",;`'\"".contains(after);
        let is_foreign = is_alone || near.iter().any(|c| !c.is_ascii());
        // A line of text contains no line break.
        let may_be_there = !(is_text && c == '\n');
        !c.is_control() || (may_be_there && (is_foreign || has(&[before, c]) || has(&[c, after])))
    })
}

/// The reading process. Its parent has written the originals and evaluates its exit status.
#[test]
#[ignore = "the child process of the other tests in this module, which start it"]
fn reading_process() {
    let Some(folder) = std::env::var_os(FOLDER).map(PathBuf::from) else {
        return;
    };
    let name = std::env::var(TARGET).expect("a target");
    let target = TARGETS.iter().find(|target| target.name == name);
    let target = target.expect("a target");
    let originals: Vec<Vec<u8>> = (0..)
        .map_while(|k| fs::read(original(&folder, k)).ok())
        .collect();
    let path = folder.join(MUTANT).with_extension(target.extension);
    for bytes in &originals {
        fs::write(&path, bytes).expect("written");
        assert_eq!((target.read)(&path), Ok(()), "an undamaged file");
    }
    let search = Search::from_environment();
    let (began, mut counts) = (Instant::now(), Counts::default());
    for mutant in in_turn(&originals, target.kind, search.seed) {
        if search.is_finished(began, counts.all(), target.usual) {
            break;
        }
        fs::write(&path, &mutant.bytes).expect("written");
        match (target.read)(&path) {
            Ok(()) => counts.read += 1,
            Err(message) => {
                let clear = is_clear(&message, &mutant.bytes, target.kind);
                assert!(clear, "{}: {message:?}", mutant.damage);
                counts.refused += 1;
            }
        }
    }
    let counts = format!("{} {}", counts.read, counts.refused);
    fs::write(folder.join(COUNTS), counts).expect("written");
}

/// Path of an undamaged file.
fn original(folder: &Path, k: usize) -> PathBuf {
    folder.join(format!("original.{k}"))
}

/// Fuzzes a reader.
fn search(target: &Target, search: Search) -> Counts {
    let desk = Desk::new();
    let folder = desk.path("");
    for (k, bytes) in (target.corpus)(&desk).iter().enumerate() {
        fs::write(original(&folder, k), bytes).expect("written");
    }
    let mutant = folder.join(MUTANT).with_extension(target.extension);
    let ended = ended(start(target, search, &folder), &mutant);
    let counts = fs::read_to_string(folder.join(COUNTS));
    let (Some(true), Ok(counts)) = (ended.map(|status| status.success()), counts) else {
        let how = ended.map_or_else(|| "it hangs".to_owned(), |status| status.to_string());
        let bytes = fs::read(&mutant).unwrap_or_default();
        let kept = keep(target.name, target.extension, &bytes);
        let said = fs::read_to_string(folder.join("stderr")).unwrap_or_default();
        panic!(
            "{}: {how}: the input is in {}\n{said}",
            target.name,
            kept.display()
        );
    };
    let mut counts = counts
        .split(' ')
        .map(|count| count.parse().expect("a number"));
    let mut next = || counts.next().expect("two numbers");
    Counts {
        read: next(),
        refused: next(),
    }
}

/// Starts the reading process.
fn start(target: &Target, search: Search, folder: &Path) -> Child {
    let program = std::env::current_exe().expect("this program");
    let mut command = if cfg!(target_os = "linux") {
        let mut limited = Command::new("prlimit");
        limited.arg(format!("--as={MEMORY}")).arg(program);
        limited
    } else {
        Command::new(program)
    };
    command
        .args([
            "fuzz::reading_process",
            "--exact",
            "--ignored",
            "--nocapture",
        ])
        .env(FOLDER, folder)
        .env(TARGET, target.name)
        .env(SEED, search.seed.to_string())
        .env_remove(SECONDS)
        // Each thread needs address space.
        .env("RAYON_NUM_THREADS", "2");
    if let Some(seconds) = search.seconds {
        command.env(SECONDS, seconds.to_string());
    }
    let stderr = File::create(folder.join("stderr")).expect("created");
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(stderr)
        .spawn()
        .expect("started")
}

/// Exit status of a process, or `None` if it hangs on a file.
fn ended(mut child: Child, mutant: &Path) -> Option<ExitStatus> {
    let began = SystemTime::now();
    loop {
        if let Some(status) = child.try_wait().expect("a child") {
            return Some(status);
        }
        let written = fs::metadata(mutant).and_then(|about| about.modified());
        let age = written.unwrap_or(began).elapsed().unwrap_or_default();
        if age > HANGING {
            child.kill().expect("it runs");
            child.wait().expect("a child");
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Saves an input permanently.
fn keep(name: &str, extension: &str, bytes: &[u8]) -> PathBuf {
    let file = tempfile::Builder::new()
        .prefix(&format!("squeakscope-fuzz-{name}-"))
        .suffix(&format!(".{extension}"))
        .tempfile()
        .expect("created");
    fs::write(file.path(), bytes).expect("written");
    let (_, path) = file.keep().expect("kept");
    path
}

/// Some mutants are read and some are rejected: both cases are tested.
#[test]
fn damaged_files_are_read_or_rejected_in_one_line() {
    for target in TARGETS {
        let counts = search(target, Search::USUAL);
        counts.print(target.name);
        assert_eq!(counts.all(), target.usual);
        assert!(counts.read > 0 && counts.refused > 0, "{}", target.name);
    }
}

#[test]
fn damaged_requests_get_a_response_or_are_closed() {
    let counts = http::search(Search::USUAL);
    counts.print("HTTP");
    assert!(counts.read > 0 && counts.refused > 0, "{counts:?}");
}

#[test]
#[ignore = "a minute for each target, or SQUEAKSCOPE_FUZZ_SECONDS: cargo test --release --test it fuzz::a_long_search -- --ignored --nocapture"]
fn a_long_search() {
    let mut long = Search::from_environment();
    long.seconds = long.seconds.or(Some(60.0));
    let chosen = std::env::var(TARGET).ok();
    let is_chosen = |name: &str| chosen.as_deref().is_none_or(|chosen| chosen == name);
    let names = TARGETS.iter().map(|target| target.name);
    let is_known = names.chain(["HTTP"]).any(is_chosen);
    assert!(is_known, "there is no target {chosen:?}");
    for target in TARGETS.iter().filter(|target| is_chosen(target.name)) {
        search(target, long).print(target.name);
    }
    if is_chosen("HTTP") {
        http::search(long).print("HTTP");
    }
}

#[test]
fn a_clear_message_contains_only_control_characters_of_the_file() {
    let file = b"t,a\x07b\n1,2\n";
    for (message, clear) in [
        ("there is no column `x`", true),
        ("there is no column `a\x07b`", true),
        ("an error\nin two lines", false),
        ("an error\tin x\x1b[31mred", false),
        ("there is: \x07, b", true),
    ] {
        assert_eq!(is_clear(message, file, Kind::Text), clear, "{message:?}");
    }
    assert!(is_clear("a\nb", b"xa\n", Kind::Binary));
    assert!(!is_clear("a:\n b", b"\n", Kind::Binary));
}
