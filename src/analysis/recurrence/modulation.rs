//! Slow modulations of the heights of successive stripes of a recurrence plot.
//!
//! On a torus the recurrence rate over the offset is an even quasi-periodic function: the height of the
//! stripe at the multiple `j` of the finest spacing is `g(a j)` with an even function `g` of period 1, and
//! `1 / a` is the beat in multiples of the finest spacing. The function has its largest value at 0, because
//! the motion then returns closest. Its cosine series is fitted one line at a time.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex};

use crate::analysis::mean;

/// Maximum number of lines fitted.
const MAX_LINES: usize = 12;
/// Minimum ratio of the variance of a line to that of a residual.
const MIN_F: f64 = 25.0;
/// Minimum peak-to-peak modulation relative to the mean height.
const MIN_DEPTH: f64 = 0.1;
/// Minimum number of cycles of a modulation within the plot.
const MIN_CYCLES: f64 = 2.0;
/// Minimum share of the variance of the heights that the modulations explain.
const MIN_EXPLAINED: f64 = 0.75;
/// Minimum share of the variance of the heights that a further modulation explains; the sampling of narrow
/// stripes by whole diagonals causes smaller lines.
const MIN_GAIN: f64 = 0.05;
/// Highest order of a combination of modulations.
const MAX_ORDER: i32 = 12;
/// Frequencies of the grid per cycle within the plot.
const GRID: usize = 16;
/// Least square of the part of a cosine that is orthogonal to the basis. A smaller one is rounding error.
const MIN_SQUARE: f64 = 1e-6;

/// A modulation of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    /// Cycles per stripe, above 0, at most 0.5.
    pub frequency: f64,
    /// Standard uncertainty of the frequency.
    pub uncertainty: f64,
    /// Whether twice the frequency belongs to the modulations found before, or is 1.
    pub doubled: bool,
}

/// A line of the cosine series.
#[derive(Clone, Copy, Debug)]
struct Line {
    frequency: f64,
    amplitude: f64,
    /// Decrease of the sum of squares.
    gain: f64,
    /// Amplitude in the farther half of the plot.
    farther: f64,
    uncertainty: f64,
}

impl Line {
    /// Whether the motion returns closer at the multiples of the period of the line, far ones, too.
    fn is_return(&self, mean: f64) -> bool {
        2.0 * self.amplitude >= MIN_DEPTH * mean && self.farther > 0.0
    }
}

/// Residual of a least-squares fit on an orthonormal basis.
#[derive(Clone, Debug)]
struct Fit {
    /// Mean height.
    mean: f64,
    weights: Vec<f64>,
    basis: Vec<Vec<f64>>,
    residual: Vec<f64>,
}

impl Fit {
    /// A fit of a constant and a linear trend.
    fn new(heights: &[f64]) -> Self {
        let count = heights.len();
        // The number of pairs falls along the plot to a tenth.
        let weight = |j: usize| (1.0 - 0.9 * j as f64 / count as f64).sqrt();
        let weights: Vec<f64> = (0..count).map(weight).collect();
        let residual = heights.iter().zip(&weights).map(|(h, w)| h * w).collect();
        let mut fit = Self {
            mean: mean(heights),
            weights,
            basis: Vec::new(),
            residual,
        };
        fit.remove(fit.weights.clone());
        let trend = (0..count).map(|j| j as f64 * fit.weights[j]).collect();
        fit.remove(trend);
        fit
    }

    /// The part of a function orthogonal to the basis.
    fn orthogonal(&self, mut function: Vec<f64>) -> Vec<f64> {
        for known in &self.basis {
            let along = dot(known, &function);
            let pairs = function.iter_mut().zip(known);
            pairs.for_each(|(value, known)| *value -= along * known);
        }
        function
    }

    /// Adds a function to the fit.
    fn remove(&mut self, function: Vec<f64>) {
        let mut new = self.orthogonal(function);
        let norm = dot(&new, &new).sqrt();
        if norm > 1e-9 {
            new.iter_mut().for_each(|value| *value /= norm);
            let along = dot(&new, &self.residual);
            let pairs = self.residual.iter_mut().zip(&new);
            pairs.for_each(|(value, new)| *value -= along * new);
            self.basis.push(new);
        }
    }

