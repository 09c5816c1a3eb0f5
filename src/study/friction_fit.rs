//! The Stribeck law of Eq. (5) fitted to measured coefficients of friction.
//!
//! `mu(V) = (1 - exp(-creep V)) (mu_d + (mu_s - mu_d) exp(-stribeck V))` with a given `creep`. For a given `stribeck` the
//! law is linear in the two coefficients, so that the sum of the weighted squares is a function of `stribeck` alone
//! (G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413), whose least value is searched. The intervals follow
//! from the covariance at the best fit, and hold as far as the law is linear within them.

use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::student;
use crate::joint::Stribeck;

/// Least number of points: Student's quantile is accurate from seven degrees of freedom on.
pub const MIN_POINTS: usize = 10;

/// Number of slope factors that are tried first.
const TRIALS: usize = 200;

/// Number of steps of the golden section: the slope factor is then exact to about nine digits.
const STEPS: usize = 60;

/// Measured point: a coefficient of friction at a slip speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionPoint {
    /// Slip speed, m/s.
    pub speed: f64,
    /// Coefficient of friction.
    pub coefficient: f64,
    /// Standard deviation of the coefficient; `None` if it is not known.
    pub deviation: Option<f64>,
}

/// A fitted number with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FittedNumber {
    /// Best value.
    pub value: f64,
    /// Half-width of the 95 % interval.
    pub half_width: f64,
}

/// The Stribeck law of friction, fitted to measured points.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FrictionFit {
    /// Static coefficient of friction `mu_s`.
    pub mu_s: FittedNumber,
    /// Kinetic coefficient of friction `mu_d`.
    pub mu_d: FittedNumber,
    /// Stribeck slope factor of the sliding region, s/m.
    pub stribeck_slope_s_per_m: FittedNumber,
    /// Creep slope factor, which was given, s/m.
    pub creep_slope_s_per_m: f64,
    /// Number of points.
    pub points: usize,
    /// Standard deviation of the residuals from the law.
    pub residual_deviation: f64,
    /// Chi-square of the residuals per degree of freedom; `None` without standard deviations of the points. Much above 1
    /// the law does not describe the points, or their deviations are too small.
    pub chi_square_per_degree: Option<f64>,
    /// Runs test: standard score of the number of runs of residuals of equal sign, in the order of the speeds. Below -1.96
    /// the residuals follow each other, and the law does not describe the points.
    pub runs_score: f64,
}

impl FrictionFit {
    /// The fitted law.
    pub fn law(&self) -> Stribeck {
        Stribeck {
            mu_s: self.mu_s.value,
            mu_d: self.mu_d.value,
            creep: self.creep_slope_s_per_m,
            stribeck: self.stribeck_slope_s_per_m.value,
        }
    }

    /// Whether the runs test accepts the law.
    pub fn describes_points(&self) -> bool {
        self.runs_score >= -1.96
    }
}

/// Reason why a law of friction cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrictionFitError {
    /// Too few points.
    #[error(
        "{have} points do not suffice for three numbers with their intervals; measure at least {MIN_POINTS}"
    )]
    TooFew {
        /// Number of points.
        have: usize,
    },
    /// The points do not determine the slope factor.
    #[error(
        "the points do not determine the slope of the law; measure at more speeds, from well below to well above the decrease"
    )]
    Undetermined,
}

