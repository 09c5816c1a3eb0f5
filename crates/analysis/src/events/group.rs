//! Partials grouped under fundamentals.

use super::partial::Partial;

/// Difference of frequencies, in fundamentals, within which tones are the same.
pub(super) const SAME: f64 = 0.03;

/// Highest multiple: the more multiples, the more other tones are near one by chance.
const MOST_HARMONICS: f64 = 10.0;

/// Least power of a fundamental relative to each of its partials.
const LEAST_POWER: f64 = 0.03;

/// A fundamental with its higher partials.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// Partials with their multiples, by frequency; the first is the fundamental, multiple 1.
    pub partials: Vec<(usize, Partial)>,
}

impl Group {
    pub fn fundamental(&self) -> &Partial {
        &self.partials[0].1
    }

    /// The partial that stands out most, with its multiple: it has the clearest ends and frequency. Partials
    /// of another duration than the fundamental are parts.
    pub fn leader(&self) -> &(usize, Partial) {
        let best = self
            .partials
            .iter()
            .filter(|(_, p)| p.duration() > 0.8 * self.fundamental().duration())
            .max_by(|a, b| (a.1.power / a.1.noise).total_cmp(&(b.1.power / b.1.noise)));
        best.expect("a group has a partial")
    }
}

/// Groups partials under the lowest fundamental of which they are multiples.
pub(super) fn groups(mut partials: Vec<Partial>) -> Vec<Group> {
    partials.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let mut out: Vec<Group> = Vec::new();
    for partial in partials {
        let multiple = |group: &Group| {
            let fundamental = group.fundamental();
            if partial.shared_with(fundamental) <= 0.5 * partial.duration()
                || fundamental.power < LEAST_POWER * partial.power
            {
                return None;
            }
            let ratio = partial.ratio_to(fundamental);
            let multiple = ratio.round();
            let fits =
                (2.0..=MOST_HARMONICS).contains(&multiple) && (ratio - multiple).abs() < SAME;
            fits.then_some(multiple as usize)
        };
        let owner = out
            .iter()
            .enumerate()
            .find_map(|(g, group)| Some((g, multiple(group)?)));
        match owner {
            Some((g, multiple)) => out[g].partials.push((multiple, partial)),
            None => out.push(Group {
                partials: vec![(1, partial)],
            }),
        }
    }
    out
}
