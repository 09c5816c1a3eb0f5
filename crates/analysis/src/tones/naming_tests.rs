//! Choice of the bases: doublings, continuity, locking and modulation.

use super::tests::{labels, lines};
use super::*;
use crate::test_signals::sines;
use crate::tones::{LineCriterion, SpectrumAnalyser, Window};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A quarter of a bin of 0.6 s, as for a settled response.
const SETTLED: f64 = 0.42;

/// The lines of the scene doubled-torus-3deg at 2 to 4.5 degrees and at 8: displacement in um, 0.6 s, downward
/// continuation.
const AT_2: &[(f64, f64)] = &[
    (4109.56, 0.617),
    (12_328.68, 0.0807),
    (3869.75, 0.0795),
    (7979.31, 0.0413),
    (239.81, 0.0284),
    (8219.12, 0.0246),
    (12_088.87, 0.0143),
    (12_568.49, 0.0112),
    (4349.37, 0.0112),
    (16_438.24, 0.0111),
    (7739.50, 0.00878),
    (479.62, 0.00865),
];
const AT_3: &[(f64, f64)] = &[
    (4112.79, 0.616),
    (3874.08, 0.0966),
    (12_338.37, 0.0788),
    (7986.87, 0.0508),
    (238.71, 0.0331),
    (8225.58, 0.0206),
    (3993.43, 0.0203),
    (12_099.66, 0.0187),
    (4351.50, 0.0161),
    (7748.15, 0.0132),
    (12_577.08, 0.0129),
    (4590.22, 0.0118),
];
const AT_3_5: &[(f64, f64)] = &[
    (4114.29, 0.615),
    (3880.62, 0.100),
    (12_342.87, 0.0778),
    (7994.91, 0.0513),
    (3997.46, 0.0396),
    (233.67, 0.0340),
    (12_109.20, 0.0198),
    (8228.58, 0.0189),
    (7878.08, 0.0188),
    (4347.96, 0.0179),
    (7761.24, 0.0147),
    (3763.79, 0.0132),
];
const AT_4_5: &[(f64, f64)] = &[
    (4118.13, 0.607),
    (3891.34, 0.113),
    (12_354.38, 0.0770),
    (8009.47, 0.0559),
    (4004.73, 0.0408),
    (226.79, 0.0380),
    (7896.07, 0.0263),
    (4344.91, 0.0240),
    (12_127.59, 0.0238),
    (3777.95, 0.0223),
    (3948.04, 0.0184),
    (7782.68, 0.0182),
];
/// At 6.5 degrees the cascade is passed in reverse; 24 of the strongest lines.
const AT_6_5: &[(f64, f64)] = &[
    (4125.93, 0.605),
    (3889.02, 0.130),
    (12_377.80, 0.0718),
    (8014.95, 0.0714),
    (4362.85, 0.0418),
    (236.91, 0.0415),
    (12_140.88, 0.0341),
    (7778.04, 0.0286),
    (4599.76, 0.0243),
    (4007.47, 0.0222),
    (7896.49, 0.0206),
    (8251.86, 0.0202),
    (3770.56, 0.017),
    (4244.39, 0.014),
    (4481.30, 0.013),
    (12_614.71, 0.012),
    (473.83, 0.010),
    (3652.10, 0.0092),
    (3829.79, 0.0091),
    (3948.25, 0.00905),
    (16_503.73, 0.0086),
    (7955.72, 0.0074),
    (118.46, 0.0073),
    (7837.26, 0.0053),
];
const AT_8: &[(f64, f64)] = &[
    (4133.16, 0.599),
    (3888.04, 0.132),
    (8021.20, 0.0790),
    (12_399.48, 0.0661),
    (4378.28, 0.0601),
    (12_154.36, 0.0426),
    (245.12, 0.0410),
    (7776.08, 0.0380),
    (4623.39, 0.0283),
    (8266.32, 0.0268),
    (3642.92, 0.0143),
    (490.24, 0.0114),
];

fn name_at(naming: &LineIdentification, list: &[(f64, f64)], frequency: f64) -> String {
    let k = list.iter().position(|line| line.0 == frequency).unwrap();
    labels(naming)[k].clone()
}

#[test]
fn the_torus_doubles_twice_and_returns_with_rising_tilt() {
    for (list, f1, f2, doubling) in [
        (AT_2, 4109.56, 3869.75, 0),
        (AT_3, 4112.79, 3874.08, 1),
        (AT_3_5, 4114.29, 3880.62, 1),
        (AT_4_5, 4118.13, 3891.34, 2),
        (AT_6_5, 4125.93, 3889.02, 2),
        (AT_8, 4133.16, 3888.04, 0),
    ] {
        let naming = identify_lines(&lines(list), SETTLED);
        assert_eq!(naming.bases, Bases::Two { f1, f2 });
        assert_eq!(naming.doubling, doubling, "{:?}", labels(&naming));
        assert!(naming.names.iter().all(Option::is_some));
        assert!((naming.bases.beat().unwrap() - (f1 - f2)).abs() < 1e-9);
        if doubling > 0 {
            let half = 0.5 * (f1 + f2);
            let line = list
                .iter()
                .find(|line| (line.0 - half).abs() < 0.02)
                .unwrap();
            assert_eq!(name_at(&naming, list, line.0), "(f1 + f2)/2");
        }
    }
    let naming = identify_lines(&lines(AT_4_5), SETTLED);
    assert_eq!(name_at(&naming, AT_4_5, 3948.04), "(f1 + 3 f2)/4");
    assert_eq!(name_at(&naming, AT_4_5, 7896.07), "(f1 + 3 f2)/2");
}

