use super::shape::{Clusters, Tree};
use super::*;
use crate::stats::range;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Crossings of the plane `normal . x = offset` by the trajectory with these channels.
fn plane_section(
    channels: &[&[f64]],
    normal: &[f64],
    offset: f64,
    direction: Direction,
) -> Vec<Crossing> {
    let height = |i: usize| channels.iter().zip(normal).map(|(x, n)| x[i] * n).sum();
    let height: Vec<f64> = (0..channels[0].len()).map(height).collect();
    let channels = [&[&height[..]], channels].concat();
    let mut finder = SectionFinder::first_of(channels.len(), offset, direction);
    let mut crossings = Vec::new();
    finder.push(&channels, |crossing| crossings.push(crossing));
    finder.finish(|crossing| crossings.push(crossing));
    crossings
        .iter_mut()
        .for_each(|crossing| _ = crossing.point.remove(0));
    crossings
}

fn clusters(points: &[&[f64]], size: f64) -> Option<Clusters> {
    Tree::new(points).clusters(points, size)
}

/// Crossings of a level by one channel.
fn level(signal: &[f64], level: f64, direction: Direction) -> Vec<Crossing> {
    plane_section(&[signal], &[1.0], level, direction)
}

/// Instants and directions.
fn instants(signal: &[f64], direction: Direction) -> Vec<(f64, bool)> {
    let all = level(signal, 0.0, direction);
    all.iter().map(|c| (c.sample, c.rising)).collect()
}

/// Shape of the delay section through the mean, without the first and last crossing.
fn shape(signal: &[f64], lag: usize) -> SectionShape {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let crossings = delay_section(signal, lag, 3, mean, Direction::Rising).unwrap();
    let points: Vec<&[f64]> = crossings.iter().map(|c| c.point.as_slice()).collect();
    section_shape(&points[1..points.len() - 1], size(signal))
}

fn size(signal: &[f64]) -> f64 {
    let [low, high] = range(signal.iter().copied());
    high - low
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// Roessler's x with a = b = 0.2, 20 samples per time unit, 117 per period.
fn roessler_x(c: f64, n: usize) -> Vec<f64> {
    coordinate(&roessler(n, 0.05, [0.2, 0.2, c], [1.0, 1.0, 0.0]), 0)
}

#[test]
fn instants_of_a_sine_have_an_error_below_1e_9() {
    // Crossings at a share of the amplitude. The limits are twice the measured error, plus the rounding
    // of instants in the thousands.
    for (period, share, limit) in [
        (16.1234, 0.9, 2.4e-10),
        (16.1234, 0.5, 7e-11),
        (16.1234, 0.0, 1e-11),
        (24.7, 0.9, 4e-12),
        (50.3, 0.9, 2e-12),
        (200.9, 0.9, 2e-12),
        (200.9, -0.3, 2e-12),
    ] {
        let signal: Vec<f64> = (0..4000)
            .map(|i| 3.0 * (TAU * f64::from(i) / period).sin())
            .collect();
        let first = f64::asin(share) / TAU;
        let found = level(&signal, 3.0 * share, Direction::Rising);
        assert!(found.len() as f64 >= 3999.0 / period - 1.0);
        let inner = |c: &&Crossing| (6.0..3993.0).contains(&c.sample);
        for crossing in found.iter().filter(inner) {
            let cycle = (crossing.sample / period - first).round();
            let error = crossing.sample - (cycle + first) * period;
            assert!(error.abs() < limit, "{period} {share}: {error:e}");
            assert!((crossing.point[0] - 3.0 * share).abs() < 1e-11);
        }
    }
}

#[test]
fn points_match_the_trajectory_at_the_instant() {
    // A smooth closed form in three channels, through an oblique plane.
    let at = |t: f64| {
        let x = (0.11 * t).sin();
        [
            x,
            (0.11 * t + 0.4).cos() + 0.3 * (0.047 * t).sin(),
            (x * x + 0.02 * t).exp() / 50.0,
        ]
    };
    let states: Vec<[f64; 3]> = (0..300).map(|i| at(f64::from(i))).collect();
    let channels: [Vec<f64>; 3] = std::array::from_fn(|c| coordinate(&states, c));
    let normal = [1.0, -2.0, 0.25];
    let views: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    let found = plane_section(&views, &normal, 0.2, Direction::Both);
    assert!(found.len() > 8);
    for crossing in found.iter().filter(|c| (6.0..293.0).contains(&c.sample)) {
        let exact = at(crossing.sample);
        let g = |x: &[f64]| x.iter().zip(normal).map(|(x, n)| x * n).sum::<f64>() - 0.2;
        assert!(g(&exact).abs() < 1e-9 && g(&crossing.point).abs() < 1e-9);
        for (found, exact) in crossing.point.iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < 1e-9, "{found} {exact}");
        }
    }
}

