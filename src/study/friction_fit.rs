//! The Stribeck law of Eq. (5) fitted to measured coefficients of friction.
//!
//! `mu(V) = (1 - exp(-creep V)) (mu_d + (mu_s - mu_d) exp(-stribeck V))` with a given `creep`. For a given `stribeck` the
//! law is linear in the two coefficients, so that the sum of the weighted squares is a function of `stribeck` alone
//! (G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413), whose least value is searched. The intervals follow
//! from the covariance at the best fit, and hold as far as the law is linear within them.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::student;
use crate::joint::Stribeck;
use crate::number::significant;
use crate::report::{Block, Measured, Report, Table};

/// Least number of points: Student's quantile is accurate from seven degrees of freedom on.
pub const MIN_POINTS: usize = 10;

/// Slip speed times creep factor below which a point is in the creep region: its coefficient is reduced by 0.7 % there.
const CREEP_REGION: f64 = 5.0;

/// Slip speed that joints and squealing brakes do not reach, m/s.
const FAST: f64 = 5.0;

/// Largest coefficient of friction of a scene.
pub const LARGEST_COEFFICIENT: f64 = 10.0;

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

impl FrictionPoint {
    /// Weight of the square of a residual.
    fn weight(&self) -> f64 {
        self.deviation.map_or(1.0, |deviation| deviation.powi(-2))
    }
}