#[test]
fn bases_do_not_depend_on_which_combination_is_strongest() {
    // The velocity at 8 degrees: amplitude times frequency, with f1 + f2 above f2.
    for strength in [0.6, 1.0, 1.6] {
        let mut list: Vec<(f64, f64)> = AT_8.iter().map(|(f, a)| (*f, f * a)).collect();
        list[2].1 *= strength;
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        let naming = identify_lines(&lines(&list), SETTLED);
        let expected = Bases::Two {
            f1: 4133.16,
            f2: 3888.04,
        };
        assert_eq!(naming.bases, expected, "{strength}");
        // With an earlier naming f2 keeps its name even if it is weak.
        let mut weak = list.clone();
        weak.iter_mut()
            .filter(|line| line.0 == 3888.04)
            .for_each(|line| line.1 *= 0.1);
        weak.sort_by(|a, b| b.1.total_cmp(&a.1));
        let earlier = Bases::Two {
            f1: 4130.5,
            f2: 3885.7,
        };
        let naming = follow_lines(&lines(&weak), SETTLED, earlier);
        assert_eq!(naming.bases, expected, "{strength}");
    }
}

#[test]
fn a_doubling_keeps_its_name_while_its_lines_grow() {
    let mut list = AT_3_5.to_vec();
    for line in list
        .iter_mut()
        .filter(|line| [3997.46, 7878.08, 3763.79].contains(&line.0))
    {
        line.1 *= 5.0;
    }
    list.sort_by(|a, b| b.1.total_cmp(&a.1));
    let list = lines(&list);
    // Alone, the list is that of a torus with the half-combination as base.
    let alone = identify_lines(&list, SETTLED);
    assert_eq!(
        alone.bases,
        Bases::Two {
            f1: 4114.29,
            f2: 3997.46
        }
    );
    let earlier = Bases::Two {
        f1: 4112.79,
        f2: 3874.08,
    };
    let naming = follow_lines(&list, SETTLED, earlier);
    assert_eq!(
        naming.bases,
        Bases::Two {
            f1: 4114.29,
            f2: 3880.62
        }
    );
    assert_eq!(naming.doubling, 1);
}

/// At the onset of the torus `f1 + f2` is stronger than `f2`, and is the second base until `f2` has grown.
#[test]
fn the_second_base_becomes_the_side_line_next_to_the_first() {
    let onset = Bases::Two {
        f1: 4109.56,
        f2: 7979.31,
    };
    let naming = follow_lines(&lines(AT_2), SETTLED, onset);
    let expected = Bases::Two {
        f1: 4109.56,
        f2: 3869.75,
    };
    assert_eq!(naming.bases, expected);
}

#[test]
fn bases_of_another_motion_are_not_kept() {
    let earlier = Bases::Two {
        f1: 2070.0,
        f2: 12_180.0,
    };
    let list = lines(AT_2);
    let alone = identify_lines(&list, SETTLED);
    assert_eq!(follow_lines(&list, SETTLED, earlier), alone);
}

#[test]
fn a_harmonic_is_no_second_base() {
    // The third harmonic is the strongest line, and a strong line is off all harmonics.
    let list = lines(&[
        (12_335.0, 1.0),
        (4111.66, 0.9),
        (8223.3, 0.5),
        (16_446.6, 0.3),
        (9713.0, 0.2),
    ]);
    let naming = identify_lines(&list, SETTLED);
    let expected = Bases::Two {
        f1: 4111.66,
        f2: 9713.0,
    };
    assert_eq!(naming.bases, expected);
    assert_eq!(labels(&naming), ["3 f1", "f1", "2 f1", "4 f1", "f2"]);
}

/// The named lines of a signal of 0.6 s at 100 kHz.
fn named(tones: &[(f64, f64, f64)]) -> (Vec<String>, LineIdentification) {
    let signal = sines(100e3, 60_000, tones);
    let spectrum = SpectrumAnalyser::new(Window::BlackmanHarris, 100e3)
        .analyse(&signal)
        .unwrap();
    let lines = spectrum.lines(&LineCriterion::default());
    let naming = identify_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin);
    (labels(&naming), naming)
}

