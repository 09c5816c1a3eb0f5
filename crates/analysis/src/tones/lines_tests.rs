//! Identification of lines: published lists, lists from scenes, and random lines.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A tenth of a 50 Hz bin.
const UNCERTAINTY: f64 = 5.0;

pub(super) fn lines(list: &[(f64, f64)]) -> Vec<Line> {
    let line = |&(frequency, amplitude)| Line {
        frequency,
        amplitude,
    };
    list.iter().map(line).collect()
}

pub(super) fn labels(naming: &LineIdentification) -> Vec<String> {
    let symbols = naming.bases.symbols();
    let label = |name: &Option<Combination>| name.map_or(String::new(), |c| c.text(symbols));
    naming.names.iter().map(label).collect()
}

#[test]
fn a_single_line_is_the_fundamental() {
    let naming = identify_lines(&lines(&[(4100.0, 1.0)]), UNCERTAINTY);
    assert_eq!(naming.bases, Bases::One { f1: 4100.0 });
    assert_eq!(labels(&naming), ["f1"]);
    assert_eq!(naming.bases.beat(), None);
}

#[test]
fn harmonics_of_the_limit_cycle_are_identified() {
    // 2 degrees, azimuth 0: 4.117 kHz, 12.33 kHz at 0.13, 8.22 kHz at 0.05.
    let list = lines(&[(4117.0, 1.0), (12_351.5, 0.13), (8233.0, 0.05)]);
    let naming = identify_lines(&list, UNCERTAINTY);
    assert_eq!(labels(&naming), ["f1", "3 f1", "2 f1"]);
}

#[test]
fn a_weak_fundamental_below_the_strongest_line_is_found() {
    // The locked 1:2 tone: 2.07 kHz, weaker than its octave.
    let list = lines(&[(4140.0, 1.0), (2070.0, 0.4), (6210.0, 0.1), (8280.0, 0.05)]);
    let naming = identify_lines(&list, UNCERTAINTY);
    assert_eq!(naming.bases, Bases::One { f1: 2070.0 });
    assert_eq!(labels(&naming), ["2 f1", "f1", "3 f1", "4 f1"]);
}

#[test]
fn combinations_of_the_natural_set_are_identified() {
    let list = lines(&[(4110.0, 15.0), (3870.0, 4.0), (12_331.0, 2.0), (241.0, 0.1)]);
    let naming = identify_lines(&list, UNCERTAINTY);
    assert_eq!(labels(&naming), ["f1", "f2", "3 f1", "f1 - f2"]);
    assert!((naming.bases.beat().unwrap() - 240.0).abs() < 1e-9);
}

#[test]
fn combinations_of_the_paper_are_identified() {
    // Fig. 6: 0.57 = f2 - 3 f1 of 3.87 and 12.18 kHz, and further combinations.
    let list = lines(&[
        (3870.0, 1.0),
        (12_180.0, 0.8),
        (570.0, 0.2),
        (4440.0, 0.1),
        (11_610.0, 0.05),
    ]);
    let naming = identify_lines(&list, UNCERTAINTY);
    assert_eq!(
        labels(&naming),
        ["f1", "f2", "f2 - 3 f1", "f2 - 2 f1", "3 f1"]
    );
    assert!(naming.p_value < SIGNIFICANCE, "{}", naming.p_value);
    assert!((naming.bases.beat().unwrap() - 570.0).abs() < 1e-9);
}

#[test]
fn a_strong_second_tone_without_combinations_is_a_base() {
    let naming = identify_lines(&lines(&[(4100.0, 1.0), (12_900.0, 0.5)]), UNCERTAINTY);
    assert_eq!(labels(&naming), ["f1", "f2"]);
    assert_eq!(naming.p_value, 1.0);
}

