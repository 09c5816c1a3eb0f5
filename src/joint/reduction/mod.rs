//! Hyper-reduction of the contact: a few nodes with weights reproduce the generalised force of all nodes.
mod certificate;
mod nnls;
mod rule;
mod snapshots;
mod states;
mod training;

pub use certificate::{ForceCheck, ForceChecker, ReductionErrors};
pub use rule::{CubatureRule, KeptNode, RuleError};
pub use states::Excitation;
pub use training::{
    RuleErrors, TrainedRule, Trainer, TrainingCase, TrainingError, TrainingPlan, errors_of, train,
};