#[test]
fn locking_one_to_three_has_one_base_and_near_it_two() {
    let tones = |f1: f64, f2: f64| {
        [
            (f1, 1.0, 0.1),
            (f2, 0.5, 0.7),
            (f1 + f2, 0.1, 1.9),
            (f2 - f1, 0.2, 0.4),
        ]
    };
    let (names, naming) = named(&tones(4111.66, 3.0 * 4111.66));
    assert_eq!(names, ["f1", "3 f1", "2 f1", "4 f1"]);
    assert_eq!(naming.doubling, 0);
    let (names, naming) = named(&tones(4111.66, 3.0 * 4111.66 + 8.0));
    assert_eq!(names, ["f1", "f2", "f2 - f1", "f1 + f2"]);
    assert!((naming.bases.beat().unwrap() - 8.0).abs() < 0.1);
}

#[test]
fn a_weak_second_line_is_named_with_its_combinations() {
    // 50 dB below the first.
    let tones = [
        (4110.0, 1.0, 0.1),
        (3870.3, 3e-3, 0.7),
        (7980.3, 2e-3, 1.9),
        (8220.0, 0.1, 0.2),
    ];
    let (names, naming) = named(&tones);
    assert_eq!(names, ["f1", "2 f1", "f2", "f1 + f2"]);
    assert_eq!(naming.doubling, 0);
}

#[test]
fn a_doubled_torus_has_lines_at_half_combinations() {
    let (f1, f2) = (4110.0, 3870.3);
    let mut tones = vec![
        (f1, 1.0, 0.1),
        (f2, 0.3, 0.7),
        (f1 + f2, 0.1, 1.9),
        (2.0 * f1 - f2, 0.05, 0.3),
    ];
    let (_, naming) = named(&tones);
    assert_eq!(naming.doubling, 0);
    tones.push((0.5 * (f1 + f2), 0.002, 0.2));
    let (names, naming) = named(&tones);
    assert_eq!((names[4].as_str(), naming.doubling), ("(f1 + f2)/2", 1));
    // The halves of one base only.
    tones[4] = (0.5 * f2, 0.002, 0.2);
    let (names, naming) = named(&tones);
    assert_eq!((names[4].as_str(), naming.doubling), ("f2/2", 1));
    // 5 Hz off: no doubling.
    tones[4] = (0.5 * (f1 + f2) + 5.0, 0.002, 0.2);
    let (names, naming) = named(&tones);
    assert_eq!((names[4].as_str(), naming.doubling), ("", 0));
}

#[test]
fn period_doublings_have_halves_and_quarters_of_the_fundamental() {
    let f = 4110.0;
    let mut tones = vec![
        (f, 1.0, 0.1),
        (2.0 * f, 0.3, 0.2),
        (0.5 * f, 0.1, 0.7),
        (1.5 * f, 0.08, 0.9),
    ];
    let (names, naming) = named(&tones);
    assert_eq!(names, ["f1", "2 f1", "f1/2", "3 f1/2"]);
    assert_eq!(naming.doubling, 1);
    tones.extend([(0.25 * f, 0.02, 0.3), (0.75 * f, 0.015, 0.4)]);
    let (names, naming) = named(&tones);
    assert_eq!(names[2..], ["f1/2", "3 f1/2", "f1/4", "3 f1/4"]);
    assert_eq!(naming.doubling, 2);
}

#[test]
fn symmetric_sidebands_are_a_modulation() {
    // Amplitude modulation of 60 % at 240 Hz.
    let am = [(4110.0, 1.0, 0.1), (4350.0, 0.3, 0.2), (3870.0, 0.3, 0.0)];
    let (names, naming) = named(&am);
    let Bases::Modulated { f1, fm } = naming.bases else {
        panic!("{naming:?}")
    };
    assert!((f1 - 4110.0).abs() < 0.01 && (fm - 240.0).abs() < 0.01);
    assert_eq!(names[0], "f1");
    assert!(names.contains(&"f1 + fm".to_owned()) && names.contains(&"f1 - fm".to_owned()));
    assert!((naming.bases.beat().unwrap() - 240.0).abs() < 0.01);
    // With a harmonic and its sidebands.
    let more = [(8220.0, 0.2, 0.3), (8460.0, 0.05, 0.4), (7980.0, 0.05, 0.5)];
    let (names, _) = named(&[&am[..], &more].concat());
    assert!(names.contains(&"2 f1 - fm".to_owned()), "{names:?}");
    // One sideband, or unequal ones, are two tones.
    let (_, one) = named(&am[..2]);
    assert!(matches!(one.bases, Bases::Two { .. }));
    let (_, unequal) = named(&[am[0], am[1], (3870.0, 0.15, 0.0)]);
    assert!(matches!(unequal.bases, Bases::Two { .. }));
}

#[test]
fn random_lines_beside_a_torus_are_rarely_a_doubling() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let trials = 400;
    let mut doubled = 0;
    for _ in 0..trials {
        let mut list = AT_2[..8].to_vec();
        list.extend((0..4).map(|k| {
            (
                rng.random_range(200.0..17_000.0),
                1e-3 - 1e-5 * f64::from(k),
            )
        }));
        doubled += usize::from(identify_lines(&lines(&list), SETTLED).doubling > 0);
    }
    let expected = 2.0 * DOUBLING_SIGNIFICANCE * f64::from(trials);
    assert!(doubled as f64 <= expected, "{doubled} of {trials}");
}
