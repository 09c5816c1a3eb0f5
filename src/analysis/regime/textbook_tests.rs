//! Verdicts on textbook signals.

use super::*;
use crate::analysis::test_signals::textbook::{CALIBRATION, JUDGING, TEXTBOOK, Textbook};
use Regime::Undetermined;
use rayon::prelude::*;

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
}

/// Verdicts on `count` signals of each family, from a number on.
fn judge(from: u64, count: u64) -> Vec<Judged> {
    let families = TEXTBOOK
        .iter()
        .filter(|f| from >= JUDGING || !f.judged_only);
    let all: Vec<_> = families
        .flat_map(|family| (from..from + count).map(move |number| (family, number)))
        .collect();
    let one = |(family, number): (&'static Textbook, u64)| {
        let search = RegimeSearch {
            sample_rate: 1.0,
            silence: 0.0,
        };
        let verdict = classify(&family.signal(number), &search).unwrap();
        Judged {
            family,
            number,
            verdict,
        }
    };
    all.into_par_iter().map(one).collect()
}

fn table(judged: &[Judged]) {
    println!(
        "{:<34} {}",
        "",
        Regime::ALL
            .map(|r| format!("{:>7.7}", r.to_string()))
            .join("")
    );
    for family in TEXTBOOK {
        let of: Vec<&Judged> = judged
            .iter()
            .filter(|j| j.family.name == family.name)
            .collect();
        if of.is_empty() {
            continue;
        }
        let count = |r: Regime| of.iter().filter(|j| j.verdict.regime == r).count();
        let wrong = of
            .iter()
            .filter(|j| !j.is_right() && j.verdict.regime != Undetermined)
            .count();
        let cells = Regime::ALL.map(|r| match count(r) {
            0 => format!("{:>7}", "."),
            c => format!("{c:>7}"),
        });
        println!(
            "{:<34} {}   {}{}",
            family.name,
            cells.join(""),
            if wrong > 0 {
                format!("WRONG {wrong}")
            } else {
                String::new()
            },
            if family.judged_only {
                " (held out)"
            } else {
                ""
            }
        );
    }
    let n = judged.len() as f64;
    let right = judged.iter().filter(|j| j.is_right()).count() as f64;
    let un = judged
        .iter()
        .filter(|j| !j.is_right() && j.verdict.regime == Undetermined)
        .count() as f64;
    println!(
        "right {:.3} undetermined {:.3} wrong {:.3} of {n}",
        right / n,
        un / n,
        1.0 - (right + un) / n
    );
    for (lo, hi) in [
        (0.5, 0.6),
        (0.6, 0.7),
        (0.7, 0.8),
        (0.8, 0.9),
        (0.9, 0.95),
        (0.95, 0.99),
        (0.99, 1.01),
    ] {
        let of: Vec<&Judged> = judged
            .iter()
            .filter(|j| {
                j.verdict.regime != Undetermined
                    && j.verdict.confidence >= lo
                    && j.verdict.confidence < hi
            })
            .collect();
        let right = of.iter().filter(|j| j.is_right()).count();
        let mean = of.iter().map(|j| j.verdict.confidence).sum::<f64>() / of.len().max(1) as f64;
        println!(
            "confidence {lo} to {hi}: {} verdicts, {:.3} right, mean confidence {:.3}",
            of.len(),
            right as f64 / of.len().max(1) as f64,
            mean
        );
    }
}

#[test]
#[ignore]
fn explore() {
    let from: u64 = std::env::var("FROM").map_or(0, |x| x.parse().unwrap());
    let count: u64 = std::env::var("COUNT").map_or(10, |x| x.parse().unwrap());
    let start = std::time::Instant::now();
    let judged = judge(from, count);
    println!("{:?}", start.elapsed());
    table(&judged);
    if let Ok(name) = std::env::var("SHOW") {
        for j in judged.iter().filter(|j| j.family.name.starts_with(&name)) {
            if j.is_right() && std::env::var("ALL").is_err() {
                continue;
            }
            println!(
                "{} {}: {} {:.2}",
                j.family.name, j.number, j.verdict.regime, j.verdict.confidence
            );
            for e in &j.verdict.evidence {
                println!(
                    "    {:.2} {:<28} {:.3e} -> {}: {}",
                    e.weight,
                    e.criterion,
                    e.value,
                    e.supported_regimes(),
                    e.description
                );
            }
        }
    }
}

#[test]
#[ignore]
fn changes() {
    for family in TEXTBOOK.iter().filter(|f| !f.judged_only) {
        let mut all: Vec<(f64, f64)> = (0..40_u64)
            .into_par_iter()
            .map(|k| {
                let x = family.signal(k);
                let [low, high] = range(x.iter().copied());
                let a = 0.5 * (high - low);
                let y: Vec<f64> = x.iter().map(|x| (x - low) / a - 1.0).collect();
                let f = Features::of(&y, 1.0).unwrap();
                f.change
                    .map_or((0.0, 0.0), |c| (c.significance, c.size.abs()))
            })
            .collect();
        all.sort_by(|a, b| a.0.min(40.0 * a.1).total_cmp(&b.0.min(40.0 * b.1)));
        let f = |k: usize| format!("{:6.1}/{:5.2}", all[k].0, all[k].1);
        println!(
            "{:<34} {} {} {} {} {} {}",
            family.name,
            f(0),
            f(10),
            f(20),
            f(30),
            f(37),
            f(39)
        );
    }
}

/// The parameters of the confidence, from the signals for it.
#[test]
#[ignore = "the fit takes a minute"]
fn the_confidence_is_fitted_to_its_signals() {
    let judged = judge(CALIBRATION, 40);
    let decided = || {
        judged
            .iter()
            .filter(|judged| judged.verdict.regime != Undetermined)
    };
    let odds = |judged: &Judged| calibration::fitting::odds(judged.verdict.confidence);
    let verdicts: Vec<(f64, bool)> = decided().map(|j| (odds(j), j.is_right())).collect();
    let fitted = calibration::fitting::parameters(&verdicts);
    println!("{fitted:?}");
    for (fitted, used) in fitted.iter().zip(calibration::fitting::FITTED) {
        assert!((fitted - used).abs() < 0.02, "{fitted} {used}");
    }
}
