//! Shape of a section: a few points, a closed curve, an arc or a cloud.
//!
//! The shape follows from the minimum spanning tree of the points: the `n - 1` edges that connect them
//! with the smallest total length. Cutting its longest edges is single-linkage clustering (Gower and
//! Ross, Appl. Stat. 18, 54, 1969). The tree of a curve is one long path with few branches.

use schemars::JsonSchema;
use serde::Serialize;

use crate::norm::Norm;
use crate::stats::{median, range};

/// Resolution of a section: distances below this share of the trajectory's size count as 0.
const RESOLUTION: f64 = 1e-6;

/// Maximum diameter of a cluster that counts as a point, as a share of the trajectory's size.
const MAX_POINT_DIAMETER: f64 = 0.05;

/// Minimum gap between clusters, in diameters of the largest.
const MIN_GAP: f64 = 4.0;

/// Minimum number of members per cluster: the motion returns to it at least twice.
const MIN_MEMBERS: usize = 3;

/// Minimum number of points for a curve or a cloud.
const MIN_POINTS: usize = 24;

/// A curve is connected if no edge is longer than this multiple of the median edge. (On a torus close to
/// phase locking the points accumulate: up to 14 were measured, between bands of chaos 80 and more.)
const MAX_EDGE: f64 = 30.0;

/// Minimum length of the longest path through the tree of a curve, as a share of the tree's length.
/// Measured: curves 0.9 to 1, curves with noise of 1/30 of their size 0.87, clouds 0.6 and less.
const MIN_PATH_SHARE: f64 = 0.8;

/// Maximum distance between the ends of the path of a closed curve, in lengths of its longest edge.
/// Measured: closed 1 to 2, open 4 and more.
const MAX_CLOSING_GAP: f64 = 2.5;

/// Minimum number of points of a closed curve.
const MIN_LOOP_POINTS: usize = 12;

/// Minimum diameter of a closed curve, as a share of the trajectory's size. For a signal with kinks, the
/// error of the crossings depends on their position between two samples and forms a small loop, too.
const MIN_LOOP_DIAMETER: f64 = 5e-3;

/// Clusters of points, each far smaller than the gaps between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clusters {
    /// Cluster of each point, 0, 1, ... in the order of first appearance.
    pub member: Vec<usize>,
    /// Number of clusters.
    pub count: usize,
    /// Diameter of the largest.
    diameter: f64,
}

/// Shape of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(tag = "shape", content = "points", rename_all = "kebab-case")]
pub enum SectionShape {
    /// Too few crossings for a classification.
    #[serde(rename = "too few")]
    TooFew,
    /// This many points: the motion repeats after as many crossings.
    Points(usize),
    /// A closed curve: a torus.
    Loop,
    /// A curve with two ends: strongly dissipative chaos, or a transient.
    Arc,
    /// Neither: chaos, noise, or a torus of more than two frequencies.
    Cloud,
}

/// Shape of a section with these points (slices of equal length) in any order, of a trajectory of the
/// given `size`.
///
/// For [`SectionShape::Points`] the points are divided into the largest number of clusters such that each
///
/// * has at least 3 members,
/// * has a bounding box with a diagonal of at most 5 % of `size`, and
/// * is more than 4 such diagonals (of the largest, at least 1e-6 of `size`) from any other,
///
/// and is not a closed curve with a diameter of at least 0.5 % of `size`. Otherwise the points are divided at edges of the minimum
/// spanning tree longer than 30 times the median. A part is a curve if the longest path through its tree
/// has at least 80 % of the tree's length. It is closed if it has at least 12 points and the distance
/// between its ends is at most 2.5 times its longest edge. With fewer than 24 points only
/// [`SectionShape::Points`] is possible. Time is proportional to the square of the number of points;
/// 1,200 points take about 3 ms.
pub fn section_shape(points: &[&[f64]], size: f64) -> SectionShape {
    let tree = Tree::new(points);
    if let Some(found) = tree.clusters(points, size) {
        let is_loop = found.diameter >= MIN_LOOP_DIAMETER * size
            && tree.common_shape(points, &found.member, found.count) == SectionShape::Loop;
        return if is_loop {
            SectionShape::Loop
        } else {
            SectionShape::Points(found.count)
        };
    }
    if points.len() < MIN_POINTS {
        return SectionShape::TooFew;
    }
    let median = median(tree.edges.iter().map(|edge| edge.length));
    let limit = MAX_EDGE * median.max(RESOLUTION * size);
    let parts = tree.cut(points.len(), limit);
    let count = parts.iter().max().map_or(0, |last| last + 1);
    tree.common_shape(points, &parts, count)
}

/// An edge of a tree.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The end that was added to the tree earlier.
    from: usize,
    to: usize,
    length: f64,
}

/// A minimum spanning tree; edges in the order in which the tree grew from point 0.
pub(super) struct Tree {
    edges: Vec<Edge>,
}