#[test]
fn crossings_follow_the_definition() {
    use Direction::{Both, Falling, Rising};
    // Two straight lines, for which every polynomial through either is exact; at the ends linear.
    assert_eq!(
        instants(&[-1.0, 3.0, -1.0], Both),
        [(0.25, true), (1.75, false)]
    );
    assert_eq!(instants(&[-1.0, 3.0, -1.0], Rising), [(0.25, true)]);
    assert_eq!(instants(&[-1.0, 3.0, -1.0], Falling), [(1.75, false)]);
    // Through a sample: one crossing. A touch is none. Samples in the plane: crossing on arrival.
    assert_eq!(instants(&[-1.0, 0.0, 2.0], Both), [(1.0, true)]);
    assert_eq!(instants(&[1.0, 0.0, 2.0, 0.0, 0.0, 1.0], Both), []);
    assert_eq!(instants(&[2.0, 0.0, 0.0, 0.0, -1.0], Both), [(1.0, false)]);
    assert_eq!(instants(&[2.0, 0.0, 0.0, 0.0, -1.0], Rising), []);
    // Records that start or end in the plane have no crossing there.
    assert_eq!(instants(&[0.0, 0.0, 1.0, 0.0], Both), []);
    assert_eq!(instants(&[0.0; 50], Both), []);
    assert_eq!(instants(&[4.0], Both), []);
    assert_eq!(instants(&[], Both), []);
}

#[test]
fn samples_very_close_to_the_plane_are_valid() {
    for near in [1e-17, 1e-30, 1e-310] {
        let mut signal = noise(1, 40, 1.0);
        (signal[19], signal[20], signal[21]) = (-1.0, -near, 0.5);
        let found = level(&signal, 0.0, Direction::Rising);
        let passage = found.iter().find(|c| (19.5..20.5).contains(&c.sample));
        let passage = passage.unwrap_or_else(|| panic!("{near:e}: {found:?}"));
        assert!((passage.sample - 20.0).abs() < 1e-11 && passage.point[0].abs() < 1e-11);
    }
}

#[test]
fn noise_affects_the_instant_little_more_than_with_linear_interpolation() {
    let (period, n) = (50.1, 200_000);
    let clean = sines(1.0, n, &[(1.0 / period, 1.0, 0.3)]);
    let signal = sum(&clean, &noise(1, n, 1e-2));
    let (mut curved, mut straight) = (0.0, 0.0);
    for crossing in level(&signal, 0.0, Direction::Rising) {
        let cycle = (crossing.sample / period + 0.3 / TAU).round();
        let exact = (cycle - 0.3 / TAU) * period;
        let i = crossing.sample as usize;
        let line = i as f64 + signal[i] / (signal[i] - signal[i + 1]);
        curved += (crossing.sample - exact).powi(2);
        straight += (line - exact).powi(2);
    }
    let ratio = (curved / straight).sqrt();
    assert!((1.0..1.25).contains(&ratio), "{ratio}");
}

#[test]
fn the_delay_section_equals_a_plane_section_of_the_delay_trajectory() {
    let signal = sines(1.0, 900, &[(0.021, 1.0, 0.0), (0.0131, 0.4, 1.0)]);
    let found = delay_section(&signal, 12, 4, 0.1, Direction::Falling).unwrap();
    let shifted: Vec<&[f64]> = (0..4).map(|c| &signal[12 * c..][..900 - 36]).collect();
    let plane = plane_section(&shifted, &[0.0, 1.0, 0.0, 0.0], 0.1, Direction::Falling);
    assert_eq!(found, plane);
    assert!(found.len() > 15 && found.iter().all(|c| !c.rising));
}

