//! Cubature rules: a few contact nodes with weights in place of all nodes.

use serde::{Deserialize, Serialize};

use crate::joint::{Model, PatchPoint};

/// A node of the full patch with the factor on its area and load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptNode {
    /// Index of the node in the full patch.
    pub node: usize,
    /// Factor on the area and on the load of the node; positive.
    pub weight: f64,
}

/// An empirical cubature rule: nodes of a full patch, in ascending order, with positive weights.
///
/// The sum of a quantity over all nodes of the patch is approximated by the weighted sum over the kept
/// nodes. Pre-stress and stiffness per area, mode shapes and sliding velocity of a kept node are those of
/// the full patch; only its area and its load are multiplied by the weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct CubatureRule {
    /// Number of nodes of the full patch.
    full_nodes: usize,
    /// The kept nodes, in ascending order.
    kept: Vec<KeptNode>,
}

/// The fields of a rule as read from a file.
#[derive(Deserialize)]
struct Unchecked {
    /// Number of nodes of the full patch.
    full_nodes: usize,
    /// The kept nodes.
    kept: Vec<KeptNode>,
}

impl TryFrom<Unchecked> for CubatureRule {
    type Error = RuleError;

    fn try_from(read: Unchecked) -> Result<Self, RuleError> {
        Self::new(read.full_nodes, read.kept)
    }
}

/// An invalid cubature rule, or a rule for another patch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RuleError {
    /// No node is kept.
    #[error("a cubature rule needs at least one node")]
    Empty,
    /// A node does not exist, or the nodes are not in ascending order.
    #[error(
        "node {node} of a cubature rule is repeated, out of order or not below the {full_nodes} \
         nodes of the patch"
    )]
    Node {
        /// Index of the node.
        node: usize,
        /// Number of nodes of the full patch.
        full_nodes: usize,
    },
    /// A weight is not a positive number.
    #[error("the weight of node {node} of a cubature rule is {weight}; it must be positive")]
    Weight {
        /// Index of the node.
        node: usize,
        /// The weight.
        weight: f64,
    },
    /// The patch has a different number of nodes.
    #[error("the cubature rule is for a patch of {rule} nodes, and this patch has {patch}")]
    OtherPatch {
        /// Number of nodes for which the rule is valid.
        rule: usize,
        /// Number of nodes of the patch.
        patch: usize,
    },
}

impl CubatureRule {
    /// Checks and builds a rule for a patch of `full_nodes` nodes.
    ///
    /// # Errors
    /// If no node is kept, nodes are not strictly ascending indices below `full_nodes`, or a weight is not
    /// positive and finite.
    pub fn new(full_nodes: usize, kept: Vec<KeptNode>) -> Result<Self, RuleError> {
        if kept.is_empty() {
            return Err(RuleError::Empty);
        }
        let mut next = 0;
        for &KeptNode { node, weight } in &kept {
            if node < next || node >= full_nodes {
                return Err(RuleError::Node { node, full_nodes });
            }
            if !(weight > 0.0 && weight.is_finite()) {
                return Err(RuleError::Weight { node, weight });
            }
            next = node + 1;
        }
        Ok(Self { full_nodes, kept })
    }

    /// Number of nodes of the full patch.
    pub fn full_nodes(&self) -> usize {
        self.full_nodes
    }

    /// The kept nodes in ascending order, with their weights.
    pub fn kept(&self) -> &[KeptNode] {
        &self.kept
    }

    /// Checks that the rule is for a patch of `nodes` nodes.
    ///
    /// # Errors
    /// [`RuleError::OtherPatch`] if it is not.
    pub fn check_patch(&self, nodes: usize) -> Result<(), RuleError> {
        match self.full_nodes == nodes {
            true => Ok(()),
            false => Err(RuleError::OtherPatch {
                rule: self.full_nodes,
                patch: nodes,
            }),
        }
    }

    /// The values of the kept nodes, given those of all nodes.
    fn pick<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.kept.iter().map(|kept| all[kept.node]).collect()
    }

    /// The kept points of a patch with weighted areas and loads.
    pub(in crate::joint) fn points(&self, all: &[PatchPoint]) -> Vec<PatchPoint> {
        let kept = self.kept.iter().map(|kept| PatchPoint {
            area: kept.weight * all[kept.node].area,
            load: kept.weight * all[kept.node].load,
            ..all[kept.node]
        });
        kept.collect()
    }
}

impl Model {
    /// The model with the nodes and weights of a cubature rule.
    ///
    /// # Errors
    /// [`RuleError::OtherPatch`] if the rule is for another number of nodes.
    pub fn reduced(&self, rule: &CubatureRule) -> Result<Self, RuleError> {
        rule.check_patch(self.nodes())?;
        Ok(self.weighted_nodes(rule))
    }

    /// [`Model::reduced`] with a rule for this patch.
    pub(in crate::joint) fn weighted_nodes(&self, rule: &CubatureRule) -> Self {
        let kept = rule.kept();
        Self {
            positions: rule.pick(&self.positions),
            normals: rule.pick(&self.normals),
            areas: kept
                .iter()
                .map(|kept| kept.weight * self.areas[kept.node])
                .collect(),
            pre_stress: rule.pick(&self.pre_stress),
            stiffness: rule.pick(&self.stiffness),
            shapes: kept
                .iter()
                .flat_map(|kept| self.shapes_at(kept.node))
                .copied()
                .collect(),
            sliding_velocity: rule.pick(&self.sliding_velocity),
            omega: self.omega.clone(),
            damping: self.damping.clone(),
            probe: self.probe.clone(),
            friction: self.friction.clone(),
            unilateral: self.unilateral,
            contact_damping: self.contact_damping,
            convection: self.convection,
        }
    }
}
