//! Random campaign over the space of valid scenes, and over invalid texts.
//!
//! The seeds are fixed, so that every run tests the same scenes; `SQUEAKSCOPE_SEED` and `SQUEAKSCOPE_CASES`
//! change them. `SQUEAKSCOPE_VERBOSE=1` prints each scene that ends in an error or fails its energy audit.
//! The long campaign:
//! `cargo test --release --test it campaign -- --ignored --nocapture`

mod scenes;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use scenes::{joint_scene, small_scene};
use squeakscope::dynamics::DynamicsError;
use squeakscope::pipeline::message::{Frame, Record, Summary};
use squeakscope::pipeline::{Monitor, PipelineError, Sink, SinkError, run};
use squeakscope::scene::{PRESETS, Parameter, Scene, SceneError};

/// Energy audit above which the command line warns that a motion may be wrong.
const WORRYING_AUDIT: f64 = 0.05;

/// Energy resolution of the scenes, J: smaller energies do not count in the audit.
const FLOOR: f64 = 1e-12;

/// Time limit of a run, checked after each frame.
const PATIENCE: Duration = Duration::from_millis(60);

/// Time after which a run is stopped even within a frame.
const LIMIT: Duration = Duration::from_secs(20);

/// A run that does not end within this time after it was stopped hangs.
const HANGING: Duration = Duration::from_secs(60);

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A runner with a fixed seed that writes no file of failures.
fn runner(seed: u64, cases: u32) -> TestRunner {
    let seed = from_environment("SQUEAKSCOPE_SEED").unwrap_or(seed);
    let cases = from_environment("SQUEAKSCOPE_CASES").map_or(cases, |n| n as u32);
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: 200,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &bytes))
}

/// Number of scenes by outcome.
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    refused: u32,
    whole: u32,
    slow: u32,
    worrying: u32,
    faults: u32,
    worst_audit: f64,
}

/// Checks each frame on arrival.
struct Judge {
    turnover: f64,
    /// Energy audit, to compare with the summary.
    audit: f64,
    fault: Option<String>,
}

impl Judge {
    fn look(&mut self, frame: &Frame) {
        let spoilt = frame
            .q
            .iter()
            .chain(&frame.qdot)
            .chain(&frame.velocity)
            .any(|x| !x.is_finite());
        if spoilt {
            self.fault = Some(format!("a sample near t = {} s is not finite", frame.t0));
        }
        for sample in &frame.energy {
            self.turnover = self
                .turnover
                .max(sample.total)
                .max(sample.friction_work.abs());
        }
        if !frame.energy.is_empty() {
            let scale = self.turnover + FLOOR;
            let residuals = frame
                .energy
                .iter()
                .map(|sample| sample.residual.abs() / scale)
                .map(|share| if share.is_nan() { f64::INFINITY } else { share });
            self.audit = residuals.fold(0.0, f64::max);
        }
    }
}

impl Sink for Judge {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Samples(frame) = record {
            self.look(&frame);
        }
        Ok(())
    }
}

/// Result of a run, and what its frames have shown.
type Judged = (Result<Summary, PipelineError>, Judge);

/// Runs a scene for a short time in a thread of its own, so that a hanging run is detected.
fn judge(scene: Scene) -> Result<Judged, TestCaseError> {
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let stopped = Arc::clone(&stop);
    // There is no receiver any more for a run that hangs.
    std::thread::spawn(move || sender.send(judged(&scene, &stopped)).is_ok());
    let result = receiver.recv_timeout(LIMIT).or_else(|_| {
        stop.store(true, Ordering::Relaxed);
        receiver.recv_timeout(HANGING)
    });
    result.map_err(|end| match end {
        RecvTimeoutError::Timeout => TestCaseError::fail("it hangs"),
        RecvTimeoutError::Disconnected => TestCaseError::fail("it panics"),
    })
}

fn judged(scene: &Scene, stop: &Arc<AtomicBool>) -> Judged {
    let mut judge = Judge {
        turnover: 0.0,
        audit: 0.0,
        fault: None,
    };
    // Counted from the first frame: computing the body's modes does not count.
    let began = OnceLock::new();
    let monitor = Monitor {
        stop,
        progress: &|_| {
            let spent = began.get_or_init(Instant::now).elapsed();
            stop.fetch_or(spent > PATIENCE, Ordering::Relaxed);
        },
    };
    let result = run(scene, "campaign", &mut judge, monitor);
    (result, judge)
}

