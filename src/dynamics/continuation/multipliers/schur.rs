//! The periodic QR iteration with single complex shifts.
//!
//! The product is written as `H R_p ... R_1`: an upper Hessenberg matrix, which is unitary up to rounding, and upper
//! triangular factors. All magnitudes are in the triangular factors, so a subdiagonal element of `H` is negligible if it
//! is small compared with 1, whatever the range of the eigenvalues. A rotation of the rows of `H` is a rotation of the
//! columns of `R_1`, whose triangle is restored by a rotation of its rows, and so on to the columns of `H`.

use std::ops::RangeInclusive;

use nalgebra::DMatrix;

use super::super::Multiplier;
use super::rotation::{C64, Rotation, Square};

/// Failure of the iteration for the multipliers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the periodic Schur decomposition did not converge")]
pub struct SchurError;

/// Maximum number of iterations per eigenvalue.
const MAX_ITERATIONS: usize = 60;

/// Iterations after which an exceptional shift breaks a cycle.
const EXCEPTIONAL: usize = 12;

/// The factors of the product.
pub struct PeriodicSchur {
    n: usize,
    /// Upper Hessenberg.
    hessenberg: Square,
    /// Upper triangular; the first one is applied first.
    triangles: Vec<Square>,
    /// Magnitude below which a diagonal element of a triangle is a rounding error.
    negligible: Vec<f64>,
}

/// A complex number with a large range: `value e^ln_scale`.
#[derive(Clone, Copy)]
struct Scaled {
    value: C64,
    ln_scale: f64,
}

impl PeriodicSchur {
    /// Reduces the product of real matrices (row-major) to Hessenberg-triangular form.
    pub fn new(n: usize, factors: &[Vec<f64>]) -> Result<Self, SchurError> {
        let mut q = DMatrix::<f64>::identity(n, n);
        let mut triangles = Vec::with_capacity(factors.len());
        for factor in factors {
            assert_eq!(factor.len(), n * n, "the factors are n x n");
            if factor.iter().any(|x| !x.is_finite()) {
                return Err(SchurError);
            }
            let qr = (DMatrix::from_row_slice(n, n, factor) * &q).qr();
            let r = qr.r();
            let mut triangle = Square::zeros(n);
            for i in 0..n {
                for j in i..n {
                    triangle.set(i, j, C64::new(r[(i, j)], 0.0));
                }
            }
            triangles.push(triangle);
            q = qr.q();
        }
        let mut hessenberg = Square::zeros(n);
        for i in 0..n {
            for j in 0..n {
                hessenberg.set(i, j, C64::new(q[(i, j)], 0.0));
            }
        }
        let rounding = 4.0 * n as f64 * f64::EPSILON;
        let mut schur = Self {
            n,
            hessenberg,
            negligible: triangles.iter().map(|t| rounding * t.largest()).collect(),
            triangles,
        };
        schur.reduce();
        Ok(schur)
    }

    /// Makes the first matrix upper Hessenberg.
    fn reduce(&mut self) {
        let n = self.n;
        for column in 0..n.saturating_sub(2) {
            for row in (column + 2..n).rev() {
                let h = &self.hessenberg;
                let rotation = Rotation::to_zero(h.at(row - 1, column), h.at(row, column));
                self.rotate(row - 1, rotation, 0..=n - 1);
                self.hessenberg.set(row, column, C64::new(0.0, 0.0));
            }
        }
    }

    /// Applies a rotation of the coordinates `i` and `i + 1` to the product, within a diagonal block.
    fn rotate(&mut self, i: usize, rotation: Rotation, block: RangeInclusive<usize>) {
        let columns = *block.start()..*block.end() + 1;
        self.hessenberg.rotate_rows(i, rotation, columns);
        let last = self.pass_triangles(i, rotation, block.clone());
        let rows = *block.start()..*block.end() + 1;
        self.hessenberg.rotate_columns(i, last, rows);
    }

