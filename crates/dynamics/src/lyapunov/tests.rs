//! Spectra computed from prescribed growth.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// Growth over 1000 s in steps of 0.1 s at the given rates, with random increments of the given standard
/// deviations.
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
    growth(rates, noise).spectrum(rates.len(), 0.0)
}

#[test]
fn signs_and_attractors_follow_the_intervals() {
    let no_noise = [0.0; 4];
    for (rates, expected) in [
        ([-0.1, -0.2, -0.3, -4.0], Attractor::FixedPoint),
        ([0.0, -0.2, -0.3, -4.0], Attractor::Cycle),
        ([0.0, 0.0, -0.3, -4.0], Attractor::Torus(2)),
        // Positive, but within the resolution set by the bounds of a neutral vector.
        ([1e-4, -0.2, -0.3, -4.0], Attractor::Undecided),
        ([0.1, 0.0, -0.3, -4.0], Attractor::Chaos),
        ([0.1, 0.05, 0.0, -4.0], Attractor::Hyperchaos(2)),
    ] {
        assert_eq!(
            spectrum(&rates, &no_noise).attractor(),
            expected,
            "{rates:?}"
        );
    }
}

#[test]
fn an_undetermined_exponent_does_not_count_for_hyperchaos() {
    // The second rate is half its standard error.
    let noise = [0.05, 0.3, 0.05, 0.05];
    let spectrum = spectrum(&[0.5, 0.015, 0.0, -4.0], &noise);
    assert_eq!(spectrum.sign(1), Sign::Undetermined, "{spectrum:?}");
    assert_eq!(spectrum.attractor(), Attractor::Chaos);
    let same = self::spectrum(&[0.015, -1.0], &noise[1..3]);
    assert_eq!(same.attractor(), Attractor::Undecided);
}

#[test]
fn too_few_exponents_leave_the_attractor_undecided() {
    let known = growth(&[0.0, 0.0], &[0.0; 2]).spectrum(4, 0.0);
    assert_eq!(known.attractor(), Attractor::Undecided);
    assert_eq!(known.kaplan_yorke, None);
    let known = growth(&[0.0, -0.5], &[0.0; 2]).spectrum(4, 0.0);
    assert_eq!(known.attractor(), Attractor::Cycle);
    assert_eq!(known.kaplan_yorke.unwrap().value, 1.0);
}

#[test]
fn kaplan_yorke_dimensions_of_known_spectra() {
    let dimension = |rates: &[f64]| spectrum(rates, &vec![0.0; rates.len()]).kaplan_yorke;
    assert_eq!(dimension(&[-1.0, -2.0]).unwrap().value, 0.0);
    assert_eq!(dimension(&[0.0, 0.0, -2.0]).unwrap().value, 2.0);
    let value = dimension(&[0.9, 0.0, -14.5]).unwrap().value;
    assert!((value - (2.0 + 0.9 / 14.5)).abs() < 1e-12);
    assert_eq!(dimension(&[1.0, 0.0, 0.0, -1.0]).unwrap().value, 4.0);
    // The sum of the two rates has no noise: their errors are fully correlated.
    let mut growth = Growth::new(2);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for k in 1..=4096 {
        let random: f64 = StandardNormal.sample(&mut rng);
        growth.push(f64::from(k), &[1.0 + random, -3.0 - random]);
    }
    let spectrum = growth.spectrum(2, 0.0);
    let [first, second] = [0, 1].map(|k| spectrum.exponents[k]);
    let found = spectrum.kaplan_yorke.unwrap();
    let slope = 1.0 / second.value.abs() - first.value / second.value.powi(2);
    assert!((found.half_width - slope * first.half_width).abs() < 1e-9);
}

#[test]
fn a_collapsed_direction_has_exponent_minus_infinity() {
    let mut growth = growth(&[0.0, -1.0], &[0.0; 2]);
    growth.push(1003.0, &[0.0, f64::NEG_INFINITY]);
    growth.push(1009.0, &[0.0, -1.0]);
    let spectrum = growth.spectrum(2, 0.0);
    assert_eq!(spectrum.exponents[1].value, f64::NEG_INFINITY);
    assert_eq!(spectrum.sign(1), Sign::Negative);
    assert_eq!(spectrum.attractor(), Attractor::Cycle);
    assert_eq!(spectrum.kaplan_yorke.unwrap().value, 1.0);
}