/// Asserts the promise for any text: it is a scene, or gives one clear error; a scene gives a run with finite
/// results, or one clear error.
fn check(text: &str, ends: &mut Ends) -> Result<(), TestCaseError> {
    let scene = match Scene::parse("campaign", text) {
        Ok(scene) => scene,
        Err(error) => {
            ends.refused += 1;
            return is_clear(&error);
        }
    };
    let (result, judge) = judge(scene)?;
    prop_assert!(judge.fault.is_none(), "{:?}", judge.fault);
    match result {
        Ok(summary) => {
            ends.whole += u32::from(!summary.interrupted);
            ends.slow += u32::from(summary.interrupted);
            // Without friction work there is nothing to audit.
            let reported = summary.energy_residual.unwrap_or(0.0);
            let same =
                reported == judge.audit || (reported - judge.audit).abs() <= 1e-9 * judge.audit;
            prop_assert!(
                same,
                "the summary reports {reported:e}, the samples give {:e}",
                judge.audit
            );
            if reported <= WORRYING_AUDIT {
                ends.worst_audit = ends.worst_audit.max(reported);
                return Ok(());
            }
            ends.worrying += 1;
            if from_environment("SQUEAKSCOPE_VERBOSE").is_some() {
                println!("audit {reported:e} of\n{text}");
            }
            return heals(text, reported);
        }
        Err(error) => {
            ends.faults += 1;
            if from_environment("SQUEAKSCOPE_VERBOSE").is_some() {
                println!(
                    "{error}, {:?}, of\n{text}",
                    std::error::Error::source(&error)
                );
            }
            let known = matches!(
                error,
                PipelineError::Step { .. }
                    | PipelineError::Assembly(_)
                    | PipelineError::Dynamics(
                        DynamicsError::NonFinite { .. }
                            | DynamicsError::StepUnderflow { .. }
                            | DynamicsError::Stalled { .. }
                            | DynamicsError::Chatter { .. }
                            | DynamicsError::Mode { .. }
                    )
            );
            prop_assert!(known, "{error:?}");
        }
    }
    Ok(())
}

/// Checks the advice of the command line for a failed audit: a smaller tolerance, or a shorter fixed step,
/// reduces the audit error or makes the audit pass.
fn heals(text: &str, before: f64) -> Result<(), TestCaseError> {
    let scene = finer(text).map_err(|error| TestCaseError::fail(error.to_string()))?;
    if let (Ok(summary), _) = judge(scene)? {
        let audit = summary.energy_residual.unwrap_or(0.0);
        prop_assert!(
            audit < WORRYING_AUDIT.max(0.1 * before),
            "an audit of {before:e} remains {audit:e}"
        );
    }
    Ok(())
}

/// The scene of a text with 0.001 of its tolerance, or 0.1 of its step if the step is fixed.
fn finer(text: &str) -> Result<Scene, SceneError> {
    let scene = Scene::parse("campaign", text)?;
    let integrator = &scene.integrator;
    let tolerance = (1e-3 * integrator.tolerance).max(1e-13);
    let mut values = vec![(Parameter::named("time.tolerance")?, tolerance)];
    if integrator.method.has_fixed_step() {
        let step_us = (1e5 * integrator.max_step).max(1e-3);
        values = vec![(Parameter::named("time.max_step_us")?, step_us)];
    }
    scene.with_values(&values)
}

/// Asserts one message that names the place.
fn is_clear(error: &SceneError) -> Result<(), TestCaseError> {
    let said = error.to_string();
    prop_assert!(said.starts_with("campaign"), "{said}");
    prop_assert!(said.len() < 4000 && said.lines().count() == 1, "{said}");
    if let Some(at) = &error.at {
        let line = at.strip_prefix("campaign:").map(str::parse::<usize>);
        prop_assert!(matches!(line, Some(Ok(_))), "{said}");
    }
    Ok(())
}

