//! Automatic search for the scaling region, the straight part of a divergence curve.
//!
//! A candidate is a section of the curve that
//!
//! * ends before the curve first comes within a factor `e` of its largest distance, because saturation
//!   bends the curve long before it is flat;
//! * has at least five points and lasts at least a Theiler window: distances oscillate within one period
//!   of a flow, and the exponent is a mean over periods;
//! * grows by a factor of at least `e^1.5`, and by at least half of the total growth from the start to
//!   that end: neighbours first align with the direction of growth, and a short section of that is
//!   straight as well;
//! * is straight: the slope of a parabola fitted to it differs at the ends from the middle by at most a
//!   quarter, and the root-mean-square residual is at most 5 % of the growth. (For comparison, the
//!   logarithm of time over a factor `e` bends by a half.)
//!
//! The scaling region is the candidate with the largest ratio of length to mean square residual, the
//! weight of Deshmukh, Bradley, Garland and Meiss (Chaos 31, 123102, 2021). There is no region if it
//! bends by more than an eighth. As in that paper, the error comes from all candidates. It has two
//! parts, added in quadrature: the largest difference of any candidate's slope from the chosen one,
//! divided by the root of 3 (the standard deviation of a uniform distribution of that half-width); and
//! the scatter among sections of the signal (the method of batch means).

use schemars::JsonSchema;
use serde::Serialize;

use crate::stats::mean;

/// Scaling region: the straight part of a divergence curve.
///
/// It ends a factor `e` below the largest distance, grows by a factor of at least `e^1.5` and by at
/// least half of the growth up to there, lasts at least a Theiler window and bends by at most an eighth
/// of its slope. Of all such sections it has the largest ratio of length to mean square residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ScalingRegion {
    /// Start of the region, samples (s in output).
    #[serde(rename = "from_s")]
    pub from: f64,
    /// End of the region, samples (s in output).
    #[serde(rename = "to_s")]
    pub to: f64,
    /// Slope, 1/sample (1/s in output): the largest Lyapunov exponent.
    #[serde(rename = "exponent_per_s")]
    pub slope: f64,
    /// Standard error of the slope, 1/sample (1/s in output): the largest difference from the slopes of
    /// other candidates (divided by the square root of 3) and the scatter among 16 sections of the signal,
    /// added in quadrature. It does not include the downward bias for flows with few samples.
    #[serde(rename = "error_per_s")]
    pub error: f64,
    /// Ordinate of the line at step 0.
    pub intercept: f64,
}

/// Distance of the region below the maximum of the curve, natural logarithm.
const SATURATION_MARGIN: f64 = 1.0;

/// Minimum growth over a candidate, natural logarithm.
const MIN_GROWTH: f64 = 1.5;

/// Minimum growth over a candidate as a share of the total growth.
const MIN_GROWTH_SHARE: f64 = 0.5;

/// Minimum number of steps from the first to the last point of a candidate.
const MIN_STEPS: usize = 4;

/// Maximum relative change of the slope from the middle to the ends, of a candidate and of the region.
const MAX_CANDIDATE_BEND: f64 = 0.25;
const MAX_REGION_BEND: f64 = 0.125;

/// Maximum root-mean-square residual over growth.
const MAX_RESIDUAL: f64 = 0.05;

/// Smaller residuals are treated as this one: 0.1 % of a distance.
const RESIDUAL_FLOOR: f64 = 1e-3;

/// Approximate number of points, evenly spread, on which candidates start and end.
const MAX_ENDS: usize = 200;

/// Least-squares line through a section of the curve.
#[derive(Clone, Copy)]
struct Line {
    from: usize,
    to: usize,
    slope: f64,
    intercept: f64,
    /// Root mean square.
    residual: f64,
    /// Relative difference of the slope of a fitted parabola at the ends.
    bend: f64,
}

impl Line {
    fn length(&self) -> f64 {
        (self.to - self.from) as f64
    }

