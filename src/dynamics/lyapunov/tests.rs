//! Spectra of growth that is known.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// Growth for 1000 s in steps of 0.1 s at these rates, with random additions of these sizes.
fn growth(rates: &[f64], noise: &[f64]) -> Growth {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut growth = Growth::new(rates.len());
    growth.clear(2.0);
    for k in 1..=10_000 {
        let both = rates.iter().zip(noise);
        let step: Vec<f64> = both
            .map(|(rate, noise)| {
                let random: f64 = StandardNormal.sample(&mut rng);
                0.1 * rate + noise * random
            })
            .collect();
        growth.push(2.0 + 0.1 * f64::from(k), &step);
    }
    growth
}

fn spectrum(rates: &[f64], noise: &[f64]) -> LyapunovSpectrum {
    growth(rates, noise).spectrum(rates.len())
}

#[test]
fn signs_and_attractors_follow_the_intervals() {
    let quiet = [0.0; 4];
    for (rates, expected) in [
        ([-0.1, -0.2, -0.3, -4.0], Attractor::Rest),
        ([0.0, -0.2, -0.3, -4.0], Attractor::Cycle),
        ([1e-4, -1e-4, -0.3, -4.0], Attractor::Torus(2)),
        ([0.1, 0.0, -0.3, -4.0], Attractor::Chaos),
        ([0.1, 0.05, 0.0, -4.0], Attractor::HyperChaos(2)),
    ] {
        assert_eq!(spectrum(&rates, &quiet).attractor(), expected, "{rates:?}");
    }
}

#[test]
fn a_doubtful_exponent_is_no_hyper_chaos() {
    // The second rate is half of its standard error.
    let noise = [0.05, 0.3, 0.05, 0.05];
    let spectrum = spectrum(&[0.5, 0.015, 0.0, -4.0], &noise);
    assert_eq!(spectrum.sign(1), Sign::Doubtful, "{spectrum:?}");
    assert_eq!(spectrum.attractor(), Attractor::Chaos);
    let same = self::spectrum(&[0.015, -1.0], &noise[1..3]);
    assert_eq!(same.attractor(), Attractor::Undecided);
}

#[test]
fn too_few_exponents_leave_the_rest_open() {
    let known = growth(&[0.0, 0.0], &[0.0; 2]).spectrum(4);
    assert_eq!(known.attractor(), Attractor::Undecided);
    assert_eq!(known.kaplan_yorke(), None);
    let known = growth(&[0.0, -0.5], &[0.0; 2]).spectrum(4);
    assert_eq!(known.attractor(), Attractor::Cycle);
    assert_eq!(known.kaplan_yorke().unwrap().value, 1.0);
}

#[test]
fn the_dimension_of_kaplan_and_yorke() {
    let dimension = |rates: &[f64]| spectrum(rates, &vec![0.0; rates.len()]).kaplan_yorke();
    assert_eq!(dimension(&[-1.0, -2.0]).unwrap().value, 0.0);
    assert_eq!(dimension(&[0.0, 0.0, -2.0]).unwrap().value, 2.0);
    let value = dimension(&[0.9, 0.0, -14.5]).unwrap().value;
    assert!((value - (2.0 + 0.9 / 14.5)).abs() < 1e-12);
    assert_eq!(dimension(&[1.0, 0.0, 0.0, -1.0]).unwrap().value, 4.0);
    // The sum of the two is without noise: the errors of the two add up to this.
    let mut growth = Growth::new(2);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for k in 1..=4096 {
        let random: f64 = StandardNormal.sample(&mut rng);
        growth.push(f64::from(k), &[1.0 + random, -3.0 - random]);
    }
    let spectrum = growth.spectrum(2);
    let [first, second] = [0, 1].map(|k| spectrum.exponents[k]);
    let found = spectrum.kaplan_yorke().unwrap();
    let slope = 1.0 / second.value.abs() - first.value / second.value.powi(2);
    assert!((found.half_width - slope * first.half_width).abs() < 1e-9);
}

#[test]
fn a_collapsed_direction_is_minus_infinity_and_never_undefined() {
    let mut growth = growth(&[0.0, -1.0], &[0.0; 2]);
    growth.push(1003.0, &[0.0, f64::NEG_INFINITY]);
    growth.push(1009.0, &[0.0, -1.0]);
    let spectrum = growth.spectrum(2);
    assert_eq!(spectrum.exponents[1].value, f64::NEG_INFINITY);
    assert_eq!(spectrum.sign(1), Sign::Negative);
    assert_eq!(spectrum.attractor(), Attractor::Cycle);
    assert_eq!(spectrum.kaplan_yorke().unwrap().value, 1.0);
    let values = growth.convergence().values;
    assert!(values.iter().flatten().all(|x| !x.is_nan()));
}

#[test]
fn before_any_growth_nothing_is_known() {
    let spectrum = Growth::new(3).spectrum(3);
    assert_eq!(spectrum.attractor(), Attractor::Undecided);
    assert!(!spectrum.is_settled(1e9) && spectrum.kaplan_yorke().is_none());
    assert_eq!(spectrum.exponents[0].value, 0.0);
}

#[test]
fn per_radian_everything_scales_and_the_signs_stay() {
    let spectrum = spectrum(&[0.5, 0.0, -2.0], &[0.1; 3]);
    let divided = spectrum.divided_by(10.0);
    assert_eq!(
        divided.exponents[0].value,
        spectrum.exponents[0].value / 10.0
    );
    assert_eq!(divided.time, 10.0 * spectrum.time);
    assert_eq!(divided.attractor(), spectrum.attractor());
    assert!(spectrum.is_settled(0.1) && !spectrum.is_settled(1e-3));
}

#[test]
fn the_running_value_ends_at_the_present_one() {
    let growth = growth(&[0.5, -2.0], &[0.1; 2]);
    let convergence = growth.convergence();
    let spectrum = growth.spectrum(2);
    assert!((64..=129).contains(&convergence.times.len()));
    assert!(convergence.times.is_sorted());
    for (values, exponent) in convergence.values.iter().zip(&spectrum.exponents) {
        assert_eq!(values.len(), convergence.times.len());
        assert!((values.last().unwrap() - exponent.value).abs() < 1e-9);
    }
}
