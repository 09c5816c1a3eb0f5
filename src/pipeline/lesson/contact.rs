//! The contact while it sticks and separates.

use super::{FactValue, Facts};
use crate::pipeline::message::NodeShares;

/// Frequency of the strongest line over the natural frequency below which the stick phase lengthens the period.
const LENGTHENED: f64 = 0.95;

/// Nodes, or a mass, that stick and slip.
pub fn stick_slip(facts: &mut Facts<'_>) {
    let (measured, natural) = (facts.measured, facts.computed.natural_hz);
    let nodes = measured.nodes.map(|nodes| nodes.half_stuck);
    let share = nodes.or(measured.statuses.map(|shares| shares.held));
    let sticks = share.map(|share| share > 0.0);
    facts.claim("contact", ["stick-slip", "slip only"], true, sticks);
    facts.predicted("lowest natural frequency", natural, "Hz");
    let line = facts.strongest_line();
    let is_below =
        matches!(line.measured, Some(FactValue::Number(hz)) if hz < LENGTHENED * natural);
    line.predicted = Some("below the natural frequency".into());
    line.agrees = sticks.filter(|sticks| *sticks && is_below);
    if let Some(nodes) = measured.nodes {
        facts.found("nodes sticking, mean", Some(nodes.stuck), "share");
        facts.found("nodes sticking, maximum", Some(nodes.most_stuck), "share");
        facts.found("time with half of the nodes sticking", share, "share");
    } else {
        let releases = measured.statuses.map(|shares| shares.releases_per_s);
        facts.found("share of time sticking", share, "share");
        facts.found("releases", releases, "1/s");
    }
}

/// Nodes that separate and strike again.
pub fn lift_off(facts: &mut Facts<'_>) {
    facts.strongest_line();
    let nodes = facts.measured.nodes;
    let extent = nodes.map(|nodes| match (nodes.most_separated, nodes.all_separated) {
        (0.0, _) => "none, the vibration is too small",
        (_, 0.0) => "of a part of the nodes",
        _ => "of the whole contact",
    });
    facts.found("separation", extent, "");
    let mut add = |name, share: fn(NodeShares) -> f64, unit| {
        facts.found(name, nodes.map(share), unit);
    };
    add("separated nodes, mean", |n| n.separated, "share");
    add("separated nodes, maximum", |n| n.most_separated, "share");
    add("time without contact", |n| n.all_separated, "share");
    add("separations per node", |n| n.separations_per_s, "1/s");
}