#[test]
fn before_any_growth_nothing_is_known() {
    let spectrum = Growth::new(3).spectrum(3, 0.0);
    assert_eq!(spectrum.attractor(), Attractor::Undecided);
    assert!(spectrum.kaplan_yorke.is_none());
    assert_eq!(spectrum.exponents[0].value, 0.0);
}

/// A rate well within the resolution whose interval excludes zero.
#[test]
fn an_interval_that_excludes_zero_is_not_zero() {
    let spectrum = LyapunovSpectrum {
        exponents: vec![Exponent {
            value: -64.3,
            half_width: 7.2,
        }],
        time: 0.01,
        dimension: 1,
        resolution: 230.0,
        kaplan_yorke: None,
    };
    assert_eq!(spectrum.sign(0), Sign::Undetermined);
    assert_eq!(spectrum.attractor(), Attractor::Undecided);
    // From growth: the dimension depends on it and is therefore undefined.
    let found = self::spectrum(&[1e-4, -4.0], &[0.0; 2]);
    assert_eq!(found.sign(0), Sign::Undetermined, "{found:?}");
    assert_eq!(found.kaplan_yorke, None);
}

/// A zero exponent requires the minimum averaging time; a clearly non-zero one does not.
#[test]
fn a_zero_exponent_requires_the_minimum_time() {
    let noise = [0.005; 3];
    for (rates, early, late) in [
        ([0.0, -0.5, -1.0], Attractor::Undecided, Attractor::Cycle),
        (
            [-0.4, -0.5, -1.0],
            Attractor::FixedPoint,
            Attractor::FixedPoint,
        ),
        ([0.5, 0.0, -1.0], Attractor::Chaos, Attractor::Chaos),
    ] {
        let growth = growth(&rates, &noise);
        let [before, after] = [1001.0, 999.0].map(|min_time| growth.spectrum(3, min_time));
        assert_eq!((before.attractor(), after.attractor()), (early, late));
        assert_eq!(before.count(Sign::Zero), 0);
        // The dimension is not defined either if it depends on an unconfirmed zero.
        assert_eq!(before.kaplan_yorke.is_some(), early.is_decided());
    }
}

#[test]
fn the_attractor_depends_on_the_type_of_motion() {
    let of = |rates: &[f64], motion| spectrum(rates, &[0.0; 2]).attractor_of(motion);
    let both = [-0.5, -1.0];
    assert_eq!(of(&both, Motion::Free), Attractor::FixedPoint);
    assert_eq!(of(&both, Motion::Driven), Attractor::PhaseLocked);
    let stable = Attractor::StableEquilibrium;
    assert_eq!(of(&both, Motion::Still), stable);
    assert_eq!(of(&[0.0, -1.0], Motion::Driven), Attractor::Torus(2));
    assert_eq!(of(&[0.0, 0.0], Motion::Free), Attractor::Torus(2));
    let undecided = of(&[0.0, -1.0], Motion::Still);
    assert_eq!(undecided, Attractor::Equilibrium);
    assert!(!undecided.is_decided() && stable.is_decided());
    let unstable = of(&[0.7, 0.5], Motion::Still);
    assert_eq!(unstable, Attractor::UnstableEquilibrium);
}

/// Slowly converging vectors: the growth rate differs during the first tenth.
#[test]
fn an_interval_contains_the_rate_after_a_transient() {
    let mut growth = Growth::new(1);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for k in 1..=4096 {
        let random: f64 = StandardNormal.sample(&mut rng);
        let t = f64::from(k);
        growth.push(t, &[-5.0 - 60.0 * (-t / 400.0).exp() + 0.5 * random]);
    }
    let exponent = growth.spectrum(1, 0.0).exponents[0];
    assert!(
        exponent.value < -10.0 && exponent.high() > -5.5,
        "{exponent:?}"
    );
}
