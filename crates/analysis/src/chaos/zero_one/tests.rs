use proptest::prelude::*;

use super::*;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

/// The logistic map after 1000 steps.
fn logistic(r: f64, n: usize) -> Vec<f64> {
    let mut x = 0.3;
    let mut next = || {
        x = r * x * (1.0 - x);
        x
    };
    (0..1000).for_each(|_| _ = next());
    (0..n).map(|_| next()).collect()
}

fn k(samples: &[f64], stride: usize) -> f64 {
    zero_one(samples, &ZeroOneTest::with_stride(stride))
        .unwrap()
        .k
}

/// `D_c` by the definition.
fn displacement_by_definition(samples: &[f64], c: f64) -> Vec<f64> {
    let path: Vec<Complex<f64>> = translate(samples, c).collect();
    let horizon = samples.len() / HORIZON_DIVISOR;
    let starts = samples.len() - horizon;
    let at = |n: usize| {
        let squares = (0..starts).map(|j| (path[j + n] - path[j]).norm_sqr());
        squares.sum::<f64>() / starts as f64
    };
    (1..=horizon).map(at).collect()
}

#[test]
fn the_recursion_matches_the_definition_of_the_displacement() {
    for (samples, c) in [
        (centred(&logistic(3.97, 1000), 1), 1.1),
        (centred(&logistic(3.55, 777), 1), 2.3),
        // In resonance with the signal: the path is unbounded.
        (centred(&sines(1.0, 1003, &[(0.2, 1.0, 0.3)]), 1), 0.4 * PI),
    ] {
        let got = DisplacementSolver::new(&samples).displacement(c);
        let expected = displacement_by_definition(&samples, c);
        let largest = largest(&expected);
        assert_eq!(got.len(), expected.len());
        for (a, b) in got.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-11 * largest, "{a} {b}");
        }
    }
}

#[test]
fn subtracting_the_mean_first_equals_the_regularised_displacement() {
    // Gottwald and Melbourne keep the mean and subtract V_osc.
    let samples = logistic(3.97, 5000);
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    for c in [0.8, 1.3, 2.1] {
        let kept = displacement_by_definition(&samples, c);
        let oscillation = |n: f64| mean * mean * (1.0 - (n * c).cos()) / (1.0 - c.cos());
        let steps = (1..).map(f64::from);
        let theirs: Vec<f64> = kept
            .iter()
            .zip(steps)
            .map(|(m, n)| m - oscillation(n))
            .collect();
        let ours = displacement_by_definition(&centred(&samples, 1), c);
        let (a, b) = (correlation_with_time(&theirs), correlation_with_time(&ours));
        assert!((a - b).abs() < 0.01, "{a} {b}");
    }
}

#[test]
fn the_logistic_map_gives_the_values_of_the_paper() {
    // Regular at 3.55 (period 8), chaotic at 3.97.
    for n in [1000, 2000, 5000] {
        let (regular, chaotic) = (k(&logistic(3.55, n), 1), k(&logistic(3.97, n), 1));
        assert!(regular.abs() < 0.05, "{n}: {regular}");
        assert!(chaotic > 0.99, "{n}: {chaotic}");
    }
}

#[test]
fn the_result_does_not_depend_on_scale() {
    let signal = logistic(3.97, 1000);
    for power in [-400, -300, 300, 400] {
        let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(power)).collect();
        assert!((k(&scaled, 1) - k(&signal, 1)).abs() < 1e-12, "2^{power}");
    }
}

#[test]
fn tones_give_0_and_noise_gives_1() {
    let golden = 0.0713 * 1.618_034;
    let one = sines(1.0, 5000, &[(0.0713, 1.0, 0.2)]);
    let two = sines(1.0, 5000, &[(0.0713, 1.0, 0.2), (golden, 0.7, 0.0)]);
    assert!(k(&one, 1).abs() < 0.05);
    assert!(k(&two, 1).abs() < 0.05);
    assert!(k(&noise(3, 5000, 1.0), 1) > 0.99);
}

