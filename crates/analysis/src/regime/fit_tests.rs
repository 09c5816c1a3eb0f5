//! Fit of the model to signals of known regime, and what it says about others.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::recording_tests::stretches;
use super::*;
use crate::generator::{JUDGING_SEEDS, Kind, TUNING_SEEDS};
use crate::logistic::{Model, fit};
use crate::test_signals::recorded::RECORDED;
use crate::test_signals::textbook::{JUDGING, TEXTBOOK, Textbook};

/// Recordings whose sounds are fitted: their kind, signal-to-noise ratios (dB) and number. Each type of motion and other
/// sounds are prepared like squeaks, so that neither the preparation nor the length of a record is evidence for a squeak.
const FITTED_RECORDINGS: [(Kind, [f64; 2], u64); 6] = [
    (Kind::Squeaks, [5.0, 30.0], 400),
    (Kind::Torus, [15.0, 45.0], 60),
    (Kind::Doubled, [15.0, 45.0], 40),
    (Kind::Chaos, [20.0, 45.0], 40),
    (Kind::Resonance, [5.0, 30.0], 40),
    (Kind::Bursts, [5.0, 30.0], 12),
];
const FIRST: u64 = TUNING_SEEDS.start + 710_000;

/// The features of each interval of a signal; `None` for a silent one.
type Intervals = Vec<Option<Features>>;

fn of_intervals(samples: &[f64], search: &RegimeSearch) -> Intervals {
    let (intervals, averaged) = intervals(samples).unwrap();
    let found = features(samples, &intervals, averaged, search).unwrap();
    found.into_iter().map(|(_, features)| features).collect()
}

/// The verdict on a signal of a family.
struct Example {
    family: &'static Textbook,
    verdict: Verdict,
}

impl Example {
    fn is_decided(&self) -> bool {
        self.verdict.regime != Regime::Undetermined
    }

    fn is_wrong(&self) -> bool {
        self.is_decided() && !self.family.right.contains(&self.verdict.regime)
    }
}

/// Features of signals of families, `count` of each.
fn measured(
    families: impl IntoIterator<Item = &'static Textbook>,
    from: u64,
    count: u64,
) -> Vec<(&'static Textbook, Intervals)> {
    let all: Vec<_> = families
        .into_iter()
        .flat_map(|family| (from..from + count).map(move |number| (family, number)))
        .collect();
    let one = |(family, number): (&'static Textbook, u64)| {
        let (samples, background) = family.signal(number);
        let search = RegimeSearch {
            sample_rate: 1.0,
            silence: 0.0,
            background,
        };
        (family, of_intervals(&samples, &search))
    };
    all.into_par_iter().map(one).collect()
}

/// Features of the sounds in recordings of a kind, with their right verdicts.
fn recorded(
    kind: Kind,
    snr_db: [f64; 2],
    seeds: Range<u64>,
) -> Vec<(&'static [Regime], Intervals)> {
    let measured = |seed| {
        let sounds = stretches(kind, snr_db, seed).into_iter();
        sounds.map(|sound| (sound.right, of_intervals(&sound.samples, &sound.search)))
    };
    seeds.into_par_iter().flat_map_iter(measured).collect()
}

fn criteria(features: &Features) -> Vec<&'static str> {
    features.inputs.iter().map(|f| f.criterion).collect()
}

/// Verdicts on signals of all families.
fn examples(from: u64, count: u64) -> Vec<Example> {
    let measured = measured(TEXTBOOK.iter().chain(RECORDED), from, count).into_iter();
    let example = |(family, intervals): (_, Intervals)| Example {
        family,
        verdict: verdict(intervals.into_iter()).unwrap(),
    };
    measured.map(example).collect()
}

