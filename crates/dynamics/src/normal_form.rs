//! The cubic term of the normal form of a bifurcation, for the rates of a flow at an equilibrium and for the return map at
//! an orbit.
//!
//! With the derivative `A`, the second and third derivatives `B` and `C`, the critical eigenvector `q` and its left
//! eigenvector `p`, `p* q = 1`, the coefficient of a pair of complex eigenvalues is (Kuznetsov, Elements of Applied
//! Bifurcation Theory, 3rd edition, Springer 2004, sections 5.4 and 9.5)
//!
//! ```text
//! p* [C(q, q, q*) + 2 B(q, (s - A)^-1 B(q, q*)) + B(q*, (d - A)^-1 B(q, q))] / 2
//! ```
//!
//! with `s = 0` and `d = 2 i omega` for a flow, and `s = 1` and `d = exp(2 i phi)` for a map. That of a period doubling is
//!
//! ```text
//! p* [C(q, q, q) + 3 B(q, (1 - A)^-1 B(q, q))] / 6
//! ```

use faer::linalg::solvers::PartialPivLu;
use faer::prelude::Solve;
use faer::{Mat, c64};
use nalgebra::DVector;

pub(crate) type RealVector = DVector<f64>;
pub(crate) type ComplexVector = DVector<c64>;

/// Second and third derivatives: `B(u, u)` and `C(u, u, u)` for a direction `u`; `None` if they cannot be evaluated.
pub(crate) type Derivatives<'a> = &'a mut dyn FnMut(&RealVector) -> Option<[RealVector; 2]>;

/// `B(a, b)`, from the sum and the difference of the directions.
fn second(of: Derivatives<'_>, a: &RealVector, b: &RealVector) -> Option<RealVector> {
    let size = a.norm() * b.norm();
    if size == 0.0 {
        return Some(RealVector::zeros(a.len()));
    }
    let (a, b) = (a.normalize(), b.normalize());
    let [sum, _] = of(&(&a + &b))?;
    let [difference, _] = of(&(a - b))?;
    Some((sum - difference) * (0.25 * size))
}

/// `B(a, b)` for complex directions.
fn complex_second(
    of: Derivatives<'_>,
    a: &ComplexVector,
    b: &ComplexVector,
) -> Option<ComplexVector> {
    let ([ar, ai], [br, bi]) = (parts(a), parts(b));
    let re = second(of, &ar, &br)? - second(of, &ai, &bi)?;
    let im = second(of, &ar, &bi)? + second(of, &ai, &br)?;
    Some(joined(&re, &im))
}

/// A critical eigenvalue.
pub(crate) struct Critical {
    /// Right eigenvector `q`.
    pub right: ComplexVector,
    /// Left eigenvector `p` with `p* q = 1`.
    pub left: ComplexVector,
    /// Factors of `s - A` and `d - A`.
    shifted: [PartialPivLu<c64>; 2],
}

impl Critical {
    /// An eigenvalue of a matrix, given by its entries, with the shifts `s` and `d`.
    pub fn new(
        [right, left]: [ComplexVector; 2],
        entry: impl Fn(usize, usize) -> f64,
        shifts: [c64; 2],
    ) -> Self {
        let n = right.len();
        let factors = |shift: c64| {
            let shifted = |i, j| if i == j { shift } else { c64::ZERO } - entry(i, j);
            Mat::from_fn(n, n, shifted).partial_piv_lu()
        };
        Self {
            right,
            left,
            shifted: shifts.map(factors),
        }
    }

    /// Solves with a shifted matrix.
    fn solved(&self, shift: usize, right: &ComplexVector) -> ComplexVector {
        let right = Mat::from_fn(right.len(), 1, |i, _| right[i]);
        let solution = self.shifted[shift].solve(&right);
        ComplexVector::from_fn(solution.nrows(), |i, _| solution[(i, 0)])
    }

    /// The coefficient of a pair, and the sum of the sizes of the terms of `p* C(q, q, q*)`.
    pub fn of_pair(&self, of: Derivatives<'_>) -> Option<(c64, f64)> {
        let [a, b] = parts(&self.right);
        let [aa, aaa] = of(&a)?;
        let [bb, bbb] = of(&b)?;
        let [sum2, sum3] = of(&(&a + &b))?;
        let [difference2, difference3] = of(&(&a - &b))?;
        let ab = (sum2 - difference2) * 0.25;
        let aab = (&sum3 - &difference3 - &bbb * 2.0) / 6.0;
        let abb = (sum3 + difference3 - &aaa * 2.0) / 6.0;
        // C(q, q, q*) of q = a + i b.
        let cubic = joined(&(aaa + abb), &(aab + bbb));
        let steady = self.solved(0, &joined(&(&aa + &bb), &RealVector::zeros(a.len())));
        let double = self.solved(1, &joined(&(aa - bb), &(ab * 2.0)));
        let with_steady = complex_second(of, &self.right, &steady)?;
        let with_double = complex_second(of, &self.right.map(|x| x.conj()), &double)?;
        let terms = self.left.iter().zip(&cubic);
        let size = terms.map(|(p, c)| p.norm() * c.norm()).sum();
        let total = cubic + with_steady * c64::new(2.0, 0.0) + with_double;
        Some((self.left.dotc(&total) * 0.5, size))
    }

    /// The coefficient of a period doubling.
    pub fn of_flip(&self, of: Derivatives<'_>) -> Option<f64> {
        let [a, _] = parts(&self.right);
        let zero = RealVector::zeros(a.len());
        let [quadratic, cubic] = of(&a)?;
        let [steady, _] = parts(&self.solved(0, &joined(&quadratic, &zero)));
        let total = cubic + second(of, &a, &steady)? * 3.0;
        Some(self.left.dotc(&joined(&total, &zero)).re / 6.0)
    }
}

/// Real and imaginary part.
fn parts(vector: &ComplexVector) -> [RealVector; 2] {
    [vector.map(|x| x.re), vector.map(|x| x.im)]
}

fn joined(re: &RealVector, im: &RealVector) -> ComplexVector {
    re.zip_map(im, c64::new)
}
