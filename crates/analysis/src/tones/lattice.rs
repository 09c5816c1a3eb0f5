//! Choice of the base frequencies among all pairs that span the same lines.
//!
//! Lines that are combinations of two frequencies form a lattice, and a lattice has many bases: `f1` and
//! `f2` span the same lines as `f1` and `f1 + f2`. A doubling of the motion refines the lattice to twice
//! as many points: lines appear at `f1/2`, at `f2/2` or at `(f1 + f2)/2`. The bases are chosen such that
//! they change only if the motion does:
//!
//! * A coarser lattice of half or a quarter of the points is preferred if it holds most of the power of
//!   the second frequency: the other lines are those of a doubling.
//! * `f1` is the strongest line that can be a base. `f2` is the lowest of those that span the lattice
//!   together with `f1` and have at least half the amplitude of the strongest of these.
//! * The bases of an earlier reading are kept, if they are known and still span the lattice or a coarser
//!   one of it, unless the present ones are closer to each other: the second base is the side line next to the first.

use super::{Bases, Combination, Line, LineIdentification};

/// Largest number of points of the lattice per point of the coarser one: two doublings.
const MAX_INDEX: i32 = 4;

/// Minimum amplitude of a second base, relative to the strongest line that can be one (-6 dB).
const MIN_SECOND_BASE: f64 = 0.5;

/// Largest share of the power at the odd multiples of the fundamental of a motion whose period has
/// doubled (-10 dB). With more it is a tone with strong even harmonics.
const MAX_SUBHARMONIC: f64 = 0.1;

/// Largest relative change of a base frequency from one reading to the next.
const MAX_CHANGE: f64 = 0.01;

/// Largest amplitude ratio of the two sidebands of a modulated tone (3 dB).
const MAX_ASYMMETRY: f64 = std::f64::consts::SQRT_2;

/// Lines as points of a lattice with the basis `base`.
#[derive(Clone, Debug)]
pub(super) struct Lattice<'a> {
    pub lines: &'a [Line],
    /// Frequencies of the basis, Hz; the second is 0 for multiples of a single frequency.
    pub base: [f64; 2],
    /// Integer coordinates of each line; `None` for a line off the lattice.
    pub points: Vec<Option<[i32; 2]>>,
}

/// A line on the lattice.
#[derive(Clone, Copy)]
struct Node {
    line: Line,
    point: [i32; 2],
}

/// A basis: two lines that span the lattice or a coarser one.
#[derive(Clone, Copy)]
struct Basis {
    vectors: [[i32; 2]; 2],
    /// Frequencies of the basis, Hz.
    frequency: [f64; 2],
    /// Number of points of the lattice per point of this basis.
    index: i32,
}

impl<'a> Lattice<'a> {
    /// The lattice of a reading without doublings.
    pub fn of(lines: &'a [Line], reading: &LineIdentification) -> Self {
        Self {
            lines,
            base: reading.bases.pair(),
            points: reading
                .names
                .iter()
                .map(|name| name.map(|c| [c.n, c.m]))
                .collect(),
        }
    }

    /// Adds the halves of the points whose coordinates have the given parity. `found` are the positions
    /// of new lines, with coordinates in halves of the present basis.
    pub fn refine(&mut self, [p, q]: [i32; 2], found: &[(usize, Combination)]) {
        for &(line, name) in found {
            self.points[line] = Some([name.n, name.m]);
        }
        let half = 0.5 * (f64::from(p) * self.base[0] + f64::from(q) * self.base[1]);
        self.base[usize::from(p == 0)] = half;
        // Twice the coordinates of the earlier points; the half vector then replaces a basis vector.
        let is_new = |line: usize| found.iter().any(|(new, _)| *new == line);
        for (line, point) in self.points.iter_mut().enumerate() {
            let Some([n, m]) = point else { continue };
            let scale = if is_new(line) { 1 } else { 2 };
            let [n, m] = [scale * *n, scale * *m];
            *point = Some(match p {
                0 => [n / 2, m],
                _ => [n, (m - q * n) / 2],
            });
        }
    }

