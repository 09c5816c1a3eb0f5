//! Derivatives of a matrix with respect to a parameter.

use faer::{Mat, Scale};

/// Number of step sizes.
const LEVELS: usize = 6;
/// Ratio of successive steps.
const RATIO: f64 = 2.0;

/// The derivative of a matrix at zero, and its error: the largest change of an entry between the two best
/// extrapolations. The steps halve from `first` on, and the differences are extrapolated to step zero (Ridders, Adv.
/// Eng. Software 4 (1982) 75); the extrapolation with the smallest error estimate is the result.
/// Where `of` fails on one side only, at the end of a range, one-sided differences take over.
///
/// # Errors
/// The error of `of`, if it fails at zero or on both sides.
pub fn derivative<E>(
    first: f64,
    mut of: impl FnMut(f64) -> Result<Mat<f64>, E>,
) -> Result<(Mat<f64>, f64), E> {
    let here = of(0.0)?;
    let mut table: Vec<Mat<f64>> = Vec::new();
    let mut best: Option<(Mat<f64>, f64)> = None;
    for level in 0..LEVELS {
        let step = first / RATIO.powi(level as i32);
        let (start, order) = match (of(step), of(-step)) {
            (Ok(up), Ok(down)) => (Scale(0.5 / step) * (up - down), 2),
            (Ok(up), Err(_)) => (Scale(1.0 / step) * (up - &here), 1),
            (Err(_), Ok(down)) => (Scale(1.0 / step) * (&here - down), 1),
            (Err(error), Err(_)) => return Err(error),
        };
        // One row of the extrapolation table; differences of central steps have even powers only.
        let mut row = vec![start];
        for (k, coarser) in table.iter().enumerate() {
            let weight = RATIO.powi(order * (k as i32 + 1));
            let next = Mat::from_fn(here.nrows(), here.ncols(), |i, j| {
                (weight * row[k][(i, j)] - coarser[(i, j)]) / (weight - 1.0)
            });
            row.push(next);
        }
        for k in 1..row.len() {
            let change = |other: &Mat<f64>| (&row[k] - other).norm_max();
            let error = change(&row[k - 1]).max(change(&table[k - 1]));
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((row[k].clone(), error));
            }
        }
        table = row;
    }
    Ok(best.unwrap_or_else(|| (table.remove(0), f64::INFINITY)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivative_of_smooth_entries_has_ten_digits() {
        let of = |x: f64| Ok::<_, ()>(Mat::from_fn(1, 2, |_, j| [(3.0 + x).exp(), x.sin()][j]));
        let (found, error) = derivative(0.1, of).unwrap();
        let exact = 3.0_f64.exp();
        assert!((found[(0, 0)] - exact).abs() < 1e-10 * exact, "{found:?}");
        assert!((found[(0, 1)] - 1.0).abs() < 1e-10);
        assert!(error < 1e-8 * exact);
    }

    #[test]
    fn the_end_of_a_range_has_one_sided_differences() {
        let of = |x: f64| {
            if x < 0.0 {
                Err("out of range")
            } else {
                Ok(Mat::from_fn(1, 1, |_, _| (1.0 + x).powi(3)))
            }
        };
        let (found, _) = derivative(0.1, of).unwrap();
        assert!((found[(0, 0)] - 3.0).abs() < 1e-9, "{found:?}");
        assert!(derivative(0.1, |_| Err::<Mat<f64>, _>("nowhere")).is_err());
    }
}
