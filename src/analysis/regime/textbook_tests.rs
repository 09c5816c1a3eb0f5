//! Verdicts on textbook signals that served neither for limits and weights nor for the confidence.

use super::calibration::{LIMIT, MAX_ODDS, PARAMETERS, logistic};
use super::*;
use crate::analysis::test_signals::textbook::{CALIBRATION, JUDGING, TEXTBOOK, Textbook};
use Regime::Undetermined;
use rayon::prelude::*;
use std::sync::LazyLock;

/// The verdict on a signal of a family.
struct Judged {
    family: &'static Textbook,
    number: u64,
    verdict: Verdict,
}

impl Judged {
    fn is_right(&self) -> bool {
        self.family.right.contains(&self.verdict.regime)
    }

    fn is_wrong(&self) -> bool {
        !self.is_right() && self.verdict.regime != Undetermined
    }

    fn is_decided(&self) -> bool {
        self.verdict.regime != Undetermined
    }
}

/// Verdicts on `count` signals of each family, from a number on; only numbers for judging have all families.
fn judge(from: u64, count: u64) -> Vec<Judged> {
    let families = TEXTBOOK
        .iter()
        .filter(|family| from >= JUDGING || !family.judged_only);
    let all: Vec<_> = families
        .flat_map(|family| (from..from + count).map(move |number| (family, number)))
        .collect();
    let search = RegimeSearch {
        sample_rate: 1.0,
        silence: 0.0,
    };
    let one = |(family, number): (&'static Textbook, u64)| Judged {
        family,
        number,
        verdict: classify(&family.signal(number), &search).unwrap(),
    };
    all.into_par_iter().map(one).collect()
}

/// Verdicts for the tests.
static VERDICTS: LazyLock<Vec<Judged>> = LazyLock::new(|| judge(JUDGING, 6));

fn share(of: usize, all: usize) -> f64 {
    of as f64 / all as f64
}

#[test]
fn textbook_signals_have_the_right_verdict() {
    let wrong: Vec<String> = VERDICTS
        .iter()
        .filter(|judged| judged.is_wrong())
        .map(|judged| {
            format!(
                "{} {}: {}",
                judged.family.name,
                judged.number,
                judged.verdict.summary()
            )
        })
        .collect();
    let right = VERDICTS.iter().filter(|judged| judged.is_right()).count();
    assert!(share(wrong.len(), VERDICTS.len()) < 0.05, "{wrong:#?}");
    assert!(share(right, VERDICTS.len()) > 0.9, "{right}");
}

#[test]
fn the_confidence_is_the_share_of_right_verdicts() {
    for [low, high] in [[0.5, 0.9], [0.9, 1.0]] {
        let within = |j: &&Judged| j.is_decided() && (low..high).contains(&j.verdict.confidence);
        let all: Vec<&Judged> = VERDICTS.iter().filter(within).collect();
        let n = all.len() as f64;
        let right = all.iter().filter(|j| j.is_right()).count() as f64 / n;
        let expected = all.iter().map(|j| j.verdict.confidence).sum::<f64>() / n;
        // Three standard deviations of a share of n verdicts.
        let scatter = 3.0 * (expected * (1.0 - expected) / n).sqrt();
        assert!(
            (right - expected).abs() < scatter,
            "{low} to {high}: {right} of {n}, {expected}"
        );
    }
}

/// `JUDGED=1000000 cargo test --release --lib regime::textbook -- --ignored --nocapture table` prints the table of
/// the guide, and the reliability of the confidence.
#[test]
#[ignore = "prints a table"]
fn table_of_verdicts() {
    let from = std::env::var("JUDGED").map_or(0, |number| number.parse().unwrap());
    let judged = judge(from, 40);
    for family in TEXTBOOK {
        let of = || judged.iter().filter(|j| j.family.name == family.name);
        let count = |regime| of().filter(|j| j.verdict.regime == regime).count();
        let counts: String = Regime::ALL
            .map(|regime| format!("{} | ", count(regime)))
            .concat();
        println!(
            "| {} | {counts}{} |",
            family.name,
            of().filter(|j| j.is_wrong()).count()
        );
    }
    for [low, high] in [[0.5, 0.7], [0.7, 0.8], [0.8, 0.9], [0.9, 0.95], [0.95, 1.0]] {
        let within = |j: &&Judged| j.is_decided() && (low..high).contains(&j.verdict.confidence);
        let all: Vec<&Judged> = judged.iter().filter(within).collect();
        let right = all.iter().filter(|j| j.is_right()).count();
        println!(
            "confidence {low} to {high}: {right} of {} are right",
            all.len()
        );
    }
    for j in judged.iter().filter(|j| !j.is_right()) {
        println!("{} {}: {}", j.family.name, j.number, j.verdict.summary());
        if std::env::var("EVIDENCE").is_ok() {
            for e in &j.verdict.evidence {
                println!(
                    "    {:.2} {}: {}",
                    e.weight,
                    e.supported_regimes(),
                    e.explanation()
                );
            }
        }
    }
}

/// Logarithm of the odds of the share that has this confidence.
fn odds(confidence: f64) -> f64 {
    let [a, b] = PARAMETERS;
    let p = confidence / LIMIT;
    (((p / (1.0 - p)).ln() - a) / b).clamp(-MAX_ODDS, MAX_ODDS)
}

/// Share with these odds.
fn share_of(odds: f64) -> f64 {
    1.0 / (1.0 + (-odds).exp())
}

/// Maximum-likelihood parameters for verdicts with these logarithms of odds, by Newton's method.
fn parameters(verdicts: &[(f64, bool)]) -> [f64; 2] {
    let right = verdicts.iter().filter(|(_, right)| *right).count() as f64;
    let wrong = verdicts.len() as f64 - right;
    let target = |is_right| match is_right {
        true => (right + 1.0) / (right + 2.0),
        false => 1.0 / (wrong + 2.0),
    };
    let mut parameters = [0.0, 1.0];
    for _ in 0..50 {
        let (mut gradient, mut curvature) = ([0.0; 2], [[1e-9, 0.0], [0.0, 1e-9]]);
        for (odds, is_right) in verdicts {
            let x = [1.0, *odds];
            let p = logistic(parameters, share_of(*odds));
            for r in 0..2 {
                gradient[r] += x[r] * (target(*is_right) - p);
                for c in 0..2 {
                    curvature[r][c] += x[r] * x[c] * p * (1.0 - p);
                }
            }
        }
        let [[a, b], [c, d]] = curvature;
        let determinant = a * d - b * c;
        parameters[0] += (d * gradient[0] - b * gradient[1]) / determinant;
        parameters[1] += (a * gradient[1] - c * gradient[0]) / determinant;
    }
    parameters
}

/// The parameters of the confidence, from the signals for it.
#[test]
#[ignore = "the fit takes a minute"]
fn the_confidence_is_fitted_to_its_signals() {
    let verdicts: Vec<(f64, bool)> = judge(CALIBRATION, 40)
        .iter()
        .filter(|judged| judged.is_decided())
        .map(|judged| {
            let odds = odds(judged.verdict.confidence);
            (odds, judged.is_right())
        })
        .collect();
    let fitted = parameters(&verdicts);
    println!("{fitted:?}");
    for (fitted, used) in fitted.iter().zip(PARAMETERS) {
        assert!((fitted - used).abs() < 0.02, "{fitted} {used}");
    }
}