    fn squares(&self) -> f64 {
        dot(&self.residual, &self.residual)
    }

    fn cosine(&self, frequency: f64) -> Vec<f64> {
        let at = |(j, weight): (usize, &f64)| weight * (TAU * frequency * j as f64).cos();
        (1..).zip(&self.weights).map(at).collect()
    }

    /// Decrease of the sum of squares by a cosine, and its amplitude.
    fn gain(&self, frequency: f64) -> (f64, f64) {
        let new = self.orthogonal(self.cosine(frequency));
        let (product, square) = (dot(&new, &self.residual), dot(&new, &new));
        match square > MIN_SQUARE {
            true => (product * product / square, product / square),
            false => (0.0, 0.0),
        }
    }

    /// The strongest line, if it is significant. `grid`: that of the weights of this fit.
    fn strongest(&self, grid: &mut Grid) -> Option<Line> {
        let count = self.residual.len();
        let step = 1.0 / (GRID * count) as f64;
        let gains = grid.gains(self).into_iter().enumerate();
        let (nearest, _) = gains.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let near = 0.5 - nearest as f64 * step;
        let frequency = maximum(near - step, near + step, |f| self.gain(f).0).min(0.5);
        let line = self.line(frequency);
        let freedom = count as f64 - self.basis.len() as f64 - 2.0;
        let rest = (self.squares() - line.gain).max(0.0);
        (freedom > 3.0 && line.gain * freedom > MIN_F * rest).then_some(line)
    }

    /// The line at a frequency.
    fn line(&self, frequency: f64) -> Line {
        let count = self.residual.len();
        let (gain, amplitude) = self.gain(frequency);
        let cosine = self.orthogonal(self.cosine(frequency));
        let (far, residual) = (&cosine[count / 2..], &self.residual[count / 2..]);
        let freedom = (count as f64 - self.basis.len() as f64 - 2.0).max(1.0);
        // Cramer-Rao bound of the frequency of a cosine of known phase.
        let deviation = ((self.squares() - gain).max(0.0) / freedom).sqrt();
        let slope = TAU * amplitude.abs() * (count as f64).powf(1.5) / 6f64.sqrt();
        Line {
            frequency,
            amplitude,
            gain,
            farther: dot(far, residual) / dot(far, far).max(f64::MIN_POSITIVE),
            uncertainty: deviation / slope,
        }
    }
}

/// Gains of the cosines of all frequencies `0.5 - k / (GRID count)` with at least [`MIN_CYCLES`] less a half
/// within the plot.
///
/// `cos(2 pi f j)` is then `(-1)^j cos(2 pi j k / (GRID count))`: the products of a function with all cosines
/// are one Fourier transform.
struct Grid {
    transform: Arc<dyn RealToComplex<f64>>,
    /// Square of the part of each cosine that is orthogonal to the basis.
    squares: Vec<f64>,
    /// Number of functions of the basis in the squares.
    known: usize,
}

impl Grid {
    fn new(weights: &[f64]) -> Self {
        let count = weights.len();
        let transform = RealFftPlanner::new().plan_fft_forward(GRID * count);
        let least = (MIN_CYCLES - 0.5) * GRID as f64;
        let size = ((GRID * count) as f64 * 0.5 - least).max(0.0) as usize + 1;
        let mut grid = Self {
            transform,
            squares: vec![0.0; size],
            known: 0,
        };
        // cos^2 x = (1 + cos 2 x) / 2
        let doubled = grid.transformed(weights.iter().map(|w| w * w));
        let constant = weights.iter().map(|w| w * w).sum::<f64>();
        for (k, square) in grid.squares.iter_mut().enumerate() {
            let twice = (2 * k).min(GRID * count - 2 * k);
            *square = 0.5 * (constant + doubled[twice]);
        }
        grid
    }

