use super::*;
use crate::test_signals::{noise, sines};

fn image(
    vectors: &DelayVectors<'_>,
    indices: &[usize],
    norm: Norm,
    threshold: Threshold,
) -> RecurrenceImage {
    let criterion = RecurrenceCriterion {
        norm,
        threshold,
        theiler: 1,
    };
    RecurrenceImage::new(vectors, indices, &criterion, 1.0, 1e-3).unwrap()
}

/// The Euclidean image of all states.
fn of(signal: &[f64], lag: usize, dimension: usize, threshold: Threshold) -> RecurrenceImage {
    let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
    let indices: Vec<usize> = (0..vectors.len()).collect();
    image(&vectors, &indices, Norm::Euclidean, threshold)
}

#[test]
fn images_match_the_definition() {
    let signal = noise(1, 90, 1e-7);
    let vectors = DelayVectors::new(&signal, 5, 4).unwrap();
    let indices: Vec<usize> = (0..vectors.len()).step_by(3).collect();
    let n = indices.len();
    assert_eq!(n, 25);
    let distance = |i: usize, j: usize| {
        let pairs = vectors.vector(indices[i]).zip(vectors.vector(indices[j]));
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    let direct: Vec<f64> = (0..n * n).map(|p| distance(p / n, p % n)).collect();
    let largest = direct.iter().copied().fold(0.0, f64::max);
    // At a threshold between two distances the image is exactly Eq. (26).
    let mut sorted = direct.clone();
    sorted.sort_by(f64::total_cmp);
    let epsilon = 0.5 * (sorted[200] + sorted[202]);
    let image = image(
        &vectors,
        &indices,
        Norm::Euclidean,
        Threshold::Distance(epsilon),
    );
    assert_eq!((image.size, image.dimension, image.lag), (n, 4, 5e-3));
    for ((shade, pixel), d) in image.distance.iter().zip(&image.recurrent).zip(&direct) {
        assert!((f64::from(*shade) - 255.0 * d / largest).abs() <= 0.5 + 1e-3);
        assert_eq!(*pixel == 255, *d <= epsilon);
    }
}

#[test]
fn the_rate_is_within_one_pair_of_the_target() {
    let signal = noise(2, 300, 1.0);
    for asked in [0.0, 1e-4, 0.01, 0.05, 0.3, 0.99, 1.0] {
        let image = of(&signal, 7, 5, Threshold::Rate(asked));
        let one_pair = 2.0 / (image.size * (image.size - 1)) as f64;
        assert!((image.rate - asked).abs() <= one_pair, "{asked}");
        let recurrent = image.recurrent.iter().filter(|&&p| p == 255).count();
        let off_identity = (recurrent - image.size) as f64 / 2.0;
        assert!((off_identity * one_pair - image.rate).abs() < 1e-12);
    }
}

#[test]
fn images_are_symmetric_with_a_full_line_of_identity() {
    let image = of(&noise(3, 200, 1.0), 3, 3, Threshold::Rate(0.1));
    let (n, distance, recurrent) = (image.size, image.distance, image.recurrent);
    for i in 0..n {
        assert_eq!(distance[i * n + i], 0);
        assert_eq!(recurrent[i * n + i], 255);
        for j in 0..n {
            assert_eq!(distance[i * n + j], distance[j * n + i]);
            assert_eq!(recurrent[i * n + j], recurrent[j * n + i]);
        }
    }
    assert_eq!(distance.iter().max(), Some(&255));
}

#[test]
fn a_sine_gives_diagonals_a_period_apart() {
    // 50 samples per period and a lag of a quarter period: the delay vectors lie on a circle.
    let signal = sines(50.0, 425, &[(1.0, 1.0, 0.4)]);
    let image = of(&signal, 12, 2, Threshold::Rate(0.05));
    let n = image.size;
    for offset in 0..n - 50 {
        let diagonal = (0..n - offset).map(|i| image.recurrent[i * n + i + offset]);
        let share = diagonal.filter(|&p| p == 255).count() as f64 / (n - offset) as f64;
        match offset % 50 {
            0 => assert_eq!(share, 1.0, "diagonal {offset}"),
            5..=45 => assert_eq!(share, 0.0, "diagonal {offset}"),
            _ => {}
        }
    }
}

#[test]
fn the_scale_of_the_signal_does_not_change_the_images() {
    let signal = noise(4, 150, 1.0);
    // A power of two scales without rounding.
    let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-40)).collect();
    let [p, q] = [&signal, &scaled].map(|signal| of(signal, 4, 3, Threshold::Rate(0.07)));
    assert_eq!((p.distance, p.recurrent), (q.distance, q.recurrent));
    assert_eq!(p.threshold.map(|d| d * 2.0_f64.powi(-40)), q.threshold);
}

#[test]
fn a_constant_signal_is_always_recurrent() {
    let image = of(&[2.5; 40], 2, 3, Threshold::Rate(0.05));
    assert!(image.distance.iter().all(|&p| p == 0));
    assert_eq!((image.threshold, image.rate), (Some(0.0), 1.0));
    assert!(image.recurrent.iter().all(|&p| p == 255));
}

#[test]
fn a_spread_is_that_of_the_whole_window() {
    let signal = noise(6, 200, 1.0);
    let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
    for indices in [(0..199).collect::<Vec<_>>(), vec![3, 70, 71], vec![5]] {
        let image = image(&vectors, &indices, Norm::Manhattan, Threshold::Spread(0.7));
        assert_eq!(image.threshold, Some(0.7 * deviation(&signal)));
        let neighbours = Threshold::Neighbours(1);
        let image = self::image(&vectors, &indices, Norm::Manhattan, neighbours);
        assert_eq!(image.threshold, None);
        let pixels = image.recurrent.iter().filter(|&&p| p == 255).count();
        // The state itself and its neighbour.
        assert_eq!(pixels, indices.len() * indices.len().min(2));
    }
}
