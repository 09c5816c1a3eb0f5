//! The meridian section: nodes and quadrilaterals in the half-plane `(r, z)`, `r >= 0`.
//!
//! A section consists of a few four-sided patches. Each patch is bounded by four curves. A curve stores
//! its nodes and is shared by the patches on its two sides, so the mesh conforms by construction. The
//! nodes inside a patch follow from its boundary by transfinite interpolation (Gordon and Hall, Numer.
//! Math. 21, 1973, 109). The elements are isoparametric: at order `p` the error of an arc is
//! proportional to the power `p + 1` of the angle of an element.

use std::slice::ChunksExact;

use super::Elements;
use super::element::EdgeNodes;

/// A mesh of a meridian section.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Polynomial order `p` of the elements.
    pub(super) order: usize,
    /// Coordinates `(r, z)` of the nodes, m. On the axis `r` is exactly zero.
    pub(super) nodes: Vec<[f64; 2]>,
    /// Node numbers, element by element.
    elements: Vec<usize>,
}

impl Section {
    /// A section without elements, which will have the given order.
    pub(super) fn new(order: usize) -> Self {
        Self {
            order,
            nodes: Vec::new(),
            elements: Vec::new(),
        }
    }

    /// The elements: `(p + 1) x (p + 1)` node numbers each, row by row.
    pub fn elements(&self) -> ChunksExact<'_, usize> {
        self.elements.chunks_exact((self.order + 1).pow(2))
    }

    /// Diagonal of the bounding box of the section, m: the length scale of its lowest modes.
    pub(super) fn diagonal(&self) -> f64 {
        let side = |axis: usize| {
            let places = || self.nodes.iter().map(|node| node[axis]);
            places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
        };
        side(0).hypot(side(1))
    }
}

/// Elements that become smaller towards a corner at one end of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grading {
    /// Number of divisions of the element next to the corner; 0 for equal elements.
    pub(super) levels: i32,
    /// Whether the corner is at the end of the curve.
    pub(super) at_end: bool,
}

impl Grading {
    /// Smaller towards the start. Ratio and number of levels were determined by trial on the paper's body:
    /// without grading the fourth bending frequency is 5e-4 too high, with it 3e-6.
    pub(super) const START: Self = Self {
        levels: 3,
        at_end: false,
    };
    /// Smaller towards the end.
    pub(super) const END: Self = Self {
        at_end: true,
        ..Self::START
    };
    /// Size ratio of adjacent elements in a graded layer.
    const RATIO: f64 = 0.25;
}

/// Division of a curve into elements: element boundaries and nodes as fractions of its length. The elements are equal and
/// no longer than the element size (at least one). A graded curve has its last element before the corner divided
/// geometrically.
pub(super) fn partition(length: f64, elements: &Elements, grading: Grading) -> Vec<f64> {
    // The tolerance keeps 0.2 / 0.01 from giving 21 elements.
    let count = (length / elements.size - 1e-9).ceil().max(1.0);
    let mut boundaries: Vec<f64> = (0..=count as usize).map(|i| i as f64 / count).collect();
    let graded = (1..=grading.levels)
        .rev()
        .map(|level| Grading::RATIO.powi(level) / count);
    boundaries.splice(1..1, graded);
    if grading.at_end {
        boundaries.reverse();
        boundaries.iter_mut().for_each(|b| *b = 1.0 - *b);
    }
    let edge = EdgeNodes::of_order(elements.order);
    let mut params = vec![0.0];
    for boundary in boundaries.windows(2) {
        let width = boundary[1] - boundary[0];
        let inner = edge.points[1..elements.order].iter();
        params.extend(inner.map(|xi| boundary[0] + 0.5 * (1.0 + xi) * width));
        params.push(boundary[1]);
    }
    params
}

/// Node numbers along a curve and their positions as fractions of its length.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Node numbers; for elements of order `p`, every `p`-th is an element boundary.
    pub(super) nodes: Vec<usize>,
    params: Vec<f64>,
}

impl Curve {
    /// The same curve in the opposite direction.
    pub(super) fn reversed(&self) -> Self {
        Self {
            nodes: self.nodes.iter().rev().copied().collect(),
            params: self.params.iter().rev().map(|s| 1.0 - s).collect(),
        }
    }

