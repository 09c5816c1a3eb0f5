//! What a section looks like: a few points, a closed curve, an arc or a cloud.
//!
//! All is read from the minimum spanning tree of the points: the `n - 1` edges that join them at
//! the least total length. Cutting its longest edges is single-linkage clustering (Gower and
//! Ross, Appl. Stat. 18, 54, 1969); a curve's tree is one long path with hardly a branch.

use serde::{Deserialize, Serialize};

/// Distances below this share of the trajectory's extent are none: what a section cannot resolve.
const RESOLUTION: f64 = 1e-6;

/// The largest diameter of a group that passes for a point, as a share of the extent.
const POINT: f64 = 0.05;

/// Groups are apart if the gaps between them are this many times the diameter of the largest.
const APART: f64 = 4.0;

/// Each group has at least so many members: a motion is seen to come back at least twice.
const FEWEST_VISITS: usize = 3;

/// The fewest points of which a curve or a cloud is told.
const FEWEST_POINTS: usize = 24;

/// A curve is in one piece where no edge is longer than this many times the median edge. (On a
/// torus nearly in step the points bunch: up to 14 were measured, between bands of chaos 80 and
/// more.)
const PIECES: f64 = 30.0;

/// The longest path through the tree of a curve has at least this share of the tree's length;
/// measured: curves 0.9 to 1, with noise of a thirtieth of their size 0.87, clouds 0.6 and less.
const PATH_SHARE: f64 = 0.8;

/// The ends of the path of a closed curve are at most this many of its longest edges apart;
/// measured: closed 1 to 2, open 4 and more.
const CLOSING: f64 = 2.5;

/// The fewest points of a piece that is told closed.
const FEWEST_ROUND: usize = 12;

/// The smallest closed curve that is told, its diameter over the extent. A kinked signal moves the
/// located passages by a little that depends on where between two samples they fall: a loop, too.
const SMALLEST_LOOP: f64 = 5e-3;

/// Groups of passages.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    /// The group of each point, 0, 1, ... in the order of their first appearance.
    pub member: Vec<usize>,
    /// How many there are.
    pub count: usize,
    /// Whether the groups are points (each far smaller than the gaps between them); if not, the
    /// section is a curve or a cloud, and all of it is one group.
    pub compact: bool,
}

/// What a section looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(tag = "shape", content = "points", rename_all = "kebab-case")]
pub enum SectionShape {
    /// Too few passages to tell.
    #[serde(rename = "too few")]
    TooFew,
    /// This many points: the motion repeats after as many passages.
    Points(usize),
    /// A closed curve: a torus.
    Loop,
    /// A curve with two ends: a strongly dissipative chaos, or a motion that still changes.
    Arc,
    /// Neither: chaos, noise, or a torus of more than two tones.
    Cloud,
}

/// Groups points (slices of equal length) that lie closer together than to the rest. `extent` is
/// the size of the whole trajectory, the yardstick for what is a point.
///
/// The points are cut into as many groups as possible such that each
///
/// * has at least 3 members,
/// * has a bounding box with a diagonal of at most 5 % of `extent`, and
/// * is more than 4 such diagonals (of the largest, at least 1e-6 of `extent`) from any other.
///
/// Where no cut will do, they are one group, [`Clusters::compact`] only if it is as small as
/// that. The time goes as the square of the number of points; 1,200 take some 3 ms.
pub fn clusters(points: &[&[f64]], extent: f64) -> Clusters {
    Tree::new(points).clusters(points, extent).0
}

/// The shape of a section whose passages are these points (slices of equal length), in any order,
/// of a trajectory of size `extent`.
///
/// [`SectionShape::Points`] are the groups of [`clusters`], unless each is a closed curve of at
/// least 0.5 % of `extent`. Otherwise the points fall into pieces where an edge of the minimum
/// spanning tree is longer than 30 times the median. A piece is a curve if the longest path
/// through its tree has 80 % of the tree's length, and closed if it has 12 points or more and its
/// ends are no farther apart than 2.5 times its longest edge. Below 24 points only
/// [`SectionShape::Points`] is told. The time goes as that of [`clusters`].
pub fn section_shape(points: &[&[f64]], extent: f64) -> SectionShape {
    let tree = Tree::new(points);
    let (groups, diameter) = tree.clusters(points, extent);
    if groups.compact {
        let round = diameter >= SMALLEST_LOOP * extent
            && tree.form(points, &groups.member, groups.count) == SectionShape::Loop;
        return if round {
            SectionShape::Loop
        } else {
            SectionShape::Points(groups.count)
        };
    }
    if points.len() < FEWEST_POINTS {
        return SectionShape::TooFew;
    }
    let mut lengths: Vec<f64> = tree.edges.iter().map(|edge| edge.length).collect();
    let half = lengths.len() / 2;
    let median = *lengths.select_nth_unstable_by(half, f64::total_cmp).1;
    let limit = PIECES * median.max(RESOLUTION * extent);
    let pieces = tree.cut(points.len(), limit);
    let count = pieces.iter().max().map_or(0, |last| last + 1);
    tree.form(points, &pieces, count)
}

/// An edge of a tree.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The point that was in the tree before.
    from: usize,
    to: usize,
    length: f64,
}

/// A minimum spanning tree; edges in the order in which the tree grew from point 0.
struct Tree {
    edges: Vec<Edge>,
}

/// A path through a tree.
struct Path {
    ends: [usize; 2],
    length: f64,
    /// Its longest edge.
    longest: f64,
}

