//! Paths of peaks through a spectrogram.
//!
//! Hypotheses: in noise, the ratio `z` of power to floor is exponential with mean 1; on a path of mean signal-to-noise
//! ratio `s`, exponential with mean `1 + s`. The logarithm of the likelihood ratio of a bin is
//! `z s / (1 + s) - ln(1 + s)`. A path moves by `d` bins per column with a probability proportional to `(1 + s)^-|d|`:
//! a step by a bin costs as much as a column without a peak. The sum of the
//! likelihood ratios of all paths that end in a column, each with its probability, less the number of cells before,
//! is a martingale in noise (the statistic of Shiryaev and Roberts for a hidden Markov chain). Therefore
//!
//! ```text
//! P(the best path of a recording exceeds ln(cells / alpha)) <= alpha
//! ```
//!
//! whatever the paths (Doob's inequality). Hann windows that overlap by half have powers with a correlation of 3 %
//! and count as independent.

use super::ridge::Ridge;
use super::spectrogram::{Peak, Peaks};

/// Signal-to-noise ratio of the hypothesis of a tone.
const DESIGN_RATIO: f64 = 4.0;

/// A node of the search.
struct Node {
    /// Best score of a path that ends here.
    score: f64,
    /// Column and index of the peak before on that path.
    before: Option<(usize, usize)>,
    is_free: bool,
}

/// The ridges of all paths above the threshold of a probability of a false path, the best first; each peak belongs to
/// one path.
pub(super) fn ridges(peaks: &Peaks, false_alarm: f64) -> Vec<Ridge> {
    let cells = (peaks.columns.len() * peaks.bins).max(1);
    let threshold = (cells as f64 / false_alarm).ln().max(f64::MIN_POSITIVE);
    let mut nodes: Vec<Vec<Node>> = Vec::new();
    for (t, column) in peaks.columns.iter().enumerate() {
        let node = |peak| best_end(peaks, &nodes, t, peak, threshold);
        nodes.push(column.iter().map(node).collect());
    }
    let all = nodes.iter().enumerate();
    let all = all.flat_map(|(t, column)| (0..column.len()).map(move |i| (t, i)));
    let mut ends: Vec<_> = all
        .filter(|(t, i)| nodes[*t][*i].score >= threshold)
        .collect();
    ends.sort_by(|a, b| nodes[b.0][b.1].score.total_cmp(&nodes[a.0][a.1].score));
    let mut out = Vec::new();
    for end in ends {
        let before = |(t, i): &(usize, usize)| nodes[*t][*i].before;
        let chain = || std::iter::successors(Some(end), before);
        let is_free = |(t, i): &(usize, usize)| nodes[*t][*i].is_free;
        // The rest belongs to a better path.
        let rest = chain().find(|at| !is_free(at));
        let rest = rest.map_or(0.0, |(t, i)| nodes[t][i].score);
        if nodes[end.0][end.1].score - rest >= threshold {
            let mut path: Vec<_> = chain().take_while(is_free).collect();
            path.reverse();
            let point = |&(t, i): &(usize, usize)| {
                let peak = &peaks.columns[t][i];
                [peaks.step_s * t as f64, peak.bin * peaks.bin_hz, peak.noise]
            };
            let points = path.iter().map(point).collect();
            out.push(Ridge { points });
            for (t, i) in path {
                nodes[t][i].is_free = false;
            }
        }
    }
    out
}

/// The best path that ends at a peak of column `t`. A path of two columns does not exceed the threshold, however loud:
/// a knock is no tone. A path passes as many columns without a peak as the gain of one column pays for.
fn best_end(peaks: &Peaks, past: &[Vec<Node>], t: usize, peak: &Peak, threshold: f64) -> Node {
    let largest_gain = 0.5 * threshold;
    let miss = DESIGN_RATIO.ln_1p();
    // The probabilities of all steps have the sum 1.
    let stay = (1.0 + 2.0 / DESIGN_RATIO).ln();
    let most_missing = (largest_gain / (stay + miss)) as usize;
    let (mut score, mut before) = (0.0, None);
    for (missing, column) in (0..t)
        .rev()
        .take(most_missing.saturating_add(1))
        .enumerate()
    {
        let others = &peaks.columns[column];
        // A faster change of frequency is seen by a shorter window.
        let first = others.partition_point(|other| other.bin <= peak.bin - 1.5);
        let near = others[first..]
            .iter()
            .take_while(|other| other.bin < peak.bin + 1.5);
        for (i, other) in (first..).zip(near) {
            let step = (other.bin - peak.bin).abs().round();
            let missed = missing as f64;
            let reached = past[column][i].score - stay * (1.0 + missed) - miss * (step + missed);
            if reached > score {
                (score, before) = (reached, Some((column, i)));
            }
        }
    }
    Node {
        score: score + peak.gain.min(largest_gain),
        before,
        is_free: true,
    }
}

/// Logarithm of the likelihood ratio of a tone against noise for a ratio of power to floor.
pub(super) fn gain(ratio: f64) -> f64 {
    DESIGN_RATIO / (1.0 + DESIGN_RATIO) * ratio - DESIGN_RATIO.ln_1p()
}
