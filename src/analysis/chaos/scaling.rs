//! The straight part of a curve of mean logarithms of distances, found without an eye.
//!
//! Every stretch of the curve is a candidate that
//!
//! * ends before the curve first comes within a factor `e` of the largest distance it reaches:
//!   the end of growth bends it long before it is flat;
//! * has five points or more and lasts a Theiler window: within one turn of a flow distances
//!   swing, the rate is a mean over turns;
//! * grows by a factor of `e^1.5` or more, and by half of all the growth there is from the start
//!   to that end: neighbours first turn into the direction that grows, and a short piece of that
//!   is straight as well;
//! * is straight: the slope of a parabola through it differs at its ends from the middle by at
//!   most a quarter, and its points lie about the line by at most 5 % of its growth, root mean
//!   square. (The logarithm of time over a factor `e`, for comparison, bends by a half.)
//!
//! The region is the candidate with the largest length over mean square residual, the weight of
//! Deshmukh, Bradley, Garland and Meiss (Chaos 31, 123102, 2021); there is none if it bends by
//! more than an eighth. As theirs, the error comes from all candidates. It has two parts, added in
//! squares: the farthest slope of any candidate from the chosen one, over the root of 3, which is
//! the deviation if all within that reach is equally likely; and the scatter among stretches of
//! the signal (the method of batch means).

use serde::{Deserialize, Serialize};

/// The part of the curve that is a straight line.
///
/// It ends a factor `e` below the largest distance, grows by a factor of `e^1.5` at least and by
/// half of the growth up to there, lasts a Theiler window and bends by an eighth of its slope at
/// most; of all such stretches it is the one with the largest length over mean square residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScalingRegion {
    /// Begin of the region, samples.
    #[serde(rename = "from_s")]
    pub from: f64,
    /// End of the region, samples.
    #[serde(rename = "to_s")]
    pub to: f64,
    /// Slope, 1/sample: the largest exponent, per sample.
    #[serde(rename = "exponent_per_s")]
    pub slope: f64,
    /// Standard error of the slope, 1/sample: how far the slopes of other stretches lie that
    /// might be taken for the region (a bound, over the root of 3), and the scatter among 16
    /// parts of the signal, added in squares. Not in it: that flows of few samples come out low.
    #[serde(rename = "error_per_s")]
    pub error: f64,
    /// Value of the line at step 0.
    pub intercept: f64,
}

/// How far below its highest value the curve must stay, natural logarithm.
const BELOW_TOP: f64 = 1.0;

/// The least growth over a candidate, natural logarithm.
const LEAST_GROWTH: f64 = 1.5;

/// The least growth over a candidate as a share of what there is.
const LEAST_SHARE: f64 = 0.5;

/// Steps from the first to the last point of a candidate, at least.
const FEWEST_STEPS: usize = 4;

/// The most that the slope changes from the middle to the ends, over the slope: of a candidate,
/// and of the region.
const BENT: f64 = 0.25;
const STRAIGHT: f64 = 0.125;

/// Root mean square residual over growth, at most.
const ROUGH: f64 = 0.05;

/// Residuals below this are as good as none: 0.1 % of a distance.
const FINE: f64 = 1e-3;

/// Candidates begin and end on at most about so many points, evenly spread.
const ENDS: usize = 200;

/// A line of least squares through part of a curve.
#[derive(Clone, Copy)]
struct Line {
    from: usize,
    to: usize,
    slope: f64,
    intercept: f64,
    /// Root mean square.
    residual: f64,
    /// By how much a parabola's slope differs at the ends, over the slope.
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
        self.length() / self.residual.max(FINE).powi(2)
    }
}

/// Running sums over a curve, which give the line through any part of it at once.
struct Lines {
    /// Sums over all points before each of `y`, `k y`, `k^2 y`, `y^2`.
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