/// The Stribeck law of friction, fitted to measured points.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FrictionFit {
    /// Static coefficient of friction `mu_s`.
    pub mu_s: Measured,
    /// Kinetic coefficient of friction `mu_d`.
    pub mu_d: Measured,
    /// Stribeck slope factor of the sliding region, s/m.
    pub stribeck_slope_s_per_m: Measured,
    /// Creep slope factor, which was given, s/m.
    pub creep_slope_s_per_m: f64,
    /// Number of points.
    pub points: usize,
    /// Standard deviation of the residuals from the law.
    pub residual_deviation: f64,
    /// Chi-square of the residuals per degree of freedom; `None` without standard deviations of the points.
    pub chi_square_per_degree: Option<f64>,
    /// 95 % interval of chi-square per degree of freedom if the law and the deviations are right.
    pub chi_square_expected: [f64; 2],
    /// Runs test: standard score of the number of runs of residuals of equal sign, in the order of the speeds. Below -1.96
    /// the residuals follow each other, and the law does not describe the points.
    pub runs_score: f64,
    /// Number of points in the creep region, where the creep factor, which is not fitted, reduces the coefficient.
    pub points_in_creep_region: usize,
    /// What is doubtful about the law, a sentence each; empty if nothing is.
    pub doubts: Vec<String>,
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

    /// What is doubtful about the law, fitted to points up to a speed, m/s.
    fn find_doubts(&self, fastest: f64) -> Vec<String> {
        let mut doubts = Vec::new();
        if fastest > FAST {
            doubts.push(format!(
                "the speeds reach {} m/s, and joints and squealing brakes slide below {FAST} m/s: if they are in mm/s, divide \
                 them by 1000",
                significant(fastest, 3)
            ));
        }
        let remedy = "use the points as they are, with law = \"table\"";
        if self.runs_score < -1.96 {
            doubts.push(format!(
                "the residuals follow each other (runs test {:.1}): the law does not describe the points; {remedy}",
                self.runs_score
            ));
        }
        let [low, high] = self.chi_square_expected;
        match self.chi_square_per_degree {
            Some(found) if found > high => doubts.push(format!(
                "chi-square is too large: the law does not describe the points, or their deviations are too small; {remedy}"
            )),
            Some(found) if found < low => doubts.push(
                "chi-square is too small: the points scatter less than their deviations say".to_owned(),
            ),
            _ => {}
        }
        if self.points_in_creep_region > 0 {
            doubts.push(format!(
                "{} points lie below {} m/s, in the creep region, whose factor is given and not fitted: they distort the \
                 law if it is wrong; remove them, or set --creep",
                self.points_in_creep_region,
                significant(CREEP_REGION / self.creep_slope_s_per_m, 2)
            ));
        }
        if self.mu_d.value > self.mu_s.value {
            doubts.push(
                "the coefficient increases with the speed, which excites no vibration".to_owned(),
            );
        }
        doubts
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
    /// The points are as well described by a constant coefficient, or increase.
    #[error(
        "no decrease of the coefficient with the speed is significant; use law = \"constant\" with mu = {mu}, law = \"table\" \
         if it increases, or measure with less scatter"
    )]
    NoDecrease {
        /// The constant coefficient.
        mu: Measured,
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
/// Too few points, points without a significant change, or points that do not determine the law.
pub fn fit_friction(points: &[FrictionPoint], creep: f64) -> Result<FrictionFit, FrictionFitError> {
    if points.len() < MIN_POINTS {
        return Err(FrictionFitError::TooFew { have: points.len() });
    }
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    // Equal weights unless all deviations are known.
    let known = points.iter().all(|point| point.deviation.is_some());
    if !known {
        points.iter_mut().for_each(|point| point.deviation = None);
    }
    let best = |stribeck| best_coefficients(&points, creep, stribeck);
    let freedom = points.len() - 3;
    // Known deviations are taken as they are, unless the points scatter more.
    let least_scale = if known { 1.0 } else { 0.0 };
    let scale = |sum: f64, freedom: usize| (sum / freedom as f64).max(least_scale);
    let fastest = points[points.len() - 1].speed;
    let (stribeck, least) = slope_factor(&points, &|stribeck| best(stribeck).map(|(_, sum)| sum));
    let (mu, constant) = constant_coefficient(&points, creep);
    // F test of the two numbers more; the quantile of two degrees of freedom is elementary.
    let quantile = 0.5 * freedom as f64 * (0.05_f64.powf(-2.0 / freedom as f64) - 1.0);
    let is_significant = 0.5 * (constant - least) > quantile * scale(least, freedom);
    let half = points.len() / 2;
    let sum_of = |part: &[FrictionPoint]| part.iter().map(|point| point.coefficient).sum::<f64>();
    let increases = sum_of(&points[..half]) < sum_of(&points[points.len() - half..]);
    if !is_significant || stribeck.is_none() && increases {
        let [value, variance] = mu;
        let half_width =
            student(points.len() - 1) * (variance * scale(constant, points.len() - 1)).sqrt();
        let mu = Measured::new(value, half_width);
        return Err(FrictionFitError::NoDecrease { mu });
    }
    let stribeck = stribeck.ok_or(FrictionFitError::Undetermined)?;
    let (law, sum) = best(stribeck).ok_or(FrictionFitError::Undetermined)?;
    let possible = 0.0..=LARGEST_COEFFICIENT;
    if !possible.contains(&law.mu_s) || !possible.contains(&law.mu_d) {
        return Err(FrictionFitError::Undetermined);
    }
    let mut normal = Matrix3::zeros();
    for point in &points {
        let share = -(-creep * point.speed).exp_m1();
        let fall = (-stribeck * point.speed).exp();
        let slope = -(law.mu_s - law.mu_d) * point.speed * fall;
        let row = share * Vector3::new(fall, 1.0 - fall, slope);
        normal += point.weight() * row * row.transpose();
    }
    let covariance =
        normal.try_inverse().ok_or(FrictionFitError::Undetermined)? * scale(sum, freedom);
    let number =
        |k: usize, value| Measured::new(value, student(freedom) * covariance[(k, k)].sqrt());
    let slope = number(2, stribeck).unit("s/m");
    if slope.half_width.partial_cmp(&slope.value) != Some(std::cmp::Ordering::Less) {
        return Err(FrictionFitError::Undetermined);
    }
    let residual = |point: &FrictionPoint| point.coefficient - law.coefficient(point.speed);
    let residuals: Vec<f64> = points.iter().map(residual).collect();
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let all = points.iter();
    let in_creep_region = all.filter(|point| creep * point.speed < CREEP_REGION);
    let mut fit = FrictionFit {
        mu_s: number(0, law.mu_s),
        mu_d: number(1, law.mu_d),
        stribeck_slope_s_per_m: slope,
        creep_slope_s_per_m: creep,
        points: points.len(),
        residual_deviation: (squares / freedom as f64).sqrt(),
        chi_square_per_degree: known.then_some(sum / freedom as f64),
        chi_square_expected: chi_square_interval(freedom),
        runs_score: runs_score(&residuals),
        points_in_creep_region: in_creep_region.count(),
        doubts: Vec::new(),
    };
    fit.doubts = fit.find_doubts(fastest);
    Ok(fit)
}

/// 95 % interval of chi-square per degree of freedom: E. B. Wilson, M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684.
fn chi_square_interval(freedom: usize) -> [f64; 2] {
    let variance = 2.0 / (9.0 * freedom as f64);
    [-1.96, 1.96].map(|score| (1.0 - variance + score * variance.sqrt()).powi(3))
}

/// The constant coefficient with the least sum of weighted squares, its variance for weights of unit deviation, and that
/// sum: with the creep factor or, if that describes the points better, without it. Where points do not rise from the creep
/// region, the factor would let a constant coefficient decrease.
fn constant_coefficient(points: &[FrictionPoint], creep: f64) -> ([f64; 2], f64) {
    let constant = |creep: f64| {
        let share = |point: &FrictionPoint| -(-creep * point.speed).exp_m1();
        let sum = |term: &dyn Fn(&FrictionPoint) -> f64| -> f64 {
            points.iter().map(|p| p.weight() * term(p)).sum()
        };
        let squares = sum(&|point| share(point).powi(2));
        let mu = sum(&|point| share(point) * point.coefficient) / squares;
        let residuals = sum(&|point| (point.coefficient - mu * share(point)).powi(2));
        ([mu, 1.0 / squares], residuals)
    };
    let [with, without] = [creep, f64::INFINITY].map(constant);
    if with.1 <= without.1 { with } else { without }
}

/// The coefficients with the least sum of weighted squares for a slope factor, and that sum.
fn best_coefficients(
    points: &[FrictionPoint],
    creep: f64,
    stribeck: f64,
) -> Option<(Stribeck, f64)> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for point in points {
        let share = -(-creep * point.speed).exp_m1();
        let fall = (-stribeck * point.speed).exp();
        let row = share * Vector2::new(fall, 1.0 - fall);
        normal += point.weight() * row * row.transpose();
        right += point.weight() * point.coefficient * row;
    }
    if normal.determinant() <= 1e-12 * normal[(0, 0)] * normal[(1, 1)] {
        return None;
    }
    let [mu_s, mu_d] = (normal.try_inverse()? * right).into();
    let law = Stribeck {
        mu_s,
        mu_d,
        creep,
        stribeck,
    };
    let square =
        |p: &FrictionPoint| p.weight() * (p.coefficient - law.coefficient(p.speed)).powi(2);
    Some((law, points.iter().map(square).sum()))
}

