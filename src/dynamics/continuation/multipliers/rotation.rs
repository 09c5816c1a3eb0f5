//! Complex matrices and plane rotations.

use nalgebra::Complex;

/// A complex number.
pub type C64 = Complex<f64>;

/// A square matrix, row-major.
#[derive(Clone, Debug)]
pub struct Square {
    n: usize,
    elements: Vec<C64>,
}

/// The rotation `[[c, s], [-conj(s), c]]` of two neighbouring coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    c: f64,
    s: C64,
}

impl Rotation {
    /// The rotation that makes the second of two numbers zero.
    pub fn to_zero(a: C64, b: C64) -> Self {
        let (large, small) = (a.norm(), b.norm());
        if small == 0.0 {
            return Self {
                c: 1.0,
                s: C64::new(0.0, 0.0),
            };
        }
        if large == 0.0 {
            return Self {
                c: 0.0,
                s: b.conj() / small,
            };
        }
        let size = large.hypot(small);
        Self {
            c: large / size,
            s: (a / large) * (b.conj() / size),
        }
    }

    /// Whether the rotation changes nothing.
    pub fn is_identity(self) -> bool {
        self.s.re == 0.0 && self.s.im == 0.0
    }
}

impl Square {
    /// A matrix of zeros.
    pub fn zeros(n: usize) -> Self {
        Self {
            n,
            elements: vec![C64::new(0.0, 0.0); n * n],
        }
    }

    /// The element of a row and a column.
    pub fn at(&self, row: usize, column: usize) -> C64 {
        self.elements[row * self.n + column]
    }

    /// Sets an element.
    pub fn set(&mut self, row: usize, column: usize, value: C64) {
        self.elements[row * self.n + column] = value;
    }

    /// Largest magnitude of an element.
    pub fn largest(&self) -> f64 {
        self.elements.iter().fold(0.0, |max, x| x.norm().max(max))
    }

    /// Rotates the rows `i` and `i + 1` in a range of columns.
    pub fn rotate_rows(&mut self, i: usize, by: Rotation, columns: std::ops::Range<usize>) {
        let (upper, lower) = self.elements[i * self.n..].split_at_mut(self.n);
        let rows = upper[columns.clone()].iter_mut().zip(&mut lower[columns]);
        for (x, y) in rows {
            let (a, b) = (*x, *y);
            *x = a * by.c + by.s * b;
            *y = b * by.c - by.s.conj() * a;
        }
    }

    /// Multiplies by the inverse of a rotation from the right: rotates the columns `i` and `i + 1` in a range of rows.
    pub fn rotate_columns(&mut self, i: usize, by: Rotation, rows: std::ops::Range<usize>) {
        for row in self.elements[rows.start * self.n..rows.end * self.n].chunks_exact_mut(self.n) {
            let (a, b) = (row[i], row[i + 1]);
            row[i] = a * by.c + by.s.conj() * b;
            row[i + 1] = b * by.c - by.s * a;
        }
    }
}