#[test]
fn a_flow_needs_subsampling_to_show_chaos() {
    // Lorenz: 0.02 with every sample, 0.997 with every 11th. Roessler rotates at a nearly constant rate
    // and is weakly chaotic: 0.86 with every 5th.
    let flow = coordinate(&lorenz(20_000, 0.01, [1.0, 1.0, 1.0]), 0);
    let stride = ZeroOneTest::recommended_stride(&flow);
    assert!((10..=12).contains(&stride), "{stride}");
    assert!(k(&flow, stride) > 0.99);
    assert!(k(&flow, 16) > 0.99);
    assert!(k(&flow, 1) < 0.1);
    let flow = coordinate(&roessler(20_000, 0.1, [0.2, 0.2, 5.7], [1.0, 1.0, 0.0]), 0);
    assert!(k(&flow, ZeroOneTest::recommended_stride(&flow)) > 0.8);
}

#[test]
fn the_recommended_stride_follows_the_range_over_the_mean_step() {
    // A sine of period T: |sin| has the mean 2 / pi, hence pi / (2 sin(pi s / T)) = 10 at s = T / 20.
    let sine = sines(1000.0, 20_000, &[(1.0, 1.0, 0.0)]);
    let stride = ZeroOneTest::recommended_stride(&sine);
    assert!((49..=52).contains(&stride), "{stride}");
    // Too slow: the stride leaves the minimum number of samples.
    let slow = sines(1000.0, 20_000, &[(0.1, 1.0, 0.0)]);
    assert_eq!(ZeroOneTest::recommended_stride(&slow), 200);
    assert_eq!(ZeroOneTest::recommended_stride(&noise(1, 5000, 1.0)), 1);
    assert_eq!(ZeroOneTest::recommended_stride(&[3.0; 500]), 1);
    assert_eq!(ZeroOneTest::recommended_stride(&[]), 1);
}

#[test]
fn constant_signals_give_exactly_0() {
    for level in [0.0, 0.1, -7e9] {
        let still = zero_one(&[level; 300], &ZeroOneTest::with_stride(1)).unwrap();
        assert_eq!(still.k, 0.0);
        assert!(still.path.iter().all(|z| *z == [0.0; 2]));
    }
    // Sampled once per period, a sine leaves only rounding errors.
    let sine = sines(50.0, 20_000, &[(1.0, 1.0, 0.3)]);
    assert_eq!(k(&sine, 50), 0.0);
}

#[test]
fn the_result_contains_median_path_and_frequencies() {
    let test = ZeroOneTest {
        stride: 3,
        frequencies: 20,
        seed: 7,
    };
    let signal = logistic(3.97, 1000);
    let result = zero_one(&signal, &test).unwrap();
    assert_eq!((result.samples, result.path.len()), (334, 334));
    assert_eq!(result.by_frequency.len(), 20);
    let range = PI / 5.0..4.0 * PI / 5.0;
    assert!(result.by_frequency.iter().all(|[c, _]| range.contains(c)));
    let mut k: Vec<f64> = result.by_frequency.iter().map(|[_, k]| *k).collect();
    k.sort_by(f64::total_cmp);
    assert_eq!(result.k, 0.5 * (k[9] + k[10]));
    let at_median = result.by_frequency.iter().find(|[_, of]| *of == k[9]);
    let taken = centred(&signal, 3);
    let path = translate(&taken, at_median.unwrap()[0]);
    assert!(result.path.iter().copied().eq(path.map(|z| [z.re, z.im])));
    assert_ne!(
        result,
        zero_one(&signal, &ZeroOneTest { seed: 8, ..test }).unwrap()
    );
}

#[test]
fn invalid_tests_are_rejected() {
    let test = ZeroOneTest::with_stride(5);
    let rejection = |samples: &[f64], test| zero_one(samples, &test).unwrap_err();
    assert_eq!(
        rejection(&[0.0; 495], test),
        AnalysisError::TooShort {
            what: "0-1 test",
            have: 495,
            need: 496
        }
    );
    assert!(zero_one(&[0.0; 496], &test).is_ok());
    assert!(matches!(
        rejection(&[0.0; 500], ZeroOneTest::with_stride(1 << 63)),
        AnalysisError::TooShort { .. }
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn unit_and_offset_of_the_signal_do_not_matter(
        r in 3.5..4.0,
        scale in -1e3..1e3_f64,
        offset in -1e3..1e3_f64,
    ) {
        prop_assume!(scale.abs() > 1e-2);
        let signal = logistic(r, 300);
        let other: Vec<f64> = signal.iter().map(|x| scale * x + offset).collect();
        let (a, b) = (k(&signal, 1), k(&other, 1));
        prop_assert!((-1.0..=1.0).contains(&a));
        prop_assert!((a - b).abs() < 1e-6, "{} {}", a, b);
    }
}
