//! Claims compared with signals that are made of the paper's own numbers and measured like a simulation.

use std::collections::BTreeMap;

use super::*;
use crate::analysis::delay::{DelaySearch, choose_delay};
use crate::analysis::regime::Regime;
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::joint::{BallJoint, NamedMode};
use crate::scene::Scene;
use crate::study::response::SettledResponse;
use crate::study::response::tests::measured;
use crate::study::{StabilityAt, stability};
use crate::test_signals::{coordinate, lorenz, sines};

/// Sample rate, Hz, and number of samples of a signal.
const RATE: f64 = 200e3;
const SAMPLES: usize = 60_000;

/// Base frequencies of the torus within the printed digits of Fig. 6d, Hz: incommensurate, as the paper says.
const TORUS: [f64; 2] = [3870.3, 12_181.9];

/// The published motion of one kind: its displacement (m) and its exponents, 1/s.
fn published(kind: &str) -> (Vec<f64>, &'static [f64]) {
    let tones = |tones: &[(f64, f64)]| {
        let tones: Vec<_> = tones.iter().map(|&(hz, size)| (hz, size, 0.3)).collect();
        sines(RATE, SAMPLES, &tones)
    };
    let [f1, f2] = TORUS;
    let difference = f2 - 3.0 * f1;
    match kind {
        "4.1 kHz" => {
            let signal = tones(&[(4100.0, 7e-7), (8200.0, 2e-7), (12_300.0, 1e-7)]);
            (signal, &[0.1, -50.0, -90.0])
        }
        "12.48 kHz" => (tones(&[(12_480.0, 3e-7)]), &[0.1, -50.0, -90.0]),
        "torus" => {
            let signal = tones(&[(f1, 6e-7), (f2, 1.2e-7), (difference, 4e-8)]);
            (signal, &[0.1, 0.0, -50.0])
        }
        "doubled torus" => {
            let half = 0.5 * difference;
            let weak = [
                difference,
                f1 + difference,
                f2 - difference,
                f1 - difference,
            ];
            let doubled = [f1 + half, f1 - half];
            let weak = weak.into_iter().chain(doubled).map(|hz| (hz, 4e-8));
            let strong = [(f1, 6e-7), (f2, 1.2e-7)].into_iter();
            let signal = tones(&strong.chain(weak).collect::<Vec<_>>());
            (signal, &[0.1, 0.0, -50.0])
        }
        // The chaotic oscillator of Lorenz, and the lines of the torus.
        _ => {
            let states = lorenz(SAMPLES, 0.63 * f1 / RATE, [1.0, 1.0, 20.0]);
            let lines = sines(RATE, SAMPLES, &[(f1, 6e-8, 0.3), (f2, 4e-8, 0.3)]);
            let both = coordinate(&states, 0).into_iter().zip(&lines);
            let both = both.map(|(chaos, lines)| 4e-8 * chaos + lines);
            (both.collect(), &[90.0, 60.0, 30.0])
        }
    }
}

/// Linear modes at the published frequencies, of which some are unstable.
fn linear(unstable: &[f64]) -> StabilityAt {
    let modes = [1698.0, 4093.0, 4501.0, 7545.0, 9737.0, 9917.0, 12_448.0];
    let mode = |hz: f64| NamedMode {
        frequency_hz: hz,
        growth: if unstable.contains(&hz) { 700.0 } else { -10.0 },
        label: format!("{hz} Hz"),
        unstable: unstable.contains(&hz),
    };
    StabilityAt {
        tilt: 0.0,
        modes: modes.map(mode).to_vec(),
    }
}

/// A response measured from a published motion, with the linear modes that the paper gives.
fn response(kind: &str, tilt: f64) -> SettledResponse {
    let scene = Scene::load("paper").unwrap();
    let (signal, exponents) = published(kind);
    let mut response = measured(&scene, RATE, &signal).unwrap();
    let four = [1698.0, 4093.0, 7545.0, 12_448.0];
    response.linear = Some(if tilt < 3.25 {
        linear(&four)
    } else {
        linear(&[&four[..], &[4501.0]].concat())
    });
    response.exponents = Some(LyapunovSpectrum {
        exponents: exponents
            .iter()
            .map(|&value| Exponent {
                value,
                half_width: 1.0,
            })
            .collect(),
        time: 1.0,
        dimension: 22,
        resolution: 2.3,
        kaplan_yorke: None,
    });
    response
}