    /// Names of the lines in the bases described in the module documentation.
    pub fn identification(&self, previous: Bases, p_value: f64) -> LineIdentification {
        let basis = match self.base[1] {
            0.0 => self.single(previous),
            _ => self.double(previous),
        };
        let [f1, f2] = basis.frequency;
        let names = self.points.iter().map(|point| Some(basis.name((*point)?)));
        let mut found = LineIdentification {
            bases: match self.base[1] {
                0.0 => Bases::One { f1 },
                _ => Bases::Two { f1, f2 },
            },
            names: names.collect(),
            p_value,
            doubling: basis.index.ilog2(),
        };
        let asymmetry = match previous {
            Bases::Modulated { .. } => MAX_ASYMMETRY * MAX_ASYMMETRY,
            _ => MAX_ASYMMETRY,
        };
        if self.earlier_basis(previous).is_none() {
            self.describe_modulation(&mut found, asymmetry);
        }
        found
    }

    /// The lines on the lattice, strongest first.
    fn named(&self) -> impl Iterator<Item = Node> {
        let both = self.lines.iter().zip(&self.points);
        both.filter_map(|(&line, point)| (*point).map(|point| Node { line, point }))
    }

    /// The fundamental of a lattice of multiples: its base, or twice or four times of it.
    fn single(&self, previous: Bases) -> Basis {
        let [base, _] = self.base;
        let basis = |n: i32| {
            let line = self.named().find(|node| node.point[0] == n);
            let f1 = line.map_or(f64::from(n) * base, |node| node.line.frequency);
            Basis {
                vectors: [[n, 0], [0, 1]],
                frequency: [f1, 0.0],
                index: n,
            }
        };
        let is_doubled = |n: &i32| {
            let (even, odd) = self.power(|[k, _]| k % n == 0);
            odd > 0.0 && odd <= MAX_SUBHARMONIC * even
        };
        let [f1, _] = previous.pair();
        let kept = |n: &i32| (f64::from(*n) * base - f1).abs() <= MAX_CHANGE * f1;
        let multiples = [MAX_INDEX, 2, 1];
        let doubled = multiples.into_iter().find(is_doubled);
        let kept = multiples.into_iter().find(kept);
        basis(doubled.max(kept).unwrap_or(1))
    }

    /// The bases of a lattice of two frequencies.
    fn double(&self, previous: Bases) -> Basis {
        let whole = Basis {
            vectors: [[1, 0], [0, 1]],
            frequency: self.base,
            index: 1,
        };
        let mut indices = [MAX_INDEX, 2, 1].into_iter();
        let own = indices.find_map(|index| self.strongest_basis(index));
        let own = own.unwrap_or(whole);
        // An earlier basis keeps the name of a doubling whose lines have become strong. It gives way to a side line closer to
        // `f1`, which is often weak while the second tone grows.
        match self.earlier_basis(previous) {
            Some(earlier) if earlier.index > own.index => earlier,
            Some(earlier) if earlier.index == own.index && earlier.gap() <= own.gap() => earlier,
            _ => own,
        }
    }

    /// The basis with this index that the module documentation describes.
    fn strongest_basis(&self, index: i32) -> Option<Basis> {
        // Of lines of similar amplitude the lower is the more likely base: an octave counts as 1.5 dB.
        let weight = |line: &Line| line.amplitude / line.frequency.powf(0.25);
        let mut firsts: Vec<Node> = self.named().collect();
        firsts.sort_by(|a, b| weight(&b.line).total_cmp(&weight(&a.line)));
        firsts.into_iter().find_map(|first| {
            let spans = |second: &Node| {
                let basis = Basis::new([first, *second]);
                basis.index == index && self.holds_most_power(&basis)
            };
            let seconds = || self.named().filter(spans);
            let strongest = seconds().next()?.line.amplitude;
            let strong = seconds().filter(|s| s.line.amplitude >= MIN_SECOND_BASE * strongest);
            let second = strong.min_by(|a, b| a.line.frequency.total_cmp(&b.line.frequency))?;
            let mut pair = [first, second];
            pair.sort_by(|a, b| b.line.amplitude.total_cmp(&a.line.amplitude));
            Some(Basis::new(pair))
        })
    }