#[test]
fn a_weak_unrelated_line_gets_no_name() {
    let list = lines(&[
        (4100.0, 1.0),
        (8200.0, 0.3),
        (12_300.0, 0.1),
        (9713.0, 0.002),
    ]);
    let naming = identify_lines(&list, UNCERTAINTY);
    assert_eq!(labels(&naming), ["f1", "2 f1", "3 f1", ""]);
}

#[test]
fn a_line_outside_the_uncertainty_is_not_named() {
    // The tolerance of 3 f1 is 5 sqrt(10) = 15.8 Hz.
    for (miss, label) in [(15.0, "3 f1"), (17.0, "")] {
        let list = lines(&[
            (4100.0, 1.0),
            (8200.0, 0.5),
            (16_400.0, 0.3),
            (12_300.0 + miss, 0.02),
        ]);
        assert_eq!(labels(&identify_lines(&list, UNCERTAINTY))[3], label);
    }
}

/// A quarter of a bin of a 20 ms window, as in the pipeline.
const QUARTER_BIN: f64 = 12.5;

#[test]
fn the_scene_periodic_2deg_has_one_base() {
    // 20 ms, settled; amplitudes in mm/s.
    let list = lines(&[
        (4110.8, 15.776),
        (12_332.5, 5.857),
        (8221.7, 1.435),
        (16_443.3, 0.9702),
        (20_554.2, 0.5379),
        (24_665.0, 0.1653),
        (32_886.6, 0.1222),
        (36_997.5, 0.0990),
        (41_108.3, 0.0613),
        (28_775.8, 0.0609),
        (45_219.1, 0.0327),
        (57_551.6, 0.0264),
    ]);
    let orders = [1, 3, 2, 4, 5, 6, 8, 9, 10, 7, 11, 14];
    let expected = orders.map(|n| Combination::new(n, 0).text(["f1", "f2"]));
    for uncertainty in [1.0, UNCERTAINTY, QUARTER_BIN] {
        assert_eq!(labels(&identify_lines(&list, uncertainty)), expected);
    }
}

#[test]
fn growing_modes_have_no_pattern() {
    // The same scene after 10 ms: four natural frequencies.
    let list = lines(&[
        (4097.3, 1.0388),
        (7539.5, 1.0375),
        (1743.4, 0.1237),
        (12_444.2, 0.1105),
    ]);
    let naming = identify_lines(&list, 2.0 * QUARTER_BIN);
    assert_eq!(naming.bases, Bases::None);
}

#[test]
fn names_of_the_scene_torus_3deg_are_stable() {
    // 20 ms at 145 ms and at 150 ms. In the second list the sums differ from the lines by up to 7 Hz.
    let earlier = [
        (4112.6, 15.9284),
        (12_338.7, 6.0999),
        (7988.0, 2.5355),
        (3872.6, 2.3190),
        (12_100.1, 1.4222),
        (16_451.5, 1.0878),
        (8227.6, 1.0495),
        (12_579.1, 1.0079),
        (7750.2, 0.6414),
        (20_564.0, 0.4875),
        (4590.4, 0.3416),
        (24_441.2, 0.2272),
    ];
    let later = [
        (4113.3, 15.8812),
        (12_338.7, 6.1369),
        (7986.5, 2.6084),
        (3876.3, 2.4304),
        (12_100.0, 1.4497),
        (16_451.7, 1.0830),
        (8224.9, 1.0664),
        (7755.3, 0.6759),
        (20_565.3, 0.4813),
        (4587.8, 0.3569),
        (24_437.5, 0.2336),
        (16_204.6, 0.2050),
    ];
    let common = ["f1", "3 f1", "f1 + f2", "f2", "2 f1 + f2", "4 f1", "2 f1"];
    let named = |list| labels(&identify_lines(&lines(list), QUARTER_BIN));
    let (earlier, later) = (named(&earlier), named(&later));
    assert_eq!(earlier[..7], common);
    assert_eq!(later[..7], common);
    let rest = ["4 f1 - f2", "2 f2", "5 f1", "3 f1 - 2 f2", "5 f1 + f2"];
    assert_eq!(earlier[7..], rest);
    let rest = ["2 f2", "5 f1", "3 f1 - 2 f2", "5 f1 + f2", "3 f1 + f2"];
    assert_eq!(later[7..], rest);
}