/// The slope factor with the least sum: the best of many, then a golden section between its neighbours; `None` if the sum has
/// no minimum between the extreme ones. And the least sum of the many.
fn slope_factor(points: &[FrictionPoint], sum: &dyn Fn(f64) -> Option<f64>) -> (Option<f64>, f64) {
    let speeds = points.iter().map(|point| point.speed);
    let low = 0.1 / speeds.clone().fold(0.0, f64::max);
    let high = 10.0 / speeds.fold(f64::MAX, f64::min);
    let trial = |k: usize| low * (high / low).powf(k as f64 / (TRIALS - 1) as f64);
    let sums = (0..TRIALS).filter_map(|k| Some((k, sum(trial(k))?)));
    let (best, least) = sums
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, f64::INFINITY));
    if !(1..TRIALS - 1).contains(&best) {
        return (None, least);
    }
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut from, mut to] = [trial(best - 1), trial(best + 1)];
    for _ in 0..STEPS {
        let [a, b] = [to - golden * (to - from), from + golden * (to - from)];
        match sum(a).zip(sum(b)) {
            Some((first, second)) if first < second => to = b,
            Some(_) => from = a,
            None => return (None, least),
        }
    }
    (Some(0.5 * (from + to)), least)
}

/// The runs test of A. Wald and J. Wolfowitz, Ann. Math. Stat. 11 (1940) 147: the number of runs of equal sign against
/// that of independent residuals, in standard deviations; 0 if all have one sign.
fn runs_score(residuals: &[f64]) -> f64 {
    let above = residuals.iter().filter(|r| **r > 0.0).count() as f64;
    let below = residuals.len() as f64 - above;
    let all = above + below;
    let changes = residuals.windows(2);
    let changes = changes.filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0));
    let runs = 1.0 + changes.count() as f64;
    let mean = 1.0 + 2.0 * above * below / all;
    let variance = (mean - 1.0) * (mean - 2.0) / (all - 1.0);
    if variance > 0.0 {
        (runs - mean) / variance.sqrt()
    } else {
        0.0
    }
}