/// `cargo test --release --lib regime::fit_tests::the_model_is_fitted -- --ignored` fits the model anew and compares; with
/// `SQUEAKSCOPE_MODEL=FILE` it writes it to a file.
#[test]
#[ignore = "the fit takes some minutes"]
fn the_model_is_fitted() {
    let families = TEXTBOOK.iter().chain(RECORDED);
    let measured = measured(families.filter(|family| !family.judged_only), 0, 120);
    let names = criteria(measured[0].1[0].as_ref().unwrap());
    let families = measured
        .into_iter()
        .map(|(family, features)| (family.right, features));
    let sounds = FITTED_RECORDINGS
        .into_iter()
        .flat_map(|(kind, snr_db, count)| recorded(kind, snr_db, FIRST..FIRST + count));
    let training = families
        .chain(sounds)
        .flat_map(|(right, intervals)| {
            let sounding = intervals.into_iter().flatten();
            sounding.map(move |features| (right, features))
        })
        .map(|(right, features)| fit::Example {
            inputs: features.inputs.iter().map(|f| f.input).collect(),
            right: classes()
                .iter()
                .map(|class| right.contains(class))
                .collect(),
        });
    // What is too short to be anything is none of the classes.
    let training: Vec<fit::Example> = training
        .filter(|example| example.right.contains(&true))
        .collect();
    Model::fitted(&names, &training).write_or_compare(&MODEL);
}

#[test]
fn the_inputs_of_the_model_are_those_measured() {
    let names = MODEL.coefficients.iter().map(|c| c.input.as_str());
    let first = &measured(&TEXTBOOK[..1], 0, 1)[0].1[0];
    assert!(names.eq(criteria(first.as_ref().unwrap())));
}

/// Expected calibration error: the mean difference of confidence and share of right verdicts, over ten equally
/// populated groups of decided verdicts.
fn calibration_error(examples: &[&Example]) -> f64 {
    let mut decided: Vec<(f64, bool)> = examples
        .iter()
        .filter(|e| e.is_decided())
        .map(|e| (e.verdict.confidence, !e.is_wrong()))
        .collect();
    decided.sort_by(|a, b| a.0.total_cmp(&b.0));
    let groups = decided.chunks(decided.len().div_ceil(10));
    let error = |group: &[(f64, bool)]| {
        let right = group.iter().filter(|(_, right)| *right).count() as f64;
        (group.iter().map(|(p, _)| p).sum::<f64>() - right).abs()
    };
    groups.map(error).sum::<f64>() / decided.len() as f64
}

/// Shares of right, undetermined and wrong verdicts, where undetermined is not right.
fn shares(examples: &[&Example]) -> [f64; 3] {
    let share = |is: &dyn Fn(&Example) -> bool| {
        examples.iter().filter(|e| is(e)).count() as f64 / examples.len() as f64
    };
    let knows_nothing = |e: &Example| e.family.right == [Regime::Undetermined];
    [
        share(&|e| !e.is_wrong() && (e.is_decided() || knows_nothing(e))),
        share(&|e| !e.is_decided() && !knows_nothing(e)),
        share(&|e| e.is_wrong()),
    ]
}

#[test]
fn signals_that_served_for_nothing_have_the_right_verdict() {
    let all = examples(JUDGING, 12);
    let [right, _, wrong] = shares(&all.iter().collect::<Vec<_>>());
    assert!(right > 0.9 && wrong < 0.05, "{right} {wrong}");
    for judged_only in [false, true] {
        let part: Vec<&Example> = all
            .iter()
            .filter(|e| e.family.judged_only == judged_only)
            .collect();
        // Half of it is the scatter of groups of some twenty verdicts.
        assert!(
            calibration_error(&part) < 0.05,
            "{}",
            calibration_error(&part)
        );
    }
}

/// Right and undetermined verdicts on the sounds in recordings of a kind, and the number of sounds.
fn verdicts_on(kind: Kind, snr_db: f64, seeds: Range<u64>) -> [usize; 3] {
    let mut counts = [0; 3];
    for (right, intervals) in recorded(kind, [snr_db; 2], seeds) {
        let regime = verdict(intervals.into_iter()).unwrap().regime;
        counts[0] += usize::from(regime != Regime::Undetermined && right.contains(&regime));
        counts[1] += usize::from(regime == Regime::Undetermined);
        counts[2] += 1;
    }
    counts
}

