//! A randomised campaign over the whole space of valid scenes, and over texts that are none.
//!
//! Seeds are written down here, so that the same scenes run each time; `SQUEAKSCOPE_SEED` and
//! `SQUEAKSCOPE_CASES` change them, and `SQUEAKSCOPE_TELL=1` prints each scene that ends in an error or
//! fails its audit. The long one:
//! `cargo test --release --test it campaign -- --ignored --nocapture`

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use squeakscope::dynamics::DynamicsError;
use squeakscope::pipeline::message::{Frame, Record, Summary};
use squeakscope::pipeline::{Monitor, PipelineError, Sink, SinkError, run};
use squeakscope::scene::{PRESETS, Parameter, Scene, SceneError};

/// Beyond this the command line says that a motion may be wrong.
const WORRYING_AUDIT: f64 = 0.05;

/// What scenes resolve: energies below it count as nothing in the audit, J.
const FLOOR: f64 = 1e-12;

/// A run is ended after this, at its next frame.
const PATIENCE: Duration = Duration::from_millis(60);

/// A run that has not even done a frame after this hangs.
const HANGING: Duration = Duration::from_secs(120);

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A runner with a seed of its own, that keeps no file of failures.
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

/// A positive number of any size in a range, its ends among them.
fn positive(low: f64, high: f64) -> BoxedStrategy<String> {
    let inside = (low.ln()..=high.ln()).prop_map(move |x| x.exp().clamp(low, high));
    prop_oneof![1 => Just(low), 1 => Just(high), 10 => inside]
        .prop_map(|x| format!("{x:?}"))
        .boxed()
}

/// A number in a range, its ends and its middle among them.
fn number(low: f64, high: f64) -> BoxedStrategy<String> {
    prop_oneof![1 => Just(low), 1 => Just(high), 1 => Just(0.5 * (low + high)), 10 => low..=high]
        .prop_map(|x| format!("{x:?}"))
        .boxed()
}

/// A whole number in a range, small ones rather than large ones.
fn count(low: u32, high: u32) -> BoxedStrategy<String> {
    let inside = (f64::from(low.max(1)).ln()..=f64::from(high).ln()).prop_map(|x| x.exp() as u32);
    prop_oneof![1 => Just(low), 10 => inside]
        .prop_map(move |n| n.clamp(low, high).to_string())
        .boxed()
}

fn word(words: &'static [&'static str]) -> BoxedStrategy<String> {
    select(words).prop_map(|word| format!("\"{word}\"")).boxed()
}

fn flag() -> BoxedStrategy<String> {
    any::<bool>().prop_map(|flag| flag.to_string()).boxed()
}

fn vector(component: BoxedStrategy<String>) -> BoxedStrategy<String> {
    let zero = Just("0".to_owned());
    vec(prop_oneof![1 => zero, 3 => component], 3)
        .prop_map(|c| format!("[{}]", c.join(", ")))
        .boxed()
}

/// Keys of a joint's scene and what each may be: the ranges of `squeakscope scenes --keys`, but for
/// counts of nodes and elements, whose price grows with them and nothing else.
fn keys() -> Vec<(&'static str, BoxedStrategy<String>)> {
    vec![
        ("body.beam_reaches", word(&["sphere", "centre"])),
        ("body.young_gpa", positive(0.001, 2000.0)),
        ("body.poisson", number(-0.99, 0.49)),
        ("body.density_kg_m3", positive(10.0, 30_000.0)),
        ("body.element_order", count(1, 6)),
        ("socket.young_gpa", positive(0.001, 2000.0)),
        ("socket.poisson", number(-0.99, 0.49)),
        ("load.azimuth_deg", number(-360.0, 360.0)),
        ("rotation.rad_s", vector(number(-1e4, 1e4))),
        ("rotation.convection", flag()),
        ("contact.nodes", count(1, 200)),
        ("contact.quadrature", word(&["rings", "gauss"])),
        ("contact.stiffness_factor", positive(1e-6, 1e4)),
        ("contact.stiffness", word(&["uniform", "pre-stress"])),
        ("contact.radius_factor", positive(0.1, 5.0)),
        ("contact.unilateral", flag()),
        ("friction.creep_slope_s_per_m", positive(1e-3, 1e8)),
        ("friction.radial", flag()),
        ("damping.ratio", number(0.0, 0.999)),
        ("start.kick_mm_per_s", positive(1e-320, 1000.0)),
        ("start.seed", count(0, 1_000_000)),
        ("time.sample_rate_khz", positive(100.0, 2000.0)),
        (
            "time.method",
            word(&[
                "lawson54",
                "lawson853",
                "tsit54",
                "dop853",
                "rodas5p",
                "auto",
                "rk4",
            ]),
        ),
        ("time.tolerance", positive(1e-13, 1e-2)),
        ("time.max_step_us", positive(0.001, 1000.0)),
        ("time.events", word(&["through", "exact"])),
    ]
}