#[test]
fn invalid_sections_are_rejected() {
    let y = [0.0, 1.0, 0.0, 1.0];
    let delay =
        |lag, dimension| delay_section(&y, lag, dimension, 0.0, Direction::Both).unwrap_err();
    assert_eq!(
        delay(0, 2),
        AnalysisError::InvalidDelay {
            lag: 0,
            dimension: 2
        }
    );
    assert_eq!(
        delay(1, 1),
        AnalysisError::InvalidDelay {
            lag: 1,
            dimension: 1
        }
    );
    assert!(matches!(delay(1 << 63, 3), AnalysisError::TooShort { .. }));
    assert!(matches!(
        delay(4, 2),
        AnalysisError::TooShort {
            have: 4,
            need: 5,
            ..
        }
    ));
}

#[test]
fn subnormal_samples_are_crossed_between_their_neighbours() {
    // Multiples of the smallest number: their products underflow.
    let tiny = |x: f64| 5e-324 * (1000.0 * x).round();
    let y: Vec<f64> = sines(1.0, 20_000, &[(0.034, 1.0, 0.0)])
        .iter()
        .zip(noise(1, 20_000, 0.05))
        .map(|(a, b)| tiny(a + b))
        .collect();
    let crossings = plane_section(&[&y], &[1.0], 0.0, Direction::Both);
    assert!(crossings.len() > 1000);
    for crossing in crossings {
        let left = crossing.sample.floor() as usize;
        let rising = y[left] < 0.0 || y[left + 1] > 0.0;
        assert_eq!(rising, crossing.rising, "{crossing:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Few different values, which puts many samples in the plane.
    #[test]
    fn block_sizes_do_not_change_the_crossings(
        steps in prop::collection::vec(-2..=2_i32, 0..300),
        blocks in prop::collection::vec(0..40_usize, 1..20),
    ) {
        let y: Vec<f64> = steps.iter().map(|&s| f64::from(s)).collect();
        let z: Vec<f64> = y.iter().rev().copied().collect();
        let mut whole = Vec::new();
        let mut finder = SectionFinder::first_of(2, 0.0, Direction::Both);
        finder.push(&[&y, &z], |c| whole.push(c));
        finder.finish(|c| whole.push(c));
        let mut finder = SectionFinder::first_of(2, 0.0, Direction::Both);
        let mut found = Vec::new();
        let (mut at, mut lengths) = (0, blocks.iter().cycle());
        while at < y.len() {
            let end = y.len().min(at + lengths.next().unwrap().max(&1));
            finder.push(&[&y[at..end], &z[at..end]], |c| found.push(c));
            at = end;
        }
        finder.finish(|c| found.push(c));
        prop_assert_eq!(&found, &whole);
        // Rising and falling crossings alternate.
        let alternate = whole.windows(2).all(|pair| pair[0].rising != pair[1].rising);
        prop_assert!(alternate);
        prop_assert!(whole.windows(2).all(|pair| pair[0].sample < pair[1].sample));
    }
}

#[test]
fn a_long_stream_matches_the_batch_computation() {
    let signal = noise(5, 20_000, 1.0);
    let whole = delay_section(&signal, 7, 3, 0.2, Direction::Rising).unwrap();
    let mut finder = SectionFinder::delay(7, 3, 0.2, Direction::Rising);
    let mut found = Vec::new();
    for (newest, block) in signal.chunks(1).enumerate() {
        finder.push(&[block], |c| found.push(c));
        // A crossing is reported 7 samples plus the largest delay after it.
        assert!(
            found
                .last()
                .is_none_or(|c: &Crossing| c.sample + 7.0 + 14.0 <= newest as f64 + 1.0)
        );
    }
    finder.finish(|c| found.push(c));
    assert_eq!(found, whole);
}

#[test]
fn a_return_map_pairs_each_value_with_the_next() {
    assert_eq!(return_map(&[1.0, 2.0, 5.0]), [[1.0, 2.0], [2.0, 5.0]]);
    assert!(return_map(&[1.0]).is_empty() && return_map(&[]).is_empty());
}

#[test]
fn clusters_are_numbered_by_first_appearance() {
    let points = [
        [5.0],
        [0.01],
        [5.01],
        [0.0],
        [9.0],
        [5.02],
        [0.02],
        [9.01],
        [9.0],
    ];
    let views: Vec<&[f64]> = points.iter().map(|p| p.as_slice()).collect();
    let found = clusters(&views, 9.0).unwrap();
    assert_eq!(found.member, [0, 1, 0, 1, 2, 0, 1, 2, 2]);
    assert_eq!(found.count, 3);
    // If the trajectory is hardly larger than a cluster, the clusters are not points.
    assert_eq!(clusters(&views[..4], 0.1), None);
    assert_eq!(clusters(&[], 1.0), None);
    let same = clusters(&[[1.0, 2.0].as_slice(); 10], 0.0);
    assert_eq!(same.unwrap().count, 1);
}

#[test]
fn period_doublings_are_counted() {
    for (c, period) in [(2.5, 1), (3.5, 2), (4.0, 4), (4.18, 8)] {
        for n in [8_000, 16_000] {
            let found = shape(&roessler_x(c, n), 29);
            assert_eq!(found, SectionShape::Points(period), "{c} {n}");
        }
        // The clusters are visited in cyclic order.
        let x = roessler_x(c, 8_000);
        let crossings = delay_section(&x, 29, 3, 0.0, Direction::Rising).unwrap();
        let points: Vec<&[f64]> = crossings[1..].iter().map(|c| c.point.as_slice()).collect();
        let found = clusters(&points, size(&x)).unwrap();
        assert_eq!(found.count, period);
        assert!(
            found
                .member
                .iter()
                .enumerate()
                .all(|(k, &m)| m == k % period)
        );
    }
}

#[test]
fn tones_give_points_and_tori_give_loops() {
    for deviation in [0.0, 1e-3, 1e-2] {
        let floor = noise(3, 8000, deviation);
        let harmonics = sines(50.0, 8000, &[(1.0, 1.0, 0.1), (2.0, 0.3, 0.7)]);
        assert_eq!(shape(&sum(&harmonics, &floor), 12), SectionShape::Points(1));
        for (second, amplitude) in [(0.2618, 0.3), (0.618, 0.6), (1.618, 0.3)] {
            let torus = sines(50.0, 8000, &[(1.0, 1.0, 0.1), (second, amplitude, 0.7)]);
            let found = shape(&sum(&torus, &floor), 12);
            assert_eq!(found, SectionShape::Loop, "{second} {deviation}");
        }
    }
    // Without noise, even a second tone this weak gives a loop.
    let faint = sines(50.0, 8000, &[(1.0, 1.0, 0.1), (0.618, 0.01, 0.7)]);
    assert_eq!(shape(&faint, 12), SectionShape::Loop);
}

#[test]
fn chaos_gives_arcs_and_noise_a_cloud() {
    for c in [4.25, 4.5, 5.0, 5.7] {
        assert_eq!(shape(&roessler_x(c, 12_000), 29), SectionShape::Arc, "{c}");
    }
    let x = coordinate(&lorenz(12_000, 0.02, [1.0, 1.0, 1.0]), 0);
    assert_eq!(shape(&x, 8), SectionShape::Arc);
    for seed in 1..4 {
        assert_eq!(shape(&noise(seed, 3000, 1.0), 3), SectionShape::Cloud);
    }
    assert_eq!(shape(&noise(1, 80, 1.0), 3), SectionShape::TooFew);
}

#[test]
fn the_shape_does_not_depend_on_scale_or_order() {
    let x = roessler_x(5.0, 8_000);
    let scaled: Vec<f64> = x.iter().map(|x| x * 2.0_f64.powi(-30)).collect();
    assert_eq!(shape(&scaled, 29), shape(&x, 29));
    let torus = sines(50.0, 8000, &[(1.0, 1.0, 0.1), (0.618, 0.6, 0.7)]);
    let crossings = delay_section(&torus, 12, 3, 0.0, Direction::Rising).unwrap();
    let mut points: Vec<&[f64]> = crossings[1..].iter().map(|c| c.point.as_slice()).collect();
    points.sort_by(|a, b| a[2].total_cmp(&b[2]));
    assert_eq!(section_shape(&points, 3.0), SectionShape::Loop);
}