    /// Passes a rotation through all triangles, from right to left, and returns the rotation that comes out.
    fn pass_triangles(
        &mut self,
        i: usize,
        mut rotation: Rotation,
        block: RangeInclusive<usize>,
    ) -> Rotation {
        let (low, high) = (*block.start(), *block.end());
        for triangle in &mut self.triangles {
            triangle.rotate_columns(i, rotation, low..i + 2);
            rotation = Rotation::to_zero(triangle.at(i, i), triangle.at(i + 1, i));
            triangle.rotate_rows(i, rotation, i..high + 1);
            triangle.set(i + 1, i, C64::new(0.0, 0.0));
        }
        rotation
    }

    /// The eigenvalues.
    pub fn eigenvalues(mut self) -> Result<Vec<Multiplier>, SchurError> {
        let mut found = Vec::with_capacity(self.n);
        let mut high = self.n;
        let mut iterations = 0;
        while high > 0 {
            let last = high - 1;
            let low = self.start_of_block(last);
            if low == last {
                found.push(self.eigenvalue(last));
                high -= 1;
                iterations = 0;
                continue;
            }
            iterations += 1;
            if iterations > MAX_ITERATIONS {
                return Err(SchurError);
            }
            if self.clear_negligible(low..=last) {
                self.sweep_without_shift(low..=last);
            } else {
                self.sweep(low..=last, iterations % EXCEPTIONAL == 0);
            }
        }
        Ok(found)
    }

    /// Start of the unreduced block of the Hessenberg matrix that ends at `last`.
    fn start_of_block(&mut self, last: usize) -> usize {
        for i in (0..last).rev() {
            let h = &self.hessenberg;
            let size = h.at(i, i).norm() + h.at(i + 1, i + 1).norm();
            let size = if size == 0.0 { 1.0 } else { size };
            if h.at(i + 1, i).norm() <= f64::EPSILON * size {
                self.hessenberg.set(i + 1, i, C64::new(0.0, 0.0));
                return i + 1;
            }
        }
        0
    }

    /// Sets diagonal elements that are rounding errors to zero. Returns whether the block has a zero.
    fn clear_negligible(&mut self, block: RangeInclusive<usize>) -> bool {
        let mut found = false;
        for (triangle, negligible) in self.triangles.iter_mut().zip(&self.negligible) {
            for i in block.clone() {
                if triangle.at(i, i).norm() <= *negligible {
                    triangle.set(i, i, C64::new(0.0, 0.0));
                    found = true;
                }
            }
        }
        found
    }

    /// An explicit QR step without shift. A zero on the diagonal of a triangle splits the block and moves to its end, from
    /// where the next step splits it off.
    fn sweep_without_shift(&mut self, block: RangeInclusive<usize>) {
        let (low, high) = (*block.start(), *block.end());
        let mut rotations = Vec::with_capacity(high - low);
        for i in low..high {
            let h = &mut self.hessenberg;
            let rotation = Rotation::to_zero(h.at(i, i), h.at(i + 1, i));
            h.rotate_rows(i, rotation, i..high + 1);
            h.set(i + 1, i, C64::new(0.0, 0.0));
            rotations.push(rotation);
        }
        for (rotation, i) in rotations.into_iter().zip(low..) {
            let last = self.pass_triangles(i, rotation, block.clone());
            self.hessenberg.rotate_columns(i, last, low..i + 2);
            if last.is_identity() {
                self.hessenberg.set(i + 1, i, C64::new(0.0, 0.0));
            }
        }
    }