/// A path through a tree.
struct Path {
    ends: [usize; 2],
    length: f64,
    /// Length of its longest edge.
    longest: f64,
}

impl Tree {
    /// Prim's algorithm (Bell Syst. Tech. J. 36, 1389, 1957).
    pub(super) fn new(points: &[&[f64]]) -> Self {
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

    /// The largest number of clusters that meet the limits of [`section_shape`].
    pub(super) fn clusters(&self, points: &[&[f64]], size: f64) -> Option<Clusters> {
        let resolution = RESOLUTION * size;
        let mut lengths: Vec<f64> = self.edges.iter().map(|edge| edge.length).collect();
        lengths.sort_by(|a, b| b.total_cmp(a));
        // From many clusters to few. `gap` is the shortest edge that is cut.
        (1..=points.len() / MIN_MEMBERS).rev().find_map(|count| {
            let gap = if count > 1 {
                lengths[count - 2]
            } else {
                f64::INFINITY
            };
            let inside = lengths.get(count - 1).copied().unwrap_or(0.0);
            if gap <= MIN_GAP * inside.max(resolution) || inside > MAX_POINT_DIAMETER * size {
                return None;
            }
            let member = self.cut(points.len(), gap);
            let diameter = largest_cluster(points, &member, count)?;
            let is_compact =
                diameter <= MAX_POINT_DIAMETER * size && gap > MIN_GAP * diameter.max(resolution);
            is_compact.then_some(Clusters {
                member,
                count,
                diameter,
            })
        })
    }

    /// Cluster of each of `count` points after cutting edges of at least `gap`, numbered by first
    /// appearance.
    fn cut(&self, count: usize, gap: f64) -> Vec<usize> {
        // Each edge leads from a labelled point to an unlabelled one.
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

    /// Common shape of all `count` parts of the tree: loops if all are closed, arcs if all are curves,
    /// else a cloud.
    fn common_shape(&self, points: &[&[f64]], member: &[usize], count: usize) -> SectionShape {
        let mut adjacent = vec![Vec::new(); member.len()];
        let mut total = vec![0.0; count];
        let mut sizes = vec![0; count];
        let inside = |edge: &&Edge| member[edge.from] == member[edge.to];
        for edge in self.edges.iter().filter(inside) {
            adjacent[edge.from].push((edge.to, edge.length));
            adjacent[edge.to].push((edge.from, edge.length));
            total[member[edge.to]] += edge.length;
        }
        for &part in member {
            sizes[part] += 1;
        }
        let mut closed = true;
        for part in 0..count {
            let start = member.iter().position(|&m| m == part).unwrap_or(0);
            let path = longest_path(&adjacent, start);
            if path.length < MIN_PATH_SHARE * total[part] {
                return SectionShape::Cloud;
            }
            let gap = distance(points[path.ends[0]], points[path.ends[1]]);
            closed &= sizes[part] >= MIN_LOOP_POINTS && gap <= MAX_CLOSING_GAP * path.longest;
        }
        if closed {
            SectionShape::Loop
        } else {
            SectionShape::Arc
        }
    }
}

/// Longest path through the tree that contains point `start`. The point farthest from any other is one
/// of its ends.
fn longest_path(adjacent: &[Vec<(usize, f64)>], start: usize) -> Path {
    let farthest = |start: usize| {
        let mut best = Path {
            ends: [start, start],
            length: 0.0,
            longest: 0.0,
        };
        let mut pending = vec![(start, start, 0.0, 0.0)];
        while let Some((here, before, length, longest)) = pending.pop() {
            if length > best.length {
                best = Path {
                    ends: [start, here],
                    length,
                    longest,
                };
            }
            for &(next, step) in adjacent[here].iter().filter(|(next, _)| *next != before) {
                pending.push((next, here, length + step, f64::max(longest, step)));
            }
        }
        best
    };
    farthest(farthest(start).ends[1])
}

/// Diagonal of the largest bounding box of the clusters; `None` if one has too few members.
fn largest_cluster(points: &[&[f64]], member: &[usize], count: usize) -> Option<f64> {
    let diagonal = |cluster: usize| {
        let both = || points.iter().zip(member);
        let members = || both().filter(|(_, of)| **of == cluster);
        let side = |c: usize| {
            let [low, high] = range(members().map(|(point, _)| point[c]));
            high - low
        };
        let sides = (0..points[0].len()).map(side);
        (members().count() >= MIN_MEMBERS)
            .then(|| sides.map(|side| side * side).sum::<f64>().sqrt())
    };
    (0..count)
        .map(diagonal)
        .try_fold(0.0, |largest, diagonal| Some(f64::max(largest, diagonal?)))
}

/// Euclidean distance.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| a - b);
    Norm::Euclidean.rooted(Norm::Euclidean.unrooted(differences))
}