    fn growth(&self) -> f64 {
        self.slope * self.length()
    }

    fn weight(&self) -> f64 {
        self.length() / self.residual.max(RESIDUAL_FLOOR).powi(2)
    }
}

/// Running sums over a curve, which give the line through any section in constant time.
struct Lines {
    /// Sums over all preceding points of `y`, `k y`, `k^2 y`, `y^2`.
    sums: Vec<[f64; 4]>,
}

impl Lines {
    fn new(curve: &[f64]) -> Self {
        let mut sum = [0.0; 4];
        let mut sums = vec![sum];
        sums.extend(curve.iter().enumerate().map(|(k, y)| {
            let k = k as f64;
            for (sum, more) in sum.iter_mut().zip([*y, k * y, k * k * y, y * y]) {
                *sum += more;
            }
            sum
        }));
        Self { sums }
    }

    /// Line through the points `from` to `to` inclusive, at least three.
    fn line(&self, from: usize, to: usize) -> Line {
        let [y, ky, kky, yy] = std::array::from_fn(|s| self.sums[to + 1][s] - self.sums[from][s]);
        let n = (to - from + 1) as f64;
        // With t the step from the middle: the sums of t^2 and of (t^2 minus its mean)^2.
        let middle = 0.5 * (from + to) as f64;
        let second = n * (n * n - 1.0) / 12.0;
        let fourth = second * (n * n - 4.0) / 15.0;
        let slope = (ky - middle * y) / second;
        let tty = kky - 2.0 * middle * ky + middle * middle * y;
        let curvature = (tty - second * y / n) / fourth;
        let squares = yy - y * y / n - slope * slope * second;
        Line {
            from,
            to,
            slope,
            intercept: y / n - slope * middle,
            residual: (squares.max(0.0) / n).sqrt(),
            bend: (curvature * (to - from) as f64 / slope).abs(),
        }
    }
}

/// Scaling region of a curve and its error. `blocks` are curves of sections of the data. The region
/// lasts at least a Theiler window.
pub(super) fn scaling_region(
    curve: &[f64],
    blocks: &[Vec<f64>],
    theiler: usize,
) -> Option<ScalingRegion> {
    let shortest = theiler.max(MIN_STEPS);
    let top = curve.iter().copied().reduce(f64::max)? - SATURATION_MARGIN;
    let below = curve.iter().position(|&y| y > top)?;
    let min_growth = MIN_GROWTH.max(MIN_GROWTH_SHARE * (top - curve[0]));
    let lines = Lines::new(&curve[..below]);
    let ends = || (0..below).step_by(below.div_ceil(MAX_ENDS).max(1));
    let candidates: Vec<Line> = ends()
        .flat_map(|from| ends().map(move |to| (from, to)))
        .filter(|(from, to)| from + shortest <= *to)
        .map(|(from, to)| lines.line(from, to))
        .filter(|line| line.growth() >= min_growth && line.residual <= MAX_RESIDUAL * line.growth())
        .filter(|line| line.bend <= MAX_CANDIDATE_BEND)
        .collect();
    let best = *candidates
        .iter()
        .max_by(|a, b| a.weight().total_cmp(&b.weight()))?;
    if best.bend > MAX_REGION_BEND {
        return None;
    }
    let farthest = candidates
        .iter()
        .map(|line| (line.slope - best.slope).abs())
        .fold(0.0, f64::max);
    let among_candidates = farthest * farthest / 3.0;
    Some(ScalingRegion {
        from: best.from as f64,
        to: best.to as f64,
        slope: best.slope,
        error: (among_candidates + variance_of_mean(best, blocks)?).sqrt(),
        intercept: best.intercept,
    })
}

