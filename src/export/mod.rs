//! Plain NumPy arrays on disk: the model of Eq. (8), and the samples of a run.
//!
//! Both are `.npz` files, stored without compression: `numpy.load(path)` reads them.

mod file;
mod model;
mod npz;
mod samples;

pub use file::{OutputError, replace_file, temporary_beside};
pub use model::{MODEL_VERSION, ModelArrays, encode_model, read_model, write_model};
pub use npz::{Array, encode_npz, read_npz, write_npz};
pub use samples::SamplesSink;