/// Dimensions that fit together, more often than not: ball, beam in it, socket round it.
fn dimensions() -> BoxedStrategy<String> {
    (0.0..6.2_f64, 0.01..1.02_f64, 0.0..8.5_f64, -7.0..0.7_f64)
        .prop_map(|(ball, beam, length, gap)| {
            let ball = ball.exp();
            format!(
                "body.ball_diameter_mm = {ball:?}\nbody.beam_diameter_mm = {:?}\n\
                 body.beam_length_mm = {:?}\nbody.element_size_mm = {:?}\nsocket.diameter_mm = {:?}\n",
                (beam * ball).max(0.5),
                length.exp(),
                ball.max(length.exp() / 40.0).clamp(0.1, 100.0),
                ball * (1.0 + gap.exp())
            )
        })
        .boxed()
}

/// The paper's modes, fewer, or others.
fn modes() -> BoxedStrategy<String> {
    let of =
        |pairs, torsion, axial, words| {
            (count(0, pairs), count(0, torsion), count(0, axial), word(words))
            .prop_map(|(pairs, torsion, axial, frequencies)| {
                format!(
                    "body.bending_pairs = {pairs}\nbody.torsion = {torsion}\nbody.axial = {axial}\n\
                     body.frequencies = {frequencies}\n"
                )
            })
            .boxed()
        };
    prop_oneof![of(4, 2, 1, &["published", "fe"]), of(8, 4, 3, &["fe"])].boxed()
}

/// A law of friction with its coefficients, and with its slope or without.
fn friction() -> BoxedStrategy<String> {
    let mu = || number(0.0, 10.0);
    let slope = prop_oneof![
        2 => Just(String::new()),
        1 => positive(1e-3, 1e6).prop_map(|f| format!("friction.stribeck_slope_s_per_m = {f}\n")),
    ];
    let falling = (mu(), mu(), slope).prop_map(|(mu_s, mu_d, slope)| {
        format!("friction.mu_s = {mu_s}\nfriction.mu_d = {mu_d}\n{slope}")
    });
    let level = mu().prop_map(|mu| format!("friction.law = \"constant\"\nfriction.mu = {mu}\n"));
    prop_oneof![3 => falling, 1 => level].boxed()
}

/// Damping of the contact, of either law.
fn contact_damping() -> BoxedStrategy<String> {
    let law = |law: &'static str, key: &'static str, most| {
        positive(1e-6, most).prop_map(move |x| {
            format!("contact_damping.law = \"{law}\"\ncontact_damping.{key} = {x}\n")
        })
    };
    prop_oneof![
        law("kelvin-voigt", "retardation_time_us", 1e4),
        law("hunt-crossley", "dissipation_s_per_m", 100.0),
    ]
    .boxed()
}

/// A small change of the preset: two keys in three keep their value, so that scenes make sense together.
fn joint_scene() -> BoxedStrategy<String> {
    let optional = keys().into_iter().map(|(key, value)| {
        let line = value.prop_map(move |value| format!("{key} = {value}\n"));
        prop_oneof![2 => Just(String::new()), 1 => line].boxed()
    });
    let required = [
        ("load.load_n", positive(1e-6, 1e6)),
        ("load.tilt_deg", number(-90.0, 90.0)),
    ];
    let required =
        required.map(|(key, value)| value.prop_map(move |v| format!("{key} = {v}\n")).boxed());
    let blocks = [dimensions(), modes(), contact_damping()];
    let blocks = blocks.map(|block| prop_oneof![2 => Just(String::new()), 1 => block].boxed());
    let lines: Vec<_> = optional
        .chain(blocks)
        .chain(required)
        .chain([friction()])
        .collect();
    lines
        .prop_map(|lines| {
            format!(
                "{}time.duration_ms = 1.0\ntime.frame_samples = 2\nrecord.energy_rate_khz = 100\n",
                lines.concat()
            )
        })
        .boxed()
}

