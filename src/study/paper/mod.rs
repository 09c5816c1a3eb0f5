//! The paper: every claim of its text, compared with what is found here.

mod claims;
mod evidence;
mod study;

#[cfg(test)]
mod tests;

pub use claims::{CLAIMS, Claim, Finding, Holds, claims, compare, nearness, score};
pub use evidence::{Embedding, Evidence};
pub use study::{EMBEDDED_AT, MOTIONS, SUCCESSION, embedding, paper_evidence, paper_plan};