impl Report for FrictionFit {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let numbers = [
            ("mu_s", self.mu_s),
            ("mu_d", self.mu_d),
            ("stribeck_slope", self.stribeck_slope_s_per_m),
        ];
        let table = Table::of(numbers)
            .left("", |(name, _)| *name)
            .right("", |(_, number)| number.parts()[0].clone())
            .right("95 % ±", |(_, number)| number.parts()[1].clone())
            .left("", |(_, number)| number.unit);
        let deviation = significant(self.residual_deviation, 2);
        let mut residuals = format!("residuals: standard deviation {deviation}");
        if let Some(chi_square) = self.chi_square_per_degree {
            let [low, high] = self.chi_square_expected;
            let [found, low, high] = [chi_square, low, high].map(|number| significant(number, 2));
            residuals +=
                &format!(", chi-square per degree of freedom {found} ({low} to {high} expected)");
        }
        let rest = format!(", Eq. (5), fitted to {} points", self.points);
        let mut blocks = vec![
            Block::heading("Stribeck law", rest),
            table.into(),
            Block::text(residuals),
        ];
        let doubts = self.doubts.iter();
        blocks.extend(doubts.map(|doubt| Block::Warning(doubt.to_string())));
        let law = self.law();
        blocks.push(Block::Code(format!(
            "[friction]\nlaw = \"stribeck\"\nmu_s = {}\nmu_d = {}\nstribeck_slope_s_per_m = {}\ncreep_slope_s_per_m = {}\n",
            significant(law.mu_s, 6),
            significant(law.mu_d, 6),
            significant(law.stribeck, 6),
            law.creep
        )));
        blocks
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

    /// Whether the runs test and chi-square accept the law.
    fn describes_points(fit: &FrictionFit) -> bool {
        let [_, high] = fit.chi_square_expected;
        fit.runs_score >= -1.96 && fit.chi_square_per_degree.is_none_or(|found| found <= high)
    }

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
            // Eq. (5), and 95 % intervals.
            crate::report::agreement::check(&fit, &[5.0, 95.0]);
            let holds = |number: Measured, truth: f64| {
                usize::from((number.value - truth).abs() <= number.half_width)
            };
            inside[0] += holds(fit.mu_s, LAW.mu_s);
            inside[1] += holds(fit.mu_d, LAW.mu_d);
            inside[2] += holds(fit.stribeck_slope_s_per_m, LAW.stribeck);
            rejected += usize::from(!describes_points(&fit));
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
    fn an_increase_and_high_speeds_are_named() {
        let mut rising = points(0.001, 5);
        for point in &mut rising {
            point.coefficient = 0.2 + 0.5 * point.speed;
        }
        let refused = fit_friction(&rising, LAW.creep).unwrap_err();
        assert!(
            matches!(refused, FrictionFitError::NoDecrease { .. }),
            "{refused}"
        );
        let mut fast = points(0.01, 1);
        for point in &mut fast {
            point.speed *= 100.0;
        }
        let doubts = fit_friction(&fast, LAW.creep).unwrap().doubts;
        assert!(doubts[0].contains("if they are in mm/s"), "{doubts:?}");
    }