/// A scene of a small system.
fn small_scene() -> BoxedStrategy<String> {
    let table = |name: &'static str, keys: Vec<(&'static str, BoxedStrategy<String>)>| {
        let lines: Vec<_> = keys
            .into_iter()
            .map(move |(key, value)| {
                value
                    .prop_map(move |v| format!("{name}.{key} = {v}\n"))
                    .boxed()
            })
            .collect();
        lines.prop_map(|lines| lines.concat()).boxed()
    };
    let drive = || {
        [
            ("damping_ratio", number(0.0, 0.99)),
            (
                "drive_m_per_s2",
                prop_oneof![Just("0".to_owned()), positive(1e-6, 1e6)].boxed(),
            ),
            (
                "drive_frequency_hz",
                prop_oneof![Just("0".to_owned()), positive(1e-3, 1e5)].boxed(),
            ),
        ]
    };
    let mut impact = vec![
        ("frequency_hz", positive(1e-3, 1e5)),
        ("wall_um", number(-1e6, 1e6)),
        ("restitution", number(0.0, 1.0)),
    ];
    impact.extend(drive());
    let mut damped = vec![
        ("frequency_hz", positive(1e-3, 1e5)),
        ("contact_frequency_hz", positive(1e-3, 1e5)),
        ("contact_damping_ratio", number(0.0, 0.99)),
    ];
    damped.extend(drive());
    let belt = vec![
        ("frequency_hz", positive(1e-3, 1e5)),
        ("damping_ratio", number(0.0, 0.99)),
        ("load_n_per_kg", positive(1e-6, 1e6)),
        ("mu_s", number(0.0, 10.0)),
        ("mu_d", number(0.0, 10.0)),
        ("belt_mm_per_s", positive(1e-6, 1e5)),
    ];
    let system = prop_oneof![
        table("impact_oscillator", impact),
        table("damped_contact", damped),
        table("mass_on_belt", belt)
    ];
    let methods = word(&[
        "lawson54",
        "lawson853",
        "tsit54",
        "dop853",
        "rodas5p",
        "auto",
    ]);
    (
        system,
        methods,
        number(-1e6, 1e6),
        number(-1e5, 1e5),
        positive(1e-13, 1e-2),
    )
        .prop_map(|(system, method, position, velocity, tolerance)| {
            format!(
                "{system}start.position_um = {position}\nstart.velocity_mm_per_s = {velocity}\n\
                 time.method = {method}\ntime.tolerance = {tolerance}\ntime.duration_ms = 20\n\
                 time.sample_rate_khz = 20\ntime.frame_samples = 2\n"
            )
        })
        .boxed()
}

/// How many scenes ended how.
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    refused: u32,
    whole: u32,
    slow: u32,
    worrying: u32,
    faults: u32,
    worst_audit: f64,
}

