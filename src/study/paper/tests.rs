//! Claims compared with synthetic results.

use super::*;
use crate::analysis::RecurrenceKind::{Beat, Doubled, Finest};
use crate::analysis::{RecurrencePeriod, RecurrencePeriods, Regime, SpectralLine};
use crate::dynamics::{Exponent, LyapunovSpectrum, SolverStats};
use crate::joint::NamedMode;
use crate::study::StabilityAt;
use crate::study::response::SettledResponse;

/// A response with spectral lines (Hz), exponents (1/s, half-width 1/s) and a number of unstable modes.
fn response(regime: Regime, lines: &[f64], exponents: &[f64], unstable: usize) -> SettledResponse {
    let mode = |k: usize| NamedMode {
        frequency_hz: 1000.0 * (k + 1) as f64,
        growth: if k < unstable { 700.0 } else { -10.0 },
        label: format!("mode {k}"),
        unstable: k < unstable,
    };
    SettledResponse {
        transient: 0.1,
        settled: true,
        amplitude: 7e-7,
        rms_velocity: 0.01,
        peak_velocity: 0.0178,
        maxima: vec![7e-7],
        section: Vec::new(),
        lines: lines
            .iter()
            .map(|&frequency| SpectralLine {
                frequency,
                amplitude: 1e-7,
                label: String::new(),
            })
            .collect(),
        curves: None,
        doubling: 0,
        broadband_share: 0.0,
        exponents: Some(LyapunovSpectrum {
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
        }),
        recurrence: None,
        recurrence_periods: RecurrencePeriods::default(),
        linear: Some(StabilityAt {
            tilt: 0.0,
            modes: (0..11).map(mode).collect(),
        }),
        regime,
        confidence: 0.9,
        portrait: None,
        state: Vec::new(),
        stats: SolverStats::default(),
    }
}

/// Synthetic results that agree with all claims of the paper.
fn as_published() -> Evidence {
    let mut tilts: Vec<f64> = (0..=35).map(|k| 1.0 + 0.2 * f64::from(k)).collect();
    tilts.push(3.5);
    let responses = tilts.into_iter().map(|tilt| {
        let tilt = (10.0_f64 * tilt).round() / 10.0;
        let mut found = match tilt {
            t if t < 2.9 => response(Regime::Periodic, &[4100.0, 8200.0], &[0.1, -50.0], 4),
            t if t < 3.4 => response(Regime::Periodic, &[12_480.0], &[0.1, -50.0], 4),
            t if t < 4.1 => response(
                Regime::QuasiPeriodic,
                &[3870.0, 12_180.0, 570.0],
                &[0.1, 0.0, -50.0],
                5,
            ),
            _ => response(Regime::Chaotic, &[3870.0], &[90.0, 60.0, 30.0], 5),
        };
        let periods: &[_] = match tilt {
            t if t < 2.9 => &[(Finest, 2.44e-4)],
            t if t < 3.1 => &[(Finest, 8e-5)],
            t if t < 3.55 => &[(Finest, 8e-5), (Beat, 1.75e-3)],
            t if t < 4.1 => &[(Finest, 8e-5), (Beat, 1.75e-3), (Doubled, 3.5e-3)],
            _ => &[],
        };
        let periods = periods.iter().map(|&(kind, period)| RecurrencePeriod {
            kind,
            period,
            uncertainty: 1e-3 * period,
            share: 0.5,
        });
        found.recurrence_periods = periods.collect();
        (tilt, found)
    });
    let mut evidence = Evidence::new(responses);
    evidence.delay = Some(Embedding {
        lag: 6e-5,
        dimension: 5,
    });
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

fn holds(findings: &[Finding], id: &str) -> Agreement {
    findings
        .iter()
        .find(|finding| finding.claim.id == id)
        .unwrap()
        .holds
}

#[test]
fn the_claims_parse_and_each_has_one_statement() {
    let claims = claims();
    assert_eq!(claims.len(), 34);
    let mut ids: Vec<&str> = claims.iter().map(|claim| &*claim.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), claims.len());
    // A claim has exactly one key besides the common ones; a misspelt key would be a second one.
    let file: toml::Table = CLAIMS.parse().unwrap();
    for claim in file["claim"].as_array().unwrap() {
        let common = ["id", "where", "statement", "weight", "within"];
        let keys = claim.as_table().unwrap().keys();
        let statements = keys.filter(|key| !common.contains(&key.as_str()));
        assert_eq!(statements.count(), 1, "{claim}");
    }
}

#[test]
fn the_published_results_meet_all_claims() {
    let findings = compare(&as_published());
    for finding in &findings {
        let expected = match &*finding.claim.id {
            // Its unit is unknown.
            "lag" => Agreement::Unknown,
            _ => Agreement::Yes,
        };
        assert_eq!(finding.holds, expected, "{finding:?}");
        assert!(!finding.simulated.is_empty() && !finding.published.is_empty());
    }
    assert_eq!(score(&findings), 1.0);
}

#[test]
fn different_results_do_not_meet_the_claims() {
    let silent = Evidence::new([(2.0, response(Regime::Silent, &[], &[-50.0], 0))]);
    let findings = compare(&silent);
    assert_eq!(holds(&findings, "periodic-2.0"), Agreement::No);
    assert_eq!(holds(&findings, "unstable-2.0"), Agreement::No);
    assert_eq!(holds(&findings, "tone-2.0"), Agreement::Unknown);
    assert_eq!(holds(&findings, "chaos-5.0"), Agreement::Unknown);
    assert_eq!(score(&findings), 0.0);
    // Regimes in the wrong order hold in part.
    let order = [
        Regime::Chaotic,
        Regime::Periodic,
        Regime::QuasiPeriodic,
        Regime::QuasiPeriodic,
    ];
    let responses = order.into_iter().enumerate();
    let responses = responses.map(|(k, regime)| (k as f64, response(regime, &[4100.0], &[0.0], 4)));
    let findings = compare(&Evidence::new(responses));
    assert_eq!(holds(&findings, "order"), Agreement::Partly(0.75));
    assert!(matches!(holds(&findings, "exponent-zero"), Agreement::Yes));
    let finding = findings.iter().find(|f| f.claim.id == "order").unwrap();
    assert_eq!(finding.simulated, "chaotic, periodic, quasi-periodic");
}