#[test]
fn weak_squeaks_in_recordings_are_periodic() {
    let seeds = JUDGING_SEEDS.start..JUDGING_SEEDS.start + 9;
    let [right, undetermined, all] = verdicts_on(Kind::Squeaks, 15.0, seeds);
    let wrong = all - right - undetermined;
    assert!(
        all >= 3 && 10 * right >= 6 * all && 10 * wrong <= 3 * all,
        "{right} {undetermined} of {all}"
    );
}

/// `cargo test --release --lib verdicts_on_recorded_sounds -- --ignored --nocapture` prints the verdicts on sounds that
/// served for nothing.
#[test]
#[ignore = "prints a table; takes some minutes"]
fn verdicts_on_recorded_sounds() {
    let sets = [
        (Kind::Torus, 20.0),
        (Kind::Torus, 35.0),
        (Kind::Doubled, 20.0),
        (Kind::Chaos, 35.0),
        (Kind::Squeaks, 10.0),
        (Kind::Squeaks, 15.0),
        (Kind::Squeaks, 20.0),
        (Kind::Squeaks, 30.0),
        (Kind::Resonance, 0.0),
        (Kind::Bursts, 0.0),
    ];
    for ((kind, snr_db), set) in sets.into_iter().zip(0..) {
        let first = JUDGING_SEEDS.start + 300_000 + 1000 * set;
        let [right, undetermined, all] = verdicts_on(kind, snr_db, first..first + 24);
        let wrong = all - right - undetermined;
        println!("| {kind:?}, {snr_db} dB | {right} | {undetermined} | {wrong} |");
        assert!(10 * right >= 6 * all && 10 * wrong <= 2 * all, "{kind:?}");
    }
}

/// `JUDGED=1000000 cargo test --release --lib table_of_verdicts -- --ignored --nocapture` prints the tables of the
/// guide. The number is the first one of the signals.
#[test]
#[ignore = "prints a table"]
fn table_of_verdicts() {
    let from = std::env::var("JUDGED").map_or(JUDGING, |number| number.parse().unwrap());
    let all = examples(from, 40);
    let mut families: BTreeMap<&str, Vec<&Example>> = BTreeMap::new();
    for example in &all {
        families
            .entry(example.family.name)
            .or_default()
            .push(example);
    }
    for (name, examples) in &families {
        let count = |is: &dyn Fn(&Example) -> bool| examples.iter().filter(|e| is(e)).count();
        let wrong = count(&|e| e.is_wrong());
        let undetermined = count(&|e| !e.is_decided());
        let star = if examples[0].family.judged_only {
            " *"
        } else {
            ""
        };
        let verdicts: Vec<String> = classes()
            .iter()
            .map(|class| count(&|e| e.verdict.regime == *class).to_string())
            .collect();
        println!(
            "| {name}{star} | {} | {undetermined} | {wrong} | {}",
            examples.len() - wrong - undetermined,
            verdicts.join(" ")
        );
    }
    for judged_only in [false, true] {
        let part: Vec<&Example> = all
            .iter()
            .filter(|e| e.family.judged_only == judged_only)
            .collect();
        println!(
            "{judged_only}: {:.3?}, {:.3}",
            shares(&part),
            calibration_error(&part)
        );
        for [low, high] in [
            [0.6, 0.7],
            [0.7, 0.8],
            [0.8, 0.9],
            [0.9, 0.95],
            [0.95, 0.99],
            [0.99, 1.1],
        ] {
            let within =
                |e: &&&Example| e.is_decided() && (low..high).contains(&e.verdict.confidence);
            let group: Vec<_> = part.iter().filter(within).collect();
            let right = group.iter().filter(|e| !e.is_wrong()).count();
            let mean = group.iter().map(|e| e.verdict.confidence).sum::<f64>() / group.len() as f64;
            println!(
                "| {low} to {high} | {} | {right} | {mean:.3} |",
                group.len()
            );
        }
    }
}