/// The kind of motion that the paper shows at a tilt in degrees.
fn kind(tilt: f64) -> &'static str {
    match tilt {
        tilt if tilt < 2.9 => "4.1 kHz",
        tilt if tilt < 3.1 => "12.48 kHz",
        tilt if tilt < 3.55 => "torus",
        tilt if tilt < 4.1 => "doubled torus",
        _ => "chaos",
    }
}

/// The results that the paper describes, measured.
fn as_published() -> Evidence {
    let mut tilts: Vec<f64> = (5..=40).map(|k| f64::from(2 * k) / 10.0).collect();
    tilts.push(3.5);
    let mut measured: BTreeMap<(&str, bool), SettledResponse> = BTreeMap::new();
    let responses = tilts.into_iter().map(|tilt| {
        let key = (kind(tilt), tilt < 3.25);
        let found = measured
            .entry(key)
            .or_insert_with(|| response(key.0, tilt))
            .clone();
        (tilt, found)
    });
    let mut evidence = Evidence::new(responses);
    let samples = sines(RATE, 4000, &[(4100.0, 1.0, 0.0)]);
    let mut choice = choose_delay(&samples, &DelaySearch::for_samples(samples.len())).unwrap();
    choice.dimension = 5;
    evidence.embedding = Some((choice, 1.0 / RATE));
    let published = [
        ("1st bending", 1698.0),
        ("2nd bending", 4093.0),
        ("1st torsion", 4501.0),
        ("3rd bending", 7545.0),
        ("1st axial", 9737.0),
        ("2nd torsion", 9917.0),
        ("4th bending", 12448.0),
    ];
    evidence.natural_frequencies = published
        .into_iter()
        .map(|(mode, hz)| (mode.to_owned(), hz))
        .collect();
    evidence
}

fn finding<'f>(findings: &'f [Finding], id: &str) -> &'f Finding {
    findings
        .iter()
        .find(|finding| finding.claim.id == id)
        .unwrap()
}

#[test]
fn the_claims_parse_and_each_has_one_statement() {
    let claims = claims();
    let mut ids: Vec<&str> = claims.iter().map(|claimed| &*claimed.claim.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), claims.len());
    for ClaimEntry { claim, reason, .. } in &claims {
        assert!(claim.weight > 0.0 && !claim.quote.is_empty(), "{claim:?}");
        assert_eq!(claim.tolerance > 0.0, !reason.is_empty(), "{claim:?}");
    }
    // A claim has exactly one key besides the common ones; a misspelt key would be a second one.
    let file: serde_json::Value = toml_edit::de::from_str(CLAIMS).unwrap();
    let all = file["claim"].as_array().unwrap();
    assert_eq!(all.len(), claims.len());
    for claim in all {
        let common = [
            "id",
            "place",
            "quote",
            "statement",
            "weight",
            "tolerance",
            "reason",
            "tilts_deg",
            "range_deg",
        ];
        let keys = claim.as_object().unwrap().keys();
        let statements = keys.filter(|key| !common.contains(&key.as_str()));
        assert_eq!(statements.count(), 1, "{claim}");
    }
}

/// Signals made of the paper's numbers meet its claims when they are measured like a simulation.
#[test]
fn the_published_motions_meet_the_claims() {
    let findings = compare(&as_published());
    for finding in &findings {
        let expected = match &*finding.claim.id {
            // Its unit is unknown.
            "lag" => Verdict::NotComparable,
            _ => Verdict::Met,
        };
        assert_eq!(finding.comparison.verdict, expected, "{finding:?}");
    }
    let score = Score::of(&findings);
    assert_eq!((score.strict_score, score.not_comparable), (1.0, 1));
}

