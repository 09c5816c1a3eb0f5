//! Comparison with the paper: every claim of its text against the simulation results.

mod claims;
mod criterion;
mod evidence;
mod study;
mod verdict;

#[cfg(test)]
mod tests;

pub use claims::{
    CLAIMS, Claim, Finding, Score, ShortAverage, add_short_averages, claims, compare,
};
pub use evidence::{Embedding, Evidence};
pub use study::{
    EMBEDDING_TILT_DEG, FIGURE_TILTS_DEG, RECURRENCE_TILTS_DEG, embedding, paper_evidence,
    paper_plan, short_average_plan,
};
pub use verdict::Verdict;
