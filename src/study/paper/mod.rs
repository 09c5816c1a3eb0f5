//! Comparison with the paper: every claim of its text against the simulation results.

mod claims;
mod criterion;
mod study;

#[cfg(test)]
mod tests;

pub use claims::{
    CLAIMS, Claim, ClaimEntry, Comparison, Evidence, Finding, Score, ShortAverage, Verdict,
    add_short_averages, claims, compare,
};
pub use study::{
    EMBEDDING_TILT_DEG, FIGURE_TILTS_DEG, RECURRENCE_TILTS_DEG, embedding, paper_evidence,
    paper_plan, short_average_plan,
};