    /// The first node.
    pub(super) fn first(&self) -> usize {
        self.nodes[0]
    }

    /// The last node.
    pub(super) fn last(&self) -> usize {
        self.nodes[self.nodes.len() - 1]
    }
}

/// The four sides of a patch: bottom, right, top, left. Bottom and top have the same direction, left and right run from
/// bottom to top. The patch lies to the left of the bottom curve.
pub(super) type Sides<'a> = [&'a Curve; 4];

/// Construction: first vertices, then curves between them, then patches.
impl Section {
    /// Adds a corner of patches at `(r, z)`.
    pub(super) fn vertex(&mut self, position: [f64; 2]) -> usize {
        self.nodes.push(position);
        self.nodes.len() - 1
    }

    /// Adds a straight line.
    pub(super) fn line(&mut self, from: usize, to: usize, params: &[f64]) -> Curve {
        let [a, b] = [self.nodes[from], self.nodes[to]];
        self.curve(from, to, params, |s| {
            [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
        })
    }

    /// Adds a circular arc about the origin; equal fractions are equal angles.
    pub(super) fn arc(&mut self, from: usize, to: usize, params: &[f64]) -> Curve {
        let [a, b] = [self.nodes[from], self.nodes[to]];
        let radius = a[0].hypot(a[1]);
        let polar = [a[0].atan2(a[1]), b[0].atan2(b[1])];
        self.curve(from, to, params, |s| {
            let angle = polar[0] + s * (polar[1] - polar[0]);
            [radius * angle.sin(), radius * angle.cos()]
        })
    }

    fn curve(
        &mut self,
        from: usize,
        to: usize,
        params: &[f64],
        shape: impl Fn(f64) -> [f64; 2],
    ) -> Curve {
        let mut nodes = vec![from];
        for &s in &params[1..params.len() - 1] {
            nodes.push(self.vertex(shape(s)));
        }
        nodes.push(to);
        Curve {
            nodes,
            params: params.to_vec(),
        }
    }

    /// Fills the patch between four curves.
    pub(super) fn patch(&mut self, sides: Sides<'_>) {
        let [bottom, right, top, left] = sides;
        let [columns, rows] = [bottom.nodes.len(), left.nodes.len()];
        debug_assert_eq!([columns, rows], [top.nodes.len(), right.nodes.len()]);
        let mut grid = Vec::with_capacity(columns * rows);
        for j in 0..rows {
            for i in 0..columns {
                let node = if j == 0 {
                    bottom.nodes[i]
                } else if j == rows - 1 {
                    top.nodes[i]
                } else if i == 0 {
                    left.nodes[j]
                } else if i == columns - 1 {
                    right.nodes[j]
                } else {
                    let position = self.transfinite(sides, i, j);
                    self.vertex(position)
                };
                grid.push(node);
            }
        }
        for row in (0..rows - 1).step_by(self.order) {
            for column in (0..columns - 1).step_by(self.order) {
                for j in row..=row + self.order {
                    let start = j * columns + column;
                    self.elements
                        .extend_from_slice(&grid[start..=start + self.order]);
                }
            }
        }
    }

    /// The point `(i, j)` of a patch: the sum of the two linear blends of opposite sides minus the
    /// bilinear blend of the corners, which both contain.
    fn transfinite(&self, [bottom, right, top, left]: Sides<'_>, i: usize, j: usize) -> [f64; 2] {
        let [s, t] = [bottom.params[i], left.params[j]];
        let corner = |curve: &Curve| [self.nodes[curve.first()], self.nodes[curve.last()]];
        let [low, high] = [corner(bottom), corner(top)];
        let at = |curve: &Curve, k: usize| self.nodes[curve.nodes[k]];
        let [bottom, top, left, right] = [at(bottom, i), at(top, i), at(left, j), at(right, j)];
        std::array::from_fn(|x| {
            (1.0 - t) * bottom[x] + t * top[x] + (1.0 - s) * left[x] + s * right[x]
                - (1.0 - t) * ((1.0 - s) * low[0][x] + s * low[1][x])
                - t * ((1.0 - s) * high[0][x] + s * high[1][x])
        })
    }
}
