//! Cubature rules that ship with the program.
//!
//! The files are written by the ignored test `write_shipped_rules`:
//!
//! ```text
//! cargo test --release --no-default-features --lib write_shipped_rules -- --ignored --nocapture
//! ```

use serde::Deserialize;

use super::{CubatureRule, KeptNode, RuleErrors, TrainedRule};
use crate::joint::{Contact, Quadrature};

/// The rules of one patch in ascending order of their numbers of nodes.
#[derive(Deserialize)]
struct RuleFile {
    rules: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    training: RuleErrors,
    held_out: RuleErrors,
    nodes: Vec<usize>,
    weights: Vec<f64>,
}

/// The patches for which rules are shipped, with their files.
pub(super) const FILES: [(Quadrature, usize, &str); 3] = [
    (
        Quadrature::Rings,
        100,
        include_str!("../../../assets/reduction/rings-100.toml"),
    ),
    (
        Quadrature::Gauss,
        100,
        include_str!("../../../assets/reduction/gauss-100.toml"),
    ),
    (
        Quadrature::Gauss,
        1000,
        include_str!("../../../assets/reduction/gauss-1000.toml"),
    ),
];

/// Shipped rules for a Hertz patch, in ascending order of their numbers of nodes; none for most patches. Training
/// and held-out errors are those over several joints, loads and tilts.
pub fn shipped_rules(contact: &Contact) -> Vec<TrainedRule> {
    let patch = (contact.quadrature, contact.nodes);
    let files = FILES
        .iter()
        .filter(|(quadrature, nodes, _)| (*quadrature, *nodes) == patch);
    let read = |text| toml::from_str::<RuleFile>(text).expect("a valid rule file");
    let rules = files.flat_map(|(.., text)| read(text).rules);
    rules.map(|entry| entry.rule(contact.nodes)).collect()
}

impl Entry {
    fn rule(self, full_nodes: usize) -> TrainedRule {
        let kept = self.nodes.into_iter().zip(self.weights);
        let kept = kept.map(|(node, weight)| KeptNode { node, weight });
        TrainedRule {
            rule: CubatureRule::new(full_nodes, kept.collect()).expect("a valid shipped rule"),
            training: self.training,
            held_out: self.held_out,
        }
    }
}
