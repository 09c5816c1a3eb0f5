//! Comparison with the paper: every claim of its text against the simulation results.

mod claims;
mod evidence;
mod study;

#[cfg(test)]
mod tests;

pub use claims::{Agreement, CLAIMS, Claim, Finding, claims, compare, fitness, score};
pub use evidence::{Embedding, Evidence};
pub use study::{
    EMBEDDING_TILT_DEG, FIGURE_TILTS_DEG, RECURRENCE_TILTS_DEG, embedding, paper_evidence,
    paper_plan,
};