    /// Sums of the values 1, 2, ... times `cos(2 pi j k / (GRID count))`.
    fn transformed(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut input = self.transform.make_input_vec();
        let mut output = self.transform.make_output_vec();
        input[1..]
            .iter_mut()
            .zip(values)
            .for_each(|(x, value)| *x = value);
        self.transform
            .process(&mut input, &mut output)
            .expect("the buffers have the lengths of the plan");
        output.iter().map(|sum| sum.re).collect()
    }

    /// Products of a function with the weighted cosines.
    fn products(&self, fit: &Fit, function: &[f64]) -> Vec<f64> {
        let weighted = function.iter().zip(&fit.weights).map(|(x, w)| x * w);
        let signs = [-1.0, 1.0].into_iter().cycle();
        self.transformed(weighted.zip(signs).map(|(x, sign)| sign * x))
    }

    /// Decrease of the sum of squares of a fit by each cosine. The fit has the weights of the grid and all
    /// functions of the fits before.
    fn gains(&mut self, fit: &Fit) -> Vec<f64> {
        for new in &fit.basis[self.known..] {
            let products = self.products(fit, new);
            for (square, along) in self.squares.iter_mut().zip(products) {
                *square -= along * along;
            }
        }
        self.known = fit.basis.len();
        // The residual is orthogonal to the basis.
        let products = self.products(fit, &fit.residual);
        let gain = |(square, product): (&f64, f64)| match *square > MIN_SQUARE {
            true => product * product / square,
            false => 0.0,
        };
        self.squares.iter().zip(products).map(gain).collect()
    }
}

/// The modulations of the heights of the stripes 1, 2, ...: frequencies that are not harmonics, sums or
/// differences of those found before. None if they do not explain most of the variance, as in chaos.
pub fn modulations(heights: &[f64]) -> Vec<Modulation> {
    let mut found: Vec<Modulation> = Vec::new();
    let mut fit = Fit::new(heights);
    let mut grid = Grid::new(&fit.weights);
    let all = fit.squares();
    let tolerance = 0.25 / heights.len() as f64;
    for _ in 0..MAX_LINES {
        let Some(line) = fit.strongest(&mut grid) else {
            break;
        };
        let half = 0.5 - line.frequency <= tolerance;
        let frequency = if half { 0.5 } else { line.frequency };
        let harmonic = is_combination(frequency, &found, tolerance);
        // The half of a combination may be a doubling, which is examined afterwards.
        if !harmonic && !found.is_empty() && is_combination(2.0 * frequency, &found, tolerance) {
            break;
        }
        let is_resolved = |a: f64, b: f64| (a - b).abs() * heights.len() as f64 >= MIN_CYCLES;
        let new = !harmonic
            && line.is_return(fit.mean)
            && line.gain >= MIN_GAIN * all
            && found.iter().all(|m| is_resolved(frequency, m.frequency));
        fit.remove(fit.cosine(frequency));
        if new {
            found.push(Modulation {
                frequency,
                uncertainty: if half { 0.0 } else { line.uncertainty },
                doubled: half,
            });
        } else if !harmonic && found.is_empty() {
            break;
        }
    }
    if fit.squares() > (1.0 - MIN_EXPLAINED) * all {
        found.clear();
    }
    let mut bases: Vec<Modulation> = found.clone();
    let whole = Modulation {
        frequency: 1.0,
        uncertainty: 0.0,
        doubled: false,
    };
    bases.extend(Some(whole).filter(|_| !found.iter().any(|m| m.frequency == 0.5)));
    while let Some(base) = bases.pop() {
        if let Some(doubled) = doubling(&mut fit, base) {
            found.push(doubled);
            bases.push(doubled);
        }
    }
    let slow = found.iter().filter_map(|base| slow_return(heights, base));
    let slow: Vec<Modulation> = slow.collect();
    found.extend(slow);
    found
}