/// The scene has the numbers of unstable modes that its table states.
#[test]
fn the_scene_has_the_papers_numbers_of_unstable_modes() {
    let scene = Scene::load("paper").unwrap();
    let text = "Unstable modes at 2.0, 3.0, 3.5 and 5.0 deg: 4, 4, 5, 5.";
    assert!(scene.about.replace('\n', " ").contains(text));
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let tilts = [2.0, 3.0, 3.5, 5.0].map(f64::to_radians);
    let at = stability(&ball, &tilts).unwrap();
    let counts: Vec<usize> = at.iter().map(|at| at.unstable().count()).collect();
    assert_eq!(counts, [4, 4, 5, 5]);
}

/// Motions that resemble the published ones without being them do not meet the claims.
#[test]
fn similar_motions_do_not_meet_the_claims() {
    let scene = Scene::load("paper").unwrap();
    let of = |tones: &[(f64, f64)]| {
        let tones: Vec<_> = tones.iter().map(|&(hz, size)| (hz, size, 0.3)).collect();
        let signal = sines(RATE, SAMPLES, &tones);
        measured(&scene, RATE, &signal).unwrap()
    };
    // A tone of 4.06 kHz has its third harmonic at f2, and a torus has other lines 0.57 kHz apart.
    let third = of(&[(4060.0, 6e-7), (12_180.0, 3e-7), (570.0, 1e-7)]);
    let chaos = response("chaos", 2.0);
    let torus = response("torus", 3.0);
    let evidence = Evidence::new([(2.0, chaos), (3.0, torus), (3.5, third)]);
    let findings = compare(&evidence);
    for id in [
        "periodic-2.0",
        "tone-2.0",
        "harmonics-2.0",
        "periodic-3.0",
        "tone-3.0",
        "torus-f1",
        "torus-f2",
        "torus-difference",
        "order",
    ] {
        let finding = finding(&findings, id);
        assert_eq!(finding.comparison.verdict, Verdict::NotMet, "{finding:?}");
    }
    assert_eq!(
        finding(&findings, "chaos-5.0").comparison.verdict,
        Verdict::NotComparable
    );
}

#[test]
fn an_order_holds_strictly_or_in_part() {
    let of = |order: &[&str]| {
        let responses = order.iter().enumerate().map(|(k, regime)| {
            let mut response = response("12.48 kHz", 2.0);
            response.regime = match *regime {
                "periodic" => Regime::Periodic,
                "torus" => Regime::QuasiPeriodic,
                _ => Regime::Chaotic,
            };
            (k as f64, response)
        });
        let findings = compare(&Evidence::new(responses));
        finding(&findings, "order").comparison.verdict
    };
    assert_eq!(
        of(&["periodic", "periodic", "torus", "chaos"]),
        Verdict::Met
    );
    assert_eq!(
        of(&["chaos", "periodic", "torus", "torus"]),
        Verdict::NotMet
    );
    assert_eq!(
        of(&["periodic", "torus", "chaos", "periodic"]),
        Verdict::NotMet
    );
    assert_eq!(
        of(&["periodic", "chaos", "torus", "chaos"]),
        Verdict::Partly { share: 0.75 }
    );
    assert_eq!(of(&["periodic", "chaos"]), Verdict::NotMet);
}

#[test]
fn the_strict_score_counts_what_is_met_and_can_be_compared() {
    let with = |weight, verdict| Finding {
        claim: Claim {
            id: String::new(),
            place: String::new(),
            quote: String::new(),
            statement: String::new(),
            weight,
            tolerance: 0.0,
        },
        comparison: Comparison {
            expected: String::new(),
            measured: String::new(),
            deviation: None,
            verdict,
        },
        short_average: None,
    };
    let score = Score::of(&[
        with(1.0, Verdict::Met),
        with(2.0, Verdict::Partly { share: 0.5 }),
        with(1.0, Verdict::NotMet),
        with(5.0, Verdict::NotComparable),
    ]);
    let expected = Score {
        strict_score: 0.25,
        partial_score: 0.5,
        met: 1,
        partly: 1,
        not_met: 1,
        not_comparable: 1,
    };
    assert_eq!(score, expected);
}