/// Fits the law to points, which count by the inverse squares of their standard deviations if all have one. The points
/// are finite, with speeds and deviations above 0; `creep` (s/m) is above 0.
///
/// # Errors
/// Too few points, or points that do not determine the law.
pub fn fit_friction(points: &[FrictionPoint], creep: f64) -> Result<FrictionFit, FrictionFitError> {
    if points.len() < MIN_POINTS {
        return Err(FrictionFitError::TooFew { have: points.len() });
    }
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    let known = points.iter().all(|point| point.deviation.is_some());
    let weight = |point: &FrictionPoint| match point.deviation {
        Some(deviation) if known => deviation.powi(-2),
        _ => 1.0,
    };
    let best = |stribeck| best_coefficients(&points, &weight, creep, stribeck);
    let stribeck = slope_factor(&points, &|stribeck| best(stribeck).map(|(_, sum)| sum))?;
    let (law, sum) = best(stribeck).ok_or(FrictionFitError::Undetermined)?;
    let mut normal = Matrix3::zeros();
    for point in &points {
        let share = -(-creep * point.speed).exp_m1();
        let fall = (-stribeck * point.speed).exp();
        let slope = -(law.mu_s - law.mu_d) * point.speed * fall;
        let row = share * Vector3::new(fall, 1.0 - fall, slope);
        normal += weight(point) * row * row.transpose();
    }
    let freedom = points.len() - 3;
    let per_degree = sum / freedom as f64;
    // Known deviations are taken as they are, unless the points scatter more.
    let scale = if known {
        per_degree.max(1.0)
    } else {
        per_degree
    };
    let covariance = normal.try_inverse().ok_or(FrictionFitError::Undetermined)? * scale;
    let number = |k: usize, value| FittedNumber {
        value,
        half_width: student(freedom) * covariance[(k, k)].sqrt(),
    };
    let slope = number(2, stribeck);
    if slope.half_width.partial_cmp(&slope.value) != Some(std::cmp::Ordering::Less) {
        return Err(FrictionFitError::Undetermined);
    }
    let residuals = points
        .iter()
        .map(|point| point.coefficient - law.coefficient(point.speed));
    let residuals: Vec<f64> = residuals.collect();
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    Ok(FrictionFit {
        mu_s: number(0, law.mu_s),
        mu_d: number(1, law.mu_d),
        stribeck_slope_s_per_m: slope,
        creep_slope_s_per_m: creep,
        points: points.len(),
        residual_deviation: (squares / freedom as f64).sqrt(),
        chi_square_per_degree: known.then_some(per_degree),
        runs_score: runs_score(&residuals),
    })
}

/// The coefficients with the least sum of weighted squares for a slope factor, and that sum.
fn best_coefficients(
    points: &[FrictionPoint],
    weight: &dyn Fn(&FrictionPoint) -> f64,
    creep: f64,
    stribeck: f64,
) -> Option<(Stribeck, f64)> {
    // Normal equations of `mu_s` and `mu_d`.
    let (mut a, mut b, mut c, mut y) = (0.0, 0.0, 0.0, [0.0; 2]);
    for point in points {
        let share = -(-creep * point.speed).exp_m1();
        let fall = (-stribeck * point.speed).exp();
        let [first, second] = [share * fall, share * (1.0 - fall)];
        let weight = weight(point);
        a += weight * first * first;
        b += weight * first * second;
        c += weight * second * second;
        y[0] += weight * first * point.coefficient;
        y[1] += weight * second * point.coefficient;
    }
    let determinant = a * c - b * b;
    if determinant <= 1e-12 * a * c {
        return None;
    }
    let law = Stribeck {
        mu_s: (c * y[0] - b * y[1]) / determinant,
        mu_d: (a * y[1] - b * y[0]) / determinant,
        creep,
        stribeck,
    };
    let square = |point: &FrictionPoint| {
        weight(point) * (point.coefficient - law.coefficient(point.speed)).powi(2)
    };
    Some((law, points.iter().map(square).sum()))
}

/// The slope factor with the least sum: the best of many, then a golden section between its neighbours.
fn slope_factor(
    points: &[FrictionPoint],
    sum: &dyn Fn(f64) -> Option<f64>,
) -> Result<f64, FrictionFitError> {
    let speeds = points.iter().map(|point| point.speed);
    let (low, high) = (
        0.1 / speeds.clone().fold(0.0, f64::max),
        10.0 / speeds.fold(f64::MAX, f64::min),
    );
    let trial = |k: usize| low * (high / low).powf(k as f64 / (TRIALS - 1) as f64);
    let sums = (0..TRIALS).filter_map(|k| Some((k, sum(trial(k))?)));
    let best = sums.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k);
    let best = best
        .filter(|k| (1..TRIALS - 1).contains(k))
        .ok_or(FrictionFitError::Undetermined)?;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut from, mut to] = [trial(best - 1), trial(best + 1)];
    for _ in 0..STEPS {
        let [a, b] = [to - golden * (to - from), from + golden * (to - from)];
        match sum(a).zip(sum(b)) {
            Some((first, second)) if first < second => to = b,
            Some(_) => from = a,
            None => return Err(FrictionFitError::Undetermined),
        }
    }
    Ok(0.5 * (from + to))
}