/// Variance of the mean of the blocks' slopes over a region; `None` with fewer than two blocks.
fn variance_of_mean(region: Line, blocks: &[Vec<f64>]) -> Option<f64> {
    let long_enough = blocks.iter().filter(|block| block.len() > region.to);
    let slopes: Vec<f64> = long_enough
        .map(|block| Lines::new(block).line(region.from, region.to).slope)
        .collect();
    let n = slopes.len() as f64;
    let mean = mean(&slopes);
    let squares: f64 = slopes.iter().map(|s| (s - mean).powi(2)).sum();
    (slopes.len() > 1).then(|| squares / (n * (n - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::noise;

    /// Grows linearly up to `stop`, then stays constant.
    fn ramp(slope: f64, stop: usize, n: usize) -> Vec<f64> {
        (0..n).map(|k| slope * k.min(stop) as f64 - 3.0).collect()
    }

    #[test]
    fn the_region_extends_to_the_end_of_the_straight_part() {
        let curve = ramp(0.05, 100, 300);
        let blocks = vec![curve.clone(); 4];
        let region = scaling_region(&curve, &blocks, 1).unwrap();
        // The total growth is 5; the last 1 is excluded.
        assert_eq!((region.from, region.to), (0.0, 80.0));
        assert!((region.slope - 0.05).abs() < 1e-12);
        assert!((region.intercept + 3.0).abs() < 1e-10);
        assert!(region.error < 1e-12);
    }

    #[test]
    fn the_initial_transient_is_excluded() {
        // Ten steps with three times the slope, then a line.
        let bend = |k: usize| {
            if k < 10 {
                0.15 * k as f64
            } else {
                1.0 + 0.05 * k as f64
            }
        };
        let curve: Vec<f64> = (0..200).map(|k| bend(k.min(120))).collect();
        let region = scaling_region(&curve, &vec![curve.clone(); 2], 1).unwrap();
        assert!((9.0..=11.0).contains(&region.from), "{region:?}");
        assert!((region.slope - 0.05).abs() < 1e-4, "{region:?}");
    }

    #[test]
    fn the_error_is_the_scatter_of_the_blocks() {
        // Slopes of 0.05 with a deviation of 0.01 over 16 blocks: 0.0025 for the mean.
        let slopes: Vec<f64> = noise(5, 16, 0.01).iter().map(|d| 0.05 + d).collect();
        let blocks: Vec<Vec<f64>> = slopes.iter().map(|s| ramp(*s, 100, 300)).collect();
        let mean: Vec<f64> = (0..300)
            .map(|k| blocks.iter().map(|b| b[k]).sum::<f64>() / 16.0)
            .collect();
        let region = scaling_region(&mean, &blocks, 1).unwrap();
        let exact = slopes.iter().sum::<f64>() / 16.0;
        assert!((region.slope - exact).abs() < 1e-9);
        let variance = slopes.iter().map(|s| (s - exact).powi(2)).sum::<f64>() / (16.0 * 15.0);
        assert!((region.error / variance.sqrt() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn curves_without_a_straight_part_have_no_region() {
        let none = |curve: &[f64]| scaling_region(curve, &vec![curve.to_vec(); 4], 1).is_none();
        assert!(none(&[]));
        assert!(none(&[1.0]));
        assert!(none(&[2.0; 100]));
        // All growth in one step.
        let mut jump = vec![0.5; 100];
        jump[0] = -5.0;
        assert!(none(&jump));
        // Growth of 2.4, of which the last 1 is excluded, is too small.
        assert!(none(&ramp(0.04, 60, 100)));
        assert!(!none(&ramp(0.04, 70, 100)));
        // Decreasing.
        assert!(none(&ramp(-0.05, 100, 200)));
        // Growth like a power of time, as for the distances of a random walk.
        let power: Vec<f64> = (1..1000).map(|k| 1.5 * f64::from(k).ln()).collect();
        assert!(none(&power));
        // One block only.
        assert!(scaling_region(&ramp(0.05, 100, 300), &[ramp(0.05, 100, 300)], 1).is_none());
    }
}