    /// The line through the points `from` to `to`, both included, at least three.
    fn line(&self, from: usize, to: usize) -> Line {
        let [y, ky, kky, yy] = std::array::from_fn(|s| self.sums[to + 1][s] - self.sums[from][s]);
        let n = (to - from + 1) as f64;
        // Of the steps t from the middle: the sums of t^2, and of (t^2 less its mean)^2.
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

/// The scaling region of a curve and its error; `blocks` are curves from parts of the data. It
/// lasts a Theiler window at least.
pub(super) fn scaling_region(
    curve: &[f64],
    blocks: &[Vec<f64>],
    theiler: usize,
) -> Option<ScalingRegion> {
    let shortest = theiler.max(FEWEST_STEPS);
    let top = curve.iter().copied().reduce(f64::max)? - BELOW_TOP;
    let below = curve.iter().position(|&y| y > top)?;
    let least = LEAST_GROWTH.max(LEAST_SHARE * (top - curve[0]));
    let lines = Lines::new(&curve[..below]);
    let ends = || (0..below).step_by(below.div_ceil(ENDS).max(1));
    let candidates: Vec<Line> = ends()
        .flat_map(|from| ends().map(move |to| (from, to)))
        .filter(|(from, to)| from + shortest <= *to)
        .map(|(from, to)| lines.line(from, to))
        .filter(|line| line.growth() >= least && line.residual <= ROUGH * line.growth())
        .filter(|line| line.bend <= BENT)
        .collect();
    let best = *candidates
        .iter()
        .max_by(|a, b| a.weight().total_cmp(&b.weight()))?;
    if best.bend > STRAIGHT {
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

/// The variance of the mean of the blocks' slopes over a region; `None` with fewer than two.
fn variance_of_mean(region: Line, blocks: &[Vec<f64>]) -> Option<f64> {
    let whole = blocks.iter().filter(|block| block.len() > region.to);
    let slopes: Vec<f64> = whole
        .map(|block| Lines::new(block).line(region.from, region.to).slope)
        .collect();
    let n = slopes.len() as f64;
    let mean = slopes.iter().sum::<f64>() / n;
    let squares: f64 = slopes.iter().map(|s| (s - mean).powi(2)).sum();
    (slopes.len() > 1).then(|| squares / (n * (n - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::test_signals::noise;

    /// Grows along a line and stops.
    fn ramp(slope: f64, stop: usize, n: usize) -> Vec<f64> {
        (0..n).map(|k| slope * k.min(stop) as f64 - 3.0).collect()
    }

    #[test]
    fn a_line_is_found_to_the_end_of_its_straight_part() {
        let curve = ramp(0.05, 100, 300);
        let blocks = vec![curve.clone(); 4];
        let region = scaling_region(&curve, &blocks, 1).unwrap();
        // 5 in all; the last 1 is left.
        assert_eq!((region.from, region.to), (0.0, 80.0));
        assert!((region.slope - 0.05).abs() < 1e-12);
        assert!((region.intercept + 3.0).abs() < 1e-10);
        assert!(region.error < 1e-12);
    }

    #[test]
    fn what_comes_before_the_line_is_left_out() {
        // Ten steps three times as steep, then a line.
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
    fn the_error_tells_the_scatter_of_the_blocks() {
        // Slopes 0.05 with a deviation of 0.01 over 16 blocks: 0.0025 of the mean.
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
    fn curves_without_a_line_have_no_region() {
        let none = |curve: &[f64]| scaling_region(curve, &vec![curve.to_vec(); 4], 1).is_none();
        assert!(none(&[]));
        assert!(none(&[1.0]));
        assert!(none(&[2.0; 100]));
        // All at once.
        let mut jump = vec![0.5; 100];
        jump[0] = -5.0;
        assert!(none(&jump));
        // Too little growth: 2.4, of which 1 is left.
        assert!(none(&ramp(0.04, 60, 100)));
        assert!(!none(&ramp(0.04, 70, 100)));
        // Falling.
        assert!(none(&ramp(-0.05, 100, 200)));
        // Growing like a power of time, as the distances of a random walk do.
        let power: Vec<f64> = (1..1000).map(|k| 1.5 * f64::from(k).ln()).collect();
        assert!(none(&power));
        // One block only.
        assert!(scaling_region(&ramp(0.05, 100, 300), &[ramp(0.05, 100, 300)], 1).is_none());
    }
}