/// The modulation at half a known frequency, by the first odd multiples of the half; removed from the fit.
fn doubling(fit: &mut Fit, base: Modulation) -> Option<Modulation> {
    let half = 0.5 * base.frequency;
    let count = fit.residual.len() as f64;
    if half * count < MIN_CYCLES - 0.5 {
        return None;
    }
    let mut trial = fit.clone();
    let (mut gain, mut height, mut farther) = (0.0, 0.0, 0.0);
    let mut fitted: Vec<f64> = Vec::new();
    for odd in [1.0, 3.0, 5.0] {
        // The heights are sampled once per stripe: frequencies that differ by a whole number are equal.
        let folded = off_integer(odd * half);
        if fitted
            .iter()
            .any(|known| (known - folded).abs() * count < MIN_CYCLES)
        {
            continue;
        }
        fitted.push(folded);
        let line = trial.line(odd * half);
        gain += line.gain;
        height += line.amplitude;
        farther += line.farther;
        trial.remove(trial.cosine(odd * half));
    }
    let freedom = count - trial.basis.len() as f64;
    let line = Line {
        frequency: half,
        amplitude: height,
        farther,
        gain,
        uncertainty: 0.5 * base.uncertainty,
    };
    if !(gain * freedom > MIN_F * trial.squares() && line.is_return(fit.mean)) {
        return None;
    }
    *fit = trial;
    Some(Modulation {
        frequency: half,
        uncertainty: line.uncertainty,
        doubled: true,
    })
}

/// The slow return of a modulation whose period is close to, but not, a whole number of stripes: its returns
/// fall between the stripes and are less than half as high there.
fn slow_return(heights: &[f64], base: &Modulation) -> Option<Modulation> {
    let whole = (1.0 / base.frequency).round();
    let frequency = (1.0 - whole * base.frequency).abs();
    let cycles = frequency * heights.len() as f64;
    if base.doubled || cycles < MIN_CYCLES || frequency > 0.5 * base.frequency {
        return None;
    }
    let mean = |inside: std::ops::Range<f64>| {
        let off = |j: &(usize, &f64)| off_integer(j.0 as f64 * base.frequency) / base.frequency;
        let chosen = (1..).zip(heights).filter(|j| inside.contains(&off(j)));
        let (count, sum) = chosen.fold((0.0, 0.0), |(n, sum), (_, h)| (n + 1.0, sum + h));
        sum / f64::max(count, 1.0)
    };
    // At most half a stripe away.
    let (near, far) = (mean(0.0..0.125), mean(0.375..0.5));
    (far > 0.0 && 2.0 * far < near).then_some(Modulation {
        frequency,
        uncertainty: whole * base.uncertainty,
        doubled: false,
    })
}

/// Distance of a number from the nearest integer.
fn off_integer(x: f64) -> f64 {
    (x - x.round()).abs()
}

/// Whether a frequency is a combination of low order of known ones.
fn is_combination(frequency: f64, known: &[Modulation], tolerance: f64) -> bool {
    let Some((first, others)) = known.split_first() else {
        return false;
    };
    let near = |frequency: f64| off_integer(frequency) <= tolerance;
    let combined = |order: i32, other: &Modulation| {
        (-order..=order).any(|n| {
            [order - n.abs(), n.abs() - order].into_iter().any(|m| {
                near(frequency - f64::from(m) * first.frequency - f64::from(n) * other.frequency)
            })
        })
    };
    (1..=MAX_ORDER).any(|order| {
        let multiple = f64::from(order) * first.frequency;
        near(frequency - multiple)
            || near(frequency + multiple)
            || others.iter().any(|other| combined(order, other))
    })
}

/// Position of the maximum of a smooth function with one maximum in an interval, by the golden section.
fn maximum(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let inner = |low: f64, high: f64| SECTION * (high - low);
    let [mut left, mut right] = [high - inner(low, high), low + inner(low, high)];
    let [mut at_left, mut at_right] = [value(left), value(right)];
    // Reduces the interval to 1e-7 of its length.
    for _ in 0..34 {
        if at_left < at_right {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + inner(low, high);
            at_right = value(right);
        } else {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - inner(low, high);
            at_left = value(left);
        }
    }
    0.5 * (low + high)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