/// Runs a strategy's texts through [`check`].
fn campaign(name: &str, seed: u64, cases: u32, texts: &BoxedStrategy<String>) -> Ends {
    let ends = Arc::new(Mutex::new(Ends::default()));
    let began = Instant::now();
    runner(seed, cases)
        .run(texts, |text| check(&text, &mut ends.lock().unwrap()))
        .unwrap_or_else(|failure| panic!("{name}: {failure}"));
    let ends = *ends.lock().unwrap();
    println!("{name}: {ends:?} in {:.0?}", began.elapsed());
    ends
}

#[test]
fn random_joints_run_or_give_a_clear_error() {
    let ends = campaign("joints", 1, 80, &joint_scene());
    // Most scenes run, though not all to the end within the time limit.
    assert!(ends.whole + ends.slow > ends.refused, "{ends:?}");
}

#[test]
fn random_small_systems_run_or_give_a_clear_error() {
    let ends = campaign("small systems", 2, 150, &small_scene());
    assert!(ends.whole + ends.slow > ends.refused, "{ends:?}");
}

/// Mutations of a text: changed bytes, lines removed, repeated or swapped, numbers replaced.
#[derive(Clone, Debug)]
enum Mutation {
    Byte(usize, u8),
    Insert(usize, String),
    Cut(usize, usize),
    Repeat(usize, usize),
    Swap(usize, usize),
    Number(usize, String),
}

fn mutation() -> BoxedStrategy<Mutation> {
    let at = || any::<usize>();
    let scraps = select(
        &[
            "[",
            "]",
            "[[",
            "]]",
            "{",
            "}",
            "=",
            "\"",
            "\"\"\"",
            "'",
            "#",
            ",",
            ".",
            "\n",
            "\r\n",
            "\t",
            "\0",
            "\u{feff}",
            "é",
            "inf",
            "nan",
            "-",
            "1e999",
            "0x",
            "true",
            "a.b.c = 1",
            "[load]",
            "[[load.tilt]]",
            "tilt_deg = 1",
            "= =",
            "2020-01-01",
        ][..],
    );
    let numbers = prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}")),
        any::<i64>().prop_map(|n| n.to_string()),
        Just("-0".to_owned()),
        Just("1e308".to_owned()),
        Just("5e-324".to_owned()),
    ];
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(at, byte)| Mutation::Byte(at, byte)),
        (at(), scraps).prop_map(|(at, scrap)| Mutation::Insert(at, scrap.to_owned())),
        (at(), 1..200_usize).prop_map(|(at, n)| Mutation::Cut(at, n)),
        (at(), 1..200_usize).prop_map(|(at, n)| Mutation::Repeat(at, n)),
        (at(), at()).prop_map(|(a, b)| Mutation::Swap(a, b)),
        (at(), numbers).prop_map(|(at, number)| Mutation::Number(at, number)),
    ]
    .boxed()
}

fn mutate(text: &mut Vec<u8>, mutation: &Mutation) {
    let length = text.len().max(1);
    match mutation {
        Mutation::Byte(at, byte) => {
            if let Some(old) = text.get_mut(at % length) {
                *old = *byte;
            }
        }
        Mutation::Insert(at, scrap) => {
            let at = (at % length).min(text.len());
            text.splice(at..at, scrap.bytes());
        }
        Mutation::Cut(at, n) => {
            let at = (at % length).min(text.len());
            text.drain(at..text.len().min(at + n));
        }
        Mutation::Repeat(at, n) => {
            let at = (at % length).min(text.len());
            let part = text[at..text.len().min(at + n)].to_vec();
            text.splice(at..at, part);
        }
        Mutation::Swap(a, b) => {
            let mut lines: Vec<Vec<u8>> = text.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
            let n = lines.len();
            lines.swap(a % n, b % n);
            *text = lines.join(&b'\n');
        }
        Mutation::Number(at, number) => {
            // Replaces the value of a line.
            let mut lines: Vec<Vec<u8>> = text.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
            let n = lines.len();
            let line = &mut lines[at % n];
            if let Some(equals) = line.iter().position(|b| *b == b'=') {
                line.truncate(equals + 1);
                line.extend(number.bytes());
            }
            *text = lines.join(&b'\n');
        }
    }
}

/// Parses a text; asserts that the result is a scene or one clear error.
fn parses(text: &[u8]) -> Result<bool, TestCaseError> {
    match Scene::parse("campaign", text) {
        Ok(_) => Ok(true),
        Err(error) => is_clear(&error).map(|()| false),
    }
}

