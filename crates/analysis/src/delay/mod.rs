//! State-space reconstruction from a single signal: delay vectors and the choice of lag and dimension.

mod choice;
mod embedding;
mod false_neighbours;
mod mutual_information;

pub(crate) use choice::LAGS_PER_PERIOD;
pub use choice::{DelayChoice, DelaySearch, LagReason, choose_delay};
pub use embedding::DelayVectors;
pub use false_neighbours::{FalseNeighbourSearch, FalseNeighbours, false_neighbours};
pub use mutual_information::{MutualInformation, mutual_information};