impl Tree {
    /// Prim's algorithm (Bell Syst. Tech. J. 36, 1389, 1957).
    fn new(points: &[&[f64]]) -> Self {
        let mut outside: Vec<Edge> = (1..points.len())
            .map(|to| Edge {
                from: 0,
                to,
                length: f64::INFINITY,
            })
            .collect();
        let mut edges = Vec::with_capacity(outside.len());
        let mut newest = 0;
        while !outside.is_empty() {
            let mut best = 0;
            for k in 0..outside.len() {
                let edge = &mut outside[k];
                let length = distance(points[newest], points[edge.to]);
                if length < edge.length {
                    edge.from = newest;
                    edge.length = length;
                }
                if outside[k].length < outside[best].length {
                    best = k;
                }
            }
            let edge = outside.swap_remove(best);
            newest = edge.to;
            edges.push(edge);
        }
        Self { edges }
    }

    /// The groups and, if they are points, the diameter of the largest.
    fn clusters(&self, points: &[&[f64]], extent: f64) -> (Clusters, f64) {
        let resolution = RESOLUTION * extent;
        let mut lengths: Vec<f64> = self.edges.iter().map(|edge| edge.length).collect();
        lengths.sort_by(|a, b| b.total_cmp(a));
        // From many groups to few; `gap` is the shortest edge that is cut.
        for count in (1..=points.len() / FEWEST_VISITS).rev() {
            let gap = if count > 1 {
                lengths[count - 2]
            } else {
                f64::INFINITY
            };
            let inside = lengths.get(count - 1).copied().unwrap_or(0.0);
            if gap <= APART * inside.max(resolution) || inside > POINT * extent {
                continue;
            }
            let member = self.cut(points.len(), gap);
            let largest = largest_group(points, &member, count);
            if let Some(diameter) = largest
                && diameter <= POINT * extent
                && gap > APART * diameter.max(resolution)
            {
                let groups = Clusters {
                    member,
                    count,
                    compact: true,
                };
                return (groups, diameter);
            }
        }
        let all = Clusters {
            member: vec![0; points.len()],
            count: usize::from(!points.is_empty()),
            compact: false,
        };
        (all, f64::INFINITY)
    }

    /// The group of each of `count` points if edges of at least `gap` are cut, numbered by first
    /// appearance.
    fn cut(&self, count: usize, gap: f64) -> Vec<usize> {
        // Each edge leads from a point that is labelled to one that is not.
        let mut label: Vec<usize> = (0..count).collect();
        for edge in self.edges.iter().filter(|edge| edge.length < gap) {
            label[edge.to] = label[edge.from];
        }
        let mut name = vec![usize::MAX; count];
        let mut names = 0;
        for label in &mut label {
            if name[*label] == usize::MAX {
                name[*label] = names;
                names += 1;
            }
            *label = name[*label];
        }
        label
    }

    /// What all `count` pieces, parts of the tree, have in common: loops, or else curves, or else
    /// neither.
    fn form(&self, points: &[&[f64]], member: &[usize], count: usize) -> SectionShape {
        let mut joined = vec![Vec::new(); member.len()];
        let mut total = vec![0.0; count];
        let mut size = vec![0; count];
        let inside = |edge: &&Edge| member[edge.from] == member[edge.to];
        for edge in self.edges.iter().filter(inside) {
            joined[edge.from].push((edge.to, edge.length));
            joined[edge.to].push((edge.from, edge.length));
            total[member[edge.to]] += edge.length;
        }
        for &piece in member {
            size[piece] += 1;
        }
        let mut closed = true;
        for piece in 0..count {
            let some = member.iter().position(|&m| m == piece).unwrap_or(0);
            let path = longest_path(&joined, some);
            if path.length < PATH_SHARE * total[piece] {
                return SectionShape::Cloud;
            }
            let gap = distance(points[path.ends[0]], points[path.ends[1]]);
            closed &= size[piece] >= FEWEST_ROUND && gap <= CLOSING * path.longest;
        }
        if closed {
            SectionShape::Loop
        } else {
            SectionShape::Arc
        }
    }
}

/// The longest path through the tree that holds point `some`: the point farthest from any other is
/// one of its ends.
fn longest_path(joined: &[Vec<(usize, f64)>], some: usize) -> Path {
    let farthest = |start: usize| {
        let mut best = Path {
            ends: [start, start],
            length: 0.0,
            longest: 0.0,
        };
        let mut open = vec![(start, start, 0.0, 0.0)];
        while let Some((here, before, length, longest)) = open.pop() {
            if length > best.length {
                best = Path {
                    ends: [start, here],
                    length,
                    longest,
                };
            }
            for &(next, step) in joined[here].iter().filter(|(next, _)| *next != before) {
                open.push((next, here, length + step, f64::max(longest, step)));
            }
        }
        best
    };
    farthest(farthest(some).ends[1])
}

/// Diagonal of the largest bounding box of the groups; `None` if one has too few members.
fn largest_group(points: &[&[f64]], member: &[usize], count: usize) -> Option<f64> {
    let dimension = points.first().map_or(0, |point| point.len());
    let mut low = vec![f64::INFINITY; count * dimension];
    let mut high = vec![f64::NEG_INFINITY; count * dimension];
    let mut visits = vec![0; count];
    for (point, &group) in points.iter().zip(member) {
        visits[group] += 1;
        for (c, &x) in point.iter().enumerate() {
            let slot = group * dimension + c;
            low[slot] = low[slot].min(x);
            high[slot] = high[slot].max(x);
        }
    }
    if visits.iter().any(|&v| v < FEWEST_VISITS) {
        return None;
    }
    let corners = low
        .chunks(dimension.max(1))
        .zip(high.chunks(dimension.max(1)));
    Some(corners.map(|(a, b)| distance(a, b)).fold(0.0, f64::max))
}

/// Euclidean distance.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}