#[test]
fn names_of_the_scene_chaos_5deg_are_stable() {
    // 20 ms at 35 ms and at 45 ms, the strongest lines. f1 + f2 differs from its line by 10 and by
    // 20 Hz.
    let earlier = [
        (4120.2, 15.7631),
        (12_359.6, 5.8589),
        (7996.3, 3.2460),
        (3885.7, 3.0009),
        (12_125.1, 2.1305),
        (12_594.6, 1.1174),
    ];
    let later = [
        (4121.2, 15.3612),
        (12_359.3, 6.0820),
        (8007.6, 2.9609),
        (3906.5, 3.0996),
        (12_142.6, 2.0726),
        (12_575.4, 1.2702),
    ];
    for list in [earlier, later] {
        let names = labels(&identify_lines(&lines(&list), QUARTER_BIN));
        let expected = ["f1", "3 f1", "f1 + f2", "f2", "2 f1 + f2", "4 f1 - f2"];
        assert_eq!(names, expected);
    }
}

#[test]
fn a_weak_second_tone_keeps_its_name() {
    // The joint of tilt-ramp at the onset of the torus: f1 + f2 is stronger than f2.
    let list = lines(&[
        (4105.7, 16.3691),
        (12_316.8, 6.0429),
        (8213.6, 1.4425),
        (16_422.6, 1.2332),
        (20_528.9, 0.6500),
        (7965.5, 0.3556),
        (3858.5, 0.3091),
        (12_072.3, 0.1815),
        (24_636.6, 0.1687),
        (32_844.3, 0.1494),
    ]);
    let names = labels(&identify_lines(&list, UNCERTAINTY));
    assert_eq!(names[..5], ["f1", "3 f1", "2 f1", "4 f1", "5 f1"]);
    assert_eq!(names[5..], ["f1 + f2", "f2", "2 f1 + f2", "6 f1", "8 f1"]);
}

#[test]
fn random_lines_are_rarely_accepted() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let trials = 400;
    let mut accepted = 0;
    for _ in 0..trials {
        let list: Vec<(f64, f64)> = (0..8)
            .map(|_| (rng.random_range(200.0..13_000.0), 1.0))
            .collect();
        if identify_lines(&lines(&list), UNCERTAINTY).bases != Bases::None {
            accepted += 1;
        }
    }
    assert!(
        f64::from(accepted) <= SIGNIFICANCE * f64::from(trials),
        "{accepted} of {trials}"
    );
}

#[test]
fn the_misfit_is_the_deviation_from_the_name() {
    let list = lines(&[(4100.0, 1.0), (8203.0, 0.5), (9713.0, 0.002)]);
    let naming = identify_lines(&list, UNCERTAINTY);
    let misfits: Vec<_> = (0..3).map(|i| naming.misfit(i, list[i])).collect();
    assert_eq!(misfits, [Some(0.0), Some(3.0), None]);
}

#[test]
fn an_empty_list_has_no_names() {
    let naming = identify_lines(&[], UNCERTAINTY);
    assert_eq!(naming.bases, Bases::None);
    assert!(naming.names.is_empty());
}

#[test]
fn the_tail_matches_fishers_method() {
    assert_eq!(fisher_tail(0.0, 0), 1.0);
    assert_eq!(fisher_tail(0.0, 5), 1.0);
    assert!((fisher_tail(3.0, 1) - (-3.0_f64).exp()).abs() < 1e-16);
    // Two tests at 5 % each: 0.0025 (1 - ln 0.0025).
    let sum = -2.0 * 0.05_f64.ln();
    assert!((fisher_tail(sum, 2) - 0.0025 * (1.0 - 0.0025_f64.ln())).abs() < 1e-15);
}