    /// Whether the lines in the lattice of a basis, without the multiples of the strongest line, have more
    /// power than all lines outside of it.
    fn holds_most_power(&self, basis: &Basis) -> bool {
        let is_inside = |point| basis.name(point).divisor == 1;
        let strongest = self.named().next().map_or([1, 0], |node| node.point);
        let (_, outside) = self.power(is_inside);
        let is_second = |point| is_inside(point) && determinant([strongest, point]) != 0;
        is_inside(strongest) && outside < self.power(is_second).0
    }

    /// The basis of the lines closest to the bases of an earlier reading, if these span the lattice or a
    /// coarser one.
    fn earlier_basis(&self, previous: Bases) -> Option<Basis> {
        let Bases::Two { f1, f2 } = previous else {
            return None;
        };
        let nearest = |base: f64| {
            let off = |node: &Node| (node.line.frequency - base).abs();
            let node = self.named().min_by(|a, b| off(a).total_cmp(&off(b)))?;
            (off(&node) <= MAX_CHANGE * base).then_some(node)
        };
        let basis = Basis::new([nearest(f1)?, nearest(f2)?]);
        [1, 2, MAX_INDEX].contains(&basis.index).then_some(basis)
    }

    /// Power of the lines whose points satisfy a condition, and of the others.
    fn power(&self, condition: impl Fn([i32; 2]) -> bool) -> (f64, f64) {
        let (mut inside, mut outside) = (0.0, 0.0);
        for Node { line, point } in self.named() {
            let sum = if condition(point) {
                &mut inside
            } else {
                &mut outside
            };
            *sum += line.amplitude * line.amplitude;
        }
        (inside, outside)
    }

    /// Replaces two bases by a carrier and a modulation frequency if the lines are sidebands in symmetric
    /// pairs. A weak line whose mirror image could be missing from the list does not count.
    fn describe_modulation(&self, found: &mut LineIdentification, asymmetry: f64) {
        let (Bases::Two { f1, f2 }, 0) = (found.bases, found.doubling) else {
            return;
        };
        let harmonic = (f2 / f1).round() as i32;
        let offset = f2 - f64::from(harmonic) * f1;
        let sign = if offset < 0.0 { -1 } else { 1 };
        let renamed =
            |name: Combination| Combination::new(name.n + harmonic * name.m, sign * name.m);
        let named: Vec<(f64, Combination)> = self
            .lines
            .iter()
            .zip(&found.names)
            .filter_map(|(line, name)| Some((line.amplitude, renamed((*name)?))))
            .collect();
        let visible = self.lines.last().map_or(0.0, |line| line.amplitude) * asymmetry;
        let is_paired = |(amplitude, name): &(f64, Combination)| {
            let mirror = Combination::new(name.n, -name.m);
            let image = named.iter().find(|(_, other)| *other == mirror);
            let ratio = image.map_or(f64::INFINITY, |(other, _)| {
                other.max(*amplitude) / other.min(*amplitude)
            });
            name.m == 0 || name.n > 0 && ratio <= asymmetry
        };
        let sidebands = named.iter().filter(|(_, name)| name.m != 0).count();
        let mut clear = named
            .iter()
            .filter(|(amplitude, name)| *amplitude >= visible || name.n <= 0);
        if sidebands >= 2 && clear.all(is_paired) {
            found.bases = Bases::Modulated {
                f1,
                fm: offset.abs(),
            };
            found
                .names
                .iter_mut()
                .flatten()
                .for_each(|name| *name = renamed(*name));
        }
    }
}

impl Basis {
    /// The basis of two lines.
    fn new(pair: [Node; 2]) -> Self {
        let vectors = pair.map(|node| node.point);
        Self {
            vectors,
            frequency: pair.map(|node| node.line.frequency),
            index: determinant(vectors).abs(),
        }
    }

    /// Distance of the two bases, Hz.
    fn gap(&self) -> f64 {
        let [f1, f2] = self.frequency;
        (f2 - f1).abs()
    }

    /// Name of a point.
    fn name(&self, point: [i32; 2]) -> Combination {
        let [first, second] = self.vectors;
        Combination::reduced(
            determinant([point, second]),
            determinant([first, point]),
            determinant(self.vectors),
        )
    }
}

/// Determinant of two vectors: 0 if they are parallel.
fn determinant([[a, b], [c, d]]: [[i32; 2]; 2]) -> i32 {
    a * d - b * c
}