    /// An implicit QR step, which moves a bulge down the block.
    fn sweep(&mut self, block: RangeInclusive<usize>, exceptional: bool) {
        let (low, high) = (*block.start(), *block.end());
        let h = &self.hessenberg;
        let below = h.at(low + 1, low);
        let mut rotation = match exceptional {
            true => Rotation::to_zero(C64::new(0.8, 0.6), C64::new(1.0, 0.0)),
            false => Rotation::to_zero(h.at(low, low) - self.shift(low, high), below),
        };
        for i in low..high {
            if i > low {
                let h = &self.hessenberg;
                rotation = Rotation::to_zero(h.at(i, i - 1), h.at(i + 1, i - 1));
            }
            self.rotate(i, rotation, block.clone());
            if i > low {
                self.hessenberg.set(i + 1, i - 1, C64::new(0.0, 0.0));
            }
        }
    }

    /// The shift divided by the first diagonal element of the product of the triangles: the eigenvalue of the last 2 x 2
    /// block of the product that is closer to its last element.
    fn shift(&self, low: usize, high: usize) -> C64 {
        let first = high.saturating_sub(2).max(low);
        let (rows, ln_scale) = self.last_block(first, high);
        let [[a, b], [c, d]] = rows;
        let half = (a - d) * 0.5;
        let root = (half * half + b * c).sqrt();
        let root = if (half.conj() * root).re < 0.0 {
            -root
        } else {
            root
        };
        let far = half + root;
        // The eigenvalues are d - b c / far and d + far.
        let value = if far.norm() == 0.0 {
            d
        } else {
            d - b * c / far
        };
        let first = self.diagonal_product(low);
        let ratio = (ln_scale - first.ln_scale).clamp(-700.0, 700.0).exp();
        value / first.value * ratio
    }

    /// The last two rows and columns of the product, from the coordinates `first` to `high`, and the logarithm of their
    /// scale.
    fn last_block(&self, first: usize, high: usize) -> ([[C64; 2]; 2], f64) {
        let zero = C64::new(0.0, 0.0);
        let size = high - first + 1;
        let mut product = [[zero; 3]; 3];
        for (i, row) in product.iter_mut().enumerate() {
            row[i] = C64::new(1.0, 0.0);
        }
        let mut ln_scale = 0.0;
        for triangle in &self.triangles {
            let mut next = [[zero; 3]; 3];
            let mut largest = 0.0_f64;
            for (i, row) in next.iter_mut().enumerate().take(size) {
                for (j, element) in row.iter_mut().enumerate().take(size).skip(i) {
                    let terms = (i..=j).map(|k| triangle.at(first + i, first + k) * product[k][j]);
                    *element = terms.sum();
                    largest = largest.max(element.norm());
                }
            }
            if largest > 0.0 {
                next.iter_mut().flatten().for_each(|x| *x /= largest);
                ln_scale += largest.ln();
            }
            product = next;
        }
        let block = [size - 2, size - 1].map(|i| {
            [size - 2, size - 1].map(|j| {
                let terms =
                    (0..size).map(|k| self.hessenberg.at(first + i, first + k) * product[k][j]);
                terms.sum()
            })
        });
        (block, ln_scale)
    }

    /// The product of a diagonal element of the triangles, which is not zero.
    fn diagonal_product(&self, i: usize) -> Scaled {
        let one = Scaled {
            value: C64::new(1.0, 0.0),
            ln_scale: 0.0,
        };
        self.triangles.iter().fold(one, |product, triangle| {
            let factor = triangle.at(i, i);
            let size = factor.norm();
            Scaled {
                value: product.value * (factor / size),
                ln_scale: product.ln_scale + size.ln(),
            }
        })
    }

    /// The eigenvalue at a diagonal position that has been split off.
    fn eigenvalue(&self, i: usize) -> Multiplier {
        let triangles = self.triangles.iter().zip(&self.negligible);
        if triangles
            .into_iter()
            .any(|(t, negligible)| t.at(i, i).norm() <= *negligible)
        {
            return Multiplier::ZERO;
        }
        let product = self.diagonal_product(i);
        let value = self.hessenberg.at(i, i) * product.value;
        Multiplier {
            ln_magnitude: value.norm().ln() + product.ln_scale,
            angle: value.arg(),
        }
    }
}