/// Looks at each frame as it comes.
struct Judge {
    turnover: f64,
    /// As the summary should say it.
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

/// Runs a scene for a short while.
fn judge(scene: &Scene) -> (Result<Summary, PipelineError>, Judge) {
    let mut judge = Judge {
        turnover: 0.0,
        audit: 0.0,
        fault: None,
    };
    let stop = Arc::new(AtomicBool::new(false));
    // From the first frame on: the body's modes are found before.
    let began = OnceLock::new();
    let monitor = Monitor {
        stop: &stop,
        progress: &|_| {
            let spent = began.get_or_init(Instant::now).elapsed();
            stop.store(spent > PATIENCE, Ordering::Relaxed);
        },
    };
    let result = run(scene, "campaign", &mut judge, monitor);
    (result, judge)
}

/// Asserts what is promised of any text: a scene, or one clear error; of a scene, a run that keeps its
/// numbers, or one clear error.
fn check(text: &str, ends: &mut Ends) -> Result<(), TestCaseError> {
    let scene = match Scene::parse("campaign", text) {
        Ok(scene) => scene,
        Err(error) => {
            ends.refused += 1;
            return is_clear(&error);
        }
    };
    // A run that never comes back is seen from outside.
    let (tell, told) = mpsc::channel();
    // Nobody listens any more to one that hangs.
    std::thread::spawn(move || tell.send(judge(&scene)).is_ok());
    let (result, judge) = told.recv_timeout(HANGING).map_err(|end| match end {
        RecvTimeoutError::Timeout => TestCaseError::fail("it hangs"),
        RecvTimeoutError::Disconnected => TestCaseError::fail("it panics"),
    })?;
    prop_assert!(judge.fault.is_none(), "{:?}", judge.fault);
    match result {
        Ok(summary) => {
            ends.whole += u32::from(!summary.interrupted);
            ends.slow += u32::from(summary.interrupted);
            // Nothing to audit is nothing amiss.
            let told = summary.audit.unwrap_or(0.0);
            let same = told == judge.audit || (told - judge.audit).abs() <= 1e-9 * judge.audit;
            prop_assert!(
                same,
                "the summary says {told:e}, the samples {:e}",
                judge.audit
            );
            if told <= WORRYING_AUDIT {
                ends.worst_audit = ends.worst_audit.max(told);
                return Ok(());
            }
            ends.worrying += 1;
            if from_environment("SQUEAKSCOPE_TELL").is_some() {
                println!("audit {told:e} of\n{text}");
            }
            return heals(text, told);
        }
        Err(error) => {
            ends.faults += 1;
            if from_environment("SQUEAKSCOPE_TELL").is_some() {
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

/// What the command line advises against an audit that fails is of use: with a smaller tolerance, or a
/// shorter step where that is fixed, it is smaller, or passes.
fn heals(text: &str, told: f64) -> Result<(), TestCaseError> {
    let scene = finer(text).map_err(|error| TestCaseError::fail(error.to_string()))?;
    if let (Ok(summary), _) = judge(&scene) {
        let audit = summary.audit.unwrap_or(0.0);
        prop_assert!(
            audit < WORRYING_AUDIT.max(0.1 * told),
            "an audit of {told:e} remains {audit:e}"
        );
    }
    Ok(())
}

/// The scene of a text with a thousandth of the tolerance, and a tenth of the longest step where it is fixed.
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

/// One message, which names the place.
fn is_clear(error: &SceneError) -> Result<(), TestCaseError> {
    let said = error.to_string();
    prop_assert!(said.starts_with("campaign"), "{said}");
    prop_assert!(said.len() < 4000 && said.lines().count() == 1, "{said}");
    if let SceneError::Content { at, .. } = error {
        prop_assert!(at.line.is_some(), "{said}");
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
fn random_joints_run_or_say_why_not() {
    let ends = campaign("joints", 1, 80, &joint_scene());
    // Most of what is tried does run, though not all to its end.
    assert!(ends.whole + ends.slow > ends.refused, "{ends:?}");
}

#[test]
fn random_small_systems_run_or_say_why_not() {
    let ends = campaign("small systems", 2, 150, &small_scene());
    assert!(ends.whole + ends.slow > ends.refused, "{ends:?}");
}

/// Mutations of a text: bytes changed, lines lost, doubled or exchanged, numbers replaced.
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
            // The value of some line.
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

/// Parses; asserts that there is a scene, or one clear error.
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
    println!("mutations: {refused} refused, {valid} valid");
    // Both ends are met, so that both promises are put to the test.
    assert!(
        refused > cases / 10 && valid > cases / 50,
        "{refused} {valid}"
    );
}

#[test]
fn mutated_scenes_parse_or_say_where_not() {
    fuzz(3000);
}

/// TOML at random: tables, keys known and unknown, values of all types, nested.
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
            "wall_um",
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
fn random_toml_parses_or_says_where_not() {
    runner(4, 3000)
        .run(&random_toml(), |text| parses(text.as_bytes()).map(|_| ()))
        .unwrap_or_else(|failure| panic!("{failure}"));
    // And what no generator finds: depth that would overflow a stack, and no text at all.
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
#[ignore = "takes some minutes; short ones run always"]
fn a_long_campaign() {
    campaign("joints", 101, 1000, &joint_scene());
    campaign("small systems", 102, 10_000, &small_scene());
    fuzz(100_000);
    runner(104, 100_000)
        .run(&random_toml(), |text| parses(text.as_bytes()).map(|_| ()))
        .unwrap_or_else(|failure| panic!("{failure}"));
}