/// The runs test of A. Wald and J. Wolfowitz, Ann. Math. Stat. 11 (1940) 147: the number of runs of equal sign against
/// that of independent residuals, in standard deviations; 0 if all have one sign.
fn runs_score(residuals: &[f64]) -> f64 {
    let above = residuals.iter().filter(|r| **r > 0.0).count() as f64;
    let below = residuals.len() as f64 - above;
    let all = above + below;
    let runs = 1.0
        + residuals
            .windows(2)
            .filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0))
            .count() as f64;
    let mean = 1.0 + 2.0 * above * below / all;
    let variance = (mean - 1.0) * (mean - 2.0) / (all - 1.0);
    match variance > 0.0 {
        true => (runs - mean) / variance.sqrt(),
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    const LAW: Stribeck = Stribeck {
        mu_s: 0.55,
        mu_d: 0.3,
        creep: 1000.0,
        stribeck: 20.0,
    };

    /// Points of the law at 24 speeds with random errors.
    fn points(deviation: f64, seed: u64) -> Vec<FrictionPoint> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut point = |k: i32| {
            let speed = 2e-3 * 1.25_f64.powi(k);
            let error: f64 = StandardNormal.sample(&mut random);
            FrictionPoint {
                speed,
                coefficient: LAW.coefficient(speed) + deviation * error,
                deviation: None,
            }
        };
        (0..24).map(&mut point).collect()
    }

    #[test]
    fn exact_points_give_the_law() {
        let fit = fit_friction(&points(0.0, 1), LAW.creep).unwrap();
        let law = fit.law();
        for (found, expected) in [
            (law.mu_s, LAW.mu_s),
            (law.mu_d, LAW.mu_d),
            (law.stribeck, LAW.stribeck),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-6, "{law:?}");
        }
        assert!(fit.residual_deviation < 1e-8);
    }

    /// The intervals contain the truth in about 95 % of all measurements.
    #[test]
    fn intervals_contain_the_truth_as_often_as_they_say() {
        let mut inside = [0; 3];
        let mut rejected = 0;
        for seed in 0..400 {
            let fit = fit_friction(&points(0.01, seed), LAW.creep).unwrap();
            let holds = |number: FittedNumber, truth: f64| {
                usize::from((number.value - truth).abs() <= number.half_width)
            };
            inside[0] += holds(fit.mu_s, LAW.mu_s);
            inside[1] += holds(fit.mu_d, LAW.mu_d);
            inside[2] += holds(fit.stribeck_slope_s_per_m, LAW.stribeck);
            rejected += usize::from(!fit.describes_points());
        }
        // 380 are expected; the standard deviation is 4.4.
        assert!(
            inside.iter().all(|count| (365..=395).contains(count)),
            "{inside:?}"
        );
        assert!(rejected < 30, "{rejected}");
    }

    #[test]
    fn known_deviations_are_weights_and_give_chi_square() {
        let mut measured = points(0.01, 3);
        for (k, point) in measured.iter_mut().enumerate() {
            point.deviation = Some(0.01);
            // A few useless points.
            if k % 6 == 5 {
                point.coefficient += 0.2;
                point.deviation = Some(1.0);
            }
        }
        let fit = fit_friction(&measured, LAW.creep).unwrap();
        assert!(
            (fit.mu_s.value - LAW.mu_s).abs() < 2.0 * fit.mu_s.half_width,
            "{fit:?}"
        );
        let chi_square = fit.chi_square_per_degree.unwrap();
        assert!((0.3..2.0).contains(&chi_square), "{chi_square}");
    }

    #[test]
    fn another_law_is_detected_and_flat_points_are_refused() {
        let mut humped = points(0.001, 4);
        for point in &mut humped {
            let distance = (point.speed / 0.03).ln();
            point.coefficient += 0.05 * (-2.0 * distance * distance).exp();
        }
        assert!(!fit_friction(&humped, LAW.creep).unwrap().describes_points());
        let mut flat = points(0.01, 5);
        for point in &mut flat {
            let error = point.coefficient - LAW.coefficient(point.speed);
            point.coefficient = -0.4 * (-LAW.creep * point.speed).exp_m1() + error;
        }
        assert_eq!(
            fit_friction(&flat, LAW.creep),
            Err(FrictionFitError::Undetermined)
        );
        assert_eq!(
            fit_friction(&flat[..5], LAW.creep),
            Err(FrictionFitError::TooFew { have: 5 })
        );
    }
}