    #[test]
    fn a_constant_coefficient_has_no_significant_decrease() {
        let found = (0..400).filter(|seed| {
            let mut flat = points(0.01, *seed);
            for point in &mut flat {
                let error = point.coefficient - LAW.coefficient(point.speed);
                point.coefficient = -0.25 * (-LAW.creep * point.speed).exp_m1() + error;
            }
            !matches!(
                fit_friction(&flat, LAW.creep),
                Err(FrictionFitError::NoDecrease { .. })
            )
        });
        // 20 of 400 at the level of 5 %.
        let found = found.count();
        assert!(found <= 40, "{found}");
    }

    #[test]
    fn the_creep_factor_makes_no_decrease() {
        let mut flat = points(0.01, 6);
        for point in &mut flat {
            point.coefficient += 0.25 - LAW.coefficient(point.speed);
        }
        let fit = fit_friction(&flat, LAW.creep);
        assert!(
            matches!(fit, Err(FrictionFitError::NoDecrease { .. })),
            "{fit:?}"
        );
    }

    /// Points in the creep region, and deviations that are too small or too large.
    #[test]
    fn doubtful_fits_are_told_from_good_ones() {
        let fit = |slowest: f64, deviation: f64| {
            let mut measured = points(0.005, 8);
            measured.retain(|point| point.speed > slowest);
            for point in &mut measured {
                point.deviation = Some(deviation);
            }
            fit_friction(&measured, LAW.creep).unwrap()
        };
        let good = fit(5e-3, 0.005);
        assert!(
            good.doubts.is_empty() && describes_points(&good),
            "{good:?}"
        );
        // 2, 2.5, 3.1, 3.9 and 4.9 mm/s are below 5 mm/s.
        let slow = fit(0.0, 0.005);
        assert_eq!(slow.points_in_creep_region, 5);
        assert_eq!(slow.doubts.len(), 1, "{slow:?}");
        let (small, large) = (fit(5e-3, 0.002), fit(5e-3, 0.02));
        assert!(!describes_points(&small) && describes_points(&large));
        assert_eq!([small.doubts.len(), large.doubts.len()], [1, 1]);
    }

    #[test]
    fn another_law_is_detected_and_flat_points_are_refused() {
        let mut humped = points(0.001, 4);
        for point in &mut humped {
            let distance = (point.speed / 0.03).ln();
            point.coefficient += 0.05 * (-2.0 * distance * distance).exp();
        }
        assert!(!describes_points(
            &fit_friction(&humped, LAW.creep).unwrap()
        ));
        let mut flat = points(0.01, 5);
        for point in &mut flat {
            let error = point.coefficient - LAW.coefficient(point.speed);
            point.coefficient = -0.4 * (-LAW.creep * point.speed).exp_m1() + error;
        }
        let Err(FrictionFitError::NoDecrease { mu }) = fit_friction(&flat, LAW.creep) else {
            panic!("no decrease");
        };
        assert!((mu.value - 0.4).abs() < mu.half_width && mu.half_width < 0.01);
        assert_eq!(
            fit_friction(&flat[..5], LAW.creep),
            Err(FrictionFitError::TooFew { have: 5 })
        );
    }
}
