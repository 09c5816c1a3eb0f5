//! Paths of peaks through a spectrogram.
//!
//! Hypotheses: in noise, the ratio `z` of power to floor is exponential with mean 1; on a path of mean signal-to-noise
//! ratio `s`, exponential with mean `1 + s`. The logarithm of the likelihood ratio of a bin is
//! `z s / (1 + s) - ln(1 + s)`. A path moves by `d` bins per column with probability `p(d)`. The sum of the
//! likelihood ratios of all paths that end in a column, each with its probability, less the number of cells before,
//! is a martingale in noise (the statistic of Shiryaev and Roberts for a hidden Markov chain). Therefore
//!
//! ```text
//! P(the best path of a recording exceeds ln(cells / alpha)) <= alpha
//! ```
//!
//! whatever the paths (Doob's inequality). Hann windows that overlap by half have powers with a correlation of 3 %
//! and count as independent.

use super::spectrogram::{LOBE, Peak, Peaks};

/// Signal-to-noise ratio of the hypothesis of a tone.
const DESIGN_RATIO: f64 = 4.0;

/// Largest gain of a column: a tone needs several.
const LARGEST_GAIN: f64 = 7.0;

/// Columns without a peak that a path may pass.
const MOST_MISSING: usize = 4;

/// `-ln p(d)` of a step by `d` bins between columns.
const STEP_COSTS: [f64; 4] = [0.4, 2.0, 3.5, 6.0];

/// A node of the search.
#[derive(Clone, Copy)]
struct Node {
    /// Best score of a path that ends here.
    score: f64,
    /// Column and index of the peak before on that path.
    before: Option<(usize, usize)>,
    is_free: bool,
}

/// All paths above `threshold`, each as its peaks with their columns in the order of time, the best first; each peak belongs to one path, and the peaks in the main lobe around
/// a path are part of it.
pub(super) fn paths(peaks: &Peaks, threshold: f64) -> Vec<Vec<(usize, Peak)>> {
    let empty = Node {
        score: 0.0,
        before: None,
        is_free: true,
    };
    let mut nodes: Vec<Vec<Node>> = peaks
        .columns
        .iter()
        .map(|column| vec![empty; column.len()])
        .collect();
    let mut best = vec![None; nodes.len()];
    update(peaks, &mut nodes, &mut best, 0);
    let mut out = Vec::new();
    loop {
        let ends = best
            .iter()
            .enumerate()
            .filter_map(|(t, b)| Some((t, (*b)?)));
        let end = ends.max_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let Some((column, (index, score))) = end else {
            return out;
        };
        if score < threshold {
            return out;
        }
        let mut at = Some((column, index));
        let mut path = Vec::new();
        while let Some((t, i)) = at {
            let peak = peaks.columns[t][i];
            path.push((t, peak));
            at = nodes[t][i].before;
            for (node, other) in nodes[t].iter_mut().zip(&peaks.columns[t]) {
                node.is_free &= (other.bin - peak.bin).abs() > LOBE as f64;
            }
        }
        path.reverse();
        update(peaks, &mut nodes, &mut best, path[0].0);
        out.push(path);
    }
}

/// Computes the scores from a column on, until they agree with those before.
fn update(peaks: &Peaks, nodes: &mut [Vec<Node>], best: &mut [Option<(usize, f64)>], from: usize) {
    let mut unchanged = 0;
    for (t, best_end_here) in best.iter_mut().enumerate().skip(from) {
        let (past, rest) = nodes.split_at_mut(t);
        let mut is_changed = false;
        *best_end_here = None;
        for (i, peak) in peaks.columns[t].iter().enumerate() {
            let node = &mut rest[0][i];
            let old = (node.score, node.before);
            (node.score, node.before) = if node.is_free {
                best_end(peaks, past, t, peak)
            } else {
                (0.0, None)
            };
            is_changed |= old != (node.score, node.before) || !node.is_free;
            if best_end_here.is_none_or(|(_, score)| node.score > score) && node.is_free {
                *best_end_here = Some((i, node.score));
            }
        }
        unchanged = if is_changed { 0 } else { unchanged + 1 };
        if unchanged > MOST_MISSING + 1 && from > 0 {
            return;
        }
    }
}

/// Score of the best path that ends at a peak of column `t`, and the peak before.
fn best_end(
    peaks: &Peaks,
    past: &[Vec<Node>],
    t: usize,
    peak: &Peak,
) -> (f64, Option<(usize, usize)>) {
    let gain = DESIGN_RATIO / (1.0 + DESIGN_RATIO) * peak.ratio - DESIGN_RATIO.ln_1p();
    let mut best = (0.0, None);
    let reach = STEP_COSTS.len() as f64 - 0.5;
    for (missing, column) in (0..t).rev().take(MOST_MISSING + 1).enumerate() {
        let others = &peaks.columns[column];
        let first = others.partition_point(|other| other.bin <= peak.bin - reach);
        let near = others[first..]
            .iter()
            .take_while(|other| other.bin < peak.bin + reach);
        for (i, other) in (first..).zip(near) {
            let node = &past[column][i];
            let step = (other.bin - peak.bin).abs().round() as usize;
            let cost = STEP_COSTS[step] + missing as f64 * (STEP_COSTS[0] + DESIGN_RATIO.ln_1p());
            let score = node.score - cost;
            if node.is_free && score > best.0 {
                best = (score, Some((column, i)));
            }
        }
    }
    (best.0 + gain.min(LARGEST_GAIN), best.1)
}

/// Threshold of the score for a probability of a false path in `cells` cells.
pub(super) fn threshold(cells: usize, false_alarm: f64) -> f64 {
    (cells.max(1) as f64 / false_alarm).ln()
}