fn fuzz(cases: u32) {
    let texts: Vec<&str> = PRESETS.iter().map(|preset| preset.text).collect();
    let counts = Mutex::new([0_u32; 2]);
    let strategy = (select(texts), vec(mutation(), 1..6));
    runner(3, cases)
        .run(&strategy, |(text, mutations)| {
            let mut text = text.as_bytes().to_vec();
            mutations.iter().for_each(|m| mutate(&mut text, m));
            let valid = parses(&text)?;
            counts.lock().unwrap()[usize::from(valid)] += 1;
            Ok(())
        })
        .unwrap_or_else(|failure| panic!("{failure}"));
    let [refused, valid] = counts.into_inner().unwrap();
    println!("mutations: {refused} rejected, {valid} valid");
    // Both outcomes occur, so both promises are tested.
    assert!(
        refused > cases / 10 && valid > cases / 50,
        "{refused} {valid}"
    );
}

#[test]
fn mutated_scenes_parse_or_name_the_faulty_line() {
    fuzz(3000);
}

/// Random TOML: tables, known and unknown keys, nested values of all types.
fn random_toml() -> BoxedStrategy<String> {
    let names = select(
        &[
            "load",
            "load_n",
            "tilt",
            "tilt_deg",
            "time",
            "duration_ms",
            "body",
            "start",
            "kick_mm_per_s",
            "friction",
            "mu_s",
            "analysis",
            "spectrum",
            "window_ms",
            "section",
            "plane_q",
            "impact_oscillator",
            "wall_position_um",
            "record",
            "x",
            "\"\"",
            "\"a b\"",
            "'é'",
        ][..],
    );
    let leaf = prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}").replace("NaN", "nan")),
        any::<i64>().prop_map(|n| n.to_string()),
        any::<bool>().prop_map(|b| b.to_string()),
        "[ -~]{0,12}".prop_map(|s| format!("{s:?}")),
        Just("1979-05-27T07:32:00Z".to_owned()),
        Just("\"\"\"\nmany\nlines\"\"\"".to_owned()),
    ];
    let keys = names.clone();
    let value = leaf.prop_recursive(5, 24, 4, move |inner| {
        let pair = (keys.clone(), inner.clone()).prop_map(|(k, v)| format!("{k} = {v}"));
        prop_oneof![
            vec(inner, 0..4).prop_map(|items| format!("[{}]", items.join(", "))),
            vec(pair, 0..4).prop_map(|items| format!("{{ {} }}", items.join(", "))),
        ]
    });
    let path = vec(names, 1..4).prop_map(|names| names.join("."));
    let line = prop_oneof![
        4 => (path.clone(), value).prop_map(|(path, value)| format!("{path} = {value}\n")),
        1 => path.clone().prop_map(|path| format!("[{path}]\n")),
        1 => path.prop_map(|path| format!("[[{path}]]\n")),
    ];
    vec(line, 0..12).prop_map(|lines| lines.concat()).boxed()
}

#[test]
fn random_toml_parses_or_names_the_faulty_line() {
    runner(4, 3000)
        .run(&random_toml(), |text| parses(text.as_bytes()).map(|_| ()))
        .unwrap_or_else(|failure| panic!("{failure}"));
    // Cases that no generator finds: nesting that could overflow the stack, and bytes that are not text.
    for deep in ["[", "{a=", "a.", "[[", "[a.b", "\"", "é"] {
        let text = format!("x = {}", deep.repeat(100_000));
        assert!(Scene::parse("campaign", text).is_err());
        assert!(Scene::parse("campaign", deep.repeat(100_000)).is_err());
    }
    for bytes in [&b""[..], b"\xff\xfe", b"\0", b"\xef\xbb\xbf"] {
        assert!(Scene::parse("campaign", bytes).is_err());
    }
}

/// The long campaign.
#[test]
#[ignore = "takes some minutes; short campaigns always run"]
fn a_long_campaign() {
    campaign("joints", 101, 1000, &joint_scene());
    campaign("small systems", 102, 10_000, &small_scene());
    fuzz(100_000);
    runner(104, 100_000)
        .run(&random_toml(), |text| parses(text.as_bytes()).map(|_| ()))
        .unwrap_or_else(|failure| panic!("{failure}"));
}
